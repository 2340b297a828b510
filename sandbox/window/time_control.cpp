// SPDX-License-Identifier: MIT
#include "sandbox/window/time_control.h"

#include <algorithm>
#include <cmath>

namespace skerry::sandbox {
namespace {

constexpr double kSlowest = 1.0 / 64, kFastest = 16;
constexpr double kMostSeconds = 0.1;  // on the wall

}  // namespace

void TimeControl::play(bool on) {
  playing_ = on;
  owed_ = 0;
}

void TimeControl::faster() {
  speed_ = std::min(kFastest, 2 * speed_);
}

void TimeControl::slower() {
  speed_ = std::max(kSlowest, 0.5 * speed_);
}

std::uint64_t TimeControl::steps_for(double seconds, double dt) {
  if (!playing_ || !(seconds > 0)) return 0;
  owed_ += std::min(seconds, kMostSeconds) * speed_;
  // The small shift keeps a step a frame when both have the same rate.
  const double steps = std::floor(owed_ / dt + 1e-6);
  owed_ = std::max(0.0, owed_ - steps * dt);
  return static_cast<std::uint64_t>(steps);
}

}  // namespace skerry::sandbox
