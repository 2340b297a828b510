// SPDX-License-Identifier: MIT
#include "physics/solver/body_space.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "physics/solver/associated_path.h"
#include "physics/solver/block_sweeps.h"
#include "physics/solver/body_space_active_set.h"
#include "physics/solver/body_space_model.h"
#include "physics/solver/cone_rounds.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/interior_point.h"
#include "physics/solver/path_following.h"
#include "physics/solver/proximal.h"
#include "physics/solver/settling_sweeps.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Factorisations where somebody waits: of what is struck hard, more are needed where nobody does.
constexpr int kFactorisationLimit = 1000;
// Pivots of the last rungs are factorisations, too, up to about half a second of them, or ten times that; of
// those from nothing, which are begun where work has no limit, two hundred times.
constexpr double kPathVisits = 5e7, kUnlimitedPathVisits = 5e8, kPivotVisits = 1e10;
// Rows above which sweeps wander for longer than anybody waits.
constexpr std::size_t kSettlingRows = 4096;
// Sweeps hardly move what is so many times heavier, or what friction above this locks: those few settle at
// once or not at all.
constexpr double kHeavy = 100, kRough = 1;
constexpr int kBriefly = 20000;
// How long sweeps wander before they settle grows steeply with the rows: of some hundred problems of up to 32
// none settled after the first, 420 rows took 5400, and the square stands far above what was seen.
constexpr double kSettleFirst = 2000, kSettleSquare = 0.25;
// A warm active set that wins does so at once.
constexpr int kWarmIterations = 8;
// Changes that are few for a warm start, at most this and one in so many rows: they stay local, and cost less
// than a new factor.
constexpr int kFewChanges = 96, kFewOf = 64;
constexpr int kFewIterations = 16;
// Pivots of a warm path: what could rest was found before.
constexpr int kWarmPivots = 10;
// Where a solve is dear, a smaller proximal weight and a share of the target that is left over save one in
// three of them; smaller islands are solved to rounding, and their factor serves longer while they move.
constexpr double kEtaOfLarge = 3e-8, kLinearOfLarge = 0.4;
// Best residual after rounds of sweeps and paths from which proximal steps go on at once, and their first
// weight: of what is left there is little to be smoothed.
constexpr double kConesCame = 1e-2, kConesEta = 1e-2;
// Residual from which on contacts are looked at for contradictions.
constexpr double kContradiction = 1e-2;
constexpr int kColdIterations = 12;
// The interior point is sooner there than changes of states if, where all stick, one in so many rows or more
// is wrong; in large islands, where each change costs a factor of its own, already at the other number.
constexpr int kWrongOf = 8, kWrongOfLarge = 64;
// Up to so many rows a few sweeps foresee the states better than anything else, at a tenth of the cost of an
// interior point; they do not reach through more.
constexpr std::size_t kSweptRows = 128;
constexpr int kSweeps = 20;

// Larger problems have no spare memory.
constexpr std::size_t kSpareRows = 512;

struct BodySpaceMemory final : SolverMemory {
  BodySpaceModel model;
  ActiveSet active{model};
  bool has_states = false;  // `active` holds states worth starting from

  std::string_view solver() const override { return "body_space"; }
  void archive(Archive& a) override { a(model, active, has_states); }
};

/// Impulses after a few sweeps from nothing. @return false where the rows are not those of contacts
bool sweep_shortly(const IslandSystem& system, SolveWork& work, std::vector<double>& lambda) {
  Spare<BlockSweeps> sweeps;
  if (!sweeps->assign(system)) return false;
  sweeps->set({});
  for (int k = 0; k < kSweeps; ++k) sweeps->sweep();
  sweeps->get(sweeps->impulses(), lambda);
  work.visits += kSweeps * static_cast<double>(system.size());
  return true;
}

SettlingOptions settling_options(const IslandSystem& system, double tolerance) {
  SettlingOptions settling{.tolerance = tolerance};
  const auto rows = static_cast<double>(system.size());
  settling.sweeps = static_cast<int>(
      std::min<double>(settling.sweeps, std::max(kSettleFirst, kSettleSquare * rows * rows)));
  double lightest = 0, heaviest = kInfinity;
  for (const InverseMass& body : system.bodies) {
    if (!(body.linear > 0)) continue;
    lightest = std::max(lightest, body.linear);
    heaviest = std::min(heaviest, body.linear);
  }
  const bool rough =
      std::any_of(system.rows.begin(), system.rows.end(), [](const Row& row) { return row.mu > kRough; });
  if (rough || lightest > kHeavy * heaviest) settling.sweeps = std::min(settling.sweeps, kBriefly);
  return settling;
}

void note(SolveTrace* trace, const char* text) {
  if (trace) trace->notes.emplace_back(text);
}

}  // namespace

Solution solve_body_space(const IslandSystem& system, std::span<const double> warm_start,
                          const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  Solution solution;
  solution.method = "body_space";
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  SolveTrace* trace = solution.trace.get();
  const std::size_t n = system.rows.size();

  // The impulses of the last step may still be right: the whole cost is one look.
  const bool warm = warm_start.size() == n &&
                    std::any_of(warm_start.begin(), warm_start.end(), [](double z) { return z != 0; });
  if (n == 0 || warm) {
    solution.lambda = take_spare<std::vector<double>>();
    solution.lambda.assign(warm_start.begin(), warm_start.begin() + static_cast<std::ptrdiff_t>(n));
    solution.residual = clamp_and_judge(system, solution.lambda, options.tolerance, options.threads);
    solution.work.visits = static_cast<double>(n);
    if (solution.residual <= options.tolerance) {
      solution.status = SolveStatus::Solved;
      note(trace, "the warm start solves the problem already");
      return solution;
    }
  }

  // Small problems whose memory nobody keeps use that of an earlier one.
  std::unique_ptr<SolverMemory> local;
  std::optional<Spare<BodySpaceMemory>> spare;
  if (!memory && n <= kSpareRows) {
    spare.emplace();
    (*spare)->model.forget();
  } else if (!memory) {
    memory = &local;
  }
  BodySpaceMemory& kept = spare ? **spare : make_memory_as<BodySpaceMemory>(*memory);
  BodySpaceModel& model = kept.model;
  ActiveSet& active = kept.active;
  SolveWork& work = solution.work;

  model.use_threads(options.threads);
  const double change = model.assign(system, work);
  if (!std::isfinite(change)) kept.has_states = false;
  active.reset(change);
  if (trace) trace->ordering = model.pattern().order();

  SolveBudget budget;
  const bool unlimited = options.max_iterations == 0 && options.work_limit == 0 && options.time_budget == 0;
  budget.factorisations = options.max_iterations > 0 ? options.max_iterations
                          : unlimited                ? std::numeric_limits<int>::max()
                                                     : kFactorisationLimit;
  if (options.work_limit > 0) budget.visits = options.work_limit;
  if (options.time_budget > 0) {
    const auto deadline =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(options.time_budget);
    budget.exhausted = [deadline] { return std::chrono::steady_clock::now() >= deadline; };
  }
  ActiveSet::Options limits;
  limits.target = std::min(1e-12, options.tolerance);
  limits.enough = limits.target;
  limits.tolerance = options.tolerance;
  if (model.is_adaptable()) {
    limits.eta = kEtaOfLarge;
    limits.linear = kLinearOfLarge;
  }
  bool solved = false;

  if (warm) {
    active.set_impulses(solution.lambda.data());
    // Where rounding is all that is left, what is no better does not take its place, so that rest is found.
    active.offer();
    if (kept.has_states)
      active.predict_closing();
    else
      active.predict_states();
    note(trace, "active set from the warm start");
    limits.few = model.is_adaptable() ? std::min(kFewChanges, static_cast<int>(n) / kFewOf) : 0;
    limits.max_iterations = limits.few > 0 ? kFewIterations : kWarmIterations;
    // States that are settled by less than the tolerance are not worth a factor where that is dear.
    if (limits.few > 0) limits.enough = options.tolerance;
    if (kept.has_states) limits.most = static_cast<double>(n) / kWrongOf + 2;
    solved = active.run(limits, budget, work, trace);
    limits.most = kInfinity;
    if (!solved && limits.few > 0 && !budget.spent(work)) {
      // Where contacts opened and slipped a moment ago, those states can lead astray.
      active.set_impulses(solution.lambda.data());
      active.stick_everything();
      note(trace, "active set from the warm start, all touching contacts sticking");
      solved = active.run(limits, budget, work, trace);
    }
    limits.enough = limits.target;
    if (!solved && !budget.spent(work)) {
      // What is jammed and touched rests again, mostly, with forces that are hard to find from these.
      note(trace, "path of associated sliding from the warm start");
      solved = follow_associated_path(system, solution.lambda, options.tolerance, model, active, budget, work,
                                      trace);
    }
    if (!solved && kept.has_states && limits.few == 0 && !budget.spent(work)) {
      note(trace, "path from the warm start, one state at a time");
      solved = follow_path_from(solution.lambda, options.tolerance, kWarmPivots, model, active, budget, work,
                                trace);
    }
  }
  const auto continue_from_best = [&](double eta) {
    ProximalOptions proximal;
    proximal.tolerance = options.tolerance;
    proximal.eta = eta;
    solved = proximal_continuation(model, active, proximal, budget, work, trace);
  };
  const auto take_turns = [&](std::span<const double> start) {
    note(trace, "sweeps and the interior point on the cone in turn");
    ConeRoundsOptions cones;
    cones.tolerance = options.tolerance;
    solved = cone_rounds(system, start, model, active, cones, budget, work, trace);
    if (solved || budget.spent(work) || !(active.best_residual() < kConesCame)) return;
    note(trace, "proximal continuation from there");
    active.set_impulses(active.best().data());
    continue_from_best(kConesEta);
  };
  const std::vector<double> zero(n, 0.0);
  bool flows = false;         // many contacts neither stick nor stay open
  bool many_wrong = false;    // so many that changing their states one factor after the other does not pay
  std::vector<double> stuck;  // impulses if all others do
  if (!solved && !budget.spent(work)) {
    active.set_impulses(zero.data());
    active.stick_everything();
    note(trace, "active set from all touching contacts sticking");
    limits.max_iterations = kColdIterations;
    limits.few = 0;
    limits.must_fall = model.is_adaptable();
    // Two proximal steps show the forces; if many states are wrong, pivoting from here does not pay.
    const bool found = active.refine(limits, 2, work);
    const int wrong = found ? active.contradictions() : 0, rows = static_cast<int>(n);
    flows = !found || wrong > rows / kWrongOf + 2;
    many_wrong = flows || (model.is_adaptable() && wrong > rows / kWrongOfLarge);
    stuck = active.impulses();
    if (!many_wrong) solved = active.run(limits, budget, work, trace);
  }
  std::vector<double> swept;
  if (!solved && n <= kSweptRows && !budget.spent(work) && sweep_shortly(system, work, swept)) {
    active.set_impulses(swept.data());
    active.predict_states();
    note(trace, "active set from a few sweeps");
    limits.max_iterations = kWarmIterations;
    limits.must_fall = false;
    solved = active.run(limits, budget, work, trace);
  }
  if (!solved && warm && flows && !budget.spent(work)) take_turns(solution.lambda);
  if (!solved && !budget.spent(work)) {
    note(trace, "interior point, polished by the active set");
    InteriorPointOptions interior;
    interior.tolerance = options.tolerance;
    // Later changes of states led away from the size of the forces.
    if (swept.empty() && !flows) active.set_impulses(stuck.data());
    solved = interior_point(model, active, interior, budget, work, trace);
  }
  if (!solved && !(warm && flows) && !budget.spent(work))
    take_turns(std::isfinite(active.best_residual()) ? std::span<const double>(active.best()) : zero);
  const bool vain = !solved && n <= kSettlingRows && !(active.best_residual() < kContradiction) &&
                    contradicts(system, budget, work);
  if (vain) note(trace, "contacts that contradict each other: no answer");
  if (!solved && !vain && !budget.spent(work)) {
    note(trace, "proximal continuation from the best iterate");
    active.set_impulses(std::isfinite(active.best_residual()) ? active.best().data() : zero.data());
    continue_from_best(ProximalOptions().eta);
  }
  if (!solved && !vain && unlimited && options.max_iterations == 0 && model.is_adaptable()) {
    SolveBudget rest = budget;
    rest.factorisations = std::numeric_limits<int>::max();
    rest.visits = std::min(budget.visits, work.visits + kPivotVisits);
    note(trace, "path of states from nothing");
    solved = pivot_from_nothing(options.tolerance, model, active, rest, work, trace);
  }
  if (!solved && !vain && (!warm || unlimited) && options.max_iterations == 0) {
    SolveBudget rest = budget;
    rest.factorisations = std::numeric_limits<int>::max();
    rest.visits = std::min(budget.visits, work.visits + (unlimited ? kUnlimitedPathVisits : kPathVisits));
    note(trace, "path following, one state at a time");
    if (!std::isfinite(active.best_residual())) active.offer(zero.data());
    solved = follow_paths(model, active, {.tolerance = options.tolerance}, rest, work, trace);
    rest.visits = budget.visits;
    // Not worth beginning where the work does not allow for all of it.
    const SettlingOptions settling = settling_options(system, options.tolerance);
    const double all = settling.sweeps * static_cast<double>(n);
    if (!solved && !warm && n <= kSettlingRows && work.visits + all <= budget.visits && !rest.spent(work)) {
      note(trace, "sweeps until the states settle");
      solved = settle_by_sweeps(system, active, settling, rest, work, trace);
    }
  }

  // Nothing is better than impulses that ran away, or leave more than they were to change.
  if (!vain && active.best_residual() < 1) {
    solution.lambda = active.best();
  } else {
    solution.lambda = zero;
    model.project(solution.lambda.data());
  }
  kept.has_states = solved;
  solution.iterations = work.factorisations;
  conclude(system, options, solution);
  if (solution.status == SolveStatus::Inexact)
    note(trace, "no rung reached the tolerance; best iterate kept");
  return solution;
}

extern const SolverEntry kBodySpaceEntry;
const SolverEntry kBodySpaceEntry = {
    .name = "body_space",
    .summary = "block LDL^T on the body graph, active set with exact Coulomb states, interior point",
    .reference = "Hintermueller, Ito & Kunisch 2002; Mehrotra 1992; Rockafellar 1976",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_body_space,
    .make_memory = []() -> std::unique_ptr<SolverMemory> { return std::make_unique<BodySpaceMemory>(); },
};

}  // namespace skerry
