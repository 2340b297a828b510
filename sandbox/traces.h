// SPDX-License-Identifier: MIT
//
// Where points of bodies have been, and the bodies themselves at equal intervals, as under a stroboscope.
#pragma once

#include "sandbox/demo.h"
#include "sandbox/thinned.h"

namespace skerry::sandbox {

/// As many points leave a trace: of a script that names none the first bodies that move.
inline constexpr std::size_t kMostTraces = 64;

struct TracePoint {
  double time = 0;  ///< [s]
  Vec2 at;          ///< world frame [m]
};

/// A body when the stroboscope flashed.
struct StrobePose {
  double time = 0;   ///< [s]
  Transform pose;    ///< of the body
  double angle = 0;  ///< [rad]
  Vec2 at;           ///< the traced point, world frame [m]
};

struct Trace {
  TracedPoint point;
  Thinned<TracePoint, 1024> path;
  Thinned<StrobePose, 256> strobes;
};

class Traces {
 public:
  /// Begins with the bodies as they are.
  explicit Traces(const Demo& demo);
  /// Looks at the last step: along it where its paths are observed (`Observe::paths`), else at its end.
  void update(const Demo& demo);
  const std::vector<Trace>& list() const { return traces_; }
  std::size_t bytes() const;  ///< memory, roughly

 private:
  double seen_ = 0;  // up to this time [s]
  std::vector<Trace> traces_;

  void find(const Demo& demo);
  void look(const Demo& demo, double time);
};

}  // namespace skerry::sandbox
