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
// Velocities are taken for zero. It is solved by the same solvers as the step (physics/solver).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "physics/world.h"

namespace skerry::statics {

/// A contact point that touches.
struct RestContact {
  ShapeId shape_a, shape_b;
  BodyId body_a, body_b;
  Vec2 position;  ///< world frame [m]
  Vec2 normal;    ///< from a to b
  std::uint32_t feature = 0;
  double mu = 0;
  double normal_force = 0;    ///< acts on b along the normal [N]
  double friction_force = 0;  ///< acts on b along perp(normal) [N]
  int row = 0;                ///< its normal row in the system; the friction row, if mu > 0, follows
  double opening = 0;         ///< acceleration of the gap [m/s^2]
  double sliding = 0;         ///< and along perp(normal)
  bool normal_unique = true;  ///< no other forces would do
  int pair = 0;               ///< points of one pair of shapes have the same number
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
  std::vector<std::array<double, 3>> load;          ///< external force and torque on each body [N, N, N m]
  std::vector<std::array<double, 3>> acceleration;  ///< of each body [m/s^2, m/s^2, rad/s^2]
  std::vector<RestContact> contacts;
  std::vector<RestJoint> joints;
  std::vector<std::uint8_t> unique;  ///< by row: no other forces would do
  int indeterminacy = 0;             ///< independent self-stress states of the rows that carry
  double residual = 0;               ///< natural map, relative to the largest |b|
  double largest_acceleration = 0;   ///< of any point of a body [m/s^2]
  bool stands = false;               ///< nothing begins to move
};

struct RestOptions {
  double touch = 1e-6;  ///< gaps up to this count as touching [m]
  std::string solver = "auto";
};

/// Finds the touching points of all dynamic bodies at their present poses and solves for their forces. Loads
/// are gravity and the forces that wait for the next step.
/// @throws std::invalid_argument for an unknown solver, or a dynamic body without mass
RestAnalysis analyse_rest(const World& world, const RestOptions& options = {});

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
  double grip = 0;  ///< |friction| over mu times normal: 1 at the onset of sliding
  /// How far the centre of pressure is from the middle of the joint, over half its length: 1 at the edge.
  double eccentricity = 0;
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
