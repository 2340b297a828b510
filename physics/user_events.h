// SPDX-License-Identifier: MIT
//
// Events of the caller's own: functions of the motion, whose sign changes are located within the step.
//
//   skerry::UserEvents events;
//   events.add([&](double t) { return world.interpolated(ball, t).position.y - 2; },
//              [](double t, bool rising) { ... });
//   world.observe({.paths = true});
//   for (;;) {
//     world.step(h);
//     events.look(world);
//   }
#pragma once

#include <functional>
#include <vector>

#include "physics/handle.h"

namespace skerry {

class World;

/// A quantity at a time [s] of the world within its last step, made of `World::interpolated`. It must depend
/// on the motion and the time alone: it is asked several times, in no order.
using EventMeasure = std::function<double(double time)>;
/// What is done when the quantity changes its sign at `time` [s]. @param rising  from below zero to above
using EventAction = std::function<void(double time, bool rising)>;

/// Watches quantities and calls actions at their roots. Needs `Observe::paths`.
///
/// Roots are located to 1e-14 of the step, in the paths that the steppers give: exact in flight, to the
/// accuracy of the integration in `event_driven`, of second order in `time_stepping`. At a jump (an impact)
/// the root is the time of the jump. Each step is looked at in eight parts; of a quantity that changes its
/// sign twice within one of them nothing is noticed.
class UserEvents {
 public:
  /// @return a number that `remove` takes
  /// @throws std::invalid_argument if one of the functions is empty
  int add(EventMeasure measure, EventAction action);
  /// @throws std::invalid_argument for a number that is not in use
  void remove(int number);
  /// Looks at the last step of `world`, and calls the actions of all roots in it in the order of time (at one
  /// time in the order of their numbers). Actions may change the world, add and remove: all that counts from
  /// the next step on. What a function throws comes through; the actions that were left are not called.
  /// @return how many actions were called
  /// @throws std::invalid_argument if the paths of the last step were not observed and anything is watched
  int look(const World& world);

 private:
  struct Watched {
    int number;
    EventMeasure measure;
    EventAction action;
  };
  std::vector<Watched> watched_;
  int next_ = 0;
  double looked_ = 0;  ///< end of the step that was looked at last [s]
};

}  // namespace skerry
