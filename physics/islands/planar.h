// SPDX-License-Identifier: MIT
//
// Jacobian blocks and velocities of a body as a pair of lanes and a number, for loops over all rows: the same
// sums as by `along`, `push` and `inverse_mass_along` of physics/islands/island_system.h, with the same bits.
#pragma once

#include "physics/islands/island_system.h"

namespace skerry {

/// (vx, vy, omega), or a block of a Jacobian.
struct Planar {
  using Pair = double __attribute__((vector_size(16)));
  Pair xy;
  double turn;
};

inline Planar planar(const std::array<double, 3>& J) {
  return {Planar::Pair{J[0], J[1]}, J[2]};
}

/// J . v
inline double along(const Planar& J, const Planar& v) {
  const Planar::Pair xy = J.xy * v.xy;
  return xy[0] + xy[1] + J.turn * v.turn;
}

/// M^-1 J^T impulse
inline Planar pushed(const InverseMass& body, const Planar& J, double impulse) {
  const Planar::Pair linear{body.linear, body.linear}, by{impulse, impulse};
  return {linear * J.xy * by, body.angular * J.turn * impulse};
}

/// J M^-1 K^T of one body: its share of an entry of W; `J` twice for one of the diagonal.
inline double coupled(const InverseMass& body, const Planar& J, const Planar& K) {
  const Planar::Pair xy = J.xy * K.xy;
  return body.linear * (xy[0] + xy[1]) + body.angular * J.turn * K.turn;
}

}  // namespace skerry
