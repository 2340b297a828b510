// SPDX-License-Identifier: MIT
//
// Islands in flow, and large islands that are disturbed in one place; see kUsage.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <numeric>
#include <random>

#include "tests/bench/arguments.h"
#include "tests/bench/solver_timing.h"
#include "tests/support/ragdoll.h"
#include "tests/support/worlds.h"

namespace {

using namespace skerry;
using test::add;
using test::add_ground;
using test::rough;

constexpr double kFriction = 0.5;

World empty(double flow_work) {
  WorldConfig config;
  config.solve.work_limit = 0;
  config.flow_work = flow_work;
  return World(config);
}

// Boxes in loose columns that fall over each other.
World boxes(int count, double flow_work) {
  World world = empty(flow_work);
  const ShapeDef box = rough(make_box({1, 1}), kFriction);
  add_ground(world, box);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> noise(-0.2, 0.2);
  const int columns = count < 300 ? 12 : 30;
  for (int i = 0; i < count; ++i)
    add(world, {1.3 * (i % columns) + noise(random), 0.8 + 1.3 * (i / columns)}, box, 1, {}, noise(random));
  return world;
}

World discs(int count, double flow_work) {
  World world = empty(flow_work);
  const ShapeDef disc = rough(make_disc(0.5), kFriction);
  add_ground(world, disc);
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> noise(-0.2, 0.2);
  const int columns = count < 500 ? 15 : 50;
  for (int i = 0; i < count; ++i)
    add(world, {1.3 * (i % columns) + noise(random), 0.6 + 1.3 * (i / columns)}, disc, 1);
  return world;
}

using Bodies = std::vector<BodyId>;

void add_box(World& world, Bodies& bodies, Vec2 at, double width = 1, double height = 1, double angle = 0) {
  bodies.push_back(add(world, at, rough(make_box({width, height}), kFriction)));
  if (angle != 0) world.set_pose(bodies.back(), at, angle);
}

void add_pyramid(World& world, Bodies& bodies, int base) {
  for (int row = 0; row < base; ++row)
    for (int k = 0; k < base - row; ++k) add_box(world, bodies, {1.1 * (k + 0.5 * row), row + 0.5});
}

/// How far a point on the left of a pyramid is from it.
double to_pyramid(Vec2 from, int base) {
  double least = kInfinity;
  for (int row = 0; row < base; ++row) {
    const double aside = 0.55 * row - 0.5 - from.x, above = std::abs(from.y - row - 0.5) - 0.5;
    least = std::min(least, std::hypot(std::max(aside, 0.0), std::max(above, 0.0)));
  }
  return least;
}

constexpr int kBeforeBlow = 2;  // steps

/// A pyramid at rest, hit from the side by a disc of a hundred times a box's mass, which has been thrown some
/// 4 m beside it: the world begins so late in its flight that it arrives in the middle of the step after
/// those before the blow.
World struck_pyramid(int base, double flow_work) {
  World world = empty(flow_work);
  const ShapeDef box = rough(make_box({1, 1}), kFriction);
  add_ground(world, box);
  Bodies boxes;
  add_pyramid(world, boxes, base);
  const double step = 1.0 / 60, g = 9.81, speed = 15, radius = 1.5;
  const auto at = [&](double time) {
    return Vec2{-4 + speed * time, 0.3 * base + 2 - 0.5 * g * time * time};
  };
  double contact = 0;
  while (to_pyramid(at(contact), base) > radius) contact += 0.05 * step;
  const double start = contact - (kBeforeBlow + 0.5) * step;
  add(world, at(start), rough(make_disc(radius), kFriction), 100, {speed, -g * start});
  return world;
}

/// One ball, lighter than a box by 100 to 10 000 times, at up to 10 m/s. @return time of the steps [s]
double throw_ball(int number) {
  std::mt19937_64 random(static_cast<unsigned>(number));
  const auto uniform = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  const int base = static_cast<int>(uniform(20, 60));
  const double mass = std::pow(10.0, uniform(-1, 1));
  const Vec2 v{uniform(0, 1) < 0.7 ? uniform(1, 10) : 0, uniform(0, 1) < 0.5 ? -uniform(0, 6) : 0};
  WorldConfig config;
  config.sleep = false;
  World world(config);
  const ShapeDef box = rough(make_box({1, 1}), 0.6);
  add_ground(world, box);
  for (int row = 0; row < base; ++row)
    for (int k = 0; k < base - row; ++k)
      add(world, {1.05 * (k - 0.5 * (base - row - 1)), row + 0.5}, box, 1000);
  for (int k = 0; k < 20; ++k) world.step(1.0 / 60);
  const Vec2 from = v.x > 0 ? Vec2{-0.275 * base - 2, 0.45 * base} : Vec2{0.1, base + 1.0};
  add(world, from, rough(make_disc(0.5), 0.6), mass, v);
  double sum = 0, slowest = 0;
  int inexact = 0;
  for (int k = 0; k < 100; ++k) {
    const double begin = bench::thread_seconds();
    inexact += world.step(1.0 / 60).inexact_islands > 0;
    const double seconds = bench::thread_seconds() - begin;
    sum += seconds;
    slowest = std::max(slowest, seconds);
  }
  std::printf("%5d %5d %8.3g kg %5.2f %6.2f m/s %9.1f %8.1f %7d\n", number, base, mass, v.x, v.y, 1e3 * sum,
              1e3 * slowest, inexact);
  std::fflush(stdout);
  return sum;
}

/// Piles that stand, or, with a seed, lie as they fell, and how long it takes them to come to rest [steps].
struct Pile {
  const char* name;
  int steps;
  void (*add_to)(World& world, Bodies& bodies, std::uint64_t seed);
  double sleep_speed = 0;  ///< [m/s]
};

template <int kSide>
void add_wall(World& world, Bodies& bodies, std::uint64_t) {
  for (int row = 0; row < kSide; ++row)
    for (int k = 0; k < kSide; ++k) add_box(world, bodies, {k + 0.5 * (row % 2), row + 0.5});
}

void add_columns(World& world, Bodies& bodies, std::uint64_t) {
  for (int row = 0; row < 30; ++row)
    for (int k = 0; k < 30; ++k) add_box(world, bodies, {1.0 * k, row + 0.5});
}

/// Each plank on three blocks.
void add_planks(World& world, Bodies& bodies, std::uint64_t) {
  for (int row = 0; row < 20; ++row) {
    const bool planks = row % 2 == 1;
    for (int k = 0; k < (planks ? 10 : 21); ++k)
      add_box(world, bodies, {planks ? 4.0 * k + 2 : 2.0 * k, row + 0.5}, planks ? 4 : 0.9, 1);
  }
}

/// Dropped into a bin, with room for a row of the root of their number.
template <int kCount, bool kBoxes>
void add_heap(World& world, Bodies& bodies, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const double apart = kBoxes ? 1.4 : 1.15, half = (kBoxes ? 0.7 : 0.6) * std::sqrt(kCount);
  const BodyId sides = world.create_body({.type = BodyType::Static});
  world.add_shape(sides, rough(make_half_plane({-half, 0}, {1, 0}), kFriction));
  world.add_shape(sides, rough(make_half_plane({half, 0}, {-1, 0}), kFriction));
  const int columns = static_cast<int>(2 * half / apart);
  for (int i = 0; i < kCount; ++i) {
    const Vec2 at{-half + apart * (0.5 + i % columns) + 0.05 * (i / columns % 2),
                  0.8 + apart * (i / columns)};
    if (kBoxes)
      add_box(world, bodies, at, 0.5 + 0.5 * unit(random), 0.5 + 0.5 * unit(random),
              0.6 * unit(random) - 0.3);
    else
      bodies.push_back(add(world, at, rough(make_disc(0.35 + 0.15 * unit(random)), kFriction)));
  }
}

/// People, let fall into a pit. Their hinges may rub: by an eighth of what gravity turns a limb by.
template <int kCount, bool kRubs = false>
void add_people(World& world, Bodies& bodies, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  const int columns = static_cast<int>(std::sqrt(kCount));
  const double apart = 2.2, half = 0.5 * apart * columns + 0.5;
  const BodyId sides = world.create_body({.type = BodyType::Static});
  world.add_shape(sides, rough(make_half_plane({-half, 0}, {1, 0}), kFriction));
  world.add_shape(sides, rough(make_half_plane({half, 0}, {-1, 0}), kFriction));
  for (int i = 0; i < kCount; ++i) {
    const Vec2 at{apart * (i % columns + 0.5 - 0.5 * columns) + noise(random), 2 + 2.8 * (i / columns)};
    const test::Ragdoll one = test::add_ragdoll(world, at, {0, 0}, kFriction);
    bodies.insert(bodies.end(), one.limbs.begin(), one.limbs.end());
    for (const test::Hinge& hinge : one.hinges)
      if (kRubs) world.set_motor(hinge.joint, 0, 0.02);
  }
}

const Pile kPiles[] = {
    {"wall of 900", 0, add_wall<30>},
    {"wall of 3600", 0, add_wall<60>},
    {"30 columns of 30", 0, add_columns},
    {"pyramid of 60", 0, [](World& world, Bodies& bodies, std::uint64_t) { add_pyramid(world, bodies, 60); }},
    {"planks on blocks", 0, add_planks},
    {"300 discs", 900, add_heap<300, false>},
    {"1000 discs", 900, add_heap<1000, false>},
    {"200 boxes", 900, add_heap<200, true>},
};

void touch(const Pile& pile, int seeds) {
  constexpr int kSteps = 60, kPushed = 50;
  std::vector<double> seconds;
  double residual = 0;
  int factors = 0, solves = 0, inexact = 0;
  for (int seed = 1; seed <= (pile.steps > 0 ? seeds : 1); ++seed) {
    WorldConfig config;
    config.sleep = false;
    World world(config);
    add_ground(world, rough(make_box({1, 1}), kFriction));
    Bodies bodies;
    pile.add_to(world, bodies, static_cast<std::uint64_t>(seed));
    // What stands is solved for, from nothing, in the first step.
    for (int k = 0; k < std::max(1, pile.steps); ++k) world.step(1.0 / 60);
    for (int step = 0; step < kSteps; ++step) {
      const double push = 0.001 * (1 + step % 7) * (step / 14 % 2 == 0 ? 1 : -1);
      for (std::size_t i = static_cast<std::size_t>(step % 2); i < bodies.size(); i += kPushed)
        world.apply_impulse(bodies[i], {push, 0}, world.position(bodies[i]));
      const double begin = bench::thread_seconds();
      const StepReport& report = world.step(1.0 / 60);
      seconds.push_back(bench::thread_seconds() - begin);
      factors += report.work.factorisations;
      solves += report.work.resolves;
      residual = std::max(residual, report.worst_residual);
      inexact += report.inexact_islands > 0;
    }
  }
  std::sort(seconds.begin(), seconds.end());
  const auto steps = static_cast<double>(seconds.size());
  std::printf("%-20s %6.0f %8.2f %8.2f %8.2f %8.2f %8.2f %9.1e %8d\n", pile.name, steps,
              1e3 * std::accumulate(seconds.begin(), seconds.end(), 0.0) / steps,
              1e3 * seconds[seconds.size() / 2], 1e3 * seconds.back(), factors / steps, solves / steps,
              residual, inexact);
  std::fflush(stdout);
}

const Pile kHeaps[] = {
    {"200 boxes", 0, add_heap<200, true>},      {"600 boxes", 0, add_heap<600, true>},
    {"1000 boxes", 0, add_heap<1000, true>},    {"3000 boxes", 0, add_heap<3000, true>},
    {"300 discs", 0, add_heap<300, false>},     {"1000 discs", 0, add_heap<1000, false>},
    {"20 people", 0, add_people<20>},           {"80 people", 0, add_people<80>},
    {"20 that rub", 0, add_people<20, true>},   {"80 that rub", 0, add_people<80, true>},
    {"20 slow", 0, add_people<20, true>, 0.05}, {"80 slow", 0, add_people<80, true>, 0.05},
};

void wait_for_rest(const Pile& pile, int seeds) {
  constexpr int kSteps = 1800;
  std::vector<int> steps;
  double seconds = 0, slowest = 0;
  int made = 0, exact = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    WorldConfig config;
    config.sleep_speed = pile.sleep_speed;
    World world(config);
    add_ground(world, rough(make_box({1, 1}), kFriction));
    Bodies bodies;
    pile.add_to(world, bodies, static_cast<std::uint64_t>(seed));
    for (int step = 1; step <= kSteps; ++step) {
      const double begin = bench::thread_seconds();
      world.step(1.0 / 60);
      const double took = bench::thread_seconds() - begin;
      seconds += took;
      slowest = std::max(slowest, took);
      ++made;
      const std::vector<std::uint8_t>& asleep = world.bodies().asleep;
      if (100 * std::count(asleep.begin(), asleep.end(), 1) < 97 * static_cast<std::ptrdiff_t>(bodies.size()))
        continue;
      steps.push_back(step);
      exact += world.report().inexact_islands == 0;
      break;
    }
  }
  std::sort(steps.begin(), steps.end());
  std::printf("%-12s %3zu of %3d %7d %7d %8.2f %8.1f\n", pile.name, steps.size(), seeds, exact,
              steps.empty() ? 0 : steps[steps.size() / 2], 1e3 * seconds / made, 1e3 * slowest);
  std::fflush(stdout);
}

struct Scene {
  const char* name;
  int first, steps;  // steps before the measuring ones, which it takes to get busy
  std::function<World(double)> make;
};
World people(double flow_work) {
  World world = empty(flow_work);
  add_ground(world, rough(make_box({1, 1}), kFriction));
  Bodies limbs;
  add_people<40>(world, limbs, 1);
  return world;
}

const Scene kScenes[] = {
    {"200 boxes dropped", 30, 120, [](double l) { return boxes(200, l); }},
    {"300 discs dropped", 30, 120, [](double l) { return discs(300, l); }},
    {"1000 boxes dropped", 40, 60, [](double l) { return boxes(1000, l); }},
    {"3000 discs dropped", 60, 30, [](double l) { return discs(3000, l); }},
    {"40 people dropped", 60, 60, people},
    {"pyramid 20 struck", kBeforeBlow, 60, [](double l) { return struck_pyramid(20, l); }},
    {"pyramid 50 struck", kBeforeBlow, 20, [](double l) { return struck_pyramid(50, l); }},
    {"pyramid 100 struck", kBeforeBlow, 8, [](double l) { return struck_pyramid(100, l); }},
};

/// Work and what it takes: median of the steps, by body [us].
struct Price {
  double work, us;
};

Price measure(const Scene& scene, double flow_work, int steps, bool csv) {
  World world = scene.make(flow_work);
  world.observe({.stage_times = true});
  for (int k = 0; k < scene.first; ++k) world.step(1.0 / 60);
  std::vector<double> residuals, seconds;
  double visits = 0, deepest = 0;
  for (int k = 0; k < steps; ++k) {
    const double begin = bench::thread_seconds();
    const StepReport& report = world.step(1.0 / 60);
    seconds.push_back(bench::thread_seconds() - begin);
    residuals.push_back(report.worst_residual);
    visits = std::max(visits, report.work.visits);
    deepest = std::max(deepest, report.worst_penetration);
  }
  const auto exact = std::count_if(residuals.begin(), residuals.end(), [](double r) { return r <= 1e-8; });
  const auto close = std::count_if(residuals.begin(), residuals.end(), [](double r) { return r <= 1e-4; });
  std::sort(residuals.begin(), residuals.end());
  std::sort(seconds.begin(), seconds.end());
  const std::size_t half = residuals.size() / 2;
  std::printf(csv ? "\"%s\",%g,%d,%.4g,%.4g,%.3g,%.3g,%.4g,%.4g,%.3g,%.3g\n"
                  : "%-20s %7g %5d  %6.1f %6.1f  %9.1e %9.1e  %8.2f %8.2f  %9.2e %9.1e\n",
              scene.name, flow_work, steps, 100.0 * static_cast<double>(exact) / steps,
              100.0 * static_cast<double>(close) / steps, residuals[half], residuals.back(),
              1e3 * seconds[half], 1e3 * seconds.back(), visits, deepest);
  std::fflush(stdout);
  return {flow_work, 1e6 * seconds[half] / static_cast<double>(world.bodies().position.size())};
}

/// The work that takes `us` microseconds a body, if the time grows evenly with it; 0 where most steps rest.
double work_for(double us, const std::vector<Price>& prices) {
  const Price low = prices.front(), high = prices.back();
  if (!(high.us > low.us && high.us > 0.1 * us)) return 0;
  const double work = low.work + (us - low.us) * (high.work - low.work) / (high.us - low.us);
  return std::round(std::clamp(work, 100.0, 20000.0));
}

constexpr const char* kUsage =
    R"(usage: solver_flow_bench [--csv] [--steps N] [--work N]... [--us T] [FILTER]

Scenes in which hundreds of contacts change a step, with unlimited work (0: exact in pieces) and with so many
row visits for each body; at last with as many as a step of so many microseconds a body in the world allows
(4 unless told, 0: not), which the steps before tell. One line a scene and amount: the share of steps whose
every solve reached 1e-8 and 1e-4, the residuals, the time of the whole step, the largest work, and the
deepest penetration. Friction 0.5, 1/60 s. Or, with none of these options:

  --balls N             throws a ball at each of N pyramids at rest, none of which sleeps, with the usual
                        budget: time of 100 steps, the slowest one, and how many were not exact
  --touched N [FILTER]  pushes one body in 50 of piles at rest by a few mm/s at every step, N piles of those
                        that are random: means over 60 steps of the time, of factors and of solves, the
                        slowest step, the largest residual, and how many steps were not exact
  --resting N [FILTER]  drops N heaps of each kind and waits, up to half a minute of theirs, until 97 in 100
                        of the bodies are asleep: how many of the heaps are, after how many steps (median, of
                        those), the mean time of a step until then, and the slowest one. People "that rub"
                        have friction in their hinges, and "slow" ones a `sleep_speed` of 0.05 m/s besides
)";

int run(int argc, char** argv) {
  using namespace bench;
  bool csv = false;
  int steps = 0, balls = 0, touched = 0, resting = 0;
  double us = 4;
  const char* filter = "";
  std::vector<double> works;
  std::vector<std::string> given;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.starts_with('-')) given.push_back(word);
    if (word == "--csv")
      csv = true;
    else if (word == "--steps")
      steps = count_of(word, value_of(argc, argv, i), 1);
    else if (word == "--work")
      works.push_back(number_of(word, value_of(argc, argv, i), 0, 1e12));
    else if (word == "--us")
      us = number_of(word, value_of(argc, argv, i), 0, 1e9);
    else if (word == "--balls")
      balls = count_of(word, value_of(argc, argv, i), 1);
    else if (word == "--touched")
      touched = count_of(word, value_of(argc, argv, i), 1);
    else if (word == "--resting")
      resting = count_of(word, value_of(argc, argv, i), 1);
    else if (word.starts_with('-') || *filter != '\0')
      throw BadArgument(word +
                        ": expected --csv, --steps N, --work N, --us T, --balls N, --touched N, --resting N "
                        "or one filter");
    else
      filter = argv[i];
  }
  for (const auto& [option, asked] : {std::pair{"--balls", balls > 0}, std::pair{"--touched", touched > 0},
                                      std::pair{"--resting", resting > 0}})
    if (asked) expect_only(option, given, {});
  if (balls > 0) {
    if (*filter != '\0') throw BadArgument(std::string("--balls takes no filter, got '") + filter + "'");
    std::printf("%5s %5s %11s %16s %9s %8s %7s\n", "ball", "base", "mass", "velocity", "ms in all", "slowest",
                "inexact");
    double sum = 0;
    for (int number = 1; number <= balls; ++number) sum += throw_ball(number);
    std::printf("all: %.0f ms\n", 1e3 * sum);
    return 0;
  }
  if (touched > 0) {
    expect_part("pile", filter, names_of(kPiles));
    std::printf("%-20s %6s %8s %8s %8s %8s %8s %9s %8s\n", "pile", "steps", "mean ms", "median", "slowest",
                "factors", "solves", "residual", "inexact");
    for (const Pile& pile : kPiles)
      if (std::strstr(pile.name, filter) != nullptr) touch(pile, touched);
    return 0;
  }
  if (resting > 0) {
    expect_part("heap", filter, names_of(kHeaps));
    std::printf("%-12s %10s %7s %7s %8s %8s\n", "heap", "asleep", "exactly", "steps", "mean ms", "slowest");
    for (const Pile& heap : kHeaps)
      if (std::strstr(heap.name, filter) != nullptr) wait_for_rest(heap, resting);
    return 0;
  }
  expect_part("scene", filter, names_of(kScenes));
  if (works.empty()) works = {0, 400, 4000};
  if (csv)
    std::printf(
        "scene,work,steps,exact,close,median_residual,worst_residual,median_ms,worst_ms,visits,"
        "penetration\n");
  else
    std::printf("%-20s %7s %5s  %6s %6s  %9s %9s  %8s %8s  %9s %9s\n", "scene", "work", "steps", "% 1e-8",
                "% 1e-4", "median", "worst", "ms step", "worst", "visits", "deepest");
  for (const Scene& scene : kScenes) {
    if (std::strstr(scene.name, filter) == nullptr) continue;
    const int measured = steps > 0 ? steps : scene.steps;
    std::vector<Price> prices;
    for (const double flow_work : works) {
      const Price price = measure(scene, flow_work, measured, csv);
      if (flow_work > 0) prices.push_back(price);
    }
    const double work = us > 0 && prices.size() > 1 ? work_for(us, prices) : 0;
    if (work > 0) measure(scene, work, measured, csv);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::run_with_arguments("solver_flow_bench", kUsage, argc, argv, run);
}
