// SPDX-License-Identifier: MIT
//
// How far bodies can go within a step, and which pairs can meet therefore. Before the step every body has a
// way (that of its free flight), a bound on how far it strays from it (its allowance), and one on how far it
// goes at all (its reach). They hold until something strikes it; what the step finds out is looked at
// afterwards. Two bodies that go alike come no nearer to each other but for what they stray.
#include <algorithm>
#include <cmath>

#include "physics/contact.h"
#include "physics/stepping/travel.h"
#include "physics/world_step.h"

namespace skerry {
namespace {

// A body with so many times the radius of another one is compared with it in its own frame.
constexpr double kMuchLarger = 4;

// A round made again may leave overlaps so many times as deep to the next step: still less than both half
// widths.
constexpr double kLaterOverrun = 1.8;

// What strayed gets so many times the room that it took; from so many rounds on, more. Of 1052 bodies that
// came down between two slopes at 300 m/s each went elsewhere in each of 64 rounds.
constexpr double kMoreRoom = 1.25, kMuchMoreRoom = 2;
constexpr int kRoundsOfWays = 8;

// Up to this ratio of its radius and its smallest half width a body that turns does not reach through
// another.
constexpr double kCompact = 2;

/// Where something goes along a line in the step, as bounds on its displacement [m].
struct Range {
  double low = 0, high = 0;
};

/// v t + a t^2 / 2 for t in [0, h] lies between its control points as a Bezier curve.
Range range_of(double v, double a, double h) {
  const double middle = 0.5 * h * v, end = h * (v + 0.5 * h * a);
  return {std::min({0.0, middle, end}), std::max({0.0, middle, end})};
}

/// Least gap of two intervals while the second one moves against the first one. @param from  of its middle,
/// at the beginning
double least_gap(double from, double halves, const Range& moves) {
  return from > 0 ? from + moves.low - halves : -from - moves.high - halves;
}

/// A rectangle, and an upright box beside it, along the rectangle's two normals.
class SlantedGap {
 public:
  /// @return false if the shape is no rectangle
  bool find(const Shape& shape, const Transform& at, const Aabb& box) {
    const Shape::Rectangle& rectangle = shape.rectangle;
    known_ = rectangle.half.x > 0;
    if (!known_) return false;
    const Vec2 middle = 0.5 * (box.lower + box.upper), half = 0.5 * (box.upper - box.lower);
    const Vec2 d = middle - (at.p + rotate(at.q, rectangle.middle));
    for (const std::size_t k : {0, 1}) {
      const Vec2 n = normal_[k] = rotate(at.q, shape.normals[k]);
      from_[k] = dot(n, d);
      halves_[k] = (k == 0 ? rectangle.half.x : rectangle.half.y) + shape.radius + std::abs(n.x) * half.x +
                   std::abs(n.y) * half.y;
    }
    return true;
  }
  bool known() const { return known_; }
  double gap(std::size_t k) const { return std::abs(from_[k]) - halves_[k]; }
  /// The same while the box moves against the rectangle.
  double least_gap(std::size_t k, Vec2 v, Vec2 a, double h) const {
    return skerry::least_gap(from_[k], halves_[k], range_of(dot(normal_[k], v), dot(normal_[k], a), h));
  }

 private:
  bool known_ = false;
  Vec2 normal_[2];
  double from_[2], halves_[2];
};

/// Whether a body has a way. That of a body at rest would take it down, from which it strays as the others of
/// its pile do: so the bounds are the same whether its step is made or known.
bool goes(const WorldState& s, std::uint32_t i) {
  return s.bodies.type[i] != BodyType::Static;
}

/// How b moves against a while both go their ways.
struct RelativeWay {
  Vec2 v, a;
  double turn_a = 0, turn_b = 0;  ///< largest angles [rad]
};

RelativeWay relative_way(const WorldState& s, std::uint32_t a, std::uint32_t b, double h) {
  RelativeWay r;
  if (goes(s, a)) {
    const Way& way = s.way[a];
    r.v = -way.v;
    r.a = -way.a;
    r.turn_a = h * (std::abs(way.omega) + h * std::abs(way.alpha));
  }
  if (goes(s, b)) {
    const Way& way = s.way[b];
    r.v += way.v;
    r.a += way.a;
    r.turn_b = h * (std::abs(way.omega) + h * std::abs(way.alpha));
  }
  return r;
}

/// How far a turn moves what a body can meet, or any of its points. @param near  no farther from its centre
double swing(const WorldState& s, std::uint32_t body, double turn, double near) {
  return turn > 0 ? turn * std::min(s.radius[body], near) : 0;
}

/// By how much two bodies change their distance at most while they go their ways [m].
double flight_apart(const WorldState& s, std::uint32_t a, std::uint32_t b, double h) {
  const RelativeWay r = relative_way(s, a, b, h);
  return h * (length(r.v) + (r.a == Vec2{} ? 0 : h * length(r.a))) + swing(s, a, r.turn_a, kInfinity) +
         swing(s, b, r.turn_b, kInfinity);
}

}  // namespace

bool flies_freely(const WorldState& state, std::uint32_t body) {
  return state.bodies.type[body] == BodyType::Dynamic && !state.drag[body].any() && !state.field;
}

/// How far its joints will bring a body off free flight if they pull twice as hard as in the last step [m].
double Step::guess_of_joints(std::uint32_t body) const {
  Vec2 push;
  double turn = 0;
  for (const std::uint32_t slot : s_.joints_of[body]) {
    const JointRecord& joint = s_.joints[slot];
    const bool is_b = joint.def.b.index == body;
    const double sign = is_b ? 1 : -1;
    const Vec2 arm = rotate(s_.bodies.rotation[body], is_b ? joint.local_b : joint.local_a);
    push += sign * joint.impulse;
    turn += sign * (joint.angular_impulse + cross(arm, joint.impulse));
  }
  return 2 * h_ *
         (s_.bodies.inverse_mass[body] * length(push) +
          s_.bodies.inverse_inertia[body] * std::abs(turn) * s_.radius[body]);
}

/// How near the boxes of a pair are where the step begins, and come to each other while both bodies go their
/// ways. Where neither is fast, nothing has to be known of that.
PairLook Step::look_at(const Pair& pair) const {
  const ShapeRecord &low = s_.shapes[pair.low], &high = s_.shapes[pair.high];
  const std::uint32_t a = low.body.index, b = high.body.index;
  PairLook look;
  look.body_a = a;
  look.body_b = b;
  look.may_touch = may_touch(low, high);
  look.chain = low.shape->kind == ShapeKind::Chain || high.shape->kind == ShapeKind::Chain;
  if (s_.flight[a] != FlightKind::Fast && s_.flight[b] != FlightKind::Fast) return look;
  look.alike = fly_alike(a, b);
  const Aabb &box_a = s_.start_box[pair.low], &box_b = s_.start_box[pair.high];
  const Vec2 from = 0.5 * (box_b.lower + box_b.upper) - 0.5 * (box_a.lower + box_a.upper);
  // From side to side: the middle of a half-plane's box is known to a tenth of a millimetre only.
  const Vec2 above = box_b.lower - box_a.upper, below = box_a.lower - box_b.upper;
  look.gap = std::max({above.x, below.x, above.y, below.y});
  // How pairs that touch move does not matter.
  look.nearest = std::min(look.gap, 0.0);
  const bool in_frame =
      s_.radius[a] > kMuchLarger * s_.radius[b] || s_.radius[b] > kMuchLarger * s_.radius[a];
  if (!look.alike ||
      (!in_frame && !(look.gap > std::min(s_.config.touch_tolerance, s_.config.contact_margin))))
    return look;
  // A long box at a slant is not its upright box, and where it turns only what is near the other moves.
  const bool a_large = s_.radius[a] > s_.radius[b];
  const ShapeRecord& large = a_large ? low : high;
  const Aabb& box = a_large ? box_b : box_a;
  const BodyBackup& frame = s_.backup[large.body.index];
  SlantedGap slanted;
  if (in_frame && slanted.find(large.shape, {frame.position, frame.rotation}, box))
    look.gap = std::max({look.gap, slanted.gap(0), slanted.gap(1)});
  // What is too far away to be reached is so however the two move (`expect_blows`, `is_near`).
  const double margin = std::max(s_.config.touch_tolerance, s_.config.contact_margin);
  if (rounds_ == 0 && look.gap > margin + s_.reach[a] + s_.reach[b]) {
    look.nearest = look.gap;
    return look;
  }
  const RelativeWay r = relative_way(s_, a, b, h_);
  const Range x = range_of(r.v.x, r.a.x, h_), y = range_of(r.v.y, r.a.y, h_);
  look.nearest = std::max(from.x > 0 ? above.x + x.low : below.x - x.high,
                          from.y > 0 ? above.y + y.low : below.y - y.high);
  if (slanted.known()) {
    const double sign = a_large ? 1 : -1;
    const auto nearest = [&](std::size_t k) { return slanted.least_gap(k, sign * r.v, sign * r.a, h_); };
    look.nearest = std::max({look.nearest, nearest(0), nearest(1)});
  }
  const double turn = a_large ? r.turn_a : r.turn_b, own = a_large ? r.turn_b : r.turn_a;
  if (in_frame && turn > 0) {
    const double goes =
        std::max(std::abs(x.low), std::abs(x.high)) + std::max(std::abs(y.low), std::abs(y.high));
    const auto astray = [&](std::uint32_t i) { return std::max(2 * s_.reach[i], s_.strayed[i]); };
    const double own_swing = swing(s_, a_large ? b : a, own, kInfinity);
    const double around = own_swing + astray(a) + astray(b) + 2 * s_.config.contact_margin;
    const Vec2 middle = 0.5 * (box.lower + box.upper), half = 0.5 * (box.upper - box.lower);
    const double near = length(middle - frame.position) + length(half) + goes + around;
    look.nearest -= own_swing + swing(s_, large.body.index, turn, near);
  } else {
    look.nearest -= swing(s_, a, r.turn_a, kInfinity) + swing(s_, b, r.turn_b, kInfinity);
  }
  return look;
}

/// A fast body that something may strike, or that may strike something, can stray as far as a blow between
/// the two may take it; one in flow, as far as was guessed. The boxes of those that flew were made for flight
/// alone.
void Step::expect_blows() {
  std::vector<PairLook>& looks = s_.scratch.looks;
  looks.resize(s_.pairs.size());
  share(s_.pool.get(), looks.size(), kPairsAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      looks[k] = look_at(s_.pairs[k]);
      looks[k].may_strike = may_strike(s_.pairs[k], looks[k]);
    }
  });
  std::vector<std::uint32_t>& expecting = s_.scratch.left;
  expecting.clear();
  const auto expect = [&](std::uint32_t i, double blow) {
    if (!may_stray(i)) return;
    const double most = std::min(blow, 2 * s_.reach[i]);
    if (most <= s_.allowance[i]) return;
    s_.allowance[i] = most;
    if (s_.stray_guess[i] == 0) expecting.push_back(i);
  };
  for (const PairLook& look : looks) {
    if (!look.may_strike) continue;
    const std::uint32_t a = look.body_a, b = look.body_b;
    // What is heavy makes what is light twice as fast as it was against it.
    const double blow = look.alike ? 2 * flight_apart(s_, a, b, h_) + s_.config.contact_margin : kInfinity;
    expect(a, blow);
    expect(b, blow);
  }
  std::sort(expecting.begin(), expecting.end());
  expecting.erase(std::unique(expecting.begin(), expecting.end()), expecting.end());
}

/// Whether it is open how far a blow may take a body: others are not fast, or their guess stays.
bool Step::may_stray(std::uint32_t i) const {
  const double guess = s_.stray_guess[i];
  return s_.flight[i] == FlightKind::Fast && s_.bodies.type[i] == BodyType::Dynamic &&
         !(guess > 0 && guess < kInfinity);
}

/// Whether the two bodies may strike each other in this step, and it matters.
bool Step::may_strike(const Pair& pair, const PairLook& look) const {
  const std::uint32_t a = look.body_a, b = look.body_b;
  if (!may_stray(a) && !may_stray(b)) return false;
  const double farthest = look.alike ? 0 : s_.reach[a] + s_.reach[b];
  if (look.nearest > s_.config.touch_tolerance + farthest) return false;
  if (look.gap > s_.config.touch_tolerance + s_.reach[a] + s_.reach[b]) return false;
  return look.may_touch && !s_.shapes[pair.low].sensor && !s_.shapes[pair.high].sensor;
}

/// Whether the shapes can meet in this step, by their boxes where it begins; in later rounds by the ways that
/// the last one took.
bool Step::is_near(const Pair& pair, const PairLook& look) const {
  const std::uint32_t a = look.body_a, b = look.body_b;
  if (!look.alike || !(look.gap > s_.config.contact_margin)) return true;
  // What little solid shapes may overlap, and leave to the next step, a sensor is to tell now.
  if (s_.shapes[pair.low].sensor || s_.shapes[pair.high].sensor) return true;
  const double margin = s_.config.contact_margin;
  if (look.gap > margin + way_of(a) + way_of(b) || look.nearest > margin + strays(a) + strays(b))
    return false;
  if (rounds_ == 0 || look.chain) return true;
  Contact contact;
  contact.shape_a = pair.low;
  contact.shape_b = pair.high;
  contact.body_a = a;
  contact.body_b = b;
  return meet_deeply(contact);
}

/// How far a body goes at most, or did in the last round [m].
double Step::way_of(std::uint32_t i) const {
  return rounds_ == 0 || s_.bodies.type[i] != BodyType::Dynamic ? s_.reach[i] : s_.travelled[i];
}

/// How far it strays from its way at most, or did in the last round [m].
double Step::strays(std::uint32_t i) const {
  if (s_.bodies.type[i] != BodyType::Dynamic) return 0;
  return rounds_ == 0 ? s_.allowance[i] : s_.strayed[i];
}

/// Farther apart than this [m] the step cannot bring two bodies' shapes together.
double Step::margin_of(std::uint32_t a, std::uint32_t b) const {
  const double both = s_.reach[a] + s_.reach[b], margin = s_.config.contact_margin;
  // `extend_reach` lets half a margin pass for each.
  if (!fly_alike(a, b)) return 2 * margin + both;
  const auto most = [&](std::uint32_t i) {
    return s_.bodies.type[i] != BodyType::Dynamic ? 0 : s_.allowance[i];
  };
  return margin + std::min(both, flight_apart(s_, a, b, h_) + most(a) + most(b));
}

/// By how much the distance of two bodies shrank in the last round at most [m].
double Step::closest_approach(std::uint32_t a, std::uint32_t b) const {
  const double ways = way_of(a) + way_of(b);
  return fly_alike(a, b) ? std::min(ways, flight_apart(s_, a, b, h_) + strays(a) + strays(b)) : ways;
}

/// Whether it is worth a look how two bodies move against each other: one is fast, and nothing bends the way
/// of either.
bool Step::fly_alike(std::uint32_t a, std::uint32_t b) const {
  const auto plain = [this](std::uint32_t i) {
    return s_.flight[i] != FlightKind::Bent || s_.bodies.type[i] == BodyType::Static;
  };
  return (s_.flight[a] == FlightKind::Fast || s_.flight[b] == FlightKind::Fast) && plain(a) && plain(b);
}

/// Whether a body went straight on in the last round, or did not move.
bool Step::went_straight(std::uint32_t i) const {
  const BodyArrays& b = s_.bodies;
  if (b.type[i] == BodyType::Kinematic) return s_.flight[i] != FlightKind::Bent;
  if (b.type[i] == BodyType::Static || b.asleep[i] || s_.travelled[i] == 0) return true;
  if (b.island[i] < 0) return false;
  const SteppedIsland& island = s_.islands[static_cast<std::size_t>(b.island[i])];
  if (island.flew_alone) return true;
  const IslandResult& result = island.result();
  return result.in_flight ||
         (result.report.flowing && result.substeps == result.flow_pieces && !result.unmoved);
}

/// The way of the last round, of a body that went straight on.
Motion Step::straight_motion(std::uint32_t i) const {
  const BodyBackup& from = s_.backup[i];
  Motion m{from.position, from.angle};
  if (s_.bodies.type[i] == BodyType::Kinematic) {
    m.v = from.velocity;
    m.omega = from.omega;
  } else {
    m.v = (s_.bodies.position[i] - from.position) / h_;
    m.omega = (s_.bodies.angle[i] - from.angle) / h_;
  }
  return m;
}

/// Only flow leaves overlaps to the next step.
bool Step::may_overrun(std::uint32_t body) const {
  const BodyArrays& b = s_.bodies;
  if (b.type[body] != BodyType::Dynamic || b.asleep[body] != 0 || b.island[body] < 0) return false;
  const SteppedIsland& island = s_.islands[static_cast<std::size_t>(b.island[body])];
  return !island.flew_alone && island.result().report.flowing && s_.travelled[body] > 0;
}

/// Whether two bodies that may have met in the last round did, and not so little that the next step may find
/// it. Of bodies that went straight on that is known; of others it is not, which counts as well.
bool Step::meet_deeply(const Contact& contact) const {
  const std::uint32_t a = contact.body_a, b = contact.body_b;
  if (!went_straight(a) || !went_straight(b)) return true;
  const Motion of_a = straight_motion(a), of_b = straight_motion(b);
  const Shape &shape_a = s_.shapes[contact.shape_a].shape, &shape_b = s_.shapes[contact.shape_b].shape;
  const ImpactTime impact = contact_impact_time(contact, shape_a, of_a, shape_b, of_b, h_);
  if (!impact.hit) return !impact.converged;
  if (!may_overrun(a) && !may_overrun(b)) return true;
  const auto at = [&](double t, double margin) {
    return contact_manifold(contact, shape_a, of_a.at(t), shape_b, of_b.at(t), margin, nullptr, nullptr);
  };
  // Little is what neither overlaps much nor went on much against the other after they met.
  const double little = rounds_ == 1 ? little_overrun(s_, a) + little_overrun(s_, b)
                                     : kLaterOverrun * (overrun(s_, a) + overrun(s_, b));
  const double rest = h_ - impact.t;
  const Manifold first = at(impact.t, s_.config.contact_margin), last = at(h_, 0);
  if (first.count == 0) return true;
  const double onwards = rest * dot(first.normal, of_a.v - of_b.v);
  const double swings = rest * (std::abs(of_a.omega) * s_.radius[a] + std::abs(of_b.omega) * s_.radius[b]);
  if (onwards + (last.count == 0 ? swings : 0) > little) return true;
  const auto is_compact = [&](std::uint32_t i) { return s_.radius[i] < kCompact * s_.thickness[i]; };
  if (last.count > 0 && !(is_compact(a) && is_compact(b)) && !(dot(first.normal, last.normal) > 0.5))
    return true;
  double depth = 0;
  for (int i = 0; i < last.count; ++i) depth = std::max(depth, -last.points[i].separation);
  return depth > little;
}

/// Pairs of a later round were judged by the ways of the one before it: what went farther than there, or
/// elsewhere, may have met others. @return whether something did; marks it as dirty
bool Step::find_detours() {
  s_.scratch.dirty.assign(s_.bodies.size(), 0);
  if (rounds_ < 2) return false;
  const double little = s_.config.touch_tolerance, near = 0.5 * s_.config.contact_margin;
  bool found = false;
  for (const SteppedIsland& island : s_.islands) {
    if (!island.again) continue;
    for (const std::uint32_t i : island.island.bodies) {
      const Went& before = s_.went[i];
      const double shift = length(s_.bodies.position[i] - before.position) +
                           std::abs(s_.bodies.angle[i] - before.angle) * s_.radius[i];
      if (s_.travelled[i] <= before.travelled + little && s_.strayed[i] <= before.strayed + little &&
          shift <= near)
        continue;
      s_.scratch.dirty[i] = 1;
      found = true;
    }
  }
  return found;
}

/// A body that was struck may have left the box that was foreseen for it. Where it went straight on, that is
/// its way from now on; else its reach grows. Whether it did meet more than was known shows in the next
/// round. What is too small grows each time and islands only merge, so this ends.
bool Step::extend_reach() {
  std::vector<std::uint32_t>& left = s_.scratch.left;
  left.clear();
  for (const std::uint32_t i : s_.active) {
    if (!s_.kept[i] && left_its_reach(s_, i)) left.push_back(i);
  }
  if (left.empty() && rounds_ < 2) return false;
  const bool detours = find_detours();
  // In a fast crush each round has other ways: after some rounds bodies keep theirs, and get room around
  // them.
  const bool has_ways = rounds_ <= kRoundsOfWays;
  const double more = has_ways ? kMoreRoom : kMuchMoreRoom;
  for (const std::uint32_t i : left) {
    s_.scratch.dirty[i] = 1;
    // What rests strays from its fall, and goes on resting.
    if (has_ways && s_.flight[i] != FlightKind::Bent && s_.travelled[i] > 0 && went_straight(i)) {
      const Motion m = straight_motion(i);
      s_.way[i] = {m.v, {}, m.omega, 0};
      s_.reach[i] = s_.travelled[i];
      s_.allowance[i] = s_.strayed[i] = 0;
      s_.flight[i] = FlightKind::Fast;
      s_.rerouted[i] = 1;
      continue;
    }
    if (s_.travelled[i] > s_.reach[i] + 0.5 * s_.config.contact_margin) s_.reach[i] = more * s_.travelled[i];
    // Free flight takes it no farther than its reach; bounds on curved ways may add up to more.
    s_.allowance[i] = std::max(2 * s_.reach[i], more * s_.strayed[i]);
  }
  return detours || !left.empty();
}

/// A body in flow may go a little farther than was foreseen for it: queries look at what left its box until
/// it has a new one.
void Step::loosen_overrun() {
  for (const SteppedIsland& island : s_.islands) {
    if (island.flew_alone || island.kept || island.result().in_flight) continue;
    for (const std::uint32_t i : island.island.bodies) {
      // What was forgiven is noted as just the bound.
      const bool astray = s_.flight[i] == FlightKind::Fast && s_.strayed[i] >= s_.allowance[i];
      if (!(s_.travelled[i] > 0) || (s_.travelled[i] < s_.reach[i] && !astray)) continue;
      for (const std::uint32_t shape : s_.shapes_of[i]) {
        const Aabb now = bounding_box(s_.shapes[shape].shape, s_.bodies.pose(i)),
                   known = s_.shapes[shape].box;
        if (contains(known, now.lower) && contains(known, now.upper)) continue;
        // Once, so that steps do without more memory.
        if (s_.loose_shapes.capacity() < s_.shapes.size()) s_.loose_shapes.reserve(s_.shapes.size());
        s_.loose_shapes.push_back(shape);
      }
    }
  }
}

}  // namespace skerry
