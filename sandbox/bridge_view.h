// SPDX-License-Identifier: MIT
//
// A bridge of a script and how it wants to be shown.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "physics/statics/bridge.h"

namespace skerry::sandbox {

struct BridgeView {
  std::unique_ptr<statics::Bridge> bridge;
  bool numbers = false;                          ///< write the force on every member
  std::optional<statics::Quantity> influence{};  ///< whose influence line the panel shows
};

/// What the supports of a bridge that stands do to it; none when it moves.
std::span<const statics::Reaction> standing_reactions(const statics::Bridge& bridge);

inline constexpr std::size_t kMomentSections = 12;
/// Bending moments of a member at equal distances from a to b [N m].
using BendingMoments = std::array<double, kMomentSections + 1>;
/// Those of all members while the bridge stands; zero for bars and for what is broken.
std::vector<BendingMoments> bending_moments(const statics::Bridge& bridge);

}  // namespace skerry::sandbox
