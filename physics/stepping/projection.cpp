// SPDX-License-Identifier: MIT
#include "physics/stepping/projection.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/applied_forces.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/touching.h"

namespace skerry {
namespace {

/// Errors below this are what rounding leaves [m]: a thousandth of the tolerance within which contacts count
/// as closed.
double position_floor(const WorldState& state, Vec2 where) {
  return 1e-3 * touch_tolerance(state, where);
}

// Relative velocities below this share of the fastest are rounding.
constexpr double kVelocityFloor = 1e-13;

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

/// True if no contact or joint of the island is with something that does not react.
bool is_free(const WorldState& state, const Island& island) {
  const auto reacts = [&](std::uint32_t body) {
    return body != BodyId::kNone && state.local_index[body] >= 0;
  };
  return std::all_of(island.contacts.begin(), island.contacts.end(),
                     [&](std::uint32_t i) {
                       return reacts(state.contacts[i].body_a) && reacts(state.contacts[i].body_b);
                     }) &&
         std::all_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t i) {
           return reacts(state.joints[i].def.a.index) && reacts(state.joints[i].def.b.index);
         });
}

/// True if a kinematic body or a conveyor may bring energy.
bool ground_moves(const WorldState& state, const Island& island) {
  return std::any_of(island.contacts.begin(), island.contacts.end(), [&](std::uint32_t i) {
    const Contact& contact = state.contacts[i];
    return contact.surface_velocity != 0 || state.bodies.type[contact.body_a] == BodyType::Kinematic ||
           state.bodies.type[contact.body_b] == BodyType::Kinematic;
  });
}

/// Motion of an island as if it were one body.
struct RigidMotion {
  Vec2 centre, v;
  double omega = 0;
  double inertia = 0;   ///< about the centre [kg m^2]
  double momentum = 0;  ///< angular, about the centre [kg m^2/s]
  Vec2 at(Vec2 p) const { return v + omega * perp(p - centre); }
};

RigidMotion rigid_motion(const WorldState& state, const Island& island) {
  const BodyArrays& all = state.bodies;
  RigidMotion r;
  double mass = 0;
  for (const std::uint32_t i : island.bodies) {
    mass += all.mass[i];
    r.centre += all.mass[i] * all.position[i];
    r.v += all.mass[i] * all.velocity[i];
  }
  r.centre = r.centre / mass;
  r.v = r.v / mass;
  for (const std::uint32_t i : island.bodies) {
    const Vec2 arm = all.position[i] - r.centre;
    r.inertia += all.inertia[i] + all.mass[i] * length_squared(arm);
    r.momentum += all.inertia[i] * all.omega[i] + all.mass[i] * cross(arm, all.velocity[i] - r.v);
  }
  r.omega = r.inertia > 0 ? r.momentum / r.inertia : 0;
  return r;
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
      const Vec2 relative = point_velocity(state, contact.body_b, point.position, elapsed) -
                            point_velocity(state, contact.body_a, point.position, elapsed);
      if (std::abs(dot(contact.manifold.normal, relative)) > slack) return false;
      const double sliding = dot(perp(contact.manifold.normal), relative) - contact.surface_velocity;
      if (memory.sticking && std::abs(sliding) > slack) return false;
    }
  }
  return true;
}

/// Newton's iteration of `project_positions`.
void move_onto_constraints(WorldState& state, const Island& island, double elapsed, IslandResult& result) {
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

}  // namespace

void project_positions(WorldState& state, const Island& island, double elapsed, IslandResult& result) {
  if (!needs_projection(state, island)) return;
  // Moving bodies changes their angular momentum; a free island gets it back as a common rotation, which no
  // contact feels.
  const bool free = is_free(state, island);
  const double momentum = free ? rigid_motion(state, island).momentum : 0;
  move_onto_constraints(state, island, elapsed, result);
  if (!free) return;
  give_spin(state, island, momentum - rigid_motion(state, island).momentum);
}

void give_spin(WorldState& state, const Island& island, double momentum) {
  if (momentum == 0 || !is_free(state, island)) return;
  const RigidMotion now = rigid_motion(state, island);
  if (!(now.inertia > 0)) return;
  const double turn = momentum / now.inertia;
  BodyArrays& all = state.bodies;
  for (const std::uint32_t i : island.bodies) {
    all.velocity[i] += turn * perp(all.position[i] - now.centre);
    all.omega[i] += turn;
  }
}

void project_velocities(WorldState& state, const Island& island, double elapsed, IslandResult& result) {
  if (island.joints.empty() && velocities_hold(state, island, elapsed)) return;
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
  std::vector<int> bilateral_of(system.rows.size(), -1);
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
    bilateral_of[i] = bilateral.system.size();
    row.kind = RowKind::Joint;
    row.lower = -kInfinity;
    row.upper = kInfinity;
    row.normal = -1;
    row.mu = 0;
    bilateral.system.rows.push_back(row);
    bilateral.origin.push_back(origin);
    bilateral.drive.push_back(assembly.drive[i]);
  }
  // What slides or rolls at its bound changes with the load: a correction of the normal impulse brings its
  // friction with it. Without that, sliding along a curve would be of first order only.
  struct Companion {
    int row;       ///< of `assembly`
    int normal;    ///< of `bilateral`
    double share;  ///< of the normal impulse
  };
  std::vector<Companion> companions;
  for (int i = 0; i < system.size(); ++i) {
    const RowOrigin& origin = assembly.origin[i];
    if (origin.joint || origin.kind == RowKind::Normal) continue;
    const PointMemory& memory = state.contacts[origin.index].points[origin.point];
    const double impulse =
        origin.kind == RowKind::Friction ? memory.friction_impulse : memory.rolling_impulse;
    if (std::abs(impulse) < system.rows[i].mu * memory.normal_impulse * (1 - 1e-12)) continue;
    companions.push_back({i, bilateral_of[system.rows[i].normal], impulse / memory.normal_impulse});
  }
  const auto violation = [&bilateral](const std::vector<Velocity>& v) {
    double worst = 0;
    for (int i = 0; i < bilateral.system.size(); ++i)
      worst = std::max(worst, std::abs(row_velocity(bilateral, i, v)));
    return worst;
  };
  double error = violation(before);
  std::vector<Velocity> v = before;
  std::vector<double> lambda;
  bilateral.system.b.resize(bilateral.system.rows.size());
  // The friction that comes along disturbs the normal velocities a little, hence the rounds.
  for (int round = 0; round < 4 && error > kVelocityFloor * std::max(fastest, 1e-3); ++round) {
    for (int i = 0; i < bilateral.system.size(); ++i) bilateral.system.b[i] = -row_velocity(bilateral, i, v);
    solve_rows(state, bilateral.system, result, lambda);
    std::vector<Velocity> next = v;
    apply_impulses(bilateral.system, lambda, next);
    for (const Companion& companion : companions) {
      const Row& row = system.rows[companion.row];
      const double impulse = companion.share * lambda[companion.normal];
      if (row.a >= 0) push(system.bodies[row.a], row.Ja, impulse, next[row.a]);
      if (row.b >= 0) push(system.bodies[row.b], row.Jb, impulse, next[row.b]);
    }
    const double left = violation(next);
    if (!(left < error)) break;
    error = left;
    v = std::move(next);
  }
  store_velocities(state, island, v);
}

IslandEnergy::IslandEnergy(const WorldState& state, const Island& island) {
  const BodyArrays& all = state.bodies;
  for (const std::uint32_t i : island.bodies) {
    start_.push_back({all.position[i], all.angle[i]});
    kinetic_ += 0.5 * all.mass[i] * length_squared(all.velocity[i]) +
                0.5 * all.inertia[i] * all.omega[i] * all.omega[i];
  }
}

void IslandEnergy::take_gain(WorldState& state, const Island& island) const {
  if (!island.joints.empty() || ground_moves(state, island) || has_varying_forces(state, island)) return;
  BodyArrays& all = state.bodies;
  // Kinetic energy now, and the work of the external forces on the way.
  double gain = -kinetic_, kinetic = 0;
  for (std::size_t k = 0; k < start_.size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    const double m = all.mass[i], inertia = all.inertia[i];
    kinetic += 0.5 * m * length_squared(all.velocity[i]) + 0.5 * inertia * all.omega[i] * all.omega[i];
    gain -= m * dot(state.acceleration[i], all.position[i] - start_[k].position) +
            inertia * state.angular_acceleration[i] * (all.angle[i] - start_[k].angle);
  }
  gain += kinetic;
  if (!(gain > 1e-15 * kinetic)) return;
  // Only motion within the island gives: all contacts keep their velocity zero or opening, and a free island
  // its momentum.
  const RigidMotion rigid = is_free(state, island) ? rigid_motion(state, island) : RigidMotion{};
  double inner = 0;
  for (const std::uint32_t i : island.bodies) {
    const Vec2 v = all.velocity[i] - rigid.at(all.position[i]);
    const double w = all.omega[i] - rigid.omega;
    inner += 0.5 * all.mass[i] * length_squared(v) + 0.5 * all.inertia[i] * w * w;
  }
  if (!(inner > 0)) return;
  const double s = std::sqrt(std::max(0.0, 1 - gain / inner));
  for (const std::uint32_t i : island.bodies) {
    const Vec2 carried = rigid.at(all.position[i]);
    all.velocity[i] = carried + s * (all.velocity[i] - carried);
    all.omega[i] = rigid.omega + s * (all.omega[i] - rigid.omega);
  }
}

}  // namespace skerry
