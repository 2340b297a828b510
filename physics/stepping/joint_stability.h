// SPDX-License-Identifier: MIT
//
// How long a piece of a time step may be where joints under load turn or shake light bodies.
#pragma once

namespace skerry {

struct Island;
struct WorldState;

/// The length [s] up to which a midpoint piece is stable for the joints of the island; infinity if none of
/// its jointed bodies moves, or if it is `enough` [s] at a glance.
///
/// A force F that pulls at a distance r from the centre of mass acts on the angle like a spring of stiffness
/// F r, and that of a rod, or a taut spring, of length l on its end like one of F / l: the light links of a
/// chain under a heavy load shake at w = sqrt(F r / I). An explicit step must resolve that (w h <= 1; it
/// would blow up at 2) [Hairer, Lubich & Wanner 2006, sec. I.1]. Uses the forces of the last solve.
/// @param starting  bodies at rest count, too: those forces are what sets them going
double stable_length(const WorldState& state, const Island& island, double enough, bool starting = false);
/// The same for its rods, ropes, springs and pulleys alone.
double stable_length_of_rods(const WorldState& state, const Island& island);

/// The length [s] in which bodies turn by half a radian that joints hold away from their centres; infinity
/// where none of them turns by more than 0.8 in a step of length `h` [s].
///
/// Of loads that nobody asked for yet, because a joint is new or its bodies were given another velocity,
/// `stable_length` knows nothing: a bar that is set spinning about a hinge pulls at it with m w^2 r from the
/// first moment on. And where free motion takes it half-way says nothing of where it goes.
double stable_length_of_turns(const WorldState& state, const Island& island, double h);

/// The length [s] in which springs turn so little that this does not stretch them much: along a chord a
/// spring of length l that swings at w, and whose end goes past the other one at a speed v, is stretched by
/// (v h)^2 / (2 l), for which a hundredth of the energy of that speed is spent at h^2 = 0.2 l / (v w).
double stable_length_of_springs(const WorldState& state, const Island& island);

/// Whether a spring of the island swings its bodies faster than a piece of length `h` [s] can follow: w h
/// > 2.
bool swings_fast(const WorldState& state, const Island& island, double h);

}  // namespace skerry
