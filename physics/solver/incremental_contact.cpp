// SPDX-License-Identifier: MIT
//
// The solver on top of IncrementalLdlt: the rows of the active set enter and leave the factor one by one, and
// the factor stays from call to call. Slip makes the matrix unsymmetric by one column a slipping contact:
//
//   (W_FF + U V') x = r,   U = factor W_Ft a column for each tie, V' picks the normal impulse,
//
// solved with the symmetric factor and a small dense system (Woodbury). Redundant rows stay out of the factor
// with zero impulse; where they are not quite redundant and their velocity shows it, they are let in after
// all.
#include <algorithm>
#include <cmath>

#include "physics/solver/dense_factors.h"
#include "physics/solver/eigen_archive.h"
#include "physics/solver/incremental_ldlt.h"
#include "physics/solver/state_search.h"

namespace skerry {
namespace {

/// A pivot below this is all rounding.
constexpr double kDependent = 1e-15;

class IncrementalEngine : public StateEngine {
 public:
  void set_matrix(const Eigen::SparseMatrix<double>& W) {
    Eigen::MatrixXd dense(W);
    if (dense.rows() == W_.rows() && dense == W_) return;
    W_ = std::move(dense);
    factor_.clear();
    rows_.clear();
  }

  bool solve(const Reduction& reduction, std::span<const double> b, double shift, std::vector<double>& lambda,
             SolveWork& work) override {
    if (shift != 0) return false;
    std::vector<int> left_out = follow(reduction, work);
    if (!solve_factored(reduction, b, lambda)) return false;
    if (let_in(reduction, b, lambda, left_out, work)) return solve_factored(reduction, b, lambda);
    return true;
  }

  void fields(Archive& a) {
    auto& [W, factor, rows] = *this;
    archive_dense(a, W);
    a(factor, rows);
  }

 private:
  /// Brings the factor to the free rows; returns those that are redundant.
  std::vector<int> follow(const Reduction& reduction, SolveWork& work) {
    int leaving = 0;
    for (const int row : rows_) leaving += reduction.place[row] < 0;
    if (2 * leaving > factor_.size()) {
      factor_.clear();
      rows_.clear();
    }
    for (int k = factor_.size() - 1; k >= 0; --k) {
      if (reduction.place[rows_[k]] >= 0) continue;
      factor_.remove(k);
      rows_.erase(rows_.begin() + k);
      ++work.partial_factorisations;
    }
    std::vector<char> present(reduction.place.size(), 0);
    for (const int row : rows_) present[row] = 1;
    std::vector<int> left_out;
    bool changed = leaving > 0;
    for (const int row : reduction.free) {
      if (present[row]) continue;
      changed = true;
      if (!add(row, 1e-10, work)) left_out.push_back(row);
    }
    if (!changed) ++work.resolves;
    return left_out;
  }

  bool add(int row, double redundant, SolveWork& work) {
    std::vector<double> column(rows_.size());
    for (std::size_t k = 0; k < rows_.size(); ++k) column[k] = W_(rows_[k], row);
    ++work.partial_factorisations;
    if (!(W_(row, row) > 0)) return false;
    if (factor_.add(column, W_(row, row), redundant) == IncrementalLdlt::Added::Redundant) return false;
    rows_.push_back(row);
    return true;
  }

  bool solve_factored(const Reduction& reduction, std::span<const double> b, std::vector<double>& lambda) {
    const auto m = static_cast<Eigen::Index>(rows_.size());
    const auto n = static_cast<Eigen::Index>(b.size());
    const Eigen::VectorXd wanted = Eigen::Map<const Eigen::VectorXd>(b.data(), n) -
                                   W_ * Eigen::Map<const Eigen::VectorXd>(reduction.constant.data(), n);
    Eigen::VectorXd x = symmetric_solve(wanted(rows_));

    // Ties of normals that are in the factor; those of a redundant one have no impulse.
    std::vector<Eigen::Index> picks;
    Eigen::MatrixXd U(m, static_cast<Eigen::Index>(reduction.slipping.size())), Z = U;
    for (const Tie& tie : reduction.slipping) {
      const auto place = std::find(rows_.begin(), rows_.end(), tie.normal) - rows_.begin();
      if (place == m) continue;
      const auto k = static_cast<Eigen::Index>(picks.size());
      picks.push_back(place);
      U.col(k) = tie.factor * W_(rows_, tie.row);
      Z.col(k) = symmetric_solve(U.col(k));
    }
    if (!picks.empty()) {
      const auto k = static_cast<Eigen::Index>(picks.size());
      Eigen::MatrixXd small = Z.leftCols(k)(picks, Eigen::all);
      small.diagonal().array() += 1;
      const Eigen::PartialPivLU<Eigen::MatrixXd> lu(small);
      if (!(lu.rcond() > 1e-14)) return false;
      const auto correct = [&](Eigen::VectorXd y) {
        const Eigen::VectorXd normals = y(picks);
        y -= Z.leftCols(k) * solution_of(lu, normals);
        return y;
      };
      x = correct(x);
      // Woodbury loses digits where the small system is badly scaled; one step on the residual brings them
      // back.
      const Eigen::VectorXd normals = x(picks);
      const Eigen::VectorXd error = wanted(rows_) - W_(rows_, rows_) * x - U.leftCols(k) * normals;
      x += correct(symmetric_solve(error));
    }
    if (!x.allFinite()) return false;
    std::vector<double> free_impulses(reduction.free.size(), 0.0);
    for (Eigen::Index k = 0; k < m; ++k) free_impulses[reduction.place[rows_[k]]] = x[k];
    lambda = expand(reduction, free_impulses);
    return true;
  }

  Eigen::VectorXd symmetric_solve(const Eigen::VectorXd& rhs) {
    const std::vector<double> x = factor_.solve({rhs.data(), static_cast<std::size_t>(rhs.size())});
    return Eigen::Map<const Eigen::VectorXd>(x.data(), rhs.size());
  }

  /// Adds the left-out rows whose velocity is not zero to rounding; true when there were any.
  bool let_in(const Reduction& reduction, std::span<const double> b, const std::vector<double>& lambda,
              const std::vector<int>& left_out, SolveWork& work) {
    bool any = false;
    const Eigen::Map<const Eigen::VectorXd> impulses(lambda.data(), static_cast<Eigen::Index>(lambda.size()));
    for (const int row : left_out) {
      if (reduction.place[row] < 0) continue;
      const double w = W_.row(row).dot(impulses) - b[row];
      const double size = W_.row(row).cwiseAbs().dot(impulses.cwiseAbs()) + std::abs(b[row]);
      if (std::abs(w) > 64 * kRoundingUnit * size && add(row, kDependent, work)) any = true;
    }
    return any;
  }

  Eigen::MatrixXd W_;
  IncrementalLdlt factor_;
  std::vector<int> rows_;  ///< rows in the factor, in its order
};

struct IncrementalMemory final : SolverMemory {
  IncrementalEngine engine;
  std::vector<RowState> states;

  std::string_view solver() const override { return "incremental_ldlt"; }
  void archive(Archive& a) override { a(engine, states); }
};

Solution solve_incremental_contact(const ContactProblem& problem, std::span<const double> warm_start,
                                   const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  Solution solution;
  solution.method = "incremental_ldlt";
  solution.lambda = starting_impulses(problem.rows, warm_start);
  auto* kept = memory_as<IncrementalMemory>(memory);
  std::unique_ptr<IncrementalMemory> fresh;
  if (!kept) {
    fresh = std::make_unique<IncrementalMemory>();
    kept = fresh.get();
  }
  kept->engine.set_matrix(problem.W);
  solve_by_states(problem, kept->engine, false, options, kept->states, solution);
  if (memory && fresh) *memory = std::move(fresh);
  return solution;
}

Solution solve_incremental(const IslandSystem& system, std::span<const double> warm_start,
                           const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  return solve_in_contact_space(solve_incremental_contact, system, warm_start, options, memory);
}

}  // namespace

extern const SolverEntry kIncrementalLdltEntry{
    .name = "incremental_ldlt",
    .summary = "dense LDL^T that grows and shrinks row by row, redundant contacts left out, factor kept",
    .reference = "Gill, Golub, Murray & Saunders 1974; Higham 2002, ch. 10-11",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_incremental,
    .solve_contact = solve_incremental_contact,
    .make_memory = []() -> std::unique_ptr<SolverMemory> { return std::make_unique<IncrementalMemory>(); }};

}  // namespace skerry
