// SPDX-License-Identifier: MIT
//
// The memory of one Lua state in one piece, so that all variables of a script can be copied and put back.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace skerry::sandbox {

/// Everything a script had in memory at a moment. Good for the arena it came from only: it is full of
/// addresses.
struct LuaArenaImage {
  std::vector<std::byte> bytes;
  std::array<void*, 64> free{};
};

/// Blocks of 16 bytes times 1 to 32, above that of powers of two; freed blocks wait in a list for each size.
/// Address space is reserved for the limit, memory is used as it is touched.
class LuaArena {
 public:
  /// @throws std::bad_alloc if the address space cannot be had
  explicit LuaArena(std::size_t limit);
  ~LuaArena();
  LuaArena(const LuaArena&) = delete;
  LuaArena& operator=(const LuaArena&) = delete;

  /// As realloc, with the old size given; null for `block` allocates, zero for `new_size` frees. Returns null
  /// when the arena is full.
  void* resize(void* block, std::size_t old_size, std::size_t new_size);

  LuaArenaImage save() const;
  /// Puts all blocks back as they were, at the same addresses.
  void restore(const LuaArenaImage& image);

 private:
  void* take(std::size_t size);
  void give(void* block, std::size_t size);

  std::byte* base_;
  std::size_t reserved_;
  std::size_t used_ = 0;
  std::array<void*, 64> free_{};
};

}  // namespace skerry::sandbox
