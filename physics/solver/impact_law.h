// SPDX-License-Identifier: MIT
//
// Impact laws: what an island's velocities become when some of its touching contacts approach. Each law is
// one file and one row of the registry.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "physics/islands/island_system.h"
#include "physics/solver/solver.h"

namespace skerry {

/// The touching contacts and the joints of an island at the moment of an impact, before any force of the step
/// acts.
struct ImpactProblem {
  IslandSystem system;  ///< Normal rows with their Friction rows, and Joint rows; `b` is not used
  std::vector<std::array<double, 3>>
      velocity;                         ///< of each body before the impact (vx, vy, omega) [m/s, rad/s]
  std::vector<double> drive;            ///< per row: velocity that moving ground adds to J v [m/s]
  std::vector<double> restitution;      ///< per row, 0 to 1; read for Normal rows
  double ground_speed = 0;              ///< fastest that anything is told to move, along rows or not [m/s]
  double rest_speed = 1e-6;             ///< slower approaches do not bounce [m/s]
  const SolverEntry* solver = nullptr;  ///< for the plastic and frictional sub-problems
  double work_limit = 0;     ///< of the solver, over all sub-problems (`SolveOptions::work_limit`); 0: none
  double most_work = 0;      ///< visits after which nothing bounces on; 0: none
  bool welds_as_one = true;  ///< in the sub-problems (`SolveOptions::welds_as_one`)
  ThreadPool* threads = nullptr;  ///< for the sub-problems (`SolveOptions::threads`)
};

struct ImpactResult {
  std::vector<double> lambda;                   ///< impulse of each row [N s]
  std::vector<std::array<double, 3>> velocity;  ///< after the impact
  int reflections = 0;                          ///< inner steps
  int locked = 0;                               ///< contacts that cannot open, treated as plastic
  bool energy_limited = false;                  ///< the answer was drawn towards the plastic one
  SolveStatus status = SolveStatus::Solved;
  double residual = 0;  ///< worst of the sub-problems
  SolveWork work;
};

using ImpactFn = ImpactResult (*)(const ImpactProblem&);

struct ImpactLawEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view reference;
  bool may_create_energy;
  ImpactFn apply;
};

/// All laws; the first is the default.
std::span<const ImpactLawEntry> impact_laws();
/// @throws std::invalid_argument that lists the names there are.
const ImpactLawEntry& find_impact_law(std::string_view name);

}  // namespace skerry
