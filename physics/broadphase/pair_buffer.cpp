// SPDX-License-Identifier: MIT
#include "physics/broadphase/pair_buffer.h"

#include <algorithm>
#include <cstring>

#include "physics/spare.h"

namespace skerry {

namespace {

/// One-pass bucket sorts use at most this many buckets: 2^17 counters are 512 KiB.
constexpr int kDirectBits = 17;
/// Pairs that are sorted by both numbers at most: two arrays of 512 KiB.
constexpr std::size_t kMostByBoth = 1u << 16;
/// Of more pairs with few numbers, so many by both at a time, as far as they are spread evenly, and the
/// largest number up to which that pays: each time all numbers are counted.
constexpr std::size_t kByBothAtATime = 1u << 15;
constexpr ProxyIndex kFewNumbers = 1u << 15;
/// Buckets of the second pass: their counters and pairs stay in the first-level cache.
constexpr int kChunkBits = 10;
/// So many numbers a pair, as a power of two, and more: digits instead of buckets.
constexpr int kSparseShift = 3;
/// So few pairs are sorted one by one.
constexpr std::size_t kFew = 32;

constexpr Pair to_pair(std::uint64_t key) {
  return {static_cast<ProxyIndex>(key >> 32), static_cast<ProxyIndex>(key)};
}

/// Moves the smaller of two keys to the front, without a branch.
inline void order(std::uint64_t& a, std::uint64_t& b) {
  const std::uint64_t low = std::min(a, b);
  b = std::max(a, b);
  a = low;
}

/// Sorts `n` pairs by a network of comparators.
template <int n, std::size_t comparators>
inline void sort_network(Pair* p, const std::uint8_t (&network)[comparators][2]) {
  std::uint64_t k[n];
  for (int i = 0; i < n; ++i) k[i] = to_key(p[i]);
#pragma GCC unroll 19
  for (std::size_t c = 0; c < comparators; ++c) order(k[network[c][0]], k[network[c][1]]);
  for (int i = 0; i < n; ++i) p[i] = to_pair(k[i]);
}
/// The best networks for four and eight [Knuth 1998, The Art of Computer Programming 3, sec. 5.3.4].
constexpr std::uint8_t kFour[][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 3}, {1, 2}};
constexpr std::uint8_t kEight[][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6},
                                      {5, 7}, {1, 2}, {5, 6}, {0, 4}, {1, 5}, {2, 6}, {3, 7},
                                      {2, 4}, {3, 5}, {1, 2}, {3, 4}, {5, 6}};

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

/// Sorts within buckets; `ends` has each bucket's end. What follows a bucket is larger, so `n` pairs can be
/// sorted from its start on without a look at its length, which no branch predictor could guess.
template <int n, std::size_t comparators>
void sort_within_buckets(Pair* out, std::size_t count, const std::uint32_t* ends, std::uint32_t buckets,
                         const std::uint8_t (&network)[comparators][2]) {
  std::uint32_t begin = 0;
  for (std::uint32_t b = 0; b < buckets; begin = ends[b++]) {
    if (ends[b] - begin > n) {
      sort_bucket(out + begin, out + ends[b]);
    } else if (begin + n <= count) {
      sort_network<n>(out + begin, network);
    }
  }
  // The last buckets, which have no `n` pairs after their start.
  if (count > 0) std::sort(out + (count > 2 * n ? count - 2 * n : 0), out + count);
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
  if (count < 2 * std::size_t{buckets}) {
    sort_within_buckets<4>(out, count, counts, buckets, kFour);
  } else {
    sort_within_buckets<8>(out, count, counts, buckets, kEight);
  }
}

/// Makes the first place of each bucket from the counts.
void add_up(std::uint32_t* counts, std::uint32_t buckets) {
  std::uint32_t sum = 0;
  for (std::uint32_t b = 0; b < buckets; ++b) {
    const std::uint32_t here = counts[b];
    counts[b] = sum;
    sum += here;
  }
}

/// Sorts `count` keys with `high` below `limit` and `low` in [base, base + lows) into `out`: by `high`, then
/// by `low` without a change of that order. Faster than networks where a number has several pairs.
void sort_by_both(const std::uint64_t* keys, std::size_t count, ProxyIndex limit, std::uint32_t base,
                  std::uint32_t lows, PairSortScratch& scratch, Pair* out) {
  scratch.counts.assign(std::size_t{limit} + lows, 0);
  std::uint32_t* const by_high = scratch.counts.data();
  std::uint32_t* const by_low = by_high + limit;
  for (std::size_t i = 0; i < count; ++i) {
    ++by_high[static_cast<std::uint32_t>(keys[i])];
    ++by_low[static_cast<std::uint32_t>(keys[i] >> 32) - base];
  }
  add_up(by_high, limit);
  add_up(by_low, lows);
  scratch.keys.clear();
  std::uint64_t* const sorted = scratch.keys.reserve(count);
  for (std::size_t i = 0; i < count; ++i) sorted[by_high[static_cast<std::uint32_t>(keys[i])]++] = keys[i];
  for (std::size_t i = 0; i < count; ++i)
    out[by_low[static_cast<std::uint32_t>(sorted[i] >> 32) - base]++] = to_pair(sorted[i]);
}

/// Sorts `count` keys with numbers below 2^bits into `out`, digit by digit from the last: for keys that are
/// few beside the numbers, so that their buckets would be filled by chance. `keys` is overwritten.
void sort_by_digits(std::uint64_t* keys, std::size_t count, int bits, PairSortScratch& scratch, Pair* out) {
  // Digits of a number: as few as have not many more values than there are keys.
  const int digits = (bits + std::bit_width(count) - 1) / static_cast<int>(std::bit_width(count));
  const int width = (bits + digits - 1) / digits;
  const std::size_t values = std::size_t{1} << width;
  const std::uint64_t mask = values - 1;
  const auto shift_of = [&](int digit) {
    return digit < digits ? digit * width : 32 + (digit - digits) * width;
  };
  scratch.counts.assign(2 * static_cast<std::size_t>(digits) * values, 0);
  for (int digit = 0; digit < 2 * digits; ++digit) {
    std::uint32_t* const counts = scratch.counts.data() + static_cast<std::size_t>(digit) * values;
    const int shift = shift_of(digit);
    for (std::size_t i = 0; i < count; ++i) ++counts[keys[i] >> shift & mask];
    add_up(counts, static_cast<std::uint32_t>(values));
  }
  scratch.keys.clear();
  std::uint64_t* other = scratch.keys.reserve(count);
  const int last = 2 * digits - 1;
  for (int digit = 0; digit < last; ++digit) {
    std::uint32_t* const counts = scratch.counts.data() + static_cast<std::size_t>(digit) * values;
    const int shift = shift_of(digit);
    for (std::size_t i = 0; i < count; ++i) other[counts[keys[i] >> shift & mask]++] = keys[i];
    std::swap(keys, other);
  }
  std::uint32_t* const counts = scratch.counts.data() + static_cast<std::size_t>(last) * values;
  const int shift = shift_of(last);
  for (std::size_t i = 0; i < count; ++i) out[counts[keys[i] >> shift & mask]++] = to_pair(keys[i]);
}

}  // namespace

void PairBuffer::grow(std::size_t least) {
  // New pages take longer than writing keys.
  const std::size_t capacity = 2 * least + 256;
  auto larger = std::make_unique_for_overwrite<std::uint64_t[]>(capacity);
  if (size_ > 0) std::memcpy(larger.get(), keys_.get(), size_ * sizeof(std::uint64_t));
  keys_ = std::move(larger);
  capacity_ = capacity;
}

void join_pairs(std::span<const PairBuffer> parts, std::vector<Pair>& pairs) {
  std::size_t total = 0;
  for (const PairBuffer& part : parts) total += part.size();
  pairs.resize(total);
  auto to = pairs.begin();
  for (const PairBuffer& part : parts)
    to = std::transform(part.data(), part.data() + part.size(), to, to_pair);
}

void sort_pairs(std::span<PairBuffer> parts, ProxyIndex limit, PairSortScratch& scratch,
                std::vector<Pair>& pairs, Workers* workers) {
  std::size_t total = 0;
  for (const PairBuffer& part : parts) total += part.size();
  pairs.resize(total);
  if (total == 0) return;
  if (total == 1) return join_pairs(parts, pairs);

  // About one bucket a pair, but not more than there are numbers.
  const int low_bits = std::bit_width(limit > 0 ? limit - 1 : 0);
  const int pair_bits = std::bit_width(total);
  const int shift = std::max(0, low_bits - pair_bits);
  // Several pairs a number: two passes while they stay in the second-level cache.
  const bool is_dense = shift == 0 && total > 2 * std::size_t{limit};
  const bool is_sparse = shift >= kSparseShift;
  const bool in_chunks_by_both = is_dense && total > kMostByBoth && limit <= kFewNumbers;
  if (is_sparse ||
      (!in_chunks_by_both && (is_dense ? total <= kMostByBoth : low_bits - shift <= kDirectBits))) {
    PairBuffer* keys = &parts.front();
    for (PairBuffer& part : parts.subspan(1)) {
      std::uint64_t* to = keys->reserve(part.size());
      std::copy_n(part.data(), part.size(), to);
      keys->advance_to(to + part.size());
    }
    if (is_dense) {
      return sort_by_both(keys->data(), total, limit, 0, limit, scratch, pairs.data());
    }
    if (total <= kFew) {
      std::transform(keys->data(), keys->data() + total, pairs.data(), to_pair);
      return sort_bucket(pairs.data(), pairs.data() + total);
    }
    if (is_sparse) return sort_by_digits(keys->data(), total, low_bits, scratch, pairs.data());
    const std::uint32_t buckets = ((limit - 1) >> shift) + 1;
    scratch.counts.resize(buckets + 1);
    bucket_sort(keys->data(), total, shift, 0, buckets, scratch.counts.data(), pairs.data());
    return;
  }

  // First pass: chunks of 2^chunk_bits buckets.
  int chunk_bits = kChunkBits;
  while (in_chunks_by_both && chunk_bits > 1 && (total << chunk_bits) > kByBothAtATime * limit) --chunk_bits;
  const int key_shift = 32 + shift + chunk_bits;
  const std::uint32_t chunks = ((limit - 1) >> (shift + chunk_bits)) + 1;
  std::vector<std::uint32_t>& ends = scratch.chunk_counts;
  ends.assign(chunks + 1, 0);
  for (const PairBuffer& part : parts) {
    for (std::size_t i = 0; i < part.size(); ++i) ++ends[part.data()[i] >> key_shift];
  }
  add_up(ends.data(), chunks + 1);
  scratch.keys.clear();
  std::uint64_t* grouped = scratch.keys.reserve(total);
  for (const PairBuffer& part : parts) {
    for (std::size_t i = 0; i < part.size(); ++i) {
      const std::uint64_t key = part.data()[i];
      grouped[ends[key >> key_shift]++] = key;
    }
  }

  // Second pass: each chunk within the cache.
  const std::size_t shares =
      workers != nullptr ? std::min<std::size_t>(workers->shares(total, kMostByBoth), chunks) : 1;
  const auto sort_share = [&](std::size_t share) {
    Spare<PairSortScratch> own;
    own->counts.resize((std::size_t{1} << chunk_bits) + 1);
    const auto first = static_cast<std::uint32_t>(chunks * share / shares);
    const auto last = static_cast<std::uint32_t>(chunks * (share + 1) / shares);
    for (std::uint32_t c = first; c < last; ++c) {
      const std::uint32_t begin = c == 0 ? 0 : ends[c - 1], base = c << chunk_bits;
      Pair* const out = pairs.data() + begin;
      if (in_chunks_by_both) {
        sort_by_both(grouped + begin, ends[c] - begin, limit, base, 1u << chunk_bits, *own, out);
      } else {
        bucket_sort(grouped + begin, ends[c] - begin, shift, base, 1u << chunk_bits, own->counts.data(), out);
      }
    }
  };
  if (shares == 1)
    sort_share(0);
  else
    workers->run(shares, sort_share);
}

}  // namespace skerry
