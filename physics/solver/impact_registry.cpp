// SPDX-License-Identifier: MIT
#include <array>

#include "physics/registry.h"
#include "physics/solver/impact_laws.h"

namespace skerry {
namespace {

constexpr std::array<ImpactLawEntry, 3> kLaws{{
    {"reflections", "contacts act while they approach: k balls in, k balls out; energy never grows",
     "Smith, Kaufman, Vouga, Tamstorf & Grinspun 2012", false, impact::apply_reflections},
    {"poisson", "compression, then expansion by e times the compression impulse", "Glocker & Pfeiffer 1995",
     true, impact::apply_poisson},
    {"simultaneous", "Newton's u+ = -e u- at every contact in one solve; can create energy", "Moreau 1988",
     true, impact::apply_simultaneous},
}};

}  // namespace

std::span<const ImpactLawEntry> impact_laws() {
  return kLaws;
}

const ImpactLawEntry& find_impact_law(std::string_view name) {
  return find_entry("impact law", name, impact_laws());
}

}  // namespace skerry
