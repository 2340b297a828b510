// SPDX-License-Identifier: MIT
#include "render/image.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <libdeflate.h>
#include <memory>
#include <stb_image.h>
#include <stdexcept>
#include <unistd.h>

#include "render/error.h"

namespace skerry::render {
namespace {

constexpr int kMaxSide = 32768;

void append_u32(std::vector<std::uint8_t>& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// Closes a chunk that began at `start` (its length field): fills in the length and appends the checksum.
void finish_chunk(std::vector<std::uint8_t>& out, std::size_t start) {
  const std::size_t length = out.size() - start - 8;
  for (int i = 0; i < 4; ++i) out[start + i] = static_cast<std::uint8_t>(length >> (24 - 8 * i));
  append_u32(out, libdeflate_crc32(0, out.data() + start + 4, length + 4));
}

std::size_t begin_chunk(std::vector<std::uint8_t>& out, const char* type) {
  const std::size_t start = out.size();
  append_u32(out, 0);
  out.insert(out.end(), type, type + 4);
  return start;
}

/// Rows with their filter byte (0: none), as RGB if nothing is transparent.
std::vector<std::uint8_t> filtered_rows(const Image& image, bool opaque) {
  const std::size_t channels = opaque ? 3 : 4;
  const std::size_t width = static_cast<std::size_t>(image.width);
  std::vector<std::uint8_t> rows((1 + width * channels) * image.height);
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

}  // namespace

Image::Image(int width_px, int height_px, Color fill) : width(width_px), height(height_px) {
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    throw std::invalid_argument("image: sides must be 1 to 32768 px, got " + std::to_string(width) + " x " +
                                std::to_string(height));
  }
  rgba.resize(static_cast<std::size_t>(width) * height * 4);
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    rgba[i] = fill.r;
    rgba[i + 1] = fill.g;
    rgba[i + 2] = fill.b;
    rgba[i + 3] = fill.a;
  }
}

Color Image::at(int x, int y) const {
  const std::uint8_t* p = &rgba[4 * (static_cast<std::size_t>(y) * width + x)];
  return {p[0], p[1], p[2], p[3]};
}

void Image::set(int x, int y, Color color) {
  std::uint8_t* p = &rgba[4 * (static_cast<std::size_t>(y) * width + x)];
  p[0] = color.r;
  p[1] = color.g;
  p[2] = color.b;
  p[3] = color.a;
}

std::uint64_t digest(const Image& image) {
  constexpr std::uint64_t kPrime = 1099511628211ull;
  std::uint64_t hash = 14695981039346656037ull;
  hash = (hash ^ static_cast<std::uint64_t>(image.width)) * kPrime;
  hash = (hash ^ static_cast<std::uint64_t>(image.height)) * kPrime;
  // A pixel at a time instead of a byte: as good for this purpose and four times faster.
  for (std::size_t i = 0; i + 4 <= image.rgba.size(); i += 4) {
    const std::uint8_t* p = &image.rgba[i];
    const std::uint32_t pixel = p[0] | p[1] << 8 | p[2] << 16 | static_cast<std::uint32_t>(p[3]) << 24;
    hash = (hash ^ pixel) * kPrime;
    hash ^= hash >> 29;
  }
  return hash;
}

std::vector<std::uint8_t> encode_png(const Image& image) {
  const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
  if (pixels == 0 || image.rgba.size() != pixels * 4) {
    throw std::invalid_argument("png: image of " + std::to_string(image.width) + " x " +
                                std::to_string(image.height) + " px with " +
                                std::to_string(image.rgba.size()) + " bytes");
  }
  std::uint8_t alpha = 255;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) alpha &= image.rgba[i];
  const bool opaque = alpha == 255;
  const std::vector<std::uint8_t> rows = filtered_rows(image, opaque);

  std::vector<std::uint8_t> out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::size_t chunk = begin_chunk(out, "IHDR");
  append_u32(out, static_cast<std::uint32_t>(image.width));
  append_u32(out, static_cast<std::uint32_t>(image.height));
  // 8 bits, RGB or RGBA, the only compression and filter method, not interlaced
  for (const int byte : {8, opaque ? 2 : 6, 0, 0, 0}) out.push_back(static_cast<std::uint8_t>(byte));
  finish_chunk(out, chunk);

  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(1), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  chunk = begin_chunk(out, "IDAT");
  const std::size_t header = out.size();
  out.resize(header + libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
  const std::size_t used = libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(),
                                                    out.data() + header, out.size() - header);
  out.resize(header + used);
  finish_chunk(out, chunk);
  finish_chunk(out, begin_chunk(out, "IEND"));
  return out;
}

void write_file(const std::filesystem::path& path, const void* bytes, std::size_t size) {
  const std::string part = path.string() + ".part";
  const auto fail = [&](const char* what, int error) {
    throw EnvironmentError(path.string() + ": cannot " + what + ": " + system_message(error));
  };
  const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) fail("create", errno);
  const char* from = static_cast<const char*>(bytes);
  int error = 0;
  while (size > 0 && error == 0) {
    const ssize_t written = ::write(file, from, std::min<std::size_t>(size, 1 << 30));
    if (written > 0) {
      from += written;
      size -= static_cast<std::size_t>(written);
    } else if (written == 0 || errno != EINTR) {
      error = written == 0 ? ENOSPC : errno;
    }
  }
  if (::close(file) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(part.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(part.c_str());
    fail("write", error);
  }
}

void write_png(const std::filesystem::path& path, const Image& image) {
  const std::vector<std::uint8_t> bytes = encode_png(image);
  write_file(path, bytes.data(), bytes.size());
}

Image read_png(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  if (!file) throw EnvironmentError(path.string() + ": cannot open: " + system_message(errno));
  int width = 0, height = 0, channels = 0;
  const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
      stbi_load_from_file(file.get(), &width, &height, &channels, 4), stbi_image_free);
  if (!pixels) throw EnvironmentError(path.string() + ": cannot read as PNG: " + stbi_failure_reason());
  Image image(width, height);
  std::memcpy(image.rgba.data(), pixels.get(), image.rgba.size());
  return image;
}

}  // namespace skerry::render
