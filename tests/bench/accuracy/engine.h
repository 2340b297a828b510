// SPDX-License-Identifier: MIT
//
// Engines behind one interface. Each adapter is one file and one row of `engines()`; it is there only if
// CMake found the engine.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/bench/accuracy/scene.h"

namespace skerry::bench {

struct BodyState {
  Vec2 position{};  ///< centre of mass [m]
  double angle = 0;
  Vec2 velocity{};
  double omega = 0;
};

/// How an engine is run.
struct Setting {
  std::string label{};    ///< "default", "best", a solver or a stepper: one curve of a plot
  double dt = 1.0 / 60;   ///< [s]
  int iterations = 0;     ///< sweeps or sub-steps; 0: the engine's default
  bool tuned = false;     ///< no sleeping, thresholds and slops as small as the engine allows
  std::string solver{};   ///< the engine's name for it; empty: its default
  std::string stepper{};  ///< ours only
  double accuracy = 0;    ///< ours only, event-driven; 0: default
  int threads = 1;        ///< ours only
  bool dense = false;     ///< solves by dense factorisations: not for hundreds of bodies
};

/// A world of some engine made from a Scene. Bodies keep their numbers.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual void step() = 0;
  virtual BodyState state(int body) const = 0;
  /// Called once, before the first step, by measures that ask `normal_force`.
  virtual void watch_forces() {}
  /// Magnitude of the sum of the contact normal forces on the body over the last step [N].
  virtual double normal_force(int body) const = 0;
  /// When contact was lost in the last step, before its end [s]; only engines that locate it.
  virtual std::optional<double> released() const { return {}; }
  virtual void push(int body, Vec2 impulse) = 0;  ///< [N s] at the centre of mass
};

struct EngineEntry {
  std::string name;
  std::string version;
  bool ours = false;
  bool polygons = true;  ///< convex polygons other than boxes
  bool rods = true;      ///< massless distance joints
  std::unique_ptr<Engine> (*make)(const Scene& scene, const Setting& setting) = nullptr;
  std::vector<Setting> curves;  ///< dt is filled in by the benchmark
};

EngineEntry skerry_entry();
#ifdef SKERRY_WITH_BOX2D
EngineEntry box2d_entry();
#endif
#ifdef SKERRY_WITH_BOX2D3
EngineEntry box2d3_entry();
#endif
#ifdef SKERRY_WITH_CHIPMUNK
EngineEntry chipmunk_entry();
#endif
#ifdef SKERRY_WITH_BULLET
EngineEntry bullet_entry();
#endif
#ifdef SKERRY_WITH_ODE
EngineEntry ode_entry();
#endif

/// Ours first.
const std::vector<EngineEntry>& engines();

}  // namespace skerry::bench
