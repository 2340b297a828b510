// SPDX-License-Identifier: MIT
//
// A member as a simply supported beam: what loads between its ends do before its end moments act.
#pragma once

#include "physics/statics/structure_solver.h"

namespace skerry::statics {

struct Span {
  Span(const Structure& structure, int member) {
    const Member& m = structure.members[static_cast<std::size_t>(member)];
    const Vec2 way =
        structure.nodes[static_cast<std::size_t>(m.b)].at - structure.nodes[static_cast<std::size_t>(m.a)].at;
    length = skerry::length(way);
    along = way / length;
    across = perp(along);
  }

  /// Turning of the ends, (phi_a, phi_b) * E I [N m^2], positive as sagging moments would turn them.
  Vec2 end_turn_of_force(double share, double transverse) const {
    const double a = share * length, b = length - a;
    const double factor = -transverse * a * b / (6 * length);
    return {factor * (length + b), factor * (length + a)};
  }
  Vec2 end_turn_of_line(double transverse) const {
    const double turn = -transverse * length * length * length / 24;
    return {turn, turn};
  }

  /// Section forces of the simple beam at `at` [share]; just before the load where they jump. Along the
  /// member a force is shared by both sides as in a rod held at both ends, so that its mean axial force is
  /// zero.
  SectionForce of_force(double share, Vec2 force, double at) const {
    const double transverse = dot(across, force), axial = dot(along, force);
    const bool before = at <= share;
    const double reaction = -transverse * (1 - share);
    return {before ? axial * (1 - share) : -axial * share, before ? reaction : reaction + transverse,
            before ? reaction * at * length : -transverse * share * (1 - at) * length};
  }
  SectionForce of_line(Vec2 per_length, double at) const {
    const double transverse = dot(across, per_length), axial = dot(along, per_length);
    return {axial * length * (0.5 - at), transverse * length * (at - 0.5),
            -0.5 * transverse * length * length * at * (1 - at)};
  }

  static double part(const SectionForce& force, Quantity::Kind kind) {
    if (kind == Quantity::Kind::Axial) return force.axial;
    return kind == Quantity::Kind::Shear ? force.shear : force.moment;
  }

  double length = 0;
  Vec2 along, across;
};

}  // namespace skerry::statics
