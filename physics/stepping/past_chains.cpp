// SPDX-License-Identifier: MIT
#include "physics/stepping/past_chains.h"

#include <array>

#include "physics/stepping/chain_side.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"

namespace skerry {
namespace {

// Contacts of islands that are looked at in any case: large ones that were exact met nothing unforeseen.
constexpr std::size_t kFewContacts = 64;

// So much of its half width is in front of the face again: from there the next step takes out the rest.
constexpr double kInFront = 1e-3;

/// Bodies that move as told are there until the step ends.
Transform start_pose(const WorldState& state, std::uint32_t body) {
  if (state.bodies.type[body] != BodyType::Dynamic) return state.bodies.pose(body);
  return {state.backup[body].position, state.backup[body].rotation};
}

/// A segment of a chain: where it begins, its length, and its directions.
struct Line {
  Vec2 from, along, normal;
  double length;

  Line(const Shape& chain, std::size_t segment)
      : from(chain.vertices[segment]),
        along(-perp(chain.normals[segment])),
        normal(chain.normals[segment]),
        length(dot(along, chain.vertices[segment + 1 < chain.vertices.size() ? segment + 1 : 0] - from)) {}
  double height(Vec2 p) const { return dot(normal, p - from); }
  double place(Vec2 p) const { return dot(along, p - from); }
  bool is_beside(Vec2 p) const { return place(p) >= 0 && place(p) <= length; }
};

/// A straight way from one point to another.
struct Way {
  Vec2 before, now;

  /// Where it meets the line through a segment. @pre its ends are on both sides
  Vec2 through(const Line& line) const {
    const double from = line.height(before), to = line.height(now);
    return before + (from / (from - to)) * (now - before);
  }
  /// 1 if it goes through a segment from its free side to the other, -1 if it comes back, else 0.
  int crosses(const Line& line) const {
    const bool behind = line.height(now) < 0;
    if (behind == (line.height(before) < 0) || !line.is_beside(through(line))) return 0;
    return behind ? 1 : -1;
  }
  /// It ends behind the chain: what goes over a ridge comes out again.
  bool ends_behind(const Shape& chain) const {
    int sum = 0;
    for (std::size_t i = 0; i < chain.normals.size(); ++i) sum += crosses(Line(chain, i));
    return sum > 0;
  }
};

/// The shift that brings the middle of a contact's other shape in front of its segment again, through which
/// it went in the step, world frame [m]; 0 where it did not.
Vec2 way_back(const WorldState& state, const Contact& contact, double h) {
  const auto& [of_a, chain, other, middle] = chain_side(state, contact);
  const std::uint32_t ground = of_a ? contact.body_a : contact.body_b,
                      body = of_a ? contact.body_b : contact.body_a;
  const Line line(chain, static_cast<std::size_t>(contact.child));
  const Transform frame = pose_at(state, ground, h);
  const Vec2 now = to_local(frame, to_world(state.bodies.pose(body), middle));
  if (!(line.height(now) < 0)) return {};
  const Way way{to_local(start_pose(state, ground), to_world(start_pose(state, body), middle)), now};
  if (way.crosses(line) != 1 || !way.ends_behind(chain)) return {};
  // Straight up, or where it came through if something else is above it.
  const Vec2 up = now - line.height(now) * line.normal;
  const Vec2 there =
      (line.is_beside(up) ? up : way.through(line)) + kInFront * half_width(other) * line.normal;
  return rotate(frame.q, there - now);
}

}  // namespace

void put_in_front_of_chains(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (island.contacts.size() > kFewContacts && !result.report.flowing && !result.one_piece) return;
  bool any = false;
  for (const std::uint32_t index : island.contacts) {
    const Contact& contact = state.contacts[index];
    // Chains have no thickness.
    if (state.thickness[contact.body_a] > 0 && state.thickness[contact.body_b] > 0) continue;
    const bool of_a = state.shapes[contact.shape_a].shape->kind == ShapeKind::Chain;
    if (!of_a && state.shapes[contact.shape_b].shape->kind != ShapeKind::Chain) continue;
    const Vec2 back = way_back(state, contact, h);
    if (back == Vec2{}) continue;
    const std::uint32_t body = of_a ? contact.body_b : contact.body_a;
    const std::array<double, 3> shift{back.x, back.y, 0};
    shift_body(state, body, shift);
    note_shift(state, body, shift);
    any = true;
  }
  if (any) result.manifolds_reused += update_manifolds(state, island, h, result.narrow);
}

}  // namespace skerry
