// SPDX-License-Identifier: MIT
//
// How far bodies can go within a step, and which pairs can meet therefore. Before the step a body's reach
// bounds how far it goes, and its allowance how far it leaves the way of its free flight; both hold until
// something strikes it, and what the step finds out is looked at afterwards. Two bodies that fly alike come
// no nearer to each other but for what they stray.
#include <algorithm>
#include <cmath>

#include "physics/stepping/travel.h"
#include "physics/world_step.h"

namespace skerry {
namespace {

/// By how much two bodies change their distance in `h` [s] while nothing touches them [m].
double flight_apart(const WorldState& s, std::uint32_t a, std::uint32_t b, double h) {
  const auto moves = [&](std::uint32_t i) { return s.bodies.type[i] == BodyType::Dynamic && !s.kept[i]; };
  const auto spin = [&](std::uint32_t i) {
    if (!moves(i)) return 0.0;
    return h * (std::abs(s.backup[i].omega) + h * std::abs(s.angular_acceleration[i])) * s.radius[i];
  };
  const Vec2 va = moves(a) ? s.backup[a].velocity : Vec2{}, vb = moves(b) ? s.backup[b].velocity : Vec2{};
  const Vec2 aa = moves(a) ? s.acceleration[a] : Vec2{}, ab = moves(b) ? s.acceleration[b] : Vec2{};
  // Most fall alike.
  const double falls = aa == ab ? 0 : length(aa - ab);
  return h * (length(va - vb) + h * falls) + spin(a) + spin(b);
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
  return 2 * h_ * (s_.bodies.inverse_mass[body] * length(push) +
                   s_.bodies.inverse_inertia[body] * std::abs(turn) * s_.radius[body]);
}

/// What is known of a pair before the step; where neither body is fast, nothing has to be.
PairLook Step::look_at(const Pair& pair) const {
  const std::uint32_t a = s_.shapes[pair.low].body.index, b = s_.shapes[pair.high].body.index;
  if (s_.flight[a] != FlightKind::Fast && s_.flight[b] != FlightKind::Fast) return {};
  const bool alike = fly_alike(a, b);
  const double gap = box_gap(pair);
  // How pairs that touch move does not matter.
  const bool matters = alike && gap > std::min(s_.config.touch_tolerance, s_.config.contact_margin);
  return {gap, matters ? flight_apart(s_, a, b, h_) : kInfinity, alike};
}

/// A fast body that something may strike, or that may strike something, can go anywhere within its reach.
void Step::expect_blows() {
  std::vector<PairLook>& looks = s_.scratch.looks;
  looks.clear();
  for (const Pair& pair : s_.pairs) {
    const PairLook& look = looks.emplace_back(look_at(pair));
    const std::uint32_t a = s_.shapes[pair.low].body.index, b = s_.shapes[pair.high].body.index;
    const bool fast_a = s_.flight[a] == FlightKind::Fast, fast_b = s_.flight[b] == FlightKind::Fast;
    if (!fast_a && !fast_b) continue;
    if (look.gap > s_.config.touch_tolerance + std::min(look.apart, s_.reach[a] + s_.reach[b])) continue;
    if (!may_touch(pair) || s_.shapes[pair.low].sensor || s_.shapes[pair.high].sensor) continue;
    if (fast_a) s_.allowance[a] = 2 * s_.reach[a];
    if (fast_b) s_.allowance[b] = 2 * s_.reach[b];
  }
}

/// Whether the shapes can meet in this step, by their boxes where it begins.
bool Step::is_near(const Pair& pair, const PairLook& look) const {
  if (!look.alike) return true;
  const std::uint32_t a = s_.shapes[pair.low].body.index, b = s_.shapes[pair.high].body.index;
  return !(look.gap > s_.config.contact_margin) ||
         !(look.gap > s_.config.contact_margin + closest_approach(a, b, look.apart, s_.reach, s_.allowance));
}

/// Farther apart than this [m] the step cannot bring two bodies' shapes together.
double Step::margin_of(std::uint32_t a, std::uint32_t b) const {
  const double both = s_.reach[a] + s_.reach[b];
  // `extend_reach` lets half a margin pass for each.
  return fly_alike(a, b) ? s_.config.contact_margin + closest_approach(a, b, s_.reach, s_.allowance)
                         : 2 * s_.config.contact_margin + both;
}

/// Distance of the two shapes' boxes where the step begins [m], or less.
double Step::box_gap(const Pair& pair) const {
  const ShapeRecord& a = s_.shapes[pair.low];
  const ShapeRecord& b = s_.shapes[pair.high];
  const double grown = s_.reach[a.body.index] + s_.reach[b.body.index] + 2 * s_.config.contact_margin;
  const double x = std::max(b.box.lower.x - a.box.upper.x, a.box.lower.x - b.box.upper.x) + grown;
  const double y = std::max(b.box.lower.y - a.box.upper.y, a.box.lower.y - b.box.upper.y) + grown;
  // Most boxes are beside or above each other.
  if (!(x > 0) || !(y > 0)) return std::max({x, y, 0.0});
  return std::hypot(x, y);
}

/// Whether it is worth a look how two bodies move against each other: one is fast, and nothing bends the way
/// of either.
bool Step::fly_alike(std::uint32_t a, std::uint32_t b) const {
  const auto plain = [this](std::uint32_t i) {
    return s_.flight[i] != FlightKind::Bent || s_.bodies.type[i] == BodyType::Static;
  };
  return (s_.flight[a] == FlightKind::Fast || s_.flight[b] == FlightKind::Fast) && plain(a) && plain(b);
}

/// By how much the distance of two bodies can shrink in the step [m]. @param ways  how far each goes at most
/// @param astray  and how far from free flight
double Step::closest_approach(std::uint32_t a, std::uint32_t b, const std::vector<double>& ways,
                              const std::vector<double>& astray) const {
  if (!fly_alike(a, b)) return ways[a] + ways[b];
  return closest_approach(a, b, flight_apart(s_, a, b, h_), ways, astray);
}

/// The same of two that fly alike. @param apart  what their flight alone brings
double Step::closest_approach(std::uint32_t a, std::uint32_t b, double apart, const std::vector<double>& ways,
                              const std::vector<double>& astray) const {
  const auto strays = [&](std::uint32_t i) { return s_.kept[i] ? 2 * s_.reach[i] : astray[i]; };
  return std::min(ways[a] + ways[b], apart + strays(a) + strays(b));
}

/// A body that was struck may have left the box that was foreseen for it. Its reach grows; whether it did
/// meet more than was known shows in the next round. What is too small grows each time and islands only
/// merge, so this ends.
bool Step::extend_reach() {
  bool any = false;
  std::vector<std::uint8_t>& dirty = s_.scratch.dirty;
  for (const std::uint32_t i : s_.active) {
    if (s_.kept[i] || !left_its_reach(s_, i)) continue;
    if (!any) dirty.assign(s_.bodies.size(), 0);
    if (s_.travelled[i] > s_.reach[i] + 0.5 * s_.config.contact_margin) s_.reach[i] = 1.25 * s_.travelled[i];
    // Free flight takes it no farther than its reach; bounds on curved ways may add up to more.
    s_.allowance[i] = std::max(2 * s_.reach[i], 1.25 * s_.strayed[i]);
    dirty[i] = 1;
    any = true;
  }
  return any;
}

}  // namespace skerry
