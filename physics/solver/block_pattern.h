// SPDX-License-Identifier: MIT
//
// What a factorisation of a matrix of 3x3 blocks does, before there are numbers: the elimination order of the
// body graph, the fill, and where each product goes. It is analysed once and serves as long as the graph
// stays.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/archive.h"
#include "physics/solver/dissection.h"

namespace skerry {

/// Fill-reducing elimination order of a graph, and where the numbers of its factor stand.
class BlockPattern {
 public:
  /// Analyses the graph of `nodes` nodes: approximate minimum degree order [Amestoy, Davis & Duff 1996],
  /// column structure of L by the elimination tree, and for every column the places its outer product is
  /// subtracted from. Edges may repeat and stand in any order; the result depends on the set of edges, and on
  /// the places, only.
  /// @param places  of the nodes [m]; where they are given and the graph is large, the order is that of
  /// nested dissection if it takes fewer updates
  void analyse(int nodes, std::span<const std::array<int, 2>> edges, std::span<const Vec2> places = {});

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
  /// Columns, at most, whose products are subtracted together.
  static constexpr int kMostAlike = 4;
  /// Number of columns from `low` on, up to that, each of which has the rows of the one before without the
  /// first.
  int alike(int low) const;
  /// Block updates of one factorisation, a measure of its cost.
  std::int64_t updates() const { return static_cast<std::int64_t>(update_.size()); }

  void fields(Archive& a) {
    auto& [order, position, begin, row, update_begin, update] = *this;
    a(order, position, begin, row, update_begin, update);
  }

 private:
  friend class BlockFactor;
  friend class BlockSharing;
  void find_structure(const Adjacency& graph);
  std::int64_t count_updates() const;

  std::vector<int> order_, position_;
  std::vector<int> begin_;  // column j of L holds blocks begin_[j] .. begin_[j + 1]
  std::vector<int> row_;    // row of each block, ascending in a column
  std::vector<std::int64_t> update_begin_;
  std::vector<int> update_;  // targets of the outer product of a column, pair (k, i > k) by pair
};

}  // namespace skerry
