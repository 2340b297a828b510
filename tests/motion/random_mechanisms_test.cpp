// SPDX-License-Identifier: MIT
//
// Where random mechanisms go depends neither on the length of steps nor, but for its error, on the stepper.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

#include "tests/support/random_mechanism.h"
#include "tests/support/scale.h"

namespace skerry {
namespace random_mechanisms_test {

constexpr double kStep = 1.0 / 60;
constexpr int kSteps = 30;

/// Where the bodies of a recipe are after each step of `kStep`, made in so many parts.
struct Way {
  std::vector<Vec2> places;
  bool squeezed =
      false;  ///< what is told to move crushes what cannot give way, or joints want different things

  Way(const test::Recipe& recipe, const char* stepper, int parts) {
    WorldConfig config;
    config.stepper = stepper;
    World world(config);
    const std::vector<BodyId> bodies = test::build(recipe, world);
    for (int k = 0; k < kSteps; ++k) {
      for (int part = 0; part < parts; ++part) {
        const StepReport& report = world.step(kStep / parts);
        squeezed |= report.worst_penetration > 1e-5 || report.inexact_islands > 0;
      }
      for (const BodyId body : bodies) places.push_back(world.position(body));
    }
  }
};

/// How far ways of a mechanism are apart: by events in steps of two lengths; by time stepping in quarters,
/// and in sixteenths, from those [m]. Nothing where bodies are squeezed.
struct Distances {
  double events, quarters, sixteenths;
};
std::optional<Distances> distances(unsigned seed) {
  const test::RandomMechanism mechanism(seed);
  bool squeezed = false;
  const auto way = [&](const char* stepper, int parts) {
    const Way found(mechanism.recipe(), stepper, parts);
    squeezed |= found.squeezed;
    return found.places;
  };
  const std::vector<Vec2> events = way("event_driven", 1);
  const Distances out{test::apart(way("event_driven", 4), events),
                      test::apart(way("time_stepping", 4), events),
                      test::apart(way("time_stepping", 16), events)};
  if (squeezed) return std::nullopt;
  return out;
}

TEST(RandomMechanisms, GoTheSameWayByEventsInStepsOfAnyLengthAndByTimeStepping) {
  const int worlds = test_scale(200);
  int looked_at = 0, same = 0, near = 0, second_order = 0;
  for (int seed = 0; seed < worlds; ++seed) {
    const std::optional<Distances> d = distances(static_cast<unsigned>(seed));
    if (!d) continue;
    ++looked_at;
    const bool is_same = d->events < 1e-8, is_near = d->sixteenths < 1e-4;
    same += is_same;
    near += is_near;
    second_order += d->sixteenths < 1e-10 || d->quarters > 8 * d->sixteenths;
    if (!is_same || !is_near)
      std::printf("seed %d: %.1e m apart by events, by time stepping %.1e and %.1e\n", seed, d->events,
                  d->quarters, d->sixteenths);
  }
  std::printf("%d mechanisms: %d the same by events, %d near by time stepping, %d by the second order\n",
              looked_at, same, near, second_order);
  EXPECT_GE(looked_at, 0.9 * worlds);
  EXPECT_GE(same, 0.97 * looked_at);
  EXPECT_GE(near, 0.95 * looked_at);
  EXPECT_GE(second_order, 0.93 * looked_at);
  // Those in which limits were held at the ends of steps, motors drifted off their speed or stopped in an
  // impact, or what moved around a kinematic body lost its energy.
  for (const unsigned seed : {38u, 42u, 62u, 128u, 146u, 147u, 156u, 165u, 172u, 174u, 194u, 197u}) {
    const std::optional<Distances> d = distances(seed);
    ASSERT_TRUE(d) << seed;
    EXPECT_LT(d->events, 1e-9) << seed;
    EXPECT_LT(d->sixteenths, 1e-4) << seed;
  }
}

}  // namespace random_mechanisms_test
}  // namespace skerry
