// SPDX-License-Identifier: MIT
//
// One contact, or one scalar row: the answer by formula.
//
// A contact is open (lambda = 0), sticks (w = 0) or slips (lambda_t = +-mu lambda_n, w_n = 0); each choice
// leaves at most a 3 x 3 linear system. The choices are tried in the order open, stick, slip against the
// positive tangent, slip along it, and the first that satisfies every inequality is the answer. Where
// Painleve's paradox gives several (mu so large that W_nn - mu |W_nt| < 0: open and a slip can both hold, or
// stick and a slip), this order picks the one with the least impulse. For b_n > 0 one exists whenever W is
// positive definite; when the bodies cannot give what b asks for (no inverse mass along the row), the best
// choice is returned as Inexact.
#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/solver/contact_states.h"
#include "physics/solver/solver_trace.h"
#include "physics/spare.h"

namespace skerry {
namespace {

constexpr int kRows = 3;

/// The problem in local variables, on the stack.
struct OneContact {
  int n = 0;
  std::array<std::array<double, kRows>, kRows> W{};
  std::array<double, kRows> b{};
  std::array<double, kRows> mu{};
};

using Impulses = std::array<double, kRows>;

double row_product(const IslandSystem& system, const Row& x, const Row& y) {
  const auto couple = [&](int body, const std::array<double, 3>& p, const std::array<double, 3>& q) {
    if (body < 0) return 0.0;
    const InverseMass& mass = system.bodies[static_cast<std::size_t>(body)];
    return mass.linear * (p[0] * q[0] + p[1] * q[1]) + mass.angular * p[2] * q[2];
  };
  // Rows of one contact join the same bodies, perhaps the other way round.
  const bool same = x.a == y.a && x.b == y.b;
  return same ? couple(x.a, x.Ja, y.Ja) + couple(x.b, x.Jb, y.Jb)
              : couple(x.a, x.Ja, y.Jb) + couple(x.b, x.Jb, y.Ja);
}

/// Solves the k x k system by elimination with row pivoting, in place; false when it is singular to rounding.
template <int k>
bool solve_small(std::array<std::array<double, kRows>, kRows>& A, std::array<double, kRows>& x) {
  for (int p = 0; p < k; ++p) {
    int best = p;
    double scale = 0;
    for (int i = p; i < k; ++i) {
      if (std::abs(A[i][p]) > std::abs(A[best][p])) best = i;
      for (int j = p; j < k; ++j) scale = std::max(scale, std::abs(A[i][j]));
    }
    if (!(std::abs(A[best][p]) > 1e-14 * scale)) return false;
    std::swap(A[p], A[best]);
    std::swap(x[p], x[best]);
    for (int i = p + 1; i < k; ++i) {
      const double factor = A[i][p] / A[p][p];
      for (int j = p; j < k; ++j) A[i][j] -= factor * A[p][j];
      x[i] -= factor * x[p];
    }
  }
  for (int p = k - 1; p >= 0; --p) {
    for (int j = p + 1; j < k; ++j) x[p] -= A[p][j] * x[j];
    x[p] /= A[p][p];
  }
  return true;
}

/// Largest violation of the natural map, absolute. @tparam N  rows of the contact, here and below
template <int N>
double violation(const OneContact& contact, const Impulses& lambda) {
  double worst = 0;
  for (int i = 0; i < N; ++i) {
    double w = -contact.b[i];
    for (int j = 0; j < N; ++j) w += contact.W[i][j] * lambda[j];
    const double bound = contact.mu[i] * std::max(lambda[0], 0.0);
    const ImpulseBounds bounds = i == 0 ? ImpulseBounds{0, kInfinity} : ImpulseBounds{-bound, bound};
    worst = std::max(worst, natural_map_violation(bounds, contact.W[i][i], lambda[i], w));
  }
  return worst;
}

/// Impulses of a closed contact; side[i] is 0 when row i is free and +-1 when it is at that bound.
template <int N>
bool closed_impulses(const OneContact& contact, const std::array<int, kRows>& side, Impulses& lambda) {
  std::array<std::array<double, kRows>, kRows> A;
  std::array<double, kRows> x;
  std::array<int, kRows> free;
  int k = 0;
  for (int i = 0; i < N; ++i) {
    if (side[i] == 0) free[k++] = i;
  }
  for (int p = 0; p < k; ++p) {
    x[p] = contact.b[free[p]];
    for (int q = 0; q < k; ++q) A[p][q] = contact.W[free[p]][free[q]];
    // Columns at a bound follow the normal impulse, which is always the first unknown.
    for (int j = 1; j < N; ++j) A[p][0] += side[j] * contact.mu[j] * contact.W[free[p]][j];
  }
  if (!(k == 1 ? solve_small<1>(A, x) : k == 2 ? solve_small<2>(A, x) : solve_small<3>(A, x))) return false;
  for (int p = 0; p < k; ++p) lambda[free[p]] = x[p];
  for (int j = 1; j < N; ++j) {
    if (side[j] != 0) lambda[j] = side[j] * contact.mu[j] * lambda[0];
  }
  for (int j = 1; j < N; ++j) {
    const double bound = contact.mu[j] * std::max(lambda[0], 0.0);
    lambda[j] = std::clamp(lambda[j], -bound, bound);
  }
  lambda[0] = std::max(lambda[0], 0.0);
  return true;
}

/// @param best_violation  of the answer
template <int N>
Impulses solve_contact(const OneContact& contact, double tolerance, double& best_violation) {
  Impulses best{};
  best_violation = violation<N>(contact, best);
  const auto consider = [&](const std::array<int, kRows>& side) {
    Impulses lambda{};
    if (!closed_impulses<N>(contact, side, lambda)) return;
    const double found = violation<N>(contact, lambda);
    if (found < best_violation) best = lambda, best_violation = found;
  };
  for (const int friction : {0, -1, 1}) {
    for (const int rolling : {0, -1, 1}) {
      if (best_violation <= tolerance) return best;
      if (N < 3 && rolling != 0) break;
      consider({0, friction, rolling});
    }
  }
  return best;
}

bool is_one_contact(const IslandSystem& system) {
  const auto n = system.rows.size();
  if (n > kRows || system.rows[0].kind != RowKind::Normal) return false;
  if (system.rows[0].lower != 0 || system.rows[0].upper != kInfinity) return false;
  const auto same_pair = [&](const Row& x, const Row& y) {
    return (x.a == y.a && x.b == y.b) || (x.a == y.b && x.b == y.a);
  };
  for (std::size_t i = 1; i < n; ++i) {
    if (!is_scaled(system.rows[i]) || !same_pair(system.rows[0], system.rows[i])) return false;
  }
  return true;
}

Solution answer(const IslandSystem& system, const SolveOptions& options) {
  Solution solution;
  solution.method = "closed_form";
  solution.lambda = take_spare<std::vector<double>>();
  solution.lambda.assign(system.rows.size(), 0.0);
  solution.iterations = 1;
  if (system.rows.size() == 1) {
    const Row& row = system.rows[0];
    const double diagonal = inverse_effective_masses(system)[0];
    const double wanted = diagonal > 0 ? system.b[0] / diagonal : 0;
    solution.lambda[0] = std::clamp(std::isfinite(wanted) ? wanted : 0, row.lower, row.upper);
  } else if (!system.rows.empty()) {
    if (!is_one_contact(system)) {
      solution.status = SolveStatus::Unsupported;
      clamp_to_bounds(system.rows, solution.lambda);
      solution.residual = natural_map_residual(system, solution.lambda);
      return solution;
    }
    OneContact contact;
    contact.n = system.size();
    double scale = 0;
    for (int i = 0; i < contact.n; ++i) {
      const auto p = static_cast<std::size_t>(i);
      contact.b[p] = system.b[p];
      contact.mu[p] = system.rows[p].mu;
      scale = std::max(scale, std::abs(contact.b[p]));
      for (std::size_t q = 0; q <= p; ++q) {
        contact.W[p][q] = contact.W[q][p] = row_product(system, system.rows[p], system.rows[q]);
      }
      if (!system.compliance.empty()) contact.W[p][p] += system.compliance[p];
    }
    double worst = 0;
    const double tolerance = 8 * kRoundingUnit * scale;
    const Impulses lambda = contact.n == 2 ? solve_contact<2>(contact, tolerance, worst)
                                           : solve_contact<3>(contact, tolerance, worst);
    std::copy_n(lambda.begin(), contact.n, solution.lambda.begin());
    // W is at hand, and so is the residual; a sum sees what is not a number.
    if (scale > 0 && worst <= options.tolerance * scale && std::isfinite(lambda[0] + lambda[1] + lambda[2])) {
      solution.status = SolveStatus::Solved;
      solution.residual = worst / scale;
      return solution;
    }
  }
  conclude(system, options, solution);
  return solution;
}

Solution solve_closed_form(const IslandSystem& system, std::span<const double>, const SolveOptions& options,
                           std::unique_ptr<SolverMemory>*) {
  Solution solution = answer(system, options);
  if (options.trace) {
    solution.trace = std::make_unique<SolveTrace>();
    record_iteration(system, solution.lambda, *solution.trace);
  }
  return solution;
}

}  // namespace

extern const SolverEntry kClosedFormEntry{
    .name = "closed_form",
    .summary = "one contact (normal, friction, rolling) or one joint row, by formula",
    .reference = "contact states of plane Coulomb friction: Glocker 2001, ch. 8",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_closed_form};

}  // namespace skerry
