// SPDX-License-Identifier: MIT
//
// Chains (Newton's cradle, a column of discs): frictionless rows that each share bodies with at most two
// others, in a path. W is tridiagonal along the path, and elimination takes O(n).
//
// Contacts that only push, with couplings not above zero (W is an M-matrix: discs in a row): the one pass of
// physics/solver/run_pooling.h, straight from the rows where bodies ascend along the path, and judged in one
// more.
//
// Everything else by active set: rows at a bound cut the path into pieces. All violated rows change at once;
// when the number of violations does not fall for eight rounds, one row a round, which ends for the positive
// definite W of a chain [Judice & Pires 1994].
#include "physics/solver/tridiagonal.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "physics/archive.h"
#include "physics/islands/path_lanes.h"
#include "physics/islands/planar.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/run_pooling.h"
#include "physics/solver/solver_trace.h"
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

/// Rows that approach by less are at rest, to rounding.
double rest_slack(const std::vector<double>& b) {
  return 4 * kRoundingUnit * largest_magnitude(b);
}

/// Gives up on rows that do more than push, and on couplings above zero.
bool pushes(const PathRow& row, double lower, double upper) {
  // Bounds by their bits: one comparison.
  constexpr auto kAbove = std::bit_cast<std::uint64_t>(kInfinity);
  const std::uint64_t others =
      std::bit_cast<std::uint64_t>(lower) << 1 | (std::bit_cast<std::uint64_t>(upper) ^ kAbove);
  return others == 0 && row.push >= 0 && row.diagonal > 0;
}

/// The rows of an island in which bodies ascend along the path (each row lies between a body and a later one,
/// and begins no earlier than the row before ended), read as they come.
class AscendingRows {
 public:
  explicit AscendingRows(const IslandSystem& system)
      : rows_(system.rows.data()), bodies_(system.bodies.data()), b_(system.b.data()) {}

  SKERRY_ALWAYS_INLINE bool operator()(int k, PathRow& to) {
    const Row& row = rows_[k];
    if (is_scaled(row) || row.a < end_ || row.b <= row.a) return false;
    to.diagonal = to.push = 0;
    if (row.a >= 0) [[likely]] {
      const InverseMass& mass = bodies_[row.a];
      const Planar J = planar(row.Ja);
      to.diagonal = coupled(mass, J, J);
      if (row.a == end_) to.push = -coupled(mass, J_end_, J);
    }
    end_ = row.b;
    J_end_ = planar(row.Jb);
    to.diagonal += coupled(bodies_[end_], J_end_, J_end_);
    to.b = b_[k];
    return pushes(to, row.lower, row.upper);
  }

 private:
  const Row* rows_;
  const InverseMass* bodies_;
  const double* b_;
  int end_ = -1;
  Planar J_end_{};
};

/// The same four bodies at a time where each row begins where the one before ended, with the same bits.
class RowsInLanes {
 public:
  explicit RowsInLanes(const IslandSystem& system)
      : rows_(system.rows.data()), b_(system.b.data()), count_(system.size()), reader_(system) {}

  SKERRY_ALWAYS_INLINE bool operator()(int k, PathRow& to) {
    // The row needs the body behind it, too.
    if (k + 1 >= read_ && !read_on()) return false;
    to = {before_[k % kRing] + behind_[(k + 1) % kRing], push_[k % kRing], b_[k]};
    return true;
  }

 private:
  static constexpr int kRing = 32;  // bodies of which parts are kept; half of them are read at a time

  SKERRY_ALWAYS_INLINE bool read_on() {
    using Bits = std::int64_t __attribute__((vector_size(32)));
    Bits good = ~Bits{};
    for (int end = read_ + kRing / 2; read_ < end && read_ <= count_; read_ += 4) {
      PathLanes four{};
      Vec4 lower{}, upper{};
      if (reader_.inside(read_)) {
        if (!reader_.read(read_, four)) return false;
        const Row* const r = rows_ + read_;
        lower = Vec4{r[0].lower, r[1].lower, r[2].lower, r[3].lower};
        upper = Vec4{r[0].upper, r[1].upper, r[2].upper, r[3].upper};
      } else {
        const Row* rows[5];
        if (!reader_.read_end(read_, rows, four)) return false;
        for (int i = 0; i < 4; ++i) {
          const bool there = read_ + i < count_;
          lower[i] = there ? rows[i + 1]->lower : 0;
          upper[i] = there ? rows[i + 1]->upper : kInfinity;
          // Nothing pushes across the ends.
          if (!there) four.ax[i] = four.ay[i] = four.aturn[i] = 0;
          if (read_ + i == 0) four.bx[i] = four.by[i] = four.bturn[i] = 0;
        }
      }
      const Vec4 bturn = four.angular * four.bturn;
      const Vec4 before =
          four.linear * (four.ax * four.ax + four.ay * four.ay) + four.angular * four.aturn * four.aturn;
      const Vec4 behind = four.linear * (four.bx * four.bx + four.by * four.by) + bturn * four.bturn;
      const Vec4 push = -(four.linear * (four.bx * four.ax + four.by * four.ay) + bturn * four.aturn);
      good &= (lower == 0.0) & (upper == kInfinity) & (push >= 0.0);
      const int at = read_ % kRing;
      std::memcpy(before_ + at, &before, sizeof(Vec4));
      std::memcpy(behind_ + at, &behind, sizeof(Vec4));
      std::memcpy(push_ + at, &push, sizeof(Vec4));
    }
    return (good[0] & good[1] & good[2] & good[3]) != 0;
  }

  const Row* rows_;
  const double* b_;
  int count_, read_ = 0;
  PathReader reader_;
  // Of each body: its shares in D of the row behind it and of the row before, and the push between these.
  double before_[kRing], behind_[kRing], push_[kRing];
};

/// The rows of a path.
class PackedRows {
 public:
  explicit PackedRows(const Path& path) : path_(path) {}

  SKERRY_ALWAYS_INLINE bool operator()(int k, PathRow& to) const {
    to = {path_.diagonal[k], k > 0 ? -path_.next[k - 1] : 0, path_.b[k]};
    return pushes(to, path_.lower[k], path_.upper[k]);
  }

 private:
  const Path& path_;
};

struct TridiagonalMemory final : SolverMemory {
  std::vector<RowState> states;

  std::string_view solver() const override { return "tridiagonal"; }
  void archive(Archive& a) override { a(states); }
};

/// Active set from `states`.
/// @return false at a pivot that is not positive to rounding
bool search(const IslandSystem& system, const Path& path, const SolveOptions& options, double slack,
            std::vector<RowState>& states, std::vector<double>& lambda, Solution& solution) {
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
    if (solution.trace) {
      for (int k = 0; k < n; ++k) solution.lambda[path.row[k]] = lambda[k];
      record_iteration(system, solution.lambda, *solution.trace);
      solution.trace->iterations.back().pivots = static_cast<int>(changes.size());
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

// Not inlined: the loops want all registers.
__attribute__((noinline)) bool pool(const IslandSystem& system, RunPooling& pass) {
  const double slack = rest_slack(system.b);
  return pass.join_rows(system.size(), slack, AscendingRows(system));
}
SKERRY_AVX2 bool pool_lanes(const IslandSystem& system, RunPooling& pass) {
  const double slack = rest_slack(system.b);
  return pass.join_rows(system.size(), slack, RowsInLanes(system));
}
__attribute__((noinline)) bool pool(const Path& path, RunPooling& pass) {
  return pass.join_rows(static_cast<int>(path.row.size()), rest_slack(path.b), PackedRows(path));
}

/// Keeps the states of an answer; of one that the pass gave, it knows them.
void keep(const std::vector<RowState>& states, std::unique_ptr<SolverMemory>& memory) {
  make_memory_as<TridiagonalMemory>(memory).states = states;
}

/// The one pass over rows that ascend, judged. @return false, and `solution` as it was, for other rows
bool try_ascending(const IslandSystem& system, const SolveOptions& options, Solution& solution,
                   RunPooling& pass) {
  if (!may_be_path(system)) return false;
  if (!(lanes_pay(system) && pool_lanes(system, pass)) && !pool(system, pass)) return false;
  const std::size_t n = system.rows.size();
  solution.method = "tridiagonal";
  solution.lambda = take_spare<std::vector<double>>();
  solution.lambda.resize(n + 1);
  pass.solve(solution.lambda.data());
  solution.lambda.resize(n);
  solution.iterations = solution.work.factorisations = 1;
  conclude(system, options, solution);
  if (options.trace) {
    solution.trace = std::make_unique<SolveTrace>();
    record_iteration(system, solution.lambda, *solution.trace);
  }
  return true;
}

Solution solve_tridiagonal(const IslandSystem& system, std::span<const double>, const SolveOptions& options,
                           std::unique_ptr<SolverMemory>* memory) {
  Solution solution;
  const std::size_t n = system.rows.size();
  const auto* kept = memory_as<TridiagonalMemory>(memory);
  const bool warm = kept && kept->states.size() == n;
  Spare<RunPooling> pass;
  Spare<std::vector<RowState>> spare_states;
  std::vector<RowState>& states = *spare_states;
  const auto tell_states = [&] {
    states.assign(n, RowState::Free);
    pass->each_at_rest([&](int k) { states[static_cast<std::size_t>(k)] = RowState::Lower; });
  };
  if (!warm && try_ascending(system, options, solution, *pass) && solution.status == SolveStatus::Solved) {
    if (memory) {
      tell_states();
      keep(states, *memory);
    }
    return solution;
  }

  solution.method = "tridiagonal";
  solution.lambda.assign(n, 0.0);
  if (options.trace && !solution.trace) solution.trace = std::make_unique<SolveTrace>();
  Spare<Path> spare_path;
  Path& path = *spare_path;
  if (!make_path(system, path)) {
    clamp_to_bounds(system.rows, solution.lambda);
    solution.status = SolveStatus::Unsupported;
    solution.residual = natural_map_residual(system, solution.lambda);
    return solution;
  }
  Spare<std::vector<double>> spare_lambda;
  std::vector<double>& lambda = *spare_lambda;
  lambda.resize(n + 1);
  const auto judge = [&] {
    for (std::size_t k = 0; k < n; ++k) solution.lambda[path.row[k]] = lambda[k];
    conclude(system, options, solution);
  };
  states.assign(n, RowState::Free);
  if (warm) {
    states = kept->states;
  } else if (pool(path, *pass)) {
    pass->solve(lambda.data());
    tell_states();
    solution.iterations = solution.work.factorisations = 1;
    judge();
    if (solution.trace) record_iteration(system, solution.lambda, *solution.trace);
  }
  if (solution.status != SolveStatus::Solved) {
    const bool regular = search(system, path, options, rest_slack(path.b), states, lambda, solution);
    if (!regular) std::fill(lambda.begin(), lambda.end(), 0.0);
    judge();
    if (!regular && solution.status != SolveStatus::Solved) solution.status = SolveStatus::Singular;
  }
  if (memory && solution.status == SolveStatus::Solved) keep(states, *memory);
  return solution;
}

}  // namespace

bool try_chain(const IslandSystem& system, const SolveOptions& options, Solution& solution) {
  if (!may_be_path(system)) return false;
  Spare<RunPooling> pass;
  Solution found;
  if (!try_ascending(system, options, found, *pass)) return false;
  if (found.status != SolveStatus::Solved) {
    give_spare(std::move(found.lambda));
    return false;
  }
  solution = std::move(found);
  return true;
}

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
