// SPDX-License-Identifier: MIT
//
// The bridge, its surroundings and the train as bodies that are moved, or stand, while the answer is static.
#include <algorithm>
#include <cmath>

#include "physics/statics/bridge.h"
#include "physics/statics/bridge_filters.h"

namespace skerry::statics {

using namespace filters;

namespace {

constexpr double kPlate = 0.12;      // thickness of bearing plates [m]
constexpr double kPierWidth = 1.2;   // [m]
constexpr double kBankLength = 200;  // [m], beyond every view

}  // namespace

void Bridge::make_scenery(World& world) {
  const Structure& s = def_.structure;
  const double bearing = 0.5 * def_.thickness + kBearingLift;
  const double gap = 0.5 * kPierWidth + 0.05;
  const auto in_bank = [&](double x) {
    return !stations_.empty() && (x < s.nodes[static_cast<std::size_t>(def_.deck.front())].at.x - gap ||
                                  x > s.nodes[static_cast<std::size_t>(def_.deck.back())].at.x + gap);
  };
  const auto block = [&](Vec2 low, Vec2 high, const char* name) {
    if (!(high.x > low.x) || !(high.y > low.y)) return;
    const BodyId body =
        world.create_body({.type = BodyType::Static, .position = 0.5 * (low + high), .name = name});
    world.add_shape(body, plain(make_box(high - low), kWorld, ~kBearing));
  };
  for (const Support& support : s.supports) {
    const Vec2 at = s.nodes[static_cast<std::size_t>(support.node)].at;
    if (support.kind == SupportKind::Roller) {
      // The plate a roller stands on.
      const Rot turn = Rot::from_angle(support.angle);
      const BodyId plate =
          world.create_body({.type = BodyType::Static,
                             .position = at - (bearing + 0.5 * kPlate) * rotate(turn, {0, 1}),
                             .angle = support.angle,
                             .name = "bearing plate"});
      ShapeDef shape = plain(make_box({0.9 * kPierWidth, kPlate}), kBearing, kBearing);
      shape.material.friction = 0;
      world.add_shape(plate, shape);
    }
    if (def_.ground && !in_bank(at.x)) {
      const double top = at.y - bearing - (support.kind == SupportKind::Roller ? kPlate : 0);
      block({at.x - 0.5 * kPierWidth, *def_.ground}, {at.x + 0.5 * kPierWidth, top}, "pier");
    }
  }
  if (!def_.ground) return;
  const BodyId valley = world.create_body({.type = BodyType::Static, .name = "valley"});
  world.add_shape(valley, plain(make_half_plane({0, *def_.ground}, {0, 1}), kWorld, ~kBearing));
  if (stations_.empty()) return;
  const Vec2 left = s.nodes[static_cast<std::size_t>(def_.deck.front())].at;
  const Vec2 right = s.nodes[static_cast<std::size_t>(def_.deck.back())].at;
  const double up = 0.5 * def_.thickness;
  block({left.x - kBankLength, *def_.ground}, {left.x - gap, left.y + up}, "left bank");
  block({right.x + gap, *def_.ground}, {right.x + kBankLength, right.y + up}, "right bank");
}

// Shape of one piece in the frame of a body at `origin`, not turned.
Shape Bridge::piece_shape(const BridgePiece& piece, Vec2 origin, Vec2& from, Vec2& to) const {
  const Structure& s = def_.structure;
  const Member& m = s.members[static_cast<std::size_t>(piece.member)];
  const Vec2 a = s.nodes[static_cast<std::size_t>(m.a)].at, b = s.nodes[static_cast<std::size_t>(m.b)].at;
  from = a + piece.from * (b - a) - origin;
  to = a + piece.to * (b - a) - origin;
  return make_capsule(from, to, (m.cable ? 0.2 : 0.5) * def_.thickness);
}

void Bridge::make_fixed_members(World& world) {
  for (std::size_t m = 0; m < members_.size(); ++m) {
    BridgePiece piece{static_cast<int>(m), 0, 1, {}, {}, {}};
    const Member& member = def_.structure.members[m];
    const Vec2 middle = 0.5 * (def_.structure.nodes[static_cast<std::size_t>(member.a)].at +
                               def_.structure.nodes[static_cast<std::size_t>(member.b)].at);
    piece.body = world.create_body({.type = BodyType::Static, .position = middle});
    Vec2 from, to;
    world.add_shape(piece.body, plain(piece_shape(piece, middle, from, to), kMember, kWorld));
    const Transform pose = world.pose(piece.body);
    piece.local_from = to_local(pose, middle + from);
    piece.local_to = to_local(pose, middle + to);
    pieces_.push_back(piece);
  }
}

void Bridge::make_wagons(World& world, bool dynamic) {
  const Train& train = def_.train;
  const double r = train.wheel_radius;
  wagons_.clear();
  double front = train.start + train.speed * time_;
  for (std::size_t k = 0; k < train.axles.size();) {
    const bool pair = k + 1 < train.axles.size();
    const double gap = pair ? train.gaps[k] : 0;
    const Vec2 lift{0, 0.5 * def_.thickness + r};
    const Vec2 first = place(front).at + lift, second = place(front - gap).at + lift;
    BodyDef def;
    def.type = dynamic ? BodyType::Dynamic : BodyType::Kinematic;
    def.position = 0.5 * (first + second);
    def.angle = pair ? std::atan2(first.y - second.y, first.x - second.x) : 0;
    def.name = "wagon";
    if (dynamic) def.velocity = {train.speed, 0};
    const BodyId body = world.create_body(def);
    const auto add = [&](Shape shape, double mass, double area) {
      ShapeDef part = plain(std::move(shape), kWagon, kWorld | kDeck | kWagon);
      part.density = std::max(mass, kLightest) / area;
      part.material.friction = 0;
      world.add_shape(body, part);
    };
    const double wheel = kPi * r * r;
    add(make_disc(r, {0.5 * gap, 0}), train.axles[k] / kStandardGravity, wheel);
    if (pair) add(make_disc(r, {-0.5 * gap, 0}), train.axles[k + 1] / kStandardGravity, wheel);
    // A body of little mass above the axles, so that the axle loads stay what they are.
    const double length = pair ? gap + 1.6 * r : 2.2 * r;
    add(make_box({length, 2.4 * r}, {0, 1.9 * r}, 0, 0.3 * r), kLightest, length * 2.4 * r);
    if (dynamic && !wagons_.empty()) {
      const Vec2 behind = world.position(wagons_.back().body) - Vec2{0.5 * gap, 0};
      world.create_joint({.kind = JointKind::Distance,
                          .a = wagons_.back().body,
                          .b = body,
                          .anchor_a = behind,
                          .anchor_b = def.position + Vec2{0.5 * gap, 0}});
    }
    const Vec2 centre = inverse_rotate(world.pose(body).q, world.position(body) - def.position);
    wagons_.push_back({body, static_cast<int>(k), pair ? 2 : 1, centre});
    k += pair ? 2 : 1;
    front -= gap + (k < train.axles.size() ? train.gaps[k - 1] : 0);
  }
}

void Bridge::pose_wagons(World& world) {
  const Train& train = def_.train;
  double front = train.start + train.speed * time_;
  for (const Wagon& wagon : wagons_) {
    const auto k = static_cast<std::size_t>(wagon.first);
    const double gap = wagon.count == 2 ? train.gaps[k] : 0;
    const Vec2 lift{0, 0.5 * def_.thickness + train.wheel_radius};
    const Vec2 first = place(front).at + lift, second = place(front - gap).at + lift;
    // The definition's origin is the middle of the axles; the pose is that of the centre of mass.
    const double angle = wagon.count == 2 ? std::atan2(first.y - second.y, first.x - second.x) : 0;
    const Vec2 offset = rotate(Rot::from_angle(angle), wagon.centre);
    world.set_pose(wagon.body, 0.5 * (first + second) + offset, angle);
    const std::size_t next = k + static_cast<std::size_t>(wagon.count);
    front -= gap + (next < train.axles.size() ? train.gaps[next - 1] : 0);
  }
}

}  // namespace skerry::statics
