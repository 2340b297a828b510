// SPDX-License-Identifier: MIT
#include "physics/islands/delassus.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "physics/text.h"

namespace skerry {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

struct Touch {
  int row;
  const std::array<double, 3>* J;
};

/// Rows that touch each body which can move, in row order.
std::vector<std::vector<Touch>> rows_by_body(const IslandSystem& system) {
  std::vector<std::vector<Touch>> touches(system.bodies.size());
  for (int i = 0; i < system.size(); ++i) {
    const Row& row = system.rows[static_cast<std::size_t>(i)];
    for (const auto& [body, J] : {std::pair{row.a, &row.Ja}, std::pair{row.b, &row.Jb}}) {
      if (body >= 0) touches[static_cast<std::size_t>(body)].push_back({i, J});
    }
  }
  return touches;
}

double couple(const InverseMass& mass, const std::array<double, 3>& x, const std::array<double, 3>& y) {
  return mass.linear * (x[0] * y[0] + x[1] * y[1]) + mass.angular * (x[2] * y[2]);
}

/// 1-norm of the inverse of a symmetric matrix, estimated from a few solves [Hager 1984].
template <typename Solve>
double inverse_norm_estimate(Eigen::Index n, const Solve& solve) {
  Eigen::VectorXd x = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n));
  double estimate = 0;
  for (int k = 0; k < 5; ++k) {
    const Eigen::VectorXd y = solve(x);
    const double norm = y.lpNorm<1>();
    if (!(norm > estimate)) break;
    estimate = norm;
    const Eigen::VectorXd z = solve(y.unaryExpr([](double v) { return v < 0 ? -1.0 : 1.0; }));
    Eigen::Index j = 0;
    if (z.cwiseAbs().maxCoeff(&j) <= z.dot(x)) break;
    x = Eigen::VectorXd::Unit(n, j);
  }
  return estimate;
}

double one_norm(const Matrix& A) {
  double norm = 0;
  for (int j = 0; j < A.outerSize(); ++j) {
    double sum = 0;
    for (Matrix::InnerIterator it(A, j); it; ++it) sum += std::abs(it.value());
    norm = std::max(norm, sum);
  }
  return norm;
}

}  // namespace

Matrix delassus(const IslandSystem& system) {
  const int n = system.size();
  const auto touches = rows_by_body(system);
  Matrix W(n, n);
  std::vector<double> sum(static_cast<std::size_t>(n), 0.0);
  std::vector<int> seen(static_cast<std::size_t>(n), -1), column;
  for (int j = 0; j < n; ++j) {
    const Row& row = system.rows[static_cast<std::size_t>(j)];
    column.assign(1, j);
    seen[static_cast<std::size_t>(j)] = j;
    sum[static_cast<std::size_t>(j)] =
        system.compliance.empty() ? 0 : system.compliance[static_cast<std::size_t>(j)];
    // The body with the smaller number first, so that W(i, j) and W(j, i) add the same terms in one order.
    std::pair<int, const std::array<double, 3>*> ends[] = {{row.a, &row.Ja}, {row.b, &row.Jb}};
    if (ends[1].first < ends[0].first) std::swap(ends[0], ends[1]);
    for (const auto& [body, J] : ends) {
      if (body < 0) continue;
      const auto k = static_cast<std::size_t>(body);
      for (const Touch& touch : touches[k]) {
        const auto i = static_cast<std::size_t>(touch.row);
        if (seen[i] != j) {
          seen[i] = j;
          sum[i] = 0;
          column.push_back(touch.row);
        }
        sum[i] += couple(system.bodies[k], *J, *touch.J);
      }
    }
    std::sort(column.begin(), column.end());
    W.startVec(j);
    for (const int i : column) W.insertBack(i, j) = sum[static_cast<std::size_t>(i)];
  }
  W.finalize();
  return W;
}

ContactProblem contact_problem(const IslandSystem& system) {
  return {delassus(system), system.b, system.rows};
}

std::vector<double> row_velocities(const ContactProblem& problem, const std::vector<double>& lambda) {
  std::vector<double> w(lambda.size(), 0.0);
  for (int j = 0; j < problem.size(); ++j) {
    const double impulse = lambda[static_cast<std::size_t>(j)];
    if (impulse == 0) continue;
    for (Matrix::InnerIterator it(problem.W, j); it; ++it)
      w[static_cast<std::size_t>(it.row())] += it.value() * impulse;
  }
  for (std::size_t i = 0; i < w.size(); ++i) w[i] -= problem.b[i];
  return w;
}

std::vector<double> inverse_effective_masses(const ContactProblem& problem) {
  std::vector<double> diagonal(problem.rows.size());
  for (int i = 0; i < problem.size(); ++i) diagonal[static_cast<std::size_t>(i)] = problem.W.coeff(i, i);
  return diagonal;
}

double natural_map_residual(const ContactProblem& problem, const std::vector<double>& lambda) {
  const std::vector<double> w = row_velocities(problem, lambda);
  const std::vector<double> diagonal = inverse_effective_masses(problem);
  double worst = 0;
  for (std::size_t i = 0; i < w.size(); ++i) {
    const Row& row = problem.rows[i];
    const double normal_impulse = row.normal < 0 ? 0 : lambda[static_cast<std::size_t>(row.normal)];
    const double violation =
        natural_map_violation(impulse_bounds(row, normal_impulse), diagonal[i], lambda[i], w[i]);
    if (std::isnan(violation)) return violation;
    worst = std::max(worst, violation);
  }
  return worst / residual_scale(largest_magnitude(problem.b));
}

double residual_floor(const ContactProblem& problem, const std::vector<double>& lambda) {
  std::vector<double> size(lambda.size(), 0.0);
  for (int j = 0; j < problem.size(); ++j) {
    const double impulse = std::abs(lambda[static_cast<std::size_t>(j)]);
    for (Matrix::InnerIterator it(problem.W, j); it; ++it) {
      size[static_cast<std::size_t>(it.row())] += std::abs(it.value()) * impulse;
    }
  }
  const double largest = largest_magnitude(size), scale = largest_magnitude(problem.b);
  return kRoundingUnit * (scale > kLeastScale ? std::max(largest / scale, 1.0) : largest);
}

void validate(const ContactProblem& problem) {
  const int n = problem.size();
  if (problem.W.rows() != n || problem.W.cols() != n) {
    throw std::invalid_argument("W must be " + std::to_string(n) + " x " + std::to_string(n) + ", got " +
                                std::to_string(problem.W.rows()) + " x " + std::to_string(problem.W.cols()));
  }
  for (int j = 0; j < n; ++j) {
    for (Matrix::InnerIterator it(problem.W, j); it; ++it) {
      if (std::isfinite(it.value())) continue;
      throw std::invalid_argument("W(" + std::to_string(it.row()) + ", " + std::to_string(j) +
                                  ") must be finite, got " + to_text(it.value()));
    }
  }
  // The rest is the same as for an island; Jacobians are not looked at here.
  IslandSystem shell;
  shell.bodies.resize(1);
  shell.b = problem.b;
  shell.rows = problem.rows;
  for (Row& row : shell.rows) {
    row.a = -1;
    row.b = 0;
    row.Ja = row.Jb = {0, 0, 0};
  }
  validate(shell);
}

std::string_view to_string(Ordering ordering) {
  return ordering == Ordering::Natural ? "natural" : "approximate minimum degree";
}

FactorPattern factor_pattern(const IslandSystem& system, Ordering ordering) {
  return factor_pattern(delassus(system), ordering);
}

FactorPattern factor_pattern(const Matrix& W, Ordering ordering) {
  FactorPattern pattern;
  const auto n = static_cast<int>(W.rows());
  if (n == 0) return pattern;

  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation(n);
  permutation.setIdentity();
  if (ordering == Ordering::ApproximateMinimum) {
    Eigen::AMDOrdering<int> amd;
    amd(W, permutation);
  }
  pattern.order.assign(permutation.indices().data(), permutation.indices().data() + n);

  // P W P^T with order[k] in place k, made positive definite: redundant contacts make W singular.
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> to_place(permutation.inverse());
  Matrix permuted(n, n);
  permuted = W.twistedBy(to_place);
  for (int j = 0; j < n; ++j) {
    double& diagonal = permuted.coeffRef(j, j);
    diagonal = diagonal > 0 ? diagonal * (1 + 1e-10) : 1;
  }
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factor(permuted);
  const Matrix L = factor.matrixL();
  int lower_nonzeros = 0;
  for (int j = 0; j < n; ++j) {
    for (Matrix::InnerIterator it(permuted, j); it; ++it) lower_nonzeros += it.row() >= j;
    for (Matrix::InnerIterator it(L, j); it; ++it) {
      if (it.row() <= j) continue;
      pattern.row.push_back(static_cast<int>(it.row()));
      pattern.column.push_back(j);
    }
  }
  pattern.fill = static_cast<double>(pattern.row.size() + static_cast<std::size_t>(n)) / lower_nonzeros;
  pattern.condition =
      factor.info() == Eigen::Success
          ? one_norm(permuted) *
                inverse_norm_estimate(
                    n, [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(factor.solve(x)); })
          : kInfinity;
  return pattern;
}

}  // namespace skerry
