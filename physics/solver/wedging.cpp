// SPDX-License-Identifier: MIT
#include "physics/solver/wedging.h"

#include <algorithm>
#include <cmath>

#include "physics/spare.h"

namespace skerry {
namespace {

// Impulses below this many times what would stop b in their own row alone are not large: each in a tower of
// fifteen carries as much.
constexpr double kLarge = 64;

/// Impulse that somebody gave: neither a bound of one side nor that of another row, but a strength or a
/// spring.
bool is_given(const IslandSystem& system, std::size_t i) {
  const Row& row = system.rows[i];
  if (!system.compliance.empty() && system.compliance[i] > 0) return true;
  return row.normal < 0 && row.kind != RowKind::Normal && std::isfinite(row.lower) &&
         std::isfinite(row.upper);
}

double diagonal_of(const IslandSystem& system, std::size_t i) {
  const Row& row = system.rows[i];
  double sum = system.compliance.empty() ? 0 : system.compliance[i];
  if (row.a >= 0) sum += inverse_mass_along(system.bodies[static_cast<std::size_t>(row.a)], row.Ja);
  if (row.b >= 0) sum += inverse_mass_along(system.bodies[static_cast<std::size_t>(row.b)], row.Jb);
  return sum;
}

}  // namespace

double self_made_share(const IslandSystem& system, const std::vector<double>& lambda) {
  Spare<std::vector<Vec2>> momenta;
  momenta->assign(system.bodies.size(), Vec2{});
  double largest = 0, wanted = 0;
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    if (row.a >= 0) (*momenta)[static_cast<std::size_t>(row.a)] += Vec2{row.Ja[0], row.Ja[1]} * lambda[i];
    if (row.b >= 0) (*momenta)[static_cast<std::size_t>(row.b)] += Vec2{row.Jb[0], row.Jb[1]} * lambda[i];
    if (row.kind == RowKind::Normal) largest = std::max(largest, std::abs(lambda[i]));
    if (is_given(system, i)) wanted += std::abs(lambda[i]);
  }
  for (const Vec2& p : *momenta) wanted += length(p);
  return largest > 0 ? largest / wanted : 0;
}

bool is_wedged(const IslandSystem& system, const std::vector<double>& lambda) {
  const double large = kLarge * residual_scale(largest_magnitude(system.b));
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    if (system.rows[i].kind != RowKind::Normal || !(diagonal_of(system, i) * lambda[i] > large)) continue;
    return self_made_share(system, lambda) > kMostSelfMade;
  }
  return false;
}

double size_of_impulses(const IslandSystem& system, const std::vector<double>& lambda) {
  double sum = 0;
  for (std::size_t i = 0; i < system.rows.size(); ++i) sum += diagonal_of(system, i) * lambda[i] * lambda[i];
  return sum;
}

}  // namespace skerry
