// SPDX-License-Identifier: MIT
//
// What ends a contact mode, and when: roots along a flight, or in the continuous output of an inner step.
#pragma once

#include <vector>

#include "physics/narrowphase/time_of_impact.h"
#include "physics/stepping/acceleration.h"
#include "physics/stepping/runge_kutta.h"
#include "physics/stepping/stage_values.h"

namespace skerry {

/// Something that falls to zero when the mode ends.
struct ModeWatch {
  MotionEventKind kind = MotionEventKind::Landing;
  std::size_t index = 0;  ///< of the point, grip or joint row of the mode; Landing: of the island's contact
};

/// The first event of an inner step.
struct ModeEvent {
  bool found = false;
  double theta = 1;  ///< share of the inner step
  ModeWatch watch;
};

/// The first event of a flight; at most one of the two is there.
struct FlightEnd {
  double length = 0;  ///< [s]; without an event all that was asked for
  const Contact* landing = nullptr;
  const JointRecord* limit = nullptr;
};

/// Locates the events of an island. Holds references to all it is given, which may change between the calls.
class ModeEvents {
 public:
  ModeEvents(const WorldState& state, const Island& island, const AccelerationProblem& problem,
             const ContactMode& mode)
      : state_(state), island_(island), problem_(problem), mode_(mode) {}

  /// What can end the mode. @param forces  of the mode
  std::vector<ModeWatch> watches(const ModeForces& forces) const;
  double value(const ModeWatch& watch, const ModeForces& forces) const;
  /// Keeps the values at a stage of the inner step, if they may be of use.
  void note_stage(double t, const std::vector<ModeWatch>& watched, const ModeForces& forces,
                  StageValues& stages) const;

  /// Of bodies on which nothing but their external forces acts. @param length  of the flight at most [s]
  FlightEnd end_of_flight(double elapsed, double length) const;

  /// The first event of the inner step that was tried last.
  /// @param begin, end  forces at its two ends
  /// @param stages  what was watched between them
  /// @return false if there is one that cannot be located
  bool find(RungeKutta& method, const std::vector<ModeWatch>& watched, double elapsed,
            const ModeForces& begin, const ModeForces& end, const StageValues& stages,
            ModeEvent& event) const;

  /// What looking for landings cost so far, in units of `AccelerationProblem::work`.
  double work() const { return work_; }

 private:
  const Contact& contact_at(std::size_t k) const;
  bool is_loaded(const Grip& grip) const;
  bool is_force(const ModeWatch& watch) const;
  bool lingers(const Contact& contact, double elapsed) const;
  double open_gap(const Contact& contact, int child, const Transform& a, const Transform& b) const;
  double open_gap_beside(const Contact& contact, const Transform& a, const Transform& b) const;
  double gap_speed(const Contact& contact, double elapsed, double h, const ModeForces& forces) const;
  bool find_roots(RungeKutta& method, const std::vector<ModeWatch>& watched, const ModeForces& begin,
                  const ModeForces& end, const StageValues& stages, ModeEvent& event) const;
  bool find_landings(RungeKutta& method, double elapsed, const ModeForces& begin, ModeEvent& event) const;

  const WorldState& state_;
  const Island& island_;
  const AccelerationProblem& problem_;
  const ContactMode& mode_;
  mutable double work_ = 0;  ///< see `work`
};

}  // namespace skerry
