// SPDX-License-Identifier: MIT
//
// Box2D 2.4: sequential impulses with warm starts, single precision.
#include <box2d/box2d.h>

#include "tests/bench/accuracy/engine.h"

namespace skerry::bench {
namespace {

b2Vec2 convert(Vec2 v) {
  return b2Vec2(static_cast<float>(v.x), static_cast<float>(v.y));
}

class Box2d final : public Engine {
 public:
  Box2d(const Scene& scene, const Setting& setting)
      : world_(convert(scene.gravity)), dt_(static_cast<float>(setting.dt)) {
    // The manual's values by default.
    velocity_iterations_ = setting.iterations > 0 ? setting.iterations : 8;
    position_iterations_ = setting.iterations > 0 ? std::max(3, setting.iterations / 3) : 3;
    world_.SetAllowSleeping(!setting.tuned);
    for (const SceneBody& body : scene.bodies) add(scene, body, setting.tuned);
    b2BodyDef def;
    b2Body* fixed = world_.CreateBody(&def);
    for (const SceneJoint& joint : scene.joints) {
      b2Body* a = joint.a < 0 ? fixed : bodies_[static_cast<std::size_t>(joint.a)];
      b2Body* b = bodies_[static_cast<std::size_t>(joint.b)];
      if (joint.link == Link::Pin) {
        b2RevoluteJointDef pin;
        pin.Initialize(a, b, convert(joint.at_a));
        world_.CreateJoint(&pin);
      } else {
        b2DistanceJointDef rod;
        rod.Initialize(a, b, convert(joint.at_a), convert(joint.at_b));
        world_.CreateJoint(&rod);
      }
    }
  }
  void step() override { world_.Step(dt_, velocity_iterations_, position_iterations_); }
  BodyState state(int body) const override {
    const b2Body* b = bodies_[static_cast<std::size_t>(body)];
    return {{b->GetWorldCenter().x, b->GetWorldCenter().y},
            b->GetAngle(),
            {b->GetLinearVelocity().x, b->GetLinearVelocity().y},
            b->GetAngularVelocity()};
  }
  double normal_force(int body) const override {
    Vec2 sum;
    for (const b2ContactEdge* e = bodies_[static_cast<std::size_t>(body)]->GetContactList(); e != nullptr;
         e = e->next) {
      if (!e->contact->IsTouching()) continue;
      const b2Manifold* manifold = e->contact->GetManifold();
      b2WorldManifold world;
      e->contact->GetWorldManifold(&world);
      const bool second = e->contact->GetFixtureB()->GetBody() == bodies_[static_cast<std::size_t>(body)];
      for (int i = 0; i < manifold->pointCount; ++i)
        sum +=
            (second ? 1.0 : -1.0) * manifold->points[i].normalImpulse * Vec2{world.normal.x, world.normal.y};
    }
    return length(sum) / dt_;
  }
  void push(int body, Vec2 impulse) override {
    bodies_[static_cast<std::size_t>(body)]->ApplyLinearImpulseToCenter(convert(impulse), true);
  }

 private:
  void add(const Scene& scene, const SceneBody& from, bool tuned) {
    b2BodyDef def;
    def.type = from.fixed ? b2_staticBody : b2_dynamicBody;
    def.position = convert(from.position);
    def.angle = static_cast<float>(from.angle);
    def.linearVelocity = convert(from.velocity);
    def.angularVelocity = static_cast<float>(from.omega);
    b2Body* body = world_.CreateBody(&def);
    b2FixtureDef fixture;
    fixture.friction = static_cast<float>(scene.friction);
    fixture.restitution = static_cast<float>(scene.restitution);
    if (tuned) fixture.restitutionThreshold = 0;
    fixture.density = from.fixed ? 0.0f : 1.0f;
    b2CircleShape circle;
    b2PolygonShape polygon;
    const SceneShape& s = from.shape;
    if (s.form == Form::Disc) {
      circle.m_radius = static_cast<float>(s.radius);
      fixture.shape = &circle;
    } else {
      // Its skin goes round the polygon: without it, what the scene puts in touch would begin two skins deep.
      std::vector<b2Vec2> corners;
      for (const Vec2 corner : inset(corners_of(s), b2_polygonRadius)) corners.push_back(convert(corner));
      polygon.Set(corners.data(), static_cast<int32>(corners.size()));
      fixture.shape = &polygon;
    }
    body->CreateFixture(&fixture);
    if (!from.fixed) {
      b2MassData mass;
      mass.mass = static_cast<float>(from.mass);
      mass.center.SetZero();
      mass.I = static_cast<float>(inertia_of(from));
      body->SetMassData(&mass);
    }
    bodies_.push_back(body);
  }

  b2World world_;
  float dt_;
  int velocity_iterations_, position_iterations_;
  std::vector<b2Body*> bodies_;
};

std::unique_ptr<Engine> make(const Scene& scene, const Setting& setting) {
  return std::make_unique<Box2d>(scene, setting);
}

}  // namespace

EngineEntry box2d_entry() {
  EngineEntry entry;
  entry.name = "Box2D 2.4";
  entry.version = SKERRY_WITH_BOX2D;
  entry.make = make;
  entry.curves = {{.label = "default"}, {.label = "best", .iterations = 100, .tuned = true}};
  return entry;
}

}  // namespace skerry::bench
