// SPDX-License-Identifier: MIT
//
// A contact problem packed for solving in body space: the unknowns are the 3 velocities of each moving body,
// and the graph of the bodies, not of the contacts, decides the fill. Redundant contacts therefore cost
// nothing.
//
// One linear step of every method of this family has the form, row by row,
//
//   d_lambda_i = k_i - g_i (J_i dv) - h_i (J_n dv),      M dv = J^T d_lambda
//
// with n the normal row of a friction or rolling row. Eliminating d_lambda leaves the 3 x 3 block system
//
//   (M + sum g_i J_i^T J_i + sum h_i J_i^T J_n) dv = J^T k
//
// which is symmetric positive definite if all h vanish. The active set method takes g = 1 / (eta D) for
// active rows, the interior point method the ratios of its slacks.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "physics/islands/island_system.h"
#include "physics/solver/block_ldlt.h"
#include "physics/solver/local_update.h"
#include "physics/solver/row_quads.h"
#include "physics/solver/solver.h"
#include "physics/spare.h"
#include "physics/thread_pool.h"

namespace skerry {

class BodySpaceModel {
 public:
  BodySpaceModel() = default;
  BodySpaceModel(const BodySpaceModel&) = delete;
  BodySpaceModel& operator=(const BodySpaceModel&) = delete;

  using RowInfo = RowQuads::Info;

  /// Threads that share what is done for each row and body of a large problem, and its factor; null: the
  /// caller's alone. The bits are the same.
  void use_threads(ThreadPool* threads) { threads_ = threads; }
  ThreadPool* threads() const { return threads_; }
  /// Calls `item(first, last, piece)` for pieces of the rows, at the same time where threads share them; a
  /// row whose bounds another one scales is in the piece of that. Pieces are numbered from 0.
  template <class Item>
  void share_row_pieces(const Item& item) const {
    share(threads_, info_.size(), kRowsAPiece, [&](std::size_t from, std::size_t to) {
      item(beginning_of_piece(from), beginning_of_piece(to), from / kRowsAPiece);
    });
  }
  std::size_t row_pieces() const { return shared() ? (info_.size() - 1) / kRowsAPiece + 1 : 1; }
  /// The same without the number.
  template <class Item>
  void share_rows(const Item& item) const {
    share_row_pieces([&](int first, int last, std::size_t) { item(first, last); });
  }
  /// The largest of what `item(first, last)` gives for such pieces, at least 0; NaN where one is.
  template <class Item>
  double largest_of_rows(const Item& item) const {
    if (!shared()) return item(0, rows());
    Spare<std::vector<double>> found;
    found->assign(row_pieces(), 0);
    share_row_pieces([&](int first, int last, std::size_t piece) { (*found)[piece] = item(first, last); });
    double largest = 0;
    for (const double each : *found)
      if (!(each <= largest)) largest = each;
    return largest;
  }
  /// What comes next is another problem, and is solved as if nothing had been before, to the bit; the memory
  /// and the analysis of a graph that is just the same serve again.
  void forget();
  /// Packs `system`; the ordering and the fill are kept if every pair of touching bodies is already in them.
  /// Returns the largest relative change of a Jacobian entry, diagonal or compliance since the last call, or
  /// infinity if the rows are not the same ones.
  double assign(const IslandSystem& system, SolveWork& work);

  int rows() const { return static_cast<int>(info_.size()); }
  int nodes() const { return nodes_; }
  const RowInfo& row(int i) const { return info_[static_cast<std::size_t>(i)]; }
  const std::vector<RowInfo>& info() const { return info_; }
  const BlockPattern& pattern() const { return pattern_; }
  /// Largest |b|, or 1 if all are zero: the scale of residuals.
  double scale() const { return scale_; }

  /// w = W lambda - b by way of the bodies; n values each.
  void evaluate(const double* lambda, double* w);
  /// The same for impulses that `move(first, last)` makes, piece by piece as in `share_rows`: what a piece is
  /// made of is pushed while it is in the cache.
  template <class Move>
  void move_and_evaluate(const double* lambda, double* w, const Move& move) {
    std::fill(pushed_.begin(), pushed_.end(), BodyVector{});
    if (shared()) {
      share_rows(move);
      push_all(lambda);
    } else {
      for (int first = 0; first < rows();) {
        const int last = beginning_of_piece(static_cast<std::size_t>(std::min(rows(), first + kCachedRows)));
        move(first, last);
        quads_.push(first, last, lambda, pushed_.data(), false);
        first = last;
      }
    }
    evaluate_pushed(lambda, w);
  }
  /// Copies the body velocities that the last `evaluate` found: one a position, and zero for the ground.
  void velocities(BodyVector* v) const { std::copy(pushed_.begin(), pushed_.end(), v); }
  /// Largest violation of the natural map, relative to `scale()`; see natural_map_residual.
  double residual(const double* lambda, const double* w) const;
  /// Clamps `lambda` to its bounds, normal rows before those that depend on them.
  void project(double* lambda) const;
  void project(int first, int last, double* lambda) const;
  /// Smallest relative residual that rounding lets one expect at `lambda`, `kHighestFloor` at most.
  double rounding_floor(const double* lambda);

  /// Assembles and factorises the block system for weights `g` and `h`. False if it is not regular.
  [[nodiscard]] bool factor(const double* g, const double* h, SolveWork& work);
  /// Whether the factor is so large that `adapt` can pay.
  bool is_adaptable() const;
  /// Makes the last factor that of other weights, where they differ in a few rows only and that is cheaper
  /// than a new one; what follows solves for the new weights, less exactly. False if it did not.
  [[nodiscard]] bool adapt(const double* g, const double* h, SolveWork& work);
  /// What a few rows that follow other laws do to the rows around them, as far as that is known since the
  /// last `adapt`: of rows between bodies that it had to do with.
  class Surroundings {
   public:
    /// @pre the last `adapt` of the model returned true
    explicit Surroundings(BodySpaceModel& model);
    /// The rows, ascending; those of a contact are all there or none.
    const std::vector<int>& rows() const { return rows_; }
    /// Gives rows the weights `g` and `h`, and lets the laws of those that differ from the factor's want `k`
    /// on top of where they are; all others keep to theirs. False, and nothing is known, where that are too
    /// many or it leaves a singular matrix.
    [[nodiscard]] bool follow(const double* g, const double* h, const double* k);
    /// By how much the impulse and the velocity w of `rows()[number]` change then.
    void change(int number, double& d_lambda, double& d_w) const;

   private:
    BodySpaceModel& model_;
    std::vector<int> rows_;
    std::vector<double> z_;       ///< of the rows of the update
    std::vector<double> beyond_;  ///< the same, by row of `rows_`
  };
  /// The same factor serves weights that have hardly changed.
  void take_weights(const double* g, const double* h);
  /// Computes `d_lambda` from `k` with the last factor. @param g, h  weights of that factor
  void solve(const double* k, const double* g, const double* h, double* d_lambda, SolveWork& work);
  /// The same in pieces: the bodies first, then the rows from `first` to before `last`, with the same
  /// weights; those at the same time, if that is wanted.
  void begin_solve(const double* k, SolveWork& work);
  void finish_solve(int first, int last, const double* k, const double* g, const double* h, double* d_lambda);

  /// u = J v - b for body velocities `v` (changes from the free ones), one a position and one for the ground.
  void row_velocities(const BodyVector* v, double* u) const;
  /// Computes `force` = J^T lambda - M v and returns its square in the norm of inv(M).
  double imbalance(const BodyVector* v, const double* lambda, BodyVector* force) const;
  /// Solves with the last factor, in place. @pre it was not adapted
  void solve_bodies(BodyVector* x, SolveWork& work) const;

  /// Work of a factor and of a solve, counted where they are made; here for those that are made elsewhere.
  void count_factor(bool general, SolveWork& work) const;
  void count_solve(SolveWork& work) const;

  void fields(Archive& a) {
    [[maybe_unused]] auto& [threads, nodes, scale, node_of_body, position_of_body, pairs, normal_of_row,
                            quads, info, compliant, inverse_mass, velocity, pushed, pattern, factor, update,
                            factored_g, factored_h, law_k, law_g, law_h, extra, more, edges, analysed,
                            forgotten] = *this;
    a(nodes, scale, node_of_body, position_of_body, pairs, normal_of_row, quads, info, compliant,
      inverse_mass, velocity, pushed, pattern, analysed);
    if (a.reading() && analysed) factor.set_pattern(pattern);
    a(factor, update, factored_g, factored_h, law_g, law_h);
  }

 private:
  /// Rows that a thread takes at a time: some 10 us.
  static constexpr std::size_t kRowsAPiece = 2048;
  /// Bodies that it takes.
  static constexpr std::size_t kBodiesAPiece = 256;
  /// Rows whose Jacobians stay in the cache from one pass to the next.
  static constexpr int kCachedRows = 128;
  int beginning_of_piece(std::size_t row) const {
    while (row < info_.size() && !(normal_of_row_[row] < 0 && quads_.begins(static_cast<int>(row)))) ++row;
    return static_cast<int>(row);
  }
  bool shared() const { return threads_ != nullptr && threads_->threads() > 1 && info_.size() > kRowsAPiece; }
  template <class Item>
  void share_bodies(const Item& item) const {
    share(threads_, static_cast<std::size_t>(nodes_), kBodiesAPiece,
          [&](std::size_t from, std::size_t to) { item(static_cast<int>(from), static_cast<int>(to)); });
  }
  double take_rows(const IslandSystem& system);
  void push_all(const double* lambda) { push_all(lambda, pushed_.data()); }
  void push_all(const double* lambda, BodyVector* v, bool sizes = false);
  void evaluate_pushed(const double* lambda, double* w);
  bool add_to_update(int row, double g, double h);
  void begin_adapted(const double* k);

  ThreadPool* threads_ = nullptr;
  int nodes_ = 0;
  double scale_ = 1;
  std::vector<int> node_of_body_, position_of_body_;
  std::vector<std::array<int, 2>> pairs_;  // body pairs of the rows, for recognising the graph
  std::vector<int> normal_of_row_;
  RowQuads quads_;
  std::vector<RowInfo> info_;
  bool compliant_ = false;                // a row gives
  std::vector<BodyVector> inverse_mass_;  // by position; one more for the ground
  std::vector<BodyVector> velocity_;      // of the last solve; same size
  std::vector<BodyVector> pushed_;        // by the last impulses; same size
  BlockPattern pattern_;
  BlockFactor factor_;
  LocalUpdate update_;
  std::vector<double> factored_g_, factored_h_;  // weights of the factor
  std::vector<double> law_g_, law_h_, law_k_;  // of the adapted factor: what rows do in the eyes of the first
  std::vector<double> extra_;                  // scratch: what the changed ones do beyond
  std::vector<BodyVector> more_;               // scratch
  std::vector<std::array<int, 2>> edges_;      // of the graph that was analysed
  bool analysed_ = false;
  bool forgotten_ = false;
};

}  // namespace skerry
