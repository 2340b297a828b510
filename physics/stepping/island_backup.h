// SPDX-License-Identifier: MIT
//
// The part of a world that a step of one island writes, kept so that the step can be made again.
#pragma once

#include <vector>

#include "physics/islands/island_builder.h"
#include "physics/spare.h"
#include "physics/world_state.h"

namespace skerry {

/// Bodies, contacts and joints of an island as they were.
class IslandBackup {
 public:
  IslandBackup(const WorldState& state, const Island& island) {
    const BodyArrays& all = state.bodies;
    for (const std::uint32_t i : island.bodies) {
      bodies_->push_back({all.position[i], all.angle[i], all.rotation[i], all.velocity[i], all.omega[i]});
      travelled_->push_back(state.travelled[i]);
      strayed_->push_back(state.strayed[i]);
    }
    for (const std::uint32_t i : island.contacts) contacts_->push_back(state.contacts[i]);
    for (const std::uint32_t i : island.joints) joints_->push_back(state.joints[i]);
  }

  void restore(WorldState& state, const Island& island) const {
    BodyArrays& all = state.bodies;
    for (std::size_t k = 0; k < bodies_->size(); ++k) {
      const std::uint32_t i = island.bodies[k];
      all.position[i] = (*bodies_)[k].position;
      all.angle[i] = (*bodies_)[k].angle;
      all.rotation[i] = (*bodies_)[k].rotation;
      all.velocity[i] = (*bodies_)[k].velocity;
      all.omega[i] = (*bodies_)[k].omega;
      state.travelled[i] = (*travelled_)[k];
      state.strayed[i] = (*strayed_)[k];
    }
    for (std::size_t k = 0; k < contacts_->size(); ++k) state.contacts[island.contacts[k]] = (*contacts_)[k];
    for (std::size_t k = 0; k < joints_->size(); ++k) state.joints[island.joints[k]] = (*joints_)[k];
  }

 private:
  Spare<std::vector<BodyBackup>> bodies_;
  Spare<std::vector<double>> travelled_, strayed_;
  Spare<std::vector<Contact>> contacts_;
  Spare<std::vector<JointRecord>> joints_;
};

}  // namespace skerry
