// SPDX-License-Identifier: MIT
#include "physics/solver/block_ldlt.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "physics/index.h"
#include "physics/large_pages.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Pivots beyond this are overflow in the making.
constexpr double kHuge = 1e200;

constexpr int kColumns = BlockPattern::kMostAlike;

// C -= A B^T
SKERRY_ALWAYS_INLINE void subtract_abt(Block3& C, const Block3& A, const Block3& B) {
  for (int k = 0; k < 3; ++k) {
    Vec4 t = C.column[k];
    t -= A.column[0] * B.column[0][k];
    t -= A.column[1] * B.column[1][k];
    t -= A.column[2] * B.column[2][k];
    C.column[k] = t;
  }
}

// C -= A B
SKERRY_ALWAYS_INLINE void subtract_ab(Block3& C, const Block3& A, const Block3& B) {
  for (int k = 0; k < 3; ++k) {
    Vec4 t = C.column[k];
    t -= A.column[0] * B.column[k][0];
    t -= A.column[1] * B.column[k][1];
    t -= A.column[2] * B.column[k][2];
    C.column[k] = t;
  }
}

// x -= A t
SKERRY_ALWAYS_INLINE void subtract_av(Vec4& x, const Block3& A, const Vec4& t) {
  x -= A.column[0] * t[0] + A.column[1] * t[1] + A.column[2] * t[2];
}

// Replaces a symmetric block by its factors: unit lower L below the diagonal, 1/d on it.
SKERRY_ALWAYS_INLINE bool factor_symmetric(Block3& D) {
  const double d0 = D.column[0][0];
  const double i0 = 1 / d0, l10 = D.column[0][1] * i0, l20 = D.column[0][2] * i0;
  const double d1 = D.column[1][1] - l10 * D.column[0][1];
  const double e = D.column[1][2] - l20 * D.column[0][1];
  const double i1 = 1 / d1, l21 = e * i1;
  const double d2 = D.column[2][2] - l20 * D.column[0][2] - l21 * e;
  if (!(d0 > 0 && d1 > 0 && d2 > 0 && d0 < kHuge && d1 < kHuge && d2 < kHuge)) return false;
  D.column[0] = Vec4{i0, l10, l20, 0};
  D.column[1] = Vec4{0, i1, l21, 0};
  D.column[2] = Vec4{0, 0, 1 / d2, 0};
  return true;
}

// Y <- Y D^-1, D symmetric and factorised.
SKERRY_ALWAYS_INLINE void divide_symmetric(Block3& Y, const Block3& D) {
  Vec4 y0 = Y.column[0], y1 = Y.column[1], y2 = Y.column[2];
  const double l10 = D.column[0][1], l20 = D.column[0][2], l21 = D.column[1][2];
  y1 -= y0 * l10;
  y2 -= y0 * l20 + y1 * l21;
  y0 *= D.column[0][0];
  y1 *= D.column[1][1];
  y2 *= D.column[2][2];
  y1 -= y2 * l21;
  y0 -= y1 * l10 + y2 * l20;
  Y.column[0] = y0;
  Y.column[1] = y1;
  Y.column[2] = y2;
}

SKERRY_ALWAYS_INLINE void solve_symmetric(const Block3& D, Vec4& x) {
  const double l10 = D.column[0][1], l20 = D.column[0][2], l21 = D.column[1][2];
  double x0 = x[0], x1 = x[1] - l10 * x0, x2 = x[2] - (l20 * x0 + l21 * x1);
  x2 *= D.column[2][2];
  x1 = x1 * D.column[1][1] - l21 * x2;
  x0 = x0 * D.column[0][0] - (l10 * x1 + l20 * x2);
  x = Vec4{x0, x1, x2, 0};
}

// Replaces a block by P D = L U: unit L, 1/u on the diagonal.
SKERRY_ALWAYS_INLINE bool factor_general(Block3& D, std::array<unsigned char, 3>& pivot) {
  double m[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m[i][j] = D.column[j][i];
  int p[3] = {0, 1, 2};
  for (int k = 0; k < 3; ++k) {
    int best = k;
    for (int i = k + 1; i < 3; ++i)
      if (std::fabs(m[i][k]) > std::fabs(m[best][k])) best = i;
    if (best != k) {
      std::swap(p[k], p[best]);
      for (int j = 0; j < 3; ++j) std::swap(m[k][j], m[best][j]);
    }
    const double size = std::fabs(m[k][k]);
    if (!(size > 0 && size < kHuge)) return false;
    const double inverse = 1 / m[k][k];
    for (int i = k + 1; i < 3; ++i) {
      const double f = m[i][k] * inverse;
      m[i][k] = f;
      for (int j = k + 1; j < 3; ++j) m[i][j] -= f * m[k][j];
    }
    m[k][k] = inverse;
  }
  for (int j = 0; j < 3; ++j) D.column[j] = Vec4{m[0][j], m[1][j], m[2][j], 0};
  pivot = {static_cast<unsigned char>(p[0]), static_cast<unsigned char>(p[1]),
           static_cast<unsigned char>(p[2])};
  return true;
}

// Y <- Y D^-1 = Y U^-1 L^-1 P.
SKERRY_ALWAYS_INLINE void divide_general(Block3& Y, const Block3& D,
                                         const std::array<unsigned char, 3>& pivot) {
  Vec4 z0 = Y.column[0] * D.column[0][0];
  Vec4 z1 = (Y.column[1] - z0 * D.column[1][0]) * D.column[1][1];
  const Vec4 z2 = (Y.column[2] - z0 * D.column[2][0] - z1 * D.column[2][1]) * D.column[2][2];
  z1 -= z2 * D.column[1][2];
  z0 -= z1 * D.column[0][1] + z2 * D.column[0][2];
  Y.column[pivot[0]] = z0;
  Y.column[pivot[1]] = z1;
  Y.column[pivot[2]] = z2;
}

SKERRY_ALWAYS_INLINE void solve_general(const Block3& D, const std::array<unsigned char, 3>& pivot, Vec4& x) {
  double x0 = x[pivot[0]], x1 = x[pivot[1]], x2 = x[pivot[2]];
  x1 -= D.column[0][1] * x0;
  x2 -= D.column[0][2] * x0 + D.column[1][2] * x1;
  x2 *= D.column[2][2];
  x1 = (x1 - D.column[2][1] * x2) * D.column[1][1];
  x0 = (x0 - D.column[1][0] * x1 - D.column[2][0] * x2) * D.column[0][0];
  x = Vec4{x0, x1, x2, 0};
}

}  // namespace

void BlockFactor::set_pattern(const BlockPattern& pattern) {
  pattern_ = &pattern;
  sharing_.clear();
  diagonal_.resize(at(pattern.nodes()));
  resize_large(lower_, at(pattern.blocks()));
  pivot_.resize(at(pattern.nodes()));
  int longest = 0;
  for (int j = 0; j < pattern.nodes(); ++j)
    longest = std::max(longest, pattern.begin_[at(j) + 1] - pattern.begin_[at(j)]);
  column_.resize(at(longest) * kColumns);
}

void BlockFactor::clear(bool general) {
  general_ = general;
  const Block3 zero{};
  std::fill(diagonal_.begin(), diagonal_.end(), zero);
  std::fill(lower_.begin(), lower_.end(), zero);
  if (!general) return;
  reserve_large(upper_, lower_.size());
  upper_.assign(lower_.size(), zero);
}

/// What one of several threads needs for itself.
struct BlockFactor::Scratch {
  std::vector<int> place;       ///< of the blocks of the columns of a panel, one after the other, by row
  std::vector<Block3> columns;  ///< like `column_`
};

/// The loops, compiled for two instruction sets.
struct BlockFactor::Kernels {
  // Places of columns that are alike: blocks of L, and Y (L D, or U^T) in the order of the rows.
  struct Columns {
    const Block3 *L[kColumns], *Y[kColumns];
  };

  // C -= sum of A B^T over the columns, for the places C of the rows from `first` on and before `last`.
  // @param B  one a column @param place  of a row
  template <int kCount, class Place>
  static SKERRY_ALWAYS_INLINE void subtract_sums(Block3* const C, const Block3* const (&A)[kColumns],
                                                 const Block3* const (&B)[kColumns], int first, int last,
                                                 const Place& place) {
    int i = first;
    // Two at a time, so that numbers of B are fetched once for both.
    for (; i + 1 < last; i += 2) {
      Block3 &low = C[place(i)], &high = C[place(i + 1)];
      Vec4 l0 = low.column[0], l1 = low.column[1], l2 = low.column[2];
      Vec4 h0 = high.column[0], h1 = high.column[1], h2 = high.column[2];
      for (int q = 0; q < kCount; ++q) {
        // Otherwise the compiler fetches all of B before the loop, for which there are not registers enough.
        asm volatile("" ::: "memory");
        for (int m = 0; m < 3; ++m) {
          const Vec4 a = A[q][i].column[m], b = A[q][i + 1].column[m];
          const Vec4& with = B[q]->column[m];
          l0 -= a * with[0];
          h0 -= b * with[0];
          l1 -= a * with[1];
          h1 -= b * with[1];
          l2 -= a * with[2];
          h2 -= b * with[2];
        }
      }
      low = {{l0, l1, l2}};
      high = {{h0, h1, h2}};
    }
    if (i < last) {
      Block3 sum = C[place(i)];
      for (int q = 0; q < kCount; ++q) subtract_abt(sum, A[q][i], *B[q]);
      C[place(i)] = sum;
    }
  }

  // What row `k` of `rows` rows is given by the columns: its own column, and the others in it.
  // @param place  of the block of a row in that column
  template <int kCount, bool kGeneral, class Place>
  static SKERRY_ALWAYS_INLINE void subtract_from_column(BlockFactor& f, const Columns& from, int k,
                                                        int column, int rows, const Place& place) {
    const Block3 *L[kColumns], *Y[kColumns];
    for (int q = 0; q < kCount; ++q) {
      L[q] = from.L[q] + k;
      Y[q] = from.Y[q] + k;
    }
    Block3& D = f.diagonal_[at(column)];
    for (int q = 0; q < kCount; ++q) subtract_abt(D, *L[q], *Y[q]);
    subtract_sums<kCount>(f.lower_.data(), from.L, Y, k + 1, rows, place);
    if constexpr (kGeneral) subtract_sums<kCount>(f.upper_.data(), from.Y, L, k + 1, rows, place);
  }

  // To the columns of the first `inside` rows.
  template <int kCount, bool kGeneral>
  static SKERRY_ALWAYS_INLINE void subtract_products(BlockFactor& f, const Columns& from, const int* row,
                                                     int inside, int rows, const int* target) {
    for (int k = 0; k < inside; ++k) {
      subtract_from_column<kCount, kGeneral>(f, from, k, row[k], rows,
                                             [&](int i) { return target[i - k - 1]; });
      target += rows - k - 1;
    }
  }

  // Divides column `j` by its pivot. A symmetric one is kept as it was: the first `inside` blocks at `Y`, the
  // others where they are fetched later.
  template <bool kGeneral>
  static SKERRY_ALWAYS_INLINE bool divide_column(BlockFactor& f, int j, Block3* Y, int inside) {
    const BlockPattern& s = *f.pattern_;
    Block3* const L = f.lower_.data() + s.begin_[at(j)];
    const int size = s.column_size(j);
    Block3& D = f.diagonal_[at(j)];
    if constexpr (kGeneral) {
      if (!factor_general(D, f.pivot_[at(j)])) return false;
      for (int k = 0; k < size; ++k) divide_general(L[k], D, f.pivot_[at(j)]);
    } else {
      if (!factor_symmetric(D)) return false;
      for (int k = 0; k < inside; ++k) {
        Y[k] = L[k];
        divide_symmetric(L[k], D);
      }
      for (int k = inside; k < size; ++k) {
        f.upper_[at(s.begin_[at(j)] + k)] = L[k];
        divide_symmetric(L[k], D);
      }
    }
    return true;
  }

  // Factorises `count` columns from `j` on, which are alike, and subtracts their products from each other and
  // from the columns of the first `inside` rows of the last one. @param scratch  kColumns longest columns
  template <bool kGeneral>
  static SKERRY_ALWAYS_INLINE bool factor_alike(BlockFactor& f, int j, int count, int inside,
                                                std::vector<Block3>& scratch) {
    const BlockPattern& s = *f.pattern_;
    Columns from;
    for (int q = 0; q < count; ++q) {
      const int column = j + q, first = s.begin_[at(column)], next = count - 1 - q;
      Block3* const L = f.lower_.data() + first;
      Block3* const Y =
          kGeneral ? f.upper_.data() + first : scratch.data() + at(q) * (scratch.size() / kColumns);
      if (!divide_column<kGeneral>(f, column, Y, next + inside)) return false;
      // To the other columns alike at once, since they come next.
      const Columns alone{{L}, {Y}};
      subtract_products<1, kGeneral>(f, alone, s.row_.data() + first, next, s.column_size(column),
                                     s.update_.data() + s.update_begin_[at(column)]);
      from.L[q] = L + next;
      from.Y[q] = Y + next;
    }
    const int last = j + count - 1, rows = s.column_size(last);
    const int* const row = s.row_.data() + s.begin_[at(last)];
    const int* const target = s.update_.data() + s.update_begin_[at(last)];
    if (count == 1)
      subtract_products<1, kGeneral>(f, from, row, inside, rows, target);
    else if (count == 2)
      subtract_products<2, kGeneral>(f, from, row, inside, rows, target);
    else if (count == 3)
      subtract_products<3, kGeneral>(f, from, row, inside, rows, target);
    else
      subtract_products<4, kGeneral>(f, from, row, inside, rows, target);
    return true;
  }

  template <bool kGeneral>
  static SKERRY_ALWAYS_INLINE bool factor_all(BlockFactor& f) {
    const BlockPattern& s = *f.pattern_;
    for (int j = 0; j < s.nodes();) {
      const int count = s.alike(j);
      if (!factor_alike<kGeneral>(f, j, count, s.column_size(j + count - 1), f.column_)) return false;
      j += count;
    }
    return true;
  }

  struct Factor {
    static SKERRY_ALWAYS_INLINE bool run(BlockFactor& f) {
      return f.general_ ? factor_all<true>(f) : factor_all<false>(f);
    }
  };

  // One subtree of those that threads share.
  template <bool kGeneral>
  static SKERRY_ALWAYS_INLINE bool factor_subtree(BlockFactor& f, std::span<const int> columns,
                                                  std::vector<Block3>& scratch) {
    const BlockPattern& s = *f.pattern_;
    for (std::size_t k = 0; k < columns.size();) {
      const int j = columns[k];
      const int count = std::min(s.alike(j), columns.back() - j + 1);
      if (!factor_alike<kGeneral>(f, j, count, f.sharing_.inside(j + count - 1), scratch)) return false;
      k += at(count);
    }
    return true;
  }

  // Fetches what `source` subtracts from `column`, whose blocks are at `place`, by row.
  template <int kCount, bool kGeneral>
  static SKERRY_ALWAYS_INLINE void fetch(BlockFactor& f, int column, const BlockSharing::Source& source,
                                         const int* place) {
    const BlockPattern& s = *f.pattern_;
    Columns from;
    for (int q = 0; q < kCount; ++q) {
      const int behind = kCount - 1 - q;
      const std::size_t first = at(s.begin_[at(source.last - behind)] + behind);
      from.L[q] = f.lower_.data() + first;
      from.Y[q] = f.upper_.data() + first;
    }
    const int* const row = s.row_.data() + s.begin_[at(source.last)];
    subtract_from_column<kCount, kGeneral>(f, from, source.k, column, s.column_size(source.last),
                                           [&](int i) { return place[row[i]]; });
  }

  // Some of the columns above the subtrees, `top()[first]` to `top()[last - 1]`. What several of them fetch
  // is fetched for all while it is in the cache. @param finished  units
  template <bool kGeneral>
  static SKERRY_ALWAYS_INLINE bool factor_panel(BlockFactor& f, int first, int last, Scratch& scratch,
                                                std::vector<Progress>& finished) {
    const BlockPattern& s = *f.pattern_;
    const BlockSharing& sharing = f.sharing_;
    std::array<std::span<const BlockSharing::Source>, BlockSharing::kPanel> left;
    for (int i = first; i < last; ++i) {
      const int column = sharing.top()[at(i)];
      int* const place = scratch.place.data() + at(i - first) * at(s.nodes());
      for (int p = s.begin_[at(column)]; p < s.begin_[at(column) + 1]; ++p) place[s.row_[at(p)]] = p;
      left[at(i - first)] = sharing.sources(i);
    }
    for (int done = first; done < last;) {
      // The sources of a column come before it, so it is ready when the next source is not.
      int next = sharing.top()[at(done)];
      for (int i = done; i < last; ++i)
        if (const auto& own = left[at(i - first)]; !own.empty()) next = std::min(next, own.front().last);
      if (next == sharing.top()[at(done)]) {
        if (!divide_column<kGeneral>(f, next, nullptr, 0)) return false;
        finished[at(sharing.subtrees() + done++)].reached(1);
        continue;
      }
      for (int i = done; i < last; ++i) {
        auto& own = left[at(i - first)];
        if (own.empty() || own.front().last != next) continue;
        const int column = sharing.top()[at(i)];
        const int* const place = scratch.place.data() + at(i - first) * at(s.nodes());
        const BlockSharing::Source& source = own.front();
        finished[at(source.unit)].wait_for(1);
        if (source.count == 1)
          fetch<1, kGeneral>(f, column, source, place);
        else if (source.count == 2)
          fetch<2, kGeneral>(f, column, source, place);
        else if (source.count == 3)
          fetch<3, kGeneral>(f, column, source, place);
        else
          fetch<4, kGeneral>(f, column, source, place);
        own = own.subspan(1);
      }
    }
    return true;
  }

  // A task of what threads share: a subtree, or a panel.
  struct FactorTask {
    static SKERRY_ALWAYS_INLINE bool run(BlockFactor& f, int task, Scratch& scratch,
                                         std::vector<Progress>& finished) {
      const int panel = task - f.sharing_.subtrees();
      if (panel < 0) {
        const std::span<const int> columns = f.sharing_.subtree(task);
        return f.general_ ? factor_subtree<true>(f, columns, scratch.columns)
                          : factor_subtree<false>(f, columns, scratch.columns);
      }
      const auto [first, last] = f.sharing_.panel(panel);
      return f.general_ ? factor_panel<true>(f, first, last, scratch, finished)
                        : factor_panel<false>(f, first, last, scratch, finished);
    }
  };

  // Columns by number, all of them or some, ascending.
  static int count(const BlockFactor& f, const Some& some) {
    return some.all ? f.nodes() : static_cast<int>(some.columns.size());
  }
  static int column(const Some& some, int k) { return some.all ? k : some.columns[at(k)]; }

  struct Forward {
    static SKERRY_ALWAYS_INLINE void run(const BlockFactor& f, BodyVector* x, const Some& some, Rows rows) {
      const BlockPattern& s = *f.pattern_;
      const int* row = s.row_.data();
      const Block3* L = f.lower_.data();
      for (int k = 0; k < count(f, some); ++k) {
        const int j = column(some, k);
        const int first = s.begin_[at(j)];
        const int last = rows == Rows::Inside ? first + f.sharing_.inside(j) : s.begin_[at(j) + 1];
        const Vec4 t = x[j].v;
        for (int p = first; p < last; ++p) subtract_av(x[row[p]].v, L[p], t);
      }
    }
  };

  // One part of the rows above the subtrees, whose own columns are solved. A column of an earlier part is
  // waited for.
  struct ForwardPart {
    static SKERRY_ALWAYS_INLINE void run(const BlockFactor& f, BodyVector* x, int part) {
      const int* row = f.pattern_->row_.data();
      const Block3* L = f.lower_.data();
      for (const BlockSharing::Piece& piece : f.sharing_.part(part)) {
        const int of = f.sharing_.part_of(piece.column);
        // As a row it has had all columns before it.
        if (of == part)
          f.passed_[at(part)].reached(piece.column);
        else if (of >= 0)
          f.passed_[at(of)].wait_for(piece.column);
        const Vec4 t = x[piece.column].v;
        for (int p = piece.first; p < piece.end; ++p) subtract_av(x[row[p]].v, L[p], t);
      }
    }
  };

  struct Backward {
    static SKERRY_ALWAYS_INLINE void run(const BlockFactor& f, BodyVector* x, const Some& some) {
      const BlockPattern& s = *f.pattern_;
      const int* row = s.row_.data();
      const Block3* L = f.general_ ? f.upper_.data() : f.lower_.data();
      for (int k = count(f, some) - 1; k >= 0; --k) {
        const int j = column(some, k);
        Vec4 t = x[j].v;
        // Products with transposed blocks: three dot products, summed lane by lane until the end.
        Vec4 s0{}, s1{}, s2{};
        if (!f.general_) solve_symmetric(f.diagonal_[at(j)], t);
        for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p) {
          const Vec4 y = x[row[p]].v;
          s0 += L[p].column[0] * y;
          s1 += L[p].column[1] * y;
          s2 += L[p].column[2] * y;
        }
        t -= Vec4{s0[0] + s0[1] + s0[2], s1[0] + s1[1] + s1[2], s2[0] + s2[1] + s2[2], 0};
        if (f.general_) solve_general(f.diagonal_[at(j)], f.pivot_[at(j)], t);
        x[j].v = t;
      }
    }
  };

  struct SolveUnit {
    static SKERRY_ALWAYS_INLINE void run(const BlockFactor& f, std::span<const int> columns,
                                         const std::vector<int>& slot, int unit, Block3* v) {
      const BlockPattern& s = *f.pattern_;
      const int* row = s.row_.data();
      const Block3* L = f.lower_.data();
      const std::size_t start = at(slot[at(unit)]);
      for (std::size_t k = 0; k < columns.size(); ++k) v[k] = Block3{};
      for (int c = 0; c < 3; ++c) v[start].column[c][c] = 1;
      // Forward along the path from the unit, the other columns stay zero.
      for (int j = unit; j >= 0; j = s.parent(j)) {
        const Block3 t = v[slot[at(j)]];
        for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p)
          subtract_abt(v[slot[at(row[p])]], t, L[p]);
      }
      const Block3* U = f.upper_.data();
      for (std::size_t k = columns.size(); k-- > 0;) {
        const int j = columns[k];
        Block3 t = v[k];
        if (f.general_) {
          for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p)
            subtract_ab(t, v[slot[at(row[p])]], U[p]);
          for (int r = 0; r < 3; ++r) {
            Vec4 x{t.column[0][r], t.column[1][r], t.column[2][r], 0};
            solve_general(f.diagonal_[at(j)], f.pivot_[at(j)], x);
            for (int c = 0; c < 3; ++c) t.column[c][r] = x[c];
          }
        } else {
          divide_symmetric(t, f.diagonal_[at(j)]);
          for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p)
            subtract_ab(t, v[slot[at(row[p])]], L[p]);
        }
        v[k] = t;
      }
    }
  };
};

bool BlockFactor::factor() {
  return run_kernel<Kernels::Factor>(*this);
}

void BlockFactor::fill_column(int column, const FillColumn& fill) {
  const auto begin = pattern_->begin_[at(column)], end = pattern_->begin_[at(column) + 1];
  const Block3 zero{};
  diagonal_[at(column)] = zero;
  std::fill(lower_.begin() + begin, lower_.begin() + end, zero);
  if (general_) std::fill(upper_.begin() + begin, upper_.begin() + end, zero);
  fill.call(fill.it, column);
}

bool BlockFactor::factor(bool general, ThreadPool* threads, const FillColumn& fill) {
  general_ = general;
  if (threads != nullptr && threads->threads() > 1) {
    if (sharing_.threads() != threads->threads()) {
      sharing_.plan(*pattern_, threads->threads());
      finished_ = std::vector<Progress>(sharing_.units());
      passed_ = std::vector<Progress>(at(threads->threads()));
    }
    if (sharing_.pays()) return factor_by(*threads, fill);
  }
  if (general) resize_large(upper_, lower_.size());
  for (int j = 0; j < nodes(); ++j) fill_column(j, fill);
  return factor();
}

// Tasks begin in their order, so those that one waits for have begun.
bool BlockFactor::factor_by(ThreadPool& threads, const FillColumn& fill) {
  resize_large(upper_, lower_.size());
  for (Progress& unit : finished_) unit.reached(0);
  std::atomic<bool> regular = true;
  threads.run(sharing_.tasks(), [&](std::size_t i) {
    const int task = static_cast<int>(i), panel = task - sharing_.subtrees();
    const auto [first, last] = panel < 0 ? std::array{0, 0} : sharing_.panel(panel);
    if (regular) {
      Spare<Scratch> scratch;
      scratch->place.resize(at(nodes()) * BlockSharing::kPanel);
      scratch->columns.resize(column_.size());
      for (int top = first; top < last; ++top) fill_column(sharing_.top()[at(top)], fill);
      if (panel < 0)
        for (const int column : sharing_.subtree(task)) fill_column(column, fill);
      if (!run_kernel<Kernels::FactorTask>(*this, task, *scratch, finished_)) regular = false;
    }
    // Whoever waits need not know that there is nothing to come.
    if (panel < 0) finished_[i].reached(1);
    for (int top = first; top < last; ++top) finished_[at(sharing_.subtrees() + top)].reached(1);
  });
  return regular;
}

void BlockFactor::forward_some(BodyVector* x, const Some& some, Rows rows) const {
  run_kernel<Kernels::Forward>(*this, x, some, rows);
}

void BlockFactor::backward_some(BodyVector* x, const Some& some) const {
  run_kernel<Kernels::Backward>(*this, x, some);
}

void BlockFactor::forward(BodyVector* x, ThreadPool* threads) const {
  if (!shared_by(threads)) return forward_some(x, Some::everything(), Rows::All);
  threads->run(at(sharing_.subtrees()), [&](std::size_t i) {
    forward_some(x, {sharing_.subtree(static_cast<int>(i))}, Rows::Inside);
  });
  // What is done to a row above them comes in the order in which one thread would do it.
  for (Progress& part : passed_) part.reached(-1);
  threads->run(passed_.size(),
               [&](std::size_t i) { run_kernel<Kernels::ForwardPart>(*this, x, static_cast<int>(i)); });
}

void BlockFactor::backward(BodyVector* x, ThreadPool* threads) const {
  if (!shared_by(threads)) return backward_some(x, Some::everything());
  backward_some(x, {sharing_.top()});
  threads->run(at(sharing_.subtrees()),
               [&](std::size_t i) { backward_some(x, {sharing_.subtree(static_cast<int>(i))}); });
}

void BlockFactor::forward(BodyVector* x, const std::vector<int>& columns) const {
  forward_some(x, {columns}, Rows::All);
}

void BlockFactor::backward(BodyVector* x, const std::vector<int>& columns) const {
  backward_some(x, {columns});
}

void BlockFactor::solve(BodyVector* x, ThreadPool* threads) const {
  forward(x, threads);
  backward(x, threads);
}

void BlockFactor::solve_unit(std::span<const int> columns, const std::vector<int>& slot, int unit,
                             Block3* v) const {
  run_kernel<Kernels::SolveUnit>(*this, columns, slot, unit, v);
}

}  // namespace skerry
