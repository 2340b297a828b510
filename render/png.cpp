// SPDX-License-Identifier: MIT
//
// PNG: fast for captures, small for pictures that stay in the repository.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <libdeflate.h>
#include <map>
#include <memory>
#include <stb_image.h>
#include <stdexcept>

#include "render/error.h"
#include "render/image.h"
#include "render/palette.h"

namespace skerry::render {
namespace {

using Bytes = std::vector<std::uint8_t>;

enum ColorType : std::uint8_t { kRgb = 2, kPalette = 3, kRgba = 6 };

void append_u32(Bytes& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// Closes a chunk that began at `start` (its length field): fills in the length and appends the checksum.
void finish_chunk(Bytes& out, std::size_t start) {
  const std::size_t length = out.size() - start - 8;
  for (int i = 0; i < 4; ++i) out[start + i] = static_cast<std::uint8_t>(length >> (24 - 8 * i));
  append_u32(out, libdeflate_crc32(0, out.data() + start + 4, length + 4));
}

std::size_t begin_chunk(Bytes& out, const char* type) {
  const std::size_t start = out.size();
  append_u32(out, 0);
  out.insert(out.end(), type, type + 4);
  return start;
}

/// Signature and header: 8 bits, the only compression and filter method, not interlaced.
Bytes begin_file(const Image& image, ColorType type) {
  Bytes out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const std::size_t chunk = begin_chunk(out, "IHDR");
  append_u32(out, static_cast<std::uint32_t>(image.width));
  append_u32(out, static_cast<std::uint32_t>(image.height));
  for (const int byte : {8, static_cast<int>(type), 0, 0, 0}) out.push_back(static_cast<std::uint8_t>(byte));
  finish_chunk(out, chunk);
  return out;
}

/// Appends rows with their filter bytes, compressed, and the end.
void finish_file(Bytes& out, const Bytes& rows, int level) {
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(level), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  const std::size_t chunk = begin_chunk(out, "IDAT");
  const std::size_t header = out.size();
  out.resize(header + libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
  const std::size_t used = libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(),
                                                    out.data() + header, out.size() - header);
  out.resize(header + used);
  finish_chunk(out, chunk);
  finish_chunk(out, begin_chunk(out, "IEND"));
}

/// Refuses what is no picture. @return whether every pixel is opaque
bool checked_opaque(const Image& image) {
  const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
  if (pixels == 0 || image.rgba.size() != pixels * 4) {
    throw std::invalid_argument("png: image of " + std::to_string(image.width) + " x " +
                                std::to_string(image.height) + " px with " +
                                std::to_string(image.rgba.size()) + " bytes");
  }
  std::uint8_t alpha = 255;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) alpha &= image.rgba[i];
  return alpha == 255;
}

/// Rows with their filter byte (0: none), as RGB if nothing is transparent.
Bytes plain_rows(const Image& image, bool opaque) {
  const std::size_t channels = opaque ? 3 : 4;
  const std::size_t width = static_cast<std::size_t>(image.width);
  Bytes rows((1 + width * channels) * image.height);
  std::uint8_t* to = rows.data();
  const std::uint8_t* from = image.rgba.data();
  for (int y = 0; y < image.height; ++y) {
    *to++ = 0;
    if (!opaque) {
      std::memcpy(to, from, width * 4);
      to += width * 4;
      from += width * 4;
      continue;
    }
    for (std::size_t x = 0; x < width; ++x, to += 3, from += 4) {
      to[0] = from[0];
      to[1] = from[1];
      to[2] = from[2];
    }
  }
  return rows;
}

/// One byte of a row after filter 0 to 4 of the PNG specification, section 9.2.
std::uint8_t filtered(int filter, int value, int left, int up, int up_left) {
  int guess = 0;
  if (filter == 1) guess = left;
  if (filter == 2) guess = up;
  if (filter == 3) guess = (left + up) / 2;
  if (filter == 4) {
    const int p = left + up - up_left;
    const int a = std::abs(p - left), b = std::abs(p - up), c = std::abs(p - up_left);
    guess = a <= b && a <= c ? left : b <= c ? up : up_left;
  }
  return static_cast<std::uint8_t>(value - guess);
}

constexpr int kAdaptive = 5;

/// Applies a filter to plain rows; kAdaptive takes, row by row, the one with the smallest sum of magnitudes.
Bytes with_filter(const Bytes& plain, std::size_t stride, std::size_t channels, int filter) {
  Bytes rows(plain.size());
  Bytes trial(stride);
  for (std::size_t start = 0; start < plain.size(); start += stride) {
    long best = -1;
    const int first = filter == kAdaptive ? 0 : filter, last = filter == kAdaptive ? 4 : filter;
    for (int kind = first; kind <= last; ++kind) {
      trial[0] = static_cast<std::uint8_t>(kind);
      long sum = 0;
      for (std::size_t i = 1; i < stride; ++i) {
        const bool has_left = i > channels, has_up = start > 0;
        const int left = has_left ? plain[start + i - channels] : 0;
        const int up = has_up ? plain[start - stride + i] : 0;
        const int up_left = has_left && has_up ? plain[start - stride + i - channels] : 0;
        trial[i] = filtered(kind, plain[start + i], left, up, up_left);
        sum += std::abs(static_cast<int>(static_cast<std::int8_t>(trial[i])));
      }
      if (best >= 0 && sum >= best) continue;
      best = sum;
      std::copy(trial.begin(), trial.end(), rows.begin() + static_cast<std::ptrdiff_t>(start));
    }
  }
  return rows;
}

/// A palette and rows of indices into it.
struct Indexed {
  std::vector<Color> colors;
  Bytes rows;
};

/// The colours of an opaque picture in the order of their first pixel; none when there are more than 256.
Indexed exact_indices(const Image& image) {
  Indexed result;
  std::map<std::uint32_t, std::uint8_t> index;
  for (int y = 0; y < image.height; ++y) {
    result.rows.push_back(0);
    for (int x = 0; x < image.width; ++x) {
      const Color c = image.at(x, y);
      const std::uint32_t key = static_cast<std::uint32_t>(c.r << 16 | c.g << 8 | c.b);
      const auto [found, added] = index.emplace(key, static_cast<std::uint8_t>(index.size()));
      if (added && result.colors.size() == 256) return {};
      if (added) result.colors.push_back(c);
      result.rows.push_back(found->second);
    }
  }
  return result;
}

Indexed nearest_indices(const Image& image) {
  Palette palette(image);
  const std::size_t width = static_cast<std::size_t>(image.width);
  Indexed result;
  result.rows.resize((width + 1) * image.height);
  palette.map(image, result.rows.data() + 1, static_cast<std::ptrdiff_t>(width + 1));
  result.colors.assign(palette.colors().begin(), palette.colors().begin() + palette.size());
  return result;
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Image& image) {
  const bool opaque = checked_opaque(image);
  Bytes out = begin_file(image, opaque ? kRgb : kRgba);
  finish_file(out, plain_rows(image, opaque), 1);
  return out;
}

std::vector<std::uint8_t> encode_small_png(const Image& image, bool quantise) {
  constexpr int kMedium = 6, kStrongest = 12;
  const bool opaque = checked_opaque(image);
  Indexed indexed = opaque ? exact_indices(image) : Indexed{};
  if (opaque && quantise && indexed.colors.empty()) indexed = nearest_indices(image);

  const ColorType type = !indexed.colors.empty() ? kPalette : opaque ? kRgb : kRgba;
  const std::size_t channels = type == kPalette ? 1 : type == kRgb ? 3 : 4;
  const std::size_t stride = 1 + channels * static_cast<std::size_t>(image.width);
  const Bytes plain = type == kPalette ? std::move(indexed.rows) : plain_rows(image, opaque);
  const auto encoded = [&](int filter, int level) {
    Bytes out = begin_file(image, type);
    if (type == kPalette) {
      const std::size_t chunk = begin_chunk(out, "PLTE");
      for (const Color& c : indexed.colors) out.insert(out.end(), {c.r, c.g, c.b});
      finish_chunk(out, chunk);
    }
    finish_file(out, with_filter(plain, stride, channels, filter), level);
    return out;
  };
  // A medium level shows which filter suits the picture; the strongest costs ten times as much.
  int best_filter = 0;
  std::size_t best_size = 0;
  for (const int filter : {0, 1, 2, 4, kAdaptive}) {
    const std::size_t size = encoded(filter, kMedium).size();
    if (best_size != 0 && size >= best_size) continue;
    best_size = size;
    best_filter = filter;
  }
  return encoded(best_filter, kStrongest);
}

void write_png(const std::filesystem::path& path, const Image& image) {
  const std::vector<std::uint8_t> bytes = encode_png(image);
  write_file(path, bytes.data(), bytes.size());
}

Image read_png(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) throw EnvironmentError(path.string() + ": cannot open: " + system_message(errno));
  Bytes bytes;
  std::array<std::uint8_t, 65536> block;
  while (const std::size_t got = std::fread(block.data(), 1, block.size(), file.get()))
    bytes.insert(bytes.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(got));
  try {
    return decode_png(bytes.data(), bytes.size());
  } catch (const EnvironmentError& error) {
    throw EnvironmentError(path.string() + ": " + error.what());
  }
}

Image decode_png(const void* bytes, std::size_t size) {
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
      stbi_load_from_memory(static_cast<const stbi_uc*>(bytes), static_cast<int>(size), &width, &height,
                            &channels, 4),
      stbi_image_free);
  if (!pixels) throw EnvironmentError(std::string("cannot read as PNG: ") + stbi_failure_reason());
  Image image(width, height);
  std::memcpy(image.rgba.data(), pixels.get(), image.rgba.size());
  return image;
}

}  // namespace skerry::render
