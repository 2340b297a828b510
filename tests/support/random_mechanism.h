// SPDX-License-Identifier: MIT
//
// Random mechanisms of a few bodies: hinges, slides, wheels, gears, racks, pulleys, with limits, springs and
// motors, on the ground and on bodies that are told to move; on belts, in drag.
#pragma once

#include <cmath>

#include "physics/disjoint_sets.h"
#include "tests/support/draw.h"
#include "tests/support/recipe.h"
#include "tests/support/worlds.h"

namespace skerry::test {

class RandomMechanism : private Draw {
 public:
  explicit RandomMechanism(unsigned seed) : Draw(seed) {
    if (one_in(6)) recipe_.gravity = {0, 0};
    friction_ = one_in(6) ? 0 : uniform(0.1, 0.9);
    belts_ = one_in(3);
    held_harder_ = one_in(4);
    add_ground();
    if (one_in(2)) add_told();
    first_ = static_cast<int>(recipe_.parts.size());
    add_bodies(1 + pick(4), one_in(3));
    DisjointSets sets(recipe_.parts.size() + 1);
    const int joints = 1 + pick(3);
    for (int k = 0; k < joints; ++k) join(sets);
  }

  const Recipe& recipe() const { return recipe_; }

 private:
  Vec2 in_box(double size) { return {uniform(-size, size), uniform(-size, size)}; }

  ShapeDef surface(Shape shape, bool belt) {
    ShapeDef def = rough(std::move(shape), friction_);
    if (belt && belts_) def.material.surface_velocity = uniform(-2, 2);
    if (held_harder_) def.material.static_friction = 1.4 * friction_;
    return def;
  }

  /// Adds it to the recipe, and to the world in which places are looked for.
  void add(Recipe::Part part) {
    const BodyId body = places_.create_body(part.body);
    for (const ShapeDef& shape : part.shapes) places_.add_shape(body, shape);
    recipe_.parts.push_back(std::move(part));
  }

  void add_ground() {
    Recipe::Part ground{.body = {.type = BodyType::Static}, .shapes = {}};
    ground.shapes.push_back(surface(make_half_plane({0, 0}, {0, 1}), true));
    ground.shapes.push_back(surface(make_half_plane({-6, 0}, {1, 0}), false));
    ground.shapes.push_back(surface(make_half_plane({6, 0}, {-1, 0}), false));
    add(std::move(ground));
  }

  void add_told() {
    const Vec2 at{uniform(-4, 4), uniform(0.8, 2.5)};
    const bool turns = one_in(3), slides = one_in(2);
    Recipe::Part told{.body = {.type = BodyType::Kinematic,
                               .position = at,
                               .velocity = slides ? Vec2{uniform(-1, 1), 0} : Vec2{},
                               .omega = turns ? uniform(-3, 3) : 0},
                      .shapes = {}};
    told.shapes.push_back(surface(make_box({uniform(0.3, 2), 0.2}), true));
    if (!turns && !slides) {
      const double amplitude = uniform(0.1, 0.5), frequency = uniform(1, 6), turn = uniform(-1, 1);
      told.motion = [=](double time) {
        const double wave = std::sin(frequency * time);
        return Placement{at + Vec2{0, amplitude * wave}, turn * wave};
      };
    }
    told_ = static_cast<int>(recipe_.parts.size());
    add(std::move(told));
  }

  Shape shape() {
    const double size = uniform(0.25, 0.6);
    if (one_in(3)) return make_disc(0.5 * size);
    if (one_in(3)) return make_capsule({-0.3 * size, 0}, {0.3 * size, 0}, 0.2 * size);
    return make_box({size, uniform(0.2, 0.6)});
  }

  void add_bodies(int count, bool drag) {
    for (int tries = 0; tries < 200 && this->count() < count; ++tries) {
      const Vec2 at{uniform(-4.5, 4.5), uniform(0.9, 5)};
      if (!places_.shapes_overlapping(make_disc(0.75), {at, Rot::from_angle(0)}).empty()) continue;
      const double speed = one_in(3) ? 6 : 1.5;
      Recipe::Part part;
      // One after the other: the order in which arguments are evaluated is the compiler's.
      part.body.angle = uniform(0, 3);
      part.body.omega = uniform(-speed, speed);
      part.body.velocity = in_box(speed);
      part.body.mass = uniform(0.5, 2);
      const bool belt = one_in(5);
      part.shapes.push_back(surface(shape(), belt));
      part.body.position = at;
      if (drag) part.drag = {.linear = uniform(0, 2), .angular = uniform(0, 0.1)};
      add(std::move(part));
    }
  }

  int count() const { return static_cast<int>(recipe_.parts.size()) - first_; }
  Vec2 place_of(int part) const { return recipe_.parts[static_cast<std::size_t>(part)].body.position; }

  /// Adds a joint that closes no loop.
  void join(DisjointSets& sets) {
    const int to = pick(count()), from = pick(count() + 1);
    const bool ground = from == count();
    if (from == to || !sets.join(from, to)) return;
    Recipe::Link link;
    JointDef& joint = link.joint;
    const bool on_told = told_ >= 0 && one_in(2);
    link.a = !ground ? first_ + from : on_told ? told_ : -1;
    link.b = first_ + to;
    joint.anchor_b = place_of(link.b);
    joint.anchor_a = ground ? joint.anchor_b + in_box(0.5) : place_of(link.a);
    const Vec2 middle = 0.5 * (joint.anchor_a + joint.anchor_b);
    const bool limited = one_in(3), driven = one_in(2);
    switch (pick(ground ? 4 : 8)) {
      case 0:
      case 1:
        joint.kind = JointKind::Revolute;
        joint.anchor_a = middle;
        if (driven) drive(joint, 5, 20);
        break;
      case 2:
        joint.kind = JointKind::Prismatic;
        joint.anchor_a = joint.anchor_b;
        joint.axis = {uniform(0.1, 1), uniform(-1, 1)};
        if (driven) drive(joint, 2, 50);
        break;
      case 3:
        joint.kind = JointKind::Wheel;
        joint.anchor_a = joint.anchor_b;
        joint.axis = {0, 1};
        joint.stiffness = uniform(100, 1000);
        joint.damping = uniform(0, 20);
        if (driven) drive(joint, 8, 10);
        break;
      case 4:
        joint.kind = JointKind::Rope;
        joint.length = 1.1 * length(joint.anchor_b - joint.anchor_a);
        break;
      case 5:
        joint.kind = JointKind::Gear;
        joint.ratio = one_in(2) ? uniform(0.5, 2) : -uniform(0.5, 2);
        break;
      case 6:
        joint.kind = JointKind::Rack;
        joint.ratio = uniform(0.2, 0.6);
        break;
      default:
        joint.kind = JointKind::Pulley;
        joint.pulley_a = joint.anchor_a + Vec2{0, 2};
        joint.pulley_b = joint.anchor_b + Vec2{0, 2};
        joint.ratio = uniform(0.5, 2);
    }
    const bool has_way = joint.kind <= JointKind::Wheel && joint.kind != JointKind::Rope;
    if (limited && has_way) {
      joint.lower = -uniform(0.1, 1);
      joint.upper = uniform(0.1, 1);
    }
    recipe_.links.push_back(link);
  }

  void drive(JointDef& joint, double speed, double limit) {
    joint.motor_speed = uniform(-speed, speed);
    if (!one_in(3)) joint.motor_limit = uniform(0.5, limit);
  }

  Recipe recipe_;
  World places_;
  int first_ = 0, told_ = -1;
  double friction_ = 0;
  bool belts_ = false, held_harder_ = false;
};

}  // namespace skerry::test
