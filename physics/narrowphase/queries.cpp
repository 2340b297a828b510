// SPDX-License-Identifier: MIT
#include "physics/narrowphase/queries.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "physics/narrowphase/chain.h"
#include "physics/narrowphase/chain_segment.h"
#include "physics/narrowphase/chain_tree.h"
#include "physics/narrowphase/hull.h"
#include "physics/narrowphase/lanes.h"
#include "physics/narrowphase/time_of_impact.h"
#include "physics/text.h"

namespace skerry {
namespace {

using narrow::Hull;
using narrow::Segment;

constexpr double kNoMargin = 1.0e100;

/// Closest points of two cores that `meet` takes in this order; coordinates of `frame`, which is a's pose.
ClosestPoints closest(const Hull& a, const Hull& b, const Transform& frame, const Transform& relative) {
  Manifold m;
  narrow::Output world{m, frame, false, {}};
  narrow::meet(a, b, relative, kNoMargin, nullptr, nullptr, world);
  ClosestPoints out;
  out.distance = kInfinity;
  out.normal = m.normal;
  for (int i = 0; i < m.count; ++i) {
    const ManifoldPoint& point = m.points[static_cast<std::size_t>(i)];
    if (!(point.separation < out.distance)) continue;
    out.distance = point.separation;
    const Vec2 half = (0.5 * out.distance) * m.normal;
    out.point_a = point.position - half;
    out.point_b = point.position + half;
  }
  return out;
}

ClosestPoints exchanged(ClosestPoints c) {
  std::swap(c.point_a, c.point_b);
  c.normal = -c.normal;
  return c;
}

/// Of a core and another hull, in any order of kinds.
ClosestPoints closest_of(const Hull& a, const Transform& pose_a, const Hull& b, const Transform& pose_b) {
  if (narrow::rank_of(a.kind) < narrow::rank_of(b.kind)) {
    return exchanged(closest(b, a, pose_b, narrow::relative_pose(pose_b, pose_a)));
  }
  return closest(a, b, pose_a, narrow::relative_pose(pose_a, pose_b));
}

/// From either side, as to a line.
ClosestPoints closest_to_segment(const Shape& chain, int i, const Transform& pose_chain, const Hull& other,
                                 const Transform& pose_other) {
  // Coordinates from the segment's start: a long chain is as exact as a short one.
  const Vec2 start = chain.vertices[static_cast<std::size_t>(i)];
  const Segment segment(chain, i, start);
  Transform relative = narrow::relative_pose(pose_chain, pose_other);
  relative.p -= start;
  return closest(segment.hull(), other, {to_world(pose_chain, start), pose_chain.q}, relative);
}

ClosestPoints closest_to_chain(const Shape& chain, const Transform& pose_chain, const Hull& other,
                               const Transform& pose_other) {
  ClosestPoints best;
  best.distance = kInfinity;
  // The other shape lies in a disc around its origin; boxes farther than the best so far cannot be closer.
  double reach = 0;
  for (int i = 0; i < other.count; ++i) reach = std::max(reach, length(other.v[i]));
  reach += other.radius;
  const Vec2 c = to_local(pose_chain, pose_other.p);
  const auto wanted = [&](const Aabb& box) {
    const Vec2 nearest{std::clamp(c.x, box.lower.x, box.upper.x), std::clamp(c.y, box.lower.y, box.upper.y)};
    const double bound = length(c - nearest) - reach;
    const double noise = 1e-13 * (narrow::magnitude(c) + narrow::magnitude(nearest) + reach);
    return !(bound - noise > best.distance);
  };
  narrow::visit_segments(chain, wanted, [&](int i) {
    const ClosestPoints near = closest_to_segment(chain, i, pose_chain, other, pose_other);
    if (near.distance < best.distance) best = near;
  });
  return best;
}

Hull point_hull(const Vec2* point) {
  return {ShapeKind::Disc, point, nullptr, 1, 0};
}

/// A hit in the shape's frame; `t` infinite: none.
struct LocalHit {
  double t = kInfinity;
  Vec2 normal;
};

/// Whether a ray runs so nearly along an edge that the point where they meet is a quotient of roundings.
/// @param rate  product of its direction and the edge's normal
bool runs_along(double rate, double direction_squared) {
  return rate * rate < 1e-6 * direction_squared;
}

/// Parameters at which a ray passes two corners, the lesser one first.
struct Corners {
  double first, last;
};

Corners corners_along(Vec2 p, Vec2 q, Vec2 origin, Vec2 direction, double direction_squared) {
  const double at_p = dot(p - origin, direction) / direction_squared;
  const double at_q = dot(q - origin, direction) / direction_squared;
  return {std::min(at_p, at_q), std::max(at_p, at_q)};
}

/// Where a ray meets the edge from p to q, whose ends lie on both sides of it: wherever roundings put that
/// point, it is between the corners.
double between_corners(double t, Vec2 p, Vec2 q, double rate, Vec2 origin, Vec2 direction) {
  const double square = length_squared(direction);
  if (!runs_along(rate, square)) return t;
  const Corners at = corners_along(p, q, origin, direction, square);
  return std::clamp(t, at.first, at.last);
}

/// Ray against a circle; the square of the half chord is a product of a sum and a difference, so nothing
/// cancels for grazing rays.
void hit_circle(Vec2 origin, Vec2 direction, Vec2 centre, double radius, LocalHit& best) {
  const Vec2 m = origin - centre;
  const double along = dot(m, direction);
  if (along >= 0) return;
  const double speed = length(direction), miss = std::abs(cross(m, direction));
  if (miss > speed * radius) return;
  const double chord = std::sqrt((speed * radius - miss) * (speed * radius + miss));
  const double distance = length(m);
  // It enters before it is nearest to the centre; on the circle and along it both quotients are of roundings.
  const double t =
      std::min((distance - radius) * (distance + radius) / (chord - along), -along / (speed * speed));
  if (!(t >= 0 && t < best.t)) return;
  best.t = t;
  best.normal = (m + t * direction) / radius;
}

/// Bit i: corner i lies to the left of the ray's line, or on it if `closed`.
[[gnu::always_inline]] inline std::uint64_t corners_left(const Hull& hull, Vec2 origin, Vec2 direction,
                                                         bool closed) {
  using narrow::load, narrow::Two;
  const Two own = Two::both(cross(direction, origin));
  const Two dx = Two::both(direction.x), dy = Two::both(direction.y);
  std::uint64_t left = 0;
  const auto look = [&](const Two& v0, const Two& v1) {
    const Two side = dx * highs(v0, v1) - dy * lows(v0, v1);
    return closed ? bits(at_least(side, own)) : ~bits(at_least(own, side)) & 3u;
  };
  int i = 0;
  for (; i + 1 < hull.count; i += 2) {
    left |= static_cast<std::uint64_t>(look(load(hull.v[i]), load(hull.v[i + 1]))) << i;
  }
  if (i < hull.count) {
    left |= static_cast<std::uint64_t>(look(load(hull.v[i]), load(hull.v[i])) & 1u) << i;
  }
  return left;
}

/// A line enters a convex polygon at the edge whose first corner is to its left and the second to its right:
/// one division, and no branch on how the edges lie, which cannot be foreseen.
[[gnu::always_inline]] inline LocalHit hit_sharp_polygon(const Hull& hull, Vec2 origin, Vec2 direction) {
  const auto crossing = [&](std::uint64_t from) {
    const std::uint64_t next = from >> 1 | (from & 1) << (hull.count - 1);
    return from & ~next;
  };
  std::uint64_t left = corners_left(hull, origin, direction, true);
  std::uint64_t enters = crossing(left);
  if (enters == 0) {
    // All on one side; those to the left may still touch the line.
    if (left == 0) return {};
    left = corners_left(hull, origin, direction, false);
    enters = crossing(left);
    if (enters == 0) return {};
  }
  const int edge = std::countr_zero(enters);
  const auto end_of = [&](int i) { return hull.v[i + 1 < hull.count ? i + 1 : 0]; };
  const Vec2 n = hull.n[edge], p = hull.v[edge], q = end_of(edge);
  const double height = dot(n, origin - p), rate = dot(n, direction);
  if (height > 0) {
    if (!(rate < 0)) return {};
    const double t = between_corners(height / -rate, p, q, rate, origin, direction);
    if (!(t >= 0)) return {};
    return {t, n};
  }
  // Behind the edge where the line enters: inside unless also beyond the one where it leaves. Before an edge
  // along which it runs, or after it, roundings would decide.
  const double square = length_squared(direction);
  if (runs_along(rate, square)) {
    const double first = corners_along(p, q, origin, direction, square).first;
    if (first > 0) return {first, n};
  }
  const std::uint64_t all = hull.count < 64 ? (std::uint64_t{1} << hull.count) - 1 : ~std::uint64_t{0};
  const int exit = std::countr_zero(crossing(~left & all));
  if (dot(hull.n[exit], origin - hull.v[exit]) > 0) return {};
  if (runs_along(dot(hull.n[exit], direction), square) &&
      corners_along(hull.v[exit], end_of(exit), origin, direction, square).last < 0)
    return {};
  return {0, -direction / length(direction)};
}

LocalHit hit_round_hull(const Hull& hull, Vec2 origin, Vec2 direction) {
  LocalHit best;
  const Transform at_origin;
  const ClosestPoints start = closest_of(hull, at_origin, point_hull(&origin), at_origin);
  if (start.distance <= 0) return {0, -direction / length(direction)};
  for (int i = 0; i < hull.count; ++i) {
    hit_circle(origin, direction, hull.v[i], hull.radius, best);
    if (hull.count < 2) continue;
    const Vec2 n = hull.n[i];
    const double rate = dot(n, direction), height = dot(n, origin - hull.v[i]) - hull.radius;
    if (!(rate < 0 && height >= 0)) continue;
    const double t = height / -rate;
    const Vec2 at = origin + t * direction - hull.v[i];
    const Vec2 tangent = perp(n);
    const double x = dot(tangent, at);
    if (x < 0 || x > dot(tangent, hull.v[i + 1 < hull.count ? i + 1 : 0] - hull.v[i]) || !(t < best.t))
      continue;
    best = {t, n};
  }
  return best;
}

/// Does the ray meet a box before `t_max`, give or take roundings?
bool may_meet(const Aabb& box, Vec2 origin, Vec2 direction, double t_max) {
  double enter = 0, leave = t_max;
  const auto slab = [&](double from, double to, double start, double rate) {
    const double noise = 1e-14 * (std::abs(from) + std::abs(to) + std::abs(start));
    const double low = (from - noise) - start, high = (to + noise) - start;
    if (rate == 0) {
      if (low > 0 || high < 0) leave = -1;
      return;
    }
    const double first = (rate > 0 ? low : high) / rate, last = (rate > 0 ? high : low) / rate;
    enter = std::max(enter, first * (1 - 1e-14));
    leave = std::min(leave, last * (1 + 1e-14));
  };
  slab(box.lower.x, box.upper.x, origin.x, direction.x);
  slab(box.lower.y, box.upper.y, origin.y, direction.y);
  return enter <= leave;
}

LocalHit hit_chain(const Shape& chain, Vec2 origin, Vec2 direction, double t_max) {
  LocalHit best;
  const std::size_t corners = chain.vertices.size();
  const auto visit = [&](int segment) {
    const std::size_t i = static_cast<std::size_t>(segment);
    const Vec2 p = chain.vertices[i], q = chain.vertices[i + 1 < corners ? i + 1 : 0], n = chain.normals[i];
    const double rate = dot(n, direction), height = dot(n, origin - p);
    if (!(rate < 0 && height >= 0)) return;
    const double t = between_corners(height / -rate, p, q, rate, origin, direction);
    if (!(t >= 0 && t < best.t)) return;
    // The sides of the ray's line on which the ends lie; a ray through a shared corner hits at least one.
    const double side_p = cross(direction, p - origin), side_q = cross(direction, q - origin);
    if ((side_p > 0 && side_q > 0) || (side_p < 0 && side_q < 0)) return;
    best = {t, n};
  };
  narrow::visit_segments(
      chain, [&](const Aabb& box) { return may_meet(box, origin, direction, std::min(best.t, t_max)); },
      visit);
  return best;
}

void require_pair(const Shape& a, const Shape& b, const char* what) {
  const bool plane_a = a.kind == ShapeKind::HalfPlane, plane_b = b.kind == ShapeKind::HalfPlane;
  const bool chain_a = a.kind == ShapeKind::Chain, chain_b = b.kind == ShapeKind::Chain;
  if ((plane_a || chain_a) && (plane_b || chain_b)) {
    throw std::invalid_argument(
        std::string(what).append(": one of the shapes must be a disc, capsule or polygon"));
  }
}

/// Where a shape that moves against a chain touches it at time t: the segment that it meets then, since it
/// may be passing others from behind, which are as near.
ClosestPoints touch_of_chain(const Shape& chain, const Motion& motion_chain, const Shape& other,
                             const Motion& motion_other, double t) {
  const Transform pose_chain = motion_chain.at(t), pose_other = motion_other.at(t);
  const Aabb box = bounding_box(other, pose_other);
  const double noise =
      1e-9 * (narrow::magnitude(box.lower) + narrow::magnitude(box.upper) + narrow::magnitude(pose_chain.p));
  std::vector<int> segments;
  chain_segments_near(chain, pose_chain, grown(box, noise), segments);
  ClosestPoints touch;
  double first = kInfinity;
  for (const int i : segments) {
    const ImpactTime impact = time_of_impact_chain_segment(chain, i, motion_chain, other, motion_other, 1);
    if (!impact.hit || impact.t > first) continue;
    const ClosestPoints near = closest_to_segment(chain, i, pose_chain, narrow::hull_of(other), pose_other);
    if (impact.t == first && !(near.distance < touch.distance)) continue;
    first = impact.t;
    touch = near;
  }
  return first < kInfinity ? touch : distance(chain, pose_chain, other, pose_other);
}

}  // namespace

ClosestPoints distance(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b) {
  require_pair(a, b, "distance");
  if (a.kind == ShapeKind::Chain) return closest_to_chain(a, pose_a, narrow::hull_of(b), pose_b);
  if (b.kind == ShapeKind::Chain) return exchanged(closest_to_chain(b, pose_b, narrow::hull_of(a), pose_a));
  return closest_of(narrow::hull_of(a), pose_a, narrow::hull_of(b), pose_b);
}

bool overlaps(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b) {
  return distance(a, pose_a, b, pose_b).distance <= 0;
}

ClosestPoint closest_point(const Shape& shape, const Transform& pose, Vec2 point) {
  const Transform at_point{point, {}};
  const Vec2 own;
  const ClosestPoints c = shape.kind == ShapeKind::Chain
                              ? closest_to_chain(shape, pose, point_hull(&own), at_point)
                              : closest_of(narrow::hull_of(shape), pose, point_hull(&own), at_point);
  return {c.point_a, c.normal, c.distance};
}

bool contains(const Shape& shape, const Transform& pose, Vec2 point) {
  return closest_point(shape, pose, point).distance <= 0;
}

namespace {

[[noreturn, gnu::cold]] void refuse_ray(const Ray& ray) {
  throw std::invalid_argument(
      "ray_cast: the ray must be finite, its direction of 1e-150 to 1e150 m and t_max >= 0, got origin " +
      to_text(ray.origin) + ", direction " + to_text(ray.direction) + ", t_max " + to_text(ray.t_max));
}

std::uint64_t bits_of(double x) {
  return std::bit_cast<std::uint64_t>(x);
}

/// The largest finite parameter up to t_max; NaN stays.
double last_of(const Ray& ray) {
  constexpr double largest = std::numeric_limits<double>::max();
  return largest < ray.t_max ? largest : ray.t_max;
}

/// Rays that hit need no check: their results are finite, and so is all that went in.
void require_ray(const Ray& ray) {
  const double speed = length_squared(ray.direction), sum = narrow::magnitude(ray.origin) + speed;
  if (!(sum < kInfinity && speed > 0 && ray.t_max >= 0)) refuse_ray(ray);
}
[[gnu::noinline]] std::optional<RayHit> missed(const Ray& ray) {
  require_ray(ray);
  return std::nullopt;
}
[[gnu::noinline]] std::optional<RayHit> starts_inside(const Ray& ray) {
  require_ray(ray);
  return RayHit{0, ray.origin, -ray.direction / length(ray.direction)};
}

SKERRY_TWICE [[gnu::noinline]] std::optional<RayHit> ray_cast_hull(const Shape& shape, const Transform& pose,
                                                                   const Ray& ray) {
  require_ray(ray);
  const Vec2 origin = to_local(pose, ray.origin), direction = inverse_rotate(pose.q, ray.direction);
  const Hull hull = narrow::hull_of(shape);
  LocalHit hit;
  if (shape.kind == ShapeKind::Polygon && shape.radius == 0) {
    hit = hit_sharp_polygon(hull, origin, direction);
  } else if (shape.kind == ShapeKind::HalfPlane) {
    const double rate = dot(hull.n[0], direction), height = dot(hull.n[0], origin - hull.v[0]);
    if (height <= 0) {
      hit = {0, -direction / length(direction)};
    } else if (rate < 0) {
      hit = {height / -rate, hull.n[0]};
    }
  } else if (shape.kind == ShapeKind::Chain) {
    hit = hit_chain(shape, origin, direction, ray.t_max);
  } else {
    hit = hit_round_hull(hull, origin, direction);
  }
  if (!(hit.t <= ray.t_max && hit.t < kInfinity)) return std::nullopt;
  return RayHit{hit.t, ray.origin + hit.t * ray.direction, rotate(pose.q, hit.normal)};
}

/// The common case of a polygon without rounding: the line enters it, in front of the ray's origin. All
/// others are left to `ray_cast_hull`.
SKERRY_TWICE [[gnu::noinline]] std::optional<RayHit> ray_cast_polygon(const Shape& shape,
                                                                      const Transform& pose, const Ray& ray) {
  using narrow::load, narrow::Two;
  const Two cs = load(pose.q), x_row = with_high_negated(cs), y_row = exchanged(cs);
  const auto turned_back = [&](Two v) { return lows(v, v) * x_row + highs(v, v) * y_row; };
  const Two o = turned_back(load(ray.origin) - load(pose.p)), d = turned_back(load(ray.direction));
  const Two dx = lows(d, d), dy = highs(d, d);
  const Two across = dx * highs(o, o) - dy * lows(o, o);
  const Vec2* const v = shape.vertices.data();
  const std::size_t count = shape.vertices.size();
  const auto two_left = [&](std::size_t i, std::size_t k) {
    const Two v0 = load(v[i]), v1 = load(v[k]);
    return std::uint64_t{bits(at_least(dx * highs(v0, v1) - dy * lows(v0, v1), across))};
  };
  // Downwards, so that the last corner of an odd number is where it belongs; the rest as in
  // hit_sharp_polygon.
  std::uint64_t left = count % 2 != 0 ? two_left(count - 1, count - 1) & 1 : 0;
  for (std::size_t i = count & ~std::size_t{1}; i >= 2; i -= 2) left = left << 2 | two_left(i - 2, i - 1);
  const std::uint64_t enters = left & ~(left >> 1 | (left & 1) << (count - 1));
  if (enters == 0) return left == 0 ? missed(ray) : ray_cast_hull(shape, pose, ray);
  const auto edge = static_cast<std::size_t>(std::countr_zero(enters));
  const Two n = load(shape.normals[edge]), heights = n * (o - load(v[edge])), rates = n * d;
  const double height = heights.low() + heights.high(), rate = rates.low() + rates.high(), t = height / -rate;
  const Two squares = d * d;
  if (!(height > 0) || runs_along(rate, squares.low() + squares.high()))
    return ray_cast_hull(shape, pose, ray);
  if (!(t > 0 && t <= last_of(ray))) return missed(ray);
  std::optional<RayHit> hit(RayHit{t, {}, {}});
  (load(ray.origin) + Two::both(t) * load(ray.direction)).store(&hit->point.x);
  turned(cs, n).store(&hit->normal.x);
  return hit;
}

/// The slabs of a rectangle, both in the lanes; its normals are turned into the world, so the hit is there at
/// once.
[[gnu::always_inline]] inline std::optional<RayHit> ray_cast_rectangle(const Shape& shape,
                                                                       const Transform& pose,
                                                                       const Ray& ray) {
  using narrow::load, narrow::Two;
  const Two n = load(shape.normals.data()[0]), origin = load(ray.origin), d = load(ray.direction);
  const Two u = turned(load(pose.q), n), o = origin - load(pose.p);
  // Scalar and cross product of an axis with a vector.
  const auto both_products = [](Two axis, Two vector) {
    return lows(vector, vector) * with_high_negated(axis) + highs(vector, vector) * exchanged(axis);
  };
  const Two rate = both_products(u, d);
  Two at = both_products(u, o);
  // Nearly always the rectangle's middle is where its body is.
  const Vec2& middle = shape.rectangle.middle;
  if ((bits_of(middle.x) | bits_of(middle.y)) != 0) at = at - both_products(n, load(middle));
  // Where no slab is crossed, the quotients are infinite, or NaN on an edge.
  const Two half = flipped(load(shape.rectangle.half), rate);
  const Two enter = negated(half + at) / rate, leave = (half - at) / rate;
  // Which slab is entered last is hard to foresee, so it is selected.
  const Two last = greater(enter, exchanged(enter)), first_enters = at_least(lows(enter, enter), last);
  const Two from_left = negated(flipped(u, lows(rate, rate)));
  const Two from_below = negated(flipped(exchanged(with_high_negated(u)), highs(rate, rate)));
  const double t = last.low(), end = smallest(leave), most = last_of(ray);
  if (!(t > 0 && t <= (end < most ? end : most))) {
    if (bits(at_least(Two::both(0), magnitude(rate))) != 0) return ray_cast_hull(shape, pose, ray);
    return t <= 0 && end >= 0 ? starts_inside(ray) : missed(ray);
  }
  std::optional<RayHit> hit(RayHit{t, {}, {}});
  (origin + lows(last, last) * d).store(&hit->point.x);
  chosen(first_enters, from_left, from_below).store(&hit->normal.x);
  return hit;
}

/// A disc needs no turning. It is met where m + t d has the length of the radius.
[[gnu::always_inline]] inline std::optional<RayHit> ray_cast_disc(const Shape& shape, const Transform& pose,
                                                                  const Ray& ray) {
  using narrow::load, narrow::Two;
  const Two origin = load(ray.origin), d = load(ray.direction);
  Two m = origin - load(pose.p);
  // Nearly always the disc is where its body is.
  const Vec2& centre = shape.vertices.data()[0];
  if ((bits_of(centre.x) | bits_of(centre.y)) != 0) m = m - turned(load(pose.q), load(centre));
  const double radius = shape.radius, area = radius * radius;
  // Cross and scalar product; squares of the direction's and the way's lengths.
  const Two products = lows(m, m) * exchanged(d) + highs(m, m) * with_low_negated(d);
  const Two own = d * d, far = m * m, lengths = lows(own, far) + highs(own, far);
  const double miss = products.low(), along = products.high();
  const double height = lengths.high() - area, most = lengths.low() * area, square = most - miss * miss;
  if (height <= 0) return starts_inside(ray);
  // Neither negative nor infinite nor NaN, by one comparison.
  if (!(along < 0 && bits_of(square) < bits_of(kInfinity))) return missed(ray);
  // Along the circle where it starts on it, the parameter is a quotient of roundings.
  if (square < 1e-12 * most) return ray_cast_hull(shape, pose, ray);
  // Both quotients take no longer than one.
  const Two quotients = Two::of(height, 1) / Two::of(narrow::root(square) - along, radius);
  const double t = quotients.low();
  if (!(t <= last_of(ray))) return missed(ray);
  const Two way = lows(quotients, quotients) * d;
  std::optional<RayHit> hit(RayHit{t, {}, {}});
  (origin + way).store(&hit->point.x);
  (highs(quotients, quotients) * (m + way)).store(&hit->normal.x);
  return hit;
}

}  // namespace

SKERRY_TWICE std::optional<RayHit> ray_cast(const Shape& shape, const Transform& pose, const Ray& ray) {
  if (shape.kind == ShapeKind::Disc) return ray_cast_disc(shape, pose, ray);
  const bool sharp = bits_of(shape.radius) == 0;
  if (sharp && bits_of(shape.rectangle.half.x) != 0) return ray_cast_rectangle(shape, pose, ray);
  if (sharp && shape.kind == ShapeKind::Polygon) return ray_cast_polygon(shape, pose, ray);
  return ray_cast_hull(shape, pose, ray);
}

std::optional<RayHit> shape_cast(const Shape& moving, const Transform& pose_moving, Vec2 translation,
                                 const Shape& target, const Transform& pose_target) {
  require_pair(moving, target, "shape_cast");
  if (!is_finite(translation))
    throw std::invalid_argument("shape_cast: translation must be finite, got " + to_text(translation));
  const ClosestPoints start = distance(target, pose_target, moving, pose_moving);
  if (start.distance <= 0) return RayHit{0, start.point_a, start.normal};
  const auto motion = [](const Transform& pose, Vec2 v) {
    Motion m;
    m.p0 = pose.p;
    m.angle0 = std::atan2(pose.q.s, pose.q.c);
    m.v = v;
    return m;
  };
  const Motion of_target = motion(pose_target, {}), of_moving = motion(pose_moving, translation);
  const ImpactTime impact = time_of_impact(target, of_target, moving, of_moving, 1);
  if (!impact.hit) return std::nullopt;
  const ClosestPoints touch =
      target.kind == ShapeKind::Chain ? touch_of_chain(target, of_target, moving, of_moving, impact.t)
      : moving.kind == ShapeKind::Chain
          ? exchanged(touch_of_chain(moving, of_moving, target, of_target, impact.t))
          : distance(target, pose_target, moving, {pose_moving.p + impact.t * translation, pose_moving.q});
  return RayHit{impact.t, touch.point_a, touch.normal};
}

}  // namespace skerry
