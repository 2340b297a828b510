// SPDX-License-Identifier: MIT
//
// Forces that change within a step: fields by callback, and drag.
#pragma once

#include <array>
#include <vector>

#include "physics/forces.h"
#include "physics/islands/island_builder.h"
#include "physics/joint_rows.h"
#include "physics/stepping/island_rows.h"

namespace skerry {

struct WorldState;

/// Whether anything but constant forces acts on the island: then its flight is not a parabola, nor does it
/// rest because it rested.
bool has_varying_forces(const WorldState& state, const Island& island);

/// Whether a contact or joint of the island has a body that goes somewhere by a prescribed motion.
bool meets_prescribed_motion(const WorldState& state, const Island& island);

/// Whether a body is kinematic and moves in this step: what is told to stand still does not.
bool moves_as_told(const WorldState& state, std::uint32_t body);

/// Whether a contact or joint of the island has one that does.
bool meets_motion(const WorldState& state, const Island& island);

/// Largest acceleration that the applied forces give any point of the island's bodies [m/s^2].
double largest_acceleration(const WorldState& state, const Island& island);

/// What the rounding of forces (or impulses) that balance may leave of accelerations (or velocities, of
/// points of bodies that turn) in an island: it moves the lightest body most, and what that carries with it.
/// Slower than this cannot be told from rest. @param force  a large one of the island [N] (or [N s])
double rounding_of_balance(const WorldState& state, const Island& island, double force);

/// Acceleration (linear and angular) of a dynamic body in this motion, by gravity, the user's forces of this
/// step, fields and drag.
/// @param elapsed  since the beginning of the step [s]
/// @throws std::invalid_argument if the field gives a force that is not finite
std::array<double, 3> applied_acceleration(const WorldState& state, std::uint32_t body,
                                           const JointEnd& motion, double elapsed);

/// How a body goes on over a time in which drag acts against its speed as it falls. Drag is part of the
/// inertia then, so that it does not turn a body back, however steep it is, nor pull on what contacts hold.
struct DampedMotion {
  std::array<double, 3>
      acceleration;    ///< mean, without contacts and joints; `applied_acceleration` without drag
  double linear = 1;   ///< inverse mass over what there is of it without drag
  double angular = 1;  ///< the same of the inverse inertia
};

/// @param motion           in which forces are taken
/// @param elapsed          of `motion`, since the beginning of the step [s]
/// @param velocity_before  where the time `h` [s] begins
DampedMotion damped_motion(const WorldState& state, std::uint32_t body, const JointEnd& motion,
                           double elapsed, const std::array<double, 3>& velocity_before, double h);

/// The forces of the middle of a time `h` [s] in which the island's velocities change evenly from `before` to
/// `after`: they become the accelerations of the world's state.
/// @param elapsed  since the beginning of the step [s]
/// @param damping  becomes what drag makes of the inverse masses, as factors by body
void take_forces(WorldState& state, const Island& island, double elapsed, double h,
                 const std::vector<Velocity>& before, const std::vector<Velocity>& after,
                 std::vector<InverseMass>& damping);

/// Whether the field swings a body of the island faster than a piece of such length can follow where it is
/// cut again and again, w h > 0.7, as what it does half-way (by `take_forces`) tells against what it does
/// now.
bool field_swings_fast(const WorldState& state, const Island& island, double elapsed, double h,
                       const std::vector<Velocity>& before, const std::vector<Velocity>& after);

/// The length [s] in which drag takes no more than half of a speed; infinity where it takes less than that of
/// it within a time `left` [s], or the body goes no farther than a fiftieth of its size: with the mean of
/// its velocities a piece takes a body half-way to where it came without drag, however soon that stops it.
double stable_length_of_drag(const WorldState& state, const Island& island, double elapsed, double left);

/// Makes that drag part of the inertia of a system.
void damp(IslandSystem& system, const std::vector<InverseMass>& damping);

/// What `take_forces` does, for one body that will fly freely for a time `h` [s], in the middle of that
/// flight.
/// @return false where that leaves the numbers
bool take_forces_of_flight(WorldState& state, std::uint32_t body, double elapsed, double h);

/// Accelerations that `take_forces` found are without contacts and joints. What these did to the velocities
/// met drag, too: it becomes part of the accelerations, so that m a is the force that did work.
void take_drag_of_impulses(WorldState& state, const Island& island, double h,
                           const std::vector<Velocity>& before, const std::vector<Velocity>& after,
                           const std::vector<InverseMass>& damping);

/// Means over the last step of what changed within it, for a dynamic body: exact where the body moved evenly,
/// else right to the first order.
struct VaryingForces {
  Wrench field, drag;
};
/// @pre the body was in that step
VaryingForces varying_forces(const WorldState& state, std::uint32_t body);

/// True if velocities left the numbers, as under a field that is too steep for the step: the world contains
/// bodies whose velocities are no numbers, and nothing is to be found on their ways.
bool are_lost(WorldState& state, const Island& island, const std::vector<Velocity>& after);

}  // namespace skerry
