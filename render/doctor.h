// SPDX-License-Identifier: MIT
//
// What the renderer finds on this machine, for `skerry doctor`.
#pragma once

#include <string>
#include <vector>

namespace skerry::render {

struct DoctorLine {
  std::string what;  ///< e.g. "EGL: surfaceless Mesa"
  bool ok = false;
  std::string detail;     ///< version, or the reason for failing
  std::string remedy;     ///< how to get it, e.g. "apt install libegl-mesa0"; empty if ok
  bool required = false;  ///< captures do not work without it
};

/// Tries everything; throws nothing but std::bad_alloc.
[[nodiscard]] std::vector<DoctorLine> examine();

}  // namespace skerry::render
