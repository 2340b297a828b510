// SPDX-License-Identifier: MIT
//
// Islands in flow: scenes in which hundreds of contacts change a step, with unlimited work (0: exact in
// pieces) and with so many row visits for each body; at last with as many as a step of so many microseconds
// a body in the world allows (4 unless told, 0: not), which the steps before tell. One line a scene and
// amount: the share of steps whose every solve reached 1e-8 and 1e-4, the residuals, the time of the whole
// step, the largest work, and the deepest penetration.
//   solver_flow_bench [--csv] [--steps N] [--work N]... [--us T] [FILTER]
// friction 0.5, 1/60 s. And large islands that are disturbed in one place:
//   solver_flow_bench --balls N
// throws a ball at each of N pyramids at rest, none of which sleeps, with the usual budget: time of 100
// steps, the slowest one, and how many were not exact.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <random>

#include "tests/bench/solver_timing.h"
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

// A pyramid at rest, hit from the side by a disc of a hundred times a box's mass.
World struck_pyramid(int base, double flow_work) {
  World world = empty(flow_work);
  const ShapeDef box = rough(make_box({1, 1}), kFriction);
  add_ground(world, box);
  for (int row = 0; row < base; ++row)
    for (int k = 0; k < base - row; ++k) add(world, {1.1 * (k + 0.5 * row), row + 0.5}, box);
  add(world, {-4, 0.3 * base + 2}, rough(make_disc(1.5), kFriction), 100, {15, 0});
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

struct Scene {
  const char* name;
  int first, steps;  // steps before the measuring ones, which it takes to get busy
  std::function<World(double)> make;
};
const Scene kScenes[] = {
    {"200 boxes dropped", 30, 120, [](double l) { return boxes(200, l); }},
    {"300 discs dropped", 30, 120, [](double l) { return discs(300, l); }},
    {"1000 boxes dropped", 40, 60, [](double l) { return boxes(1000, l); }},
    {"3000 discs dropped", 60, 30, [](double l) { return discs(3000, l); }},
    {"pyramid 20 struck", 5, 60, [](double l) { return struck_pyramid(20, l); }},
    {"pyramid 50 struck", 5, 20, [](double l) { return struck_pyramid(50, l); }},
    {"pyramid 100 struck", 5, 8, [](double l) { return struck_pyramid(100, l); }},
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

}  // namespace

int main(int argc, char** argv) {
  bool csv = false;
  int steps = 0, balls = 0;
  double us = 4;
  const char* filter = "";
  std::vector<double> works;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--csv") == 0)
      csv = true;
    else if (std::strcmp(argv[i], "--steps") == 0 && i + 1 < argc)
      steps = std::max(1, std::atoi(argv[++i]));
    else if (std::strcmp(argv[i], "--work") == 0 && i + 1 < argc)
      works.push_back(std::max(0.0, std::atof(argv[++i])));
    else if (std::strcmp(argv[i], "--us") == 0 && i + 1 < argc)
      us = std::max(0.0, std::atof(argv[++i]));
    else if (std::strcmp(argv[i], "--balls") == 0 && i + 1 < argc)
      balls = std::max(0, std::atoi(argv[++i]));
    else
      filter = argv[i];
  }
  if (balls > 0) {
    std::printf("%5s %5s %11s %16s %9s %8s %7s\n", "ball", "base", "mass", "velocity", "ms in all", "slowest",
                "inexact");
    double sum = 0;
    for (int number = 1; number <= balls; ++number) sum += throw_ball(number);
    std::printf("all: %.0f ms\n", 1e3 * sum);
    return 0;
  }
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
}
