// SPDX-License-Identifier: MIT
//
// Box2D 3 through the large scenes, with its defaults: four sub-steps, sleeping, continuous collision.
#include <box2d/box2d.h>
#include <cmath>

#include "tests/bench/scale_run.h"

namespace skerry::scale {
namespace {

b2Vec2 convert(Vec2 v) {
  return b2Vec2{static_cast<float>(v.x), static_cast<float>(v.y)};
}

b2BodyId create(b2WorldId world, const Scene& scene, const Item& item) {
  b2BodyDef def = b2DefaultBodyDef();
  def.type = item.type == BodyType::Static      ? b2_staticBody
             : item.type == BodyType::Kinematic ? b2_kinematicBody
                                                : b2_dynamicBody;
  def.position = convert(item.at);
  def.rotation = b2MakeRot(static_cast<float>(item.angle));
  def.linearVelocity = convert(item.velocity);
  def.angularVelocity = static_cast<float>(item.omega);
  const b2BodyId body = b2CreateBody(world, &def);
  b2ShapeDef shape = b2DefaultShapeDef();
  shape.density = static_cast<float>(item.density);
  shape.material.friction = static_cast<float>(scene.friction);
  shape.material.restitution = static_cast<float>(scene.restitution);
  for (const Part& part : item.parts) {
    if (part.half.y > 0) {
      const b2Polygon box = b2MakeOffsetBox(static_cast<float>(part.half.x), static_cast<float>(part.half.y),
                                            convert(part.at), b2MakeRot(static_cast<float>(part.angle)));
      b2CreatePolygonShape(body, &shape, &box);
    } else {
      const b2Circle disc = {convert(part.at), static_cast<float>(part.half.x)};
      b2CreateCircleShape(body, &shape, &disc);
    }
  }
  return body;
}

}  // namespace

Run run_box2d3(const char* name, const Scene& scene, const Options& options) {
  b2WorldDef def = b2DefaultWorldDef();
  def.gravity = convert(scene.gravity);
  def.enableSleep = !options.awake;
  if (options.peer_stiff) {
    def.contactHertz *= static_cast<float>(options.peer_work);
    def.maxContactPushSpeed *= static_cast<float>(options.peer_work);
  }
  const b2WorldId world = b2CreateWorld(&def);
  std::vector<b2BodyId> bodies;
  for (const Item& item : scene.items) bodies.push_back(create(world, scene, item));
  for (const Hinge& hinge : scene.hinges) {
    b2RevoluteJointDef pin = b2DefaultRevoluteJointDef();
    pin.bodyIdA = bodies[static_cast<std::size_t>(hinge.a)];
    pin.bodyIdB = bodies[static_cast<std::size_t>(hinge.b)];
    pin.localAnchorA = b2Body_GetLocalPoint(pin.bodyIdA, convert(hinge.at));
    pin.localAnchorB = b2Body_GetLocalPoint(pin.bodyIdB, convert(hinge.at));
    b2CreateRevoluteJoint(world, &pin);
  }
  Run row{name, "Box2D 3", scene.items.size(), {}};
  const auto anchor = [&](int item, b2Vec2 at) {
    return b2Body_GetWorldPoint(bodies[static_cast<std::size_t>(item)], at);
  };
  std::vector<std::pair<b2Vec2, b2Vec2>> anchors;
  for (const Hinge& hinge : scene.hinges) {
    anchors.emplace_back(b2Body_GetLocalPoint(bodies[static_cast<std::size_t>(hinge.a)], convert(hinge.at)),
                         b2Body_GetLocalPoint(bodies[static_cast<std::size_t>(hinge.b)], convert(hinge.at)));
  }
  OverlapLog overlaps(scene, options, [&](std::size_t i) {
    const b2Vec2 at = b2Body_GetPosition(bodies[i]);
    const b2Rot turn = b2Body_GetRotation(bodies[i]);
    return Transform{{at.x, at.y}, Rot{turn.c, turn.s}};
  });
  measure(
      options, row, [&] { b2World_Step(world, 1.0f / 60, 4 * options.peer_work); },
      [&] {
        const b2Profile profile = b2World_GetProfile(world);
        row.collision.push_back(profile.pairs + profile.collide);
        for (std::size_t i = 0; i < anchors.size(); ++i) {
          const b2Vec2 a = anchor(scene.hinges[i].a, anchors[i].first);
          const b2Vec2 b = anchor(scene.hinges[i].b, anchors[i].second);
          row.apart = std::max(row.apart, static_cast<double>(b2Distance(a, b)));
        }
        overlaps.note(row);
      });
  for (const b2BodyId body : bodies)
    row.asleep += b2Body_GetType(body) == b2_dynamicBody && !b2Body_IsAwake(body);
  b2DestroyWorld(world);
  return row;
}

}  // namespace skerry::scale
