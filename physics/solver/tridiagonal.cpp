// SPDX-License-Identifier: MIT
//
// Chains (Newton's cradle, a column of discs): frictionless rows that each share bodies with at most two
// others, in a path. W is tridiagonal along the path, and one LDL^T sweep solves it in O(n).
//
// Contacts that only push, with couplings below zero (W is an M-matrix: discs in a row): one pass from the
// left. What is free stays free, so a row that approaches joins the run on its left, and a row at its bound
// between two runs joins both when their impulses make it approach; runs are known by their two ends, so that
// joining them takes O(1) [Chandrasekaran 1970; for equal discs this
// pools adjacent violators of the order of velocities, Barlow et al. 1972].
//
// Everything else by active set: rows at a bound cut the path into pieces. All violated rows change at once;
// when the number of violations does not fall for eight rounds, one row a round, which ends for the positive
// definite W of a chain [Judice & Pires 1994].
#include <cmath>

#include "physics/archive.h"
#include "physics/solver/contact_states.h"
#include "physics/spare.h"

namespace skerry {
namespace {

/// W along the path: diagonal and the coupling of each row with the next.
struct Path {
  std::vector<int> row;  ///< rows in path order
  std::vector<double> diagonal, next, b, lower, upper;

  void resize(int n) {
    row.resize(n);
    for (auto* values : {&diagonal, &next, &b, &lower, &upper}) values->resize(n);
  }
};

double body_product(const IslandSystem& system, int body, const std::array<double, 3>& x,
                    const std::array<double, 3>& y) {
  const InverseMass& mass = system.bodies[body];
  return mass.linear * (x[0] * y[0] + x[1] * y[1]) + mass.angular * x[2] * y[2];
}

double coupling(const IslandSystem& system, const Row& x, const Row& y) {
  double sum = 0;
  if (x.a >= 0 && x.a == y.a) sum += body_product(system, x.a, x.Ja, y.Ja);
  if (x.a >= 0 && x.a == y.b) sum += body_product(system, x.a, x.Ja, y.Jb);
  if (x.b >= 0 && x.b == y.a) sum += body_product(system, x.b, x.Jb, y.Ja);
  if (x.b >= 0 && x.b == y.b) sum += body_product(system, x.b, x.Jb, y.Jb);
  return sum;
}

/// The rows each row shares a movable body with; false when one has more than two of them.
class Neighbours {
 public:
  explicit Neighbours(const IslandSystem& system) : of_(system.rows.size(), {-1, -1}) {
    std::vector<std::array<int, 2>> touching(system.bodies.size(), {-1, -1});
    for (int i = 0; i < system.size(); ++i) {
      for (const int body : {system.rows[i].a, system.rows[i].b}) {
        if (body < 0 || (system.bodies[body].linear == 0 && system.bodies[body].angular == 0)) continue;
        auto& [first, second] = touching[body];
        if (second >= 0) {
          path_ = false;  // three rows on one body are all neighbours of each other: no path
          return;
        }
        if (first >= 0) link(first, i);
        (first < 0 ? first : second) = i;
      }
    }
  }

  bool found_path() const { return path_; }
  const std::array<int, 2>& operator[](int i) const { return of_[i]; }

 private:
  void link(int i, int j) {
    // Two rows between the same two bodies meet twice and count once.
    if (of_[i][0] == j || of_[i][1] == j) return;
    for (const auto& [from, to] : {std::pair{i, j}, std::pair{j, i}}) {
      auto& [first, second] = of_[from];
      if (first >= 0 && second >= 0) path_ = false;
      (first < 0 ? first : second) = to;
    }
  }

  std::vector<std::array<int, 2>> of_;
  bool path_ = true;
};

bool is_natural_path(const Neighbours& neighbours, int n) {
  for (int i = 0; i < n; ++i) {
    for (const int j : neighbours[i]) {
      if (j >= 0 && j != i - 1 && j != i + 1) return false;
    }
  }
  return true;
}

/// Rows in path order, piece after piece; false for rings.
bool order_rows(const Neighbours& neighbours, int n, std::vector<int>& order) {
  order.reserve(n);
  if (is_natural_path(neighbours, n)) {
    for (int i = 0; i < n; ++i) order.push_back(i);
    return true;
  }
  std::vector<char> taken(n, 0);
  for (int start = 0; start < n; ++start) {
    const bool end_of_path = neighbours[start][1] < 0;
    if (taken[start] || !end_of_path) continue;
    for (int row = start; row >= 0;) {
      taken[row] = 1;
      order.push_back(row);
      int following = -1;
      for (const int j : neighbours[row]) {
        if (j >= 0 && !taken[j]) following = j;
      }
      row = following;
    }
  }
  return static_cast<int>(order.size()) == n;
}

/// The block of `row` that acts on `body`, one of its two.
const std::array<double, 3>& block_of(const Row& row, int body) {
  return row.a == body ? row.Ja : row.Jb;
}

/// The path whose rows stand in their order already, in one pass over them; false for any other.
bool make_natural_path(const IslandSystem& system, Path& path) {
  const int n = system.size();
  path.resize(n);
  // Twice the last row of each body, plus one if it is its second.
  Spare<std::vector<int>> last_rows;
  last_rows->assign(system.bodies.size(), -1);
  int* const last = last_rows->data();
  for (int k = 0; k < n; ++k) {
    const Row& row = system.rows[k];
    if (is_scaled(row)) return false;
    double diagonal = 0;
    int shared = 0, with = -1;
    for (const int body : {row.a, row.b}) {
      if (body < 0) continue;
      const InverseMass& mass = system.bodies[body];
      if (mass.linear == 0 && mass.angular == 0) continue;
      diagonal += inverse_mass_along(mass, block_of(row, body));
      if (last[body] < 0) {
        last[body] = 2 * k;
        continue;
      }
      if (last[body] != 2 * (k - 1)) return false;
      last[body] = 2 * k + 1;
      ++shared;
      with = body;
    }
    path.diagonal[k] = diagonal + (system.compliance.empty() ? 0 : system.compliance[k]);
    path.next[k] = 0;
    if (shared > 0) {
      const Row& before = system.rows[k - 1];
      path.next[k - 1] = shared == 1 ? body_product(system, with, block_of(before, with), block_of(row, with))
                                     : coupling(system, before, row);
    }
    path.row[k] = k;
    path.b[k] = system.b[k];
    path.lower[k] = row.lower;
    path.upper[k] = row.upper;
  }
  return true;
}

bool make_path(const IslandSystem& system, Path& path) {
  if (make_natural_path(system, path)) return true;
  path.row.clear();
  const int n = system.size();
  for (const Row& row : system.rows) {
    if (is_scaled(row)) return false;
  }
  const Neighbours neighbours(system);
  if (!neighbours.found_path() || !order_rows(neighbours, n, path.row)) return false;
  path.resize(n);
  for (int k = 0; k < n; ++k) {
    const int i = path.row[k];
    const Row& row = system.rows[i];
    path.diagonal[k] = coupling(system, row, row) + (system.compliance.empty() ? 0 : system.compliance[i]);
    path.next[k] = k + 1 < n ? coupling(system, row, system.rows[path.row[k + 1]]) : 0;
    path.b[k] = system.b[i];
    path.lower[k] = row.lower;
    path.upper[k] = row.upper;
  }
  return true;
}

/// Solves the free pieces of the path among rows `first` to `last`, which no free row outside touches; rows
/// at bounds keep their bound.
/// @return false at a pivot that is not positive to rounding: the rows are dependent
bool solve_pieces(const Path& path, const std::vector<RowState>& states, int first, int last,
                  std::vector<double>& pivot, std::vector<double>& lambda) {
  const int n = static_cast<int>(path.row.size());
  for (int k = first; k <= last; ++k) {
    if (states[k] != RowState::Free) {
      lambda[k] = states[k] == RowState::Lower ? path.lower[k] : path.upper[k];
    }
  }
  // Forward: lambda holds the eliminated right-hand side.
  for (int k = first; k <= last; ++k) {
    if (states[k] != RowState::Free) continue;
    double d = path.diagonal[k], y = path.b[k];
    if (k > 0) {
      if (states[k - 1] == RowState::Free) {
        const double factor = path.next[k - 1] / pivot[k - 1];
        d -= factor * path.next[k - 1];
        y -= factor * lambda[k - 1];
      } else {
        y -= path.next[k - 1] * lambda[k - 1];
      }
    }
    if (k + 1 < n && states[k + 1] != RowState::Free) y -= path.next[k] * lambda[k + 1];
    if (!(d > 1e-14 * path.diagonal[k])) return false;
    pivot[k] = d;
    lambda[k] = y;
  }
  for (int k = last; k >= first; --k) {
    if (states[k] != RowState::Free) continue;
    double y = lambda[k];
    if (k + 1 < n && states[k + 1] == RowState::Free) y -= path.next[k] * lambda[k + 1];
    lambda[k] = y / pivot[k];
  }
  return true;
}

/// State that row k should have; the present one unless it is violated beyond rounding.
RowState wanted_state(const Path& path, RowState state, const std::vector<double>& lambda, int k,
                      double velocity_slack) {
  if (state == RowState::Free) {
    const double slack = velocity_slack / path.diagonal[k];
    if (lambda[k] < path.lower[k] - slack) return RowState::Lower;
    if (lambda[k] > path.upper[k] + slack) return RowState::Upper;
    return state;
  }
  const int n = static_cast<int>(path.row.size());
  double w = path.diagonal[k] * lambda[k] - path.b[k];
  if (k > 0) w += path.next[k - 1] * lambda[k - 1];
  if (k + 1 < n) w += path.next[k] * lambda[k + 1];
  const bool held = state == RowState::Lower ? w >= -velocity_slack : w <= velocity_slack;
  return held || path.lower[k] == path.upper[k] ? state : RowState::Free;
}

/// Whether W is an M-matrix as far as signs tell, and all bounds are those of contacts.
bool only_pushes(const Path& path) {
  bool pushes = true;
  for (std::size_t k = 0; k < path.row.size(); ++k)
    pushes = pushes && path.lower[k] == 0 && path.upper[k] == kInfinity && path.next[k] <= 0 &&
             path.diagonal[k] > 0;
  return pushes;
}

/// Neighbouring free rows, seen from their two ends: with nothing pushing from outside, `g` are the impulses
/// of the first and the last row, and `inverse` the entries of W^-1 between these two.
struct Run {
  int first = 0, last = 0;
  double g_first = 0, g_last = 0;
  double inverse_first = 0, inverse_across = 0, inverse_last = 0;
};

/// A run of one row. @return false at a pivot that is not positive
bool make_run(const Path& path, int k, Run& run) {
  if (!(path.diagonal[k] > 0)) return false;
  const double inverse = 1 / path.diagonal[k];
  run = {k, k, path.b[k] * inverse, path.b[k] * inverse, inverse, inverse, inverse};
  return true;
}

/// Joins two runs side by side in O(1): each feels the end of the other through their coupling.
/// @return false at a pivot that is not positive to rounding: the rows are dependent
bool join(const Path& path, const Run& left, Run& run) {
  const Run right = run;
  const double c = path.next[left.last];
  const double pivot = 1 - c * c * left.inverse_last * right.inverse_first;
  if (!(pivot > 1e-14)) return false;
  const double s = 1 / pivot;
  // The impulses on both sides of the seam.
  const double l = s * (left.g_last - left.inverse_last * c * right.g_first);
  const double r = s * (right.g_first - right.inverse_first * c * left.g_last);
  run.first = left.first;
  run.g_first = left.g_first - left.inverse_across * c * r;
  run.g_last = right.g_last - right.inverse_across * c * l;
  const double from_left = left.inverse_across * c, from_right = right.inverse_across * c;
  run.inverse_first = left.inverse_first + s * from_left * from_left * right.inverse_first;
  run.inverse_last = right.inverse_last + s * from_right * from_right * left.inverse_last;
  run.inverse_across = -s * from_left * right.inverse_across;
  return true;
}

/// Finds the states in one pass over a path that only pushes; rows that approach by less than `slack` are at
/// rest. Each row joins a run at most once, so the pass takes O(n).
/// @return false at a pivot that is not positive to rounding
bool pool_rows(const Path& path, double slack, std::vector<RowState>& states) {
  const int n = static_cast<int>(path.row.size());
  Spare<std::vector<Run>> spare;
  std::vector<Run>& runs = *spare;
  for (int k = 0; k < n; ++k) {
    const bool beside = !runs.empty() && runs.back().last == k - 1;
    double w = -path.b[k];
    if (beside) w += path.next[k - 1] * runs.back().g_last;
    states[k] = RowState::Lower;
    if (!(w < -slack)) continue;
    states[k] = RowState::Free;
    Run run;
    if (!make_run(path, k, run)) return false;
    if (beside) {
      if (!join(path, runs.back(), run)) return false;
      runs.pop_back();
    }
    // Its impulse reaches the row before its run, which may have to join.
    while (run.first > 0) {
      const int before = run.first - 1;
      const bool meets = !runs.empty() && runs.back().last == before - 1;
      w = path.next[before] * run.g_first - path.b[before];
      if (meets) w += path.next[before - 1] * runs.back().g_last;
      if (!(w < -slack)) break;
      states[before] = RowState::Free;
      Run joining;
      if (!make_run(path, before, joining) || !join(path, joining, run)) return false;
      if (!meets) continue;
      if (!join(path, runs.back(), run)) return false;
      runs.pop_back();
    }
    runs.push_back(run);
  }
  return true;
}

/// Impulses of a path that only pushes: free rows are solved run by run, the others push nothing.
/// @return false at a pivot that is not positive to rounding
bool solve_runs(const Path& path, const std::vector<RowState>& states, std::vector<double>& lambda) {
  const int n = static_cast<int>(path.row.size());
  Spare<std::vector<double>> spare;
  spare->resize(n);
  double* const inverse = spare->data();  // of the pivots; zero at bounds
  for (int k = 0; k < n; ++k) {
    inverse[k] = lambda[k] = 0;
    if (states[k] != RowState::Free) continue;
    double d = path.diagonal[k], y = path.b[k];
    if (k > 0 && inverse[k - 1] != 0) {
      const double factor = path.next[k - 1] * inverse[k - 1];
      d -= factor * path.next[k - 1];
      y -= factor * lambda[k - 1];
    }
    if (!(d > 1e-14 * path.diagonal[k])) return false;
    inverse[k] = 1 / d;
    lambda[k] = y;
  }
  double after = 0;
  for (int k = n - 1; k >= 0; --k) after = lambda[k] = inverse[k] * (lambda[k] - path.next[k] * after);
  return true;
}

struct TridiagonalMemory : SolverMemory {
  std::vector<RowState> states;

  std::string_view solver() const override { return "tridiagonal"; }
  void archive(Archive& a) override { a(states); }
};

/// Active set from `states`.
/// @return false at a pivot that is not positive to rounding
bool search(const Path& path, const SolveOptions& options, double slack, std::vector<RowState>& states,
            std::vector<double>& lambda, Solution& solution) {
  const int n = static_cast<int>(path.row.size());
  std::vector<double> pivot(n, 0.0);
  const int rounds = options.max_iterations > 0 ? options.max_iterations : 100 + 2 * n;
  int fewest = n + 1, patience = 8;
  std::vector<std::pair<int, RowState>> changes, applied;
  std::vector<std::pair<int, int>> spans;
  while (solution.iterations < rounds) {
    ++solution.iterations;
    ++solution.work.factorisations;
    changes.clear();
    if (applied.empty() || patience == 0) {
      if (!solve_pieces(path, states, 0, n - 1, pivot, lambda)) return false;
      for (int k = 0; k < n; ++k) {
        const RowState wanted = wanted_state(path, states[k], lambda, k, slack);
        if (wanted != states[k]) changes.emplace_back(k, wanted);
      }
    } else {
      // Only the pieces beside a change are others than before.
      spans.clear();
      for (std::size_t c = 0; c < applied.size();) {
        int first = applied[c].first, last = first;
        while (first > 0 && states[first - 1] == RowState::Free) --first;
        for (; c < applied.size() && applied[c].first <= last + 1; ++c) {
          last = std::max(last, applied[c].first);
          while (last + 1 < n && states[last + 1] == RowState::Free) ++last;
        }
        if (!solve_pieces(path, states, first, last, pivot, lambda)) return false;
        spans.emplace_back(first, last);
      }
      // The rows at bounds on both sides feel them, too.
      int looked = -1;
      for (const auto& [first, last] : spans) {
        for (int k = std::max(looked + 1, first - 1); k <= std::min(n - 1, last + 1); ++k) {
          const RowState wanted = wanted_state(path, states[k], lambda, k, slack);
          if (wanted != states[k]) changes.emplace_back(k, wanted);
          looked = k;
        }
      }
    }
    if (changes.empty()) return true;
    const int count = static_cast<int>(changes.size());
    if (count < fewest) {
      fewest = count;
      patience = 8;
    } else if (patience > 0) {
      --patience;
    }
    if (patience == 0) changes = {changes.back()};
    for (const auto& [k, state] : changes) states[k] = state;
    solution.work.pivots += static_cast<int>(changes.size());
    applied.swap(changes);
  }
  return true;
}

Solution solve_tridiagonal(const IslandSystem& system, std::span<const double>, const SolveOptions& options,
                           std::unique_ptr<SolverMemory>* memory) {
  Solution solution;
  solution.method = "tridiagonal";
  solution.lambda.assign(system.rows.size(), 0.0);
  Spare<Path> spare_path;
  Path& path = *spare_path;
  if (!make_path(system, path)) {
    clamp_to_bounds(system.rows, solution.lambda);
    solution.status = SolveStatus::Unsupported;
    solution.residual = natural_map_residual(system, solution.lambda);
    return solution;
  }
  const std::size_t n = path.row.size();
  auto* kept = memory ? dynamic_cast<TridiagonalMemory*>(memory->get()) : nullptr;
  Spare<std::vector<RowState>> spare_states;
  std::vector<RowState>& states = *spare_states;
  Spare<std::vector<double>> spare_lambda;
  std::vector<double>& lambda = *spare_lambda;
  lambda.resize(n);
  const auto judge = [&] {
    for (std::size_t k = 0; k < n; ++k) solution.lambda[path.row[k]] = lambda[k];
    conclude(system, options, solution);
  };
  const double slack = 4 * kRoundingUnit * largest_magnitude(path.b);
  const bool warm = kept && kept->states.size() == n;
  bool pooled = false;
  if (warm) {
    states = kept->states;
  } else {
    states.assign(n, RowState::Free);
    pooled = only_pushes(path) && pool_rows(path, slack, states);
    if (!pooled) states.assign(n, RowState::Free);
  }
  if (pooled && solve_runs(path, states, lambda)) {
    solution.iterations = solution.work.factorisations = 1;
    judge();
  }
  if (solution.status != SolveStatus::Solved) {
    const bool regular = search(path, options, slack, states, lambda, solution);
    if (!regular) lambda.assign(n, 0.0);
    judge();
    if (!regular && solution.status != SolveStatus::Solved) solution.status = SolveStatus::Singular;
  }
  if (memory && solution.status == SolveStatus::Solved) {
    if (kept) {
      kept->states = states;
    } else {
      auto fresh = std::make_unique<TridiagonalMemory>();
      fresh->states = states;
      *memory = std::move(fresh);
    }
  }
  return solution;
}

}  // namespace

extern const SolverEntry kTridiagonalEntry{
    .name = "tridiagonal",
    .summary = "frictionless chains: O(n) elimination along the path, active set for the signs",
    .reference = "Thomas algorithm; block pivots: Judice & Pires 1994",
    .exact = true,
    .friction = false,
    .bilateral = true,
    .solve = solve_tridiagonal,
    .make_memory = []() -> std::unique_ptr<SolverMemory> { return std::make_unique<TridiagonalMemory>(); }};

}  // namespace skerry
