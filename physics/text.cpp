// SPDX-License-Identifier: MIT
#include "physics/text.h"

#include <charconv>

namespace skerry {

std::string to_text(double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  return std::string(digits, end);
}

std::string to_text(Vec2 value) {
  return "(" + to_text(value.x) + ", " + to_text(value.y) + ")";
}

}  // namespace skerry
