// SPDX-License-Identifier: MIT
//
// Parametric pivoting in body space: the sure way through hard states, one state at a time.
#pragma once

#include "physics/solver/body_space_active_set.h"

namespace skerry {

struct PathOptions {
  double tolerance = 1e-10;  ///< relative residual of the polished answer
  double eta = 1e-2;         ///< first proximal weight relative to D
  int moves = 24;            ///< of the proximal centre
};

/// Proximal steps from `active.best()`, each solved by following a path (below), eta falling; when a path
/// does not arrive, eta rises. Each centre is offered to the active set, which ends with the exact answer.
/// @return whether the answer is in `active.best()`
bool follow_paths(BodySpaceModel& model, ActiveSet& active, const PathOptions& options,
                  const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

/// The same for a problem that has changed since `start` [n] solved it: two short paths, with a larger weight
/// and, from the end of that, with a small one, then the active set. They get through where a contact that
/// slipped, or stuck, makes the linear problem of the last states nearly singular, and its answer changes
/// hundreds of others. @param pivots  of each path at most
bool follow_path_from(const std::vector<double>& start, double tolerance, int pivots, BodySpaceModel& model,
                      ActiveSet& active, const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

/// Lemke's method in body space [Lemke 1965; Stewart & Trinkle 1996; Anitescu & Potra 1997]: a path from the
/// impulses zero, all contacts open, then proximal steps that go on from its states. The matrix of Coulomb's
/// law is copositive, so that the first path arrives, however often it folds; what is struck takes some
/// thousands of pivots. Ties are broken by wanted velocities that are off by up to a few billionths of the
/// largest, and stay off: the answer is known to that, and offered to the active set.
/// @return whether `active.best()` is within `tolerance`; it may have improved all the same
bool pivot_from_nothing(double tolerance, BodySpaceModel& model, ActiveSet& active, const SolveBudget& budget,
                        SolveWork& work, SolveTrace* trace);

/// Follows the solution of a regularised problem
///
///   0 in w(lambda) + eta D (lambda - centre) + p + t r + N(lambda),  w = W lambda - b, exact Coulomb states
///
/// from t = 1, where r is chosen such that a given guess is the solution, to t = 0. For fixed states the
/// solution is linear in t; where a row meets its bound its state changes, and the path goes on in the next
/// piece, backwards in t where it folds [parametric and complementary pivoting: Lemke 1965; Cottle, Pang &
/// Stone 2009, sec. 4.5; Eaves 1976]. The guess is moved off its bounds by a fixed sequence of dice, so that
/// two rows do not meet theirs at once before the very end.
///
/// Each piece costs one factorisation with the sparsity of the bodies. From a guess of which few states are
/// wrong the path is short, wherever a Newton method may cycle among them.
class PathFollower {
 public:
  enum class End { Reached, Ray, Limit };

  explicit PathFollower(BodySpaceModel& model) : model_(model) {}

  /// @param centre  n impulses
  /// @param guess   n impulses to start from
  /// @param margin  size of the dice, relative to the scale of the problem
  /// @param covered  start with all contacts open, as Lemke's method does, whatever the velocities of the
  /// guess
  /// @return whether `impulses` solves the problem with t = 0
  End run(const std::vector<double>& centre, double eta, const std::vector<double>& guess, double margin,
          bool covered, int max_pivots, const SolveBudget& budget, SolveWork& work);

  /// Goes on from the end of the last path, which is the next centre, with another weight, and with `share`
  /// of what the wanted velocities are off.
  End go_on(double eta, double share, const SolveBudget& budget, SolveWork& work);
  /// Velocities p that the next paths are off by at most, relative to the scale of the problem; contacts are
  /// wanted to open by them. A path whose ties come together at its end needs them.
  void set_off(double off) { off_ = off; }

  const std::vector<double>& impulses() const { return lambda_; }
  const std::vector<RowState>& states() const { return states_; }
  int pivots() const { return pivots_; }

 private:
  void start(const std::vector<double>& centre, double eta, const std::vector<double>& guess, double margin,
             bool covered);
  End follow(int max_pivots, int patience, const SolveBudget& budget, SolveWork& work);
  bool factor(SolveWork& work);
  void direction(const std::vector<double>& wanted, std::vector<double>& d_lambda, SolveWork& work);
  struct Event {
    double length = kInfinity;
    double speed = 0;
    int row = -1;
    RowState state = RowState::Free;
  };
  /// @param last  the row that changed its state before, which cannot go back to `left` at once
  Event next_event(double sign, int last, RowState left) const;
  double speed_inwards(int row) const;
  void flip(const Event& event);

  BodySpaceModel& model_;
  double eta_ = 0, t_ = 0, off_ = 0;
  int pivots_ = 0;
  std::vector<RowState> states_;
  std::vector<double> lambda_, w_, r_, g_, h_, k_;  // w includes the regularisation, p and t r
  std::vector<double> d_lambda_, d_w_, wanted_, centre_, p_;
};

}  // namespace skerry
