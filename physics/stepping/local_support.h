// SPDX-License-Identifier: MIT
//
// What can be told of rest without solving for it.
#pragma once

#include <vector>

#include "physics/islands/island_system.h"
#include "physics/stepping/island_rows.h"

namespace skerry {

class ThreadPool;

/// True if each body could be stopped by impulses of its own rows, whatever those did to the others: without
/// that there are no forces that hold them all. Of each body the velocity is projected onto the cone of what
/// its rows can take away, non-negative least squares in three components [Lawson & Hanson 1974, chapter 23].
/// Rows of joints that have bounds, and of rolling, count as if they had none.
/// @param free    by body, its velocity without the rows [m/s, m/s, rad/s]
/// @param radius  by body: what turns its ends [m]
/// @param slow    sqrt(v^2 + (radius omega)^2) that counts as stopped [m/s]
bool each_can_be_stopped(const IslandSystem& system, const std::vector<Velocity>& free,
                         const std::vector<double>& radius, double slow, ThreadPool* threads);

}  // namespace skerry
