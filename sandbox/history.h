// SPDX-License-Identifier: MIT
//
// What overlays need to remember from earlier steps: impacts, which last one step but should be seen for
// longer, the last system of equations and how it was solved, energy and momentum over time.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "physics/islands/delassus.h"
#include "physics/step_report.h"
#include "sandbox/demo.h"
#include "sandbox/thinned.h"
#include "sandbox/traces.h"

namespace skerry::sandbox {

/// How long an impact stays visible [s of the video]: it lasts one step, eyes need longer.
inline constexpr double kFlashSeconds = 0.5;

/// Systems with more rows do not get names for them.
inline constexpr int kMostNamedRows = 24;

/// An impact at a contact point.
struct Flash {
  double time = 0;                        ///< end of its step [s]
  double begin = 0;                       ///< when it happened [s]
  Vec2 point;                             ///< world frame [m]
  Vec2 normal;                            ///< from the first body to the second
  double impulse = 0;                     ///< [N s]
  bool fixed_a = false, fixed_b = false;  ///< static or kinematic: not moved by it
};

/// Where in the scene a row of the equations acts. The point moves with a body.
struct RowAnchor {
  BodyId a, b;     ///< dynamic bodies; none for the ground
  BodyId carrier;  ///< the body that the point moves with; none: the world
  Vec2 local;      ///< in the carrier's frame [m]
};

/// The factor of W under both orderings.
struct FactorViews {
  FactorPattern natural, reduced;
};

/// A copy of the equations of one island.
struct SystemRecord {
  double time = 0;      ///< [s]
  bool impact = false;  ///< of an impact; otherwise of the forces of a step
  int island = -1;      ///< number in that step
  IslandSystem system;
  std::vector<double> lambda;          ///< [N s]
  std::vector<std::string> row_names;  ///< "A-B", "B-ground n": the bodies of each row; may be empty
  std::vector<RowAnchor> anchors;      ///< one a row; empty for systems of more than 4096 rows
  std::string method;
  SolveStatus status = SolveStatus::Solved;
  double residual = 0;
  std::vector<SolveIteration> iterations;  ///< with `Observe::solve_traces`
  std::vector<std::string> notes;          ///< the same

  /// Computed when first asked for. @pre the system has at most `kMostFactoredRows` rows
  const FactorViews& factors() const;

 private:
  mutable std::shared_ptr<const FactorViews> factors_;
};

/// Larger factors are not drawn: one cell a pixel would not show them, and the natural order may fill.
inline constexpr int kMostFactoredRows = 1200;

/// Energy and momentum of the dynamic bodies, and the accuracy, at a moment.
struct LedgerSample {
  double time = 0;
  double kinetic = 0, potential = 0;  ///< [J]
  Vec2 momentum;                      ///< [kg m/s]
  double angular_momentum = 0;        ///< about the world's origin [kg m^2/s]
  double residual = 0;                ///< worst of the islands, relative
};

/// A moment with impacts.
struct Beat {
  double time = 0;
  double impulse = 0;  ///< the largest [N s]
};

class History {
 public:
  /// @param keep_systems copy the equations of an island at each step
  /// @param flash_seconds how long an impact stays visible [s of the world's time]
  History(const Demo& demo, bool keep_systems, double flash_seconds);

  /// Looks at the last step.
  void update(const Demo& demo);
  /// Keeps the equations of this island instead of the largest one; -1: the largest.
  void follow_island(int island) {
    if (island != followed_) impact_.reset();
    followed_ = island;
  }
  /// The same for the island that this body is in, whatever its number; none: as `follow_island` says.
  void follow_body(BodyId body) {
    if (body != followed_body_) impact_.reset();
    followed_body_ = body;
  }
  BodyId followed_body() const { return followed_body_; }
  /// Sets the moment that is shown [s], if it is not the end of the last step.
  void show_at(double time) { now_ = time; }

  const std::vector<Flash>& flashes() const { return flashes_; }
  /// 1 for an impact that just happened, 0 when it is no longer to be seen.
  double brightness(const Flash& flash) const;
  /// The system to show: of the last impact while that is recent, unless the forces of a larger island have
  /// been solved since; else of the last step that solved one.
  const SystemRecord* system() const;
  /// The system of forces of the last step that solved one; null before that.
  const SystemRecord* resting() const { return resting_ ? &*resting_ : nullptr; }
  /// The system of the last impact; null before one.
  const SystemRecord* impact() const { return impact_ ? &*impact_ : nullptr; }
  /// Samples at equal distances from the start, and the last one: at most 4097, whatever the length of the
  /// run.
  const std::vector<LedgerSample>& ledger() const { return ledger_.samples(); }
  const Traces& traces() const { return traces_; }
  /// Moments with impacts, at most 4096 of them; the oldest of neighbours make room.
  const std::vector<Beat>& beats() const { return beats_; }
  /// Duration of each stage, mean over about ten steps [s]; zero unless they are observed.
  const std::array<double, kStageCount>& stage_seconds() const { return stage_seconds_; }

  /// Largest impact impulse [N s] and contact force [N] so far, for the scale of arrows.
  double largest_impulse() const { return largest_impulse_; }
  double largest_force() const { return largest_force_; }
  /// Contact forces up to this are rounding noise [N].
  double force_floor(const World& world) const;
  /// Largest support reaction [N] and bending moment [N m] of bridges so far, likewise.
  double largest_reaction() const { return largest_reaction_; }
  double largest_moment() const { return largest_moment_; }
  double fastest() const { return fastest_; }  ///< largest speed so far [m/s]
  std::size_t bytes() const;                   ///< memory of what grows with the run, roughly
  double now() const { return now_; }          ///< time that is shown [s]

 private:
  bool keep_systems_;
  double flash_seconds_;
  int followed_ = -1;
  BodyId followed_body_;
  double now_ = 0;
  std::vector<Flash> flashes_;
  std::optional<SystemRecord> impact_, resting_;
  Thinned<LedgerSample, 4096> ledger_;
  Traces traces_;
  std::vector<Beat> beats_;
  std::array<double, kStageCount> stage_seconds_{};
  double largest_impulse_ = 0, largest_force_ = 0, fastest_ = 0, largest_mass_ = 0;
  double largest_reaction_ = 0, largest_moment_ = 0;

  void look_at_bodies(const World& world);
  void look_at_bridges(const Demo& demo);
  void look_at_contacts(const World& world);
  void look_at_systems(const World& world);
  void add_beat(double impulse);
};

/// The world point of an anchor at the moment that is shown [m].
Vec2 anchor_point(const Demo& demo, const RowAnchor& anchor);

}  // namespace skerry::sandbox
