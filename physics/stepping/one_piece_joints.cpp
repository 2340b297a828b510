// SPDX-License-Identifier: MIT
#include "physics/stepping/one_piece_joints.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "physics/disjoint_sets.h"
#include "physics/joint_rows.h"
#include "physics/solver/bilateral.h"
#include "physics/spare.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"
#include "physics/thread_pool.h"

namespace skerry {
namespace {

// Sweeps over joints that are torn, the error at which they are mended (see `how_far_off`), and the angle by
// which a row turns a body at most [rad].
constexpr int kMendingSweeps = 50;
// Those after which all of them are mended at once, so often at most, before sweeps go on, where more joints
// hang together than there are in a person: along a chain sweeps take more than it has links. And the
// tolerance of that.
constexpr int kManyJoints = 20;
constexpr int kFirstMendingSweeps = 10, kMendingRounds = 16;
constexpr double kMendingTolerance = 1e-6;
constexpr double kMended = 1e-3, kMostTurn = 0.5;
// The square of how fast a taut hinge may swing its bodies, times the step; from 4 on that is unstable, and
// loads that rise from step to step need some room.
constexpr double kFastest = 0.5;
// Joints that a thread takes at a time.
constexpr std::size_t kJointsAPiece = 256;

/// Where a body comes to with a velocity; bodies that do not react go where they are told to.
JointEnd end_after(const WorldState& state, std::uint32_t body, double from, double h,
                   const std::vector<Velocity>& v) {
  const int local = body == BodyId::kNone ? -1 : state.local_index[body];
  if (local < 0) return joint_end(state, body, from + h);
  const Velocity& own = v[static_cast<std::size_t>(local)];
  const double angle = state.bodies.angle[body] + h * own[2];
  return {state.bodies.position[body] + h * Vec2{own[0], own[1]}, Rot::from_angle(angle), angle, {}, 0};
}

/// Of bodies that hang together.
struct Fall {
  Vec2 force;
  double mass = 0;
  bool jointed = false, held = false;
};

// Least size of what hangs on a joint without a size or an arm [m].
constexpr double kLeastSize = 1e-3;

/// Moves the bodies of one joint by what its rows want, row by row. @param shift  what is added to theirs
void mend(WorldState& state, std::uint32_t slot, double elapsed, std::vector<Velocity>& shift) {
  const JointRecord& joint = state.joints[slot];
  const std::array<std::uint32_t, 2> bodies{joint.def.a.index, joint.def.b.index};
  JointRows rows;
  int count = 1;
  for (int k = 0; k < count; ++k) {
    count = joint_geometry(joint, joint_end(state, bodies[0], elapsed), joint_end(state, bodies[1], elapsed),
                           rows);
    const JointRow& row = rows[static_cast<std::size_t>(k)];
    const bool holds = row.kind == JointRowKind::Hold;
    if (!holds && !(row.kind == JointRowKind::Limit && row.error < 0)) continue;
    std::array<Velocity, 2> moves{};  // of each body, for a correction of 1
    double gives = 0;
    for (std::size_t side = 0; side < 2; ++side) {
      const std::uint32_t body = bodies[side];
      if (body == BodyId::kNone || state.local_index[body] < 0) continue;
      const std::array<double, 3>& J = side == 0 ? row.Ja : row.Jb;
      const double linear = state.bodies.inverse_mass[body], angular = state.bodies.inverse_inertia[body];
      moves[side] = {linear * J[0], linear * J[1], angular * J[2]};
      gives += along(J, moves[side]);
    }
    if (!(gives > 0)) continue;
    const double turn = std::max(std::abs(moves[0][2]), std::abs(moves[1][2])) / gives;
    const double correction =
        -std::clamp(row.error, -kMostTurn / std::max(turn, 1e-300), kMostTurn / std::max(turn, 1e-300));
    for (std::size_t side = 0; side < 2; ++side) {
      if (moves[side] == Velocity{}) continue;
      for (double& x : moves[side]) x *= correction / gives;
      shift_body(state, bodies[side], moves[side]);
      Velocity& all = shift[static_cast<std::size_t>(state.local_index[bodies[side]])];
      for (std::size_t c = 0; c < 3; ++c) all[c] += moves[side][c];
    }
  }
}

/// Moves the bodies by what all joints want at once, linear where they are, by Newton's iteration.
/// @param shift  what is added to theirs
void mend_together(WorldState& state, const Island& island, double elapsed, std::vector<Velocity>& shift) {
  Spare<Assembly> rows;
  Spare<std::vector<std::uint8_t>> no_points;
  no_points->assign(island.contacts.size(), 0);
  AssemblyRequest request;
  request.points = &*no_points;
  request.elapsed = elapsed;
  SolveOptions options;
  options.tolerance = kMendingTolerance;
  Spare<std::vector<Velocity>> moves;
  for (int round = 0; round < kMendingRounds; ++round) {
    assemble(state, island, request, *rows);
    IslandSystem& system = rows->system;
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      Row& row = system.rows[i];
      row.kind = RowKind::Joint;
      row.lower = -kInfinity;
      row.upper = kInfinity;
      system.b[i] = -rows->origin[i].error;
    }
    const Solution solution = solve_without_bounds(system, options, nullptr);
    moves->assign(island.bodies.size(), Velocity{});
    apply_impulses(system, solution.lambda, *moves);
    // What turns far does not end where its rows say.
    double most = 0;
    bool finite = true;
    for (const Velocity& move : *moves) {
      most = std::max(most, std::abs(move[2]));
      finite &= std::isfinite(move[0]) && std::isfinite(move[1]) && std::isfinite(move[2]);
    }
    if (!finite) return;
    const double share = most > kMostTurn ? kMostTurn / most : 1;
    for (std::size_t k = 0; k < moves->size(); ++k) {
      Velocity& move = (*moves)[k];
      for (std::size_t c = 0; c < 3; ++c) {
        move[c] *= share;
        shift[k][c] += move[c];
      }
      shift_body(state, island.bodies[k], move);
    }
    if (!joints_are_off(state, island, elapsed, kMended)) return;
  }
}

}  // namespace

double how_far_off(const WorldState& state, std::uint32_t slot, double elapsed) {
  const JointRecord& joint = state.joints[slot];
  const std::uint32_t a = joint.def.a.index, b = joint.def.b.index;
  double least = std::min(size_in_island(state, a), size_in_island(state, b));
  if (!(least > 0))
    least = std::max({length(joint.local_a), length(joint.local_b), joint.length, kLeastSize});
  JointRows rows;
  const int count = joint_geometry(joint, joint_end(state, a, elapsed), joint_end(state, b, elapsed), rows);
  double most = 0;
  for (int k = 0; k < count; ++k) {
    const JointRow& row = rows[static_cast<std::size_t>(k)];
    const bool holds = row.kind == JointRowKind::Hold;
    if (!holds && row.kind != JointRowKind::Limit) continue;
    const bool turns = row.Jb[0] == 0 && row.Jb[1] == 0;
    const double error = holds ? std::abs(row.error) : -row.error;
    most = std::max(most, turns || error <= 0 ? error : error / least);
  }
  return most;
}

std::optional<double> aim_actuator(const RowOrigin& origin, double h, std::size_t row, IslandSystem& system) {
  if (origin.spring()) {
    // lambda = -h (k (C + h J v1) + c J v1), a row with compliance.
    system.compliance.resize(system.rows.size(), 0);
    system.compliance[row] = 1 / (h * (h * origin.stiffness + origin.damping));
    return -system.compliance[row] * h * origin.stiffness * origin.error;
  }
  if (origin.kind != RowKind::Motor) return {};
  system.rows[row].lower *= h;
  system.rows[row].upper *= h;
  return 0;
}

void aim_joints(const WorldState& state, double from, double h, const std::vector<Velocity>& free,
                Assembly& assembly, std::vector<double>& warm) {
  IslandSystem& system = assembly.system;
  JointRows there;
  for (int i = 0; i < system.size() && assembly.origin[static_cast<std::size_t>(i)].joint; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const RowOrigin& origin = assembly.origin[k];
    const JointRecord& joint = state.joints[origin.index];
    if (i == 0 || assembly.origin[k - 1].index != origin.index) {
      joint_geometry(joint, end_after(state, joint.def.a.index, from, h, free),
                     end_after(state, joint.def.b.index, from, h, free), there);
    }
    const double speed = row_velocity(assembly, i, free);
    double target = 0;
    if (const auto driven = aim_actuator(origin, h, k, system)) {
      target = *driven;
    } else {
      const double slack = origin.kind == RowKind::Limit ? std::max(0.0, origin.error) : 0;
      const double bent = there[static_cast<std::size_t>(origin.point)].error - origin.error - h * speed;
      target = -(slack + bent) / h;
    }
    system.b[k] = target - speed;
    warm[k] = joint.row_force[origin.point] * h;
  }
}

void steady_hinges(const WorldState& state, double h, const std::vector<double>& warm, Assembly& assembly) {
  IslandSystem& system = assembly.system;
  Spare<std::vector<double>> stiffness;  // times h^2
  stiffness->assign(system.bodies.size(), 0);
  // r and the force from the rows of a hinge, along x and y: J = (1, 0, -r_y) and (0, 1, r_x), or both
  // negative.
  const auto add = [&](int body, const std::array<double, 3>& x, const std::array<double, 3>& y, double p,
                       double q) {
    if (body >= 0) (*stiffness)[static_cast<std::size_t>(body)] += h * (y[2] * p - x[2] * q);
  };
  for (std::size_t i = 0; i + 1 < system.rows.size() && assembly.origin[i].joint; ++i) {
    const RowOrigin& origin = assembly.origin[i];
    if (origin.point != 0 || state.joints[origin.index].def.kind != JointKind::Revolute) continue;
    const Row &x = system.rows[i], &y = system.rows[i + 1];
    add(x.a, x.Ja, y.Ja, warm[i], warm[i + 1]);
    add(x.b, x.Jb, y.Jb, warm[i], warm[i + 1]);
  }
  for (std::size_t k = 0; k < system.bodies.size(); ++k) {
    double& inverse = system.bodies[k].angular;
    if ((*stiffness)[k] > 0) inverse = std::min(inverse, kFastest / (*stiffness)[k]);
  }
}

void store_joint_impulses(WorldState& state, const Island& island, const Assembly& assembly,
                          const std::vector<double>& lambda, double h) {
  for (const std::uint32_t slot : island.joints)
    std::fill(std::begin(state.joints[slot].row_force), std::end(state.joints[slot].row_force), 0);
  for (std::size_t i = 0; i < lambda.size() && assembly.origin[i].joint; ++i) {
    JointRecord& joint = state.joints[assembly.origin[i].index];
    joint.row_force[assembly.origin[i].point] = lambda[i] / h;
    joint.row_impulse[assembly.origin[i].point] += lambda[i];
  }
}

void bind_jointed(const WorldState& state, const Island& island, double h, std::vector<std::uint8_t>& pushed,
                  std::vector<Vec2>& lag) {
  const std::size_t count = island.bodies.size();
  lag.assign(count, {});
  if (island.joints.empty()) return;
  DisjointSets sets(count);
  Spare<std::vector<Fall>> falls;
  falls->assign(count, {});
  const auto local = [&](BodyId body) { return body ? state.local_index[body.index] : -1; };
  for (const std::uint32_t slot : island.joints) {
    const int a = local(state.joints[slot].def.a), b = local(state.joints[slot].def.b);
    if (a >= 0 && b >= 0) sets.join(a, b);
    for (const int k : {a, b}) {
      if (k < 0) continue;
      (*falls)[static_cast<std::size_t>(k)].jointed = true;
      (*falls)[static_cast<std::size_t>(k)].held |= a < 0 || b < 0;
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    Fall& own = (*falls)[k];
    own.held |= pushed[k] != 0;
    own.mass = state.bodies.mass[island.bodies[k]];
    own.force = own.mass * state.acceleration[island.bodies[k]];
  }
  // The root of a set is its first body.
  for (std::size_t k = 0; k < count; ++k) {
    const auto root = static_cast<std::size_t>(sets.root(static_cast<int>(k)));
    if (root == k) continue;
    Fall &all = (*falls)[root], &own = (*falls)[k];
    all.held |= own.held;
    all.mass += own.mass;
    all.force += own.force;
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (!(*falls)[k].jointed) continue;
    const Fall& all = (*falls)[static_cast<std::size_t>(sets.root(static_cast<int>(k)))];
    if (!all.held) lag[k] = (0.5 * h * h / all.mass) * all.force;
    pushed[k] = 1;
  }
}

bool joints_are_off(const WorldState& state, const Island& island, double elapsed, double share) {
  return any_of(state.island_threads, island.joints.size(), kJointsAPiece,
                [&](std::size_t k) { return how_far_off(state, island.joints[k], elapsed) > share; });
}

void mend_joints(WorldState& state, const Island& island, double elapsed, double share) {
  if (!joints_are_off(state, island, elapsed, share)) return;
  const auto local = [&](BodyId body) { return body ? state.local_index[body.index] : -1; };
  DisjointSets sets(island.bodies.size());
  for (const std::uint32_t slot : island.joints) {
    const int a = local(state.joints[slot].def.a), b = local(state.joints[slot].def.b);
    if (a >= 0 && b >= 0) sets.join(a, b);
  }
  const auto set_of = [&](std::uint32_t slot) {
    const int a = local(state.joints[slot].def.a);
    return static_cast<std::size_t>(sets.root(a >= 0 ? a : local(state.joints[slot].def.b)));
  };
  Spare<std::vector<std::uint8_t>> torn;
  torn->assign(island.bodies.size(), 0);
  for (const std::uint32_t slot : island.joints) {
    if (how_far_off(state, slot, elapsed) > share) (*torn)[set_of(slot)] = 1;
  }
  Spare<std::vector<int>> joints;  // of what is torn
  joints->assign(island.bodies.size(), 0);
  for (const std::uint32_t slot : island.joints) (*joints)[set_of(slot)] += (*torn)[set_of(slot)];
  const bool long_one = *std::max_element(joints->begin(), joints->end()) > kManyJoints;
  Spare<std::vector<Velocity>> shift;
  shift->assign(island.bodies.size(), Velocity{});
  bool off = true;
  for (int sweep = 0; off && sweep < kMendingSweeps; ++sweep) {
    if (long_one && sweep == kFirstMendingSweeps) mend_together(state, island, elapsed, *shift);
    off = false;
    for (const std::uint32_t slot : island.joints) {
      if ((*torn)[set_of(slot)] == 0 || how_far_off(state, slot, elapsed) <= kMended) continue;
      off = true;
      mend(state, slot, elapsed, *shift);
    }
  }
  for (std::size_t k = 0; k < shift->size(); ++k) {
    if ((*shift)[k] == Velocity{}) continue;
    const double way = length_of_shift(state, island.bodies[k], (*shift)[k]);
    note_way(state, island.bodies[k], way, true);
    note_way_astray(state, island.bodies[k], way, true);
  }
}

}  // namespace skerry
