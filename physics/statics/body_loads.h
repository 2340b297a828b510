// SPDX-License-Identifier: MIT
//
// Loads on the bodies of a system.
#pragma once

#include <array>
#include <vector>

namespace skerry::statics {

/// Force and torque on each body, about its centre of mass, world frame [N, N, N m].
using BodyLoads = std::vector<std::array<double, 3>>;

}  // namespace skerry::statics
