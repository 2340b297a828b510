// SPDX-License-Identifier: MIT
//
// Every implementation against brute force, on every scene, while boxes move, teleport, appear and vanish.
// The brute force of the registry is itself checked here against a double loop of the definition. The random
// steps are 80 an implementation and scene; SKERRY_TEST_SCALE=75 makes them more than a million in all:
//   SKERRY_TEST_SCALE=75 broadphase_tests --gtest_filter='*ReportsTheOraclesPairs*'
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <sstream>

#include "tests/broadphase/scenes.h"

namespace skerry::broadphase_test {
namespace oracle_test {

/// The definition, with none of the library's code but `overlap`.
class Model {
 public:
  struct Entry {
    Aabb box;
    ProxyKind kind;
    bool moved;
  };
  std::map<ProxyIndex, Entry> entries;

  std::vector<Pair> pairs(bool all) const {
    // In a row, because a million of these double loops are run.
    const std::vector<std::pair<ProxyIndex, Entry>> row(entries.begin(), entries.end());
    std::vector<Pair> found;
    for (auto a = row.begin(); a != row.end(); ++a) {
      for (auto b = std::next(a); b != row.end(); ++b) {
        if (!overlap(a->second.box, b->second.box)) continue;
        if (a->second.kind == ProxyKind::Fixed && b->second.kind == ProxyKind::Fixed) continue;
        if (all || a->second.moved || b->second.moved) found.push_back({a->first, b->first});
      }
    }
    return found;
  }
  std::vector<ProxyIndex> query(const Aabb& box) const {
    std::vector<ProxyIndex> found;
    for (const auto& [proxy, entry] : entries) {
      if (overlap(entry.box, box)) found.push_back(proxy);
    }
    return found;
  }
  void forget_moves() {
    for (auto& [proxy, entry] : entries) entry.moved = false;
  }
};

/// The pairs of `a` that `b` has not; both are sorted.
std::vector<Pair> only_in(const std::vector<Pair>& a, const std::vector<Pair>& b) {
  std::vector<Pair> rest;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(rest));
  return rest;
}

/// A broad phase under test beside the model; every change goes to both.
class Twin {
 public:
  Twin(std::string_view name, const BroadPhaseOptions& options) : tested(make_broad_phase(name, options)) {}

  void insert(ProxyIndex proxy, const Aabb& box, ProxyKind kind) {
    tested->insert(proxy, box, kind);
    model.entries[proxy] = {box, kind, true};
  }
  void remove(ProxyIndex proxy) {
    tested->remove(proxy);
    model.entries.erase(proxy);
  }
  void update(const std::vector<BoxUpdate>& moved) {
    tested->update(moved);
    for (const BoxUpdate& u : moved) {
      model.entries[u.proxy].box = u.box;
      model.entries[u.proxy].moved = true;
    }
  }
  void expect_same_pairs() {
    std::vector<Pair> pairs{{7, 7}};
    tested->moved_pairs(pairs);
    ASSERT_NO_FATAL_FAILURE(expect_equal(pairs, model.pairs(false)));
    model.forget_moves();
    ASSERT_EQ(tested->stats().pairs, pairs.size());
    ASSERT_EQ(tested->size(), model.entries.size());
  }
  void expect_same_pairs_in_all() {
    std::vector<Pair> pairs{{7, 7}};
    tested->all_pairs(pairs);
    ASSERT_NO_FATAL_FAILURE(expect_equal(pairs, model.pairs(true)));
  }

  /// Names the pairs that differ, with their boxes.
  void expect_equal(const std::vector<Pair>& pairs, const std::vector<Pair>& expected) const {
    if (pairs == expected) return;
    std::ostringstream text;
    text.precision(17);
    const auto name = [&](const char* what, const std::vector<Pair>& some) {
      for (const Pair pair : some) {
        text << what << ' ' << pair.low << '-' << pair.high;
        for (const ProxyIndex proxy : {pair.low, pair.high}) {
          const auto at = model.entries.find(proxy);
          if (at == model.entries.end()) continue;
          const auto& [box, kind, moved] = at->second;
          text << (kind == ProxyKind::Fixed ? ", fixed" : ", moving") << (moved ? " and moved: [" : ": [")
               << box.lower.x << ", " << box.upper.x << "] x [" << box.lower.y << ", " << box.upper.y << ']';
        }
        text << '\n';
      }
    };
    name("missing", only_in(expected, pairs));
    name("too many", only_in(pairs, expected));
    FAIL() << text.str() << pairs.size() << " pairs, " << expected.size() << " expected";
  }

  std::unique_ptr<BroadPhase> tested;
  Model model;
};

class EveryBroadPhase : public testing::TestWithParam<std::tuple<BroadPhaseEntry, Scene>> {
 protected:
  std::string_view name() const { return std::get<0>(GetParam()).name; }
  std::vector<Aabb> boxes(Random& random, int count) const {
    return std::get<1>(GetParam()).make(random, count);
  }
};

std::string case_name(const testing::TestParamInfo<std::tuple<BroadPhaseEntry, Scene>>& info) {
  return std::string(std::get<0>(info.param).name) + "_" + std::get<1>(info.param).name;
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryBroadPhase,
                         testing::Combine(testing::ValuesIn(broad_phases().begin(), broad_phases().end()),
                                          testing::ValuesIn(scenes())),
                         case_name);

TEST_P(EveryBroadPhase, ReportsTheOraclesPairsWhileBoxesMoveTeleportAppearAndVanish) {
  const int rounds = std::max(1, static_cast<int>(2 * test_scale()));
  for (int round = 0; round < rounds; ++round) {
    // The first seed has a moving box that is removed, asked around, and comes back as a fixed one beside
    // another: a list of pairs that forgets what it was reports them.
    const unsigned seed = 4108 + static_cast<unsigned>(round);
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const std::vector<Aabb> start = boxes(random, 150);
    Twin twin(name(), {});
    // Numbers with gaps, not in the order of the boxes; one in six is fixed.
    std::vector<ProxyIndex> present, absent;
    for (ProxyIndex i = 0; i < start.size(); ++i) {
      const ProxyIndex proxy = (i * 7) % 1021;
      twin.insert(proxy, start[i], i % 6 == 5 ? ProxyKind::Fixed : ProxyKind::Moving);
      present.push_back(proxy);
    }
    ASSERT_NO_FATAL_FAILURE(twin.expect_same_pairs());
    ASSERT_NO_FATAL_FAILURE(twin.expect_same_pairs_in_all());

    for (int step = 0; step < 40; ++step) {
      SCOPED_TRACE(testing::Message() << "step " << step);
      std::vector<BoxUpdate> moved;
      // Between nothing and everything moves, by a tenth of its size; the bits may stay the same as well.
      const double share = step % 8 == 0 ? 1.0 : step % 8 == 1 ? 0.0 : uniform(random, 0, 0.3);
      for (const ProxyIndex proxy : present) {
        if (uniform(random, 0, 1) >= share) continue;
        const Aabb box = twin.model.entries[proxy].box;
        const double size =
            std::min(1e300, 0.1 * std::max(box.upper.x - box.lower.x, box.upper.y - box.lower.y));
        moved.push_back({proxy, shifted(box, {uniform(random, -size, size), uniform(random, -size, size)})});
      }
      // A teleport to the place of another box, sometimes with another size.
      if (step % 3 == 0 && present.size() > 1) {
        const ProxyIndex to = present[random() % present.size()], who = present[random() % present.size()];
        const Aabb target = twin.model.entries[to].box;
        moved.push_back({who, step % 2 ? target : Aabb{target.lower, target.lower}});
      }
      for (const BoxUpdate& u : moved) {
        ASSERT_TRUE(std::isfinite(u.box.lower.x) && u.box.lower.x <= u.box.upper.x);
      }
      twin.update(moved);
      if (step % 4 == 1) {
        for (int k = 0; k < 5 && !present.empty(); ++k) {
          const std::size_t at = random() % present.size();
          twin.remove(present[at]);
          absent.push_back(present[at]);
          present.erase(present.begin() + static_cast<std::ptrdiff_t>(at));
        }
      }
      if (step % 4 >= 2 && !absent.empty()) {
        const ProxyIndex proxy = absent.back();
        absent.pop_back();
        present.push_back(proxy);
        twin.insert(proxy, start[random() % start.size()], step % 2 ? ProxyKind::Fixed : ProxyKind::Moving);
      }
      // Sometimes two rounds of changes come before the next report, with a query between them.
      if (step % 5 == 4) {
        std::vector<ProxyIndex> found;
        const Aabb region = start[random() % start.size()];
        twin.tested->query(region, found);
        ASSERT_EQ(found, twin.model.query(region));
        continue;
      }
      ASSERT_NO_FATAL_FAILURE(twin.expect_same_pairs());
      if (step % 10 == 7) {
        ASSERT_NO_FATAL_FAILURE(twin.expect_same_pairs_in_all());
      }
    }
  }
}

TEST_P(EveryBroadPhase, AnswersRegionPointAndRayQueriesLikeTheOracle) {
  const unsigned seed = 77;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  const std::vector<Aabb> start = boxes(random, 200);
  const auto tested = make_broad_phase(name());
  const auto oracle = make_broad_phase(broad_phases().front().name);
  Model model;
  for (ProxyIndex i = 0; i < start.size(); ++i) {
    tested->insert(i, start[i], ProxyKind::Moving);
    oracle->insert(i, start[i], ProxyKind::Moving);
    model.entries[i] = {start[i], ProxyKind::Moving, false};
  }
  std::vector<ProxyIndex> found{99}, expected;
  const auto corner = [&] {
    const Aabb& box = start[random() % start.size()];
    return Vec2{random() % 2 ? box.lower.x : box.upper.x, random() % 2 ? box.lower.y : box.upper.y};
  };
  const int count = static_cast<int>(100 * test_scale());
  for (int i = 0; i < count; ++i) {
    const Vec2 a = corner(), b = corner();
    const Aabb region{{std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(a.x, b.x), std::max(a.y, b.y)}};
    tested->query(region, found);
    ASSERT_EQ(found, model.query(region));
    tested->query(a, found);
    ASSERT_EQ(found, model.query({a, a}));
    // Rays through corners, along the axes, without end and of length zero.
    Ray ray{a, b - a, i % 3 == 0 ? kInfinity : uniform(random, 0, 1.5)};
    if (i % 5 == 1) ray.direction.x = 0;
    if (i % 7 == 1) ray.direction.y = 0;
    if (i % 11 == 1) ray.t_max = 0;
    if (!is_finite(ray.direction) || ray.direction == Vec2{}) ray.direction = {0, -1};
    tested->ray_cast(ray, found);
    oracle->ray_cast(ray, expected);
    ASSERT_EQ(found, expected) << "ray from " << ray.origin.x << ' ' << ray.origin.y << " along "
                               << ray.direction.x << ' ' << ray.direction.y << " to " << ray.t_max;
  }
  tested->query(Aabb{{-kInfinity, -kInfinity}, {kInfinity, kInfinity}}, found);
  EXPECT_EQ(found.size(), start.size());
}

}  // namespace oracle_test
}  // namespace skerry::broadphase_test
