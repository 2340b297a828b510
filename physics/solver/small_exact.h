// SPDX-License-Identifier: MIT
//
// Exact solves of small islands without any allocation but that of the answer: fixed-size body space on the
// stack. The same code runs on one island or on eight of one topology side by side.
#pragma once

#include <span>

#include "physics/solver/solver.h"

namespace skerry {

inline constexpr int kSmallBodies = 8;
inline constexpr int kSmallRows = 48;  ///< 16 contacts with friction and rolling

/// Whether the fast path applies: at most `kSmallBodies` bodies, all of which move and turn, at most
/// `kSmallRows` rows, contacts and joints only, no compliance.
bool fits_small_exact(const IslandSystem& system);

/// Tries "everything that touches sticks": a formula for one body on two points of a straight edge with
/// friction (a box on the floor), else one block factorisation and two proximal steps in fixed-size arrays.
/// @return false, and `solution` as it was, where that is not the answer, or the island does not fit
bool try_small_exact(const IslandSystem& system, const SolveOptions& options, Solution& solution);

/// The same; where there is no answer, `solve_body_space` takes over (and is named as the method). A warm
/// start is used only by that.
Solution solve_small_exact(const IslandSystem& system, std::span<const double> warm_start,
                           const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);

/// Eight islands of one topology, structure of arrays.
class SmallBatch {
 public:
  static constexpr int kLanes = 8;
  SmallBatch();
  ~SmallBatch();
  SmallBatch(SmallBatch&&) noexcept;
  SmallBatch& operator=(SmallBatch&&) noexcept;

  /// Puts `system` into a lane; the first one fixes the topology (bodies, pairs, kinds of rows).
  /// @return false if the island does not fit (`fits_small_exact`), or its topology is another one, or only
  /// one of both is a body on an edge (`try_small_exact`)
  /// @throws std::invalid_argument if `lane` is not in [0, kLanes)
  bool set(int lane, const IslandSystem& system);
  /// Solves all lanes at once. Lanes that were never set hold copies of no island and are left alone.
  void solve();
  /// Largest violation of the natural map in the lane, relative to its largest |b|; large where sticking is
  /// not the answer: solve that island by itself.
  double residual(int lane) const;
  /// What sticking gives the lane, called solved whatever its residual.
  Solution solution(int lane) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Solves any number of islands: neighbours in the list that share a topology go side by side, all others one
/// by one. The answers are those of `solve_small_exact` up to the order of roundings being the same: bit for
/// bit.
std::vector<Solution> solve_batch(std::span<const IslandSystem* const> systems, const SolveOptions& options);

}  // namespace skerry
