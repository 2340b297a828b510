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

}  // namespace

bool settle_by_sweeps(const IslandSystem& system, ActiveSet& active, const SettlingOptions& options,
                      const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  Spare<BlockSweeps> sweeps;
  if (!sweeps->assign(system)) return false;
  sweeps->set({});
  ActiveSet::Options polish;
  polish.target = std::min(1e-12, options.tolerance);
  polish.tolerance = options.tolerance;
  polish.max_iterations = polish.patience = kPolishIterations;
  const double scale = largest_magnitude(system.b) > 0 ? largest_magnitude(system.b) : 1;
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
