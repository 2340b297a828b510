// SPDX-License-Identifier: MIT
#include "physics/solver/block_ldlt.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/spare.h"

namespace skerry {
namespace {

// Pivots beyond this are overflow in the making.
constexpr double kHuge = 1e200;

// Columns whose products are subtracted together.
constexpr int kColumns = 4;

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

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

namespace {

// What an analysis needs for a moment.
struct AnalysisVectors {
  std::vector<int> start, neighbour, fill, finish, mark, first_child, next_child;
};

}  // namespace

void BlockPattern::analyse(int nodes, std::span<const std::array<int, 2>> edges) {
  const std::size_t n = at(nodes);
  // Adjacency in compressed form, both directions, sorted, without repeats.
  Spare<AnalysisVectors> vectors;
  std::vector<int>&start = vectors->start, &neighbour = vectors->neighbour, &fill = vectors->fill,
  &finish = vectors->finish;
  start.assign(n + 1, 0);
  neighbour.resize(2 * edges.size());
  for (const auto& e : edges) {
    ++start[at(e[0]) + 1];
    ++start[at(e[1]) + 1];
  }
  for (std::size_t i = 0; i < n; ++i) start[i + 1] += start[i];
  fill.assign(start.begin(), start.end() - 1);
  for (const auto& e : edges) {
    neighbour[at(fill[at(e[0])]++)] = e[1];
    neighbour[at(fill[at(e[1])]++)] = e[0];
  }
  finish.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto first = neighbour.begin() + start[i], last = neighbour.begin() + start[i + 1];
    std::sort(first, last);
    finish[i] = static_cast<int>(std::unique(first, last) - neighbour.begin());
  }

  // Fill-reducing order; a handful of nodes needs none.
  order_.resize(n);
  position_.resize(n);
  for (std::size_t i = 0; i < n; ++i) order_[i] = static_cast<int>(i);
  if (nodes > 3) {
    Eigen::SparseMatrix<double> graph(nodes, nodes);
    std::size_t entries = n;
    for (std::size_t i = 0; i < n; ++i) entries += at(finish[i] - start[i]);
    graph.reserve(static_cast<Eigen::Index>(entries));
    for (std::size_t j = 0; j < n; ++j) {
      const int column = static_cast<int>(j);
      graph.startVec(column);
      bool diagonal = false;
      for (int p = start[j]; p < finish[j]; ++p) {
        if (!diagonal && neighbour[at(p)] > column) {
          graph.insertBack(column, column) = 1;
          diagonal = true;
        }
        graph.insertBack(neighbour[at(p)], column) = 1;
      }
      if (!diagonal) graph.insertBack(column, column) = 1;
    }
    graph.finalize();
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
    Eigen::AMDOrdering<int>()(graph, permutation);
    for (std::size_t i = 0; i < n; ++i) order_[i] = permutation.indices()[static_cast<Eigen::Index>(i)];
  }
  for (std::size_t i = 0; i < n; ++i) position_[at(order_[i])] = static_cast<int>(i);

  // Structure of L: column j has its own neighbours and what its children in the elimination tree hand up.
  std::vector<int>&mark = vectors->mark, &first_child = vectors->first_child,
  &next_child = vectors->next_child;
  for (std::vector<int>* list : {&mark, &first_child, &next_child}) list->assign(n, -1);
  begin_.assign(n + 1, 0);
  row_.clear();
  for (std::size_t j = 0; j < n; ++j) {
    const int column = static_cast<int>(j);
    mark[j] = column;
    const std::size_t first = row_.size();
    const std::size_t node = at(order_[j]);
    for (int p = start[node]; p < finish[node]; ++p) {
      const int i = position_[at(neighbour[at(p)])];
      if (i > column && mark[at(i)] != column) {
        mark[at(i)] = column;
        row_.push_back(i);
      }
    }
    for (int child = first_child[j]; child >= 0; child = next_child[at(child)])
      for (int p = begin_[at(child)]; p < begin_[at(child) + 1]; ++p) {
        const int i = row_[at(p)];
        if (mark[at(i)] != column) {
          mark[at(i)] = column;
          row_.push_back(i);
        }
      }
    std::sort(row_.begin() + static_cast<std::ptrdiff_t>(first), row_.end());
    begin_[j + 1] = static_cast<int>(row_.size());
    if (row_.size() > first) {
      const std::size_t parent = at(row_[first]);
      next_child[j] = first_child[parent];
      first_child[parent] = column;
    }
  }

  // Where the outer product of each column goes.
  update_begin_.assign(n + 1, 0);
  for (std::size_t j = 0; j < n; ++j) {
    const std::int64_t d = begin_[j + 1] - begin_[j];
    update_begin_[j + 1] = update_begin_[j] + d * (d - 1) / 2;
  }
  update_.resize(static_cast<std::size_t>(update_begin_[n]));
  int* target = update_.data();
  for (std::size_t j = 0; j < n; ++j)
    for (int k = begin_[j]; k < begin_[j + 1]; ++k) {
      int p = begin_[at(row_[at(k)])];
      for (int i = k + 1; i < begin_[j + 1]; ++i) {
        while (row_[at(p)] < row_[at(i)]) ++p;
        *target++ = p;
      }
    }
}

int BlockPattern::block(int low, int high) const {
  const auto first = row_.begin() + begin_[at(low)], last = row_.begin() + begin_[at(low) + 1];
  const auto it = std::lower_bound(first, last, high);
  return it != last && *it == high ? static_cast<int>(it - row_.begin()) : -1;
}

void BlockFactor::set_pattern(const BlockPattern& pattern) {
  pattern_ = &pattern;
  diagonal_.resize(at(pattern.nodes()));
  lower_.resize(at(pattern.blocks()));
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
  if (general) upper_.assign(lower_.size(), zero);
}

/// The loops, compiled for two instruction sets.
struct BlockFactor::Kernels {
  // Columns from `j` on, at most kColumns, each of which has the rows of the one before without the first:
  // what they take away from a block is subtracted while that is at hand.
  static SKERRY_ALWAYS_INLINE int alike(const BlockPattern& s, int j) {
    int count = 1;
    while (count < kColumns && s.column_size(j + count - 1) > 0 && s.parent(j + count - 1) == j + count &&
           s.column_size(j + count) + 1 == s.column_size(j + count - 1))
      ++count;
    return count;
  }

  // Places of columns that are alike: blocks, and Y (symmetric: L D) in the order of the rows.
  struct Columns {
    Block3 *L[kColumns], *Y[kColumns];
  };

  template <int kCount, bool kGeneral>
  static SKERRY_ALWAYS_INLINE void subtract_products(BlockFactor& f, const Columns& from, const int* row,
                                                     int rows, const int* target) {
    Block3* L = f.lower_.data();
    Block3* U = f.upper_.data();
    for (int k = 0; k < rows; ++k) {
      Block3& D = f.diagonal_[at(row[k])];
      for (int q = 0; q < kCount; ++q) {
        if constexpr (kGeneral)
          subtract_ab(D, from.L[q][k], from.Y[q][k]);
        else
          subtract_abt(D, from.L[q][k], from.Y[q][k]);
      }
      for (int i = k + 1; i < rows; ++i) {
        const int t = *target++;
        Block3 C = L[t];
        for (int q = 0; q < kCount; ++q) {
          if constexpr (kGeneral)
            subtract_ab(C, from.L[q][i], from.Y[q][k]);
          else
            subtract_abt(C, from.L[q][i], from.Y[q][k]);
        }
        L[t] = C;
        if constexpr (kGeneral) {
          C = U[t];
          for (int q = 0; q < kCount; ++q) subtract_ab(C, from.L[q][k], from.Y[q][i]);
          U[t] = C;
        }
      }
    }
  }

  template <bool kGeneral>
  static SKERRY_ALWAYS_INLINE bool factor_loop(BlockFactor& f) {
    const BlockPattern& s = *f.pattern_;
    const int* row = s.row_.data();
    const int* target = s.update_.data();
    const std::size_t longest = f.column_.size() / kColumns;
    Columns from;
    for (int j = 0; j < s.nodes();) {
      const int count = alike(s, j);
      for (int q = 0; q < count; ++q) {
        const int column = j + q, first = s.begin_[at(column)], d = s.column_size(column);
        Block3* const L = f.lower_.data() + first;
        Block3* const Y = kGeneral ? f.upper_.data() + first : f.column_.data() + at(q) * longest;
        Block3& D = f.diagonal_[at(column)];
        if constexpr (kGeneral) {
          if (!factor_general(D, f.pivot_[at(column)])) return false;
          for (int k = 0; k < d; ++k) divide_general(L[k], D, f.pivot_[at(column)]);
        } else {
          if (!factor_symmetric(D)) return false;
          for (int k = 0; k < d; ++k) {
            Y[k] = L[k];
            divide_symmetric(L[k], D);
          }
        }
        // To the other columns alike at once, since they come next.
        const int next = count - 1 - q;
        for (int k = 0; k < next; ++k) {
          Block3& to = f.diagonal_[at(row[first + k])];
          if constexpr (kGeneral)
            subtract_ab(to, L[k], Y[k]);
          else
            subtract_abt(to, L[k], Y[k]);
          for (int i = k + 1; i < d; ++i) {
            const int t = *target++;
            if constexpr (kGeneral) {
              subtract_ab(f.lower_[at(t)], L[i], Y[k]);
              subtract_ab(f.upper_[at(t)], L[k], Y[i]);
            } else {
              subtract_abt(f.lower_[at(t)], L[i], Y[k]);
            }
          }
        }
        from.L[q] = L + next;
        from.Y[q] = Y + next;
        if (next > 0) target += at(d - next) * at(d - next - 1) / 2;
      }
      const int last = j + count - 1, rows = s.column_size(last);
      const int* const below = row + s.begin_[at(last)];
      if (count == 1)
        subtract_products<1, kGeneral>(f, from, below, rows, target);
      else if (count == 2)
        subtract_products<2, kGeneral>(f, from, below, rows, target);
      else if (count == 3)
        subtract_products<3, kGeneral>(f, from, below, rows, target);
      else
        subtract_products<4, kGeneral>(f, from, below, rows, target);
      target += at(rows) * at(rows - 1) / 2;
      j += count;
    }
    return true;
  }

  static SKERRY_ALWAYS_INLINE void forward_loop(const BlockFactor& f, BodyVector* x,
                                                const std::vector<int>* columns) {
    const BlockPattern& s = *f.pattern_;
    const int* row = s.row_.data();
    const Block3* L = f.lower_.data();
    const int count = columns ? static_cast<int>(columns->size()) : s.nodes();
    for (int k = 0; k < count; ++k) {
      const int j = columns ? (*columns)[at(k)] : k;
      const Vec4 t = x[j].v;
      for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p) subtract_av(x[row[p]].v, L[p], t);
    }
  }

  static SKERRY_ALWAYS_INLINE void backward_loop(const BlockFactor& f, BodyVector* x,
                                                 const std::vector<int>* columns) {
    const BlockPattern& s = *f.pattern_;
    const int* row = s.row_.data();
    const Block3* L = f.lower_.data();
    const Block3* U = f.upper_.data();
    for (int k = (columns ? static_cast<int>(columns->size()) : s.nodes()) - 1; k >= 0; --k) {
      const int j = columns ? (*columns)[at(k)] : k;
      Vec4 t = x[j].v;
      if (f.general_) {
        for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p) subtract_av(t, U[p], x[row[p]].v);
        solve_general(f.diagonal_[at(j)], f.pivot_[at(j)], t);
        x[j].v = t;
        continue;
      }
      // Products with L^T: three dot products, summed lane by lane until the end.
      Vec4 s0{}, s1{}, s2{};
      solve_symmetric(f.diagonal_[at(j)], t);
      for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p) {
        const Vec4 y = x[row[p]].v;
        s0 += L[p].column[0] * y;
        s1 += L[p].column[1] * y;
        s2 += L[p].column[2] * y;
      }
      x[j].v = t - Vec4{s0[0] + s0[1] + s0[2], s1[0] + s1[1] + s1[2], s2[0] + s2[1] + s2[2], 0};
    }
  }

  static SKERRY_ALWAYS_INLINE void solve_unit_loop(const BlockFactor& f, std::span<const int> columns,
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
      for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p) subtract_abt(v[slot[at(row[p])]], t, L[p]);
    }
    const Block3* U = f.upper_.data();
    for (std::size_t k = columns.size(); k-- > 0;) {
      const int j = columns[k];
      Block3 t = v[k];
      if (f.general_) {
        for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p)
          subtract_abt(t, v[slot[at(row[p])]], U[p]);
        for (int r = 0; r < 3; ++r) {
          Vec4 x{t.column[0][r], t.column[1][r], t.column[2][r], 0};
          solve_general(f.diagonal_[at(j)], f.pivot_[at(j)], x);
          for (int c = 0; c < 3; ++c) t.column[c][r] = x[c];
        }
      } else {
        divide_symmetric(t, f.diagonal_[at(j)]);
        for (int p = s.begin_[at(j)]; p < s.begin_[at(j) + 1]; ++p) subtract_ab(t, v[slot[at(row[p])]], L[p]);
      }
      v[k] = t;
    }
  }

  static void solve_unit_portable(const BlockFactor& f, std::span<const int> columns,
                                  const std::vector<int>& slot, int unit, Block3* v) {
    solve_unit_loop(f, columns, slot, unit, v);
  }
  SKERRY_AVX2 static void solve_unit_avx2(const BlockFactor& f, std::span<const int> columns,
                                          const std::vector<int>& slot, int unit, Block3* v) {
    solve_unit_loop(f, columns, slot, unit, v);
  }
  static bool factor_portable(BlockFactor& f) {
    return f.general_ ? factor_loop<true>(f) : factor_loop<false>(f);
  }
  SKERRY_AVX2 static bool factor_avx2(BlockFactor& f) {
    return f.general_ ? factor_loop<true>(f) : factor_loop<false>(f);
  }
  using Some = const std::vector<int>*;
  static void forward_portable(const BlockFactor& f, BodyVector* x, Some c) { forward_loop(f, x, c); }
  SKERRY_AVX2 static void forward_avx2(const BlockFactor& f, BodyVector* x, Some c) { forward_loop(f, x, c); }
  static void backward_portable(const BlockFactor& f, BodyVector* x, Some c) { backward_loop(f, x, c); }
  SKERRY_AVX2 static void backward_avx2(const BlockFactor& f, BodyVector* x, Some c) {
    backward_loop(f, x, c);
  }
};

bool BlockFactor::factor() {
  return cpu_has_avx2() ? Kernels::factor_avx2(*this) : Kernels::factor_portable(*this);
}

void BlockFactor::forward(BodyVector* x, const std::vector<int>* columns) const {
  if (cpu_has_avx2())
    Kernels::forward_avx2(*this, x, columns);
  else
    Kernels::forward_portable(*this, x, columns);
}

void BlockFactor::backward(BodyVector* x, const std::vector<int>* columns) const {
  if (cpu_has_avx2())
    Kernels::backward_avx2(*this, x, columns);
  else
    Kernels::backward_portable(*this, x, columns);
}

void BlockFactor::solve(BodyVector* x) const {
  forward(x);
  backward(x);
}

void BlockFactor::solve_unit(std::span<const int> columns, const std::vector<int>& slot, int unit,
                             Block3* v) const {
  if (cpu_has_avx2())
    Kernels::solve_unit_avx2(*this, columns, slot, unit, v);
  else
    Kernels::solve_unit_portable(*this, columns, slot, unit, v);
}

}  // namespace skerry
