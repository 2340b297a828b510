// SPDX-License-Identifier: MIT
#include "physics/statics/rest.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/contact.h"
#include "physics/joint_rows.h"
#include "physics/narrowphase/chain.h"
#include "physics/solver/solver.h"
#include "physics/statics/null_space.h"

namespace skerry::statics {
namespace {

// Forces and accelerations below these shares of the largest are rounding.
constexpr double kCarries = 1e-10;
constexpr double kMoves = 1e-7;

class Builder {
 public:
  Builder(const World& world, const RestOptions& options, RestAnalysis& out)
      : world_(world), options_(options), out_(out), local_(world.bodies().size(), -1) {}

  void run() {
    add_bodies();
    add_joints();
    add_contacts();
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
      const Vec2 force = b.mass[i] * b.gravity_scale[i] * world_.config().gravity + b.force[i];
      out_.load.push_back({force.x, force.y, b.torque[i]});
    }
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
        directions_.push_back(direction);
        add_row(row);
      }
      out_.joints.push_back({slot, spring, true});
      joint_rows_.push_back({first, out_.system.size()});
    }
  }

  void push_load(int body, const std::array<double, 3>& J, double force) {
    for (std::size_t c = 0; body >= 0 && c < 3; ++c)
      out_.load[static_cast<std::size_t>(body)][c] += J[c] * force;
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
    for (std::uint32_t i = 0; i < shapes.size(); ++i) {
      for (std::uint32_t j = i + 1; j < shapes.size(); ++j) {
        if (!shapes[i].alive || !shapes[j].alive || !overlap(boxes[i], boxes[j])) continue;
        if (!may_touch(shapes[i], shapes[j])) continue;
        const bool chain_i = shapes[i].shape.kind == ShapeKind::Chain;
        if (chain_i && shapes[j].shape.kind == ShapeKind::Chain) continue;
        if (!chain_i && shapes[j].shape.kind != ShapeKind::Chain) {
          add_pair(i, j, 0);
          continue;
        }
        const ShapeRecord& chain = shapes[chain_i ? i : j];
        chain_segments_near(chain.shape, world_.pose(chain.body), boxes[chain_i ? j : i], segments);
        for (const int segment : segments) add_pair(i, j, segment);
      }
    }
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
    const double mu =
        mix(std::max(a.friction_rule, b.friction_rule), a.material.friction, b.material.friction);
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
      made.mu = mu;
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

 public:
  std::vector<std::array<int, 2>> joint_rows_;  ///< of each joint: first row, and the one after its last
  std::vector<Vec2> directions_;                ///< of joint rows, in their order

 private:
  const World& world_;
  const RestOptions& options_;
  RestAnalysis& out_;
  std::vector<int> local_;
  int pairs_ = 0;
};

/// Rows that carry (or may, at no load) and leave a body at rest: their null vectors are self-stress states.
void find_uniqueness(RestAnalysis& out) {
  const IslandSystem& system = out.system;
  const int n = system.size();
  out.unique.assign(static_cast<std::size_t>(n), 1);
  double largest = 0;
  for (const double force : out.lambda) largest = std::max(largest, std::abs(force));
  std::vector<int> column_of(static_cast<std::size_t>(n), -1), row_of;
  std::vector<Entry> entries;
  for (int i = 0; i < n; ++i) {
    const Row& row = system.rows[static_cast<std::size_t>(i)];
    const int normal = row.normal >= 0 ? row.normal : i;
    const bool one_sided = row.kind == RowKind::Normal || row.kind == RowKind::Limit || row.normal >= 0;
    // A contact that opens cannot carry, whatever the others do.
    if (one_sided && out.lambda[static_cast<std::size_t>(normal)] <= kCarries * largest) {
      const double w = row_velocities(system, out.lambda)[static_cast<std::size_t>(normal)];
      if (w > kMoves * (1 + std::abs(w))) continue;
    }
    column_of[static_cast<std::size_t>(i)] = static_cast<int>(row_of.size());
    row_of.push_back(i);
    const auto add = [&](int body, const std::array<double, 3>& J) {
      for (int c = 0; body >= 0 && c < 3; ++c) {
        if (J[static_cast<std::size_t>(c)] != 0)
          entries.push_back(
              {3 * body + c, column_of[static_cast<std::size_t>(i)], J[static_cast<std::size_t>(c)]});
      }
    };
    add(row.a, row.Ja);
    add(row.b, row.Jb);
  }
  const NullSpace space =
      null_space(3 * static_cast<int>(system.bodies.size()), static_cast<int>(row_of.size()), entries, 1e-9);
  out.indeterminacy = static_cast<int>(space.basis.size());
  for (const std::vector<double>& z : space.basis) {
    for (std::size_t k = 0; k < row_of.size(); ++k)
      if (std::abs(z[k]) > 1e-8) out.unique[static_cast<std::size_t>(row_of[k])] = 0;
  }
}

}  // namespace

RestAnalysis analyse_rest(const World& world, const RestOptions& options) {
  const SolverEntry& solver = find_solver(options.solver);
  RestAnalysis out;
  Builder builder(world, options, out);
  builder.run();
  IslandSystem& system = out.system;
  std::vector<std::array<double, 3>> external;
  for (std::size_t k = 0; k < out.bodies.size(); ++k) {
    const InverseMass& m = system.bodies[k];
    external.push_back({m.linear * out.load[k][0], m.linear * out.load[k][1], m.angular * out.load[k][2]});
  }
  for (const Row& row : system.rows) {
    double a = 0;
    if (row.a >= 0) a += along(row.Ja, external[static_cast<std::size_t>(row.a)]);
    if (row.b >= 0) a += along(row.Jb, external[static_cast<std::size_t>(row.b)]);
    system.b.push_back(-a);
  }
  out.lambda.assign(system.rows.size(), 0);
  if (system.size() > 0) {
    SolveOptions exact;
    exact.tolerance = 1e-13;
    const Solution solution = solver.solve(system, {}, exact, nullptr);
    out.lambda = solution.lambda;
    out.residual = solution.residual;
  }
  out.acceleration = external;
  apply_impulses(system, out.lambda, out.acceleration);

  const std::vector<double> w = row_velocities(system, out.lambda);
  find_uniqueness(out);
  for (RestContact& contact : out.contacts) {
    const auto row = static_cast<std::size_t>(contact.row);
    contact.normal_force = out.lambda[row];
    contact.opening = w[row];
    contact.normal_unique = out.unique[row] != 0;
    if (!(contact.mu > 0)) continue;
    contact.friction_force = out.lambda[row + 1];
    contact.sliding = w[row + 1];
  }
  for (std::size_t k = 0; k < out.joints.size(); ++k) {
    for (int i = builder.joint_rows_[k][0]; i < builder.joint_rows_[k][1]; ++i) {
      const auto row = static_cast<std::size_t>(i);
      out.joints[k].force += out.lambda[row] * builder.directions_[row];
      out.joints[k].unique = out.joints[k].unique && out.unique[row] != 0;
    }
  }
  double scale = 0;
  for (std::size_t k = 0; k < out.bodies.size(); ++k) {
    // Turning counts at the radius of gyration.
    const InverseMass& m = system.bodies[k];
    const double arm = m.angular > 0 ? std::sqrt(m.linear / m.angular) : 0;
    const auto size = [&](const std::array<double, 3>& a) {
      return std::max(std::hypot(a[0], a[1]), arm * std::abs(a[2]));
    };
    scale = std::max(scale, size(external[k]));
    out.largest_acceleration = std::max(out.largest_acceleration, size(out.acceleration[k]));
  }
  out.stands = out.largest_acceleration <= kMoves * scale;
  return out;
}

const char* to_string(Fate fate) {
  switch (fate) {
    case Fate::Stands:
      return "stands";
    case Fate::Slides:
      return "slides";
    case Fate::Tips:
      return "tips";
    case Fate::Falls:
      return "falls";
    case Fate::Collapses:
      return "collapses";
  }
  return "";
}

Fate fate_of(const RestAnalysis& rest) {
  if (rest.stands) return Fate::Stands;
  const double moving = 1e-6 * std::max(rest.largest_acceleration, 1e-300);
  std::vector<std::uint8_t> supported(rest.bodies.size(), 0);
  for (const Row& row : rest.system.rows) {
    if (row.a >= 0) supported[static_cast<std::size_t>(row.a)] = 1;
    if (row.b >= 0) supported[static_cast<std::size_t>(row.b)] = 1;
  }
  int turning = 0, sliding = 0, falling = 0;
  for (std::size_t k = 0; k < rest.bodies.size(); ++k) {
    const InverseMass& m = rest.system.bodies[k];
    const double arm = m.angular > 0 ? std::sqrt(m.linear / m.angular) : 0;
    const std::array<double, 3>& a = rest.acceleration[k];
    if (std::max(std::hypot(a[0], a[1]), arm * std::abs(a[2])) <= moving) continue;
    if (!supported[k])
      ++falling;
    else if (arm * std::abs(a[2]) > moving)
      ++turning;
    else
      ++sliding;
  }
  if (turning == 0) return sliding > 0 ? Fate::Slides : Fate::Falls;
  return turning == 1 && sliding == 0 ? Fate::Tips : Fate::Collapses;
}

std::vector<PairForce> pair_forces(const RestAnalysis& rest) {
  std::vector<PairForce> result;
  for (std::size_t i = 0; i < rest.contacts.size();) {
    PairForce pair;
    pair.first = static_cast<int>(i);
    Vec2 moment_point{}, middle{};
    double mu = 0;
    std::size_t end = i;
    for (; end < rest.contacts.size() && rest.contacts[end].pair == rest.contacts[i].pair; ++end) {
      const RestContact& c = rest.contacts[end];
      pair.normal += c.normal_force;
      pair.friction += c.friction_force;
      pair.force += c.normal_force * c.normal + c.friction_force * perp(c.normal);
      moment_point += c.normal_force * c.position;
      middle += c.position;
      mu = c.mu;
    }
    pair.count = static_cast<int>(end - i);
    middle = middle / static_cast<double>(pair.count);
    pair.at = pair.normal > 0 ? moment_point / pair.normal : middle;
    const double half =
        pair.count == 2 ? 0.5 * length(rest.contacts[i + 1].position - rest.contacts[i].position) : 0;
    pair.eccentricity = half > 0 ? length(pair.at - middle) / half : 0;
    pair.grip = mu * pair.normal > 0 ? std::abs(pair.friction) / (mu * pair.normal) : 0;
    result.push_back(pair);
    i = end;
  }
  return result;
}

std::vector<ThrustSegment> thrust_line(const RestAnalysis& rest) {
  const std::vector<PairForce> pairs = pair_forces(rest);
  double largest = 0;
  for (const PairForce& pair : pairs) largest = std::max(largest, length(pair.force));
  std::vector<ThrustSegment> result;
  for (const BodyId body : rest.bodies) {
    std::vector<const PairForce*> loaded;
    for (const PairForce& pair : pairs) {
      const RestContact& c = rest.contacts[static_cast<std::size_t>(pair.first)];
      if ((c.body_a == body || c.body_b == body) && length(pair.force) > 1e-9 * largest)
        loaded.push_back(&pair);
    }
    if (loaded.size() != 2) continue;
    result.push_back(
        {body, loaded[0]->at, loaded[1]->at, 0.5 * (length(loaded[0]->force) + length(loaded[1]->force))});
  }
  return result;
}

}  // namespace skerry::statics
