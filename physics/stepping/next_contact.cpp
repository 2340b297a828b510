// SPDX-License-Identifier: MIT
#include "physics/stepping/next_contact.h"

#include <algorithm>

#include "physics/stepping/chain_side.h"
#include "physics/stepping/flush_faces.h"
#include "physics/stepping/touching.h"

namespace skerry {
namespace {

// Hops shorter than 1e-12 of the piece are none.
constexpr int kHalvings = 40;
// Most looks within a piece for thin bodies, for one whose middle is past a segment at the end of it, and
// those for when that passes.
constexpr int kMostLooksOfThin = 256, kMostLooks = 64;
constexpr double kLeastLooks = 4, kLooksARadian = 4;
// Of the stretch in which it passes.
constexpr int kPassingHalvings = 20;
// Touch tolerances to within which a landing is found.
constexpr double kLanded = 1e-3;
// Share of a time that is none.
constexpr double kAtOnce = 1e-12;

/// Smallest separation among the points whose features do not rest, at time `t`; the margin if there is none.
class FreePoints {
 public:
  FreePoints(const WorldState& state, const Contact& contact, const Motion& a, const Motion& b,
             std::uint8_t resting, FreeSegments beside)
      : contact_(contact),
        shape_a_(state.shapes[contact.shape_a].shape),
        shape_b_(state.shapes[contact.shape_b].shape),
        a_(a),
        b_(b),
        margin_(state.config.contact_margin),
        beside_(beside) {
    for (int i = 0; i < contact.manifold.count; ++i) {
      if ((resting >> i & 1) != 0) resting_features_[count_++] = contact.manifold.points[i].feature;
    }
  }

  double separation(double t) const {
    const Manifold manifold = manifold_of(contact_.child, t);
    double smallest = kInfinity;
    for (int i = 0; i < manifold.count; ++i) {
      const auto end = resting_features_.begin() + count_;
      if (std::find(resting_features_.begin(), end, manifold.points[i].feature) != end) continue;
      smallest = std::min(smallest, manifold.points[i].separation);
    }
    if (smallest < kInfinity) return smallest;
    smallest = margin_;
    for (const int segment : {beside_.previous, beside_.next}) {
      const Manifold other = segment >= 0 ? manifold_of(segment, t) : Manifold{};
      for (int i = 0; i < other.count; ++i) smallest = std::min(smallest, other.points[i].separation);
    }
    return smallest;
  }

 private:
  Manifold manifold_of(int child, double t) const {
    return contact_manifold(child, shape_a_, a_.at(t), shape_b_, b_.at(t), margin_, nullptr, nullptr);
  }

  const Contact& contact_;
  const Shape& shape_a_;
  const Shape& shape_b_;
  const Motion& a_;
  const Motion& b_;
  double margin_;
  FreeSegments beside_;
  std::array<std::uint32_t, 2> resting_features_{};
  int count_ = 0;
};

/// Segments have one side: a body whose middle is past one has no points there any more, however deep it is.
/// This is how high above the line of the contact's segment the middle of the other shape is.
class MiddleAboveSegment {
 public:
  MiddleAboveSegment(const WorldState& state, const Contact& contact, const Motion& a, const Motion& b)
      : side_(chain_side(state, contact)), chain_(side_.of_a ? a : b), other_(side_.of_a ? b : a) {
    const auto segment = static_cast<std::size_t>(contact.child);
    start_ = side_.chain.vertices[segment];
    normal_ = side_.chain.normals[segment];
  }

  double height(double t) const {
    const Transform chain = chain_.at(t);
    return dot(rotate(chain.q, normal_), to_world(other_.at(t), side_.middle) - to_world(chain, start_));
  }
  double thickness() const { return half_width(side_.other); }

  /// A time before `h` just before which the middle passes the line; `h` if it does not.
  double last_in_front(double h) const {
    if (!(height(0) > 0)) return h;
    const auto turn = [h](const Motion& m) { return h * (std::abs(m.omega) + 0.5 * h * std::abs(m.alpha)); };
    const int looks = static_cast<int>(
        std::min(kLeastLooks + kLooksARadian * (turn(chain_) + turn(other_)), 1.0 * kMostLooks));
    for (int i = 1; i <= looks; ++i) {
      double low = h * (i - 1) / looks, high = h * i / looks;
      if (height(high) > 0) continue;
      for (int k = 0; k < kPassingHalvings; ++k) {
        const double t = 0.5 * (low + high);
        (height(t) > 0 ? low : high) = t;
      }
      return low;
    }
    return h;
  }

 private:
  ChainSide side_;
  const Motion &chain_, &other_;
  Vec2 start_, normal_;
};

int looks_at(double way, double thickness, int most) {
  return way > 0 ? static_cast<int>(std::clamp(4 * way / thickness, 1.0, 1.0 * most)) : 1;
}

/// Looks while less than a quarter of a body goes past the other one, as far as that can be afforded: what
/// turns down about a point that rests is through something thin in no time. With a segment in any case just
/// before the middle of the body passes it.
/// @return a time at which a free point is deeper than `ignored`; `h` if there is none
double first_deep_look(const WorldState& state, const Contact& contact, const FreePoints& free,
                       const Motion& a, const Motion& b, double h, double ignored) {
  const Shape &shape_a = state.shapes[contact.shape_a].shape, &shape_b = state.shapes[contact.shape_b].shape;
  const auto turn_of = [h](const Motion& motion) {
    return h * (std::abs(motion.omega) + 0.5 * h * std::abs(motion.alpha));
  };
  const auto way_of = [&](const Motion& motion, std::uint32_t body) {
    const double turn = turn_of(motion);
    return h * length(motion.v + (0.5 * h) * motion.a) + (turn > 0 ? turn * state.radius[body] : 0);
  };
  const double way = way_of(a, contact.body_a) + way_of(b, contact.body_b);
  const auto is_deep = [&](double t) { return free.separation(t) < -ignored; };
  if (!is_on_chain(state, contact)) {
    // What goes far into something thick is in it at the end, but for what turns out of it again.
    const bool endless = shape_a.kind == ShapeKind::HalfPlane || shape_b.kind == ShapeKind::HalfPlane;
    const auto by_turn =
        static_cast<int>(std::min(kLooksARadian * (turn_of(a) + turn_of(b)), 1.0 * kMostLooks));
    const int by_way =
        endless ? 1 : looks_at(way, half_width(shape_a) + half_width(shape_b), kMostLooksOfThin);
    const int looks = std::max(by_turn, by_way);
    for (int i = 1; i < looks; ++i)
      if (is_deep(h * i / looks)) return h * i / looks;
    return h;
  }
  const MiddleAboveSegment middle(state, contact, a, b);
  const int looks = looks_at(way, middle.thickness(), kMostLooks);
  const double last = middle.last_in_front(h);
  for (int i = 1; i < looks && h * i / looks < last; ++i)
    if (is_deep(h * i / looks)) return h * i / looks;
  return last < h && is_deep(last) ? last : h;
}

}  // namespace

NextContact next_contact_time(const WorldState& state, std::uint32_t index, const Motion& a, const Motion& b,
                              std::uint8_t resting, double h, FreeSegments beside, const SmallGaps& gaps) {
  const Contact& contact = state.contacts[index];
  const double touch = touch_tolerance(state, a.p0), left = gaps.hop * touch;
  if (resting == 0) {
    const ImpactTime impact = landing_time(state, contact, a, b, h);
    // A segment of a chain that touches without a point has left it to the one beside it.
    if (contact.manifold.count == 0 && is_on_chain(state, contact) && impact.t <= kAtOnce * h) return {h};
    if (!impact.hit) return {h};
    const bool stays =
        touches(state, contact) && FreePoints(state, contact, a, b, 0, {}).separation(0.5 * impact.t) <= left;
    return stays ? NextContact{h, true} : NextContact{impact.t};
  }

  if (rests_wholly(state, contact, resting)) return {h};

  // One point rests and another may come down (a box that rocks onto its face): the root of that point's
  // separation. A point that is hardly deeper than that at the end is left to the projection; it needs no
  // event of its own.
  const double ignored = gaps.sunk * touch;
  const FreePoints free(state, contact, a, b, resting, beside);
  const double deep = first_deep_look(state, contact, free, a, b, h, ignored);
  if (deep == h && free.separation(h) > -ignored) return {h};
  h = deep;
  double low = 0;
  double high = h;
  if (free.separation(0) <= left) {
    // It touches now and is about to hop: the flight begins somewhere in front of its landing.
    double open = h;
    for (int i = 0; i < kHalvings && free.separation(open) <= left; ++i) open *= 0.5;
    if (free.separation(open) <= left) return {h, true};
    low = open;
    high = std::min(h, 2 * open);
  }
  // Bisection to 1e-3 of the piece, then the false position with halving [Dowell & Jarratt 1971] to rounding.
  for (int i = 0; i < 10; ++i) {
    const double middle = 0.5 * (low + high);
    (free.separation(middle) > 0 ? low : high) = middle;
  }
  double f_low = free.separation(low);
  double f_high = free.separation(high);
  for (int i = 0; i < 60 && high - low > 1e-15 * h; ++i) {
    const double t = std::clamp((low * f_high - high * f_low) / (f_high - f_low), low, high);
    const double f = free.separation(t);
    if (std::abs(f) < kLanded * touch) return {std::max(t, 1e-12 * h)};
    if (f > 0) {
      low = t;
      f_low = f;
      f_high *= 0.5;
    } else {
      high = t;
      f_high = f;
      f_low *= 0.5;
    }
  }
  return {high};
}

}  // namespace skerry
