// SPDX-License-Identifier: MIT
//
// Energy and momentum of one island, for what must not change them.
#pragma once

#include <optional>
#include <vector>

#include "physics/islands/island_builder.h"
#include "physics/math.h"
#include "physics/spare.h"
#include "physics/stepping/island_rows.h"

namespace skerry {

struct WorldState;

/// True if no contact or joint of the island is with something that does not react.
bool is_free(const WorldState& state, const Island& island);
/// The same for what may be near, but does not touch: what is there neither pushed in the last solve nor
/// could at once.
bool is_off_ground(const WorldState& state, const Island& island);
/// The same for what did not push in the last solve: its impulses changed no momentum of the island.
bool is_unpushed(const WorldState& state, const Island& island);

/// True if moving ground, motors or springs may bring an island energy.
bool may_be_given_energy(const WorldState& state, const Island& island);

/// Fastest that anything of an island is told to move in a time `h` [s]: ground, conveyors, motors without
/// limit, bodies whose turning nothing changes [m/s].
double told_speed(const WorldState& state, const Island& island, double h);

/// Motion of an island as if it were one body.
struct RigidMotion {
  Vec2 centre, v;
  double omega = 0;
  double inertia = 0;   ///< about the centre [kg m^2]
  double momentum = 0;  ///< angular, about the centre [kg m^2/s]
  Vec2 at(Vec2 p) const { return v + omega * perp(p - centre); }
};

RigidMotion rigid_motion(const WorldState& state, const Island& island);

/// The energy of an island at one moment, kept to see whether what follows creates any.
class IslandEnergy {
 public:
  /// @param known    the work of fields and drag is: by `take_forces` and `take_drag_of_impulses`
  /// @param elapsed  springs to kinematic bodies end where these are then: in the middle of the motion, as
  /// with that their energy changes by what they do to the island [s]
  IslandEnergy(const WorldState& state, const Island& island, bool known = false, double elapsed = 0);
  /// From here on bodies only leave what they are in: forces have done their work.
  void end_motion(const WorldState& state, const Island& island);
  /// Takes what was gained beyond the work of the external forces, of springs, and of motors at most, out of
  /// the motion of the bodies against each other (against the ground, if they touch it), by one factor for
  /// all of them. What is told to move (ground, motors without limit) may have brought what makes every body
  /// four times as fast as that, and lifts them at such a speed; without joints as in `take_push`.
  /// @param h  time since then [s]
  /// @param brought  the most that ground which is told to move did [J], where it is known and there are no
  /// joints
  void take_gain(WorldState& state, const Island& island, double h, std::optional<double> brought = {}) const;
  /// The same of contacts alone, on ground that moves: what that squeezes may have been given what makes
  /// every body 32 times as fast as it is, and no body is faster than that by it; an impact (`h` = 0) also
  /// what turns all of them round. Without a bound what is crushed gets faster with each step.
  void take_push(WorldState& state, const Island& island, double h, std::optional<double> brought = {}) const;
  /// As `take_gain`, where it is more than a hundredth of the energy that moved: pieces of a step are of
  /// second order, and what they are off by comes and goes.
  /// @param brought  work of what is told to move, where the forces that did it are an answer [J]
  /// @param passed   what was gained so far in the step and not taken, with what is now [J]
  void take_much(WorldState& state, const Island& island, double h, double brought, double& passed) const;
  /// Whether as much was gained, whatever what is told to move may have brought.
  bool gained_much(const WorldState& state, const Island& island, double h) const;
  /// Whether more than a thousandth of the energy that moved came or went, but for the work of external
  /// forces.
  bool changed(const WorldState& state, const Island& island, double h) const;
  /// Bounds velocities with which bodies are to move on for a time `h` [s], where they have far more energy
  /// than there is: that of the motion and of springs, and the work of external forces on the way and of
  /// motors, and what is told to move makes of it, as in `take_gain` and `take_push`. Joints that contradict
  /// each other, or are far from where they were, may want any, and so may contacts that are squeezed. By one
  /// factor.
  void bound(WorldState& state, const Island& island, double h, std::vector<Velocity>& after) const;
  /// Gives a projection that was small against the motion the energy from before it and the `work` of its
  /// friction [J], in the same way but in both directions: the midpoint rule keeps the energy of what does
  /// not rub, and so does the whole piece then; that of springs counts. Motors have no part in it. Does
  /// nothing where ground that moves, and holds or touches, may have brought energy.
  void keep(WorldState& state, const Island& island, double work) const;

 private:
  /// What was gained beyond the work of the external forces [J]. @param drag  counts as one of them, by the
  /// accelerations of the world's state; else nothing was gained from it
  double gain(const WorldState& state, const Island& island, bool drag) const;
  /// What was gained beyond the work of the external forces, of springs, and of motors and what is told to
  /// move at most, in a time `h` [J]; 0 where forces do work that is not known.
  /// @param most  fastest that what is told to move makes a body [m/s]
  double unexplained_gain(const WorldState& state, const Island& island, double h, double most) const;
  /// The energy that moved: what there was, and what bodies get from rest in a time `h` [s] [J].
  double moved(const WorldState& state, const Island& island, double h) const;
  /// True for more than a hundredth of the energy that moved.
  bool is_much(const WorldState& state, const Island& island, double h, double gained) const;
  /// True if a body without joints has more energy after a time `h` [s] than all had, but for what is told
  /// to move.
  bool has_more(const WorldState& state, const Island& island, double h) const;
  /// Nothing gets faster than four times what is told to move (32 times without joints), or than with all
  /// energy that there was: a light body would take what a heavy one might have been given.
  /// @param more  energy that came since then [J]
  void slow_down(WorldState& state, const Island& island, double told, double h, double more) const;
  /// True if forces do work that is not known.
  bool is_unknown(const WorldState& state) const;

  struct Place {
    Vec2 position;
    double angle;
  };
  static void note_places(const WorldState& state, const Island& island, std::vector<Place>& places);

  Spare<std::vector<Place>> start_, end_;
  double kinetic_ = 0, springs_ = 0, elapsed_;
  bool known_;
};

}  // namespace skerry
