// SPDX-License-Identifier: MIT
#include "physics/stepping/island_rows.h"

#include "physics/contact_batch.h"
#include "physics/joint_rows.h"
#include "physics/spare.h"
#include "physics/stepping/touching.h"

namespace skerry {
namespace {

// Contacts from which on the narrow phase takes them in groups of four.
constexpr std::size_t kBatch = 4;

Velocity body_velocity(const WorldState& state, std::uint32_t body) {
  return {state.bodies.velocity[body].x, state.bodies.velocity[body].y, state.bodies.omega[body]};
}

Velocity kinematic_velocity(const WorldState& state, std::uint32_t body, double elapsed) {
  const KinematicState now = kinematic_state(state, body, elapsed);
  return {now.v.x, now.v.y, now.omega};
}

/// Number in the island; -1 for the ground and for bodies that do not react.
int local_index(const WorldState& state, std::uint32_t body) {
  return body == BodyId::kNone ? -1 : state.local_index[body];
}

bool moves_by_itself(const WorldState& state, std::uint32_t body) {
  return body != BodyId::kNone && state.bodies.type[body] == BodyType::Kinematic;
}

/// Adds an empty row between two bodies. @return the row, to be filled before `finish_row`
Row& begin_row(const WorldState& state, RowKind kind, std::uint32_t body_a, std::uint32_t body_b,
               Assembly& out) {
  Row& row = out.system.rows.emplace_back();
  row.kind = kind;
  row.a = local_index(state, body_a);
  row.b = local_index(state, body_b);
  return row;
}

/// What a body outside the island contributes to the last row moves into its drive.
/// @param elapsed  since the beginning of the step [s]
[[gnu::always_inline]] inline void finish_row(const WorldState& state, double elapsed, std::uint32_t body_a,
                                              std::uint32_t body_b, Row& row, double drive, Assembly& out) {
  if (row.a < 0) {
    if (moves_by_itself(state, body_a)) drive += along(row.Ja, kinematic_velocity(state, body_a, elapsed));
    row.Ja = {};
  }
  if (row.b < 0) {
    if (moves_by_itself(state, body_b)) drive += along(row.Jb, kinematic_velocity(state, body_b, elapsed));
    row.Jb = {};
  }
  out.drive.push_back(drive);
}

Transform pose_of(const WorldState& state, const AssemblyRequest& request, std::uint32_t body) {
  const int local = local_index(state, body);
  return request.poses != nullptr && local >= 0 ? (*request.poses)[local]
                                                : pose_at(state, body, request.elapsed);
}

JointEnd end_of(const WorldState& state, const AssemblyRequest& request, std::uint32_t body) {
  JointEnd end = joint_end(state, body, request.elapsed);
  const int local = local_index(state, body);
  if (request.poses == nullptr || local < 0) return end;
  end.p = (*request.poses)[local].p;
  end.q = (*request.poses)[local].q;
  end.angle = (*request.angles)[local];
  return end;
}

bool is_wanted(const AssemblyRequest& request, const JointRow& row) {
  using enum AssemblyRequest::Actuators;
  switch (row.kind) {
    case JointRowKind::Hold:
      return true;
    case JointRowKind::Limit:
      return row.error <= request.rope_slack;
    case JointRowKind::Motor:
      return request.actuators == All || (request.actuators == Rigid && row.most == kInfinity);
    case JointRowKind::Spring:
      return request.actuators == All;
  }
  return false;
}

void add_joint(const WorldState& state, const AssemblyRequest& request, std::uint32_t slot, Assembly& out) {
  const JointRecord& joint = state.joints[slot];
  const std::uint32_t a = joint.def.a.index;
  const std::uint32_t b = joint.def.b.index;
  JointRows geometry;
  const int count = joint_rows(joint, end_of(state, request, a), end_of(state, request, b), geometry);
  for (int k = 0; k < count; ++k) {
    const JointRow& from = geometry[k];
    if (!is_wanted(request, from)) continue;
    const RowKind kind = from.kind == JointRowKind::Hold    ? RowKind::Joint
                         : from.kind == JointRowKind::Limit ? RowKind::Limit
                                                            : RowKind::Motor;
    Row& row = begin_row(state, kind, a, b, out);
    row.Ja = from.Ja;
    row.Jb = from.Jb;
    row.lower = kind == RowKind::Limit ? 0 : -from.most;
    row.upper = from.most;
    row.source = (std::uint64_t{slot} << 3 | static_cast<unsigned>(k)) | std::uint64_t{1} << 63;
    finish_row(state, request.elapsed, a, b, row, -from.speed, out);
    out.origin.push_back({kind, true, slot, k, from.error, from.stiffness, from.damping});
  }
}

void add_point(const WorldState& state, const AssemblyRequest& request, const Manifold& manifold,
               std::uint32_t index, int i, Assembly& out) {
  const Contact& contact = state.contacts[index];
  const ManifoldPoint& point = manifold.points[i];
  const Vec2 n = manifold.normal;
  const Vec2 t = perp(n);
  const Vec2 ra = point.position - pose_of(state, request, contact.body_a).p;
  const Vec2 rb = point.position - pose_of(state, request, contact.body_b).p;

  const std::uint64_t source = contact.source(i);
  const int normal = out.system.size();
  const auto add = [&](RowKind kind, const std::array<double, 3>& Ja, const std::array<double, 3>& Jb,
                       double mu, double drive, double error) {
    Row& row = begin_row(state, kind, contact.body_a, contact.body_b, out);
    row.Ja = Ja;
    row.Jb = Jb;
    row.source = source;
    if (kind != RowKind::Normal) {
      row.lower = -kInfinity;
      row.normal = normal;
      row.mu = mu;
    }
    finish_row(state, request.elapsed, contact.body_a, contact.body_b, row, drive, out);
    out.origin.push_back({kind, false, index, i, error});
  };
  add(RowKind::Normal, {-n.x, -n.y, -cross(ra, n)}, {n.x, n.y, cross(rb, n)}, 0, 0, point.separation);
  if (!request.friction) return;
  if (contact.friction > 0 || !state.config.skips.smooth_rows)
    add(RowKind::Friction, {-t.x, -t.y, -cross(ra, t)}, {t.x, t.y, cross(rb, t)}, contact.friction,
        -contact.surface_velocity, 0);
  if (contact.rolling_resistance > 0)
    add(RowKind::Rolling, {0, 0, -1}, {0, 0, 1}, contact.rolling_resistance, 0, 0);
}

}  // namespace

void assemble(const WorldState& state, const Island& island, const AssemblyRequest& request, Assembly& out) {
  out.clear();
  for (const std::uint32_t body : island.bodies) {
    out.system.bodies.push_back({state.bodies.inverse_mass[body], state.bodies.inverse_inertia[body]});
    out.system.positions.push_back(pose_of(state, request, body).p);
  }
  for (const std::uint32_t joint : island.joints) add_joint(state, request, joint, out);
  for (std::size_t k = 0; k < island.contacts.size(); ++k) {
    const std::uint32_t index = island.contacts[k];
    const Manifold& manifold =
        request.manifolds != nullptr ? (*request.manifolds)[k] : state.contacts[index].manifold;
    for (int i = 0; i < manifold.count; ++i) {
      if (((*request.points)[k] >> i & 1) != 0) add_point(state, request, manifold, index, i, out);
    }
  }
  out.system.b.assign(out.system.rows.size(), 0);
}

std::vector<Velocity> island_velocities(const WorldState& state, const Island& island) {
  std::vector<Velocity> v = take_spare<std::vector<Velocity>>();
  island_velocities(state, island, v);
  return v;
}

void island_velocities(const WorldState& state, const Island& island, std::vector<Velocity>& v) {
  v.resize(island.bodies.size());
  for (std::size_t k = 0; k < v.size(); ++k) v[k] = body_velocity(state, island.bodies[k]);
}

void add_free_motion(const WorldState& state, const Island& island, double h, std::vector<Velocity>& v) {
  for (std::size_t k = 0; k < v.size(); ++k) {
    const std::uint32_t body = island.bodies[k];
    v[k][0] += h * state.acceleration[body].x;
    v[k][1] += h * state.acceleration[body].y;
    v[k][2] += h * state.angular_acceleration[body];
  }
}

void store_velocities(WorldState& state, const Island& island, const std::vector<Velocity>& v) {
  for (std::size_t k = 0; k < island.bodies.size(); ++k) {
    state.bodies.velocity[island.bodies[k]] = {v[k][0], v[k][1]};
    state.bodies.omega[island.bodies[k]] = v[k][2];
  }
}

int update_manifolds(WorldState& state, const Island& island, double elapsed, NarrowPhaseStats& stats) {
  int reused = 0;
  // A few contacts are no batch.
  if (island.contacts.size() < kBatch) {
    for (const std::uint32_t index : island.contacts) {
      Contact& contact = state.contacts[index];
      reused += !refresh_manifold(
          contact, state.shapes[contact.shape_a].shape, pose_at(state, contact.body_a, elapsed),
          state.shapes[contact.shape_b].shape, pose_at(state, contact.body_b, elapsed), contact.margin,
          state.config.skips, stats);
    }
    return reused;
  }
  ManifoldRefresh manifolds(state.config.skips, stats, [](Contact&) {});
  for (const std::uint32_t index : island.contacts) {
    Contact& contact = state.contacts[index];
    reused += !manifolds.refresh(contact, state.shapes[contact.shape_a].shape,
                                 pose_at(state, contact.body_a, elapsed), state.shapes[contact.shape_b].shape,
                                 pose_at(state, contact.body_b, elapsed), contact.margin);
  }
  manifolds.finish();
  return reused;
}

}  // namespace skerry
