// SPDX-License-Identifier: MIT
//
// A factor of H = M + sum J_i^T (g_i J_i + h_i J_n) whose weights have changed in a few rows, without
// factorising anew. What the changed rows do beyond what the factor takes them to do is an unknown impulse
// z_i each, small in number and dense:
//
//   z_i / s_i + R_i (x + G C^T z) = c_i / s_i,   R_i = ((g_i - g0_i) J_i + (h_i - h0_i) J_n) / s_i
//
// with x the velocities that the factor alone gives, C the Jacobians of the changed rows, G = E^T H^-1 E at
// their bodies, s_i the larger of the weights [Woodbury 1950; Hager 1989]. With z for unknowns no stiff
// weight cancels another one. G needs the factor on the paths from those bodies to the root of the
// elimination tree only; it grows with them and is kept while the factor is.
#pragma once

#include <vector>

#include "physics/solver/block_ldlt.h"

namespace skerry {

class LocalUpdate {
 public:
  /// Changed rows and their bodies, at most.
  static constexpr int kMostRows = 128, kMostNodes = 64;

  /// One changed row: Jacobian blocks (C) and change of law (R) of its two positions; -1 for the ground.
  struct Row {
    int row = 0, low = -1, high = -1;
    double size = 0;  // s
    BodyVector C_low{}, C_high{}, R_low{}, R_high{};

    void fields(Archive& a) {
      auto& [row_, low_, high_, size_, C_low_, C_high_, R_low_, R_high_] = *this;
      a(row_, low_, high_, size_, C_low_, C_high_, R_low_, R_high_);
    }
  };

  /// Forgets everything: the factor is another one.
  void reset();
  /// Whether the rows say that the factor is not that of the weights.
  bool active() const { return active_; }

  /// Begins a change of the weights of the factor, from nothing.
  void start();
  /// @return false if there are too many rows or bodies already
  [[nodiscard]] bool add(const Row& row);
  /// Makes the change the one that is solved with; false if it leaves a singular matrix.
  [[nodiscard]] bool finish(const BlockPattern& pattern, const BlockFactor& factor);
  /// Blocks of the factor that were visited for G by the last `finish`.
  double visited() const { return visited_; }

  const std::vector<Row>& rows() const { return rows_; }
  /// Positions whose answers to impulses at each other are known: those of the rows, and of earlier ones.
  const std::vector<int>& nodes() const { return nodes_; }
  /// Columns of the factor on the paths from the rows' positions to the root, ascending.
  const std::vector<int>& columns() const { return columns_; }
  /// Computes z from the velocities `x` that the factor gives, or null where it gives none, and `z` = c, one
  /// a row.
  void solve(const BodyVector* x, std::vector<double>& z) const;
  /// Sets the velocities that z alone gives, by position, at `nodes()`.
  void respond(const std::vector<double>& z, BodyVector* v) const;

  void fields(Archive& a) {
    [[maybe_unused]] auto& [rows, place, nodes, known, G, lu, pivot, columns, slot, paths, velocity, active,
                            visited] = *this;
    a(rows, place, nodes, known, G, lu, pivot, columns, active);
  }

 private:
  int node(int position);
  void add_response(int row, double impulse, BodyVector* velocity) const;
  bool factor_dense();

  std::vector<Row> rows_;
  std::vector<std::array<int, 2>> place_;  // of the rows' positions among the nodes, or -1
  std::vector<int> nodes_;                 // positions
  int known_ = 0;                          // nodes whose part of G is there
  std::vector<double> G_;                  // 3 kMostNodes a side, by column
  std::vector<double> lu_;                 // of the rows' matrix, kMostRows a side, by column
  std::vector<int> pivot_;
  std::vector<int> columns_;                  // on the paths, ascending
  std::vector<int> slot_;                     // scratch: where each stands in columns_
  std::vector<Block3> paths_;                 // scratch: by column on the paths
  mutable std::vector<BodyVector> velocity_;  // scratch: by node
  bool active_ = false;
  double visited_ = 0;
};

}  // namespace skerry
