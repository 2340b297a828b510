// SPDX-License-Identifier: MIT
//
// Bodies that are squeezed along a line, by others that give way only across it.
#pragma once

#include <vector>

#include "physics/stepping/island_rows.h"

namespace skerry {

/// Moves aside what sweeps for a shift left between two others on a line through its corners or its middle:
/// no push along that line parts them, as they need more of it than there is, and the smallest displacement
/// across it does. Every other body of the island goes to the other side.
/// @param shift  of the bodies of the island, where sweeps ended
/// @return whether there was any
bool step_aside(const WorldState& state, const Assembly& assembly, std::vector<Velocity>& shift);

}  // namespace skerry
