// SPDX-License-Identifier: MIT
//
// Sliding, sticking and rolling on an incline; rolling off a cylinder.
#include <cmath>
#include <deque>

#include "tests/bench/accuracy/problem.h"

namespace skerry::bench {
namespace {

constexpr double kSlope = kPi / 6;

/// A body on a slope of 30 degrees, touching it.
Scene incline(const SceneShape& shape, double height, double friction) {
  Scene scene;
  scene.friction = friction;
  scene.add(ground(-kSlope));
  scene.add({.shape = shape, .position = rotate(Rot::from_angle(-kSlope), {0, height}), .angle = -kSlope});
  return scene;
}

/// Way down the slope after 2 s against a t^2 / 2.
Problem way_problem(std::string name, std::string title, std::string source, const SceneShape& shape,
                    double friction, double acceleration) {
  Problem problem;
  problem.name = std::move(name);
  problem.title = std::move(title);
  problem.measure = "relative error of the way after 2 s";
  problem.source = std::move(source);
  problem.run = [=](const Trial& trial) {
    const Scene scene = incline(shape, 0.5, friction);
    const Vec2 down = rotate(Rot::from_angle(-kSlope), {1, 0});
    Outcome outcome;
    const bool good = simulate(trial, scene, 2, outcome, [&](Engine& engine, double t) {
      const double way = dot(engine.state(1).position - scene.bodies[1].position, down);
      const double exact = 0.5 * acceleration * t * t;
      outcome.error = std::abs(way - exact) / exact;
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

Problem stick_problem() {
  Problem problem;
  problem.name = "incline_stick";
  problem.title = "Box that sticks on 30 degrees, mu = 0.6, 10 s";
  problem.measure = "drift [m]";
  problem.source = "sticks iff tan A <= mu";
  problem.run = [](const Trial& trial) {
    const Scene scene = incline(box(1, 1), 0.5, 0.6);
    Outcome outcome;
    const bool good = simulate(trial, scene, 10, outcome, [&](Engine& engine, double) {
      outcome.error = displacement(scene, engine);
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

/// A solid disc of radius 0.5 m leaves a fixed one of 1 m. Where: the engine's own event if it locates one,
/// else the zero of the normal force, which falls linearly with the cosine near it.
Problem roll_off_problem(std::string name, std::string title, std::string source, double friction,
                         double exact) {
  Problem problem;
  problem.name = std::move(name);
  problem.title = std::move(title);
  problem.measure = "error of the cosine of the departure angle";
  problem.source = std::move(source);
  problem.run = [=](const Trial& trial) {
    Scene scene;
    scene.friction = friction;
    scene.add({.shape = disc(1), .fixed = true});
    const Rot q = Rot::from_angle(-0.1);
    scene.add({.shape = disc(0.5), .position = rotate(q, {0, 1.5})});
    struct Sample {
      double cosine, force;
    };
    std::deque<Sample> loaded;
    double last = 0.1, departure = kInfinity;
    const auto angle_of = [](Vec2 p) { return std::atan2(p.x, p.y); };
    Outcome outcome;
    const bool good = simulate(
        trial, scene, 6, outcome,
        [&](Engine& engine, double) {
          const BodyState state = engine.state(1);
          const double angle = angle_of(state.position);
          const double force = engine.normal_force(1);
          if (force > 1e-6) {
            loaded.push_back({std::cos(0.5 * (angle + last)), force});
            if (loaded.size() > 3) loaded.pop_front();
          }
          if (const auto before_end = engine.released()) {
            // Flight since then is known exactly, so it can be followed back.
            const double s = *before_end;
            departure = std::cos(angle_of(state.position - s * state.velocity + 0.5 * s * s * scene.gravity));
          }
          last = angle;
          return length(state.position) < 1.7;
        },
        true);
    if (!std::isfinite(departure) && loaded.size() == 3) {
      // The last one may have been left halfway.
      const Sample x = loaded[0], y = loaded[1];
      const double zero = y.cosine - y.force * (x.cosine - y.cosine) / (x.force - y.force);
      departure = std::abs(zero - y.cosine) < 0.1 ? zero : y.cosine;
    }
    outcome.error = good ? std::abs(departure - exact) : kInfinity;
    return outcome;
  };
  return problem;
}

}  // namespace

std::vector<Problem> motion_problems() {
  const double g = 10, sine = std::sin(kSlope), cosine = std::cos(kSlope);
  return {
      way_problem("incline_slide", "Box sliding down 30 degrees, mu = 0.3", "a = g (sin A - mu cos A)",
                  box(1, 1), 0.3, g * (sine - 0.3 * cosine)),
      way_problem("incline_roll", "Disc rolling down 30 degrees, mu = 0.6",
                  "a = (2/3) g sin A while tan A <= 3 mu", disc(0.5), 0.6, 2 * g * sine / 3),
      stick_problem(),
      roll_off_problem("roll_off_rough", "Disc that rolls, slips and leaves a cylinder, mu = 0.5",
                       "references: y = C e^(2 mu t) + a cos t + b sin t; leaves at 0.936306116500060 rad",
                       0.5, std::cos(0.936306116500060)),
      roll_off_problem("roll_off_smooth", "Disc that slides off a smooth cylinder", "cos t = (2/3) cos t0", 0,
                       2 * std::cos(0.1) / 3),
  };
}

}  // namespace skerry::bench
