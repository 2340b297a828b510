// SPDX-License-Identifier: MIT
//
// One projected Gauss-Seidel sweep, for the three solvers built on it, over two ways to apply W: through the
// velocities of the bodies (O(1) a row), or row by row of a given W.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "physics/islands/delassus.h"
#include "physics/solver/contact_states.h"

namespace skerry {

/// W of an island by way of the bodies: holds M^-1 J^T lambda.
class BodyOperator {
 public:
  using Problem = IslandSystem;
  using State = std::vector<std::array<double, 3>>;

  explicit BodyOperator(const IslandSystem& system)
      : system_(system),
        diagonal_(inverse_effective_masses(system)),
        change_(system.bodies.size(), {0, 0, 0}) {}

  const Problem& problem() const { return system_; }
  double diagonal(std::size_t i) const { return diagonal_[i]; }
  const State& state() const { return change_; }

  void restart(const std::vector<double>& lambda) {
    std::fill(change_.begin(), change_.end(), std::array<double, 3>{0, 0, 0});
    apply_impulses(system_, lambda, change_);
  }

  /// (W lambda - b)_i.
  double velocity(std::size_t i, double lambda) const {
    const Row& row = system_.rows[i];
    double u = -system_.b[i];
    if (!system_.compliance.empty()) u += system_.compliance[i] * lambda;
    if (row.a >= 0) u += along(row.Ja, change_[static_cast<std::size_t>(row.a)]);
    if (row.b >= 0) u += along(row.Jb, change_[static_cast<std::size_t>(row.b)]);
    return u;
  }

  void add(std::size_t i, double impulse) {
    const Row& row = system_.rows[i];
    if (row.a >= 0) push(row.a, row.Ja, impulse);
    if (row.b >= 0) push(row.b, row.Jb, impulse);
  }

  /// state += factor * direction, for steps along combinations of impulses.
  void add_state(double factor, const State& direction) {
    for (std::size_t k = 0; k < change_.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) change_[k][c] += factor * direction[k][c];
    }
  }

 private:
  static double along(const std::array<double, 3>& J, const std::array<double, 3>& v) {
    return J[0] * v[0] + J[1] * v[1] + J[2] * v[2];
  }
  void push(int body, const std::array<double, 3>& J, double impulse) {
    const auto k = static_cast<std::size_t>(body);
    const InverseMass& mass = system_.bodies[k];
    change_[k][0] += mass.linear * J[0] * impulse;
    change_[k][1] += mass.linear * J[1] * impulse;
    change_[k][2] += mass.angular * J[2] * impulse;
  }

  const IslandSystem& system_;
  std::vector<double> diagonal_;
  State change_;
};

/// A given W: holds W lambda.
class MatrixOperator {
 public:
  using Problem = ContactProblem;
  using State = std::vector<double>;

  explicit MatrixOperator(const ContactProblem& problem)
      : problem_(problem), diagonal_(inverse_effective_masses(problem)), product_(problem.rows.size(), 0.0) {}

  const Problem& problem() const { return problem_; }
  double diagonal(std::size_t i) const { return diagonal_[i]; }
  const State& state() const { return product_; }

  void restart(const std::vector<double>& lambda) {
    product_ = row_velocities(problem_, lambda);
    for (std::size_t i = 0; i < product_.size(); ++i) product_[i] += problem_.b[i];
  }
  double velocity(std::size_t i, double) const { return product_[i] - problem_.b[i]; }
  void add(std::size_t i, double impulse) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(problem_.W, static_cast<int>(i)); it; ++it) {
      product_[static_cast<std::size_t>(it.row())] += it.value() * impulse;
    }
  }
  void add_state(double factor, const State& direction) {
    for (std::size_t i = 0; i < product_.size(); ++i) product_[i] += factor * direction[i];
  }

 private:
  const ContactProblem& problem_;
  std::vector<double> diagonal_;
  State product_;
};

/// Sweeps once over the rows in order; friction rows use the normal impulse of this sweep. The operator's
/// state must belong to `lambda`.
/// @param load  share of b that is wanted  @param take  share of the way to what a row wants
/// @return largest change, as a velocity: an estimate of the residual, absolute [m/s]
template <typename Operator>
double gauss_seidel_sweep(Operator& op, std::vector<double>& lambda, double load = 1, double take = 1) {
  const std::vector<Row>& rows = op.problem().rows;
  double largest = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double diagonal = op.diagonal(i);
    if (!(diagonal > 0)) continue;
    const Row& row = rows[i];
    const double normal_impulse = is_scaled(row) ? lambda[static_cast<std::size_t>(row.normal)] : 0;
    const ImpulseBounds bounds = impulse_bounds(row, normal_impulse);
    // The operator knows the whole load; what is not wanted is taken back.
    const double w = op.velocity(i, lambda[i]) + (1 - load) * op.problem().b[i];
    const double wanted = lambda[i] - take * w / diagonal;
    const double change = std::clamp(wanted, bounds.lower, bounds.upper) - lambda[i];
    if (change == 0 || !std::isfinite(change)) continue;
    lambda[i] += change;
    op.add(i, change);
    largest = std::max(largest, std::abs(change) * diagonal);
  }
  return largest;
}

}  // namespace skerry
