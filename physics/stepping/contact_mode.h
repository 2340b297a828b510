// SPDX-License-Identifier: MIT
//
// Which contacts of an island are closed, which of them stick or slip, which ropes are taut, which motors
// reach their speed: between two events none of it changes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "physics/joint_rows.h"
#include "physics/stepping/contact_kinematics.h"

namespace skerry {

/// A contact point that touches and does not separate.
struct ModePoint {
  std::size_t contact = 0;    ///< position in the island's list
  int point = 0;              ///< of the manifold
  std::uint32_t feature = 0;  ///< of that point
  ContactFeatures features;
  bool closed = false;  ///< carries load; otherwise it is about to part
};

/// Friction of a pair, or its resistance to rolling. The points of a pair share their tangent, so one force
/// serves them all.
struct Grip {
  std::size_t contact = 0;
  bool rolling = false;
  double mu = 0;       ///< bound over the sum of the normal forces; rolling: [m]
  double hold = 0;     ///< the same while it sticks, at least `mu`
  double surface = 0;  ///< velocity of a conveyor's surface [m/s]
  int sign = 0;        ///< direction of the relative motion; 0: none, it sticks
  std::array<int, 2> points{};
  int count = 0;
};

/// What a row of a joint does.
enum class JointRowState : std::uint8_t {
  Off,       ///< no force (a limit that is not reached), or one that position and speed give (a spring)
  Holds,     ///< it keeps what it keeps with whatever force that takes
  Forward,   ///< a motor pushes with its largest force
  Backward,  ///< and against its direction
};

struct ModeRow {
  std::size_t joint = 0;  ///< position in the island's list
  int row = 0;            ///< of the joint; rows of one joint stand together, in order
  JointRowKind kind = JointRowKind::Hold;
  JointRowState state = JointRowState::Off;
};

struct ContactMode {
  std::vector<ModePoint> points;
  std::vector<Grip> grips;
  std::vector<ModeRow> rows;  ///< of all joints of the island
  /// Forces with which the mode was chosen: of points, grips and rows [N or N m]; empty: none. Where supports
  /// are redundant many others have the same effect, but may break the laws of contact.
  std::vector<double> point_force, grip_force, row_force;

  /// True if nothing acts on the bodies but their external forces.
  bool free() const {
    for (const ModePoint& point : points) {
      if (point.closed) return false;
    }
    for (const ModeRow& row : rows) {
      if (row.state != JointRowState::Off || row.kind == JointRowKind::Spring) return false;
    }
    return true;
  }
};

}  // namespace skerry
