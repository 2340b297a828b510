// SPDX-License-Identifier: MIT
#include "sandbox/traces.h"

#include <algorithm>
#include <cmath>

namespace skerry::sandbox {
namespace {

/// Points of the path in a step that is known throughout: a ball that bounces within it turns there.
constexpr int kPointsPerStep = 4;

}  // namespace

Traces::Traces(const Demo& demo) {
  find(demo);
  look(demo, demo.time());
  seen_ = demo.time();
}

void Traces::find(const Demo& demo) {
  const auto add = [&](const TracedPoint& point) {
    const bool known =
        std::any_of(traces_.begin(), traces_.end(), [&](const Trace& trace) { return trace.point == point; });
    if (!known && traces_.size() < kMostTraces) traces_.push_back({point, {}, {}});
  };
  const Picture& picture = demo.picture();
  for (const TracedPoint& point : picture.traced) add(point);
  if (!picture.traced.empty()) return;
  const World& world = demo.world();
  const BodyArrays& bodies = world.bodies();
  for (std::size_t i = 0; i < bodies.size() && traces_.size() < kMostTraces; ++i)
    if (bodies.alive[i] && bodies.type[i] == BodyType::Dynamic) add({world.body_id(i), {}});
}

void Traces::look(const Demo& demo, double time) {
  const double strobe = demo.picture().strobe;
  // The flash at this moment, if there is one: moments are products, and so may be off by rounding.
  const bool flash = strobe > 0 && std::abs(time - strobe * std::round(time / strobe)) <= 1e-5 * demo.dt();
  for (Trace& trace : traces_) {
    if (!demo.world().alive(trace.point.body)) continue;
    const BodyState state = demo.state_at(trace.point.body.index, time);
    const Vec2 at = to_world(state.pose(), trace.point.local);
    trace.path.add({time, at});
    if (flash) trace.strobes.add({time, state.pose(), state.angle, at});
  }
}

void Traces::update(const Demo& demo) {
  find(demo);
  const double begin = seen_, end = demo.time();
  const int parts = demo.knows_paths() ? kPointsPerStep : 1;
  std::vector<double> moments;
  for (int k = 1; k < parts; ++k) moments.push_back(begin + (end - begin) * k / parts);
  if (const double strobe = demo.picture().strobe; strobe > 0) {
    const double slack = 1e-6 * (end - begin);
    for (double k = std::floor((begin + slack) / strobe) + 1; k * strobe < end - slack; ++k)
      moments.push_back(k * strobe);
  }
  std::sort(moments.begin(), moments.end());
  const auto same = [&](double one, double other) { return other - one <= 1e-6 * (end - begin); };
  moments.erase(std::unique(moments.begin(), moments.end(), same), moments.end());
  for (const double moment : moments) look(demo, moment);
  look(demo, end);
  seen_ = end;
}

std::size_t Traces::bytes() const {
  std::size_t sum = 0;
  for (const Trace& trace : traces_)
    sum += sizeof(Trace) + trace.path.samples().size() * sizeof(TracePoint) +
           trace.strobes.samples().size() * sizeof(StrobePose);
  return sum;
}

}  // namespace skerry::sandbox
