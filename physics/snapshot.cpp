// SPDX-License-Identifier: MIT
#include "physics/snapshot.h"

#include <algorithm>

#include "physics/snapshot_fields.h"

namespace skerry {
namespace {

constexpr std::string_view kKind = "world";
constexpr std::uint32_t kSnapshotVersion = 28;
constexpr std::string_view kTags[] = {"conf", "body", "shap", "join", "cont", "isla", "repo"};
constexpr std::size_t kParts = std::size(kTags);

/// Indices and sizes that the step takes for granted.
void check_tables(const WorldState& s, const WorldArchives& from) {
  const auto require = [](const Archive& archive, bool holds, const char* what) {
    if (!holds) archive.refuse(what);
  };
  const BodyArrays& b = s.bodies;
  const std::size_t n = b.size();
  for (const std::size_t size : {b.angle.size(),         b.rotation.size(),
                                 b.velocity.size(),      b.omega.size(),
                                 b.force.size(),         b.torque.size(),
                                 b.mass.size(),          b.inertia.size(),
                                 b.inverse_mass.size(),  b.inverse_inertia.size(),
                                 b.gravity_scale.size(), b.type.size(),
                                 b.alive.size(),         b.asleep.size(),
                                 b.island.size(),        b.generation.size(),
                                 b.number.size(),        s.names.size(),
                                 s.given_mass.size(),    s.given_inertia.size(),
                                 s.shapes_of.size(),     s.joints_of.size(),
                                 s.centre.size(),        s.radius.size(),
                                 s.reach.size(),         s.drag.size(),
                                 s.step_memory.size(),   s.thickness.size(),
                                 s.stray_guess.size(),   s.support.size(),
                                 s.applied.size()}) {
    require(from.bodies, size == n, "the lists of the bodies differ in length");
  }
  const auto below = [](const std::vector<std::uint32_t>& list, std::size_t limit) {
    return std::all_of(list.begin(), list.end(), [&](std::uint32_t i) { return i < limit; });
  };
  for (std::size_t i = 0; i < n; ++i) {
    require(from.bodies, below(s.shapes_of[i], s.shapes.size()), "a body has a shape that is not there");
    require(from.bodies, below(s.joints_of[i], s.joints.size()), "a body has a joint that is not there");
  }
  require(from.bodies, below(s.free_bodies, n), "a free slot that is not there");
  require(from.shapes, below(s.free_shapes, s.shapes.size()) && below(s.loose_shapes, s.shapes.size()),
          "a free slot that is not there");
  require(from.joints, below(s.free_joints, s.joints.size()), "a free slot that is not there");
  for (const ShapeRecord& shape : s.shapes) {
    require(from.shapes, !shape.alive || (shape.body.index < n && !shape.shape->vertices.empty()),
            "a shape without a body or without corners");
  }
  for (const JointRecord& joint : s.joints) {
    const auto there = [&](BodyId body) { return body.index < n; };
    require(from.joints, !joint.alive || (there(joint.def.b) && (!joint.def.a || there(joint.def.a))),
            "a joint to a body that is not there");
  }
  require(from.bodies, below(s.touched, n) && below(s.displaced, n), "a touched body that is not there");
  const auto check = [&](const Archive& archive, const Contact& c) {
    require(archive,
            c.shape_a < s.shapes.size() && c.shape_b < s.shapes.size() && c.body_a < n && c.body_b < n &&
                c.manifold.count >= 0 && c.manifold.count <= 2 && c.child >= 0,
            "a contact of something that is not there");
  };
  for (const Contact& c : s.contacts) check(from.contacts, c);
  require(from.islands, is_valid(s.sleepers, s), "a sleeping island of something that is not there");
  for (const SleepingIsland& island : s.sleepers.islands()) {
    require(from.islands, island.bodies.empty() || island.rest.strayed.size() == island.bodies.size(),
            "a sleeping island of another size");
    for (const Contact& c : island.contacts) check(from.islands, c);
  }
}

/// Arrays that every step fills, in their sizes; the boxes as the last step left them; the working set.
void complete(WorldState& s) {
  const std::size_t n = s.bodies.size();
  const BodyArrays& b = s.bodies;
  s.backup.clear();
  for (std::uint32_t i = 0; i < n; ++i) {
    s.backup.push_back({b.position[i], b.angle[i], b.rotation[i], b.velocity[i], b.omega[i]});
    if (b.alive[i] && b.type[i] == BodyType::Dynamic && !b.asleep[i]) s.awake.push_back(i);
    if (b.alive[i] && b.type[i] == BodyType::Kinematic) s.kinematic.push_back(i);
  }
  s.springs = static_cast<int>(std::count_if(s.joints.begin(), s.joints.end(), [](const JointRecord& joint) {
    return joint.alive && joint.def.stiffness > 0;
  }));
  s.acceleration.resize(n);
  s.angular_acceleration.resize(n);
  s.way.resize(n);
  s.rerouted.resize(n);
  for (ShapeRecord& shape : s.shapes) {
    if (shape.alive) s.shape_pool.share(shape.shape);
    const std::uint32_t body = shape.body.index;
    s.start_box.push_back(shape.alive ? bounding_box(shape.shape, {b.position[body], b.rotation[body]})
                                      : Aabb{});
  }
  s.travelled.resize(n);
  s.strayed.resize(n);
  // What the next step does not begin anew is slow: it sleeps, or it is kinematic and stands.
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool slow = b.type[i] == BodyType::Kinematic || flies_freely(s, i);
    s.allowance.push_back(2 * s.reach[i]);
    s.flight.push_back(slow ? FlightKind::Slow : FlightKind::Bent);
  }
  // Sleepers have the ways of their last step, and what kept them from falling on these.
  for (const SleepingIsland& island : s.sleepers.islands()) {
    for (std::size_t k = 0; k < island.bodies.size(); ++k) {
      const std::uint32_t i = island.bodies[k];
      s.way[i].a = b.gravity_scale[i] * s.config.gravity;
      s.strayed[i] = island.rest.strayed[k];
    }
  }
  s.local_index.assign(n, -1);
  s.prescribed.resize(n);
  s.rests.assign(n, 0);
  for (std::uint32_t i = 0; i < n; ++i) s.kept.push_back(b.type[i] != BodyType::Dynamic);
  s.paths.resize(n);
  fill_broad_phase(s);
}

}  // namespace

std::vector<std::byte> save_snapshot(const World& world) {
  std::array<ArchiveSection, kParts> sections;
  std::vector<Archive> archives;
  archives.reserve(kParts);
  for (std::size_t i = 0; i < kParts; ++i) {
    std::copy_n(kTags[i].begin(), 4, sections[i].tag.begin());
    archives.emplace_back(sections[i].bytes);
  }
  // The same lists read and write, so they take mutable references; writing changes nothing.
  auto& state = const_cast<WorldState&>(*world.state_);
  fields(WorldArchives{archives[0], archives[1], archives[2], archives[3], archives[4], archives[5],
                       archives[6]},
         state);
  return pack_sections(kKind, kSnapshotVersion, sections);
}

World load_snapshot(std::span<const std::byte> bytes) {
  std::vector<Archive> archives = unpack_sections(bytes, kKind, kSnapshotVersion, kTags);
  // The world is made by its configuration, so this is read twice.
  Archive first = archives[0];
  WorldConfig config;
  first(config);
  try {
    World world(config);
    WorldState& s = *world.state_;
    const WorldArchives from{archives[0], archives[1], archives[2], archives[3],
                             archives[4], archives[5], archives[6]};
    fields(from, s);
    for (const Archive& archive : archives) archive.finish();
    check_tables(s, from);
    complete(s);
    return world;
  } catch (const std::invalid_argument& error) {
    archives[0].refuse(error.what());
  }
}

}  // namespace skerry
