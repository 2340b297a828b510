// SPDX-License-Identifier: MIT
//
// Active set method in body space with exact Coulomb states. A row is free (w = 0), or at its lower or upper
// bound; for a contact that reads open, sticking, slipping one way or the other. For given states the problem
// is linear; it is solved by proximal steps
//
//   (W_s + eta D) d_lambda = -w      on free rows, slipping ones tied to their normal,
//
// with one factor: repeating the step removes eta, and redundant rows (three points on an edge) do no harm:
// from zero the steps lead to nearly the smallest impulses. Then all states that contradict the signs change
// at once (a semismooth Newton step on the natural map [Alart & Curnier 1991; Hintermueller, Ito & Kunisch
// 2002]).
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "physics/solver/body_space_model.h"
#include "physics/solver/contact_states.h"

namespace skerry {

/// Limits on the work of one solve, shared by the methods that it tries in turn.
struct SolveBudget {
  int factorisations = 0;           ///< at most this many in all
  double visits = kInfinity;        ///< counted work at most
  std::function<bool()> exhausted;  ///< asked before each factorisation; empty: never
  bool spent(const SolveWork& work) const {
    return work.factorisations >= factorisations || work.visits >= visits || (exhausted && exhausted());
  }
};

class ActiveSet {
 public:
  struct Options {
    double eta = 1e-7;         ///< proximal weight relative to D to begin with
    double target = 1e-12;     ///< relative residual that is asked of linear solves
    double linear = 0.1;       ///< share of it that they may leave over
    double enough = 1e-12;     ///< relative residual at which no state is looked at more sharply
    double tolerance = 1e-10;  ///< relative residual that will do where the target is out of reach
    int max_iterations = 12;   ///< changes of states
    int patience = 1;          ///< iterations without fewer changes that are put up with
    double growth = 1.5;       ///< number of changes, relative to the least so far, at which to give up
    bool must_fall = false;    ///< whether to give up if the first changes leave no fewer contradictions
    double most = kInfinity;   ///< number of changes, the first time, beyond which to give up at once
    int few = 0;               ///< so many changes more are put up with, and so few three iterations longer
  };

  explicit ActiveSet(BodySpaceModel& model) : model_(model) {}

  /// Takes the sizes of the model. @param change  what BodySpaceModel::assign returned: when it is small the
  /// factor is kept, and refreshed only if the refinement does not converge with it.
  void reset(double change);

  /// Sets impulses [n], clamped to the bounds, and the velocities that follow.
  void set_impulses(const double* lambda);
  /// States that the natural map predicts from impulses and velocities.
  void predict_states();
  /// Like `predict_states`, but only closes open rows that approach; the other states are kept.
  void predict_closing();
  /// Every touching contact sticks. Contacts whose wanted change of velocity is far below zero have a gap.
  void stick_everything();

  /// Runs from the present states. Returns whether the tolerance or the rounding floor is reached; `best`
  /// then holds the answer. Otherwise `best` may still have improved.
  bool run(const Options& options, const SolveBudget& budget, SolveWork& work, SolveTrace* trace);
  /// Takes proximal steps for the present states without changing them; false if the factor fails.
  /// @param solved  if given, set to whether the last step solved the linear problem to the target
  bool refine(const Options& options, int steps, SolveWork& work, bool* solved = nullptr);

  /// Solves the regularised problem w + eta D (lambda - centre) from the present states and impulses, all of
  /// whose states change at once; false if the number of changes does not fall for a while.
  bool solve_regularised(const std::vector<double>& centre, double eta, int max_iterations,
                         const SolveBudget& budget, SolveWork& work);

  /// Number of rows whose state contradicts the present impulses or velocities.
  int contradictions() { return look_at_states({}); }
  int free_rows() const;
  const std::vector<double>& impulses() const { return lambda_; }
  const std::vector<double>& velocities() const { return w_; }
  std::vector<RowState>& states() { return states_; }

  /// The best iterate so far within the bounds, and its residual; zeros and infinity before one was offered.
  const std::vector<double>& best() const { return best_; }
  double best_residual() const { return best_residual_; }
  /// Whether the best iterate is within the tolerance, or as near to zero as rounding lets one come.
  bool is_answer(double tolerance);
  /// Offers an iterate; it is clamped to the bounds and kept if it is better. Returns its residual, infinite
  /// for impulses that ran away.
  double offer(const double* lambda);
  /// The same with the present impulses. @pre the present velocities are theirs, not of a regularised problem
  double offer();
  /// The factor is not of these states any more: another method used the model's.
  void drop_factor() { factored_ = false; }

  /// @pre when reading, the model is in the state that it had
  void fields(Archive& a) {
    [[maybe_unused]] auto& [model, states, factored_states, lambda, w, best, scratch, scratch_w, g, h, k,
                            d_lambda, around, around_states, found, centre, best_residual, factored_eta, eta,
                            factored, stale, weighted] = *this;
    // `centre` is null between solves, and what was found means nothing.
    a(states, factored_states, lambda, w, best, scratch, scratch_w, g, h, k, d_lambda, best_residual,
      factored_eta, eta, factored, stale, weighted);
  }

 private:
  /// How large a contradiction has to be to be seen.
  struct Eyes {
    double impulse = 1e-9;   ///< relative to the largest impulse
    double velocity = 1e-9;  ///< relative to the scale of residuals
  };
  void predict_states(int first, int last);
  void predict_closing(int first, int last);
  double judge(const double* lambda, bool present);
  bool held_by_normal(int row) const;
  template <class NormalImpulse>
  double bound(int row, const NormalImpulse& impulse) const;
  double linear_error() const;
  /// @param to_bound  only where a row meets its bound on the way
  bool leap(double length, bool to_bound);
  void add_regularisation(double eta);
  bool step(double eta, SolveWork& work);
  void set_weights(double eta, int first, int last);
  void set_right_hand_side(int first, int last);
  void move_impulses(int first, int last);
  /// @return how many states contradict the present impulses or velocities; what to change is noted
  int look_at_states(const Eyes& eyes);
  /// Makes the changes noted last. @return how many of them are contradictions
  int change_states();
  double largest_impulse() const;
  bool settle_around(const Eyes& eyes, SolveWork& work);
  void record(SolveTrace* trace, double residual, int pivots) const;

  /// A state that is to change.
  struct Due {
    int row;
    RowState state;
  };
  /// What a piece of the rows shows.
  struct Found {
    std::vector<Due> due;
    int contradictions = 0, due_contradictions = 0;
  };
  void look_at_states(int first, int last, double below, double moving, Found& found) const;

  BodySpaceModel& model_;
  std::vector<RowState> states_, factored_states_;
  std::vector<double> lambda_, w_, best_, scratch_, scratch_w_;
  std::vector<double> g_, h_, k_, d_lambda_;
  std::vector<std::array<double, 3>> around_;    // scratch: of some rows, numbers to go back to
  std::vector<RowState> around_states_;          // scratch: the best of theirs
  std::vector<Found> found_;                     // by piece of the rows, by the last look at them
  const std::vector<double>* centre_ = nullptr;  // of the regularised problem, or null
  double best_residual_ = kInfinity;
  double factored_eta_ = 0;
  double eta_ = 0;  // of the refinement; falls where that converges slowly; 0: not chosen yet
  bool factored_ = false;
  bool stale_ = false;
  bool weighted_ = false;  // g and h are of these rows
};

}  // namespace skerry
