// SPDX-License-Identifier: MIT
//
// Whole steps of large scenes, ours and Box2D 2.4's, made from one description.
//
//   scale_bench [--steps N] [--budget S] [--threads N] [--solver NAME] [--stepper NAME] [--awake] [--fresh]
//               [SCENE...]
//
// A Markdown row for each scene and engine: bodies, steps made within the budget, mean, median and slowest
// step [ms], of the mean pairs and narrow phase [ms], penetration [m], residual of the contact problem in the
// last step, bodies asleep at the end. Then the ratios, losing ones first; the means are those over the steps
// that all made. With one thread times are processor times, but pairs and narrow phase are by the clock.
// Box2D runs with its defaults and without its continuous collision; the ratio is that to the faster of both.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "tests/bench/scale_scenes.h"

#ifdef SKERRY_WITH_BOX2D
#include <box2d/box2d.h>
#endif

namespace {

using namespace skerry;
using namespace skerry::scale;

struct Options {
  int steps = 120;
  double budget = 20;  ///< of one engine in one scene [s]
  int threads = 1;
  std::string solver = "auto";
  std::string stepper = "time_stepping";
  bool awake = false;  ///< nothing sleeps
  bool fresh = false;  ///< nor are islands at rest kept: every step solves everything
};

/// What a run of one engine gave.
struct Run {
  std::string scene, engine;
  std::size_t bodies = 0;
  std::vector<double> ms;
  double collision = 0;    ///< pairs and narrow phase, mean [ms]
  double penetration = 0;  ///< largest [m]
  double residual = -1;    ///< of the last step; < 0: unknown
  int asleep = 0;

  double mean(std::size_t steps) const {
    double sum = 0;
    for (std::size_t i = 0; i < steps; ++i) sum += ms[i];
    return sum / static_cast<double>(steps);
  }
  double median() const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
};

/// Processor time of this thread where it does all the work, which neighbours on the machine do not change;
/// else the time of the clock [s].
double now(const Options& options) {
  timespec t{};
  clock_gettime(options.threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Calls `step` until the steps or the budget are spent, and `after` untimed.
template <class Step, class After>
void measure(const Options& options, Run& row, Step&& step, After&& after) {
  double seconds = 0;
  for (int i = 0; i < options.steps && seconds < options.budget; ++i) {
    const double start = now(options);
    step();
    const double spent = now(options) - start;
    row.ms.push_back(1e3 * spent);
    seconds += spent;
    after();
  }
}

void print(const Run& row) {
  std::printf("| %s | %s | %zu | %zu | %.3f | %.3f | %.3f | %.3f | %.1e | ", row.scene.c_str(),
              row.engine.c_str(), row.bodies, row.ms.size(), row.mean(row.ms.size()), row.median(),
              *std::max_element(row.ms.begin(), row.ms.end()), row.collision, row.penetration);
  if (row.residual >= 0)
    std::printf("%.1e", row.residual);
  else
    std::printf("-");
  std::printf(" | %d |\n", row.asleep);
  std::fflush(stdout);
}

Run run_ours(const char* name, const Scene& scene, const Options& options) {
  WorldConfig config;
  config.gravity = scene.gravity;
  config.threads = options.threads;
  config.solver = options.solver;
  config.stepper = options.stepper;
  config.sleep = !options.awake;
  config.reuse_resting = !options.fresh;
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
    world.create_joint({.a = bodies[static_cast<std::size_t>(hinge.a)],
                        .b = bodies[static_cast<std::size_t>(hinge.b)],
                        .anchor_a = hinge.at});
  }
  world.observe({.stage_times = true});
  Run row{name, "Skerry " + options.solver, scene.items.size(), {}};
  double collision = 0;
  measure(
      options, row, [&] { world.step(1.0 / 60); },
      [&] {
        const StepReport& report = world.report();
        collision += report.stage_seconds[static_cast<int>(Stage::Broad)] +
                     report.stage_seconds[static_cast<int>(Stage::Narrow)];
        row.penetration = std::max(row.penetration, report.worst_penetration);
      });
  row.collision = 1e3 * collision / static_cast<double>(row.ms.size());
  row.residual = world.report().worst_residual;
  row.asleep = world.report().bodies_asleep;
  return row;
}

#ifdef SKERRY_WITH_BOX2D
/// The natural map of our own solvers at Box2D's impulses: with D the inverse effective mass of a row, u its
/// relative velocity after the step and lambda its impulse, the largest D |lambda - clamp(lambda - u / D)|
/// over the normal and friction rows of all contacts, relative to the largest relative velocity that the row
/// would have without impulses. Contacts of sleepers are left out.
double natural_map_of(b2World& world, const std::vector<b2Vec2>& free_velocity,
                      const std::vector<float>& free_omega) {
  double worst = 0, scale = 0;
  for (b2Contact* c = world.GetContactList(); c != nullptr; c = c->GetNext()) {
    b2Body* bodies[2] = {c->GetFixtureA()->GetBody(), c->GetFixtureB()->GetBody()};
    if (!c->IsTouching() || (!bodies[0]->IsAwake() && !bodies[1]->IsAwake())) continue;
    b2WorldManifold at;
    c->GetWorldManifold(&at);
    const b2Manifold* manifold = c->GetManifold();
    for (int k = 0; k < manifold->pointCount; ++k) {
      const double pressed = manifold->points[k].normalImpulse;
      const b2Vec2 axes[2] = {at.normal, b2Cross(at.normal, 1.0f)};
      const double impulses[2] = {pressed, manifold->points[k].tangentImpulse};
      const double lower[2] = {0, -c->GetFriction() * pressed};
      const double upper[2] = {1e300, c->GetFriction() * pressed};
      for (int row = 0; row < 2; ++row) {
        double u = 0, u_free = 0, D = 0;
        for (int side = 0; side < 2; ++side) {
          b2Body* body = bodies[side];
          const double sign = side == 0 ? -1 : 1;
          const b2Vec2 r = at.points[k] - body->GetWorldCenter();
          u += sign * b2Dot(axes[row], body->GetLinearVelocity() + b2Cross(body->GetAngularVelocity(), r));
          const std::size_t i = body->GetUserData().pointer;
          u_free += sign * b2Dot(axes[row], free_velocity[i] + b2Cross(free_omega[i], r));
          const double arm = b2Cross(r, axes[row]);
          if (body->GetType() != b2_dynamicBody) continue;
          const double centre = b2Dot(body->GetLocalCenter(), body->GetLocalCenter());
          D += 1 / body->GetMass() + arm * arm / (body->GetInertia() - body->GetMass() * centre);
        }
        const double wanted = std::clamp(impulses[row] - u / D, lower[row], upper[row]);
        worst = std::max(worst, D * std::abs(impulses[row] - wanted));
        scale = std::max(scale, std::abs(u_free));
      }
    }
  }
  return scale > 0 ? worst / scale : worst;
}

Run run_box2d(const char* name, const Scene& scene, const Options& options, bool continuous) {
  const auto vec = [](Vec2 v) { return b2Vec2(static_cast<float>(v.x), static_cast<float>(v.y)); };
  b2World world(vec(scene.gravity));
  world.SetAllowSleeping(!options.awake);
  world.SetContinuousPhysics(continuous);
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
    def.userData.pointer = bodies.size();
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
    def.Initialize(bodies[static_cast<std::size_t>(hinge.a)], bodies[static_cast<std::size_t>(hinge.b)],
                   vec(hinge.at));
    world.CreateJoint(&def);
  }
  Run row{name, continuous ? "Box2D 2.4" : "Box2D 2.4, not continuous", scene.items.size(), {}};
  double collision = 0;
  std::vector<b2Vec2> velocity(bodies.size());
  std::vector<float> omega(bodies.size());
  const float h = 1.0f / 60;
  const auto note_free_velocities = [&] {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const bool falls = bodies[i]->GetType() == b2_dynamicBody;
      velocity[i] = bodies[i]->GetLinearVelocity() + (falls ? h : 0) * world.GetGravity();
      omega[i] = bodies[i]->GetAngularVelocity();
    }
  };
  note_free_velocities();
  measure(
      options, row, [&] { world.Step(h, 8, 3); },
      [&] {
        collision += world.GetProfile().collide + world.GetProfile().broadphase;
        for (const b2Contact* c = world.GetContactList(); c != nullptr; c = c->GetNext()) {
          b2WorldManifold manifold;
          c->GetWorldManifold(&manifold);
          // The shapes carry a skin of b2_polygonRadius, so touching is a separation of zero between the
          // skins.
          for (int k = 0; k < c->GetManifold()->pointCount; ++k)
            row.penetration = std::max(row.penetration, -static_cast<double>(manifold.separations[k]));
        }
        row.residual = natural_map_of(world, velocity, omega);
        note_free_velocities();
      });
  row.collision = collision / static_cast<double>(row.ms.size());
  for (const b2Body* b = world.GetBodyList(); b != nullptr; b = b->GetNext())
    row.asleep += b->GetType() == b2_dynamicBody && !b->IsAwake();
  return row;
}
#endif

struct Ratio {
  std::string scene;
  double mean, median, collision;  ///< ours over the peer's
};

void print(std::vector<Ratio> ratios) {
  std::sort(ratios.begin(), ratios.end(), [](const Ratio& x, const Ratio& y) { return x.mean > y.mean; });
  std::printf(
      "\nOurs / Box2D's, the losing ones first:\n\n| scene | mean step | median step | pairs + narrow phase "
      "|\n"
      "| --- | --- | --- | --- |\n");
  for (const Ratio& r : ratios)
    std::printf("| %s | %.3g | %.3g | %.3g |\n", r.scene.c_str(), r.mean, r.median, r.collision);
}

int usage(const std::string& what) {
  std::fprintf(stderr, "scale_bench: %s; scenes:", what.c_str());
  for (const Named& n : kScenes) std::fprintf(stderr, " %s", n.name);
  std::fprintf(stderr, "\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  std::vector<std::string> wanted;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const char* next = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--steps")
      options.steps = std::max(1, std::atoi(next)), ++i;
    else if (word == "--budget")
      options.budget = std::atof(next), ++i;
    else if (word == "--threads")
      options.threads = std::max(1, std::atoi(next)), ++i;
    else if (word == "--solver")
      options.solver = next, ++i;
    else if (word == "--stepper")
      options.stepper = next, ++i;
    else if (word == "--awake")
      options.awake = true;
    else if (word == "--fresh")
      options.awake = options.fresh = true;
    else if (word[0] == '-')
      return usage("no option " + word);
    else
      wanted.push_back(word);
  }
  for (const std::string& name : wanted) {
    if (std::none_of(kScenes.begin(), kScenes.end(), [&](const Named& n) { return n.name == name; }))
      return usage("no scene '" + name + "'");
  }
  std::printf(
      "| scene | engine | bodies | steps | mean ms | median ms | slowest ms | pairs + narrow ms | "
      "penetration m | "
      "residual | asleep |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  std::vector<Ratio> ratios;
  for (const Named& named : kScenes) {
    if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), named.name) == wanted.end()) continue;
    const Scene scene = named.make();
    const Run ours = run_ours(named.name, scene, options);
    print(ours);
#ifdef SKERRY_WITH_BOX2D
    const Run peer = run_box2d(named.name, scene, options, true);
    print(peer);
    const Run discrete = run_box2d(named.name, scene, options, false);
    print(discrete);
    // The beginning that all of them made.
    const std::size_t steps = std::min({ours.ms.size(), peer.ms.size(), discrete.ms.size()});
    const Run& best = discrete.mean(steps) < peer.mean(steps) ? discrete : peer;
    ratios.push_back({named.name, ours.mean(steps) / best.mean(steps), ours.median() / best.median(),
                      ours.collision / best.collision});
#endif
  }
  if (!ratios.empty()) print(std::move(ratios));
  return 0;
}
