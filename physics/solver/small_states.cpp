// SPDX-License-Identifier: MIT
//
// Semi-smooth Newton's method on states, as in body_space_active_set.h [Hintermueller, Ito & Kunisch 2002]:
// with J' = J M^-1/2 the free rows want w = -eta D d, so that
//
//   (I + sum g (J_n + s mu J_t)^T J_n + sum g J_t^T J_t) u = J^T k,   d = -g (w + J u),   g = 1 / (eta D),
//
// where s is the side to which a contact slips. The matrix is factored in blocks of bodies, in natural order.
#include "physics/solver/small_states.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "physics/index.h"
#include "physics/solver/bilateral.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/simd.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Weight of a proximal step relative to D: it leaves that share of the error, and roundings amplified by its
// inverse, which states must not be judged by. Without bounds there are none to judge.
constexpr double kEta = 1e-7, kBilateralEta = 1e-9;
// Contradictions of states below this, relative, are roundings of a first step.
constexpr double kClear = 1e-9;
// Changes of states from a start, and how many without fewer contradictions are put up with.
constexpr int kMostChanges = 12, kPatience = 3, kSingles = 12;
// Steps at most with the last states.
constexpr int kFinalSteps = 6;
// Relative residual to stop at.
constexpr double kTarget = 1e-13;
constexpr int kSweeps = 10;

// Work of a step and of a factor for each row, and of a block of the factor [visits].
constexpr double kStepVisits = 2, kFactorVisits = 1, kBlockVisits = 1;

SKERRY_ALWAYS_INLINE void sum_of(const Vec4& x, double& sum) {
  sum = (x[0] + x[1]) + x[2];
}

class SmallStates {
 public:
  /// @return false if the island does not fit
  SKERRY_ALWAYS_INLINE bool assign(const IslandSystem& system) {
    const double eta = is_bilateral(system) ? kBilateralEta : kEta;
    const std::size_t n = system.rows.size(), bodies = system.bodies.size();
    if (n == 0 || n > kStateRows || bodies > kStateBodies || !system.compliance.empty()) return false;
    rows_ = static_cast<int>(n);
    bodies_ = static_cast<int>(bodies);
    for (int j = 0; j < bodies_; ++j) {
      const double m = std::sqrt(system.bodies[at(j)].linear);
      root_[j] = Vec4{m, m, std::sqrt(system.bodies[at(j)].angular), 0};
      below_[j] = 0;
    }
    scale_ = 0;
    for (int i = 0; i < rows_; ++i) {
      const Row& row = system.rows[at(i)];
      StateRow& r = row_[i];
      // The ground moves with a body that is not there.
      r.a = row.a >= 0 ? row.a : bodies_;
      r.b = row.b >= 0 ? row.b : bodies_;
      r.Ja = r.Jb = Vec4{};
      if (row.a >= 0) r.Ja = Vec4{row.Ja[0], row.Ja[1], row.Ja[2], 0} * root_[row.a];
      if (row.b >= 0) r.Jb = Vec4{row.Jb[0], row.Jb[1], row.Jb[2], 0} * root_[row.b];
      const Vec4 square = r.Ja * r.Ja + r.Jb * r.Jb;
      sum_of(square, r.D);
      if (!(r.D > 0) || (row.a >= 0 && row.a == row.b)) return false;
      r.g = 1 / (eta * r.D);
      r.normal = row.normal;
      r.mu = row.mu;
      r.lower = row.normal >= 0 ? 0 : row.lower;
      r.upper = row.normal >= 0 ? 0 : row.upper;
      r.b_wanted = system.b[at(i)];
      scale_ = std::max(scale_, std::abs(r.b_wanted));
      if (row.a >= 0 && row.b >= 0) below_[std::min(row.a, row.b)] |= 1u << std::max(row.a, row.b);
    }
    scale_ = residual_scale(scale_);
    blocks_ = bodies_;
    for (int j = 0; j < bodies_; ++j) {
      blocks_ += std::popcount(below_[j]);
      if (below_[j] == 0) continue;
      const int parent = std::countr_zero(below_[j]);
      below_[parent] |= below_[j] & ~(1u << parent);
    }
    best_residual_ = kInfinity;
    factored_ = false;
    return true;
  }

  SKERRY_ALWAYS_INLINE void start_from(const double* lambda) {
    for (int i = 0; i < rows_; ++i) lambda_[i] = lambda[i];
    project(lambda_);
    evaluate();
  }
  SKERRY_ALWAYS_INLINE void start_from_nothing() {
    for (int i = 0; i < rows_; ++i) lambda_[i] = 0;
    project(lambda_);
    evaluate();
  }

  /// States that the natural map predicts from impulses and velocities.
  SKERRY_ALWAYS_INLINE void predict_states() {
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      const double z = lambda_[i] - w_[i] / r.D;
      double lower = r.lower, upper = r.upper;
      if (r.normal >= 0) {
        const double zn = lambda_[r.normal] - w_[r.normal] / row_[r.normal].D;
        upper = r.mu * std::max(0.0, zn);
        lower = -upper;
        state_[i] = z > upper ? RowState::Upper : z < lower ? RowState::Lower : RowState::Free;
      } else {
        state_[i] = z <= lower ? RowState::Lower : z >= upper ? RowState::Upper : RowState::Free;
      }
    }
  }

  /// Whatever approaches touches, and sticks.
  SKERRY_ALWAYS_INLINE void stick_everything() {
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      const bool open = r.normal < 0 && r.lower >= 0 && std::isfinite(r.lower) && r.b_wanted < 0;
      state_[i] = open ? RowState::Lower : RowState::Free;
    }
  }

  /// Projected Gauss-Seidel from nothing.
  SKERRY_ALWAYS_INLINE void sweep() {
    Vec4 v[kStateBodies + 1];
    for (Vec4& each : v) each = Vec4{};
    for (int i = 0; i < rows_; ++i) lambda_[i] = 0;
    for (int k = 0; k < kSweeps; ++k) {
      for (int i = 0; i < rows_; ++i) {
        const StateRow& r = row_[i];
        const Vec4 along = r.Ja * v[r.a] + r.Jb * v[r.b];
        double w;
        sum_of(along, w);
        double lower = r.lower, upper = r.upper;
        if (r.normal >= 0) {
          upper = r.mu * lambda_[r.normal];
          lower = -upper;
        }
        const double next = std::clamp(lambda_[i] - (w - r.b_wanted) / r.D, lower, upper);
        const double change = next - lambda_[i];
        lambda_[i] = next;
        v[r.a] += r.Ja * change;
        v[r.b] += r.Jb * change;
      }
    }
    evaluate();
  }

  /// Changes states until none contradicts its impulses and velocities.
  /// @return whether there is an answer
  SKERRY_ALWAYS_INLINE bool search(double tolerance, SolveWork& work, SolveTrace* trace) {
    int fewest = rows_ + 1, waited = 0;
    double clear = kClear;
    bool single = false;
    int singles = 0;
    for (int k = 0; k < kMostChanges + kSingles; ++k) {
      if (!step(work)) break;
      int changes = change_states(clear, false);
      if (trace != nullptr) record(*trace, changes);
      if (changes == 0) {
        if (!finish(work)) break;
        offer();
        if (best_residual_ <= kTarget) return true;
        // Sharper eyes may see what is left.
        clear = kTarget;
        changes = change_states(clear, false);
        if (changes == 0) break;
      }
      if (changes >= fewest && ++waited > kPatience) single = true;
      fewest = std::min(fewest, changes);
      if (single) {
        if (++singles > kSingles) break;
        change_worst(clear);
        ++work.pivots;
        continue;
      }
      work.pivots += changes;
      change_states(clear, true);
    }
    return best_residual_ <= tolerance;
  }

  const double* impulses() const { return best_; }
  int rows() const { return rows_; }

 private:
  struct alignas(32) StateRow {
    Vec4 Ja, Jb;  // times the roots of the inverse masses
    double D, g, mu, lower, upper, b_wanted;
    int a, b, normal;
  };

  SKERRY_ALWAYS_INLINE void project(double* lambda) const {
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      double lower = r.lower, upper = r.upper;
      if (r.normal >= 0) {
        upper = r.mu * std::max(0.0, lambda[r.normal]);
        lower = -upper;
      }
      lambda[i] = std::clamp(lambda[i], lower, upper);
    }
  }

  /// w = J J^T lambda - b
  SKERRY_ALWAYS_INLINE void evaluate() {
    Vec4 v[kStateBodies + 1];
    for (int j = 0; j <= bodies_; ++j) v[j] = Vec4{};
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      v[r.a] += r.Ja * lambda_[i];
      v[r.b] += r.Jb * lambda_[i];
    }
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      const Vec4 along = r.Ja * v[r.a] + r.Jb * v[r.b];
      double u;
      sum_of(along, u);
      w_[i] = u - r.b_wanted;
    }
  }

  SKERRY_ALWAYS_INLINE bool is_open(int normal) const { return state_[normal] != RowState::Free; }
  /// Whether the row's impulse is that of its normal row times this.
  SKERRY_ALWAYS_INLINE double side(int i) const {
    return state_[i] == RowState::Upper ? row_[i].mu : state_[i] == RowState::Lower ? -row_[i].mu : 0;
  }
  SKERRY_ALWAYS_INLINE bool is_free(int i) const {
    const StateRow& r = row_[i];
    return state_[i] == RowState::Free && !(r.normal >= 0 && (r.mu == 0 || is_open(r.normal)));
  }

  SKERRY_ALWAYS_INLINE void factor(SolveWork& work) {
    for (int j = 0; j < bodies_; ++j) {
      block_[j][j][0] = Vec4{1, 0, 0, 0};
      block_[j][j][1] = Vec4{0, 1, 0, 0};
      block_[j][j][2] = Vec4{0, 0, 1, 0};
      for (unsigned rest = below_[j]; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        for (int c = 0; c < 3; ++c) block_[i][j][c] = block_[j][i][c] = Vec4{};
      }
    }
    for (int i = 0; i < rows_; ++i) {
      if (!is_free(i)) continue;
      const StateRow& r = row_[i];
      Vec4 Pa = r.Ja, Pb = r.Jb;
      if (r.normal < 0) {
        // What slips or rolls at its bound pushes with it.
        for (int t = i + 1; t < rows_ && row_[t].normal == i; ++t) {
          const double s = side(t);
          if (s == 0) continue;
          Pa += row_[t].Ja * s;
          Pb += row_[t].Jb * s;
        }
      }
      Pa *= r.g;
      Pb *= r.g;
      const bool has_a = r.a < bodies_, has_b = r.b < bodies_;
      if (has_a)
        for (int c = 0; c < 3; ++c) block_[r.a][r.a][c] += Pa * r.Ja[c];
      if (has_b)
        for (int c = 0; c < 3; ++c) block_[r.b][r.b][c] += Pb * r.Jb[c];
      if (has_a && has_b) {
        for (int c = 0; c < 3; ++c) block_[r.a][r.b][c] += Pa * r.Jb[c];
        for (int c = 0; c < 3; ++c) block_[r.b][r.a][c] += Pb * r.Ja[c];
      }
    }
    for (int j = 0; j < bodies_; ++j) {
      // L U of the block itself, with the inverses of the pivots.
      const Vec4(&d)[3] = block_[j][j];
      Pivot& p = pivot_[j];
      p.i0 = 1 / d[0][0];
      p.l10 = d[0][1] * p.i0;
      p.l20 = d[0][2] * p.i0;
      p.u01 = d[1][0];
      p.u02 = d[2][0];
      p.i1 = 1 / (d[1][1] - p.l10 * p.u01);
      p.l21 = (d[1][2] - p.l20 * p.u01) * p.i1;
      p.u12 = d[2][1] - p.l10 * p.u02;
      p.i2 = 1 / ((d[2][2] - p.l20 * p.u02) - p.l21 * p.u12);
      for (unsigned rest = below_[j]; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        Vec4(&X)[3] = block_[i][j];
        X[0] = X[0] * p.i0;
        X[1] = (X[1] - X[0] * p.u01) * p.i1;
        X[2] = ((X[2] - X[0] * p.u02) - X[1] * p.u12) * p.i2;
        X[1] = X[1] - X[2] * p.l21;
        X[0] = (X[0] - X[1] * p.l10) - X[2] * p.l20;
        for (unsigned left = below_[j]; left; left &= left - 1) {
          const int k = std::countr_zero(left);
          for (int c = 0; c < 3; ++c) {
            const Vec4& Y = block_[j][k][c];
            block_[i][k][c] -= (X[0] * Y[0] + X[1] * Y[1]) + X[2] * Y[2];
          }
        }
      }
    }
    std::copy(state_, state_ + rows_, factored_state_);
    factored_ = true;
    ++work.factorisations;
    work.visits += kFactorVisits * rows_ + kBlockVisits * blocks_;
  }

  SKERRY_ALWAYS_INLINE void solve(Vec4* x) const {
    for (int j = 0; j < bodies_; ++j) {
      for (unsigned rest = below_[j]; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        const Vec4(&L)[3] = block_[i][j];
        x[i] -= (L[0] * x[j][0] + L[1] * x[j][1]) + L[2] * x[j][2];
      }
    }
    for (int j = bodies_ - 1; j >= 0; --j) {
      for (unsigned rest = below_[j]; rest; rest &= rest - 1) {
        const int k = std::countr_zero(rest);
        const Vec4(&U)[3] = block_[j][k];
        x[j] -= (U[0] * x[k][0] + U[1] * x[k][1]) + U[2] * x[k][2];
      }
      const Pivot& p = pivot_[j];
      const double y0 = x[j][0], y1 = x[j][1] - p.l10 * y0, y2 = (x[j][2] - p.l20 * y0) - p.l21 * y1;
      const double z2 = y2 * p.i2, z1 = (y1 - p.u12 * z2) * p.i1;
      x[j] = Vec4{((y0 - p.u01 * z1) - p.u02 * z2) * p.i0, z1, z2, 0};
    }
  }

  /// A proximal step with the present states. @return false where it runs away
  SKERRY_ALWAYS_INLINE bool step(SolveWork& work) {
    if (!factored_ || !std::equal(state_, state_ + rows_, factored_state_)) factor(work);
    // What the rows push with if no body reacts.
    double k[kStateRows];
    Vec4 x[kStateBodies + 1];
    for (int j = 0; j <= bodies_; ++j) x[j] = Vec4{};
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      if (is_free(i))
        k[i] = -r.g * w_[i];
      else if (r.normal >= 0)
        k[i] = side(i) * (lambda_[r.normal] + k[r.normal]) - lambda_[i];
      else
        k[i] = (state_[i] == RowState::Lower ? r.lower : r.upper) - lambda_[i];
      x[r.a] += r.Ja * k[i];
      x[r.b] += r.Jb * k[i];
    }
    solve(x);
    x[bodies_] = Vec4{};
    double size = 0;
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      if (is_free(i)) {
        const Vec4 along = r.Ja * x[r.a] + r.Jb * x[r.b];
        double u;
        sum_of(along, u);
        lambda_[i] += k[i] - r.g * u;
      } else if (r.normal >= 0) {
        lambda_[i] = side(i) * lambda_[r.normal];
      } else {
        lambda_[i] = state_[i] == RowState::Lower ? r.lower : r.upper;
      }
      // NaN must not slip through the comparison.
      if (!(r.D * std::abs(lambda_[i]) <= size)) size = r.D * std::abs(lambda_[i]);
    }
    evaluate();
    ++work.resolves;
    work.visits += kStepVisits * rows_;
    return size < 1e100 * scale_;
  }

  /// Largest velocity of the free rows, which the next step is to take away.
  SKERRY_ALWAYS_INLINE double linear_error() const {
    double error = 0;
    for (int i = 0; i < rows_; ++i)
      if (is_free(i)) error = std::max(error, std::abs(w_[i]));
    return error;
  }

  /// Steps until the linear problem of the present states is solved to rounding.
  SKERRY_ALWAYS_INLINE bool finish(SolveWork& work) {
    double error = linear_error();
    for (int k = 0; k < kFinalSteps && error > 0.1 * kTarget * scale_; ++k) {
      const double last = error;
      if (!step(work)) return false;
      error = linear_error();
      if (!(error < 0.5 * last)) break;
    }
    return true;
  }

  /// Rows whose state contradicts impulses and velocities by more than `clear`, relative.
  SKERRY_ALWAYS_INLINE int change_states(double clear, bool apply) {
    double largest = scale_;
    for (int i = 0; i < rows_; ++i) largest = std::max(largest, row_[i].D * std::abs(lambda_[i]));
    const double below = clear * largest, moving = clear * scale_;
    int changes = 0;
    bool closing = false;
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      const RowState old = state_[i];
      RowState s = old;
      if (r.normal < 0) {
        closing = false;
        if (old == RowState::Free) {
          if ((r.lower - lambda_[i]) * r.D > below) s = RowState::Lower;
          if ((lambda_[i] - r.upper) * r.D > below) s = RowState::Upper;
        } else if (r.lower < r.upper) {
          if (old == RowState::Lower ? w_[i] < -moving : w_[i] > moving) s = RowState::Free;
          closing = s == RowState::Free;
        }
      } else if (r.mu > 0) {
        if (closing) {
          // A contact that closes sticks or slips as its own two rows alone would have it.
          const double z = -w_[i] / r.D, bound = r.mu * (-w_[r.normal] / row_[r.normal].D);
          if (apply) state_[i] = z > bound ? RowState::Upper : z < -bound ? RowState::Lower : RowState::Free;
          continue;
        }
        if (is_open(r.normal)) continue;
        const double bound = r.mu * std::max(0.0, lambda_[r.normal]);
        if (old == RowState::Free) {
          if ((lambda_[i] - bound) * r.D > below) s = RowState::Upper;
          if ((-bound - lambda_[i]) * r.D > below) s = RowState::Lower;
        } else if (old == RowState::Upper ? w_[i] > moving : w_[i] < -moving) {
          s = RowState::Free;
        }
      }
      if (s == old) continue;
      ++changes;
      if (apply) state_[i] = s;
    }
    return changes;
  }

  /// Changes the state that is contradicted most.
  SKERRY_ALWAYS_INLINE void change_worst(double clear) {
    RowState before[kStateRows];
    std::copy(state_, state_ + rows_, before);
    change_states(clear, true);
    int worst = -1;
    double most = -1;
    for (int i = 0; i < rows_; ++i) {
      if (state_[i] == before[i]) continue;
      const StateRow& r = row_[i];
      double by = std::abs(w_[i]);
      if (before[i] == RowState::Free) {
        double lower = r.lower, upper = r.upper;
        if (r.normal >= 0) {
          upper = r.mu * std::max(0.0, lambda_[r.normal]);
          lower = -upper;
        }
        by = r.D * std::max(lower - lambda_[i], lambda_[i] - upper);
      }
      if (by > most) {
        most = by;
        worst = i;
      }
    }
    const RowState chosen = worst >= 0 ? state_[worst] : RowState::Free;
    std::copy(before, before + rows_, state_);
    if (worst >= 0) state_[worst] = chosen;
  }

  /// Largest violation of the natural map, relative, of the present impulses within their bounds.
  SKERRY_ALWAYS_INLINE double residual() {
    project(lambda_);
    evaluate();
    double worst = 0;
    for (int i = 0; i < rows_; ++i) {
      const StateRow& r = row_[i];
      double lower = r.lower, upper = r.upper;
      if (r.normal >= 0) {
        upper = r.mu * lambda_[r.normal];
        lower = -upper;
      }
      const double x = lambda_[i];
      const double violation = r.D * std::abs(x - std::clamp(x - w_[i] / r.D, lower, upper));
      if (!(violation <= worst)) worst = violation;
    }
    return worst / scale_;
  }

  /// Keeps the present impulses, within their bounds, if they are better than the best.
  SKERRY_ALWAYS_INLINE void offer() {
    const double now = residual();
    if (!(now < best_residual_)) return;
    best_residual_ = now;
    std::copy(lambda_, lambda_ + rows_, best_);
  }

  void record(SolveTrace& trace, int changes) const {
    SmallStates copy = *this;
    SolveIteration it;
    it.residual = copy.residual();
    it.pivots = changes;
    for (int i = 0; i < rows_; ++i) {
      const bool free = state_[i] == RowState::Free;
      if (row_[i].normal < 0)
        ++(free ? it.stick : it.open);
      else if (!free && !is_open(row_[i].normal))
        --it.stick, ++it.slip;
    }
    trace.iterations.push_back(it);
  }

  /// L U of a block on the diagonal.
  struct Pivot {
    double i0, i1, i2, l10, l20, l21, u01, u02, u12;
  };

  Vec4 root_[kStateBodies];
  StateRow row_[kStateRows];
  Vec4 block_[kStateBodies][kStateBodies][3];  // columns of the blocks
  double scale_, best_residual_;
  double lambda_[kStateRows], w_[kStateRows], best_[kStateRows];
  Pivot pivot_[kStateBodies];
  int rows_, bodies_, blocks_;
  std::array<unsigned, kStateBodies> below_;  // bodies of each column of the factor, as bits
  bool factored_;
  RowState state_[kStateRows], factored_state_[kStateRows];
};

SKERRY_ALWAYS_INLINE bool run(const IslandSystem& system, const double* warm, double tolerance,
                              double* lambda, SolveWork& work, SolveTrace* trace) {
  SmallStates states;
  if (!states.assign(system)) return false;
  bool solved = false;
  if (warm != nullptr) {
    states.start_from(warm);
    states.predict_states();
    solved = states.search(tolerance, work, trace);
  }
  if (!solved) {
    states.start_from_nothing();
    states.stick_everything();
    solved = states.search(tolerance, work, trace);
  }
  if (!solved) {
    states.sweep();
    work.visits += kSweeps * states.rows();
    states.predict_states();
    solved = states.search(tolerance, work, trace);
  }
  if (!solved) return false;
  std::copy(states.impulses(), states.impulses() + states.rows(), lambda);
  return true;
}

using Run = bool(const IslandSystem&, const double*, double, double*, SolveWork&, SolveTrace*);
bool run_portable(const IslandSystem& system, const double* warm, double tolerance, double* lambda,
                  SolveWork& work, SolveTrace* trace) {
  return run(system, warm, tolerance, lambda, work, trace);
}
SKERRY_AVX2 bool run_avx2(const IslandSystem& system, const double* warm, double tolerance, double* lambda,
                          SolveWork& work, SolveTrace* trace) {
  return run(system, warm, tolerance, lambda, work, trace);
}

}  // namespace

bool try_small_states(const IslandSystem& system, std::span<const double> warm_start,
                      const SolveOptions& options, Solution& solution) {
  if (system.rows.size() > kStateRows || system.bodies.size() > kStateBodies) return false;
  const bool warm = warm_start.size() == system.rows.size();
  std::array<double, kStateRows> lambda;
  std::unique_ptr<SolveTrace> trace;
  if (options.trace) {
    trace = std::make_unique<SolveTrace>();
    trace->notes.emplace_back("small island, active set on the stack");
  }
  Run* const solve = cpu_has_avx2() ? run_avx2 : run_portable;
  if (!solve(system, warm ? warm_start.data() : nullptr, options.tolerance, lambda.data(), solution.work,
             trace.get()))
    return false;
  if (solution.lambda.capacity() == 0) solution.lambda = take_spare<std::vector<double>>();
  solution.lambda.assign(lambda.begin(), lambda.begin() + static_cast<std::ptrdiff_t>(system.rows.size()));
  solution.residual = clamp_and_judge(system, solution.lambda);
  solution.method = "small_states";
  solution.iterations = solution.work.factorisations;
  if (!(solution.residual <= options.tolerance)) {
    // Within rounding it is an answer all the same, which others may improve on.
    conclude(system, options, solution);
    return false;
  }
  solution.status = SolveStatus::Solved;
  solution.trace = std::move(trace);
  return true;
}

}  // namespace skerry
