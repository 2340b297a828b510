// SPDX-License-Identifier: MIT
//
// The reference: the contact problem as a linear complementarity problem, solved by Lemke's method.
//
// In 2D the friction cone has two generators, so this is exact, not a linearised cone. Per contact with
// lambda_t = p - m [Stewart & Trinkle 1996; Anitescu & Potra 1997]:
//
//   0 <= lambda_n  perp  w_n >= 0,    0 <= p  perp  w_t + s >= 0,
//   0 <= s  perp  mu lambda_n - p - m >= 0,    0 <= m  perp  -w_t + s >= 0.
//
// z'Mz = lambda'W lambda + mu s lambda_n >= 0: copositive, so Lemke's method ends with a solution whenever
// one exists that needs no impossible bilateral motion. Rows without bounds are eliminated first with a
// pseudo inverse (redundant joints are no harm); a row with two bounds gets a multiplier for the upper one.
#include "physics/solver/lemke.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "physics/solver/dense_factors.h"
#include "physics/solver/independent_parts.h"
#include "physics/solver/solver_trace.h"

namespace skerry {
namespace {

/// Covering vectors tried after a ray.
constexpr int kCoverings = 8;
/// Sizes up to which all complementary bases are tried in the end: 16384 small systems, some 30 ms; under a
/// limit of work 256, a fifth of a millisecond.
constexpr int kEnumerated = 14, kEnumeratedSoon = 8;

/// The tableau w = M z + d z0 + q in the form  [w-columns | z-columns | z0 | rhs], one row a basic variable.
template <typename Scalar>
class Tableau {
 public:
  /// @param cover  d > 0
  Tableau(const Eigen::MatrixXd& M, const Eigen::VectorXd& q, const Eigen::VectorXd& cover)
      : n_(M.rows()), table_(n_, 2 * n_ + 2) {
    table_.setZero();
    table_.leftCols(n_).setIdentity();
    table_.middleCols(n_, n_) = -M.cast<Scalar>();
    table_.col(artificial()) = -cover.cast<Scalar>();
    table_.col(rhs()) = q.cast<Scalar>();
    basis_.resize(static_cast<std::size_t>(n_));
    for (Eigen::Index i = 0; i < n_; ++i) basis_[i] = i;
  }

  enum class End { Solved, Ray, Limit };

  End run(int max_pivots, int& pivots) {
    // The artificial variable enters; the row that leaves makes every right-hand side non-negative.
    if (table_.col(rhs()).minCoeff() >= 0) return End::Solved;
    Eigen::Index entering = artificial(), row = first_row();
    while (pivots < max_pivots) {
      const Eigen::Index leaving = basis_[row];
      pivot(row, entering);
      ++pivots;
      if (leaving == artificial()) return End::Solved;
      entering = leaving < n_ ? leaving + n_ : leaving - n_;
      row = leaving_row(entering);
      if (row < 0) return End::Ray;
    }
    return End::Limit;
  }

  Eigen::VectorXd z() const {
    Eigen::VectorXd result = Eigen::VectorXd::Zero(n_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      const Eigen::Index variable = basis_[i];
      if (variable >= n_ && variable < 2 * n_) {
        result[variable - n_] = std::max(0.0, static_cast<double>(table_(i, rhs())));
      }
    }
    return result;
  }

 private:
  Eigen::Index artificial() const { return 2 * n_; }
  Eigen::Index rhs() const { return 2 * n_ + 1; }

  /// Lexicographically least of the rows (q, basis inverse) / d.
  Eigen::Index first_row() const {
    Eigen::Index best = 0;
    for (Eigen::Index i = 1; i < n_; ++i) {
      // Cross-multiplied by d. Of tied rows the last: the identity's 1 stands later in it.
      const Scalar x = table_(i, rhs()) * table_(best, artificial());
      const Scalar y = table_(best, rhs()) * table_(i, artificial());
      if (x >= y) best = i;
    }
    return best;
  }

  /// Lexicographic minimum ratio over the positive entries of the entering column; the artificial variable
  /// leaves whenever it is among the ties. -1: no positive entry.
  Eigen::Index leaving_row(Eigen::Index entering) const {
    const auto column = table_.col(entering);
    const Scalar epsilon = std::numeric_limits<Scalar>::epsilon();
    const Scalar smallest_pivot = 1e3 * epsilon * std::max(Scalar(1), column.cwiseAbs().maxCoeff());
    const Scalar tie = 256 * epsilon * std::max(Scalar(1), table_.col(rhs()).cwiseAbs().maxCoeff());
    Eigen::Index best = -1;
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (column[i] <= smallest_pivot) continue;
      if (best < 0 || precedes(i, best, entering, tie)) best = i;
    }
    if (best < 0) return best;
    for (Eigen::Index i = 0; i < n_; ++i) {
      if (basis_[i] != artificial() || column[i] <= smallest_pivot) continue;
      if (table_(i, rhs()) / column[i] <= table_(best, rhs()) / column[best] + tie / column[i]) return i;
    }
    return best;
  }

  bool precedes(Eigen::Index i, Eigen::Index best, Eigen::Index entering, Scalar tie) const {
    const Scalar ci = table_(i, entering), cb = table_(best, entering);
    // Cross-multiplied by both pivots, so that small ones do not blow rounding up.
    const Scalar difference = table_(i, rhs()) * cb - table_(best, rhs()) * ci;
    if (std::abs(difference) > tie * std::max(ci, cb)) return difference < 0;
    for (Eigen::Index j = 0; j < n_; ++j) {
      const Scalar x = table_(i, j) * cb, y = table_(best, j) * ci;
      if (std::abs(x - y) > 64 * std::numeric_limits<Scalar>::epsilon() * (std::abs(x) + std::abs(y)))
        return x < y;
    }
    return false;
  }

  void pivot(Eigen::Index row, Eigen::Index entering) {
    table_.row(row) /= table_(row, entering);
    table_(row, entering) = 1;
    for (Eigen::Index i = 0; i < n_; ++i) {
      const Scalar factor = table_(i, entering);
      if (i == row || factor == 0) continue;
      table_.row(i) -= factor * table_.row(row);
      table_(i, entering) = 0;
    }
    basis_[row] = entering;
  }

  Eigen::Index n_;
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> table_;
  std::vector<Eigen::Index> basis_;
};

double lcp_residual(const Eigen::MatrixXd& M, const Eigen::VectorXd& q, const Eigen::VectorXd& z) {
  return (M * z + q).cwiseMin(z).cwiseAbs().maxCoeff();
}

struct DenseLcpResult {
  Eigen::VectorXd z;
  bool solved = false, ray = false;
  int pivots = 0;
  double residual = kInfinity;
};

/// One step of refinement: the linear system of the basic variables, solved again from the given data.
void refine(const Eigen::MatrixXd& M, const Eigen::VectorXd& q, DenseLcpResult& result) {
  std::vector<Eigen::Index> basic;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (result.z[i] > 0) basic.push_back(i);
  }
  if (basic.empty()) return;
  const Eigen::FullPivLU<Eigen::MatrixXd> factor(M(basic, basic));
  for (int round = 0; round < 3; ++round) {
    const Eigen::VectorXd w = M * result.z + q;
    Eigen::VectorXd z = result.z;
    const Eigen::VectorXd error = w(basic);
    z(basic) -= solution_of(factor, error);
    z = z.cwiseMax(0);
    const double residual = z.allFinite() ? lcp_residual(M, q, z) : kInfinity;
    if (!(residual < result.residual)) break;
    result.z = z;
    result.residual = residual;
  }
}

/// Tries every complementary basis: 2^n linear systems, the answer where a ray says nothing (bimatrix games,
/// whose matrix is copositive but not copositive-plus).
void enumerate_bases(const Eigen::MatrixXd& M, const Eigen::VectorXd& q, DenseLcpResult& result) {
  const auto n = static_cast<int>(q.size());
  for (unsigned mask = 0; mask < 1u << n; ++mask) {
    std::vector<Eigen::Index> basic;
    for (int i = 0; i < n; ++i) {
      if (mask >> i & 1) basic.push_back(i);
    }
    Eigen::VectorXd z = Eigen::VectorXd::Zero(n);
    if (!basic.empty()) {
      const Eigen::VectorXd wanted = -q(basic);
      z(basic) = solution_of(Eigen::PartialPivLU<Eigen::MatrixXd>(M(basic, basic)), wanted);
    }
    if (!z.allFinite() || !((M * z + q).cwiseMin(z).minCoeff() >= -1e-12 * (1 + z.cwiseAbs().maxCoeff())))
      continue;
    z = z.cwiseMax(0);
    const double residual = lcp_residual(M, q, z);
    if (!(residual < result.residual)) continue;
    result.z = z;
    result.residual = residual;
    result.solved = residual <= 1e-10;
    if (result.solved) return;
  }
}

/// Lemke's method on data of unit size. @param enumerated  size up to which all bases are tried in the end
DenseLcpResult solve_scaled(const Eigen::MatrixXd& M, const Eigen::VectorXd& q, int max_pivots,
                            int enumerated) {
  const Eigen::Index n = q.size();
  DenseLcpResult best;
  best.z = Eigen::VectorXd::Zero(n);
  if (n == 0) {
    best.solved = true;
    best.residual = 0;
    return best;
  }
  Eigen::VectorXd cover = Eigen::VectorXd::Ones(n);
  const auto attempt = [&](auto zero) {
    using Scalar = decltype(zero);
    Tableau<Scalar> tableau(M, q, cover);
    DenseLcpResult result;
    const auto end = tableau.run(max_pivots, result.pivots);
    result.ray = end == Tableau<Scalar>::End::Ray;
    result.z = tableau.z();
    if (end != Tableau<Scalar>::End::Solved || !result.z.allFinite()) {
      best.pivots += result.pivots;
      best.ray = best.ray || result.ray;
      return;
    }
    result.residual = lcp_residual(M, q, result.z);
    refine(M, q, result);
    // 1e-7: a wrong basis leaves errors of the size of q, rounding leaves far less even at condition 1e8.
    result.solved = result.residual <= 1e-7;
    result.pivots += best.pivots;
    if (result.residual < best.residual) best = result;
  };
  attempt(0.0);
  // A ray for one covering vector need not be one for another where M is not copositive-plus: spread d by the
  // golden ratio, differently each time.
  for (int k = 1; k <= kCoverings && !best.solved && best.ray; ++k) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const double turns = 0.6180339887498949 * static_cast<double>((i + 1) * k);
      cover[i] = 0.5 + (turns - std::floor(turns));
    }
    attempt(0.0);
  }
  const double scale = M.cwiseAbs().maxCoeff() * best.z.cwiseAbs().maxCoeff();
  // 1e-13: what a well-conditioned basis leaves in double after refinement.
  if (!best.solved || best.residual > 1e-13 * (1 + scale)) attempt(0.0L);
  if (!best.solved && n <= enumerated) enumerate_bases(M, q, best);
  if (!best.solved) best.z.setZero();
  return best;
}

/// How the contact problem's rows became variables of the LCP: lambda = particular + map z.
struct Formulation {
  Eigen::MatrixXd M;
  Eigen::VectorXd q;
  Eigen::MatrixXd map;         ///< rows of `rows` x variables
  Eigen::VectorXd particular;  ///< lambda at z = 0
  Eigen::VectorXd scale;       ///< z (true) = scale * z (scaled)
};

/// One LCP variable: a generator of the impulses, or a multiplier.
struct Variable {
  Eigen::Index row = -1;  ///< generator along +-lambda[row]; -1: multiplier
  double sign = 1;
  Eigen::Index slack = -1;  ///< variable of the multiplier that is added to its complement
};

/// @param sizes  diagonal of W before rows were eliminated: what is left of it may be rounding
Formulation formulate(const Eigen::MatrixXd& W, const Eigen::VectorXd& b, const Eigen::VectorXd& sizes,
                      const std::vector<Row>& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  std::vector<Variable> variables;
  std::vector<Eigen::Index> normal_variable(rows.size(), -1);
  struct Budget {  // mu lambda_n - sum of generators >= 0, or upper - lower - z >= 0
    Eigen::Index multiplier, normal_row;
    double mu, limit;
  };
  std::vector<Budget> budgets;
  Formulation lcp;
  lcp.particular = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Row& row = rows[i];
    const auto next = static_cast<Eigen::Index>(variables.size());
    if (is_scaled(row)) {
      variables.push_back({i, 1, next + 2});
      variables.push_back({i, -1, next + 2});
      variables.push_back({});
      budgets.push_back({next + 2, row.normal, row.mu, 0});
    } else if (std::isfinite(row.lower) || std::isfinite(row.upper)) {
      const bool from_lower = std::isfinite(row.lower), both = from_lower && std::isfinite(row.upper);
      lcp.particular[i] = from_lower ? row.lower : row.upper;
      normal_variable[i] = next;
      variables.push_back({i, from_lower ? 1.0 : -1.0, both ? next + 1 : -1});
      if (both) {
        variables.push_back({});
        budgets.push_back({next + 1, -1, 0, row.upper - row.lower});
      }
    }
  }
  const auto size = static_cast<Eigen::Index>(variables.size());
  lcp.map = Eigen::MatrixXd::Zero(n, size);
  lcp.M = Eigen::MatrixXd::Zero(size, size);
  lcp.q = Eigen::VectorXd::Zero(size);
  lcp.scale = Eigen::VectorXd::Ones(size);
  for (Eigen::Index k = 0; k < size; ++k) {
    const Variable& variable = variables[k];
    if (variable.row < 0) continue;
    lcp.map(variable.row, k) = variable.sign;
    lcp.scale[k] = sizes[variable.row] > 0 ? 1 / std::sqrt(sizes[variable.row]) : 1;
    if (variable.slack >= 0) {
      lcp.M(k, variable.slack) = 1;
      lcp.M(variable.slack, k) = -1;
      lcp.scale[variable.slack] = 1 / lcp.scale[k];
    }
  }
  for (const Budget& budget : budgets) {
    if (budget.normal_row >= 0) lcp.M(budget.multiplier, normal_variable[budget.normal_row]) += budget.mu;
    lcp.q[budget.multiplier] = budget.limit;
    // A normal row with a positive lower bound brings that much friction with it.
    if (budget.normal_row >= 0) lcp.q[budget.multiplier] += budget.mu * lcp.particular[budget.normal_row];
  }
  lcp.M += lcp.map.transpose() * W * lcp.map;
  lcp.q += lcp.map.transpose() * (W * lcp.particular - b);
  return lcp;
}

/// Unbounded rows: lambda_J = W_JJ^+ (b_J - W_JC lambda_C), eliminated from the others.
struct Elimination {
  std::vector<Eigen::Index> bilateral, others;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> inverse;
};

bool is_bilateral(const Row& row) {
  return !is_scaled(row) && row.lower == -kInfinity && row.upper == kInfinity;
}

void solve_as_lcp(const ContactProblem& problem, const SolveOptions& options, Solution& solution) {
  const auto n = static_cast<Eigen::Index>(problem.rows.size());
  const Eigen::MatrixXd W(problem.W);
  const Eigen::Map<const Eigen::VectorXd> b(problem.b.data(), n);

  Elimination elimination;
  std::vector<Row> rows;
  std::vector<int> place(problem.rows.size(), -1);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (is_bilateral(problem.rows[i])) {
      elimination.bilateral.push_back(i);
      continue;
    }
    place[i] = static_cast<int>(rows.size());
    elimination.others.push_back(i);
    rows.push_back(problem.rows[i]);
    if (is_scaled(rows.back())) rows.back().normal = place[rows.back().normal];
  }
  const auto& J = elimination.bilateral;
  const auto& C = elimination.others;
  Eigen::MatrixXd reduced = W(C, C);
  Eigen::VectorXd reduced_b = b(C);
  if (!J.empty()) {
    // 1e-12: joints of one loop repeat each other to rounding; nothing regular in a mechanism is that small.
    elimination.inverse.setThreshold(1e-12);
    elimination.inverse.compute(W(J, J));
  }
  if (!J.empty() && !C.empty()) {
    const Eigen::MatrixXd columns = W(J, C);
    const Eigen::VectorXd wanted = b(J);
    reduced -= W(C, J) * solution_of(elimination.inverse, columns);
    reduced_b -= W(C, J) * solution_of(elimination.inverse, wanted);
  }

  if (C.empty()) {
    // Joints alone: a linear system.
    const Eigen::VectorXd wanted = b(J);
    const Eigen::VectorXd lambda = solution_of(elimination.inverse, wanted);
    solution.lambda.assign(problem.rows.size(), 0.0);
    solution.status = lambda.allFinite() ? SolveStatus::Inexact : SolveStatus::Failed;
    if (lambda.allFinite()) std::copy(lambda.begin(), lambda.end(), solution.lambda.begin());
    return;
  }

  Formulation lcp = formulate(reduced, reduced_b, W.diagonal()(C), rows);
  const double size =
      std::max(lcp.q.size() ? (lcp.scale.asDiagonal() * lcp.q).cwiseAbs().maxCoeff() : 0.0, 1e-300);
  const Eigen::MatrixXd M = lcp.scale.asDiagonal() * lcp.M * lcp.scale.asDiagonal();
  const Eigen::VectorXd q = lcp.scale.asDiagonal() * lcp.q / size;
  const int limit =
      options.max_iterations > 0 ? options.max_iterations : 50 * static_cast<int>(q.size()) + 100;
  solution.lambda.assign(problem.rows.size(), 0.0);
  if (!M.allFinite() || !q.allFinite()) {
    solution.status = SolveStatus::Failed;
    return;
  }
  const DenseLcpResult result =
      solve_scaled(M, q, limit, options.work_limit > 0 ? kEnumeratedSoon : kEnumerated);
  solution.iterations = solution.work.pivots = result.pivots;
  const Eigen::VectorXd others = lcp.particular + lcp.map * (lcp.scale.asDiagonal() * result.z * size);
  Eigen::VectorXd lambda = Eigen::VectorXd::Zero(n);
  lambda(C) = others;
  if (!J.empty()) {
    const Eigen::VectorXd wanted = b(J) - W(J, C) * others;
    lambda(J) = solution_of(elimination.inverse, wanted);
  }
  if (!result.solved || !lambda.allFinite()) {
    solution.status = SolveStatus::Failed;
    return;
  }
  std::copy(lambda.begin(), lambda.end(), solution.lambda.begin());
  solution.status = SolveStatus::Inexact;
}

Solution solve_part(const ContactProblem& problem, const SolveOptions& options) {
  Solution solution;
  solution.method = "lemke";
  solve_as_lcp(problem, options, solution);
  if (solution.status == SolveStatus::Failed) {
    clamp_to_bounds(problem.rows, solution.lambda);
    solution.residual = natural_map_residual(problem, solution.lambda);
    return solution;
  }
  conclude(problem, options, solution);
  return solution;
}

Solution solve_lemke_contact(const ContactProblem& problem, std::span<const double>,
                             const SolveOptions& options, std::unique_ptr<SolverMemory>*) {
  const auto part = [&](const ContactProblem& rows, const std::vector<double>&, std::size_t) {
    return solve_part(rows, options);
  };
  Solution solution =
      solve_by_parts(problem, independent_parts(problem), starting_impulses(problem.rows, {}), options, part);
  if (options.trace) {
    // What the tableau holds before its last pivot is no answer to the problem.
    if (!solution.trace) solution.trace = std::make_unique<SolveTrace>();
    record_iteration(problem, solution.lambda, *solution.trace);
    solution.trace->iterations.back().pivots = solution.work.pivots;
  }
  return solution;
}

Solution solve_lemke(const IslandSystem& system, std::span<const double> warm_start,
                     const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  return solve_in_contact_space(solve_lemke_contact, system, warm_start, options, memory);
}

}  // namespace

LcpSolution solve_lcp(std::span<const double> M, std::span<const double> q, int max_pivots) {
  const auto n = static_cast<Eigen::Index>(q.size());
  if (M.size() != q.size() * q.size()) {
    throw std::invalid_argument("M must have " + std::to_string(q.size() * q.size()) + " entries, got " +
                                std::to_string(M.size()));
  }
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::MatrixXd matrix = Eigen::Map<const RowMajor>(M.data(), n, n);
  const Eigen::VectorXd vector = Eigen::Map<const Eigen::VectorXd>(q.data(), n);
  if (!matrix.allFinite() || !vector.allFinite()) {
    throw std::invalid_argument("M and q must be finite");
  }
  LcpSolution solution;
  solution.z.assign(q.size(), 0.0);
  if (n == 0) {
    solution.solved = true;
    return solution;
  }
  // Rows and columns scaled by the diagonal where there is one; q to unit size.
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double size = matrix(i, i) > 0 ? matrix(i, i) : matrix.row(i).cwiseAbs().maxCoeff();
    scale[i] = size > 0 ? 1 / std::sqrt(size) : 1;
  }
  const double size = std::max((scale.asDiagonal() * vector).cwiseAbs().maxCoeff(), 1e-300);
  const DenseLcpResult result =
      solve_scaled(scale.asDiagonal() * matrix * scale.asDiagonal(), scale.asDiagonal() * vector / size,
                   max_pivots > 0 ? max_pivots : 50 * static_cast<int>(n) + 100, kEnumerated);
  const Eigen::VectorXd z = scale.asDiagonal() * result.z * size;
  solution.solved = result.solved;
  solution.ray = result.ray && !result.solved;
  solution.pivots = result.pivots;
  std::copy(z.begin(), z.end(), solution.z.begin());
  solution.residual = lcp_residual(matrix, vector, z);
  return solution;
}

extern const SolverEntry kLemkeEntry{
    .name = "lemke",
    .summary = "reference: complementary pivoting on the dense LCP, exact plane friction",
    .reference = "Lemke 1965; Stewart & Trinkle 1996; Anitescu & Potra 1997",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_lemke,
    .solve_contact = solve_lemke_contact};

}  // namespace skerry
