// SPDX-License-Identifier: MIT
#pragma once

#include "physics/solver/impact_law.h"

namespace skerry::impact {

ImpactResult apply_reflections(const ImpactProblem& problem);
ImpactResult apply_simultaneous(const ImpactProblem& problem);
ImpactResult apply_poisson(const ImpactProblem& problem);

}  // namespace skerry::impact
