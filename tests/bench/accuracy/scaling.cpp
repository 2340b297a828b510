// SPDX-License-Identifier: MIT
//
// Time a step against the number of bodies, by stage, on one and two threads; peers for comparison.
#include <chrono>
#include <cmath>
#include <cstdio>

#include "tests/bench/accuracy/engine_skerry.h"
#include "tests/bench/accuracy/options.h"
#include "tests/bench/accuracy/problem.h"
#include "tests/bench/arguments.h"

namespace skerry::bench {
namespace {

constexpr int kCounts[] = {10, 100, 316, 1000, 3162, 10000, 31623, 100000};
// Steps before those whose median is taken. Engines let bodies sleep after half a second at rest, Bullet
// after two; what is poured falls freely at first, and after 1.5 s nearly all of it touches.
constexpr int kWarmUp = 2, kUntilPiled = 90, kUntilAsleep = 150, kSteps = 6;
// A size is the last one of a scene when a step of it takes longer than this [s].
constexpr double kLongStep = 0.03;

/// Discs that fly and rarely meet.
Scene sparse(int count) {
  Scene scene = gas_scene(count, 0.01, 1);
  scene.bodies.erase(scene.bodies.begin(), scene.bodies.begin() + 4);
  return scene;
}

/// A wall of bricks in running bond, as wide as it is high: one island.
Scene wall(int count) {
  Scene scene;
  SceneBody floor = ground();
  floor.shape.extent = 4000;
  scene.add(floor);
  const int width = static_cast<int>(std::ceil(std::sqrt(count)));
  for (int i = 0; i < count; ++i) {
    const int row = i / width;
    scene.add({.shape = box(1, 1), .position = {i % width + 0.5 * (row % 2) - width / 2, row + 0.5}});
  }
  return scene;
}

/// Stacks of five, apart from each other: many islands.
Scene stacks(int count) {
  Scene scene;
  SceneBody floor = ground();
  floor.shape.extent = 200000;
  scene.add(floor);
  for (int i = 0; i < count; ++i)
    scene.add({.shape = box(1, 1), .position = {2.0 * (i / 5) - count / 5, i % 5 + 0.5}});
  return scene;
}

/// Discs of two sizes poured into a bin, where they come to lie on each other and flow: a pile in motion.
Scene pile(int count) {
  Scene scene;
  scene.friction = 0.3;
  const int width = static_cast<int>(std::ceil(std::sqrt(count)));
  SceneBody floor = ground();
  floor.shape.extent = 4.0 * width + 100;
  scene.add(floor);
  for (const double side : {-1.0, 1.0}) {
    SceneBody plane = ground(side * kPi / 2, {side * (0.55 * width + 0.5), 0});
    plane.shape.extent = 4.0 * width + 100;
    scene.add(plane);
  }
  for (int i = 0; i < count; ++i) {
    const int row = i / width;
    scene.add({.shape = disc(i % 3 == 0 ? 0.4 : 0.5),
               .position = {(i % width) * 1.02 + 0.4 * (row % 2) - 0.51 * width, 0.5 + row * 0.98},
               .mass = i % 3 == 0 ? 0.64 : 1});
  }
  return scene;
}

struct Family {
  const char* name;
  Scene (*make)(int count);
  int pushed;  ///< one body in so many is pushed at every step; 0: none
  int warm_up = kWarmUp;
};

constexpr Family kFamilies[] = {{"sparse", sparse, 0},
                                {"pile", pile, 0, kUntilPiled},
                                {"one island", wall, 50},
                                {"many islands", stacks, 5},
                                {"mostly asleep", stacks, 500, kUntilAsleep}};

/// Pushes so lightly that nothing slides, but forces change.
template <class Push>
void disturb(const Family& family, int bodies, int step, Push push) {
  if (family.pushed == 0) return;
  for (int i = 1 + step % 2; i <= bodies; i += family.pushed) push(i, Vec2{0.001 * (1 + step % 7), 0});
}

struct Times {
  std::vector<double> seconds;  // of the steps after the warm-up
  double slowest = 0;           // of all but the first ones: that in which all are put to sleep is among them
  void note(const Family& family, int step, double spent) {
    if (step >= kWarmUp) slowest = std::max(slowest, spent);
    if (step >= family.warm_up) seconds.push_back(spent);
  }
  double median_us() const { return 1e6 * median(seconds); }
  double min_us() const { return 1e6 * *std::min_element(seconds.begin(), seconds.end()); }
  double max_us() const { return 1e6 * slowest; }
};

std::string row_of(const Family& family, int count, const EngineEntry& engine, const std::string& curve,
                   int threads, const Times& times) {
  return joined({family.name, std::to_string(count), engine.name, engine.version, curve,
                 std::to_string(threads), number(times.median_us()), number(times.min_us()),
                 number(times.max_us())});
}

/// Ours, with the number of contacts, the residual and the stages of the step. Several threads are timed by
/// the wall, one by the processor.
double ours(const Family& family, int count, const EngineEntry& engine, int threads,
            std::vector<std::string>& rows) {
  const Scene scene = family.make(count);
  std::vector<BodyId> bodies;
  WorldConfig config = skerry_config({.threads = threads});
  World world = make_world(scene, config, bodies);
  world.observe({.stage_times = true});
  const int fixed = static_cast<int>(scene.bodies.size()) - count;
  Times times;
  std::array<std::vector<double>, kStageCount> stages;
  std::vector<double> contacts;
  double residual = 0;
  for (int step = 0; step < family.warm_up + kSteps; ++step) {
    disturb(family, count, step, [&](int i, Vec2 impulse) {
      const BodyId id = bodies[static_cast<std::size_t>(std::min(count, i) + fixed - 1)];
      world.apply_impulse(id, impulse, world.position(id));
    });
    const auto wall_start = std::chrono::steady_clock::now();
    const double start = thread_seconds();
    const StepReport& report = world.step(1.0 / 60);
    const double processor = thread_seconds() - start;
    const double wall_time =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
    times.note(family, step, threads == 1 ? processor : wall_time);
    if (step < family.warm_up) continue;
    contacts.push_back(report.contacts);
    residual = std::max(residual, report.worst_residual);
    for (std::size_t k = 0; k < stages.size(); ++k) stages[k].push_back(1e6 * report.stage_seconds[k]);
  }
  std::string row = row_of(family, count, engine, "time_stepping", threads, times);
  row.append(1, ',').append(number(median(contacts))).append(1, ',').append(number(residual));
  for (const std::vector<double>& stage : stages) row.append(1, ',').append(number(median(stage)));
  rows.push_back(row);
  return times.median_us() * 1e-6;
}

double peer(const Family& family, int count, const EngineEntry& engine, std::vector<std::string>& rows) {
  const Scene scene = family.make(count);
  const auto world = engine.make(scene, engine.curves.front());
  const int fixed = static_cast<int>(scene.bodies.size()) - count;
  Times times;
  for (int step = 0; step < family.warm_up + kSteps; ++step) {
    disturb(family, count, step,
            [&](int i, Vec2 impulse) { world->push(std::min(count, i) + fixed - 1, impulse); });
    const double start = thread_seconds();
    world->step();
    times.note(family, step, thread_seconds() - start);
  }
  std::string row = row_of(family, count, engine, engine.curves.front().label, 1, times);
  row.append(kStageCount + 2, ',');
  rows.push_back(row);
  return times.median_us() * 1e-6;
}

}  // namespace

std::vector<std::string> scaling_scenes() {
  return names_of(kFamilies);
}

void run_scaling(const Options& options) {
  std::string header = "scene,bodies,engine,version,curve,threads,median_us,min_us,max_us,contacts,residual";
  for (int k = 0; k < kStageCount; ++k) header.append(1, ',').append(stage_name(static_cast<Stage>(k)));
  for (const Family& family : kFamilies) {
    if (!options.wants_scene(family.name)) continue;
    std::vector<std::string> rows;
    for (const EngineEntry& engine : engines()) {
      if (!options.wants_engine(engine.name)) continue;
      for (const int threads : {1, 2}) {
        if (threads > 1 && !engine.ours) continue;
        for (const int count : kCounts) {
          const double step =
              engine.ours ? ours(family, count, engine, threads, rows) : peer(family, count, engine, rows);
          if (step > kLongStep) break;
        }
        std::fprintf(stderr, "%s %s %d\n", family.name, engine.name.c_str(), threads);
      }
    }
    merge_csv(options, "scaling.csv", header, {family.name}, rows);
  }
}

}  // namespace skerry::bench
