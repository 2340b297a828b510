// SPDX-License-Identifier: MIT
//
// What overlays need to remember from earlier steps: impacts, which last one step but should be seen for
// longer, the last system of equations, and the energy over time.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "physics/step_report.h"
#include "sandbox/demo.h"

namespace skerry::sandbox {

/// Systems with more rows do not get names for them.
inline constexpr int kMostNamedRows = 24;

/// An impact at a contact point.
struct Flash {
  double time = 0;                        ///< [s]
  Vec2 point;                             ///< world frame [m]
  Vec2 normal;                            ///< from the first body to the second
  double impulse = 0;                     ///< [N s]
  bool fixed_a = false, fixed_b = false;  ///< static or kinematic: not moved by it
};

/// A copy of the equations of one island.
struct SystemRecord {
  double time = 0;      ///< [s]
  bool impact = false;  ///< of an impact; otherwise of the forces of a step
  IslandSystem system;
  std::vector<double> lambda;          ///< [N s]
  std::vector<std::string> row_names;  ///< "A-B", "B-ground n": the bodies of each row; may be empty
  std::string method;
  double residual = 0;
};

/// Energy of the dynamic bodies at a moment.
struct EnergySample {
  double time = 0;
  double kinetic = 0, potential = 0;  ///< [J]
};

class History {
 public:
  /// @param keep_systems copy the equations of the largest island at each step
  /// @param flash_seconds how long an impact stays visible [s of the world's time]
  History(const Demo& demo, bool keep_systems, double flash_seconds);

  /// Looks at the last step.
  void update(const Demo& demo);

  const std::vector<Flash>& flashes() const { return flashes_; }
  /// 1 for an impact that just happened, 0 when it is no longer to be seen.
  double brightness(const Flash& flash) const;
  /// The system to show: of the last impact while that is recent, else of the last step that solved one.
  const SystemRecord* system() const;
  const std::vector<EnergySample>& energy() const { return energy_; }
  /// Largest impact impulse [N s] and contact force [N] so far, for the scale of arrows.
  double largest_impulse() const { return largest_impulse_; }
  double largest_force() const { return largest_force_; }
  /// Contact forces up to this are rounding noise [N].
  double force_floor(const World& world) const;
  double fastest() const { return fastest_; }  ///< largest speed so far [m/s]
  double now() const { return now_; }          ///< time of the last step [s]

 private:
  bool keep_systems_;
  double flash_seconds_;
  double now_ = 0;
  std::vector<Flash> flashes_;
  std::optional<SystemRecord> impact_, resting_;
  std::vector<EnergySample> energy_;
  double largest_impulse_ = 0, largest_force_ = 0, fastest_ = 0, largest_mass_ = 0;

  void look_at_bodies(const World& world);
};

/// A short name of a body for labels: its own, else a letter for the first 26 dynamic ones, else its
/// number among them.
std::string body_label(const World& world, BodyId body);

}  // namespace skerry::sandbox
