// SPDX-License-Identifier: MIT
//
// Where the envelope ends: one parameter at a time goes to its extremes, and each run is judged.
#include <cmath>
#include <cstdio>
#include <map>
#include <random>

#include "tests/bench/accuracy/options.h"
#include "tests/bench/accuracy/problem.h"

namespace skerry::bench {
namespace {

// A step that takes longer than a frame is too slow [s].
constexpr double kRealTime = 1.0 / 60;
// Processor time of one check [s].
constexpr double kLimit = 0.4;

/// One point of an axis: a scene, and how far it is from what is right.
struct Check {
  std::string axis;
  double value = 0;
  Scene scene;
  double seconds = 2;
  double dt = 1.0 / 60;
  bool at_rest = true;  ///< it should stand still: speeds at the end are jitter
  /// Distance from the right answer, relative to the size of the bodies. Default: displacement over size.
  std::function<double(const Engine&, double)> error{};
  std::function<void(Engine&, int)> disturb{};  ///< before each step
  bool open = false;  ///< no known answer: NaN, energy and the walls are judged only
};

double size_of(const SceneBody& body) {
  return body.shape.form == Form::Box ? std::min(body.shape.size.x, body.shape.size.y)
                                      : 2 * body.shape.radius;
}

double relative_displacement(const Scene& scene, const Engine& engine) {
  double worst = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.fixed) continue;
    worst =
        std::max(worst, length(engine.state(static_cast<int>(i)).position - body.position) / size_of(body));
  }
  return worst;
}

struct Energy {
  double total = 0, kinetic = 0, speed = 0;
  bool finite = true;
};

/// Potential energy counts from where the bodies began.
Energy energy_of(const Scene& scene, const Engine& engine) {
  Energy energy;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.fixed) continue;
    const BodyState s = engine.state(static_cast<int>(i));
    energy.finite = energy.finite && is_finite(s.position) && is_finite(s.velocity) && std::isfinite(s.omega);
    energy.kinetic +=
        0.5 * body.mass * length_squared(s.velocity) + 0.5 * inertia_of(body) * s.omega * s.omega;
    energy.total -= body.mass * dot(scene.gravity, s.position - body.position);
    energy.speed = std::max(energy.speed, length(s.velocity));
  }
  energy.total += energy.kinetic;
  return energy;
}

/// To the left and to the right, so high that no body that bounces between them gets over.
std::vector<SceneBody> walls() {
  std::vector<SceneBody> both = {ground(-kPi / 2, {-8, 0}), ground(kPi / 2, {8, 0})};
  for (SceneBody& wall : both) wall.shape.extent = 2000;
  return both;
}

std::vector<Check> checks() {
  std::vector<Check> list;
  for (int power = 0; power <= 9; ++power)
    list.push_back(
        {.axis = "mass ratio", .value = std::pow(10, power), .scene = heavy_scene(2, std::pow(10, power))});
  for (int power = 0; power <= 6; ++power) {
    const double size = std::pow(10, power);
    Scene scene;
    SceneBody floor = ground();
    floor.shape.extent = std::max(200.0, 4 * size);
    scene.add(floor);
    scene.add({.shape = box(size, size), .position = {0, size / 2}, .mass = size * size});
    scene.add({.shape = box(1, 1), .position = {0, size + 0.5}});
    list.push_back({.axis = "size ratio", .value = size, .scene = scene});
  }
  for (const int height : {10, 20, 50, 100, 200, 500, 1000})
    list.push_back(
        {.axis = "stack height", .value = double(height), .scene = stack_scene(height), .seconds = 1});
  for (const double mu : {0.0, 0.1, 0.3, 0.5, 0.6, 1.0, 3.0, 10.0}) {
    const double slope = kPi / 6;
    Scene scene;
    scene.friction = mu;
    scene.add(ground(-slope));
    scene.add({.shape = box(1, 1), .position = rotate(Rot::from_angle(-slope), {0, 0.5}), .angle = -slope});
    const double acceleration = std::max(0.0, 10 * (std::sin(slope) - mu * std::cos(slope)));
    list.push_back(
        {.axis = "friction",
         .value = mu,
         .scene = scene,
         .seconds = 1,
         .at_rest = acceleration == 0,
         .error = [=](const Engine& engine, double t) {
           const Vec2 way = engine.state(1).position - scene.bodies[1].position;
           const Vec2 exact = 0.5 * acceleration * t * t * rotate(Rot::from_angle(-slope), Vec2{1, 0});
           return length(way - exact);
         }});
  }
  for (const double e : {0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0}) {
    Scene scene;
    scene.friction = 0;
    scene.restitution = e;
    scene.add(ground());
    scene.add({.shape = disc(0.5), .position = {0, 1.5}});
    list.push_back({.axis = "restitution",
                    .value = e,
                    .scene = scene,
                    .seconds = 1.2,
                    .at_rest = false,
                    .error = [=](const Engine& engine, double t) {
                      // Flight by flight; after a thousand bounces it lies.
                      double begin = 0, speed = 0, height = 1;
                      for (int k = 0; k < 1000; ++k) {
                        const double flight = k == 0 ? std::sqrt(0.2) : 2 * speed / 10;
                        if (t < begin + flight) {
                          const double s = t - begin;
                          return std::abs(engine.state(1).position.y - 0.5 -
                                          (k == 0 ? height - 5 * s * s : speed * s - 5 * s * s));
                        }
                        begin += flight;
                        speed = e * (k == 0 ? std::sqrt(20.0) : speed);
                      }
                      return std::abs(engine.state(1).position.y - 0.5);
                    }});
  }
  for (const int rate : {15, 30, 60, 120, 240, 500, 1000})
    list.push_back(
        {.axis = "steps a second", .value = double(rate), .scene = pyramid_scene(5), .dt = 1.0 / rate});
  for (int power = 0; power <= 7; ++power) {
    Scene scene = stack_scene(5);
    const double far = power == 0 ? 0 : std::pow(10, power);
    for (SceneBody& body : scene.bodies) body.position.x += far;
    list.push_back({.axis = "distance from the origin", .value = far, .scene = scene});
  }
  for (const int pillars : {2, 3, 5, 10, 20, 50}) {
    Scene scene;
    for (int i = 0; i < pillars; ++i)
      scene.add({.shape = box(0.1, 1), .fixed = true, .position = {10.0 * i / (pillars - 1) - 5, -0.5}});
    scene.add({.shape = box(10.2, 0.2), .position = {0, 0.1}});
    scene.add({.shape = box(10.2, 0.2), .position = {0, 0.3}});
    list.push_back({.axis = "supports of a plank", .value = double(pillars), .scene = scene});
  }
  for (const double speed : {0.01, 0.1, 1.0, 10.0, 100.0}) {
    Scene scene = pyramid_scene(5);
    for (const SceneBody& wall : walls()) scene.add(wall);
    auto random = std::make_shared<std::mt19937>(3);
    list.push_back({.axis = "random shocks",
                    .value = speed,
                    .scene = scene,
                    .seconds = 3,
                    .disturb =
                        [=](Engine& engine, int step) {
                          if (step == 0) random->seed(3);
                          if (step > 60 || step % 4 != 0) return;
                          const int body = 1 + static_cast<int>((*random)() % 15);
                          const double angle = (*random)() / 4294967296.0 * 2 * kPi;
                          engine.push(body, speed * Vec2{std::cos(angle), std::sin(angle)});
                        },
                    .open = true});
  }
  for (int seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (random() / 4294967296.0);
    };
    Scene scene;
    scene.friction = uniform(0, 2);
    scene.restitution = uniform(0, 1);
    scene.add(ground());
    for (const SceneBody& wall : walls()) scene.add(wall);
    for (int i = 0; i < 30; ++i) {
      const bool round = random() % 2 == 0;
      const double size = uniform(0.2, 1.2);
      SceneBody body{.shape = round ? disc(size / 2) : box(size, uniform(0.3, 1) * size),
                     .position = {-6.0 + 2.4 * (i % 6), 1 + 1.8 * (i / 6)},
                     .angle = uniform(0, 6),
                     .velocity = {uniform(-8, 8), uniform(-8, 8)},
                     .omega = uniform(-5, 5)};
      body.mass = std::pow(10, uniform(-2, 2));
      scene.add(body);
    }
    list.push_back(
        {.axis = "random worlds", .value = double(seed), .scene = scene, .seconds = 3, .open = true});
  }
  return list;
}

/// Runs one check; returns the row of the table.
std::string judge(const Check& check, const EngineEntry& entry, Setting setting, double& step_seconds) {
  setting.dt = check.dt;
  const auto engine = entry.make(check.scene, setting);
  double scale = 0;
  for (const SceneBody& body : check.scene.bodies) {
    if (!body.fixed) scale += body.mass * (10 * size_of(body) + 0.5 * length_squared(body.velocity));
  }
  const int steps = static_cast<int>(std::lround(check.seconds / check.dt));
  double reference = energy_of(check.scene, *engine).total, gained = 0, jitter = 0, spent = 0;
  bool finite = true, escaped = false;
  int done = 0;
  while (done < steps && finite && spent < kLimit) {
    if (check.disturb) {
      check.disturb(*engine, done);
      reference = std::max(reference, energy_of(check.scene, *engine).total);
    }
    const double start = thread_seconds();
    engine->step();
    spent += thread_seconds() - start;
    ++done;
    const Energy now = energy_of(check.scene, *engine);
    finite = now.finite;
    gained = std::max(gained, (now.total - reference) / scale);
    if (done > 0.8 * steps) jitter = std::max(jitter, now.speed);
  }
  if (check.open) {
    for (std::size_t i = 0; i < check.scene.bodies.size() && finite; ++i) {
      if (check.scene.bodies[i].fixed) continue;
      const Vec2 p = engine->state(static_cast<int>(i)).position;
      escaped = escaped || std::abs(p.x) > 8 || p.y < 0;
    }
  }
  step_seconds = spent / done;
  double error = 0;
  if (finite && !check.open) {
    error = check.error ? check.error(*engine, done * check.dt) : relative_displacement(check.scene, *engine);
  }
  const char* verdict = "exact";
  if (!finite) {
    verdict = "not a number";
  } else if (gained > 0.1) {
    verdict = "explodes";
  } else if (done < steps || spent > kRealTime * done) {
    verdict = "too slow";
  } else if (escaped) {
    verdict = "tunnels";
  } else if (error > 0.1) {
    verdict = "fails";
  } else if (error > 1e-3) {
    verdict = "drifts";
  } else if (check.at_rest && !check.open && jitter > 1e-2) {
    verdict = "jitters";
  } else if (check.open || error > 1e-8) {
    verdict = "good";
  }
  return joined({check.axis, number(check.value), entry.name, entry.version, setting.label, number(error),
                 number(gained), number(jitter), number(1e6 * spent / done), verdict});
}

}  // namespace

std::vector<std::string> stress_scenes() {
  std::vector<std::string> names;
  for (const Check& check : checks())
    if (names.empty() || names.back() != check.axis) names.push_back(check.axis);
  return names;
}

void run_stress(const Options& options) {
  std::vector<std::string> rows, axes;
  // Stacks: what was too slow once, or would be for one step if it grew as a dense factorisation does, is not
  // asked for more.
  struct Cost {
    double height = 1, step = 0;
    bool slow = false;
  };
  std::map<std::string, Cost> costs;
  for (const Check& check : checks()) {
    if (!options.wants_scene(check.axis)) continue;
    axes.push_back(check.axis);
    const bool stack = check.axis == "stack height";
    for (const EngineEntry& engine : engines()) {
      if (!options.wants_engine(engine.name)) continue;
      for (const Setting& curve : engine.curves) {
        if (curve.solver == "nncg" || curve.solver == "tgs_soft") continue;
        Cost& cost = costs[engine.name + curve.label];
        if (stack) cost.slow = cost.slow || cost.step * std::pow(check.value / cost.height, 3) > kLimit;
        if (stack && cost.slow) {
          rows.push_back(joined({check.axis, number(check.value), engine.name, engine.version, curve.label,
                                 "", "", "", "", "too slow"}));
          continue;
        }
        double step = 0;
        rows.push_back(judge(check, engine, curve, step));
        if (stack) cost = {check.value, step, rows.back().ends_with("too slow")};
      }
    }
    std::fprintf(stderr, "%s %g\n", check.axis.c_str(), check.value);
    // After each point: what is interrupted keeps what it has.
    merge_csv(options, "stress.csv",
              "axis,value,engine,version,curve,error,energy_gain,jitter,us_per_step,verdict", axes, rows);
  }
}

}  // namespace skerry::bench
