// SPDX-License-Identifier: MIT
//
// ODE in the plane: every body on a plane-2D joint, discs as spheres. Boxes are 3D boxes whose contacts of
// the front face are kept: they are the two points of the plane. Double precision.
#include <array>
#include <ode/ode.h>

#include "tests/bench/accuracy/engine.h"

namespace skerry::bench {
namespace {

class Ode final : public Engine {
 public:
  Ode(const Scene& scene, const Setting& setting)
      : scene_friction_(scene.friction),
        scene_restitution_(scene.restitution),
        dt_(setting.dt),
        exact_(setting.solver != "quick"),
        bounce_speed_(setting.tuned ? 0 : 0.01) {
    [[maybe_unused]] static const bool ready = [] {
      dInitODE2(0);
      // What its LCP solver has to say on standard error is said by the result.
      dSetMessageHandler([](int, const char*, va_list) {});
      return true;
    }();
    dAllocateODEDataForThread(dAllocateMaskAll);
    dRandSetSeed(1);
    world_ = dWorldCreate();
    space_ = dHashSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, scene.gravity.x, scene.gravity.y, 0);
    if (setting.iterations > 0) dWorldSetQuickStepNumIterations(world_, setting.iterations);
    for (const SceneBody& body : scene.bodies) add(body);
    for (const SceneJoint& joint : scene.joints) {
      dBodyID a = joint.a < 0 ? nullptr : bodies_[static_cast<std::size_t>(joint.a)];
      dBodyID b = bodies_[static_cast<std::size_t>(joint.b)];
      if (joint.link == Link::Pin) {
        dJointID pin = dJointCreateBall(world_, nullptr);
        dJointAttach(pin, b, a);
        dJointSetBallAnchor(pin, joint.at_a.x, joint.at_a.y, 0);
      } else {
        dJointID rod = dJointCreateDBall(world_, nullptr);
        dJointAttach(rod, b, a);
        dJointSetDBallAnchor1(rod, joint.at_b.x, joint.at_b.y, 0);
        dJointSetDBallAnchor2(rod, joint.at_a.x, joint.at_a.y, 0);
      }
    }
  }
  ~Ode() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }
  void watch_forces() override { watched_ = true; }
  void step() override {
    dJointGroupEmpty(contacts_);
    feedback_.clear();
    dSpaceCollide(space_, this,
                  [](void* self, dGeomID a, dGeomID b) { static_cast<Ode*>(self)->touch(a, b); });
    if (watched_) {
      for (Feedback& f : feedback_) dJointSetFeedback(f.joint, &f.force);
    }
    if (exact_) {
      dWorldStep(world_, dt_);
    } else {
      dWorldQuickStep(world_, dt_);
    }
    // As its manual asks of planar bodies: no rotation out of the plane.
    for (const dBodyID body : bodies_) {
      if (body == nullptr) continue;
      const dReal* w = dBodyGetAngularVel(body);
      dBodySetAngularVel(body, 0, 0, w[2]);
      const dReal* q = dBodyGetQuaternion(body);
      dReal flat[4] = {q[0], 0, 0, q[3]};
      const dReal norm = std::sqrt(flat[0] * flat[0] + flat[3] * flat[3]);
      if (!(norm > 0)) continue;
      flat[0] /= norm;
      flat[3] /= norm;
      dBodySetQuaternion(body, flat);
    }
  }
  BodyState state(int body) const override {
    const dBodyID b = bodies_[static_cast<std::size_t>(body)];
    if (b == nullptr) return {};
    const dReal* p = dBodyGetPosition(b);
    const dReal* q = dBodyGetQuaternion(b);
    const dReal* v = dBodyGetLinearVel(b);
    return {{p[0], p[1]}, 2 * std::atan2(q[3], q[0]), {v[0], v[1]}, dBodyGetAngularVel(b)[2]};
  }
  double normal_force(int body) const override {
    const dBodyID self = bodies_[static_cast<std::size_t>(body)];
    Vec2 sum;
    for (const Feedback& f : feedback_) {
      if (dJointGetBody(f.joint, 0) != self && dJointGetBody(f.joint, 1) != self) continue;
      const dReal* force = dJointGetBody(f.joint, 0) == self ? f.force.f1 : f.force.f2;
      sum += dot(Vec2{force[0], force[1]}, f.normal) * f.normal;
    }
    return length(sum);
  }
  void push(int body, Vec2 impulse) override {
    const dBodyID b = bodies_[static_cast<std::size_t>(body)];
    dMass mass;
    dBodyGetMass(b, &mass);
    const dReal* v = dBodyGetLinearVel(b);
    dBodySetLinearVel(b, v[0] + impulse.x / mass.mass, v[1] + impulse.y / mass.mass, 0);
  }

 private:
  struct Feedback {
    dJointID joint;
    Vec2 normal;
    dJointFeedback force;
  };

  void touch(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (body_a == nullptr && body_b == nullptr) return;
    if (body_a != nullptr && body_b != nullptr &&
        dAreConnectedExcluding(body_a, body_b, dJointTypeContact) != 0)
      return;
    std::array<dContact, 16> found{};
    const int count = dCollide(a, b, static_cast<int>(found.size()), &found[0].geom, sizeof(dContact));
    const bool discs = dGeomGetClass(a) == dSphereClass || dGeomGetClass(b) == dSphereClass;
    for (int i = 0; i < count; ++i) {
      dContact& contact = found[static_cast<std::size_t>(i)];
      if (!discs && contact.geom.pos[2] <= 0) continue;
      contact.geom.pos[2] = 0;
      // Coulomb's law: friction bounded by mu times the normal force rather than by a constant.
      contact.surface.mode = dContactApprox1 | dContactBounce;
      contact.surface.mu = scene_friction_;
      contact.surface.bounce = scene_restitution_;
      contact.surface.bounce_vel = bounce_speed_;
      if (scene_restitution_ == 0) contact.surface.mode = dContactApprox1;
      const dJointID joint = dJointCreateContact(world_, contacts_, &contact);
      dJointAttach(joint, body_a, body_b);
      if (watched_) feedback_.push_back({joint, {contact.geom.normal[0], contact.geom.normal[1]}, {}});
    }
  }

  void add(const SceneBody& from) {
    const SceneShape& s = from.shape;
    dGeomID geom = nullptr;
    if (s.form == Form::HalfPlane) {
      const Vec2 n = rotate(Rot::from_angle(from.angle), {0, 1});
      dCreatePlane(space_, n.x, n.y, 0, dot(n, from.position));
      bodies_.push_back(nullptr);
      return;
    }
    geom = s.form == Form::Disc ? dCreateSphere(space_, s.radius) : dCreateBox(space_, s.size.x, s.size.y, 1);
    dMatrix3 rotation;
    dRFromAxisAndAngle(rotation, 0, 0, 1, from.angle);
    if (from.fixed) {
      dGeomSetPosition(geom, from.position.x, from.position.y, 0);
      dGeomSetRotation(geom, rotation);
      bodies_.push_back(nullptr);
      return;
    }
    const dBodyID body = dBodyCreate(world_);
    dMass mass;
    const double inertia = inertia_of(from);
    dMassSetParameters(&mass, from.mass, 0, 0, 0, inertia, inertia, inertia, 0, 0, 0);
    dBodySetMass(body, &mass);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, from.position.x, from.position.y, 0);
    dBodySetRotation(body, rotation);
    dBodySetLinearVel(body, from.velocity.x, from.velocity.y, 0);
    dBodySetAngularVel(body, 0, 0, from.omega);
    dJointAttach(dJointCreatePlane2D(world_, nullptr), body, nullptr);
    bodies_.push_back(body);
  }

  double scene_friction_, scene_restitution_, dt_;
  bool exact_;
  double bounce_speed_;
  bool watched_ = false;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  std::vector<dBodyID> bodies_;
  std::vector<Feedback> feedback_;
};

std::unique_ptr<Engine> make(const Scene& scene, const Setting& setting) {
  return std::make_unique<Ode>(scene, setting);
}

}  // namespace

EngineEntry ode_entry() {
  EngineEntry entry;
  entry.name = "ODE";
  entry.version = SKERRY_WITH_ODE;
  entry.polygons = false;
  entry.make = make;
  entry.curves = {{.label = "quick default", .solver = "quick"},
                  {.label = "quick best", .iterations = 200, .tuned = true, .solver = "quick"},
                  {.label = "exact (Dantzig)", .tuned = true, .dense = true}};
  return entry;
}

}  // namespace skerry::bench
