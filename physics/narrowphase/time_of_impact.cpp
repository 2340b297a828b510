// SPDX-License-Identifier: MIT
#include "physics/narrowphase/time_of_impact.h"

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <tuple>

#include "physics/narrowphase/chain.h"
#include "physics/narrowphase/chain_segment.h"
#include "physics/narrowphase/chain_tree.h"
#include "physics/narrowphase/hull.h"
#include "physics/narrowphase/lanes.h"
#include "physics/root.h"
#include "physics/text.h"

namespace skerry {
namespace {

using narrow::Hull;
using narrow::NormalFrom;
using narrow::Segment;

constexpr int kMaxIterations = 1000;
// Guesses at the impact, each of which may cost a look in vain, and Newton's steps in each.
constexpr int kMaxGuesses = 3;
constexpr int kMaxNewton = 8;
// Gaps below this, relative to the coordinates, are touching: a few roundings of the distance.
constexpr double kTouchingNoise = 2.0e-15;
// Angle [rad] that bodies may turn by in a step that follows their turning.
constexpr double kShortTurn = 0.1;
// Where touching corners neither part nor approach, time goes on by what cannot sink them deeper than this,
// relative to the coordinates.
constexpr double kTouchingSlip = 1.0e-12;

/// A moving core.
struct Mover {
  Hull hull;
  Motion motion;
  double reach = 0;  ///< largest distance of a corner of the core from the body's origin [m]
  bool turns = false;
  double top_omega = 0;  ///< largest |angular velocity| in the step [rad/s]

  Mover(const Hull& core, const Motion& m, double t_max) : hull(core), motion(m) {
    double square = 0;
    for (int i = 0; i < hull.count; ++i) square = std::max(square, length_squared(hull.v[i]));
    reach = std::sqrt(square);
    turns = (m.omega != 0 || m.alpha != 0) && (reach > 0 || core.kind == ShapeKind::HalfPlane);
    if (turns) top_omega = std::max(std::abs(m.omega), std::abs(m.omega + m.alpha * t_max));
  }
  /// Bound on a corner's acceleration relative to the body's origin [m/s^2].
  double turning_bound() const {
    return turns ? (top_omega * top_omega + std::abs(motion.alpha)) * reach : 0;
  }
  double omega_at(double t) const { return turns ? motion.omega + t * motion.alpha : 0; }
  Rot rotation_at(double t) const {
    return Rot::from_angle(turns ? motion.angle0 + t * (motion.omega + 0.5 * t * motion.alpha)
                                 : motion.angle0);
  }
};

/// Height of one point over time is at least value + rate s + curvature s^2 / 2.
struct Line {
  double value, rate;
};

/// First s in (0, longest] with
///   p(s) = value + rate s + curvature s^2 / 2 - jerk s^3 / 6 = 0,   value >= 0, jerk >= 0,
/// or a little less, never more; `longest` if there is none. A zero at the start that rises from there does
/// not count.
double safe_root(double value, double rate, double curvature, double jerk, double longest) {
  const auto p = [&](double s) { return value + s * (rate + s * (0.5 * curvature - (jerk / 6) * s)); };
  // p bends up until `low` and down from there.
  double low = curvature > 0 ? std::min(curvature / jerk, longest) : 0;
  if (rate < 0 && low > 0) {
    // It falls into a dip, or as far as it bends up. Newton's steps to a zero before that stay in front of
    // it.
    const double square = curvature * curvature + 2 * jerk * rate;
    const double dip = square > 0 ? std::min(-2 * rate / (curvature + std::sqrt(square)), low) : low;
    double s = 0, height = value;
    for (int round = 0; round < kMaxNewton && !(p(dip) > 0); ++round) {
      const double slope = rate + s * (curvature - 0.5 * jerk * s);
      if (!(height > 0 && slope < 0)) return s;
      s = std::min(s - height / slope, dip);
      height = p(s);
    }
    if (!(p(dip) > 0)) return s;
  }
  if (p(longest) > 0) return longest;
  if (!(low > 0)) {
    // Up to a zero of the parabola above, p is above another one.
    const double high = std::min(first_root(value, rate, curvature), longest);
    return std::min(first_root(value, rate, curvature - (jerk / 3) * high), longest);
  }
  // Below what bends down a chord meets zero too early, a tangent too late. Where each of the other terms is
  // at most a third of the last one it is below zero, and a tangent from there is near it.
  double high = std::min(std::max({std::cbrt(18 * value / jerk), std::sqrt(18 * std::max(rate, 0.0) / jerk),
                                   9 * curvature / jerk}),
                         longest);
  for (int round = 0; round < kMaxNewton && p(low) > 0; ++round) {
    const double slope = rate + high * (curvature - 0.5 * jerk * high);
    if (slope < 0) high = std::max(high - p(high) / slope, low);
    const double at_low = p(low), at_high = p(high);
    const double s = at_high < 0 ? low + (high - low) * (at_low / (at_low - at_high)) : low;
    if (!(s - low > 1e-3 * low)) break;
    low = s;
  }
  return low;
}

/// Room for the lines of all corners, left as it is.
struct Lines {
  Line line[narrow::kMaxCorners];
};

/// Heights of the corners over the lowest one along `n` (in the core's frame), and their rates when the core
/// turns with `omega` while the direction stays.
[[gnu::always_inline]] inline void fill_lines(const Hull& hull, Vec2 n, double omega, Line* lines) {
  using narrow::Two;
  // Value and rate side by side.
  const Vec2 sideways = omega * perp(n);
  const Two x_row = Two::of(n.x, -sideways.x), y_row = Two::of(n.y, -sideways.y);
  Two low = Two::both(kInfinity);
  for (int i = 0; i < hull.count; ++i) {
    const Two line = x_row * Two::both(hull.v[i].x) + y_row * Two::both(hull.v[i].y);
    line.store(&lines[i].value);
    low = lesser(line, low);
  }
  const Two lowest = Two::of(low.low(), 0);
  for (int i = 0; i < hull.count; ++i) (Two::load(&lines[i].value) - lowest).store(&lines[i].value);
}

/// One pair in flight, ordered as `meet` wants it.
class Flight {
 public:
  Flight(const Hull& a, const Motion& motion_a, const Hull& b, const Motion& motion_b, double t_max,
         double target, const Segment* segment = nullptr)
      : segment_(segment),
        a_(a, motion_a, t_max),
        b_(b, motion_b, t_max),
        t_max_(t_max),
        target_(target),
        offset_(motion_b.p0 - motion_a.p0),
        velocity_(motion_b.v - motion_a.v),
        acceleration_(motion_b.a - motion_a.a),
        bounded_(a.kind != ShapeKind::HalfPlane),
        scale_of_shapes_(a_.reach + b_.reach + a.radius + b.radius + std::abs(target) +
                         (bounded_ ? 0.0 : narrow::magnitude(a.v[0]))),
        sweep_(a_.reach + a.radius + b_.reach + b.radius + target) {}

  ImpactTime run();

 private:
  void look(double t);
  bool approaches() const;
  double safe_step(double gap, double longest, double on_fixed_axis) const;
  double step_of_touching(double safe, double longest) const;
  double step_of_discs() const;
  double step_on_fixed_axis(double gap, double longest, double direction = 1) const;
  double root_of_features(double t) const;
  double step_on_turning_axis(double gap, double span) const;
  double jump_to_discs_contact() const;
  bool take_own_contact();
  double step_past_neighbours_contact();

  const Segment* segment_;  // a is this segment of a chain
  Mover a_, b_;
  double t_max_, target_;
  Vec2 offset_, velocity_, acceleration_;  // of b relative to a at t = 0
  bool bounded_;                           // a has a bounding disc
  double scale_of_shapes_;                 // magnitude of their coordinates [m]
  double sweep_;                           // distance of the origins below which the shapes can touch [m]

  // At the present time:
  double t_ = 0;
  Rot qa_, qb_;
  Vec2 d_, v_;  // of b's origin relative to a's
  Manifold m_;  // world orientation, relative to a's origin
  NormalFrom from_ = NormalFrom::First;
  Vec2 n_;
  double gap_ = 0, scale_ = 0;
  int corner_a_ = -1, corner_b_ = -1;  // of the features that are closest; -1: not known
};

SKERRY_TWICE void Flight::look(double t) {
  t_ = t;
  qa_ = a_.rotation_at(t);
  qb_ = b_.rotation_at(t);
  const Transform relative{inverse_rotate(qa_, d_), narrow::relative_rotation(qa_, qb_)};
  scale_ = narrow::magnitude(d_) + scale_of_shapes_;
  m_.count = 0;
  narrow::Output out{m_, {{}, qa_}, false, {}};
  if (a_.hull.count > 1 && b_.hull.count > 1) {
    // Contact points are needed only where they touch.
    narrow::Placed placed;
    const narrow::Axis axis =
        narrow::find_axis(a_.hull, b_.hull, relative, kInfinity, placed, nullptr, nullptr);
    const narrow::Closest c = narrow::closest(a_.hull, b_.hull, placed, axis);
    gap_ = c.distance - a_.hull.radius - b_.hull.radius - target_;
    n_ = rotate(qa_, c.normal);
    from_ = c.from;
    corner_a_ = c.corner_a;
    corner_b_ = c.corner_b;
    if (gap_ > kTouchingNoise * scale_) return;
    narrow::clip(a_.hull, b_.hull, placed, axis, 1e100, out);
  } else {
    narrow::meet(a_.hull, b_.hull, relative, 1e100, nullptr, nullptr, out);
  }
  from_ = out.from;
  n_ = m_.normal;
  gap_ = kInfinity;
  for (unsigned i = 0; i < static_cast<unsigned>(m_.count); ++i) {
    gap_ = std::min(gap_, m_.points[i].separation - target_);
  }
}

/// Do the touching points close, at first or else at second order?
bool Flight::approaches() const {
  const double wa = a_.omega_at(t_), wb = b_.omega_at(t_);
  const double alpha_a = a_.turns ? a_.motion.alpha : 0, alpha_b = b_.turns ? b_.motion.alpha : 0;
  for (unsigned i = 0; i < static_cast<unsigned>(m_.count); ++i) {
    if (m_.points[i].separation - target_ > gap_ + kTouchingNoise * scale_) continue;
    const Vec2 ra = m_.points[i].position, rb = ra - d_;
    const Vec2 relative = v_ + wb * perp(rb) - wa * perp(ra);
    const double rate = dot(n_, relative);
    const double speed_noise =
        1e-14 * (narrow::magnitude(v_) + std::abs(wa) * length(ra) + std::abs(wb) * length(rb));
    if (rate < -speed_noise) return true;
    if (rate > speed_noise) continue;
    // The normal turns with the body whose edge it is.
    const double turn = from_ == NormalFrom::First ? wa : from_ == NormalFrom::Second ? wb : 0;
    const Vec2 push =
        acceleration_ + alpha_b * perp(rb) - (wb * wb) * rb - alpha_a * perp(ra) + (wa * wa) * ra;
    const double curvature = dot(n_, push) + 2 * turn * dot(perp(n_), relative);
    const double push_noise =
        1e-13 * (narrow::magnitude(acceleration_) + wa * wa * length(ra) + wb * wb * length(rb));
    if (curvature < -push_noise) return true;
  }
  return false;
}

/// Step until the bounding discs could touch, along the line of the origins.
double Flight::step_of_discs() const {
  const double distance = length(d_);
  if (!(distance > sweep_)) return 0;
  const Vec2 along = d_ / distance;
  return first_root(distance - sweep_, dot(along, v_), dot(along, acceleration_));
}

/// Step along the present normal, kept fixed in the world. @param direction  -1: back in time
SKERRY_TWICE double Flight::step_on_fixed_axis(double gap, double longest, double direction) const {
  if (!a_.turns && !b_.turns) return first_root(gap, direction * dot(n_, v_), dot(n_, acceleration_));
  if (!bounded_ && a_.turns) return 0;
  const double curvature = std::min(0.0, dot(n_, acceleration_)) - a_.turning_bound() - b_.turning_bound();
  // Heights of b's corners over its lowest, and of a's highest over its others, with their rates.
  Lines up_a, up_b;
  fill_lines(b_.hull, inverse_rotate(qb_, n_), direction * b_.omega_at(t_), up_b.line);
  int count_a = 1;
  up_a.line[0] = {0, 0};
  if (a_.turns) {
    count_a = a_.hull.count;
    fill_lines(a_.hull, inverse_rotate(qa_, -n_), direction * a_.omega_at(t_), up_a.line);
  }
  const Line base{gap, direction * dot(n_, v_)};
  double s = longest;
  // Starting from the end, the lines that are lowest there give an earlier root, until they are themselves
  // the lowest: the minimum is concave, so nothing is skipped. The lowest sum is the sum of the lowest.
  const auto lowest_at = [&](const Line* lines, int count, double time) {
    Line best = lines[0];
    double low = kInfinity;
    for (int i = 0; i < count; ++i) {
      const double value = lines[i].value + lines[i].rate * time;
      if (value < low) {
        low = value;
        best = lines[i];
      }
    }
    return best;
  };
  for (int round = 0; round < 2 * narrow::kMaxCorners; ++round) {
    const Line lb = lowest_at(up_b.line, b_.hull.count, s), la = lowest_at(up_a.line, count_a, s);
    const double value = base.value + lb.value + la.value, rate = base.rate + lb.rate + la.rate;
    if (value + rate * s + 0.5 * curvature * s * s > 0) return s;
    const double root = first_root(value, rate, curvature);
    if (!(root < s)) return s;
    s = root;
  }
  return s;
}

/// Step along the present normal as seen from the body whose edge it belongs to, with which it turns; only
/// the other body's corners count. In that body's frame, for a corner at d + r and with J the quarter turn,
///   x'  = v - w J d + (w_other - w) J r
///   x'' = a - alpha J d - 2 w J v - w^2 d + (alpha_other - alpha) J r - (w_other - w)^2 r
/// are taken as they are, so that bodies that turn together, and corners that part at second order only, do
/// not stop the step; x''' is bounded over `span`.
SKERRY_TWICE double Flight::step_on_turning_axis(double gap, double span) const {
  const bool first = from_ != NormalFrom::Second;
  const Mover& owner = first ? a_ : b_;
  const Mover& other = first ? b_ : a_;
  const Vec2 d = first ? d_ : -d_, v = first ? v_ : -v_, n = first ? n_ : -n_;
  const Vec2 push = first ? acceleration_ : -acceleration_;
  const Rot q = first ? qb_ : qa_;
  const double w = owner.omega_at(t_), alpha = owner.turns ? owner.motion.alpha : 0;
  const double dw = other.omega_at(t_) - w, dalpha = (other.turns ? other.motion.alpha : 0) - alpha;
  const double base_rate = dot(n, v - w * perp(d));
  const double base_curvature = dot(n, push - alpha * perp(d) - 2 * w * perp(v) - (w * w) * d);

  const double a = length(push), top_v = length(v) + a * span, top_d = length(d) + top_v * span;
  const double top_w = owner.top_omega, top_dw = std::max(std::abs(dw), std::abs(dw + span * dalpha));
  const double jerk = 3 * (std::abs(alpha) + top_w * top_w) * top_v + 3 * top_w * a +
                      top_w * (3 * std::abs(alpha) + top_w * top_w) * top_d +
                      top_dw * (3 * std::abs(dalpha) + top_dw * top_dw) * other.reach;

  const Vec2 along = inverse_rotate(q, n), sideways = -perp(along);
  double lowest = kInfinity;
  for (int i = 0; i < other.hull.count; ++i) lowest = std::min(lowest, dot(along, other.hull.v[i]));
  double s = span;
  for (int i = 0; i < other.hull.count; ++i) {
    const double height = dot(along, other.hull.v[i]), side = dot(sideways, other.hull.v[i]);
    s = safe_root(gap + (height - lowest), base_rate + dw * side,
                  base_curvature + dalpha * side - dw * dw * height, jerk, s);
  }
  return s;
}

/// Step that is safe whatever the features do for what may come nearer by `gap`, given that on the fixed
/// axis.
double Flight::safe_step(double gap, double longest, double on_fixed_axis) const {
  const double s = on_fixed_axis;
  if (s >= longest) return s;
  // The bounds grow with the span that they are for, so the span is one that is worth having.
  const double turn = std::max(a_.top_omega, b_.top_omega);
  const double span = s > 0 && turn > 0 ? std::min(std::max(8 * s, kShortTurn / turn), longest) : longest;
  return std::max(s, step_on_turning_axis(gap, span));
}

/// Step in which shapes that touch, and neither part nor approach but for rounding, cannot sink too deep.
/// @param safe  a step in which they do not sink at all, which rounding may leave short
double Flight::step_of_touching(double safe, double longest) const {
  const double slip = kTouchingSlip * scale_;
  const double bound = narrow::magnitude(acceleration_) + a_.turning_bound() + b_.turning_bound();
  const double least = bound > 0 ? std::sqrt(2 * slip / bound) : 0;
  if (safe > least) return safe;
  // What slides along a face is as fast as it likes.
  return std::max(least, safe_step(slip, longest, step_on_fixed_axis(slip, longest)));
}

/// When the features that are closest now would touch, if they stayed so: Newton's method on the distance of
/// a corner from an edge or from a corner. Infinite if it finds nothing.
SKERRY_TWICE double Flight::root_of_features(double t) const {
  if (corner_a_ < 0) return kInfinity;
  const Vec2 pa = a_.hull.v[corner_a_], pb = b_.hull.v[corner_b_];
  const double radii = a_.hull.radius + b_.hull.radius + target_;
  double gap = gap_, tau = t;
  Rot qa = qa_, qb = qb_;
  Vec2 d = d_, v = v_;
  for (int round = 0; round < kMaxNewton; ++round) {
    const double wa = a_.omega_at(tau), wb = b_.omega_at(tau);
    const Vec2 ra = rotate(qa, pa), rb = rotate(qb, pb), between = (d + rb) - ra;
    const Vec2 closing = v + wb * perp(rb) - wa * perp(ra);
    double rate;
    if (from_ == NormalFrom::Corners) {
      const double distance = length(between);
      if (!(distance > 0)) return kInfinity;
      if (round > 0) gap = distance - radii;
      rate = dot(between, closing) / distance;
    } else {
      const bool first = from_ == NormalFrom::First;
      const Vec2 n = first ? rotate(qa, a_.hull.n[corner_a_]) : -rotate(qb, b_.hull.n[corner_b_]);
      if (round > 0) gap = dot(n, between) - radii;
      rate = dot(n, closing) + (first ? wa : wb) * dot(perp(n), between);
    }
    if (round > 0 && std::abs(gap) <= 0.25 * kTouchingNoise * scale_) return tau;
    const double next = tau - gap / rate;
    if (!(rate < 0 && next >= t && next <= t_max_)) return kInfinity;
    if (next == tau) return tau;
    tau = next;
    qa = a_.rotation_at(tau);
    qb = b_.rotation_at(tau);
    d = offset_ + tau * (velocity_ + (0.5 * tau) * acceleration_);
    v = velocity_ + tau * acceleration_;
  }
  return tau;
}

/// Time at which the bounding discs first touch when they fly straight: the smaller root of
/// |d + v t|^2 = sweep^2, written so that nothing cancels. Zero if they overlap, infinite if they miss.
double Flight::jump_to_discs_contact() const {
  const double distance = length(d_);
  if (!(distance > sweep_)) return 0;
  const double approach = -dot(d_, v_);
  if (approach <= 0 || sweep_ < 0) return kInfinity;
  const double speed = length(v_);
  const double miss = std::abs(cross(d_, v_)) / speed;
  if (miss > sweep_) return kInfinity;
  const double square = (sweep_ - miss) * (sweep_ + miss);  // half chord
  return (distance - sweep_) * (distance + sweep_) / (approach + speed * std::sqrt(square));
}

/// Takes the touching points that the segment reports, in place of all that touch. False if there are none:
/// they are its neighbours'.
bool Flight::take_own_contact() {
  const Transform relative{inverse_rotate(qa_, d_), narrow::relative_rotation(qa_, qb_)};
  const double margin = target_ + std::max(gap_, 0.0) + 10 * kTouchingNoise * scale_;
  const narrow::SegmentContact own = narrow::meet_segment(*segment_, b_.hull, relative, margin, nullptr);
  if (own.m.count == 0) return false;
  m_ = own.m;
  from_ = own.from;
  n_ = m_.normal = rotate(qa_, own.m.normal);
  gap_ = kInfinity;
  for (unsigned i = 0; i < static_cast<unsigned>(m_.count); ++i) {
    m_.points[i].position = rotate(qa_, m_.points[i].position);
    gap_ = std::min(gap_, m_.points[i].separation - target_);
  }
  return true;
}

/// Step until a corner of the other shape may come down on the segment, or from beside over it; infinite if
/// none can.
double Flight::step_past_neighbours_contact() {
  n_ = rotate(qa_, segment_->n[0]);
  const Vec2 along = -perp(n_), n_local = inverse_rotate(qb_, n_), along_local = -perp(n_local);
  const Vec2 start = d_ - rotate(qa_, segment_->v[1]);
  const double omega = b_.omega_at(t_), radius = b_.hull.radius + target_;
  const double noise = 10 * kTouchingNoise * scale_;
  // The faster of the segment's ends comes up to meet it.
  const double wa = a_.omega_at(t_);
  const double lift =
      std::max(wa * cross(rotate(qa_, segment_->v[0]), n_), wa * cross(rotate(qa_, segment_->v[1]), n_));
  const double turning = a_.turning_bound() + b_.turning_bound();
  const double fall =
      a_.turns || b_.turns ? std::min(0.0, dot(n_, acceleration_)) - turning : dot(n_, acceleration_);
  double s = kInfinity;
  for (int i = 0; i < b_.hull.count; ++i) {
    const Vec2 corner = b_.hull.v[i];
    const double height = dot(n_, start) + dot(n_local, corner) - radius;
    const double x = dot(along, start) + dot(along_local, corner), side = std::max(-x, x - segment_->length);
    if (height < -noise) continue;
    if (height > noise || !(side > 0)) {
      const double rate = dot(n_, v_) + omega * cross(corner, n_local) - lift;
      s = std::min(s, first_root(std::max(height, 0.0), rate, fall));
    } else {
      // On the line beside the segment it is its neighbours' concern, until it comes over this one.
      const double leaving = dot(along, v_) + omega * cross(corner, along_local);
      const double curvature = -length(acceleration_) - turning - std::abs(wa) * length(v_);
      s = std::min(s, first_root(side, x < 0 ? -leaving : leaving, curvature));
    }
  }
  return std::max(s, 1e-9 * t_max_);
}

ImpactTime Flight::run() {
  ImpactTime result;
  result.t = t_max_;
  double t = 0;
  const bool straight = acceleration_ == Vec2{};
  const bool two_discs =
      a_.hull.kind == ShapeKind::Disc && b_.hull.kind == ShapeKind::Disc && !a_.turns && !b_.turns;
  const auto move_to = [&](double time) {
    t = time;
    d_ = offset_ + t * (velocity_ + (0.5 * t) * acceleration_);
    v_ = velocity_ + t * acceleration_;
  };
  // How far the bounding discs let the pair fly without a look at the shapes.
  move_to(0);
  if (bounded_ && straight) {
    const double first = jump_to_discs_contact();
    if (first > t_max_) return result;
    if (two_discs && a_.reach + b_.reach == 0 && first > 0) {
      result.hit = true;
      result.t = first;
      return result;
    }
    if (first > 0) move_to(first);
  }
  int guesses = kMaxGuesses;
  while (result.iterations < kMaxIterations) {
    if (bounded_ && !straight) {
      // Far apart the bounding discs are enough to look at.
      while (length(d_) > 1.5 * sweep_ && result.iterations < kMaxIterations) {
        ++result.iterations;
        const double s = step_of_discs();
        if (!(t + s < t_max_)) return result;
        move_to(t + s);
      }
    }
    ++result.iterations;
    look(t);
    const bool touching = gap_ <= kTouchingNoise * scale_;
    const bool ghost = touching && segment_ != nullptr && !take_own_contact();
    if (touching && !ghost && approaches()) {
      result.hit = true;
      result.t = t;
      return result;
    }
    double s = 0;
    if (ghost) {
      s = step_past_neighbours_contact();
    } else {
      const double gap = std::max(gap_, 0.0), longest = t_max_ - t;
      const double fixed = step_on_fixed_axis(gap, longest), clear = t + fixed;
      const bool turns = a_.turns || b_.turns;
      const double guess = turns && segment_ == nullptr && !touching && guesses > 0 && clear < t_max_
                               ? root_of_features(t)
                               : kInfinity;
      if (guess > clear && guess <= t_max_) {
        // A guess at the impact itself. It counts if it touches and nothing can have touched before: forth
        // from here until `clear`, and back from there, as far as the same bound reaches.
        --guesses;
        ++result.iterations;
        // What was seen here; contact points are kept only where shapes touch.
        const auto here = std::tuple(t_, qa_, qb_, d_, v_, from_, n_, gap_, scale_, corner_a_, corner_b_);
        move_to(guess);
        look(t);
        if (std::abs(gap_) <= kTouchingNoise * scale_ && approaches() &&
            guess - step_on_fixed_axis(0, guess, -1) < clear) {
          result.hit = true;
          result.t = guess;
          return result;
        }
        std::tie(t_, qa_, qb_, d_, v_, from_, n_, gap_, scale_, corner_a_, corner_b_) = here;
        t = t_;
      }
      s = safe_step(gap, longest, fixed);
      if (touching) s = std::max(s, step_of_touching(s, longest));
    }
    if (!(t + s < t_max_)) return result;
    if (!(t + s > t)) {
      // Closer than time can tell.
      result.hit = true;
      result.t = t;
      return result;
    }
    move_to(t + s);
  }
  result.hit = true;
  result.t = t;
  result.converged = false;
  return result;
}

bool is_finite(const Motion& m) {
  return skerry::is_finite(m.p0) && std::isfinite(m.angle0) && skerry::is_finite(m.v) &&
         std::isfinite(m.omega) && skerry::is_finite(m.a) && std::isfinite(m.alpha);
}

[[noreturn, gnu::cold]] void refuse_motion(const char* which, const Motion& m) {
  throw std::invalid_argument(std::string("time_of_impact: the ") + which +
                              " motion must be finite, got p0 " + to_text(m.p0) + ", angle0 " +
                              to_text(m.angle0) + ", v " + to_text(m.v) + ", omega " + to_text(m.omega) +
                              ", a " + to_text(m.a) + ", alpha " + to_text(m.alpha));
}

ImpactTime fly_at_segment(const Shape& chain, int index, const Motion& motion_chain, const Shape& other,
                          const Motion& motion_other, double t_max, double target) {
  if (narrow::rank_of(other.kind) == 2 || other.kind == ShapeKind::Chain) return {false, t_max, 0, true};
  const Segment segment(chain, index, {});
  return Flight(segment.hull(), motion_chain, narrow::hull_of(other), motion_other, t_max, target, &segment)
      .run();
}

/// A box of the chain's frame that `other` does not leave in its flight; everything if the chain turns.
Aabb swept_box(const Motion& motion_chain, const Shape& other, const Motion& motion, double t_max,
               double target) {
  const Aabb everything{{-kInfinity, -kInfinity}, {kInfinity, kInfinity}};
  if (motion_chain.omega != 0 || motion_chain.alpha != 0) return everything;
  const Rot q = Rot::from_angle(motion_chain.angle0);
  const Vec2 start = motion.p0 - motion_chain.p0, a = motion.a - motion_chain.a;
  const Vec2 end = start + t_max * ((motion.v - motion_chain.v) + (0.5 * t_max) * a);
  // A parabola leaves its chord by |a| t^2 / 8.
  const double size = bounding_radius(other) + std::abs(target) + 0.125 * t_max * t_max * length(a);
  const double scale = narrow::magnitude(start) + narrow::magnitude(end) + size;
  if (!(scale < 1e100)) return everything;
  const Vec2 p = inverse_rotate(q, start), r = inverse_rotate(q, end);
  return grown({{std::min(p.x, r.x), std::min(p.y, r.y)}, {std::max(p.x, r.x), std::max(p.y, r.y)}},
               size + 1e-12 * scale);
}

void require_usable(const Motion& motion_a, const Motion& motion_b, double t_max, double target) {
  std::array<char, 96> message{};
  if (!(t_max >= 0 && std::isfinite(t_max))) {
    std::snprintf(message.data(), message.size(), "time_of_impact: t_max must be finite and >= 0, got %g",
                  t_max);
    throw std::invalid_argument(message.data());
  }
  if (!std::isfinite(target)) {
    std::snprintf(message.data(), message.size(), "time_of_impact: target must be finite, got %g", target);
    throw std::invalid_argument(message.data());
  }
  if (!is_finite(motion_a)) refuse_motion("first", motion_a);
  if (!is_finite(motion_b)) refuse_motion("second", motion_b);
}

}  // namespace

ImpactTime time_of_impact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                          double t_max, double target) {
  require_usable(motion_a, motion_b, t_max, target);
  if (a.kind == ShapeKind::Chain || b.kind == ShapeKind::Chain) {
    const bool exchange = a.kind != ShapeKind::Chain;
    const Shape& chain = exchange ? b : a;
    ImpactTime first{false, t_max, 0, true};
    const Aabb swept = exchange ? swept_box(motion_b, a, motion_a, t_max, target)
                                : swept_box(motion_a, b, motion_b, t_max, target);
    const auto visit = [&](int i) {
      // Later segments need to be looked at only until the first hit.
      const ImpactTime impact = exchange ? fly_at_segment(b, i, motion_b, a, motion_a, first.t, target)
                                         : fly_at_segment(a, i, motion_a, b, motion_b, first.t, target);
      first.iterations += impact.iterations;
      if (!impact.hit || (first.hit && impact.t >= first.t)) return;
      first.hit = true;
      first.t = impact.t;
      first.converged = impact.converged;
    };
    narrow::visit_segments(
        chain, [&](const Aabb& box) { return overlap(box, swept); }, visit);
    return first;
  }
  const Hull hull_a = narrow::hull_of(a), hull_b = narrow::hull_of(b);
  const int rank_a = narrow::rank_of(a.kind), rank_b = narrow::rank_of(b.kind);
  if (rank_a == 2 && rank_b == 2) return {false, t_max, 0, true};
  if (rank_a < rank_b) return Flight(hull_b, motion_b, hull_a, motion_a, t_max, target).run();
  return Flight(hull_a, motion_a, hull_b, motion_b, t_max, target).run();
}

ImpactTime time_of_impact_chain_segment(const Shape& chain, int segment, const Motion& motion_chain,
                                        const Shape& other, const Motion& motion_other, double t_max,
                                        double target) {
  require_usable(motion_chain, motion_other, t_max, target);
  if (segment < 0 || segment >= chain_segment_count(chain)) {
    std::array<char, 96> message{};
    std::snprintf(message.data(), message.size(), "time_of_impact_chain_segment: segment %d of a chain of %d",
                  segment, chain_segment_count(chain));
    throw std::invalid_argument(message.data());
  }
  return fly_at_segment(chain, segment, motion_chain, other, motion_other, t_max, target);
}

}  // namespace skerry
