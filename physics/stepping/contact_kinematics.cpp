// SPDX-License-Identifier: MIT
#include "physics/stepping/contact_kinematics.h"

#include <algorithm>
#include <cmath>

namespace skerry {
namespace {

// Rounding of a place, in shares of its coordinates.
constexpr double kRoundedPlace = 4e-15;

/// Corners and edges of a shape as the manifold's feature codes count them.
class Outline {
 public:
  Outline(const Shape& shape, int child) : shape_(shape), child_(child) {}

  int count() const { return static_cast<int>(shape_.vertices.size()); }
  Vec2 corner(int i) const { return shape_.vertices[static_cast<std::size_t>(wrapped(i + first()))]; }
  Vec2 normal(int edge) const { return shape_.normals[static_cast<std::size_t>(wrapped(edge + first()))]; }
  bool has_edges() const { return !shape_.normals.empty(); }
  bool endless() const { return shape_.kind == ShapeKind::HalfPlane; }

  /// Directions of the edges that leave corner `i`.
  int edges_from(int i, std::array<Vec2, 2>& out) const {
    if (count() < 2) return 0;
    if (shape_.kind == ShapeKind::Chain) {
      out[0] = unit(corner(1 - i) - corner(i));
      return 1;
    }
    out[0] = unit(corner(i + 1) - corner(i));
    out[1] = unit(corner(i - 1) - corner(i));
    return 2;
  }

  /// Edges that meet at corner `i`.
  std::array<int, 2> edges_at(int i) const {
    if (shape_.kind == ShapeKind::Chain) return {0, 0};
    return {i, i == 0 ? count() - 1 : i - 1};
  }

 private:
  int first() const { return shape_.kind == ShapeKind::Chain ? child_ : 0; }
  int wrapped(int i) const { return (i + count()) % count(); }
  static Vec2 unit(Vec2 v) { return v / skerry::length(v); }

  const Shape& shape_;
  int child_;
};

/// Describes an edge of one shape against a point of the other.
void set_edge(const Outline& outline, int edge, Vec2& start, ContactFeatures& f) {
  start = outline.corner(edge);
  f.normal = outline.normal(edge);
  if (outline.endless()) {
    f.along = perp(f.normal);
    return;
  }
  const Vec2 d = outline.corner(edge + 1) - start;
  f.length = length(d);
  f.along = d / f.length;
}

/// Number of the edge at corner `i` whose normal is `n` (shape's frame), or -1.
int matching_edge(const Outline& outline, int i, Vec2 n) {
  if (!outline.has_edges()) return -1;
  for (const int edge : outline.edges_at(i)) {
    const Vec2 own = outline.normal(edge);
    // Corners of aligned faces bear the label of two corners; the normal tells what they are.
    if (dot(own, n) > 0 && std::abs(cross(own, n)) < 1e-7) return edge;
  }
  return -1;
}

/// True if a point that touches a corner, with a normal that is that of an edge there, has passed the corner:
/// the edge does not meet it any more. @param point  in the frame of the outline  @param slack  rounding [m]
bool is_past(const Outline& outline, int edge, Vec2 point, double slack) {
  ContactFeatures f;
  Vec2 start;
  set_edge(outline, edge, start, f);
  const double s = dot(f.along, point - start);
  return std::min(s, f.length - s) < -std::max(0.5 * kBeyondCorner, slack);
}

/// Point `p` of F above the edge (start `e`, normal N) of E. All vectors in the world frame; the result's
/// normal points from E to F.
ContactKinematics point_on_edge(const ContactFeatures& f, Vec2 start, Vec2 point, double radius_e,
                                double radius_f, const BodyMotion& e, const BodyMotion& p) {
  ContactKinematics k;
  const Vec2 n = rotate(e.q, f.normal), along = rotate(e.q, f.along);
  const Vec2 r = rotate(p.q, point);
  const Vec2 d = (p.p - e.p) + (r - rotate(e.q, start));
  const double distance = dot(n, d);
  const double s = dot(along, d);
  k.gap = distance - radius_e - radius_f;
  if (std::isfinite(f.length)) k.range = std::min(s, f.length - s);
  const Vec2 foot = (p.p - e.p) + (r - distance * n);  // material point of E below the point
  const Vec2 v_point = p.v + p.omega * perp(r);
  const Vec2 apart = v_point - (e.v + e.omega * perp(foot));
  k.gap_rate = dot(n, apart);
  // d2/dt2 of N . d for a turning N, less what the accelerations bring.
  k.normal_bias = dot(n, e.omega * e.omega * foot - p.omega * p.omega * r) +
                  2 * e.omega * dot(perp(n), apart) - e.omega * e.omega * distance;
  k.normal = n;
  k.position = p.p + r - (radius_f + 0.5 * k.gap) * n;
  return k;
}

/// Fills what concerns sliding: `turn` is the rate at which the normal turns, `c` the velocity of the contact
/// point's position.
void add_sliding(const BodyMotion& a, const BodyMotion& b, double turn, Vec2 c, ContactKinematics& k) {
  const Vec2 t = perp(k.normal);
  const Vec2 relative = b.v + b.omega * perp(k.position - b.p) - a.v - a.omega * perp(k.position - a.p);
  k.sliding = dot(t, relative);
  k.tangent_bias =
      -turn * dot(k.normal, relative) + dot(t, b.omega * perp(c - b.v) - a.omega * perp(c - a.v));
}

}  // namespace

std::optional<ContactFeatures> features_of(const Contact& contact, const Shape& a, const Transform& pose_a,
                                           const Shape& b, const Transform& pose_b, int i) {
  std::uint32_t feature = contact.manifold.points[static_cast<std::size_t>(i)].feature;
  if (b.kind == ShapeKind::Chain) feature = mirrored(feature);  // chains come first in their manifolds
  const std::uint32_t code_a = feature >> 16, code_b = feature & 0xffffu;
  const Outline outline_a(a, contact.child), outline_b(b, contact.child);
  const int index_a = static_cast<int>(code_a / 2), index_b = static_cast<int>(code_b / 2);
  int edge_a = code_a % 2 == 1 ? index_a : -1;
  int edge_b = code_b % 2 == 1 ? index_b : -1;
  if (edge_a >= 0 && edge_b >= 0) return std::nullopt;

  ContactFeatures f;
  f.radius_a = a.radius;
  f.radius_b = b.radius;
  if (edge_a < 0 && edge_b < 0) {
    const Vec2 corner_a = to_world(pose_a, outline_a.corner(index_a)),
               corner_b = to_world(pose_b, outline_b.corner(index_b));
    const double slack = kRoundedPlace * (std::abs(corner_a.x) + std::abs(corner_a.y));
    edge_a = matching_edge(outline_a, index_a, inverse_rotate(pose_a.q, contact.manifold.normal));
    edge_b = matching_edge(outline_b, index_b, inverse_rotate(pose_b.q, -contact.manifold.normal));
    const bool a_meets = edge_a >= 0 && !is_past(outline_a, edge_a, to_local(pose_a, corner_b), slack);
    const bool b_meets = edge_b >= 0 && !is_past(outline_b, edge_b, to_local(pose_b, corner_a), slack);
    if (a_meets) {
      edge_b = -1;
    } else if (b_meets) {
      edge_a = -1;
    } else if (f.radius_a + f.radius_b > 0) {
      edge_a = edge_b = -1;
    } else {
      f.past = edge_a >= 0 || edge_b >= 0;
    }
  }
  if (edge_a >= 0) {
    f.kind = ContactFeatures::Kind::EdgeOfA;
    set_edge(outline_a, edge_a, f.point_a, f);
    f.point_b = outline_b.corner(index_b);
  } else if (edge_b >= 0) {
    f.kind = ContactFeatures::Kind::EdgeOfB;
    set_edge(outline_b, edge_b, f.point_b, f);
    f.point_a = outline_a.corner(index_a);
  } else {
    f.point_a = outline_a.corner(index_a);
    f.point_b = outline_b.corner(index_b);
    f.edge_count_a = outline_a.edges_from(index_a, f.edges_a);
    f.edge_count_b = outline_b.edges_from(index_b, f.edges_b);
  }
  return f;
}

std::optional<ContactKinematics> kinematics_of(const ContactFeatures& f, const BodyMotion& a,
                                               const BodyMotion& b) {
  if (f.kind == ContactFeatures::Kind::EdgeOfA) {
    ContactKinematics k = point_on_edge(f, f.point_a, f.point_b, f.radius_a, f.radius_b, a, b);
    const Vec2 v_point = b.v + b.omega * perp(rotate(b.q, f.point_b));
    const double offset = f.radius_b + 0.5 * k.gap;
    add_sliding(a, b, a.omega, v_point - offset * a.omega * perp(k.normal) - 0.5 * k.gap_rate * k.normal, k);
    return k;
  }
  if (f.kind == ContactFeatures::Kind::EdgeOfB) {
    ContactKinematics k = point_on_edge(f, f.point_b, f.point_a, f.radius_b, f.radius_a, b, a);
    const Vec2 v_point = a.v + a.omega * perp(rotate(a.q, f.point_a));
    const double offset = f.radius_a + 0.5 * k.gap;
    const Vec2 c = v_point - offset * b.omega * perp(k.normal) - 0.5 * k.gap_rate * k.normal;
    k.normal = -k.normal;
    add_sliding(a, b, b.omega, c, k);
    return k;
  }
  ContactKinematics k;
  const Vec2 ra = rotate(a.q, f.point_a), rb = rotate(b.q, f.point_b);
  const Vec2 d = (b.p - a.p) + (rb - ra);
  const double distance = length(d);
  const double size = std::abs(ra.x) + std::abs(ra.y) + std::abs(rb.x) + std::abs(rb.y) + f.radius_a;
  if (!(distance > 1e-9 * size)) return std::nullopt;
  k.normal = d / distance;
  const Vec2 t = perp(k.normal);
  k.gap = distance - f.radius_a - f.radius_b;
  const Vec2 v_a = a.v + a.omega * perp(ra);
  const Vec2 apart = b.v + b.omega * perp(rb) - v_a;
  k.gap_rate = dot(k.normal, apart);
  const double across = dot(t, apart);
  k.normal_bias = dot(k.normal, a.omega * a.omega * ra - b.omega * b.omega * rb) + across * across / distance;
  const double offset = f.radius_a + 0.5 * k.gap;
  k.position = a.p + ra + offset * k.normal;
  for (int i = 0; i < f.edge_count_a; ++i)
    k.range = std::min(k.range, -dot(rotate(a.q, f.edges_a[static_cast<std::size_t>(i)]), d));
  for (int i = 0; i < f.edge_count_b; ++i)
    k.range = std::min(k.range, dot(rotate(b.q, f.edges_b[static_cast<std::size_t>(i)]), d));
  const double turn = across / distance;
  add_sliding(a, b, turn, v_a + offset * turn * t + 0.5 * k.gap_rate * k.normal, k);
  return k;
}

}  // namespace skerry
