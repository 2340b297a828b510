// SPDX-License-Identifier: MIT
#include "physics/stepping/joint_midpoint.h"

#include <algorithm>
#include <cmath>

#include "physics/disjoint_sets.h"
#include "physics/joint_rows.h"
#include "physics/solver/bilateral.h"
#include "physics/spare.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/solver_memories.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

constexpr int kMostRounds = 4;
// A round that leaves more than this share of the errors does not converge, or left their rounding.
constexpr double kConverging = 0.5;
// Joints that are off by this share of the touch tolerance are closed. Rows that repeat each other would
// contradict each other by what is left, and a motor among them pays for that with any force.
constexpr double kClosed = 1e-4;

struct MidpointScratch {
  std::vector<std::uint8_t> no_points;
  Assembly rows;
  std::vector<Velocity> shift;
  std::vector<Transform> poses;
  std::vector<double> angles;
};

}  // namespace

bool holds_always(const JointDef& def) {
  switch (def.kind) {
    case JointKind::Rope:
    case JointKind::Spring:
    case JointKind::Motor:
      return false;
    case JointKind::Distance:
      return held_rows(def) > 0;
    default:
      return true;
  }
}

bool has_loops_of_joints(const WorldState& state, const Island& island) {
  if (island.joints.size() < 2) return false;
  const std::size_t ground = island.bodies.size();
  DisjointSets sets(ground + 1);
  const auto node = [&](BodyId body) {
    const int local = body.index == BodyId::kNone ? -1 : state.local_index[body.index];
    return local >= 0 ? local : static_cast<int>(ground);
  };
  return std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t slot) {
    const JointDef& def = state.joints[slot].def;
    return holds_always(def) && !sets.join(node(def.a), node(def.b));
  });
}

void hold_joints(WorldState& state, const Island& island, double elapsed, std::vector<Transform>& poses,
                 std::vector<double>& angles, IslandResult& result) {
  Spare<MidpointScratch> scratch;
  scratch->no_points.assign(island.contacts.size(), 0);
  scratch->poses = poses;
  scratch->angles = angles;
  AssemblyRequest request;
  request.points = &scratch->no_points;
  request.poses = &scratch->poses;
  request.angles = &scratch->angles;
  request.rope_slack = -kInfinity;
  request.elapsed = elapsed;
  double last = kInfinity;
  for (int round = 0; round <= kMostRounds; ++round) {
    assemble(state, island, request, scratch->rows);
    IslandSystem& system = scratch->rows.system;
    double error = 0;
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      system.b[i] = -scratch->rows.origin[i].error;
      error = std::max(error, std::abs(system.b[i]));
    }
    if (!(error < kConverging * last)) break;
    // The first places are those that were given.
    if (round > 0) {
      poses = scratch->poses;
      angles = scratch->angles;
    }
    if (error <= kClosed * state.config.touch_tolerance || round == kMostRounds) break;
    last = error;
    SolveOptions options;
    options.threads = state.island_threads;
    MemoryLoan memory(state, result, SolvePurpose::Midpoints, system);
    Solution solution = solve_without_bounds(system, options, memory.get());
    result.work += solution.work;
    scratch->shift.assign(island.bodies.size(), Velocity{});
    apply_impulses(system, solution.lambda, scratch->shift);
    give_spare(std::move(solution.lambda));
    for (std::size_t k = 0; k < scratch->shift.size(); ++k) {
      const Velocity& shift = scratch->shift[k];
      scratch->angles[k] += shift[2];
      scratch->poses[k] = {scratch->poses[k].p + Vec2{shift[0], shift[1]},
                           Rot::from_angle(scratch->angles[k])};
    }
  }
}

}  // namespace skerry
