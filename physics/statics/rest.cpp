// SPDX-License-Identifier: MIT
#include "physics/statics/rest.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/disjoint_sets.h"
#include "physics/solver/solver.h"
#include "physics/statics/null_space.h"
#include "physics/statics/rest_rows.h"
#include "physics/text.h"

namespace skerry::statics {
namespace {

// Forces and accelerations below these shares of the largest are rounding.
constexpr double kCarries = 1e-10;
constexpr double kMoves = 1e-7;
// The last step's forces count as those of this moment where they leave this share of the accelerations: a
// step at rest is exact to 1e-10, one of a moving world is far from it.
constexpr double kLastStep = 1e-6;
// Residual of solves, and up to which forces of the last step are solved as they are.
constexpr double kTolerance = 1e-13, kSolved = 1e-11;
// Entries of a null vector below this share of its largest are zero.
constexpr double kPartOf = 1e-8;

/// Rows that carry, or may, at no load: a contact that opens cannot, whatever the others do.
std::vector<int> carrying_rows(const RestAnalysis& rest, const std::vector<double>& w) {
  double largest = 0;
  for (const double force : rest.lambda) largest = std::max(largest, std::abs(force));
  std::vector<int> rows;
  for (int i = 0; i < rest.system.size(); ++i) {
    const Row& row = rest.system.rows[static_cast<std::size_t>(i)];
    const auto normal = static_cast<std::size_t>(row.normal >= 0 ? row.normal : i);
    const bool one_sided = row.kind == RowKind::Normal || row.kind == RowKind::Limit || row.normal >= 0;
    const bool opens =
        one_sided && rest.lambda[normal] <= kCarries * largest && w[normal] > kMoves * (1 + w[normal]);
    if (!opens) rows.push_back(i);
  }
  return rows;
}

/// Groups of rows that share bodies, in the order of their first rows.
std::vector<std::vector<int>> connected(const IslandSystem& system, const std::vector<int>& rows) {
  DisjointSets sets(system.bodies.size());
  for (const int i : rows) {
    const Row& row = system.rows[static_cast<std::size_t>(i)];
    if (row.a >= 0 && row.b >= 0) sets.join(row.a, row.b);
  }
  std::vector<int> group_of(system.bodies.size(), -1);
  std::vector<std::vector<int>> groups;
  for (const int i : rows) {
    const Row& row = system.rows[static_cast<std::size_t>(i)];
    int& group = group_of[static_cast<std::size_t>(sets.root(row.a >= 0 ? row.a : row.b))];
    if (group < 0) {
      group = static_cast<int>(groups.size());
      groups.emplace_back();
    }
    groups[static_cast<std::size_t>(group)].push_back(i);
  }
  return groups;
}

/// The null vectors of J' over `rows` are self-stress states: what they touch is not unique.
void find_uniqueness(RestAnalysis& out, const std::vector<int>& rows) {
  const IslandSystem& system = out.system;
  out.unique.assign(system.rows.size(), 1);
  out.pair_unique.assign(out.contacts.empty() ? 0 : static_cast<std::size_t>(out.contacts.back().pair) + 1,
                         1);
  out.indeterminacy = 0;
  std::vector<int> pair_of(system.rows.size(), -1), local(system.bodies.size(), -1);
  for (std::size_t k = 0; k < out.contacts.size(); ++k) {
    const std::size_t end =
        k + 1 < out.contacts.size() ? static_cast<std::size_t>(out.contacts[k + 1].row) : system.rows.size();
    for (auto i = static_cast<std::size_t>(out.contacts[k].row); i < end; ++i)
      pair_of[i] = out.contacts[k].pair;
  }
  for (const std::vector<int>& group : connected(system, rows)) {
    int bodies = 0;
    std::vector<Entry> entries;
    std::vector<int> seen;
    for (std::size_t column = 0; column < group.size(); ++column) {
      const Row& row = system.rows[static_cast<std::size_t>(group[column])];
      const auto add = [&](int body, const std::array<double, 3>& J) {
        if (body < 0) return;
        int& number = local[static_cast<std::size_t>(body)];
        if (number < 0) {
          number = bodies++;
          seen.push_back(body);
        }
        for (int c = 0; c < 3; ++c) {
          if (J[static_cast<std::size_t>(c)] != 0)
            entries.push_back({3 * number + c, static_cast<int>(column), J[static_cast<std::size_t>(c)]});
        }
      };
      add(row.a, row.Ja);
      add(row.b, row.Jb);
    }
    for (const int body : seen) local[static_cast<std::size_t>(body)] = -1;
    const NullSpace space = null_space(3 * bodies, static_cast<int>(group.size()), entries, 1e-9);
    out.indeterminacy += static_cast<int>(space.basis.size());
    for (const std::vector<double>& z : space.basis) {
      // Points of a pair may trade forces as long as their resultant stays.
      std::array<double, 3> resultant{};
      for (std::size_t k = 0; k < group.size(); ++k) {
        const auto i = static_cast<std::size_t>(group[k]);
        if (std::abs(z[k]) > kPartOf) out.unique[i] = 0;
        const int pair = pair_of[i];
        if (pair < 0) continue;
        const Row& row = system.rows[i];
        const std::array<double, 3>& J = row.b >= 0 ? row.Jb : row.Ja;
        for (std::size_t c = 0; c < 3; ++c) resultant[c] += z[k] * J[c];
        if (k + 1 < group.size() && pair_of[static_cast<std::size_t>(group[k + 1])] == pair) continue;
        const double size =
            std::max({std::abs(resultant[0]), std::abs(resultant[1]), std::abs(resultant[2])});
        if (size > kPartOf) out.pair_unique[static_cast<std::size_t>(pair)] = 0;
        resultant = {};
      }
    }
  }
}

}  // namespace

double RestAnalysis::size(std::size_t body, const std::array<double, 3>& a) const {
  const InverseMass& m = system.bodies[body];
  const double arm = m.angular > 0 ? std::sqrt(m.linear / m.angular) : 0;
  return std::max(std::hypot(a[0], a[1]), arm * std::abs(a[2]));
}

struct RestSolver::State {
  RestOptions options;
  RestAnalysis out;
  RestRows rows;
  std::unique_ptr<SolverMemory> memory;
  std::vector<double> base;  // forces of the first load
  std::vector<int> carrying;
  std::vector<std::array<double, 2>> applied;  // magnitudes of the loads, as `RestRows::applied`
  SolveWork work;

  State(const World& world, const RestOptions& given) : options(given) {
    const SolverEntry& solver = find_solver(options.solver);
    rows = rest_rows(world, options, out);
    applied = rows.applied;
    set_load();
    std::vector<double> start;
    double tolerance = kTolerance;
    if (options.last_step && !rows.last_step.empty()) {
      const double residual = natural_map_residual(out.system, rows.last_step);
      if (residual <= kLastStep) {
        start = rows.last_step;
        out.from_last_step = true;
        // Of many answers it is to stay the one that it is.
        if (residual <= kSolved) tolerance = std::max(tolerance, 2 * residual);
      }
    }
    solve(solver, start, tolerance);
    base = out.lambda;
    finish();
  }

  /// b of the rows from the loads: what the accelerations without contacts lack.
  void set_load() {
    IslandSystem& system = out.system;
    out.acceleration.clear();
    for (std::size_t k = 0; k < out.bodies.size(); ++k) {
      const InverseMass& m = system.bodies[k];
      out.acceleration.push_back(
          {m.linear * out.load[k][0], m.linear * out.load[k][1], m.angular * out.load[k][2]});
    }
    system.b.clear();
    for (const Row& row : system.rows) {
      double a = 0;
      if (row.a >= 0) a += along(row.Ja, out.acceleration[static_cast<std::size_t>(row.a)]);
      if (row.b >= 0) a += along(row.Jb, out.acceleration[static_cast<std::size_t>(row.b)]);
      system.b.push_back(-a);
    }
  }

  /// @param tolerance  of the first try
  void solve(const SolverEntry& solver, const std::vector<double>& start, double tolerance = kTolerance) {
    bool known = true;
    for (RestContact& contact : out.contacts) known = set_friction(contact, contact.held_mu) && known;
    if (!known) memory.reset();
    solve_rows(solver, start, tolerance);
    // What slides is held by less; it may let others go. At most once a contact.
    while (let_slide()) {
      memory.reset();
      solve_rows(solver, out.lambda, kTolerance);
    }
  }

  void solve_rows(const SolverEntry& solver, const std::vector<double>& start, double tolerance) {
    out.residual = 0;
    Solution solution;
    if (out.system.size() > 0) {
      SolveOptions exact;
      exact.tolerance = tolerance;
      solution = solver.solve(out.system, start, exact, &memory);
      work += solution.work;
      out.residual = solution.residual;
    }
    out.lambda = std::move(solution.lambda);
    find_rounding();
  }

  /// @return whether it was so before
  bool set_friction(RestContact& contact, double mu) {
    if (contact.mu == mu) return true;
    contact.mu = mu;
    out.system.rows[static_cast<std::size_t>(contact.row) + 1].mu = mu;
    return false;
  }

  /// Gives contacts that begin to slide the friction of what slides, and forces within it. @return whether
  /// there were any
  bool let_slide() {
    bool any = false;
    std::vector<double> w;
    for (RestContact& contact : out.contacts) {
      if (!(contact.sliding_mu < contact.mu)) continue;
      const auto row = static_cast<std::size_t>(contact.row);
      const double most = contact.mu * out.lambda[row];
      if (!(most > 0) || std::abs(out.lambda[row + 1]) < most * (1 - kCarries)) continue;
      if (w.empty()) w = row_velocities(out.system, out.lambda);
      double rounding = 0;
      for (const int body : {out.system.rows[row].a, out.system.rows[row].b})
        if (body >= 0) rounding += out.rounding[static_cast<std::size_t>(body)];
      if (std::abs(w[row + 1]) <= rounding) continue;
      set_friction(contact, contact.sliding_mu);
      out.lambda[row + 1] *= contact.mu * out.lambda[row] / most;
      any = true;
    }
    return any;
  }

  void find_rounding() {
    std::vector<std::array<double, 2>> sums = applied;
    for (std::size_t i = 0; i < out.system.rows.size(); ++i) {
      const Row& row = out.system.rows[i];
      const auto add = [&](int body, const std::array<double, 3>& J) {
        if (body < 0) return;
        sums[static_cast<std::size_t>(body)][0] += std::abs(out.lambda[i]) * std::hypot(J[0], J[1]);
        sums[static_cast<std::size_t>(body)][1] += std::abs(out.lambda[i] * J[2]);
      };
      add(row.a, row.Ja);
      add(row.b, row.Jb);
    }
    out.rounding.clear();
    for (std::size_t k = 0; k < out.bodies.size(); ++k) {
      const InverseMass& m = out.system.bodies[k];
      out.rounding.push_back(kMoves * out.size(k, {m.linear * sums[k][0], 0, m.angular * sums[k][1]}));
    }
  }

  /// Accelerations, and the forces of contacts and joints, from those of the rows.
  void finish() {
    apply_impulses(out.system, out.lambda, out.acceleration);
    out.largest_acceleration = 0;
    out.stands = true;
    for (std::size_t k = 0; k < out.bodies.size(); ++k) {
      const double size = out.size(k, out.acceleration[k]);
      out.largest_acceleration = std::max(out.largest_acceleration, size);
      out.stands = out.stands && size <= out.rounding[k];
    }

    const std::vector<double> w = row_velocities(out.system, out.lambda);
    if (options.uniqueness) {
      std::vector<int> now = carrying_rows(out, w);
      if (now != carrying || out.unique.size() != out.system.rows.size()) {
        carrying = std::move(now);
        find_uniqueness(out, carrying);
      }
    }
    const auto unique = [&](std::size_t row) { return out.unique.empty() || out.unique[row] != 0; };
    for (RestContact& contact : out.contacts) {
      const auto row = static_cast<std::size_t>(contact.row);
      contact.normal_force = out.lambda[row];
      contact.opening = w[row];
      contact.normal_unique = unique(row);
      if (!(contact.held_mu > 0)) continue;
      contact.friction_force = out.lambda[row + 1];
      contact.friction_unique = unique(row + 1);
      contact.sliding = w[row + 1];
    }
    for (std::size_t k = 0; k < out.joints.size(); ++k) {
      out.joints[k].force = rows.springs[k];
      out.joints[k].unique = true;
      for (int i = rows.of_joint[k][0]; i < rows.of_joint[k][1]; ++i) {
        const auto row = static_cast<std::size_t>(i);
        out.joints[k].force += out.lambda[row] * rows.directions[row];
        out.joints[k].unique = out.joints[k].unique && unique(row);
      }
    }
  }
};

RestSolver::RestSolver(const World& world, const RestOptions& options)
    : state_(std::make_unique<State>(world, options)) {}
RestSolver::~RestSolver() = default;
RestSolver::RestSolver(RestSolver&&) noexcept = default;
RestSolver& RestSolver::operator=(RestSolver&&) noexcept = default;

const RestAnalysis& RestSolver::analysis() const {
  return state_->out;
}
const SolveWork& RestSolver::work() const {
  return state_->work;
}

const RestAnalysis& RestSolver::solve(const BodyLoads& load) {
  State& state = *state_;
  if (load.size() != state.out.bodies.size())
    throw std::invalid_argument("rest: " + std::to_string(state.out.bodies.size()) +
                                " bodies have as many loads, got " + std::to_string(load.size()));
  for (std::size_t k = 0; k < load.size(); ++k)
    for (const double value : load[k])
      if (!std::isfinite(value))
        throw std::invalid_argument("rest: load " + std::to_string(k + 1) + " is " + to_text(value));
  state.out.load = load;
  for (std::size_t k = 0; k < load.size(); ++k) {
    const std::array<double, 2>& springs = state.rows.sprung[k];
    state.applied[k] = {std::hypot(load[k][0], load[k][1]) + springs[0], std::abs(load[k][2]) + springs[1]};
  }
  state.out.from_last_step = false;
  state.set_load();
  state.solve(find_solver(state.options.solver), state.base);
  state.finish();
  return state.out;
}

RestAnalysis analyse_rest(const World& world, const RestOptions& options) {
  return RestSolver(world, options).analysis();
}

}  // namespace skerry::statics
