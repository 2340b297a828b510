// SPDX-License-Identifier: MIT
//
// A world at rest as a contact problem: its bodies, what touches, its joints, its loads.
#include "physics/statics/rest_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

#include "physics/contact.h"
#include "physics/joint_rows.h"
#include "physics/narrowphase/chain.h"
#include "physics/text.h"

namespace skerry::statics {
namespace {

class Builder {
 public:
  Builder(const World& world, const RestOptions& options, RestAnalysis& out)
      : world_(world),
        options_(options),
        field_(world.callbacks().field),
        out_(out),
        local_(world.bodies().size(), -1) {}

  RestRows run() {
    add_bodies();
    add_joints();
    add_contacts();
    add_last_step();
    return std::move(rows_);
  }

 private:
  void add_bodies() {
    const BodyArrays& b = world_.bodies();
    for (std::size_t i = 0; i < b.size(); ++i) {
      if (!b.alive[i] || b.type[i] != BodyType::Dynamic) continue;
      if (!(b.inverse_mass[i] > 0))
        throw std::invalid_argument("body " + std::to_string(i) + " is dynamic but has no mass");
      local_[i] = static_cast<int>(out_.bodies.size());
      out_.bodies.push_back(world_.body_id(i));
      out_.system.bodies.push_back({b.inverse_mass[i], b.inverse_inertia[i]});
      out_.system.positions.push_back(b.position[i]);
      const Vec2 weight = b.mass[i] * b.gravity_scale[i] * world_.config().gravity;
      const Wrench wrench = field(i);
      const Vec2 force = weight + b.force[i] + wrench.force;
      out_.load.push_back({force.x, force.y, b.torque[i] + wrench.torque});
      out_.weight.push_back(length(weight));
      rows_.applied.push_back({length(weight) + length(b.force[i]) + length(wrench.force),
                               std::abs(b.torque[i]) + std::abs(wrench.torque)});
    }
    rows_.sprung.resize(out_.bodies.size(), {0, 0});
  }

  /// The field's force on a body that rests.
  Wrench field(std::size_t i) const {
    if (!field_) return {};
    const BodyArrays& b = world_.bodies();
    const Wrench wrench = field_({.body = world_.body_id(i),
                                  .position = b.position[i],
                                  .angle = b.angle[i],
                                  .velocity = {},
                                  .omega = 0,
                                  .mass = b.mass[i],
                                  .inertia = b.inertia[i],
                                  .time = world_.time()});
    if (!is_finite(wrench.force) || !std::isfinite(wrench.torque))
      throw std::invalid_argument("force field: not finite for body " + std::to_string(i) + ": " +
                                  to_text(wrench.force) + ", " + to_text(wrench.torque));
    return wrench;
  }

  int local(BodyId body) const { return body ? local_[body.index] : -1; }

  void add_row(Row row) {
    row.source = static_cast<std::uint64_t>(out_.system.rows.size());
    if (row.a < 0) row.Ja = {};
    if (row.b < 0) row.Jb = {};
    out_.system.rows.push_back(row);
  }

  JointEnd end_of(BodyId body) const {
    if (!body) return {};
    const Transform pose = world_.pose(body);
    return {pose.p, pose.q, world_.angle(body), {}, 0};
  }

  void add_joints() {
    const std::span<const JointRecord> joints = world_.joints();
    for (std::uint32_t slot = 0; slot < joints.size(); ++slot) {
      const JointRecord& joint = joints[slot];
      if (!joint.alive) continue;
      const int a = local(joint.def.a), b = local(joint.def.b);
      if (a < 0 && b < 0) continue;
      const JointEnd end_b = end_of(joint.def.b);
      JointRows geometry;
      const int count = joint_rows(joint, end_of(joint.def.a), end_b, geometry);
      const int first = out_.system.size();
      Vec2 spring{};
      for (int k = 0; k < count; ++k) {
        const JointRow& from = geometry[static_cast<std::size_t>(k)];
        const Vec2 direction = row_reaction(joint, end_b, from).force;
        if (from.kind == JointRowKind::Spring) {
          // Known at rest: a load.
          const double force = -from.stiffness * from.error;
          push_load(a, from.Ja, force);
          push_load(b, from.Jb, force);
          spring += force * direction;
          continue;
        }
        if (from.kind == JointRowKind::Limit && from.error > options_.touch) continue;
        Row row;
        row.a = a;
        row.b = b;
        row.Ja = from.Ja;
        row.Jb = from.Jb;
        row.kind = from.kind == JointRowKind::Hold ? RowKind::Joint : RowKind::Motor;
        row.lower = -from.most;
        row.upper = from.most;
        if (from.kind == JointRowKind::Limit) {
          row.kind = RowKind::Limit;
          row.lower = 0;
          row.upper = kInfinity;
        }
        rows_.directions.push_back(direction);
        joint_forces_.push_back(joint.row_force[k]);
        add_row(row);
      }
      out_.joints.push_back({slot, spring, true});
      rows_.springs.push_back(spring);
      rows_.of_joint.push_back({first, out_.system.size()});
    }
  }

  void push_load(int body, const std::array<double, 3>& J, double force) {
    if (body < 0) return;
    const auto i = static_cast<std::size_t>(body);
    for (std::size_t c = 0; c < 3; ++c) out_.load[i][c] += J[c] * force;
    for (auto* sums : {&rows_.applied, &rows_.sprung}) {
      (*sums)[i][0] += std::abs(force) * std::hypot(J[0], J[1]);
      (*sums)[i][1] += std::abs(force * J[2]);
    }
  }

  bool may_touch(const ShapeRecord& a, const ShapeRecord& b) const {
    if (a.sensor || b.sensor || a.body == b.body || !may_collide(a.filter, b.filter)) return false;
    if (local(a.body) < 0 && local(b.body) < 0) return false;
    for (const JointRecord& joint : world_.joints()) {
      if (!joint.alive || joint.def.collide) continue;
      if ((joint.def.a == a.body && joint.def.b == b.body) ||
          (joint.def.a == b.body && joint.def.b == a.body))
        return false;
    }
    return true;
  }

  void add_contacts() {
    const std::span<const ShapeRecord> shapes = world_.shapes();
    std::vector<Aabb> boxes(shapes.size());
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      if (shapes[i].alive)
        boxes[i] = grown(bounding_box(shapes[i].shape, world_.pose(shapes[i].body)), options_.touch);
    }
    std::vector<int> segments;
    for (const auto& [i, j] : overlapping(boxes)) {
      if (!may_touch(shapes[i], shapes[j])) continue;
      const bool chain_i = shapes[i].shape->kind == ShapeKind::Chain;
      if (chain_i && shapes[j].shape->kind == ShapeKind::Chain) continue;
      if (!chain_i && shapes[j].shape->kind != ShapeKind::Chain) {
        add_pair(i, j, 0);
        continue;
      }
      const ShapeRecord& chain = shapes[chain_i ? i : j];
      chain_segments_near(chain.shape, world_.pose(chain.body), boxes[chain_i ? j : i], segments);
      for (const int segment : segments) add_pair(i, j, segment);
    }
  }

  /// Slots of living shapes whose boxes overlap, low before high, in their order: a sweep along x.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> overlapping(const std::vector<Aabb>& boxes) const {
    std::vector<std::uint32_t> by_x, open;
    for (std::uint32_t i = 0; i < boxes.size(); ++i)
      if (world_.shapes()[i].alive) by_x.push_back(i);
    std::sort(by_x.begin(), by_x.end(), [&](std::uint32_t i, std::uint32_t j) {
      return std::pair(boxes[i].lower.x, i) < std::pair(boxes[j].lower.x, j);
    });
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const std::uint32_t i : by_x) {
      std::erase_if(open, [&](std::uint32_t j) { return boxes[j].upper.x < boxes[i].lower.x; });
      for (const std::uint32_t j : open)
        if (overlap(boxes[i], boxes[j])) pairs.emplace_back(std::min(i, j), std::max(i, j));
      open.push_back(i);
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

  void add_pair(std::uint32_t i, std::uint32_t j, int child) {
    const ShapeRecord& a = world_.shapes()[i];
    const ShapeRecord& b = world_.shapes()[j];
    Contact contact;
    contact.shape_a = i;
    contact.shape_b = j;
    contact.child = child;
    contact.body_a = a.body.index;
    contact.body_b = b.body.index;
    const Manifold manifold = contact_manifold(contact, a.shape, world_.pose(a.body), b.shape,
                                               world_.pose(b.body), options_.touch, nullptr, nullptr);
    // Nothing slides yet: static friction, which is never below the other.
    const MixingRule rule = std::max(a.friction_rule, b.friction_rule);
    const auto held = [](const Material& m) { return m.static_friction.value_or(m.friction); };
    const double sliding = mix(rule, a.material.friction, b.material.friction);
    const double mu = mix(rule, held(a.material), held(b.material));
    const double rolling = std::max(a.material.rolling_resistance, b.material.rolling_resistance);
    for (int k = 0; k < manifold.count; ++k) {
      const ManifoldPoint& point = manifold.points[static_cast<std::size_t>(k)];
      if (point.separation > options_.touch) continue;
      RestContact made;
      made.shape_a = {i, a.generation};
      made.shape_b = {j, b.generation};
      made.body_a = a.body;
      made.body_b = b.body;
      made.position = point.position;
      made.normal = manifold.normal;
      made.feature = point.feature;
      made.mu = made.held_mu = mu;
      made.sliding_mu = sliding;
      made.row = out_.system.size();
      made.pair = pairs_;
      out_.contacts.push_back(made);
      Row row;
      row.a = local(a.body);
      row.b = local(b.body);
      const auto along = [&](Vec2 d) {
        row.Ja = {-d.x, -d.y, -cross(point.position - world_.position(a.body), d)};
        row.Jb = {d.x, d.y, cross(point.position - world_.position(b.body), d)};
      };
      along(manifold.normal);
      add_row(row);
      row.normal = made.row;
      row.lower = -kInfinity;
      if (mu > 0) {
        row.kind = RowKind::Friction;
        row.mu = mu;
        along(perp(manifold.normal));
        add_row(row);
      }
      if (rolling > 0) {
        row.kind = RowKind::Rolling;
        row.mu = rolling;
        row.Ja = {0, 0, -1};
        row.Jb = {0, 0, 1};
        add_row(row);
      }
    }
    ++pairs_;
  }

  /// The forces of the world's last step, for the rows here: points are known by their shapes and features,
  /// those of chains also by where they are.
  void add_last_step() {
    const StepReport& report = world_.report();
    if (!(report.h > 0) || (!out_.contacts.empty() && report.contacts_list.empty())) return;
    using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;
    std::multimap<Key, const ContactPointReport*> points;
    for (const ContactReport& contact : report.contacts_list)
      for (int k = 0; k < contact.count; ++k) {
        const ContactPointReport& point = contact.points[static_cast<std::size_t>(k)];
        points.emplace(Key{contact.shape_a.index, contact.shape_b.index, point.feature}, &point);
      }
    rows_.last_step = joint_forces_;
    rows_.last_step.resize(out_.system.rows.size(), 0);
    for (const RestContact& contact : out_.contacts) {
      const auto [first, last] =
          points.equal_range(Key{contact.shape_a.index, contact.shape_b.index, contact.feature});
      const ContactPointReport* nearest = nullptr;
      for (auto it = first; it != last; ++it) {
        if (!nearest ||
            length(it->second->position - contact.position) < length(nearest->position - contact.position))
          nearest = it->second;
      }
      if (!nearest) continue;
      const auto row = static_cast<std::size_t>(contact.row);
      rows_.last_step[row] = nearest->normal_impulse / report.h;
      if (contact.held_mu > 0) rows_.last_step[row + 1] = nearest->friction_impulse / report.h;
    }
  }

  const World& world_;
  const RestOptions& options_;
  const ForceField field_;
  RestAnalysis& out_;
  RestRows rows_;
  std::vector<int> local_;
  std::vector<double> joint_forces_;  // of the last step, by row
  int pairs_ = 0;
};

}  // namespace

RestRows rest_rows(const World& world, const RestOptions& options, RestAnalysis& out) {
  return Builder(world, options, out).run();
}

}  // namespace skerry::statics
