// SPDX-License-Identifier: MIT
//
// How many steps a frame makes: playing or paused, faster or slower than the clock on the wall.
#pragma once

#include <cstdint>

namespace skerry::sandbox {

class TimeControl {
 public:
  bool playing() const { return playing_; }
  void play(bool on);
  void toggle() { play(!playing_); }

  /// Seconds of the world in a second on the wall: a power of two from 1/64 to 16.
  double speed() const { return speed_; }
  void faster();
  void slower();
  void normal() { speed_ = 1; }

  /// Steps that are due after `seconds` on the wall, with steps of `dt`. Fractions are carried over. When the
  /// machine cannot follow, time is lost instead of piling up: at most a tenth of a second is made up for.
  std::uint64_t steps_for(double seconds, double dt);

 private:
  bool playing_ = true;
  double speed_ = 1;
  double owed_ = 0;  ///< time of the world that no step was made for yet [s]
};

}  // namespace skerry::sandbox
