// SPDX-License-Identifier: MIT
#include "physics/shape.h"

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <string_view>

#include "physics/narrowphase/chain_tree.h"

namespace skerry {
namespace {

constexpr double kLargestLength = 1.0e12;  // coordinates beyond this are refused: their squares lose too much
constexpr double kSmallestLength = 1.0e-100;  // shorter ones have squares that underflow: no direction
constexpr std::size_t kMaxCorners = 64;
// Two edges count as collinear below this sine. Slivers of a ratio 1e-11 are still accepted; corners that
// were meant to lie on a line and differ by rounding are not.
constexpr double kCollinearSine = 1.0e-12;

std::string text(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.17g", value);
  return buffer.data();
}

std::string text(std::size_t value) {
  return std::to_string(value);
}

std::string text(Vec2 value) {
  return std::string("(").append(text(value.x)).append(", ").append(text(value.y)).append(")");
}

std::string text(std::string_view value) {
  return std::string(value);
}

template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
  std::string message;
  (message.append(text(parts)), ...);
  throw std::invalid_argument(message);
}

bool is_usable(Vec2 p) {
  return std::abs(p.x) <= kLargestLength && std::abs(p.y) <= kLargestLength;  // false for NaN
}

void require_point(Vec2 p, std::string_view what) {
  if (!is_usable(p)) refuse(what, " must be finite and within 1e12 m, got ", p);
}

void require_points(std::span<const Vec2> points, std::string_view what) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_usable(points[i])) refuse(what, i, " must be finite and within 1e12 m, got ", points[i]);
  }
}

void require_length(double value, std::string_view what) {
  if (!(value > 0 && value <= kLargestLength))
    refuse(what, " must be positive and at most 1e12 m, got ", value);
}

/// Angle in (0, pi) with the given sine and cosine. Sums, quotients and roots only, so that every machine
/// gives the same bits.
double turn_angle(double sine, double cosine) {
  double t = cosine >= 0 ? sine / (1 + cosine) : (1 - cosine) / sine;  // tan(angle/2)
  int halvings = 1;
  while (t > 0.2) {
    t = t / (1 + std::sqrt(1 + t * t));
    ++halvings;
  }
  // Arctangent's series: 0.2^27/27 is below 1e-20.
  const double z = t * t;
  double sum = 0;
  for (int k = 25; k >= 1; k -= 2) sum = 1.0 / k - z * sum;
  return std::ldexp(t * sum, halvings);
}

/// The rectangle that four corners make, within a few roundings of their coordinates.
Shape::Rectangle rectangle_of(const std::vector<Vec2>& v, const std::vector<Vec2>& n) {
  if (v.size() != 4) return {};
  const Vec2 middle = 0.5 * (v[0] + v[2]), skew = (v[0] + v[2]) - (v[1] + v[3]);
  double scale = 0;
  for (const Vec2 p : v) scale = std::max({scale, std::abs(p.x), std::abs(p.y)});
  const bool right = std::abs(dot(n[0], n[1])) <= 1e-15;
  if (!right || std::abs(skew.x) + std::abs(skew.y) > 2e-15 * scale) return {};
  return {middle, {0.5 * dot(n[0], v[1] - v[2]), 0.5 * dot(n[1], v[1] - v[0])}};
}

AreaProperties rounded_polygon_properties(const Shape& shape) {
  const std::size_t n = shape.vertices.size();
  const double r = shape.radius;
  // All moments about the first corner, where nothing large cancels.
  const Vec2 origin = shape.vertices[0];
  double area = 0, second = 0;
  Vec2 first;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = i + 1 < n ? i + 1 : 0;
    const Vec2 a = shape.vertices[i] - origin, b = shape.vertices[j] - origin;
    // Triangle (origin, a, b).
    const double twice = cross(a, b);
    area += 0.5 * twice;
    first += (twice / 6) * (a + b);
    second += twice / 12 * (dot(a, a) + dot(a, b) + dot(b, b));
    if (r == 0) continue;
    // Rectangle that rounding adds along the edge.
    const double edge = length(b - a);
    const Vec2 middle = 0.5 * (a + b) + (0.5 * r) * shape.normals[i];
    area += edge * r;
    first += (edge * r) * middle;
    second += edge * r * ((edge * edge + r * r) / 12 + dot(middle, middle));
    // Sector at b between this normal and the next: its first moment about b is the integral of r^2/3 u dphi.
    const Vec2 from = shape.normals[i], to = shape.normals[j];
    const double angle = turn_angle(cross(from, to), dot(from, to));
    const double sector = 0.5 * angle * r * r;
    const Vec2 sector_first = (-r * r * r / 3) * perp(to - from);
    area += sector;
    first += sector * b + sector_first;
    second += sector * dot(b, b) + 2 * dot(b, sector_first) + 0.25 * angle * r * r * r * r;
  }
  const Vec2 centroid = first / area;
  return {area, origin + centroid, second - area * dot(centroid, centroid)};
}

}  // namespace

Shape make_disc(double radius, Vec2 centre) {
  require_length(radius, "make_disc: radius");
  require_point(centre, "make_disc: centre");
  Shape shape;
  shape.kind = ShapeKind::Disc;
  shape.radius = radius;
  shape.vertices = {centre};
  return shape;
}

Shape make_capsule(Vec2 from, Vec2 to, double radius) {
  require_point(from, "make_capsule: first end");
  require_point(to, "make_capsule: second end");
  require_length(radius, "make_capsule: radius");
  const double len = length(to - from);
  if (!(len > kSmallestLength)) refuse("make_capsule: the ends coincide at ", from);
  Shape shape;
  shape.kind = ShapeKind::Capsule;
  shape.radius = radius;
  shape.vertices = {from, to};
  const Vec2 normal = -perp((to - from) / len);
  shape.normals = {normal, -normal};
  return shape;
}

Shape make_polygon(std::span<const Vec2> corners, double rounding) {
  const std::size_t n = corners.size();
  if (n < 3 || n > kMaxCorners) {
    refuse("make_polygon: 3 to 64 corners expected, got ", n);
  }
  if (!(rounding >= 0 && rounding <= kLargestLength)) {
    refuse("make_polygon: rounding must be >= 0 and at most 1e12 m, got ", rounding);
  }
  require_points(corners, "make_polygon: corner ");

  // Orientation by the area about the first corner.
  double twice_area = 0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    twice_area += cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  }
  std::vector<std::size_t> order(n);  // the caller's number of each corner, counter-clockwise
  for (std::size_t i = 0; i < n; ++i) order[i] = twice_area < 0 ? (n - i) % n : i;

  Shape shape;
  shape.kind = ShapeKind::Polygon;
  shape.radius = rounding;
  shape.vertices.reserve(n);
  shape.normals.reserve(n);
  for (std::size_t i : order) shape.vertices.push_back(corners[i]);
  const auto& v = shape.vertices;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = i + 1 < n ? i + 1 : 0;
    const double len = length(v[next] - v[i]);
    if (!(len > kSmallestLength)) {
      const auto [low, high] = std::minmax(order[i], order[next]);
      refuse("make_polygon: corner ", high, " repeats corner ", low, ", ", v[i]);
    }
    shape.normals.push_back(-perp((v[next] - v[i]) / len));
  }
  // Each corner must turn left.
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t previous = i > 0 ? i - 1 : n - 1;
    const double sine = cross(shape.normals[previous], shape.normals[i]);
    if (sine > kCollinearSine) continue;
    const bool collinear = sine >= -kCollinearSine;
    refuse("make_polygon: corner ", order[i], " at ", v[i],
           (collinear ? " lies on a line with its neighbours" : " makes the outline non-convex"));
  }
  // Left turns all around may still wind twice, like a star: no corner may lie outside any edge.
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      const double height = dot(shape.normals[i], v[k] - v[i]);
      if (height > kCollinearSine * length(v[k] - v[i])) {
        refuse("make_polygon: corner ", order[k], " at ", v[k], " lies outside the edge from corner ",
               order[i], ", so the outline is non-convex");
      }
    }
  }
  shape.rectangle = rectangle_of(shape.vertices, shape.normals);
  return shape;
}

Shape make_box(Vec2 size, Vec2 centre, double angle, double rounding) {
  require_length(size.x, "make_box: width");
  require_length(size.y, "make_box: height");
  require_point(centre, "make_box: centre");
  if (!std::isfinite(angle)) refuse("make_box: angle must be finite, got ", angle);
  const Vec2 half = 0.5 * size - Vec2{rounding, rounding};
  if (!(rounding >= 0 && half.x > 0 && half.y > 0)) {
    refuse("make_box: rounding must be >= 0 and below half of ", size, ", got ", rounding);
  }
  const Rot q = Rot::from_angle(angle);
  const std::array<Vec2, 4> corners{
      centre + rotate(q, {-half.x, -half.y}), centre + rotate(q, {half.x, -half.y}),
      centre + rotate(q, {half.x, half.y}), centre + rotate(q, {-half.x, half.y})};
  return make_polygon(corners, rounding);
}

Shape make_half_plane(Vec2 point, Vec2 normal) {
  require_point(point, "make_half_plane: point");
  const double len = length(normal);
  if (!(std::isfinite(len) && len > kSmallestLength)) {
    refuse("make_half_plane: normal must be finite and not zero, got ", normal);
  }
  Shape shape;
  shape.kind = ShapeKind::HalfPlane;
  shape.vertices = {point};
  shape.normals = {normal / len};
  return shape;
}

Shape make_chain(std::span<const Vec2> corners, bool closed) {
  const std::size_t n = corners.size();
  if (n < (closed ? 3u : 2u)) {
    refuse("make_chain: at least ", (closed ? "3" : "2"), " corners expected, got ", n);
  }
  Shape shape;
  shape.kind = ShapeKind::Chain;
  shape.closed = closed;
  require_points(corners, "make_chain: corner ");
  shape.vertices.assign(corners.begin(), corners.end());
  const std::size_t segments = closed ? n : n - 1;
  shape.normals.reserve(segments);
  for (std::size_t i = 0; i < segments; ++i) {
    const std::size_t next = i + 1 < n ? i + 1 : 0;
    const Vec2 edge = corners[next] - corners[i];
    const double len = length(edge);
    if (!(len > kSmallestLength)) {
      refuse("make_chain: corner ", next, " repeats corner ", i, ", ", corners[i]);
    }
    shape.normals.push_back(perp(edge / len));
  }
  shape.tree = narrow::chain_tree(shape);
  return shape;
}

Shape translated(const Shape& shape, Vec2 offset) {
  Shape moved = shape;
  for (Vec2& v : moved.vertices) v += offset;
  // Rounding keeps order, so the moved boxes are those of the moved corners.
  for (Vec2& v : moved.tree) v += offset;
  if (moved.rectangle.half != Vec2{}) moved.rectangle.middle += offset;
  return moved;
}

AreaProperties area_properties(const Shape& shape) {
  const double r = shape.radius;
  switch (shape.kind) {
    case ShapeKind::Disc:
      return {kPi * r * r, shape.vertices[0], 0.5 * kPi * r * r * r * r};
    case ShapeKind::Capsule: {
      // A rectangle and two half discs; a half disc's centre of mass is 4 r / (3 pi) from its diameter.
      const double len = length(shape.vertices[1] - shape.vertices[0]);
      const double box = 2 * r * len, disc = kPi * r * r;
      const double second = box * (len * len + 4 * r * r) / 12 + disc * (0.5 * r * r + 0.25 * len * len) +
                            4.0 / 3.0 * r * r * r * len;
      return {box + disc, 0.5 * (shape.vertices[0] + shape.vertices[1]), second};
    }
    case ShapeKind::Polygon:
      return rounded_polygon_properties(shape);
    default:
      return {0, shape.vertices[0], 0};
  }
}

Aabb bounding_box(const Shape& shape, const Transform& pose) {
  if (shape.kind == ShapeKind::HalfPlane) {
    const Vec2 n = rotate(pose.q, shape.normals[0]);
    const Vec2 point = to_world(pose, shape.vertices[0]);
    const double offset = dot(n, point);
    Aabb box{{-kEndless, -kEndless}, {kEndless, kEndless}};
    // Within |x| <= limit the plane bounds y, and the other way round.
    const auto bound = [&](double along, double across, double& lower, double& upper) {
      if (along == 0) return;
      const double limit = (offset + std::abs(across) * kEndless) / along;
      if (along > 0) upper = std::clamp(limit, lower, upper);
      if (along < 0) lower = std::clamp(limit, lower, upper);
    };
    bound(n.y, n.x, box.lower.y, box.upper.y);
    bound(n.x, n.y, box.lower.x, box.upper.x);
    return box;
  }
  Vec2 lower = rotate(pose.q, shape.vertices[0]), upper = lower;
  for (std::size_t i = 1; i < shape.vertices.size(); ++i) {
    const Vec2 v = rotate(pose.q, shape.vertices[i]);
    lower = {std::min(lower.x, v.x), std::min(lower.y, v.y)};
    upper = {std::max(upper.x, v.x), std::max(upper.y, v.y)};
  }
  return grown({pose.p + lower, pose.p + upper}, shape.radius);
}

double bounding_radius(const Shape& shape) {
  if (shape.kind == ShapeKind::HalfPlane) return kInfinity;
  double largest = 0;
  for (const Vec2 v : shape.vertices) largest = std::max(largest, length_squared(v));
  return std::sqrt(largest) + shape.radius;
}

double half_width(const Shape& shape) {
  if (shape.kind == ShapeKind::HalfPlane || shape.kind == ShapeKind::Chain) return 0;
  if (shape.kind != ShapeKind::Polygon) return shape.radius;
  Vec2 middle;
  for (const Vec2 v : shape.vertices) middle += v;
  middle = middle / static_cast<double>(shape.vertices.size());
  double least = kInfinity;
  for (std::size_t i = 0; i < shape.vertices.size(); ++i)
    least = std::min(least, dot(shape.normals[i], shape.vertices[i] - middle));
  return least + shape.radius;
}

}  // namespace skerry
