// SPDX-License-Identifier: MIT
#include "physics/solver/interior_point.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace skerry {
namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// Fraction of the step to the boundary.
constexpr double kToBoundary = 0.99;
// Regularises rows whose slacks say nothing yet (relative to D).
constexpr double kDelta = 1e-9;
// Steps with the bounds of friction held, after two short ones in a row.
constexpr int kHeldSteps = 6;
constexpr double kShortStep = 0.1;
// The active set is asked when the residual is below the first and tau has fallen by the second.
constexpr double kPolishResidual = 1e-2;
constexpr double kPolishTau = 0.05;
constexpr double kSmallestTau = 1e-18;

// One inequality of a row: slack > 0, multiplier > 0, slack * multiplier -> 0.
struct Side {
  double slack = 0, multiplier = 0;      // slack 0: there is no such bound
  double weight = 0;                     // target of the product is tau * weight
  double gap = 0;                        // (lambda - bound) - slack: infeasibility
  double target = 0;                     // right-hand side of the complementarity equation
  double d_slack = 0, d_multiplier = 0;  // direction
  double c_slack = 0, c_multiplier = 0;  // correction of it
  bool active() const { return slack > 0; }
  double weighted() const { return slack * multiplier / weight; }
};

struct InteriorRow {
  Side lower, upper;
  double lambda = 0;
  bool fixed = false;  // lambda is given: dead rows, friction with mu = 0, equal bounds
  double theta = 0;    // coupling of a friction row to the step of its normal row
};

class InteriorPoint {
 public:
  InteriorPoint(BodySpaceModel& model, ActiveSet& active, const InteriorPointOptions& options)
      : model_(model), active_(active), options_(options), rows_(at(model.rows())) {
    for (auto* v : {&w_, &g_, &h_, &k_, &d_, &c_, &lambda_}) v->assign(rows_.size(), 0.0);
    start();
  }
  bool run(const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

 private:
  void start();
  bool assemble(SolveWork& work);
  void correction(bool with_residuals, SolveWork& work);
  double add_correction(double least_weight);
  double mean_product(double step) const;
  template <class F>
  void each_side(F&& f) {
    for (InteriorRow& row : rows_) {
      if (row.lower.active()) f(row.lower);
      if (row.upper.active()) f(row.upper);
    }
  }
  template <class F>
  void each_side(F&& f) const {
    for (const InteriorRow& row : rows_) {
      if (row.lower.active()) f(row.lower);
      if (row.upper.active()) f(row.upper);
    }
  }
  bool polish(const SolveBudget& budget, SolveWork& work, SolveTrace* trace);
  void copy_impulses() {
    for (std::size_t i = 0; i < rows_.size(); ++i) lambda_[i] = rows_[i].lambda;
  }

  BodySpaceModel& model_;
  ActiveSet& active_;
  const InteriorPointOptions& options_;
  std::vector<InteriorRow> rows_;
  std::vector<double> w_, g_, h_, k_, d_, c_, lambda_;
  int sides_ = 0;
  bool coupled_ = true;
};

void InteriorPoint::start() {
  const double scale = model_.scale();
  const std::vector<double>& guess = active_.impulses();
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    InteriorRow& row = rows_[at(i)];
    if (r.dead || (r.normal >= 0 && r.mu == 0) || (r.normal < 0 && r.lower == r.upper)) {
      row.fixed = true;
      row.lambda = r.normal >= 0 ? 0 : std::clamp(0.0, r.lower, r.upper);
      continue;
    }
    if (r.normal >= 0) {
      // The cone is entered in its middle, as far up as the normal row is.
      const Side& n = rows_[at(r.normal)].lower;
      const double radius = r.mu * rows_[at(r.normal)].lambda;
      if (!(radius > 0)) {
        row.fixed = true;
        continue;
      }
      row.lower = row.upper = {.slack = radius, .multiplier = n.multiplier, .weight = radius * n.multiplier};
    } else if (std::isfinite(r.lower) && std::isfinite(r.upper)) {
      row.lambda = 0.5 * (r.lower + r.upper);
      const double radius = 0.5 * (r.upper - r.lower);
      row.lower = row.upper = {.slack = radius, .multiplier = scale, .weight = radius * scale};
    } else if (std::isfinite(r.lower) || std::isfinite(r.upper)) {
      // Forces differ by orders of magnitude from top to bottom of a stack; the path starts at their size.
      const double unit = scale / r.D;
      double slack = unit, multiplier = scale;
      if (options_.from_impulses) {
        slack = std::clamp(std::fabs(guess[at(i)]), unit, 1e12 * unit);
        multiplier = std::max(scale * std::sqrt(unit / slack), 1e-3 * scale);
      }
      const Side side{.slack = slack, .multiplier = multiplier, .weight = slack * multiplier};
      if (std::isfinite(r.lower)) {
        row.lower = side;
        row.lambda = r.lower + slack;
      } else {
        row.upper = side;
        row.lambda = r.upper - slack;
      }
    }
    sides_ += row.lower.active() + row.upper.active();
  }
}

bool InteriorPoint::assemble(SolveWork& work) {
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    InteriorRow& row = rows_[at(i)];
    g_[at(i)] = h_[at(i)] = row.theta = 0;
    if (row.fixed) continue;
    const double p = row.lower.active() ? row.lower.multiplier / row.lower.slack : 0;
    const double q = row.upper.active() ? row.upper.multiplier / row.upper.slack : 0;
    const double g = 1 / (p + q + r.compliance + kDelta * r.D);
    g_[at(i)] = g;
    if (r.normal >= 0) {
      const double radius = r.mu * rows_[at(r.normal)].lambda;
      row.lower.gap = radius + row.lambda - row.lower.slack;
      row.upper.gap = radius - row.lambda - row.upper.slack;
      if (coupled_) {
        row.theta = r.mu * (p - q) * g;
        h_[at(i)] = -row.theta * g_[at(r.normal)];
      }
    } else {
      if (row.lower.active()) row.lower.gap = row.lambda - r.lower - row.lower.slack;
      if (row.upper.active()) row.upper.gap = r.upper - row.lambda - row.upper.slack;
    }
  }
  return model_.factor(g_.data(), h_.data(), work);
}

// Solves the Newton equations for the targets of the sides, with or without the residuals of the other
// equations.
void InteriorPoint::correction(bool with_residuals, SolveWork& work) {
  for (int i = 0; i < model_.rows(); ++i) {
    const InteriorRow& row = rows_[at(i)];
    k_[at(i)] = 0;
    if (row.fixed) continue;
    double k = with_residuals ? -w_[at(i)] : 0;
    const auto add = [&](const Side& s, double sign) {
      if (!s.active()) return;
      k += sign *
           (with_residuals ? s.multiplier + (s.target - s.multiplier * s.gap) / s.slack : s.target / s.slack);
    };
    add(row.lower, 1);
    add(row.upper, -1);
    k_[at(i)] = k * g_[at(i)];
    if (row.theta != 0) k_[at(i)] -= row.theta * k_[at(model_.row(i).normal)];
  }
  model_.solve(k_.data(), g_.data(), h_.data(), c_.data(), work);
  for (int i = 0; i < model_.rows(); ++i) {
    InteriorRow& row = rows_[at(i)];
    if (row.fixed) continue;
    const auto& r = model_.row(i);
    const double widening = r.normal >= 0 && coupled_ ? r.mu * c_[at(r.normal)] : 0;
    const auto finish = [&](Side& s, double d) {
      if (!s.active()) return;
      s.c_slack = widening + d + (with_residuals ? s.gap : 0);
      s.c_multiplier = (s.target - s.multiplier * s.c_slack) / s.slack;
    };
    finish(row.lower, c_[at(i)]);
    finish(row.upper, -c_[at(i)]);
  }
}

// Adds the correction with the weight that allows the longest step that keeps slacks and multipliers
// positive; returns that step. One pass looks at all weights: the falls, relative to what there is, are
// linear in them.
double InteriorPoint::add_correction(double least_weight) {
  constexpr int kTrials = 8;
  std::array<double, kTrials + 1> weights, falls{};
  for (int k = 0; k <= kTrials; ++k) weights[at(k)] = least_weight + (1 - least_weight) * k / kTrials;
  const auto look = [&](double size, double direction, double correction) {
    const double inverse = -1 / size, d = direction * inverse, c = correction * inverse;
    for (int k = 0; k <= kTrials; ++k) falls[at(k)] = std::max(falls[at(k)], d + weights[at(k)] * c);
  };
  each_side([&](const Side& s) {
    look(s.slack, s.d_slack, s.c_slack);
    look(s.multiplier, s.d_multiplier, s.c_multiplier);
  });
  double best = -1, weight = 0;
  for (int k = kTrials; k >= 0; --k) {
    const double length = falls[at(k)] > 1 ? 1 / falls[at(k)] : 1;
    if (length > best) {
      best = length;
      weight = weights[at(k)];
    }
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) d_[i] += weight * c_[i];
  each_side([&](Side& s) {
    s.d_slack += weight * s.c_slack;
    s.d_multiplier += weight * s.c_multiplier;
  });
  return best;
}

double InteriorPoint::mean_product(double step) const {
  double sum = 0;
  each_side([&](const Side& s) {
    sum += (s.slack + step * s.d_slack) * (s.multiplier + step * s.d_multiplier) / s.weight;
  });
  return sum / std::max(1, sides_);
}

bool InteriorPoint::polish(const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  std::vector<RowState>& states = active_.states();
  for (int i = 0; i < model_.rows(); ++i) {
    const InteriorRow& row = rows_[at(i)];
    const double D = model_.row(i).D;
    RowState s = RowState::Free;
    // A constraint counts as active where its slack, in velocity units, is smaller than its multiplier.
    const bool low = row.lower.active() && row.lower.slack * D < row.lower.multiplier;
    const bool high = row.upper.active() && row.upper.slack * D < row.upper.multiplier;
    if (low && (!high || row.lower.multiplier > row.upper.multiplier))
      s = RowState::Lower;
    else if (high)
      s = RowState::Upper;
    else if (row.fixed && model_.row(i).normal < 0)
      s = RowState::Lower;
    states[at(i)] = s;
  }
  active_.set_impulses(lambda_.data());
  active_.drop_factor();
  ActiveSet::Options limits;
  limits.target = std::min(1e-12, options_.tolerance);
  limits.tolerance = options_.tolerance;
  limits.patience = 100;  // the number of changes may rise a little on the way
  const bool solved = active_.run(limits, budget, work, trace);
  active_.drop_factor();
  return solved;
}

bool InteriorPoint::run(const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  double last_polish = kInfinity;
  int short_steps = 0, held = 0;
  for (int it = 0; it < options_.max_iterations && !budget.spent(work); ++it) {
    each_side([](Side& s) { s.d_slack = s.d_multiplier = 0; });
    std::fill(d_.begin(), d_.end(), 0.0);
    const double tau = mean_product(0);
    copy_impulses();
    model_.evaluate(lambda_.data(), w_.data());
    if (!assemble(work)) return false;

    // Predictor: straight to the end; how far it comes tells how much to centre.
    each_side([](Side& s) { s.target = -s.slack * s.multiplier; });
    correction(true, work);
    double length = add_correction(1);
    const double reached = std::max(0.0, mean_product(length));
    const double centring = std::min(0.8, std::pow(reached / tau, 3));
    const double aim = centring * tau;
    each_side([&](Side& s) { s.target = aim * s.weight - s.d_slack * s.d_multiplier; });
    correction(false, work);
    length = add_correction(length * length);

    length *= kToBoundary;
    if (!(length > 0)) return false;

    for (std::size_t i = 0; i < rows_.size(); ++i) {
      InteriorRow& row = rows_[i];
      if (row.fixed) continue;
      row.lambda += length * d_[i];
      for (Side* s : {&row.lower, &row.upper})
        if (s->active()) {
          s->slack += length * s->d_slack;
          s->multiplier += length * s->d_multiplier;
        }
    }
    copy_impulses();
    const double residual = active_.offer(lambda_.data());
    if (!std::isfinite(residual)) return false;
    if (trace) trace->iterations.push_back({.residual = residual});
    each_side([](Side& s) { s.d_slack = s.d_multiplier = 0; });
    const double now = mean_product(0);
    if (residual < kPolishResidual && now < kPolishTau * last_polish) {
      last_polish = now;
      if (polish(budget, work, trace)) return true;
    }
    if (tau < kSmallestTau) break;

    // The full Newton step is not always a good one: the bounds of friction move with it.
    if (coupled_) {
      short_steps = length < kShortStep ? short_steps + 1 : std::max(0, short_steps - 1);
      if (short_steps >= 2) {
        coupled_ = false;
        held = kHeldSteps;
        short_steps = 0;
      }
    } else if (--held <= 0) {
      coupled_ = true;
    }
  }
  return false;
}

}  // namespace

bool interior_point(BodySpaceModel& model, ActiveSet& active, const InteriorPointOptions& options,
                    const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  InteriorPoint method(model, active, options);
  active.drop_factor();
  return method.run(budget, work, trace);
}

}  // namespace skerry
