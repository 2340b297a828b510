// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: one segment of a chain with what it knows of its neighbours.
#pragma once

#include "physics/narrowphase/hull.h"

namespace skerry::narrow {

/// A one-sided segment. As a core its corner 0 is the segment's end and corner 1 its start, so that edge 0 is
/// the free side. Hull points into it, so it must stay where it is while its hull is used.
struct Segment {
  Vec2 v[2];  ///< end, start
  Vec2 n[2];  ///< free side, solid side
  double length = 0;
  bool has_previous = false, has_next = false;
  Vec2 previous, next;  ///< the neighbours' normals
  Vec2 before, after;   ///< their far ends

  /// @param origin  point of the chain's frame that becomes the origin of the segment's coordinates
  Segment(const Shape& chain, int index, Vec2 origin);
  Segment(const Segment&) = delete;
  Segment& operator=(const Segment&) = delete;

  Hull hull() const { return {ShapeKind::Capsule, v, n, 2, 0}; }
  /// True if `u` lies between the segment's normal and the next one's at a ridge, or between the normal and
  /// the direction of walking at an open end.
  bool may_push_at_end(Vec2 u) const;
  bool may_push_at_start(Vec2 u) const;
  /// True if `p` lies above the neighbour beyond the start or the end, and that neighbour bounds a valley
  /// with this segment: along its face `p` comes down into this segment's.
  /// @param noise  by which `p` may be beside it [m]
  bool is_over_valley(Vec2 p, double noise) const;
};

/// A manifold and whose edge gave its normal.
struct SegmentContact {
  Manifold m;
  NormalFrom from = NormalFrom::First;
};

/// Contact of a segment with a core in the segment's frame; empty for what its neighbours report.
SegmentContact meet_segment(const Segment& segment, const Hull& other, const Transform& relative,
                            double margin, NarrowPhaseStats* stats);

}  // namespace skerry::narrow
