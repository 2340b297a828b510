// SPDX-License-Identifier: MIT
//
// The sort of pairs against std::sort: few and many, sparse and dense, as far as the numbers that change its
// way.
#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "physics/broadphase/pair_buffer.h"

namespace skerry {
namespace pair_sort_test {

/// Which pairs come: any, neighbours in number, or some boxes with all others.
enum class Kind { Any, Near, Hubs };

Pair random_pair(Kind kind, ProxyIndex limit, std::mt19937& random) {
  const auto below = [&](ProxyIndex end) { return static_cast<ProxyIndex>(random() % end); };
  const ProxyIndex a = kind == Kind::Hubs ? below(std::min<ProxyIndex>(limit, 3)) : below(limit);
  const ProxyIndex b =
      kind == Kind::Near ? (a + 1 + below(std::min<ProxyIndex>(limit - 1, 20))) % limit : below(limit);
  return {std::min(a, b), std::max(a, b)};
}

TEST(PairSort, IsThatOfTheLibraryForAnyDensityAndAnyThreads) {
  const unsigned seed = 7;
  std::mt19937 random(seed);
  PairSortScratch scratch;
  for (const int threads : {0, 1, 4}) {
    Workers workers(std::max(threads, 1));
    for (const ProxyIndex limit : {2u, 300u, 5000u, 32768u, 32769u, 200000u}) {
      for (const std::size_t total : {0u, 1u, 40u, 3000u, 20000u, 70000u, 200000u}) {
        for (const Kind kind : {Kind::Any, Kind::Near, Kind::Hubs}) {
          SCOPED_TRACE("seed " + std::to_string(seed) + " threads " + std::to_string(threads) + " limit " +
                       std::to_string(limit) + " total " + std::to_string(total) + " kind " +
                       std::to_string(static_cast<int>(kind)));
          std::vector<PairBuffer> parts(1 + random() % 4);
          std::vector<Pair> wanted, sorted;
          for (std::size_t i = 0; i < total; ++i) {
            const Pair pair = random_pair(kind, limit, random);
            parts[random() % parts.size()].add(pair.low, pair.high);
            wanted.push_back(pair);
          }
          std::sort(wanted.begin(), wanted.end());
          sort_pairs(parts, limit, scratch, sorted, threads > 0 ? &workers : nullptr);
          ASSERT_TRUE(sorted == wanted);
        }
      }
    }
  }
}

}  // namespace pair_sort_test
}  // namespace skerry
