// SPDX-License-Identifier: MIT
#include "sandbox/loop.h"

#include <cmath>

#include "sandbox/io.h"

namespace skerry::sandbox {

std::uint64_t frame_count(const Demo& demo, const LoopClock& clock) {
  const double frames = static_cast<double>(demo.total_steps()) * demo.dt() * clock.fps / clock.speed;
  return static_cast<std::uint64_t>(std::ceil(frames - 1e-6));
}

bool run_loop(Demo& demo, const LoopClock& clock, const LoopCallbacks& callbacks) {
  const std::uint64_t steps = demo.total_steps();
  const std::uint64_t frames = clock.fps > 0 ? frame_count(demo, clock) : 0;
  std::uint64_t frame = 0;
  bool moved = true;
  for (;;) {
    // Frames whose time comes before the next step. The times are products, not sums, so they do not drift;
    // the small shift keeps frame k on step k when both have the same rate.
    while (frame < frames && static_cast<double>(frame) * clock.speed / clock.fps <
                                 (static_cast<double>(demo.steps_done()) + 1 - 1e-6) * demo.dt()) {
      if (callbacks.frame) callbacks.frame(demo, moved);
      moved = false;
      ++frame;
      if (interrupted()) return false;
    }
    if (demo.steps_done() >= steps) break;
    demo.step();
    moved = true;
    if (callbacks.step) callbacks.step(demo);
    if (interrupted()) return false;
  }
  demo.finish();
  return true;
}

}  // namespace skerry::sandbox
