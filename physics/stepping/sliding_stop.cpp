// SPDX-License-Identifier: MIT
#include "physics/stepping/sliding_stop.h"

#include <algorithm>
#include <cmath>

#include "physics/spare.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

constexpr std::size_t kMostRows = 16;
// A second solution counts only if its stopping rows are at their bounds up to this.
constexpr double kAtBound = 1 - 1e-9;

/// True for friction, rolling resistance and motors that have a largest force: they act against a velocity
/// with all of it, and hold what comes to rest with less.
bool may_stop(const Row& row) {
  return row.normal >= 0 ? row.mu > 0 : row.kind == RowKind::Motor && row.upper < kInfinity;
}

/// Largest impulse of such a row.
double bound_of(const Row& row, const std::vector<double>& lambda) {
  return row.normal >= 0 ? row.mu * lambda[static_cast<std::size_t>(row.normal)] : row.upper;
}

/// How much an impulse of 1 in row `j` changes the velocity of row `i`: an entry of W without compliance.
double coupling(const IslandSystem& system, int i, int j) {
  const Row &one = system.rows[i], &other = system.rows[j];
  const auto through = [&](int body, const std::array<double, 3>& J) {
    double sum = 0;
    if (body < 0) return sum;
    const InverseMass& m = system.bodies[body];
    if (other.a == body)
      sum += m.linear * (J[0] * other.Ja[0] + J[1] * other.Ja[1]) + m.angular * J[2] * other.Ja[2];
    if (other.b == body)
      sum += m.linear * (J[0] * other.Jb[0] + J[1] * other.Jb[1]) + m.angular * J[2] * other.Jb[2];
    return sum;
  };
  return through(one.a, one.Ja) + through(one.b, one.Jb);
}

/// A row that stops within the piece.
struct Stopping {
  int row;
  double from;    ///< its velocity at the beginning [m/s or rad/s]
  double target;  ///< what its right-hand side was [m/s or rad/s]
};

}  // namespace

bool has_few_rows(const IslandSystem& system) {
  return system.rows.size() <= kMostRows;
}

double slide_to_stop(const WorldState& state, const SolvedPiece& piece, const SolveOptions& options,
                     std::unique_ptr<SolverMemory>* memory, Solution& solution) {
  IslandSystem& system = piece.assembly.system;
  if (std::none_of(system.rows.begin(), system.rows.end(), may_stop)) return piece.h;
  // What stops within this distance does not show.
  const double shortest = 1e-3 * state.config.touch_tolerance;

  // What is told to move has in the assembly the velocity of half-way; by so much it changes until then.
  const auto half_drive = [&](int i) {
    return piece.assembly.drive[static_cast<std::size_t>(i)] - piece.start.drive[static_cast<std::size_t>(i)];
  };

  Spare<std::vector<Stopping>> stopping;
  Spare<std::vector<Velocity>> after;
  // The mean over the piece is that of the geometry half-way: where bodies turn, the geometry of the
  // beginning gives the velocity there.
  const auto end_velocity = [&](int i, double from) {
    const double bend = piece.bend.empty() ? 0 : piece.bend[static_cast<std::size_t>(i)];
    return row_velocity(piece.assembly, i, piece.before) + row_velocity(piece.assembly, i, *after) - from +
           bend;
  };
  const auto stops = [&](int i) {
    return std::any_of(stopping->begin(), stopping->end(), [&](const Stopping& s) { return s.row == i; });
  };
  // Rows that move at the beginning and do no longer, or backwards, at the end of what `lambda` makes of it.
  const auto find_stops = [&](const std::vector<double>& lambda) {
    const std::size_t known = stopping->size();
    *after = piece.free;
    apply_impulses(system, lambda, *after);
    for (int i = 0; i < system.size(); ++i) {
      const Row& row = system.rows[i];
      if (!may_stop(row) || !(bound_of(row, lambda) > 0)) continue;
      if (stops(i)) continue;
      const double from = row_velocity(piece.start, i, piece.before), to = end_velocity(i, from);
      if (!(std::abs(from) * piece.h > shortest)) continue;
      // The rounding of a solve counts as zero.
      if ((from > 0 ? to : -to) <= 1e-9 * std::abs(from)) stopping->push_back({i, from, system.b[i]});
    }
    // To want more than the bounds can give is to be at the bound: backwards by four times what all impulses
    // change, with the largest ones of what stops.
    for (std::size_t k = known; k < stopping->size(); ++k) {
      const Stopping& stop = (*stopping)[k];
      double impulses = 0;
      for (int j = 0; j < system.size(); ++j) {
        const double impulse = stops(j) ? bound_of(system.rows[j], lambda) : lambda[j];
        impulses += std::abs(coupling(system, stop.row, j) * impulse);
      }
      const double change = std::abs(row_velocity(piece.assembly, stop.row, piece.free)) +
                            std::abs(half_drive(stop.row)) + 4 * impulses;
      system.b[stop.row] += stop.from > 0 ? -change : change;
    }
    return stopping->size() > known;
  };
  // The first stop, if all of them are at their bounds until then; else the end of the piece.
  const auto first_stop = [&](const Solution& sliding) {
    if (sliding.status != SolveStatus::Solved) return piece.h;
    double first = piece.h;
    *after = piece.free;
    apply_impulses(system, sliding.lambda, *after);
    for (const Stopping& stop : *stopping) {
      const double against = stop.from > 0 ? -sliding.lambda[stop.row] : sliding.lambda[stop.row];
      if (!(against >= kAtBound * bound_of(system.rows[stop.row], sliding.lambda))) return piece.h;
      const double to = end_velocity(stop.row, stop.from);
      if (to * stop.from < 0) first = std::min(first, piece.h * (stop.from / (stop.from - to)));
    }
    return first;
  };

  // While the first ones go on, beyond their stops, others may stop.
  double first = piece.h;
  std::size_t known = 0;
  while (find_stops(solution.lambda)) {
    Solution sliding = state.solver->solve(system, solution.lambda, options, memory);
    solution.work += sliding.work;
    const double stop = first_stop(sliding);
    if (!(stop < piece.h)) {
      // Where there is no such motion by Coulomb's law, or hardly one, the solution before it stands.
      for (; known < stopping->size(); ++known) system.b[(*stopping)[known].row] = (*stopping)[known].target;
      break;
    }
    sliding.work = solution.work;
    sliding.iterations += solution.iterations;
    solution = std::move(sliding);
    first = stop;
    known = stopping->size();
  }
  return first;
}

}  // namespace skerry
