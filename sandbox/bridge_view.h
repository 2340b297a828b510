// SPDX-License-Identifier: MIT
//
// A bridge of a script and how it wants to be shown.
#pragma once

#include <memory>
#include <optional>

#include "physics/statics/bridge.h"

namespace skerry::sandbox {

struct BridgeView {
  std::unique_ptr<statics::Bridge> bridge;
  bool numbers = false;                          ///< write the force on every member
  std::optional<statics::Quantity> influence{};  ///< whose influence line the panel shows
};

}  // namespace skerry::sandbox
