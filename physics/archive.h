// SPDX-License-Identifier: MIT
//
// Bytes of files: one list of fields writes a structure and reads it back. Numbers are little-endian whatever
// the machine, so a file is the same everywhere.
//
// A structure takes part with a function `fields(Archive&, T&)` beside the others of its kind, or a member
// `fields(Archive&)`. Written as a structured binding of all members it cannot be forgotten: a new member
// does not compile until it is bound, and one looks at the list then.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace skerry {

class SolverMemory;

/// Bytes that are no such file, or no longer: the message says what is wrong and at which offset.
class ArchiveError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Archive {
 public:
  /// Writes: appends to `out`.
  explicit Archive(std::vector<std::byte>& out) : out_(&out) {}
  /// Reads `in`. @param origin offset of its first byte in the file, for messages
  Archive(std::span<const std::byte> in, std::size_t origin) : in_(in), origin_(origin) {}

  bool reading() const { return out_ == nullptr; }
  /// Bytes not read yet.
  std::size_t left() const { return in_.size() - at_; }
  /// @throws ArchiveError "offset N: why"
  [[noreturn]] void refuse(const std::string& why) const;
  /// After reading: @throws ArchiveError if bytes are left over.
  void finish() const;

  template <class... T>
  void operator()(T&... values) {
    (value(values), ...);
  }
  /// `count` doubles that lie behind each other.
  void doubles(void* first, std::size_t count);
  /// A number of things that need at least one byte each: more than there are bytes left are refused.
  void count(std::size_t& n);

 private:
  void raw(void* data, std::size_t size);
  void text(std::string& value);
  void text(std::string_view& value);
  void memory(std::unique_ptr<SolverMemory>& value);

  template <class T>
  struct IsVector : std::false_type {};
  template <class T>
  struct IsVector<std::vector<T>> : std::true_type {};
  template <class T>
  struct IsStdArray : std::false_type {};
  template <class T, std::size_t N>
  struct IsStdArray<std::array<T, N>> : std::true_type {};
  template <class T>
  struct IsOptional : std::false_type {};
  template <class T>
  struct IsOptional<std::optional<T>> : std::true_type {};

  template <class T>
  void value(T& x) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = x ? 1 : 0;
      raw(&byte, 1);
      if (byte > 1) refuse("expected 0 or 1, got " + std::to_string(byte));
      x = byte != 0;
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      number(x);
    } else if constexpr (std::is_same_v<T, std::string> || std::is_same_v<T, std::string_view>) {
      text(x);
    } else if constexpr (std::is_same_v<T, std::unique_ptr<SolverMemory>>) {
      memory(x);
    } else if constexpr (std::is_array_v<T> || IsStdArray<T>::value) {
      for (auto& item : x) value(item);
    } else if constexpr (IsOptional<T>::value) {
      bool has = x.has_value();
      value(has);
      if (reading()) x.reset();
      if (has && reading()) x.emplace();
      if (has) value(*x);
    } else if constexpr (IsVector<T>::value) {
      vector(x);
    } else if constexpr (requires { x.fields(*this); }) {
      x.fields(*this);
    } else {
      fields(*this, x);
    }
  }

  template <class T>
  void number(T& x) {
    if constexpr (std::endian::native == std::endian::little || sizeof(T) == 1) {
      raw(&x, sizeof x);
    } else {
      auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(x);
      for (std::size_t i = 0; i < bytes.size() / 2; ++i) std::swap(bytes[i], bytes[bytes.size() - 1 - i]);
      raw(bytes.data(), bytes.size());
      for (std::size_t i = 0; i < bytes.size() / 2; ++i) std::swap(bytes[i], bytes[bytes.size() - 1 - i]);
      x = std::bit_cast<T>(bytes);
    }
  }

  template <class T>
  void vector(std::vector<T>& items) {
    std::size_t n = items.size();
    count(n);
    if constexpr (std::is_arithmetic_v<T> && std::endian::native == std::endian::little) {
      if (reading() && n > left() / sizeof(T)) refuse("ends in the middle of a list");
      items.resize(n);
      raw(items.data(), n * sizeof(T));
    } else {
      // One by one, so that a wrong count meets the end of the bytes before it takes the memory.
      if (reading()) items.clear();
      for (std::size_t i = 0; i < n; ++i) {
        if (reading()) items.emplace_back();
        value(items[i]);
      }
    }
  }

  std::vector<std::byte>* out_ = nullptr;
  std::span<const std::byte> in_;
  std::size_t at_ = 0, origin_ = 0;
};

/// A part of a file: four letters and its bytes.
struct ArchiveSection {
  std::array<char, 4> tag;
  std::vector<std::byte> bytes;
};

/// Puts sections together: magic, kind, version, byte order, then each section with its length and checksum.
/// @param kind at most 8 characters
std::vector<std::byte> pack_sections(std::string_view kind, std::uint32_t version,
                                     std::span<const ArchiveSection> sections);

/// The inverse. Gives an archive to read for each of `tags`, in this order.
/// @throws ArchiveError for a file that is foreign, of another kind or version, cut off, longer than it says,
/// or with a section whose checksum does not hold; the message names the offset
std::vector<Archive> unpack_sections(std::span<const std::byte> bytes, std::string_view kind,
                                     std::uint32_t version, std::span<const std::string_view> tags);

}  // namespace skerry
