// SPDX-License-Identifier: MIT
//
// Which blocks of a Gauss-Seidel sweep may be swept side by side. A block reads and writes the velocities of
// its two bodies only, so what matters is the order of the blocks that share a body: every order that keeps
// it gives the bits of one block after the other. A block's level is the first after those of all earlier
// blocks of its bodies; within a level no two share a body.
#pragma once

#include <cstddef>
#include <vector>

namespace skerry {

class SweepLevels {
 public:
  /// Blocks of one kind in one level: `order()[begin]` up to `order()[end]`.
  struct Run {
    int kind;
    std::size_t begin, end;
  };

  /// Forgets the blocks. @param bodies  how many there are  @param kinds  of blocks
  void start(std::size_t bodies, int kinds);
  /// The next block, between bodies `a` and `b`; numbers that are no body's stand for the ground, which
  /// nothing moves.
  void add(int a, int b, int kind);
  /// After the last block.
  void finish();

  const std::vector<Run>& runs() const { return runs_; }    ///< level by level, in a level by kind
  const std::vector<int>& order() const { return order_; }  ///< numbers of blocks; in a run ascending

 private:
  int kinds_ = 1;
  std::vector<int> next_;               ///< by body: first level after its blocks
  std::vector<std::size_t> place_;      ///< by block: level and kind in one number
  std::vector<std::size_t> beginning_;  ///< of each such number, in `order_`
  std::vector<int> order_;
  std::vector<Run> runs_;
};

}  // namespace skerry
