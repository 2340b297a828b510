// SPDX-License-Identifier: MIT
//
// Joints: a chain with a heavy end, hanging and swinging; trusses.
#include <algorithm>
#include <cmath>

#include "tests/bench/accuracy/chain_reference.h"
#include "tests/bench/accuracy/problem.h"

namespace skerry::bench {
namespace {

double energy(const Scene& scene, const Engine* engine) {
  double sum = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.fixed) continue;
    BodyState s{.position = body.position, .velocity = body.velocity, .omega = body.omega};
    if (engine != nullptr) s = engine->state(static_cast<int>(i));
    sum += 0.5 * body.mass * length_squared(s.velocity) + 0.5 * inertia_of(body) * s.omega * s.omega -
           body.mass * dot(scene.gravity, s.position);
  }
  return sum;
}

Problem hanging() {
  Problem problem;
  problem.name = "chain_hanging";
  problem.title = "Chain of 100 links of 1 kg with 1000 kg at its end, 5 s";
  problem.measure = "largest displacement [m] (the chain is 50 m long)";
  problem.source = "it hangs straight: nothing moves";
  problem.run = [](const Trial& trial) {
    const Scene scene = chain_scene(100, 1000, false);
    Outcome outcome;
    const bool good = simulate(trial, scene, 5, outcome, [&](Engine& engine, double) {
      outcome.error = displacement(scene, engine);
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

Problem swinging() {
  Problem problem;
  problem.name = "chain_swinging";
  problem.title = "The same chain let go when level, 2 s";
  problem.measure = "energy error / (weight x length), or how far its end is off / length; the larger one";
  problem.source = "frictionless joints keep the energy; Lagrange's equations in the links' angles";
  problem.run = [](const Trial& trial) {
    const Scene scene = chain_scene(100, 1000, true);
    const double before = energy(scene, nullptr);
    static const Vec2 end = swinging_end(scene, 2);
    Outcome outcome;
    const bool good = simulate(trial, scene, 2, outcome, [&](Engine& engine, double) {
      // Energy alone could be kept by a chain that hangs in the air.
      const double off = length(engine.state(static_cast<int>(scene.bodies.size()) - 1).position - end);
      outcome.error = std::max(std::abs(energy(scene, &engine) - before) / (1100 * 10 * 50.0), off / 50);
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

struct Bar {
  int from, to;
};

/// A Warren truss of equilateral triangles: `panels` below, `panels` - 1 above.
std::vector<Vec2> truss_nodes(int panels, std::vector<Bar>& bars) {
  std::vector<Vec2> nodes;
  const double height = std::sqrt(3.0);
  for (int i = 0; i <= panels; ++i) nodes.push_back({2.0 * i, 10});
  for (int i = 0; i < panels; ++i) nodes.push_back({2.0 * i + 1, 10 + height});
  for (int i = 0; i < panels; ++i) {
    const int top = panels + 1 + i;
    bars.push_back({i, i + 1});
    bars.push_back({i, top});
    bars.push_back({top, i + 1});
    if (i + 1 < panels) bars.push_back({top, top + 1});
  }
  return nodes;
}

/// Bars of 1 kg that are pinned to each other at the nodes, 1000 kg in the middle, a hinge at one end and a
/// pendulum support at the other.
Scene pinned_truss() {
  const int panels = 6;
  std::vector<Bar> bars;
  const std::vector<Vec2> nodes = truss_nodes(panels, bars);
  Scene scene;
  std::vector<int> first(nodes.size(), -1);
  const auto pin = [&](int node, int body) {
    const auto n = static_cast<std::size_t>(node);
    if (first[n] < 0) {
      first[n] = body;
    } else {
      scene.joints.push_back({Link::Pin, first[n], body, nodes[n], {}});
    }
  };
  // Shorter than the way between their pins, so that they do not touch each other.
  const auto add_bar = [&](Vec2 a, Vec2 b) {
    const Vec2 way = b - a;
    return scene.add(
        {.shape = box(0.6 * length(way), 0.1), .position = 0.5 * (a + b), .angle = std::atan2(way.y, way.x)});
  };
  for (const Bar& bar : bars) {
    const int body =
        add_bar(nodes[static_cast<std::size_t>(bar.from)], nodes[static_cast<std::size_t>(bar.to)]);
    pin(bar.from, body);
    pin(bar.to, body);
  }
  const Vec2 middle = nodes[panels / 2];
  const int load = scene.add({.shape = box(0.2, 1), .position = {middle.x, middle.y - 1}, .mass = 1000});
  pin(panels / 2, load);
  scene.joints.push_back({Link::Pin, -1, first[0], nodes[0], {}});
  const Vec2 end = nodes[panels];
  const int support = add_bar({end.x, end.y - 2}, end);
  pin(panels, support);
  scene.joints.push_back({Link::Pin, -1, support, {end.x, end.y - 2}, {}});
  return scene;
}

Problem truss() {
  Problem problem;
  problem.name = "truss";
  problem.title = "Truss of 23 pinned bars that carries 1000 times a bar, 5 s";
  problem.measure = "largest displacement [m] (span 12 m)";
  problem.source = "statically determinate and rigid: nothing moves";
  problem.run = [](const Trial& trial) {
    const Scene scene = pinned_truss();
    Outcome outcome;
    const bool good = simulate(trial, scene, 5, outcome, [&](Engine& engine, double) {
      outcome.error = displacement(scene, engine);
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

/// Nodes as small discs of 1 kg (100 kg in the middle), members as massless rods.
Scene rod_truss(std::vector<Vec2>& nodes, std::vector<Bar>& bars) {
  const int panels = 6;
  nodes = truss_nodes(panels, bars);
  Scene scene;
  for (const Vec2 node : nodes) scene.add({.shape = disc(0.05), .position = node});
  scene.bodies[panels / 2].mass = 100;
  for (const Bar& bar : bars)
    scene.joints.push_back({Link::Rod, bar.from, bar.to, nodes[static_cast<std::size_t>(bar.from)],
                            nodes[static_cast<std::size_t>(bar.to)]});
  // A hinge is two rods to the ground, a pendulum support one.
  const auto hold = [&](int node, Vec2 to) {
    scene.joints.push_back({Link::Rod, -1, node, nodes[static_cast<std::size_t>(node)] + to,
                            nodes[static_cast<std::size_t>(node)]});
  };
  hold(0, {-2, 0});
  hold(0, {0, -2});
  hold(panels, {0, -2});
  return scene;
}

Problem rods() {
  Problem problem;
  problem.name = "truss_rods";
  problem.title = "The truss as 13 nodes with massless rods, 5 s";
  problem.measure = "largest displacement [m] (span 12 m)";
  problem.source = "statically determinate and rigid: nothing moves";
  problem.rods = true;
  problem.run = [](const Trial& trial) {
    std::vector<Vec2> nodes;
    std::vector<Bar> bars;
    const Scene scene = rod_truss(nodes, bars);
    Outcome outcome;
    const bool good = simulate(trial, scene, 5, outcome, [&](Engine& engine, double) {
      outcome.error = displacement(scene, engine);
      return true;
    });
    if (!good) outcome.error = kInfinity;
    return outcome;
  };
  return problem;
}

}  // namespace

Scene chain_scene(int links, double heavy, bool lying) {
  const double pitch = 0.5;
  const Vec2 along = lying ? Vec2{1, 0} : Vec2{0, -1};
  Scene scene;
  int before = -1;
  for (int i = 0; i < links; ++i) {
    // Shorter than the way between the pins: links do not touch.
    const int link = scene.add({.shape = box(0.6 * pitch, 0.1),
                                .position = (i + 0.5) * pitch * along,
                                .angle = lying ? 0 : -kPi / 2});
    scene.joints.push_back({Link::Pin, before, link, i * pitch * along, {}});
    before = link;
  }
  const int end = scene.add({.shape = disc(0.5), .position = (links * pitch + 0.55) * along, .mass = heavy});
  scene.joints.push_back({Link::Pin, before, end, links * pitch * along, {}});
  return scene;
}

std::vector<Problem> joint_problems() {
  return {hanging(), swinging(), truss(), rods()};
}

}  // namespace skerry::bench
