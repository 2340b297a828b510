// SPDX-License-Identifier: MIT
//
// What single structures promise besides what every broad phase does: whom the neighbour list tests and
// keeps, the grid's cost of a move, the exchanges of sweep and prune.
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "physics/broadphase/hierarchical_grid.h"
#include "tests/broadphase/scenes.h"

namespace skerry::broadphase_test {
namespace structures_test {

/// A unit of length, and where the boxes are: near the origin, or where margins and shifts are lost in
/// rounding.
struct Place {
  const char* name;
  double unit;
  Vec2 origin;
};
class NeighbourListOfTheFew : public testing::TestWithParam<Place> {};

INSTANTIATE_TEST_SUITE_P(
    Places, NeighbourListOfTheFew,
    testing::Values(Place{"NearTheOrigin", 1, {}}, Place{"FarAway", 1, {1e9, -1e9}},
                    Place{"LargeAndFarAway", 300, {1e9, -1e9}},
                    // Boxes of a few units in the last place, with margins of none.
                    Place{"InTheLastPlaces", 2e-7, {1e9, 1e9}}, Place{"FarOnOneAxis", 1e-3, {1e9, 0}},
                    Place{"WithAreasOfZero", 1e-200, {}}, Place{"BelowSinglePrecision", 1e-42, {}},
                    Place{"AboveSinglePrecision", 1e200, {}}, Place{"AtTheEndOfDoubles", 1e305, {}}),
    [](const testing::TestParamInfo<Place>& place) { return std::string(place.param.name); });

TEST_P(NeighbourListOfTheFew, KeepsThePairsWhateverElseHappens) {
  const auto tested = make_broad_phase("neighbour_list"), oracle = make_broad_phase("brute_force");
  const unsigned seed = 77;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  // What follows is in units of length around the origin, as if it were the only place.
  const auto placed = [&](const Aabb& box) {
    const Place& place = GetParam();
    return Aabb{place.unit * box.lower + place.origin, place.unit * box.upper + place.origin};
  };
  const auto both = [&](auto call) {
    call(*tested);
    call(*oracle);
  };
  const ProxyIndex count = 600;
  std::vector<Aabb> boxes;
  std::vector<Vec2> flights;
  std::vector<bool> moves, present(count, true), fixed(count, false);
  for (ProxyIndex i = 0; i < count; ++i) {
    boxes.push_back(box_at(uniform(random, 0, 25), uniform(random, 0, 25), uniform(random, 0.5, 1.5), 1));
    flights.push_back({uniform(random, -0.15, 0.15), uniform(random, -0.15, 0.15)});
    moves.push_back(i % 20 == 0);
    fixed[i] = i % 7 == 3;
    const ProxyKind kind = fixed[i] ? ProxyKind::Fixed : ProxyKind::Moving;
    both([&](BroadPhase& b) { b.insert(i, placed(boxes[i]), kind); });
  }
  std::vector<Pair> pairs, expected;
  const int steps = static_cast<int>((GetParam().unit == 1 ? 500 : 200) * test_scale());
  for (int step = 0; step < steps; ++step) {
    // Boxes stop, start, turn, leave, and come back elsewhere and as another kind.
    for (int event = 0; event < 3; ++event) {
      const auto i = static_cast<ProxyIndex>(random() % count);
      switch (random() % 6) {
        case 0:
          moves[i] = !moves[i] && random() % 8 == 0;
          break;
        case 1:
          flights[i] = uniform(random, 0, 1) < 0.1 ? Vec2{7, -3} : -flights[i];
          break;
        case 2:
          if (!present[i] || random() % 4 != 0) break;
          present[i] = false;
          both([&](BroadPhase& b) { b.remove(i); });
          break;
        case 3:
          if (present[i]) break;
          present[i] = true;
          if (random() % 2 == 0) boxes[i] = shifted(boxes[i], {uniform(random, -3, 3), 0});
          fixed[i] = random() % 3 == 0;
          both([&](BroadPhase& b) {
            b.insert(i, placed(boxes[i]), fixed[i] ? ProxyKind::Fixed : ProxyKind::Moving);
          });
          break;
        case 4:
          moves[random() % count] = true;
          break;
        default:
          if (step % 50 == 0) {
            tested->all_pairs(pairs);
            oracle->all_pairs(expected);
            ASSERT_EQ(pairs, expected) << "step " << step;
          }
      }
    }
    // Sometimes all move for a step or two.
    const bool all = step % 100 >= 98;
    std::vector<BoxUpdate> moved;
    for (ProxyIndex i = 0; i < count; ++i) {
      if (!present[i] || !(moves[i] || all)) continue;
      const Vec2 middle = 0.5 * (boxes[i].lower + boxes[i].upper);
      if (std::abs(middle.x - 12.5) > 12.5) flights[i].x = std::copysign(flights[i].x, 12.5 - middle.x);
      if (std::abs(middle.y - 12.5) > 12.5) flights[i].y = std::copysign(flights[i].y, 12.5 - middle.y);
      boxes[i] = shifted(boxes[i], flights[i]);
      moved.push_back({i, placed(boxes[i])});
    }
    both([&](BroadPhase& b) { b.update(moved); });
    tested->moved_pairs(pairs);
    oracle->moved_pairs(expected);
    ASSERT_EQ(pairs, expected) << "step " << step;
  }
}

/// Boxes that fall and fly together, as bodies do: margins go along with them.
class NeighbourListOfTheMany : public testing::TestWithParam<Place> {};

INSTANTIATE_TEST_SUITE_P(
    Places, NeighbourListOfTheMany,
    testing::Values(Place{"NearTheOrigin", 1, {}}, Place{"FarAway", 1, {1e9, -1e9}},
                    Place{"InTheLastPlaces", 2e-7, {1e9, 1e9}}, Place{"FarOnOneAxis", 1e-3, {1e9, 0}},
                    Place{"BelowSinglePrecision", 1e-42, {}}, Place{"AboveSinglePrecision", 1e200, {}},
                    Place{"AtTheEndOfDoubles", 1e305, {}}),
    [](const testing::TestParamInfo<Place>& place) { return std::string(place.param.name); });

TEST_P(NeighbourListOfTheMany, KeepsThePairsAndAnswersWhileAllDrift) {
  const auto tested = make_broad_phase("neighbour_list"), oracle = make_broad_phase("brute_force");
  const unsigned seed = 1967;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  const auto placed = [&](const Aabb& box) {
    const Place& place = GetParam();
    return Aabb{place.unit * box.lower + place.origin, place.unit * box.upper + place.origin};
  };
  const auto both = [&](auto call) {
    call(*tested);
    call(*oracle);
  };
  const ProxyIndex count = 300;
  std::vector<Aabb> boxes;
  std::vector<Vec2> flights;
  std::vector<bool> present(count, true);
  const auto is_fixed = [](ProxyIndex i) { return i % 15 == 7; };
  for (ProxyIndex i = 0; i < count; ++i) {
    const double length = is_fixed(i) ? 9 : uniform(random, 0.5, 1.5);
    boxes.push_back(box_at(uniform(random, 0, 25), uniform(random, 0, 25), length, 1));
    flights.push_back({uniform(random, -0.02, 0.02), uniform(random, -0.02, 0.02)});
    const ProxyKind kind = is_fixed(i) ? ProxyKind::Fixed : ProxyKind::Moving;
    both([&](BroadPhase& b) { b.insert(i, placed(boxes[i]), kind); });
  }
  std::vector<Pair> pairs, expected;
  std::vector<ProxyIndex> found, wanted;
  const auto compare = [&](int step) {
    tested->moved_pairs(pairs);
    oracle->moved_pairs(expected);
    EXPECT_EQ(pairs, expected) << "step " << step;
  };
  Vec2 drift;
  const int steps = static_cast<int>(300 * test_scale());
  for (int step = 0; step < steps && !HasFailure(); ++step) {
    // They fall ever faster, are thrown up again, or stop, some of them or all.
    drift.y -= 0.01;
    if (random() % 20 == 0) drift = {uniform(random, -0.2, 0.2), uniform(random, 0, 0.5)};
    const bool still = step % 60 >= 50;
    const auto rests = [&](ProxyIndex i) { return step % 90 > 40 && i % 3 == 0; };
    std::vector<BoxUpdate> moved;
    for (ProxyIndex i = 0; i < count; ++i) {
      if (!present[i] || is_fixed(i)) continue;
      Vec2 shift = flights[i];
      if (!rests(i)) shift += drift;
      if (boxes[i].lower.y + shift.y < -3) shift.y += 30;
      if (boxes[i].lower.y + shift.y > 28) shift.y -= 30;
      if (still && i % 8 != 0) continue;
      boxes[i] = shifted(boxes[i], shift);
      moved.push_back({i, placed(boxes[i])});
    }
    both([&](BroadPhase& b) { b.update(moved); });
    compare(step);
    // Some change once more, as the boxes of bodies that were struck do, come, or go.
    moved.clear();
    for (std::uint64_t k = random() % 12; k > 0; --k) {
      const auto i = static_cast<ProxyIndex>(random() % count);
      if (!present[i]) {
        present[i] = true;
        both([&](BroadPhase& b) {
          b.insert(i, placed(boxes[i]), is_fixed(i) ? ProxyKind::Fixed : ProxyKind::Moving);
        });
      } else if (random() % 10 == 0) {
        present[i] = false;
        both([&](BroadPhase& b) { b.remove(i); });
      } else {
        boxes[i].upper.x += boxes[i].upper.x - boxes[i].lower.x < 2 ? 0.3 : -0.3;
        both([&](BroadPhase& b) { b.update(std::vector<BoxUpdate>{{i, placed(boxes[i])}}); });
      }
    }
    if (random() % 4 != 0) compare(step);
    if (random() % 8 == 0) {
      tested->all_pairs(pairs);
      oracle->all_pairs(expected);
      EXPECT_EQ(pairs, expected) << "step " << step;
    }
    const Aabb region = placed(box_at(uniform(random, 0, 25), uniform(random, 0, 25), 3, 2));
    tested->query(region, found);
    oracle->query(region, wanted);
    EXPECT_EQ(found, wanted) << "step " << step;
    const Ray ray{region.lower, region.upper - region.lower, 4};
    tested->ray_cast(ray, found);
    oracle->ray_cast(ray, wanted);
    EXPECT_EQ(found, wanted) << "step " << step;
  }
}

/// Tests of each box and step while 2500 fall, but every `stride`-th flies sideways, much faster.
double tests_while_falling(ProxyIndex stride) {
  const auto tested = make_broad_phase("neighbour_list");
  const int count = 2500, side = 50;
  std::vector<Aabb> boxes;
  for (ProxyIndex i = 0; i < count; ++i) {
    const int column = static_cast<int>(i) % side, row = static_cast<int>(i) / side;
    boxes.push_back(box_at(1.1 * column, 1.1 * row, 0.5, 0.5));
    tested->insert(i, boxes[i], ProxyKind::Moving);
  }
  tested->insert(count, {{-100, -101}, {200, -100}}, ProxyKind::Fixed);
  std::vector<Pair> pairs;
  std::uint64_t tests = 0;
  const int steps = 60;
  for (int step = 0; step < steps; ++step) {
    std::vector<BoxUpdate> moved;
    for (ProxyIndex i = 0; i < count; ++i) {
      const bool is_fast = stride > 0 && i % stride == 0;
      boxes[i] = shifted(boxes[i], is_fast ? Vec2{8, 0} : Vec2{0, -0.011 * step});
      moved.push_back({i, boxes[i]});
    }
    tested->update(moved);
    tested->moved_pairs(pairs);
    tests += tested->stats().box_tests;
  }
  return static_cast<double>(tests) / (steps * count);
}

TEST(NeighbourList, FallsWithTheBoxes) {
  // Of each box a list has four partners; margins that stay behind take 30 tests of each in every step.
  EXPECT_LT(tests_while_falling(0), 7);
}

TEST(NeighbourList, FallsWithTheBoxesThoughSomeFlyFast) {
  EXPECT_LT(tests_while_falling(500), 7);
}

TEST(NeighbourList, TestsOnlyThePartnersOfTheFewThatMove) {
  const auto tested = make_broad_phase("neighbour_list");
  Random random(5);
  const int count = 20000, side = 230;
  std::vector<Aabb> boxes;
  for (ProxyIndex i = 0; i < count; ++i) {
    boxes.push_back(box_at(uniform(random, 0, side), uniform(random, 0, side), 1, 1));
    tested->insert(i, boxes[i], ProxyKind::Moving);
  }
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  std::uint64_t searches = 0, tests = 0;
  const int steps = 40, stride = 100;
  for (int step = 0; step < steps; ++step) {
    std::vector<BoxUpdate> moved;
    for (ProxyIndex i = 0; i < count; i += stride) {
      boxes[i] = shifted(boxes[i], {0.05, 0.02});
      moved.push_back({i, boxes[i]});
    }
    tested->update(moved);
    tested->moved_pairs(pairs);
    if (step < 10) continue;
    tests += tested->stats().box_tests;
    searches += tested->stats().box_tests > 20 * moved.size() ? 1 : 0;
  }
  // A box overlaps about six others; a margin that reaches one size ahead meets half as many more. All start
  // together, so they leave their margins in the same two steps.
  EXPECT_LT(tests / (30.0 * count / stride), 14);
  EXPECT_LE(searches, 4);
}

TEST(NeighbourList, TestsNotManyMoreFarFromTheOriginWhereShiftsAreLostInRounding) {
  // The same few slow boxes near the origin and 1e9 m away, where single precision counts in steps of 64 m.
  std::uint64_t tests[2];
  for (const int far : {0, 1}) {
    const auto tested = make_broad_phase("neighbour_list"), oracle = make_broad_phase("brute_force");
    Random random(8);
    std::vector<Aabb> boxes;
    for (ProxyIndex i = 0; i < 2000; ++i) {
      boxes.push_back(
          box_at(1e9 * far + uniform(random, 0, 7000), uniform(random, 0, 7000) - 1e9 * far, 100, 100));
      for (BroadPhase* b : {tested.get(), oracle.get()}) b->insert(i, boxes[i], ProxyKind::Moving);
    }
    std::vector<Pair> pairs, expected;
    tested->moved_pairs(pairs);
    oracle->moved_pairs(expected);
    tests[far] = 0;
    for (int step = 0; step < 60; ++step) {
      std::vector<BoxUpdate> moved;
      for (ProxyIndex i = 0; i < boxes.size(); i += 100) {
        boxes[i] = shifted(boxes[i], {3, 1});
        moved.push_back({i, boxes[i]});
      }
      for (BroadPhase* b : {tested.get(), oracle.get()}) b->update(moved);
      tested->moved_pairs(pairs);
      oracle->moved_pairs(expected);
      ASSERT_EQ(pairs, expected) << "step " << step;
      tests[far] += tested->stats().box_tests;
    }
  }
  EXPECT_LT(tests[1], 2 * tests[0]);
}

TEST(NeighbourList, TestsTheSameCandidatesUntilBoxesLeaveTheirMargins) {
  const auto tested = make_broad_phase("neighbour_list");
  Random random(3);
  const std::vector<Aabb> start = scenes()[1].make(random, 1000);
  for (ProxyIndex i = 0; i < start.size(); ++i) tested->insert(i, start[i], ProxyKind::Moving);
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  const auto tests_after = [&](double away) {
    std::vector<BoxUpdate> moved;
    for (ProxyIndex i = 0; i < start.size(); ++i) moved.push_back({i, shifted(start[i], {away, 0})});
    tested->update(moved);
    tested->moved_pairs(pairs);
    return tested->stats().box_tests;
  };
  const std::uint64_t kept = tests_after(0.1);
  // 3 overlaps a box, and (1 + 2 * 0.28)^2 times as many of the margins.
  EXPECT_LT(kept, 6000u);
  EXPECT_EQ(tests_after(-0.2), kept);
  EXPECT_EQ(tests_after(0.25), kept);
  EXPECT_GT(tests_after(0.4), kept);
}

TEST(NeighbourList, AgreesWithBruteForceWhileMarginsAreLeftAndListsRenewed) {
  const unsigned seed = 44;
  const int steps = static_cast<int>(300 * std::min(1.0, test_scale()));
  for (const bool wide : {false, true}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << " wide " << wide);
    Random random(seed);
    const auto tested = make_with_finder("neighbour_list", make_neighbour_list({}, wide));
    const auto oracle = make_broad_phase("brute_force");
    std::vector<Aabb> boxes = scenes()[0].make(random, 400);
    std::vector<std::uint8_t> is_present(boxes.size(), 1);
    const auto insert = [&](ProxyIndex i) {
      const ProxyKind kind = random() % 5 == 0 ? ProxyKind::Fixed : ProxyKind::Moving;
      for (BroadPhase* b : {tested.get(), oracle.get()}) b->insert(i, boxes[i], kind);
      is_present[i] = 1;
    };
    for (ProxyIndex i = 0; i < boxes.size(); ++i) insert(i);
    std::vector<Pair> pairs, expected;
    for (int step = 0; step < steps; ++step) {
      SCOPED_TRACE(testing::Message() << "step " << step);
      // Slow, at the margins, and far; from a third of the boxes to all; the same box may come and go.
      const double far = step % 60 < 30 ? 0.02 : step % 60 < 50 ? 0.2 : 2;
      const double share = step % 7 == 0 ? 0.1 : uniform(random, 0.3, 1.1);
      std::vector<BoxUpdate> moved;
      for (ProxyIndex i = 0; i < boxes.size(); ++i) {
        if (random() % 97 == 0) {
          if (is_present[i]) {
            for (BroadPhase* b : {tested.get(), oracle.get()}) b->remove(i);
            is_present[i] = 0;
          }
          if (random() % 2) insert(i);
        } else if (!is_present[i] && random() % 8 == 0) {
          insert(i);
        } else if (is_present[i] && uniform(random, 0, 1) < share) {
          boxes[i] = shifted(boxes[i], {uniform(random, -far, far), uniform(random, -far, far)});
          moved.push_back({i, boxes[i]});
        }
      }
      tested->update(moved);
      oracle->update(moved);
      tested->moved_pairs(pairs);
      oracle->moved_pairs(expected);
      ASSERT_EQ(pairs, expected);
    }
  }
}

TEST(HierarchicalGrid, KeepsTheCostOfAMoveIndependentOfTheSleepers) {
  // Counted, not timed: tests of one moving box among many sleepers.
  std::uint64_t tests[2];
  for (int k = 0; k < 2; ++k) {
    const int count = k == 0 ? 1000 : 30000;
    Random random(8);
    const auto tested = make_broad_phase("hierarchical_grid");
    const std::vector<Aabb> boxes = scenes()[1].make(random, count);
    for (ProxyIndex i = 0; i < boxes.size(); ++i) tested->insert(i, boxes[i], ProxyKind::Moving);
    std::vector<Pair> pairs;
    tested->moved_pairs(pairs);
    tested->update(std::vector<BoxUpdate>{{7, shifted(boxes[7], {0.1, 0})}});
    tested->moved_pairs(pairs);
    tests[k] = tested->stats().box_tests;
  }
  EXPECT_LT(tests[1], tests[0] + 30);
}

TEST(HierarchicalGrid, TestsNoMoreAfterAFewBoxesHaveBeenElsewhere) {
  const auto tested = make_broad_phase("hierarchical_grid");
  const unsigned seed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random(seed);
  constexpr ProxyIndex kCount = 1000, kStride = 200;
  const auto anywhere = [&] { return box_at(uniform(random, 0, 40), uniform(random, 0, 40), 1, 1); };
  std::vector<BoxUpdate> home;
  for (ProxyIndex i = 0; i < kCount; ++i) {
    const Aabb box = anywhere();
    tested->insert(i, box, ProxyKind::Moving);
    if (i % kStride == 0) home.push_back({i, box});
  }
  std::vector<Pair> pairs;
  tested->moved_pairs(pairs);
  const auto tests_at_home = [&] {
    tested->update(home);
    tested->moved_pairs(pairs);
    return tested->stats().box_tests;
  };
  const std::uint64_t expected = tests_at_home();
  // Not so many moves that the grid is made anew.
  for (int step = 0; step < 40; ++step) {
    std::vector<BoxUpdate> away = home;
    for (BoxUpdate& update : away) update.box = anywhere();
    tested->update(away);
    tested->moved_pairs(pairs);
  }
  EXPECT_EQ(tests_at_home(), expected);
}

TEST(HierarchicalGrid, FindsTheSamePairsWithNarrowAndWideInstructions) {
  const unsigned seed = 21;
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(testing::Message() << scene.name << " seed " << seed);
    Random random(seed);
    const std::vector<Aabb> boxes = scene.make(random, 700);
    std::vector<Pair> pairs[2];
    for (const bool wide : {false, true}) {
      const auto tested = make_with_finder("hierarchical_grid",
                                           std::make_unique<HierarchicalGrid>(BroadPhaseOptions{}, wide));
      for (ProxyIndex i = 0; i < boxes.size(); ++i) {
        tested->insert(i, boxes[i], i % 5 == 0 ? ProxyKind::Fixed : ProxyKind::Moving);
      }
      tested->moved_pairs(pairs[wide]);
      std::vector<BoxUpdate> moved;
      for (ProxyIndex i = 0; i < boxes.size(); i += 2) moved.push_back({i, boxes[i]});
      tested->update(moved);
      std::vector<Pair> again;
      tested->moved_pairs(again);
      pairs[wide].insert(pairs[wide].end(), again.begin(), again.end());
    }
    ASSERT_TRUE(pairs[0] == pairs[1]);
  }
}

TEST(SweepAndPrune, CountsExchangesThatGrowWithTheMotion) {
  Random random(4);
  const std::vector<Aabb> boxes = scenes()[1].make(random, 500);
  std::uint64_t swaps[2];
  for (int k = 0; k < 2; ++k) {
    const auto tested = make_broad_phase("sweep_and_prune");
    std::vector<BoxUpdate> moved;
    Random same(6);
    for (ProxyIndex i = 0; i < boxes.size(); ++i) {
      tested->insert(i, boxes[i], ProxyKind::Moving);
      const double far = k == 0 ? 0.01 : 0.1;
      moved.push_back({i, shifted(boxes[i], {uniform(same, -far, far), uniform(same, -far, far)})});
    }
    std::vector<Pair> pairs;
    tested->moved_pairs(pairs);
    tested->update(moved);
    tested->moved_pairs(pairs);
    swaps[k] = tested->stats().swaps;
  }
  EXPECT_GT(swaps[0], 0u);
  EXPECT_GT(swaps[1], 4 * swaps[0]);
}

/// One of the few that move comes back as another kind, elsewhere, before anybody asks again.
TEST(NeighbourList, SearchesAnewForABoxThatComesBackAsAnotherKind) {
  for (const ProxyKind before : {ProxyKind::Moving, ProxyKind::Fixed}) {
    const auto tested = make_broad_phase("neighbour_list"), oracle = make_broad_phase("brute_force");
    const ProxyKind after = before == ProxyKind::Moving ? ProxyKind::Fixed : ProxyKind::Moving;
    const auto both = [&](auto call) {
      call(*tested);
      call(*oracle);
    };
    const auto at = [](double x, double y) { return Aabb{{x, y}, {x + 1, y + 1}}; };
    both([&](BroadPhase& b) {
      for (ProxyIndex i = 0; i < 200; ++i) {
        const ProxyIndex column = i % 20, row = i / 20;
        b.insert(i, at(2.0 * column, 2.0 * row), i == 0 ? before : ProxyKind::Moving);
      }
    });
    std::vector<Pair> pairs, expected;
    const auto compare = [&] {
      tested->moved_pairs(pairs);
      oracle->moved_pairs(expected);
      EXPECT_EQ(pairs, expected);
    };
    compare();
    for (int step = 1; step <= 3; ++step) {
      both([&](BroadPhase& b) { b.update(std::vector<BoxUpdate>{{0, at(0.01 * step, 0)}}); });
      compare();
    }
    both([&](BroadPhase& b) {
      b.remove(0);
      b.insert(0, at(20.5, 10.5), after);
    });
    compare();
    EXPECT_FALSE(expected.empty());
  }
}

/// Margins are as wide as the boxes have it, be they grains or ships.
TEST(NeighbourList, TestsTheSameAtAnyScale) {
  const auto tests_at = [](double unit) {
    const auto tested = make_broad_phase("neighbour_list");
    Random random(3);
    std::vector<Aabb> boxes = scenes()[1].make(random, 1000);
    std::vector<Vec2> flights;
    for (ProxyIndex i = 0; i < boxes.size(); ++i) {
      flights.push_back({uniform(random, -0.05, 0.05), uniform(random, -0.05, 0.05)});
      tested->insert(i, {unit * boxes[i].lower, unit * boxes[i].upper}, ProxyKind::Moving);
    }
    std::vector<Pair> pairs;
    std::uint64_t tests = 0;
    for (int step = 0; step < 40; ++step) {
      std::vector<BoxUpdate> moved;
      // All of them, then a few.
      for (ProxyIndex i = 0; i < boxes.size(); i += step < 20 ? 1 : 20) {
        boxes[i] = shifted(boxes[i], flights[i]);
        moved.push_back({i, {unit * boxes[i].lower, unit * boxes[i].upper}});
      }
      tested->update(moved);
      tested->moved_pairs(pairs);
      tests += tested->stats().box_tests;
    }
    return tests;
  };
  const std::uint64_t usual = tests_at(1);
  for (const double unit : {1.0 / 1024, 1024.0}) EXPECT_EQ(tests_at(unit), usual) << unit;
}

}  // namespace structures_test
}  // namespace skerry::broadphase_test
