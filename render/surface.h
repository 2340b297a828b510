// SPDX-License-Identifier: MIT
//
// A picture in memory, for whoever draws on it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skerry::render {

/// An opaque RGBA8 picture that somebody else owns, at least `kLeastWidth` pixels wide, top row first, no
/// padding.
struct Surface {
  std::uint8_t* pixels = nullptr;
  int width = 0, height = 0;  ///< [px]
};

/// Groups of so many pixels never leave a surface.
inline constexpr int kLeastWidth = 8;

}  // namespace skerry::render
