// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "physics/spare.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/projection_rows.h"
#include "physics/stepping/touching.h"
#include "physics/thread_pool.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Relative velocities below this share of the fastest are rounding.
constexpr double kVelocityFloor = 1e-13;
// The same after an integration to rounding, which must keep the energy for 1e5 steps.
constexpr double kFineVelocityFloor = 1e-16;
// Velocities above this share of the fastest that are left violate rows.
constexpr double kHeld = 1e-6;
// Rows that a thread takes at a time.
constexpr std::size_t kRowsAPiece = 2048;

/// True if no loaded contact moves along its normal, nor a sticking one along its tangent, beyond rounding: a
/// look without rows, for islands without joints.
bool velocities_hold(const WorldState& state, const Island& island, double elapsed) {
  const BodyArrays& all = state.bodies;
  double fastest = 1e-3;
  for (const std::uint32_t i : island.bodies)
    fastest =
        std::max({fastest, std::abs(all.velocity[i].x), std::abs(all.velocity[i].y), std::abs(all.omega[i])});
  const double slack = kVelocityFloor * fastest;
  for (const std::uint32_t index : island.contacts) {
    const Contact& contact = state.contacts[index];
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[i];
      const PointMemory& memory = contact.points[i];
      if (!(memory.normal_impulse > 0) || !is_touching(state, point)) continue;
      const Vec2 relative = relative_velocity(state, contact, point.position, elapsed);
      if (std::abs(dot(contact.manifold.normal, relative)) > slack) return false;
      const double sliding = dot(perp(contact.manifold.normal), relative) - contact.surface_velocity;
      if (memory.sticking && std::abs(sliding) > slack) return false;
    }
  }
  return true;
}

/// What pushed a row of a piece [N s].
double load_of(const WorldState& state, const RowOrigin& origin, double h) {
  if (origin.joint) return h * state.joints[origin.index].row_force[origin.point];
  return state.contacts[origin.index].points[origin.point].normal_impulse;
}

/// Contacts and limits that the corrections would pull by more than their load pushed in a piece of the
/// length `h` [s] are open. @return whether there were
bool let_open(WorldState& state, const Assembly& bilateral, const std::vector<double>& lambda, double h) {
  bool any = false;
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    const RowOrigin& origin = bilateral.origin[i];
    if (!is_kept_closed(state, origin) || !(load_of(state, origin, h) + lambda[i] < 0)) continue;
    open_row(state, origin);
    any = true;
  }
  return any;
}

/// What a projection corrects belongs to the load of the piece: only with it is the load of second order.
void add_to_loads(WorldState& state, const Assembly& bilateral, const std::vector<double>& lambda) {
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    const RowOrigin& origin = bilateral.origin[i];
    if (origin.joint) continue;
    PointMemory& memory = state.contacts[origin.index].points[origin.point];
    if (origin.kind == RowKind::Normal) {
      // Friction at its bound stays there.
      const double load = std::max(memory.normal_impulse + lambda[i], 1e-300);
      if (!memory.sticking) memory.friction_impulse *= load / memory.normal_impulse;
      memory.rolling_impulse *= load / memory.normal_impulse;
      memory.normal_impulse = load;
      memory.total_normal += lambda[i];
    } else {
      memory.friction_impulse += lambda[i];
    }
  }
}

/// What slides or rolls at its bound changes with the load: a correction of the normal impulse brings its
/// friction with it. Without that, sliding along a curve would be of first order only.
struct Companion {
  int row;       ///< of the full assembly
  int normal;    ///< of the bilateral one
  double share;  ///< of the normal impulse
};

/// What a projection of velocities needs for a moment.
struct VelocityScratch {
  Assembly full, bilateral;
  std::vector<Companion> companions;
  std::vector<int> bilateral_of;  ///< by row of `full`
  std::vector<std::uint8_t> points, limits;
  std::vector<Velocity> v, next;
  std::vector<double> lambda;
};

/// The contacts and limits that carry load, with all joints: rows at the present geometry.
void assemble_loaded(const WorldState& state, const Island& island, double elapsed,
                     VelocityScratch& scratch) {
  std::vector<std::uint8_t>& points = scratch.points;
  points.assign(island.contacts.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    for (int i = 0; i < contact.manifold.count; ++i) {
      if (contact.points[i].normal_impulse > 0 && is_touching(state, contact.manifold.points[i]))
        points[k] |= 1u << i;
    }
  }
  AssemblyRequest request;
  request.points = &points;
  request.friction = true;
  scratch.limits.resize(island.joints.size());
  std::transform(island.joints.begin(), island.joints.end(), scratch.limits.begin(),
                 [&](std::uint32_t slot) { return state.held_rows[slot]; });
  request.limits = &scratch.limits;
  request.actuators = AssemblyRequest::Actuators::All;
  request.elapsed = elapsed;
  assemble(state, island, request, scratch.full);
}

/// True if a row holds both ways: sliding and rolling rows are free, and so are springs and motors that do
/// not reach their speed.
/// @param known  `WorldState::held_rows` says which motors did in the last piece
bool holds_both_ways(const WorldState& state, const Assembly& full, int i, const std::vector<Velocity>& v,
                     double fastest, bool known) {
  const RowOrigin& origin = full.origin[i];
  if (origin.kind == RowKind::Rolling || origin.spring()) return false;
  if (origin.kind == RowKind::Friction) return state.contacts[origin.index].points[origin.point].sticking;
  const Row& row = full.system.rows[i];
  if (origin.kind != RowKind::Motor || !(row.upper < kInfinity)) return true;
  if (known) return (state.held_rows[origin.index] >> origin.point & 1) != 0;
  const double force = state.joints[origin.index].row_force[origin.point];
  return std::abs(force) < row.upper * (1 - 1e-9) &&
         std::abs(row_velocity(full, i, v)) <= 1e-6 * (1 + fastest);
}

void free_of_bounds(Row& row) {
  row.kind = RowKind::Joint;
  row.lower = -kInfinity;
  row.upper = kInfinity;
  row.normal = -1;
  row.mu = 0;
}

/// The rows of `scratch.full` that hold both ways, without bounds, and what comes along with them.
/// @return `scratch.bilateral`, or `scratch.full` itself where that is all of it
Assembly& select_bilateral(const WorldState& state, const std::vector<Velocity>& v, double fastest,
                           bool known, VelocityScratch& scratch) {
  Assembly& full = scratch.full;
  const IslandSystem& system = full.system;
  const int count = system.size();
  int selected = 0;
  scratch.bilateral_of.assign(system.rows.size(), -1);
  for (int i = 0; i < count; ++i) {
    if (holds_both_ways(state, full, i, v, fastest, known)) scratch.bilateral_of[i] = selected++;
  }
  for (int i = 0; i < count; ++i) {
    const RowOrigin& origin = full.origin[i];
    // Static friction holds more than that of sliding.
    if (origin.joint || origin.kind == RowKind::Normal || scratch.bilateral_of[i] >= 0) continue;
    const PointMemory& memory = state.contacts[origin.index].points[origin.point];
    const double impulse =
        origin.kind == RowKind::Friction ? memory.friction_impulse : memory.rolling_impulse;
    if (std::abs(impulse) < system.rows[i].mu * memory.normal_impulse * (1 - 1e-12)) continue;
    scratch.companions.push_back(
        {i, scratch.bilateral_of[system.rows[i].normal], impulse / memory.normal_impulse});
  }
  if (selected == count && scratch.companions.empty()) {
    std::for_each(full.system.rows.begin(), full.system.rows.end(), free_of_bounds);
    return full;
  }
  Assembly& bilateral = scratch.bilateral;
  bilateral.drop_rows();
  bilateral.system.bodies = system.bodies;
  bilateral.system.positions = system.positions;
  for (int i = 0; i < count; ++i) {
    if (scratch.bilateral_of[i] < 0) continue;
    free_of_bounds(bilateral.system.rows.emplace_back(system.rows[i]));
    bilateral.origin.push_back(full.origin[i]);
    bilateral.drive.push_back(full.drive[i]);
  }
  return bilateral;
}

}  // namespace

VelocityShift project_velocities(WorldState& state, const Island& island, double elapsed, double pushed,
                                 IslandResult& result, Assembly* rows) {
  if (island.joints.empty() && velocities_hold(state, island, elapsed)) return {};
  Spare<VelocityScratch> scratch;
  std::vector<Velocity>&v = scratch->v, &next = scratch->next;
  island_velocities(state, island, v);
  double fastest = 0;
  for (const Velocity& one : v)
    fastest = std::max({fastest, std::abs(one[0]), std::abs(one[1]), std::abs(one[2])});
  // Joints that only hold slide nowhere, and so nothing comes along.
  const bool ready = rows != nullptr;
  std::vector<Companion>& companions = scratch->companions;
  companions.clear();
  if (!ready) assemble_loaded(state, island, elapsed, *scratch);
  Assembly& bilateral = ready ? *rows : select_bilateral(state, v, fastest, pushed > 0, *scratch);
  const IslandSystem& system = scratch->full.system;  // of the companions
  std::vector<double>& wanted = bilateral.system.b;
  wanted.resize(bilateral.system.rows.size());
  // The largest violation, which is what the next round is to take away.
  const auto violation = [&](const std::vector<Velocity>& u) {
    return largest_of(state.island_threads, wanted.size(), kRowsAPiece,
                      [&](std::size_t from, std::size_t to) {
                        double most = 0;
                        for (std::size_t i = from; i < to; ++i) {
                          const double speed = row_velocity(bilateral, static_cast<int>(i), u);
                          wanted[i] = -speed;
                          most = std::max(most, std::abs(speed));
                        }
                        return most;
                      });
  };
  VelocityShift done;
  double error = violation(v);
  std::vector<double>& lambda = scratch->lambda;
  // The friction that comes along disturbs the normal velocities a little, hence the rounds.
  // What is left does work against the joints' forces all the way to the next projection.
  const double floor = (pushed > 0 ? kVelocityFloor : kFineVelocityFloor) * std::max(fastest, 1e-3);
  for (int round = 0; round < 4 && error > floor; ++round) {
    next = v;
    solve_for_motion(state, SolvePurpose::Velocities, bilateral, floor, result, lambda, next);
    if (pushed > 0 && round == 0 && let_open(state, bilateral, lambda, pushed))
      return project_velocities(state, island, elapsed, pushed, result);
    for (const Companion& companion : companions) {
      const Row& row = system.rows[companion.row];
      const double impulse = companion.share * lambda[companion.normal];
      if (row.a >= 0) push(system.bodies[row.a], row.Ja, impulse, next[row.a]);
      if (row.b >= 0) push(system.bodies[row.b], row.Jb, impulse, next[row.b]);
    }
    const double left = violation(next);
    if (!(left < error)) break;
    for (const Companion& companion : companions) {
      const Row& row = system.rows[companion.row];
      const double impulse = companion.share * lambda[companion.normal];
      // Each impulse works against the mean of the velocities before and after it.
      if (row.a >= 0) done.friction += 0.5 * impulse * (along(row.Ja, v[row.a]) + along(row.Ja, next[row.a]));
      if (row.b >= 0) done.friction += 0.5 * impulse * (along(row.Jb, v[row.b]) + along(row.Jb, next[row.b]));
    }
    error = left;
    done.brought += work_of_drive(bilateral, lambda);
    std::swap(v, next);
    if (pushed > 0) add_to_loads(state, bilateral, lambda);
  }
  store_velocities(state, island, v);
  done.holds = !(error > kHeld * std::max(fastest, 1e-3));
  return done;
}

}  // namespace skerry
