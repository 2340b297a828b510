// SPDX-License-Identifier: MIT
//
// Impacts of an island at one instant, the same for all steppers.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "physics/stepping/stepper.h"

namespace skerry {

struct ImpactOptions {
  /// Second derivative of the gap of point `point` of contact `contact` under the external forces [m/s^2]. If
  /// given, bounces too low to be told from contact are not carried out one by one (see `SettledContact`).
  std::function<double(std::uint32_t contact, int point)> normal_acceleration;
  double work_limit = 0;  ///< in visits; 0: none but that of the configuration
  /// Contacts that approach more slowly than this do not bounce, but for those that lose nothing [m/s].
  double slow = 0;
};

/// A contact whose further bounces, infinitely many, are summed: it closes now, and the last of them would
/// have ended `rest` [s] later, by the geometric series 2 e u / (g (1 - e)).
struct SettledContact {
  std::uint32_t contact = 0;
  double rest = 0;
};

struct ImpactOutcome {
  bool applied = false;
  bool spent = false;  ///< not exact, for want of work
  std::vector<SettledContact> settled;
};

/// Whether a contact touches and approaches, or a joint may have come to its limit.
bool is_struck(const WorldState& state, const Island& island, double elapsed);

/// Contacts that touch and approach bounce by the world's impact law; forces do not act meanwhile.
/// @param elapsed  since the beginning of the step [s]
ImpactOutcome apply_impact(WorldState& state, const Island& island, double elapsed,
                           const ImpactOptions& options, IslandResult& result);

}  // namespace skerry
