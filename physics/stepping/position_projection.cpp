// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "physics/spare.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/one_piece_sweeps.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/projection_rows.h"
#include "physics/stepping/squeezed.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"

namespace skerry {
namespace {

// Shifts beyond the contact margin that are longer than so many times the largest error come from geometry,
// not from errors.
constexpr double kFarShift = 10;
// Where a shift makes errors larger, a share of it is tried, so many times.
constexpr double kShorter = 0.25;
constexpr int kShorterShifts = 3;
// Shifts of what is drift, and of what may have far to go.
constexpr int kShifts = 5, kFarShifts = 40;
// What has far to go may reach what is so many times as far away as it is off; and above this [m or rad] its
// shifts are shortened as often as they have to be. Each one has to leave less than this share, and all may
// take so many visits a row, which forty of those that are no riddle do not.
constexpr double kReach = 2, kCoarse = 1e-3, kNearer = 0.99, kFarVisits = 1000;
// Errors above this that a solve leaves are no rounding [m or rad].
constexpr double kContradiction = 1e-6;
// What went aside has to be no better at once, and is allowed so many times the error.
constexpr double kMoreAside = 1.1;
// Sweeps for a shift where no answer is found.
constexpr double kSweptShift = 40;
// Contacts, or joints, and rows that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 1024, kRowsAPiece = 2048;

/// Points that are near enough to be pushed into contact by a projection.
void find_near_points(const WorldState& state, const Island& island, double near,
                      std::vector<std::uint8_t>& points) {
  points.assign(island.contacts.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Manifold& manifold = state.contacts[island.contacts[k]].manifold;
    for (int i = 0; i < manifold.count; ++i) {
      if (manifold.points[i].separation <= near) points[k] |= 1u << i;
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
    open_row(state, origin);
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
                           IslandResult& result, bool far) {
  BodyArrays& all = state.bodies;
  double last = kInfinity;
  bool held_back = false, pulls = true, went_aside = false;
  int shorter = 0, shortened = 0;
  const auto visits = result.work.visits;
  Spare<PositionScratch> scratch;
  std::vector<Velocity>& shift = scratch->shift;
  AssemblyRequest request;
  request.points = &scratch->points;
  request.rope_slack = state.config.contact_margin;
  request.slack_at_ends = true;
  request.elapsed = elapsed;
  const auto try_shift = [&] {
    for (std::size_t k = 0; k < shift.size(); ++k) {
      shift_body(state, island.bodies[k], shift[k]);
      note_shift(state, island.bodies[k], shift[k]);
    }
    result.manifolds_reused += update_manifolds(state, island, elapsed, result.narrow);
  };
  const auto take_rows = [&] {
    find_near_points(state, island, request.rope_slack, scratch->points);
    assemble(state, island, request, assembly);
    return position_error(state, assembly);
  };
  if (far) request.rope_slack = std::max(request.rope_slack, kReach * take_rows());
  const int most = far ? kFarShifts : kShifts;
  for (int round = 0; round < most && (round == 0 || needs_projection(state, island)); ++round) {
    const double error = take_rows();
    double extent = 0;
    for (const std::uint32_t body : island.bodies) {
      extent = std::max({extent, std::abs(all.position[body].x), std::abs(all.position[body].y)});
    }
    const double floor = position_floor(state, {extent, extent});
    if (error > (went_aside ? kMoreAside : 1) * last && error > kContradiction) {
      // Rows that contradict each other, or bodies that turn far: what made it worse is undone.
      go_back(state, island, scratch->before);
      if (shorter == kShorterShifts || shortened == kFarShifts) {
        result.manifolds_reused += update_manifolds(state, island, elapsed, result.narrow);
        return false;
      }
      ++(far && error > kCoarse ? shortened : shorter);
      --round;
      for (Velocity& one : shift)
        for (double& component : one) component *= kShorter;
      try_shift();
      continue;
    }
    // Newton's iteration converges quadratically; when it no longer gains, the rest is rounding. From afar it
    // does so in the end.
    const bool comes_nearer =
        far && error > kContradiction && error < kNearer * last &&
        result.work.visits - visits < kFarVisits * static_cast<double>(assembly.system.rows.size());
    if (error <= floor || (error > 0.5 * last && !comes_nearer)) return true;
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
    went_aside = false;
    if (!pulls && leaves_errors(assembly, shift, error)) {
      sweep_rows(state, island, assembly.system, result, scratch->lambda, shift);
      went_aside = step_aside(state, assembly, shift);
    }
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

double position_floor(const WorldState& state, Vec2 where) {
  return 1e-3 * touch_tolerance(state, where);
}

bool project_positions(WorldState& state, const Island& island, double elapsed, IslandResult& result,
                       Assembly& rows, bool far) {
  if (!needs_projection(state, island)) return false;
  // Moving bodies changes their angular momentum; a free island gets it back as a common rotation, which no
  // contact feels.
  const bool free = is_off_ground(state, island);
  const double momentum = free ? rigid_motion(state, island).momentum : 0;
  const bool current = move_onto_constraints(state, island, elapsed, rows, result, far);
  if (free) give_spin(state, island, momentum - rigid_motion(state, island).momentum);
  return current && only_holds(state, island);
}

void give_spin(WorldState& state, const Island& island, double momentum) {
  if (momentum == 0) return;
  const RigidMotion now = rigid_motion(state, island);
  if (!(now.inertia > 0)) return;
  const double turn = momentum / now.inertia;
  BodyArrays& all = state.bodies;
  for (const std::uint32_t i : island.bodies) {
    all.velocity[i] += turn * perp(all.position[i] - now.centre);
    all.omega[i] += turn;
  }
}

void turn_by_forces(WorldState& state, const Island& island, double h, const std::vector<Transform>& start) {
  constexpr double kRounding = 1e-9;
  const BodyArrays& all = state.bodies;
  Vec2 moved, force;
  double mass = 0, moment = 0, size = 0;
  for (std::size_t k = 0; k < start.size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    const Vec2 half = 0.5 * (all.position[i] - start[k].p), push = all.mass[i] * state.acceleration[i];
    moved += all.mass[i] * half;
    force += push;
    mass += all.mass[i];
    moment += cross(half, push);
    size += length(half) * length(push);
  }
  moment -= cross(moved / mass, force);
  // A uniform field has none.
  if (std::abs(moment) > kRounding * size && is_unpushed(state, island)) give_spin(state, island, h * moment);
}

}  // namespace skerry
