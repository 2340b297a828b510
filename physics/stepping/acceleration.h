// SPDX-License-Identifier: MIT
//
// The contact problem at acceleration level: forces and accelerations of an island at one instant.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "physics/stepping/applied_forces.h"
#include "physics/stepping/bilateral_forces.h"
#include "physics/stepping/contact_mode.h"
#include "physics/stepping/sparse_forces.h"
#include "physics/stepping/stepper.h"

namespace skerry {

/// Forces of a mode, and what tells when the mode ends. All by the mode's numbers.
struct ModeForces {
  std::vector<std::array<double, 3>> acceleration;  ///< of each body
  std::vector<ContactKinematics> points;
  std::vector<double> point_force;  ///< normal forces [N]; 0 for points that are not closed
  std::vector<double> grip_force;   ///< friction [N] or rolling moment [N m]
  std::vector<double> grip_limit;   ///< largest possible one
  std::vector<double> grip_speed;   ///< of sliding [m/s] or rolling [rad/s]
  std::vector<JointRow> rows;       ///< joint rows as they are now
  std::vector<double> row_force;    ///< of each of them [N or N m]
  double scale = 0;                 ///< a large force of this system [N]
};

/// The index-1 problem of an island: constraints are differentiated twice,
///
///   J a + bias = 0,   a = a_ext + M^-1 (J + J_slip)' lambda,
///
/// with bias = (dJ/dt) v in closed form, and J_slip the friction that sliding contacts add to their normal
/// forces [Pfeiffer & Glocker 1996, ch. 5].
class AccelerationProblem {
 public:
  /// State vector: (x, y, angle, vx, vy, omega) of each body, then the impulses of the mode: one a point, one
  /// a grip, one a row of a joint.
  using State = std::vector<double>;

  AccelerationProblem(const WorldState& state, const Island& island, IslandResult& result);
  ~AccelerationProblem();

  State gather(const ContactMode& mode) const;  ///< from the bodies; impulses are zero
  void scatter(const State& y, WorldState& state) const;
  BodyMotion motion(std::uint32_t body, double elapsed, const State& y) const;
  JointEnd joint_end(std::uint32_t body, double elapsed, const State& y) const;

  /// Forces and accelerations of `mode` at (elapsed, y). @return false if there are none, or not finite
  bool evaluate(const ContactMode& mode, double elapsed, const State& y, ModeForces& out) const;
  void derivative(const State& y, const ModeForces& forces, State& dy) const;

  /// Decides which of the points stay closed, which grips and motors hold and which limits carry, by one
  /// solve of the complementarity problem of the accelerations with the world's solver.
  /// @param mode  its points, grips and joints are candidates; grips that move already have a sign
  /// @return false if the solver found no answer
  bool choose(ContactMode& mode, double elapsed, const State& y) const;

  /// The contact problem that `forces` solve, for an observer. They act for `h`: b is in m/s and lambda in N
  /// s, as in the problems of other steppers, and `b = -h (J a + bias)` of the motion without them. Where a
  /// contact slides, b also counts the speed that would have to go for it to stick, or as much as is needed
  /// for friction to stay at its bound.
  void equations(const ContactMode& mode, double elapsed, const State& y, const ModeForces& forces, double h,
                 IslandSystem& system, std::vector<double>& lambda) const;

  /// What the evaluations so far cost, in unknown forces of body space (about 0.3 us each): a dense
  /// elimination of n counts as n^3 / 100, one of n rows of joints alone as n / 4.
  double work() const { return work_; }

 private:
  struct AccelerationRow {
    int a = -1, b = -1;
    std::array<double, 3> Ja{}, Jb{};
    double bias = 0;
  };
  struct Geometry;
  struct Unknown;
  struct Scratch;
  struct Places;

  bool geometry(const ContactMode& mode, double elapsed, const State& y, Geometry& out) const;
  /// Accelerations by everything that is known: external forces, springs, motors at their largest force.
  void apply(const ContactMode& mode, double elapsed, const Geometry& g,
             std::vector<std::array<double, 3>>& acceleration) const;
  /// The complementarity problem of the accelerations of all that a mode may hold. @pre `system` is empty
  void set_up(const ContactMode& mode, const Geometry& g, const std::vector<std::array<double, 3>>& free,
              IslandSystem& system, Places& places) const;
  /// What the acceleration of ground that moves as told adds to a row's bias.
  double ground_bias(std::uint32_t body, const std::array<double, 3>& J, double elapsed) const;
  std::array<double, 3> inverse_mass(int k) const;
  AccelerationRow contact_row(const Contact& contact, Vec2 direction, Vec2 where, double bias, double elapsed,
                              const BodyMotion& a, const BodyMotion& b) const;

  /// Values of the unknown forces; `free`: the accelerations without them. @return false if there are none
  bool solve_dense(const std::vector<Unknown>& unknowns, const std::vector<std::array<double, 3>>& free,
                   std::vector<double>& lambda) const;
  bool solve_sparse(const std::vector<Unknown>& unknowns, const std::vector<std::array<double, 3>>& free,
                    std::vector<double>& lambda) const;
  bool solve_joints(const std::vector<Unknown>& unknowns, const std::vector<std::array<double, 3>>& free,
                    std::vector<double>& lambda) const;
  bool solve_many(const std::vector<Unknown>& unknowns, const std::vector<std::array<double, 3>>& free,
                  std::vector<double>& lambda) const;

  const WorldState& state_;
  const Island& island_;
  IslandResult& result_;
  bool varying_;                    ///< forces depend on the state
  mutable double work_ = 0;         ///< see `work`
  mutable SparseForces sparse_;     ///< keeps the analysis of the body graph
  mutable BilateralForces joints_;  ///< and this one that of the joints
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace skerry
