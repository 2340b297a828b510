// SPDX-License-Identifier: MIT
//
// What should stand: stacks, mass ratios, pyramids; and where standing ends: overhang and arch.
#include <cmath>

#include "tests/bench/accuracy/problem.h"

namespace skerry::bench {
namespace {

Problem standing(std::string name, std::string title, const Scene& scene, double seconds) {
  Problem problem;
  problem.name = std::move(name);
  problem.title = std::move(title);
  problem.measure = "largest displacement after " + std::to_string(static_cast<int>(seconds)) + " s [m]";
  problem.source = "it is in equilibrium: nothing moves";
  problem.run = [=](const Trial& trial) {
    Outcome outcome;
    const bool good = simulate(trial, scene, seconds, outcome, [&](Engine& engine, double) {
      outcome.error = displacement(scene, engine);
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

/// Ten planks of 2 m x 0.2 m over the edge of a table; `factor` of the harmonic limit.
Scene overhang(double factor) {
  const int count = 10;
  Scene scene;
  scene.add({.shape = box(20, 2), .fixed = true, .position = {-10, -1}});
  double x = -1;
  for (int k = count; k >= 1; --k) {
    x += factor / k;
    scene.add({.shape = box(2, 0.2), .position = {x, 0.1 + 0.2 * (count - k)}});
  }
  return scene;
}

/// Half a ring of straight-edged blocks of mean radius 10 m.
Scene arch(double thickness) {
  const int count = 15;
  const double radius = 10, inner = radius * (1 - thickness / 2), outer = radius * (1 + thickness / 2);
  Scene scene;
  scene.friction = 1;
  scene.add(ground());
  for (int i = 0; i < count; ++i) {
    const Vec2 from = rotate(Rot::from_angle(kPi * i / count), {1, 0});
    const Vec2 to = rotate(Rot::from_angle(kPi * (i + 1) / count), {1, 0});
    std::vector<Vec2> corners = {inner * from, outer * from, outer * to, inner * to};
    double area = 0;
    Vec2 centre;
    for (std::size_t k = 0; k < 4; ++k) {
      const double part = cross(corners[k], corners[(k + 1) % 4]);
      area += part / 2;
      centre += part / 6 * (corners[k] + corners[(k + 1) % 4]);
    }
    centre = centre / area;
    for (Vec2& corner : corners) corner = corner - centre;
    scene.add({.shape = polygon(corners), .position = centre, .mass = area});
  }
  return scene;
}

// What is so much lower than it began has fallen, whatever skins, slops and soft contacts let it sag [m].
constexpr double kFall = 0.5;

bool has_fallen(const Scene& scene, const Engine& engine) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (!body.fixed && engine.state(static_cast<int>(i)).position.y < body.position.y - kFall) return true;
  }
  return false;
}

/// Looks for the parameter at which a family of scenes begins, or ceases, to stand. Where all of them stand,
/// or none, it is not found: an infinite error.
template <class Family>
Outcome bisect(const Trial& trial, Family family, double low, double high, int halvings, double seconds,
               bool high_stands, double exact) {
  Outcome outcome;
  bool some_stand = false, some_fall = false;
  for (int k = 0; k < halvings; ++k) {
    const double middle = 0.5 * (low + high);
    const Scene scene = family(middle);
    bool stands = true;
    const bool good = simulate(trial, scene, seconds, outcome, [&](Engine& engine, double) {
      stands = !has_fallen(scene, engine);
      return stands;
    });
    if (outcome.gave_up) break;
    stands = stands && good;
    (stands ? some_stand : some_fall) = true;
    (stands == high_stands ? high : low) = middle;
  }
  const bool found = !outcome.gave_up && some_stand && some_fall;
  outcome.error = found ? std::abs(0.5 * (low + high) - exact) / exact : kInfinity;
  return outcome;
}

std::vector<Problem> limits() {
  Problem topples;
  topples.name = "overhang_102";
  topples.title = "Ten planks at 1.02 of the harmonic overhang";
  topples.measure = "0: a plank is 0.5 m lower after 5 s, as it should; 1: none is";
  topples.source = "offsets (half length)/k are the limit";
  topples.run = [](const Trial& trial) {
    const Scene scene = overhang(1.02);
    Outcome outcome;
    const bool good = simulate(trial, scene, 5, outcome, [&](Engine& engine, double) {
      outcome.error = has_fallen(scene, engine) ? 0 : 1;
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  Problem limit;
  limit.name = "overhang_limit";
  limit.title = "Overhang at which ten planks topple (bisection)";
  limit.measure = "relative error of the limit (resolved to 2e-4)";
  limit.source = "offsets (half length)/k are the limit";
  limit.run = [](const Trial& trial) { return bisect(trial, overhang, 0.8, 1.1, 10, 5, false, 1); };
  Problem arch_limit;
  arch_limit.name = "arch_limit";
  arch_limit.title = "Thickness at which a semicircular arch of 15 blocks stands (bisection)";
  arch_limit.measure = "relative error of the least t/R (resolved to 1e-3)";
  arch_limit.source = "Milankovitch 1907; Makris & Alexakis 2013: t/R = 0.106068 for 15 straight blocks";
  arch_limit.polygons = true;
  arch_limit.run = [](const Trial& trial) { return bisect(trial, arch, 0.08, 0.16, 10, 8, true, 0.106068); };
  return {standing("overhang_098", "Ten planks at 0.98 of the harmonic overhang", overhang(0.98), 5), topples,
          limit, arch_limit};
}

}  // namespace

Scene stack_scene(int count) {
  Scene scene;
  scene.add(ground());
  for (int i = 0; i < count; ++i) scene.add({.shape = box(1, 1), .position = {0, i + 0.5}});
  return scene;
}

Scene heavy_scene(int light, double ratio) {
  Scene scene = stack_scene(light + 1);
  scene.bodies.back().mass = ratio;
  return scene;
}

Scene pyramid_scene(int base) {
  Scene scene;
  scene.add(ground());
  for (int row = 0; row < base; ++row) {
    for (int i = 0; i < base - row; ++i)
      scene.add({.shape = box(1, 1), .position = {i + 0.5 * row - 0.5 * base, row + 0.5}});
  }
  return scene;
}

std::vector<Problem> rest_problems() {
  std::vector<Problem> list;
  for (const int count : {10, 30, 100}) {
    const std::string n = std::to_string(count);
    list.push_back(standing("stack_" + n, "Stack of " + n + " boxes", stack_scene(count), 5));
  }
  for (const int light : {1, 10}) {
    for (const int power : {2, 3, 6}) {
      const std::string ratio = "1e" + std::to_string(power);
      list.push_back(standing("heavy_" + ratio + "_on_" + std::to_string(light),
                              "Box of " + ratio + " kg on " + std::to_string(light) + " of 1 kg",
                              heavy_scene(light, std::pow(10, power)), 5));
    }
  }
  list.push_back(standing("pyramid_20", "Pyramid with a base of 20 boxes", pyramid_scene(20), 4));
  list.push_back(standing("pyramid_50", "Pyramid with a base of 50 boxes", pyramid_scene(50), 2));
  list.push_back(standing("pyramid_100", "Pyramid with a base of 100 boxes", pyramid_scene(100), 1));
  list[list.size() - 2].large = list.back().large = true;
  for (Problem& problem : limits()) list.push_back(std::move(problem));
  return list;
}

}  // namespace skerry::bench
