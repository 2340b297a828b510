// SPDX-License-Identifier: MIT
#include "physics/broadphase/pair_buffer.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace skerry {

namespace {

/// One-pass bucket sorts use at most this many buckets: 2^17 counters are 512 KiB.
constexpr int kDirectBits = 17;
/// Buckets of the second pass: their counters and pairs stay in the first-level cache.
constexpr int kChunkBits = 10;
constexpr Pair to_pair(std::uint64_t key) {
  return {static_cast<ProxyIndex>(key >> 32), static_cast<ProxyIndex>(key)};
}

/// Moves the smaller of two keys to the front, without a branch.
inline void order(std::uint64_t& a, std::uint64_t& b) {
  const std::uint64_t low = std::min(a, b);
  b = std::max(a, b);
  a = low;
}

/// Sorts four pairs by a network.
inline void sort_four(Pair* p) {
  // On a little-endian machine the halves of a pair are in the wrong order for one comparison.
  std::uint64_t k[4];
  for (int i = 0; i < 4; ++i) k[i] = std::uint64_t{p[i].low} << 32 | p[i].high;
  order(k[0], k[1]);
  order(k[2], k[3]);
  order(k[0], k[2]);
  order(k[1], k[3]);
  order(k[1], k[2]);
  for (int i = 0; i < 4; ++i) p[i] = to_pair(k[i]);
}

/// Sorts a longer bucket; short ones by insertion, a floor with thousands of boxes on it as the library does.
inline void sort_bucket(Pair* first, Pair* last) {
  constexpr std::ptrdiff_t kShort = 16;
  if (last - first > kShort) return std::sort(first, last);
  for (Pair* i = first + 1; i < last; ++i) {
    const Pair moving = *i;
    Pair* j = i;
    for (; j > first && moving < j[-1]; --j) *j = j[-1];
    *j = moving;
  }
}

/// Sorts within buckets; `ends` has each bucket's end. What follows a bucket is larger, so four pairs can be
/// sorted from its start on without a look at its length, which no branch predictor could guess.
void sort_within_buckets(Pair* out, std::size_t count, const std::uint32_t* ends, std::uint32_t buckets) {
  std::uint32_t begin = 0;
  for (std::uint32_t b = 0; b < buckets; begin = ends[b++]) {
    if (ends[b] - begin > 4) {
      sort_bucket(out + begin, out + ends[b]);
    } else if (begin + 4 <= count) {
      sort_four(out + begin);
    }
  }
  // The last buckets, which have no four pairs after their start.
  if (count > 0) std::sort(out + (count > 8 ? count - 8 : 0), out + count);
}

/// Sorts `count` keys into `out` by buckets `(low >> shift) - base`.
void bucket_sort(const std::uint64_t* keys, std::size_t count, int shift, std::uint32_t base,
                 std::uint32_t buckets, std::uint32_t* counts, Pair* out) {
  std::memset(counts, 0, (buckets + 1) * sizeof(std::uint32_t));
  const int key_shift = 32 + shift;
  for (std::size_t i = 0; i < count; ++i) ++counts[static_cast<std::uint32_t>(keys[i] >> key_shift) - base];
  std::uint32_t sum = 0;
  for (std::uint32_t b = 0; b < buckets; ++b) {
    const std::uint32_t here = counts[b];
    counts[b] = sum;
    sum += here;
  }
  for (std::size_t i = 0; i < count; ++i) {
    out[counts[static_cast<std::uint32_t>(keys[i] >> key_shift) - base]++] = to_pair(keys[i]);
  }
  sort_within_buckets(out, count, counts, buckets);
}

}  // namespace

void PairBuffer::grow(std::size_t least) {
  const std::size_t capacity = std::max(least, capacity_ + capacity_ / 2 + 256);
  auto larger = std::make_unique_for_overwrite<std::uint64_t[]>(capacity);
  if (size_ > 0) std::memcpy(larger.get(), keys_.get(), size_ * sizeof(std::uint64_t));
  keys_ = std::move(larger);
  capacity_ = capacity;
}

void sort_pairs(std::span<PairBuffer> parts, ProxyIndex limit, PairSortScratch& scratch,
                std::vector<Pair>& pairs) {
  std::size_t total = 0;
  for (const PairBuffer& part : parts) total += part.size();
  pairs.resize(total);
  if (total == 0) return;

  // About one bucket a pair, but not more than there are numbers.
  const int low_bits = std::bit_width(limit > 0 ? limit - 1 : 0);
  const int pair_bits = std::bit_width(total);
  const int shift = std::max(0, low_bits - pair_bits);
  if (low_bits - shift <= kDirectBits) {
    PairBuffer* keys = &parts.front();
    for (PairBuffer& part : parts.subspan(1)) {
      std::uint64_t* to = keys->reserve(part.size());
      std::copy_n(part.data(), part.size(), to);
      keys->advance_to(to + part.size());
    }
    const std::uint32_t buckets = ((limit - 1) >> shift) + 1;
    scratch.counts.resize(buckets + 1);
    bucket_sort(keys->data(), total, shift, 0, buckets, scratch.counts.data(), pairs.data());
    return;
  }

  // First pass: chunks of 2^kChunkBits buckets.
  const int key_shift = 32 + shift + kChunkBits;
  const std::uint32_t chunks = ((limit - 1) >> (shift + kChunkBits)) + 1;
  std::vector<std::uint32_t>& ends = scratch.chunk_counts;
  ends.assign(chunks + 1, 0);
  for (const PairBuffer& part : parts) {
    for (std::size_t i = 0; i < part.size(); ++i) ++ends[part.data()[i] >> key_shift];
  }
  std::uint32_t sum = 0;
  for (std::uint32_t& end : ends) {
    const std::uint32_t here = end;
    end = sum;
    sum += here;
  }
  scratch.keys.clear();
  std::uint64_t* grouped = scratch.keys.reserve(total);
  for (const PairBuffer& part : parts) {
    for (std::size_t i = 0; i < part.size(); ++i) {
      const std::uint64_t key = part.data()[i];
      grouped[ends[key >> key_shift]++] = key;
    }
  }

  // Second pass: each chunk within the cache.
  scratch.counts.resize((std::size_t{1} << kChunkBits) + 1);
  std::uint32_t begin = 0;
  for (std::uint32_t c = 0; c < chunks; ++c) {
    bucket_sort(grouped + begin, ends[c] - begin, shift, c << kChunkBits, 1u << kChunkBits,
                scratch.counts.data(), pairs.data() + begin);
    begin = ends[c];
  }
}

}  // namespace skerry
