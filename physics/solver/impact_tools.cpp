// SPDX-License-Identifier: MIT
#include "physics/solver/impact_tools.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "physics/spare.h"

namespace skerry::impact {
namespace {

constexpr double kTolerance = 1e-13;
// Some answers of a thousand rows are as good as 1e-12, and no better: they are taken.
constexpr double kGoodEnough = 1e-11;
constexpr int kFewRows = 100;
// Where work has no limit, a problem of many rows has this much for the tolerance (the default of a world, so
// that scenes that need less have the same bits), and the rest for what is good enough.
constexpr double kFirstLook = 1e8;
// Rows that contradict each other give by so much of their own part of W, so that the impulses are bounded.
constexpr double kGive = 1e-2;
// What rounding may add to an energy.
constexpr double kRounding = 1e-9;

/// Tolerance, and what is left of the work; a sixteenth of it at least, so that every sub-problem is looked
/// at. @param spent  visits so far
SolveOptions options_of(const ImpactProblem& problem, double spent) {
  SolveOptions options;
  options.tolerance = kTolerance;
  options.welds_as_one = problem.welds_as_one;
  options.threads = problem.threads;
  if (problem.work_limit > 0)
    options.work_limit = std::max(problem.work_limit / 16, problem.work_limit - spent);
  return options;
}

/// Solves `system`: within what is left of the work, or, without a limit, as well as it can be had.
Solution answer(const ImpactProblem& problem, const IslandSystem& system, const ImpactResult& result) {
  SolveOptions options = options_of(problem, result.work.visits);
  if (problem.work_limit > 0 || system.size() <= kFewRows)
    return problem.solver->solve(system, {}, options, nullptr);
  options.work_limit = kFirstLook;
  Solution first = problem.solver->solve(system, {}, options, nullptr);
  if (first.status == SolveStatus::Solved || first.residual <= kGoodEnough) return first;
  options.work_limit = 0;
  options.tolerance = kGoodEnough;
  Solution second = problem.solver->solve(system, {}, options, nullptr);
  second.work += first.work;
  return second;
}

void clear(IslandSystem& system) {
  system.bodies.clear();
  system.positions.clear();
  system.rows.clear();
  system.b.clear();
  system.compliance.clear();
}

/// Impulses of rows that give, where there are none of rigid ones.
void give_way(const ImpactProblem& problem, IslandSystem& system, const ImpactResult& result,
              Solution& solution) {
  if (solution.status == SolveStatus::Solved || !(solution.residual > kContradiction)) return;
  system.compliance.resize(system.rows.size());
  for (int i = 0; i < system.size(); ++i) system.compliance[i] = kGive * inverse_mass(system, i);
  const double spent = result.work.visits + solution.work.visits;
  Solution other = problem.solver->solve(system, {}, options_of(problem, spent), nullptr);
  solution.work += other.work;
  solution.lambda = std::move(other.lambda);
}

/// Whether all that a sub-system is to change is rounding beside what approaches: a residual relative to that
/// says nothing.
bool is_of_rounding(const ImpactProblem& problem, const IslandSystem& system) {
  constexpr double kNothing = 1e-12;
  double wanted = 0, fastest = 0;
  for (const double b : system.b) wanted = std::max(wanted, std::abs(b));
  for (int i = 0; i < problem.system.size(); ++i)
    fastest = std::max(fastest, std::abs(row_velocity(problem, i, problem.velocity)));
  return wanted <= kNothing * fastest;
}

/// Solves the sub-system and books its work, status and residual.
std::vector<double> solve(const ImpactProblem& problem, IslandSystem& system, ImpactResult& result) {
  Solution solution = answer(problem, system, result);
  give_way(problem, system, result, solution);
  result.work += solution.work;
  if (solution.status == SolveStatus::Solved || !is_of_rounding(problem, system)) {
    result.residual = std::max(result.residual, solution.residual);
    if (result.status == SolveStatus::Solved) result.status = solution.status;
  }
  return std::move(solution.lambda);
}

}  // namespace

double row_velocity(const ImpactProblem& problem, int i, const Velocities& v) {
  const Row& row = problem.system.rows[i];
  double u = problem.drive[i];
  if (row.a >= 0) u += along(row.Ja, v[row.a]);
  if (row.b >= 0) u += along(row.Jb, v[row.b]);
  return u;
}

void apply_row(const IslandSystem& system, int i, double impulse, Velocities& v) {
  const Row& row = system.rows[i];
  if (row.a >= 0) push(system.bodies[row.a], row.Ja, impulse, v[row.a]);
  if (row.b >= 0) push(system.bodies[row.b], row.Jb, impulse, v[row.b]);
}

double inverse_mass(const IslandSystem& system, int i) {
  const Row& row = system.rows[i];
  double w = 0;
  if (row.a >= 0) w += inverse_mass_along(system.bodies[row.a], row.Ja);
  if (row.b >= 0) w += inverse_mass_along(system.bodies[row.b], row.Jb);
  return w;
}

double kinetic_energy(const IslandSystem& system, const Velocities& v) {
  double energy = 0;
  for (std::size_t k = 0; k < v.size(); ++k) {
    const InverseMass& mass = system.bodies[k];
    if (mass.linear > 0) energy += 0.5 * (v[k][0] * v[k][0] + v[k][1] * v[k][1]) / mass.linear;
    if (mass.angular > 0) energy += 0.5 * v[k][2] * v[k][2] / mass.angular;
  }
  return energy;
}

double energy_but_for_ground(const ImpactProblem& problem, const Velocities& v,
                             const std::vector<double>& lambda) {
  return kinetic_energy(problem.system, v) +
         std::inner_product(lambda.begin(), lambda.end(), problem.drive.begin(), 0.0);
}

bool ground_at_rest(const ImpactProblem& problem) {
  return std::all_of(problem.drive.begin(), problem.drive.end(), [](double u) { return u == 0; });
}

namespace {

/// Fastest that ground comes or goes [m/s].
double fastest_drive(const ImpactProblem& problem) {
  double fastest = 0;
  for (int i = 0; i < problem.system.size(); ++i) {
    if (problem.system.rows[i].kind == RowKind::Normal)
      fastest = std::max(fastest, std::abs(problem.drive[i]));
  }
  return fastest;
}

/// Energy of the bodies if all of them had that speed [J].
double energy_at(const ImpactProblem& problem, double speed) {
  return kinetic_energy(problem.system, Velocities(problem.velocity.size(), {speed, 0, 0}));
}

/// Energy of the least motion that goes with joints and with ground that comes or goes [J]; 0 without joints,
/// and where there is none.
double energy_of_hinged(const ImpactProblem& problem) {
  if (rows_of(problem.system, RowKind::Joint).empty()) return 0;
  const std::vector<int> rows = unilateral_rows(problem.system);
  Velocities v(problem.velocity.size(), {0, 0, 0});
  ImpactResult along;
  const std::vector<double> lambda = unilateral(problem, rows, v, {}, along);
  if (along.status != SolveStatus::Solved) return 0;
  for (std::size_t k = 0; k < rows.size(); ++k) apply_row(problem.system, rows[k], lambda[k], v);
  return kinetic_energy(problem.system, v);
}

/// The most that bodies of some energy have when ground turned them round, or took them along [J]: in its
/// frame they stay as fast as they were. @param of_ground  the energy that they would have at its speed [J]
double turned_round(double energy, double of_ground) {
  const double root = std::sqrt(energy) + 2 * std::sqrt(of_ground);
  return root * root;
}

/// Energy of the bodies if all of them were as fast as the fastest ground; 0 where none comes or goes [J].
double energy_of_ground(const ImpactProblem& problem) {
  const double drive = fastest_drive(problem);
  return drive == 0 ? 0 : energy_at(problem, std::max(drive, problem.ground_speed));
}

/// What a bounce leaves at most: where nothing is lost it is all of that [J].
double bounce_off(const ImpactProblem& problem, double of_ground) {
  return (1 + kRounding) * turned_round(kinetic_energy(problem.system, problem.velocity), of_ground);
}

}  // namespace

double most_of_bounce(const ImpactProblem& problem) {
  const double ground = energy_of_ground(problem);
  if (ground == 0) return kInfinity;
  // What is hinged near where it is struck turns faster than the ground goes, within the reach of levers.
  return bounce_off(problem, std::clamp(energy_of_hinged(problem), ground, kWedge * kWedge * ground));
}

bool exceeds_bounce(const ImpactProblem& problem, const Velocities& v) {
  const double energy = kinetic_energy(problem.system, v), ground = energy_of_ground(problem);
  // The bound with hinges takes a solve, and is no less.
  const double least = ground == 0 ? kInfinity : bounce_off(problem, ground);
  return !(energy <= least) && !(energy <= most_of_bounce(problem));
}

double most_of_push(const ImpactProblem& problem, double times) {
  const double drive = fastest_drive(problem);
  if (drive == 0) return kInfinity;
  const double pushed =
      kinetic_energy(problem.system, problem.velocity) + times * times * energy_at(problem, drive);
  // Ground that comes slowly may go fast along itself.
  return problem.ground_speed > drive ? turned_round(pushed, energy_at(problem, problem.ground_speed))
                                      : pushed;
}

std::vector<double> unilateral(const ImpactProblem& problem, const std::vector<int>& rows,
                               const Velocities& v, const std::vector<double>& targets,
                               ImpactResult& result) {
  const auto wanted = [&](std::size_t k) {
    return (targets.empty() ? 0 : targets[k]) - row_velocity(problem, rows[k], v);
  };
  if (rows.size() == 1 && problem.system.rows[rows[0]].kind == RowKind::Normal) {
    const double w = inverse_mass(problem.system, rows[0]);
    return {w > 0 ? std::max(0.0, wanted(0) / w) : 0.0};
  }

  // The bodies of these rows, renumbered in ascending order.
  Spare<std::vector<int>> spare_bodies;
  std::vector<int>& bodies = *spare_bodies;
  for (const int i : rows) {
    for (const int body : {problem.system.rows[i].a, problem.system.rows[i].b}) {
      if (body >= 0) bodies.push_back(body);
    }
  }
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  const auto local = [&bodies](int body) {
    return body < 0 ? -1
                    : static_cast<int>(std::lower_bound(bodies.begin(), bodies.end(), body) - bodies.begin());
  };

  Spare<IslandSystem> spare;
  IslandSystem& sub = *spare;
  clear(sub);
  for (const int body : bodies) {
    sub.bodies.push_back(problem.system.bodies[body]);
    if (!problem.system.positions.empty()) sub.positions.push_back(problem.system.positions[body]);
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Row row = problem.system.rows[rows[k]];
    row.a = local(row.a);
    row.b = local(row.b);
    sub.rows.push_back(row);
    sub.b.push_back(wanted(k));
  }
  return solve(problem, sub, result);
}

void add_friction(const ImpactProblem& problem, ImpactResult& result) {
  // Normal impulses are known now, so friction is a box-constrained least-energy problem: always solvable,
  // unique in velocities, and it can only take energy away.
  Spare<IslandSystem> spare;
  IslandSystem& tangential = *spare;
  clear(tangential);
  tangential.bodies = problem.system.bodies;
  tangential.positions = problem.system.positions;
  Spare<std::vector<int>> spare_rows;
  std::vector<int>& rows = *spare_rows;
  for (int i = 0; i < problem.system.size(); ++i) {
    Row row = problem.system.rows[i];
    if (row.kind == RowKind::Friction || row.kind == RowKind::Rolling) {
      const double limit = row.mu * result.lambda[row.normal];
      if (!(limit > 0)) continue;
      row.kind = RowKind::Motor;
      row.lower = -limit;
      row.upper = limit;
      row.normal = -1;
    } else if (row.kind != RowKind::Joint) {
      continue;
    }
    rows.push_back(i);
    tangential.rows.push_back(row);
    tangential.b.push_back(-row_velocity(problem, i, result.velocity));
  }
  const bool any = std::any_of(tangential.rows.begin(), tangential.rows.end(),
                               [](const Row& row) { return row.kind == RowKind::Motor; });
  if (!any) return;
  std::vector<double> p = solve(problem, tangential, result);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    apply_row(problem.system, rows[k], p[k], result.velocity);
    result.lambda[rows[k]] += p[k];
  }
  give_spare(std::move(p));

  // Friction may have turned a body into a contact: one plastic Coulomb solve over everything ends the
  // approach.
  double worst = 0;
  for (int i = 0; i < problem.system.size(); ++i) {
    if (problem.system.rows[i].kind == RowKind::Normal) {
      worst = std::min(worst, row_velocity(problem, i, result.velocity));
    }
  }
  if (worst > -problem.rest_speed) return;
  std::vector<double> q;
  if (!coulomb(problem, result.velocity, q, result)) return end_approach(problem, result);
  for (std::size_t i = 0; i < q.size(); ++i) result.lambda[i] += q[i];
}

void end_approach(const ImpactProblem& problem, ImpactResult& result) {
  const std::vector<int> rows = unilateral_rows(problem.system);
  const bool bad = std::any_of(rows.begin(), rows.end(), [&](int i) {
    const double u = row_velocity(problem, i, result.velocity);
    return problem.system.rows[i].kind == RowKind::Joint ? std::abs(u) > 1e-13 : u < -problem.rest_speed;
  });
  if (!bad) return;
  const std::vector<double> rest = unilateral(problem, rows, result.velocity, {}, result);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    apply_row(problem.system, rows[k], rest[k], result.velocity);
    result.lambda[rows[k]] += rest[k];
  }
}

bool coulomb(const ImpactProblem& problem, Velocities& v, std::vector<double>& lambda, ImpactResult& result) {
  Spare<IslandSystem> spare;
  IslandSystem& plastic = *spare;
  plastic = problem.system;
  plastic.b.resize(plastic.rows.size());
  for (int i = 0; i < plastic.size(); ++i) plastic.b[i] = -row_velocity(problem, i, v);
  Solution solution = answer(problem, plastic, result);
  result.work += solution.work;
  lambda = std::move(solution.lambda);
  if (solution.status != SolveStatus::Solved && !(solution.residual <= kGoodEnough)) return false;
  result.residual = std::max(result.residual, solution.residual);
  for (int i = 0; i < plastic.size(); ++i) apply_row(problem.system, i, lambda[i], v);
  return true;
}

std::vector<int> rows_of(const IslandSystem& system, RowKind kind) {
  std::vector<int> rows;
  for (int i = 0; i < system.size(); ++i) {
    if (system.rows[i].kind == kind) rows.push_back(i);
  }
  return rows;
}

std::vector<int> unilateral_rows(const IslandSystem& system) {
  std::vector<int> rows;
  for (int i = 0; i < system.size(); ++i) {
    if (system.rows[i].kind == RowKind::Normal || system.rows[i].kind == RowKind::Joint) rows.push_back(i);
  }
  return rows;
}

}  // namespace skerry::impact
