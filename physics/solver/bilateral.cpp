// SPDX-License-Identifier: MIT
#include "physics/solver/bilateral.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "physics/archive.h"
#include "physics/index.h"
#include "physics/solver/body_space_model.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/simd.h"
#include "physics/solver/small_states.h"
#include "physics/spare.h"
#include "physics/thread_pool.h"

namespace skerry {
namespace {

constexpr std::size_t kDenseRows = 12;
constexpr std::size_t kDenseBodies = 16;
constexpr std::size_t kFewRows = 3;
// Bodies up to which fixed-size arrays do; along more, rounding in their order asks for a refinement more.
constexpr std::size_t kFewBodies = 8;
// A pivot that cancellation has made this small against its diagonal is rounding: the row depends on others.
constexpr double kDependent = 1e-11;
// Weight of the proximal term relative to D. A step reduces the error to eta D / (least eigenvalue of W).
constexpr double kEta = 1e-9;
// Width of the envelope of W, in rows before its own that a row has in the mean, up to which a factor within
// it is cheaper than one of the body graph: along a chain of hinges it is 2.5, of a person of eleven
// bodies 5.5. A factor counts so many visits a row.
constexpr std::size_t kMeanWidth = 8;
// Relative error that ends the refinement, and the most refinements.
constexpr double kTarget = 1e-13;
constexpr int kRefinements = 4;
// A unit in the last place: a sum of some terms is not known better than this share of them.
constexpr double kRounding = 0x1p-52;
// Share of an error that a refinement at least takes away unless the rows contradict each other. It takes as
// little only of what impulses 1e11 times as large as the error would answer.
constexpr double kStands = 0.01;

using Velocity = std::array<double, 3>;

struct BilateralMemory final : SolverMemory {
  BodySpaceModel model;

  std::string_view solver() const override { return "bilateral"; }
  void archive(Archive& a) override { a(model); }
};

/// J_x M^-1 J_y^T of two rows.
SKERRY_ALWAYS_INLINE double coupling(const InverseMass* bodies, const Row& x, const Row& y) {
  double sum = 0;
  const auto add = [&](int body, const Velocity& p, const Velocity& q) {
    const InverseMass& mass = bodies[body];
    sum += mass.linear * (p[0] * q[0] + p[1] * q[1]) + mass.angular * p[2] * q[2];
  };
  if (x.a >= 0 && x.a == y.a) add(x.a, x.Ja, y.Ja);
  if (x.a >= 0 && x.a == y.b) add(x.a, x.Ja, y.Jb);
  if (x.b >= 0 && x.b == y.a) add(x.b, x.Jb, y.Ja);
  if (x.b >= 0 && x.b == y.b) add(x.b, x.Jb, y.Jb);
  return sum;
}

/// P W P^T = L D L^T with diagonal pivoting, until a pivot is rounding. @tparam N  number of rows, 0: any
template <std::size_t N>
class DenseFactor {
 public:
  explicit DenseFactor(const IslandSystem& system) : count_(system.rows.size()) {
    const std::size_t n = size();
    std::array<double, kMost> whole;
    const Row* const rows = system.rows.data();
    const InverseMass* const bodies = system.bodies.data();
    const double* const compliance = system.compliance.empty() ? nullptr : system.compliance.data();
    for (std::size_t i = 0; i < n; ++i) {
      if constexpr (kPivots) order_[i] = i;
      for (std::size_t j = 0; j <= i; ++j) A_[i][j] = coupling(bodies, rows[i], rows[j]);
      if (compliance != nullptr) A_[i][i] += compliance[i];
      whole[i] = A_[i][i];
    }
    for (; rank_ < n; ++rank_) {
      const std::size_t k = rank_;
      std::size_t best = k;
      for (std::size_t i = k + 1; kPivots && i < n; ++i)
        if (A_[i][i] * whole[best] > A_[best][best] * whole[i]) best = i;
      if (!(A_[best][best] > kDependent * whole[best])) return;
      if (kPivots && best != k) {
        exchange(k, best);
        std::swap(whole[k], whole[best]);
      }
      const double inverse = 1 / A_[k][k];
      for (std::size_t i = k + 1; i < n; ++i) {
        const double l = A_[i][k] * inverse;
        for (std::size_t j = k + 1; j <= i; ++j) A_[i][j] -= l * A_[j][k];
        // Row k below the diagonal keeps L D until its column is done.
        l_[i] = l;
      }
      for (std::size_t i = k + 1; i < n; ++i) A_[i][k] = l_[i];
      A_[k][k] = inverse;
    }
  }

  bool regular() const { return rank_ == size(); }

  /// lambda += x with W x = r. @pre `regular`
  void add_solution(const std::array<double, kDenseRows>& r, double* lambda) const {
    const std::size_t n = size();
    std::array<double, kMost> x;
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = r[place(i)];
      for (std::size_t j = 0; j < i; ++j) x[i] -= A_[i][j] * x[j];
    }
    for (std::size_t i = n; i-- > 0;) {
      x[i] *= A_[i][i];
      for (std::size_t j = i + 1; j < n; ++j) x[i] -= A_[j][i] * x[j];
      lambda[place(i)] += x[i];
    }
  }

 private:
  static constexpr std::size_t kMost = N > 0 ? N : kDenseRows;
  // The first pivots are all alike, and of two there is no choice for the second.
  static constexpr bool kPivots = N == 0 || N > 2;
  /// Number in W of what was chosen as pivot `i`.
  std::size_t place(std::size_t i) const { return kPivots ? order_[i] : i; }
  std::size_t size() const { return N > 0 ? N : count_; }

  void exchange(std::size_t k, std::size_t m) {
    const std::size_t n = size();
    std::swap(order_[k], order_[m]);
    for (std::size_t j = 0; j < k; ++j) std::swap(A_[k][j], A_[m][j]);
    std::swap(A_[k][k], A_[m][m]);
    for (std::size_t j = k + 1; j < m; ++j) std::swap(A_[j][k], A_[m][j]);
    for (std::size_t i = m + 1; i < n; ++i) std::swap(A_[i][k], A_[i][m]);
  }

  std::size_t count_, rank_ = 0;
  std::array<std::array<double, kMost>, kMost> A_;  // lower triangle
  std::array<double, kMost> l_;
  std::array<std::size_t, kMost> order_;
};

/// r = b - W lambda by way of the bodies. @tparam N  number of rows, 0: any @param v  zeros, of the bodies
/// @return its largest magnitude; NaN where it has one
template <std::size_t N = 0>
double remainder_of(const IslandSystem& system, const double* lambda, Velocity* v, double* r) {
  const std::size_t n = N > 0 ? N : system.rows.size();
  const Row* const rows = system.rows.data();
  const InverseMass* const bodies = system.bodies.data();
  const double* const target = system.b.data();
  const double* const compliance = system.compliance.empty() ? nullptr : system.compliance.data();
  for (std::size_t i = 0; i < n; ++i) {
    const Row& row = rows[i];
    const auto a = static_cast<std::size_t>(row.a), b = static_cast<std::size_t>(row.b);
    if (row.a >= 0) push(bodies[a], row.Ja, lambda[i], v[a]);
    if (row.b >= 0) push(bodies[b], row.Jb, lambda[i], v[b]);
  }
  double worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Row& row = rows[i];
    double w = (compliance == nullptr ? 0 : compliance[i] * lambda[i]) - target[i];
    if (row.a >= 0) w += along(row.Ja, v[static_cast<std::size_t>(row.a)]);
    if (row.b >= 0) w += along(row.Jb, v[static_cast<std::size_t>(row.b)]);
    r[i] = -w;
    // A comparison that NaN fails must not hide it.
    if (!(std::abs(w) <= worst)) worst = std::abs(w);
  }
  return worst;
}

/// The same of few.
template <std::size_t N>
double remainder(const IslandSystem& system, const double* lambda, std::array<double, kDenseRows>& r) {
  std::array<Velocity, kDenseBodies> v;
  for (std::size_t k = 0; k < system.bodies.size(); ++k) v[k] = {0, 0, 0};
  return remainder_of<N>(system, lambda, v.data(), r.data());
}

/// Refines by `step(floor)`, which returns the largest |w| after it and may set what rounding leaves of that,
/// until it is small or does not fall.
template <class Step>
double refine(double target, Step&& step) {
  double error = kInfinity;
  for (int k = 0; k <= kRefinements; ++k) {
    double floor = 0;
    const double next = step(floor);
    const bool falls = next < 0.5 * error;
    error = next;
    if (!falls || error <= std::max(target, floor)) break;
  }
  return error;
}

/// @param lambda  zeros, exchanged for the answer
/// @return infinity if W is not regular to rounding
template <std::size_t N>
double solve_dense(const IslandSystem& system, double target, double* lambda, SolveWork& work) {
  const DenseFactor<N> factor(system);
  if (!factor.regular()) return kInfinity;
  std::array<double, kDenseRows> r;
  std::copy(system.b.begin(), system.b.end(), r.begin());
  ++work.factorisations;
  return refine(target, [&](double&) {
    factor.add_solution(r, lambda);
    ++work.resolves;
    return remainder<N>(system, lambda, r);
  });
}

/// Dense, and of a fixed size where that is small: one joint is the most frequent case.
double solve_dense_of_size(const IslandSystem& system, double target, double* lambda, SolveWork& work) {
  switch (system.rows.size()) {
    case 1:
      return solve_dense<1>(system, target, lambda, work);
    case 2:
      return solve_dense<2>(system, target, lambda, work);
    case 3:
      return solve_dense<3>(system, target, lambda, work);
    default:
      return solve_dense<0>(system, target, lambda, work);
  }
}

/// Numbers of a solve within the envelope of W.
struct EnvelopeScratch {
  std::vector<int> first;          ///< by body: its first row
  std::vector<int> from;           ///< by row: the first one that it may be coupled with
  std::vector<std::size_t> start;  ///< by row: where `l` has its entry for `from`
  std::vector<double> l;           ///< L below its diagonal, row by row
  std::vector<double> inverse;     ///< of D
  std::vector<double> r;
  std::vector<Velocity> v;

  double* row(int i) { return l.data() + start[at(i)]; }
};

/// Finds the envelope of W, with rows in the order that they have. @return false if it is wide
bool find_envelope(const IslandSystem& system, EnvelopeScratch& scratch) {
  const int n = system.size();
  const std::size_t most = kMeanWidth * at(n);
  scratch.first.assign(system.bodies.size(), n);
  scratch.from.resize(at(n));
  scratch.start.resize(at(n));
  std::size_t size = 0;
  for (int i = 0; i < n; ++i) {
    const Row& row = system.rows[at(i)];
    int from = i;
    for (const int body : {row.a, row.b}) {
      if (body < 0) continue;
      int& first = scratch.first[at(body)];
      first = std::min(first, i);
      from = std::min(from, first);
    }
    scratch.from[at(i)] = from;
    scratch.start[at(i)] = size;
    size += at(i - from);
    if (size > most) return false;
  }
  scratch.l.resize(size);
  scratch.inverse.resize(at(n));
  return true;
}

/// W = L D L^T within its envelope. @return false if W is not regular to rounding
bool factor_envelope(const IslandSystem& system, EnvelopeScratch& scratch) {
  const int n = system.size();
  const InverseMass* const bodies = system.bodies.data();
  const Row* const rows = system.rows.data();
  const int* const from = scratch.from.data();
  double* const inverse = scratch.inverse.data();
  // The entries of row i before `end`, l_ij d_j until all of them are there.
  const auto couple = [&](int i, int begin, int end) {
    double* const own = scratch.row(i);
    for (int j = begin; j < end; ++j) {
      const int both = std::max(from[i], from[j]);
      const double *const x = own + (both - from[i]), *const y = scratch.row(j) + (both - from[j]);
      double sum = coupling(bodies, rows[i], rows[j]);
      for (int k = 0; k < j - both; ++k) sum -= x[k] * y[k];
      own[j - from[i]] = sum;
    }
  };
  // The same of rows i and i + 1 of one joint, side by side: one waits while the other is computed.
  const auto couple_two = [&](int i) {
    double *const own = scratch.row(i), *const next = scratch.row(i + 1);
    for (int j = from[i]; j < i; ++j) {
      const int both = std::max(from[i], from[j]), skip = both - from[i];
      const double *const x = own + skip, *const z = next + skip,
                          *const y = scratch.row(j) + (both - from[j]);
      double sum = coupling(bodies, rows[i], rows[j]), next_sum = coupling(bodies, rows[i + 1], rows[j]);
      for (int k = 0; k < j - both; ++k) {
        sum -= x[k] * y[k];
        next_sum -= z[k] * y[k];
      }
      own[j - from[i]] = sum;
      next[j - from[i]] = next_sum;
    }
  };
  const auto finish = [&](int i) {
    double* const own = scratch.row(i);
    double pivot = coupling(bodies, rows[i], rows[i]);
    if (!system.compliance.empty()) pivot += system.compliance[at(i)];
    const double whole = pivot;
    for (int k = 0; k < i - from[i]; ++k) {
      const double l = own[k] * inverse[from[i] + k];
      pivot -= l * own[k];
      own[k] = l;
    }
    inverse[i] = 1 / pivot;
    return pivot > kDependent * whole;
  };
  for (int i = 0; i < n; ++i) {
    if (i + 1 < n && from[i + 1] == from[i] && from[i] < i) {
      couple_two(i);
      if (!finish(i)) return false;
      ++i;
      couple(i, i - 1, i);
    } else {
      couple(i, from[i], i);
    }
    if (!finish(i)) return false;
  }
  return true;
}

/// @param lambda  zeros, exchanged for the answer
/// @return infinity if the envelope of W is wide, or W is not regular to rounding
double solve_in_envelope(const IslandSystem& system, double target, double* lambda, SolveWork& work) {
  Spare<EnvelopeScratch> scratch;
  if (!find_envelope(system, *scratch) || !factor_envelope(system, *scratch)) return kInfinity;
  ++work.factorisations;
  const int n = system.size();
  const int* const from = scratch->from.data();
  const double* const inverse = scratch->inverse.data();
  scratch->r = system.b;
  double* const r = scratch->r.data();
  work.visits += static_cast<double>(scratch->l.size());
  return refine(target, [&](double&) {
    for (int i = 0; i < n; ++i) {
      const double* const l = scratch->row(i);
      double sum = r[i];
      for (int j = from[i]; j < i; ++j) sum -= l[j - from[i]] * r[j];
      r[i] = sum;
    }
    for (int i = 0; i < n; ++i) r[i] *= inverse[i];
    for (int i = n; i-- > 0;) {
      const double* const l = scratch->row(i);
      for (int j = from[i]; j < i; ++j) r[j] -= l[j - from[i]] * r[i];
    }
    for (int i = 0; i < n; ++i) lambda[i] += r[i];
    ++work.resolves;
    work.visits += n;
    scratch->v.assign(system.bodies.size(), Velocity{});
    return remainder_of(system, lambda, scratch->v.data(), r);
  });
}

/// @param good           an error that will do, though `target` is what is tried for
/// @param contradictory  becomes true if the error is larger and the last refinement left it as it was
double solve_sparse(const IslandSystem& system, double target, double good, BodySpaceModel& model,
                    ThreadPool* threads, Solution& solution, bool& contradictory) {
  model.use_threads(threads);
  model.assign(system, solution.work);
  const std::size_t n = system.rows.size();
  Spare<std::vector<double>> g, h, k, w, change;
  h->assign(n, 0);
  for (std::vector<double>* numbers : {&*g, &*k, &*w, &*change}) numbers->resize(n);
  model.share_rows([&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const BodySpaceModel::RowInfo& row = model.info()[i];
      (*g)[i] = row.dead ? 0 : 1 / (kEta * row.D + row.compliance);
      (*w)[i] = -system.b[i];
    }
  });
  if (!model.factor(g->data(), h->data(), solution.work)) return kInfinity;
  const double error = refine(target, [&](double& floor) {
    std::atomic<double> largest = 0;  // of the terms that make up a w
    model.share_rows([&](int first, int last) {
      for (int i = first; i < last; ++i) (*k)[i] = -(*g)[i] * (*w)[i];
    });
    model.begin_solve(k->data(), solution.work);
    model.move_and_evaluate(solution.lambda.data(), w->data(), [&](int first, int last) {
      model.finish_solve(first, last, k->data(), g->data(), h->data(), change->data());
      double most = 0;
      for (int i = first; i < last; ++i) {
        solution.lambda[i] += (*change)[i];
        most = std::max(most, model.info()[i].D * std::abs(solution.lambda[i]));
      }
      raise_to(largest, most);
    });
    floor = kRounding * largest;
    return model.largest_of_rows([&](int first, int last) {
      double worst = 0;
      for (int i = first; i < last; ++i)
        if (!(std::abs((*w)[i]) <= worst)) worst = std::abs((*w)[i]);
      return worst;
    });
  });
  if (error <= good) return error;
  // k still holds the error before the last refinement.
  double change_of_error = 0;
  for (std::size_t i = 0; i < n; ++i)
    if ((*g)[i] > 0) change_of_error = std::max(change_of_error, std::abs((*w)[i] + (*k)[i] / (*g)[i]));
  contradictory = change_of_error <= kStands * error;
  return error;
}

}  // namespace

bool is_bilateral(const IslandSystem& system) {
  return std::all_of(system.rows.begin(), system.rows.end(), [](const Row& row) {
    return row.normal < 0 && row.lower == -kInfinity && row.upper == kInfinity;
  });
}

Solution solve_bilateral(const IslandSystem& system, std::span<const double>, const SolveOptions& options,
                         std::unique_ptr<SolverMemory>* memory) {
  if (is_bilateral(system)) return solve_without_bounds(system, options, memory);
  Solution solution;
  solution.method = "bilateral";
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  solution.lambda.assign(system.rows.size(), 0);
  solution.status = SolveStatus::Unsupported;
  clamp_to_bounds(system.rows, solution.lambda);
  solution.residual = natural_map_residual(system, solution.lambda);
  return solution;
}

bool solve_few_without_bounds(const IslandSystem& system, double tolerance, std::vector<double>& lambda,
                              SolveWork& work) {
  const std::size_t n = system.rows.size();
  if (n == 0 || n > kFewRows || system.bodies.size() > kDenseBodies || !is_bilateral(system)) return false;
  lambda.assign(n, 0);
  double scale = 0;
  for (const double each : system.b) scale = std::max(scale, std::abs(each));
  if (scale == 0) return true;
  return solve_dense_of_size(system, kTarget * scale, lambda.data(), work) / scale <= tolerance;
}

Solution solve_without_bounds(const IslandSystem& system, const SolveOptions& options,
                              std::unique_ptr<SolverMemory>* memory, double scale, bool* contradictory) {
  Solution solution;
  bool stands = false;
  solution.method = "bilateral";
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  const std::size_t n = system.rows.size();
  solution.lambda = take_spare<std::vector<double>>();
  solution.lambda.assign(n, 0);
  const double largest = largest_magnitude(system.b);
  if (scale == 0) scale = residual_scale(largest);
  double error = largest == 0 ? 0 : kInfinity;
  if (error > 0 && n <= kDenseRows && system.bodies.size() <= kDenseBodies) {
    error = solve_dense_of_size(system, kTarget * scale, solution.lambda.data(), solution.work);
    if (solution.trace && error < kInfinity) solution.trace->notes.emplace_back("no bounds: W, dense");
  }
  // Where it had no answer it is not asked again.
  if (error == kInfinity && n > kDenseRows && memory_as<BilateralMemory>(memory) == nullptr) {
    error = solve_in_envelope(system, kTarget * scale, solution.lambda.data(), solution.work);
    // What is nearly dependent is better off with the weights of the body graph.
    if (!(error <= options.tolerance * scale)) {
      error = kInfinity;
      std::fill(solution.lambda.begin(), solution.lambda.end(), 0);
    }
    if (solution.trace && error < kInfinity)
      solution.trace->notes.emplace_back("no bounds: W, within its envelope");
  }
  // Rows that depend on each other share their impulse there.
  if (error == kInfinity) {
    if (system.bodies.size() <= kFewBodies && try_small_states(system, {}, options, solution)) {
      solution.method = "bilateral";
      return solution;
    }
    std::unique_ptr<SolverMemory> local;
    if (memory == nullptr) memory = &local;
    BodySpaceModel& model = make_memory_as<BilateralMemory>(*memory).model;
    if (solution.trace) solution.trace->notes.emplace_back("no bounds: body graph");
    error = solve_sparse(system, kTarget * scale, options.tolerance * scale, model, options.threads, solution,
                         stands);
    if (solution.trace) solution.trace->ordering = model.pattern().order();
  }
  solution.iterations = solution.work.factorisations;
  solution.residual = error / scale;
  solution.status = SolveStatus::Solved;
  if (contradictory != nullptr) *contradictory = stands;
  // Beyond the tolerance only what rounding explains will do.
  if (!(solution.residual <= options.tolerance)) conclude(system, options, solution);
  return solution;
}

extern const SolverEntry kBilateralEntry;
const SolverEntry kBilateralEntry = {
    .name = "bilateral",
    .summary = "joints and springs without bounds: one factorisation and its refinement",
    .reference = "Golub & Van Loan 2013, sec. 3.5.3, 4.2.8; George & Liu 1981, sec. 4.2; Rockafellar 1976",
    .exact = true,
    .friction = false,
    .bilateral = true,
    .solve = solve_bilateral,
    .make_memory = []() -> std::unique_ptr<SolverMemory> { return std::make_unique<BilateralMemory>(); },
};

}  // namespace skerry
