// SPDX-License-Identifier: MIT
//
// Numbers of bodies, rows and columns are `int`, as in the matrices that have them; places in arrays are not.
#pragma once

#include <cstddef>

namespace skerry {

/// The place in an array of what has number `i >= 0`.
constexpr std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

}  // namespace skerry
