// SPDX-License-Identifier: MIT
//
// Box2D 2.4 through the large scenes.
#include <box2d/box2d.h>
#include <cmath>

#include "tests/bench/scale_run.h"

namespace skerry::scale {
namespace {

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

}  // namespace

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
      fixture.density = static_cast<float>(item.density);
      fixture.friction = static_cast<float>(scene.friction);
      fixture.restitution = static_cast<float>(scene.restitution);
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
  OverlapLog overlaps(scene, options, [&](std::size_t i) {
    const b2Vec2 at = bodies[i]->GetPosition();
    return Transform{{at.x, at.y}, Rot::from_angle(bodies[i]->GetAngle())};
  });
  measure(
      options, row, [&] { world.Step(h, 8 * options.peer_work, 3 * options.peer_work); },
      [&] {
        row.collision.push_back(world.GetProfile().collide + world.GetProfile().broadphase);
        overlaps.note(row);
        for (b2Joint* j = world.GetJointList(); j != nullptr; j = j->GetNext())
          row.apart = std::max(row.apart, static_cast<double>((j->GetAnchorA() - j->GetAnchorB()).Length()));
        row.residual = natural_map_of(world, velocity, omega);
        note_free_velocities();
      });
  for (const b2Body* b = world.GetBodyList(); b != nullptr; b = b->GetNext())
    row.asleep += b->GetType() == b2_dynamicBody && !b->IsAwake();
  return row;
}

}  // namespace skerry::scale
