// SPDX-License-Identifier: MIT
#include "tests/bench/accuracy/problem.h"

#include <cmath>
#include <iterator>

#include "tests/bench/accuracy/options.h"

namespace skerry::bench {

bool simulate(const Trial& trial, const Scene& scene, double seconds, Outcome& outcome,
              const std::function<bool(Engine&, double)>& look, bool forces) {
  const double start = thread_seconds();
  const auto engine = trial.engine->make(scene, trial.setting);
  if (forces) engine->watch_forces();
  const int steps = static_cast<int>(std::lround(seconds / trial.setting.dt));
  int done = 0;
  bool good = true;
  while (done < steps && good) {
    engine->step();
    ++done;
    const bool on = look(*engine, done * trial.setting.dt);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].fixed) continue;
      const BodyState state = engine->state(static_cast<int>(i));
      good = good && is_finite(state.position) && is_finite(state.velocity);
    }
    if (!on) break;
    if (thread_seconds() - start > trial.time_limit) {
      outcome.gave_up = true;
      good = false;
    }
  }
  outcome.runs.push_back({scene, done});
  return good;
}

double displacement(const Scene& scene, const Engine& engine) {
  double worst = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed) continue;
    worst = std::max(worst, length(engine.state(static_cast<int>(i)).position - scene.bodies[i].position));
  }
  return worst;
}

const std::vector<Problem>& problems() {
  static const std::vector<Problem> all = [] {
    std::vector<Problem> list;
    for (auto part : {impact_problems, motion_problems, rest_problems, joint_problems}) {
      std::vector<Problem> some = part();
      std::move(some.begin(), some.end(), std::back_inserter(list));
    }
    return list;
  }();
  return all;
}

const std::vector<EngineEntry>& engines() {
  static const std::vector<EngineEntry> all = [] {
    std::vector<EngineEntry> list = {skerry_entry()};
#ifdef SKERRY_WITH_BOX2D
    list.push_back(box2d_entry());
#endif
#ifdef SKERRY_WITH_BOX2D3
    list.push_back(box2d3_entry());
#endif
#ifdef SKERRY_WITH_CHIPMUNK
    list.push_back(chipmunk_entry());
#endif
#ifdef SKERRY_WITH_BULLET
    list.push_back(bullet_entry());
#endif
#ifdef SKERRY_WITH_ODE
    list.push_back(ode_entry());
#endif
    return list;
  }();
  return all;
}

}  // namespace skerry::bench
