// SPDX-License-Identifier: MIT
//
// Whole steps of large scenes, ours and Box2D 2.4's, made from one description.
//
//   scale_bench [--steps N] [--threads N] [--solver NAME] [--awake] [SCENE...]
//
// Prints a Markdown row for each scene and engine: bodies, mean, median and slowest step [ms], penetration
// [m], residual of the contact problem (ours), bodies asleep at the end.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "physics/world.h"

#ifdef SKERRY_WITH_BOX2D
#include <box2d/box2d.h>
#endif

namespace {

using namespace skerry;

/// A box, or a disc where `half.y` is zero.
struct Part {
  Vec2 half;
  Vec2 at{};
  double angle = 0;
};
struct Item {
  BodyType type = BodyType::Dynamic;
  Vec2 at{};
  double angle = 0;
  Vec2 velocity{};
  double omega = 0;
  std::vector<Part> parts;
};
struct Hinge {
  int a, b;
  Vec2 at;
};
struct Scene {
  Vec2 gravity{0, -10};
  double friction = 0.6;
  std::vector<Item> items;
  std::vector<Hinge> hinges;
};

void add_box(Scene& s, Vec2 at, Vec2 half, BodyType type = BodyType::Dynamic) {
  s.items.push_back({type, at, 0, {}, 0, {{half, {}, 0}}});
}

/// 5050 boxes, 14 950 contact points.
Scene large_pyramid() {
  Scene s;
  add_box(s, {0, -1}, {100, 1}, BodyType::Static);
  for (int row = 0; row < 100; ++row) {
    for (int i = 0; i < 100 - row; ++i) add_box(s, {i + 0.5 * row - 50, row + 0.5}, {0.5, 0.5});
  }
  return s;
}

/// 20 shelves with 20 pyramids of base 10 each: 22 000 boxes.
Scene many_pyramids() {
  Scene s;
  for (int shelf = 0; shelf < 20; ++shelf) {
    const double y = 13.0 * shelf;
    add_box(s, {120, y - 0.5}, {125, 0.5}, BodyType::Static);
    for (int p = 0; p < 20; ++p) {
      for (int row = 0; row < 10; ++row) {
        for (int i = 0; i < 10 - row; ++i) add_box(s, {12.0 * p + i + 0.5 * row, y + row + 0.5}, {0.5, 0.5});
      }
    }
  }
  return s;
}

/// 100 x 100 discs, hinged to their neighbours, hung up along the top.
Scene joint_grid() {
  Scene s;
  constexpr int n = 100;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const bool fixed = i == 0 && k % 10 == 0;
      s.items.push_back(
          {fixed ? BodyType::Static : BodyType::Dynamic, {1.0 * k, -1.0 * i}, 0, {}, 0, {{{0.4, 0}}}});
      if (k > 0) s.hinges.push_back({n * i + k - 1, n * i + k, {k - 0.5, -1.0 * i}});
      if (i > 0) s.hinges.push_back({n * (i - 1) + k, n * i + k, {1.0 * k, 0.5 - i}});
    }
  }
  return s;
}

/// A drum that turns with 2025 small boxes in it.
Scene tumbler() {
  Scene s;
  Item drum{BodyType::Kinematic, {0, 10}, 0, {}, 25 * std::acos(-1.0) / 180, {}};
  drum.parts = {{{0.5, 10}, {10, 0}}, {{0.5, 10}, {-10, 0}}, {{10, 0.5}, {0, 10}}, {{10, 0.5}, {0, -10}}};
  s.items.push_back(drum);
  for (int i = 0; i < 45; ++i) {
    for (int k = 0; k < 45; ++k) add_box(s, {0.2 * (i - 22) * 2, 10 + 0.2 * (k - 22) * 2}, {0.125, 0.125});
  }
  return s;
}

/// A heavy box flies into 9600 small ones, without gravity.
Scene smash() {
  Scene s;
  s.gravity = {};
  s.items.push_back({BodyType::Dynamic, {-20, 0}, 0, {40, 0}, 0, {{{4, 4}}}});
  for (int i = 0; i < 120; ++i) {
    for (int k = 0; k < 80; ++k) add_box(s, {0.4 * i + 4, 0.4 * (k - 40)}, {0.2, 0.2});
  }
  return s;
}

/// Bodies of two crossed planks each, dropped on a floor.
Scene compounds() {
  Scene s;
  add_box(s, {0, -1}, {100, 1}, BodyType::Static);
  for (int i = 0; i < 50; ++i) {
    for (int k = 0; k < 20; ++k) {
      s.items.push_back({BodyType::Dynamic,
                         {2.2 * (i - 25) + 0.03 * k, 1.5 + 2.2 * k},
                         0.1 * (i % 7),
                         {},
                         0,
                         {{{1, 0.15}}, {{0.15, 1}}}});
    }
  }
  return s;
}

struct Named {
  const char* name;
  std::function<Scene()> make;
};
const std::vector<Named> kScenes{{"large_pyramid", large_pyramid},
                                 {"many_pyramids", many_pyramids},
                                 {"joint_grid", joint_grid},
                                 {"tumbler", tumbler},
                                 {"smash", smash},
                                 {"compounds", compounds}};

struct Options {
  int steps = 120;
  int threads = 1;
  std::string solver = "auto";
  bool awake = false;
};

struct Timing {
  std::vector<double> ms;
  template <class Step>
  void measure(Step&& step) {
    const auto start = std::chrono::steady_clock::now();
    step();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
};

void print(const char* scene, const std::string& engine, std::size_t bodies, Timing t, double penetration,
           double residual, int asleep) {
  double sum = 0;
  for (const double ms : t.ms) sum += ms;
  std::sort(t.ms.begin(), t.ms.end());
  std::printf("| %s | %s | %zu | %.3f | %.3f | %.3f | %.1e | ", scene, engine.c_str(), bodies,
              sum / static_cast<double>(t.ms.size()), t.ms[t.ms.size() / 2], t.ms.back(), penetration);
  if (residual >= 0)
    std::printf("%.1e", residual);
  else
    std::printf("-");
  std::printf(" | %d |\n", asleep);
  std::fflush(stdout);
}

void run_ours(const char* name, const Scene& scene, const Options& options) {
  WorldConfig config;
  config.gravity = scene.gravity;
  config.threads = options.threads;
  config.solver = options.solver;
  config.sleep = !options.awake;
  World world(config);
  std::vector<BodyId> bodies;
  for (const Item& item : scene.items) {
    const BodyId body = world.create_body({.type = item.type,
                                           .position = item.at,
                                           .angle = item.angle,
                                           .velocity = item.velocity,
                                           .omega = item.omega});
    for (const Part& part : item.parts) {
      ShapeDef def;
      def.shape = part.half.y > 0 ? make_box({2 * part.half.x, 2 * part.half.y}, part.at, part.angle)
                                  : make_disc(part.half.x, part.at);
      def.density = 1;
      def.material.friction = scene.friction;
      world.add_shape(body, def);
    }
    bodies.push_back(body);
  }
  for (const Hinge& hinge : scene.hinges) {
    world.create_joint({.a = bodies[hinge.a], .b = bodies[hinge.b], .anchor_a = hinge.at});
  }
  Timing timing;
  double penetration = 0, residual = 0;
  for (int i = 0; i < options.steps; ++i) {
    timing.measure([&] { world.step(1.0 / 60); });
    penetration = std::max(penetration, world.report().worst_penetration);
    residual = std::max(residual, world.report().worst_residual);
  }
  print(name, "Skerry " + options.solver, scene.items.size(), timing, penetration, residual,
        world.report().bodies_asleep);
}

#ifdef SKERRY_WITH_BOX2D
void run_box2d(const char* name, const Scene& scene, const Options& options) {
  const auto vec = [](Vec2 v) { return b2Vec2(static_cast<float>(v.x), static_cast<float>(v.y)); };
  b2World world(vec(scene.gravity));
  world.SetAllowSleeping(!options.awake);
  std::vector<b2Body*> bodies;
  for (const Item& item : scene.items) {
    b2BodyDef def;
    def.type = item.type == BodyType::Static      ? b2_staticBody
               : item.type == BodyType::Kinematic ? b2_kinematicBody
                                                  : b2_dynamicBody;
    def.position = vec(item.at);
    def.angle = static_cast<float>(item.angle);
    def.linearVelocity = vec(item.velocity);
    def.angularVelocity = static_cast<float>(item.omega);
    b2Body* body = world.CreateBody(&def);
    for (const Part& part : item.parts) {
      b2PolygonShape box;
      b2CircleShape disc;
      box.SetAsBox(static_cast<float>(part.half.x), static_cast<float>(std::max(part.half.y, 0.01)),
                   vec(part.at), static_cast<float>(part.angle));
      disc.m_radius = static_cast<float>(part.half.x);
      disc.m_p = vec(part.at);
      b2FixtureDef fixture;
      fixture.shape = part.half.y > 0 ? static_cast<const b2Shape*>(&box) : &disc;
      fixture.density = 1;
      fixture.friction = static_cast<float>(scene.friction);
      body->CreateFixture(&fixture);
    }
    bodies.push_back(body);
  }
  for (const Hinge& hinge : scene.hinges) {
    b2RevoluteJointDef def;
    def.Initialize(bodies[hinge.a], bodies[hinge.b], vec(hinge.at));
    world.CreateJoint(&def);
  }
  Timing timing;
  double penetration = 0;
  for (int i = 0; i < options.steps; ++i) {
    timing.measure([&] { world.Step(1.0f / 60, 8, 3); });
    for (const b2Contact* c = world.GetContactList(); c != nullptr; c = c->GetNext()) {
      b2WorldManifold manifold;
      c->GetWorldManifold(&manifold);
      // The shapes carry a skin of b2_polygonRadius, so touching is a separation of zero between the skins.
      for (int k = 0; k < c->GetManifold()->pointCount; ++k)
        penetration = std::max(penetration, -static_cast<double>(manifold.separations[k]));
    }
  }
  int asleep = 0;
  for (const b2Body* b = world.GetBodyList(); b != nullptr; b = b->GetNext())
    asleep += b->GetType() == b2_dynamicBody && !b->IsAwake();
  print(name, "Box2D 2.4", scene.items.size(), timing, penetration, -1, asleep);
}
#endif

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::vector<std::string> wanted;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const char* next = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--steps")
      options.steps = std::max(1, std::atoi(next)), ++i;
    else if (word == "--threads")
      options.threads = std::max(1, std::atoi(next)), ++i;
    else if (word == "--solver")
      options.solver = next, ++i;
    else if (word == "--awake")
      options.awake = true;
    else
      wanted.push_back(word);
  }
  for (const std::string& name : wanted) {
    if (std::none_of(kScenes.begin(), kScenes.end(), [&](const Named& n) { return n.name == name; })) {
      std::fprintf(stderr, "scale_bench: no scene '%s'; there are", name.c_str());
      for (const Named& n : kScenes) std::fprintf(stderr, " %s", n.name);
      std::fprintf(stderr, "\n");
      return 2;
    }
  }
  std::printf(
      "| scene | engine | bodies | mean ms | median ms | slowest ms | penetration m | residual | asleep |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  for (const Named& named : kScenes) {
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), named.name) == wanted.end()) continue;
    const Scene scene = named.make();
    run_ours(named.name, scene, options);
#ifdef SKERRY_WITH_BOX2D
    run_box2d(named.name, scene, options);
#endif
  }
  return 0;
}
