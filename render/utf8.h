// SPDX-License-Identifier: MIT
//
// Text for formats that refuse what is not UTF-8: XML, JSON, metadata of videos.
#pragma once

#include <string>
#include <string_view>

namespace skerry::render {

/// `text` with U+FFFD in place of what is not UTF-8 (stray bytes, overlong forms, surrogates, code points
/// beyond U+10FFFF), and of U+FFFE and U+FFFF, which XML does not allow.
[[nodiscard]] std::string valid_utf8(std::string_view text);

}  // namespace skerry::render
