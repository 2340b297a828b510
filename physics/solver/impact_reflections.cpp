// SPDX-License-Identifier: MIT
//
// Generalised reflections: contacts act while they approach [Smith, Kaufman, Vouga, Tamstorf & Grinspun
// 2012].
//
//   x = v, joints holding
//   while the set A of approaching contacts is not empty:
//     lambda = argmin |x + M^-1 J_A' lambda|_M, lambda >= 0       (joints hold meanwhile)
//     x += 2 M^-1 J_A' lambda                                     (a mirror image: energy is kept)
//
// This is the elastic answer, with normal impulses L1. L0 are those of the plastic one, e = 0, which is
// Coulomb's problem with normals and friction solved together: a corner that friction lifts off does not
// push, so a rocking block goes over to its other corner [Housner 1963]. Contacts with restitution e take (1
// - e) L0 + e L1 and friction within mu times that, as much as dissipates most; what still approaches is
// stopped plastically.
//
// Energy never grows with one e for all: (1 - e) and e times the friction of both answers is allowed, and
// gives the mean of two velocities of which neither has gained; the friction that dissipates most ends below.
// With different e the answer is drawn towards the plastic one where it would gain.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "physics/solver/impact_laws.h"
#include "physics/solver/impact_tools.h"
#include "physics/spare.h"

namespace skerry::impact {
namespace {

// Residual of Coulomb's problem up to which an answer is taken that is not solved.
constexpr double kNearly = 1e-4;
// Where Coulomb's problem has no answer, what is left is so many times as fast as what moves at most.
constexpr double kJam = 4;
// Energy that an elastic phase may have on its way, in that of one bounce.
constexpr double kOnTheWay = 4;
// Visits a row for the question whether contacts can open.
constexpr double kOpeningWork = 3000;

/// Rows of one kind by body, one body after the other.
struct RowsOfBodies {
  std::vector<int> first, rows;

  void assign(const IslandSystem& system, RowKind kind) {
    first.assign(system.bodies.size() + 1, 0);
    each(system, kind, [&](int body, int) { ++first[body + 1]; });
    for (std::size_t k = 1; k < first.size(); ++k) first[k] += first[k - 1];
    rows.resize(first.back());
    each(system, kind, [&](int body, int row) { rows[first[body]++] = row; });
    // Each start has become the next one's.
    for (std::size_t k = first.size() - 1; k > 0; --k) first[k] = first[k - 1];
    first[0] = 0;
  }
  std::span<const int> of(int body) const {
    return std::span(rows).subspan(first[body], first[body + 1] - first[body]);
  }

 private:
  template <class F>
  static void each(const IslandSystem& system, RowKind kind, F&& f) {
    for (int i = 0; i < system.size(); ++i) {
      const Row& row = system.rows[i];
      if (row.kind != kind) continue;
      if (row.a >= 0) f(row.a, i);
      if (row.b >= 0) f(row.b, i);
    }
  }
};

/// What an elastic phase needs for a moment.
struct ReflectionVectors {
  RowsOfBodies normals, joints;
  std::vector<int> row_mark, body_mark;
  std::vector<std::uint8_t> active, locked;
  std::vector<double> recent;
  std::vector<int> candidates, approaching, rows, bodies, touched;
};

/// Which rows touch which body, and the walk from an approaching contact to all that must be solved with it.
class Neighbourhood {
 public:
  Neighbourhood(const IslandSystem& system, ReflectionVectors& vectors)
      : system_(system),
        normals_(vectors.normals),
        joints_(vectors.joints),
        row_mark_(vectors.row_mark),
        body_mark_(vectors.body_mark) {
    normals_.assign(system, RowKind::Normal);
    joints_.assign(system, RowKind::Joint);
    row_mark_.assign(system.rows.size(), 0);
    body_mark_.assign(system.bodies.size(), 0);
  }

  std::span<const int> normals(int body) const { return normals_.of(body); }

  /// The component of `seed` in the set `active` of contacts (1 for each row in it); joints of the bodies met
  /// belong to it. Rows ascend; a row is reported once per `round`.
  void component(int seed, const std::vector<std::uint8_t>& active, int round, std::vector<int>& rows,
                 std::vector<int>& bodies) {
    rows.clear();
    bodies.clear();
    visit_row(seed, round, rows, bodies);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      for (const int i : normals_.of(bodies[k])) {
        if (active[i] && row_mark_[i] != round) visit_row(i, round, rows, bodies);
      }
      for (const int i : joints_.of(bodies[k])) {
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
  RowsOfBodies &normals_, &joints_;
  std::vector<int>&row_mark_, &body_mark_;
};

/// Could all contacts open at once? True when some motion w has J w >= 1 for every contact and J w = 0 for
/// every joint; its least-energy form is a complementarity problem that has a solution exactly then.
/// @param work  what it cost is added to it
bool can_all_open(const ImpactProblem& problem, SolveWork& work) {
  ImpactResult scratch;
  const std::vector<int> rows = unilateral_rows(problem.system);
  std::vector<double> targets(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    targets[k] = problem.system.rows[rows[k]].kind == RowKind::Normal ? 1 : 0;
  }
  ImpactProblem still = problem;
  std::fill(still.drive.begin(), still.drive.end(), 0);
  // Where there is none, the search for it would take all the work there is.
  const double enough = kOpeningWork * static_cast<double>(rows.size());
  if (!(still.work_limit > 0 && still.work_limit < enough)) still.work_limit = enough;
  const Velocities rest(problem.velocity.size(), {0, 0, 0});
  const std::vector<double> lambda = unilateral(still, rows, rest, targets, scratch);
  work += scratch.work;
  Velocities w = rest;
  for (std::size_t k = 0; k < rows.size(); ++k) apply_row(problem.system, rows[k], lambda[k], w);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double u = row_velocity(still, rows[k], w);
    if (std::abs(targets[k]) > 0 ? u < 0.5 : std::abs(u) > 0.5) return false;
  }
  return true;
}

/// Takes out what these joint rows are off by. A mirror image would keep it with the other sign, and contacts
/// that it makes approach would do so in every round.
void hold_joints(const ImpactProblem& problem, const std::vector<int>& joints, Velocities& x,
                 std::vector<double>& lambda, ImpactResult& result) {
  if (joints.empty()) return;
  std::vector<double> impulses = unilateral(problem, joints, x, {}, result);
  for (std::size_t k = 0; k < joints.size(); ++k) {
    apply_row(problem.system, joints[k], impulses[k], x);
    lambda[joints[k]] += impulses[k];
  }
  give_spare(std::move(impulses));
}

bool has_run_away(const ImpactProblem& problem, const Velocities& x, double most,
                  const ImpactResult& result) {
  return result.residual > kContradiction || kinetic_energy(problem.system, x) > most;
}

/// Whether something that is told to move squeezes bodies: no velocities end all approach and hold all
/// joints, though those of each contact alone do, and mirror images, or stops, go to and fro between them.
bool is_squeezed(const ImpactProblem& problem, const Velocities& x, ImpactResult& result) {
  if (ground_at_rest(problem)) return false;
  unilateral(problem, unilateral_rows(problem.system), x, {}, result);
  return result.residual > kContradiction;
}

/// The elastic phase. Returns x, adds to `lambda`; contacts that cannot open are locked (they stop
/// plastically). What approaches when the work is spent still does so. Nothing where bodies are squeezed:
/// with more than `most` energy or contacts that contradict each other, by ground that moves; with rows that
/// still do so after many rounds, by joints; or may be, when the work is spent.
std::optional<Velocities> reflect(const ImpactProblem& problem, double most, std::vector<double>& lambda,
                                  ImpactResult& result) {
  const IslandSystem& system = problem.system;
  Spare<ReflectionVectors> vectors;
  Neighbourhood near(system, *vectors);
  Velocities x = take_spare<Velocities>();
  x = problem.velocity;
  hold_joints(problem, rows_of(system, RowKind::Joint), x, lambda, result);
  std::vector<std::uint8_t>&active = vectors->active, &locked = vectors->locked;
  active.assign(system.rows.size(), 0);
  locked.assign(system.rows.size(), 0);

  double fastest = 0;
  std::vector<int>& candidates = vectors->candidates;
  candidates.clear();
  for (int i = 0; i < system.size(); ++i) {
    if (system.rows[i].kind == RowKind::Normal) candidates.push_back(i);
  }
  for (const int i : candidates) fastest = std::max(fastest, std::abs(row_velocity(problem, i, x)));
  // A check for jammed contacts is due when the count is beyond what free contacts take and momentum has
  // piled up.
  const int contacts = static_cast<int>(candidates.size());
  const int first_check = 4 * contacts + 50;
  int next_check = first_check;
  std::optional<bool> separable;
  std::vector<double>& recent = vectors->recent;
  recent.assign(system.rows.size(), 0);

  // Work besides what the sub-problems book, of which the smallest are formulas: rows that were looked at.
  double looked = 0;

  std::vector<int>&approaching = vectors->approaching, &rows = vectors->rows, &bodies = vectors->bodies,
  &touched = vectors->touched;
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
      std::vector<double> impulses = unilateral(problem, rows, x, {}, result);
      looked += static_cast<double>(rows.size());
      bool stops = false;
      for (std::size_t k = 0; k < rows.size(); ++k) {
        const int i = rows[k];
        stops |= locked[i] != 0;
        const double impulse = (locked[i] ? 1.0 : 2.0) * impulses[k];
        if (impulse == 0) continue;
        apply_row(system, i, impulse, x);
        lambda[i] += impulse;
        recent[i] += std::abs(impulse);
      }
      give_spare(std::move(impulses));
      if (stops) {
        // Where some rows stop, what is mirrored with them no longer fits the joints between.
        std::erase_if(rows, [&](int i) { return system.rows[i].kind != RowKind::Joint; });
        hold_joints(problem, rows, x, lambda, result);
      }
      touched.insert(touched.end(), bodies.begin(), bodies.end());
      ++result.reflections;
    }
    for (const int i : approaching) active[i] = 0;
    if (most < kInfinity && has_run_away(problem, x, most, result)) return {};

    // Only contacts of bodies whose velocity changed can have begun to approach.
    candidates.clear();
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    for (const int body : touched) {
      candidates.insert(candidates.end(), near.normals(body).begin(), near.normals(body).end());
    }
    std::sort(candidates.begin(), candidates.end());
    candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());

    looked += static_cast<double>(candidates.size());
    if (problem.most_work > 0 && result.work.visits + looked > problem.most_work) {
      result.work.visits += looked;
      result.status = SolveStatus::Inexact;
      if (!ground_at_rest(problem)) return {};
      break;
    }

    if (round < next_check) continue;
    if (result.residual > kContradiction) return {};
    next_check = round + first_check;
    // Places do not change in an impact.
    if (!separable) {
      separable = can_all_open(problem, result.work);
      if (!*separable && is_squeezed(problem, x, result)) return {};
    }
    if (!*separable) {
      // Balls wedged between walls would bounce for ever: contacts that carried the most lose their
      // elasticity.
      double largest = 0;
      for (const int i : rows_of(system, RowKind::Normal))
        largest = std::max(largest, recent[i] * std::sqrt(inverse_mass(system, i)));
      for (const int i : rows_of(system, RowKind::Normal)) {
        if (!locked[i] && recent[i] * std::sqrt(inverse_mass(system, i)) > 1e-3 * largest) {
          locked[i] = 1;
          ++result.locked;
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

/// Velocities and impulses of all rows without restitution.
struct Plastic {
  std::vector<double> lambda;
  Velocities velocity;
};

/// How far impulses are from Coulomb's law without restitution: the natural map, relative to the largest
/// wanted change of velocity.
double violation(const ImpactProblem& problem, const std::vector<double>& lambda) {
  Spare<IslandSystem> plastic;
  *plastic = problem.system;
  plastic->b.resize(plastic->rows.size());
  for (int i = 0; i < plastic->size(); ++i) plastic->b[i] = -row_velocity(problem, i, problem.velocity);
  return natural_map_residual(*plastic, lambda);
}

/// What is jammed between bodies that are told to move can go nowhere, and without its friction would be shot
/// out at any speed: the impulses that came nearest to Coulomb's law, which leave some approach, or as much
/// of them as brings no more energy than those bodies may.
void stay(const ImpactProblem& problem, Plastic& nearest, ImpactResult& result) {
  const IslandSystem& system = problem.system;
  const double most = most_of_push(problem, kJam);
  const std::vector<double> all = nearest.lambda;
  double share = 1;
  do {
    nearest.velocity = problem.velocity;
    for (int i = 0; i < system.size(); ++i) {
      nearest.lambda[i] = share * all[i];
      apply_row(system, i, nearest.lambda[i], nearest.velocity);
    }
    share *= 0.5;
  } while (!(kinetic_energy(system, nearest.velocity) <= most) && share > 1e-300);
  result.residual = std::max(result.residual, violation(problem, nearest.lambda));
  result.status = SolveStatus::Inexact;
}

Plastic stop(const ImpactProblem& problem, ImpactResult& result) {
  Plastic out;
  out.velocity = problem.velocity;
  const bool rough = std::any_of(problem.system.rows.begin(), problem.system.rows.end(),
                                 [](const Row& row) { return row.mu > 0; });
  if (rough && coulomb(problem, out.velocity, out.lambda, result)) return out;
  // What work without a limit came so near to is far nearer than what follows.
  if (rough && problem.work_limit == 0) {
    const double left = violation(problem, out.lambda);
    if (left <= kNearly) {
      for (int i = 0; i < problem.system.size(); ++i)
        apply_row(problem.system, i, out.lambda[i], out.velocity);
      result.residual = std::max(result.residual, left);
      result.status = SolveStatus::Inexact;
      return out;
    }
  }

  // Without friction, or where Coulomb's problem could not be solved: normals alone, which always works, and
  // friction after them.
  ImpactResult normals;
  normals.velocity = problem.velocity;
  normals.lambda.assign(problem.system.rows.size(), 0);
  const std::vector<int> rows = unilateral_rows(problem.system);
  const std::vector<double> lambda = unilateral(problem, rows, problem.velocity, {}, result);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    normals.lambda[rows[k]] = lambda[k];
    apply_row(problem.system, rows[k], lambda[k], normals.velocity);
  }
  double left = 0;
  bool jams = false;
  if (rough) {
    normals.work = result.work;
    add_friction(problem, normals);
    result.work = normals.work;
    left = violation(problem, normals.lambda);
    jams = !ground_at_rest(problem) && violation(problem, out.lambda) < left;
  }
  if (jams ||
      kinetic_energy(problem.system, normals.velocity) > most_of_push(problem, rough ? kJam : kWedge)) {
    if (!rough) out.lambda = std::move(normals.lambda);
    stay(problem, out, result);
    return out;
  }
  if (rough) {
    result.residual = std::max(result.residual, left);
    result.status = SolveStatus::Inexact;
  }
  out.lambda = std::move(normals.lambda);
  out.velocity = std::move(normals.velocity);
  return out;
}

/// Draws the answer towards the plastic one until it keeps the share of the energy that the largest e allows,
/// as seen from ground that moves.
void limit_energy(const ImpactProblem& problem, const Plastic& plastic, double e_max, ImpactResult& result) {
  const IslandSystem& system = problem.system;
  const double before = kinetic_energy(system, problem.velocity);
  const double lowest = energy_but_for_ground(problem, plastic.velocity, plastic.lambda);
  const double allowed = lowest + e_max * (before - lowest);
  const double rounding = 1e-14 * (std::abs(lowest) + e_max * std::abs(before - lowest));
  if (energy_but_for_ground(problem, result.velocity, result.lambda) <= allowed + rounding) return;
  // Largest s in [0, 1] with E(v0 + s (v - v0)) = allowed.
  Velocities d = result.velocity;
  double linear = 0;
  for (std::size_t i = 0; i < result.lambda.size(); ++i)
    linear += problem.drive[i] * (result.lambda[i] - plastic.lambda[i]);
  for (std::size_t k = 0; k < d.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      d[k][c] -= plastic.velocity[k][c];
      const double inverse = c < 2 ? system.bodies[k].linear : system.bodies[k].angular;
      if (inverse > 0) linear += plastic.velocity[k][c] * d[k][c] / inverse;
    }
  }
  const double square = kinetic_energy(system, d);
  const double root = std::sqrt(std::max(0.0, linear * linear - 4 * square * (lowest - allowed)));
  const double s = square > 0 ? std::clamp((root - linear) / (2 * square), 0.0, 1.0) : 0;
  for (std::size_t k = 0; k < d.size(); ++k) {
    for (std::size_t c = 0; c < 3; ++c) result.velocity[k][c] = plastic.velocity[k][c] + s * d[k][c];
  }
  for (std::size_t i = 0; i < result.lambda.size(); ++i)
    result.lambda[i] = plastic.lambda[i] + s * (result.lambda[i] - plastic.lambda[i]);
  result.energy_limited = true;
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

  // Elastic answer, unless nothing bounces; plastic one, unless everything does.
  std::vector<double> elastic(system.rows.size(), 0);
  if (e_max > 0) {
    const double most = kOnTheWay * most_of_bounce(problem);
    std::optional<Velocities> x = reflect(problem, most, elastic, result);
    if (!x) {
      // What is squeezed does not bounce.
      e_max = 0;
    } else if (e_min >= 1 && result.locked == 0 && result.status == SolveStatus::Solved) {
      result.lambda = std::move(elastic);
      result.velocity = std::move(*x);
      add_friction(problem, result);
      return result;
    }
  }
  Plastic plastic = stop(problem, result);
  if (!(e_max > 0)) {
    result.lambda = std::move(plastic.lambda);
    result.velocity = std::move(plastic.velocity);
    return result;
  }

  result.velocity = problem.velocity;
  const std::vector<int> rows = unilateral_rows(system);
  for (const int i : rows) {
    // Joints pass on what the contacts around them do; what is left of their share is solved for below.
    const double e = system.rows[i].kind == RowKind::Normal ? problem.restitution[i] : e_max;
    result.lambda[i] = (1 - e) * plastic.lambda[i] + e * elastic[i];
    apply_row(system, i, result.lambda[i], result.velocity);
  }
  add_friction(problem, result);
  end_approach(problem, result);
  limit_energy(problem, plastic, e_max, result);
  return result;
}

}  // namespace skerry::impact
