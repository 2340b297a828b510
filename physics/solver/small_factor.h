// SPDX-License-Identifier: MIT
//
// The numbers of small islands, one alone or several of one topology side by side, and the block factor of
// their bodies, on the stack.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "physics/solver/simd.h"
#include "physics/solver/small_topology.h"

namespace skerry::small {

// Relative weight of a proximal step: 2 to the minus this. Two steps leave its square.
inline constexpr std::uint64_t kEtaBits = 27;
inline constexpr int kSteps = 2;

// Stands for D of rows along which nothing moves: their impulses leave every bound behind, and only a bound
// explains the velocity that they cannot change.
inline constexpr double kLeastD = 1e-290;

using Lanes2 = double __attribute__((vector_size(16)));
using Lanes8 = double __attribute__((vector_size(64)));

// The numbers of a row: R is a double for one island or as many as there are islands side by side, or four
// for the rows of a group of one island.
template <class R>
struct Slot {
  R Ja[3], Jb[3], b, mu;
  R D, g, lambda;
};

// S is a number of a body, R one of a slot.
template <class Scalar, class Row, int slots>
struct Numbers {
  using S = Scalar;
  using R = Row;
  Slot<R> slot[slots];
  S inverse_mass[kSmallBodies][3];
  S residual;
};
using OneIsland = Numbers<double, Vec4, kGroups>;
using OneGroup = Numbers<double, double, kTogether>;  // the only one of an island
template <class V>
using Islands = Numbers<V, V, kGroups * kTogether>;

// Eight islands, in vectors of the width that the processor has.
union alignas(64) EightIslands {
  Islands<Lanes2> two[4];
  Islands<Vec4> four[2];
  Islands<Lanes8> eight;
};

// m <- max(m, x)
template <class T>
SKERRY_ALWAYS_INLINE void raise(T& m, const T& x) {
  m = x > m ? x : m;
}
template <class T>
SKERRY_ALWAYS_INLINE void clamp_to(T& x, const T& lower, const T& upper) {
  x = x < lower ? lower : x;
  x = x > upper ? upper : x;
}

// Numbers as bits.
template <class T>
struct BitsOf;
template <>
struct BitsOf<double> {
  using Type = std::uint64_t;
};
template <>
struct BitsOf<Lanes2> {
  using Type = std::uint64_t __attribute__((vector_size(16)));
};
template <>
struct BitsOf<Vec4> {
  using Type = std::uint64_t __attribute__((vector_size(32)));
};
template <>
struct BitsOf<Lanes8> {
  using Type = std::uint64_t __attribute__((vector_size(64)));
};
template <class T>
SKERRY_ALWAYS_INLINE void get_bits(const T& x, typename BitsOf<T>::Type& bits) {
  std::memcpy(&bits, &x, sizeof(T));
}
template <class T>
SKERRY_ALWAYS_INLINE void set_bits(T& x, const typename BitsOf<T>::Type& bits) {
  std::memcpy(&x, &bits, sizeof(T));
}

template <class T>
SKERRY_ALWAYS_INLINE void make_absolute(T& x) {
  typename BitsOf<T>::Type bits;
  get_bits(x, bits);
  set_bits(x, bits & ~(std::uint64_t{1} << 63));
}

// The weight of a row, about 1 / (eta D): any positive number near it serves, and the bits of D taken from a
// constant are one within 6 %, without a division.
template <class R>
SKERRY_ALWAYS_INLINE void weigh(const R& D, R& g) {
  constexpr std::uint64_t kReciprocal = 0x7FDE6238502484BA, kEta = kEtaBits << 52;
  typename BitsOf<R>::Type bits;
  get_bits(D, bits);
  set_bits(g, (kReciprocal + kEta) - bits);
}

// Three sums over the rows of a group, always in the same order; rows that are not there count as zero.
template <class T, int n>
SKERRY_ALWAYS_INLINE void add_up(const T (&x)[3][n], T (&sum)[3]) {
  for (int k = 0; k < 3; ++k) {
    if constexpr (n == 2)
      sum[k] = x[k][0] + x[k][1];
    else
      sum[k] = (x[k][0] + x[k][1]) + (x[k][2] + x[k][3]);
  }
}
SKERRY_ALWAYS_INLINE void add_up(const Vec4 (&x)[3][1], double (&sum)[3]) {
  const Vec4 &a = x[0][0], &b = x[1][0], &c = x[2][0];
  const Vec4 ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Vec4 cc = __builtin_shufflevector(c, c, 0, 4, 2, 6) + __builtin_shufflevector(c, c, 1, 5, 3, 7);
  const Lanes2 first = __builtin_shufflevector(ab, ab, 0, 1) + __builtin_shufflevector(ab, ab, 2, 3);
  const Lanes2 last = __builtin_shufflevector(cc, cc, 0, 1) + __builtin_shufflevector(cc, cc, 2, 3);
  sum[0] = first[0];
  sum[1] = first[1];
  sum[2] = last[0];
}

// u = J v of one slot.
template <bool grounded, class R, class S>
SKERRY_ALWAYS_INLINE void velocity_along(const Slot<R>& slot, const S* va, const S* vb, R& u) {
  u = slot.Jb[0] * vb[0] + slot.Jb[1] * vb[1] + slot.Jb[2] * vb[2];
  if constexpr (!grounded) u += slot.Ja[0] * va[0] + slot.Ja[1] * va[1] + slot.Ja[2] * va[2];
}

// Block LDL^T of the body graph in natural order, on the stack.
template <class S, int most>
struct SmallFactor {
  S diagonal[most][6];        // lower triangle by rows, without M; then inverse pivots and multipliers
  S block[most][most][3][3];  // below the diagonal, row by column; [i][j] with i > j

  SKERRY_ALWAYS_INLINE void clear(const Topology& t) {
    for (int j = 0; j < (most == 1 ? 1 : t.bodies); ++j) {
      for (S& d : diagonal[j]) d = S{};
      if constexpr (most == 1) return;
      for (unsigned rest = t.below[at(j)]; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) block[i][j][r][c] = S{};
      }
    }
  }

  // 1 / (1 / m + x)
  static SKERRY_ALWAYS_INLINE void invert(const S& m, const S& x, S& inverse) { inverse = m / (m * x + 1.0); }

  SKERRY_ALWAYS_INLINE void factor(const Topology& t, const S (&inverse_mass)[kSmallBodies][3]) {
    for (int j = 0; j < (most == 1 ? 1 : t.bodies); ++j) {
      S(&d)[6] = diagonal[j];
      const S(&m)[3] = inverse_mass[j];
      S i0, i1, i2;
      invert(m[0], d[0], i0);
      const S l10 = d[1] * i0, l20 = d[3] * i0;
      invert(m[1], d[2] - l10 * d[1], i1);
      const S e = d[4] - l20 * d[1], l21 = e * i1;
      invert(m[2], (d[5] - l20 * d[3]) - l21 * e, i2);
      d[0] = i0;
      d[1] = l10;
      d[2] = i1;
      d[3] = l20;
      d[4] = l21;
      d[5] = i2;
      if constexpr (most > 1) {
        for (unsigned rest = t.below[at(j)]; rest; rest &= rest - 1) {
          const int i = std::countr_zero(rest);
          S(&X)[3][3] = block[i][j];
          S Y[3][3];
          for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) Y[r][c] = X[r][c];
            // A row of L is Y D^-1.
            solve_diagonal(d, X[r]);
          }
          // L_kj Y_ij^T = Y_kj D^-1 Y_ij^T: of column i itself the lower triangle.
          for (int r = 0; r < 3; ++r)
            for (int c = 0; c <= r; ++c)
              diagonal[i][r * (r + 1) / 2 + c] -= X[r][0] * Y[c][0] + X[r][1] * Y[c][1] + X[r][2] * Y[c][2];
          // The blocks below it still hold their Y.
          for (unsigned left = rest & (rest - 1); left; left &= left - 1) {
            const int k = std::countr_zero(left);
            for (int r = 0; r < 3; ++r)
              for (int c = 0; c < 3; ++c)
                block[k][i][r][c] -=
                    block[k][j][r][0] * X[c][0] + block[k][j][r][1] * X[c][1] + block[k][j][r][2] * X[c][2];
          }
        }
      }
    }
  }

  static SKERRY_ALWAYS_INLINE void solve_diagonal(const S (&d)[6], S (&x)[3]) {
    const S x1 = x[1] - d[1] * x[0], x2 = (x[2] - d[3] * x[0]) - d[4] * x1;
    x[2] = x2 * d[5];
    x[1] = x1 * d[2] - d[4] * x[2];
    x[0] = (x[0] * d[0] - d[3] * x[2]) - d[1] * x[1];
  }

  SKERRY_ALWAYS_INLINE void solve(const Topology& t, S (&x)[most][3]) const {
    if constexpr (most == 1) {
      solve_diagonal(diagonal[0], x[0]);
    } else {
      for (int j = 0; j < t.bodies; ++j) {
        for (unsigned rest = t.below[at(j)]; rest; rest &= rest - 1) {
          const int i = std::countr_zero(rest);
          for (int r = 0; r < 3; ++r)
            x[i][r] -=
                block[i][j][r][0] * x[j][0] + block[i][j][r][1] * x[j][1] + block[i][j][r][2] * x[j][2];
        }
        solve_diagonal(diagonal[j], x[j]);
      }
      for (int j = t.bodies - 1; j >= 0; --j)
        for (unsigned rest = t.below[at(j)]; rest; rest &= rest - 1) {
          const int i = std::countr_zero(rest);
          for (int c = 0; c < 3; ++c)
            x[j][c] -=
                block[i][j][0][c] * x[i][0] + block[i][j][1][c] * x[i][1] + block[i][j][2][c] * x[i][2];
        }
    }
  }
};

}  // namespace skerry::small
