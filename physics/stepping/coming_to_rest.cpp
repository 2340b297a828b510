// SPDX-License-Identifier: MIT
#include "physics/stepping/coming_to_rest.h"

#include <algorithm>
#include <cmath>

#include "physics/solver/associated_path.h"
#include "physics/spare.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/path.h"
#include "physics/stepping/point_memory.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Steps from one look to the next, of so many bodies: a look costs as much as three steps in flow. It grows
// with the power 3/2 of the bodies, and so there are fewer looks at more.
constexpr double kEvery = 16, kUsualBodies = 1000;
// Fastest motion, of what gravity does in a step.
constexpr double kQuiet = 0.01;
// Gaps that count as closed, of the smaller body's size.
constexpr double kClosed = 1e-4;
// What may be left of the speed that gravity gives in a step.
constexpr double kStill = 1e-9;

class ComingToRest {
 public:
  ComingToRest(WorldState& state, const Island& island, double h, IslandResult& result)
      : state_(state), island_(island), h_(h), result_(result) {}

  bool run() {
    gravity_ = h_ * largest_acceleration(state_, island_);
    if (!(gravity_ > 0) || !(fastest() <= kQuiet * gravity_)) return false;
    if (meets_prescribed_motion(state_, island_) || is_free(state_, island_)) return false;
    Spare<Assembly> rows;
    assemble_closed(*rows);
    IslandSystem& system = rows->system;
    Spare<std::vector<Velocity>> after;
    after->assign(island_.bodies.size(), Velocity{});
    add_free_motion(state_, island_, h_, *after);
    for (int i = 0; i < system.size(); ++i) {
      const RowOrigin& origin = rows->origin[static_cast<std::size_t>(i)];
      Row& row = system.rows[static_cast<std::size_t>(i)];
      system.b[static_cast<std::size_t>(i)] = -row_velocity(*rows, i, *after);
      if (origin.kind == RowKind::Friction)
        row.mu = std::max(row.mu, state_.contacts[origin.index].static_friction);
    }
    SolveOptions options = state_.config.solve;
    options.threads = state_.island_threads;
    Solution solution;
    {
      StageTimer timer(state_, result_, Stage::Solve);
      solution = find_rest(system, options);
    }
    result_.work += solution.work;
    if (solution.status != SolveStatus::Solved) return false;
    apply_impulses(system, solution.lambda, *after);
    for (const Velocity& v : *after)
      for (const double c : v)
        if (!(std::abs(c) <= kStill * gravity_)) return false;
    const double speed = std::max(fastest(), widest_gap(*rows, solution.lambda) / h_);
    store(*rows, solution.lambda);
    result_.report.method = solution.method;
    result_.report.iterations = solution.iterations;
    result_.report.rows = system.size();
    stop(speed);
    if (state_.observe.systems)
      keep_trace(state_, island_, 0, system, solution.lambda, solution.status, solution.method,
                 solution.residual, false, nullptr, result_);
    return true;
  }

 private:
  /// Fastest motion of a body, its ends included [m/s].
  double fastest() const {
    const BodyArrays& all = state_.bodies;
    double most = 0;
    for (const std::uint32_t i : island_.bodies) {
      const double speed = length(all.velocity[i]) + state_.radius[i] * std::abs(all.omega[i]);
      if (!(speed <= most)) most = speed;
    }
    return most;
  }

  /// Of the points that carry load [m].
  static double widest_gap(const Assembly& rows, const std::vector<double>& lambda) {
    double widest = 0;
    for (std::size_t i = 0; i < lambda.size(); ++i)
      if (rows.origin[i].kind == RowKind::Normal && lambda[i] > 0)
        widest = std::max(widest, std::abs(rows.origin[i].error));
    return widest;
  }

  /// Rows of all points that count as closed.
  void assemble_closed(Assembly& rows) {
    StageTimer timer(state_, result_, Stage::Assemble);
    Spare<std::vector<std::uint8_t>> points;
    points->assign(island_.contacts.size(), 0);
    for (std::size_t k = 0; k < points->size(); ++k) {
      const Contact& contact = state_.contacts[island_.contacts[k]];
      const double size =
          std::min(size_in_island(state_, contact.body_a), size_in_island(state_, contact.body_b));
      for (int i = 0; i < contact.manifold.count; ++i)
        if (contact.manifold.points[i].separation <= kClosed * size) (*points)[k] |= 1u << i;
    }
    AssemblyRequest request;
    request.points = &*points;
    request.friction = true;
    assemble(state_, island_, request, rows);
  }

  void store(const Assembly& rows, const std::vector<double>& lambda) {
    for (const std::uint32_t index : island_.contacts) forget_impulses(state_.contacts[index], h_);
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const RowOrigin& origin = rows.origin[i];
      Contact& contact = state_.contacts[origin.index];
      remember_impulse(origin, rows.system.rows[i].mu, lambda[i], contact);
      if (origin.kind == RowKind::Normal)
        contact.points[static_cast<std::size_t>(origin.point)].total_normal += lambda[i];
      result_.friction_rows += origin.kind == RowKind::Friction;
    }
  }

  /// The bodies stop, and the gaps of what carries load are closed.
  /// @param speed  of the fastest, and of gaps that close within the step [m/s]
  void stop(double speed) {
    StageTimer timer(state_, result_, Stage::Apply);
    std::vector<PathEnd> start;
    for (const std::uint32_t i : island_.bodies) {
      state_.bodies.velocity[i] = {};
      state_.bodies.omega[i] = 0;
    }
    if (state_.observe.paths) start = path_ends(state_, island_.bodies);
    Spare<Assembly> rows;
    project_positions(state_, island_, h_, result_, *rows);
    if (state_.observe.paths) record_hermite(state_, island_.bodies, 0, h_, start, result_);
    ++result_.substeps;
    // It would have gone on a little.
    note_status(result_, SolveStatus::Inexact, speed / gravity_);
    result_.report.flowing = true;
    result_.step_memory = {};
  }

  WorldState& state_;
  const Island& island_;
  double h_;
  IslandResult& result_;
  double gravity_ = 0;  ///< what it does in a step [m/s]
};

}  // namespace

bool come_to_rest(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (!island.joints.empty() || has_varying_forces(state, island) || !state.solver->exact) return false;
  const double more = std::sqrt(std::max(1.0, static_cast<double>(island.bodies.size()) / kUsualBodies));
  if ((state.steps + island.bodies.front()) % static_cast<std::uint64_t>(kEvery * more) != 0) return false;
  return ComingToRest(state, island, h, result).run();
}

}  // namespace skerry
