// SPDX-License-Identifier: MIT
//
// Box2D 3: soft contacts with sub-steps ("soft step"), single precision, SIMD.
#include <box2d/box2d.h>

#include "tests/bench/accuracy/engine.h"

namespace skerry::bench {
namespace {

b2Vec2 convert(Vec2 v) {
  return b2Vec2{static_cast<float>(v.x), static_cast<float>(v.y)};
}

class Box2d3 final : public Engine {
 public:
  Box2d3(const Scene& scene, const Setting& setting)
      : dt_(static_cast<float>(setting.dt)), substeps_(setting.iterations > 0 ? setting.iterations : 4) {
    b2WorldDef def = b2DefaultWorldDef();
    def.gravity = convert(scene.gravity);
    def.enableSleep = !setting.tuned;
    if (setting.tuned) def.restitutionThreshold = 0;
    // Contacts as stiff as their sub-steps allow: it limits them to an eighth of the rate of those itself.
    // The default, 30 Hz, suits four sub-steps of 1/60 s.
    if (setting.solver == "stiff") def.contactHertz = static_cast<float>(0.125 * substeps_ / setting.dt);
    world_ = b2CreateWorld(&def);
    for (const SceneBody& body : scene.bodies) add(scene, body);
    b2BodyDef ground = b2DefaultBodyDef();
    const b2BodyId fixed = b2CreateBody(world_, &ground);
    for (const SceneJoint& joint : scene.joints) {
      const b2BodyId a = joint.a < 0 ? fixed : bodies_[static_cast<std::size_t>(joint.a)];
      const b2BodyId b = bodies_[static_cast<std::size_t>(joint.b)];
      if (joint.link == Link::Pin) {
        b2RevoluteJointDef pin = b2DefaultRevoluteJointDef();
        pin.bodyIdA = a;
        pin.bodyIdB = b;
        pin.localAnchorA = b2Body_GetLocalPoint(a, convert(joint.at_a));
        pin.localAnchorB = b2Body_GetLocalPoint(b, convert(joint.at_a));
        b2CreateRevoluteJoint(world_, &pin);
      } else {
        b2DistanceJointDef rod = b2DefaultDistanceJointDef();
        rod.bodyIdA = a;
        rod.bodyIdB = b;
        rod.localAnchorA = b2Body_GetLocalPoint(a, convert(joint.at_a));
        rod.localAnchorB = b2Body_GetLocalPoint(b, convert(joint.at_b));
        rod.length = static_cast<float>(length(joint.at_b - joint.at_a));
        b2CreateDistanceJoint(world_, &rod);
      }
    }
  }
  ~Box2d3() override { b2DestroyWorld(world_); }
  void step() override { b2World_Step(world_, dt_, substeps_); }
  BodyState state(int body) const override {
    const b2BodyId id = bodies_[static_cast<std::size_t>(body)];
    const b2Vec2 p = b2Body_GetPosition(id);
    const b2Vec2 v = b2Body_GetLinearVelocity(id);
    return {{p.x, p.y}, b2Rot_GetAngle(b2Body_GetRotation(id)), {v.x, v.y}, b2Body_GetAngularVelocity(id)};
  }
  double normal_force(int body) const override {
    const b2BodyId id = bodies_[static_cast<std::size_t>(body)];
    std::vector<b2ContactData> contacts(static_cast<std::size_t>(b2Body_GetContactCapacity(id)));
    const int count = b2Body_GetContactData(id, contacts.data(), static_cast<int>(contacts.size()));
    Vec2 sum;
    for (int k = 0; k < count; ++k) {
      const b2Manifold& manifold = contacts[static_cast<std::size_t>(k)].manifold;
      const double sign =
          B2_ID_EQUALS(b2Shape_GetBody(contacts[static_cast<std::size_t>(k)].shapeIdB), id) ? 1.0 : -1.0;
      for (int i = 0; i < manifold.pointCount; ++i)
        sum += sign * manifold.points[i].totalNormalImpulse * Vec2{manifold.normal.x, manifold.normal.y};
    }
    // The total has every sub-step twice: after its solve and after its relaxation.
    return length(sum) / (2 * dt_);
  }
  void push(int body, Vec2 impulse) override {
    b2Body_ApplyLinearImpulseToCenter(bodies_[static_cast<std::size_t>(body)], convert(impulse), true);
  }

 private:
  void add(const Scene& scene, const SceneBody& from) {
    b2BodyDef def = b2DefaultBodyDef();
    def.type = from.fixed ? b2_staticBody : b2_dynamicBody;
    def.position = convert(from.position);
    def.rotation = b2MakeRot(static_cast<float>(from.angle));
    def.linearVelocity = convert(from.velocity);
    def.angularVelocity = static_cast<float>(from.omega);
    const b2BodyId body = b2CreateBody(world_, &def);
    b2ShapeDef shape = b2DefaultShapeDef();
    shape.material.friction = static_cast<float>(scene.friction);
    shape.material.restitution = static_cast<float>(scene.restitution);
    const SceneShape& s = from.shape;
    if (s.form == Form::Disc) {
      const b2Circle circle = {{0, 0}, static_cast<float>(s.radius)};
      b2CreateCircleShape(body, &shape, &circle);
    } else {
      // Not by b2ComputeHull, which takes another corner first.
      b2Hull hull{};
      for (const Vec2 corner : corners_of(s)) hull.points[hull.count++] = convert(corner);
      const b2Polygon polygon = b2MakePolygon(&hull, 0);
      b2CreatePolygonShape(body, &shape, &polygon);
    }
    if (!from.fixed) {
      const b2MassData mass = {static_cast<float>(from.mass), {0, 0}, static_cast<float>(inertia_of(from))};
      b2Body_SetMassData(body, mass);
    }
    bodies_.push_back(body);
  }

  b2WorldId world_{};
  float dt_;
  int substeps_;
  std::vector<b2BodyId> bodies_;
};

std::unique_ptr<Engine> make(const Scene& scene, const Setting& setting) {
  return std::make_unique<Box2d3>(scene, setting);
}

}  // namespace

EngineEntry box2d3_entry() {
  EngineEntry entry;
  entry.name = "Box2D 3";
  entry.version = SKERRY_WITH_BOX2D3;
  entry.make = make;
  entry.curves = {{.label = "default"},
                  {.label = "best", .iterations = 16, .tuned = true, .solver = "stiff"},
                  {.label = "best soft", .iterations = 16, .tuned = true}};
  return entry;
}

}  // namespace skerry::bench
