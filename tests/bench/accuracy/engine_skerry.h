// SPDX-License-Identifier: MIT
//
// Our world from a Scene; scaling looks into its reports.
#pragma once

#include "physics/world.h"
#include "tests/bench/accuracy/engine.h"

namespace skerry::bench {

WorldConfig skerry_config(const Setting& setting);

/// @param bodies  filled: body i of the scene
World make_world(const Scene& scene, WorldConfig config, std::vector<BodyId>& bodies);

}  // namespace skerry::bench
