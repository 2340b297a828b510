// SPDX-License-Identifier: MIT
#include "sandbox/loop.h"

#include <algorithm>
#include <cmath>

#include "sandbox/io.h"

namespace skerry::sandbox {

std::uint64_t frame_count(const Demo& demo, const LoopClock& clock) {
  const double frames = static_cast<double>(demo.total_steps()) * demo.dt() * clock.fps / clock.speed;
  // Only slow motion of an endless run has more.
  constexpr double kMost = 1e18;
  // The first one shows the beginning, however short the rest is.
  return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(std::min(frames, kMost) - 1e-6)));
}

bool run_loop(Demo& demo, const LoopClock& clock, const LoopCallbacks& callbacks) {
  const std::uint64_t steps = clock.until ? steps_until(*clock.until, demo.dt()) : demo.total_steps();
  const std::uint64_t frames = clock.fps > 0 ? frame_count(demo, clock) : 0;
  std::uint64_t frame = 0;
  // Between two steps the picture shows what the stepper knows of the motion there.
  const double frames_per_step = frames > 0 ? demo.dt() * clock.fps / clock.speed : 1;
  const double steps_per_frame = 1 / frames_per_step;
  if (std::abs(steps_per_frame - std::round(steps_per_frame)) > 1e-6 * steps_per_frame) demo.keep_paths();
  for (;;) {
    // Frames up to the present. Their times are products, not sums, so they do not drift; the small shift
    // keeps frame k on step k when both have the same rate.
    for (; frame < frames; ++frame) {
      const double time = static_cast<double>(frame) * clock.speed / clock.fps;
      if (time > demo.time() + 1e-6 * demo.dt()) break;
      demo.show_at(std::min(time, demo.time()));
      if (callbacks.frame) callbacks.frame(demo);
      if (interrupted()) return false;
    }
    if (demo.steps_done() >= steps) break;
    demo.step();
    if (callbacks.step) callbacks.step(demo);
    if (interrupted()) return false;
  }
  demo.finish();
  return true;
}

}  // namespace skerry::sandbox
