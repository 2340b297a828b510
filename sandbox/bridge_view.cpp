// SPDX-License-Identifier: MIT
#include "sandbox/bridge_view.h"

namespace skerry::sandbox {

std::span<const statics::Reaction> standing_reactions(const statics::Bridge& bridge) {
  if (bridge.moving() || !bridge.determinacy().stable()) return {};
  return bridge.response().reactions;
}

std::vector<BendingMoments> bending_moments(const statics::Bridge& bridge) {
  const statics::Structure& structure = bridge.def().structure;
  std::vector<BendingMoments> moments(structure.members.size());
  if (bridge.moving()) return moments;
  statics::Response ends;
  for (const statics::MemberState& state : bridge.members())
    ends.members.push_back({state.axial, state.moment_a, state.moment_b});
  for (std::size_t m = 0; m < moments.size(); ++m) {
    if (structure.members[m].kind != statics::MemberKind::Beam || bridge.members()[m].broken) continue;
    for (std::size_t i = 0; i <= kMomentSections; ++i)
      moments[m][i] = statics::section_force(structure, bridge.load(), ends, static_cast<int>(m),
                                             static_cast<double>(i) / kMomentSections)
                          .moment;
  }
  return moments;
}

}  // namespace skerry::sandbox
