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
#include <span>
#include <vector>

#include "physics/archive.h"
#include "physics/progress.h"
#include "physics/solver/block_pattern.h"
#include "physics/solver/block_sharing.h"
#include "physics/solver/simd.h"
#include "physics/thread_pool.h"

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
  /// Its mirror, row low and column high, transposed. Only for matrices without symmetry.
  Block3& upper(int index) { return upper_[static_cast<std::size_t>(index)]; }

  /// Factorises in place. Returns false, and leaves the numbers unusable, if a pivot is zero, not finite or,
  /// for a symmetric matrix, not positive.
  [[nodiscard]] bool factor();
  /// The same for the matrix that `fill(position)` makes, which is called for each position and gives the
  /// diagonal block and those of the pattern below it and, if `general`, their mirrors, in place of zeros; it
  /// is called at the same time for several. @param threads  share a large matrix; null: the caller's alone
  template <class Fill>
  [[nodiscard]] bool factor(bool general, ThreadPool* threads, const Fill& fill) {
    return factor(general, threads,
                  {[](const void* it, int position) { (*static_cast<const Fill*>(it))(position); }, &fill});
  }
  /// Solves in place: `x` holds the right-hand side, one vector a position, then the solution.
  /// @param threads  share it where they shared the factorisation @pre the last `factor` returned true
  void solve(BodyVector* x, ThreadPool* threads = nullptr) const;
  /// The two halves of `solve`, L first.
  void forward(BodyVector* x, ThreadPool* threads = nullptr) const;
  void backward(BodyVector* x, ThreadPool* threads = nullptr) const;
  /// The same as far as some columns go: what is not in them is neither read nor written.
  /// @param columns ascending, with all their ancestors
  void forward(BodyVector* x, const std::vector<int>& columns) const;
  void backward(BodyVector* x, const std::vector<int>& columns) const;
  /// Solves for the three unit vectors of position `unit`, on some columns only: transposed blocks, one a
  /// column. @param columns ascending, with all their ancestors @param slot where each stands in `columns`
  void solve_unit(std::span<const int> columns, const std::vector<int>& slot, int unit, Block3* v) const;

  int nodes() const { return static_cast<int>(diagonal_.size()); }
  /// Whether the last matrix was one without symmetry.
  bool is_general() const { return general_; }

  /// @pre when reading, `set_pattern` with the same pattern
  void fields(Archive& a) {
    [[maybe_unused]] auto& [pattern, general, diagonal, lower, upper, column, pivot, sharing, finished,
                            passed] = *this;
    a(general, diagonal, lower, upper, column, pivot);
  }

 private:
  struct Kernels;
  struct Scratch;
  struct FillColumn {
    void (*call)(const void* it, int position);
    const void* it;
  };
  /// Columns that one call goes over, ascending.
  struct Some {
    std::span<const int> columns;
    bool all = false;
    static Some everything() { return {{}, true}; }
  };
  enum class Rows { All, Inside };  ///< of a column: all, or those of its subtree
  bool factor(bool general, ThreadPool* threads, const FillColumn& fill);
  bool factor_by(ThreadPool& threads, const FillColumn& fill);
  bool shared_by(ThreadPool* threads) const {
    return threads != nullptr && sharing_.threads() == threads->threads() && sharing_.pays();
  }
  void fill_column(int column, const FillColumn& fill);
  void forward_some(BodyVector* x, const Some& some, Rows rows) const;
  void backward_some(BodyVector* x, const Some& some) const;

  const BlockPattern* pattern_ = nullptr;
  bool general_ = false;
  std::vector<Block3> diagonal_, lower_, upper_, column_;
  std::vector<std::array<unsigned char, 3>> pivot_;
  BlockSharing sharing_;
  std::vector<Progress> finished_;        // units of `sharing_`
  mutable std::vector<Progress> passed_;  // columns that each part of the rows is done with, while it solves
};

}  // namespace skerry
