// SPDX-License-Identifier: MIT
//
// Pairs as 64-bit keys, and their sort. The sort is a part of every pair search, so it has to cost little
// more than writing the pairs down.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "physics/broadphase/broadphase.h"
#include "physics/broadphase/workers.h"

namespace skerry {

/// low in the upper half: keys sort as pairs do.
constexpr std::uint64_t pair_key(ProxyIndex a, ProxyIndex b) {
  return a < b ? (std::uint64_t{a} << 32) | b : (std::uint64_t{b} << 32) | a;
}

/// A pair as one number that compares as the pair does.
inline std::uint64_t to_key(const Pair& pair) {
  // On a little-endian machine the halves are in the wrong order for one comparison.
  if constexpr (std::endian::native == std::endian::little) {
    return std::rotl(std::bit_cast<std::uint64_t>(pair), 32);
  } else {
    return std::bit_cast<std::uint64_t>(pair);
  }
}

/// A growing array of keys that is never cleared to zero.
class PairBuffer {
 public:
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  std::uint64_t* data() { return keys_.get(); }
  const std::uint64_t* data() const { return keys_.get(); }
  void add(ProxyIndex a, ProxyIndex b) {
    *reserve(1) = pair_key(a, b);
    ++size_;
  }
  /// Makes room for `more` keys and returns where they go; the caller then says with `advance_to` how many
  /// came.
  std::uint64_t* reserve(std::size_t more) {
    if (size_ + more > capacity_) grow(size_ + more);
    return keys_.get() + size_;
  }
  void advance_to(const std::uint64_t* end) { size_ = static_cast<std::size_t>(end - keys_.get()); }
  std::size_t bytes() const { return capacity_ * sizeof(std::uint64_t); }

 private:
  void grow(std::size_t least);

  std::unique_ptr<std::uint64_t[]> keys_;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// Memory that the sort keeps between calls.
struct PairSortScratch {
  PairBuffer keys;
  std::vector<std::uint32_t> counts;
  std::vector<std::uint32_t> chunk_counts;

  std::size_t bytes() const {
    return keys.bytes() + (counts.capacity() + chunk_counts.capacity()) * sizeof(std::uint32_t);
  }
};

/// Sorts the keys of `parts` together into `pairs`: a bucket sort on `low` with about one bucket a pair, in
/// one pass while the buckets fit the second-level cache and in two beyond, then an insertion sort of the few
/// neighbours that share a bucket. O(pairs), whatever `limit`.
/// @param limit  one more than the largest number in the keys
/// @param workers  share the work where there is much of it; may be null
void sort_pairs(std::span<PairBuffer> parts, ProxyIndex limit, PairSortScratch& scratch,
                std::vector<Pair>& pairs, Workers* workers = nullptr);
/// The same for keys that are sorted already, one part after the other.
void join_pairs(std::span<const PairBuffer> parts, std::vector<Pair>& pairs);

}  // namespace skerry
