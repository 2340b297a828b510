// SPDX-License-Identifier: MIT
//
// Forces of many joints at acceleration level, in the space of the joints: the cheapest way for chains and
// trees.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "physics/islands/island_system.h"
#include "physics/solver/block_ldlt.h"
#include "physics/solver/solver.h"

namespace skerry {

/// Solves W lambda = b, W = J M^-1 J', for rows without bounds. Rows of one joint make a block; W has a block
/// off its diagonal where two joints share a body, so that of a chain is block tridiagonal and costs O(n), by
/// one LDL' without fill [Golub & Van Loan 2013, sec. 4.5.1].
class BilateralForces {
 public:
  struct Row {
    int a = -1, b = -1;  ///< bodies; -1: the ground
    std::array<double, 3> Ja{}, Jb{};
    double wanted = 0;  ///< b
  };

  /// @param lambda  one value a row
  /// @return false where W is not regular to nine digits, or so many joints share a body that W is nearly
  /// full: then `lambda` means nothing
  bool solve(std::span<const InverseMass> bodies, std::span<const Row> rows, SolveWork& work,
             std::vector<double>& lambda);

 private:
  /// Consecutive rows between the same bodies, three at most.
  struct Joint {
    int first = 0, count = 0;  ///< rows
    int a = -1, b = -1;
    int place = 0;  ///< elimination position
  };
  /// Two joints that share a body.
  struct Coupling {
    int low = 0, high = 0;               ///< joints, the one that is eliminated first first
    bool low_b = false, high_b = false;  ///< the body is their b
    int block = 0;
  };

  bool analyse(std::size_t bodies, std::span<const Row> rows, SolveWork& work);
  bool factor(std::span<const InverseMass> bodies, std::span<const Row> rows, SolveWork& work);
  void add_solution(const std::vector<double>& r, std::vector<double>& lambda);
  double remainder(std::span<const InverseMass> bodies, std::span<const Row> rows,
                   const std::vector<double>& lambda, std::vector<double>& r);

  std::vector<Joint> joints_, found_;
  std::vector<Coupling> couplings_;
  std::size_t bodies_ = 0;
  bool fits_ = false;  ///< the graph is sparse enough
  BlockPattern pattern_;
  BlockFactor factor_;
  std::vector<BodyVector> x_;
  std::vector<std::array<double, 3>> velocity_;
  std::vector<double> r_, whole_;  ///< remainder; the diagonal of W
};

}  // namespace skerry
