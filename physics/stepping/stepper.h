// SPDX-License-Identifier: MIT
//
// Steppers: how an island is brought from the beginning to the end of a step. Each is one file and one
// registry row.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "physics/islands/island_builder.h"
#include "physics/step_report.h"
#include "physics/stepping/path.h"

namespace skerry {

struct WorldState;

/// What a solver keeps for an island between steps, found again by the hash of the island's row sources.
struct IslandMemory {
  std::uint64_t key = 0;
  std::unique_ptr<SolverMemory> memory;
};

/// What a stepper keeps of an island for the next step. It is stored by body, so that it survives mergers: an
/// island takes the most cautious of its bodies' numbers.
struct StepMemory {
  int busy = 0;            ///< steps for which `auto` stays with time_stepping
  int flow = 0;            ///< steps for which the island still counts as in flow
  int light_failures = 0;  ///< exact steps in one piece that failed one after the other
  int light_wait = 0;      ///< calls for which none is tried again
  int near_rest = 0;       ///< steps for which forces that are not quite exact could have held it
  int held = 0;            ///< 1: stopped in flow, and held by such forces
  int stopped = 0;         ///< 1: because it was slow, and held as it is
  double slow = 0;  ///< for so long nothing of the island was faster than `WorldConfig::sleep_speed` [s]
  double inner_step = 0;  ///< length of the last step that error control chose [s]; 0: none yet

  bool operator==(const StepMemory&) const = default;
};

/// The numbers of an `IslandResult`: nothing that owns memory.
struct IslandNumbers {
  IslandReport report;
  int substeps = 0;
  int impacts = 0;
  int reflections = 0;
  int friction_rows = 0;
  int manifolds_reused = 0;
  int force_solves = 0;       ///< evaluations of the forces at acceleration level
  int events_found = 0;       ///< changes of the contact mode that were located within the step
  int mode_changes = 0;       ///< contacts that began or ceased to carry load, to stick or to slip
  int inner_steps = 0;        ///< steps accepted by error control
  int rejected_steps = 0;     ///< inner steps taken again because their error was too large
  int fallbacks = 0;          ///< 1: events gave up, time_stepping made the step
  bool in_flight = false;     ///< nothing to meet: closed form
  bool at_rest = false;       ///< nothing changed since the last step: its result was used again
  int flow_pieces = 0;        ///< of the sub-steps, those in flow
  bool unmoved = false;       ///< a body would leave its reach: to be made again, whatever it meets
  bool one_piece = false;     ///< one exact solve for impacts and forces
  bool bounces_well = false;  ///< flows only where exact steps are dear
  double overlap = 0;         ///< deepest one [m] at the beginning of a step in flow
  SolveWork work;
  SolveWork thrown_away;  ///< of earlier rounds of the step, which had to be made again
  double vain = 0;        ///< visits of that in problems whose answer was not found
  double work_limit = 0;  ///< in visits: what costs more is broken off; 0: none but that of the configuration
  NarrowPhaseStats narrow;
  std::array<double, kStageCount> stage_seconds{};
  StepMemory step_memory;  ///< for the bodies of the island
};

/// What stepping one island produced; merged into the StepReport in the order of the islands.
struct IslandResult : IslandNumbers {
  std::vector<MotionEvent> motion_events;  ///< times since the beginning of the step
  std::vector<IslandTrace> traces;
  std::vector<PathPiece> path;         ///< only with `Observe::paths`
  std::vector<IslandMemory> memories;  ///< solver memories to keep for the next step

  void clear() {
    static_cast<IslandNumbers&>(*this) = {};
    motion_events.clear();
    traces.clear();
    path.clear();
    memories.clear();
  }
};

/// Advances the bodies of `island` by `h` [s]. Touches nothing but these bodies, the island's contacts and
/// joints, and `WorldState::travelled` and `strayed` of its bodies, so islands may be stepped in any order or
/// at the same time.
using StepIslandFn = void (*)(WorldState& state, const Island& island, double h, IslandResult& result);

struct StepperEntry {
  std::string_view name;
  std::string_view summary;
  std::string_view reference;
  StepIslandFn step;
};

std::span<const StepperEntry> steppers();
/// @throws std::invalid_argument that lists the names there are.
const StepperEntry& find_stepper(std::string_view name);

/// Whether an island is in free flight: nothing is in reach, no joint holds it, and no force varies.
bool is_in_flight(const WorldState& state, const Island& island);

/// If it is, or falls with joints that have nothing to do: one flight in closed form. @return false if not
bool fly_freely(WorldState& state, const Island& island, double h, IslandResult& result);

}  // namespace skerry
