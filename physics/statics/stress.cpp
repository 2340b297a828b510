// SPDX-License-Identifier: MIT
//
// Section forces along a member, and its largest stresses.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/statics/span.h"
#include "physics/statics/structure_solver.h"
#include "physics/text.h"

namespace skerry::statics {

SectionForce section_force(const Structure& structure, const Load& load, const Response& response, int member,
                           double share) {
  if (!(share >= 0 && share <= 1))
    throw std::invalid_argument("section_force: share must be from 0 to 1, got " + to_text(share));
  const Span span(structure, member);
  const MemberForce& ends = response.members[static_cast<std::size_t>(member)];
  SectionForce sum{ends.axial, (ends.moment_b - ends.moment_a) / span.length,
                   (1 - share) * ends.moment_a + share * ends.moment_b};
  const auto add = [&](const SectionForce& more) {
    sum.axial += more.axial;
    sum.shear += more.shear;
    sum.moment += more.moment;
  };
  for (const SpanLoad& l : load.spans)
    if (l.member == member) add(span.of_force(l.share, l.force, share));
  for (const LineLoad& l : load.lines)
    if (l.member == member) add(span.of_line(l.force_per_length, share));
  return sum;
}

MemberStress member_stress(const Structure& structure, const Load& load, const Response& response,
                           int member) {
  const Member& m = structure.members[static_cast<std::size_t>(member)];
  MemberStress result;
  if (!(m.area > 0)) return result;
  // Between these sections the moment is a parabola; its summit is where the shear is zero.
  std::vector<double> shares{0, 1};
  for (const SpanLoad& l : load.spans)
    if (l.member == member) shares.push_back(l.share);
  std::sort(shares.begin(), shares.end());
  for (std::size_t i = 0, count = shares.size(); i + 1 < count; ++i) {
    const double width = shares[i + 1] - shares[i];
    if (!(width > 0)) continue;
    const double first = section_force(structure, load, response, member, shares[i] + 0.25 * width).shear;
    const double second = section_force(structure, load, response, member, shares[i] + 0.75 * width).shear;
    if (first == second) continue;
    const double t = 0.25 + 0.5 * first / (first - second);
    if (t > 0 && t < 1) shares.push_back(shares[i] + t * width);
  }
  const bool bends = m.second_moment > 0 && m.depth > 0;
  double largest = -1, push = 0;
  for (const double share : shares) {
    // On both sides of a point load.
    for (const double side : {-1e-12, 1e-12}) {
      const double at = std::clamp(share + side, 0.0, 1.0);
      const SectionForce force = section_force(structure, load, response, member, at);
      const double even = force.axial / m.area;
      push = std::max(push, -force.axial);
      const double bend = bends ? std::abs(force.moment) * 0.5 * m.depth / m.second_moment : 0;
      result.tension = std::max(result.tension, even + bend);
      result.compression = std::max(result.compression, bend - even);
      if (std::max(even + bend, bend - even) > largest) {
        largest = std::max(even + bend, bend - even);
        result.share = share;
      }
    }
  }
  // A bar buckles under its axial force alone; what bending adds or takes away only breaks it.
  const double buckling = push / buckling_load(structure, member);
  result.utilisation = std::max(result.tension, result.compression) / m.strength;
  result.buckles = buckling > result.utilisation;
  if (result.buckles) result.utilisation = buckling;
  result.squeezed = result.buckles || result.compression > result.tension;
  return result;
}

}  // namespace skerry::statics
