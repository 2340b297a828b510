// SPDX-License-Identifier: MIT
#include "tests/bench/accuracy/engine_skerry.h"

#include "physics/stepping/stepper.h"
#include "physics/world.h"

namespace skerry::bench {
namespace {

Shape shape_of(const SceneBody& body) {
  const SceneShape& s = body.shape;
  switch (s.form) {
    case Form::Disc:
      return make_disc(s.radius);
    case Form::Box:
      return make_box(s.size);
    case Form::Polygon:
      return make_polygon(s.corners);
    default:
      return make_half_plane({0, 0}, {0, 1});
  }
}

class SkerryEngine final : public Engine {
 public:
  SkerryEngine(const Scene& scene, const Setting& setting)
      : world_(make_world(scene, skerry_config(setting), bodies_)), dt_(setting.dt) {}
  void step() override { world_.step(dt_); }
  BodyState state(int body) const override {
    const BodyId id = bodies_[static_cast<std::size_t>(body)];
    return {world_.position(id), world_.angle(id), world_.velocity(id), world_.omega(id)};
  }
  void watch_forces() override { world_.observe({.contacts = true}); }
  double normal_force(int body) const override {
    const BodyId id = bodies_[static_cast<std::size_t>(body)];
    Vec2 sum;
    for (const ContactReport& contact : world_.report().contacts_list) {
      if (contact.body_a != id && contact.body_b != id) continue;
      for (int i = 0; i < contact.count; ++i)
        sum += (contact.body_b == id ? 1.0 : -1.0) *
               contact.points[static_cast<std::size_t>(i)].normal_impulse * contact.normal;
    }
    return length(sum) / dt_;
  }
  std::optional<double> released() const override {
    std::optional<double> found;
    for (const MotionEvent& event : world_.report().motion_events) {
      if (event.kind == MotionEventKind::Release) found = world_.time() - event.time;
    }
    return found;
  }
  void push(int body, Vec2 impulse) override {
    const BodyId id = bodies_[static_cast<std::size_t>(body)];
    world_.apply_impulse(id, impulse, world_.position(id));
  }

 private:
  std::vector<BodyId> bodies_;
  World world_;
  double dt_;
};

std::unique_ptr<Engine> make(const Scene& scene, const Setting& setting) {
  return std::make_unique<SkerryEngine>(scene, setting);
}

}  // namespace

WorldConfig skerry_config(const Setting& setting) {
  WorldConfig config;
  if (!setting.solver.empty()) config.solver = setting.solver;
  if (!setting.stepper.empty()) config.stepper = setting.stepper;
  if (setting.iterations > 0) config.solve.max_iterations = setting.iterations;
  if (setting.accuracy > 0) config.accuracy = setting.accuracy;
  config.threads = setting.threads;
  return config;
}

World make_world(const Scene& scene, WorldConfig config, std::vector<BodyId>& bodies) {
  config.gravity = scene.gravity;
  World world(config);
  bodies.clear();
  for (const SceneBody& body : scene.bodies) {
    BodyDef def;
    def.type = body.fixed ? BodyType::Static : BodyType::Dynamic;
    def.position = body.position;
    def.angle = body.angle;
    def.velocity = body.velocity;
    def.omega = body.omega;
    if (!body.fixed) {
      def.mass = body.mass;
      def.inertia = inertia_of(body);
    }
    bodies.push_back(world.create_body(def));
    ShapeDef shape;
    shape.shape = shape_of(body);
    shape.material.friction = scene.friction;
    shape.material.restitution = scene.restitution;
    world.add_shape(bodies.back(), shape);
  }
  for (const SceneJoint& joint : scene.joints) {
    JointDef def;
    def.kind = joint.link == Link::Pin ? JointKind::Revolute : JointKind::Distance;
    if (joint.a >= 0) def.a = bodies[static_cast<std::size_t>(joint.a)];
    def.b = bodies[static_cast<std::size_t>(joint.b)];
    def.anchor_a = joint.at_a;
    def.anchor_b = joint.link == Link::Pin ? joint.at_a : joint.at_b;
    world.create_joint(def);
  }
  return world;
}

EngineEntry skerry_entry() {
  EngineEntry entry;
  entry.name = "skerry";
  entry.version = SKERRY_VERSION;
  entry.ours = true;
  entry.make = make;
  for (const StepperEntry& stepper : steppers()) {
    Setting setting;
    setting.label = std::string(stepper.name);
    setting.stepper = stepper.name;
    setting.dense = stepper.name == "event_driven";
    entry.curves.push_back(setting);
  }
  for (const char* solver : {"nncg", "tgs_soft"}) {
    Setting setting;
    setting.label = solver;
    setting.solver = solver;
    setting.stepper = "time_stepping";
    entry.curves.push_back(setting);
  }
  return entry;
}

}  // namespace skerry::bench
