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
  std::string text = "(";
  text += to_text(value.x);
  text += ", ";
  text += to_text(value.y);
  text += ")";
  return text;
}

}  // namespace skerry
