// SPDX-License-Identifier: MIT
#include "physics/solver/state_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace skerry {

extern const SolverEntry kNncgEntry;

namespace {

constexpr int kPatience = 8;
/// Sweeps before each attempt from an iterate of nncg; each sweep costs about a hundredth of a factorisation.
constexpr int kPreviewSweeps[] = {60, 200, 600, 2000};
constexpr int kSingles = 40;
constexpr double kFirstShift = 0.1, kLastShift = 1e-11;
constexpr int kMaxSteps = 60, kRepeats = 20;

/// A row and the state it should have.
struct Change {
  int row;
  RowState state;
};

class Search {
 public:
  Search(const ContactProblem& problem, StateEngine& engine, const SolveOptions& options, Solution& solution)
      : problem_(problem),
        engine_(engine),
        options_(options),
        solution_(solution),
        diagonal_(inverse_effective_masses(problem)),
        scale_(residual_scale(largest_magnitude(problem.b))) {
    best_ = solution.lambda;
    clamp_to_bounds(problem.rows, best_);
    best_residual_ = natural_map_residual(problem, best_);
  }

  bool good() const {
    return best_residual_ <= std::min(options_.tolerance, 1e-12) ||
           best_residual_ <= 16 * residual_floor(problem_, best_);
  }
  bool good_enough() const { return best_residual_ <= options_.tolerance || good(); }
  bool met_singular() const { return met_singular_; }
  const std::vector<double>& best() const { return best_; }
  const std::vector<RowState>& best_states() const { return best_states_; }

  /// Searches from `states`; with a shift the target is the shifted problem about `reference`.
  bool run(std::vector<RowState>& states, double shift, const std::vector<double>& reference, int rounds) {
    std::vector<double> lambda = reference, b = problem_.b;
    for (std::size_t i = 0; i < b.size(); ++i) b[i] += shift * diagonal_[i] * reference[i];
    int fewest = problem_.size() + 1, patience = kPatience, singles = 0;
    std::uint64_t dice = 0x9e3779b97f4a7c15u;
    for (int round = 0; round < rounds; ++round) {
      const Reduction reduction = reduce(problem_.rows, states);
      ++solution_.iterations;
      if (!engine_.solve(reduction, b, shift, lambda, solution_.work)) {
        met_singular_ = true;
        return false;
      }
      std::vector<Change> changes = find_changes(states, lambda, b, shift);
      if (shift == 0) consider(lambda, states);
      record(states, changes);
      if (changes.empty()) {
        impulses_ = lambda;
        return true;
      }
      const int count = static_cast<int>(changes.size());
      if (count < fewest) {
        fewest = count;
        patience = kPatience;
        singles = 0;
      } else if (patience > 0) {
        --patience;
      }
      if (patience == 0) {
        if (++singles > kSingles) return false;
        // Which one: the same bits every time, but no pattern that a cycle could lock on to.
        dice = dice * 6364136223846793005u + 1442695040888963407u;
        changes = {changes[(dice >> 33) % changes.size()]};
      }
      for (const Change& change : changes) states[change.row] = change.state;
      solution_.work.pivots += static_cast<int>(changes.size());
      if (shift == 0 && good()) return true;
    }
    return false;
  }

  /// Proximal continuation; true when the answer is good.
  bool continue_proximally(std::vector<RowState> states, std::vector<double> reference) {
    double shift = kFirstShift, good_shift = 0, factor = 0.1;
    std::vector<RowState> last_states = states;
    for (int step = 0; step < kMaxSteps && shift >= kLastShift; ++step) {
      states = last_states;
      if (run(states, shift, reference, 60)) {
        reference = impulses_;
        last_states = states;
        good_shift = shift;
        consider(reference, states);
        if (!good() && try_unshifted(states, reference)) return true;
        if (good()) return true;
        shift *= factor;
      } else if (good_shift == 0) {
        if (shift > 10) return false;
        shift *= 10;
      } else {
        // Too large a stride: a smaller one from the last shift that worked.
        factor = std::sqrt(factor);
        shift = good_shift * factor;
        if (factor > 0.7) return repeat_at(good_shift, last_states, reference);
      }
    }
    return good();
  }

  /// Takes `lambda` for the answer if it is the best so far.
  void consider(const std::vector<double>& lambda, const std::vector<RowState>& states) {
    std::vector<double> clamped = lambda;
    clamp_to_bounds(problem_.rows, clamped);
    const double residual = natural_map_residual(problem_, clamped);
    if (!(residual < best_residual_)) return;
    best_ = std::move(clamped);
    best_residual_ = residual;
    best_states_ = states;
  }

 private:
  /// Looks from a solution of a shifted problem for one of the problem itself; the smallest shifts are only
  /// for problems that have none nearby.
  bool try_unshifted(std::vector<RowState> states, const std::vector<double>& reference) {
    run(states, 0, reference, 24);
    return good();
  }

  /// The proximal point method proper: one shift, the reference moves. For W given with few digits, whose
  /// rounding makes small shifts indefinite.
  bool repeat_at(double shift, std::vector<RowState> states, std::vector<double> reference) {
    for (int step = 0; step < kRepeats; ++step) {
      if (!run(states, shift, reference, 60)) break;
      reference = impulses_;
      consider(reference, states);
      if (good() || try_unshifted(states, reference)) return true;
    }
    return good();
  }

  std::vector<Change> find_changes(const std::vector<RowState>& states, const std::vector<double>& lambda,
                                   const std::vector<double>& b, double shift) const {
    std::vector<double> w = row_velocities(problem_, lambda);
    for (std::size_t i = 0; i < w.size(); ++i) {
      w[i] += problem_.b[i] - b[i] + shift * diagonal_[i] * lambda[i];
    }
    const double slack = 4 * residual_floor(problem_, lambda) * scale_;
    std::vector<Change> changes;
    for (int i = 0; i < problem_.size(); ++i) {
      const RowState wanted = wanted_state(states, lambda, i, w[i], slack);
      if (wanted != states[i]) changes.push_back({i, wanted});
    }
    return changes;
  }

  RowState wanted_state(const std::vector<RowState>& states, const std::vector<double>& lambda, int i,
                        double w, double slack) const {
    const Row& row = problem_.rows[i];
    const RowState state = states[i];
    double normal_impulse = 0;
    if (is_scaled(row)) {
      normal_impulse = lambda[row.normal];
      // A contact that opens forgets how it slid: when it closes again it starts by sticking.
      const bool open = states[row.normal] == RowState::Lower && problem_.rows[row.normal].lower <= 0;
      if (open || normal_impulse < 0) return row.mu == 0 ? RowState::Lower : RowState::Free;
    }
    const ImpulseBounds bounds = impulse_bounds(row, normal_impulse);
    if (state == RowState::Free) {
      const double impulse_slack = diagonal_[i] > 0 ? slack / diagonal_[i] : 0;
      if (lambda[i] < bounds.lower - impulse_slack) return RowState::Lower;
      if (lambda[i] > bounds.upper + impulse_slack) return RowState::Upper;
      // Left out as redundant, and it separates: it is open.
      if (!is_scaled(row) && lambda[i] == bounds.lower && w > slack) return RowState::Lower;
      return state;
    }
    if (bounds.lower == bounds.upper && row.normal < 0) return state;
    if (is_scaled(row) && row.mu == 0) return state;
    const bool held = state == RowState::Lower ? w >= -slack : w <= slack;
    return held ? state : RowState::Free;
  }

  void record(const std::vector<RowState>& states, const std::vector<Change>& changes) {
    if (!solution_.trace) return;
    SolveIteration entry;
    entry.residual = best_residual_;
    entry.pivots = static_cast<int>(changes.size());
    count_states(problem_.rows, states, entry);
    solution_.trace->iterations.push_back(entry);
  }

  const ContactProblem& problem_;
  StateEngine& engine_;
  const SolveOptions& options_;
  Solution& solution_;
  std::vector<double> diagonal_;
  double scale_;
  std::vector<double> best_, impulses_;
  std::vector<RowState> best_states_;
  double best_residual_ = kInfinity;
  bool met_singular_ = false;
};

}  // namespace

Reduction reduce(const std::vector<Row>& rows, const std::vector<RowState>& states) {
  const std::size_t n = rows.size();
  Reduction reduction;
  reduction.place.assign(n, -1);
  reduction.constant.assign(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const Row& row = rows[i];
    const double sign = states[i] == RowState::Lower ? -1 : 1;
    if (is_scaled(row)) {
      const bool normal_free = reduction.place[row.normal] >= 0;
      const double bound = normal_free ? 0 : row.mu * std::max(0.0, reduction.constant[row.normal]);
      if (states[i] != RowState::Free && normal_free) {
        reduction.slipping.push_back({static_cast<int>(i), row.normal, sign * row.mu});
        continue;
      }
      if (states[i] != RowState::Free || (!normal_free && bound == 0)) {
        reduction.constant[i] = sign * bound;
        continue;
      }
    } else if (states[i] != RowState::Free) {
      reduction.constant[i] = states[i] == RowState::Lower ? row.lower : row.upper;
      continue;
    }
    reduction.place[i] = static_cast<int>(reduction.free.size());
    reduction.free.push_back(static_cast<int>(i));
  }
  return reduction;
}

std::vector<double> expand(const Reduction& reduction, std::span<const double> free_impulses) {
  std::vector<double> lambda = reduction.constant;
  for (std::size_t k = 0; k < reduction.free.size(); ++k) lambda[reduction.free[k]] = free_impulses[k];
  for (const Tie& tie : reduction.slipping) lambda[tie.row] = tie.factor * lambda[tie.normal];
  return lambda;
}

void solve_by_states(const ContactProblem& problem, StateEngine& engine, bool proximal,
                     const SolveOptions& options, std::vector<RowState>& states, Solution& solution) {
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  const std::vector<double> warm = solution.lambda;
  const bool has_warm = largest_magnitude(warm) > 0;
  Search search(problem, engine, options, solution);
  const int rounds = options.max_iterations > 0 ? options.max_iterations : 60 + problem.size();
  const auto note = [&](const char* text) {
    if (solution.trace) solution.trace->notes.emplace_back(text);
  };
  const auto attempt = [&](const char* name, std::vector<RowState> start) {
    if (search.good_enough()) return;
    note(name);
    search.run(start, 0, warm, rounds);
  };
  const bool kept = states.size() == problem.rows.size();
  if (kept) attempt("states of the last call", states);
  if (has_warm) attempt("states of the warm start", states_from_impulses(problem.rows, warm));
  attempt("all sticking", all_sticking(problem.rows));
  std::vector<double> preview = warm;
  for (const int sweeps : kPreviewSweeps) {
    if (search.good_enough()) break;
    preview = kNncgEntry.solve_contact(problem, preview, {.max_iterations = sweeps}, nullptr).lambda;
    const std::vector<RowState> start = states_from_impulses(problem.rows, preview);
    attempt("states of a preview by conjugate gradients", start);
    // A method that stands for its factor must not answer with sweeps.
    if (proximal) search.consider(preview, start);
  }
  if (proximal && !search.good_enough()) {
    note("proximal continuation");
    search.continue_proximally(states_from_impulses(problem.rows, preview), preview);
  }
  solution.lambda = search.best();
  states = search.best_states().empty() ? states_from_impulses(problem.rows, solution.lambda)
                                        : search.best_states();
  conclude(problem, options, solution);
  if (solution.status != SolveStatus::Solved && search.met_singular())
    solution.status = SolveStatus::Singular;
}

}  // namespace skerry
