// SPDX-License-Identifier: MIT
//
// What the impact laws share: velocities under impulses, plastic and frictional sub-problems.
#pragma once

#include <vector>

#include "physics/solver/impact_law.h"

namespace skerry::impact {

/// Residual above which contacts contradict each other, as where ground that moves squeezes bodies: no
/// impulses end all approach.
inline constexpr double kContradiction = 1e-6;

using Velocities = std::vector<std::array<double, 3>>;

/// Relative velocity of row `i`: J v + drive.
double row_velocity(const ImpactProblem& problem, int i, const Velocities& v);
/// v += M^-1 J_i^T impulse
void apply_row(const IslandSystem& system, int i, double impulse, Velocities& v);
/// Inverse effective mass of row `i`.
double inverse_mass(const IslandSystem& system, int i);
double kinetic_energy(const IslandSystem& system, const Velocities& v);
/// Kinetic energy less the work of ground that moves, by the impulses that led there [J]: seen from the
/// ground it must not grow.
double energy_but_for_ground(const ImpactProblem& problem, const Velocities& v,
                             const std::vector<double>& lambda);
/// True when no ground moves, so that the kinetic energy of the island must not grow.
bool ground_at_rest(const ImpactProblem& problem);

/// Kinetic energy that a bounce off ground that moves can leave at most [J]; infinite where none does. What
/// is squeezed by something that moves on its own could bounce to and fro for ever, faster each time.
double most_of_bounce(const ImpactProblem& problem);
/// Whether velocities have more than that, or are no numbers.
bool exceeds_bounce(const ImpactProblem& problem, const Velocities& v);
/// What smooth wedges press out may be so many times as fast as they are; beyond that (angles below a
/// thirtieth) they jam.
inline constexpr double kWedge = 32;
/// The same of what ground that moves pushes without a bounce, up to so many `times` as fast as it is.
double most_of_push(const ImpactProblem& problem, double times);

/// Solves for impulses on `rows` (indices of Normal and Joint rows): w >= target, lambda >= 0 and
/// complementary for Normal, w = 0 for Joint rows, starting from velocities `v`; the result is in the order
/// of `rows`.
/// @param targets  wanted relative velocity of each of `rows` [m/s]; empty: zero
std::vector<double> unilateral(const ImpactProblem& problem, const std::vector<int>& rows,
                               const Velocities& v, const std::vector<double>& targets, ImpactResult& result);

/// Adds friction to an impact with known normal impulses: minimises the kinetic energy over tangential
/// impulses within mu times the normal ones; if that makes a contact approach, an exact plastic Coulomb solve
/// follows.
void add_friction(const ImpactProblem& problem, ImpactResult& result);

/// Coulomb's problem without restitution, normals and friction together, from velocities `v`; they become
/// those after it. Energy cannot grow: normal rows end at rest or open, friction opposes what still slides.
/// @return false if the solver found no answer; `v` is as it was then
bool coulomb(const ImpactProblem& problem, Velocities& v, std::vector<double>& lambda, ImpactResult& result);

/// Stops what still approaches, and what joints do not allow, without friction.
void end_approach(const ImpactProblem& problem, ImpactResult& result);

/// Indices of the rows of one kind.
std::vector<int> rows_of(const IslandSystem& system, RowKind kind);
/// All Normal and Joint rows.
std::vector<int> unilateral_rows(const IslandSystem& system);

}  // namespace skerry::impact
