// SPDX-License-Identifier: MIT
//
// Chipmunk 7: sequential impulses with warm starts, double precision.
#include <chipmunk/chipmunk.h>

#include "tests/bench/accuracy/engine.h"

namespace skerry::bench {
namespace {

cpVect convert(Vec2 v) {
  return cpv(v.x, v.y);
}

class Chipmunk final : public Engine {
 public:
  Chipmunk(const Scene& scene, const Setting& setting) : space_(cpSpaceNew()), dt_(setting.dt) {
    cpSpaceSetGravity(space_, convert(scene.gravity));
    if (setting.iterations > 0) cpSpaceSetIterations(space_, setting.iterations);
    // The default slop is 0.1 m.
    if (setting.tuned) cpSpaceSetCollisionSlop(space_, 1e-4);
    for (const SceneBody& body : scene.bodies) add(scene, body);
    for (const SceneJoint& joint : scene.joints) {
      cpBody* a = joint.a < 0 ? cpSpaceGetStaticBody(space_) : bodies_[static_cast<std::size_t>(joint.a)];
      cpBody* b = bodies_[static_cast<std::size_t>(joint.b)];
      cpConstraint* constraint = joint.link == Link::Pin
                                     ? cpPivotJointNew(a, b, convert(joint.at_a))
                                     : cpPinJointNew(a, b, cpBodyWorldToLocal(a, convert(joint.at_a)),
                                                     cpBodyWorldToLocal(b, convert(joint.at_b)));
      cpConstraintSetCollideBodies(constraint, cpFalse);
      constraints_.push_back(cpSpaceAddConstraint(space_, constraint));
    }
  }
  ~Chipmunk() override {
    for (cpConstraint* constraint : constraints_) {
      cpSpaceRemoveConstraint(space_, constraint);
      cpConstraintFree(constraint);
    }
    for (cpShape* shape : shapes_) {
      cpSpaceRemoveShape(space_, shape);
      cpShapeFree(shape);
    }
    for (cpBody* body : bodies_) {
      cpSpaceRemoveBody(space_, body);
      cpBodyFree(body);
    }
    cpSpaceFree(space_);
  }
  void step() override { cpSpaceStep(space_, dt_); }
  BodyState state(int body) const override {
    const cpBody* b = bodies_[static_cast<std::size_t>(body)];
    const cpVect p = cpBodyGetPosition(b);
    const cpVect v = cpBodyGetVelocity(b);
    return {{p.x, p.y}, cpBodyGetAngle(b), {v.x, v.y}, cpBodyGetAngularVelocity(b)};
  }
  double normal_force(int body) const override {
    struct Sum {
      Vec2 impulse;
    } sum;
    cpBodyEachArbiter(
        bodies_[static_cast<std::size_t>(body)],
        [](cpBody*, cpArbiter* arbiter, void* data) {
          // Only the total with friction is public; along the normal it is the normal part.
          const cpVect n = cpArbiterGetNormal(arbiter);
          const double along = cpvdot(cpArbiterTotalImpulse(arbiter), n);
          static_cast<Sum*>(data)->impulse += along * Vec2{n.x, n.y};
        },
        &sum);
    return length(sum.impulse) / dt_;
  }
  void push(int body, Vec2 impulse) override {
    cpBody* b = bodies_[static_cast<std::size_t>(body)];
    cpBodyApplyImpulseAtWorldPoint(b, convert(impulse), cpBodyGetPosition(b));
  }

 private:
  void add(const Scene& scene, const SceneBody& from) {
    cpBody* body = from.fixed ? cpBodyNewStatic() : cpBodyNew(from.mass, inertia_of(from));
    cpBodySetPosition(body, convert(from.position));
    cpBodySetAngle(body, from.angle);
    if (!from.fixed) {
      cpBodySetVelocity(body, convert(from.velocity));
      cpBodySetAngularVelocity(body, from.omega);
    }
    cpSpaceAddBody(space_, body);
    const SceneShape& s = from.shape;
    cpShape* shape = nullptr;
    if (s.form == Form::Disc) {
      shape = cpCircleShapeNew(body, s.radius, cpvzero);
    } else if (s.form == Form::Box) {
      shape = cpBoxShapeNew(body, s.size.x, s.size.y, 0);
    } else {
      std::vector<cpVect> corners;
      for (const Vec2 corner : corners_of(s)) corners.push_back(convert(corner));
      shape = cpPolyShapeNew(body, static_cast<int>(corners.size()), corners.data(), cpTransformIdentity, 0);
    }
    // Products of the two shapes' values: the roots give the scene's.
    cpShapeSetFriction(shape, std::sqrt(scene.friction));
    cpShapeSetElasticity(shape, std::sqrt(scene.restitution));
    cpSpaceAddShape(space_, shape);
    bodies_.push_back(body);
    shapes_.push_back(shape);
  }

  cpSpace* space_;
  double dt_;
  std::vector<cpBody*> bodies_;
  std::vector<cpShape*> shapes_;
  std::vector<cpConstraint*> constraints_;
};

std::unique_ptr<Engine> make(const Scene& scene, const Setting& setting) {
  return std::make_unique<Chipmunk>(scene, setting);
}

}  // namespace

EngineEntry chipmunk_entry() {
  EngineEntry entry;
  entry.name = "Chipmunk";
  entry.version = SKERRY_WITH_CHIPMUNK;
  entry.make = make;
  entry.curves = {{.label = "default"}, {.label = "best", .iterations = 100, .tuned = true}};
  return entry;
}

}  // namespace skerry::bench
