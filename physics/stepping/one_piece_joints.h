// SPDX-License-Identifier: MIT
//
// Joints of an island that makes its step in one piece (physics/stepping/one_piece.h).
//
// What a joint holds is wanted at the end of the step, where geometry that turns has left the plane of its
// rows. With q* the places that the free velocities v* lead to,
//
//   C(q0 + h v1) = C(q0)  ->  J v1 = -(C(q*) - C(q0) - h J v*) / h
//
// which is the method of Verlet with constraints [Ryckaert, Ciccotti & Berendsen 1977], linear, and leaves
// errors of third order in h to the projection of positions. Limits want C(q0 + h v1) >= 0. Springs take the
// force of the end of the step, which no stiffness makes unstable; motors have their force times h.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "physics/stepping/island_rows.h"

namespace skerry {

/// Gives row `row` its compliance, if it is a spring's, or its bounds as impulses in `h` [s], if a motor's.
/// @return what it wants of J v [m/s or rad/s]; nothing for other rows
std::optional<double> aim_actuator(const RowOrigin& origin, double h, std::size_t row, IslandSystem& system);

/// Gives the rows of joints, which are the first ones of `assembly`, what they want, their bounds as
/// impulses, their compliance, and where to begin.
/// @param from, h  beginning and length of the step [s]  @param free  velocities v* of the island's bodies
/// @param warm     impulses by row; those of joints are set
void aim_joints(const WorldState& state, double from, double h, const std::vector<Velocity>& free,
                Assembly& assembly, std::vector<double>& warm);

/// A hinge that pulls with a force f at an arm r turns its body back like a spring of r . f [N m/rad], the
/// geometric stiffness [Tournier, Nesme, Gilles & Faure 2015]. Impulses along the directions of the beginning
/// of a step are unstable where that makes a body swing faster than 2 / h: a taut chain shakes itself to
/// pieces. So impulses meet as much inertia as makes it slower, and what turns already goes on as it does.
/// @param h     length of the step [s]
/// @param warm  impulses by row, of the last step
void steady_hinges(const WorldState& state, double h, const std::vector<double>& warm, Assembly& assembly);

/// Keeps the impulses of a step of length `h` [s] as the forces of its joints.
void store_joint_impulses(WorldState& state, const Island& island, const Assembly& assembly,
                          const std::vector<double>& lambda, double h);

/// What joints keep together must go along alike. In a step in one piece a body goes h v1 where impulses act
/// and h (v0 + v1) / 2 where none does; of bodies with joints all that hang together go h v1, less the
/// h^2 a / 2 that their common fall is shorter where neither contacts nor the ground hold any of them.
/// @param h       length of the step [s]
/// @param pushed  by body of the island: an impulse of a contact acts on it; then also: goes h v1 less `lag`
/// @param lag     by body of the island [m]
void bind_jointed(const WorldState& state, const Island& island, double h, std::vector<std::uint8_t>& pushed,
                  std::vector<Vec2>& lag);

/// By how much what a joint holds, or limits, is off: the largest share of the size of the smaller body (of
/// the joint where that has none, a point); of angles, which move its ends by its size, in rad.
/// @param elapsed  since the beginning of the step [s]
double how_far_off(const WorldState& state, std::uint32_t slot, double elapsed);

/// True if what joints hold, or limit, is off by more than a share of the size of the smaller body.
/// @param elapsed  since the beginning of the step [s]
bool joints_are_off(const WorldState& state, const Island& island, double elapsed, double share);

/// Closes joints that are off by more than a share of the size of the smaller body, by sweeps over all joints
/// of what hangs together with them, each taken where the bodies are by then: what turns by a radian in a
/// step, as a forearm that was struck does, is not to be mended along straight lines. Where more than 20
/// joints hang together what 10 sweeps leave is taken out of all at once, by Newton's iteration. Does not
/// look at contacts.
/// @param elapsed  since the beginning of the step [s]
void mend_joints(WorldState& state, const Island& island, double elapsed, double share);

}  // namespace skerry
