// SPDX-License-Identifier: MIT
//
// Rows of joints in the interior point for contacts: without bounds, between bounds of their own, or
// compliant.
//
// With L = D lambda, in velocities, and slacks p = L - lower, q = upper - L against z, r >= 0:
//
//   w + c lambda - z + r = 0,      p z = tau,      q r = tau
//
// Eliminated, a row adds j j' / (c / D + z / p + r / q) to the matrix of the bodies. What has no bounds takes
// a proximal weight in their place, so that rows that say the same leave it regular [Rockafellar 1976].
#pragma once

#include <array>
#include <span>
#include <vector>

#include "physics/islands/island_system.h"
#include "physics/solver/block_ldlt.h"
#include "physics/solver/cone_incidence.h"

namespace skerry {

class ConeJoints {
 public:
  /// Whether a row is one that this takes: its bounds are its own, and leave it room or nothing.
  static bool takes(const Row& row) {
    return row.kind != RowKind::Normal && row.normal < 0 && (row.lower < row.upper || row.lower == 0);
  }

  void clear();
  /// Adds row `index` between positions of a pattern, `ground` for the ground. @param mass  M^-1/2 by
  /// position
  void add(const IslandSystem& system, int index, std::array<int, 2> positions, const BlockPattern& pattern,
           const std::vector<BodyVector>& mass, int ground);
  /// All are there. @param middle  what roots D^1/2 are relative to in weights of products
  void finish(int nodes, double middle);
  std::size_t size() const { return joints_.size(); }

  /// Begins next to impulses [n]. @param centre  root of the products [m/s]
  void start(std::span<const double> lambda, double centre);
  void get(std::vector<double>& lambda) const;

  /// Sums of the products, over their weight, and how many there are.
  double products() const;
  int sides() const { return sides_; }

  /// Impulses as they are. `push` acts with what was set last.
  void act();
  void push(std::vector<BodyVector>& y) const;
  /// What is wrong where bodies move by `y`. @return sum of its squares [m^2/s^2]
  double measure(const std::vector<BodyVector>& y);
  /// Adds to column `position` of the matrix; with the mirrors, if it is general.
  void fill(int position, bool general, BlockFactor& factor) const;
  /// Right-hand side towards products of `target`.
  void aim(double target);
  /// The direction, from that of the bodies. @return by how much the fastest falls, of what there is
  double direct(const std::vector<BodyVector>& y, double target);
  /// What the predictor changes in products. @return their sum, over their weight
  double predict(double length);
  /// @param least  what presses where a product is smaller, over its weight, rises to that
  void move(double length, double least);

 private:
  /// A bound, the slack before it and what presses against it.
  struct Side {
    bool is = false;
    double bound = 0;
    double slack = 1, press = 0, d_slack = 0, d_press = 0, rest = 0;
  };
  struct alignas(32) Joint {
    BodyVector low_row{}, high_row{};  ///< over their root, velocities by the roots of the masses
    double root = 0;                   ///< D^1/2
    double unit = 1;                   ///< what one of its velocities moves [m/s]
    double weight = 1, inverse_weight = 1;
    double b = 0, give = 0;                       ///< c / D
    double least = -kInfinity, most = kInfinity;  ///< bounds of lambda
    double impulse = 0, change = 0, wrong = 0, stiffness = 0, push = 0;
    int low = 0, high = 0, block = -1, row = 0;
    std::array<Side, 2> sides;  ///< lower, upper
  };
  static double velocity(const Joint& joint, const std::vector<BodyVector>& y);
  static double towards(const Joint& joint, double target);

  std::vector<Joint> joints_;
  ConeIncidence incidence_;
  int sides_ = 0;
};

}  // namespace skerry
