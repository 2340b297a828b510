// SPDX-License-Identifier: MIT
#include <array>
#include <stdexcept>
#include <string>

#include "physics/stepping/event_driven.h"
#include "physics/stepping/stepper.h"
#include "physics/stepping/time_stepping.h"

namespace skerry {
namespace {

constexpr std::array<StepperEntry, 2> kSteppers{{
    {"time_stepping", "fixed steps on velocity level, cut at impacts; second order between events",
     "Moreau 1988; Stewart & Trinkle 1996", step_island_by_time_stepping},
    {"event_driven", "accelerations integrated with error control from one located event to the next",
     "Pfeiffer & Glocker 1996; Hairer, Norsett & Wanner 1993", step_island_by_events},
}};

}  // namespace

std::span<const StepperEntry> steppers() {
  return kSteppers;
}

const StepperEntry& find_stepper(std::string_view name) {
  std::string known;
  for (const StepperEntry& stepper : kSteppers) {
    if (stepper.name == name) return stepper;
    known += known.empty() ? "" : ", ";
    known += stepper.name;
  }
  throw std::invalid_argument("unknown stepper '" + std::string(name) + "'; known: " + known);
}

}  // namespace skerry
