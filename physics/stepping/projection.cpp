// SPDX-License-Identifier: MIT
#include "physics/stepping/projection.h"

#include <algorithm>
#include <cmath>

#include "physics/joint_rows.h"
#include "physics/solver/auto.h"
#include "physics/solver/bilateral.h"
#include "physics/solver/welded_bodies.h"
#include "physics/spare.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/one_piece_sweeps.h"
#include "physics/stepping/solver_memories.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"

namespace skerry {
namespace {

/// Errors below this are what rounding leaves [m]: a thousandth of the tolerance within which contacts count
/// as closed.
double position_floor(const WorldState& state, Vec2 where) {
  return 1e-3 * touch_tolerance(state, where);
}

// Relative velocities below this share of the fastest are rounding.
constexpr double kVelocityFloor = 1e-13;
// The same after an integration to rounding, which must keep the energy for 1e5 steps.
constexpr double kFineVelocityFloor = 1e-16;
// Shifts beyond the contact margin that are longer than so many times the largest error come from geometry,
// not from errors.
constexpr double kFarShift = 10;
// Residual of the solves, relative to the error that they take out; and the share of what counts as rounding
// that they may leave.
constexpr double kTolerance = 1e-12, kShareOfFloor = 0.1;
// Rows from which on what stays open is left out: the shortest shift costs little for fewer.
constexpr std::size_t kManyRows = 64;
// Solves without what stays open, at most; the share of the rows that may join in one of them, as what lands
// is many; and the share of the error that they may leave, which Newton's iteration takes out.
constexpr int kClosedRounds = 10;
constexpr double kFewChanges = 0.05, kShareLeft = 0.1;
// Where a shift makes errors larger, a share of it is tried, so many times.
constexpr double kShorter = 0.25;
constexpr int kShorterShifts = 3;
// Errors above this that a solve leaves are no rounding [m or rad]; and the same of velocities, as a share of
// the fastest.
constexpr double kContradiction = 1e-6, kHeld = 1e-6;
// Sweeps for a shift where no answer is found.
constexpr double kSweptShift = 40;
// Contacts, or joints, and rows that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 1024, kRowsAPiece = 2048;

bool carried_load(const WorldState& state, const RowOrigin& origin) {
  return !origin.joint && state.contacts[origin.index].points[origin.point].normal_impulse > 0;
}

/// True for a row with lambda >= 0 that is kept closed: a loaded contact, or a limit that was reached.
bool is_kept_closed(const WorldState& state, const RowOrigin& origin) {
  if (origin.kind == RowKind::Limit) return (state.held_rows[origin.index] >> origin.point & 1) != 0;
  return origin.kind == RowKind::Normal && carried_load(state, origin);
}

/// Points that are near enough to be pushed into contact by a projection.
void find_near_points(const WorldState& state, const Island& island, std::vector<std::uint8_t>& points) {
  points.assign(island.contacts.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Manifold& manifold = state.contacts[island.contacts[k]].manifold;
    for (int i = 0; i < manifold.count; ++i) {
      if (manifold.points[i].separation <= state.config.contact_margin) points[k] |= 1u << i;
    }
  }
}

/// True if there is nothing but joints, and these have no limits, motors or springs: then the same rows serve
/// positions and velocities.
bool only_holds(const WorldState& state, const Island& island) {
  return island.contacts.empty() &&
         !any_of(state.island_threads, island.joints.size(), kContactsAPiece,
                 [&](std::size_t k) { return held_rows(state.joints[island.joints[k]].def) < 0; });
}

/// True if a joint, an overlap or a loaded contact is farther off than rounding explains: a cheap look before
/// the rows are made.
bool needs_projection(const WorldState& state, const Island& island) {
  if (!island.joints.empty()) return true;
  return any_of(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[i];
      const bool closed =
          contact.points[i].normal_impulse > 0 && point.separation <= state.config.contact_margin;
      const double error = closed ? std::abs(point.separation) : -point.separation;
      if (error > position_floor(state, point.position)) return true;
    }
    return false;
  });
}

/// Largest violation of the rows [m]; loaded contacts count gaps, too.
double position_error(const WorldState& state, const Assembly& assembly) {
  const auto worst_of = [&](std::size_t from, std::size_t to) {
    double most = 0;
    for (std::size_t i = from; i < to; ++i) {
      const RowOrigin& origin = assembly.origin[i];
      const bool closed = origin.kind == RowKind::Joint || is_kept_closed(state, origin);
      most = std::max(most, closed ? std::abs(origin.error) : -origin.error);
    }
    return most;
  };
  return largest_of(state.island_threads, assembly.origin.size(), kRowsAPiece, worst_of);
}

/// @param floor   errors below this are rounding, in the unit of the right-hand side
/// @param lambda  exchanged for the answer
void solve_rows(WorldState& state, SolvePurpose purpose, const IslandSystem& system, double floor,
                IslandResult& result, std::vector<double>& lambda) {
  SolveOptions options;
  // Redundant rows contradict each other by rounding: of an error that is hardly more, no solver leaves less.
  options.tolerance = std::max(kTolerance, kShareOfFloor * floor / largest_magnitude(system.b));
  // One joint or contact is the most frequent case, and there is nothing to choose.
  if (state.solver->solve == solve_auto &&
      solve_few_without_bounds(system, options.tolerance, lambda, result.work))
    return;
  options.work_limit = work_left(state, result);
  options.threads = state.island_threads;
  options.welds_as_one = state.config.solve.welds_as_one;
  MemoryLoan memory(state, result, purpose, system);
  Solution solution = state.solver->solve(system, {}, options, memory.get());
  note_work(result, solution.work, solution.status);
  lambda.swap(solution.lambda);
  give_spare(std::move(solution.lambda));
}

/// What `solve_closed_rows` needs for a moment.
struct ClosedScratch {
  std::vector<std::uint8_t> closed;  ///< by row
  std::vector<std::size_t> chosen;   ///< rows of `part`
  IslandSystem part;
  std::vector<Velocity> shift;
};

/// The rows that are closed, as rows that hold both ways.
void select_closed(const IslandSystem& system, ClosedScratch& scratch) {
  IslandSystem& part = scratch.part;
  scratch.chosen.clear();
  part.rows.clear();
  part.b.clear();
  part.bodies = system.bodies;
  part.positions = system.positions;
  for (std::size_t i = 0; i < scratch.closed.size(); ++i) {
    if (scratch.closed[i] == 0) continue;
    scratch.chosen.push_back(i);
    Row& row = part.rows.emplace_back(system.rows[i]);
    row.kind = RowKind::Joint;
    row.lower = -kInfinity;
    part.b.push_back(system.b[i]);
  }
}

/// Answers rows that hold both ways, and rows with lambda >= 0 of which most stay open, without these: what
/// is closed has no bounds, and its problem is linear. Of overlaps those stay that want to be pushed apart,
/// and what the answer would close joins until nothing does. That is an answer, though perhaps not the
/// shortest shift.
/// @param floor   errors below this are rounding, in the unit of the right-hand side
/// @param lambda  becomes the answer, if there is one; it may leave some of the error
/// @return false where there are few rows, or there is none: other bounds, too much that joins, rows that
/// contradict each other
bool solve_closed_rows(WorldState& state, const IslandSystem& system, double floor, IslandResult& result,
                       std::vector<double>& lambda) {
  if (state.solver->solve != solve_auto || !system.compliance.empty()) return false;
  if (system.rows.size() < kManyRows) return false;
  Spare<ClosedScratch> scratch;
  std::vector<std::uint8_t>& closed = scratch->closed;
  closed.assign(system.rows.size(), 0);
  bool all = true;
  for (std::size_t i = 0; i < closed.size(); ++i) {
    const Row& row = system.rows[i];
    const bool holds = row.lower == -kInfinity;
    if (row.normal >= 0 || row.upper < kInfinity || !(holds || row.lower == 0)) return false;
    closed[i] = holds || system.b[i] > 0;
    all &= holds;
  }
  if (all) return false;
  SolveOptions options;
  options.threads = state.island_threads;
  options.welds_as_one = state.config.solve.welds_as_one;
  for (int round = 0; round < kClosedRounds; ++round) {
    select_closed(system, *scratch);
    const double largest = largest_magnitude(scratch->part.b);
    options.tolerance = std::max(kTolerance, kShareOfFloor * floor / largest);
    lambda.assign(closed.size(), 0);
    MemoryLoan memory(state, result, SolvePurpose::Positions, scratch->part);
    Solution solution = solve_without_bounds(scratch->part, options, memory.get());
    result.work += solution.work;
    for (std::size_t k = 0; k < scratch->chosen.size(); ++k) lambda[scratch->chosen[k]] = solution.lambda[k];
    give_spare(std::move(solution.lambda));
    if (!(solution.residual * residual_scale(largest) <= std::max(kShareLeft * largest, floor))) return false;
    scratch->shift.assign(system.bodies.size(), Velocity{});
    apply_impulses(system, lambda, scratch->shift);
    std::size_t changes = 0;
    for (std::size_t i = 0; i < closed.size(); ++i) {
      const Row& row = system.rows[i];
      if (row.lower < 0) continue;
      const bool opens = round == 0 && closed[i] != 0 && lambda[i] < 0;
      double u = -system.b[i];
      if (row.a >= 0) u += along(row.Ja, scratch->shift[static_cast<std::size_t>(row.a)]);
      if (row.b >= 0) u += along(row.Jb, scratch->shift[static_cast<std::size_t>(row.b)]);
      const bool closes = closed[i] == 0 && u < -floor;
      if (opens || closes) closed[i] = closes;
      changes += opens || closes;
    }
    if (changes == 0) return true;
    if (static_cast<double>(changes) > kFewChanges * static_cast<double>(closed.size())) return false;
  }
  return false;
}

/// What the rows of a projection want of the bodies.
/// @param lambda  becomes the impulses that bring it; those of welds, which nobody asks for, may be missing
/// @param motion  velocities, or shifts, of the island's bodies, to which what they do is added
void solve_for_motion(WorldState& state, SolvePurpose purpose, const Assembly& assembly, double floor,
                      IslandResult& result, std::vector<double>& lambda, std::vector<Velocity>& motion) {
  const IslandSystem& system = assembly.system;
  const auto solve = [&](const IslandSystem& rows, std::vector<double>& answer) {
    if (purpose == SolvePurpose::Positions && solve_closed_rows(state, rows, floor, result, answer)) return;
    solve_rows(state, purpose, rows, floor, result, answer);
  };
  const auto contact = std::find_if(assembly.origin.begin(), assembly.origin.end(),
                                    [](const RowOrigin& origin) { return !origin.joint; });
  Spare<WeldedBodies> welded;
  if (state.solver->solve != solve_auto || !state.config.solve.welds_as_one ||
      !welded->find(system, static_cast<int>(contact - assembly.origin.begin()))) {
    solve(system, lambda);
    apply_impulses(system, lambda, motion);
    return;
  }
  std::vector<double> own = take_spare<std::vector<double>>();
  solve(welded->groups(), own);
  result.work.rows_left_out += welded->rows_less();
  lambda.assign(system.rows.size(), 0);
  for (std::size_t k = 0; k < own.size(); ++k) lambda[static_cast<std::size_t>(welded->rows()[k])] = own[k];
  welded->move(own, motion);
  give_spare(std::move(own));
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
      const Vec2 relative = relative_velocity(state, contact, point.position, elapsed);
      if (std::abs(dot(contact.manifold.normal, relative)) > slack) return false;
      const double sliding = dot(perp(contact.manifold.normal), relative) - contact.surface_velocity;
      if (memory.sticking && std::abs(sliding) > slack) return false;
    }
  }
  return true;
}

/// Lets go of a contact, or of a limit that was reached.
void open(WorldState& state, const RowOrigin& origin) {
  if (origin.joint) {
    state.held_rows[origin.index] &= static_cast<std::uint8_t>(~(1u << origin.point));
    return;
  }
  PointMemory& memory = state.contacts[origin.index].points[origin.point];
  memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
  memory.sticking = false;
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
    open(state, origin);
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

/// How far a shift moves a body, its ends included [m].
double way_of(const WorldState& state, std::uint32_t body, const Velocity& shift) {
  const double inverse_inertia = state.bodies.inverse_inertia[body];
  const double gyration =
      inverse_inertia > 0 ? std::sqrt(state.bodies.inverse_mass[body] / inverse_inertia) : 0;
  return std::abs(shift[0]) + std::abs(shift[1]) + gyration * std::abs(shift[2]);
}

/// Share of the shifts that moves no body much farther than anything is off, with what the layers of a large
/// pile add up to.
double share_of_shifts(const WorldState& state, const Island& island, const std::vector<Velocity>& shift,
                       double error) {
  double farthest = 0;
  for (std::size_t k = 0; k < shift.size(); ++k)
    farthest = std::max(farthest, way_of(state, island.bodies[k], shift[k]));
  const double layers = std::sqrt(static_cast<double>(shift.size()));
  const double most = std::max(state.config.contact_margin, std::max(kFarShift, layers) * error);
  return farthest > most ? most / farthest : 1;
}

/// Whether shifts leave more than half of the largest error, and much: the rows contradict each other.
bool leaves_errors(const Assembly& assembly, const std::vector<Velocity>& shift, double error) {
  const double most = std::max(0.5 * error, kContradiction);
  for (int i = 0; i < assembly.system.size(); ++i) {
    const double left = assembly.origin[static_cast<std::size_t>(i)].error +
                        row_velocity(assembly, i, shift) - assembly.drive[static_cast<std::size_t>(i)];
    const bool holds = assembly.system.rows[static_cast<std::size_t>(i)].lower < 0;
    if ((holds ? std::abs(left) : -left) > most) return true;
  }
  return false;
}

/// Loaded contacts that hold bodies back are let open: what landed in other geometry than it was solved for
/// cannot be pulled shut. @return whether there were
bool let_go_of_held_back(WorldState& state, const Assembly& assembly, const std::vector<double>& lambda) {
  bool any = false;
  for (std::size_t i = 0; i < lambda.size(); ++i) {
    const RowOrigin& origin = assembly.origin[i];
    if (!is_kept_closed(state, origin) || !(lambda[i] < 0)) continue;
    open(state, origin);
    any = true;
  }
  return any;
}

/// A shift that takes out some of the overlaps, by so many sweeps: of rows that contradict each other an
/// exact answer is none.
void sweep_rows(WorldState& state, const Island& island, const IslandSystem& system, IslandResult& result,
                std::vector<double>& lambda, std::vector<Velocity>& shift) {
  SolveOptions options;
  options.work_limit = work_of_sweeps(system, kSweptShift);
  options.threads = state.island_threads;
  options.welds_as_one = state.config.solve.welds_as_one;
  Solution solution = sweep_until_done(system, true, {}, options, island.joints.empty() ? Give{} : kShiftGive,
                                       look_at_nothing);
  result.work += solution.work;
  lambda.swap(solution.lambda);
  give_spare(std::move(solution.lambda));
  shift.assign(island.bodies.size(), Velocity{});
  apply_impulses(system, lambda, shift);
}

/// Where a body is.
struct Place {
  Vec2 position;
  double angle;
  Rot rotation;
};

/// What a projection of positions needs for a moment.
struct PositionScratch {
  std::vector<std::uint8_t> points;
  std::vector<Velocity> shift;
  std::vector<double> lambda;
  std::vector<Place> before;  ///< the last shift, of the bodies of the island
};

void keep_places(const WorldState& state, const Island& island, std::vector<Place>& places) {
  const BodyArrays& all = state.bodies;
  places.clear();
  for (const std::uint32_t i : island.bodies)
    places.push_back({all.position[i], all.angle[i], all.rotation[i]});
}

void go_back(WorldState& state, const Island& island, const std::vector<Place>& places) {
  BodyArrays& all = state.bodies;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    all.position[i] = places[k].position;
    all.angle[i] = places[k].angle;
    all.rotation[i] = places[k].rotation;
  }
}

/// Newton's iteration of `project_positions`. @return whether `assembly` has the rows where the bodies are
/// now. @pre needs_projection
bool move_onto_constraints(WorldState& state, const Island& island, double elapsed, Assembly& assembly,
                           IslandResult& result) {
  BodyArrays& all = state.bodies;
  double last = kInfinity;
  bool held_back = false, pulls = true;
  int shorter = 0;
  Spare<PositionScratch> scratch;
  std::vector<Velocity>& shift = scratch->shift;
  AssemblyRequest request;
  request.points = &scratch->points;
  request.rope_slack = state.config.contact_margin;
  request.elapsed = elapsed;
  const auto try_shift = [&] {
    for (std::size_t k = 0; k < shift.size(); ++k) {
      shift_body(state, island.bodies[k], shift[k]);
      note_shift(state, island.bodies[k], shift[k]);
    }
    result.manifolds_reused += update_manifolds(state, island, elapsed, result.narrow);
  };
  for (int round = 0; round < 5 && (round == 0 || needs_projection(state, island)); ++round) {
    find_near_points(state, island, scratch->points);
    assemble(state, island, request, assembly);
    double extent = 0;
    for (const std::uint32_t body : island.bodies) {
      extent = std::max({extent, std::abs(all.position[body].x), std::abs(all.position[body].y)});
    }
    const double error = position_error(state, assembly), floor = position_floor(state, {extent, extent});
    if (error > last && error > kContradiction) {
      // Rows that contradict each other, or bodies that turn far: what made it worse is undone.
      go_back(state, island, scratch->before);
      if (shorter == kShorterShifts) {
        result.manifolds_reused += update_manifolds(state, island, elapsed, result.narrow);
        return false;
      }
      ++shorter;
      --round;
      for (Velocity& one : shift)
        for (double& component : one) component *= kShorter;
      try_shift();
      continue;
    }
    // Newton's iteration converges quadratically; when it no longer gains, the rest is rounding.
    if (error <= floor || error > 0.5 * last) return true;
    last = error;

    for (std::size_t i = 0; i < assembly.system.rows.size(); ++i) {
      Row& row = assembly.system.rows[i];
      const RowOrigin& origin = assembly.origin[i];
      if (pulls && is_kept_closed(state, origin)) {
        row.kind = RowKind::Joint;
        row.lower = -kInfinity;
      }
      assembly.system.b[i] = -origin.error;
    }
    shift.assign(island.bodies.size(), Velocity{});
    solve_for_motion(state, SolvePurpose::Positions, assembly, floor, result, scratch->lambda, shift);
    // What the user put between bodies that lie on each other cannot be taken out while they stay together.
    if (pulls && !island.contacts.empty() && leaves_errors(assembly, shift, error)) {
      pulls = false;
      last = kInfinity;
      continue;
    }
    // Nor is there any shift that takes all of it out, where it is wedged, or none is found in a crowd.
    if (!pulls && leaves_errors(assembly, shift, error))
      sweep_rows(state, island, assembly.system, result, scratch->lambda, shift);
    const double share = share_of_shifts(state, island, shift, error);
    if (share < 1 && !held_back && let_go_of_held_back(state, assembly, scratch->lambda)) {
      held_back = true;
      last = kInfinity;
      continue;
    }
    // In a jam of heavy and light bodies, what is straight for a moment would take some right through others.
    if (share < 1)
      for (Velocity& one : shift)
        for (double& component : one) component *= share;
    keep_places(state, island, scratch->before);
    try_shift();
  }
  return false;
}

}  // namespace

bool project_positions(WorldState& state, const Island& island, double elapsed, IslandResult& result,
                       Assembly& rows) {
  if (!needs_projection(state, island)) return false;
  // Moving bodies changes their angular momentum; a free island gets it back as a common rotation, which no
  // contact feels.
  const bool free = is_free(state, island);
  const double momentum = free ? rigid_motion(state, island).momentum : 0;
  const bool current = move_onto_constraints(state, island, elapsed, rows, result);
  if (free) give_spin(state, island, momentum - rigid_motion(state, island).momentum);
  return current && only_holds(state, island);
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

namespace {

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
