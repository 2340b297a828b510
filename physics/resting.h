// SPDX-License-Identifier: MIT
//
// Islands at rest: a step maps their state, impulses included, onto itself bit by bit. While nothing of the
// input changes the map need not be evaluated again; contact forces stay exact and visible at no cost.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "physics/stepping/stepper.h"

namespace skerry {

/// What is known of an island whose last step changed nothing.
struct RestingIsland {
  std::uint64_t key = 0;  ///< of everything that a step of it reads
  IslandReport report;
  int friction_rows = 0;
  std::vector<std::uint64_t> memory_keys;
  std::vector<double> strayed;  ///< of its bodies, from the ways on which nothing strikes them [m]
};

/// Whether no body moved in this step, nor did before.
bool stood_still(const WorldState& state, const Island& island);

/// Hash of the bits that a step of `island` reads: states, masses, accelerations, what steppers keep,
/// contacts, joints and `h`.
std::uint64_t resting_key(const WorldState& state, const Island& island, double h);

/// If the island was at rest under the same input, fills `result` as the last step did and returns true.
bool reuse_resting(WorldState& state, const Island& island, double h, IslandResult& result);

/// What to remember of the island for the next step, if this one changed neither its state nor its impulses.
std::optional<RestingIsland> remember_resting(const WorldState& state, const Island& island, double h,
                                              const IslandResult& result);

}  // namespace skerry
