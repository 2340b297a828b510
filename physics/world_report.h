// SPDX-License-Identifier: MIT
#pragma once

#include "physics/joint_rows.h"
#include "physics/world_state.h"

namespace skerry {

/// Fills the step report from the islands (in their canonical order) and the contact table, makes the contact
/// events, and sets the joints' reactions. Islands that are kept count as they did in the last step.
void write_report(WorldState& state, double h);

/// A report of a step that was not made. @param cause  see `StepReport::interrupted`
void write_report_of_nothing(WorldState& state, const char* cause);

/// What happened at a contact, of shapes that are there still.
ContactEvent event_of(const WorldState& state, const Contact& contact, ContactEventKind kind);

/// A body as it was half-way through the last step, with the velocity of its end: directions of forces that
/// turn with it are right on the mean. @pre it was in that step
JointEnd halfway(const WorldState& state, std::uint32_t body);

}  // namespace skerry
