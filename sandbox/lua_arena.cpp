// SPDX-License-Identifier: MIT
#include "sandbox/lua_arena.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <new>
#include <sys/mman.h>

namespace skerry::sandbox {
namespace {

constexpr std::size_t kGrain = 16;
constexpr std::size_t kSmall = 512;  // up to here a size has its own list
constexpr std::size_t kSmallClasses = kSmall / kGrain;

struct SizeClass {
  std::size_t index, bytes;
};

SizeClass class_of(std::size_t size) {
  if (size <= kSmall) {
    const std::size_t grains = std::max<std::size_t>(1, (size + kGrain - 1) / kGrain);
    return {grains - 1, grains * kGrain};
  }
  const std::size_t bytes = std::bit_ceil(size);
  return {kSmallClasses + static_cast<std::size_t>(std::countr_zero(bytes / kSmall)) - 1, bytes};
}

}  // namespace

LuaArena::LuaArena(std::size_t limit)
    // Rounding up to powers of two and lists of freed blocks of other sizes: four times the limit is ample.
    : reserved_(4 * std::max<std::size_t>(limit, 1u << 20)) {
  void* place =
      mmap(nullptr, reserved_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (place == MAP_FAILED) throw std::bad_alloc();
  base_ = static_cast<std::byte*>(place);
}

LuaArena::~LuaArena() {
  munmap(base_, reserved_);
}

void* LuaArena::take(std::size_t size) {
  const SizeClass kind = class_of(size);
  if (void* block = free_[kind.index]) {
    std::memcpy(&free_[kind.index], block, sizeof(void*));
    return block;
  }
  if (kind.bytes > reserved_ - used_) return nullptr;
  void* block = base_ + used_;
  used_ += kind.bytes;
  return block;
}

void LuaArena::give(void* block, std::size_t size) {
  const SizeClass kind = class_of(size);
  std::memcpy(block, &free_[kind.index], sizeof(void*));
  free_[kind.index] = block;
}

void* LuaArena::resize(void* block, std::size_t old_size, std::size_t new_size) {
  if (new_size == 0) {
    if (block) give(block, old_size);
    return nullptr;
  }
  if (!block) return take(new_size);
  if (class_of(old_size).index == class_of(new_size).index) return block;
  void* result = take(new_size);
  if (!result) return nullptr;
  std::memcpy(result, block, std::min(old_size, new_size));
  give(block, old_size);
  return result;
}

LuaArenaImage LuaArena::save() const {
  return {{base_, base_ + used_}, free_};
}

void LuaArena::restore(const LuaArenaImage& image) {
  std::memcpy(base_, image.bytes.data(), image.bytes.size());
  used_ = image.bytes.size();
  free_ = image.free;
}

}  // namespace skerry::sandbox
