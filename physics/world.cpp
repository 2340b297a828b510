// SPDX-License-Identifier: MIT
//
// Settings and sums of a world. Its bodies are in world_build.cpp and world_bodies.cpp, its joints in
// world_joints.cpp, the step in world_step.cpp.
#include "physics/world.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/solver/impact_law.h"
#include "physics/text.h"
#include "physics/world_access.h"

namespace skerry {
namespace {

void require_accuracy(const std::optional<double>& accuracy) {
  require(!accuracy || (*accuracy >= 1e-14 && *accuracy <= 1e-2), "accuracy must be from 1e-14 to 1e-2, got ",
          accuracy.value_or(0));
}

/// Refuses settings out of range.
void check(const WorldConfig& config) {
  require_finite(config.gravity, "gravity");
  require_at_least_zero(config.contact_margin, "contact_margin");
  require_at_least_zero(config.touch_tolerance, "touch_tolerance");
  require_at_least_zero(config.rest_speed, "rest_speed");
  require_at_least_zero(config.sleep_speed, "sleep_speed");
  require_at_least_zero(config.solve.work_limit, "solve.work_limit");
  require_at_least_zero(config.solve.tolerance, "solve.tolerance");
  require_at_least_zero(config.solve.time_budget, "solve.time_budget");
  require(config.solve.max_iterations >= 0, "solve.max_iterations must be >= 0, got ",
          config.solve.max_iterations);
  require_at_least_zero(config.flow_work.value_or(0), "flow_work");
  require_accuracy(config.accuracy);
  require(config.max_impacts_per_step >= 0, "max_impacts_per_step must be >= 0, got ",
          config.max_impacts_per_step);
  require(config.touch_tolerance <= config.contact_margin,
          "touch_tolerance must not exceed contact_margin, got ", config.touch_tolerance, " and ",
          config.contact_margin);
}

/// All names are looked up before any is taken.
void look_up_methods(WorldState& s, const WorldConfig& config) {
  const SolverEntry& solver = find_solver(config.solver);
  const ImpactLawEntry& impact_law = find_impact_law(config.impact_law);
  const StepperEntry& stepper = find_stepper(config.stepper);
  s.solver = &solver;
  s.impact_law = &impact_law;
  s.stepper = &stepper;
}

/// It shares the world's threads: those of a second pool would take turns with them on the same processors.
std::unique_ptr<BroadPhase> make_broad_phase(const WorldConfig& config, ThreadPool& pool) {
  BroadPhaseOptions options = config.broad_phase_options;
  options.pool = &pool;
  return make_broad_phase(config.broad_phase, options);
}

}  // namespace

void fill_broad_phase(WorldState& s) {
  for (std::uint32_t i = 0; i < s.shapes.size(); ++i) {
    const ShapeRecord& shape = s.shapes[i];
    if (!shape.alive || !shape.in_broad_phase) continue;
    const bool fixed = s.bodies.type[shape.body.index] == BodyType::Static;
    s.broad_phase->insert(i, shape.box, fixed ? ProxyKind::Fixed : ProxyKind::Moving);
  }
  s.broad_phase->moved_pairs(s.pairs);
}

World::World(WorldConfig config) : state_(std::make_unique<WorldState>()) {
  check(config);
  state_->pool = std::make_unique<ThreadPool>(config.threads);
  config.broad_phase_options.threads = config.threads;
  state_->broad_phase = make_broad_phase(config, *state_->pool);
  look_up_methods(*state_, config);
  state_->config = std::move(config);
}

void World::reconfigure(const WorldConfig& given) {
  WorldState& s = *state_;
  WorldConfig config = given;
  check(config);
  config.threads = config.broad_phase_options.threads = s.config.threads;
  std::unique_ptr<BroadPhase> broad_phase = make_broad_phase(config, *s.pool);
  look_up_methods(s, config);
  s.config = std::move(config);
  s.sleepers.wake_all(s);
  s.ledger.mark_all();
  s.memories.clear();
  forget_resting(s);
  s.graph_known = false;
  std::fill(s.step_memory.begin(), s.step_memory.end(), StepMemory{});
  s.broad_phase = std::move(broad_phase);
  fill_broad_phase(s);
}

World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

const StepReport& World::report() const {
  return state_->report;
}
double World::time() const {
  return state_->time;
}
void World::observe(const Observe& what) {
  WorldState& s = *state_;
  s.observe = what;
  if (what.contacts) return;
  // Sleepers have the number of an island only in the list that is made for an observer.
  for (const SleepingIsland& island : s.sleepers.islands())
    for (const std::uint32_t body : island.bodies) s.bodies.island[body] = -1;
}
const WorldConfig& World::config() const {
  return state_->config;
}

void World::set_accuracy(std::optional<double> accuracy) {
  require_accuracy(accuracy);
  WorldState& s = *state_;
  if (accuracy == s.config.accuracy) return;
  s.config.accuracy = accuracy;
  // Lengths that served another accuracy are no good first guess; what rested does so by another step.
  for (StepMemory& memory : s.step_memory) memory.inner_step = 0;
  s.sleepers.wake_all(s);
  forget_resting(s);
}

void World::set_gravity(Vec2 gravity) {
  require_finite(gravity, "gravity");
  if (gravity == state_->config.gravity) return;
  state_->config.gravity = gravity;
  state_->ledger.mark_all();
  state_->sleepers.wake_all(*state_);
}

const BodyArrays& World::bodies() const {
  return state_->bodies;
}
std::span<const ShapeRecord> World::shapes() const {
  return state_->shapes;
}
std::span<const JointRecord> World::joints() const {
  return state_->joints;
}
const BroadPhase& World::broad_phase() const {
  return *state_->broad_phase;
}

double World::kinetic_energy() const {
  return sum_bodies(state_->bodies, state_->config.gravity).kinetic;
}

double World::potential_energy() const {
  return sum_bodies(state_->bodies, state_->config.gravity).potential + spring_energy();
}

Vec2 World::momentum() const {
  return sum_bodies(state_->bodies, state_->config.gravity).momentum;
}

double World::angular_momentum() const {
  return sum_bodies(state_->bodies, state_->config.gravity).angular;
}

std::uint64_t World::state_hash() const {
  return sum_bodies(state_->bodies, state_->config.gravity).hash;
}

}  // namespace skerry
