// SPDX-License-Identifier: MIT
//
// Sizes of randomised tests: the environment variable SKERRY_TEST_SCALE multiplies their counts.
#pragma once

#include <algorithm>
#include <cstdlib>

namespace skerry {

/// Returns `count` times SKERRY_TEST_SCALE (1 when it is not set or not a positive number), at least 1.
inline int test_scale(int count) {
  const char* text = std::getenv("SKERRY_TEST_SCALE");
  const double scale = text ? std::atof(text) : 1;
  return std::max(1, static_cast<int>(count * (scale > 0 ? scale : 1)));
}

}  // namespace skerry
