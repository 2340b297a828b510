// SPDX-License-Identifier: MIT
#include "physics/joint_rows.h"

#include "physics/world.h"

namespace skerry {
namespace {

/// A scalar function of the two poses with its first and second derivative in time.
struct Coordinate {
  double value = 0;
  std::array<double, 3> Ja{}, Jb{};
  double bias = 0;
  bool singular = false;
};

Coordinate operator-(const Coordinate& c) {
  return {-c.value, {-c.Ja[0], -c.Ja[1], -c.Ja[2]}, {-c.Jb[0], -c.Jb[1], -c.Jb[2]}, -c.bias, c.singular};
}

/// The anchors of a joint and how they move. @tparam kMoving  false: velocities are not looked at, and every
/// bias is zero
template <bool kMoving>
class Anchors {
 public:
  Anchors(const JointRecord& joint, const JointEnd& a, const JointEnd& b)
      : a_(a),
        b_(b),
        ra_(rotate(a.q, joint.local_a)),
        rb_(rotate(b.q, joint.local_b)),
        apart_((b.p - a.p) + (rb_ - ra_)) {
    if constexpr (!kMoving) return;
    rate_ = b.v + b.omega * perp(rb_) - a.v - a.omega * perp(ra_);
    centripetal_ = a.omega * a.omega * ra_ - b.omega * b.omega * rb_;
  }

  /// e . d for a direction that is fixed in the world.
  Coordinate along(Vec2 e) const {
    return {dot(e, apart_),
            {-e.x, -e.y, -cross(ra_, e)},
            {e.x, e.y, cross(rb_, e)},
            kMoving ? dot(e, centripetal_) : 0,
            false};
  }

  /// u . d for a direction that turns with a: u' = omega_a perp(u).
  Coordinate along_axis(Vec2 u) const {
    const double w = kMoving ? a_.omega : 0;
    return {dot(u, apart_),
            {-u.x, -u.y, -cross(ra_ + apart_, u)},
            {u.x, u.y, cross(rb_, u)},
            kMoving ? dot(u, centripetal_) + 2 * w * dot(perp(u), rate_) - w * w * dot(u, apart_) : 0,
            false};
  }

  /// |d|: the second derivative is n . d'' + (n x d')^2 / |d|.
  Coordinate distance() const {
    const double distance = length(apart_);
    // Anchors on one point have no direction; any will do, and the next step has one.
    const Vec2 n = distance > 0 ? apart_ / distance : Vec2{0, 1};
    Coordinate c = along(n);
    const double across = cross(n, rate_);
    c.value = distance;
    c.singular = !(distance > 0);
    if (kMoving && !c.singular) c.bias += across * across / distance;
    return c;
  }

  Coordinate angle(double reference) const {
    return {b_.angle - a_.angle - reference, {0, 0, -1}, {0, 0, 1}, 0, false};
  }

  /// |x_a - wheel_a| + ratio |x_b - wheel_b|
  Coordinate pulley(const JointDef& def) const {
    Coordinate c;
    const auto add = [&c](const JointEnd& body, Vec2 r, Vec2 wheel, double weight, std::array<double, 3>& J) {
      const Vec2 rope = body.p + r - wheel;
      const double distance = length(rope);
      const Vec2 n = distance > 0 ? rope / distance : Vec2{0, -1};
      c.value += weight * distance;
      J = {weight * n.x, weight * n.y, weight * cross(r, n)};
      c.singular |= !(distance > 0);
      if constexpr (!kMoving) return;
      c.bias -= weight * body.omega * body.omega * dot(n, r);
      const double across = cross(n, body.v + body.omega * perp(r));
      if (distance > 0) c.bias += weight * across * across / distance;
    };
    add(a_, ra_, def.pulley_a, 1, c.Ja);
    add(b_, rb_, def.pulley_b, def.ratio, c.Jb);
    return c;
  }

  /// angle_b + ratio angle_a
  Coordinate gear(double ratio) const {
    return {b_.angle + ratio * a_.angle, {0, 0, ratio}, {0, 0, 1}, 0, false};
  }

  /// u . x_b - radius angle_a, u fixed in the world
  Coordinate rack(Vec2 u, double radius) const {
    return {dot(u, b_.p + rb_) - radius * a_.angle,
            {0, 0, -radius},
            {u.x, u.y, cross(rb_, u)},
            kMoving ? -b_.omega * b_.omega * dot(u, rb_) : 0,
            false};
  }

 private:
  const JointEnd& a_;
  const JointEnd& b_;
  Vec2 ra_, rb_, apart_;
  Vec2 rate_, centripetal_;  // of what moves
};

double rate_of(const Coordinate& c, const JointEnd& a, const JointEnd& b) {
  return c.Ja[0] * a.v.x + c.Ja[1] * a.v.y + c.Ja[2] * a.omega + c.Jb[0] * b.v.x + c.Jb[1] * b.v.y +
         c.Jb[2] * b.omega;
}

/// Collects the rows of one joint. @tparam kMoving  false: without `rate` and `bias`
template <bool kMoving>
class Rows {
 public:
  Rows(const JointDef& def, bool stalled, const JointEnd& a, const JointEnd& b, JointRows& rows)
      : def_(def), stalled_(stalled), a_(a), b_(b), rows_(rows) {}

  void hold(const Coordinate& c, double value) { add(JointRowKind::Hold, c, value); }

  void spring(const Coordinate& c, double rest) {
    if (!(def_.stiffness > 0) && !(def_.damping > 0)) return;
    JointRow& row = add(JointRowKind::Spring, c, rest);
    row.stiffness = def_.stiffness;
    row.damping = def_.damping;
  }

  void motor(const Coordinate& c) {
    // One without a force does nothing.
    if (!def_.motor_speed || !(def_.motor_limit > 0)) return;
    // One that has come to a limit holds there.
    if (stalled_) return hold(c, *def_.motor_speed > 0 ? *def_.upper : *def_.lower);
    JointRow& row = add(JointRowKind::Motor, c, c.value);
    row.speed = *def_.motor_speed;
    row.most = def_.motor_limit;
  }

  void limits(const Coordinate& c) {
    // Limits without a way between them hold.
    if (def_.lower && def_.upper && *def_.lower == *def_.upper) return hold(c, *def_.lower);
    if (def_.lower) add(JointRowKind::Limit, c, *def_.lower);
    if (def_.upper) add(JointRowKind::Limit, -c, -*def_.upper);
  }

  void all(const Coordinate& c, double rest) {
    spring(c, rest);
    motor(c);
    limits(c);
  }

  /// Something acts on the coordinate of the joint.
  bool any() const {
    return def_.stiffness > 0 || def_.damping > 0 || def_.motor_speed || def_.lower || def_.upper;
  }

  int count() const { return count_; }

 private:
  JointRow& add(JointRowKind kind, const Coordinate& c, double value) {
    JointRow& row = rows_[static_cast<std::size_t>(count_++)];
    row.kind = kind;
    row.Ja = c.Ja;
    row.Jb = c.Jb;
    row.error = c.value - value;
    if constexpr (kMoving) {
      row.rate = rate_of(c, a_, b_);
      row.bias = c.bias;
    }
    row.speed = row.stiffness = row.damping = 0;
    row.most = kInfinity;
    row.singular = c.singular;
    return row;
  }

  const JointDef& def_;
  bool stalled_;
  const JointEnd& a_;
  const JointEnd& b_;
  JointRows& rows_;
  int count_ = 0;
};

template <bool kMoving>
int write_rows(const JointRecord& joint, const JointEnd& a, const JointEnd& b, JointRows& rows) {
  const JointDef& def = joint.def;
  const Anchors<kMoving> anchors(joint, a, b);
  Rows<kMoving> out(def, joint.stalled, a, b, rows);
  switch (def.kind) {
    case JointKind::Revolute:
      out.hold(anchors.along({1, 0}), 0);
      out.hold(anchors.along({0, 1}), 0);
      if (out.any()) out.all(anchors.angle(joint.reference_angle), 0);
      break;
    case JointKind::Distance:
      if (out.any())
        out.all(anchors.distance(), joint.length);
      else
        out.hold(anchors.distance(), joint.length);
      break;
    case JointKind::Rope: {
      // The slack falls as the distance grows.
      JointDef limit;
      limit.upper = joint.length;
      Rows<kMoving> rope(limit, false, a, b, rows);
      rope.limits(anchors.distance());
      return rope.count();
    }
    case JointKind::Prismatic: {
      const Vec2 axis = rotate(a.q, joint.local_axis);
      out.hold(anchors.along_axis(perp(axis)), 0);
      out.hold(anchors.angle(joint.reference_angle), 0);
      out.all(anchors.along_axis(axis), 0);
      break;
    }
    case JointKind::Weld:
      out.hold(anchors.along({1, 0}), 0);
      out.hold(anchors.along({0, 1}), 0);
      out.hold(anchors.angle(joint.reference_angle), 0);
      break;
    case JointKind::Wheel: {
      const Vec2 axis = rotate(a.q, joint.local_axis);
      out.hold(anchors.along_axis(perp(axis)), 0);
      out.spring(anchors.along_axis(axis), 0);
      out.motor(anchors.angle(joint.reference_angle));
      out.limits(anchors.along_axis(axis));
      break;
    }
    case JointKind::Pulley:
      out.hold(anchors.pulley(def), joint.length);
      break;
    case JointKind::Gear:
      out.hold(anchors.gear(def.ratio), joint.length);
      break;
    case JointKind::Rack:
      out.hold(anchors.rack(joint.local_axis, def.ratio), joint.length);
      break;
    case JointKind::Motor:
      out.motor(anchors.angle(joint.reference_angle));
      break;
    case JointKind::Spring:
      // A spring without length is the same in every direction: two rows, no singularity.
      if (joint.length > 0) {
        out.spring(anchors.distance(), joint.length);
      } else {
        out.spring(anchors.along({1, 0}), 0);
        out.spring(anchors.along({0, 1}), 0);
      }
      out.limits(anchors.distance());
      break;
  }
  return out.count();
}

}  // namespace

int joint_rows(const JointRecord& joint, const JointEnd& a, const JointEnd& b, JointRows& rows) {
  return write_rows<true>(joint, a, b, rows);
}

int joint_geometry(const JointRecord& joint, const JointEnd& a, const JointEnd& b, JointRows& rows) {
  return write_rows<false>(joint, a, b, rows);
}

int held_rows(const JointDef& def) {
  if (def.stiffness > 0 || def.damping > 0 || def.motor_speed || def.lower || def.upper) return -1;
  switch (def.kind) {
    case JointKind::Weld:
      return 3;
    case JointKind::Revolute:
    case JointKind::Prismatic:
      return 2;
    case JointKind::Distance:
    case JointKind::Wheel:
    case JointKind::Pulley:
    case JointKind::Gear:
    case JointKind::Rack:
      return 1;
    case JointKind::Rope:
    case JointKind::Motor:
    case JointKind::Spring:
      break;
  }
  return -1;
}

JointCoordinate joint_coordinate(const JointRecord& joint, const JointEnd& a, const JointEnd& b) {
  const Anchors<true> anchors(joint, a, b);
  const auto result = [&](const Coordinate& c, double from) {
    return JointCoordinate{c.value - from, rate_of(c, a, b)};
  };
  switch (joint.def.kind) {
    case JointKind::Distance:
    case JointKind::Rope:
    case JointKind::Spring:
      return result(anchors.distance(), 0);
    case JointKind::Prismatic:
    case JointKind::Wheel:
      return result(anchors.along_axis(rotate(a.q, joint.local_axis)), 0);
    case JointKind::Pulley:
      return result(anchors.pulley(joint.def), joint.length);
    case JointKind::Gear:
      return result(anchors.gear(joint.def.ratio), joint.length);
    case JointKind::Rack:
      return result(anchors.rack(joint.local_axis, joint.def.ratio), joint.length);
    default:
      return result(anchors.angle(joint.reference_angle), 0);
  }
}

JointReaction row_reaction(const JointRecord& joint, const JointEnd& b, const JointRow& row) {
  const Vec2 force{row.Jb[0], row.Jb[1]};
  return {force, row.Jb[2] - cross(rotate(b.q, joint.local_b), force)};
}

}  // namespace skerry
