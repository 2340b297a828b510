// SPDX-License-Identifier: MIT
#include "physics/stepping/piece_forces.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "physics/spare.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/chain_side.h"
#include "physics/stepping/flow_work.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/joint_midpoint.h"
#include "physics/stepping/midpoint_manifold.h"
#include "physics/stepping/paradox.h"
#include "physics/stepping/sliding_stop.h"
#include "physics/stepping/solver_memories.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Corners within so many touch tolerances touch each other.
constexpr double kNearCorner = 16;
// Contacts, rows, and bodies that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 256, kRowsAPiece = 2048, kBodiesAPiece = 1024;
// Residual of forces that are as good as none, for which it is 1; and of those that a step in flow of as much
// work leaves less of.
constexpr double kVain = 0.5, kPoor = 0.1;
// Velocities that joints do not allow, in shares of the fastest one, and of 1 m/s, which are rounding.
constexpr double kObeyed = 1e-9;

// Share of their distance to which anchors of a spring come along its line in half of a piece, by free
// motion, from which on they pass each other.
constexpr double kPassing = 0.25;

// A way [m or rad] below which geometry changes by less than rounding.
constexpr double kStill = 1e-12;
// Speed of what stuck that projections may leave, in what forces change a velocity in the piece.
constexpr double kLeftOfSticking = 1e-3;
// What slides at the end of a piece, as a share of what the solve had to change.
constexpr double kSlip = 1e-8;

/// What the solve of a piece needs for a moment.
struct PieceScratch {
  Assembly start, mid;  ///< rows where the piece begins, and half-way
  std::vector<Transform> poses;
  std::vector<double> angles;
  std::vector<Manifold> manifolds;
  std::vector<double> warm, bend;
  std::vector<std::uint8_t> modes;  ///< of the points of the contacts, before the solve
};

class PieceSolve {
 public:
  PieceSolve(WorldState& state, const Island& island, const Piece& piece, IslandResult& result)
      : state_(state), island_(island), piece_(piece), result_(result) {}

  /// Forces that depend on the state are found from the velocities that they give: second order, and with the
  /// contact forces in them.
  void solve(const std::vector<Velocity>& before, std::vector<Velocity>& after) {
    if (!piece_.varying) return solve_once(before, after);
    const double h = piece_.h;
    after = before;
    Spare<std::vector<InverseMass>> damping;
    for (int pass = 0; pass < 3; ++pass) {
      take_forces(state_, island_, piece_.elapsed, h, before, after, *damping);
      // The first guess needs no contact forces: the second pass has them.
      if (pass == 0) {
        add_free_motion(state_, island_, h, after);
      } else {
        solve_once(before, after, &*damping);
        if (found_.given_up || found_.disobeyed) return;
      }
      if (are_lost(state_, island_, after)) return;
    }
  }

  const PieceForces& found() const { return found_; }

 private:
  /// Geometry half-way through the piece, if anything moves enough to matter.
  bool midpoint(double h, const std::vector<Velocity>& v, std::vector<Transform>& poses,
                std::vector<double>& angles, std::vector<Manifold>& manifolds) {
    if (moves_by(h, v) < kStill && !piece_.told) return false;
    poses.resize(v.size());
    angles.resize(v.size());
    share(state_.island_threads, v.size(), kBodiesAPiece, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) {
        const std::uint32_t body = island_.bodies[k];
        angles[k] = state_.bodies.angle[body] + 0.5 * h * v[k][2];
        poses[k] = {state_.bodies.position[body] + 0.5 * h * Vec2{v[k][0], v[k][1]},
                    Rot::from_angle(angles[k])};
      }
    });
    if (has_loops_of_joints(state_, island_))
      hold_joints(state_, island_, piece_.elapsed + 0.5 * h, poses, angles, result_);
    const auto pose = [&](std::uint32_t body) {
      const int local = state_.local_index[body];
      return local >= 0 ? poses[local] : pose_at(state_, body, piece_.elapsed + 0.5 * h);
    };
    const std::size_t contacts = piece_.resting.size();
    manifolds.resize(contacts);
    Spare<std::vector<NarrowPhaseStats>> stats;
    stats->assign((contacts + kContactsAPiece - 1) / kContactsAPiece, {});
    share(state_.island_threads, contacts, kContactsAPiece, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) {
        Contact& contact = state_.contacts[island_.contacts[k]];
        manifolds[k] = contact.manifold;
        if (piece_.resting[k] == 0) continue;
        const Manifold mid = contact_manifold(
            contact, state_.shapes[contact.shape_a].shape, pose(contact.body_a),
            state_.shapes[contact.shape_b].shape, pose(contact.body_b), contact.margin,
            state_.config.skips.axes ? &contact.cache : nullptr, &(*stats)[from / kContactsAPiece]);
        const bool on_chain = is_on_chain(state_, contact);
        if (!on_chain && are_corners_that_touch(mid, manifolds[k], radii(contact), near_corner(contact))) {
          manifolds[k].points[0].position = mid.points[0].position;
          continue;
        }
        const unsigned found = take_geometry(mid, manifolds[k], on_chain);
        if (found == kAllPoints) continue;
        if (found == 0 && !on_chain && (follow_corner(mid, manifolds[k]) || !are_of_one_body(manifolds[k])))
          continue;
        for (int i = 0; i < manifolds[k].count; ++i) {
          if ((found >> i & 1u) == 0) carry(contact, on_chain, pose, manifolds[k].points[i]);
        }
      }
    });
    for (const NarrowPhaseStats& piece : *stats) result_.narrow += piece;
    return true;
  }

  double radii(const Contact& contact) const {
    return state_.shapes[contact.shape_a].shape->radius + state_.shapes[contact.shape_b].shape->radius;
  }
  double near_corner(const Contact& contact) const {
    return kNearCorner * touch_tolerance(state_, contact.manifold.points[0].position);
  }

  /// A corner goes with its body, though it leaves the other one by half-way: an arm to where it was would be
  /// wrong by twice as much as one of the beginning. What is round goes with its middle: a disc that is over
  /// the next segment by then has its point below that all the same.
  template <class Pose>
  void carry(const Contact& contact, bool on_chain, const Pose& pose, ManifoldPoint& point) const {
    const bool clear = !on_chain && is_corner_of_a(point) != is_corner_of_b(point);
    const bool of_b = clear ? is_corner_of_b(point) : state_.local_index[contact.body_b] >= 0;
    const std::uint32_t body = of_b ? contact.body_b : contact.body_a;
    const Transform then = pose_at(state_, body, piece_.elapsed), now = pose(body);
    const bool round = state_.shapes[of_b ? contact.shape_b : contact.shape_a].shape->kind == ShapeKind::Disc;
    point.position =
        round ? point.position + (now.p - then.p) : to_world(now, to_local(then, point.position));
  }

  /// Springs along a line, whose free way would take their anchors past each other, keep the direction of the
  /// beginning: half-way it would point the other way, which the stretch of the beginning does not.
  void keep_springs_this_side(const Assembly& start, Assembly& mid) const {
    if (state_.springs == 0) return;
    for (std::size_t i = 0; i < mid.origin.size() && mid.origin[i].joint; ++i) {
      if (!mid.origin[i].spring()) continue;
      const JointRecord& joint = state_.joints[mid.origin[i].index];
      const bool line = joint.def.kind == JointKind::Distance || joint.def.kind == JointKind::Spring;
      if (!line || !(joint.length > 0)) continue;
      Row& row = mid.system.rows[i];
      const Row& first = start.system.rows[i];
      const auto part = [](const std::array<double, 3>& J) { return Vec2{J[0], J[1]}; };
      const double turned = dot(part(row.Ja), part(first.Ja)) + dot(part(row.Jb), part(first.Jb));
      const double both = length_squared(part(first.Ja)) + length_squared(part(first.Jb));
      const double before = start.origin[i].error + joint.length, now = mid.origin[i].error + joint.length;
      if (turned * now > kPassing * both * before) continue;
      row.Ja = first.Ja;
      row.Jb = first.Jb;
      mid.drive[i] = start.drive[i];
    }
  }

  /// @param damping  by body, factors of its inverse masses, if there are any
  void solve_once(const std::vector<Velocity>& before, std::vector<Velocity>& after,
                  const std::vector<InverseMass>* damping = nullptr) {
    const double h = piece_.h;
    after = before;
    add_free_motion(state_, island_, h, after);

    Spare<PieceScratch> scratch;
    Assembly &start = scratch->start, &mid = scratch->mid;
    found_.moving = false;
    {
      StageTimer timer(state_, result_, Stage::Assemble);
      AssemblyRequest request;
      request.points = &piece_.resting;
      request.friction = true;
      request.elapsed = piece_.elapsed;
      request.rope_slack = kInfinity;
      request.limits = piece_.limits;
      request.actuators = AssemblyRequest::Actuators::All;
      assemble(state_, island_, request, start);
      if (piece_.first && (found_.disobeyed = disobeys(start, before))) return;
      // Where nothing is held there is nothing to look at.
      if (!piece_.plastic && !start.system.rows.empty() &&
          midpoint(h, before, scratch->poses, scratch->angles, scratch->manifolds)) {
        request.poses = &scratch->poses;
        request.angles = &scratch->angles;
        request.elapsed = piece_.elapsed + 0.5 * h;
        request.manifolds = &scratch->manifolds;
        assemble(state_, island_, request, mid);
        found_.moving = mid.system.size() == start.system.size();
        if (found_.moving) keep_springs_this_side(start, mid);
      }
    }
    found_.stop = h;
    Assembly& assembly = found_.moving ? mid : start;
    IslandSystem& system = assembly.system;
    found_.act = !system.rows.empty();
    if (!found_.act) {
      // What flies carries no load any more: the projection must not pull it back.
      return store_impulses(assembly, {}, h, *scratch);
    }

    if (!island_.joints.empty() && std::any_of(assembly.origin.begin(), assembly.origin.end(),
                                               [](const RowOrigin& origin) { return origin.spring(); }))
      system.compliance.resize(system.rows.size(), 0);
    std::atomic<int> rubbing = 0;
    scratch->warm.resize(system.rows.size());
    share_rows(system, [&](int first, int last) {
      int frictions = 0;
      for (int i = first; i < last; ++i) {
        set_target(assembly, start, i, before, after);
        scratch->warm[i] = warm_impulse(assembly.origin[i], h);
        frictions += assembly.origin[i].kind == RowKind::Friction;
      }
      rubbing += frictions;
    });
    result_.friction_rows += rubbing;
    scratch->bend.clear();
    if (piece_.told && found_.moving && has_few_rows(system))
      bend_with_ground(start, before, assembly, scratch->bend);
    if (damping != nullptr) damp(system, *damping);
    MemoryLoan memory(state_, result_, SolvePurpose::Forces, system);
    Solution solution =
        solve_system({start, assembly, before, after, scratch->bend, h}, scratch->warm, memory.get());
    note_work(result_, solution.work, solution.status);
    found_.given_up = is_given_up(solution);
    // What goes on in another way begins with the impulses from before: those of no answer would let a heap
    // sink in.
    if (found_.given_up) return give_spare(std::move(solution.lambda));
    if (solution.status == SolveStatus::Solved) found_.brought = work_of_drive(assembly, solution.lambda);
    note_paradoxes(start, before, solution.lambda);
    apply_impulses(system, solution.lambda, after);
    quieten(h, solution.lambda, after);
    // What begins to move leaves its joints and contacts by as little as what moves.
    if (!piece_.plastic && !found_.moving) found_.moving = moves_by(h, after) > kStill;
    store_impulses(assembly, solution.lambda, h, *scratch);
    note_solution(solution, system);
    if (state_.observe.systems) {
      keep_trace(state_, island_, piece_.elapsed, system, solution.lambda, solution.status, solution.method,
                 solution.residual, false, std::move(solution.trace), result_);
    }
    give_spare(std::move(solution.lambda));
  }

  /// True if what joints, or motors without limit, hold moves otherwise: bodies were given another velocity,
  /// or motors another speed.
  bool disobeys(const Assembly& start, const std::vector<Velocity>& v) const {
    if (island_.joints.empty()) return false;
    const auto worst_of = [&](std::size_t from, std::size_t to) {
      double worst = 0;
      for (std::size_t i = from; i < to; ++i) {
        const RowOrigin& origin = start.origin[i];
        const bool held = origin.kind == RowKind::Joint ||
                          (origin.kind == RowKind::Motor && start.system.rows[i].upper == kInfinity);
        if (held && !origin.spring())
          worst = std::max(worst, std::abs(row_velocity(start, static_cast<int>(i), v)));
      }
      return worst;
    };
    const double worst = largest_of(state_.island_threads, start.origin.size(), kRowsAPiece, worst_of);
    if (!(worst > kObeyed)) return false;
    double fastest = 0;
    for (std::size_t k = 0; k < v.size(); ++k)
      fastest = std::max(fastest,
                         std::hypot(v[k][0], v[k][1]) + std::abs(v[k][2]) * state_.radius[island_.bodies[k]]);
    return worst > kObeyed * (1 + fastest);
  }

  /// Calls `item(first, last)` for pieces of the rows, shared by threads; rows of a contact are in one piece.
  template <class Item>
  void share_rows(const IslandSystem& system, const Item& item) const {
    const auto beginning_of_contact = [&](std::size_t row) {
      while (row < system.rows.size() && system.rows[row].normal >= 0) ++row;
      return static_cast<int>(row);
    };
    share(state_.island_threads, system.rows.size(), kRowsAPiece, [&](std::size_t from, std::size_t to) {
      item(beginning_of_contact(from), beginning_of_contact(to));
    });
  }

  /// The wanted change of velocity of row `i`, and the bounds of motors as impulses.
  /// @param start  rows where the piece begins
  void set_target(Assembly& assembly, const Assembly& start, int i, const std::vector<Velocity>& before,
                  const std::vector<Velocity>& after) const {
    IslandSystem& system = assembly.system;
    const RowOrigin& origin = assembly.origin[i];
    const double h = piece_.h;
    double target = 0;
    // The average of both ends obeys the midpoint's constraint, and so does what slides: at the end it is at
    // rest where the average is half of what it slid with. What is not explained by the geometry is not kept.
    if (origin.spring()) {
      target = add_spring(assembly, i, start.origin[i].error, before, h);
    } else {
      if (found_.moving && (origin.kind != RowKind::Limit || rests(start, i, before))) {
        target = row_velocity(start, i, before);
        // What is held though it leaves, as it would be back at once, is back at the end.
        if (origin.kind == RowKind::Normal) target = std::min(target, 0.0);
        target -= row_velocity(assembly, i, before);
      }
      if (piece_.plastic && origin.kind == RowKind::Normal) target = -std::max(0.0, origin.error) / h;
      if (origin.kind == RowKind::Limit && !rests(start, i, before))
        target = -std::max(0.0, origin.error) / h;
      if (origin.kind == RowKind::Motor) {
        system.rows[i].lower *= h;
        system.rows[i].upper *= h;
      }
    }
    system.b[i] = target - row_velocity(assembly, i, after);
  }

  /// What slides on ground that does not speed up evenly is at rest where the velocity of that ground at the
  /// end says so. Ground that turns is left out: there the place of the contact counts as much.
  /// @param start  rows where the piece begins
  void bend_with_ground(const Assembly& start, const std::vector<Velocity>& before, Assembly& assembly,
                        std::vector<double>& bend) const {
    bend.assign(assembly.system.rows.size(), 0);
    for (int i = 0; i < assembly.system.size(); ++i) {
      const RowOrigin& origin = assembly.origin[i];
      if (origin.joint || origin.kind != RowKind::Friction) continue;
      if (!(std::abs(row_velocity(start, i, before)) > state_.config.rest_speed)) continue;
      const Contact& contact = state_.contacts[origin.index];
      const Row& row = assembly.system.rows[static_cast<std::size_t>(i)];
      const auto take = [&](std::uint32_t told, const std::array<double, 3>& J) {
        if (!state_.prescribed[told] || state_.paths[told].turn() != 0) return;
        const auto velocity = [&](double t) { return kinematic_state(state_, told, piece_.elapsed + t).v; };
        const Vec2 bent = velocity(piece_.h) - 2 * velocity(0.5 * piece_.h) + velocity(0);
        bend[static_cast<std::size_t>(i)] -= dot({J[0], J[1]}, bent);
      };
      take(contact.body_a, row.Jb);
      take(contact.body_b, row.Ja);
      assembly.system.b[static_cast<std::size_t>(i)] -= bend[static_cast<std::size_t>(i)];
    }
  }

  /// How far rounding lets rows that repeat each other contradict each other, relative to b: as much in a
  /// short piece, where b is small, as in a long one.
  static double rounding_of_target(const SolvedPiece& piece) {
    constexpr double kRoundings = 16;
    const IslandSystem& system = piece.assembly.system;
    const auto size = [&](int body, const std::array<double, 3>& J) {
      if (body < 0) return 0.0;
      const Velocity& v = piece.before[static_cast<std::size_t>(body)];
      return std::abs(J[0] * v[0]) + std::abs(J[1] * v[1]) + std::abs(J[2] * v[2]);
    };
    double largest = 0;
    for (const Row& row : system.rows) largest = std::max(largest, size(row.a, row.Ja) + size(row.b, row.Jb));
    return kRoundings * kRoundingUnit * largest / residual_scale(largest_magnitude(system.b));
  }

  /// The impulses of a piece, with the friction that holds and the sliding that ends in it.
  Solution solve_system(const SolvedPiece& piece, const std::vector<double>& warm,
                        std::unique_ptr<SolverMemory>* memory) {
    StageTimer timer(state_, result_, Stage::Solve);
    SolveOptions options = state_.config.solve;
    options.work_limit = work_left(state_, result_);
    options.threads = state_.island_threads;
    options.trace = state_.observe.systems && state_.observe.solve_traces;
    const IslandSystem& system = piece.assembly.system;
    if (has_few_rows(system)) options.tolerance = std::max(options.tolerance, rounding_of_target(piece));
    std::vector<int> held = held_rows(piece.start, piece.assembly, piece.before);
    Solution solution = state_.solver->solve(system, warm, options, memory);
    const auto solve_again = [&] {
      const SolveWork before_it = solution.work;
      if (options.work_limit > 0 && state_.config.solve.work_limit > 0)
        options.work_limit =
            std::min(options.work_limit, work_left_of_all(state_, result_, before_it.visits));
      solution = state_.solver->solve(system, solution.lambda, options, memory);
      solution.work += before_it;
    };
    // What static friction cannot hold slides, and pulls less from then on, so that others may follow; each
    // round at least one fewer is held.
    while (let_go(piece.assembly, solution.lambda, held)) solve_again();
    if (!piece_.plastic && piece_.may_stop && has_few_rows(system)) {
      found_.stop = slide_to_stop(state_, piece, options, memory, solution);
    } else if (hold_turned(piece, solution.lambda, held)) {
      do solve_again();
      while (let_go(piece.assembly, solution.lambda, held));
    }
    return solution;
  }

  /// @param start  rows where the piece begins
  void note_paradoxes(const Assembly& start, const std::vector<Velocity>& before,
                      const std::vector<double>& lambda) {
    if (island_.contacts.empty()) return;
    const auto is_one = [&](std::size_t i) {
      const Row& row = start.system.rows[i];
      if (row.kind != RowKind::Friction || !(lambda[static_cast<std::size_t>(row.normal)] > 0)) return false;
      const double sliding = row_velocity(start, static_cast<int>(i), before);
      return std::abs(sliding) > state_.config.rest_speed && is_paradoxical(start.system, row, sliding);
    };
    // Nearly always there is none.
    const std::size_t rows = start.system.rows.size();
    if (!any_of(state_.island_threads, rows, kRowsAPiece, is_one)) return;
    for (std::size_t i = 0; i < rows; ++i) {
      if (!is_one(i)) continue;
      const Contact& contact = state_.contacts[start.origin[i].index];
      result_.motion_events.push_back({MotionEventKind::Paradox, piece_.elapsed,
                                       state_.shapes[contact.shape_a].body,
                                       state_.shapes[contact.shape_b].body});
    }
  }

  /// Friction of a contact that holds more than it brakes.
  bool may_be_held(const RowOrigin& origin) const {
    if (origin.joint || origin.kind != RowKind::Friction) return false;
    const Contact& contact = state_.contacts[origin.index];
    return contact.static_friction > contact.friction;
  }

  /// Friction rows that static friction holds: they stuck, or do not slide at the beginning. Gives them its
  /// coefficient.
  std::vector<int> held_rows(const Assembly& start, Assembly& assembly,
                             const std::vector<Velocity>& before) const {
    std::vector<int> held;
    if (island_.contacts.empty()) return held;
    // What stuck moves by what projections leave; a blow, or the user, may have let it slide.
    const double left = std::max(state_.config.rest_speed,
                                 kLeftOfSticking * piece_.h * largest_acceleration(state_, island_));
    for (int i = 0; i < assembly.system.size(); ++i) {
      const RowOrigin& origin = assembly.origin[i];
      if (!may_be_held(origin)) continue;
      const Contact& contact = state_.contacts[origin.index];
      const bool stuck = contact.points[origin.point].sticking;
      if (!(std::abs(row_velocity(start, i, before)) <= (stuck ? left : state_.config.rest_speed))) continue;
      assembly.system.rows[i].mu = contact.static_friction;
      held.push_back(i);
    }
    return held;
  }

  /// The same of those that slide at the beginning and the other way at the end, so that they are at rest in
  /// between; adds them to `held`. @return whether there are any
  bool hold_turned(const SolvedPiece& piece, const std::vector<double>& lambda,
                   std::vector<int>& held) const {
    IslandSystem& system = piece.assembly.system;
    const std::size_t known = held.size();
    std::vector<double> w;
    for (int i = 0; i < system.size(); ++i) {
      const RowOrigin& origin = piece.assembly.origin[i];
      if (!may_be_held(origin)) continue;
      const double from = row_velocity(piece.start, i, piece.before);
      if (!(std::abs(from) > state_.config.rest_speed)) continue;
      if (w.empty()) w = row_velocities(system, lambda);
      const double to = w[static_cast<std::size_t>(i)];
      if (!(to * from < 0) || !(std::abs(to) > kSlip * largest_magnitude(system.b))) continue;
      system.rows[static_cast<std::size_t>(i)].mu = state_.contacts[origin.index].static_friction;
      held.push_back(i);
    }
    return held.size() > known;
  }

  /// Gives the rows of `held` that slide in spite of it the coefficient of sliding. One point of a face at
  /// its bound says nothing: its neighbour may hold for both. @return whether there were any
  bool let_go(Assembly& assembly, const std::vector<double>& lambda, std::vector<int>& held) const {
    if (held.empty()) return false;
    const std::vector<double> w = row_velocities(assembly.system, lambda);
    const double slip = kSlip * largest_magnitude(assembly.system.b);
    return std::erase_if(held, [&](int i) {
             if (!(std::abs(w[static_cast<std::size_t>(i)]) > slip)) return false;
             assembly.system.rows[static_cast<std::size_t>(i)].mu =
                 state_.contacts[assembly.origin[static_cast<std::size_t>(i)].index].friction;
             return true;
           }) > 0;
  }

  /// A joint limit that is reached and is not about to be left.
  bool rests(const Assembly& start, int i, const std::vector<Velocity>& v) const {
    const RowOrigin& origin = start.origin[i];
    return origin.kind == RowKind::Limit && origin.error <= state_.config.touch_tolerance &&
           row_velocity(start, i, v) <= state_.config.rest_speed;
  }

  /// A spring by the midpoint rule: its force is that of the stretch and the speed half-way,
  ///
  ///   lambda = -h (k (C + h u / 2) + c u),   u = (J v0 + J v1) / 2,   so with  g = 4 / (h^2 k + 2 h c)
  ///   J v1 + g lambda = -J v0 - g h k C
  ///
  /// a row with compliance g, whose place is there. For a linear oscillator without damper the energy is that
  /// of the beginning
  /// [Hairer, Lubich & Wanner 2006, sec. II.1.2, IV.2]; of second order in general.
  ///
  /// In a plastic piece all goes with v1 throughout, and the force is that of its end: u = J v1 and
  /// g = 1 / (h^2 k + h c) in  J v1 + g lambda = -g h k C.
  /// @param stretch  C at the beginning of the piece
  double add_spring(Assembly& assembly, int i, double stretch, const std::vector<Velocity>& before,
                    double h) const {
    const RowOrigin& origin = assembly.origin[i];
    if (piece_.plastic) {
      const double g = 1 / (h * (h * origin.stiffness + origin.damping));
      assembly.system.compliance[i] = g;
      return -g * h * origin.stiffness * stretch;
    }
    const double g = 4 / (h * (h * origin.stiffness + 2 * origin.damping));
    assembly.system.compliance[i] = g;
    return -row_velocity(assembly, i, before) - g * h * origin.stiffness * stretch;
  }

  /// About how far velocities take any body of the island in half of a time `h` [s].
  double moves_by(double h, const std::vector<Velocity>& v) const {
    return largest_of(state_.island_threads, v.size(), kBodiesAPiece, [&](std::size_t from, std::size_t to) {
      double most = 0;
      for (std::size_t k = from; k < to; ++k)
        most = std::max(most, 0.5 * h * (length(Vec2{v[k][0], v[k][1]}) + std::abs(v[k][2])));
      return most;
    });
  }

  /// What the impulses leave of the weight they balance is rounding, not motion: bodies that are slower than
  /// that are at rest to the bit, so that nothing of them has to be computed again.
  /// Under heavy loads the rounding of the impulses shakes the lightest body, and what it carries with it.
  void quieten(double h, const std::vector<double>& lambda, std::vector<Velocity>& v) const {
    const auto speed = [&](std::size_t k) {
      const double turn = std::abs(v[k][2]) * state_.radius[island_.bodies[k]];
      return std::max({std::abs(v[k][0]), std::abs(v[k][1]), turn});
    };
    const double floor = 1e-10 * h * largest_acceleration(state_, island_);  // the solvers' tolerance
    const auto stop_slow_ones = [&](std::size_t from, std::size_t to) {
      double most = 0;
      for (std::size_t k = from; k < to; ++k) {
        if (speed(k) < floor) v[k] = {0, 0, 0};
        most = std::max(most, speed(k));
      }
      return most;
    };
    const double fastest = largest_of(state_.island_threads, v.size(), kBodiesAPiece, stop_slow_ones);
    if (fastest > 0 && fastest < rounding_of_balance(state_, island_, largest_magnitude(lambda)))
      std::fill(v.begin(), v.end(), Velocity{});
  }

  /// What the last piece, or step, had at this row.
  double warm_impulse(const RowOrigin& origin, double h) const {
    if (origin.joint) return state_.joints[origin.index].row_force[origin.point] * h;
    const PointMemory& memory = state_.contacts[origin.index].points[origin.point];
    if (!(memory.h > 0)) return 0;
    const double impulse = origin.kind == RowKind::Normal     ? memory.normal_impulse
                           : origin.kind == RowKind::Friction ? memory.friction_impulse
                                                              : memory.rolling_impulse;
    return impulse * (h / memory.h);
  }

  void store_impulses(const Assembly& assembly, const std::vector<double>& lambda, double h,
                      PieceScratch& scratch) {
    std::vector<std::uint8_t>& modes = scratch.modes;
    modes.resize(2 * island_.contacts.size());
    const auto each_point = [&](const auto& item) {
      share(state_.island_threads, island_.contacts.size(), kContactsAPiece,
            [&](std::size_t from, std::size_t to) {
              for (std::size_t k = from; k < to; ++k)
                for (std::size_t p = 0; p < 2; ++p)
                  item(state_.contacts[island_.contacts[k]].points[p], modes[2 * k + p]);
            });
    };
    each_point([&](PointMemory& memory, std::uint8_t& mode) {
      mode = mode_of(memory);
      memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
      memory.h = h;
      memory.sticking = false;
    });
    // Limits that take no part push nothing.
    share(state_.island_threads, island_.joints.size(), kContactsAPiece,
          [&](std::size_t from, std::size_t to) {
            for (std::size_t k = from; k < to; ++k) {
              JointRecord& joint = state_.joints[island_.joints[k]];
              std::fill(std::begin(joint.row_force), std::end(joint.row_force), 0);
            }
          });
    if (!lambda.empty())
      share_rows(assembly.system, [&](int first, int last) {
        for (int i = first; i < last; ++i) store_impulse(assembly, i, lambda[i], h);
      });
    std::atomic<int> changes = 0;
    each_point([&](const PointMemory& memory, std::uint8_t mode) {
      if (mode_of(memory) != mode) changes.fetch_add(1, std::memory_order_relaxed);
    });
    result_.mode_changes += changes;
  }

  void store_impulse(const Assembly& assembly, int i, double lambda, double h) const {
    const RowOrigin& origin = assembly.origin[i];
    if (origin.joint) {
      state_.joints[origin.index].row_force[origin.point] = lambda / h;
      return;
    }
    PointMemory& memory = state_.contacts[origin.index].points[origin.point];
    if (origin.kind == RowKind::Normal) {
      memory.normal_impulse = lambda;
      memory.normal = push_on_b(assembly.system.rows[i]);
    }
    if (origin.kind == RowKind::Rolling) memory.rolling_impulse = lambda;
    if (origin.kind != RowKind::Friction) return;
    memory.friction_impulse = lambda;
    memory.sticking = memory.normal_impulse > 0 &&
                      std::abs(lambda) < assembly.system.rows[i].mu * memory.normal_impulse * (1 - 1e-12);
  }

  /// 0 open, 1 slipping, 2 sticking
  static std::uint8_t mode_of(const PointMemory& memory) {
    return memory.normal_impulse > 0 ? 1 + memory.sticking : 0;
  }

  void note_solution(const Solution& solution, const IslandSystem& system) {
    note_status(result_, solution.status, solution.residual);
    result_.report.method = solution.method;
    result_.report.iterations += solution.iterations;
    result_.report.rows = system.size();
  }

  /// True for no answer that cost all that it may: what its island may (or is poor for what was left of
  /// that), or, if nothing would be held, what the world grants an island that may flow.
  bool is_given_up(const Solution& solution) const {
    if (solution.status == SolveStatus::Solved) return false;
    const double own = result_.work_limit, limit = state_.config.solve.work_limit;
    if (own > 0 && (result_.work.visits > own || solution.residual > kPoor)) return true;
    return solution.residual > kVain && limit > 0 && result_.work.visits > limit && may_flow(state_);
  }

  WorldState& state_;
  const Island& island_;
  const Piece& piece_;
  IslandResult& result_;
  PieceForces found_;
};

}  // namespace

PieceForces solve_piece(WorldState& state, const Island& island, const Piece& piece,
                        const std::vector<Velocity>& before, std::vector<Velocity>& after,
                        IslandResult& result) {
  PieceSolve solve(state, island, piece, result);
  solve.solve(before, after);
  return solve.found();
}

}  // namespace skerry
