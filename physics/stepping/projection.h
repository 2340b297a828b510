// SPDX-License-Identifier: MIT
//
// Drift: brings positions and velocities back onto the constraints after a piece of a step.
#pragma once

#include <vector>

#include "physics/math.h"
#include "physics/stepping/stepper.h"

namespace skerry {

struct Assembly;

/// Errors below this are what rounding leaves [m]: a thousandth of the tolerance within which contacts count
/// as closed.
double position_floor(const WorldState& state, Vec2 where);

/// Moves the bodies by the smallest mass-weighted displacement after which joints hold, contacts do not
/// penetrate, and contacts that carried load are closed. Velocities are left alone but for a common rotation
/// that keeps the angular momentum of islands that touch nothing fixed. Does nothing (and solves nothing)
/// when all errors are at rounding level already.
/// @param elapsed  since the beginning of the step [s]
/// @param rows     memory for rows
/// @param far      joints may be off by much: more and smaller shifts are tried, and what they may reach is
///                 looked at, not only what is near
/// @return whether `rows` are those that hold at the new places: the island is nothing but joints without
///         limits, motors and springs
bool project_positions(WorldState& state, const Island& island, double elapsed, IslandResult& result,
                       Assembly& rows, bool far = false);

/// Adds angular momentum [kg m^2/s] to an island as a common rotation, which no contact within it feels.
void give_spin(WorldState& state, const Island& island, double momentum);

/// Forces on an island are those of the middle of a time `h` [s], but act where it begins: if nothing else
/// pushed it, it gets the angular momentum that this took, the moment of the forces about where they act.
/// @param start  by body of the island, where it was; it has moved since
void turn_by_forces(WorldState& state, const Island& island, double h, const std::vector<Transform>& start);

/// What a projection of velocities did.
struct VelocityShift {
  double friction = 0;  ///< work of the friction that belongs to it [J]
  double brought = 0;   ///< work of what is told to move [J]
  bool holds = true;    ///< but for rounding nothing is violated any more
};

/// Removes the velocity that violates joints, loaded contacts and sticking contacts at the present geometry,
/// by the least-energy change and the friction that belongs to it; kept only where it makes the violation
/// smaller.
/// @param pushed  contacts and limits that it would pull by more than they were pushed in a piece of this
///                length [s] open instead; 0: none do
/// @param rows    those of `project_positions`, if it said that they hold and nothing has moved since
/// @param motors  those at their speed hold it
VelocityShift project_velocities(WorldState& state, const Island& island, double elapsed, double pushed,
                                 IslandResult& result, Assembly* rows = nullptr, bool motors = true);

/// True if what joints, or motors without limit, hold moves otherwise: bodies were given another velocity, or
/// motors another speed.
bool joints_disobey(const WorldState& state, const Island& island, double elapsed);

/// What joints cannot but obey happens at once, by the least-energy change. Contacts have no part in that:
/// those that it presses are struck, and their friction is bounded by the impulse of that impact. On what is
/// frictionless and plastic both together are the impact of all of them. Joints that contradict each other
/// may want any velocity, so that energy is bounded (`IslandEnergy::take_much`).
/// @param passed  energy that nothing explains, in the step so far [J]
void obey_joints(WorldState& state, const Island& island, double elapsed, double& passed,
                 IslandResult& result);

}  // namespace skerry
