// SPDX-License-Identifier: MIT
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

std::span<const Overlay> overlays() {
  static constexpr Overlay kOverlays[] = {
      {.name = "islands", .summary = "bodies that are solved together, a hue each", .draw = draw_islands},
      {.name = "contacts",
       .summary = "contact points and normals",
       .needs = {.contacts = true},
       .draw = draw_contacts},
      {.name = "impulses",
       .summary = "impact impulses and contact forces as arrows",
       .needs = {.contacts = true},
       .draw = draw_impulses},
      {.name = "velocities", .summary = "velocity of each body", .draw = draw_velocities},
      {.name = "matrix",
       .summary = "the equations W lambda = b of the largest island",
       .needs = {.systems = true},
       .panel = show_matrix,
       .column = true},
      {.name = "energy",
       .summary = "kinetic and potential energy over time",
       .panel = show_energy,
       .column = true},
      {.name = "checks",
       .summary = "the demo's expectations and what was measured",
       .panel = show_checks,
       .column = true},
  };
  return kOverlays;
}

std::vector<std::string> overlay_names() {
  std::vector<std::string> names;
  for (const Overlay& overlay : overlays()) names.emplace_back(overlay.name);
  return names;
}

}  // namespace skerry::sandbox
