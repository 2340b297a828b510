// SPDX-License-Identifier: MIT
//
// Member forces, reactions and displacements of a structure: analysed and factorised once, solved for as many
// loads as wanted.
//
//   A s = p                       equilibrium of the free displacements of the nodes (e x u, sparse)
//   e = A^T d,  s = S (e - e0)    compatibility and Hooke's law, where stiffness is given
//
// | s  | u | N      | a bar: its axial force; a beam: axial force and the end moments (over its length)   |
// | p  | e | N      | loads on the free displacements: two a node, and its turning where a beam is clamped |
// | S  | u x u | N/m | member stiffness, blocks of 1 and 2; e0: what loads between the ends would do alone  |
//
// Determinate structures (u = e = rank A): sparse LU of A, no stiffness enters. Indeterminate ones: if all
// members have modulus, area and (beams) second moment, the displacement method, (A S A^T) d = p + A S e0,
// by sparse LDL^T, with the residual of equilibrium corrected; otherwise the forces of minimum norm,
// s = A^T (A A^T)^-1 p. Which of the three it was stands in `StructureSolver::method`.
//
// References: Livesley 1975, ch. 2-5 (equilibrium matrix, displacement method); Pellegrino & Calladine 1986
// (determinacy from the null spaces of A).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "physics/statics/structure.h"

namespace skerry::statics {

enum class ForceMethod : std::uint8_t {
  Equilibrium,  ///< determinate: equilibrium alone decides
  Stiffness,    ///< indeterminate, real stiffness of the members
  MinimumNorm,  ///< indeterminate, no stiffness: the smallest sum of squares of s
  None,         ///< a mechanism: no forces
};
const char* to_string(ForceMethod method);

/// A way in which a structure can move without any member changing its length or bending (infinitesimally).
struct Mechanism {
  std::vector<Vec2> displacement;  ///< a node; the largest component is 1
  std::vector<double> rotation;    ///< a node [rad/m]; 0 where no beam is clamped
  int node = 0;                    ///< that moves most
  std::string sentence;            ///< "node 7 can move to the left"
};

/// Counts of A [Maxwell 1864; Pellegrino & Calladine 1986].
struct Determinacy {
  int equations = 0;  ///< e, free displacements
  int unknowns = 0;   ///< u, member forces
  int rank = 0;
  std::vector<Mechanism> mechanisms;  ///< e - rank

  int indeterminacy() const { return unknowns - rank; }  ///< number of self-stress states
  bool stable() const { return rank == equations; }
  /// "statically determinate", "2 times statically indeterminate", "mechanism: node 7 can move to the left".
  std::string sentence() const;
};

struct MemberForce {
  double axial = 0;     ///< N > 0 in tension [N]; its mean where loads act along the member
  double moment_a = 0;  ///< bending moments at the ends [N m]
  double moment_b = 0;
};

struct Reaction {
  Vec2 force{};       ///< of the support on the node, world frame [N]
  double moment = 0;  ///< [N m]
};

struct Displacement {
  Vec2 shift{};         ///< [m]
  double rotation = 0;  ///< [rad]; 0 where no beam is clamped
};

/// The answer to one load.
struct Response {
  std::vector<MemberForce> members;
  std::vector<Reaction> reactions;          ///< one a support, in their order
  std::vector<Displacement> displacements;  ///< one a node; empty unless asked for and stiffness is given
  double residual = 0;                      ///< largest |A s - p| over the largest |p| and |s|
};

/// Axial force, shear and bending moment of a section.
struct SectionForce {
  double axial = 0;   ///< [N]
  double shear = 0;   ///< dM/dx [N]
  double moment = 0;  ///< [N m]
};

/// A force of the structure as a linear function of the loads.
struct Quantity {
  enum class Kind : std::uint8_t { Axial, Shear, Moment, ReactionX, ReactionY, ReactionMoment };
  Kind kind = Kind::Axial;
  int index = 0;       ///< of the member, or of the support
  double share = 0.5;  ///< where on the member, 0 to 1
};

class StructureSolver {
 public:
  /// Analyses and factorises. A mechanism is no error: `determinacy` says what moves.
  /// @throws std::invalid_argument for a structure that `validate` refuses
  explicit StructureSolver(Structure structure);
  ~StructureSolver();
  StructureSolver(StructureSolver&&) noexcept;
  StructureSolver& operator=(StructureSolver&&) noexcept;

  const Structure& structure() const;
  const Determinacy& determinacy() const;
  ForceMethod method() const;
  /// True if displacements can be had: every member has its stiffness.
  bool has_stiffness() const;

  /// Solves for one load with the kept factor: O(nonzeros). Without forces (a mechanism) all are zero.
  /// One object must not be used by two threads at the same time.
  /// @throws std::invalid_argument for members or nodes that do not exist, and for a moment on a hinge
  void solve(const Load& load, Response& response, bool displacements = false);
  Response solve(const Load& load, bool displacements = false);

  /// The influence vector of a quantity: its value for a load is the sum over the nodes of
  /// force . displacement + moment * rotation, plus what `span_influence` gives for loads between nodes.
  /// One solve with the transposed factor for all positions of the load [Mueller-Breslau 1886].
  struct Influence {
    Quantity quantity;
    std::vector<Vec2> force;     ///< per node: value per unit force [1 or m]
    std::vector<double> moment;  ///< per node: value per unit moment [1/m or 1]
    std::vector<double> strain;  ///< u numbers that loads between the ends meet
  };
  Influence influence(const Quantity& quantity);
  /// Value of the quantity for a load, from its influence vector.
  double value(const Influence& influence, const Load& load) const;

  /// A basis of the self-stress states: member forces in equilibrium without loads; largest entry 1.
  std::vector<std::vector<MemberForce>> self_stresses() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Forces in a section of a member, `share` of the way from `a` to `b`, with the loads between its ends.
/// At a point load: just before it.
SectionForce section_force(const Structure& structure, const Load& load, const Response& response, int member,
                           double share);

/// Largest stresses of a member [Pa].
struct MemberStress {
  double tension = 0;      ///< >= 0
  double compression = 0;  ///< >= 0
  double share = 0.5;      ///< where the larger of the two is
  double utilisation = 0;  ///< of its strength, and of its buckling load; 1: it breaks
  bool buckles = false;    ///< the buckling load decides, not the strength
  bool squeezed = false;   ///< compression decides, or buckling
};

/// N/A + M (depth/2) / I where it is largest: at the ends, under point loads, and where the shear is zero.
/// All zero for members without an area.
MemberStress member_stress(const Structure& structure, const Load& load, const Response& response,
                           int member);

}  // namespace skerry::statics
