// SPDX-License-Identifier: MIT
#include "physics/islands/island_system.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "physics/islands/path_lanes.h"
#include "physics/islands/planar.h"
#include "physics/spare.h"
#include "physics/text.h"
#include "physics/thread_pool.h"

namespace skerry {
namespace {

double compliance_of(const IslandSystem& system, std::size_t i) {
  return system.compliance.empty() ? 0 : system.compliance[i];
}

// Rows that a thread takes at a time.
constexpr std::size_t kRowsAPiece = 2048;

using Velocities = std::vector<std::array<double, 3>>;

/// w = (W lambda - b) of one row, from the velocities that all impulses give.
inline double row_velocity(const IslandSystem& system, std::size_t i, double lambda,
                           const Velocities& change) {
  const Row& row = system.rows[i];
  double u = compliance_of(system, i) * lambda;
  if (row.a >= 0) u += along(row.Ja, change[static_cast<std::size_t>(row.a)]);
  if (row.b >= 0) u += along(row.Jb, change[static_cast<std::size_t>(row.b)]);
  return u - system.b[i];
}

inline double inverse_effective_mass(const IslandSystem& system, std::size_t i) {
  const Row& row = system.rows[i];
  double sum = compliance_of(system, i);
  if (row.a >= 0) sum += inverse_mass_along(system.bodies[static_cast<std::size_t>(row.a)], row.Ja);
  if (row.b >= 0) sum += inverse_mass_along(system.bodies[static_cast<std::size_t>(row.b)], row.Jb);
  return sum;
}

// What the residual of every answer goes through, row by row: to be inlined.
inline ImpulseBounds bounds_of(const Row& row, double normal_impulse) {
  if (row.normal < 0) return {row.lower, row.upper};
  const double bound = row.mu * std::max(normal_impulse, 0.0);
  return {-bound, bound};
}

// Nothing moves: only a bound can explain a velocity, on the side from which it pushes.
double violation_without_motion(ImpulseBounds bounds, double lambda, double w) {
  const double outside = std::max({bounds.lower - lambda, lambda - bounds.upper, 0.0});
  const bool explained = w == 0 || (w > 0 && lambda <= bounds.lower) || (w < 0 && lambda >= bounds.upper);
  return std::max(outside, explained ? 0.0 : std::abs(w));
}

inline double violation_of(ImpulseBounds bounds, double diagonal, double lambda, double w) {
  if (!(diagonal > 0)) return violation_without_motion(bounds, lambda, w);
  // D (lambda - clamp(lambda - w / D, l, u)) without the cancellation of lambda - (lambda - w / D).
  const double low = diagonal * (lambda - bounds.upper), high = diagonal * (lambda - bounds.lower);
  return std::abs(std::min(std::max(w, low), high));
}

inline void push_row(const InverseMass* bodies, const Row& row, double impulse, std::array<double, 3>* v) {
  if (row.a >= 0) push(bodies[row.a], row.Ja, impulse, v[row.a]);
  if (row.b >= 0) push(bodies[row.b], row.Jb, impulse, v[row.b]);
}

// The largest violation of some rows, of impulses that give the bodies the velocities `change`, or the first
// one above `most`, or NaN.
inline double worst_violation(const IslandSystem& system, const std::vector<double>& lambda,
                              const Velocities& change, std::size_t from, std::size_t to, double most) {
  double worst = 0;
  for (std::size_t i = from; i < to && worst <= most; ++i) {
    const Row& row = system.rows[i];
    const double normal_impulse = row.normal < 0 ? 0 : lambda[static_cast<std::size_t>(row.normal)];
    const double violation = violation_of(bounds_of(row, normal_impulse), inverse_effective_mass(system, i),
                                          lambda[i], row_velocity(system, i, lambda[i], change));
    // A comparison that NaN fails must not hide it.
    if (!(violation <= worst)) worst = violation;
  }
  return worst;
}

// The residual; infinity where it is above `enough`; NaN where a violation is.
double residual_of(const IslandSystem& system, const std::vector<double>& lambda, const Velocities& change,
                   double enough = kInfinity, ThreadPool* threads = nullptr) {
  const double scale = residual_scale(largest_magnitude(system.b)), most = enough * scale;
  const std::size_t n = system.rows.size();
  double worst = 0;
  if (threads == nullptr || n <= kRowsAPiece) {
    worst = worst_violation(system, lambda, change, 0, n, most);
  } else {
    std::atomic<double> largest = 0;
    std::atomic<bool> lost = false;
    share(threads, n, kRowsAPiece, [&](std::size_t from, std::size_t to) {
      const double found = worst_violation(system, lambda, change, from, to, most);
      if (std::isnan(found)) lost = true;
      raise_to(largest, found);
    });
    worst = lost ? std::numeric_limits<double>::quiet_NaN() : largest.load();
  }
  return worst > most ? kInfinity : worst / scale;
}

// Clamps and judges, as `clamp_and_judge`, an island in which bodies ascend along the rows: each row lies
// between a body and a later one, begins no earlier than the row before ended, and has bounds of its own. A
// body's velocity is then known with the row behind it, and one pass does, with the same bits.
// @return false at the first row that is another one or moves nothing, and at impulses or violations that are
//   not finite
bool judge_path(const IslandSystem& system, std::vector<double>& lambda, double& residual) {
  const InverseMass* const bodies = system.bodies.data();
  const double* b = system.b.data();
  double* impulse = lambda.data();
  double worst = 0, scale = 0;
  // Of the row before: its second body, which the next row may push, too; its velocity without that of this
  // body; the rest of its natural map.
  int end = -1;
  Planar J_end{}, v_end{};
  double u = 0, wanted = 0, low = 0, high = 0;
  const auto judge = [&] {
    const double w = (u + along(J_end, v_end)) - wanted;
    const double violation = std::abs(std::min(std::max(w, low), high));
    if (violation <= worst) return true;
    worst = violation;
    return !std::isnan(worst);
  };
  for (const Row& row : system.rows) {
    double x = *impulse;
    if (row.normal >= 0 || row.a < end || row.b <= row.a || !std::isfinite(x)) return false;
    x = x < row.lower ? row.lower : x;
    x = x > row.upper ? row.upper : x;
    *impulse++ = x;
    double of_a = 0, diagonal = 0;
    if (row.a >= 0) {
      const Planar J = planar(row.Ja);
      Planar v = pushed(bodies[row.a], J, x);
      if (row.a == end) {
        v_end.xy += v.xy;
        v_end.turn += v.turn;
        v = v_end;
      }
      of_a = along(J, v);
      diagonal = coupled(bodies[row.a], J, J);
    }
    if (!judge()) return false;
    end = row.b;
    J_end = planar(row.Jb);
    v_end = pushed(bodies[end], J_end, x);
    diagonal += coupled(bodies[end], J_end, J_end);
    if (!(diagonal > 0)) return false;
    u = of_a;
    wanted = *b++;
    low = diagonal * (x - row.upper);
    high = diagonal * (x - row.lower);
    scale = std::max(scale, std::abs(wanted));
  }
  if (!judge()) return false;
  residual = worst / residual_scale(scale);
  return true;
}

// The same four rows at a time, for impulses that are within their bounds.
SKERRY_AVX2 bool judge_path_lanes(const IslandSystem& system, const std::vector<double>& lambda,
                                  double& residual) {
  using Bits = std::int64_t __attribute__((vector_size(32)));
  constexpr std::int64_t kNoSign = ~(std::int64_t{1} << 63);
  const Bits no_sign{kNoSign, kNoSign, kNoSign, kNoSign};
  const int n = system.size();
  const PathReader reader(system);
  Vec4 worst{}, scale{};
  Bits good = ~Bits{};
  // Of the last body of the four before: its share in the velocity and in D of the row behind it.
  Vec4 u_before{}, D_before{};
  for (int k = 0; k <= n; k += 4) {
    PathLanes four{};
    Vec4 lower, upper, before, behind, b;  // `before`, `behind`: impulses of the rows there
    if (reader.inside(k)) {
      if (!reader.read(k, four)) return false;
      const Row* const r = system.rows.data() + k;
      lower = Vec4{r[-1].lower, r[0].lower, r[1].lower, r[2].lower};
      upper = Vec4{r[-1].upper, r[0].upper, r[1].upper, r[2].upper};
      std::memcpy(&before, lambda.data() + k - 1, sizeof(Vec4));
      std::memcpy(&behind, lambda.data() + k, sizeof(Vec4));
      std::memcpy(&b, system.b.data() + k - 1, sizeof(Vec4));
    } else {
      const Row* rows[5];
      if (!reader.read_end(k, rows, four)) return false;
      double impulse[5], wanted[5];
      for (int i = 0; i < 5; ++i) {
        const int row = k - 1 + i;
        const bool there = row >= 0 && row < n;
        impulse[i] = there ? lambda[static_cast<std::size_t>(row)] : 0;
        wanted[i] = there ? system.b[static_cast<std::size_t>(row)] : 0;
      }
      lower = Vec4{rows[0]->lower, rows[1]->lower, rows[2]->lower, rows[3]->lower};
      upper = Vec4{rows[0]->upper, rows[1]->upper, rows[2]->upper, rows[3]->upper};
      std::memcpy(&before, impulse, sizeof(Vec4));
      std::memcpy(&behind, impulse + 1, sizeof(Vec4));
      std::memcpy(&b, wanted, sizeof(Vec4));
    }
    const Vec4 bturn = four.angular * four.bturn, aturn = four.angular * four.aturn;
    const Vec4 x = four.linear * four.bx * before + four.linear * four.ax * behind;
    const Vec4 y = four.linear * four.by * before + four.linear * four.ay * behind;
    const Vec4 turn = bturn * before + aturn * behind;
    const Vec4 u_behind = four.ax * x + four.ay * y + four.aturn * turn;
    const Vec4 u_of_b = four.bx * x + four.by * y + four.bturn * turn;
    const Vec4 D_behind = four.linear * (four.ax * four.ax + four.ay * four.ay) + aturn * four.aturn;
    const Vec4 D_of_b = four.linear * (four.bx * four.bx + four.by * four.by) + bturn * four.bturn;
    const Vec4 w = (__builtin_shufflevector(u_before, u_behind, 3, 4, 5, 6) + u_of_b) - b;
    const Vec4 D = __builtin_shufflevector(D_before, D_behind, 3, 4, 5, 6) + D_of_b;
    u_before = u_behind;
    D_before = D_behind;
    const Vec4 low = D * (before - upper), high = D * (before - lower);
    Vec4 violation = w < low ? low : w;
    violation = violation > high ? high : violation;
    violation = (Vec4)((Bits)violation & no_sign);
    const Vec4 size = (Vec4)((Bits)b & no_sign);
    good &= (before >= lower) & (before <= upper) & (D > 0.0) & (violation < kInfinity);
    worst = violation > worst ? violation : worst;
    scale = size > scale ? size : scale;
  }
  if (!(good[0] & good[1] & good[2] & good[3])) return false;
  const double most = std::max(std::max(worst[0], worst[1]), std::max(worst[2], worst[3]));
  const double largest = std::max(std::max(scale[0], scale[1]), std::max(scale[2], scale[3]));
  residual = most / residual_scale(largest);
  return true;
}

[[noreturn]] void reject(std::size_t row, const char* what, double value) {
  throw std::invalid_argument("row " + std::to_string(row) + ": " + what + ", got " + to_text(value));
}

bool all_finite(const std::array<double, 3>& J) {
  return std::isfinite(J[0]) && std::isfinite(J[1]) && std::isfinite(J[2]);
}

void validate_row(const IslandSystem& system, std::size_t i) {
  const Row& row = system.rows[i];
  const int bodies = static_cast<int>(system.bodies.size());
  for (const int body : {row.a, row.b}) {
    if (body < -1 || body >= bodies) reject(i, "body must be -1 or one of the island", body);
  }
  if (row.a == row.b) reject(i, "the two bodies must differ", row.a);
  if (!all_finite(row.Ja) || !all_finite(row.Jb))
    reject(i, "Jacobian must be finite, first entry", row.Ja[0]);
  if (!std::isfinite(system.b[i])) reject(i, "b must be finite", system.b[i]);

  if (row.kind == RowKind::Friction || row.kind == RowKind::Rolling) {
    if (!(row.mu >= 0) || !std::isfinite(row.mu)) reject(i, "mu must be finite and not negative", row.mu);
    const bool earlier = row.normal >= 0 && static_cast<std::size_t>(row.normal) < i;
    if (!earlier) reject(i, "the normal row must be an earlier one", row.normal);
    if (system.rows[static_cast<std::size_t>(row.normal)].kind != RowKind::Normal) {
      reject(i, "the row that scales the bounds must be a normal row", row.normal);
    }
    return;
  }
  if (row.normal >= 0) reject(i, "only friction and rolling rows have a normal row", row.normal);
  if (std::isnan(row.lower) || row.lower == kInfinity) reject(i, "lower bound must be below +inf", row.lower);
  if (std::isnan(row.upper) || row.upper == -kInfinity)
    reject(i, "upper bound must be above -inf", row.upper);
  if (row.lower > row.upper) reject(i, "lower bound must not exceed the upper one", row.lower);
  if (row.kind == RowKind::Normal && row.lower < 0)
    reject(i, "a normal impulse never pulls; lower bound", row.lower);
}

}  // namespace

ImpulseBounds impulse_bounds(const Row& row, double normal_impulse) {
  return bounds_of(row, normal_impulse);
}

double natural_map_violation(ImpulseBounds bounds, double diagonal, double lambda, double w) {
  return violation_of(bounds, diagonal, lambda, w);
}

void apply_impulses(const IslandSystem& system, const std::vector<double>& lambda,
                    std::vector<std::array<double, 3>>& velocity) {
  const std::size_t count = system.rows.size();
  const InverseMass* const bodies = system.bodies.data();
  std::array<double, 3>* const v = velocity.data();
  for (std::size_t i = 0; i < count; ++i) {
    const Row& row = system.rows[i];
    const double impulse = lambda[i];
    if (impulse != 0) push_row(bodies, row, impulse, v);
  }
}

std::vector<double> row_velocities(const IslandSystem& system, const std::vector<double>& lambda) {
  Spare<Velocities> change;
  change->assign(system.bodies.size(), {0, 0, 0});
  apply_impulses(system, lambda, *change);
  std::vector<double> w(system.rows.size());
  for (std::size_t i = 0; i < w.size(); ++i) w[i] = row_velocity(system, i, lambda[i], *change);
  return w;
}

std::vector<double> inverse_effective_masses(const IslandSystem& system) {
  std::vector<double> diagonal(system.rows.size());
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    diagonal[i] = inverse_effective_mass(system, i);
  }
  return diagonal;
}

double largest_magnitude(const std::vector<double>& values) {
  // Four maxima side by side: one alone waits for the one before.
  double largest[4] = {};
  const std::size_t count = values.size();
  const auto take = [&](std::size_t i, double& most) {
    const double size = std::abs(values[i]);
    most = most < size ? size : most;
  };
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) take(i + lane, largest[lane]);
  for (; i < count; ++i) take(i, largest[0]);
  return std::max(std::max(largest[0], largest[1]), std::max(largest[2], largest[3]));
}

double natural_map_residual(const IslandSystem& system, const std::vector<double>& lambda) {
  Spare<Velocities> change;
  change->assign(system.bodies.size(), {0, 0, 0});
  apply_impulses(system, lambda, *change);
  return residual_of(system, lambda, *change);
}

double clamp_and_judge(const IslandSystem& system, std::vector<double>& lambda, double enough,
                       ThreadPool* threads) {
  double residual = 0;
  if (may_be_path(system) && ((lanes_pay(system) && judge_path_lanes(system, lambda, residual)) ||
                              judge_path(system, lambda, residual)))
    return residual;
  Spare<Velocities> change;
  change->assign(system.bodies.size(), {0, 0, 0});
  const InverseMass* const bodies = system.bodies.data();
  std::array<double, 3>* const v = change->data();
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    const double normal_impulse = row.normal < 0 ? 0 : lambda[static_cast<std::size_t>(row.normal)];
    const ImpulseBounds bounds = bounds_of(row, normal_impulse);
    double impulse = std::isfinite(lambda[i]) ? lambda[i] : 0;
    impulse = std::clamp(impulse, bounds.lower, bounds.upper);
    lambda[i] = impulse;
    if (impulse != 0) push_row(bodies, row, impulse, v);
  }
  return residual_of(system, lambda, *change, enough, threads);
}

double residual_floor(const IslandSystem& system, const std::vector<double>& lambda) {
  // The same sums as in row_velocities with every term positive: what rounding is relative to.
  Spare<Velocities> sizes;
  Velocities& size = *sizes;
  size.assign(system.bodies.size(), {0, 0, 0});
  const auto magnitude = [](const std::array<double, 3>& J) {
    return std::array<double, 3>{std::abs(J[0]), std::abs(J[1]), std::abs(J[2])};
  };
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    for (const auto& [body, J] : {std::pair{row.a, row.Ja}, std::pair{row.b, row.Jb}}) {
      if (body < 0) continue;
      const auto k = static_cast<std::size_t>(body);
      push(system.bodies[k], magnitude(J), std::abs(lambda[i]), size[k]);
    }
  }
  double largest = 0;
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    double sum = std::abs(compliance_of(system, i) * lambda[i]);
    if (row.a >= 0) sum += along(magnitude(row.Ja), size[static_cast<std::size_t>(row.a)]);
    if (row.b >= 0) sum += along(magnitude(row.Jb), size[static_cast<std::size_t>(row.b)]);
    largest = std::max(largest, sum);
  }
  const double scale = largest_magnitude(system.b);
  return kRoundingUnit * (scale > kLeastScale ? std::max(largest / scale, 1.0) : largest);
}

void validate(const IslandSystem& system) {
  const std::size_t n = system.rows.size();
  const auto check_size = [](const char* what, std::size_t size, std::size_t wanted) {
    if (size == wanted) return;
    throw std::invalid_argument(std::string(what) + " must have " + std::to_string(wanted) +
                                " entries, got " + std::to_string(size));
  };
  check_size("b", system.b.size(), n);
  if (!system.compliance.empty()) check_size("compliance", system.compliance.size(), n);
  if (!system.positions.empty()) check_size("positions", system.positions.size(), system.bodies.size());
  for (std::size_t k = 0; k < system.bodies.size(); ++k) {
    for (const double value : {system.bodies[k].linear, system.bodies[k].angular}) {
      if (std::isfinite(value) && value >= 0) continue;
      throw std::invalid_argument("body " + std::to_string(k) +
                                  ": inverse mass must be finite and not negative, got " + to_text(value));
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    validate_row(system, i);
    const double compliance = compliance_of(system, i);
    if (!std::isfinite(compliance) || compliance < 0) {
      reject(i, "compliance must be finite and not negative", compliance);
    }
    const double diagonal = inverse_effective_mass(system, i);
    if (!std::isfinite(diagonal)) reject(i, "J M^-1 J' must be finite", diagonal);
  }
}

}  // namespace skerry
