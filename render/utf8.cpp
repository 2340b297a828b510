// SPDX-License-Identifier: MIT
#include "render/utf8.h"

#include "render/glyphs.h"

namespace skerry::render {

std::string valid_utf8(std::string_view text) {
  constexpr std::string_view kReplacement = "\xEF\xBF\xBD";
  // Smallest code point of each length in bytes; a longer form of a smaller one is none.
  constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t first = at;
    const char32_t code = next_code_point(text, at);
    const std::size_t length = at - first;
    const bool surrogate = code >= 0xd800 && code < 0xe000;
    const bool bad = (length == 1 && code >= 0x80) || code < kLeast[length] || surrogate || code > 0x10ffff ||
                     code == 0xfffe || code == 0xffff;
    if (bad)
      result += kReplacement;
    else
      result += text.substr(first, length);
  }
  return result;
}

}  // namespace skerry::render
