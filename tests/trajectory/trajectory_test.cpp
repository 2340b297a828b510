// SPDX-License-Identifier: MIT
//
// Expected state hashes: the same bits on every x86-64 machine, with g++ and clang, in Debug and Release.
//
// After a change that is meant to move worlds, raise kTrajectoryVersion in physics/trajectory.h and run
//   SKERRY_BLESS=1 build/release/tests/trajectory_tests
// which writes tests/trajectory/trajectories.txt anew.
#include "physics/trajectory.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <sstream>
#include <utility>

#include "tests/support/paths.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace trajectory_test {

using test::add;
using test::add_ground;
using test::add_row;
using test::rough;
using test::smooth;

struct Scene {
  const char* name;
  void (*build)(World& world);
};

const Scene kScenes[] = {
    {"stack",
     [](World& w) {
       add_ground(w, rough(make_disc(1), 0.5));
       for (int i = 0; i < 8; ++i) add(w, {0.02 * (i % 3), i + 0.6}, rough(make_box({1, 1}), 0.5), 1 + i);
     }},
    {"heap",
     [](World& w) {
       std::mt19937 random(7);
       const auto number = [&random] { return static_cast<double>(random()) / 4294967296.0; };
       add_ground(w, rough(make_disc(1), 0.4));
       for (int i = 0; i < 15; ++i) {
         const Shape shape = i % 3 == 0   ? make_disc(0.4)
                             : i % 3 == 1 ? make_box({0.7, 0.5})
                                          : make_capsule({-0.3, 0}, {0.3, 0}, 0.2);
         // One after the other: compilers evaluate arguments in different orders.
         const double angle = 6 * number();
         const double omega = number();
         const double speed = number() - 0.5;
         const double mass = 0.5 + number();
         const Vec2 at{i % 5 + 0.3 * number(), 1 + 1.1 * (i / 5)};
         add(w, at, rough(shape, 0.3, i % 4 == 0 ? 0.3 : 0), mass, {speed, 0}, omega, angle);
       }
     }},
    {"cradle",
     [](World& w) {
       for (int i = 0; i < 5; ++i) {
         const Vec2 at = i == 0 ? Vec2{-1.5, -1.25} : Vec2{1.0 * i, -2};
         const BodyId ball = add(w, at, smooth(make_disc(0.5), 1));
         w.create_joint({.kind = JointKind::Distance, .b = ball, .anchor_a = {1.0 * i, 0}, .anchor_b = at});
       }
     }},
    {"chain",
     [](World& w) {
       BodyId last{};
       for (int i = 0; i < 6; ++i) {
         const BodyId link = add(w, {0.5 + i, 4}, rough(make_box({0.9, 0.2}), 0.3));
         w.create_joint({.a = last, .b = link, .anchor_a = {1.0 * i, 4}});
         last = link;
       }
     }},
    {"slope",
     [](World& w) {
       add_ground(w, rough(make_disc(1), 0.5), -0.2);
       add(w, {0, 0.6}, rough(make_disc(0.5), 0.5, 0.5), 1, {1, 0}, 3);
       add(w, {3, 1}, rough(make_box({1, 0.5}), 0.1), 2, {-1, 0});
     }},
    {"drum",
     [](World& w) {
       const BodyId drum = w.create_body({.type = BodyType::Kinematic, .omega = 0.5});
       for (const Vec2 side : {Vec2{3, 0}, Vec2{-3, 0}, Vec2{0, 3}, Vec2{0, -3}})
         w.add_shape(drum, rough(make_box(side.x != 0 ? Vec2{0.5, 6} : Vec2{6, 0.5}, side), 0.4));
       for (int i = 0; i < 9; ++i)
         add(w, {0.9 * (i % 3) - 0.9, 0.9 * (i / 3) - 0.9}, rough(make_box({0.6, 0.6}), 0.4));
     }},
    {"pour",
     [](World& w) {
       std::mt19937 random(3);
       const auto number = [&random] { return static_cast<double>(random()) / 4294967296.0; };
       add_ground(w, smooth(make_disc(1)));
       for (const double side : {0.0, 8.0}) {
         const BodyId wall = w.create_body({.type = BodyType::Static});
         w.add_shape(wall, smooth(make_half_plane({side, 0}, {side > 0 ? -1.0 : 1.0, 0})));
       }
       for (int i = 0; i < 120; ++i) {
         const double radius = 0.3 + 0.3 * number();
         const Vec2 at{0.7 + 1.25 * (i % 6) + 0.05 * number(), 0.65 + 1.25 * (i / 6)};
         add(w, at, smooth(make_disc(radius)), 1, {0, -12});
       }
     }},
    {"frames",
     [](World& w) {
       add_ground(w, rough(make_disc(1), 0.5));
       for (int frame = 0; frame < 4; ++frame) {
         BodyId parts[4];
         for (int i = 0; i < 4; ++i) {
           const int row = i / 2;
           const Vec2 at{0.4 * frame + 0.7 * (i % 2), 0.5 + 1.6 * frame + 0.7 * row};
           parts[i] = add(w, at, rough(make_box({0.6, 0.6}), 0.5), 1 + frame, {}, 0, 0.1 * frame);
         }
         for (const auto& [a, b] : {std::pair{0, 1}, {1, 3}, {3, 2}, {2, 0}})
           w.create_joint(
               {.kind = JointKind::Weld, .a = parts[a], .b = parts[b], .anchor_a = w.position(parts[a])});
       }
     }},
    {"told",
     [](World& w) {
       // A table that goes to and fro, and a paddle that jumps back, with breaks within the steps.
       const BodyId table = w.create_body({.type = BodyType::Kinematic});
       w.add_shape(table, rough(make_box({6, 1}), 0.4));
       w.set_motion(table, [](double t) {
         const double part = std::fmod(t, 0.37);
         return Placement{{part < 0.185 ? part : 0.37 - part, 0}, 0};
       });
       const BodyId paddle = w.create_body({.type = BodyType::Kinematic});
       w.add_shape(paddle, rough(make_box({0.2, 0.5}), 0.4));
       w.set_motion(paddle, [](double t) { return Placement{{-3 + 3 * std::fmod(t, 0.45), 0.8}, 0}; });
       for (int i = 0; i < 6; ++i)
         add(w, {1.1 * (i % 3) - 1.6, 1.1 + 1.2 * (i / 3)}, rough(make_box({0.8, 0.9}), 0.4, 0.2), 1 + i);
     }},
};

constexpr int kSteps = 60;
constexpr const char* kSteppers[] = {"time_stepping", "event_driven", "auto"};

std::map<std::string, std::string> trajectories() {
  std::map<std::string, std::string> found;
  for (const Scene& scene : kScenes) {
    for (const char* stepper : kSteppers) {
      WorldConfig config;
      config.stepper = stepper;
      World world(config);
      scene.build(world);
      for (int i = 0; i < kSteps; ++i) world.step(1.0 / 60);
      char hash[32];
      std::snprintf(hash, sizeof hash, "%016" PRIx64, world.report().state_hash);
      found[std::string(scene.name) + ' ' + stepper] = hash;
    }
  }
  return found;
}

/// Lines "scene stepper hash" after a line "version number".
std::map<std::string, std::string> read(const std::string& file, int& version) {
  std::ifstream in(file);
  std::map<std::string, std::string> table;
  std::string scene, stepper, hash;
  in >> scene >> version;
  while (in >> scene >> stepper >> hash) table[scene + ' ' + stepper] = hash;
  return table;
}

TEST(Trajectory, HasTheExpectedBits) {
  const std::string file = std::string(source_dir()) + "/tests/trajectory/trajectories.txt";
  int version = 0;
  const std::map<std::string, std::string> expected = read(file, version), found = trajectories();
  std::ostringstream text;
  text << "version " << kTrajectoryVersion << '\n';
  for (const auto& [scene, hash] : found) text << scene << ' ' << hash << '\n';
  if (std::getenv("SKERRY_BLESS") != nullptr) {
    ASSERT_TRUE(found == expected || version != kTrajectoryVersion)
        << "other bits under the same number: raise kTrajectoryVersion in physics/trajectory.h first";
    std::ofstream out(file);
    out << text.str();
    ASSERT_TRUE(out.flush()) << file;
    return;
  }
  EXPECT_EQ(version, kTrajectoryVersion) << "see the head of tests/trajectory/trajectory_test.cpp";
  EXPECT_EQ(found, expected)
      << "worlds move in other ways than before. If that is meant: raise kTrajectoryVersion "
         "in physics/trajectory.h, then run this test with SKERRY_BLESS=1. The table is now\n"
      << text.str();
}

}  // namespace trajectory_test
}  // namespace skerry
