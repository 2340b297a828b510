// SPDX-License-Identifier: MIT
//
// What the points of a contact remember of a step in one piece.
#pragma once

#include <cmath>

#include "physics/contact.h"
#include "physics/stepping/island_rows.h"

namespace skerry {

/// No impulses. @param h  length of the step [s]
inline void forget_impulses(Contact& contact, double h) {
  for (PointMemory& memory : contact.points) {
    memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
    memory.h = h;
    memory.sticking = false;
  }
}

/// The impulse of one row; normal ones come before those of their friction.
/// @param mu  of a row of friction
inline void remember_impulse(const RowOrigin& origin, double mu, double lambda, Contact& contact) {
  PointMemory& memory = contact.points[static_cast<std::size_t>(origin.point)];
  if (origin.kind == RowKind::Normal) memory.normal_impulse = lambda;
  if (origin.kind == RowKind::Rolling) memory.rolling_impulse = lambda;
  if (origin.kind != RowKind::Friction) return;
  memory.friction_impulse = lambda;
  memory.total_friction += lambda;
  memory.sticking = memory.normal_impulse > 0 && std::abs(lambda) < mu * memory.normal_impulse * (1 - 1e-12);
}

}  // namespace skerry
