// SPDX-License-Identifier: MIT
//
// The fonts that are part of the binary: DejaVu (see fonts.md for their licence).
#pragma once

#include <cstddef>
#include <cstdint>

namespace skerry::render {

/// A TrueType file in memory.
struct FontData {
  const std::uint8_t* bytes = nullptr;
  std::size_t size = 0;
};

[[nodiscard]] FontData sans_font();
[[nodiscard]] FontData sans_bold_font();
[[nodiscard]] FontData mono_font();

}  // namespace skerry::render
