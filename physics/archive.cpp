// SPDX-License-Identifier: MIT
#include "physics/archive.h"

#include <algorithm>
#include <mutex>
#include <set>

#include "physics/hash.h"
#include "physics/solver/solver.h"

namespace skerry {
namespace {

// As in PNG: a byte above 127, and line ends that a text transfer would change.
constexpr char kMagic[] = "\x8bSKERRY\r\n\x1a\n";
constexpr std::size_t kMagicSize = sizeof kMagic - 1;
constexpr std::uint64_t kByteOrder = 0x0123456789abcdefull;
constexpr std::size_t kKindSize = 8;
// Names of solvers and methods are short; a longer one is no name.
constexpr std::size_t kLongestName = 256;

[[noreturn]] void refuse_at(std::size_t offset, const std::string& why) {
  throw ArchiveError("offset " + std::to_string(offset) + ": " + why);
}

std::uint64_t checksum(std::span<const std::byte> bytes) {
  Fnv1a hash;
  hash.add(static_cast<std::uint64_t>(bytes.size()));
  for (std::size_t i = 0; i < bytes.size(); i += 8) {
    std::uint64_t word = 0;
    const std::size_t size = std::min<std::size_t>(8, bytes.size() - i);
    for (std::size_t k = 0; k < size; ++k) word |= std::to_integer<std::uint64_t>(bytes[i + k]) << (8 * k);
    hash.add(word);
  }
  return hash.value();
}

std::array<char, kKindSize> padded(std::string_view kind) {
  std::array<char, kKindSize> letters;
  letters.fill(' ');
  std::copy_n(kind.begin(), std::min(kind.size(), kKindSize), letters.begin());
  return letters;
}

/// Text with the lifetime of the program, for views.
std::string_view interned(const std::string& text) {
  static std::mutex mutex;
  static std::set<std::string> names;
  const std::lock_guard lock(mutex);
  return *names.insert(text).first;
}

}  // namespace

void Archive::refuse(const std::string& why) const {
  refuse_at(origin_ + at_, why);
}

void Archive::finish() const {
  if (left() != 0) refuse(std::to_string(left()) + " bytes more than expected");
}

void Archive::raw(void* data, std::size_t size) {
  if (size == 0) return;
  if (out_) {
    const auto* first = static_cast<const std::byte*>(data);
    out_->insert(out_->end(), first, first + size);
    return;
  }
  if (left() < size) refuse("the data end, but " + std::to_string(size) + " more bytes are needed");
  std::memcpy(data, in_.data() + at_, size);
  at_ += size;
}

void Archive::count(std::size_t& n) {
  auto number = static_cast<std::uint64_t>(n);
  value(number);
  if (reading() && number > left()) {
    refuse("a list of " + std::to_string(number) + " entries, but only " + std::to_string(left()) +
           " bytes are left");
  }
  n = static_cast<std::size_t>(number);
}

void Archive::doubles(void* first, std::size_t count) {
  auto* place = static_cast<std::byte*>(first);
  for (std::size_t i = 0; i < count; ++i, place += sizeof(double)) {
    double number;
    std::memcpy(&number, place, sizeof number);
    value(number);
    std::memcpy(place, &number, sizeof number);
  }
}

void Archive::text(std::string& text) {
  std::size_t size = text.size();
  count(size);
  text.resize(size);
  raw(text.data(), size);
}

void Archive::text(std::string_view& text_view) {
  std::string copy(text_view);
  text(copy);
  if (copy.size() > kLongestName) refuse("a name of " + std::to_string(copy.size()) + " characters");
  if (reading()) text_view = interned(copy);
}

void Archive::memory(std::unique_ptr<SolverMemory>& memory) {
  std::string solver(memory ? memory->solver() : "");
  text(solver);
  if (reading()) {
    memory.reset();
    if (solver.empty()) return;
    const auto all = solvers();
    const auto row = std::find_if(all.begin(), all.end(), [&](const auto& x) { return x.name == solver; });
    if (row == all.end() || !row->make_memory) refuse("no solver \"" + solver + "\" that keeps a memory");
    memory = row->make_memory();
  }
  if (memory) memory->archive(*this);
}

std::vector<std::byte> pack_sections(std::string_view kind, std::uint32_t version,
                                     std::span<const ArchiveSection> sections) {
  std::vector<std::byte> out;
  Archive archive(out);
  for (const char c : std::string_view(kMagic, kMagicSize)) out.push_back(static_cast<std::byte>(c));
  std::array<char, kKindSize> letters = padded(kind);
  std::uint64_t order = kByteOrder;
  auto count = static_cast<std::uint32_t>(sections.size());
  archive(letters, version, order, count);
  for (const ArchiveSection& section : sections) {
    std::array<char, 4> tag = section.tag;
    std::uint64_t size = section.bytes.size(), sum = checksum(section.bytes);
    archive(tag, size, sum);
    out.insert(out.end(), section.bytes.begin(), section.bytes.end());
  }
  return out;
}

std::vector<Archive> unpack_sections(std::span<const std::byte> bytes, std::string_view kind,
                                     std::uint32_t version, std::span<const std::string_view> tags) {
  const auto as_text = [](auto letters) {
    std::string text(letters.begin(), letters.end());
    return text.substr(0, text.find_last_not_of(' ') + 1);
  };
  if (bytes.size() < kMagicSize || std::memcmp(bytes.data(), kMagic, kMagicSize) != 0) {
    refuse_at(0, "not a Skerry file (its first bytes are others)");
  }
  std::size_t offset = kMagicSize;
  Archive head(bytes.subspan(offset), offset);
  std::array<char, kKindSize> letters;
  std::uint32_t found_version = 0, count = 0;
  std::uint64_t order = 0;
  head(letters, found_version, order, count);
  if (letters != padded(kind)) {
    refuse_at(offset,
              "a Skerry file of kind \"" + as_text(letters) + "\", expected \"" + std::string(kind) + '"');
  }
  if (found_version != version) {
    refuse_at(offset + kKindSize, "version " + std::to_string(found_version) +
                                      ", this program reads version " + std::to_string(version));
  }
  if (order != kByteOrder) refuse_at(offset + kKindSize + 4, "the byte order mark is damaged");
  if (count != tags.size())
    refuse_at(offset + kKindSize + 12,
              "expected " + std::to_string(tags.size()) + " sections, got " + std::to_string(count));
  std::vector<Archive> sections;
  offset = bytes.size() - head.left();
  for (const std::string_view expected : tags) {
    Archive start(bytes.subspan(offset), offset);
    std::array<char, 4> tag;
    std::uint64_t size = 0, sum = 0;
    start(tag, size, sum);
    if (std::string_view(tag.data(), tag.size()) != expected)
      refuse_at(offset, "expected section " + std::string(expected));
    if (size > start.left()) {
      refuse_at(offset, "section " + std::string(expected) + " is cut off: " + std::to_string(size) +
                            " bytes announced, " + std::to_string(start.left()) + " there");
    }
    offset = bytes.size() - start.left();
    const auto content = bytes.subspan(offset, static_cast<std::size_t>(size));
    if (checksum(content) != sum)
      refuse_at(offset, "section " + std::string(expected) + " is damaged: its checksum does not hold");
    sections.emplace_back(content, offset);
    offset += content.size();
  }
  if (offset != bytes.size()) {
    refuse_at(offset, std::to_string(bytes.size() - offset) + " bytes after the last section");
  }
  return sections;
}

}  // namespace skerry
