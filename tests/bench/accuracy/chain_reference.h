// SPDX-License-Identifier: MIT
//
// Where the end of a swinging chain is, from an integration that shares nothing with any engine.
#pragma once

#include "tests/bench/accuracy/scene.h"

namespace skerry::bench {

/// Place of the last body after `seconds` [m]: Lagrange's equations in the angles of the bodies, with no
/// joints to hold (the inertia matrix of a chain has the entries A_ij cos(q_i - q_j)), by the method of Runge
/// and Kutta of order 4 with 4096 and 8192 steps, extrapolated; those two are 6e-9 m from each other.
/// @param scene  bodies that hang on each other by pins, in their order, the first one on the ground; they
/// lie along x
///               at the start, at rest
Vec2 swinging_end(const Scene& scene, double seconds);

}  // namespace skerry::bench
