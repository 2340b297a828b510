// SPDX-License-Identifier: MIT
//
// Error control for time stepping.
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// Makes a step of time_stepping out of inner steps whose length follows an error estimate: each is made once
/// as a whole and once with each of its pieces in halves; for a method of order 2 a third of the difference
/// is the error of the halves, which are kept [Hairer, Norsett & Wanner 1993, sec. II.4].
///
/// A smooth inner step of length d may have the error `accuracy` * d / (1 s), so errors add up to about
/// `accuracy` in a second; one in which contacts open, close, stick or slip, where the order is lost, a tenth
/// of `accuracy`. Errors are those of positions and velocities, relative above 1 (SI units). Below a
/// millionth of the step a length is taken as it is; `IslandReport::error_estimate` then shows what it cost.
void step_with_error_control(WorldState& state, const Island& island, double h, double accuracy,
                             IslandResult& result);

}  // namespace skerry
