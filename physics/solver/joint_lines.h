// SPDX-License-Identifier: MIT
//
// Long chains and trees of joints, answered as a whole. Gauss-Seidel sweeps hand a pull on by one joint a
// sweep and take as many as a chain has links, squared, to spread it; but what all its joints want at once,
//
//   Q Q' (change of x) = b - Q y
//
// is a system whose rows of one joint are coupled with those of the joints at the same two bodies only. In a
// tree these are cliques, so that elimination from the leaves inwards fills nothing in [Parter 1961] and both
// factor and solve are linear in the joints. It is one block among the others of a sweep [block relaxation:
// Saad 2003, section 4.1.1], which leaves the answer that sweeps come to as it is.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/solver/simd.h"

namespace skerry {

class JointLines {
 public:
  /// Joint of two bodies with so many rows that hold both ways, as orthonormal combinations of theirs.
  struct Joint {
    int block = 0;  ///< number of its impulses
    int a = 0, b = 0;
    int count = 0;  ///< 1 to 4
  };
  /// The numbers of its rows, as in `BlockSweeps`.
  struct Rows {
    const Vec4& b;
    const BodyVector *low, *high;  ///< on the velocities of `a` and `b`
    const double* speed;
  };

  void clear();
  bool empty() const { return joints_.empty(); }
  /// Of the joints those of trees that are long: of a cycle all but one joint, of those at one body the first
  /// few. @param ground  number of the body that nothing moves, which connects nothing
  void choose(std::span<const Joint> joints, int ground);
  /// Those that were chosen, in the order in which they are eliminated.
  const std::vector<Joint>& joints() const { return joints_; }

  /// Copies the numbers of one of them.
  void take(std::size_t joint, const Rows& rows);
  /// Factors Q Q' + give. @param held  becomes 0, by joint, where rows depend on those of other joints to
  /// rounding: these are not changed; else 1
  void eliminate(double give, std::vector<std::uint8_t>& held);

  /// Changes impulses to the answer, and velocities with them.
  /// @return largest amount by which a row missed what it wants before [m/s]
  double answer(std::vector<BodyVector>& impulses, std::vector<BodyVector>& velocities);

 private:
  struct Row {
    BodyVector low, high;
    double b = 0, speed = 0;
    double inverse = 0;      ///< of the pivot; 0: depends on others
    int first = 0, end = 0;  ///< entries of L, in `entries_`
  };
  struct Entry {
    int row = 0;
    double l = 0;
  };
  struct Kernel;

  void order(std::span<const Joint> chosen, int ground);
  double coupling(std::size_t row, std::size_t other) const;

  double give_ = 0;
  std::vector<Joint> joints_;
  std::vector<int> first_;     ///< row by joint, and the end of the last one
  std::vector<int> joint_of_;  ///< by row
  std::vector<Row> rows_;
  std::vector<Entry> entries_;
  std::vector<double> work_;  ///< by row
};

}  // namespace skerry
