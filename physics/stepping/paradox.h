// SPDX-License-Identifier: MIT
//
// Painleve's paradox: contacts that slide in a way for which Coulomb's law and rigid bodies have no
// acceleration, or several.
#pragma once

#include <cmath>

#include "physics/islands/island_system.h"

namespace skerry {

/// True if a contact that slides pushes itself together: with the friction of its own normal force, that
/// force gives no acceleration apart, W_nn - mu |W_nt| <= 0 where W_nt has the sign of the sliding [Painleve
/// 1895; Champneys & Varkonyi 2016, sec. 2]. Other contacts of the bodies are not looked at.
/// @param sliding  velocity along the friction row [m/s], not zero
inline bool is_paradoxical(const IslandSystem& system, const Row& friction, double sliding) {
  const Row& normal = system.rows[static_cast<std::size_t>(friction.normal)];
  double Wnn = 0, Wnt = 0;
  const auto add = [&](int body, const std::array<double, 3>& n, const std::array<double, 3>& t) {
    if (body < 0) return;
    const InverseMass& mass = system.bodies[static_cast<std::size_t>(body)];
    Wnn += inverse_mass_along(mass, n);
    Wnt += mass.linear * (n[0] * t[0] + n[1] * t[1]) + mass.angular * n[2] * t[2];
  };
  add(normal.a, normal.Ja, friction.Ja);
  add(normal.b, normal.Jb, friction.Jb);
  return Wnn - std::copysign(friction.mu, sliding) * Wnt <= 0;
}

}  // namespace skerry
