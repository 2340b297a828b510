// SPDX-License-Identifier: MIT
//
// A plane structure as plain data: nodes, members (truss bars and Euler-Bernoulli beams), supports, loads.
//
// Signs: axial forces are positive in tension; bending moments are positive where they stretch the side on
// the right hand of the way from `a` to `b` (sagging, for a beam drawn from left to right); the shear force
// is the slope of the bending moment.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "physics/math.h"

namespace skerry::statics {

struct Node {
  Vec2 at;             ///< [m]
  std::string name{};  ///< for messages; empty: its number, counted from 1
};

/// A bar has hinges at both ends and carries along its axis; a beam bends, and is clamped to its nodes except
/// where it has a hinge.
enum class MemberKind : std::uint8_t { Bar, Beam };

struct Member {
  int a = 0, b = 0;  ///< nodes
  MemberKind kind = MemberKind::Bar;
  double modulus = 0;                     ///< Young's modulus [Pa]; 0: not given
  double area = 0;                        ///< of the section [m^2]; 0: not given, then there are no stresses
  double second_moment = 0;               ///< of the section [m^4]; bars: for buckling; 0: not given
  double depth = 0;                       ///< of the section, its outer fibres at half of it [m]
  double strength = kInfinity;            ///< stress at which it breaks, tension or compression [Pa]
  double density = 0;                     ///< [kg/m^3]; of its weight
  bool hinge_a = false, hinge_b = false;  ///< beams: that end carries no moment
  bool cable = false;                     ///< cannot push: it is slack instead
};

enum class SupportKind : std::uint8_t {
  Pinned,  ///< holds the node, which may turn
  Roller,  ///< lets it move along a line
  Fixed,   ///< holds it and keeps it from turning
};

struct Support {
  int node = 0;
  SupportKind kind = SupportKind::Pinned;
  double angle = 0;  ///< Roller: of the line it rolls along, against the x axis [rad]
};

/// Supported nodes and members; the plain data of a structure without loads.
struct Structure {
  std::vector<Node> nodes;
  std::vector<Member> members;
  std::vector<Support> supports;
};

struct NodeLoad {
  int node = 0;
  Vec2 force{};       ///< [N]
  double moment = 0;  ///< counter-clockwise [N m]; only where a beam is clamped to the node
};

/// A force at a point of a member.
struct SpanLoad {
  int member = 0;
  double share = 0;  ///< of the way from `a` to `b`, 0 to 1
  Vec2 force{};      ///< [N]
};

/// A force spread evenly over a member.
struct LineLoad {
  int member = 0;
  Vec2 force_per_length{};  ///< [N/m]
};

struct Load {
  std::vector<NodeLoad> nodes;
  std::vector<SpanLoad> spans;
  std::vector<LineLoad> lines;

  void clear() {
    nodes.clear();
    spans.clear();
    lines.clear();
  }
};

/// Checks indices, lengths, sections and supports.
/// @throws std::invalid_argument with the number of the member, node or support (from 1) and the value
void validate(const Structure& structure);

/// Checks a load against its structure. @throws std::invalid_argument
void validate(const Structure& structure, const Load& load);

/// The weight of the members as line loads, density * area * gravity.
Load self_weight(const Structure& structure, Vec2 gravity = {0, -9.81});

/// "node 7", or "node A" when it has a name.
std::string node_label(const Structure& structure, int node);

double member_length(const Structure& structure, int member);  ///< [m]

/// Largest compression that a bar can bear by Euler's formula pi^2 E I / L^2 [N]; infinite where modulus or
/// second moment are not given, and for beams.
double buckling_load(const Structure& structure, int member);

}  // namespace skerry::statics
