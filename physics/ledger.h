// SPDX-License-Identifier: MIT
//
// Energy, momentum and hash of all bodies, kept in blocks: a step that moves few bodies adds up few. The sums
// are taken block by block in one order, so they do not depend on which blocks were kept.
#pragma once

#include <cstdint>
#include <vector>

#include "physics/body.h"
#include "physics/thread_pool.h"

namespace skerry {

/// Sums over the bodies, dynamic ones for all but the hash.
struct BodySums {
  double kinetic = 0;    ///< [J]
  double potential = 0;  ///< in the uniform field, zero at the origin [J]
  Vec2 momentum;         ///< [kg m/s]
  double angular = 0;    ///< about the world's origin [kg m^2/s]
  /// Of the slot, position, angle and velocities of live bodies: hash.h over each block, then over the
  /// blocks' hashes.
  std::uint64_t hash = 0;
};

/// Sums over all bodies, computed from scratch.
BodySums sum_bodies(const BodyArrays& bodies, Vec2 gravity);

class Ledger {
 public:
  /// The body may have changed, appeared or vanished since the last `total`.
  void mark(std::uint32_t body);
  void mark_all() { blocks_.clear(); }
  /// The same bits as `sum_bodies`, from the blocks that were marked and the kept ones.
  /// @param threads  share the work; may be null
  BodySums total(const BodyArrays& bodies, Vec2 gravity, ThreadPool* threads = nullptr);

 private:
  struct Block {
    BodySums sums;
    bool any = false;  ///< a body of it is alive
    bool stale = true;
  };
  friend BodySums sum_bodies(const BodyArrays& bodies, Vec2 gravity);
  static void add_up(const BodyArrays& bodies, Vec2 gravity, std::size_t block, Block& out);

  std::vector<Block> blocks_;
};

}  // namespace skerry
