// SPDX-License-Identifier: MIT
//
// Demos as parameters of tests: named, not dumped, in the tests' names.
#pragma once

#include <ostream>

#include "sandbox/demo_files.h"

namespace skerry::sandbox {

inline void PrintTo(const DemoFile& demo, std::ostream* out) {
  *out << demo.name;
}

}  // namespace skerry::sandbox
