// SPDX-License-Identifier: MIT
//
// The dense reference that textbooks describe: W lambda = b by LU in O(c^3), a new right-hand side with the
// kept factor in O(c^2). Where W is singular (a box on two contacts with friction is enough) it says so.

#include "physics/solver/dense_factors.h"
#include "physics/solver/eigen_archive.h"
#include "physics/solver/state_search.h"

namespace skerry {
namespace {

/// Reciprocal condition below which the factor has no correct digit left; W scaled to a unit diagonal.
constexpr double kSingular = 1e-14;

class DenseEngine : public StateEngine {
 public:
  /// Takes the matrix over; the factor stays when it is the same as before.
  void set_matrix(const Eigen::SparseMatrix<double>& W) {
    Eigen::MatrixXd dense(W);
    if (dense.rows() == W_.rows() && dense == W_) return;
    W_ = std::move(dense);
    scale_ = W_.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.0; });
    factored_ = false;
  }

  bool solve(const Reduction& reduction, std::span<const double> b, double shift, std::vector<double>& lambda,
             SolveWork& work) override {
    const auto& F = reduction.free;
    const auto n = static_cast<Eigen::Index>(reduction.place.size());
    const Eigen::Map<const Eigen::VectorXd> constant(reduction.constant.data(), n);
    const Eigen::VectorXd wanted = Eigen::Map<const Eigen::VectorXd>(b.data(), n) - W_ * constant;
    Eigen::VectorXd x(static_cast<Eigen::Index>(F.size()));
    if (!F.empty()) {
      if (factored_ && shift == shift_ && F == free_ && reduction.slipping == slipping_) {
        ++work.resolves;
      } else {
        ++work.factorisations;
        if (!factor(reduction, shift)) return false;
      }
      const Eigen::VectorXd S = scale_(F), rhs = S.cwiseProduct(wanted(F));
      x = solution_of(lu_, rhs);
      x += solution_of(lu_, residual(A_, x, rhs));
      x = x.cwiseProduct(S);
      if (!x.allFinite()) return false;
    }
    lambda = expand(reduction, {x.data(), F.size()});
    return true;
  }

  void fields(Archive& a) {
    [[maybe_unused]] auto& [W, A, scale, lu, free, slipping, shift, factored] = *this;
    archive_dense(a, W);
    archive_dense(a, A);
    archive_dense(a, scale);
    a(free, slipping, shift, factored);
    // The same matrix gives the same factor.
    if (a.reading() && factored) lu.compute(A);
  }

 private:
  bool factor(const Reduction& reduction, double shift) {
    const auto& F = reduction.free;
    factored_ = false;
    A_ = W_(F, F);
    for (const Tie& tie : reduction.slipping)
      A_.col(reduction.place[tie.normal]) += tie.factor * W_(F, tie.row);
    const Eigen::VectorXd S = scale_(F);
    A_ = S.asDiagonal() * A_ * S.asDiagonal();
    A_.diagonal().array() += shift;
    if (!A_.allFinite()) return false;
    lu_.compute(A_);
    if (!(lu_.rcond() > kSingular)) return false;
    free_ = F;
    slipping_ = reduction.slipping;
    shift_ = shift;
    factored_ = true;
    return true;
  }

  Eigen::MatrixXd W_, A_;  ///< A_: the reduced matrix, scaled
  Eigen::VectorXd scale_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
  std::vector<int> free_;
  std::vector<Tie> slipping_;
  double shift_ = 0;
  bool factored_ = false;
};

struct DenseMemory final : SolverMemory {
  DenseEngine engine;
  std::vector<RowState> states;

  std::string_view solver() const override { return "dense_lu"; }
  void archive(Archive& a) override { a(engine, states); }
};

Solution solve_dense_contact(const ContactProblem& problem, std::span<const double> warm_start,
                             const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  Solution solution;
  solution.method = "dense_lu";
  solution.lambda = starting_impulses(problem.rows, warm_start);
  auto* kept = memory_as<DenseMemory>(memory);
  std::unique_ptr<DenseMemory> fresh;
  if (!kept) {
    fresh = std::make_unique<DenseMemory>();
    kept = fresh.get();
  }
  kept->engine.set_matrix(problem.W);
  solve_by_states(problem, kept->engine, false, options, kept->states, solution);
  if (memory && fresh) *memory = std::move(fresh);
  return solution;
}

Solution solve_dense(const IslandSystem& system, std::span<const double> warm_start,
                     const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  return solve_in_contact_space(solve_dense_contact, system, warm_start, options, memory);
}

}  // namespace

extern const SolverEntry kDenseLuEntry{
    .name = "dense_lu",
    .summary = "textbook reference: dense LU of W with an active set; says singular where W is",
    .reference = "Golub & Van Loan 2013, sec. 3.4; Judice & Pires 1994",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_dense,
    .solve_contact = solve_dense_contact,
    .make_memory = []() -> std::unique_ptr<SolverMemory> { return std::make_unique<DenseMemory>(); }};

}  // namespace skerry
