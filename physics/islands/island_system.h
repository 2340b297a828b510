// SPDX-License-Identifier: MIT
//
// The discrete contact problem of one island as plain data: it can be copied, hashed, drawn, exported and
// solved again by any solver.
//
//   w = W lambda - b,   W = J M^-1 J^T + diag(compliance)       (n x n, the Delassus operator)
//
// row by row:  w = 0 strictly inside the bounds of lambda,  w >= 0 at a lower,  w <= 0 at an upper bound.
// lambda are impulses [N s] (rolling rows: [N m s]); w and b are velocities [m/s] (angular rows: [rad/s]).
// With v* the free velocity and u the wanted relative velocity, b = u - J v*; the new velocity is v = v* +
// M^-1 J^T lambda.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "physics/math.h"

namespace skerry {

class ThreadPool;

enum class RowKind : std::uint8_t { Normal, Friction, Rolling, Joint, Limit, Motor };

/// One scalar constraint between two bodies of the island. The velocity along the row is `Ja . v_a + Jb .
/// v_b` with v = (vx, vy, omega).
struct Row {
  RowKind kind = RowKind::Normal;
  int a = -1;                  ///< body of the island, or -1 for the ground (a body of infinite mass)
  int b = -1;                  ///< the other one; never equal to `a`
  std::array<double, 3> Ja{};  ///< velocity Jacobian block of `a` [1, 1, m]; zero for the ground
  std::array<double, 3> Jb{};  ///< that of `b`
  double lower = 0;            ///< bounds of the impulse [N s]; Normal: 0 and +inf, Joint: -inf and +inf
  double upper = kInfinity;
  int normal = -1;  ///< Friction and Rolling: row whose impulse scales the bounds, always an earlier row
  double mu = 0;    ///< |lambda| <= mu * lambda[normal]; Friction: [1], Rolling: [m]
  std::uint64_t source = 0;  ///< contact or joint, with the feature: equal from step to step while it lasts
};

/// Inverse mass and inverse moment of inertia about the centre of mass [1/kg, 1/(kg m^2)]. Zero: does not
/// move.
struct InverseMass {
  double linear = 0;
  double angular = 0;
};

/// A contact problem. Rows of one contact stand together: Normal, then its Friction, then its Rolling row.
struct IslandSystem {
  std::vector<InverseMass> bodies;  ///< in the island's canonical order
  std::vector<Vec2>
      positions;          ///< centres of mass, for drawing and geometric orderings; same length, may be empty
  std::vector<Row> rows;  ///< n rows
  std::vector<double> b;  ///< n wanted changes of relative velocity
  std::vector<double> compliance;  ///< n diagonal terms [m/(N s)], or empty when all are zero

  int size() const { return static_cast<int>(rows.size()); }
};

/// Velocity of a body along a Jacobian block: J . v.
inline double along(const std::array<double, 3>& J, const std::array<double, 3>& v) {
  return J[0] * v[0] + J[1] * v[1] + J[2] * v[2];
}

/// v += M^-1 J^T impulse for one body.
inline void push(const InverseMass& body, const std::array<double, 3>& J, double impulse,
                 std::array<double, 3>& v) {
  v[0] += body.linear * J[0] * impulse;
  v[1] += body.linear * J[1] * impulse;
  v[2] += body.angular * J[2] * impulse;
}

/// J M^-1 J^T of one body: its share of a diagonal entry of W.
inline double inverse_mass_along(const InverseMass& body, const std::array<double, 3>& J) {
  return body.linear * (J[0] * J[0] + J[1] * J[1]) + body.angular * J[2] * J[2];
}

/// Adds `J^T lambda` times the inverse masses to `velocity` (one (vx, vy, omega) a body).
void apply_impulses(const IslandSystem& system, const std::vector<double>& lambda,
                    std::vector<std::array<double, 3>>& velocity);

/// Returns w = W lambda - b by way of the bodies, in O(rows).
std::vector<double> row_velocities(const IslandSystem& system, const std::vector<double>& lambda);

/// Diagonal of W: the inverse effective mass seen by each row [1/kg; angular rows 1/(kg m^2)], compliance
/// included.
std::vector<double> inverse_effective_masses(const IslandSystem& system);

/// The one error measure for all solvers: the largest violation of the natural map, in velocity units,
/// relative to the largest |b| (absolute when that is no more than none).
///
/// For a row with bounds [l, u] (friction: +-mu lambda_n) and D its diagonal of W, the violation is
/// `D * |lambda - clamp(lambda - w / D, l, u)|`; it is zero exactly at solutions [Acary & Brogliato 2008,
/// sec. 3.3]. A friction row whose normal impulse is negative counts with bounds zero. Rows with D = 0
/// (nothing moves) count their |w| where lambda is not at a bound that explains it.
double natural_map_residual(const IslandSystem& system, const std::vector<double>& lambda);

/// Puts each impulse into its bounds (what is not finite becomes 0 first), row by row, and returns
/// `natural_map_residual` of the result: one pass over the rows less than the two calls.
/// @param enough   whoever wants no more may be told infinity in place of a larger residual
/// @param threads  share what they can; null: the caller's alone
double clamp_and_judge(const IslandSystem& system, std::vector<double>& lambda, double enough = kInfinity,
                       ThreadPool* threads = nullptr);

/// Returns the residual that rounding alone explains at `lambda`: about one unit of rounding of the largest
/// sum |W| |lambda|, relative as in `natural_map_residual`. Solvers accept a few times this in place of the
/// tolerance; there is nothing to gain below it.
double residual_floor(const IslandSystem& system, const std::vector<double>& lambda);

/// Bounds of one impulse [N s].
struct ImpulseBounds {
  double lower = 0;
  double upper = 0;
};
/// Returns the bounds of a row; `normal_impulse` is that of `row.normal` (negative counts as zero) and is
/// not looked at for rows with bounds of their own.
ImpulseBounds impulse_bounds(const Row& row, double normal_impulse);

/// Returns the violation of one row's natural map [m/s], as in `natural_map_residual`.
double natural_map_violation(ImpulseBounds bounds, double diagonal, double lambda, double w);

/// Returns the largest absolute value, 0 for none.
double largest_magnitude(const std::vector<double>& values);

/// Velocities below this [m/s] are no more than none: they may have no digits left to divide by.
inline constexpr double kLeastScale = 1e-280;

/// Returns what residuals are relative to [m/s]: the largest |b|, or 1 where that is no more than none.
inline double residual_scale(double largest) {
  return largest > kLeastScale ? largest : 1;
}

/// Half a unit in the last place of 1.
inline constexpr double kRoundingUnit = 1.1102230246251565e-16;

/// Checks sizes, indices, bounds (lower <= upper), finiteness, and the order of friction rows.
/// @throws std::invalid_argument with the row's number and the value.
void validate(const IslandSystem& system);

}  // namespace skerry
