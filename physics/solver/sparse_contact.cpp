// SPDX-License-Identifier: MIT
//
// Contact space with a sparse factor: LDL^T of W under a fill-reducing order, LU where contacts slip.
//
// W is singular as soon as contacts are redundant, so W + eta D is factored, D its diagonal, and the solve is
// repeated on the residual: each repetition is a step of the proximal point method and takes eta out again
// [Rockafellar 1976]. Rows that are not free keep their place with a diagonal entry alone, so the pattern,
// and with it the ordering and the symbolic analysis, serve every set of states of the island.
#include <Eigen/SparseCholesky>
#include <Eigen/SparseLU>
#include <cmath>

#include "physics/solver/eigen_archive.h"
#include "physics/solver/independent_parts.h"
#include "physics/solver/state_search.h"

namespace skerry {

extern const SolverEntry kLemkeEntry;

namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// Raises of the diagonal: the first is easy to factor and removed in a few repetitions; the second is for
/// contacts so close to redundant that the first leaves a residual.
constexpr double kShift = 1e-9, kSmallShift = 1e-12;
constexpr int kRepetitions = 12;
/// Up to so many rows Lemke's method takes milliseconds, and it succeeds where a search over states may not.
constexpr int kPivotingRows = 96;

bool same_pattern(const Matrix& x, const Matrix& y) {
  return x.rows() == y.rows() && x.nonZeros() == y.nonZeros() &&
         std::equal(x.outerIndexPtr(), x.outerIndexPtr() + x.outerSize() + 1, y.outerIndexPtr()) &&
         std::equal(x.innerIndexPtr(), x.innerIndexPtr() + x.nonZeros(), y.innerIndexPtr());
}

/// W with a pattern in which all rows of a contact have the same columns, symmetric, with a full diagonal.
Matrix united_pattern(const ContactProblem& problem) {
  const int n = problem.size();
  std::vector<int> contact(n);
  std::vector<std::vector<int>> members(n);
  for (int i = 0; i < n; ++i) {
    contact[i] = is_scaled(problem.rows[i]) ? problem.rows[i].normal : i;
    members[contact[i]].push_back(i);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < n; ++j) {
    entries.emplace_back(j, j, 0.0);
    for (Matrix::InnerIterator it(problem.W, j); it; ++it) {
      const int i = static_cast<int>(it.row());
      entries.emplace_back(i, j, it.value());
      for (const int p : members[contact[i]]) {
        for (const int q : members[contact[j]]) {
          entries.emplace_back(p, q, 0.0);
          entries.emplace_back(q, p, 0.0);
        }
      }
    }
  }
  Matrix united(n, n);
  united.setFromTriplets(entries.begin(), entries.end());
  return united;
}

class SparseEngine : public StateEngine {
 public:
  void set_problem(const ContactProblem& problem, SolveWork& work) {
    if (same_pattern(problem.W, given_) && rows_match(problem.rows)) {
      if (!std::equal(problem.W.valuePtr(), problem.W.valuePtr() + problem.W.nonZeros(), given_.valuePtr())) {
        W_ = united_pattern(problem);
        factored_ = false;
      }
      given_ = problem.W;
      ++work.symbolic_skipped;
      return;
    }
    given_ = problem.W;
    W_ = united_pattern(problem);
    normals_.resize(problem.rows.size());
    for (std::size_t i = 0; i < normals_.size(); ++i) normals_[i] = problem.rows[i].normal;
    A_ = W_;
    analyzed_symmetric_ = analyzed_general_ = factored_ = false;
  }

  bool solve(const Reduction& reduction, std::span<const double> b, double shift, std::vector<double>& lambda,
             SolveWork& work) override {
    if (solve_raised(reduction, b, shift, kShift, lambda, work)) return true;
    return solve_raised(reduction, b, shift, kSmallShift, lambda, work);
  }

  void fields(Archive& a) {
    auto& [given, W, A, normals, ldlt, lu, analyzed_symmetric, analyzed_general, factored, symmetric, raise,
           place, slipping] = *this;
    archive_sparse(a, given);
    archive_sparse(a, W);
    archive_sparse(a, A);
    a(normals, analyzed_symmetric, analyzed_general, factored, symmetric, raise, place, slipping);
    if (!a.reading()) return;
    // The same pattern gives the same order, the same matrix the same factor.
    if (analyzed_symmetric) ldlt.analyzePattern(A);
    if (analyzed_general) lu.analyzePattern(A);
    if (factored && symmetric) ldlt.factorize(A);
    if (factored && !symmetric) lu.factorize(A);
  }

 private:
  bool rows_match(const std::vector<Row>& rows) const {
    if (rows.size() != normals_.size()) return false;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].normal != normals_[i]) return false;
    }
    return true;
  }

  /// A = reduced W with the diagonal raised; rows that are not free are rows of the identity times D.
  bool factor(const Reduction& reduction, double raise, SolveWork& work) {
    if (factored_ && raise == raise_ && reduction.place == place_ && reduction.slipping == slipping_) {
      ++work.resolves;
      return true;
    }
    factored_ = false;
    const int n = static_cast<int>(W_.rows());
    for (int j = 0; j < n; ++j) {
      for (int p = W_.outerIndexPtr()[j]; p < W_.outerIndexPtr()[j + 1]; ++p) {
        const int i = W_.innerIndexPtr()[p];
        const bool both = reduction.place[i] >= 0 && reduction.place[j] >= 0;
        double value = both ? W_.valuePtr()[p] : 0;
        if (i == j) value = both ? value * (1 + raise) : 1;
        // A body that cannot move along its row: any positive number keeps the factor regular.
        if (i == j && both && !(value > 0)) value = 1;
        A_.valuePtr()[p] = value;
      }
    }
    for (const Tie& tie : reduction.slipping) {
      const int from = W_.outerIndexPtr()[tie.row], to = W_.outerIndexPtr()[tie.normal];
      const int count = W_.outerIndexPtr()[tie.row + 1] - from;
      for (int k = 0; k < count; ++k) {
        if (reduction.place[W_.innerIndexPtr()[from + k]] < 0) continue;
        A_.valuePtr()[to + k] += tie.factor * W_.valuePtr()[from + k];
      }
    }
    ++work.factorisations;
    symmetric_ = reduction.slipping.empty();
    if (symmetric_) {
      if (!analyzed_symmetric_)
        ldlt_.analyzePattern(A_), analyzed_symmetric_ = true, ++work.symbolic_analyses;
      ldlt_.factorize(A_);
      if (ldlt_.info() != Eigen::Success) return false;
    } else {
      if (!analyzed_general_) lu_.analyzePattern(A_), analyzed_general_ = true, ++work.symbolic_analyses;
      lu_.factorize(A_);
      if (lu_.info() != Eigen::Success) return false;
    }
    raise_ = raise;
    place_ = reduction.place;
    slipping_ = reduction.slipping;
    factored_ = true;
    return true;
  }

  /// Solves with W + shift D wanted and W + (shift + raise) D factored.
  bool solve_raised(const Reduction& reduction, std::span<const double> b, double shift, double raise,
                    std::vector<double>& lambda, SolveWork& work) {
    if (!factor(reduction, shift + raise, work)) return false;
    const auto n = static_cast<Eigen::Index>(b.size());
    const Eigen::Map<const Eigen::VectorXd> wanted(b.data(), n);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n), best = x;
    double least = kInfinity;
    const double scale = std::max(wanted.cwiseAbs().maxCoeff(), 1e-300);
    for (int k = 0; k < kRepetitions; ++k) {
      const Eigen::VectorXd error = reduced_error(reduction, wanted, shift, x);
      const double size = error.cwiseAbs().maxCoeff();
      if (!(size < least)) break;
      const bool stalls = size > 0.5 * least;
      least = size;
      best = x;
      if (size <= 4 * kRoundingUnit * scale || stalls) break;
      const Eigen::VectorXd step =
          symmetric_ ? Eigen::VectorXd(ldlt_.solve(error)) : Eigen::VectorXd(lu_.solve(error));
      for (const int i : reduction.free) x[i] += step[i];
    }
    if (!best.allFinite()) return false;
    std::vector<double> free_impulses;
    free_impulses.reserve(reduction.free.size());
    for (const int i : reduction.free) free_impulses.push_back(best[i]);
    lambda = expand(reduction, free_impulses);
    // 1e-9 of the scale: such an error is no rounding but a raise that hides a nearly singular matrix.
    return least <= 1e-9 * scale || raise <= kSmallShift;
  }

  /// b - (W + shift D) lambda on the free rows, zero elsewhere; x holds the impulses of the free rows.
  Eigen::VectorXd reduced_error(const Reduction& reduction, const Eigen::Map<const Eigen::VectorXd>& wanted,
                                double shift, const Eigen::VectorXd& x) const {
    Eigen::VectorXd impulses = x;
    for (Eigen::Index i = 0; i < impulses.size(); ++i) {
      if (reduction.place[i] < 0) impulses[i] = reduction.constant[i];
    }
    for (const Tie& tie : reduction.slipping) impulses[tie.row] = tie.factor * impulses[tie.normal];
    const Eigen::VectorXd product = W_ * impulses;
    Eigen::VectorXd error = Eigen::VectorXd::Zero(impulses.size());
    for (const int i : reduction.free) {
      error[i] = wanted[i] - product[i] - (shift > 0 ? shift * W_.coeff(i, i) * impulses[i] : 0);
    }
    return error;
  }

  Matrix given_, W_, A_;  ///< as given, with united pattern, reduced
  std::vector<int> normals_;
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower, Eigen::AMDOrdering<int>> ldlt_;
  Eigen::SparseLU<Matrix, Eigen::COLAMDOrdering<int>> lu_;
  bool analyzed_symmetric_ = false, analyzed_general_ = false, factored_ = false, symmetric_ = true;
  double raise_ = 0;
  std::vector<int> place_;
  std::vector<Tie> slipping_;
};

struct SparseMemory final : SolverMemory {
  struct Part {
    SparseEngine engine;
    std::vector<RowState> states;
  };
  std::vector<std::unique_ptr<Part>> parts;

  std::string_view solver() const override { return "sparse_contact"; }
  void archive(Archive& a) override {
    std::size_t count = parts.size();
    a.count(count);
    parts.resize(count);
    for (std::unique_ptr<Part>& part : parts) {
      bool there = part != nullptr;
      a(there);
      if (!there) continue;
      if (!part) part = std::make_unique<Part>();
      a(part->engine, part->states);
    }
  }
};

Solution solve_part(const ContactProblem& problem, std::vector<double> start, const SolveOptions& options,
                    std::unique_ptr<SparseMemory::Part>& kept) {
  Solution solution;
  solution.method = "sparse_contact";
  solution.lambda = std::move(start);
  if (!kept) kept = std::make_unique<SparseMemory::Part>();
  kept->engine.set_problem(problem, solution.work);
  solve_by_states(problem, kept->engine, true, options, kept->states, solution);
  if (solution.status != SolveStatus::Solved && problem.size() <= kPivotingRows) {
    Solution pivoted = kLemkeEntry.solve_contact(problem, {}, options, nullptr);
    if (pivoted.residual < solution.residual) {
      if (solution.trace) solution.trace->notes.emplace_back("complementary pivoting");
      solution.lambda = std::move(pivoted.lambda);
      solution.residual = pivoted.residual;
      solution.status = pivoted.status;
      solution.work.pivots += pivoted.work.pivots;
    }
  }
  return solution;
}

Solution solve_sparse_contact_space(const ContactProblem& problem, std::span<const double> warm_start,
                                    const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  const std::vector<double> start = starting_impulses(problem.rows, warm_start);
  const std::vector<std::vector<int>> parts = independent_parts(problem);
  auto* kept = memory_as<SparseMemory>(memory);
  std::unique_ptr<SparseMemory> fresh;
  if (!kept || kept->parts.size() != parts.size()) {
    fresh = std::make_unique<SparseMemory>();
    fresh->parts.resize(parts.size());
    kept = fresh.get();
  }
  Solution solution = solve_by_parts(problem, parts, start, options,
                                     [&](const ContactProblem& part, auto impulses, std::size_t k) {
                                       return solve_part(part, std::move(impulses), options, kept->parts[k]);
                                     });
  if (memory && fresh) *memory = std::move(fresh);
  return solution;
}

Solution solve_sparse(const IslandSystem& system, std::span<const double> warm_start,
                      const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  return solve_in_contact_space(solve_sparse_contact_space, system, warm_start, options, memory);
}

}  // namespace

extern const SolverEntry kSparseContactEntry{
    .name = "sparse_contact",
    .summary = "sparse LDL^T of W (LU with slip), minimum degree order, active set and proximal continuation",
    .reference = "Amestoy, Davis & Duff 1996; Rockafellar 1976; Judice & Pires 1994",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_sparse,
    .solve_contact = solve_sparse_contact_space,
    .make_memory = []() -> std::unique_ptr<SolverMemory> { return std::make_unique<SparseMemory>(); }};

}  // namespace skerry
