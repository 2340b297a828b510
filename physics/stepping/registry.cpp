// SPDX-License-Identifier: MIT
#include "physics/registry.h"

#include <array>

#include "physics/stepping/auto.h"
#include "physics/stepping/event_driven.h"
#include "physics/stepping/stepper.h"
#include "physics/stepping/time_stepping.h"

namespace skerry {
namespace {

constexpr std::array<StepperEntry, 3> kSteppers{{
    {"time_stepping", "fixed steps on velocity level, cut at impacts; second order between events",
     "Moreau 1988; Stewart & Trinkle 1996", step_island_by_time_stepping},
    {"event_driven", "accelerations integrated with error control from one located event to the next",
     "Pfeiffer & Glocker 1996; Hairer, Norsett & Wanner 1993", step_island_by_events},
    {"auto", "event_driven for islands with few events in a step, time_stepping for busy ones, and back",
     "Acary & Brogliato 2008, ch. 8", step_island_by_choice},
}};

}  // namespace

std::span<const StepperEntry> steppers() {
  return kSteppers;
}

const StepperEntry& find_stepper(std::string_view name) {
  return find_entry("stepper", name, steppers());
}

}  // namespace skerry
