// SPDX-License-Identifier: MIT
#include "tests/support/paths.h"

namespace skerry {

const char* source_dir() {
  return SKERRY_SOURCE_DIR;
}

}  // namespace skerry
