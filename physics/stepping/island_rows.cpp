// SPDX-License-Identifier: MIT
#include "physics/stepping/island_rows.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "physics/contact_batch.h"
#include "physics/joint_rows.h"
#include "physics/spare.h"
#include "physics/stepping/flush_faces.h"
#include "physics/stepping/touching.h"

namespace skerry {
namespace {

// Contacts from which on the narrow phase takes them in groups of four.
constexpr std::size_t kBatch = 4;
// Contacts, or joints, that a thread takes at a time: some 50 us.
constexpr std::size_t kContactsAPiece = 256;

/// What one piece of the contacts found.
struct PieceCount {
  int reused = 0;
  NarrowPhaseStats stats;
};

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

/// Two bodies as their rows see them, for all rows of a contact or joint.
struct Ends {
  std::uint32_t body_a, body_b;
  int a, b;  ///< numbers in the island, or -1
};

Ends ends_of(const WorldState& state, std::uint32_t body_a, std::uint32_t body_b) {
  return {body_a, body_b, local_index(state, body_a), local_index(state, body_b)};
}

/// Writes the rows of an assembly over those of the last time: where the number of rows stays, nothing is
/// constructed.
class RowWriter {
 public:
  /// @param out  whose lists become as long as that of the rows @param first  row to write
  explicit RowWriter(Assembly& out, std::size_t first = 0) : out_(out), count_(first) {
    resize(out.system.rows.size());
  }

  int count() const { return static_cast<int>(count_); }

  /// Adds a row with its blocks; bounds, `normal` and `mu` are left to the caller. What a body outside the
  /// island contributes to it moves into its drive.
  /// @param elapsed  since the beginning of the step [s]
  [[gnu::always_inline]] Row& add(const WorldState& state, double elapsed, const RowOrigin& origin,
                                  const Ends& ends, const std::array<double, 3>& Ja,
                                  const std::array<double, 3>& Jb, double drive, std::uint64_t source) {
    if (count_ == size_) resize(size_ + size_ / 8 + 8);
    Row& row = out_.system.rows[count_];
    row.kind = origin.kind;
    row.a = ends.a;
    row.b = ends.b;
    row.source = source;
    const auto block = [&](int local, std::uint32_t body, const std::array<double, 3>& J) {
      if (local >= 0) return J;
      if (moves_by_itself(state, body)) drive += along(J, kinematic_velocity(state, body, elapsed));
      return std::array<double, 3>{};
    };
    row.Ja = block(ends.a, ends.body_a, Ja);
    row.Jb = block(ends.b, ends.body_b, Jb);
    out_.drive[count_] = drive;
    out_.system.b[count_] = 0;
    out_.origin[count_] = origin;
    ++count_;
    return row;
  }

  void finish() {
    if (count_ != size_) resize(count_);
  }
  void resize(std::size_t size) {
    resize_with_room(out_.system.rows, size);
    resize_with_room(out_.system.b, size);
    resize_with_room(out_.drive, size);
    resize_with_room(out_.origin, size);
    size_ = size;
  }

 private:
  Assembly& out_;
  std::size_t size_ = 0, count_;
};

/// Where the body of number `local` is that a request asks for.
Vec2 centre_of(const WorldState& state, const AssemblyRequest& request, std::uint32_t body, int local) {
  return request.poses != nullptr && local >= 0 ? (*request.poses)[static_cast<std::size_t>(local)].p
                                                : pose_at(state, body, request.elapsed).p;
}

JointEnd end_of(const WorldState& state, const AssemblyRequest& request, std::uint32_t body, int local) {
  if (request.poses == nullptr || local < 0) return joint_end(state, body, request.elapsed);
  // The rows of an assembly depend on places only.
  const Transform& pose = (*request.poses)[static_cast<std::size_t>(local)];
  return {.p = pose.p, .q = pose.q, .angle = (*request.angles)[static_cast<std::size_t>(local)], .v = {}};
}

/// Slack of a limit, now or ahead.
double slack_of(const WorldState& state, const AssemblyRequest& request, const Ends& ends,
                const JointRow& row) {
  if (request.velocities == nullptr) return row.error;
  const auto rate = [&](std::uint32_t body, int local, const std::array<double, 3>& J) {
    if (local >= 0) return along(J, (*request.velocities)[static_cast<std::size_t>(local)]);
    return body != BodyId::kNone && moves_by_itself(state, body)
               ? along(J, kinematic_velocity(state, body, request.elapsed))
               : 0;
  };
  return row.error + request.ahead * (rate(ends.body_a, ends.a, row.Ja) + rate(ends.body_b, ends.b, row.Jb));
}

/// How far the smaller body of a row of angles reaches, which is what an angle moves [m]; 1 for other rows.
double arm_of(const WorldState& state, const Ends& ends, const JointRow& row) {
  if (row.Jb[0] != 0 || row.Jb[1] != 0 || row.Ja[0] != 0 || row.Ja[1] != 0) return 1;
  double arm = kInfinity;
  if (ends.a >= 0) arm = state.radius[ends.body_a];
  if (ends.b >= 0) arm = std::min(arm, state.radius[ends.body_b]);
  return arm;
}

/// @param k  among the rows of the joint `number` of the island
bool is_wanted(const WorldState& state, const AssemblyRequest& request, std::size_t number, const Ends& ends,
               int k, const JointRow& row) {
  using enum AssemblyRequest::Actuators;
  switch (row.kind) {
    case JointRowKind::Hold:
      return true;
    case JointRowKind::Limit:
      if (request.limits != nullptr) return ((*request.limits)[number] >> k & 1) != 0;
      return slack_of(state, request, ends, row) * (request.slack_at_ends ? arm_of(state, ends, row) : 1) <=
             request.rope_slack;
    case JointRowKind::Motor:
      return request.actuators == All || (request.actuators == Rigid && row.most == kInfinity);
    case JointRowKind::Spring:
      return request.actuators == All;
  }
  return false;
}

/// Calls `visit(ends, k, row)` for the rows of the joint `number` of an island that are asked for.
template <class Visit>
void for_joint_rows(const WorldState& state, const Island& island, const AssemblyRequest& request,
                    std::size_t number, Visit&& visit) {
  const JointRecord& joint = state.joints[island.joints[number]];
  const Ends ends = ends_of(state, joint.def.a.index, joint.def.b.index);
  JointRows geometry;
  const int count = joint_geometry(joint, end_of(state, request, ends.body_a, ends.a),
                                   end_of(state, request, ends.body_b, ends.b), geometry);
  for (int k = 0; k < count; ++k) {
    const JointRow& row = geometry[static_cast<std::size_t>(k)];
    if (is_wanted(state, request, number, ends, k, row)) visit(ends, k, row);
  }
}

/// How many rows `add_joint` adds.
std::size_t rows_of_joint(const WorldState& state, const Island& island, const AssemblyRequest& request,
                          std::size_t number) {
  const int held = held_rows(state.joints[island.joints[number]].def);
  if (held >= 0) return static_cast<std::size_t>(held);
  std::size_t count = 0;
  for_joint_rows(state, island, request, number, [&](const Ends&, int, const JointRow&) { ++count; });
  return count;
}

std::uint64_t source_of_joint(std::uint32_t slot, int k) {
  return (std::uint64_t{slot} << 3 | static_cast<unsigned>(k)) | std::uint64_t{1} << 63;
}

/// The rows of a hinge that is nothing but a hinge, which most joints are: those of `joint_geometry`, at
/// less than half of the cost.
void add_hinge(const WorldState& state, const AssemblyRequest& request, std::uint32_t slot, RowWriter& rows) {
  const JointRecord& joint = state.joints[slot];
  const Ends ends = ends_of(state, joint.def.a.index, joint.def.b.index);
  const JointEnd a = end_of(state, request, ends.body_a, ends.a),
                 b = end_of(state, request, ends.body_b, ends.b);
  const Vec2 ra = rotate(a.q, joint.local_a), rb = rotate(b.q, joint.local_b);
  const Vec2 apart = (b.p - a.p) + (rb - ra);
  const auto hold = [&](int k, double error, const std::array<double, 3>& Ja,
                        const std::array<double, 3>& Jb) {
    Row& row = rows.add(state, request.elapsed, {RowKind::Joint, true, slot, k, error, 0, 0}, ends, Ja, Jb, 0,
                        source_of_joint(slot, k));
    row.lower = -kInfinity;
    row.upper = kInfinity;
    row.normal = -1;
    row.mu = 0;
  };
  hold(0, apart.x, {-1, 0, ra.y}, {1, 0, -rb.y});
  hold(1, apart.y, {0, -1, -ra.x}, {0, 1, rb.x});
}

void add_joint(const WorldState& state, const Island& island, const AssemblyRequest& request,
               std::size_t number, RowWriter& rows) {
  const std::uint32_t slot = island.joints[number];
  const JointDef& def = state.joints[slot].def;
  if (def.kind == JointKind::Revolute && held_rows(def) > 0) return add_hinge(state, request, slot, rows);
  for_joint_rows(state, island, request, number, [&](const Ends& ends, int k, const JointRow& from) {
    const RowKind kind = from.kind == JointRowKind::Hold    ? RowKind::Joint
                         : from.kind == JointRowKind::Limit ? RowKind::Limit
                                                            : RowKind::Motor;
    Row& row =
        rows.add(state, request.elapsed, {kind, true, slot, k, from.error, from.stiffness, from.damping},
                 ends, from.Ja, from.Jb, -from.speed, source_of_joint(slot, k));
    row.lower = kind == RowKind::Limit ? 0 : -from.most;
    row.upper = from.most;
    row.normal = -1;
    row.mu = 0;
  });
}

bool rubs(const WorldState& state, const AssemblyRequest& request, const Contact& contact) {
  return request.friction && (contact.friction > 0 || !state.config.skips.smooth_rows);
}

bool resists(const AssemblyRequest& request, const Contact& contact) {
  return request.friction && contact.rolling_resistance > 0;
}

/// How many rows `add_contact` adds.
std::size_t rows_of_contact(const WorldState& state, const AssemblyRequest& request, const Manifold& manifold,
                            std::uint32_t index, std::uint8_t points) {
  const Contact& contact = state.contacts[index];
  const auto asked = static_cast<unsigned>(std::popcount(points & ((1u << manifold.count) - 1u)));
  return asked * (1u + rubs(state, request, contact) + resists(request, contact));
}

/// The points of a contact that are asked for. @param points  their bits
void add_contact(const WorldState& state, const AssemblyRequest& request, const Manifold& manifold,
                 std::uint32_t index, std::uint8_t points, RowWriter& rows) {
  const Contact& contact = state.contacts[index];
  const Ends ends = ends_of(state, contact.body_a, contact.body_b);
  const Vec2 pa = centre_of(state, request, ends.body_a, ends.a);
  const Vec2 pb = centre_of(state, request, ends.body_b, ends.b);
  const Vec2 n = manifold.normal;
  const Vec2 t = perp(n);
  const bool with_friction = rubs(state, request, contact), with_rolling = resists(request, contact);
  for (int i = 0; i < manifold.count; ++i) {
    if ((points >> i & 1) == 0) continue;
    const ManifoldPoint& point = manifold.points[static_cast<std::size_t>(i)];
    const Vec2 ra = point.position - pa;
    const Vec2 rb = point.position - pb;
    const std::uint64_t source = contact.source(i);
    const int normal = rows.count();
    Row& row = rows.add(state, request.elapsed, {RowKind::Normal, false, index, i, point.separation}, ends,
                        {-n.x, -n.y, -cross(ra, n)}, {n.x, n.y, cross(rb, n)}, 0, source);
    row.lower = 0;
    row.upper = kInfinity;
    row.normal = -1;
    row.mu = 0;
    const auto bound = [normal](Row& scaled, double mu) {
      scaled.lower = -kInfinity;
      scaled.upper = kInfinity;
      scaled.normal = normal;
      scaled.mu = mu;
    };
    if (with_friction) {
      bound(
          rows.add(state, request.elapsed, {RowKind::Friction, false, index, i, 0}, ends,
                   {-t.x, -t.y, -cross(ra, t)}, {t.x, t.y, cross(rb, t)}, -contact.surface_velocity, source),
          contact.friction);
    }
    if (with_rolling) {
      bound(rows.add(state, request.elapsed, {RowKind::Rolling, false, index, i, 0}, ends, {0, 0, -1},
                     {0, 0, 1}, 0, source),
            contact.rolling_resistance);
    }
  }
}

}  // namespace

void assemble(const WorldState& state, const Island& island, const AssemblyRequest& request, Assembly& out) {
  const std::size_t count = island.bodies.size();
  if (out.system.bodies.size() != count) out.system.bodies.resize(count);
  if (out.system.positions.size() != count) out.system.positions.resize(count);
  out.system.compliance.clear();
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t body = island.bodies[k];
    out.system.bodies[k] = {state.bodies.inverse_mass[body], state.bodies.inverse_inertia[body]};
    out.system.positions[k] = centre_of(state, request, body, static_cast<int>(k));
  }
  // Joints and then contacts are numbered through. Calls `joint(number)` for each joint among some, and
  // `contact(manifold, index, points)` for the contacts that are asked for.
  const std::size_t joints = island.joints.size(), items = joints + island.contacts.size();
  const auto visit = [&](std::size_t from, std::size_t to, auto&& joint, auto&& contact) {
    for (std::size_t k = from; k < std::min(to, joints); ++k) joint(k);
    for (std::size_t k = std::max(from, joints) - joints; k + joints < to; ++k) {
      const std::uint32_t index = island.contacts[k];
      const std::uint8_t points = (*request.points)[k];
      if (points == 0) continue;
      contact(request.manifolds != nullptr ? (*request.manifolds)[k] : state.contacts[index].manifold, index,
              points);
    }
  };
  const auto add = [&](std::size_t from, std::size_t to, RowWriter& rows) {
    visit(
        from, to, [&](std::size_t number) { add_joint(state, island, request, number, rows); },
        [&](const Manifold& manifold, std::uint32_t index, std::uint8_t points) {
          add_contact(state, request, manifold, index, points, rows);
        });
  };
  if (state.island_threads == nullptr || items <= kContactsAPiece) {
    RowWriter rows(out);
    add(0, items, rows);
    rows.finish();
    return;
  }
  // Where the rows of each piece begin is counted first.
  Spare<std::vector<std::size_t>> begin;
  begin->assign((items + kContactsAPiece - 1) / kContactsAPiece + 1, 0);
  share(state.island_threads, items, kContactsAPiece, [&](std::size_t from, std::size_t to) {
    std::size_t rows = 0;
    visit(
        from, to, [&](std::size_t number) { rows += rows_of_joint(state, island, request, number); },
        [&](const Manifold& manifold, std::uint32_t index, std::uint8_t points) {
          rows += rows_of_contact(state, request, manifold, index, points);
        });
    (*begin)[from / kContactsAPiece + 1] = rows;
  });
  std::partial_sum(begin->begin(), begin->end(), begin->begin());
  if (begin->back() != out.system.rows.size()) RowWriter(out).resize(begin->back());
  share(state.island_threads, items, kContactsAPiece, [&](std::size_t from, std::size_t to) {
    RowWriter rows(out, (*begin)[from / kContactsAPiece]);
    add(from, to, rows);
  });
}

void keep_known(const Assembly& before, const std::vector<double>& lambda, const Assembly& after,
                std::vector<double>& out) {
  out.resize(after.origin.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const bool known = next < before.origin.size() && before.origin[next].is_same(after.origin[i]);
    out[i] = known ? lambda[next++] : 0;
  }
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

double work_of_drive(const Assembly& assembly, const std::vector<double>& lambda) {
  return -std::inner_product(lambda.begin(), lambda.end(), assembly.drive.begin(), 0.0);
}

double most_of_drive(const WorldState& state, const Assembly& assembly, const std::vector<double>& lambda,
                     double elapsed, double h) {
  double most = work_of_drive(assembly, lambda);
  for (std::size_t i = 0; i < lambda.size() && !state.kinematic.empty(); ++i) {
    const RowOrigin& origin = assembly.origin[i];
    if (lambda[i] == 0 || origin.joint) continue;
    const Contact& contact = state.contacts[origin.index];
    const Vec2 where = contact.manifold.points[static_cast<std::size_t>(origin.point)].position;
    for (const std::uint32_t body : {contact.body_a, contact.body_b}) {
      if (state.local_index[body] >= 0 || state.bodies.type[body] != BodyType::Kinematic) continue;
      const Vec2 now = point_velocity(state, body, where, elapsed);
      most += std::abs(lambda[i]) * length(point_velocity(state, body, where + h * now, elapsed + h) - now);
    }
  }
  return most;
}

int update_manifolds(WorldState& state, const Island& island, double elapsed, NarrowPhaseStats& stats) {
  // A few contacts are no batch.
  if (island.contacts.size() < kBatch) {
    int reused = 0;
    for (const std::uint32_t index : island.contacts) {
      Contact& contact = state.contacts[index];
      reused += !refresh_manifold(
          contact, state.shapes[contact.shape_a].shape, pose_at(state, contact.body_a, elapsed),
          state.shapes[contact.shape_b].shape, pose_at(state, contact.body_b, elapsed), contact.margin,
          state.config.skips, stats);
      pass_flush_face(state, contact, elapsed);
    }
    return reused;
  }
  const auto refresh = [&](std::size_t from, std::size_t to, NarrowPhaseStats& counts) {
    int reused = 0;
    ManifoldRefresh manifolds(state.config.skips, counts,
                              [&](Contact& contact) { pass_flush_face(state, contact, elapsed); });
    for (std::size_t k = from; k < to; ++k) {
      Contact& contact = state.contacts[island.contacts[k]];
      reused += !manifolds.refresh(
          contact, state.shapes[contact.shape_a].shape, pose_at(state, contact.body_a, elapsed),
          state.shapes[contact.shape_b].shape, pose_at(state, contact.body_b, elapsed), contact.margin);
    }
    manifolds.finish();
    return reused;
  };
  const std::size_t contacts = island.contacts.size();
  if (state.island_threads == nullptr || contacts <= kContactsAPiece) return refresh(0, contacts, stats);
  Spare<std::vector<PieceCount>> counts;
  counts->assign((contacts + kContactsAPiece - 1) / kContactsAPiece, PieceCount{});
  share(state.island_threads, contacts, kContactsAPiece, [&](std::size_t from, std::size_t to) {
    PieceCount& count = (*counts)[from / kContactsAPiece];
    count.reused = refresh(from, to, count.stats);
  });
  int reused = 0;
  for (const PieceCount& count : *counts) {
    reused += count.reused;
    stats += count.stats;
  }
  return reused;
}

}  // namespace skerry
