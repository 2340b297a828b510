// SPDX-License-Identifier: MIT
//
// Small plane geometry: vectors, rotations, rigid transforms, axis-aligned boxes. No Eigen here: this header
// is included everywhere, and everything in it is two to four doubles. Angles are in rad, lengths in m unless
// said.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace skerry {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A vector or point of the plane.
struct Vec2 {
  double x = 0;
  double y = 0;

  constexpr Vec2& operator+=(Vec2 o) { return x += o.x, y += o.y, *this; }
  constexpr Vec2& operator-=(Vec2 o) { return x -= o.x, y -= o.y, *this; }
  constexpr Vec2& operator*=(double s) { return x *= s, y *= s, *this; }
  friend constexpr bool operator==(Vec2, Vec2) = default;
};

constexpr Vec2 operator+(Vec2 a, Vec2 b) {
  return {a.x + b.x, a.y + b.y};
}
constexpr Vec2 operator-(Vec2 a, Vec2 b) {
  return {a.x - b.x, a.y - b.y};
}
constexpr Vec2 operator-(Vec2 a) {
  return {-a.x, -a.y};
}
constexpr Vec2 operator*(double s, Vec2 a) {
  return {s * a.x, s * a.y};
}
constexpr Vec2 operator*(Vec2 a, double s) {
  return {s * a.x, s * a.y};
}
constexpr Vec2 operator/(Vec2 a, double s) {
  return {a.x / s, a.y / s};
}
constexpr double dot(Vec2 a, Vec2 b) {
  return a.x * b.x + a.y * b.y;
}
/// The z component of the cross product; positive when `b` is to the left of `a`.
constexpr double cross(Vec2 a, Vec2 b) {
  return a.x * b.y - a.y * b.x;
}
/// `a` turned by +90 degrees; the velocity of a point is `v + omega * perp(r)`.
constexpr Vec2 perp(Vec2 a) {
  return {-a.y, a.x};
}
constexpr double length_squared(Vec2 a) {
  return dot(a, a);
}
inline double length(Vec2 a) {
  return std::sqrt(dot(a, a));
}
inline bool is_finite(Vec2 a) {
  return std::isfinite(a.x) && std::isfinite(a.y);
}

/// Sine and cosine of one angle.
struct SinCos {
  double sin;
  double cos;
};

/// Returns sine and cosine of `angle` [rad] to about one unit in the last place.
///
/// The C library picks its sine by processor (with or without fused multiply-add), so its last bit differs
/// between machines; this one uses additions and multiplications in a fixed order only, and gives the same
/// bits everywhere.
SinCos sin_cos(double angle);

/// A rotation as cosine and sine.
struct Rot {
  double c = 1;
  double s = 0;

  static Rot from_angle(double angle) {
    const SinCos sc = sin_cos(angle);
    return {sc.cos, sc.sin};
  }
  friend constexpr bool operator==(Rot, Rot) = default;
};

constexpr Vec2 rotate(Rot q, Vec2 v) {
  return {q.c * v.x - q.s * v.y, q.s * v.x + q.c * v.y};
}
constexpr Vec2 inverse_rotate(Rot q, Vec2 v) {
  return {q.c * v.x + q.s * v.y, q.c * v.y - q.s * v.x};
}
/// The rotation `a` after `b`.
constexpr Rot operator*(Rot a, Rot b) {
  return {a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s};
}

/// A pose: `world = p + q local`. For bodies `p` is the centre of mass.
struct Transform {
  Vec2 p;
  Rot q;
  friend constexpr bool operator==(const Transform&, const Transform&) = default;
};

constexpr Vec2 to_world(const Transform& t, Vec2 local) {
  return t.p + rotate(t.q, local);
}
constexpr Vec2 to_local(const Transform& t, Vec2 world) {
  return inverse_rotate(t.q, world - t.p);
}

/// An axis-aligned box; touching boxes overlap.
struct Aabb {
  Vec2 lower;
  Vec2 upper;
};

constexpr bool overlap(const Aabb& a, const Aabb& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y;
}
constexpr bool contains(const Aabb& box, Vec2 point) {
  return box.lower.x <= point.x && point.x <= box.upper.x && box.lower.y <= point.y && point.y <= box.upper.y;
}
constexpr Aabb united(const Aabb& a, const Aabb& b) {
  return {{std::min(a.lower.x, b.lower.x), std::min(a.lower.y, b.lower.y)},
          {std::max(a.upper.x, b.upper.x), std::max(a.upper.y, b.upper.y)}};
}
constexpr Aabb grown(const Aabb& box, double margin) {
  return {{box.lower.x - margin, box.lower.y - margin}, {box.upper.x + margin, box.upper.y + margin}};
}

}  // namespace skerry
