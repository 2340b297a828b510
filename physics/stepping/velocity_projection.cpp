// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "physics/joint_rows.h"
#include "physics/spare.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/mode_choice.h"
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
// What joints hold moves otherwise if it does so by more than this share of what is fast.
constexpr double kObeyed = 1e-9;
// Where rounds lead nowhere, corrections are found together with the friction that they bring along, if so
// many normals at most do.
constexpr std::ptrdiff_t kMostBrought = 4;
// A normal that this share of is left of once its friction has pushed back may be corrected. In a wedge it is
// nothing, or negative: then what would take the smallest velocity away is endless.
constexpr double kLeastLeft = 0.1;
// Share of the energy that a correction may add: with its friction it is no projection, but nearly one.
constexpr double kMostGain = 0.02;
// Friction beyond its bound by this share is more than rounding.
constexpr double kBeyondBound = 1e-6;
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

/// Contacts that stick, and that the corrections would load beyond what friction holds, slide.
/// @return whether there were
bool let_slide(WorldState& state, const Assembly& bilateral, const std::vector<double>& lambda) {
  bool any = false;
  for (std::size_t i = 1; i < lambda.size(); ++i) {
    const RowOrigin &origin = bilateral.origin[i], &normal = bilateral.origin[i - 1];
    if (origin.joint || origin.kind != RowKind::Friction) continue;
    // A point's friction follows its normal.
    if (normal.joint || normal.kind != RowKind::Normal || normal.index != origin.index) continue;
    Contact& contact = state.contacts[origin.index];
    PointMemory& memory = contact.points[origin.point];
    const double most =
        std::max(contact.friction, contact.static_friction) * (memory.normal_impulse + lambda[i - 1]);
    if (!(std::abs(memory.friction_impulse + lambda[i]) > (1 + kBeyondBound) * most)) continue;
    memory.sticking = false;
    any = true;
  }
  return any;
}

/// Motors that hold their speed, and that the corrections would load beyond their largest force, are let go
/// of. @return whether there were
bool let_run(WorldState& state, const Assembly& bilateral, const std::vector<double>& lambda, double h) {
  bool any = false;
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    const RowOrigin& origin = bilateral.origin[i];
    if (!origin.joint || origin.kind != RowKind::Motor) continue;
    const JointRecord& joint = state.joints[origin.index];
    const double most = h * joint.def.motor_limit;
    if (!(std::abs(h * joint.row_force[origin.point] + lambda[i]) > (1 + kBeyondBound) * most)) continue;
    state.held_rows[origin.index] &= static_cast<std::uint8_t>(~(1u << origin.point));
    any = true;
  }
  return any;
}

/// What a projection corrects belongs to what joints do in the step, and to the loads of the piece, if there
/// was one: only with it are they of second order.
void add_to_loads(WorldState& state, const Assembly& bilateral, const std::vector<double>& lambda,
                  bool piece) {
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    const RowOrigin& origin = bilateral.origin[i];
    if (origin.joint) state.joints[origin.index].row_impulse[origin.point] += lambda[i];
    if (origin.joint || !piece) continue;
    Contact& contact = state.contacts[origin.index];
    PointMemory& memory = contact.points[origin.point];
    contact.impulse += lambda[i] * push_on_b(bilateral.system.rows[i]);
    if (origin.kind == RowKind::Normal) {
      // Friction at its bound stays there; what was let go of before it came to that has no more of it.
      const double load = std::max(memory.normal_impulse + lambda[i], 1e-300),
                   share = load / memory.normal_impulse,
                   bound = contact.friction * memory.normal_impulse * (1 - 1e-12);
      if (!memory.sticking && !(std::abs(memory.friction_impulse) < bound)) {
        memory.total_friction += (share - 1) * memory.friction_impulse;
        contact.impulse += (share - 1) * memory.friction_impulse * perp(contact.manifold.normal);
        memory.friction_impulse *= share;
      }
      memory.rolling_impulse *= share;
      memory.normal_impulse = load;
      memory.total_normal += lambda[i];
    } else {
      memory.friction_impulse += lambda[i];
      memory.total_friction += lambda[i];
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

/// The friction that comes along with an impulse `push` of one normal, and what rows that hold make of it:
/// their impulses, and the motion of the bodies.
struct Brought {
  int normal;
  double push;
  std::vector<double> lambda;
  std::vector<Velocity> motion;

  /// Whether the normal does its work in spite of what it brings along.
  bool works() const { return (push - lambda[normal]) / push > kLeastLeft; }

  /// Adds it to an answer that has only the impulse of the normal without it. @pre works()
  void join(std::vector<double>& to, std::vector<Velocity>& moved) const {
    const double share = to[normal] / (push - lambda[normal]);
    for (std::size_t i = 0; i < to.size(); ++i) to[i] += share * lambda[i];
    for (std::size_t k = 0; k < moved.size(); ++k)
      for (int c = 0; c < 3; ++c) moved[k][c] += share * motion[k][c];
  }
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
void assemble_loaded(const WorldState& state, const Island& island, double elapsed, bool motors,
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
  request.actuators = motors ? AssemblyRequest::Actuators::All : AssemblyRequest::Actuators::None;
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

/// The rows of one projection, and what takes their velocities away.
class Correction {
 public:
  /// @param companions  of `full`, those of a normal one after the other
  /// @param floor  velocities below this are rounding [m/s]
  Correction(WorldState& state, const Assembly& full, Assembly& bilateral,
             const std::vector<Companion>& companions, double floor, IslandResult& result)
      : state_(state),
        full_(full.system),
        bilateral_(bilateral),
        wanted_(bilateral.system.b),
        companions_(companions),
        floor_(floor),
        result_(result) {
    wanted_.resize(bilateral.system.rows.size());
  }

  /// The largest violation, which is what the next correction is to take away.
  double violation(const std::vector<Velocity>& v) {
    return largest_of(state_.island_threads, wanted_.size(), kRowsAPiece,
                      [&](std::size_t from, std::size_t to) {
                        double most = 0;
                        for (std::size_t i = from; i < to; ++i) {
                          const double speed = row_velocity(bilateral_, static_cast<int>(i), v);
                          wanted_[i] = -speed;
                          // Loads of rounding bring friction that is no number.
                          most = std::isfinite(speed) ? std::max(most, std::abs(speed)) : kInfinity;
                        }
                        return most;
                      });
  }

  /// Without what comes along. @pre `violation(v)` was asked for last
  void hold(std::vector<double>& lambda, std::vector<Velocity>& v) {
    solve_for_motion(state_, SolvePurpose::Velocities, bilateral_, floor_, result_, lambda, v);
  }

  /// The friction that belongs to corrections of normals.
  void bring(const std::vector<double>& lambda, std::vector<Velocity>& v) const {
    for (const Companion& companion : companions_) push_by(companion, lambda[companion.normal], v);
  }

  /// True if few normals bring something along.
  bool may_hold_with_friction() const {
    const auto normals = std::count_if(companions_.begin(), companions_.end(),
                                       [&](const Companion& one) { return is_first(one); });
    return normals > 0 && normals <= kMostBrought;
  }

  /// Both at once: each normal joins those before it by the formula for a matrix that changes by one column
  /// [Sherman & Morrison 1950]. @return false where they jam each other
  bool hold_with_friction(std::vector<double>& lambda, std::vector<Velocity>& v) {
    std::vector<Brought> all;
    violation(v);
    hold(lambda, v);
    for (const Companion& first : companions_) {
      if (!is_first(first) || lambda[first.normal] == 0) continue;
      Brought one{first.normal, lambda[first.normal], {}, std::vector<Velocity>(v.size(), Velocity{})};
      for (const Companion& companion : companions_)
        if (companion.normal == one.normal) push_by(companion, one.push, one.motion);
      for (std::size_t i = 0; i < wanted_.size(); ++i)
        wanted_[i] = bilateral_.drive[i] - row_velocity(bilateral_, static_cast<int>(i), one.motion);
      hold(one.lambda, one.motion);
      for (const Brought& before : all) before.join(one.lambda, one.motion);
      if (!one.works()) return false;
      all.push_back(std::move(one));
    }
    for (const Brought& one : all) one.join(lambda, v);
    return true;
  }

  /// Work of the friction that came along [J]: each impulse works against the mean of the velocities before
  /// and after it.
  double friction_work(const std::vector<double>& lambda, const std::vector<Velocity>& before,
                       const std::vector<Velocity>& after) const {
    double work = 0;
    for (const Companion& companion : companions_) {
      const Row& row = full_.rows[companion.row];
      const double impulse = companion.share * lambda[companion.normal];
      if (row.a >= 0) work += 0.5 * impulse * (along(row.Ja, before[row.a]) + along(row.Ja, after[row.a]));
      if (row.b >= 0) work += 0.5 * impulse * (along(row.Jb, before[row.b]) + along(row.Jb, after[row.b]));
    }
    return work;
  }

 private:
  bool is_first(const Companion& one) const {
    return &one == companions_.data() || (&one - 1)->normal != one.normal;
  }
  void push_by(const Companion& companion, double normal, std::vector<Velocity>& v) const {
    const Row& row = full_.rows[companion.row];
    const double impulse = companion.share * normal;
    if (row.a >= 0) push(full_.bodies[row.a], row.Ja, impulse, v[row.a]);
    if (row.b >= 0) push(full_.bodies[row.b], row.Jb, impulse, v[row.b]);
  }

  WorldState& state_;
  const IslandSystem& full_;  ///< of the companions
  Assembly& bilateral_;
  std::vector<double>& wanted_;
  const std::vector<Companion>& companions_;
  double floor_;
  IslandResult& result_;
};

/// Largest part of a velocity of the island.
double fastest_of(const std::vector<Velocity>& v) {
  double fastest = 0;
  for (const Velocity& one : v)
    fastest = std::max({fastest, std::abs(one[0]), std::abs(one[1]), std::abs(one[2])});
  return fastest;
}

/// True if a correction gives much more energy than ground and motors that move bring: friction that comes
/// along between wedged bodies can.
bool adds_energy(const IslandSystem& system, const std::vector<Velocity>& before,
                 const std::vector<Velocity>& after, double brought) {
  double first = 0, second = 0;
  for (std::size_t k = 0; k < before.size(); ++k) {
    const InverseMass& m = system.bodies[k];
    const auto energy_of = [&m](const Velocity& v) {
      const double linear = m.linear > 0 ? (v[0] * v[0] + v[1] * v[1]) / m.linear : 0;
      return 0.5 * (linear + (m.angular > 0 ? v[2] * v[2] / m.angular : 0));
    };
    first += energy_of(before[k]);
    second += energy_of(after[k]);
  }
  return second > (1 + kMostGain) * first + std::max(brought, 0.0);
}

/// Rounds of corrections of the velocities `scratch.v`, which the island then has. The friction that comes
/// along disturbs the normal velocities a little, hence the rounds.
/// @return false, and nothing has happened, if contacts or limits that would be pulled, or stick too hard,
/// were let go of
bool take_away(WorldState& state, const Island& island, Assembly& bilateral, double floor, double fastest,
               double pushed, IslandResult& result, VelocityScratch& scratch, VelocityShift& done) {
  std::vector<Velocity>&v = scratch.v, &next = scratch.next;
  std::vector<double>& lambda = scratch.lambda;
  Correction correction(state, scratch.full, bilateral, scratch.companions, floor, result);
  const auto let_go = [&](int round) {
    return pushed > 0 && round == 0 &&
           (let_open(state, bilateral, lambda, pushed) || let_slide(state, bilateral, lambda) ||
            let_run(state, bilateral, lambda, pushed));
  };
  double error = correction.violation(v);
  for (int round = 0; round < 4 && error > floor; ++round) {
    next = v;
    correction.hold(lambda, next);
    if (let_go(round)) return false;
    correction.bring(lambda, next);
    double left = correction.violation(next);
    if (!(left < error) && correction.may_hold_with_friction()) {
      next = v;
      if (!correction.hold_with_friction(lambda, next)) break;
      if (let_go(round)) return false;
      left = correction.violation(next);
    }
    const double brought = work_of_drive(bilateral, lambda);
    if (!(left < error) || adds_energy(bilateral.system, v, next, brought)) break;
    done.friction += correction.friction_work(lambda, v, next);
    error = left;
    done.brought += brought;
    std::swap(v, next);
    add_to_loads(state, bilateral, lambda, pushed > 0);
  }
  store_velocities(state, island, v);
  done.holds = !(error > kHeld * std::max(fastest, 1e-3));
  return true;
}

}  // namespace

VelocityShift project_velocities(WorldState& state, const Island& island, double elapsed, double pushed,
                                 IslandResult& result, Assembly* rows, bool motors) {
  if (island.joints.empty() && velocities_hold(state, island, elapsed)) return {};
  Spare<VelocityScratch> scratch;
  island_velocities(state, island, scratch->v);
  const double fastest = fastest_of(scratch->v);
  // Joints that only hold slide nowhere, and so nothing comes along.
  const bool ready = rows != nullptr;
  scratch->companions.clear();
  if (!ready) assemble_loaded(state, island, elapsed, motors, *scratch);
  Assembly& bilateral = ready ? *rows : select_bilateral(state, scratch->v, fastest, pushed > 0, *scratch);
  // What is left does work against the joints' forces all the way to the next projection.
  const double floor = (pushed > 0 ? kVelocityFloor : kFineVelocityFloor) * std::max(fastest, 1e-3);
  VelocityShift done;
  if (!take_away(state, island, bilateral, floor, fastest, pushed, result, *scratch, done))
    return project_velocities(state, island, elapsed, pushed, result, nullptr, motors);
  return done;
}

bool joints_disobey(const WorldState& state, const Island& island, double elapsed) {
  double worst = 0;
  for (const std::uint32_t slot : island.joints) {
    const JointRecord& joint = state.joints[slot];
    JointRows rows;
    const int count = joint_rows(joint, joint_end(state, joint.def.a.index, elapsed),
                                 joint_end(state, joint.def.b.index, elapsed), rows);
    for (int i = 0; i < count; ++i) {
      const JointRow& row = rows[static_cast<std::size_t>(i)];
      if (row.kind == JointRowKind::Hold) worst = std::max(worst, std::abs(row.rate));
      if (row.kind == JointRowKind::Motor && row.most == kInfinity)
        worst = std::max(worst, std::abs(row.rate - row.speed));
    }
  }
  return worst > kObeyed && worst > kObeyed * (1 + speed_bound(state, island));
}

void obey_joints(WorldState& state, const Island& island, double elapsed, double& passed,
                 IslandResult& result) {
  Spare<VelocityScratch> scratch;
  std::vector<std::uint8_t>&none = scratch->points, &no_limit = scratch->limits;
  none.assign(island.contacts.size(), 0);
  no_limit.assign(island.joints.size(), 0);
  AssemblyRequest request;
  request.points = &none;
  request.limits = &no_limit;
  request.actuators = AssemblyRequest::Actuators::Rigid;
  request.elapsed = elapsed;
  Assembly& rows = scratch->full;
  assemble(state, island, request, rows);
  std::for_each(rows.system.rows.begin(), rows.system.rows.end(), free_of_bounds);
  scratch->companions.clear();
  island_velocities(state, island, scratch->v);
  const double fastest = fastest_of(scratch->v);
  const IslandEnergy energy(state, island, true, elapsed);
  VelocityShift done;
  take_away(state, island, rows, kFineVelocityFloor * std::max(fastest, 1e-3), fastest, 0, result, *scratch,
            done);
  energy.take_much(state, island, 0, done.holds ? done.brought : 0, passed);
}

}  // namespace skerry
