// SPDX-License-Identifier: MIT
#include "physics/solver/dependent_rows.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "physics/solver/contact_states.h"
#include "physics/solver/dense_factors.h"
#include "physics/spare.h"

namespace skerry {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Least singular value of the scaled W that counts, as a share of the largest: the square of what velocities
// change by.
constexpr double kLeastShare = 1e-14;
// Compliance of rows, scaled as W is, of which all have an answer; and the share of what is wanted that they
// then give way by where there is none without. Rounds of it at most.
constexpr double kGive = 1e-12, kGivesWay = 1e-3;
constexpr int kSingleRounds = 200;
// Refinements of one linear problem, and changes of states.
constexpr int kRefinements = 3, kRounds = 20;
// A row takes part in a contradiction if it has more than this share of its largest error.
constexpr double kTakesPart = 1e-3;
// Cost of a round in visits, besides a visit for each entry of W.
constexpr double kRound = 200;

/// Rows are scaled by the roots of their W_ii: `A_` is that of J M^-1/2, W its square, and impulses are
/// `z_ = lambda sqrt(W_ii)`.
class DependentRowsSolve {
 public:
  DependentRowsSolve(const IslandSystem& system, const SolveOptions& options, Solution& solution)
      : system_(system), options_(options), solution_(solution), count_(system.size()) {
    const auto columns = 3 * static_cast<Index>(system.bodies.size());
    const bool gives = !system.compliance.empty();
    A_ = MatrixXd::Zero(count_, columns + (gives ? count_ : 0));
    for (Index i = 0; i < count_; ++i) {
      has_scaled_ |= row(i).normal >= 0;
      put(i, row(i).a, row(i).Ja);
      put(i, row(i).b, row(i).Jb);
      if (gives) A_(i, columns + i) = std::sqrt(system.compliance[at(i)]);
    }
    size_ = A_.rowwise().norm();
    const VectorXd scale = size_.unaryExpr([](double s) { return s > 0 ? 1 / s : 0; });
    A_ = scale.asDiagonal() * A_;
    b_ = scale.cwiseProduct(Eigen::Map<const VectorXd>(system.b.data(), count_));
  }

  DependentRows run(std::span<const double> warm_start) {
    if (!A_.allFinite() || !b_.allFinite()) return DependentRows::Unknown;
    if (warm_start.size() == system_.rows.size()) {
      std::vector<double> lambda = starting_impulses(system_.rows, warm_start);
      states_ = states_from_impulses(system_.rows, lambda);
      give_spare(std::move(lambda));
    } else {
      states_ = all_sticking(system_.rows);
    }
    for (int round = 0; round < kRounds; ++round) {
      solve_states();
      if (offer()) return DependentRows::Solved;
      if (!change_states(0)) {
        if (is_contradiction()) return DependentRows::Contradictory;
        break;
      }
    }
    return has_scaled_ ? DependentRows::Unknown : solve_with_compliance();
  }

 private:
  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }
  const Row& row(Index i) const { return system_.rows[at(i)]; }
  RowState state(Index i) const { return states_[at(i)]; }

  void put(Index i, int body, const std::array<double, 3>& J) {
    if (body < 0) return;
    const InverseMass& mass = system_.bodies[static_cast<std::size_t>(body)];
    A_(i, 3 * body) += std::sqrt(mass.linear) * J[0];
    A_(i, 3 * body + 1) += std::sqrt(mass.linear) * J[1];
    A_(i, 3 * body + 2) += std::sqrt(mass.angular) * J[2];
  }

  bool is_open(Index i) const { return row(i).normal >= 0 && state(row(i).normal) != RowState::Free; }

  /// Bounds of `z_`; those of friction by the normal impulses that there are.
  ImpulseBounds bounds(Index i) const {
    const int normal = row(i).normal;
    const double carried = normal < 0 ? 0 : z_[normal] / size_[normal];
    const ImpulseBounds own = impulse_bounds(row(i), std::isfinite(carried) ? carried : 0);
    return {own.lower * size_[i], own.upper * size_[i]};
  }

  VectorXd error() const { return b_ - A_ * (A_.transpose() * z_); }

  /// Without friction: rows that give a little have one answer, whose states single changes come to. Where it
  /// leaves errors there is none without.
  DependentRows solve_with_compliance() {
    bool all = true;  // change all that are wrong, as long as these get fewer
    Index least = count_ + 1;
    const auto is_spent = [this] {
      return options_.work_limit > 0 && solution_.work.visits > options_.work_limit;
    };
    for (int round = 0; round < kSingleRounds; ++round) {
      if (round > 0 && is_spent()) return DependentRows::Unknown;
      give_a_little();
      const std::vector<RowState> before = states_;
      const Index wrong = change_states(kGive);
      if (wrong == 0) break;
      if (wrong < least)
        least = wrong;
      else
        all = false;
      if (all) continue;
      const auto [first, then] = std::mismatch(before.begin(), before.end(), states_.begin());
      const RowState changed = *then;
      const Index place = first - before.begin();
      states_ = before;
      states_[at(place)] = changed;
    }
    const double gives = kGive * z_.cwiseAbs().maxCoeff(), most = b_.cwiseAbs().maxCoeff();
    offer();
    solve_states();
    if (offer()) return DependentRows::Solved;
    return gives > kGivesWay * most ? DependentRows::Contradictory : DependentRows::Unknown;
  }

  /// Impulses of free rows with a compliance of `kGive`, the rest at their bounds.
  void give_a_little() {
    count_work();
    std::vector<Index> free;
    z_ = VectorXd::Zero(count_);
    for (Index i = 0; i < count_; ++i) {
      if (!(size_[i] > 0)) continue;
      if (state(i) == RowState::Free)
        free.push_back(i);
      else
        z_[i] = size_[i] * (state(i) == RowState::Lower ? row(i).lower : row(i).upper);
    }
    if (free.empty()) return;
    const MatrixXd chosen = A_(free, Eigen::all);
    MatrixXd W = chosen * chosen.transpose();
    W.diagonal().array() += kGive;
    const VectorXd rest = error()(free);
    const VectorXd found = W.llt().solve(rest);
    for (std::size_t k = 0; k < free.size(); ++k) z_[free[k]] = found[static_cast<Index>(k)];
  }

  void count_work() {
    ++solution_.work.factorisations;
    solution_.work.visits += static_cast<double>(count_ * count_) + kRound;
  }

  /// Impulses of what is free, by least squares; the rest at their bounds.
  void solve_states() {
    count_work();
    slips_ = false;
    std::vector<Index> free;
    z_ = VectorXd::Zero(count_);
    // What impulses of free rows bring along: themselves, and the friction of what slips.
    MatrixXd along = MatrixXd::Zero(count_, count_);
    for (Index i = 0; i < count_; ++i) {
      if (!(size_[i] > 0)) continue;
      const int normal = row(i).normal;
      if (normal < 0 && state(i) != RowState::Free) {
        z_[i] = size_[i] * (state(i) == RowState::Lower ? row(i).lower : row(i).upper);
      } else if (state(i) == RowState::Free && !is_open(i)) {
        along(i, static_cast<Index>(free.size())) = 1;
        free.push_back(i);
      } else if (!is_open(i) && row(i).mu > 0 && size_[normal] > 0) {
        const Index place = std::find(free.begin(), free.end(), normal) - free.begin();
        along(i, place) = (state(i) == RowState::Lower ? -row(i).mu : row(i).mu) * size_[i] / size_[normal];
        slips_ = true;
      }
    }
    const auto unknowns = static_cast<Index>(free.size());
    if (unknowns == 0) return;
    const MatrixXd chosen = A_(free, Eigen::all);
    const auto brought = along.leftCols(unknowns);
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> factor;
    factor.setThreshold(kLeastShare);
    factor.compute(chosen * (A_.transpose() * brought));
    VectorXd left = error()(free);
    double worst = kInfinity;
    for (int k = 0; k <= kRefinements; ++k) {
      const VectorXd before = z_;
      z_ += brought * solution_of(factor, left);
      left = error()(free);
      const double now = left.cwiseAbs().maxCoeff();
      // What a refinement does not make better is rounding.
      if (now < worst) {
        worst = now;
      } else {
        z_ = before;
        break;
      }
    }
  }

  /// @return whether the impulses are an answer
  bool offer() {
    Solution other;
    other.lambda = take_spare<std::vector<double>>();
    other.lambda.resize(at(count_));
    for (Index i = 0; i < count_; ++i) other.lambda[at(i)] = size_[i] > 0 ? z_[i] / size_[i] : 0;
    conclude(system_, options_, other);
    const bool solved = other.status == SolveStatus::Solved;
    if (solved || other.residual < solution_.residual) {
      solution_.lambda.swap(other.lambda);
      solution_.residual = other.residual;
      solution_.status = other.status;
    }
    give_spare(std::move(other.lambda));
    return solved;
  }

  /// States by the natural map of rows with some compliance. @return how many changed
  Index change_states(double compliance) {
    const VectorXd r = error() - compliance * z_;
    Index changed = 0;
    std::vector<RowState> next = states_;
    for (Index i = 0; i < count_; ++i) {
      if (!(size_[i] > 0) || is_open(i)) continue;
      const ImpulseBounds limits = bounds(i);
      const double wanted = z_[i] + r[i];
      RowState& own = next[at(i)];
      own = wanted < limits.lower   ? RowState::Lower
            : wanted > limits.upper ? RowState::Upper
                                    : RowState::Free;
      changed += own != state(i);
    }
    states_.swap(next);
    return changed;
  }

  /// True if the errors are impulses that change no velocity, and nothing bounds them.
  bool is_contradiction() const {
    if (slips_) return false;
    const VectorXd r = error();
    double worst = 0;
    for (Index i = 0; i < count_; ++i)
      if (state(i) == RowState::Free && !is_open(i)) worst = std::max(worst, std::abs(r[i]));
    for (Index i = 0; i < count_; ++i) {
      if (state(i) != RowState::Free || is_open(i) || !(std::abs(r[i]) > kTakesPart * worst)) continue;
      const bool bounded = r[i] > 0 ? row(i).upper < kInfinity : row(i).lower > -kInfinity;
      if (row(i).normal >= 0 || bounded) return false;
    }
    return worst > 0;
  }

  const IslandSystem& system_;
  const SolveOptions& options_;
  Solution& solution_;
  Index count_;
  MatrixXd A_;
  VectorXd size_, b_, z_;
  std::vector<RowState> states_;
  bool slips_ = false, has_scaled_ = false;
};

}  // namespace

DependentRows solve_dependent_rows(const IslandSystem& system, std::span<const double> warm_start,
                                   const SolveOptions& options, Solution& solution) {
  return DependentRowsSolve(system, options, solution).run(warm_start);
}

}  // namespace skerry
