// SPDX-License-Identifier: MIT
//
// Bridges for tests.
#pragma once

#include "physics/statics/bridge.h"
#include "tests/statics/trusses.h"

namespace skerry::statics::test {

/// A Pratt truss with two axles that come from the left at 4 m/s.
inline BridgeDef truss_bridge(int panels) {
  BridgeDef def;
  def.structure = pratt(panels);
  for (Member& m : def.structure.members) {
    m.strength = 2.35e8;
    m.density = 7850;
  }
  for (int i = 0; i <= panels; ++i) def.deck.push_back(i);
  def.train = {{1e5, 8e4}, {1.5}, 4, -1};
  return def;
}

}  // namespace skerry::statics::test
