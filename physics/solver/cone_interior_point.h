// SPDX-License-Identifier: MIT
//
// Interior point for contacts with Coulomb friction, for bounded work: from the impulses that sweeps ended
// with, some ten to twenty Newton steps, each with one factor on the graph of the bodies.
//
// The plane's friction cone has two edges, lambda = l+ (n + mu t) + l- (n - mu t) with l+, l- >= 0, and with
// De Saxce's shift Coulomb's law is complementarity along them:
//
//   0 <= l+-  perp  s+- = w_n + mu |w_t| +- mu w_t >= 0,      w = W lambda - b      [De Saxce & Feng 1998]
//
// Steps of Mehrotra's predictor and corrector on l s = tau [Mehrotra 1992], after which products stay near
// the path [Wachter & Biegler 2006, eq. 16], in the unknowns of the bodies:
//
//   (1 + sum (l/s) J+-' (J+- + theta mu J_t)) dy = ...,      theta = w_t / (|w_t| + smoothing)
//
// Held, the shift leaves a convex problem, and a symmetric matrix; but then what slides converges only as
// fast as the shift does. With its slope theta it is Newton's method for Coulomb's law itself; the shorter
// the last step was cut, the less of the slope is taken, down to seven tenths. What the predictor changes in
// the shift the corrector knows. The start is the point on the central path next to what is given [Chen &
// Harker 1993; Kanzow 1996]: l - s is kept.
//
// Without the shift the problem is that of associated sliding, in which what slides moves apart: convex, with
// a symmetric matrix, so that the path always arrives, at half the price of a factor. Where nothing slides,
// its answer is Coulomb's, too. Rows of joints go along (`solver/cone_joints.h`).
//
// In units of velocity the impulse between a light body and a heavy one that it bears is as many times larger
// as that is heavier. Products l s in proportion to D_n^1/2, halfway between velocities and energies, let
// such a path be followed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/islands/island_system.h"
#include "physics/solver/block_ldlt.h"
#include "physics/solver/block_sweeps.h"
#include "physics/solver/cone_incidence.h"
#include "physics/solver/cone_joints.h"
#include "physics/solver/solver.h"

namespace skerry {

class ConeInteriorPoint {
 public:
  /// Takes an island. @param threads  share the steps of a large one; the bits are the same
  /// @return false where it has no contact, rolling resistance, or contacts that give
  bool assign(const IslandSystem& system, SolveWork& work, ThreadPool* threads = nullptr);
  /// Counted work of one step.
  double step_cost() const { return step_cost_; }

  enum class Sliding : std::uint8_t { Coulomb, Associated };
  /// Begins next to impulses within their bounds. @param centre  root of the products l s [m/s]
  void start(std::span<const double> lambda, double centre, Sliding sliding = Sliding::Coulomb);
  /// One Newton step. @return how much of it could be taken; 0 where the factor failed
  double step(SolveWork& work);
  /// Root of the mean product l s, over its weight: how far the central path still has to go [m/s].
  double centre() const;
  /// Root of what sliding takes from the bodies, as the mean product of impulses along the edges and De
  /// Saxce's shift, over its weight [m/s]: by so much the answer of the associated problem misses Coulomb's.
  double sliding() const;
  /// The impulses, within their bounds.
  void get(std::vector<double>& lambda) const;

 private:
  /// Groups of contacts, and bodies, that a thread takes at a time.
  static constexpr std::size_t kGroupsAPiece = 256, kBodiesAPiece = 256;
  struct Kernels;
  struct alignas(32) Contact {
    Vec4 n_low, n_high, t_low, t_high;  ///< rows over their root, velocities by the roots of the masses
    double n_root, t_root;              ///< D^1/2
    int low, high, block;               ///< elimination positions and off-diagonal block, or -1
    int row;                            ///< of the system; its friction is the next
    bool rough;
  };
  /// Four contacts, one a lane, both edges; all in velocity units: l is D_n times the impulse. Lanes without
  /// a contact are open ones on the ground.
  struct alignas(32) Group {
    Vec4 mu, unit, inverse_unit, b_n, b_t;  ///< friction of the scaled rows; D_n^1/2 and its inverse
    Vec4 weight, inverse_weight;            ///< of the products l s
    Vec4 u_n, u_t, theta, shift;
    Vec4 l[2], s[2], inverse_s[2], inverse_l[2];
    Vec4 inverse[2];  ///< of s, with a proximal term
    Vec4 gap[2];      ///< s+- wanted - s
    Vec4 rest[2];     ///< second-order term of the corrector
    Vec4 dl[2], ds[2], du_t;
    Vec4 W, S, B, E;      ///< of the matrix
    Vec4 push_n, push_t;  ///< impulses that act on the bodies
  };
  void push();
  /// Finds the direction towards l s = target - rest. @return by how much the fastest falls, of what there is
  double direct(double target);
  double take_step();

  ThreadPool* threads_ = nullptr;
  bool shifts_ = true;
  int nodes_ = 0;
  double step_cost_ = 0, last_length_ = 1;
  int rows_ = 0;
  double products_ = 0;  ///< how many there are
  ConeJoints joints_;
  std::vector<Contact> contacts_;
  std::vector<Group> groups_;
  std::vector<BodyVector> pieces_;  ///< scratch: sums or maxima of groups, by piece
  ConeIncidence incidence_;
  std::vector<BodyVector> mass_;  ///< M^-1/2, by position; zero for the ground
  std::vector<BodyVector> y_;     ///< scratch: one a position, and the ground's
  std::vector<std::array<int, 2>> edges_;
  BlockPattern pattern_;
  BlockFactor factor_;
};

/// Improves what sweeps came to by as many steps as fit into the work, and a few sweeps; what is better stays
/// in `sweeps`.
/// @param limit  on `work`, which goes on from what it is @param threads  may be null
/// @param violation  that is left [m/s]
/// @return false, and nothing happened, where it does not fit into the work, or the rows are of other kinds
bool improve_by_interior_point(const IslandSystem& system, double limit, ThreadPool* threads,
                               BlockSweeps& sweeps, double& violation, SolveWork& work);

}  // namespace skerry
