// SPDX-License-Identifier: MIT
//
// Direct solver for matrices of 3x3 blocks, one block row a body. The pattern is that of the body graph; it
// is analysed once (fill-reducing order, fill, update lists) and then factorised as often as the numbers
// change:
//
//   symmetric positive definite   P H P^T = L D L^T
//   general, same pattern         P H P^T = L D U      (no pivoting across blocks, partial pivoting inside
//   them)
//
// States: a pattern (BlockPattern) -> a matrix (`clear`, `diagonal`, `lower`, `upper`) -> `factor_*` ->
// `solve`. Everything here is numbered by elimination position; `BlockPattern::position` translates.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/archive.h"
#include "physics/solver/simd.h"

namespace skerry {

/// A 3x3 block, three columns; the fourth lane of each is zero.
struct alignas(32) Block3 {
  Vec4 column[3];
};

inline void fields(Archive& a, Block3& block) {
  static_assert(sizeof(Block3) == 12 * sizeof(double));
  a.doubles(&block, 12);
}
inline void fields(Archive& a, BodyVector& vector) {
  static_assert(sizeof(BodyVector) == 4 * sizeof(double));
  a.doubles(&vector, 4);
}

/// Fill-reducing elimination order of a graph, and where the numbers of its factor stand.
class BlockPattern {
 public:
  /// Analyses the graph of `nodes` nodes: approximate minimum degree order [Amestoy, Davis & Duff 1996],
  /// column structure of L by the elimination tree, and for every column the places its outer product is
  /// subtracted from. Edges may repeat and stand in any order; the result depends on the set of edges only.
  void analyse(int nodes, std::span<const std::array<int, 2>> edges);

  int nodes() const { return static_cast<int>(order_.size()); }
  /// Number of blocks of L below the diagonal.
  int blocks() const { return static_cast<int>(row_.size()); }
  /// Elimination position of `node`.
  int position(int node) const { return position_[static_cast<std::size_t>(node)]; }
  /// Node at each elimination position.
  const std::vector<int>& order() const { return order_; }
  /// Index of the block of L in column `low` and row `high` (positions, low < high), or -1 if it is not
  /// there.
  int block(int low, int high) const;
  /// Number of blocks of column `low` below the diagonal.
  int column_size(int low) const {
    return begin_[static_cast<std::size_t>(low) + 1] - begin_[static_cast<std::size_t>(low)];
  }
  /// The column's parent in the elimination tree, or -1 at a root.
  int parent(int low) const {
    return column_size(low) > 0 ? row_[static_cast<std::size_t>(begin_[static_cast<std::size_t>(low)])] : -1;
  }
  /// Block updates of one factorisation, a measure of its cost.
  std::int64_t updates() const { return static_cast<std::int64_t>(update_.size()); }

  void fields(Archive& a) {
    auto& [order, position, begin, row, update_begin, update] = *this;
    a(order, position, begin, row, update_begin, update);
  }

 private:
  friend class BlockFactor;
  std::vector<int> order_, position_;
  std::vector<int> begin_;  // column j of L holds blocks begin_[j] .. begin_[j + 1]
  std::vector<int> row_;    // row of each block, ascending in a column
  std::vector<std::int64_t> update_begin_;
  std::vector<int> update_;  // targets of the outer product of a column, pair (k, i > k) by pair
};

/// The numbers of a matrix on a BlockPattern, then of its factor.
class BlockFactor {
 public:
  /// Takes the sizes of `pattern`, which must outlive this object's use with it.
  void set_pattern(const BlockPattern& pattern);
  /// Sets the matrix to zero. @param general whether blocks above the diagonal will be given (`upper`).
  void clear(bool general);

  Block3& diagonal(int position) { return diagonal_[static_cast<std::size_t>(position)]; }
  /// Block `index` of the pattern: row high, column low.
  Block3& lower(int index) { return lower_[static_cast<std::size_t>(index)]; }
  /// Its mirror: row low, column high. Only after `clear(true)`.
  Block3& upper(int index) { return upper_[static_cast<std::size_t>(index)]; }

  /// Factorises in place. Returns false, and leaves the numbers unusable, if a pivot is zero, not finite or,
  /// for a symmetric matrix, not positive.
  [[nodiscard]] bool factor();
  /// Solves in place: `x` holds the right-hand side, one vector a position, then the solution.
  /// @pre the last `factor` returned true
  void solve(BodyVector* x) const;
  /// The two halves of `solve`, L first, as far as some columns go: what is not in them is neither read nor
  /// written. @param columns ascending, with all their ancestors; null: all
  void forward(BodyVector* x, const std::vector<int>* columns = nullptr) const;
  void backward(BodyVector* x, const std::vector<int>* columns = nullptr) const;
  /// Solves for the three unit vectors of position `unit`, on some columns only: transposed blocks, one a
  /// column. @param columns ascending, with all their ancestors @param slot where each stands in `columns`
  void solve_unit(std::span<const int> columns, const std::vector<int>& slot, int unit, Block3* v) const;

  int nodes() const { return static_cast<int>(diagonal_.size()); }
  /// Whether the last matrix was one without symmetry.
  bool is_general() const { return general_; }

  /// @pre when reading, `set_pattern` with the same pattern
  void fields(Archive& a) {
    [[maybe_unused]] auto& [pattern, general, diagonal, lower, upper, column, pivot] = *this;
    a(general, diagonal, lower, upper, column, pivot);
  }

 private:
  struct Kernels;
  const BlockPattern* pattern_ = nullptr;
  bool general_ = false;
  std::vector<Block3> diagonal_, lower_, upper_, column_;
  std::vector<std::array<unsigned char, 3>> pivot_;
};

}  // namespace skerry
