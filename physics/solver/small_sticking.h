// SPDX-License-Identifier: MIT
//
// "Everything that touches sticks", for one small island or several of one topology side by side: a factor
// and two proximal steps, or, for towers, a formula; then judged by the natural map.
#pragma once

#include <cstring>
#include <type_traits>

#include "physics/solver/simd.h"
#include "physics/solver/small_factor.h"
#include "physics/solver/small_topology.h"

// Of a lambda.
#define SKERRY_INLINED __attribute__((always_inline))

namespace skerry::small {

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

}  // namespace skerry::small

#undef SKERRY_INLINED
