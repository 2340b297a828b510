// SPDX-License-Identifier: MIT
//
// A bridge that has broken, or is dynamic by choice: its pieces as dynamic bodies, their forces from the
// joints, and bars that break on the way.
//
// Bars are rods between hinges; beams that are clamped to each other are one body and break no further;
// cables are ropes. At a node all bodies hang on the first. A roller is a small wheel on a plate, so it may
// lift off.
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "physics/statics/bridge.h"
#include "physics/statics/bridge_filters.h"

namespace skerry::statics {
namespace {

constexpr double kBearingMass = 20;  // [kg] of the little wheel of a roller

}  // namespace

void Bridge::let_go(World& world) {
  moving_ = true;
  for (const BridgePiece& piece : pieces_) world.destroy(piece.body);
  pieces_.clear();
  for (const Wagon& wagon : wagons_) world.destroy(wagon.body);
  if (!def_.train.axles.empty()) make_wagons(world, true);

  const Structure& s = def_.structure;
  attached_.assign(s.nodes.size(), {});
  is_weight_.assign(s.nodes.size(), 0);
  joints_.assign(s.nodes.size(), {});
  held_by_.assign(s.supports.size(), {});
  response_ = {};
  response_.reactions.resize(s.supports.size());
  std::vector<BridgePiece> parts;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    const int member = static_cast<int>(m);
    if (s.members[m].cable) {
      if (!members_[m].broken) ropes_.push_back({member, {}});
    } else if (members_[m].broken) {
      const double cut =
          s.members[m].kind == MemberKind::Bar ? 0.5 : std::clamp(members_[m].stress.share, 0.05, 0.95);
      parts.push_back({member, 0, cut, {}, {}, {}});
      parts.push_back({member, cut, 1, {}, {}, {}});
    } else {
      parts.push_back({member, 0, 1, {}, {}, {}});
    }
  }

  // Ends that are clamped to each other at a node make one body.
  std::vector<std::size_t> group(parts.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
  };
  std::map<int, std::size_t> clamped;  // by node
  const auto clamp = [&](int node, std::size_t part) {
    const auto [known, is_new] = clamped.emplace(node, part);
    if (!is_new) group[root(part)] = root(known->second);
  };
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Member& m = s.members[static_cast<std::size_t>(parts[i].member)];
    if (m.kind != MemberKind::Beam) continue;
    if (parts[i].from == 0 && !m.hinge_a) clamp(m.a, i);
    if (parts[i].to == 1 && !m.hinge_b) clamp(m.b, i);
  }
  std::map<std::size_t, std::vector<BridgePiece>> groups;
  for (std::size_t i = 0; i < parts.size(); ++i) groups[root(i)].push_back(parts[i]);
  for (const auto& [first, members] : groups) make_group(world, members);

  // Nodes of cables alone are small weights.
  for (const RopeMember& rope : ropes_) {
    const Member& m = s.members[static_cast<std::size_t>(rope.member)];
    for (const int node : {m.a, m.b}) {
      const auto n = static_cast<std::size_t>(node);
      if (!attached_[n].empty()) continue;
      double mass = 0;
      for (const RopeMember& other : ropes_) {
        const Member& o = s.members[static_cast<std::size_t>(other.member)];
        if (o.a == node || o.b == node) mass += 0.5 * o.density * o.area * member_length(s, other.member);
      }
      const BodyId body =
          world.create_body({.position = s.nodes[n].at, .mass = std::max(mass, filters::kLightest)});
      world.add_shape(body,
                      filters::plain(make_disc(0.25 * def_.thickness), filters::kMember, filters::kWorld));
      attached_[n].push_back({body, {0, 0}, false});
      is_weight_[n] = 1;
    }
  }
  for (std::size_t node = 0; node < s.nodes.size(); ++node) connect(world, node);
  for (RopeMember& rope : ropes_) hang_rope(world, rope);
  apply_fixed_loads(world);
}

// One body of `parts`, at their places in the structure; returns the numbers of its pieces.
std::vector<std::size_t> Bridge::make_group(World& world, const std::vector<BridgePiece>& parts) {
  const Structure& s = def_.structure;
  std::vector<std::size_t> made;
  Vec2 origin{}, unused;
  const Member& first = s.members[static_cast<std::size_t>(parts.front().member)];
  origin = s.nodes[static_cast<std::size_t>(first.a)].at;
  const BodyId body = world.create_body({.position = origin});
  for (const BridgePiece& part : parts) {
    const Member& m = s.members[static_cast<std::size_t>(part.member)];
    BridgePiece piece = part;
    const bool deck =
        std::find(deck_members_.begin(), deck_members_.end(), part.member) != deck_members_.end();
    Vec2 from, to;
    ShapeDef shape =
        filters::plain(piece_shape(part, origin, from, to), deck ? filters::kDeck : filters::kMember,
                       deck ? filters::kWorld | filters::kWagon : filters::kWorld);
    const double span = length(to - from), radius = 0.5 * def_.thickness;
    const double mass = std::max(m.density * m.area * span, filters::kLightest);
    shape.density = mass / (2 * radius * span + kPi * radius * radius);
    world.add_shape(body, shape);
    piece.body = body;
    piece.local_from = from;
    piece.local_to = to;
    made.push_back(pieces_.size());
    pieces_.push_back(piece);
  }
  // The centre of mass is known now.
  const Transform pose = world.pose(body);
  for (const std::size_t i : made) {
    BridgePiece& piece = pieces_[i];
    piece.local_from = to_local(pose, origin + piece.local_from);
    piece.local_to = to_local(pose, origin + piece.local_to);
    const Member& m = s.members[static_cast<std::size_t>(piece.member)];
    const bool beam = m.kind == MemberKind::Beam;
    if (piece.from == 0) attach(world, m.a, body, beam && !m.hinge_a);
    if (piece.to == 1) attach(world, m.b, body, beam && !m.hinge_b);
  }
  return made;
}

void Bridge::attach(World& world, int node, BodyId body, bool clamped) {
  std::vector<Attachment>& list = attached_[static_cast<std::size_t>(node)];
  for (Attachment& known : list) {
    if (known.body != body) continue;
    known.clamped = known.clamped || clamped;
    return;
  }
  const Vec2 at = def_.structure.nodes[static_cast<std::size_t>(node)].at;
  list.push_back({body, to_local(world.pose(body), at), clamped});
}

// All bodies at the node hang on the first, and that on the support.
void Bridge::connect(World& world, std::size_t node) {
  for (const JointId joint : joints_[node])
    if (world.alive(joint)) world.destroy(joint);
  joints_[node].clear();
  if (attached_[node].empty()) return;
  const Attachment& hub = attached_[node].front();
  const Vec2 at = to_world(world.pose(hub.body), hub.local);
  const auto pin = [&](BodyId a, BodyId b, Vec2 where) {
    joints_[node].push_back(world.create_joint(
        {.kind = JointKind::Revolute, .a = a, .b = b, .anchor_a = where, .anchor_b = where}));
  };
  for (std::size_t k = 1; k < attached_[node].size(); ++k) pin(hub.body, attached_[node][k].body, at);
  for (std::size_t k = 0; k < def_.structure.supports.size(); ++k) {
    const Support& support = def_.structure.supports[k];
    if (static_cast<std::size_t>(support.node) != node) continue;
    held_by_[k].clear();
    if (support.kind == SupportKind::Roller) {
      const auto known = bearings_.find(static_cast<int>(node));
      BodyId wheel = known != bearings_.end() ? known->second : BodyId{};
      if (wheel && !world.alive(wheel)) continue;
      if (!wheel) {
        wheel = world.create_body({.position = at, .mass = kBearingMass, .name = "bearing"});
        ShapeDef disc = filters::plain(make_disc(0.5 * def_.thickness + filters::kBearingLift),
                                       filters::kBearing, filters::kBearing);
        disc.material.friction = 0;
        world.add_shape(wheel, disc);
        bearings_[static_cast<int>(node)] = wheel;
      }
      pin(wheel, hub.body, at);
      held_by_[k].push_back(joints_[node].back());
      continue;
    }
    // Beams that are clamped to a node are one body: the fixed support holds that, and lets bars turn.
    const auto clamped = std::find_if(attached_[node].begin(), attached_[node].end(),
                                      [](const Attachment& attachment) { return attachment.clamped; });
    if (support.kind == SupportKind::Fixed && clamped != attached_[node].end())
      joints_[node].push_back(
          world.create_joint({.kind = JointKind::Weld, .b = clamped->body, .anchor_a = at, .anchor_b = at}));
    else
      pin({}, hub.body, at);
    held_by_[k].push_back(joints_[node].back());
  }
}

void Bridge::hang_rope(World& world, RopeMember& rope) {
  const Member& m = def_.structure.members[static_cast<std::size_t>(rope.member)];
  if (rope.joint && world.alive(rope.joint)) world.destroy(rope.joint);
  const std::vector<Attachment>&at_a = attached_[static_cast<std::size_t>(m.a)],
        &at_b = attached_[static_cast<std::size_t>(m.b)];
  if (at_a.empty() || at_b.empty()) return;
  const Attachment &a = at_a.front(), &b = at_b.front();
  if (a.body == b.body) return;
  rope.joint = world.create_joint({.kind = JointKind::Rope,
                                   .a = a.body,
                                   .b = b.body,
                                   .anchor_a = to_world(world.pose(a.body), a.local),
                                   .anchor_b = to_world(world.pose(b.body), b.local),
                                   .length = member_length(def_.structure, rope.member)});
}

// Sum of what the joints, ropes and loads of a node do to `body` [N].
Vec2 Bridge::force_at(const World& world, std::size_t node, BodyId body) const {
  const double h = world.report().h;
  Vec2 sum{};
  const auto add = [&](JointId joint) {
    if (!joint || !world.alive(joint) || !(h > 0)) return;
    const JointRecord& record = world.joints()[joint.index];
    if (record.def.b == body) sum += record.impulse / h;
    if (record.def.a == body) sum += -(record.impulse / h);
  };
  for (const JointId joint : joints_[node]) add(joint);
  for (const RopeMember& rope : ropes_) {
    const Member& m = def_.structure.members[static_cast<std::size_t>(rope.member)];
    if (static_cast<std::size_t>(m.a) == node || static_cast<std::size_t>(m.b) == node) add(rope.joint);
  }
  if (attached_[node].front().body == body) sum += fixed_force(node);
  return sum;
}

void Bridge::measure_reactions(const World& world) {
  const double h = world.report().h;
  for (std::size_t k = 0; k < held_by_.size(); ++k) {
    Reaction& reaction = response_.reactions[k];
    reaction = {};
    for (const JointId joint : held_by_[k]) {
      if (!world.alive(joint) || !(h > 0)) continue;
      const JointRecord& record = world.joints()[joint.index];
      reaction.force += record.impulse / h;
      if (record.def.kind == JointKind::Weld) reaction.moment += record.angular_impulse / h;
    }
  }
}

// Fixed loads on a node; those on its cables among them, and their weight, as they have no body. Where there
// are cables alone, that is the weight of the node's.
Vec2 Bridge::fixed_force(std::size_t node) const {
  const Structure& s = def_.structure;
  Vec2 sum{};
  const auto add_share = [&](int member, double share, Vec2 force) {
    const Member& m = s.members[static_cast<std::size_t>(member)];
    if (!m.cable) return;
    if (static_cast<std::size_t>(m.a) == node) sum += (1 - share) * force;
    if (static_cast<std::size_t>(m.b) == node) sum += share * force;
  };
  for (const NodeLoad& l : def_.fixed.nodes)
    if (static_cast<std::size_t>(l.node) == node) sum += l.force;
  for (const SpanLoad& l : def_.fixed.spans) add_share(l.member, l.share, l.force);
  for (const LineLoad& l : def_.fixed.lines)
    add_share(l.member, 0.5, member_length(s, l.member) * l.force_per_length);
  if (is_weight_[node]) return sum;
  for (const RopeMember& rope : ropes_) {
    const Member& m = s.members[static_cast<std::size_t>(rope.member)];
    if (!members_[static_cast<std::size_t>(rope.member)].broken)
      add_share(rope.member, 0.5, m.density * m.area * member_length(s, rope.member) * gravity_);
  }
  return sum;
}

// For the next step. What acts on a node acts on the body that the others hang on.
void Bridge::apply_fixed_loads(World& world) const {
  for (std::size_t node = 0; node < attached_.size(); ++node) {
    const Vec2 force = fixed_force(node);
    if (force == Vec2{} || attached_[node].empty()) continue;
    const Attachment& hub = attached_[node].front();
    world.apply_force(hub.body, force, to_world(world.pose(hub.body), hub.local));
  }
  for (const NodeLoad& l : def_.fixed.nodes) {
    if (l.moment == 0) continue;
    for (const Attachment& attachment : attached_[static_cast<std::size_t>(l.node)])
      if (attachment.clamped) world.apply_torque(attachment.body, l.moment);
  }
  const auto on_piece = [&](const BridgePiece& piece, double share, Vec2 force) {
    const double along = (share - piece.from) / (piece.to - piece.from);
    const Vec2 local = (1 - along) * piece.local_from + along * piece.local_to;
    world.apply_force(piece.body, force, to_world(world.pose(piece.body), local));
  };
  for (const SpanLoad& l : def_.fixed.spans) {
    const auto piece = std::find_if(pieces_.begin(), pieces_.end(), [&](const BridgePiece& one) {
      return one.member == l.member && l.share >= one.from && l.share <= one.to;
    });
    if (piece != pieces_.end()) on_piece(*piece, l.share, l.force);
  }
  for (const LineLoad& l : def_.fixed.lines) {
    const Vec2 force = member_length(def_.structure, l.member) * l.force_per_length;
    for (const BridgePiece& piece : pieces_)
      if (piece.member == l.member)
        on_piece(piece, 0.5 * (piece.from + piece.to), (piece.to - piece.from) * force);
  }
}

void Bridge::measure(World& world, double time) {
  // Whoever has the world may remove a part; what hung on it is loose then.
  const auto gone = [&world](const auto& part) { return !world.alive(part.body); };
  std::erase_if(pieces_, gone);
  std::erase_if(wagons_, gone);
  for (std::vector<Attachment>& list : attached_) std::erase_if(list, gone);
  measure_reactions(world);
  std::vector<std::size_t> failing;
  const auto note = [&](int member, double axial) {
    const auto m = static_cast<std::size_t>(member);
    MemberState& state = members_[m];
    const Member& section = def_.structure.members[m];
    state.axial = axial;
    state.moment_a = state.moment_b = 0;
    if (!(section.area > 0)) return false;
    const double stress = axial / section.area;
    state.stress = {std::max(0.0, stress), std::max(0.0, -stress)};
    const double limit =
        axial < 0 ? std::min(section.strength * section.area, buckling_load(def_.structure, member))
                  : section.strength * section.area;
    state.signed_use = axial / limit;
    state.stress.squeezed = axial < 0;
    state.stress.utilisation = std::abs(state.signed_use);
    state.stress.buckles = limit < section.strength * section.area;
    if (std::abs(state.signed_use) > std::abs(state.peak_use)) {
      state.peak_use = state.signed_use;
      state.peak_time = time;
    }
    return def_.breaks && std::abs(state.signed_use) > 1;
  };
  const auto forget = [&](int member) {
    MemberState& state = members_[static_cast<std::size_t>(member)];
    state.axial = state.moment_a = state.moment_b = state.signed_use = 0;
    state.stress = {};
  };
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const BridgePiece& piece = pieces_[i];
    const Member& m = def_.structure.members[static_cast<std::size_t>(piece.member)];
    if (m.kind != MemberKind::Bar || piece.from != 0 || piece.to != 1) {
      forget(piece.member);
      continue;
    }
    const Transform pose = world.pose(piece.body);
    const Vec2 way = to_world(pose, piece.local_to) - to_world(pose, piece.local_from);
    const Vec2 along = way / length(way);
    const double axial = 0.5 * dot(along, force_at(world, static_cast<std::size_t>(m.b), piece.body) -
                                              force_at(world, static_cast<std::size_t>(m.a), piece.body));
    if (note(piece.member, axial)) failing.push_back(i);
  }
  for (RopeMember& rope : ropes_) {
    if (!rope.joint || !world.alive(rope.joint)) continue;
    const double h = world.report().h;
    const double pull = h > 0 ? length(world.joints()[rope.joint.index].impulse) / h : 0;
    members_[static_cast<std::size_t>(rope.member)].slack = pull == 0;
    if (!note(rope.member, pull)) continue;
    members_[static_cast<std::size_t>(rope.member)].broken = true;
    breaks_.push_back({rope.member, time, members_[static_cast<std::size_t>(rope.member)].signed_use});
    world.destroy(rope.joint);
    forget(rope.member);
  }
  for (const std::size_t piece : failing) {
    const int member = pieces_[piece].member;
    members_[static_cast<std::size_t>(member)].broken = true;
    breaks_.push_back({member, time, members_[static_cast<std::size_t>(member)].signed_use});
    snap(world, piece);
    forget(member);
  }
}

// A moving bar becomes two halves that go on as they moved.
void Bridge::snap(World& world, std::size_t piece) {
  const BridgePiece old = pieces_[piece];
  const Member& m = def_.structure.members[static_cast<std::size_t>(old.member)];
  const Transform pose = world.pose(old.body);
  const Vec2 from = to_world(pose, old.local_from), to = to_world(pose, old.local_to);
  const double radius = 0.5 * def_.thickness, span = 0.5 * length(to - from);
  const double mass = std::max(m.density * m.area * span, filters::kLightest);
  const double omega = world.omega(old.body);
  BridgePiece halves[2];
  for (int k = 0; k < 2; ++k) {
    const Vec2 start = k == 0 ? from : 0.5 * (from + to), end = k == 0 ? 0.5 * (from + to) : to;
    const Vec2 middle = 0.5 * (start + end);
    const BodyId body = world.create_body(
        {.position = middle, .velocity = world.velocity_at(old.body, middle), .omega = omega, .mass = mass});
    world.add_shape(body, filters::plain(make_capsule(start - middle, end - middle, radius), filters::kMember,
                                         filters::kWorld));
    halves[k] = {old.member, 0.5 * k, 0.5 + 0.5 * k, body, start - middle, end - middle};
    // It takes the place of the whole bar at its node.
    const auto node = static_cast<std::size_t>(k == 0 ? m.a : m.b);
    for (Attachment& attachment : attached_[node])
      if (attachment.body == old.body) attachment = {body, k == 0 ? start - middle : end - middle};
  }
  pieces_[piece] = halves[0];
  pieces_.push_back(halves[1]);
  world.destroy(old.body);
  for (const int node : {m.a, m.b}) {
    connect(world, static_cast<std::size_t>(node));
    for (RopeMember& rope : ropes_) {
      const Member& r = def_.structure.members[static_cast<std::size_t>(rope.member)];
      if ((r.a == node || r.b == node) && !members_[static_cast<std::size_t>(rope.member)].broken)
        hang_rope(world, rope);
    }
  }
}

}  // namespace skerry::statics
