// SPDX-License-Identifier: MIT
//
// Pictures in memory, and PNG files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "render/draw_list.h"

namespace skerry::render {

/// 8-bit sRGB with straight alpha, top row first, no padding: pixel (x, y) starts at `4 * (y * width + x)`.
struct Image {
  int width = 0, height = 0;  ///< [px]
  std::vector<std::uint8_t> rgba;

  Image() = default;

  /// @throws std::invalid_argument unless both sides are in 1..32768
  Image(int width_px, int height_px, Color fill = {0, 0, 0, 255});

  /// Colour at (x, y), x to the right, y down; no range check.
  [[nodiscard]] Color at(int x, int y) const;
  void set(int x, int y, Color color);

  friend bool operator==(const Image&, const Image&) = default;
};

/// FNV-1a (64 bits) over size and pixels: the digest of golden images and of the hash sink.
[[nodiscard]] std::uint64_t digest(const Image& image);

/// Encodes as PNG: 24 bits when every pixel is opaque, else 32. No row filter: renderings are flat, and
/// filters cost more time than they save bytes (libdeflate, level 1).
/// @throws std::invalid_argument for an empty image
[[nodiscard]] std::vector<std::uint8_t> encode_png(const Image& image);

/// Encodes as PNG in as few bytes as we can, which takes some hundred times longer: for pictures that stay in
/// a repository. Opaque pictures of at most 256 colours get a palette.
/// @param quantise  an opaque picture of more colours is reduced to 256 (see Palette); otherwise every pixel
///                  is kept
/// @throws std::invalid_argument for an empty image
[[nodiscard]] std::vector<std::uint8_t> encode_small_png(const Image& image, bool quantise = false);

/// Writes `path` whole or not at all (render/output_file.h); FIFOs and devices get the bytes as they come.
/// @throws EnvironmentError with the file's name and the system's reason; no file is left behind
void write_png(const std::filesystem::path& path, const Image& image);

/// Reads a PNG of any colour type as 8-bit RGBA.
/// @throws EnvironmentError with the file's name if it cannot be read or is no PNG
[[nodiscard]] Image read_png(const std::filesystem::path& path);

/// The same from memory. @throws EnvironmentError if the bytes are no PNG
[[nodiscard]] Image decode_png(const void* bytes, std::size_t size);

/// Writes `bytes` to `path` whole or not at all, like write_png.
/// @throws EnvironmentError with the file's name and the system's reason
void write_file(const std::filesystem::path& path, const void* bytes, std::size_t size);

}  // namespace skerry::render
