// SPDX-License-Identifier: MIT
//
// A world at rest: the forces of all contacts and joints at this instant, whether they are the only possible
// ones, and what begins to move if it does not stand.
//
// The contact problem of the step with accelerations in place of velocities and no restitution:
//
//   w = W lambda - b,  b = -J a_ext,  lambda_n >= 0,  |lambda_t| <= mu lambda_n,   a = a_ext + M^-1 J' lambda
//
// lambda are forces [N], w and a accelerations; the world stands if a = 0, that is J' lambda + f = 0.
// Velocities are taken for zero. It is solved by the same solvers as the step (physics/solver), with static
// friction first; where that is not enough it is solved again with the friction of what slides.
//
// Where the rows that carry are dependent (a box on two rough corners, a wall of bricks), equilibrium leaves
// a choice. What does not depend on it is marked `unique`: by row, by joint, and for the resultant of each
// pair of shapes. The member of the solutions that is returned is, in this order:
//   1. the forces of the world's last step, if they are in equilibrium here (the world must observe
//   contacts);
//   2. else what the solver finds from nothing: nearly the least sum of W_ii lambda_i^2;
//   3. for new loads (`RestSolver::solve`): the forces of the first load plus nearly the least change.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "physics/statics/body_loads.h"
#include "physics/world.h"

namespace skerry::statics {

/// A contact point that touches.
struct RestContact {
  ShapeId shape_a, shape_b;
  BodyId body_a, body_b;
  Vec2 position;  ///< world frame [m]
  Vec2 normal;    ///< from a to b
  std::uint32_t feature = 0;
  double mu = 0;              ///< of its friction row; of those two, the one that acts:
  double held_mu = 0;         ///< static friction; without it there is no friction row
  double sliding_mu = 0;      ///< of what slides, never above the other
  double normal_force = 0;    ///< acts on b along the normal [N]
  double friction_force = 0;  ///< acts on b along perp(normal) [N]
  int row = 0;                ///< its normal row in the system; the friction row, if there is one, follows
  double opening = 0;         ///< acceleration of the gap [m/s^2]
  double sliding = 0;         ///< and along perp(normal)
  bool normal_unique = true;  ///< no other force would do
  bool friction_unique = true;
  int pair = 0;  ///< points of one pair of shapes have the same number
};

struct RestJoint {
  std::uint32_t slot = 0;  ///< in World::joints()
  Vec2 force;              ///< on its second body [N]
  bool unique = true;
};

struct RestAnalysis {
  std::vector<BodyId> bodies;                       ///< dynamic ones
  IslandSystem system;                              ///< with accelerations as b
  std::vector<double> lambda;                       ///< forces of its rows [N]
  BodyLoads load;                                   ///< external, on each of them
  std::vector<double> weight;                       ///< of each of them, part of its load [N]
  std::vector<std::array<double, 3>> acceleration;  ///< of each body [m/s^2, m/s^2, rad/s^2]
  /// What rounding may leave of each body's acceleration: a share of all that acts on it, whichever way, over
  /// its mass [m/s^2].
  std::vector<double> rounding;
  std::vector<RestContact> contacts;
  std::vector<RestJoint> joints;
  std::vector<std::uint8_t> unique;       ///< by row: no other forces would do
  std::vector<std::uint8_t> pair_unique;  ///< by `RestContact::pair`: no other resultant would do
  int indeterminacy = 0;                  ///< independent self-stress states of the rows that carry
  bool from_last_step = false;            ///< lambda began as the forces of the world's last step
  double residual = 0;                    ///< natural map, relative to the largest |b|
  double largest_acceleration = 0;        ///< of any point of a body [m/s^2]
  bool stands = false;                    ///< nothing begins to move

  /// The larger of a body's acceleration and its turning at the radius of gyration [m/s^2].
  double size(std::size_t body, const std::array<double, 3>& acceleration) const;
};

struct RestOptions {
  double touch = 1e-6;  ///< gaps up to this count as touching [m]
  std::string solver = "auto";
  bool last_step = true;   ///< begin with the forces of the world's last step where they are in equilibrium
  bool uniqueness = true;  ///< find which forces are the only possible ones: a rank-revealing factorisation
};

/// Finds the touching points of all dynamic bodies at their present poses and solves for their forces. Loads
/// are gravity, springs, the forces that wait for the next step, and the world's force field for bodies at
/// rest. @throws std::invalid_argument for an unknown solver, a dynamic body without mass, or a field that is
/// not finite; what the field throws
RestAnalysis analyse_rest(const World& world, const RestOptions& options = {});

/// A world at rest under many loads: contacts, joints, order and factor are found once and kept. While the
/// same contacts carry, and the same slide, a new load costs solves with the kept factor, O(its nonzeros).
class RestSolver {
 public:
  /// Analyses the world under its own loads. @throws std::invalid_argument as `analyse_rest`
  explicit RestSolver(const World& world, const RestOptions& options = {});
  ~RestSolver();
  RestSolver(RestSolver&&) noexcept;
  RestSolver& operator=(RestSolver&&) noexcept;

  /// The answer to the last load.
  const RestAnalysis& analysis() const;
  /// Replaces all loads, weights included: one entry for each of `analysis().bodies`. Springs are among them.
  /// The answer depends on `load` and the first answer alone, not on loads in between.
  /// @throws std::invalid_argument for another number of bodies, or a load that is not finite
  const RestAnalysis& solve(const BodyLoads& load);
  /// Work of all solves so far.
  const SolveWork& work() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What a world does from rest.
enum class Fate : std::uint8_t { Stands, Slides, Tips, Falls, Collapses };
const char* to_string(Fate fate);

/// Names the motion that begins: nothing moves; bodies slide along their contacts; one body turns over an
/// edge; bodies without any support fall; or several bodies move against each other.
Fate fate_of(const RestAnalysis& rest);

/// Resultant of the points of one pair of shapes.
struct PairForce {
  int first = 0, count = 0;  ///< in RestAnalysis::contacts
  Vec2 at;                   ///< where the resultant crosses the joint (centre of pressure) [m]
  Vec2 force;                ///< on b [N]
  double normal = 0, friction = 0;
  /// |friction| over mu times normal: 1 at the onset of sliding; 0 of what carries nothing, as the next one.
  double grip = 0;
  /// How far the centre of pressure is from the middle of the joint, over half its length: 1 at the edge.
  double eccentricity = 0;
  bool unique = true;  ///< force and centre of pressure are the only possible ones
};
std::vector<PairForce> pair_forces(const RestAnalysis& rest);

/// A segment of the line of thrust: within a body, from one centre of pressure to the next.
struct ThrustSegment {
  BodyId body;
  Vec2 from, to;
  double force = 0;  ///< mean of the two resultants [N]
};
/// The line of thrust through all bodies that touch others in exactly two loaded places.
std::vector<ThrustSegment> thrust_line(const RestAnalysis& rest);

}  // namespace skerry::statics
