// SPDX-License-Identifier: MIT
//
// Error against wall time of the steppers on scenes with known answers; see kUsage.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string_view>
#include <vector>

#include "physics/stepping/stepper.h"
#include "tests/bench/arguments.h"
#include "tests/support/worlds.h"

namespace {

using namespace skerry;
using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kG = 9.81;
constexpr int kRuns = 7;

/// A world and the error of its state after `seconds`.
struct Scene {
  const char* name;
  double seconds;
  std::function<BodyId(World&)> build;
  std::function<double(const World&, BodyId)> error;
};

/// Of the positions only: what a viewer sees. [m]
std::vector<Scene> scenes() {
  std::vector<Scene> list;
  list.push_back({"bouncing ball", 2,
                  [](World& world) {
                    add_ground(world, smooth(make_disc(1), 0.8));
                    return add(world, {0, 2.5}, smooth(make_disc(0.5), 0.8));
                  },
                  [](const World& world, BodyId ball) {
                    // Flights one after the other.
                    double t = 2 - std::sqrt(2 * 2 / kG), up = 0.8 * std::sqrt(2 * kG * 2);
                    while (t > 2 * up / kG) {
                      t -= 2 * up / kG;
                      up *= 0.8;
                    }
                    return std::abs(world.position(ball).y - 0.5 - up * t + 0.5 * kG * t * t);
                  }});
  list.push_back({"bowling", 1,
                  [](World& world) {
                    add_ground(world, rough(make_disc(1), 0.2));
                    return add(world, {0, 0.5}, rough(make_disc(0.5), 0.2), 1, {3, 0});
                  },
                  [](const World& world, BodyId disc) {
                    const double time = 3 / (3 * 0.2 * kG), path = 5 * 9 / (18 * 0.2 * kG);
                    return std::abs(world.position(disc).x - (path + 2 * (1 - time)));
                  }});
  list.push_back(
      {"roll-off", 1.2,
       [](World& world) {
         const auto cylinder = world.create_body({.type = BodyType::Static});
         world.add_shape(cylinder, rough(make_disc(1), 0.2));
         return add(world, {1.25 * std::sin(0.1), 1.25 * std::cos(0.1)}, rough(make_disc(0.25), 0.2));
       },
       nullptr});
  list.push_back(
      {"pendulum", 2,
       [](World& world) {
         const auto bob = world.create_body({.position = {1, 0}, .mass = 1.0, .inertia = 0.1});
         world.create_joint({.kind = JointKind::Revolute, .b = bob, .anchor_a = {0, 0}, .anchor_b = {0, 0}});
         return bob;
       },
       nullptr});
  return list;
}

World make_world(std::string_view stepper, std::optional<double> accuracy) {
  WorldConfig config;
  config.stepper = stepper;
  config.accuracy = accuracy;
  return World(config);
}

/// Reference where there is no formula: events at the finest accuracy in short steps.
Vec2 reference(const Scene& scene) {
  World world = make_world("event_driven", 1e-14);
  const BodyId body = scene.build(world);
  const int steps = 480;
  for (int i = 0; i < steps; ++i) world.step(scene.seconds / steps);
  return world.position(body);
}

/// What is timed, and a place where a profiler can begin to count. @return force solves at acceleration level
[[gnu::noinline]] long make_steps(World& world, double h, int count) {
  long solves = 0;
  for (int i = 0; i < count; ++i) solves += world.step(h).force_solves;
  return solves;
}

void measure(const Scene& scene, Vec2 exact, std::string_view stepper, std::optional<double> accuracy,
             int per_second) {
  std::vector<double> times;
  double error = 0;
  long solves = 0;
  const int steps = static_cast<int>(std::lround(scene.seconds * per_second));
  for (int run = 0; run < kRuns; ++run) {
    World world = make_world(stepper, accuracy);
    const BodyId body = scene.build(world);
    const auto start = std::chrono::steady_clock::now();
    solves = make_steps(world, scene.seconds / steps, steps);
    times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    error = scene.error ? scene.error(world, body) : length(world.position(body) - exact);
  }
  std::sort(times.begin(), times.end());
  std::printf("%s,%s,%.0e,%d,%d,%.3e,%.3e,%.3e,%.3f,%.1f\n", scene.name, std::string(stepper).c_str(),
              accuracy.value_or(0), per_second, steps, error, times.front(), times[times.size() / 2],
              1e6 * times.front() / steps, static_cast<double>(solves) / steps);
}

constexpr const char* kUsage =
    R"(usage: stepping_bench [SCENE STEPPER STEPS_A_SECOND]

Prints CSV: one line for each scene, stepper and step length (or accuracy that was asked for), with the least
and the median time of several runs (tests/bench/stepping.sh draws it); or one line alone, to count its
instructions (tests/bench/stepping.md).
)";

int run(int argc, char** argv) {
  if (argc != 1 && argc != 4) throw bench::BadArgument("expected nothing, or SCENE STEPPER STEPS_A_SECOND");
  int rate = 0;
  if (argc == 4) {
    bench::expect_name("scene", argv[1], bench::names_of(scenes()));
    bench::expect_name("stepper", argv[2], bench::names_of(steppers()));
    rate = bench::count_of("STEPS_A_SECOND", argv[3], 1);
  }
  std::printf(
      "scene,stepper,accuracy,steps a second,steps,error,least seconds,median seconds,us a step,"
      "force solves a step\n");
  for (const Scene& scene : scenes()) {
    if (argc == 4) {
      if (std::string_view(argv[1]) == scene.name)
        measure(scene, scene.error ? Vec2{} : reference(scene), argv[2], std::nullopt, rate);
      continue;
    }
    const Vec2 exact = scene.error ? Vec2{} : reference(scene);
    for (const StepperEntry& stepper : steppers()) {
      for (int per_second = 30; per_second <= 1920; per_second *= 2)
        measure(scene, exact, stepper.name, std::nullopt, per_second);
      for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8})
        measure(scene, exact, stepper.name, accuracy, 60);
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::run_with_arguments("stepping_bench", kUsage, argc, argv, run);
}
