// SPDX-License-Identifier: MIT
#include "physics/narrowphase/chain.h"

#include <stdexcept>
#include <string>

#include "physics/narrowphase/chain_segment.h"
#include "physics/narrowphase/chain_tree.h"

namespace skerry {
namespace narrow {
namespace {

// Sine of the turn below which neighbours count as one flat stretch.
constexpr double kFlatSine = 1.0e-9;
// Directions this close to a segment's normal are its own, not a corner's.
constexpr double kSameDirection = 1.0e-12;

// Behind a sharp ridge what is in front of one face is far below the other's line. From this depth on [m] a
// segment asks whether its neighbour is nearer, by this share of its own depth.
constexpr double kAsked = 1.0e-6, kNearer = 0.5;

/// Codes of the segment as a core become those of the segment as its users know it.
std::uint32_t users_feature(std::uint32_t feature) {
  const std::uint32_t own = feature >> 16;
  const std::uint32_t code = own == corner_code(0)   ? corner_code(1)
                             : own == corner_code(1) ? corner_code(0)
                                                     : edge_code(0);
  return make_feature(code, feature & 0xffffu);
}

/// A disc above the face is met by the face; beyond the end it is met by the corner, unless the next
/// segment's face has it. Corners at the start belong to the segment before.
Manifold meet_disc(const Segment& s, const Hull& disc, const Transform& relative, double margin) {
  const Vec2 c = relative.p + rotate(relative.q, disc.v[0]);
  const Vec2 n = s.n[0], along = -perp(n);
  const Vec2 from_start = c - s.v[1], from_end = c - s.v[0];
  const double height = dot(n, from_start);
  const double noise = kNoise * (magnitude(c) + magnitude(s.v[0]) + magnitude(s.v[1]));
  Manifold m;
  m.normal = n;
  double distance = height;
  std::uint32_t code = edge_code(0);
  const bool before = dot(along, from_start)<0, behind = dot(along, from_end)> 0;
  if (before || behind) {
    if (before && (s.has_previous || height < 0)) return m;
    if (behind && s.has_next && dot(-perp(s.next), from_end) > noise) return m;
    if (behind && !s.has_next && height < 0) return m;
    const Vec2 gap = before ? from_start : from_end;
    distance = length(gap);
    code = corner_code(before ? 0 : 1);
    if (distance > noise) {
      m.normal = gap / distance;
    }
  } else if (height < 0) {
    return m;
  }
  if (!(distance - disc.radius <= margin)) return m;
  m.count = 1;
  m.points[0] = {c - (0.5 * (distance + disc.radius)) * m.normal, distance - disc.radius,
                 make_feature(code, corner_code(0))};
  return m;
}

}  // namespace

Segment::Segment(const Shape& chain, int index, Vec2 origin) {
  const int corners = static_cast<int>(chain.vertices.size());
  const int segments = static_cast<int>(chain.normals.size());
  const int end = index + 1 < corners ? index + 1 : 0;
  v[0] = chain.vertices[static_cast<std::size_t>(end)] - origin;
  v[1] = chain.vertices[static_cast<std::size_t>(index)] - origin;
  n[0] = chain.normals[static_cast<std::size_t>(index)];
  n[1] = -n[0];
  length = skerry::length(v[0] - v[1]);
  has_previous = chain.closed || index > 0;
  has_next = chain.closed || index + 1 < segments;
  if (has_previous) {
    const auto neighbour = static_cast<std::size_t>(index > 0 ? index - 1 : segments - 1);
    previous = chain.normals[neighbour];
    before = chain.vertices[neighbour] - origin;
  }
  if (has_next) {
    next = chain.normals[static_cast<std::size_t>(index + 1 < segments ? index + 1 : 0)];
    after = chain.vertices[static_cast<std::size_t>(end + 1 < corners ? end + 1 : 0)] - origin;
  }
}

// A ridge turns clockwise, and so do the normals along it.
bool Segment::may_push_at_end(Vec2 u) const {
  if (!(cross(n[0], u) < -kSameDirection)) return false;
  if (!has_next) return dot(n[0], u) >= 0;
  return cross(n[0], next) < 0 && cross(u, next) <= kSameDirection && dot(u, n[0] + next) > 0;
}

bool Segment::may_push_at_start(Vec2 u) const {
  if (!(cross(n[0], u) > kSameDirection)) return false;
  if (!has_previous) return dot(n[0], u) >= 0;
  return cross(previous, n[0]) < 0 && cross(previous, u) <= kSameDirection && dot(u, n[0] + previous) > 0;
}

bool Segment::is_over_valley(Vec2 p, double noise) const {
  const Vec2 along = -perp(n[0]);
  if (has_previous && dot(along, p - v[1]) <= noise)
    return cross(previous, n[0]) > kFlatSine && dot(perp(previous), p - before) <= 0;
  if (has_next && dot(along, p - v[0]) >= -noise)
    return cross(n[0], next) > kFlatSine && dot(perp(next), p - after) >= 0;
  return false;
}

namespace {

/// A corner of a core that is foreseen by its height above the face.
SegmentContact foresee(const Segment& s, const Placed& placed, int corner, double height, double radius) {
  SegmentContact foreseen;
  foreseen.m.normal = s.n[0];
  foreseen.m.count = 1;
  foreseen.m.points[0] = {placed.v[corner] - (0.5 * (height + radius)) * s.n[0], height - radius,
                          make_feature(edge_code(0), corner_code(corner))};
  return foreseen;
}

/// True if what is below this line by so much [m] is less deep behind a neighbour's face, or in front of it,
/// beyond a sharp ridge: then that keeps them apart.
bool is_nearer_to_neighbour(const Segment& s, const Hull& other, const Placed& placed, double depth) {
  const auto is_nearer = [&](Vec2 normal, Vec2 ridge) {
    for (int i = 0; i < other.count; ++i)
      if (dot(normal, placed.v[i] - ridge) - other.radius < -kNearer * depth) return false;
    return true;
  };
  return (s.has_previous && cross(s.previous, s.n[0]) < -kFlatSine && is_nearer(s.previous, s.v[1])) ||
         (s.has_next && cross(s.n[0], s.next) < -kFlatSine && is_nearer(s.next, s.v[0]));
}

/// An edge that leans on the ridge at the start is the concern of the segment before. What turns over the
/// ridge comes down on this one's face with its lowest corner, wherever its edge leans.
SegmentContact from_ridge_before(const Segment& s, const Hull& other, const Placed& placed, double margin,
                                 double noise) {
  int lowest = -1;
  double low = kInfinity;
  for (int i = 0; i < other.count; ++i) {
    const Vec2 from_start = placed.v[i] - s.v[1];
    const double x = dot(-perp(s.n[0]), from_start), height = dot(s.n[0], from_start);
    if (x < -noise || x > s.length + noise || height >= low) continue;
    lowest = i;
    low = height;
  }
  if (lowest < 0 || !(std::abs(low - other.radius) <= margin)) return {};
  // Under a sharp ridge what is in front of the segment before is below this one's line.
  if (low < other.radius &&
      dot(s.previous, placed.v[lowest] - s.v[1]) - other.radius > kNearer * (low - other.radius))
    return {};
  if (low - other.radius < -kAsked && is_nearer_to_neighbour(s, other, placed, other.radius - low)) return {};
  return foresee(s, placed, lowest, low, other.radius);
}

/// The corner of the core that is what is nearest to the ridge at the end, if this segment may answer it;
/// else -1.
int corner_over_ridge(const Segment& s, const Hull& other, const Placed& placed, double noise) {
  int nearest = 0;
  for (int i = 1; i < other.count; ++i)
    if (length_squared(placed.v[i] - s.v[0]) < length_squared(placed.v[nearest] - s.v[0])) nearest = i;
  const Vec2 corner = placed.v[nearest], gap = corner - s.v[0];
  const double size = length(gap);
  const auto beyond = [&](int i) { return dot(placed.v[i] - corner, gap) >= 0; };
  const bool answers = size > noise && beyond((nearest + 1) % other.count) &&
                       beyond((nearest + other.count - 1) % other.count) && s.may_push_at_end(gap / size);
  return answers ? nearest : -1;
}

/// Of a rounded corner and the ridge at the end.
SegmentContact meet_ridge(const Segment& s, const Hull& other, const Placed& placed, int corner,
                          double margin) {
  SegmentContact contact{{}, NormalFrom::Corners};
  const Vec2 gap = placed.v[corner] - s.v[0];
  const double distance = length(gap);
  if (!(distance - other.radius <= margin)) return contact;
  Manifold& m = contact.m;
  m.normal = gap / distance;
  m.count = 1;
  m.points[0] = {placed.v[corner] - (0.5 * (distance + other.radius)) * m.normal, distance - other.radius,
                 users_feature(make_feature(corner_code(0), corner_code(corner)))};
  return contact;
}

}  // namespace

SegmentContact meet_segment(const Segment& s, const Hull& other, const Transform& relative, double margin,
                            NarrowPhaseStats* stats) {
  if (other.kind == ShapeKind::Disc) {
    return {meet_disc(s, other, relative, margin), NormalFrom::Corners};
  }
  SegmentContact none;
  const Vec2 n = s.n[0];
  const double limit = margin + other.radius;
  Placed placed;
  placed.turn = relative.q;
  Vec2 middle;
  double low = kInfinity, scale = magnitude(s.v[0]) + magnitude(s.v[1]);
  Axis axis;
  for (int i = 0; i < other.count; ++i) {
    const Vec2 w = relative.p + rotate(relative.q, other.v[i]);
    placed.v[i] = w;
    middle += w;
    scale = std::max(scale, magnitude(w));
    const double height = dot(n, w - s.v[1]);
    if (height < low) {
      low = height;
      axis.support = i;
    }
  }
  if (stats != nullptr) stats->axes_tested += 1;
  if (low > limit) return none;
  // Behind the line, what may push is the corner of a ridge, from where its other side is seen from in front.
  middle = middle / other.count;
  const bool behind = dot(n, middle - s.v[1]) < 0;
  if (behind && !(s.has_next && cross(n, s.next) < 0 && dot(s.next, middle - s.v[0]) >= 0)) return none;
  // This line and the edges alone do not tell a rounded corner over a sharp ridge from one that is inside.
  if (other.radius > 0 && s.has_next && cross(n, s.next) < -kFlatSine) {
    const int corner = corner_over_ridge(s, other, placed, kNoise * scale);
    if (corner >= 0) return meet_ridge(s, other, placed, corner, margin);
  }
  const int lowest_corner = axis.support;
  axis.separation = low;
  axis.n = n;
  axis.scale = scale;

  // Edges of the other shape: those that have the segment before them, and those whose push a corner of it
  // may answer.
  bool at_start = false;
  double nearest_to_end = -kInfinity, nearest_to_start = -kInfinity;  // edges' separations
  for (int j = 0; j < other.count; ++j) {
    const Vec2 m = rotate(relative.q, other.n[j]), u = -m;
    const double of_end = dot(m, s.v[0] - placed.v[j]), of_start = dot(m, s.v[1] - placed.v[j]);
    if (std::min(of_end, of_start) > limit) return none;
    nearest_to_end = std::max(nearest_to_end, of_end);
    nearest_to_start = std::max(nearest_to_start, of_start);
    const bool start = s.may_push_at_start(u);
    if (!start && !s.may_push_at_end(u)) continue;
    if (stats != nullptr) stats->axes_tested += 1;
    const int corner = start ? 1 : 0;
    const double separation = start ? of_start : of_end;
    if (separation > limit) return none;
    if (separation > axis.separation + kAxisBias * scale) {
      axis.separation = separation;
      axis.index = ~j;
      axis.n = m;
      axis.support = corner;
      at_start = start;
    }
  }
  // A corner that went over the ridge at the start and sank in below it, behind both faces, has another edge
  // nearer to that: then the segment before has nothing, and this face pushes.
  if (axis.index < 0 && at_start && s.has_previous &&
      nearest_to_start > axis.separation + kAxisBias * scale &&
      dot(s.previous, placed.v[lowest_corner] - s.v[1]) < other.radius) {
    axis.separation = low;
    axis.index = 0;
    axis.n = n;
    axis.support = lowest_corner;
    at_start = false;
  }
  if (axis.index < 0 && at_start && s.has_previous)
    return from_ridge_before(s, other, placed, margin, kNoise * scale);
  // Another edge is nearer to the corner of the ridge, which is not inside of the other shape: what is beside
  // it is the next segment's concern, but what sank in through this face is that of the face.
  if (axis.index < 0 && !at_start && nearest_to_end > std::max(axis.separation, 0.0) + kAxisBias * scale &&
      corner_over_ridge(s, other, placed, kNoise * scale) < 0) {
    if (behind || !(low < other.radius)) return none;
    axis.separation = low;
    axis.index = 0;
    axis.n = n;
    axis.support = lowest_corner;
  }
  const bool from_ridge = axis.index < 0 && !at_start;
  if (behind && !from_ridge) return none;

  const double noise = kNoise * scale, len = s.length;
  const Vec2 along = -perp(n), lowest = placed.v[axis.index >= 0 ? axis.support : 0];
  // A sharp corner that comes along the other side of a valley is foreseen by its height above this face,
  // onto which it moves without ever having been nearest to more than the corner between.
  const auto from_valley = [&] {
    const Vec2 start = lowest - s.v[1], end = lowest - s.v[0];
    if (axis.index < 0 || other.radius > 0 || !s.is_over_valley(lowest, noise) ||
        std::min(length_squared(start), length_squared(end)) > margin * margin) {
      return none;
    }
    return foresee(s, placed, axis.support, low, 0);
  };

  const Hull own = s.hull();
  SegmentContact contact;
  Manifold& m = contact.m;
  Output out{m, {}, false, {}};
  // Ends of the segment that are no ridge have no normal but its own.
  const double lowest_x = dot(along, lowest - s.v[1]);
  const bool may_turn = lowest_x < 0 ? !s.has_previous || cross(s.previous, n) < -kFlatSine
                                     : !s.has_next || cross(n, s.next) < -kFlatSine;
  clip(own, other, placed, axis, margin, out, may_turn);
  contact.from = out.from;
  if (m.count == 0) return from_valley();
  if (contact.from != NormalFrom::First) {
    const double lean = cross(n, m.normal);  // negative: towards the end
    if (lean < -kSameDirection && !s.may_push_at_end(m.normal)) return from_valley();
    if (lean > kSameDirection && (s.has_previous || !s.may_push_at_start(m.normal))) return from_valley();
  }
  // What pokes below the line beyond an end is the neighbours' concern; on a flat stretch the ends inside it
  // are no ends of the contact.
  const bool flat_start =
      s.has_previous && std::abs(cross(s.previous, n)) < kFlatSine && dot(s.previous, n) > 0;
  const bool flat_end = s.has_next && std::abs(cross(s.next, n)) < kFlatSine && dot(s.next, n) > 0;
  // An edge that leans beyond a neighbour's normal lies on that: this side of the ridge it stands above, and
  // where it meets the ridge itself, within rounding, is no contact of this face.
  const bool ridge_start = s.has_previous && cross(s.previous, n) < -kFlatSine;
  const bool ridge_end = s.has_next && cross(n, s.next) < -kFlatSine;
  const auto lies_beyond = [&](std::uint32_t own_code, std::uint32_t other_code) {
    const Vec2 u = -rotate(relative.q, other.n[other_code >> 1]);
    return (own_code == corner_code(1) && ridge_start && cross(s.previous, u) > kSameDirection) ||
           (own_code == corner_code(0) && ridge_end && cross(u, s.next) > kSameDirection);
  };
  int kept = 0;
  for (int i = 0; i < m.count; ++i) {
    const std::uint32_t own_code = m.points[i].feature >> 16, other_code = m.points[i].feature & 0xffffu;
    const double x = dot(along, m.points[i].position - s.v[1]);
    if (contact.from == NormalFrom::First && (x < -noise || x > len + noise)) continue;
    const bool on_edge = (other_code & 1u) != 0;  // a corner of the segment against an edge
    if (on_edge && own_code == corner_code(1) && flat_start) continue;
    if (on_edge && own_code == corner_code(0) && flat_end) continue;
    if (on_edge && contact.from == NormalFrom::First && lies_beyond(own_code, other_code)) continue;
    m.points[kept++] = m.points[i];
  }
  m.count = kept;
  if (kept == 0) return from_valley();
  double deepest = 0;
  for (int i = 0; i < m.count; ++i) deepest = std::min(deepest, m.points[i].separation);
  if (deepest < -std::min(margin, kAsked) && is_nearer_to_neighbour(s, other, placed, -deepest)) return none;
  for (int i = 0; i < m.count; ++i) m.points[i].feature = users_feature(m.points[i].feature);
  return contact;
}

}  // namespace narrow

namespace {

void require_segment(const Shape& chain, int segment) {
  if (chain.kind == ShapeKind::Chain && segment >= 0 && segment < chain_segment_count(chain)) return;
  std::string message("collide_chain_segment: segment ");
  message.append(std::to_string(segment))
      .append(" of a chain of ")
      .append(std::to_string(chain_segment_count(chain)));
  throw std::invalid_argument(message);
}

}  // namespace

int chain_segment_count(const Shape& chain) {
  return chain.kind == ShapeKind::Chain ? static_cast<int>(chain.normals.size()) : 0;
}

Aabb chain_segment_box(const Shape& chain, int segment, const Transform& pose) {
  const auto first = static_cast<std::size_t>(segment);
  const std::size_t second = first + 1 < chain.vertices.size() ? first + 1 : 0;
  const Vec2 p = to_world(pose, chain.vertices[first]), q = to_world(pose, chain.vertices[second]);
  return {{std::min(p.x, q.x), std::min(p.y, q.y)}, {std::max(p.x, q.x), std::max(p.y, q.y)}};
}

void chain_segments_near(const Shape& chain, const Transform& pose, const Aabb& box, std::vector<int>& out) {
  out.clear();
  if (chain.kind != ShapeKind::Chain) return;
  // The box in the chain's frame, grown by what roundings may hide.
  Aabb wanted{{-kInfinity, -kInfinity}, {kInfinity, kInfinity}};
  const Vec2 middle = 0.5 * (box.lower + box.upper), half = 0.5 * (box.upper - box.lower);
  const double scale =
      narrow::magnitude(box.lower) + narrow::magnitude(box.upper) + narrow::magnitude(pose.p);
  if (scale < 1e100) {
    const Vec2 c = to_local(pose, middle);
    const double noise = 1e-14 * scale, co = std::abs(pose.q.c), si = std::abs(pose.q.s);
    const Vec2 reach{co * half.x + si * half.y + noise, si * half.x + co * half.y + noise};
    wanted = {c - reach, c + reach};
  }
  narrow::visit_segments(
      chain, [&](const Aabb& part) { return overlap(part, wanted); },
      [&](int i) {
        if (overlap(chain_segment_box(chain, i, pose), box)) out.push_back(i);
      });
}

namespace {

/// Calls `meet(segment, hull, relative)`, which returns a manifold in coordinates of the segment's start, so
/// that a long chain is as exact as a short one.
template <class Meet>
Manifold meet_in_place(const Shape& chain, int segment, const Transform& pose_chain, const Shape& other,
                       const Transform& pose_other, const Meet& meet) {
  require_segment(chain, segment);
  Manifold m;
  if (other.kind == ShapeKind::HalfPlane || other.kind == ShapeKind::Chain) return m;
  const Vec2 origin = chain.vertices[static_cast<std::size_t>(segment)];
  const narrow::Segment own(chain, segment, origin);
  Transform relative = narrow::relative_pose(pose_chain, pose_other);
  if (!(narrow::magnitude(relative.p) < 1e100)) return m;
  relative.p -= origin;
  m = meet(own, narrow::hull_of(other), relative);
  if (m.count == 0) return m;
  m.normal = rotate(pose_chain.q, m.normal);
  for (ManifoldPoint& point : m.points) point.position = to_world(pose_chain, origin + point.position);
  return m;
}

}  // namespace

Manifold collide_chain_segment(const Shape& chain, int segment, const Transform& pose_chain,
                               const Shape& other, const Transform& pose_other, double margin,
                               NarrowPhaseStats* stats) {
  if (stats != nullptr) stats->pairs += 1;
  const Manifold m =
      meet_in_place(chain, segment, pose_chain, other, pose_other,
                    [&](const narrow::Segment& own, const narrow::Hull& hull, const Transform& relative) {
                      return narrow::meet_segment(own, hull, relative, margin, stats).m;
                    });
  if (stats != nullptr && m.count > 0) stats->manifolds += 1;
  return m;
}

Manifold cross_chain_segment(const Shape& chain, int segment, const Transform& pose_chain, const Shape& other,
                             const Transform& pose_other, double margin) {
  return meet_in_place(chain, segment, pose_chain, other, pose_other,
                       [&](const narrow::Segment& own, const narrow::Hull& hull, const Transform& relative) {
                         Manifold m;
                         narrow::Output out{m, {}, false, {}};
                         narrow::meet(own.hull(), hull, relative, margin, nullptr, nullptr, out);
                         return m;
                       });
}

}  // namespace skerry
