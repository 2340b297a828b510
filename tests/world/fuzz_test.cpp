// SPDX-License-Identifier: MIT
//
// Random worlds with random calls. Whatever happens: finite states, no exception but invalid_argument, no
// energy out of nothing, and steps that end. SKERRY_TEST_SCALE makes it longer; a failure names its seed,
// and SKERRY_FUZZ_SEED runs that one alone.
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "physics/stepping/stepper.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace fuzz_test {

using test::add_ground;
using test::rough;

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Fuzz {
 public:
  Fuzz(std::string_view stepper, unsigned seed) : random_(seed), world_(config(stepper, seed)) {
    friction_ = uniform(0, 1.5);
    restitution_ = pick(3) == 0 ? 1 : uniform(0, 1);
    add_ground(world_, rough(make_disc(1), friction_, restitution_));
    for (const double side : {-1.0, 1.0}) {
      const BodyId wall = world_.create_body({.type = BodyType::Static, .position = {side * 6, 0}});
      world_.add_shape(wall, rough(make_half_plane({0, 0}, {-side, 0}), friction_, restitution_));
    }
    for (int i = 0; i < 8; ++i) create();
  }

  void step() {
    forced_ = false;
    const int calls = pick(3);
    for (int i = 0; i < calls; ++i) call();
    const double before = energy();
    const double start = thread_seconds();
    world_.step(h_);
    ASSERT_LT(thread_seconds() - start, 2.0) << "a step of " << bodies_.size() << " bodies";
    double largest = 1;
    for (const BodyId body : bodies_) {
      ASSERT_TRUE(is_finite(world_.position(body)) && is_finite(world_.velocity(body)));
      ASSERT_TRUE(std::isfinite(world_.angle(body)) && std::isfinite(world_.omega(body)));
      largest = std::max(largest, world_.mass(body) * 100);
    }
    ASSERT_EQ(world_.report().contained, 0);
    if (forced_) return;
    // Of a piece of a step, and of what bounces for ever and is laid down.
    const double gain = (energy() - before) / std::max(std::abs(before), largest);
    gains_ += gain > 1e-6;
    ASSERT_LE(gain, 1e-4);
  }
  /// Steps that gained any energy.
  int gains() const { return gains_; }

 private:
  static WorldConfig config(std::string_view stepper, unsigned seed) {
    WorldConfig config;
    config.stepper = stepper;
    if (seed % 2 == 0) config.broad_phase = "hash_sort";
    return config;
  }

  unsigned pick(unsigned count) { return random_() % count; }
  double uniform(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }
  double energy() const { return world_.kinetic_energy() + world_.potential_energy(); }
  BodyId any() { return bodies_[pick(static_cast<unsigned>(bodies_.size()))]; }

  Shape shape() {
    const double size = uniform(0.2, 0.9);
    switch (pick(4)) {
      case 0:
        return make_disc(size / 2);
      case 1:
        return make_box({size, uniform(0.2, 1) * size});
      case 2:
        return make_capsule({-size / 2, 0}, {size / 2, 0}, 0.3 * size);
      default: {
        const std::vector<Vec2> corners = {{-size / 2, -size / 3}, {size / 2, -size / 3}, {0, 2 * size / 3}};
        return make_polygon(corners);
      }
    }
  }

  /// Somewhere where nothing is: overlaps would be an energy that nobody put in.
  void create() {
    const Shape made = shape();
    for (int attempt = 0; attempt < 10; ++attempt) {
      const Vec2 at{uniform(-5, 5), uniform(1, 6)};
      const double angle = uniform(0, 6);
      if (!world_.shapes_overlapping(made, {at, Rot::from_angle(angle)}).empty()) continue;
      const BodyId body = world_.create_body({.position = at,
                                              .angle = angle,
                                              .velocity = {uniform(-5, 5), uniform(-5, 5)},
                                              .omega = uniform(-5, 5),
                                              .mass = std::pow(10, uniform(-1, 1))});
      world_.add_shape(body, rough(made, friction_, restitution_));
      bodies_.push_back(body);
      return;
    }
  }

  template <class Call>
  void expect_refusal(Call&& refused) {
    const std::uint64_t before = world_.state_hash();
    EXPECT_THROW(refused(), std::invalid_argument);
    EXPECT_EQ(world_.state_hash(), before);
  }

  void call() {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    switch (pick(9)) {
      case 0:
        if (bodies_.size() < 14) create();
        break;
      case 1: {
        if (bodies_.size() < 4) break;
        const unsigned i = pick(static_cast<unsigned>(bodies_.size()));
        const BodyId gone = bodies_[i];
        world_.destroy(gone);
        bodies_.erase(bodies_.begin() + i);
        expect_refusal([&] { world_.set_velocity(gone, {0, 0}, 0); });
        break;
      }
      case 2: {
        const BodyId body = any();
        world_.apply_impulse(body, {uniform(-3, 3), uniform(-3, 3)},
                             world_.position(body) + Vec2{uniform(-0.2, 0.2), uniform(-0.2, 0.2)});
        break;
      }
      case 3: {
        const BodyId body = any();
        world_.apply_force(body, {uniform(-50, 50), uniform(-50, 50)}, world_.position(body));
        forced_ = true;
        break;
      }
      case 4:
        world_.set_velocity(any(), {uniform(-20, 20), uniform(-20, 20)}, uniform(-20, 20));
        break;
      case 5:
        expect_refusal([&] { world_.set_velocity(any(), {nan, 0}, 0); });
        break;
      case 6:
        expect_refusal([&] { world_.step(uniform(-1, 0)); });
        break;
      case 7:
        expect_refusal([&] { world_.create_body({.position = {nan, 0}, .mass = 1.0}); });
        break;
      default:
        h_ = 1.0 / (20 + pick(200));
    }
  }

  std::mt19937 random_;
  World world_;
  std::vector<BodyId> bodies_;
  double friction_ = 0, restitution_ = 0, h_ = 1.0 / 60;
  bool forced_ = false;
  int gains_ = 0;
};

class FuzzOf : public testing::TestWithParam<std::string> {};

TEST_P(FuzzOf, RandomWorldsStayFiniteBoundedAndKeepTheirEnergy) {
  const char* const only = std::getenv("SKERRY_FUZZ_SEED");
  int gains = 0, steps = 0;
  for (int k = 0; k < (only != nullptr ? 1 : test_scale(6)); ++k) {
    const unsigned seed =
        only != nullptr ? static_cast<unsigned>(std::atoi(only)) : 1000 + static_cast<unsigned>(k);
    SCOPED_TRACE("seed " + std::to_string(seed));
    Fuzz fuzz(GetParam(), seed);
    for (int step = 0; step < 80 && !testing::Test::HasFatalFailure(); ++step) {
      SCOPED_TRACE("step " + std::to_string(step));
      fuzz.step();
      ++steps;
    }
    if (testing::Test::HasFatalFailure()) return;
    gains += fuzz.gains();
  }
  // By `time_stepping` 25 of 240 000.
  EXPECT_LE(gains, steps / 1000);
}

std::vector<std::string> stepper_names() {
  std::vector<std::string> names;
  for (const StepperEntry& entry : steppers()) names.emplace_back(entry.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Steppers, FuzzOf, testing::ValuesIn(stepper_names()),
                         [](const testing::TestParamInfo<std::string>& test) { return test.param; });

}  // namespace fuzz_test
}  // namespace skerry
