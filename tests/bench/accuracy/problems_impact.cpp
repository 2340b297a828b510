// SPDX-License-Identifier: MIT
//
// Impacts: cradles, bouncing balls, an elastic gas.
#include <cmath>
#include <limits>
#include <random>

#include "tests/bench/accuracy/problem.h"

namespace skerry::bench {
namespace {

/// `count` free discs in a row, the first at 2 m/s and `gap` before the others.
Scene cradle(int count, double gap) {
  Scene scene;
  scene.gravity = {};
  scene.friction = 0;
  scene.restitution = 1;
  for (int i = 0; i < count; ++i) {
    SceneBody body{.shape = disc(0.5), .position = {static_cast<double>(i), 0}};
    if (i == 0) {
      body.position.x = -gap;
      body.velocity = {2, 0};
    }
    scene.add(body);
  }
  return scene;
}

Problem cradle_problem(int count, double gap) {
  Problem problem;
  problem.name = "cradle_" + std::to_string(count) + (gap > 0 ? "_gap" : "");
  problem.title =
      "Cradle of " + std::to_string(count) + " free discs" + (gap > 0 ? ", the first in flight" : "");
  problem.measure = "largest velocity error / incoming speed";
  problem.source = "equal masses, e = 1: one in, one out, the rest still";
  problem.run = [=](const Trial& trial) {
    const Scene scene = cradle(count, gap);
    Outcome outcome;
    const bool good = simulate(trial, scene, 0.5, outcome, [&](Engine& engine, double) {
      double worst = 0;
      for (int i = 0; i < count; ++i) {
        const Vec2 exact{i == count - 1 ? 2.0 : 0.0, 0};
        worst = std::max(worst, length(engine.state(i).velocity - exact));
      }
      outcome.error = worst / 2;
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

/// The height of the flight after so many bounces: the top of the parabola through three states.
Problem bounce_problem(double e, int bounces) {
  Problem problem;
  problem.name = e == 1 ? "bounce_elastic" : "bounce_08";
  problem.title = "Ball, e = " + std::string(e == 1 ? "1, " : "0.8, ") + std::to_string(bounces) + " bounces";
  problem.measure = "relative error of the height after the last bounce";
  problem.source = "h_n = e^(2n) h";
  problem.run = [=](const Trial& trial) {
    Scene scene;
    scene.friction = 0;
    scene.restitution = e;
    scene.add(ground());
    const double drop = 1;
    const int ball = scene.add({.shape = disc(0.5), .position = {0, 0.5 + drop}});
    Outcome outcome;
    double last_speed = 0, y0 = 0, y1 = 0;
    int count = 0, flying = 0;
    const double exact = std::pow(e, 2 * bounces) * drop;
    // A ball that lies on the ground, or has left, has no such flight.
    outcome.error = 1;
    // Twice the time that so many elastic bounces take.
    const double seconds = 2 * (2 * bounces + 1) * std::sqrt(2 * drop / 10);
    const bool good = simulate(trial, scene, seconds, outcome, [&](Engine& engine, double) {
      const BodyState state = engine.state(ball);
      const double y2 = state.position.y - 0.5;
      count += last_speed < -1e-3 && state.velocity.y > 0;
      last_speed = state.velocity.y;
      if (count >= bounces && ++flying >= 3 && y1 >= y2) {
        const double slope = 0.5 * (y2 - y0), bend = y2 - 2 * y1 + y0;
        const double height = bend < 0 ? y1 - slope * slope / (2 * bend) : y1;
        outcome.error = std::abs(height - exact) / exact;
        return false;
      }
      y0 = y1;
      y1 = y2;
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

Problem gas_problem() {
  Problem problem;
  problem.name = "gas";
  problem.title = "Gas of 300 elastic discs, 5 s";
  problem.measure = "relative error of the kinetic energy";
  problem.source = "smooth elastic discs keep their energy";
  problem.run = [](const Trial& trial) {
    const Scene scene = gas_scene(300, 0.3, 5);
    const auto energy = [&](const Engine* engine) {
      double sum = 0;
      for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].fixed) continue;
        const BodyState s = engine != nullptr ? engine->state(static_cast<int>(i))
                                              : BodyState{.velocity = scene.bodies[i].velocity, .omega = 0};
        sum += 0.5 * length_squared(s.velocity) + 0.5 * inertia_of(scene.bodies[i]) * s.omega * s.omega;
      }
      return sum;
    };
    const double before = energy(nullptr);
    Outcome outcome;
    const bool good = simulate(trial, scene, 5, outcome, [&](Engine& engine, double t) {
      if (t > 4.9) outcome.error = std::abs(energy(&engine) / before - 1);
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

}  // namespace

Scene gas_scene(int discs, double share, double speed) {
  Scene scene;
  scene.gravity = {};
  scene.friction = 0;
  scene.restitution = 1;
  const int side = static_cast<int>(std::ceil(std::sqrt(discs)));
  const double width = std::sqrt(kPi * 0.25 * discs / share);
  for (int k = 0; k < 4; ++k) {
    const double angle = k * kPi / 2;
    SceneBody wall = ground(angle, rotate(Rot::from_angle(angle), {0, -width / 2}));
    wall.shape.extent = 3 * width;
    scene.add(wall);
  }
  std::mt19937 random(7);
  // Sums of uniform numbers: the same on every platform, which std::normal_distribution is not.
  const auto normal = [&] {
    double sum = -6;
    for (int k = 0; k < 12; ++k) sum += static_cast<double>(random()) / 4294967296.0;
    return sum;
  };
  for (int i = 0; i < discs; ++i) {
    const double pitch = width / side;
    scene.add({.shape = disc(0.5),
               .position = {-width / 2 + (i % side + 0.5) * pitch, -width / 2 + (i / side + 0.5) * pitch},
               .velocity = {speed * normal() / std::sqrt(2.0), speed * normal() / std::sqrt(2.0)}});
  }
  return scene;
}

std::vector<Problem> impact_problems() {
  return {cradle_problem(5, 0),   cradle_problem(50, 0),  cradle_problem(5, 0.25),
          bounce_problem(1, 100), bounce_problem(0.8, 5), gas_problem()};
}

}  // namespace skerry::bench
