// SPDX-License-Identifier: MIT
#include "physics/solver/path_following.h"

#include <algorithm>
#include <cmath>

#include "physics/index.h"

namespace skerry {
namespace {

// A path that went back and forth for so many pivots without a new smallest t never arrived.
constexpr int kPatience = 300;
// The path is begun at this distance from all bounds, later ones, from answers, at the second one.
constexpr double kFirstMargin = 0.1, kMargin = 1e-6;
constexpr double kEtaLeast = 1e-8, kEtaFalls = 0.1, kEtaRises = 30;
constexpr int kFailures = 3;
constexpr int kPolishIterations = 6;
// From a warm start: proximal weights and distances of the two paths, and how many pivots each may take. With
// the first weight nearly all paths arrive, but the states at its end are still wrong; the second one alone
// arrives less often.
constexpr double kWarmEta = 1e-3, kWarmMargin = 1e-3;
constexpr double kWarmEtaEnd = 1e-6;
// From nothing: the first proximal weight and how far the wanted velocities are off. Both fall to their last
// value, the weight where a path took few pivots. With a smaller weight at first, rounding turns paths back.
constexpr double kColdEta = 1e-6, kColdEtaLeast = 1e-8, kColdOff = 1e-8, kColdOffLeast = 1e-9;
constexpr double kOffFalls = 0.3;
constexpr int kFewPivots = 100, kColdMoves = 40, kColdTries = 2, kColdPivots = 50000, kOnPivots = 8000;
// Distance, relative to the scale, within which events are one.
constexpr double kTogether = 1e-14;

// Numbers in [1/2, 3/2), the same ones for every solve: multiples of the golden ratio, modulo one.
class Dice {
 public:
  double next() {
    value_ += 0.6180339887498949;
    if (value_ >= 1) value_ -= 1;
    return 0.5 + value_;
  }

 private:
  double value_ = 0;
};

}  // namespace

void PathFollower::start(const std::vector<double>& centre, double eta, const std::vector<double>& guess,
                         double margin, bool covered) {
  const std::size_t n = at(model_.rows());
  for (auto* v : {&w_, &r_, &g_, &h_, &k_, &d_lambda_, &d_w_, &wanted_}) v->assign(n, 0.0);
  states_.assign(n, RowState::Free);
  eta_ = eta;
  centre_ = centre;
  lambda_ = guess;
  pivots_ = 0;
  t_ = 1;
  model_.project(lambda_.data());
  model_.evaluate(lambda_.data(), w_.data());
  for (std::size_t i = 0; i < n; ++i) w_[i] += eta * model_.info()[i].D * (lambda_[i] - centre[i]);

  // States that the guess and its velocities predict, and impulses strictly inside what they allow.
  Dice dice;
  const double slack = margin * model_.scale();
  std::vector<double> wanted(n, 0.0);
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    const double off = slack * dice.next();
    RowState& s = states_[at(i)];
    double& z = lambda_[at(i)];
    if (r.dead) continue;
    double lower = r.lower, upper = r.upper;
    if (r.normal >= 0) {
      if (states_[at(r.normal)] != RowState::Free || r.mu == 0) {
        z = 0;
        wanted[at(i)] = w_[at(i)];
        continue;
      }
      upper = r.mu * lambda_[at(r.normal)];
      lower = -upper;
    }
    const double predicted = z - w_[at(i)] / r.D;
    if (predicted >= upper) s = RowState::Upper;
    if (predicted <= lower || (covered && r.normal < 0 && std::isfinite(lower))) s = RowState::Lower;
    if (s == RowState::Free) {
      // Half-way between near bounds at most.
      const double inside = std::min(off / r.D, 0.25 * (upper - lower));
      if (std::isfinite(lower)) z = std::max(z, lower + inside);
      if (std::isfinite(upper)) z = std::min(z, upper - inside);
    } else {
      z = s == RowState::Upper ? upper : lower;
      wanted[at(i)] = s == RowState::Upper ? std::min(w_[at(i)], -off) : std::max(w_[at(i)], off);
    }
  }
  p_.assign(n, 0.0);
  for (int i = 0; off_ > 0 && i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    if (!r.dead) p_[at(i)] = off_ * model_.scale() * (r.normal < 0 ? dice.next() : 2 * dice.next() - 2);
  }
  model_.evaluate(lambda_.data(), w_.data());
  for (std::size_t i = 0; i < n; ++i) {
    w_[i] += eta * model_.info()[i].D * (lambda_[i] - centre[i]) + p_[i];
    r_[i] = wanted[i] - w_[i];
    w_[i] = wanted[i];
  }
}

bool PathFollower::factor(SolveWork& work) {
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    const RowState s = states_[at(i)];
    double g = 0, h = 0;
    const bool held = r.normal >= 0 && (r.mu == 0 || states_[at(r.normal)] != RowState::Free);
    if (s == RowState::Free && !held && !r.dead) {
      g = 1 / (eta_ * r.D + r.compliance);
    } else if (s != RowState::Free && r.normal >= 0 && !held) {
      h = (s == RowState::Upper ? r.mu : -r.mu) * g_[at(r.normal)];
    }
    g_[at(i)] = g;
    h_[at(i)] = h;
  }
  return model_.factor(g_.data(), h_.data(), work);
}

// d_lambda such that w changes by `wanted` on the free rows, slipping rows tied.
void PathFollower::direction(const std::vector<double>& wanted, std::vector<double>& d_lambda,
                             SolveWork& work) {
  for (int i = 0; i < model_.rows(); ++i) {
    const auto& r = model_.row(i);
    const RowState s = states_[at(i)];
    double k = g_[at(i)] * wanted[at(i)];
    if (r.normal >= 0 && s != RowState::Free) {
      const bool held = r.mu == 0 || states_[at(r.normal)] != RowState::Free;
      k = held ? 0 : (s == RowState::Upper ? r.mu : -r.mu) * k_[at(r.normal)];
    }
    k_[at(i)] = k;
  }
  model_.solve(k_.data(), g_.data(), h_.data(), d_lambda.data(), work);
}

PathFollower::Event PathFollower::next_event(double sign, int last, RowState left) const {
  Event best;
  const double tie = 1e-13, together = kTogether * model_.scale();
  const double slowest = (off_ == 0 ? 1e-14 : 1e-13) * model_.scale();
  double limit = kInfinity;
  bool choosing = false;
  const auto test = [&](int row, RowState to, double distance, double speed) {
    // Distance to the bound and speed towards it, in velocity units.
    if (!(speed > slowest) || (row == last && to == left)) return;
    distance = std::max(0.0, distance);
    if (off_ == 0) {
      const double length = distance / speed;
      if (length < best.length - tie || (length < best.length + tie && speed > best.speed))
        best = {.length = std::min(length, best.length), .speed = speed, .row = row, .state = to};
    } else if (!choosing) {
      limit = std::min(limit, (distance + together) / speed);
    } else if (distance <= limit * speed && speed > best.speed) {
      best = {.length = distance / speed, .speed = speed, .row = row, .state = to};
    }
  };
  const auto sticks = [&](int normal) {
    for (int j = normal + 1; j < model_.rows() && model_.row(j).normal == normal; ++j)
      if (model_.row(j).mu > 0 && !model_.row(j).dead && states_[at(j)] == RowState::Free) return true;
    return false;
  };
  const auto look = [&] {
    for (int i = 0; i < model_.rows(); ++i) {
      const auto& r = model_.row(i);
      if (r.dead) continue;
      const RowState s = states_[at(i)];
      const double z = lambda_[at(i)], d = sign * d_lambda_[at(i)];
      if (r.normal < 0) {
        if (s == RowState::Free) {
          // What sticks slips before it opens: where both come at once, opening leads onto another path.
          if (off_ == 0 || !sticks(i)) test(i, RowState::Lower, (z - r.lower) * r.D, -d * r.D);
          test(i, RowState::Upper, (r.upper - z) * r.D, d * r.D);
        } else if (r.lower < r.upper) {
          const double side = s == RowState::Lower ? 1 : -1;
          test(i, RowState::Free, side * w_[at(i)], -side * sign * d_w_[at(i)]);
        }
      } else if (r.mu > 0 && states_[at(r.normal)] == RowState::Free) {
        if (s == RowState::Free) {
          const double bound = r.mu * lambda_[at(r.normal)], wider = r.mu * sign * d_lambda_[at(r.normal)];
          test(i, RowState::Upper, (bound - z) * r.D, (d - wider) * r.D);
          test(i, RowState::Lower, (bound + z) * r.D, (-d - wider) * r.D);
        } else {
          const double side = s == RowState::Lower ? 1 : -1;
          test(i, RowState::Free, side * w_[at(i)], -side * sign * d_w_[at(i)]);
        }
      }
    }
  };
  look();
  // Of those that come first nearly together the fastest [Harris 1973].
  choosing = true;
  if (off_ > 0) look();
  return best;
}

// Speed with which a row that just changed its state moves away from the change, as t falls.
double PathFollower::speed_inwards(int i) const {
  const auto& r = model_.row(i);
  const RowState s = states_[at(i)];
  if (s != RowState::Free) return s == RowState::Lower ? d_w_[at(i)] : -d_w_[at(i)];
  if (r.normal < 0) {
    const bool low = !std::isfinite(r.upper) || lambda_[at(i)] - r.lower < r.upper - lambda_[at(i)];
    return (low ? d_lambda_[at(i)] : -d_lambda_[at(i)]) * r.D;
  }
  const double side = lambda_[at(i)] >= 0 ? 1 : -1;
  return (r.mu * d_lambda_[at(r.normal)] - side * d_lambda_[at(i)]) * r.D;
}

void PathFollower::flip(const Event& event) {
  const auto& r = model_.row(event.row);
  states_[at(event.row)] = event.state;
  if (r.normal >= 0) return;
  // A contact that opens loses its friction; one that closes slips against its velocity.
  for (int j = event.row + 1; j < model_.rows() && model_.row(j).normal == event.row; ++j) {
    states_[at(j)] = RowState::Free;
    if (event.state != RowState::Free) {
      lambda_[at(j)] = 0;
    } else if (w_[at(j)] != 0) {
      states_[at(j)] = w_[at(j)] < 0 ? RowState::Upper : RowState::Lower;
    }
  }
}

PathFollower::End PathFollower::run(const std::vector<double>& centre, double eta,
                                    const std::vector<double>& guess, double margin, bool covered,
                                    int max_pivots, const SolveBudget& budget, SolveWork& work) {
  start(centre, eta, guess, margin, covered);
  return follow(max_pivots, off_ > 0 ? max_pivots : kPatience, budget, work);
}

PathFollower::End PathFollower::go_on(double eta, double share, const SolveBudget& budget, SolveWork& work) {
  for (std::size_t i = 0; i < lambda_.size(); ++i) {
    r_[i] = eta_ * model_.info()[i].D * (lambda_[i] - centre_[i]) + (1 - share) * p_[i];
    p_[i] *= share;
  }
  off_ *= share;
  centre_ = lambda_;
  eta_ = eta;
  t_ = 1;
  pivots_ = 0;
  return follow(kOnPivots, kOnPivots, budget, work);
}

PathFollower::End PathFollower::follow(int max_pivots, int patience, const SolveBudget& budget,
                                       SolveWork& work) {
  const std::size_t n = lambda_.size();
  int last = -1, since_progress = 0;
  RowState left = RowState::Free;  // by the last row
  double sign = 1, least_t = 1;
  while (true) {
    if (budget.spent(work) || pivots_ > max_pivots || since_progress > patience) return End::Limit;
    if (!factor(work)) return End::Limit;
    // Rounding of the last pieces is taken out first.
    for (std::size_t i = 0; i < n; ++i) wanted_[i] = -w_[i];
    direction(wanted_, d_lambda_, work);
    for (std::size_t i = 0; i < n; ++i) lambda_[i] += d_lambda_[i];
    // d/ds of w = 0 on the free rows, s = 1 - t: W d_lambda = r.
    direction(r_, d_lambda_, work);
    // Velocities now, and how they change.
    model_.evaluate(lambda_.data(), w_.data());
    model_.evaluate(d_lambda_.data(), d_w_.data());
    for (std::size_t i = 0; i < n; ++i) {
      const auto& r = model_.info()[i];
      w_[i] += eta_ * r.D * (lambda_[i] - centre_[i]) + p_[i] + t_ * r_[i];
      d_w_[i] += r.b + eta_ * r.D * d_lambda_[i] - r_[i];
    }
    // Where the path folds t grows for a while.
    if (last >= 0) sign = speed_inwards(last) >= 0 ? 1 : -1;
    const double remaining = sign > 0 ? t_ : kInfinity;
    Event event = next_event(sign, last, left);
    if (!(event.length < remaining)) {
      if (sign < 0) return End::Ray;
      for (std::size_t i = 0; i < n; ++i) lambda_[i] += remaining * d_lambda_[i];
      t_ = 0;
      return End::Reached;
    }
    for (std::size_t i = 0; i < n; ++i) {
      lambda_[i] += sign * event.length * d_lambda_[i];
      w_[i] += sign * event.length * d_w_[i];
    }
    t_ -= sign * event.length;
    if (!std::isfinite(t_) || t_ > 1e6) return End::Ray;
    since_progress = t_ < least_t - 1e-12 ? 0 : since_progress + 1;
    least_t = std::min(least_t, t_);
    left = states_[at(event.row)];
    flip(event);
    last = event.row;
    ++pivots_;
    ++work.pivots;
  }
}

namespace {

// The active set, from where a path ended.
bool polish(const PathFollower& path, double tolerance, ActiveSet& active, const SolveBudget& budget,
            SolveWork& work, SolveTrace* trace) {
  ActiveSet::Options limits;
  limits.target = std::min(1e-12, tolerance);
  limits.tolerance = tolerance;
  limits.max_iterations = limits.patience = kPolishIterations;
  const double residual = active.offer(path.impulses().data());
  if (trace) trace->iterations.push_back({.residual = residual, .pivots = path.pivots()});
  active.set_impulses(path.impulses().data());
  active.states() = path.states();
  const bool solved = active.run(limits, budget, work, trace);
  active.drop_factor();
  return solved;
}

}  // namespace

bool follow_path_from(const std::vector<double>& start, double tolerance, int pivots, BodySpaceModel& model,
                      ActiveSet& active, const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  PathFollower path(model);
  auto end = path.run(start, kWarmEta, start, kWarmMargin, false, pivots, budget, work);
  if (end == PathFollower::End::Reached) {
    const std::vector<double> centre = path.impulses();
    end = path.run(centre, kWarmEtaEnd, centre, kMargin, false, pivots, budget, work);
  }
  active.drop_factor();
  return end == PathFollower::End::Reached && polish(path, tolerance, active, budget, work, trace);
}

bool follow_paths(BodySpaceModel& model, ActiveSet& active, const PathOptions& options,
                  const SolveBudget& budget, SolveWork& work, SolveTrace* trace) {
  PathFollower path(model);
  const std::vector<double> zero(static_cast<std::size_t>(model.rows()), 0.0);
  std::vector<double> centre = active.best();
  double eta = options.eta, margin = kFirstMargin;
  int failures = 0;
  for (int move = 0; move < options.moves && !budget.spent(work); ++move) {
    const int limit = 2 * model.rows() + 300;
    auto end = path.run(centre, eta, centre, margin, false, limit, budget, work);
    // A path from a guess may lead nowhere; one on which all contacts are open at first is longer and surer.
    if (end == PathFollower::End::Ray)
      end = path.run(centre, eta, zero, kFirstMargin, true, limit, budget, work);
    active.drop_factor();
    if (end != PathFollower::End::Reached) {
      eta *= kEtaRises;
      if (++failures > kFailures) return false;
      continue;
    }
    if (polish(path, options.tolerance, active, budget, work, trace)) return true;
    centre = path.impulses();
    eta = std::max(kEtaLeast, eta * kEtaFalls);
    margin = kMargin;
  }
  return false;
}

bool pivot_from_nothing(double tolerance, BodySpaceModel& model, ActiveSet& active, const SolveBudget& budget,
                        SolveWork& work, SolveTrace* trace) {
  PathFollower path(model);
  const std::vector<double> zero(at(model.rows()), 0.0);
  double eta = kColdEta;
  path.set_off(kColdOff);
  auto end = path.run(zero, eta, zero, kFirstMargin, true, kColdPivots, budget, work);
  double off = kColdOff;
  int again = 0;
  for (int move = 0; move < kColdMoves && end == PathFollower::End::Reached; ++move) {
    active.drop_factor();
    if (polish(path, tolerance, active, budget, work, trace)) return true;
    if (budget.spent(work)) break;
    if (path.pivots() < kFewPivots) eta = std::max(kColdEtaLeast, eta * kEtaFalls);
    const double share = off > kColdOffLeast ? kOffFalls : 1;
    off *= share;
    const std::vector<double> centre = path.impulses();
    end = path.go_on(eta, share, budget, work);
    if (end == PathFollower::End::Reached || budget.spent(work) || ++again > kColdTries) continue;
    // A path from within may be a loop; one from nothing, with the same centre, is none.
    eta = kColdEta;
    path.set_off(off);
    end = path.run(centre, eta, zero, kFirstMargin, true, kColdPivots, budget, work);
  }
  active.drop_factor();
  return active.is_answer(tolerance);
}

}  // namespace skerry
