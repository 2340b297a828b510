// SPDX-License-Identifier: MIT
//
// Limit load of an assembly of rigid blocks by linear programming: the largest factor s for which forces in
// equilibrium exist that no contact refuses.
//
//   maximise s   such that   J' lambda + f_dead + s f_live = 0,  lambda_n >= 0,  |lambda_t| <= mu lambda_n
//
// By the lower-bound theorem s is safe; its dual is a mechanism, velocities v of the blocks with J_n v >= 0,
// by the upper-bound theorem the way it collapses [Livesley 1978; Gilbert & Melbourne 1994].
//
// Friction makes the theorem one-sided: the dual of |lambda_t| <= mu lambda_n is *associated* flow, in which
// sliding blocks also lift off by mu times the slip. Real (Coulomb, non-associated) friction does not lift,
// so where the mechanism slides the LP's factor is an upper bound of the real one; where nothing slides, and
// for frictionless or non-sliding contacts, it is the limit itself [Drucker 1954].
#pragma once

#include <array>
#include <string>
#include <vector>

#include "physics/islands/island_system.h"
#include "physics/statics/body_loads.h"

namespace skerry::statics {

/// Whether contacts may slide.
enum class Sliding : std::uint8_t {
  Coulomb,  ///< within mu of each friction row
  None,     ///< friction rows carry whatever is needed (masonry: Heyman's assumptions)
};

enum class LimitStatus : std::uint8_t {
  Optimal,
  Unbounded,    ///< any multiple of the live load is carried
  Infeasible,   ///< not even the dead load is carried
  NoLoad,       ///< the dead load is carried, and there is no live load
  Unavailable,  ///< built without COIN-OR Clp
  Failed,       ///< the LP solver gave up
};
const char* to_string(LimitStatus status);

struct LimitLoad {
  LimitStatus status = LimitStatus::Failed;
  double factor = 0;           ///< s; infinite when unbounded
  std::vector<double> forces;  ///< of each row [N]
  /// Velocities (vx, vy, omega) of the collapse mechanism, on which the live load does the work 1 a second.
  std::vector<std::array<double, 3>> mechanism;
};

/// False if the library was built without COIN-OR Clp (Debian: coinor-libclp-dev).
bool limit_load_available();
/// "built without COIN-OR Clp; install coinor-libclp-dev and configure again"
std::string limit_load_missing();

/// Solves the linear programme. `system.rows` decide: Normal, Friction (after its Normal), Rolling, Joint,
/// Limit, Motor (up to its largest force). Of inverse masses only one thing is looked at: a body that has a
/// mass and no inverse moment of inertia is held against turning. @param dead, live  one entry a body
/// @throws std::invalid_argument if sizes differ, a load is not finite or the system is not valid
LimitLoad limit_load(const IslandSystem& system, const BodyLoads& dead, const BodyLoads& live,
                     Sliding sliding = Sliding::Coulomb);

/// Least sum of forces and torques that is missing for equilibrium, over the sum of the given ones: 0 if and
/// only if the assembly can carry `loads`. Infinite when unavailable.
double missing_support(const IslandSystem& system, const BodyLoads& loads,
                       Sliding sliding = Sliding::Coulomb);

}  // namespace skerry::statics
