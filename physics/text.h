// SPDX-License-Identifier: MIT
//
// Words for error messages: numbers with as many digits as they need, and "did you mean".
#pragma once

#include <string>

#include "physics/math.h"

namespace skerry {

/// Shortest decimal form that reads back as the same value: 0.1, 1e-9, nan.
std::string to_text(double value);
/// "(x, y)"
std::string to_text(Vec2 value);

}  // namespace skerry
