// SPDX-License-Identifier: MIT
//
// Mechanisms in words: which node moves, and which way.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "physics/statics/structure_solver.h"

namespace skerry::statics {

/// "to the left", "up and to the right", ...: the nearest of eight directions.
std::string direction_word(Vec2 direction);

/// Turns a null vector of A^T into displacements of the nodes and a sentence about the one that moves most.
/// @param row_of  by node: its components in `motion` (those beyond its end are held), or -1
/// @param axes  by node: the frame of its components
/// @param arm  length [m] that a rotation was multiplied with
Mechanism describe_mechanism(const Structure& structure, const std::vector<std::array<int, 3>>& row_of,
                             const std::vector<Rot>& axes, double arm, const std::vector<double>& motion);

}  // namespace skerry::statics
