// SPDX-License-Identifier: MIT
//
// Bullet in the plane, as in its own 2D demo: planar factors, 2D boxes and 2D convex shapes.
#include <BulletCollision/CollisionDispatch/btBox2dBox2dCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btConvex2dConvex2dAlgorithm.h>
#include <BulletCollision/CollisionShapes/btBox2dShape.h>
#include <BulletCollision/CollisionShapes/btConvex2dShape.h>
#include <BulletCollision/NarrowPhaseCollision/btMinkowskiPenetrationDepthSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include "tests/bench/accuracy/engine.h"

namespace skerry::bench {
namespace {

btVector3 convert(Vec2 v) {
  return btVector3(v.x, v.y, 0);
}

class Bullet final : public Engine {
 public:
  Bullet(const Scene& scene, const Setting& setting)
      : dispatcher_(&configuration_), convex_algorithm_(&simplex_, &penetration_), dt_(setting.dt) {
    dispatcher_.registerCollisionCreateFunc(CONVEX_2D_SHAPE_PROXYTYPE, CONVEX_2D_SHAPE_PROXYTYPE,
                                            &convex_algorithm_);
    dispatcher_.registerCollisionCreateFunc(BOX_2D_SHAPE_PROXYTYPE, CONVEX_2D_SHAPE_PROXYTYPE,
                                            &convex_algorithm_);
    dispatcher_.registerCollisionCreateFunc(CONVEX_2D_SHAPE_PROXYTYPE, BOX_2D_SHAPE_PROXYTYPE,
                                            &convex_algorithm_);
    dispatcher_.registerCollisionCreateFunc(BOX_2D_SHAPE_PROXYTYPE, BOX_2D_SHAPE_PROXYTYPE, &box_algorithm_);
    if (setting.solver == "mlcp") {
      solver_ = std::make_unique<btMLCPSolver>(&dantzig_);
    } else {
      solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
    }
    world_ = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broad_phase_, solver_.get(),
                                                       &configuration_);
    world_->setGravity(convert(scene.gravity));
    btContactSolverInfo& info = world_->getSolverInfo();
    if (setting.iterations > 0) info.m_numIterations = setting.iterations;
    if (setting.solver == "mlcp") info.m_minimumSolverBatchSize = 1;
    if (setting.tuned) info.m_restitutionVelocityThreshold = 0;
    for (const SceneBody& body : scene.bodies) add(scene, body, setting.tuned);
    for (const SceneJoint& joint : scene.joints) {
      btRigidBody& b = *bodies_[static_cast<std::size_t>(joint.b)];
      const btVector3 at_b = b.getWorldTransform().inverse() * convert(joint.at_a);
      if (joint.a < 0) {
        joints_.push_back(std::make_unique<btPoint2PointConstraint>(b, at_b));
      } else {
        btRigidBody& a = *bodies_[static_cast<std::size_t>(joint.a)];
        joints_.push_back(std::make_unique<btPoint2PointConstraint>(
            b, a, at_b, a.getWorldTransform().inverse() * convert(joint.at_a)));
      }
      world_->addConstraint(joints_.back().get(), true);
    }
  }
  ~Bullet() override {
    for (const auto& joint : joints_) world_->removeConstraint(joint.get());
    for (const auto& body : bodies_) world_->removeRigidBody(body.get());
  }
  void step() override { world_->stepSimulation(dt_, 0); }
  BodyState state(int body) const override {
    const btRigidBody& b = *bodies_[static_cast<std::size_t>(body)];
    const btMatrix3x3& q = b.getWorldTransform().getBasis();
    const btVector3& p = b.getWorldTransform().getOrigin();
    return {{p.x(), p.y()},
            std::atan2(q[1][0], q[0][0]),
            {b.getLinearVelocity().x(), b.getLinearVelocity().y()},
            b.getAngularVelocity().z()};
  }
  double normal_force(int body) const override {
    const btRigidBody* const self = bodies_[static_cast<std::size_t>(body)].get();
    Vec2 sum;
    for (int k = 0; k < world_->getDispatcher()->getNumManifolds(); ++k) {
      const btPersistentManifold* manifold = world_->getDispatcher()->getManifoldByIndexInternal(k);
      if (manifold->getBody0() != self && manifold->getBody1() != self) continue;
      const double sign = manifold->getBody0() == self ? 1.0 : -1.0;
      for (int i = 0; i < manifold->getNumContacts(); ++i) {
        const btManifoldPoint& point = manifold->getContactPoint(i);
        sum +=
            sign * point.getAppliedImpulse() * Vec2{point.m_normalWorldOnB.x(), point.m_normalWorldOnB.y()};
      }
    }
    return length(sum) / dt_;
  }
  void push(int body, Vec2 impulse) override {
    bodies_[static_cast<std::size_t>(body)]->activate();
    bodies_[static_cast<std::size_t>(body)]->applyCentralImpulse(convert(impulse));
  }

 private:
  void add(const Scene& scene, const SceneBody& from, bool tuned) {
    const SceneShape& s = from.shape;
    Vec2 centre = from.position;
    if (s.form == Form::Disc) {
      cores_.push_back(std::make_unique<btCylinderShapeZ>(btVector3(s.radius, s.radius, 0.5)));
      shapes_.push_back(std::make_unique<btConvex2dShape>(static_cast<btConvexShape*>(cores_.back().get())));
    } else if (s.form == Form::Box) {
      shapes_.push_back(std::make_unique<btBox2dShape>(btVector3(s.size.x / 2, s.size.y / 2, 0.5)));
    } else if (s.form == Form::HalfPlane) {
      // As in the 2D demo the ground is a box.
      shapes_.push_back(std::make_unique<btBox2dShape>(btVector3(s.extent / 2, s.extent / 4, 0.5)));
      centre = centre + rotate(Rot::from_angle(from.angle), {0, -s.extent / 4});
    } else {
      // Its margin goes round the hull.
      const double margin = 0.005;
      auto hull = std::make_unique<btConvexHullShape>();
      for (const Vec2 corner : inset(s.corners, margin)) {
        hull->addPoint(btVector3(corner.x, corner.y, -0.5), false);
        hull->addPoint(btVector3(corner.x, corner.y, 0.5), false);
      }
      hull->recalcLocalAabb();
      hull->setMargin(margin);
      cores_.push_back(std::move(hull));
      shapes_.push_back(std::make_unique<btConvex2dShape>(static_cast<btConvexShape*>(cores_.back().get())));
    }
    btTransform pose(btQuaternion(btVector3(0, 0, 1), from.angle), convert(centre));
    motions_.push_back(std::make_unique<btDefaultMotionState>(pose));
    const double inertia = from.fixed ? 0 : inertia_of(from);
    btRigidBody::btRigidBodyConstructionInfo info(from.fixed ? 0 : from.mass, motions_.back().get(),
                                                  shapes_.back().get(), btVector3(inertia, inertia, inertia));
    // Products of the two bodies' values: the roots give the scene's.
    info.m_friction = std::sqrt(scene.friction);
    info.m_restitution = std::sqrt(scene.restitution);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& body = *bodies_.back();
    if (!from.fixed) {
      body.setLinearFactor(btVector3(1, 1, 0));
      body.setAngularFactor(btVector3(0, 0, 1));
      body.setLinearVelocity(convert(from.velocity));
      body.setAngularVelocity(btVector3(0, 0, from.omega));
      if (tuned) body.setActivationState(DISABLE_DEACTIVATION);
    }
    world_->addRigidBody(&body);
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broad_phase_;
  btVoronoiSimplexSolver simplex_;
  btMinkowskiPenetrationDepthSolver penetration_;
  btConvex2dConvex2dAlgorithm::CreateFunc convex_algorithm_;
  btBox2dBox2dCollisionAlgorithm::CreateFunc box_algorithm_;
  btDantzigSolver dantzig_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  double dt_;
  std::vector<std::unique_ptr<btCollisionShape>> cores_, shapes_;
  std::vector<std::unique_ptr<btMotionState>> motions_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
};

std::unique_ptr<Engine> make(const Scene& scene, const Setting& setting) {
  return std::make_unique<Bullet>(scene, setting);
}

}  // namespace

EngineEntry bullet_entry() {
  EngineEntry entry;
  entry.name = "Bullet";
  entry.version = SKERRY_WITH_BULLET;
  entry.rods = false;
  entry.make = make;
  entry.curves = {{.label = "default"},
                  {.label = "best", .iterations = 100, .tuned = true},
                  {.label = "MLCP", .tuned = true, .solver = "mlcp", .dense = true}};
  return entry;
}

}  // namespace skerry::bench
