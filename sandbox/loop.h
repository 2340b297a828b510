// SPDX-License-Identifier: MIT
//
// The one loop of the app: steps a demo and calls out for each step and each frame. A run without pictures
// has no frames; a capture has them at fixed times.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "sandbox/demo.h"

namespace skerry::sandbox {

struct LoopClock {
  double fps = 0;    ///< frames a second of the video; 0: no frames
  double speed = 1;  ///< seconds of the world in a second of the video
  /// Ends with the first step that reaches this time, before or after the demo's own end [s]. The demo keeps
  /// its length: time axes show how much of it that is.
  std::optional<double> until{};
};

struct LoopCallbacks {
  /// After each step.
  std::function<void(Demo&)> step;
  /// For each frame in order; `Demo::shown` is the world at its time.
  std::function<void(const Demo&)> frame;
};

/// Number of frames of the whole demo, at least 1.
std::uint64_t frame_count(const Demo& demo, const LoopClock& clock);

/// Runs the demo to its end, or to `until`, then evaluates what waits for the end. Frame k shows the world at
/// time k * speed / fps, between steps by `World::interpolated`. Stops early on Ctrl-C.
/// @return whether it came to the end
bool run_loop(Demo& demo, const LoopClock& clock, const LoopCallbacks& callbacks);

}  // namespace skerry::sandbox
