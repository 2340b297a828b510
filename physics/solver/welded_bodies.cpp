// SPDX-License-Identifier: MIT
#include "physics/solver/welded_bodies.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "physics/solver/bilateral.h"
#include "physics/solver/contact_states.h"
#include "physics/spare.h"

namespace skerry {
namespace {

using Velocity = std::array<double, 3>;
using Matrix = std::array<Velocity, 3>;  // rows

// Determinant below which rows leave the bodies some motion, relative to the product of the rows' lengths;
// and what the motion of a body may differ from that of a rigid group, relative to its arm.
constexpr double kSingular = 1e-9, kRigid = 1e-9;
// Share of a row's largest number with which it pushes a group as a whole. Joints that are torn come to a few
// hundredths.
constexpr double kWhole = 0.1;

bool holds_both_ways(const IslandSystem& system, int i) {
  const Row& row = system.rows[static_cast<std::size_t>(i)];
  return row.kind == RowKind::Joint && row.normal < 0 && row.lower == -kInfinity && row.upper == kInfinity &&
         (system.compliance.empty() || system.compliance[static_cast<std::size_t>(i)] == 0);
}

double length_of(const Velocity& v) {
  return std::sqrt(along(v, v));
}

Velocity cross_product(const Velocity& x, const Velocity& y) {
  return {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
}

/// The inverse, by the adjugate where the rows are not those of two directions and a turn.
/// @return false if it is singular to rounding
bool invert(const Matrix& m, Matrix& inverse) {
  const double sign = m[2][2];
  if (m[0][0] == sign && m[0][1] == 0 && m[1][0] == 0 && m[1][1] == sign && m[2][0] == 0 && m[2][1] == 0 &&
      std::abs(sign) == 1) {
    inverse = {Velocity{sign, 0, -m[0][2]}, {0, sign, -m[1][2]}, {0, 0, sign}};
    return true;
  }
  const Velocity x = cross_product(m[1], m[2]), y = cross_product(m[2], m[0]), z = cross_product(m[0], m[1]);
  const double determinant = along(m[0], x);
  if (!(std::abs(determinant) > kSingular * length_of(m[0]) * length_of(m[1]) * length_of(m[2])))
    return false;
  for (std::size_t k = 0; k < 3; ++k)
    inverse[k] = {x[k] / determinant, y[k] / determinant, z[k] / determinant};
  return true;
}

}  // namespace

/// Welds, and those of each body. @return whether there are any
bool WeldedBodies::find_welds(int joints) {
  const IslandSystem& system = *system_;
  welds_.clear();
  Matrix blocks, unused;
  for (int i = 0; i + 2 < std::min(joints, system.size()); ++i) {
    const Row* const rows = &system.rows[static_cast<std::size_t>(i)];
    const Row& row = rows[0];
    if (row.kind != RowKind::Joint) {
      // Joints come before contacts.
      if (row.kind == RowKind::Normal) break;
      continue;
    }
    // Nearly all others end here.
    if (rows[2].a != row.a || rows[2].b != row.b) continue;
    bool weld = true;
    for (int k = 0; weld && k < 3; ++k) {
      const Row& other = rows[k];
      weld = other.a == row.a && other.b == row.b && holds_both_ways(system, i + k);
      blocks[static_cast<std::size_t>(k)] = row.b >= 0 ? other.Jb : other.Ja;
    }
    if (!weld || !invert(blocks, unused)) continue;
    for (const int body : {row.a, row.b})
      if (body >= 0 && !(system.bodies[static_cast<std::size_t>(body)].linear > 0)) return false;
    welds_.push_back({i, row.a, row.b});
    i += 2;
  }
  if (welds_.empty()) return false;
  // By counting: those of body k stand from first_weld_[k] on.
  const std::size_t bodies = system.bodies.size();
  first_weld_.assign(bodies + 1, 0);
  for (const Weld& weld : welds_)
    for (const int body : {weld.a, weld.b})
      if (body >= 0) ++first_weld_[static_cast<std::size_t>(body) + 1];
  for (std::size_t k = 0; k < bodies; ++k) first_weld_[k + 1] += first_weld_[k];
  weld_of_.resize(static_cast<std::size_t>(first_weld_[bodies]));
  open_.assign(first_weld_.begin(), first_weld_.end() - 1);
  for (std::size_t w = 0; w < welds_.size(); ++w)
    for (const int body : {welds_[w].a, welds_[w].b})
      if (body >= 0)
        weld_of_[static_cast<std::size_t>(open_[static_cast<std::size_t>(body)]++)] = static_cast<int>(w);
  return true;
}

/// Places the other body of a weld. @param from  a placed one, or the number of bodies: the ground
/// @return false if it does not move like a part of a rigid body
bool WeldedBodies::hang_on(std::size_t from, const Weld& weld) {
  const IslandSystem& system = *system_;
  const bool ground = from == system.bodies.size();
  const bool from_a = ground ? weld.a < 0 : weld.a == static_cast<int>(from);
  const auto to = static_cast<std::size_t>(from_a ? weld.b : weld.a);
  const Member parent = ground ? Member{} : members_[from];
  Member& child = members_[to];
  child.group = parent.group;
  Matrix own, inverse;
  // What the rows want of the child, where nothing moves, and for unit motions of the group.
  Velocity wanted, of_motion[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = static_cast<std::size_t>(weld.first) + k;
    const Row& row = system.rows[i];
    const Velocity& J = from_a ? row.Ja : row.Jb;
    own[k] = from_a ? row.Jb : row.Ja;
    wanted[k] = system.b[i] - along(J, parent.constant);
    of_motion[0][k] = -J[0];
    of_motion[1][k] = -J[1];
    of_motion[2][k] = -along(J, {-parent.arm.y, parent.arm.x, 1});
  }
  if (!invert(own, inverse)) return false;
  const auto times = [&](const Velocity& v) {
    return Velocity{along(inverse[0], v), along(inverse[1], v), along(inverse[2], v)};
  };
  child.constant = times(wanted);
  placed_[to] = 1;
  open_.push_back(static_cast<int>(to));
  if (child.group < 0) return true;
  const Velocity x = times(of_motion[0]), y = times(of_motion[1]), turn = times(of_motion[2]);
  child.arm = {turn[1], -turn[0]};
  const double slack = kRigid * (1 + length(child.arm));
  const double off = std::max({std::abs(x[0] - 1), std::abs(x[1]), std::abs(x[2]), std::abs(y[0]),
                               std::abs(y[1] - 1), std::abs(y[2]), std::abs(turn[2] - 1)});
  return off <= slack;
}

/// Gives every body its group and its arm from the first body of it.
bool WeldedBodies::walk_along_welds() {
  const std::size_t bodies = system_->bodies.size();
  members_.assign(bodies, Member{});
  placed_.assign(bodies, 0);
  open_.clear();
  const auto walk = [&] {
    for (std::size_t next = 0; next < open_.size(); ++next) {
      const auto k = static_cast<std::size_t>(open_[next]);
      for (int w = first_weld_[k]; w < first_weld_[k + 1]; ++w) {
        const Weld& weld = welds_[static_cast<std::size_t>(weld_of_[static_cast<std::size_t>(w)])];
        const int other = weld.a == static_cast<int>(k) ? weld.b : weld.a;
        if (other >= 0 && placed_[static_cast<std::size_t>(other)] == 0 && !hang_on(k, weld)) return false;
      }
    }
    open_.clear();
    return true;
  };
  for (const Weld& weld : welds_) {
    const int body = std::max(weld.a, weld.b);
    if (std::min(weld.a, weld.b) < 0 && placed_[static_cast<std::size_t>(body)] == 0 &&
        !hang_on(bodies, weld))
      return false;
  }
  if (!walk()) return false;
  int groups = 0;
  for (std::size_t k = 0; k < bodies; ++k) {
    if (placed_[k] != 0) continue;
    placed_[k] = 1;
    members_[k].group = groups++;
    open_.push_back(static_cast<int>(k));
    if (!walk()) return false;
  }
  groups_.bodies.assign(static_cast<std::size_t>(groups), {});
  return true;
}

/// Masses and centres; arms are from the centres then, and no group has a momentum without impulses.
void WeldedBodies::weigh_groups() {
  const IslandSystem& system = *system_;
  sums_.assign(groups_.bodies.size(), Sum{});
  const auto sum_of = [&](std::size_t k) -> Sum& {
    return sums_[static_cast<std::size_t>(members_[k].group)];
  };
  for (std::size_t k = 0; k < members_.size(); ++k) {
    if (members_[k].group < 0) continue;
    Sum& sum = sum_of(k);
    const double mass = 1 / system.bodies[k].linear;
    ++sum.bodies;
    sum.mass += mass;
    sum.moment += mass * members_[k].arm;
    if (!system.positions.empty()) sum.place += mass * system.positions[k];
  }
  groups_.positions.clear();
  for (const Sum& sum : sums_)
    if (!system.positions.empty()) groups_.positions.push_back(sum.place / sum.mass);
  for (std::size_t k = 0; k < members_.size(); ++k) {
    Member& member = members_[k];
    if (member.group < 0) continue;
    Sum& sum = sum_of(k);
    const auto group = static_cast<std::size_t>(member.group);
    if (sum.bodies == 1) {
      member.alone = true;
      groups_.bodies[group] = system.bodies[k];
      if (!system.positions.empty()) groups_.positions[group] = system.positions[k];
      continue;
    }
    member.arm -= sum.moment / sum.mass;
    const InverseMass& inverse = system.bodies[k];
    const double mass = 1 / inverse.linear;
    const Vec2 v{member.constant[0], member.constant[1]};
    sum.momentum += mass * v;
    // A body that does not turn keeps its group from turning.
    if (!(inverse.angular > 0)) {
      if (sum.turns) sum.spin = member.constant[2];
      sum.turns = false;
    } else if (sum.turns) {
      const double inertia = 1 / inverse.angular;
      sum.inertia += inertia + mass * length_squared(member.arm);
      sum.spin += inertia * member.constant[2] + mass * cross(member.arm, v);
    }
  }
  for (std::size_t group = 0; group < sums_.size(); ++group) {
    Sum& sum = sums_[group];
    if (sum.bodies == 1) continue;
    groups_.bodies[group] = {1 / sum.mass, sum.turns ? 1 / sum.inertia : 0};
    sum.momentum = sum.momentum / sum.mass;
    if (sum.turns) sum.spin /= sum.inertia;
  }
  for (std::size_t k = 0; k < members_.size(); ++k) {
    Member& member = members_[k];
    if (member.group < 0 || member.alone) continue;
    const Sum& sum = sum_of(k);
    const Vec2 carried = sum.momentum + sum.spin * perp(member.arm);
    member.constant[0] -= carried.x;
    member.constant[1] -= carried.y;
    member.constant[2] -= sum.spin;
  }
}

/// True if a row between two bodies of one group pushes the group as a whole, by more than joints are off by.
bool WeldedBodies::pushes_whole(const Row& row) {
  if (row.normal >= 0 || row.kind == RowKind::Normal) return false;
  double whole = 0, largest = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    whole = std::max(whole, std::abs(row.Ja[c] + row.Jb[c]));
    largest = std::max({largest, std::abs(row.Ja[c]), std::abs(row.Jb[c])});
  }
  return whole > kWhole * largest;
}

/// Which rows see groups, and how. @return false where there are rows that this cannot leave out
bool WeldedBodies::sort_rows() {
  const IslandSystem& system = *system_;
  own_.clear();
  held_.clear();
  idle_.clear();
  row_of_.assign(system.rows.size(), -1);
  groups_.rows.clear();
  groups_.b.clear();
  groups_.compliance.clear();
  for (int i = 0; i < system.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Row& row = system.rows[k];
    Row own = row;
    double b = system.b[k];
    const auto see = [&](int body, Velocity& J, int& group) {
      group = -1;
      if (body < 0) return;
      const Member& member = members_[static_cast<std::size_t>(body)];
      group = member.group;
      b -= along(J, member.constant);
      J[2] += J[1] * member.arm.x - J[0] * member.arm.y;
      if (group < 0) J = {};
    };
    see(row.a, own.Ja, own.a);
    see(row.b, own.Jb, own.b);
    if (own.a == own.b && own.a >= 0 && pushes_whole(own)) {
      // A pulley, a gear or a rack between bodies that move as one.
      for (std::size_t c = 0; c < 3; ++c) own.Ja[c] += own.Jb[c];
      own.Jb = {};
      own.b = -1;
    } else if (own.a == own.b) {
      if (holds_both_ways(system, i))
        held_.push_back(i);
      else if (row.kind == RowKind::Normal || (row.kind != RowKind::Joint && row.normal >= 0))
        idle_.push_back(i);
      else
        return false;
      continue;
    }
    if (own.normal >= 0) own.normal = row_of_[static_cast<std::size_t>(own.normal)];
    row_of_[k] = static_cast<int>(own_.size());
    own_.push_back(i);
    groups_.rows.push_back(own);
    groups_.b.push_back(b);
    if (!system.compliance.empty()) groups_.compliance.push_back(system.compliance[k]);
  }
  return true;
}

bool WeldedBodies::find(const IslandSystem& system, int joints) {
  if (system.rows.size() < 3 || system.rows.front().kind == RowKind::Normal) return false;
  system_ = &system;
  has_welds_ = false;
  if (!find_welds(joints) || !walk_along_welds()) return false;
  weigh_groups();
  return sort_rows();
}

void WeldedBodies::restrict_to_groups(std::span<const double> all, std::vector<double>& own) const {
  own.clear();
  if (all.size() != system_->rows.size()) return;
  for (const int i : own_) own.push_back(all[static_cast<std::size_t>(i)]);
}

const IslandSystem& WeldedBodies::welds() {
  if (has_welds_) return welds_alone_;
  has_welds_ = true;
  const IslandSystem& system = *system_;
  number_of_.assign(system.bodies.size(), -1);
  welds_alone_.bodies.clear();
  welds_alone_.positions.clear();
  welds_alone_.rows.clear();
  welds_alone_.b.assign(held_.size(), 0);
  const auto number = [&](int& body) {
    if (body < 0) return;
    const auto k = static_cast<std::size_t>(body);
    if (number_of_[k] < 0) {
      number_of_[k] = static_cast<int>(welds_alone_.bodies.size());
      welds_alone_.bodies.push_back(system.bodies[k]);
      if (!system.positions.empty()) welds_alone_.positions.push_back(system.positions[k]);
    }
    body = number_of_[k];
  };
  for (const int i : held_) {
    Row& row = welds_alone_.rows.emplace_back(system.rows[static_cast<std::size_t>(i)]);
    number(row.a);
    number(row.b);
  }
  return welds_alone_;
}

void WeldedBodies::expand(const std::vector<double>& own, const SolveOptions& options,
                          std::unique_ptr<SolverMemory>* memory, std::vector<double>& all, SolveWork& work) {
  const IslandSystem& system = *system_;
  all.assign(system.rows.size(), 0);
  for (std::size_t k = 0; k < own_.size(); ++k) all[static_cast<std::size_t>(own_[k])] = own[k];
  velocity_.assign(system.bodies.size(), Velocity{});
  apply_impulses(system, all, velocity_);
  welds();
  for (std::size_t k = 0; k < held_.size(); ++k) {
    const auto i = static_cast<std::size_t>(held_[k]);
    const Row& row = system.rows[i];
    double u = 0;
    if (row.a >= 0) u += along(row.Ja, velocity_[static_cast<std::size_t>(row.a)]);
    if (row.b >= 0) u += along(row.Jb, velocity_[static_cast<std::size_t>(row.b)]);
    welds_alone_.b[k] = system.b[i] - u;
  }
  SolveOptions alone;
  alone.tolerance = options.tolerance;
  alone.threads = options.threads;
  const double scale = residual_scale(largest_magnitude(system.b));
  Solution held = solve_without_bounds(welds_alone_, alone, memory, scale);
  work += held.work;
  for (std::size_t k = 0; k < held_.size(); ++k) all[static_cast<std::size_t>(held_[k])] = held.lambda[k];
}

void WeldedBodies::expand(Solution& solution, const SolveOptions& options,
                          std::unique_ptr<SolverMemory>* memory) {
  std::vector<double> own;
  own.swap(solution.lambda);
  expand(own, options, memory, solution.lambda, solution.work);
  solution.work.rows_left_out += rows_less();
  if (solution.trace)
    solution.trace->notes.push_back(std::to_string(rows_less()) +
                                    " rows left out: welded bodies move as one");
  conclude(*system_, options, solution);
}

void WeldedBodies::move(const std::vector<double>& own, std::vector<Velocity>& velocities) const {
  Spare<std::vector<Velocity>> groups;
  groups->assign(groups_.bodies.size(), Velocity{});
  apply_impulses(groups_, own, *groups);
  for (std::size_t k = 0; k < members_.size(); ++k) {
    const Member& member = members_[k];
    Velocity& v = velocities[k];
    for (std::size_t c = 0; c < 3; ++c) v[c] += member.constant[c];
    if (member.group < 0) continue;
    const Velocity& of_group = (*groups)[static_cast<std::size_t>(member.group)];
    v[0] += of_group[0] - of_group[2] * member.arm.y;
    v[1] += of_group[1] + of_group[2] * member.arm.x;
    v[2] += of_group[2];
  }
}

void WeldedBodies::join(const std::vector<Velocity>& bodies, std::vector<Velocity>& groups) const {
  groups.assign(groups_.bodies.size(), Velocity{});
  for (std::size_t k = 0; k < members_.size(); ++k) {
    const Member& member = members_[k];
    if (member.group < 0) continue;
    const InverseMass& of_group = groups_.bodies[static_cast<std::size_t>(member.group)];
    const InverseMass& own = system_->bodies[k];
    Velocity& sum = groups[static_cast<std::size_t>(member.group)];
    if (member.alone) {
      sum = bodies[k];
      continue;
    }
    Velocity v = bodies[k];
    for (std::size_t c = 0; c < 3; ++c) v[c] += member.constant[c];
    const double share = of_group.linear / own.linear;
    sum[0] += share * v[0];
    sum[1] += share * v[1];
    if (!(own.angular > 0))
      sum[2] = v[2];
    else if (of_group.angular > 0)
      sum[2] += of_group.angular * (v[2] / own.angular + cross(member.arm, Vec2{v[0], v[1]}) / own.linear);
  }
}

double WeldedBodies::told(std::size_t k, const std::vector<Velocity>& bodies) const {
  const Row& row = system_->rows[static_cast<std::size_t>(own_[k])];
  double u = 0;
  const auto add = [&](int body, const Velocity& J) {
    if (body < 0 || members_[static_cast<std::size_t>(body)].group >= 0) return;
    const auto i = static_cast<std::size_t>(body);
    u += along(J, bodies[i]) + along(J, members_[i].constant);
  };
  add(row.a, row.Ja);
  add(row.b, row.Jb);
  return u;
}

void WeldedBodies::spread(const std::vector<Velocity>& groups, std::vector<Velocity>& bodies) const {
  for (std::size_t k = 0; k < members_.size(); ++k) {
    const Member& member = members_[k];
    if (member.group < 0) {
      for (std::size_t c = 0; c < 3; ++c) bodies[k][c] += member.constant[c];
      continue;
    }
    const Velocity& of_group = groups[static_cast<std::size_t>(member.group)];
    const Vec2 v = Vec2{of_group[0], of_group[1]} + of_group[2] * perp(member.arm);
    bodies[k] = {v.x, v.y, of_group[2]};
  }
}

}  // namespace skerry
