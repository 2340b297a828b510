// SPDX-License-Identifier: MIT
#include "physics/solver/cone_rounds.h"

#include <algorithm>
#include <cmath>

#include "physics/solver/block_sweeps.h"
#include "physics/solver/cone_interior_point.h"
#include "physics/solver/contact_states.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Sweeps before each path, and its steps at most.
constexpr int kSweeps = 100, kSteps = 60;
// Where a path is joined, of the largest |b| (the first one) and of the violation at least.
constexpr double kStart = 0.1, kFarStart = 5;
// Solves in a step of a path.
constexpr int kSolves = 2;
// A path is lost where steps are shorter than this.
constexpr double kShort = 1e-2;
// The active set is asked when the residual is below the first, and has fallen by the second since it was
// last asked.
constexpr double kPolishResidual = 1e-3, kPolishProgress = 0.3;
constexpr int kPolishIterations = 6;
// Rounds that bring the residual to more than this of what it was do not pay.
constexpr double kProgress = 0.7;

}  // namespace

bool cone_rounds(const IslandSystem& system, std::span<const double> start, const BodySpaceModel& model,
                 ActiveSet& active, const ConeRoundsOptions& options, const SolveBudget& budget,
                 SolveWork& work, SolveTrace* trace) {
  Spare<BlockSweeps> sweeps;
  Spare<ConeInteriorPoint> path;
  SolveWork uncounted;
  if (!sweeps->assign(system, false, model.threads()) || !path->assign(system, uncounted, model.threads()))
    return false;
  work.symbolic_analyses += uncounted.symbolic_analyses;
  const double scale = residual_scale(largest_magnitude(system.b));
  ActiveSet::Options polish;
  polish.target = std::min(1e-12, options.tolerance);
  polish.tolerance = options.tolerance;
  polish.max_iterations = polish.patience = kPolishIterations;
  sweeps->set(start);
  double asked_at = kInfinity;
  std::vector<double> lambda;
  int idle = 0;
  for (int round = 0; round < options.rounds && !budget.spent(work); ++round) {
    const double before = active.best_residual();
    for (int k = 0; k < kSweeps; ++k) sweeps->sweep();
    work.visits += kSweeps * static_cast<double>(system.size());
    sweeps->get(sweeps->impulses(), lambda);
    active.offer(lambda.data());
    const double violation = sweeps->violation();
    if (!std::isfinite(violation)) return false;
    path->start(lambda, std::max(round == 0 ? kStart * scale : 0, kFarStart * violation));
    for (int k = 0; k < kSteps && !budget.spent(work); ++k) {
      const double length = path->step(uncounted);
      model.count_factor(true, work);
      for (int solves = 0; solves < kSolves; ++solves) model.count_solve(work);
      if (!(length > 0)) break;
      path->get(lambda);
      if (active.offer(lambda.data()) <= options.tolerance || length < kShort) break;
    }
    const double residual = active.best_residual();
    if (trace) trace->iterations.push_back({.residual = residual});
    if (residual < kPolishResidual && residual < kPolishProgress * asked_at) {
      asked_at = residual;
      const std::vector<double> best = active.best();
      active.set_impulses(best.data());
      active.predict_states();
      if (active.run(polish, budget, work, trace)) return true;
    }
    idle = residual > kProgress * before ? idle + 1 : 0;
    if (idle > 1 || !std::isfinite(residual)) break;
    sweeps->set(active.best());
  }
  return false;
}

}  // namespace skerry
