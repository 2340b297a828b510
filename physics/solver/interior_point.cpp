// SPDX-License-Identifier: MIT
#include "physics/solver/interior_point.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "physics/index.h"
#include "physics/large_pages.h"
#include "physics/spare.h"
#include "physics/thread_pool.h"

namespace skerry {
namespace {

// Fraction of the step to the boundary.
constexpr double kToBoundary = 0.99;
// Regularises rows whose slacks say nothing yet (relative to D).
constexpr double kDelta = 1e-12;
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
      : model_(model), active_(active), options_(options) {
    resize_large(rows_, at(model.rows()));
    for (auto* v : {&w_, &g_, &h_, &k_, &d_, &c_, &lambda_}) v->assign(rows_.size(), 0.0);
    start();
  }
  bool run(const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

 private:
  // Rows whose sums are taken together, whoever takes them.
  static constexpr int kSummed = 2048;
  // Weights of a correction that are tried.
  static constexpr int kTrials = 8;
  using Falls = std::array<double, kTrials + 1>;

  void start();
  bool assemble(SolveWork& work);
  void aim(double product);
  double predict(SolveWork& work);
  double correct(double least_weight, SolveWork& work, double& weight);
  double move(double length, double weight);
  void finish_direction(int first, int last, bool with_residuals);
  double mean_product(double step) const;

  // Calls `f` for each inequality of the rows from `first` to before `last`.
  template <class Rows, class F>
  static void each_side(Rows& rows, int first, int last, F&& f) {
    for (int i = first; i < last; ++i) {
      auto& row = rows[at(i)];
      if (row.lower.active()) f(row.lower);
      if (row.upper.active()) f(row.upper);
    }
  }
  // The mean over all inequalities, of sums that `f(first, last)` takes.
  template <class F>
  double mean(const F& f) const {
    const int n = model_.rows(), pieces = (n + kSummed - 1) / kSummed;
    Spare<std::vector<double>> sums;
    sums->assign(at(pieces), 0.0);
    share_each(model_.threads(), at(pieces), 1, [&](std::size_t i) {
      const int first = static_cast<int>(i) * kSummed;
      (*sums)[i] = f(first, std::min(n, first + kSummed));
    });
    double sum = 0;
    for (const double each : *sums) sum += each;
    return sum / std::max(1, sides_);
  }
  bool polish(const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

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

// Factorises the Newton equations, and sets the right-hand side of the predictor, which goes straight to the
// end.
bool InteriorPoint::assemble(SolveWork& work) {
  model_.share_rows([&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const auto& r = model_.row(i);
      InteriorRow& row = rows_[at(i)];
      g_[at(i)] = h_[at(i)] = k_[at(i)] = row.theta = 0;
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
      double k = -w_[at(i)];
      const auto add = [&](Side& s, double sign) {
        if (!s.active()) return;
        s.target = -s.slack * s.multiplier;
        k += sign * (s.multiplier + (s.target - s.multiplier * s.gap) / s.slack);
      };
      add(row.lower, 1);
      add(row.upper, -1);
      k_[at(i)] = k * g;
      if (row.theta != 0) k_[at(i)] -= row.theta * k_[at(r.normal)];
    }
  });
  return model_.factor(g_.data(), h_.data(), work);
}

// Sets the right-hand side of the corrector: products that are to become `product` times their weights.
void InteriorPoint::aim(double product) {
  model_.share_rows([&](int first, int last) {
    for (int i = first; i < last; ++i) {
      InteriorRow& row = rows_[at(i)];
      if (row.fixed) continue;
      double k = 0;
      const auto add = [&](Side& s, double sign) {
        if (!s.active()) return;
        s.target = product * s.weight - s.d_slack * s.d_multiplier;
        k += sign * (s.target / s.slack);
      };
      add(row.lower, 1);
      add(row.upper, -1);
      k_[at(i)] = k * g_[at(i)];
      if (row.theta != 0) k_[at(i)] -= row.theta * k_[at(model_.row(i).normal)];
    }
  });
}

// What the step `c_` of the impulses means for the slacks and multipliers of some rows.
void InteriorPoint::finish_direction(int first, int last, bool with_residuals) {
  for (int i = first; i < last; ++i) {
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

// Solves for the predictor, which becomes the direction; returns the longest step, 1 at most, that keeps
// slacks and multipliers positive.
double InteriorPoint::predict(SolveWork& work) {
  model_.solve(k_.data(), g_.data(), h_.data(), c_.data(), work);
  const double fall = model_.largest_of_rows([&](int first, int last) {
    finish_direction(first, last, true);
    double most = 0;
    each_side(rows_, first, last, [&](Side& s) {
      s.d_slack = s.c_slack;
      s.d_multiplier = s.c_multiplier;
      most = std::max({most, s.d_slack * (-1 / s.slack), s.d_multiplier * (-1 / s.multiplier)});
    });
    std::copy(c_.begin() + first, c_.begin() + last, d_.begin() + first);
    return most;
  });
  return fall > 1 ? 1 / fall : 1;
}

// Solves for the corrector, and looks for the weight with which it allows the longest step; returns that
// step. One pass looks at all weights: the falls, relative to what there is, are linear in them.
double InteriorPoint::correct(double least_weight, SolveWork& work, double& weight) {
  model_.solve(k_.data(), g_.data(), h_.data(), c_.data(), work);
  Falls weights;
  for (int k = 0; k <= kTrials; ++k) weights[at(k)] = least_weight + (1 - least_weight) * k / kTrials;
  Spare<std::vector<Falls>> found;
  found->assign(model_.row_pieces(), Falls{});
  model_.share_row_pieces([&](int first, int last, std::size_t piece) {
    finish_direction(first, last, false);
    Falls& falls = (*found)[piece];
    const auto look = [&](double size, double direction, double correction) {
      const double inverse = -1 / size, d = direction * inverse, c = correction * inverse;
      for (int k = 0; k <= kTrials; ++k) falls[at(k)] = std::max(falls[at(k)], d + weights[at(k)] * c);
    };
    each_side(rows_, first, last, [&](const Side& s) {
      look(s.slack, s.d_slack, s.c_slack);
      look(s.multiplier, s.d_multiplier, s.c_multiplier);
    });
  });
  double best = -1;
  for (int k = kTrials; k >= 0; --k) {
    double fall = 0;
    for (const Falls& falls : *found) fall = std::max(fall, falls[at(k)]);
    const double length = fall > 1 ? 1 / fall : 1;
    if (length > best) {
      best = length;
      weight = weights[at(k)];
    }
  }
  return best;
}

// Moves along the direction with so much of the correction; returns the mean product.
double InteriorPoint::move(double length, double weight) {
  return mean([&](int first, int last) {
    double sum = 0;
    for (int i = first; i < last; ++i) {
      InteriorRow& row = rows_[at(i)];
      if (!row.fixed) row.lambda += length * (d_[at(i)] + weight * c_[at(i)]);
      lambda_[at(i)] = row.lambda;
    }
    each_side(rows_, first, last, [&](Side& s) {
      s.slack += length * (s.d_slack + weight * s.c_slack);
      s.multiplier += length * (s.d_multiplier + weight * s.c_multiplier);
      sum += s.slack * s.multiplier / s.weight;
    });
    return sum;
  });
}

// The mean product after so much of the direction.
double InteriorPoint::mean_product(double step) const {
  return mean([&](int first, int last) {
    double sum = 0;
    each_side(rows_, first, last, [&](const Side& s) {
      sum += (s.slack + step * s.d_slack) * (s.multiplier + step * s.d_multiplier) / s.weight;
    });
    return sum;
  });
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
  double now = mean_product(0);
  for (std::size_t i = 0; i < rows_.size(); ++i) lambda_[i] = rows_[i].lambda;
  for (int it = 0; it < options_.max_iterations && !budget.spent(work); ++it) {
    const double tau = now;
    model_.evaluate(lambda_.data(), w_.data());
    if (!assemble(work)) return false;

    // How far the predictor comes tells how much to centre.
    double length = predict(work);
    const double reached = std::max(0.0, mean_product(length));
    const double centring = std::min(0.8, std::pow(reached / tau, 3));
    aim(centring * tau);
    double weight = 0;
    length = kToBoundary * correct(length * length, work, weight);
    if (!(length > 0)) return false;

    now = move(length, weight);
    const double residual = active_.offer(lambda_.data());
    if (!std::isfinite(residual)) return false;
    if (trace) trace->iterations.push_back({.residual = residual});
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
