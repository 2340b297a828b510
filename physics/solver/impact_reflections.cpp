// SPDX-License-Identifier: MIT
//
// Generalised reflections: contacts act while they approach [Smith, Kaufman, Vouga, Tamstorf & Grinspun
// 2012].
//
//   x = v
//   while the set A of approaching contacts is not empty:
//     lambda = argmin |x + M^-1 J_A' lambda|_M, lambda >= 0       (joints hold meanwhile)
//     x += 2 M^-1 J_A' lambda                                     (a mirror image: energy is kept)
//
// This is the elastic answer, with impulses L1; L0 is the plastic one. Contacts with restitution e take
// (1 - e) L0 + e L1, which dissipates; what still approaches is stopped plastically.
#include <algorithm>
#include <cmath>

#include "physics/solver/impact_laws.h"
#include "physics/solver/impact_tools.h"

namespace skerry::impact {
namespace {

/// Which rows touch which body, and the walk from an approaching contact to all that must be solved with it.
class Neighbourhood {
 public:
  explicit Neighbourhood(const IslandSystem& system)
      : system_(system), normals_(system.bodies.size()), joints_(system.bodies.size()) {
    for (int i = 0; i < system.size(); ++i) {
      const Row& row = system.rows[i];
      if (row.kind != RowKind::Normal && row.kind != RowKind::Joint) continue;
      auto& lists = row.kind == RowKind::Normal ? normals_ : joints_;
      if (row.a >= 0) lists[row.a].push_back(i);
      if (row.b >= 0) lists[row.b].push_back(i);
    }
    row_mark_.assign(system.rows.size(), 0);
    body_mark_.assign(system.bodies.size(), 0);
  }

  const std::vector<int>& normals(int body) const { return normals_[body]; }

  /// The component of `seed` in the set `active` of contacts (1 for each row in it); joints of the bodies met
  /// belong to it. Rows ascend; a row is reported once per `round`.
  void component(int seed, const std::vector<std::uint8_t>& active, int round, std::vector<int>& rows,
                 std::vector<int>& bodies) {
    rows.clear();
    bodies.clear();
    visit_row(seed, round, rows, bodies);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      for (const int i : normals_[bodies[k]]) {
        if (active[i] && row_mark_[i] != round) visit_row(i, round, rows, bodies);
      }
      for (const int i : joints_[bodies[k]]) {
        if (row_mark_[i] != round) visit_row(i, round, rows, bodies);
      }
    }
    std::sort(rows.begin(), rows.end());
  }
  bool visited(int row, int round) const { return row_mark_[row] == round; }

 private:
  void visit_row(int i, int round, std::vector<int>& rows, std::vector<int>& bodies) {
    row_mark_[i] = round;
    rows.push_back(i);
    for (const int body : {system_.rows[i].a, system_.rows[i].b}) {
      if (body < 0 || body_mark_[body] == round) continue;
      body_mark_[body] = round;
      bodies.push_back(body);
    }
  }

  const IslandSystem& system_;
  std::vector<std::vector<int>> normals_, joints_;
  std::vector<int> row_mark_, body_mark_;
};

/// Could all contacts open at once? True when some motion w has J w >= 1 for every contact and J w = 0 for
/// every joint; its least-energy form is a complementarity problem that has a solution exactly then.
bool can_all_open(const ImpactProblem& problem) {
  ImpactResult scratch;
  const std::vector<int> rows = unilateral_rows(problem.system);
  std::vector<double> targets(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    targets[k] = problem.system.rows[rows[k]].kind == RowKind::Normal ? 1 : 0;
  }
  ImpactProblem still = problem;
  std::fill(still.drive.begin(), still.drive.end(), 0);
  const Velocities rest(problem.velocity.size(), {0, 0, 0});
  const std::vector<double> lambda = unilateral(still, rows, rest, targets, scratch);
  Velocities w = rest;
  for (std::size_t k = 0; k < rows.size(); ++k) apply_row(problem.system, rows[k], lambda[k], w);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double u = row_velocity(still, rows[k], w);
    if (std::abs(targets[k]) > 0 ? u < 0.5 : std::abs(u) > 0.5) return false;
  }
  return true;
}

/// The elastic phase. Returns x, adds to `lambda`; contacts that cannot open are locked (they stop
/// plastically).
Velocities reflect(const ImpactProblem& problem, std::vector<double>& lambda, ImpactResult& result) {
  const IslandSystem& system = problem.system;
  Neighbourhood near(system);
  Velocities x = problem.velocity;
  std::vector<std::uint8_t> active(system.rows.size(), 0), locked(system.rows.size(), 0);

  double fastest = 0;
  std::vector<int> candidates = rows_of(system, RowKind::Normal);
  for (const int i : candidates) fastest = std::max(fastest, std::abs(row_velocity(problem, i, x)));
  // A check for jammed contacts is due when the count is beyond what free contacts take and momentum has
  // piled up.
  const int contacts = static_cast<int>(candidates.size());
  const int first_check = 4 * contacts + 50;
  int next_check = first_check;
  bool separable = false;
  std::vector<double> recent(system.rows.size(), 0);

  std::vector<int> approaching, rows, bodies, touched;
  for (int round = 1; !candidates.empty(); ++round) {
    approaching.clear();
    for (const int i : candidates) {
      if (row_velocity(problem, i, x) < -problem.rest_speed && inverse_mass(system, i) > 0)
        approaching.push_back(i);
    }
    if (approaching.empty()) break;
    for (const int i : approaching) active[i] = 1;

    touched.clear();
    for (const int seed : approaching) {
      if (near.visited(seed, round)) continue;
      near.component(seed, active, round, rows, bodies);
      const std::vector<double> impulses = unilateral(problem, rows, x, {}, result);
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const int i = rows[k];
        const double impulse = (locked[i] ? 1.0 : 2.0) * impulses[k];
        if (impulse == 0) continue;
        apply_row(system, i, impulse, x);
        lambda[i] += impulse;
        recent[i] += std::abs(impulse);
      }
      touched.insert(touched.end(), bodies.begin(), bodies.end());
      ++result.reflections;
    }
    for (const int i : approaching) active[i] = 0;

    // Only contacts of bodies whose velocity changed can have begun to approach.
    candidates.clear();
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const int body : touched) {
      candidates.insert(candidates.end(), near.normals(body).begin(), near.normals(body).end());
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());

    if (round < next_check) continue;
    next_check = round + first_check;
    double largest = 0;
    for (const int i : rows_of(system, RowKind::Normal)) {
      largest = std::max(largest, recent[i] * std::sqrt(inverse_mass(system, i)));
    }
    if (!separable) {
      separable = can_all_open(problem);
      // Balls wedged between walls would bounce for ever: contacts that carried the most lose their
      // elasticity.
      if (!separable) {
        for (const int i : rows_of(system, RowKind::Normal)) {
          if (!locked[i] && recent[i] * std::sqrt(inverse_mass(system, i)) > 1e-3 * largest) {
            locked[i] = 1;
            ++result.locked;
          }
        }
      }
    }
    std::fill(recent.begin(), recent.end(), 0);
    // The proven bound grows with |w| max W / rest_speed; this backstop is far above anything seen, and
    // plastic.
    if (round > 2000 * (contacts + 50)) {
      result.status = SolveStatus::Inexact;
      break;
    }
  }
  return x;
}

}  // namespace

ImpactResult apply_reflections(const ImpactProblem& problem) {
  const IslandSystem& system = problem.system;
  ImpactResult result;
  result.lambda.assign(system.rows.size(), 0);

  double e_min = 1, e_max = 0;
  for (const int i : rows_of(system, RowKind::Normal)) {
    e_min = std::min(e_min, problem.restitution[i]);
    e_max = std::max(e_max, problem.restitution[i]);
  }

  // Elastic answer, unless nothing bounces.
  std::vector<double> elastic(system.rows.size(), 0);
  Velocities y = problem.velocity;
  if (e_max > 0) y = reflect(problem, elastic, result);

  if (e_min >= 1 && result.locked == 0 && result.status == SolveStatus::Solved) {
    result.lambda = elastic;
  } else {
    const std::vector<int> rows = unilateral_rows(system);
    const std::vector<double> plastic = unilateral(problem, rows, problem.velocity, {}, result);
    Velocities stopped = problem.velocity;
    std::vector<double> plastic_all(system.rows.size(), 0);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      plastic_all[rows[k]] = plastic[k];
      apply_row(system, rows[k], plastic[k], stopped);
    }

    y = problem.velocity;
    for (const int i : rows) {
      // Joints pass on what the contacts around them do; their share is fixed by the projection below.
      const double e = system.rows[i].kind == RowKind::Normal ? problem.restitution[i] : e_max;
      result.lambda[i] = (1 - e) * plastic_all[i] + e * elastic[i];
      apply_row(system, i, result.lambda[i], y);
    }
    bool projected = false;
    for (const int i : rows) {
      const double u = row_velocity(problem, i, y);
      const bool joint = system.rows[i].kind == RowKind::Joint;
      if (joint ? std::abs(u) > 1e-13 : u < -problem.rest_speed) projected = true;
    }
    if (projected) {
      const std::vector<double> rest = unilateral(problem, rows, y, {}, result);
      for (std::size_t k = 0; k < rows.size(); ++k) {
        apply_row(system, rows[k], rest[k], y);
        result.lambda[rows[k]] += rest[k];
      }
    }

    // Energy between the plastic and the given one, in the share that the largest e allows; else drawn back.
    if (ground_at_rest(problem)) {
      const double before = kinetic_energy(system, problem.velocity);
      const double lowest = kinetic_energy(system, stopped);
      const double allowed = lowest + e_max * (before - lowest);
      if (kinetic_energy(system, y) > allowed * (1 + 1e-14)) {
        // Largest s in [0, 1] with E(stopped + s (y - stopped)) = allowed.
        Velocities d = y;
        double linear = 0;
        for (std::size_t k = 0; k < d.size(); ++k) {
          for (int c = 0; c < 3; ++c) {
            d[k][c] -= stopped[k][c];
            const double inverse = c < 2 ? system.bodies[k].linear : system.bodies[k].angular;
            if (inverse > 0) linear += stopped[k][c] * d[k][c] / inverse;
          }
        }
        const double square = kinetic_energy(system, d);
        const double rest = lowest - allowed;
        const double root = std::sqrt(std::max(0.0, linear * linear - 4 * square * rest));
        const double s = std::clamp((root - linear) / (2 * square), 0.0, 1.0);
        for (std::size_t k = 0; k < y.size(); ++k) {
          for (int c = 0; c < 3; ++c) y[k][c] = stopped[k][c] + s * d[k][c];
        }
        for (const int i : rows) result.lambda[i] = plastic_all[i] + s * (result.lambda[i] - plastic_all[i]);
        result.energy_limited = true;
      }
    }
  }
  result.velocity = std::move(y);
  add_friction(problem, result);
  return result;
}

}  // namespace skerry::impact
