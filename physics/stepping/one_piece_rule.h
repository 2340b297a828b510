// SPDX-License-Identifier: MIT
//
// Which islands make their step in one piece (physics/stepping/one_piece.h) instead of going from landing to
// landing: those in flow, where many contacts slide, land or part within the step, and those that are but
// lightly disturbed, where all of that is slow.
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// `StepMemory::flow` of bodies whose island flows in this step if it may at all.
inline constexpr int kMustFlow = 3;
/// The same of bodies whose joints an exact step left apart: their island flows until they are together.
inline constexpr int kParted = 4;

struct OnePieceRule {
  bool flows = false;         ///< with a bounded amount of work
  bool light = false;         ///< exactly, where that can be had; tried first
  bool large = false;         ///< so are impacts; where no exact answer can be had, it flows
  bool bounces_well = false;  ///< it flows only where exact steps are dear, however often they were cut
  /// Work in visits after which exact forces are given up; 0 if it may not flow.
  double work_limit = 0;
  /// The same of work beside joints in vain: where they jam no answer is found, however often it is asked
  /// for.
  double vain_limit = 0;
  /// Pieces after which the rest of the step flows; 0: as many as `WorldConfig::max_impacts_per_step`.
  int most_pieces = 0;
};

/// Counts the contact points that touch, or may within the step; of them those that approach or slide faster
/// than `slow_speed`, those that touch and approach (strikes), and those that land in the step.
///
/// An island with more than 30 points is in flow if a fifth of them are fast or more than 8 land; a twentieth
/// or more than 2 are enough if it flowed in the last step, or was cut into more than 4 pieces. After more
/// than 16 pieces more than 8 points will do, as long as one of them approaches fast; what must flow
/// (`kMustFlow`) does with more than 30. It is lightly disturbed if none is fast, but one strikes or more
/// than 2 land. It is large from 100 points on, without joints. Joints count with the points for the 30,
/// beside more than 8 points; an island that flowed goes on while joints are off by a hundredth of a body's
/// size. Joints that an exact step could not keep together, those of a chain without slack between two walls,
/// flow with or without contacts. Islands with restitution above 0.5 flow only where an exact step costs more
/// than `work_limit`, or, with restitution to 0.9, after the first piece of a large one in which more than 8
/// points land: from then on something rests, and each piece costs all of it (flights are no pieces,
/// `flight_queue.h`). Those that bounce at all are not lightly disturbed; with a solver that is not exact all
/// others of more than 8 points flow.
///
/// In a world too large for more than 1000 visits a body a step in flow costs less than two pieces of an
/// exact one and leaves no deeper overlaps: there, more than 4 points will do for all of that, those that
/// bounce well left out; what is not in flow, and has joints or more than 4 points, flows after a piece if a
/// point is fast, and after 16 if none is; and a large island that nothing holds, a cloud of bodies that
/// drift together, flows instead of being lightly disturbed.
OnePieceRule one_piece_rule(const WorldState& state, const Island& island, double h);

/// True if so many bodies are in each other that most contacts say what others do, as where many were made at
/// one place: more than 1000 points, and more than 24 a body. Where it may, such an island flows whatever it
/// does and whoever steps it, as exact answers to thousands of rows that contradict each other cost seconds.
bool is_crowded(const WorldState& state, const Island& island);

/// True if a body of the island flowed in the last step.
bool was_in_flow(const WorldState& state, const Island& island);

/// True if it flowed in the last step by its motion, and does in this one.
bool flows_on(const WorldState& state, const Island& island, double h);

/// What the largest force changes a velocity in a time `h` [s], and a little [m/s].
double slow_speed(const WorldState& state, const Island& island, double h);

/// What a corner does in a piece of a step that is neither leaving nor landing, in touch tolerances.
struct SmallGaps {
  /// By which it has to get away to have left: some, but in a step that was cut often more, up to one, as
  /// corners that rattle by less only come to rest after hundreds of cuts.
  double hop = 0;
  /// By which it may have come down at the end, beside one that rests, for the projection to lift it: far
  /// less than bodies fall in a step, lest each end of a face that lies down falls in turn, and never stops.
  double sunk = 1;
};
/// @param piece  its number @param h  length of the step [s]
SmallGaps small_gaps(const WorldState& state, const Island& island, double h, int piece);

/// Approach below which nothing bounces in a piece of a step of `h` [s], but for what loses nothing [m/s]. In
/// a step that was cut often, bounces of a pile that die away are most of what cuts it: the lowest ones are
/// left out, and the more, the more pieces there were; in the end those that would last about a step.
/// @param piece  the number of the piece
double slowest_bounce(const WorldState& state, const Island& island, double h, int piece);

/// Reports an island inexact whose joints a step of `h` [s] left off by more than 1e-5 of a body's size, or,
/// if it was exact, whose contacts are so deep in each other; with such joints its bodies are `kParted` after
/// an exact step.
void note_parted(const WorldState& state, const Island& island, double h, IslandResult& result);

/// How often an exact step was cut, as `StepMemory::flow` of the next one: 0 seldom, 1 often, 2 very often.
int restlessness(const IslandResult& result);

/// An exact step failed: the next 1, 2, 4 ... 256 calls do not try; without joints, in a world with less than
/// 1000 visits a body, the next 16, 32 ... 256.
void wait_after_failure(const WorldState& state, const Island& island, StepMemory& memory);

/// Least work of a body [visits] where heavy bodies lie on light ones; else 0.
double work_for_heavy(const WorldState& state, const Island& island);

}  // namespace skerry
