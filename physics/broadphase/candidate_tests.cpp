// SPDX-License-Identifier: MIT
#include "physics/broadphase/candidate_tests.h"

#include <algorithm>

namespace skerry {

namespace {

/// So many candidates ahead the processor is told which box will be needed.
constexpr std::size_t kAhead = 24;
static_assert(kAhead + 4 <= kCandidatePadding);
/// Candidates are tested in blocks, for which room is made at once.
constexpr std::size_t kBlock = 2048;

/// The exact answer, by doubles where single precision cannot tell, and by the marks.
template <bool by_mark>
bool is_pair(const PairRequest& request, Pair pair, FloatOverlap overlaps) {
  auto hit = static_cast<unsigned>(overlaps.maybe);
  if ((hit & ~static_cast<unsigned>(overlaps.certain)) != 0) [[unlikely]] {
    hit = overlap(request.boxes.box(pair.low), request.boxes.box(pair.high)) ? 1 : 0;
  }
  if constexpr (by_mark) {
    hit &= static_cast<unsigned>(request.wants(pair.low)) | static_cast<unsigned>(request.wants(pair.high));
  }
  return hit != 0;
}

/// Tests candidates in their order and writes down those that are pairs. @return the end of what was
/// written
/// @tparam by_mark  only pairs with a box that is marked as moved
template <bool by_mark>
std::uint64_t* test_narrow(const CandidateTests& tests, std::span<const Pair> candidates, std::uint64_t* at) {
  const PairRequest& request = tests.request;
  const FloatBox* const tight = tests.boxes.data();
  for (const Pair& pair : candidates) {
    prefetch(&tight[(&pair)[kAhead].high]);
    const FloatOverlap overlaps = FloatLimits(tight[pair.low]).compare(tight[pair.high]);
    // Stored in any case and kept if it counts: nothing here for a processor to guess, but the rare ties.
    *at = std::uint64_t{pair.low} << 32 | pair.high;
    at += is_pair<by_mark>(request, pair, overlaps) ? 1 : 0;
  }
  return at;
}

#if defined(SKERRY_WIDE_TESTS)
/// The same with four candidates in one instruction, where the processor has it.
/// @tparam scattered  neighbours in the list are not neighbours in memory
template <bool by_mark, bool scattered>
__attribute__((target("avx512f,avx512vl,bmi2,popcnt"))) std::uint64_t* test_wide(
    const CandidateTests& tests, std::span<const Pair> candidates, std::uint64_t* at) {
  const PairRequest& request = tests.request;
  const FloatBox* const tight = tests.boxes.data();
  const __m512 sign = _mm512_castsi512_ps(_mm512_set1_epi32(static_cast<int>(0x80000000u)));
  std::size_t i = 0;
  for (; i + 4 <= candidates.size(); i += 4) {
    const Pair* const p = &candidates[i];
    __m512 low = _mm512_castps128_ps512(_mm_load_ps(tight[p[0].low].v));
    __m512 high = _mm512_castps128_ps512(_mm_load_ps(tight[p[0].high].v));
    low = _mm512_insertf32x4(low, _mm_load_ps(tight[p[1].low].v), 1);
    high = _mm512_insertf32x4(high, _mm_load_ps(tight[p[1].high].v), 1);
    low = _mm512_insertf32x4(low, _mm_load_ps(tight[p[2].low].v), 2);
    high = _mm512_insertf32x4(high, _mm_load_ps(tight[p[2].high].v), 2);
    low = _mm512_insertf32x4(low, _mm_load_ps(tight[p[3].low].v), 3);
    high = _mm512_insertf32x4(high, _mm_load_ps(tight[p[3].high].v), 3);
    for (std::size_t k = 0; k < 4; ++k) {
      prefetch(&tight[p[kAhead + k].high]);
      if constexpr (scattered) prefetch(&tight[p[kAhead + k].low]);
    }
    const __m512 limits = _mm512_castsi512_ps(
        _mm512_xor_si512(_mm512_castps_si512(_mm512_shuffle_ps(low, low, _MM_SHUFFLE(1, 0, 3, 2))),
                         _mm512_castps_si512(sign)));
    std::uint32_t hit = all_of_four(_mm512_cmp_ps_mask(high, limits, _CMP_LE_OQ));
    const std::uint32_t certain = all_of_four(_mm512_cmp_ps_mask(high, limits, _CMP_LT_OQ));
    if (by_mark || (hit & ~certain) != 0) {
      const std::uint32_t maybe = hit;
      hit = 0;
      for (unsigned k = 0; k < 4; ++k) {
        const FloatOverlap overlaps{(maybe >> k & 1) != 0, (certain >> k & 1) != 0};
        hit |= static_cast<std::uint32_t>(is_pair<by_mark>(request, p[k], overlaps)) << k;
      }
    }
    const __m256i keys = _mm256_rol_epi64(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)), 32);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(at),
                        _mm256_maskz_compress_epi64(static_cast<__mmask8>(hit), keys));
    at += _mm_popcnt_u32(hit);
  }
  // The call below is the last thing here, before which g++ 12 forgets it: until some other wide code does
  // it, all that follows in the step would keep the upper halves of its registers, at up to twice the time.
  _mm256_zeroupper();
  return test_narrow<by_mark>(tests, candidates.subspan(i), at);
}
#endif

}  // namespace

void CandidateTests::run(std::span<const Pair> candidates, PairBuffer& out, BroadPhaseStats& stats) const {
#if defined(SKERRY_WIDE_TESTS)
  const bool has_wide = wide && has_wide_tests();
#endif
  const std::size_t before = out.size();
  for (std::size_t begin = 0; begin < candidates.size(); begin += kBlock) {
    const std::span<const Pair> block =
        candidates.subspan(begin, std::min(kBlock, candidates.size() - begin));
    std::uint64_t* at = out.reserve(kBlock + 4);
#if defined(SKERRY_WIDE_TESTS)
    if (has_wide) {
      at = scattered ? (by_mark ? test_wide<true, true>(*this, block, at)
                                : test_wide<false, true>(*this, block, at))
                     : (by_mark ? test_wide<true, false>(*this, block, at)
                                : test_wide<false, false>(*this, block, at));
      out.advance_to(at);
      continue;
    }
#endif
    at = by_mark ? test_narrow<true>(*this, block, at) : test_narrow<false>(*this, block, at);
    out.advance_to(at);
  }
  stats.box_tests += candidates.size();
  stats.false_pairs += candidates.size() - (out.size() - before);
}

}  // namespace skerry
