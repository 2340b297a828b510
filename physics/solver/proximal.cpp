// SPDX-License-Identifier: MIT
#include "physics/solver/proximal.h"

#include <algorithm>
#include <cmath>

#include "physics/index.h"

namespace skerry {
namespace {

constexpr double kEtaLeast = 1e-10;
constexpr double kEtaGreatest = 4;
// Factors of eta after an inner problem without a change of state, one with, and one that was not solved.
constexpr double kEtaSettled = 0.1;
constexpr double kEtaFalls = 0.3;
constexpr double kEtaRises = 4;
// Failures and moves without progress that are put up with; near the end the way is worth more of them.
constexpr int kFailures = 12, kFailuresNear = 40, kMoves = 80;
constexpr double kNear = 1e-4, kProgress = 0.8;
constexpr int kStateIterations = 40;
constexpr int kNewtonSteps = 20;
constexpr int kHalvings = 5;
// The inner problem need not be solved better than the outer error deserves.
constexpr double kInnerReduction = 1e-2;
// The active set is asked when the residual is below the first, and has fallen by the second since it was
// last asked.
constexpr double kPolishResidual = 0.05, kPolishProgress = 0.3;
constexpr int kPolishIterations = 6;

class Proximal {
 public:
  Proximal(BodySpaceModel& model, ActiveSet& active) : model_(model), active_(active) {
    const std::size_t n = at(model.rows()), bodies = at(model.nodes()) + 1;
    for (auto* v : {&u_, &g_, &h_, &lambda_, &scratch_}) v->assign(n, 0.0);
    for (auto* v : {&velocity_, &trial_, &best_trial_, &force_}) v->assign(bodies, BodyVector{});
    states_.assign(n, RowState::Free);
    centre_ = active.impulses();
  }
  bool run(const ProximalOptions& options, const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

 private:
  double balance(const std::vector<BodyVector>& v);
  bool factor(SolveWork& work);
  bool inner(const SolveBudget& budget, SolveWork& work, int& steps, double& before, double& after);

  BodySpaceModel& model_;
  ActiveSet& active_;
  double eta_ = 0, factored_eta_ = 0;
  bool factored_ = false;
  std::vector<double> centre_, u_, g_, h_, lambda_, scratch_;
  std::vector<BodyVector> velocity_, trial_, best_trial_, force_;
  std::vector<RowState> states_, factored_states_;
};

// Impulses and states that follow from body velocities, and the momentum that they leave over.
double Proximal::balance(const std::vector<BodyVector>& v) {
  model_.row_velocities(v.data(), u_.data());
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    double lower = r.lower, upper = r.upper;
    if (r.normal >= 0) {
      upper = r.mu * std::max(0.0, lambda_[at(r.normal)]);
      lower = -upper;
    }
    const double weight = eta_ * r.D;
    const double z = r.dead ? 0 : (weight * centre_[at(i)] - u_[at(i)]) / (weight + r.compliance);
    states_[at(i)] = z > upper ? RowState::Upper : z < lower ? RowState::Lower : RowState::Free;
    lambda_[at(i)] = std::clamp(z, lower, upper);
  }
  return std::sqrt(model_.imbalance(v.data(), lambda_.data(), force_.data()));
}

bool Proximal::factor(SolveWork& work) {
  if (factored_ && factored_eta_ == eta_ && factored_states_ == states_) return true;
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    const RowState s = states_[at(i)];
    double g = 0, h = 0;
    const bool open = r.normal >= 0 && states_[at(r.normal)] != RowState::Free;
    if (s == RowState::Free) {
      if (!r.dead && !open && !(r.normal >= 0 && r.mu == 0)) g = 1 / (eta_ * r.D + r.compliance);
    } else if (r.normal >= 0 && !open) {
      h = (s == RowState::Upper ? r.mu : -r.mu) * g_[at(r.normal)];
    }
    g_[at(i)] = g;
    h_[at(i)] = h;
  }
  factored_ = model_.factor(g_.data(), h_.data(), work);
  factored_states_ = states_;
  factored_eta_ = eta_;
  return factored_;
}

// Newton with backtracking from velocity_; true if the imbalance fell as far as asked.
bool Proximal::inner(const SolveBudget& budget, SolveWork& work, int& steps, double& before, double& after) {
  const double rounding = 1e-11 * model_.scale();
  before = after = balance(velocity_);
  for (steps = 0; steps < kNewtonSteps; ++steps) {
    if (steps > 0 && (after < kInnerReduction * before || after < rounding)) return true;
    if (budget.spent(work) || !factor(work)) return false;
    model_.solve_bodies(force_.data(), work);
    const std::vector<BodyVector> direction = force_;
    double length = 1, least = kInfinity;
    bool falls = false;
    for (int k = 0; k < kHalvings && !falls; ++k, length *= 0.5) {
      for (std::size_t p = 0; p < trial_.size(); ++p) trial_[p].v = velocity_[p].v + direction[p].v * length;
      const double size = balance(trial_);
      if (size < least) {
        least = size;
        best_trial_ = trial_;
      }
      falls = size < (1 - 0.1 * length) * after;
    }
    if (!std::isfinite(least)) return false;
    velocity_ = best_trial_;
    after = balance(velocity_);
    if (!falls) break;
  }
  return after < kInnerReduction * before || after < rounding;
}

bool Proximal::run(const ProximalOptions& options, const SolveBudget& budget, SolveWork& work,
                   SolveTrace* trace) {
  eta_ = options.eta;
  double polished_at = kInfinity;
  ActiveSet::Options polish;
  polish.target = std::min(1e-12, options.tolerance);
  polish.tolerance = options.tolerance;
  polish.max_iterations = kPolishIterations;
  polish.patience = kPolishIterations;
  active_.set_impulses(centre_.data());
  active_.predict_states();
  std::vector<RowState> last = active_.states();
  int failures = 0, moves = 0;
  double least = kInfinity;
  for (int k = 0; k < options.max_iterations && !budget.spent(work); ++k) {
    // The states of the last centre are mostly right; changed all at once they settle in a few iterations.
    active_.states() = last;
    active_.set_impulses(centre_.data());
    bool solved = active_.solve_regularised(centre_, eta_, kStateIterations, budget, work);
    if (solved) {
      lambda_ = active_.impulses();
      states_ = active_.states();
    } else if (!budget.spent(work)) {
      // Newton with a merit function takes longer and goes further.
      model_.evaluate(centre_.data(), scratch_.data());
      model_.velocities(velocity_.data());
      active_.drop_factor();
      factored_ = false;
      int steps = 0;
      double before = 0, after = 0;
      solved = inner(budget, work, steps, before, after);
      active_.drop_factor();
    }
    if (!solved) {
      eta_ *= kEtaRises;
      if (eta_ > kEtaGreatest || ++failures > (least < kNear ? kFailuresNear : kFailures)) return false;
      continue;
    }
    int changes = 0;
    for (std::size_t i = 0; i < last.size(); ++i) changes += last[i] != states_[i];
    last = states_;
    centre_ = lambda_;
    model_.project(centre_.data());
    const double residual = active_.offer(centre_.data());
    if (trace) trace->iterations.push_back({.residual = residual, .pivots = changes});
    if (residual <= options.tolerance) return true;
    if (residual < kProgress * least) {
      // Far from the end failures add up: what comes through only now and then seldom arrives.
      if (residual < kNear) failures = 0;
      least = residual;
      moves = 0;
    } else if (++moves > kMoves) {
      return false;
    }
    if (residual < kPolishResidual && (residual < kPolishProgress * polished_at || changes == 0)) {
      polished_at = residual;
      active_.set_impulses(centre_.data());
      active_.drop_factor();
      const bool done = active_.run(polish, budget, work, trace);
      active_.drop_factor();
      if (done) return true;
    }
    eta_ = std::max(kEtaLeast, eta_ * (changes == 0 ? kEtaSettled : kEtaFalls));
  }
  return false;
}

}  // namespace

bool proximal_continuation(BodySpaceModel& model, ActiveSet& active, const ProximalOptions& options,
                           const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  Proximal method(model, active);
  active.drop_factor();
  return method.run(options, budget, work, trace);
}

}  // namespace skerry
