// SPDX-License-Identifier: MIT
//
// What every broad phase promises besides its pairs: refusals that change nothing, options, threads, large
// sets, changes of structure, and memory.
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/broadphase/scenes.h"

namespace skerry::broadphase_test {
namespace contract_test {

class EveryBroadPhaseContract : public testing::TestWithParam<BroadPhaseEntry> {
 protected:
  std::unique_ptr<BroadPhase> make(const BroadPhaseOptions& options = {}) const {
    return make_broad_phase(GetParam().name, options);
  }
};

INSTANTIATE_TEST_SUITE_P(Registry, EveryBroadPhaseContract,
                         testing::ValuesIn(broad_phases().begin(), broad_phases().end()),
                         [](const auto& entry) { return std::string(entry.param.name); });

/// The message of the std::invalid_argument that `call` throws; empty if it throws none.
template <class Call>
std::string refusal(Call call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

std::vector<Pair> all_pairs(BroadPhase& tested) {
  std::vector<Pair> pairs;
  tested.all_pairs(pairs);
  return pairs;
}

TEST_P(EveryBroadPhaseContract, RefusesBadBoxesWithNumberAndValuesAndStaysUnchanged) {
  const auto tested = make();
  tested->insert(3, {{0, 0}, {1, 1}}, ProxyKind::Moving);
  tested->insert(8, {{0.5, 0.5}, {2, 2}}, ProxyKind::Moving);
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  ASSERT_THAT(pairs, testing::ElementsAre(Pair{3, 8}));

  const double nan = std::nan("");
  const Aabb bad[] = {{{2.25, 0}, {1, 1}}, {{0, 2.25}, {1, 1}},      {{nan, 0}, {1, 1}},
                      {{0, 0}, {1, nan}},  {{0, 0}, {kInfinity, 1}}, {{-kInfinity, 0}, {1, 1}},
                      {{0, nan}, {1, 1}},  {{0, 0}, {nan, 1}}};
  for (const Aabb& box : bad) {
    const std::string inserted = refusal([&] { tested->insert(77, box, ProxyKind::Moving); });
    EXPECT_THAT(inserted, testing::HasSubstr("77"));
    // The good update before the bad one must not happen either.
    const std::vector<BoxUpdate> moved{{3, {{10, 10}, {11, 11}}}, {8, box}};
    const std::string updated = refusal([&] { tested->update(moved); });
    EXPECT_THAT(updated, testing::AllOf(testing::HasSubstr("proxy 8"), testing::HasSubstr("x from")));
    ASSERT_EQ(tested->size(), 2u);
    tested->moved_pairs(pairs);
    ASSERT_TRUE(pairs.empty());
    ASSERT_THAT(all_pairs(*tested), testing::ElementsAre(Pair{3, 8}));
  }
  EXPECT_THAT(refusal([&] { tested->insert(5, bad[0], ProxyKind::Fixed); }), testing::HasSubstr("2.25"));
}

TEST_P(EveryBroadPhaseContract, RefusesProxiesThatArePresentTwiceOrNotAtAll) {
  const auto tested = make();
  const Aabb box{{0, 0}, {1, 1}};
  tested->insert(4, box, ProxyKind::Moving);
  EXPECT_THAT(refusal([&] { tested->insert(4, box, ProxyKind::Moving); }), testing::HasSubstr("proxy 4"));
  EXPECT_THAT(refusal([&] { tested->insert(~0u, box, ProxyKind::Moving); }),
              testing::HasSubstr("4294967295"));
  EXPECT_THAT(refusal([&] { tested->remove(5); }), testing::HasSubstr("proxy 5"));
  const std::vector<BoxUpdate> moved{{4, {{5, 5}, {6, 6}}}, {2000000, box}};
  EXPECT_THAT(refusal([&] { tested->update(moved); }), testing::HasSubstr("proxy 2000000"));
  std::vector<ProxyIndex> found;
  tested->query(Vec2{0.5, 0.5}, found);
  EXPECT_THAT(found, testing::ElementsAre(4));
  tested->remove(4);
  EXPECT_THAT(refusal([&] { tested->remove(4); }), testing::HasSubstr("proxy 4"));
  EXPECT_TRUE(all_pairs(*tested).empty());
}

TEST_P(EveryBroadPhaseContract, RefusesRegionsAndRaysThatMeanNothing) {
  const auto tested = make();
  tested->insert(0, {{0, 0}, {1, 1}}, ProxyKind::Moving);
  std::vector<ProxyIndex> found;
  EXPECT_NE(refusal([&] { tested->query(Aabb{{1, 0}, {0, 1}}, found); }), "");
  EXPECT_NE(refusal([&] { tested->query(Vec2{std::nan(""), 0}, found); }), "");
  EXPECT_NE(refusal([&] { tested->query(Vec2{kInfinity, 0}, found); }), "");
  EXPECT_NE(refusal([&] { tested->ray_cast({{0, 0}, {0, 0}, 1}, found); }), "");
  EXPECT_NE(refusal([&] { tested->ray_cast({{0, 0}, {1, 0}, -1}, found); }), "");
  EXPECT_NE(refusal([&] { tested->ray_cast({{kInfinity, 0}, {1, 0}, 1}, found); }), "");
}

TEST_P(EveryBroadPhaseContract, BoxesWhoseWidthIsNoNumberAreFoundAmongOthers) {
  const auto tested = make();
  const double far = 1.7e308;
  std::vector<Aabb> boxes{
      {{-far, -far}, {far, far}}, {{-far, 3}, {far, 4}}, {{0.9 * far, 0.9 * far}, {far, far}}};
  for (int i = 0; i < 40; ++i) boxes.push_back({{i * 1.0, 0}, {i + 1.5, 1}});
  std::vector<Pair> expected, pairs;
  for (ProxyIndex i = 0; i < boxes.size(); ++i) {
    tested->insert(i, boxes[i], i == 1 ? ProxyKind::Fixed : ProxyKind::Moving);
    for (ProxyIndex k = i + 1; k < boxes.size(); ++k)
      if (overlap(boxes[i], boxes[k])) expected.push_back({i, k});
  }
  tested->moved_pairs(pairs);
  EXPECT_EQ(pairs, expected);
  // And once the others are in their places.
  const std::vector<BoxUpdate> moved{{0, boxes[0]}, {2, {{0.8 * far, -far}, {far, far}}}};
  tested->update(moved);
  std::erase_if(expected, [](const Pair& pair) { return pair.low > 0; });
  expected.push_back({1, 2});
  tested->moved_pairs(pairs);
  EXPECT_EQ(pairs, expected);
  std::vector<ProxyIndex> found;
  tested->query(Vec2{0.95 * far, 0.95 * far}, found);
  EXPECT_THAT(found, testing::ElementsAre(0, 2));
  tested->query(Aabb{{-kInfinity, 2}, {kInfinity, 3.5}}, found);
  EXPECT_THAT(found, testing::ElementsAre(0, 1, 2));
}

TEST_P(EveryBroadPhaseContract, IsEmptyBeforeTheFirstAndAfterTheLastBox) {
  const auto tested = make();
  std::vector<Pair> pairs{{1, 2}};
  std::vector<ProxyIndex> found{1};
  for (int round = 0; round < 2; ++round) {
    tested->moved_pairs(pairs);
    EXPECT_TRUE(pairs.empty());
    tested->query(Aabb{{-kInfinity, -kInfinity}, {kInfinity, kInfinity}}, found);
    EXPECT_TRUE(found.empty());
    tested->ray_cast({{0, 0}, {1, 1}, kInfinity}, found);
    EXPECT_TRUE(found.empty());
    for (ProxyIndex i = 0; i < 300; ++i)
      tested->insert(i, {{0, i * 0.5}, {1, i * 0.5 + 0.6}}, ProxyKind::Moving);
    EXPECT_EQ(all_pairs(*tested).size(), 299u);
    for (ProxyIndex i = 0; i < 300; ++i) tested->remove(i);
  }
}

TEST_P(EveryBroadPhaseContract, GivesTheSamePairsForAnyThreadsCellSizeAndAxes) {
  const unsigned seed = 5;
  Random random(seed);
  const int count = static_cast<int>(1100 * std::min(1.0, test_scale()));
  for (const std::size_t scene : {1u, 3u, 5u}) {
    SCOPED_TRACE(testing::Message() << scenes()[scene].name << " seed " << seed);
    const std::vector<Aabb> boxes = scenes()[scene].make(random, count);
    std::vector<BroadPhaseOptions> options(1);
    for (const int threads : {2, 4}) options.emplace_back().threads = threads;
    for (const double cell : {0.3, 2.0, 1000.0}) options.emplace_back().cell_size = cell;
    for (const std::vector<double>& axes : {std::vector{0.0}, std::vector{0.0, kPi / 2},
                                            std::vector{0.1, 1.2, 2.3}, std::vector{0.0, 0.7, 1.6, 2.5}}) {
      options.emplace_back().axes = axes;
    }
    std::vector<Pair> expected;
    for (const BroadPhaseOptions& o : options) {
      const auto tested = make(o);
      for (ProxyIndex i = 0; i < boxes.size(); ++i) tested->insert(i, boxes[i], ProxyKind::Moving);
      std::vector<Pair> pairs;
      tested->moved_pairs(pairs);
      std::vector<BoxUpdate> moved;
      for (ProxyIndex i = 0; i < boxes.size(); ++i)
        moved.push_back({i, shifted(boxes[i], {0.1 * (i % 3), 0.05})});
      tested->update(moved);
      tested->moved_pairs(pairs);
      if (expected.empty()) expected = pairs;
      ASSERT_FALSE(expected.empty());
      ASSERT_TRUE(pairs == expected) << o.threads << ' ' << o.cell_size << ' ' << o.axes.size();
    }
  }
}

TEST_P(EveryBroadPhaseContract, ForgetsMovesAfterAReportButNotAfterAllPairs) {
  const auto tested = make();
  tested->insert(0, {{0, 0}, {1, 1}}, ProxyKind::Moving);
  tested->insert(1, {{1, 1}, {2, 2}}, ProxyKind::Fixed);
  tested->insert(2, {{1, 1}, {3, 3}}, ProxyKind::Fixed);
  const std::vector<Pair> expected{{0, 1}, {0, 2}};
  EXPECT_EQ(all_pairs(*tested), expected);
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  EXPECT_EQ(pairs, expected);
  tested->moved_pairs(pairs);
  EXPECT_TRUE(pairs.empty());
  // A box that comes back as another kind has other pairs.
  tested->remove(1);
  tested->insert(1, {{1, 1}, {2, 2}}, ProxyKind::Moving);
  tested->moved_pairs(pairs);
  EXPECT_EQ(pairs, (std::vector<Pair>{{0, 1}, {1, 2}}));
}

TEST_P(EveryBroadPhaseContract, ForgetsThePairsOfABoxThatComesBackAsAnotherKindEvenAfterAQuery) {
  const unsigned seed = 6;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  const auto tested = make(), oracle = make_broad_phase("brute_force");
  const std::vector<Aabb> boxes = scenes()[1].make(random, 300);
  std::vector<ProxyKind> kinds;
  const auto insert = [&](ProxyIndex i) {
    for (BroadPhase* b : {tested.get(), oracle.get()}) b->insert(i, boxes[i], kinds[i]);
  };
  for (ProxyIndex i = 0; i < boxes.size(); ++i) {
    kinds.push_back(i % 3 == 0 ? ProxyKind::Fixed : ProxyKind::Moving);
    insert(i);
  }
  std::vector<Pair> pairs, expected;
  std::vector<ProxyIndex> found;
  for (int step = 0; step < 60; ++step) {
    // Half of the boxes move and stay where they are: whatever is kept from step to step stays valid.
    std::vector<BoxUpdate> moved;
    for (ProxyIndex i = step % 2; i < boxes.size(); i += 2) moved.push_back({i, boxes[i]});
    for (BroadPhase* b : {tested.get(), oracle.get()}) b->update(moved);
    const auto who = static_cast<ProxyIndex>(random() % boxes.size());
    for (BroadPhase* b : {tested.get(), oracle.get()}) b->remove(who);
    // One time in two the structure sees that the box has gone, by a query or by a report.
    if (step % 4 == 1) tested->query(boxes[who], found);
    if (step % 4 == 3) {
      tested->moved_pairs(pairs);
      oracle->moved_pairs(expected);
      ASSERT_EQ(pairs, expected) << "step " << step;
    }
    kinds[who] = kinds[who] == ProxyKind::Fixed ? ProxyKind::Moving : ProxyKind::Fixed;
    insert(who);
    tested->moved_pairs(pairs);
    oracle->moved_pairs(expected);
    ASSERT_EQ(pairs, expected) << "step " << step;
    ASSERT_EQ(all_pairs(*tested), all_pairs(*oracle)) << "step " << step;
  }
}

TEST_P(EveryBroadPhaseContract, RaysMeetABoxThatWentFarAwayFromTheOthers) {
  const auto tested = make();
  for (ProxyIndex i = 0; i < 300; ++i) {
    const ProxyIndex row = i / 20, column = i % 20;
    tested->insert(i, box_at(column, row, 0.25, 0.25), ProxyKind::Moving);
  }
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  std::vector<ProxyIndex> found;
  for (const Vec2 at : {Vec2{60, 3}, Vec2{-40, -50}, Vec2{3, 70}}) {
    const BoxUpdate update{7, {at, at + Vec2{0.5, 0.5}}};
    tested->update({&update, 1});
    tested->ray_cast({at + Vec2{-2, 0.25}, {4, 0.01}}, found);
    EXPECT_THAT(found, testing::ElementsAre(7));
    tested->ray_cast({at + Vec2{0.25, 2}, {0.01, -4}}, found);
    EXPECT_THAT(found, testing::ElementsAre(7));
  }
}

TEST_P(EveryBroadPhaseContract, ABoxThatGrowsIsFoundWhereItReaches) {
  BroadPhaseOptions options;
  options.axes = {0};
  const auto tested = make(options);
  for (ProxyIndex i = 0; i < 40; ++i) {
    const double x = 10 + 2 * i;
    tested->insert(i, {{x, 0}, {x + 0.9, 1}}, ProxyKind::Moving);
  }
  tested->insert(40, {{0.05, 0}, {0.9, 1}}, ProxyKind::Moving);
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  std::vector<ProxyIndex> found;
  for (const double end : {1.9, 3.9, 7.9, 3.8, 0.9}) {
    const BoxUpdate update{40, {{0.05, 0}, {end, 1}}};
    tested->update({&update, 1});
    tested->query(Aabb{{end - 0.05, 0.4}, {end - 0.01, 0.6}}, found);
    EXPECT_THAT(found, testing::ElementsAre(40)) << end;
  }
}

TEST_P(EveryBroadPhaseContract, KeepsMemoryLinearWhateverTheExtent) {
  // Ten times the boxes may take ten times the memory, in a world that is a million times as wide.
  Random random(9);
  const auto bytes = [&](int count, double side) {
    const auto tested = make();
    std::vector<BoxUpdate> moved;
    for (int i = 0; i < count; ++i) {
      const double size = i % 50 == 0 ? side * 0.2 : 1;
      const Aabb box =
          box_at(uniform(random, 0, side), uniform(random, 0, side), size, i % 50 == 0 ? 1 : size);
      tested->insert(static_cast<ProxyIndex>(i), box, ProxyKind::Moving);
      moved.push_back({static_cast<ProxyIndex>(i), shifted(box, {0.1, 0.1})});
    }
    std::vector<ProxyIndex> found;
    tested->query(Vec2{0, 0}, found);
    // What is kept from step to step, where all move and where few do.
    std::vector<Pair> pairs;
    for (const std::size_t movers : {moved.size(), moved.size() / 20}) {
      tested->moved_pairs(pairs);
      tested->update(std::span(moved).first(movers));
    }
    tested->moved_pairs(pairs);
    return static_cast<double>(tested->stats().bytes);
  };
  EXPECT_LT(bytes(3000, 3e8), 1500.0 * 3000);
  EXPECT_LT(bytes(300, 300), 1500.0 * 300 + 20000);
}

TEST_P(EveryBroadPhaseContract, ShowsItsStructure) {
  struct Counter final : StructureVisitor {
    int cells = 0, axes = 0, intervals = 0, listed = 0;
    void cell(const Aabb& box, int level, int count) override {
      EXPECT_LE(box.lower.x, box.upper.x);
      EXPECT_GE(level, 0);
      ++cells;
      listed += count;
    }
    void axis(int index, Vec2, Vec2 direction) override {
      EXPECT_EQ(index, axes++);
      EXPECT_NEAR(length(direction), 1, 1e-12);
    }
    std::vector<double> last;  // the intervals' lower ends, by axis
    bool is_sorted = true;
    void interval(int index, ProxyIndex proxy, double lower, double upper) override {
      last.resize(static_cast<std::size_t>(index) + 1, -kInfinity);
      is_sorted &= last.back() <= lower;
      last.back() = lower;
      EXPECT_LT(index, axes);
      EXPECT_LT(proxy, 200u);
      EXPECT_LE(lower, upper);
      ++intervals;
    }
  } counter;
  const auto tested = make();
  Random random(3);
  const std::vector<Aabb> boxes = scenes()[0].make(random, 200);
  for (ProxyIndex i = 0; i < boxes.size(); ++i) tested->insert(i, boxes[i], ProxyKind::Moving);
  tested->visit_structure(counter);
  EXPECT_EQ(counter.intervals, 200 * counter.axes);
  if (counter.axes == 0) {
    EXPECT_GE(counter.listed, 200);
  }
  if (GetParam().name == "sweep_and_prune") {
    EXPECT_EQ(counter.axes, 2);
    EXPECT_TRUE(counter.is_sorted);
  }
}

TEST_P(EveryBroadPhaseContract, TestsNothingWhereNothingMovesAndLittleWhereLittleDoes) {
  const auto tested = make();
  Random random(14);
  const std::vector<Aabb> boxes = scenes()[1].make(random, 2000);
  for (ProxyIndex i = 0; i < boxes.size(); ++i) {
    tested->insert(i, boxes[i], i % 10 == 0 ? ProxyKind::Fixed : ProxyKind::Moving);
  }
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  const std::uint64_t all = tested->stats().box_tests;
  tested->update({});
  tested->moved_pairs(pairs);
  EXPECT_TRUE(pairs.empty());
  EXPECT_EQ(tested->stats().box_tests, 0u);
  // One box in a hundred: a tenth of the tests of all is far more than their share. Structures of single axes
  // count the intervals that they pass.
  std::vector<BoxUpdate> moved;
  for (ProxyIndex i = 1; i < boxes.size(); i += 100) moved.push_back({i, shifted(boxes[i], {0.05, 0.05})});
  tested->update(moved);
  tested->moved_pairs(pairs);
  EXPECT_LT(tested->stats().box_tests, all / 10);
  EXPECT_FALSE(pairs.empty());
}

TEST_P(EveryBroadPhaseContract, CountsItsTestsAndThoseThatGaveNoPair) {
  const auto tested = make();
  Random random(13);
  const std::vector<Aabb> boxes = scenes()[1].make(random, 500);
  for (ProxyIndex i = 0; i < boxes.size(); ++i) tested->insert(i, boxes[i], ProxyKind::Moving);
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  const BroadPhaseStats stats = tested->stats();
  EXPECT_EQ(stats.pairs, pairs.size());
  EXPECT_GT(stats.false_pairs, 0u);
  EXPECT_GE(stats.box_tests, stats.pairs + stats.false_pairs);
  EXPECT_GT(stats.bytes, 500 * sizeof(Aabb));
}

TEST(BroadPhaseRegistry, NamesItsEntriesWhenAskedForAnUnknownOne) {
  EXPECT_THAT(refusal([] { make_broad_phase("octree"); }),
              testing::AllOf(testing::HasSubstr("octree"), testing::HasSubstr("sweep_and_prune")));
  BroadPhaseOptions options;
  options.cell_size = -1;
  EXPECT_THAT(refusal([&] { make_broad_phase("uniform_grid", options); }), testing::HasSubstr("-1"));
  options = {};
  options.axes = {1, 2, 3, 4, 5};
  EXPECT_THAT(refusal([&] { make_broad_phase("sweep_and_prune", options); }), testing::HasSubstr("5"));
  options = {};
  options.threads = 0;
  EXPECT_THAT(refusal([&] { broad_phases().front().make(options); }), testing::HasSubstr("threads"));
}

TEST(BroadPhaseRegistry, GivesTheSamePairsForAHundredThousandBoxes) {
  const unsigned seed = 31;
  const int count = static_cast<int>(1e5 * std::min(1.0, test_scale()));
  for (const std::size_t scene : {1u, 3u}) {
    SCOPED_TRACE(testing::Message() << scenes()[scene].name << " seed " << seed);
    std::vector<Pair> expected;
    // Brute force and the structures of single axes take long here; at a larger scale they are asked as well.
    std::vector<std::string_view> names{"hierarchical_grid", "uniform_grid", "aabb_tree", "neighbour_list",
                                        "auto"};
    if (test_scale() > 1) {
      names.insert(names.end(), {"brute_force", "sweep_and_prune", "hash_sort", "hierarchical_hash_sort"});
    }
    for (const std::string_view name : names) {
      Random random(seed);
      std::vector<Aabb> boxes = scenes()[scene].make(random, scene == 3 ? count / 30 : count);
      BroadPhaseOptions options;
      options.threads = 4;
      const auto tested = make_broad_phase(name, options);
      for (ProxyIndex i = 0; i < boxes.size(); ++i) tested->insert(i, boxes[i], ProxyKind::Moving);
      std::vector<Pair> pairs, together;
      for (const unsigned stride : {1u, 50u}) {
        std::vector<BoxUpdate> moved;
        for (ProxyIndex i = 0; i < boxes.size(); i += stride) {
          boxes[i] = shifted(boxes[i], {uniform(random, -0.1, 0.1), uniform(random, -0.1, 0.1)});
          moved.push_back({i, boxes[i]});
        }
        tested->update(moved);
        tested->moved_pairs(pairs);
        together.insert(together.end(), pairs.begin(), pairs.end());
      }
      if (expected.empty()) expected = together;
      ASSERT_GT(expected.size(), boxes.size());
      ASSERT_TRUE(together == expected) << name;
    }
  }
}

TEST(AutoBroadPhase, SwitchesBothWaysAndLosesOrDoublesNoPair) {
  const auto tested = make_broad_phase("auto"), oracle = make_broad_phase("brute_force");
  const unsigned seed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  std::vector<std::string> choices;
  std::vector<Pair> pairs, expected;
  ProxyIndex count = 0;
  // The number of boxes goes up and down through every threshold while some of them move.
  for (int step = 0; step < 400; ++step) {
    const bool grows = step % 200 < 100;
    for (int k = 0; k < 3; ++k) {
      if (grows) {
        const Aabb box = box_at(uniform(random, 0, 12), uniform(random, 0, 12), uniform(random, 0, 1), 0.5);
        for (BroadPhase* b : {tested.get(), oracle.get()}) b->insert(count, box, ProxyKind::Moving);
        ++count;
      } else {
        --count;
        for (BroadPhase* b : {tested.get(), oracle.get()}) b->remove(count);
      }
    }
    std::vector<BoxUpdate> moved;
    for (ProxyIndex p = 0; p < count; ++p) {
      if (random() % 4 == 0)
        moved.push_back({p, box_at(uniform(random, 0, 12), uniform(random, 0, 12), 0.5, 0.5)});
    }
    tested->update(moved);
    oracle->update(moved);
    tested->moved_pairs(pairs);
    oracle->moved_pairs(expected);
    ASSERT_EQ(pairs, expected) << "step " << step;
    const BroadPhaseChoice choice = tested->choice();
    if (choices.empty() || choices.back() != choice.name) choices.emplace_back(choice.name);
    ASSERT_EQ(choice.switches, choices.size() - 1) << "step " << step;
  }
  EXPECT_THAT(reason_of(tested->choice()), testing::HasSubstr(" moved a step, "));
  EXPECT_THAT(choices, testing::ElementsAre("brute_force", "neighbour_list", "brute_force", "neighbour_list",
                                            "brute_force"));
}

TEST(AutoBroadPhase, TakesTheListAndTheGridWhereOneBoxMoves) {
  const auto tested = make_broad_phase("auto");
  Random random(2);
  std::vector<Aabb> boxes = scenes()[1].make(random, 2000);
  for (ProxyIndex i = 0; i < boxes.size(); ++i) tested->insert(i, boxes[i], ProxyKind::Moving);
  std::vector<Pair> pairs;
  for (const auto& [stride, expected] :
       {std::pair{1u, "neighbour_list"}, {100u, "neighbour_list"}, {2000u, "hierarchical_grid"}}) {
    for (int step = 0; step < 60; ++step) {
      std::vector<BoxUpdate> moved;
      for (ProxyIndex i = 0; i < boxes.size(); i += stride) moved.push_back({i, boxes[i]});
      tested->update(moved);
      tested->moved_pairs(pairs);
    }
    EXPECT_EQ(tested->choice().name, expected);
  }
}

}  // namespace contract_test
}  // namespace skerry::broadphase_test
