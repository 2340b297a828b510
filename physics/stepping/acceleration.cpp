// SPDX-License-Identifier: MIT
#include "physics/stepping/acceleration.h"

#include <algorithm>
#include <cmath>

#include "physics/joint_rows.h"
#include "physics/solver/dense_factors.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

using Block = std::array<double, 3>;

// Up to here a dense factorisation with full pivoting costs less than the sparse one does.
constexpr int kDenseRows = 24;
// Points nearer to each other along a face than this are at one place [m]; sine of the angle by which normals
// may differ that are those of one face.
constexpr double kOnePlace = 1e-6, kParallel = 1e-6;

double product(const Block& x, const Block& y) {
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

/// Force of a row that does not depend on accelerations [N or N m].
double given_force(const ModeRow& mode, const JointRow& row) {
  if (mode.kind == JointRowKind::Spring) return -row.stiffness * row.error - row.damping * row.rate;
  if (mode.state == JointRowState::Forward) return row.most;
  return mode.state == JointRowState::Backward ? -row.most : 0;
}

/// J a of the free motion.
double along_row(int a, const Block& Ja, int b, const Block& Jb, const std::vector<Block>& acceleration) {
  double sum = 0;
  if (a >= 0) sum += product(Ja, acceleration[static_cast<std::size_t>(a)]);
  if (b >= 0) sum += product(Jb, acceleration[static_cast<std::size_t>(b)]);
  return sum;
}

}  // namespace

/// All rows that a mode may use, at one state.
struct AccelerationProblem::Geometry {
  std::vector<ContactKinematics> points;
  std::vector<AccelerationRow> normals;
  std::vector<AccelerationRow> grips;
  std::vector<double> grip_speed;
  std::vector<AccelerationRow> rows;
  std::vector<JointRow> joint_rows;
  std::vector<JointEnd> ends;  ///< of the island's bodies

  void clear() {
    points.clear();
    normals.clear();
    grips.clear();
    grip_speed.clear();
    rows.clear();
    joint_rows.clear();
  }
};

AccelerationProblem::State AccelerationProblem::gather(const ContactMode& mode) const {
  State y;
  const BodyArrays& all = state_.bodies;
  for (const std::uint32_t i : island_.bodies) {
    y.insert(y.end(), {all.position[i].x, all.position[i].y, all.angle[i], all.velocity[i].x,
                       all.velocity[i].y, all.omega[i]});
  }
  y.resize(y.size() + mode.points.size() + mode.grips.size() + mode.rows.size(), 0);
  return y;
}

void AccelerationProblem::scatter(const State& y, WorldState& state) const {
  BodyArrays& all = state.bodies;
  for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
    const std::uint32_t i = island_.bodies[k];
    const double* q = y.data() + 6 * k;
    all.position[i] = {q[0], q[1]};
    if (all.angle[i] != q[2]) {
      all.angle[i] = q[2];
      all.rotation[i] = Rot::from_angle(q[2]);
    }
    all.velocity[i] = {q[3], q[4]};
    all.omega[i] = q[5];
  }
}

BodyMotion AccelerationProblem::motion(std::uint32_t body, double elapsed, const State& y) const {
  if (body == BodyId::kNone) return {};
  const BodyArrays& all = state_.bodies;
  const int k = state_.local_index[body];
  if (k >= 0) {
    const double* q = y.data() + 6 * k;
    return {{q[0], q[1]}, Rot::from_angle(q[2]), {q[3], q[4]}, q[5]};
  }
  if (all.type[body] != BodyType::Kinematic) return {all.position[body], all.rotation[body], {}, 0};
  const KinematicState now = kinematic_state(state_, body, elapsed);
  return {now.p, Rot::from_angle(now.angle), now.v, now.omega};
}

/// An unknown force: `row` is what it keeps at zero, `force` how it acts, with the friction it brings.
struct AccelerationProblem::Unknown {
  const AccelerationRow* row;
  const AccelerationRow* force;
  double* value;
  /// Sliding and rolling that follow a normal force: rows and factors.
  std::array<std::pair<const AccelerationRow*, double>, 2> friction{};
  int count = 0;
};

/// Memory of the evaluations.
struct AccelerationProblem::Scratch {
  Geometry geometry;
  std::vector<Block> free;
  std::vector<Unknown> unknowns;
  std::vector<AccelerationRow> pushes;  ///< of normal forces, with the friction they bring
  std::vector<double> lambda;
  std::vector<InverseMass> bodies;
  std::vector<BilateralForces::Row> rows;
  // Of the dense elimination.
  Eigen::MatrixXd matrix;
  Eigen::VectorXd rhs, solution;
  Eigen::FullPivLU<Eigen::MatrixXd> lu;
};

AccelerationProblem::AccelerationProblem(const WorldState& state, const Island& island, IslandResult& result)
    : state_(state),
      island_(island),
      result_(result),
      varying_(has_varying_forces(state, island)),
      scratch_(std::make_unique<Scratch>()) {}

AccelerationProblem::~AccelerationProblem() = default;

JointEnd AccelerationProblem::joint_end(std::uint32_t body, double elapsed, const State& y) const {
  if (body == BodyId::kNone) return {};
  const int k = state_.local_index[body];
  if (k < 0) return skerry::joint_end(state_, body, elapsed);
  const double* q = y.data() + 6 * k;
  return {{q[0], q[1]}, Rot::from_angle(q[2]), q[2], {q[3], q[4]}, q[5]};
}

AccelerationProblem::AccelerationRow AccelerationProblem::contact_row(const Contact& contact, Vec2 direction,
                                                                      Vec2 where, double bias, double elapsed,
                                                                      const BodyMotion& a,
                                                                      const BodyMotion& b) const {
  AccelerationRow row;
  row.a = state_.local_index[contact.body_a];
  row.b = state_.local_index[contact.body_b];
  const Block Ja{-direction.x, -direction.y, -cross(where - a.p, direction)};
  const Block Jb{direction.x, direction.y, cross(where - b.p, direction)};
  if (row.a >= 0) row.Ja = Ja;
  if (row.b >= 0) row.Jb = Jb;
  row.bias = bias + ground_bias(contact.body_a, Ja, elapsed) + ground_bias(contact.body_b, Jb, elapsed);
  return row;
}

bool AccelerationProblem::geometry(const ContactMode& mode, double elapsed, const State& y,
                                   Geometry& out) const {
  out.clear();
  out.ends.resize(island_.bodies.size());
  for (std::size_t k = 0; k < out.ends.size(); ++k) out.ends[k] = joint_end(island_.bodies[k], elapsed, y);
  const auto end_of = [&](std::uint32_t body) {
    if (body == BodyId::kNone) return JointEnd{};
    const int k = state_.local_index[body];
    return k >= 0 ? out.ends[static_cast<std::size_t>(k)] : skerry::joint_end(state_, body, elapsed);
  };
  const auto motion_of = [&](std::uint32_t body) {
    if (body == BodyId::kNone || state_.local_index[body] < 0) return motion(body, elapsed, y);
    const JointEnd& end = out.ends[static_cast<std::size_t>(state_.local_index[body])];
    return BodyMotion{end.p, end.q, end.v, end.omega};
  };
  for (const ModePoint& point : mode.points) {
    const Contact& contact = state_.contacts[island_.contacts[point.contact]];
    const BodyMotion a = motion_of(contact.body_a), b = motion_of(contact.body_b);
    const std::optional<ContactKinematics> k = kinematics_of(point.features, a, b);
    if (!k) return false;
    out.points.push_back(*k);
    out.normals.push_back(contact_row(contact, k->normal, k->position, k->normal_bias, elapsed, a, b));
  }
  for (const Grip& grip : mode.grips) {
    const Contact& contact = state_.contacts[island_.contacts[grip.contact]];
    const BodyMotion a = motion_of(contact.body_a), b = motion_of(contact.body_b);
    AccelerationRow row;
    double speed = 0;
    if (grip.rolling) {
      row.a = state_.local_index[contact.body_a];
      row.b = state_.local_index[contact.body_b];
      if (row.a >= 0) row.Ja = {0, 0, -1};
      if (row.b >= 0) row.Jb = {0, 0, 1};
      row.bias =
          ground_bias(contact.body_a, {0, 0, -1}, elapsed) + ground_bias(contact.body_b, {0, 0, 1}, elapsed);
      speed = b.omega - a.omega;
    } else {
      // The points of a pair lie on one tangent: any of them that is closed stands for all.
      int at = grip.points[0];
      if (grip.count == 2 && !mode.points[static_cast<std::size_t>(at)].closed) at = grip.points[1];
      const ContactKinematics& k = out.points[static_cast<std::size_t>(at)];
      row = contact_row(contact, perp(k.normal), k.position, k.tangent_bias, elapsed, a, b);
      speed = k.sliding - grip.surface;
    }
    out.grips.push_back(row);
    out.grip_speed.push_back(speed);
  }
  const JointRecord* joint = nullptr;
  JointRows rows;
  for (const ModeRow& wanted : mode.rows) {
    const std::uint32_t slot = island_.joints[wanted.joint];
    if (joint != &state_.joints[slot]) {
      joint = &state_.joints[slot];
      skerry::joint_rows(*joint, end_of(joint->def.a.index), end_of(joint->def.b.index), rows);
    }
    const JointRow& from = rows[static_cast<std::size_t>(wanted.row)];
    // Slack ropes may well have no direction.
    if (from.singular && (wanted.state != JointRowState::Off || wanted.kind == JointRowKind::Spring))
      return false;
    const std::uint32_t a = joint->def.a.index, b = joint->def.b.index;
    AccelerationRow row;
    row.a = a == BodyId::kNone ? -1 : state_.local_index[a];
    row.b = b == BodyId::kNone ? -1 : state_.local_index[b];
    if (row.a >= 0) row.Ja = from.Ja;
    if (row.b >= 0) row.Jb = from.Jb;
    row.bias = from.bias + ground_bias(a, from.Ja, elapsed) + ground_bias(b, from.Jb, elapsed);
    out.rows.push_back(row);
    out.joint_rows.push_back(from);
  }
  return true;
}

Block AccelerationProblem::inverse_mass(int k) const {
  const std::uint32_t body = island_.bodies[static_cast<std::size_t>(k)];
  return {state_.bodies.inverse_mass[body], state_.bodies.inverse_mass[body],
          state_.bodies.inverse_inertia[body]};
}

double AccelerationProblem::ground_bias(std::uint32_t body, const Block& J, double elapsed) const {
  if (body == BodyId::kNone || state_.local_index[body] >= 0 || !state_.prescribed[body]) return 0;
  const KinematicState now = kinematic_state(state_, body, elapsed);
  return J[0] * now.a.x + J[1] * now.a.y + J[2] * now.alpha;
}

void AccelerationProblem::apply(const ContactMode& mode, double elapsed, const Geometry& g,
                                std::vector<Block>& acceleration) const {
  acceleration.resize(island_.bodies.size());
  for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
    const std::uint32_t body = island_.bodies[k];
    if (varying_) {
      acceleration[k] = applied_acceleration(state_, body, g.ends[k], elapsed);
      continue;
    }
    acceleration[k] = {state_.acceleration[body].x, state_.acceleration[body].y,
                       state_.angular_acceleration[body]};
  }
  for (std::size_t i = 0; i < mode.rows.size(); ++i) {
    const double force = given_force(mode.rows[i], g.joint_rows[i]);
    if (force == 0) continue;
    const auto act = [&](int k, const Block& J) {
      if (k < 0) return;
      const Block m = inverse_mass(k);
      for (std::size_t c = 0; c < 3; ++c) acceleration[static_cast<std::size_t>(k)][c] += m[c] * J[c] * force;
    };
    act(g.rows[i].a, g.rows[i].Ja);
    act(g.rows[i].b, g.rows[i].Jb);
  }
}

bool AccelerationProblem::solve_dense(const std::vector<Unknown>& unknowns, const std::vector<Block>& free,
                                      std::vector<double>& lambda) const {
  const int n = static_cast<int>(unknowns.size());
  const auto weighted = [&](int k, const Block& force) {
    const Block m = inverse_mass(k);
    return Block{m[0] * force[0], m[1] * force[1], m[2] * force[2]};
  };
  Eigen::MatrixXd& matrix = scratch_->matrix;
  Eigen::VectorXd &rhs = scratch_->rhs, &solution = scratch_->solution;
  matrix.resize(n, n);
  rhs.resize(n);
  solution.resize(n);
  for (int j = 0; j < n; ++j) {
    const AccelerationRow& force = *unknowns[static_cast<std::size_t>(j)].force;
    const Block fa = force.a >= 0 ? weighted(force.a, force.Ja) : Block{};
    const Block fb = force.b >= 0 ? weighted(force.b, force.Jb) : Block{};
    for (int i = 0; i < n; ++i) {
      const AccelerationRow& row = *unknowns[static_cast<std::size_t>(i)].row;
      double w = 0;
      if (row.a >= 0 && row.a == force.a) w += product(row.Ja, fa);
      if (row.a >= 0 && row.a == force.b) w += product(row.Ja, fb);
      if (row.b >= 0 && row.b == force.a) w += product(row.Jb, fa);
      if (row.b >= 0 && row.b == force.b) w += product(row.Jb, fb);
      matrix(i, j) = w;
    }
    const AccelerationRow& row = *unknowns[static_cast<std::size_t>(j)].row;
    rhs(j) = -(row.bias + along_row(row.a, row.Ja, row.b, row.Jb, free));
  }
  Eigen::FullPivLU<Eigen::MatrixXd>& lu = scratch_->lu;
  lu.compute(matrix);
  ++result_.work.factorisations;
  if (lu.isInvertible()) {
    solution = solution_of(lu, rhs);
  } else {
    // Redundant supports: of the forces that do it those nearest to the ones with which the mode was chosen.
    for (int j = 0; j < n; ++j) solution(j) = *unknowns[static_cast<std::size_t>(j)].value;
    solution += solution_of(Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(matrix),
                            residual(matrix, solution, rhs));
    const double error = residual(matrix, solution, rhs).cwiseAbs().maxCoeff();
    if (error > 1e-9 * (1 + rhs.cwiseAbs().maxCoeff())) return false;
  }
  if (!solution.allFinite()) return false;
  lambda.assign(solution.data(), solution.data() + n);
  return true;
}

bool AccelerationProblem::solve_sparse(const std::vector<Unknown>& unknowns, const std::vector<Block>& free,
                                       std::vector<double>& lambda) const {
  IslandSystem system;
  for (const std::uint32_t body : island_.bodies)
    system.bodies.push_back({state_.bodies.inverse_mass[body], state_.bodies.inverse_inertia[body]});
  const auto add = [&system](const AccelerationRow& from, double b) -> Row& {
    Row row;
    row.kind = RowKind::Joint;
    row.a = from.a;
    row.b = from.b;
    row.Ja = from.Ja;
    row.Jb = from.Jb;
    row.lower = -kInfinity;
    system.rows.push_back(row);
    system.b.push_back(b);
    return system.rows.back();
  };
  for (const Unknown& unknown : unknowns) {
    const AccelerationRow& row = *unknown.row;
    add(row, -(row.bias + along_row(row.a, row.Ja, row.b, row.Jb, free)));
  }
  lambda.clear();
  for (const Unknown& unknown : unknowns) lambda.push_back(*unknown.value);
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    for (int f = 0; f < unknowns[i].count; ++f) {
      Row& row = add(*unknowns[i].friction[static_cast<std::size_t>(f)].first, 0);
      row.kind = RowKind::Friction;
      row.normal = static_cast<int>(i);
      row.mu = unknowns[i].friction[static_cast<std::size_t>(f)].second;
      lambda.push_back(row.mu * lambda[i]);
    }
  }
  return sparse_.solve(system, static_cast<int>(unknowns.size()), result_.work, lambda);
}

bool AccelerationProblem::solve_joints(const std::vector<Unknown>& unknowns, const std::vector<Block>& free,
                                       std::vector<double>& lambda) const {
  Scratch& s = *scratch_;
  s.bodies.clear();
  for (const std::uint32_t body : island_.bodies)
    s.bodies.push_back({state_.bodies.inverse_mass[body], state_.bodies.inverse_inertia[body]});
  s.rows.clear();
  for (const Unknown& unknown : unknowns) {
    const AccelerationRow& row = *unknown.row;
    s.rows.push_back(
        {row.a, row.b, row.Ja, row.Jb, -(row.bias + along_row(row.a, row.Ja, row.b, row.Jb, free))});
  }
  return joints_.solve(s.bodies, s.rows, result_.work, lambda);
}

/// More rows than a dense factorisation is good for.
bool AccelerationProblem::solve_many(const std::vector<Unknown>& unknowns, const std::vector<Block>& free,
                                     std::vector<double>& lambda) const {
  const bool slides =
      std::any_of(unknowns.begin(), unknowns.end(), [](const Unknown& one) { return one.count > 0; });
  if (!slides && solve_joints(unknowns, free, lambda)) {
    work_ += 0.25 * static_cast<double>(unknowns.size());
    return true;
  }
  work_ += static_cast<double>(unknowns.size());
  return solve_sparse(unknowns, free, lambda);
}

bool AccelerationProblem::evaluate(const ContactMode& mode, double elapsed, const State& y,
                                   ModeForces& out) const {
  ++result_.force_solves;
  Geometry& g = scratch_->geometry;
  if (!geometry(mode, elapsed, y, g)) return false;
  apply(mode, elapsed, g, out.acceleration);
  out.points.swap(g.points);
  out.grip_speed.swap(g.grip_speed);
  out.rows.swap(g.joint_rows);
  std::vector<Block>& free = scratch_->free;
  free = out.acceleration;

  std::vector<Unknown>& unknowns = scratch_->unknowns;
  std::vector<AccelerationRow>& pushes = scratch_->pushes;
  unknowns.clear();
  pushes.clear();
  pushes.reserve(mode.points.size());
  out.point_force.assign(mode.points.size(), 0);
  out.grip_force.assign(mode.grips.size(), 0);
  out.grip_limit.assign(mode.grips.size(), 0);
  out.row_force.resize(mode.rows.size());
  for (std::size_t i = 0; i < mode.rows.size(); ++i) {
    out.row_force[i] = given_force(mode.rows[i], out.rows[i]);
    if (mode.rows[i].state != JointRowState::Holds) continue;
    if (!mode.row_force.empty()) out.row_force[i] = mode.row_force[i];
    unknowns.push_back(Unknown{&g.rows[i], &g.rows[i], &out.row_force[i]});
  }
  for (std::size_t p = 0; p < mode.points.size(); ++p) {
    if (!mode.points[p].closed) continue;
    AccelerationRow& push = pushes.emplace_back(g.normals[p]);
    Unknown normal{&g.normals[p], &push, &out.point_force[p]};
    if (!mode.point_force.empty()) out.point_force[p] = mode.point_force[p];
    for (std::size_t k = 0; k < mode.grips.size(); ++k) {
      const Grip& grip = mode.grips[k];
      if (grip.contact != mode.points[p].contact || grip.sign == 0) continue;
      const double factor = -grip.sign * grip.mu;
      for (std::size_t c = 0; c < 3; ++c) {
        push.Ja[c] += factor * g.grips[k].Ja[c];
        push.Jb[c] += factor * g.grips[k].Jb[c];
      }
      normal.friction[static_cast<std::size_t>(normal.count++)] = {&g.grips[k], factor};
    }
    unknowns.push_back(normal);
  }
  // Two points of a pair of bodies, of one contact or several, that lie beside each other along one face hold
  // the angle already; resistance to rolling takes over when one of them parts.
  const auto same_pair = [](const AccelerationRow& one, const AccelerationRow& other) {
    return (one.a == other.a && one.b == other.b) || (one.a == other.b && one.b == other.a);
  };
  const auto hold_angle = [&](std::size_t p, std::size_t q) {
    if (!mode.points[p].closed || !mode.points[q].closed || !same_pair(g.normals[p], g.normals[q]))
      return false;
    const Vec2 normal = out.points[p].normal;
    return std::abs(cross(normal, out.points[q].normal)) < kParallel &&
           std::abs(cross(normal, out.points[q].position - out.points[p].position)) > kOnePlace;
  };
  const auto holds = [&](const Grip& grip) {
    const auto is_closed = [&](int p) { return mode.points[static_cast<std::size_t>(p)].closed; };
    if (std::none_of(grip.points.begin(), grip.points.begin() + grip.count, is_closed)) return false;
    if (!grip.rolling) return true;
    const AccelerationRow& own = g.grips[static_cast<std::size_t>(&grip - mode.grips.data())];
    for (std::size_t p = 0; p < mode.points.size(); ++p) {
      if (!same_pair(g.normals[p], own)) continue;
      for (std::size_t q = 0; q < p; ++q)
        if (hold_angle(p, q)) return false;
    }
    return true;
  };
  for (std::size_t k = 0; k < mode.grips.size(); ++k) {
    if (mode.grips[k].sign != 0 || !holds(mode.grips[k])) continue;
    if (!mode.grip_force.empty()) out.grip_force[k] = mode.grip_force[k];
    unknowns.push_back(Unknown{&g.grips[k], &g.grips[k], &out.grip_force[k]});
  }

  const int n = static_cast<int>(unknowns.size());
  double fastest = 0, heaviest = 0;
  for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
    fastest = std::max(fastest, std::hypot(free[k][0], free[k][1]));
    heaviest = std::max(heaviest, 1 / state_.bodies.inverse_mass[island_.bodies[k]]);
  }
  out.scale = fastest * heaviest;
  std::vector<double>& lambda = scratch_->lambda;
  if (n <= kDenseRows) work_ += 1 + 0.01 * n * n * n;
  if (n > 0 && !(n > kDenseRows ? solve_many(unknowns, free, lambda) : solve_dense(unknowns, free, lambda)))
    return false;
  for (int j = 0; j < n; ++j) {
    const Unknown& unknown = unknowns[static_cast<std::size_t>(j)];
    const double value = lambda[static_cast<std::size_t>(j)];
    *unknown.value = value;
    out.scale = std::max(out.scale, std::abs(value));
    const auto act = [&](int k, const Block& force) {
      if (k < 0) return;
      const Block m = inverse_mass(k);
      for (std::size_t c = 0; c < 3; ++c)
        out.acceleration[static_cast<std::size_t>(k)][c] += m[c] * force[c] * value;
    };
    act(unknown.force->a, unknown.force->Ja);
    act(unknown.force->b, unknown.force->Jb);
  }
  for (std::size_t k = 0; k < mode.grips.size(); ++k) {
    const Grip& grip = mode.grips[k];
    double load = 0;
    for (int i = 0; i < grip.count; ++i)
      load += out.point_force[static_cast<std::size_t>(grip.points[static_cast<std::size_t>(i)])];
    out.grip_limit[k] = (grip.sign == 0 ? grip.hold : grip.mu) * load;
    if (grip.sign != 0) out.grip_force[k] = -grip.sign * grip.mu * load;
  }
  return true;
}

void AccelerationProblem::derivative(const State& y, const ModeForces& forces, State& dy) const {
  dy.resize(y.size());
  for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      dy[6 * k + c] = y[6 * k + 3 + c];
      dy[6 * k + 3 + c] = forces.acceleration[k][c];
    }
  }
  std::size_t at = 6 * island_.bodies.size();
  for (const double force : forces.point_force) dy[at++] = force;
  for (const double force : forces.grip_force) dy[at++] = force;
  for (const double force : forces.row_force) dy[at++] = force;
}

/// Rows of a contact problem, and what of a mode they stand for.
struct AccelerationProblem::Places {
  struct Place {
    int row = -1;
    std::size_t index = 0;
  };
  std::vector<Place> held, limits, motors, normals, frictions;
};

void AccelerationProblem::set_up(const ContactMode& mode, const Geometry& g, const std::vector<Block>& free,
                                 IslandSystem& system, Places& places) const {
  for (const std::uint32_t body : island_.bodies) {
    system.bodies.push_back({state_.bodies.inverse_mass[body], state_.bodies.inverse_inertia[body]});
    system.positions.push_back(state_.bodies.position[body]);
  }
  const auto add = [&](const AccelerationRow& from, RowKind kind) -> Row& {
    Row row;
    row.kind = kind;
    row.a = from.a;
    row.b = from.b;
    row.Ja = from.Ja;
    row.Jb = from.Jb;
    if (kind != RowKind::Normal && kind != RowKind::Limit) row.lower = -kInfinity;
    row.source = static_cast<std::uint64_t>(system.rows.size());
    system.rows.push_back(row);
    system.b.push_back(-(from.bias + along_row(from.a, from.Ja, from.b, from.Jb, free)));
    return system.rows.back();
  };
  for (std::size_t i = 0; i < mode.rows.size(); ++i) {
    if (mode.rows[i].state != JointRowState::Holds) continue;
    const int at = system.size();
    switch (mode.rows[i].kind) {
      case JointRowKind::Limit:
        places.limits.push_back({at, i});
        add(g.rows[i], RowKind::Limit);
        break;
      case JointRowKind::Motor: {
        places.motors.push_back({at, i});
        Row& row = add(g.rows[i], RowKind::Motor);
        row.upper = g.joint_rows[i].most;
        row.lower = -row.upper;
        break;
      }
      default:
        places.held.push_back({at, i});
        add(g.rows[i], RowKind::Joint);
    }
  }
  for (std::size_t p = 0; p < mode.points.size(); ++p) {
    const int normal = system.size();
    places.normals.push_back({normal, p});
    add(g.normals[p], RowKind::Normal);
    for (std::size_t k = 0; k < mode.grips.size(); ++k) {
      const Grip& grip = mode.grips[k];
      if (grip.contact != mode.points[p].contact) continue;
      places.frictions.push_back({system.size(), k});
      Row& row = add(g.grips[k], grip.rolling ? RowKind::Rolling : RowKind::Friction);
      row.normal = normal;
      row.mu = grip.sign == 0 ? grip.hold : grip.mu;
    }
  }
}

void AccelerationProblem::equations(const ContactMode& mode, double elapsed, const State& y,
                                    const ModeForces& forces, double h, IslandSystem& system,
                                    std::vector<double>& lambda) const {
  Geometry& g = scratch_->geometry;
  if (!geometry(mode, elapsed, y, g)) return;
  std::vector<Block> free;
  apply(mode, elapsed, g, free);
  Places places;
  set_up(mode, g, free, system, places);
  for (double& b : system.b) b *= h;
  lambda.assign(system.rows.size(), 0);
  const auto impulse = [&](const Places::Place& place) -> double& {
    return lambda[static_cast<std::size_t>(place.row)];
  };
  for (const auto* rows : {&places.held, &places.limits, &places.motors})
    for (const Places::Place& place : *rows) impulse(place) = h * forces.row_force[place.index];
  for (const Places::Place& place : places.motors) {
    Row& row = system.rows[static_cast<std::size_t>(place.row)];
    row.upper *= h;
    row.lower *= h;
  }
  for (const Places::Place& place : places.normals) impulse(place) = h * forces.point_force[place.index];
  for (const Places::Place& place : places.frictions) {
    const Grip& grip = mode.grips[place.index];
    const Row& row = system.rows[static_cast<std::size_t>(place.row)];
    // Two points share the friction by their loads.
    double load = 0;
    for (int i = 0; i < grip.count; ++i)
      load += h * forces.point_force[static_cast<std::size_t>(grip.points[static_cast<std::size_t>(i)])];
    const double own = lambda[static_cast<std::size_t>(row.normal)];
    if (load > 0) impulse(place) = h * forces.grip_force[place.index] * own / load;
    if (grip.sign != 0) system.b[static_cast<std::size_t>(place.row)] -= g.grip_speed[place.index];
  }
  const std::vector<double> w = row_velocities(system, lambda);
  for (const Places::Place& place : places.frictions) {
    const auto row = static_cast<std::size_t>(place.row);
    if (mode.grips[place.index].sign * w[row] < 0) system.b[row] += w[row];
  }
}

bool AccelerationProblem::choose(ContactMode& mode, double elapsed, const State& y) const {
  ++result_.force_solves;
  Geometry& g = scratch_->geometry;
  if (!geometry(mode, elapsed, y, g)) return false;
  std::vector<Block> free;
  apply(mode, elapsed, g, free);
  IslandSystem system;
  Places places;
  set_up(mode, g, free, system, places);
  const auto& [held, limits, motors, normals, frictions] = places;
  double largest = 0;
  for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
    const double turn = std::abs(free[k][2]) * state_.radius[island_.bodies[k]];
    largest = std::max({largest, std::hypot(free[k][0], free[k][1]), turn});
  }
  for (const double b : system.b) largest = std::max(largest, std::abs(b));
  // A contact that slides has its friction at the bound whatever the accelerations: it is asked for one that
  // no force within the bounds can give.
  for (const Places::Place& place : frictions) {
    const int sign = mode.grips[place.index].sign;
    if (sign != 0) system.b[static_cast<std::size_t>(place.row)] = -sign * 1e3 * (1 + largest);
  }
  if (system.rows.empty()) return true;
  SolveOptions options = state_.config.solve;
  options.work_limit = work_left_of_all(state_, result_);
  const Solution solution = state_.solver->solve(system, {}, options, nullptr);
  result_.report.rows = system.size();
  result_.report.residual = std::max(result_.report.residual, solution.residual);
  result_.report.iterations += solution.iterations;
  result_.report.method = solution.method;
  result_.friction_rows = static_cast<int>(frictions.size());
  result_.work += solution.work;
  if (solution.status != SolveStatus::Solved) return false;

  mode.point_force.assign(mode.points.size(), 0);
  mode.grip_force.assign(mode.grips.size(), 0);
  mode.row_force.assign(mode.rows.size(), 0);
  const auto force_of = [&](const Places::Place& place) {
    return solution.lambda[static_cast<std::size_t>(place.row)];
  };
  for (const Places::Place& place : held) mode.row_force[place.index] = force_of(place);
  for (const Places::Place& place : limits) mode.row_force[place.index] = force_of(place);
  for (const Places::Place& place : motors) mode.row_force[place.index] = force_of(place);
  for (const Places::Place& place : normals) mode.point_force[place.index] = force_of(place);
  for (const Places::Place& place : frictions) mode.grip_force[place.index] += force_of(place);

  const std::vector<double> w = row_velocities(system, solution.lambda);
  double load = 0;
  for (const double lambda : solution.lambda) load = std::max(load, std::abs(lambda));
  const auto carries = [&](int row) { return solution.lambda[static_cast<std::size_t>(row)] > 1e-11 * load; };
  for (const Places::Place& place : limits)
    mode.rows[place.index].state = carries(place.row) ? JointRowState::Holds : JointRowState::Off;
  for (const Places::Place& place : motors) {
    const double force = solution.lambda[static_cast<std::size_t>(place.row)];
    if (std::abs(force) < system.rows[static_cast<std::size_t>(place.row)].upper * (1 - 1e-12)) continue;
    mode.rows[place.index].state = force > 0 ? JointRowState::Forward : JointRowState::Backward;
  }
  for (const Places::Place& place : normals) mode.points[place.index].closed = carries(place.row);
  bool weaker = false;
  for (const Places::Place& place : frictions) {
    Grip& grip = mode.grips[place.index];
    if (grip.sign != 0 || !carries(system.rows[static_cast<std::size_t>(place.row)].normal)) continue;
    // Where even the largest friction cannot hold, the acceleration tells which way it begins to slide.
    const double slip = w[static_cast<std::size_t>(place.row)];
    if (!(std::abs(slip) > 1e-9 * (1 + largest))) continue;
    grip.sign = slip > 0 ? 1 : -1;
    weaker |= grip.hold > grip.mu;
  }
  // What begins to slide pulls less from then on, so others may follow: each round at least one grip fewer
  // holds.
  return !weaker || choose(mode, elapsed, y);
}

}  // namespace skerry
