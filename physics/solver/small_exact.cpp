// SPDX-License-Identifier: MIT
#include "physics/solver/small_exact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "physics/solver/body_space.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/simd.h"
#include "physics/spare.h"

#if defined(__x86_64__)
#define SKERRY_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl")))
#else
#define SKERRY_AVX512
#endif

// Of a lambda.
#define SKERRY_INLINED __attribute__((always_inline))

namespace skerry {
namespace {

// Relative weight of a proximal step: 2 to the minus this. Two steps leave its square.
constexpr std::uint64_t kEtaBits = 27;
constexpr int kSteps = 2;

// Stands for D of rows along which nothing moves: their impulses leave every bound behind, and only a bound
// explains the velocity that they cannot change.
constexpr double kLeastD = 1e-290;

// Rows of a pair of bodies that are taken together, and the most such groups: the plane graph of eight bodies
// and the ground has 21 edges.
constexpr int kTogether = 4;
constexpr int kGroups = 24;

using Vec2 = double __attribute__((vector_size(16)));
using Vec8 = double __attribute__((vector_size(64)));

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// What bounds the rows of a group.
enum class Bounds : signed char {
  Normal,    // zero
  Joint,     // nothing
  Contacts,  // normal rows, each followed by its friction
  Mixed
};

// Up to four successive rows between two bodies.
struct Group {
  signed char a, b;          // a < b; a is -1 for the ground
  signed char first, count;  // rows
  signed char slot;          // of the first row where each has its own: two or four of them
  Bounds bounds;

  bool operator==(const Group&) const = default;
  int slots() const { return count > 2 ? 4 : 2; }
};

// In place of the row whose impulse bounds this one.
constexpr signed char kNormalRow = -1, kJointRow = -2;

// What islands must share to be solved side by side. (Nothing has initial values: setting what is not there
// would cost a box a tenth of its time.)
struct Topology {
  int bodies, rows, groups, slots;
  std::array<unsigned, kSmallBodies> below;  // rows of each column of the factor, as bits
  std::array<Group, kGroups> group;          // the first `groups` are set
  // Of each row: what bounds it, its group and its place in it.
  std::array<signed char, kSmallRows> normal, group_of, lane;
  // Every body stands on one edge of an earlier one, or of the ground: which group that is. Set where
  // `tower`.
  bool tower;
  std::array<signed char, kSmallBodies> support;

  bool operator==(const Topology& o) const {
    return bodies == o.bodies && rows == o.rows && groups == o.groups && tower == o.tower &&
           std::equal(group.begin(), group.begin() + groups, o.group.begin()) &&
           (tower || std::equal(normal.begin(), normal.begin() + rows, o.normal.begin()));
  }
};

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
  Islands<Vec2> two[4];
  Islands<Vec4> four[2];
  Islands<Vec8> eight;
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
struct BitsOf<Vec2> {
  using Type = std::uint64_t __attribute__((vector_size(16)));
};
template <>
struct BitsOf<Vec4> {
  using Type = std::uint64_t __attribute__((vector_size(32)));
};
template <>
struct BitsOf<Vec8> {
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
  const Vec2 first = __builtin_shufflevector(ab, ab, 0, 1) + __builtin_shufflevector(ab, ab, 2, 3);
  const Vec2 last = __builtin_shufflevector(cc, cc, 0, 1) + __builtin_shufflevector(cc, cc, 2, 3);
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

// Sticks everything, then judges by the natural map. One body with one group of rows, in `only` slots, the
// most frequent island of all, stays in registers; 0: any number of groups.
template <class N, int most, int only>
class Sticking {
 public:
  using S = typename N::S;
  using R = typename N::R;
  using Vector = S[most][3];

  SKERRY_ALWAYS_INLINE Sticking(const Topology& t, N& n) : t_(t), n_(n) {}

  SKERRY_ALWAYS_INLINE void run() {
    SmallFactor<S, most> factor;
    Vector x, v;
    if constexpr (!one_group) factor.clear(t_);
    clear(x);
    each([&](auto rows, auto grounded, const Group& group, Slot<R>* slot)
             SKERRY_INLINED { begin<rows, grounded>(group, slot, factor, x); });
    factor.factor(t_, n_.inverse_mass);
    factor.solve(t_, x);
    clear(v);
    each([&](auto rows, auto grounded, const Group& group, Slot<R>* slot)
             SKERRY_INLINED { take_first<rows, grounded>(group, slot, x, v); });
    scale(v);
    clear(x);
    each([&](auto rows, auto grounded, const Group& group, Slot<R>* slot)
             SKERRY_INLINED { go_on<rows, grounded>(group, slot, v, x); });
    factor.solve(t_, x);
    clear(v);
    each([&](auto rows, auto grounded, const Group& group, Slot<R>* slot)
             SKERRY_INLINED { take_last<rows, grounded>(group, slot, x, v); });
    scale(v);
    verdict(v);
  }

  // Of a tower: as `stick_edge`, upwards for the velocities and downwards for the impulses.
  SKERRY_ALWAYS_INLINE void run_tower() {
    Vector v, force;
    S apart[most];
    for (int j = 0; j < t_.bodies; ++j)
      at_support(j, [&](auto rows, auto grounded, const Group& group, Slot<R>* slot)
                        SKERRY_INLINED { open_edge<rows, grounded>(group, slot, apart); });
    for (int j = 0; j < t_.bodies; ++j)
      at_support(j, [&](auto rows, auto grounded, const Group& group, Slot<R>* slot)
                        SKERRY_INLINED { carry<rows, grounded>(group, slot, apart, v, force); });
    for (int j = t_.bodies - 1; j >= 0; --j)
      at_support(j, [&](auto rows, auto grounded, const Group& group, Slot<R>* slot)
                        SKERRY_INLINED { bear<rows, grounded>(group, slot, apart, force); });
    clear(v);
    each([&](auto rows, auto grounded, const Group& group, Slot<R>* slot) SKERRY_INLINED {
      R z[rows];
      for (int i = 0; i < rows; ++i) z[i] = slot[i].lambda;
      settle<grounded>(group, slot, z, v);
    });
    scale(v);
    verdict(v);
  }

 private:
  static constexpr bool one_group = only > 0;
  static constexpr bool kLanes = sizeof(R) > sizeof(S);  // the rows of a group stand in the lanes of a slot
  template <int n>
  using Const = std::integral_constant<int, n>;

  template <class F>
  SKERRY_ALWAYS_INLINE void each(F&& f) {
    for (int k = 0; k < (one_group ? 1 : t_.groups); ++k) {
      const Group& group = t_.group[at(k)];
      Slot<R>* const slot = n_.slot + (kLanes ? k : group.slot);
      const bool grounded = most == 1 || group.a < 0;
      if constexpr (one_group)
        f(Const<only>{}, std::true_type{}, group, slot);
      else if (kLanes)
        choose<1>(grounded, f, group, slot);
      else if (group.slots() == 2)
        choose<2>(grounded, f, group, slot);
      else
        choose<4>(grounded, f, group, slot);
    }
  }
  // The same for the group under body j of a tower.
  template <class F>
  SKERRY_ALWAYS_INLINE void at_support(int j, F&& f) {
    const int k = t_.support[at(j)];
    const Group& group = t_.group[at(k)];
    choose<kLanes ? 1 : 4>(group.a < 0, f, group, n_.slot + (kLanes ? k : group.slot));
  }
  template <int n, class F>
  SKERRY_ALWAYS_INLINE static void choose(bool grounded, F&& f, const Group& group, Slot<R>* slot) {
    if constexpr (kLanes == (n == 1)) {
      if (grounded)
        f(Const<n>{}, std::true_type{}, group, slot);
      else if constexpr (most > 1)
        f(Const<n>{}, std::false_type{}, group, slot);
    }
  }

  SKERRY_ALWAYS_INLINE void clear(Vector& x) const {
    if constexpr (one_group) return;
    for (int j = 0; j < (most == 1 ? 1 : t_.bodies); ++j)
      for (int c = 0; c < 3; ++c) x[j][c] = S{};
  }
  SKERRY_ALWAYS_INLINE void scale(Vector& v) const {
    for (int j = 0; j < (most == 1 ? 1 : t_.bodies); ++j)
      for (int c = 0; c < 3; ++c) v[j][c] *= n_.inverse_mass[j][c];
  }
  // to += x, which is all there is where there is one group.
  SKERRY_ALWAYS_INLINE static void add(const S& x, S& to) {
    if constexpr (one_group)
      to = x;
    else
      to += x;
  }
  template <bool grounded>
  SKERRY_ALWAYS_INLINE static int a(const Group& group) {
    return grounded ? 0 : group.a;
  }
  SKERRY_ALWAYS_INLINE static int b(const Group& group) { return most == 1 ? 0 : group.b; }

  // Adds three sums over the slots of a group.
  template <int n>
  SKERRY_ALWAYS_INLINE static void add_three(const R (&x)[3][n], S* to) {
    S sum[3];
    add_up(x, sum);
    for (int k = 0; k < 3; ++k) add(sum[k], to[k]);
  }

  // sum += J^T z over the slots of a group.
  template <bool grounded, int n>
  SKERRY_ALWAYS_INLINE static void add_impulses(const Slot<R>* slot, const R (&z)[n], S* sum_a, S* sum_b) {
    R x[3][n];
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < n; ++i) x[k][i] = slot[i].Jb[k] * z[i];
    add_three(x, sum_b);
    if constexpr (!grounded) {
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < n; ++i) x[k][i] = slot[i].Ja[k] * z[i];
      add_three(x, sum_a);
    }
  }

  // The share of one body in H = M + J^T g J, and the first impulses on it; s is g J.
  template <int n>
  SKERRY_ALWAYS_INLINE static void begin_body(const Slot<R>* slot, const R (Slot<R>::*J)[3],
                                              const R (&s)[3][n], S (&diagonal)[6], S* x) {
    R upper[3][n], lower[3][n], push[3][n];
    for (int i = 0; i < n; ++i) {
      const R(&Ji)[3] = slot[i].*J;
      upper[0][i] = s[0][i] * Ji[0];
      upper[1][i] = s[1][i] * Ji[0];
      upper[2][i] = s[1][i] * Ji[1];
      for (int c = 0; c < 3; ++c) lower[c][i] = s[2][i] * Ji[c];
      for (int c = 0; c < 3; ++c) push[c][i] = s[c][i] * slot[i].b;
    }
    add_three(upper, diagonal);
    add_three(lower, diagonal + 3);
    add_three(push, x);
  }

  template <int n, bool grounded>
  SKERRY_ALWAYS_INLINE void begin(const Group& group, Slot<R>* slot, SmallFactor<S, most>& factor,
                                  Vector& x) {
    const int ia = a<grounded>(group), ib = b(group);
    R s[3][n];
    for (int i = 0; i < n; ++i) {
      measure<grounded>(group, slot[i]);
      weigh(slot[i].D, slot[i].g);
      for (int c = 0; c < 3; ++c) s[c][i] = slot[i].g * slot[i].Jb[c];
    }
    begin_body(slot, &Slot<R>::Jb, s, factor.diagonal[ib], x[ib]);
    if constexpr (!grounded) {
      for (int r = 0; r < 3; ++r) {
        R row[3][n];
        for (int c = 0; c < 3; ++c)
          for (int i = 0; i < n; ++i) row[c][i] = s[r][i] * slot[i].Ja[c];
        add_three(row, factor.block[ib][ia][r]);
      }
      for (int c = 0; c < 3; ++c)
        for (int i = 0; i < n; ++i) s[c][i] = slot[i].g * slot[i].Ja[c];
      begin_body(slot, &Slot<R>::Ja, s, factor.diagonal[ia], x[ia]);
    }
  }

  // Four rows of a group, one by one.
  template <int n>
  SKERRY_ALWAYS_INLINE static void unpack(const R (&x)[n], S (&to)[4]) {
    for (int i = 0; i < 4; ++i) {
      if constexpr (kLanes)
        to[i] = x[0][i];
      else
        to[i] = x[i];
    }
  }
  template <int n>
  SKERRY_ALWAYS_INLINE static void unpack(const Slot<R>* slot, int k, S (&to)[4]) {
    R x[n];
    for (int i = 0; i < n; ++i) x[i] = slot[i].Jb[k];
    unpack(x, to);
  }

  // D of an edge, and one over the distance of its points.
  template <int n, bool grounded>
  SKERRY_ALWAYS_INLINE void open_edge(const Group& group, Slot<R>* slot, S (&apart)[most]) {
    for (int i = 0; i < n; ++i) measure<grounded>(group, slot[i]);
    S turn[4];
    unpack<n>(slot, 2, turn);
    apart[b(group)] = 1.0 / (turn[0] - turn[2]);
  }

  // The velocity that sticking to what is below gives a body, and the impulse that it takes.
  template <int n, bool grounded>
  SKERRY_ALWAYS_INLINE void carry(const Group& group, const Slot<R>* slot, const S (&apart)[most], Vector& v,
                                  Vector& force) {
    const int ia = a<grounded>(group), ib = b(group);
    R wanted[n];
    for (int i = 0; i < n; ++i) {
      wanted[i] = slot[i].b;
      if constexpr (!grounded)
        wanted[i] -= slot[i].Ja[0] * v[ia][0] + slot[i].Ja[1] * v[ia][1] + slot[i].Ja[2] * v[ia][2];
    }
    S u[4], x[4], y[4], turn[4];
    unpack(wanted, u);
    unpack<n>(slot, 0, x);
    unpack<n>(slot, 1, y);
    unpack<n>(slot, 2, turn);
    const S omega = (u[0] - u[2]) * apart[ib];
    const S rise = u[0] - turn[0] * omega;
    const S slide = ((u[1] - turn[1] * omega) + (u[3] - turn[3] * omega)) * 0.5;
    v[ib][0] = x[0] * rise + x[1] * slide;
    v[ib][1] = y[0] * rise + y[1] * slide;
    v[ib][2] = omega;
    for (int k = 0; k < 3; ++k) force[ib][k] = v[ib][k] / n_.inverse_mass[ib][k];
  }

  // The impulses of its edge that give a body what it takes, and what it passes on to the body below.
  template <int n, bool grounded>
  SKERRY_ALWAYS_INLINE void bear(const Group& group, Slot<R>* slot, const S (&apart)[most], Vector& force) {
    const int ib = b(group);
    S x[4], y[4], turn[4];
    unpack<n>(slot, 0, x);
    unpack<n>(slot, 1, y);
    unpack<n>(slot, 2, turn);
    const S pressure = x[0] * force[ib][0] + y[0] * force[ib][1];
    const S drag = (x[1] * force[ib][0] + y[1] * force[ib][1]) * 0.5;
    const S moment = force[ib][2] - (turn[1] + turn[3]) * drag;
    const S first = (moment - turn[2] * pressure) * apart[ib],
            second = (turn[0] * pressure - moment) * apart[ib];
    R z[n];
    if constexpr (kLanes) {
      z[0] = R{first, drag, second, drag};
    } else {
      z[0] = first;
      z[1] = z[3] = drag;
      z[2] = second;
    }
    for (int i = 0; i < n; ++i) slot[i].lambda = z[i];
    if constexpr (!grounded) {
      R push[3][n];
      S sum[3];
      for (int k = 0; k < 3; ++k)
        for (int i = 0; i < n; ++i) push[k][i] = slot[i].Ja[k] * z[i];
      add_up(push, sum);
      for (int k = 0; k < 3; ++k) force[group.a][k] -= sum[k];
    }
  }

  // D of a row, or of the rows in its lanes.
  template <bool grounded>
  SKERRY_ALWAYS_INLINE void measure(const Group& group, Slot<R>& slot) const {
    const auto& mb = n_.inverse_mass[b(group)];
    const R(&J)[3] = slot.Jb;
    // Both directions have the same mass.
    R D = (J[0] * J[0] + J[1] * J[1]) * mb[0] + J[2] * J[2] * mb[2];
    if constexpr (!grounded) {
      const auto& ma = n_.inverse_mass[group.a];
      const R(&K)[3] = slot.Ja;
      D += (K[0] * K[0] + K[1] * K[1]) * ma[0] + K[2] * K[2] * ma[2];
    }
    raise(D, R{} + kLeastD);
    slot.D = D;
  }

  // Takes the first step x, from nothing, and adds what the impulses do to the bodies.
  template <int n, bool grounded>
  SKERRY_ALWAYS_INLINE void take_first(const Group& group, Slot<R>* slot, const Vector& x, Vector& v) {
    const int ia = a<grounded>(group), ib = b(group);
    R z[n];
    for (int i = 0; i < n; ++i) {
      R u;
      velocity_along<grounded>(slot[i], x[ia], x[ib], u);
      z[i] = slot[i].g * (slot[i].b - u);
      slot[i].lambda = z[i];
    }
    add_impulses<grounded>(slot, z, v[ia], v[ib]);
  }

  // The second step begins from the velocities that the first one gives.
  template <int n, bool grounded>
  SKERRY_ALWAYS_INLINE void go_on(const Group& group, Slot<R>* slot, const Vector& v, Vector& x) {
    const int ia = a<grounded>(group), ib = b(group);
    R z[n];
    for (int i = 0; i < n; ++i) {
      R u;
      velocity_along<grounded>(slot[i], v[ia], v[ib], u);
      z[i] = slot[i].g * (slot[i].b - u);
      slot[i].lambda += z[i];
    }
    add_impulses<grounded>(slot, z, x[ia], x[ib]);
  }

  // Takes it, puts the impulses into their bounds, and adds what they do to the bodies.
  template <int n, bool grounded>
  SKERRY_ALWAYS_INLINE void take_last(const Group& group, Slot<R>* slot, const Vector& x, Vector& v) {
    const int ia = a<grounded>(group), ib = b(group);
    R z[n];
    for (int i = 0; i < n; ++i) {
      R u;
      velocity_along<grounded>(slot[i], x[ia], x[ib], u);
      z[i] = slot[i].lambda - slot[i].g * u;
    }
    settle<grounded>(group, slot, z, v);
  }

  template <bool grounded, int n>
  SKERRY_ALWAYS_INLINE void settle(const Group& group, Slot<R>* slot, R (&z)[n], Vector& v) {
    const int ia = a<grounded>(group), ib = b(group);
    if (group.bounds == Bounds::Contacts) {
      for (int i = 0; i < n; i += 2) hold_contact(slot + i, z + i);
      for (int i = 0; i < n; ++i) slot[i].lambda = z[i];
    } else {
      for (int i = 0; i < n; ++i) hold(group, slot, i, z[i]);
    }
    add_impulses<grounded>(slot, z, v[ia], v[ib]);
  }

  // A normal row and its friction, or two of both in the lanes of one slot.
  SKERRY_ALWAYS_INLINE static void hold_contact(const Slot<R>* slot, R* z) {
    if constexpr (kLanes) {
      R lower, upper;
      contact_limits(slot, *z, lower, upper);
      clamp_to(*z, lower, upper);
    } else {
      z[0] = z[0] < R{} ? R{} : z[0];
      const R most_allowed = slot[1].mu * z[0];
      clamp_to(z[1], R(-most_allowed), most_allowed);
    }
  }
  SKERRY_ALWAYS_INLINE static void contact_limits(const Slot<Vec4>* slot, const Vec4& z, Vec4& lower,
                                                  Vec4& upper) {
    const double first = z[0] < 0 ? 0 : z[0], second = z[2] < 0 ? 0 : z[2];
    const double most_first = slot->mu[1] * first, most_second = slot->mu[3] * second;
    upper = Vec4{kInfinity, most_first, kInfinity, most_second};
    lower = Vec4{0, -most_first, 0, -most_second};
  }

  SKERRY_ALWAYS_INLINE void hold(const Group& group, Slot<R>* slot, int i, R& z) {
    R lower, upper;
    own_lower(group, i, lower);
    z = z < lower ? lower : z;
    slot[i].lambda = z;
    if (group.bounds != Bounds::Mixed) return;
    limits(group, slot, i, lower, upper);
    clamp_to(z, lower, upper);
    slot[i].lambda = z;
  }

  // A row's lower bound, as far as it does not depend on other rows.
  SKERRY_ALWAYS_INLINE void own_lower(const Group& group, int i, R& lower) const {
    if (group.bounds == Bounds::Normal)
      lower = R{};
    else if (group.bounds == Bounds::Joint)
      lower = R{} - kInfinity;
    else
      each_lane(group, i, lower, [&](int row) { return t_.normal[at(row)] == kNormalRow ? 0 : -kInfinity; });
  }

  // Of rows of a mixed group, from the normal impulses, which are within theirs.
  SKERRY_ALWAYS_INLINE void limits(const Group& group, const Slot<R>* slot, int i, R& lower, R& upper) const {
    R normal, room;
    each_lane(group, i, room, [&](int row) { return t_.normal[at(row)] >= 0 ? 0 : kInfinity; });
    if constexpr (kLanes) {
      each_lane(group, i, normal, [&](int row) {
        const int of = t_.normal[at(row)];
        return of >= 0 ? n_.slot[t_.group_of[at(of)]].lambda[t_.lane[at(of)]] : 0;
      });
    } else {
      const int row = group.first + i, of = i < group.count ? t_.normal[at(row)] : kJointRow;
      normal = R{};
      if (of >= 0) normal = n_.slot[t_.group[at(t_.group_of[at(of)])].slot + t_.lane[at(of)]].lambda;
    }
    upper = slot[i].mu * normal + room;
    own_lower(group, i, lower);
    lower = lower > -upper ? lower : -upper;
  }

  // to = f(row) of the row of this slot, or of the four in its lanes; nothing bounds rows that are not there.
  template <class F>
  SKERRY_ALWAYS_INLINE static void each_lane(const Group& group, int i, R& to, F&& f) {
    if constexpr (kLanes) {
      double of[kTogether] = {};
      for (int lane = 0; lane < group.count; ++lane) of[lane] = f(group.first + lane);
      std::memcpy(&to, of, sizeof(to));
    } else {
      to = R{} + (i < group.count ? f(group.first + i) : 0);
    }
  }

  template <int n, bool grounded>
  SKERRY_ALWAYS_INLINE void judge(const Group& group, const Slot<R>* slot, const Vector& v, R& worst,
                                  R& largest) {
    const int ia = a<grounded>(group), ib = b(group);
    R w[n];
    for (int i = 0; i < n; ++i) {
      velocity_along<grounded>(slot[i], v[ia], v[ib], w[i]);
      w[i] -= slot[i].b;
    }
    if (group.bounds == Bounds::Contacts) {
      for (int i = 0; i < n; i += 2) {
        if constexpr (kLanes) {
          R lower, upper;
          contact_limits(slot, slot->lambda, lower, upper);
          judge_row(*slot, lower, upper, *w);
        } else {
          const R most_allowed = slot[i + 1].mu * slot[i].lambda, most_wrong = slot[i].D * slot[i].lambda;
          w[i] = w[i] > most_wrong ? most_wrong : w[i];
          judge_row(slot[i + 1], R(-most_allowed), most_allowed, w[i + 1]);
        }
      }
    } else {
      for (int i = 0; i < n; ++i) {
        R lower, upper;
        if (group.bounds == Bounds::Mixed) {
          limits(group, slot, i, lower, upper);
        } else {
          own_lower(group, i, lower);
          upper = R{} + kInfinity;
        }
        judge_row(slot[i], lower, upper, w[i]);
      }
    }
    for (int i = 0; i < n; ++i) {
      R size = slot[i].b;
      make_absolute(w[i]);
      make_absolute(size);
      raise(worst, w[i]);
      raise(largest, size);
    }
  }

  // w <- D (lambda - clamp(lambda - w / D)) without the division.
  SKERRY_ALWAYS_INLINE static void judge_row(const Slot<R>& slot, const R& lower, const R& upper, R& w) {
    const R low = slot.D * (slot.lambda - upper), high = slot.D * (slot.lambda - lower);
    clamp_to(w, low, high);
  }

  SKERRY_ALWAYS_INLINE void verdict(const Vector& v) {
    R worst{}, largest{};
    each([&](auto rows, auto grounded, const Group& group, Slot<R>* slot)
             SKERRY_INLINED { judge<rows, grounded>(group, slot, v, worst, largest); });
    S most_wrong, size;
    if constexpr (kLanes) {
      most_wrong = worst[0];
      size = largest[0];
      for (int lane = 1; lane < kTogether; ++lane) {
        raise(most_wrong, worst[lane]);
        raise(size, largest[lane]);
      }
    } else {
      most_wrong = worst;
      size = largest;
    }
    // A comparison does not see what is not a number; a sum does.
    S spoiled{};
    for (int j = 0; j < (most == 1 ? 1 : t_.bodies); ++j) spoiled += (v[j][0] + v[j][1]) + v[j][2];
    n_.residual = most_wrong / (size > S{} ? size : S{} + 1.0) + spoiled * 0.0;
  }

  const Topology& t_;
  N& n_;
};

// A body on two points of one edge, with friction: rows are normal, friction, normal, friction, and both
// normals are one direction. Velocities of the points say how the body moves; the moment about each point how
// they share the normal impulse; friction is shared evenly, as both rows have the same D where the edge lies
// flat. With one body there are two divisions one after the other, and a third of the roundings of the steps
// above. Judged as they are.
template <class R>
SKERRY_ALWAYS_INLINE void stick_edge(Slot<R>* slot, const R (&inverse_mass)[3], R& residual) {
  const R &mass = inverse_mass[0], &inertia = inverse_mass[2];
  const R &a = slot[0].Jb[2], &b = slot[1].Jb[2], &c = slot[2].Jb[2], &d = slot[3].Jb[2];
  const R apart = 1.0 / (a - c);
  const R turn = (slot[0].b - slot[2].b) * apart;
  const R rise = slot[0].b - a * turn;
  const R slide = ((slot[1].b - b * turn) + (slot[3].b - d * turn)) * 0.5;
  const R pressure = rise / mass;
  R drag = (slide / mass) * 0.5;
  const R moment = turn / inertia - (b + d) * drag;
  R z[4] = {(moment - c * pressure) * apart, drag, (a * pressure - moment) * apart, drag};
  for (int i = 0; i < 4; i += 2) {
    z[i] = z[i] < R{} ? R{} : z[i];
    const R most_allowed = slot[i + 1].mu * z[i];
    clamp_to(z[i + 1], R(-most_allowed), most_allowed);
  }
  R v[3];
  for (int k = 0; k < 3; ++k) {
    const R sum =
        (slot[0].Jb[k] * z[0] + slot[1].Jb[k] * z[1]) + (slot[2].Jb[k] * z[2] + slot[3].Jb[k] * z[3]);
    v[k] = sum * inverse_mass[k];
  }
  R worst{}, largest{};
  for (int i = 0; i < 4; ++i) {
    const R(&J)[3] = slot[i].Jb;
    const R D = (J[0] * J[0] + J[1] * J[1]) * mass + J[2] * J[2] * inertia;
    R w = (J[0] * v[0] + J[1] * v[1] + J[2] * v[2]) - slot[i].b, size = slot[i].b;
    const R most_wrong = D * z[i];
    if (i % 2 == 0) {
      w = w > most_wrong ? most_wrong : w;
    } else {
      const R most_allowed = slot[i].mu * z[i - 1];
      clamp_to(w, R(D * (z[i] - most_allowed)), R(D * (z[i] + most_allowed)));
    }
    slot[i].lambda = z[i];
    make_absolute(w);
    make_absolute(size);
    raise(worst, w);
    raise(largest, size);
  }
  // A comparison does not see what is not a number; a sum does.
  const R spoiled = (v[0] + v[1]) + v[2];
  residual = worst / (largest > R{} ? largest : R{} + 1.0) + spoiled * 0.0;
}

template <class N>
SKERRY_ALWAYS_INLINE void solve_one_group(const Topology& t, N& n) {
  if (t.slots == 2)
    Sticking<N, 1, 2>(t, n).run();
  else
    Sticking<N, 1, 4>(t, n).run();
}
template <class N>
SKERRY_ALWAYS_INLINE void solve_groups(const Topology& t, N& n) {
  if (t.tower)
    Sticking<N, kSmallBodies, 0>(t, n).run_tower();
  else if (t.bodies > 1)
    Sticking<N, kSmallBodies, 0>(t, n).run();
  else
    Sticking<N, 1, 0>(t, n).run();
}
template <class N>
SKERRY_ALWAYS_INLINE void solve_small(const Topology& t, N& n) {
  if (t.bodies == 1 && t.groups == 1)
    solve_one_group(t, n);
  else
    solve_groups(t, n);
}

void solve_one_group_portable(const Topology& t, OneGroup& n) {
  solve_one_group(t, n);
}
SKERRY_AVX2 void solve_one_group_avx2(const Topology& t, OneGroup& n) {
  solve_one_group(t, n);
}
void solve_one_portable(const Topology& t, OneIsland& n) {
  solve_groups(t, n);
}
SKERRY_AVX2 void solve_one_avx2(const Topology& t, OneIsland& n) {
  solve_groups(t, n);
}
template <class V>
SKERRY_ALWAYS_INLINE void solve_side_by_side(const Topology& t, Islands<V>& n) {
  if (t.tower && t.bodies == 1)
    stick_edge(n.slot, n.inverse_mass[0], n.residual);
  else
    solve_small(t, n);
}
void solve_eight_portable(const Topology& t, EightIslands& n) {
  for (Islands<Vec2>& two : n.two) solve_side_by_side(t, two);
}
SKERRY_AVX2 void solve_eight_avx2(const Topology& t, EightIslands& n) {
  for (Islands<Vec4>& four : n.four) solve_side_by_side(t, four);
}
SKERRY_AVX512 void solve_eight_avx512(const Topology& t, EightIslands& n) {
  solve_side_by_side(t, n.eight);
}

bool cpu_has_avx512() {
#if defined(__x86_64__)
  static const bool has = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                          __builtin_cpu_supports("avx512vl");
  return has;
#else
  return false;
#endif
}

// What bounds a row; false if the fast path does not know it.
bool read_bounds(const Row& row, signed char& normal) {
  normal = static_cast<signed char>(row.normal);
  if (row.normal >= 0) return true;
  if (row.kind == RowKind::Normal && row.lower == 0 && row.upper == kInfinity) {
    normal = kNormalRow;
    return true;
  }
  normal = kJointRow;
  return row.kind == RowKind::Joint && row.lower == -kInfinity && row.upper == kInfinity;
}

// Of the rows that the group has so far and a further one.
Bounds bounds_with(const Group& group, std::size_t row, signed char normal) {
  if (group.count == 0)
    return normal == kNormalRow ? Bounds::Normal : normal == kJointRow ? Bounds::Joint : Bounds::Mixed;
  const bool own_friction = normal == static_cast<signed char>(row) - 1;
  switch (group.bounds) {
    case Bounds::Normal:
      if (normal == kNormalRow) return Bounds::Normal;
      return group.count == 1 && own_friction ? Bounds::Contacts : Bounds::Mixed;
    case Bounds::Joint:
      return normal == kJointRow ? Bounds::Joint : Bounds::Mixed;
    case Bounds::Contacts:
      return group.count % 2 == 0 ? (normal == kNormalRow ? Bounds::Contacts : Bounds::Mixed)
                                  : (own_friction ? Bounds::Contacts : Bounds::Mixed);
    case Bounds::Mixed:
      break;
  }
  return Bounds::Mixed;
}

// No more rows come.
void close(Topology& t, Group& group) {
  t.slots += group.slots();
  if (group.bounds == Bounds::Contacts && group.count % 2 != 0) group.bounds = Bounds::Mixed;
}

// Topology of an island; false if the fast path does not apply.
bool read_topology(const IslandSystem& system, Topology& t) {
  const std::size_t rows = system.rows.size(), bodies = system.bodies.size();
  if (rows == 0 || rows > kSmallRows || bodies > kSmallBodies || !system.compliance.empty()) return false;
  for (const InverseMass& m : system.bodies)
    if (!(m.linear > 0 && m.angular > 0)) return false;
  t.bodies = static_cast<int>(bodies);
  t.rows = static_cast<int>(rows);
  t.groups = t.slots = 0;
  t.tower = false;
  for (std::size_t j = 0; j < bodies; ++j) t.below[j] = 0;
  Group* group = nullptr;
  for (std::size_t i = 0; i < rows; ++i) {
    const Row& row = system.rows[i];
    if (!read_bounds(row, t.normal[i])) return false;
    const int a = std::min(row.a, row.b), b = std::max(row.a, row.b);
    // Rows of a group name its bodies in the same order.
    if (!group || group->count == kTogether || group->a != a || group->b != b ||
        row.a != system.rows[i - 1].a) {
      if (t.groups == kGroups || b < 0) return false;
      if (group) close(t, *group);
      group = &t.group[at(t.groups++)];
      *group = {static_cast<signed char>(a),       static_cast<signed char>(b),
                static_cast<signed char>(i),       0,
                static_cast<signed char>(t.slots), Bounds::Mixed};
      if (a >= 0) t.below[at(a)] |= 1u << b;
    }
    group->bounds = bounds_with(*group, i, t.normal[i]);
    t.group_of[i] = static_cast<signed char>(t.groups - 1);
    t.lane[i] = group->count++;
  }
  close(t, *group);
  for (std::size_t j = 0; j < bodies; ++j)
    if (t.below[j]) {
      const int parent = std::countr_zero(t.below[j]);
      t.below[at(parent)] |= t.below[j] & ~(1u << parent);
    }
  return true;
}

void begin_answer(std::size_t rows, double residual, Solution& solution) {
  solution.status = SolveStatus::Solved;
  solution.method = "small_exact";
  solution.lambda = take_spare<std::vector<double>>();
  solution.lambda.resize(rows);
  solution.residual = residual;
  solution.iterations = 1;
}

void note_sticking(const SolveOptions& options, Solution& solution) {
  if (!options.trace) return;
  solution.trace = std::make_unique<SolveTrace>();
  solution.trace->notes.emplace_back("small island, everything sticks");
}

// Points that are close to each other say less of how the body turns: what is worse than this is for the
// steps that always reach rounding.
constexpr double kEdgeTolerance = 1e-13;

// Whether four rows, from row `first` of an island, are an edge as `stick_edge` wants it.
bool is_edge(const Row* rows, int first) {
  const bool swapped = rows[0].a > rows[0].b;
  for (int i = 0; i < 4; ++i) {
    const Row& row = rows[i];
    if (row.a != rows[0].a || row.b != rows[0].b) return false;
    const bool friction = row.normal == first + i - 1;
    const bool contact =
        row.normal < 0 && row.kind == RowKind::Normal && row.lower == 0 && row.upper == kInfinity;
    if (i % 2 == 0 ? !contact : !friction) return false;
  }
  const auto direction = [&](int i) -> const std::array<double, 3>& {
    return swapped ? rows[i].Ja : rows[i].Jb;
  };
  const auto &n = direction(0), &t = direction(1), &n2 = direction(2), &t2 = direction(3);
  const bool one_direction = n[0] == n2[0] && n[1] == n2[1] && t[0] == t2[0] && t[1] == t2[1];
  return one_direction && ((t[0] == -n[1] && t[1] == n[0]) || (t[0] == n[1] && t[1] == -n[0]));
}

// Whether a body stands on an edge of the ground.
bool is_edge(const IslandSystem& system) {
  if (system.rows.size() != 4 || system.bodies.size() != 1 || !system.compliance.empty()) return false;
  const InverseMass& body = system.bodies[0];
  return body.linear > 0 && body.angular > 0 && is_edge(system.rows.data(), 0);
}

// Topology of a tower. @return false if the island is none
bool read_tower(const IslandSystem& system, Topology& t) {
  const std::size_t bodies = system.bodies.size();
  if (bodies > kSmallBodies || system.rows.size() != 4 * bodies || bodies == 0 || !system.compliance.empty())
    return false;
  for (const InverseMass& m : system.bodies)
    if (!(m.linear > 0 && m.angular > 0)) return false;
  t.bodies = t.groups = static_cast<int>(bodies);
  t.rows = t.slots = 4 * t.bodies;
  t.tower = true;
  unsigned stands = 0;
  for (int k = 0; k < t.groups; ++k) {
    const Row* const rows = system.rows.data() + 4 * k;
    const int a = std::min(rows[0].a, rows[0].b), b = std::max(rows[0].a, rows[0].b);
    if (b < 0 || (stands >> b & 1) != 0 || !is_edge(rows, 4 * k)) return false;
    stands |= 1u << b;
    t.support[at(b)] = static_cast<signed char>(k);
    t.group[at(k)] = {static_cast<signed char>(a),     static_cast<signed char>(b),
                      static_cast<signed char>(4 * k), 4,
                      static_cast<signed char>(4 * k), Bounds::Contacts};
  }
  return true;
}

// Its numbers by way of `put(T&, double)`.
template <class N, class Put>
SKERRY_ALWAYS_INLINE void read_edge(const IslandSystem& system, N& n, Put&& put) {
  put(n.inverse_mass[0][0], system.bodies[0].linear);
  put(n.inverse_mass[0][1], system.bodies[0].linear);
  put(n.inverse_mass[0][2], system.bodies[0].angular);
  const bool swapped = system.rows[0].a == 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Row& row = system.rows[i];
    const std::array<double, 3>& J = swapped ? row.Ja : row.Jb;
    for (std::size_t c = 0; c < 3; ++c) put(n.slot[i].Jb[c], J[c]);
    put(n.slot[i].b, system.b[i]);
    put(n.slot[i].mu, row.mu);
  }
}

const Row kNoRow{};

void read_numbers(const IslandSystem& system, const Topology& t, OneIsland& n) {
  for (std::size_t j = 0; j < system.bodies.size(); ++j) {
    n.inverse_mass[j][0] = n.inverse_mass[j][1] = system.bodies[j].linear;
    n.inverse_mass[j][2] = system.bodies[j].angular;
  }
  for (int k = 0; k < t.groups; ++k) {
    const Group& group = t.group[at(k)];
    Slot<Vec4>& slot = n.slot[k];
    const Row* const row = &system.rows[at(group.first)];
    const double* const b = &system.b[at(group.first)];
    const Row &r0 = row[0], &r1 = group.count > 1 ? row[1] : kNoRow, &r2 = group.count > 2 ? row[2] : kNoRow,
              &r3 = group.count > 3 ? row[3] : kNoRow;
    const bool swapped = r0.a > r0.b;
    const auto gather = [](Vec4(&to)[3], const auto& j0, const auto& j1, const auto& j2, const auto& j3) {
      for (std::size_t c = 0; c < 3; ++c) to[c] = Vec4{j0[c], j1[c], j2[c], j3[c]};
    };
    if (swapped)
      gather(slot.Jb, r0.Ja, r1.Ja, r2.Ja, r3.Ja);
    else
      gather(slot.Jb, r0.Jb, r1.Jb, r2.Jb, r3.Jb);
    if (group.a >= 0) {
      if (swapped)
        gather(slot.Ja, r0.Jb, r1.Jb, r2.Jb, r3.Jb);
      else
        gather(slot.Ja, r0.Ja, r1.Ja, r2.Ja, r3.Ja);
    }
    slot.b = Vec4{b[0], group.count > 1 ? b[1] : 0, group.count > 2 ? b[2] : 0, group.count > 3 ? b[3] : 0};
    slot.mu = Vec4{r0.mu, r1.mu, r2.mu, r3.mu};
  }
}

// One row a slot, by way of `put(T&, double)`.
template <class N, class Put>
SKERRY_ALWAYS_INLINE void read_rows(const IslandSystem& system, const Topology& t, N& n, Put&& put) {
  for (std::size_t j = 0; j < system.bodies.size(); ++j) {
    put(n.inverse_mass[j][0], system.bodies[j].linear);
    put(n.inverse_mass[j][1], system.bodies[j].linear);
    put(n.inverse_mass[j][2], system.bodies[j].angular);
  }
  for (int k = 0; k < t.groups; ++k) {
    const Group& group = t.group[at(k)];
    for (int i = 0; i < group.slots(); ++i) {
      auto& slot = n.slot[group.slot + i];
      const bool there = i < group.count;
      const Row& row = there ? system.rows[at(group.first + i)] : kNoRow;
      const bool swapped = row.a > row.b;
      const auto &Ja = swapped ? row.Jb : row.Ja, &Jb = swapped ? row.Ja : row.Jb;
      for (std::size_t c = 0; c < 3; ++c) put(slot.Jb[c], Jb[c]);
      if (group.a >= 0)
        for (std::size_t c = 0; c < 3; ++c) put(slot.Ja[c], Ja[c]);
      put(slot.b, there ? system.b[at(group.first + i)] : 0);
      put(slot.mu, row.mu);
    }
  }
}

void read_numbers(const IslandSystem& system, const Topology& t, OneGroup& n) {
  read_rows(system, t, n, [](double& to, double from) { to = from; });
}
template <class V>
void read_numbers(const IslandSystem& system, const Topology& t, int lane, Islands<V>& n) {
  read_rows(system, t, n, [lane](V& to, double from) { to[lane] = from; });
}

// f(the vectors that this processor takes side by side, the lane in them)
template <class F>
void at_lane(EightIslands& n, int lane, F&& f) {
  if (cpu_has_avx512())
    f(n.eight, lane);
  else if (cpu_has_avx2())
    f(n.four[lane / 4], lane % 4);
  else
    f(n.two[lane / 2], lane % 2);
}

void read_lane(const IslandSystem& system, const Topology& t, int lane, EightIslands& n) {
  at_lane(n, lane, [&](auto& islands, int k) { read_numbers(system, t, k, islands); });
}

void solve_one(const Topology& t, OneGroup& n) {
  if (cpu_has_avx2())
    solve_one_group_avx2(t, n);
  else
    solve_one_group_portable(t, n);
}
void solve_one(const Topology& t, OneIsland& n) {
  if (cpu_has_avx2())
    solve_one_avx2(t, n);
  else
    solve_one_portable(t, n);
}

// The answer that everything sticks. @param impulse  of a group's row
template <class Impulse>
void tell(const Topology& t, double residual, Impulse&& impulse, Solution& solution) {
  begin_answer(at(t.rows), residual, solution);
  double* to = solution.lambda.data();
  for (int k = 0; k < t.groups; ++k)
    for (int i = 0; i < t.group[at(k)].count; ++i) *to++ = impulse(k, i);
}

// What `Sticking` does.
void count_work(Solution& solution) {
  solution.work.factorisations = 1;
  solution.work.resolves = kSteps;
}

// Edges and towers, by formula. @return false, and `solution` as it was, where the island is none, or does
// not stick, or not to the last digits
bool try_tower(const IslandSystem& system, const SolveOptions& options, Solution& solution) {
  const double tolerance = std::min(options.tolerance, kEdgeTolerance);
  if (is_edge(system)) {
    OneGroup n;
    read_edge(system, n, [](double& to, double from) { to = from; });
    stick_edge(n.slot, n.inverse_mass[0], n.residual);
    if (!(n.residual <= tolerance)) return false;
    begin_answer(4, n.residual, solution);
    for (std::size_t i = 0; i < 4; ++i) solution.lambda[i] = n.slot[i].lambda;
  } else {
    Topology t;
    if (!read_tower(system, t)) return false;
    OneIsland n;
    read_numbers(system, t, n);
    solve_one(t, n);
    if (!(n.residual <= tolerance)) return false;
    tell(
        t, n.residual, [&](int k, int i) { return n.slot[k].lambda[i]; }, solution);
  }
  note_sticking(options, solution);
  return true;
}

}  // namespace

bool fits_small_exact(const IslandSystem& system) {
  Topology topology;
  return read_topology(system, topology);
}

bool try_small_exact(const IslandSystem& system, const SolveOptions& options, Solution& solution) {
  if (try_tower(system, options, solution)) return true;
  Topology topology;
  if (!read_topology(system, topology)) return false;
  if (topology.bodies == 1 && topology.groups == 1) {
    OneGroup numbers;
    read_numbers(system, topology, numbers);
    solve_one(topology, numbers);
    if (!(numbers.residual <= options.tolerance)) return false;
    tell(
        topology, numbers.residual, [&](int, int i) { return numbers.slot[i].lambda; }, solution);
  } else {
    OneIsland numbers;
    read_numbers(system, topology, numbers);
    solve_one(topology, numbers);
    if (!(numbers.residual <= options.tolerance)) return false;
    tell(
        topology, numbers.residual, [&](int k, int i) { return numbers.slot[k].lambda[i]; }, solution);
  }
  count_work(solution);
  note_sticking(options, solution);
  return true;
}

Solution solve_small_exact(const IslandSystem& system, std::span<const double> warm_start,
                           const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  Solution solution;
  if (!try_small_exact(system, options, solution))
    solution = solve_body_space(system, warm_start, options, memory);
  return solution;
}

struct SmallBatch::Data {
  Topology topology;
  bool any = false;
  EightIslands numbers;
};

SmallBatch::SmallBatch() : data_(std::make_unique<Data>()) {}
SmallBatch::~SmallBatch() = default;
SmallBatch::SmallBatch(SmallBatch&&) noexcept = default;
SmallBatch& SmallBatch::operator=(SmallBatch&&) noexcept = default;

bool SmallBatch::set(int lane, const IslandSystem& system) {
  if (lane < 0 || lane >= kLanes)
    throw std::invalid_argument("SmallBatch: lane " + std::to_string(lane) + " of 8");
  Topology topology;
  if (!read_tower(system, topology) && !read_topology(system, topology)) return false;
  if (data_->any && !(topology == data_->topology)) return false;
  if (!data_->any) {
    // Lanes that stay empty must be harmless: they all start as this island.
    data_->topology = topology;
    data_->any = true;
    for (int k = 0; k < kLanes; ++k) read_lane(system, topology, k, data_->numbers);
  }
  read_lane(system, topology, lane, data_->numbers);
  return true;
}

void SmallBatch::solve() {
  if (!data_->any) return;
  if (cpu_has_avx512())
    solve_eight_avx512(data_->topology, data_->numbers);
  else if (cpu_has_avx2())
    solve_eight_avx2(data_->topology, data_->numbers);
  else
    solve_eight_portable(data_->topology, data_->numbers);
}

double SmallBatch::residual(int lane) const {
  double residual = kInfinity;
  if (data_->any)
    at_lane(data_->numbers, lane, [&](auto& islands, int k) { residual = islands.residual[k]; });
  return data_->topology.tower && !(residual <= kEdgeTolerance) ? kInfinity : residual;
}

Solution SmallBatch::solution(int lane) const {
  const Topology& t = data_->topology;
  Solution solution;
  at_lane(data_->numbers, lane, [&](auto& islands, int k) {
    const auto impulse = [&](int group, int i) {
      return islands.slot[t.group[at(group)].slot + i].lambda[k];
    };
    tell(t, islands.residual[k], impulse, solution);
  });
  if (!data_->topology.tower) count_work(solution);
  return solution;
}

std::vector<Solution> solve_batch(std::span<const IslandSystem* const> systems, const SolveOptions& options) {
  std::vector<Solution> solutions(systems.size());
  for (std::size_t first = 0; first < systems.size();) {
    SmallBatch batch;
    int lanes = 0;
    while (lanes < SmallBatch::kLanes && first + at(lanes) < systems.size() &&
           batch.set(lanes, *systems[first + at(lanes)]))
      ++lanes;
    if (lanes > 1) batch.solve();
    for (int lane = 0; lane < std::max(1, lanes); ++lane) {
      const IslandSystem& system = *systems[first + at(lane)];
      Solution& solution = solutions[first + at(lane)];
      if (lanes > 1 && batch.residual(lane) <= options.tolerance) {
        solution = batch.solution(lane);
      } else {
        solution = solve_small_exact(system, {}, options, nullptr);
      }
    }
    first += at(std::max(1, lanes));
  }
  return solutions;
}

extern const SolverEntry kSmallExactEntry;
const SolverEntry kSmallExactEntry = {
    .name = "small_exact",
    .summary = "fixed-size body space on the stack for small islands; else body_space",
    .reference = "physics/README.md",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_small_exact,
};

}  // namespace skerry
