// SPDX-License-Identifier: MIT
//
// Which cables of a bridge are slack.
//
//   minimise s' F s / 2   such that   A s = p,  s_cable >= 0
//
// The forces are unique. They are found by the dual active set method of Goldfarb & Idnani [1983]: all cables
// carry at first; of those that push, the worst is taken in until it carries nothing, and then has that much
// to spare. A slack cable that has no more to spare on the way is put back first. What is left of the
// structure stands after every step, and the energy s' F s / 2 only grows, so no set of slack cables comes
// twice.
#include <algorithm>
#include <cmath>

#include "physics/statics/bridge.h"

namespace skerry::statics {
namespace {

// Of the largest force: a cable that pushes less carries nothing.
constexpr double kPushes = 1e-12;
// The same where the bridge would fall without the cable: forces are exact to about this.
constexpr double kFalls = 1e-9;
// A cable that is taken in, and whose ends follow it up to this share, pushes on: without it nothing stands.
constexpr double kFollows = 1e-9;

double largest_force(const Structure& structure, const Response& response) {
  double largest = 0;
  for (std::size_t m = 0; m < response.members.size(); ++m) {
    const MemberForce& force = response.members[m];
    const double lever = member_length(structure, static_cast<int>(m));
    largest = std::max(
        {largest, std::abs(force.axial), std::abs(force.moment_a) / lever, std::abs(force.moment_b) / lever});
  }
  for (const Reaction& reaction : response.reactions) largest = std::max(largest, length(reaction.force));
  return largest;
}

}  // namespace

void Bridge::find_slack_cables() {
  const Structure& s = def_.structure;
  bool any = false;
  for (MemberState& member : members_) {
    any = any || member.slack;
    member.slack = false;
  }
  const auto solve_again = [&] {
    rebuild_solver();
    solve(time_);
  };
  if (any) solve_again();
  // How much longer the slack ones are than the way between their ends [m].
  std::vector<double> spare(members_.size(), 0);
  const auto cables = static_cast<std::size_t>(
      std::count_if(s.members.begin(), s.members.end(), [](const Member& m) { return m.cable; }));
  // Where several cables are at the point of going slack rounding might go round in a circle.
  std::size_t left = 8 + 8 * cables;
  while (solver_->determinacy().stable()) {
    const double scale = largest_force(solver_->structure(), response_);
    int worst = -1;
    double push = 0;
    for (std::size_t k = 0; k < kept_.size(); ++k) {
      const double axial = response_.members[k].axial;
      if (s.members[static_cast<std::size_t>(kept_[k])].cable && axial < push) {
        push = axial;
        worst = kept_[k];
      }
    }
    if (worst < 0 || -push <= kPushes * scale) return;
    const auto w = static_cast<std::size_t>(worst);
    const Member& cable = s.members[w];
    while (!members_[w].slack) {
      if (left-- == 0) return;
      // How the ends of all members part when the worst cable is let out by 1: by reciprocity the influence
      // line of its force.
      const int index = solver_index_[w];
      const StructureSolver::Influence motion = solver_->influence({Quantity::Kind::Axial, index});
      const auto parting = [&](std::size_t m) {
        const auto a = static_cast<std::size_t>(s.members[m].a), b = static_cast<std::size_t>(s.members[m].b);
        const Vec2 way = s.nodes[b].at - s.nodes[a].at;
        return dot(way, motion.force[b] - motion.force[a]) / length(way);
      };
      const double stiffness = solver_->method() == ForceMethod::Stiffness
                                   ? cable.modulus * cable.area / member_length(s, worst)
                                   : 1;
      const double gain = stiffness * (1 - parting(w));
      const double force = response_.members[static_cast<std::size_t>(index)].axial + spare[w] * gain;
      double most = gain > kFollows * stiffness ? std::max(0.0, -force / gain) : kInfinity;
      int tight = -1;
      for (std::size_t m = 0; m < members_.size(); ++m) {
        if (!members_[m].slack) continue;
        const double rate = -parting(m);
        if (rate > kFollows && spare[m] < most * rate) {
          most = std::max(0.0, spare[m] / rate);
          tight = static_cast<int>(m);
        }
      }
      if (tight < 0 && !(most < kInfinity) && -force <= kFalls * scale) return;
      if (most < kInfinity) {
        for (std::size_t m = 0; m < members_.size(); ++m)
          if (members_[m].slack) spare[m] += most * parting(m);
        spare[w] += most;
      }
      // Without either the bridge falls: the caller sees a mechanism.
      const std::size_t changed = tight < 0 ? w : static_cast<std::size_t>(tight);
      members_[changed].slack = tight < 0;
      if (tight >= 0) spare[changed] = 0;
      solve_again();
    }
  }
}

}  // namespace skerry::statics
