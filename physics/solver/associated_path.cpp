// SPDX-License-Identifier: MIT
#include "physics/solver/associated_path.h"

#include <algorithm>
#include <vector>

#include "physics/solver/cone_interior_point.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/welded_bodies.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Where the path is joined, of the largest |b|, its steps at most, and its solves in a step.
constexpr double kStart = 0.3;
constexpr int kSteps = 40, kSolves = 2;
// The path is at its end where steps are shorter than this.
constexpr double kShort = 1e-2;
// Something slides if sliding is so many times what the path has left to go, which it is not before it has
// come so far, of the largest |b|.
constexpr double kSlides = 10, kFar = 1e-2;
// The active set is asked when the residual is below the first, and has fallen by the second since.
constexpr double kPolishResidual = 1e-5, kPolishProgress = 1e-2;
constexpr int kPolishIterations = 6;
// Of a search for rest alone.
constexpr int kRestFactors = 60;

}  // namespace

bool follow_associated_path(const IslandSystem& system, std::span<const double> start, double tolerance,
                            const BodySpaceModel& model, ActiveSet& active, const SolveBudget& budget,
                            SolveWork& work, SolveTrace* trace) {
  Spare<ConeInteriorPoint> path;
  SolveWork uncounted;
  if (!path->assign(system, uncounted, model.threads())) return false;
  work.symbolic_analyses += uncounted.symbolic_analyses;
  const double scale = residual_scale(largest_magnitude(system.b));
  ActiveSet::Options limits;
  limits.target = std::min(1e-12, tolerance);
  limits.tolerance = tolerance;
  limits.max_iterations = limits.patience = kPolishIterations;
  const auto polish = [&](const std::vector<double>& lambda) {
    active.set_impulses(lambda.data());
    active.predict_states();
    const bool solved = active.run(limits, budget, work, trace);
    active.drop_factor();
    return solved;
  };
  path->start(start, kStart * scale, ConeInteriorPoint::Sliding::Associated);
  double ask_below = kPolishResidual;
  Spare<std::vector<double>> lambda;
  for (int k = 0; k < kSteps && !budget.spent(work); ++k) {
    const double before = path->centre();
    const double length = path->step(uncounted);
    model.count_factor(false, work);
    for (int solves = 0; solves < kSolves; ++solves) model.count_solve(work);
    if (!(length > 0)) break;
    path->get(*lambda);
    const double residual = active.offer(lambda->data());
    if (trace) trace->iterations.push_back({.residual = residual});
    // Velocities are those of the beginning of the step.
    if (before < kFar * scale && path->sliding() > kSlides * before) return false;
    if (residual <= tolerance) return true;
    const bool ends = length < kShort && before < kFar * scale;
    if (residual < ask_below || ends) {
      if (polish(*lambda)) return true;
      ask_below = kPolishProgress * residual;
    }
    if (ends) return false;
  }
  return false;
}

Solution find_rest(const IslandSystem& system, std::span<const double> start, const SolveOptions& options) {
  Spare<WeldedBodies> welded;
  if (options.welds_as_one && welded->find(system)) {
    Spare<std::vector<double>> own;
    welded->restrict_to_groups(start, *own);
    Solution of_groups = find_rest(welded->groups(), *own, options);
    welded->expand(of_groups, options, nullptr);
    return of_groups;
  }
  Solution solution;
  solution.method = "associated";
  BodySpaceModel model;
  model.use_threads(options.threads);
  ActiveSet active(model);
  active.reset(model.assign(system, solution.work));
  SolveBudget budget;
  budget.factorisations = kRestFactors;
  const std::vector<double> zero(system.rows.size(), 0.0);
  active.offer(zero.data());
  follow_associated_path(system, start.empty() ? zero : start, options.tolerance, model, active, budget,
                         solution.work, nullptr);
  solution.lambda = active.best();
  solution.iterations = solution.work.factorisations;
  conclude(system, options, solution);
  return solution;
}

}  // namespace skerry
