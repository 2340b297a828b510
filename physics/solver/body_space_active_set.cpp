// SPDX-License-Identifier: MIT
#include "physics/solver/body_space_active_set.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "physics/index.h"

namespace skerry {
namespace {

// A factor made with slightly different Jacobians still contracts the refinement; beyond this it is not
// tried.
constexpr double kStaleLimit = 1e-6;
// Smallest proximal weight: below it redundant rows lose too many digits.
constexpr double kLeastEta = 1e-9;
// Reduction of the error in a step above which it does not fall at all.
constexpr double kContradiction = 1 - 1e-6;
// Relative error below which slow convergence is a matter of rounding.
constexpr double kWorthAFactor = 1e-8;
// Steps that solve a linear problem to the end, mostly.
constexpr int kAllSteps = 12;
// Iterations that a few changes are put up with beyond the patience of the options.
constexpr int kFewPatience = 3;
// Rounding floors of the model that `conclude` accepts; searching on for less than that has no end where
// masses differ by 1e9.
constexpr double kAcceptedFloors = 2;
// Contradictions that make up a residual are at least so large against it.
constexpr double kSharp = 0.1;
// Pivots of one solve along directions in which rows contradict each other: one row a leap.
constexpr int kLeaps = 30;

}  // namespace

void ActiveSet::reset(double change) {
  const std::size_t n = at(model_.rows());
  if (states_.size() != n || change > kStaleLimit) factored_ = false;
  stale_ = stale_ || change > 0;
  weighted_ = false;
  if (!std::isfinite(change) || states_.size() != n) states_.assign(n, RowState::Free);
  lambda_.assign(n, 0);
  w_.resize(n);
  g_.resize(n);
  h_.resize(n);
  k_.resize(n);
  d_lambda_.resize(n);
  best_.assign(n, 0);
  best_residual_ = kInfinity;
  if (change > kStaleLimit) eta_ = 0;
}

void ActiveSet::set_impulses(const double* lambda) {
  std::copy(lambda, lambda + model_.rows(), lambda_.begin());
  model_.project(lambda_.data());
  model_.evaluate(lambda_.data(), w_.data());
}

void ActiveSet::predict_states() {
  model_.share_rows([&](int first, int last) { predict_states(first, last); });
}

void ActiveSet::predict_states(int first, int last) {
  for (int i = first; i < last; ++i) {
    const auto& r = model_.row(i);
    RowState& s = states_[at(i)];
    s = RowState::Free;
    if (r.dead) continue;
    const double z = lambda_[at(i)] - w_[at(i)] / r.D;
    if (r.normal >= 0) {
      const auto& n = model_.row(r.normal);
      const double zn = n.dead ? 0 : lambda_[at(r.normal)] - w_[at(r.normal)] / n.D;
      const double bound = r.mu * std::max(0.0, zn);
      if (z > bound) s = RowState::Upper;
      if (z < -bound) s = RowState::Lower;
    } else {
      if (z >= r.upper) s = RowState::Upper;
      if (z <= r.lower) s = RowState::Lower;
    }
  }
}

void ActiveSet::predict_closing() {
  model_.share_rows([&](int first, int last) { predict_closing(first, last); });
}

void ActiveSet::predict_closing(int first, int last) {
  const double tolerance = 1e-9 * model_.scale();
  for (int i = first; i < last; ++i) {
    const auto& r = model_.row(i);
    if (r.normal >= 0 || r.dead || states_[at(i)] != RowState::Lower || w_[at(i)] >= -tolerance) continue;
    states_[at(i)] = RowState::Free;
    for (int j = i + 1; j < model_.rows() && model_.row(j).normal == i; ++j) {
      const double z = model_.row(j).dead ? 0 : -w_[at(j)] / model_.row(j).D;
      const double bound = model_.row(j).mu * (-w_[at(i)] / r.D);
      states_[at(j)] = z > bound ? RowState::Upper : z < -bound ? RowState::Lower : RowState::Free;
    }
  }
}

void ActiveSet::stick_everything() {
  // A gap of g asks for b = -g/h below what gravity gives; half the largest |b| is a gap of millimetres at 60
  // Hz.
  const double separated = -0.5 * model_.scale();
  model_.share_rows([&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const auto& r = model_.row(i);
      RowState s = RowState::Free;
      if (r.normal < 0 && std::isfinite(r.lower) && r.lower >= 0 && r.b < separated) s = RowState::Lower;
      states_[at(i)] = s;
    }
  });
}

int ActiveSet::free_rows() const {
  return static_cast<int>(std::count(states_.begin(), states_.end(), RowState::Free));
}

double ActiveSet::offer(const double* lambda) {
  return judge(lambda, false);
}

double ActiveSet::offer() {
  return judge(lambda_.data(), true);
}

double ActiveSet::judge(const double* lambda, bool present) {
  const std::size_t n = at(model_.rows());
  scratch_.resize(n);
  scratch_w_.resize(n);
  std::atomic<bool> known = present;
  const double largest = model_.largest_of_rows([&](int first, int last) {
    // Rows whose bounds stay in the cache from one look to the next.
    constexpr int kRows = 512;
    double most = 0;
    bool same = true;
    for (int from = first; from < last; from += kRows) {
      const int to = std::min(last, from + kRows);
      std::copy(lambda + from, lambda + to, scratch_.data() + from);
      model_.project(from, to, scratch_.data());
      for (int i = from; i < to; ++i) {
        most = std::max(most, model_.row(i).D * std::fabs(scratch_[at(i)]));
        same &= scratch_[at(i)] == lambda[i];
      }
    }
    if (!same) known = false;
    return most;
  });
  // Of impulses so large that rounding hides what they leave nothing can be said.
  if (!(largest * std::numeric_limits<double>::epsilon() < kHighestFloor * model_.scale())) return kInfinity;
  if (!known) model_.evaluate(scratch_.data(), scratch_w_.data());
  const double residual = model_.residual(scratch_.data(), known ? w_.data() : scratch_w_.data());
  if (residual < best_residual_) {
    best_residual_ = residual;
    best_.swap(scratch_);
  }
  return residual;
}

bool ActiveSet::is_answer(double tolerance) {
  if (best_residual_ <= tolerance) return true;
  if (!std::isfinite(best_residual_)) return false;
  return best_residual_ <= kAcceptedFloors * model_.rounding_floor(best_.data());
}

// Whether a friction row has the state of its normal row, which does not stick.
bool ActiveSet::held_by_normal(int row) const {
  const auto& r = model_.row(row);
  return r.normal >= 0 && (r.mu == 0 || states_[at(r.normal)] != RowState::Free);
}

// Where the state of a row that does not stick holds its impulse, by that of its normal row.
template <class NormalImpulse>
double ActiveSet::bound(int row, const NormalImpulse& impulse) const {
  const auto& r = model_.row(row);
  const RowState s = states_[at(row)];
  if (r.normal < 0) return s == RowState::Lower ? r.lower : r.upper;
  const double side = s == RowState::Upper ? r.mu : s == RowState::Lower ? -r.mu : 0;
  return side * impulse(at(r.normal));
}

// Which rows stick is what g says: it is zero for all others.
void ActiveSet::set_weights(double eta, int first, int last) {
  for (int i = first; i < last; ++i) {
    const auto& r = model_.row(i);
    const RowState s = states_[at(i)];
    double g = 0, h = 0;
    if (!held_by_normal(i)) {
      if (s == RowState::Free)
        g = r.dead ? 0 : 1 / (eta * r.D + r.compliance);
      else if (r.normal >= 0)
        h = (s == RowState::Upper ? r.mu : -r.mu) * g_[at(r.normal)];
    }
    g_[at(i)] = g;
    h_[at(i)] = h;
  }
}

void ActiveSet::set_right_hand_side(int first, int last) {
  for (int i = first; i < last; ++i) {
    double k = 0;
    if (g_[at(i)] != 0)
      k = -g_[at(i)] * w_[at(i)];
    else if (states_[at(i)] != RowState::Free || held_by_normal(i))
      k = bound(i, [&](std::size_t normal) { return lambda_[normal] + k_[normal]; }) - lambda_[at(i)];
    k_[at(i)] = k;
  }
}

// Rows that stick take their change, the others go to their bounds.
void ActiveSet::move_impulses(int first, int last) {
  for (int i = first; i < last; ++i)
    if (g_[at(i)] != 0)
      lambda_[at(i)] += d_lambda_[at(i)];
    else if (states_[at(i)] != RowState::Free || held_by_normal(i))
      lambda_[at(i)] = bound(i, [&](std::size_t normal) { return lambda_[normal]; });
}

bool ActiveSet::step(double eta, SolveWork& work) {
  const bool fresh = !factored_ || eta != factored_eta_ || states_ != factored_states_;
  if (fresh || !weighted_) {
    model_.share_rows([&](int first, int last) { set_weights(eta, first, last); });
    weighted_ = true;
    if (!fresh) model_.take_weights(g_.data(), h_.data());
  }
  if (fresh) {
    const bool adapted = factored_ && eta == factored_eta_ && model_.adapt(g_.data(), h_.data(), work);
    if (!adapted) {
      factored_ = model_.factor(g_.data(), h_.data(), work);
      if (!factored_) return false;
    }
    factored_states_ = states_;
    factored_eta_ = eta;
    stale_ = adapted;
  }
  model_.share_rows([&](int first, int last) { set_right_hand_side(first, last); });
  model_.begin_solve(k_.data(), work);
  model_.move_and_evaluate(lambda_.data(), w_.data(), [&](int first, int last) {
    model_.finish_solve(first, last, k_.data(), g_.data(), h_.data(), d_lambda_.data());
    move_impulses(first, last);
  });
  add_regularisation(eta);
  return true;
}

void ActiveSet::add_regularisation(double eta) {
  if (!centre_) return;
  for (std::size_t i = 0; i < w_.size(); ++i)
    w_[i] += eta * model_.info()[i].D * (lambda_[i] - (*centre_)[i]);
}

bool ActiveSet::solve_regularised(const std::vector<double>& centre, double eta, int max_iterations,
                                  const SolveBudget& budget, SolveWork& work) {
  // More than this many iterations without a new least number of changes never led anywhere.
  constexpr int kPatience = 6;
  centre_ = &centre;
  model_.evaluate(lambda_.data(), w_.data());
  add_regularisation(eta);
  bool solved = false;
  int fewest = std::numeric_limits<int>::max(), waited = 0;
  for (int it = 0; it < max_iterations && !solved && !budget.spent(work); ++it) {
    if (!step(eta, work)) break;
    double size = 0;
    for (const double z : lambda_) size = std::max(size, std::fabs(z));
    if (!std::isfinite(size)) break;
    look_at_states({.impulse = 1e-11, .velocity = 1e-9});
    const int changes = change_states();
    work.pivots += changes;
    solved = changes == 0;
    if (changes < fewest) {
      fewest = changes;
      waited = 0;
    } else if (++waited > kPatience) {
      break;
    }
  }
  centre_ = nullptr;
  return solved;
}

double ActiveSet::linear_error() const {
  return model_.largest_of_rows([&](int first, int last) {
    double error = 0;
    for (int i = first; i < last; ++i)
      if (g_[at(i)] != 0) error = std::max(error, std::fabs(w_[at(i)]));
    return error;
  });
}

bool ActiveSet::refine(const Options& options, int steps, SolveWork& work, bool* solved) {
  // Below this the steps are long: so nearly redundant are the rows that the leap only finds where they end.
  constexpr double kLongestLeap = 1e12;
  const double enough = options.linear * options.target * model_.scale();
  if (eta_ == 0) eta_ = options.eta;
  double last = kInfinity;
  int leaps = 0;
  for (int k = 0; k < steps; ++k) {
    if (!step(eta_, work)) return false;
    const double error = linear_error();
    if (!(error < 1e100 * model_.scale())) return false;
    if (solved) *solved = error <= std::max(enough, options.target * model_.scale());
    if (error <= enough) break;
    if (error > 0.7 * last) {
      if (stale_) {
        // The kept factor is of other Jacobians; make it afresh.
        factored_ = false;
        last = kInfinity;
        continue;
      }
      if (error <= 0.25 * model_.rounding_floor(lambda_.data()) * model_.scale()) break;
      // Slow where eigenvalues of W are below eta, as under a heavy body: a smaller one is worth its factor.
      // An error that stays as it is belongs to rows that contradict each other: no eta helps.
      const double ratio = error / last;
      if (eta_ > kLeastEta && ratio < kContradiction && error > kWorthAFactor * model_.scale()) {
        eta_ = std::max(kLeastEta, 1e-2 * eta_);
        last = kInfinity;
        continue;
      }
      // What converges slowly, does so along one direction: go to the limit of the geometric series at once,
      // or to where the first row meets its bound. Without bounds, rows that contradict each other by less
      // than anybody asks for would press for that as hard as they can.
      const bool small = ratio >= kContradiction && error <= options.tolerance * model_.scale();
      if (!leap(ratio < 1 ? std::min(kLongestLeap, ratio / (1 - ratio)) : kLongestLeap, small)) break;
      last = kInfinity;
      // Neither it nor the two steps that showed the direction count where all is to be solved.
      if (steps >= kAllSteps && ratio >= kContradiction && leaps++ < kLeaps) k -= 2;
      continue;
    }
    last = error;
  }
  return true;
}

bool ActiveSet::leap(double length, bool to_bound) {
  // Ratio test on the rows that are free.
  double limit = length;
  int blocking = -1;
  RowState side = RowState::Lower;
  const auto test = [&](int i, RowState s, double distance, double speed) {
    if (speed > 0 && distance < limit * speed) {
      limit = std::max(0.0, distance / speed);
      blocking = i;
      side = s;
    }
  };
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    if (r.dead || states_[at(i)] != RowState::Free) continue;
    const double x = lambda_[at(i)], d = d_lambda_[at(i)];
    if (r.normal < 0) {
      test(i, RowState::Lower, x - r.lower, -d);
      test(i, RowState::Upper, r.upper - x, d);
    } else if (r.mu > 0 && states_[at(r.normal)] == RowState::Free) {
      const double bound = r.mu * lambda_[at(r.normal)], wider = r.mu * d_lambda_[at(r.normal)];
      test(i, RowState::Lower, bound + x, -(wider + d));
      test(i, RowState::Upper, bound - x, d - wider);
    }
  }
  // Beyond its bound already, by less than what counted as a contradiction: nothing to gain.
  if (!(limit > 1) || (to_bound && blocking < 0)) return false;
  for (int i = 0; i < model_.rows(); ++i) lambda_[at(i)] += limit * d_lambda_[at(i)];
  if (blocking >= 0) states_[at(blocking)] = side;
  model_.evaluate(lambda_.data(), w_.data());
  return true;
}

// In units of velocity.
double ActiveSet::largest_impulse() const {
  return std::max(model_.scale(), model_.largest_of_rows([&](int first, int last) {
    double most = 0;
    for (int i = first; i < last; ++i) most = std::max(most, model_.row(i).D * std::fabs(lambda_[at(i)]));
    return most;
  }));
}

int ActiveSet::look_at_states(const Eyes& eyes) {
  const double largest = largest_impulse();
  // Both in velocity units.
  const double below = eyes.impulse * largest, moving = eyes.velocity * model_.scale();
  found_.resize(model_.row_pieces());
  model_.share_row_pieces([&](int first, int last, std::size_t piece) {
    Found& found = found_[piece];
    found.due.clear();
    found.contradictions = found.due_contradictions = 0;
    look_at_states(first, last, below, moving, found);
  });
  int contradictions = 0;
  for (const Found& found : found_) contradictions += found.contradictions;
  return contradictions;
}

void ActiveSet::look_at_states(int first, int last, double below, double moving, Found& found) const {
  int normal_row = -1;
  RowState normal_state = RowState::Free;  // that it will have
  bool closing = false;
  for (int i = first; i < last; ++i) {
    const auto& r = model_.row(i);
    if (r.dead) continue;
    const RowState old = states_[at(i)];
    RowState s = old;
    const double lambda = lambda_[at(i)], w = w_[at(i)];
    bool with_normal = true;
    if (r.normal < 0) {
      closing = false;
      if (old == RowState::Free) {
        if ((r.lower - lambda) * r.D > below) s = RowState::Lower;
        if ((lambda - r.upper) * r.D > below) s = RowState::Upper;
      } else if (r.lower < r.upper) {
        if (old == RowState::Lower ? w < -moving : w > moving) s = RowState::Free;
        closing = s == RowState::Free;
      }
      normal_row = i;
      normal_state = s;
    } else if (r.mu > 0) {
      const std::size_t normal = at(r.normal);
      if (closing) {
        // A contact that closes sticks or slips as its own two rows alone would have it.
        const double z = -w / r.D, bound = r.mu * (-w_[normal] / model_.row(r.normal).D);
        const RowState predicted = z > bound    ? RowState::Upper
                                   : z < -bound ? RowState::Lower
                                                : RowState::Free;
        if (predicted != old) found.due.push_back({i, predicted});
        continue;
      }
      if (states_[normal] != RowState::Free) continue;
      // One whose normal row opens contradicts, and goes along with that.
      with_normal = r.normal != normal_row || normal_state == RowState::Free;
      const double bound = r.mu * std::max(0.0, lambda_[normal]);
      if (old == RowState::Free) {
        if ((lambda - bound) * r.D > below) s = RowState::Upper;
        if ((-bound - lambda) * r.D > below) s = RowState::Lower;
      } else if (old == RowState::Upper ? w > moving : w < -moving) {
        s = RowState::Free;
      }
    }
    if (s == old) continue;
    ++found.contradictions;
    if (!with_normal) continue;
    ++found.due_contradictions;
    found.due.push_back({i, s});
  }
}

int ActiveSet::change_states() {
  int contradictions = 0;
  for (const Found& found : found_) {
    for (const Due& due : found.due) states_[at(due.row)] = due.state;
    contradictions += found.due_contradictions;
  }
  return contradictions;
}

// Where a few rows change state, others around them do, too, and so on. Before all rows are solved for again,
// those near the changed ones are followed alone, with the answer of all others to them, until no state among
// them contradicts: only the states are kept of that, where there is no such end those that came nearest.
// Returns whether there is.
bool ActiveSet::settle_around(const Eyes& eyes, SolveWork& work) {
  constexpr int kRounds = 24, kPatience = 4;
  constexpr std::size_t kFewLeft = 4;
  model_.share_rows([&](int first, int last) { set_weights(eta_, first, last); });
  weighted_ = false;
  if (!model_.adapt(g_.data(), h_.data(), work)) return false;
  BodySpaceModel::Surroundings around(model_);
  const std::vector<int>& rows = around.rows();
  const double below = eyes.impulse * largest_impulse(), moving = eyes.velocity * model_.scale();
  // The last step solved w + eta D (lambda - centre) = 0 for the rows that were free.
  around_.resize(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::size_t i = at(rows[r]);
    around_[r] = {lambda_[i], w_[i], w_[i] + eta_ * model_.info()[i].D * d_lambda_[i]};
    w_[i] = around_[r][2];
  }
  Found found;
  // What contradicts the present states, as far as it is near; false if that cannot be told.
  const auto look = [&] {
    for (const int i : rows) set_weights(eta_, i, i + 1);
    for (const int i : rows) {
      const auto& r = model_.row(i);
      const bool other = states_[at(i)] != factored_states_[at(i)] ||
                         (r.normal >= 0 && states_[at(r.normal)] != factored_states_[at(r.normal)]);
      k_[at(i)] = 0;
      if (other) set_right_hand_side(i, i + 1);
    }
    work.visits += 10 * static_cast<double>(rows.size());
    if (!around.follow(g_.data(), h_.data(), k_.data())) return false;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      double d_w = 0;
      around.change(static_cast<int>(r), d_lambda_[at(rows[r])], d_w);
      move_impulses(rows[r], rows[r] + 1);
      w_[at(rows[r])] += d_w + eta_ * model_.row(rows[r]).D * (lambda_[at(rows[r])] - around_[r][0]);
    }
    found.due.clear();
    for (std::size_t r = 0; r < rows.size();) {
      const int first = rows[r];
      int last = first;
      for (; r < rows.size() && rows[r] == last; ++r) ++last;
      look_at_states(first, last, below, moving, found);
    }
    for (std::size_t r = 0; r < rows.size(); ++r) {
      lambda_[at(rows[r])] = around_[r][0];
      w_[at(rows[r])] = around_[r][2];
    }
    return true;
  };
  std::vector<RowState>& best = around_states_;
  std::size_t fewest = rows.size() + 1;
  const auto keep = [&] {
    if (found.due.size() >= fewest) return false;
    fewest = found.due.size();
    best.clear();
    for (const int i : rows) best.push_back(states_[at(i)]);
    return true;
  };
  const auto go_back = [&] {
    for (std::size_t r = 0; r < rows.size(); ++r) states_[at(rows[r])] = best[r];
  };
  int waited = 0;
  for (int round = 0; round < kRounds && waited < kPatience && fewest > 0 && look(); ++round) {
    waited = keep() ? 0 : waited + 1;
    if (fewest > 0)
      for (const Due& due : found.due) states_[at(due.row)] = due.state;
  }
  // Contacts that open and close in turn may slip the other way: each state of each of the last few friction
  // rows.
  for (std::size_t before = kFewLeft + 1; fewest > 0 && fewest < before;) {
    before = fewest;
    go_back();
    if (!look()) break;
    const std::vector<Due> left = found.due;
    for (const Due& due : left) {
      if (model_.row(due.row).normal < 0) continue;
      for (const RowState s : {RowState::Free, RowState::Lower, RowState::Upper}) {
        if (fewest < before || states_[at(due.row)] == s) continue;
        states_[at(due.row)] = s;
        if (look()) keep();
        go_back();
      }
    }
  }
  if (fewest <= rows.size()) go_back();
  for (std::size_t r = 0; r < rows.size(); ++r) w_[at(rows[r])] = around_[r][1];
  return fewest == 0;
}

void ActiveSet::record(SolveTrace* trace, double residual, int pivots) const {
  if (!trace) return;
  SolveIteration it;
  it.residual = residual;
  it.pivots = pivots;
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    const bool is_free = states_[at(i)] == RowState::Free;
    if (r.normal < 0)
      ++(is_free ? it.stick : it.open);
    else if (!is_free && states_[at(r.normal)] == RowState::Free)
      --it.stick, ++it.slip;
  }
  trace->iterations.push_back(it);
}

bool ActiveSet::run(const Options& options, const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  int fewest = -1, waited = 0;
  Eyes eyes;
  bool fine = false, settled = false;
  // Whatever ends the run, an iterate that is good enough ends the search.
  const auto accepted = [&] { return is_answer(options.tolerance); };
  for (int it = 0; it < options.max_iterations; ++it) {
    if (budget.spent(work) && !(factored_ && states_ == factored_states_)) return accepted();
    // One step leaves impulses open that W hardly resists, and changes what has settled; a second one is only
    // taken early: the end asks for it, too.
    bool solved = false;
    if (!refine(options, fine ? 6 : settled ? 2 : 1, work, &solved)) return accepted();
    // Impulses carry the rounding of velocities amplified by 1/eta; only clear contradictions count at first.
    int changes = look_at_states(eyes);
    if (trace) record(trace, model_.residual(lambda_.data(), w_.data()), changes);
    if (changes == 0) {
      // The linear problem is the right one; solve it to the end, then look with sharper eyes.
      if (!(solved && options.few > 0) && !refine(options, kAllSteps, work)) return accepted();
      const double residual = offer();
      if (residual <= options.enough) return true;
      const double floor = model_.rounding_floor(lambda_.data());
      if (residual <= floor) return true;
      // What is far smaller than the residual is not what it is made of.
      const double sharp = std::max(floor, std::min(kSharp * residual, Eyes().velocity));
      eyes = {.impulse = sharp * model_.scale() / largest_impulse(), .velocity = sharp};
      changes = look_at_states(eyes);
      if (fine && changes == 0) return accepted();
      fine = true;
      fewest = -1;
    }
    if (it == 0 && changes > options.most) return accepted();
    if (options.must_fall && it == 1 && fewest >= 0 && changes >= fewest) return accepted();
    if (fewest >= 0 && changes > options.growth * fewest + 4 + options.few) return accepted();
    if (fewest >= 0 && changes >= fewest) {
      if (++waited > options.patience + (changes <= options.few ? kFewPatience : 0)) return accepted();
    } else {
      waited = 0;
    }
    fewest = fewest < 0 ? changes : std::min(fewest, changes);
    work.pivots += change_states();
    settled = changes <= options.few && settle_around(eyes, work);
  }
  return accepted();
}

}  // namespace skerry
