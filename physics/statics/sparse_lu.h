// SPDX-License-Identifier: MIT
//
// LU factors of a sparse square matrix that is factorised once and solved with often.
#pragma once

#include <vector>

namespace skerry::statics {

/// One entry of a sparse matrix.
struct Entry {
  int row = 0, column = 0;
  double value = 0;
};

/// P A Q = L U with partial pivoting, column by column [Gilbert & Peierls 1988]; Q by COLAMD.
///
/// States: empty -> `factor` returned true -> `solve`, `solve_transposed` any number of times, each in
/// O(nonzeros of L and U).
class SparseLu {
 public:
  /// Factorises the n x n matrix whose entries are summed where they repeat.
  /// @param smallest_pivot  a column whose pivot is not above this is taken for dependent on those before
  /// @return false if there is such a column, or a number that is not finite; the factor is unusable then
  [[nodiscard]] bool factor(int n, const std::vector<Entry>& entries, double smallest_pivot);

  /// The same for n rows and more columns: a column that depends on those before it (in the order of
  /// elimination) is left out, and `left_out` gets its number. `solve` then answers with one number a column,
  /// zero for those left out.
  [[nodiscard]] bool factor(int n, int columns, const std::vector<Entry>& entries, double smallest_pivot,
                            std::vector<int>& left_out);

  /// Solves A x = x in place. `work` is resized as needed; passing the same one saves allocations.
  void solve(std::vector<double>& x, std::vector<double>& work) const;
  /// Solves A^T x = x in place.
  void solve_transposed(std::vector<double>& x, std::vector<double>& work) const;

  int size() const { return n_; }
  /// Nonzeros of L and U together.
  int nonzeros() const { return static_cast<int>(lower_.row.size() + upper_.row.size()) + n_; }

 private:
  struct Columns {
    std::vector<int> begin, row;
    std::vector<double> value;
  };
  bool eliminate(int n, int columns, const std::vector<Entry>& entries, double smallest_pivot,
                 std::vector<int>* left_out);

  int n_ = 0, columns_ = 0;
  std::vector<int> column_order_;  ///< Q: which column of A is eliminated at each position
  std::vector<int> row_position_;  ///< P: position of each row of A
  Columns lower_, upper_;          ///< by positions; without the unit diagonal, without the pivots
  std::vector<double> inverse_pivot_;
};

}  // namespace skerry::statics
