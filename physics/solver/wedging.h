// SPDX-License-Identifier: MIT
//
// Impulses that bodies exert on each other beyond what their motion takes. Where friction holds a body
// between others, Coulomb's law allows it to press against them as hard as one likes: such answers are
// solutions, but nobody wants one of 20 000 N s where 120 do.
#pragma once

#include "physics/islands/island_system.h"

namespace skerry {

/// Returns how many times the largest normal impulse is larger than all that could call for it: the momenta
/// that the impulses give to the bodies, and those of motors of finite strength and of springs. Some units
/// where bodies lean on each other, more in flat arches; 0 without normal impulses.
double self_made_share(const IslandSystem& system, const std::vector<double>& lambda);

/// Self-made shares above this are looked into: whether smaller impulses do.
inline constexpr double kMostSelfMade = 16;

/// Whether the impulses are large beside b and mostly self-made. One pass over the rows where they are not
/// large.
bool is_wedged(const IslandSystem& system, const std::vector<double>& lambda);

/// Returns the sum of W_ii lambda_i^2, by which answers with the same residual are compared.
double size_of_impulses(const IslandSystem& system, const std::vector<double>& lambda);

}  // namespace skerry
