// SPDX-License-Identifier: MIT
#include "physics/resting.h"

#include <algorithm>

#include "physics/hash.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/point_memory.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

/// The force solve gave back the impulses from which it started, and nothing collided.
bool impulses_unchanged(const Contact& contact) {
  for (int i = 0; i < 2; ++i) {
    const PointMemory& now = contact.points[i];
    const PointForces& before = contact.points_at_start[i];
    if (now.feature != before.feature || now.normal_impulse != before.normal_impulse ||
        now.friction_impulse != before.friction_impulse || now.rolling_impulse != before.rolling_impulse ||
        now.h != before.h || now.sticking != before.sticking) {
      return false;
    }
  }
  return true;
}

/// True if what acts on the island may be another at the next time: there is a field, something moves as
/// told, or a joint holds on to what moves by itself, so that a limit or a slack rope may be reached.
bool may_act_otherwise(const WorldState& s, const Island& island) {
  return s.field || meets_prescribed_motion(s, island) ||
         std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t i) {
           const JointDef& def = s.joints[i].def;
           return moves_as_told(s, def.a.index) || moves_as_told(s, def.b.index);
         });
}

}  // namespace

bool stood_still(const WorldState& s, const Island& island) {
  const BodyArrays& b = s.bodies;
  return std::all_of(island.bodies.begin(), island.bodies.end(), [&](std::uint32_t i) {
    const BodyBackup& from = s.backup[i];
    return b.velocity[i] == Vec2{} && b.omega[i] == 0 && from.velocity == Vec2{} && from.omega == 0 &&
           b.position[i] == from.position && b.angle[i] == from.angle;
  });
}

std::uint64_t resting_key(const WorldState& s, const Island& island, double h) {
  Fnv1a hash;
  hash.add(h);
  const BodyArrays& b = s.bodies;
  for (const std::uint32_t i : island.bodies) {
    hash.add(std::uint64_t{i} << 32 | b.generation[i]);
    for (const double value : {b.position[i].x, b.position[i].y, b.angle[i], b.velocity[i].x, b.velocity[i].y,
                               b.omega[i], b.inverse_mass[i], b.inverse_inertia[i], s.acceleration[i].x,
                               s.acceleration[i].y, s.angular_acceleration[i]}) {
      hash.add(value);
    }
    // How the step is made depends on what acts, whatever it amounts to at rest, and on the steps before it.
    hash.add(static_cast<std::uint32_t>(s.drag[i].any()));
    const StepMemory& memory = s.step_memory[i];
    for (const int value : {memory.busy, memory.flow, memory.light_failures, memory.light_wait,
                            memory.near_rest, memory.held, memory.stopped})
      hash.add(static_cast<std::uint32_t>(value));
    hash.add(memory.slow);
    hash.add(memory.inner_step);
  }
  for (const std::uint32_t index : island.contacts) {
    const Contact& c = s.contacts[index];
    hash.add(std::uint64_t{c.shape_a} << 32 | c.shape_b);
    hash.add(std::uint64_t{s.shapes[c.shape_a].generation} << 32 | s.shapes[c.shape_b].generation);
    hash.add(static_cast<std::uint32_t>(c.child));
  }
  for (const std::uint32_t i : island.joints) {
    const JointRecord& joint = s.joints[i];
    hash.add(std::uint64_t{i} << 32 | joint.generation);
    // The motor's aim may change while nothing moves.
    hash.add(joint.def.motor_speed.value_or(0));
    hash.add(joint.def.motor_limit);
    // Ends that are not of the island may have been moved, or move by themselves.
    for (const std::uint32_t body : {joint.def.a.index, joint.def.b.index}) {
      if (body == BodyId::kNone || s.local_index[body] >= 0) continue;
      for (const double value : {b.position[body].x, b.position[body].y, b.angle[body], b.velocity[body].x,
                                 b.velocity[body].y, b.omega[body]}) {
        hash.add(value);
      }
    }
  }
  return hash.value();
}

bool reuse_resting(WorldState& s, const Island& island, double h, IslandResult& result) {
  if (s.resting.empty() || s.observe.systems || !s.config.reuse_resting) return false;
  if (may_act_otherwise(s, island)) return false;
  for (const std::uint32_t index : island.contacts) {
    const Contact& c = s.contacts[index];
    // Other poses, of fixed bodies too, mean other geometry.
    if (!c.manifold_reused || moves_as_told(s, c.body_a) || moves_as_told(s, c.body_b)) return false;
  }
  const std::uint64_t key = resting_key(s, island, h);
  const auto found =
      std::lower_bound(s.resting.begin(), s.resting.end(), key,
                       [](const RestingIsland& known, std::uint64_t k) { return known.key < k; });
  if (found == s.resting.end() || found->key != key || found->strayed.size() != island.bodies.size())
    return false;

  result.report = found->report;
  result.step_memory = s.step_memory[island.bodies.front()];
  result.friction_rows = found->friction_rows;
  result.at_rest = true;
  result.substeps = 1;
  for (std::size_t k = 0; k < island.bodies.size(); ++k) s.strayed[island.bodies[k]] = found->strayed[k];
  repeat_forces(s, island, h);
  for (const std::uint64_t memory_key : found->memory_keys) {
    const auto memory =
        std::lower_bound(s.memories.begin(), s.memories.end(), memory_key,
                         [](const IslandMemory& kept, std::uint64_t k) { return kept.key < k; });
    if (memory != s.memories.end() && memory->key == memory_key && memory->memory != nullptr) {
      result.memories.push_back({memory_key, std::move(memory->memory)});
    }
  }
  return true;
}

std::optional<RestingIsland> remember_resting(const WorldState& s, const Island& island, double h,
                                              const IslandResult& result) {
  if (!s.config.reuse_resting || result.in_flight || result.substeps != 1 || result.impacts > 0) return {};
  if (!stood_still(s, island)) return {};
  // What still waits for something would make another step of the same state.
  for (const std::uint32_t i : island.bodies)
    if (s.step_memory[i] != result.step_memory) return {};
  if (may_act_otherwise(s, island)) return {};
  for (const std::uint32_t index : island.contacts) {
    if (!impulses_unchanged(s.contacts[index])) return {};
  }
  for (const std::uint32_t i : island.joints) {
    const std::array<double, kMaxJointRows>& before = s.joint_start[i].row_force;
    if (!std::equal(before.begin(), before.end(), std::begin(s.joints[i].row_force))) return {};
  }
  RestingIsland known;
  known.key = resting_key(s, island, h);
  known.report = result.report;
  known.friction_rows = result.friction_rows;
  for (const IslandMemory& memory : result.memories) known.memory_keys.push_back(memory.key);
  known.strayed.reserve(island.bodies.size());
  for (const std::uint32_t i : island.bodies) known.strayed.push_back(s.strayed[i]);
  return known;
}

}  // namespace skerry
