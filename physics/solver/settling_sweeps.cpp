// SPDX-License-Identifier: MIT
#include "physics/solver/settling_sweeps.h"

#include <algorithm>
#include <cmath>

#include "physics/solver/block_sweeps.h"
#include "physics/solver/contact_states.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Sweeps between two looks at the residual.
constexpr int kSweeps = 100;
// The active set is asked when the residual is below the first and has fallen by the second since it was last
// asked; where it rises above the first again, the iterates wander on.
constexpr double kSettled = 1e-4, kProgress = 0.1;
constexpr int kPolishIterations = 6;
// Sweeps between two kicks.
constexpr int kOrbit = 20000;
// Lengths of the stretches of sweeps after which impulses may be seen to run away; how alike those are, and
// how small what moves is beside them (heavy on light moves by the root of the ratio of their masses).
constexpr int kStretches[] = {300, 3000};
constexpr double kAlike = 1e-2, kStill = 1e-6;
// Of the work that is left, at most, for such a stretch.
constexpr double kStretchShare = 0.1;

using Vectors = std::vector<BodyVector>;

/// Sum of squares of (c - b) - (b - a).
double bend(const Vectors& a, const Vectors& b, const Vectors& c) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Vec4 d = (c[k].v - b[k].v) - (b[k].v - a[k].v);
    sum += (d[0] * d[0] + d[1] * d[1]) + (d[2] * d[2] + d[3] * d[3]);
  }
  return sum;
}
/// Sum of squares of b - a.
double way(const Vectors& a, const Vectors& b) {
  return bend(b, b, a);
}

}  // namespace

bool contradicts(const IslandSystem& system, const SolveBudget& budget, SolveWork& work) {
  Spare<BlockSweeps> sweeps;
  if (!sweeps->assign(system, true)) return false;
  for (const int stretch : kStretches) {
    const double cost = 3.0 * stretch * static_cast<double>(system.size());
    if (budget.spent(work) || cost > kStretchShare * (budget.visits - work.visits)) return false;
    work.visits += cost;
    sweeps->set({});
    Vectors impulses[3], velocities[3];
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < stretch; ++i) sweeps->sweep();
      impulses[k] = sweeps->impulses();
      velocities[k] = sweeps->velocities();
    }
    const double gone = way(impulses[1], impulses[2]);
    if (gone > 0 && bend(impulses[0], impulses[1], impulses[2]) <= kAlike * kAlike * gone &&
        way(velocities[1], velocities[2]) <= kStill * kStill * gone)
      return true;
  }
  return false;
}

bool settle_by_sweeps(const IslandSystem& system, ActiveSet& active, const SettlingOptions& options,
                      const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  Spare<BlockSweeps> sweeps;
  if (!sweeps->assign(system)) return false;
  sweeps->set({});
  ActiveSet::Options polish;
  polish.target = std::min(1e-12, options.tolerance);
  polish.tolerance = options.tolerance;
  polish.max_iterations = polish.patience = kPolishIterations;
  const double scale = residual_scale(largest_magnitude(system.b));
  double asked_at = kSettled;
  int since_kick = 0;
  std::vector<double> lambda;
  for (int done = 0; done < options.sweeps && !budget.spent(work); done += kSweeps) {
    for (int k = 0; k < kSweeps; ++k) sweeps->sweep();
    work.visits += kSweeps * static_cast<double>(system.size());
    const double residual = sweeps->violation() / scale;
    if (!std::isfinite(residual)) return false;
    if (residual > kSettled) asked_at = kSettled;
    since_kick += kSweeps;
    if (since_kick >= kOrbit && residual > kSettled) {
      // An orbit that closed would go on for ever: friction the other way round begins another one.
      since_kick = 0;
      sweeps->get(sweeps->impulses(), lambda);
      for (std::size_t i = 0; i < lambda.size(); ++i)
        if (is_scaled(system.rows[i])) lambda[i] = -lambda[i];
      sweeps->set(lambda);
      continue;
    }
    if (!(residual < kProgress * asked_at)) continue;
    asked_at = residual;
    sweeps->get(sweeps->impulses(), lambda);
    active.set_impulses(lambda.data());
    active.offer(lambda.data());
    active.predict_states();
    active.drop_factor();
    const bool solved = active.run(polish, budget, work, trace);
    active.drop_factor();
    if (solved) return true;
  }
  return false;
}

}  // namespace skerry
