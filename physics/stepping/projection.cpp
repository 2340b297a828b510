// SPDX-License-Identifier: MIT
#include "physics/stepping/projection.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/island_rows.h"
#include "physics/stepping/touching.h"

namespace skerry {
namespace {

/// Errors below this are what rounding leaves [m]: a thousandth of the tolerance within which contacts count
/// as closed.
double position_floor(const WorldState& state, Vec2 where) {
  return 1e-3 * touch_tolerance(state, where);
}

bool carried_load(const WorldState& state, const RowOrigin& origin) {
  return !origin.joint && state.contacts[origin.index].points[origin.point].normal_impulse > 0;
}

/// Points that are near enough to be pushed into contact by a projection.
std::vector<std::uint8_t> near_points(const WorldState& state, const Island& island) {
  std::vector<std::uint8_t> points(island.contacts.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Manifold& manifold = state.contacts[island.contacts[k]].manifold;
    for (int i = 0; i < manifold.count; ++i) {
      if (manifold.points[i].separation <= state.config.contact_margin) points[k] |= 1u << i;
    }
  }
  return points;
}

/// True if a joint, an overlap or a loaded contact is farther off than rounding explains: a cheap look before
/// the rows are made.
bool needs_projection(const WorldState& state, const Island& island) {
  if (!island.joints.empty()) return true;
  for (const std::uint32_t index : island.contacts) {
    const Contact& contact = state.contacts[index];
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[i];
      const bool closed =
          contact.points[i].normal_impulse > 0 && point.separation <= state.config.contact_margin;
      const double error = closed ? std::abs(point.separation) : -point.separation;
      if (error > position_floor(state, point.position)) return true;
    }
  }
  return false;
}

/// Largest violation of the rows [m]; loaded contacts count gaps, too.
double position_error(const WorldState& state, const Assembly& assembly) {
  double worst = 0;
  for (const RowOrigin& origin : assembly.origin) {
    const bool closed =
        origin.kind == RowKind::Joint || (origin.kind == RowKind::Normal && carried_load(state, origin));
    worst = std::max(worst, closed ? std::abs(origin.error) : -origin.error);
  }
  return worst;
}

void solve_rows(const WorldState& state, const IslandSystem& system, IslandResult& result,
                std::vector<double>& lambda) {
  SolveOptions options;
  options.tolerance = 1e-12;
  Solution solution = state.solver->solve(system, {}, options, nullptr);
  result.work.factorisations += solution.work.factorisations;
  result.work.resolves += solution.work.resolves;
  lambda = std::move(solution.lambda);
}

}  // namespace

void project_positions(WorldState& state, const Island& island, double elapsed, IslandResult& result) {
  BodyArrays& all = state.bodies;
  double last = kInfinity;
  for (int round = 0; round < 5 && needs_projection(state, island); ++round) {
    const std::vector<std::uint8_t> points = near_points(state, island);
    Assembly assembly;
    AssemblyRequest request;
    request.points = &points;
    request.rope_slack = state.config.contact_margin;
    request.elapsed = elapsed;
    assemble(state, island, request, assembly);
    double extent = 0;
    for (const std::uint32_t body : island.bodies) {
      extent = std::max({extent, std::abs(all.position[body].x), std::abs(all.position[body].y)});
    }
    const double error = position_error(state, assembly);
    // Newton's iteration converges quadratically; when it no longer gains, the rest is rounding.
    if (error <= position_floor(state, {extent, extent}) || error > 0.5 * last) return;
    last = error;

    for (int i = 0; i < assembly.system.size(); ++i) {
      Row& row = assembly.system.rows[i];
      if (row.kind == RowKind::Normal && carried_load(state, assembly.origin[i])) {
        row.kind = RowKind::Joint;
        row.lower = -kInfinity;
      }
      assembly.system.b[i] = -assembly.origin[i].error;
    }
    std::vector<double> lambda;
    solve_rows(state, assembly.system, result, lambda);
    std::vector<Velocity> shift(island.bodies.size(), Velocity{});
    apply_impulses(assembly.system, lambda, shift);
    for (std::size_t k = 0; k < shift.size(); ++k) {
      const std::uint32_t body = island.bodies[k];
      all.position[body] += Vec2{shift[k][0], shift[k][1]};
      if (shift[k][2] != 0) {
        all.angle[body] += shift[k][2];
        all.rotation[body] = Rot::from_angle(all.angle[body]);
      }
      state.travelled[body] +=
          std::hypot(shift[k][0], shift[k][1]) + std::abs(shift[k][2]) * state.radius[body];
    }
    result.manifolds_reused += update_manifolds(state, island, elapsed, result.narrow);
  }
}

void project_velocities(WorldState& state, const Island& island, double elapsed, IslandResult& result) {
  std::vector<std::uint8_t> points(island.contacts.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    for (int i = 0; i < contact.manifold.count; ++i) {
      if (contact.points[i].normal_impulse > 0 && is_touching(state, contact.manifold.points[i]))
        points[k] |= 1u << i;
    }
  }
  Assembly assembly;
  AssemblyRequest request;
  request.points = &points;
  request.friction = true;
  request.rope_slack = -1;
  request.actuators = AssemblyRequest::Actuators::All;
  request.elapsed = elapsed;
  assemble(state, island, request, assembly);

  const std::vector<Velocity> before = island_velocities(state, island);
  double fastest = 0;
  for (const Velocity& v : before)
    fastest = std::max({fastest, std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});

  // Sliding and rolling rows are free here, and so are springs and motors that do not reach their speed; the
  // rest holds in both directions.
  IslandSystem& system = assembly.system;
  Assembly bilateral;
  bilateral.system.bodies = system.bodies;
  bilateral.system.positions = system.positions;
  for (int i = 0; i < system.size(); ++i) {
    const RowOrigin& origin = assembly.origin[i];
    if (origin.kind == RowKind::Rolling) continue;
    if (origin.kind == RowKind::Friction && !state.contacts[origin.index].points[origin.point].sticking)
      continue;
    if (origin.spring()) continue;
    if (origin.kind == RowKind::Motor && system.rows[i].upper < kInfinity) {
      const double force = state.joints[origin.index].row_force[origin.point];
      const bool reaches = std::abs(force) < system.rows[i].upper * (1 - 1e-9) &&
                           std::abs(row_velocity(assembly, i, before)) <= 1e-6 * (1 + fastest);
      if (!reaches) continue;
    }
    Row row = system.rows[i];
    row.kind = RowKind::Joint;
    row.lower = -kInfinity;
    row.upper = kInfinity;
    row.normal = -1;
    bilateral.system.rows.push_back(row);
    bilateral.origin.push_back(origin);
    bilateral.drive.push_back(assembly.drive[i]);
  }
  const auto violation = [&bilateral](const std::vector<Velocity>& v) {
    double worst = 0;
    for (int i = 0; i < bilateral.system.size(); ++i)
      worst = std::max(worst, std::abs(row_velocity(bilateral, i, v)));
    return worst;
  };
  const double error = violation(before);
  if (error <= 1e-13 * std::max(fastest, 1e-3)) return;

  bilateral.system.b.resize(bilateral.system.rows.size());
  for (int i = 0; i < bilateral.system.size(); ++i)
    bilateral.system.b[i] = -row_velocity(bilateral, i, before);
  std::vector<double> lambda;
  solve_rows(state, bilateral.system, result, lambda);
  std::vector<Velocity> after = before;
  apply_impulses(bilateral.system, lambda, after);
  if (violation(after) < error) store_velocities(state, island, after);
}

}  // namespace skerry
