// SPDX-License-Identifier: MIT
//
// The embedded Runge-Kutta pair of order 8 with continuous output of order 7.
#pragma once

#include <array>
#include <functional>
#include <vector>

namespace skerry {

/// One step of the pair of Dormand and Prince of order 8(5,3) for y' = f(t, y), with its error estimate and
/// its interpolant [Dormand & Prince 1980; Hairer, Norsett & Wanner 1993, sec. II.5 and II.6].
///
/// Twelve evaluations a step, since the derivative at its end is that at the beginning of the next; three
/// more if the interpolant is wanted.
class RungeKutta {
 public:
  using State = std::vector<double>;
  /// Writes the derivative; false if there is none.
  using Derivative = std::function<bool(double t, const State& y, State& dy)>;

  /// @param controlled  the first `controlled` components decide the error
  RungeKutta(Derivative f, int controlled) : f_(std::move(f)), controlled_(controlled) {}

  /// Tries a step of length `h` [s] from (t, y), where the derivative is `dy`.
  /// @param tolerance  local error that is wanted, relative for components above `unit`, else to `unit`
  /// @return the error over the tolerance: the step is good up to 1; infinite if f could not be evaluated
  double attempt(double t, const State& y, const State& dy, double h, double tolerance, double unit);

  const State& end() const { return y1_; }
  const State& end_derivative() const { return k_[12]; }

  /// Makes `at` ready for the step that was tried last, once. @return false if f could not be evaluated
  bool prepare_dense();
  /// State at the share `theta` in [0, 1] of the step. @pre prepare_dense
  void at(double theta, State& y) const;
  /// The same of `count` components from `first` on; the others are left as they are.
  void at(double theta, std::size_t first, std::size_t count, State& y) const;

  /// Component `i` as the coefficients of a PathPiece. @pre prepare_dense
  std::array<double, 8> coefficients(std::size_t i) const;

  double length() const { return h_; }
  double begin() const { return t_; }

 private:
  bool stage(int i);

  Derivative f_;
  int controlled_;
  double t_ = 0, h_ = 0;
  bool dense_ready_ = false;
  State y0_, y1_, work_;
  State k_[16];
  State dense_[7];  ///< coefficients of the interpolant; the first belongs to theta
};

/// The factor by which to change the length of a step with this error (1 is just good), for order 8.
double step_factor(double error);

}  // namespace skerry
