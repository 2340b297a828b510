// SPDX-License-Identifier: MIT
//
// Sleep: islands whose step maps them onto themselves bit by bit leave the working set. A step costs nothing
// for them, and because their step would have changed nothing, a world with sleep has the same bits as one
// without. What could change their step wakes them: a touch, a force, a new pose of what they rest on, other
// gravity, another length of the step.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/contact.h"
#include "physics/islands/island_builder.h"
#include "physics/resting.h"

namespace skerry {

struct WorldState;
class Archive;

/// What sleeping islands add to the counts of a step report.
struct SleepTotals {
  int islands = 0, bodies = 0;
  int pairs = 0, contacts = 0, contact_points = 0, pairs_out_of_reach = 0;
  int rows = 0, friction_rows = 0, inexact = 0;
  double worst_residual = 0;
  double worst_penetration = 0;                     ///< [m]
  double normal_impulse = 0, friction_impulse = 0;  ///< of a step [N s]
};

/// An island outside the working set, with everything that it needs to go on as if nothing had been.
struct SleepingIsland {
  std::vector<std::uint32_t> bodies, joints;  ///< slots, ascending; none: this place is free
  std::vector<Contact> contacts;              ///< by key; near ones that do not touch, too
  std::vector<IslandMemory> memories;
  RestingIsland rest;
  /// Other islands that keep contacts of these bodies (a contact of two sleepers lies with the one that fell
  /// asleep later).
  std::vector<std::uint32_t> keepers;
  SleepTotals totals;
};

/// All sleeping islands of a world.
class Sleepers {
 public:
  bool none() const { return free_places_.size() == islands_.size(); }
  const SleepTotals& totals();
  /// By place; those without bodies are free.
  std::span<const SleepingIsland> islands() const { return islands_; }
  double h() const { return h_; }  ///< length of the step under which they sleep [s]

  /// An island that fell asleep in this step.
  struct Candidate {
    const Island* island = nullptr;
    RestingIsland rest;
    std::vector<IslandMemory> memories;
  };
  /// Takes islands and their contacts out of the working set.
  void put_to_sleep(WorldState& state, double h, std::vector<Candidate> candidates);

  /// Brings the islands of these bodies back, as they were. @return the bodies that woke, ascending
  std::vector<std::uint32_t> wake(WorldState& state, std::span<const std::uint32_t> bodies);
  void wake_all(WorldState& state);
  /// Wakes what has a contact or a joint with `body`, which does not sleep itself (fixed or kinematic).
  void wake_at(WorldState& state, std::uint32_t body);

 private:
  friend void fields(Archive& archive, Sleepers& sleepers);
  friend bool is_valid(const Sleepers& sleepers, const WorldState& state);

  std::vector<std::uint32_t> wake_places(WorldState& state, std::vector<std::uint32_t> places);
  void grow(const WorldState& state);
  void hold(const WorldState& state, const SleepingIsland& island, int sign);

  std::vector<SleepingIsland> islands_;
  std::vector<std::uint32_t> free_places_;  ///< places of `islands_` that are free
  std::vector<std::int32_t> place_of_;      ///< by body: place in `islands_`, -1: awake
  std::vector<std::uint32_t>
      held_;  ///< by body: contacts and joints of sleepers with this one that cannot sleep
  SleepTotals totals_;
  bool stale_totals_ = false;
  double h_ = 0;
};

/// True if every slot that the sleepers name is there (for snapshots of unknown origin).
bool is_valid(const Sleepers& sleepers, const WorldState& state);

}  // namespace skerry
