// SPDX-License-Identifier: MIT
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

std::span<const Overlay> overlays() {
  static constexpr Overlay kOverlays[] = {
      {.name = "islands",
       .summary = "bodies that are solved together, a hue each",
       .key = 'l',
       .draw = draw_islands},
      {.name = "contacts",
       .summary = "contact points and normals",
       .key = 'c',
       .needs = {.contacts = true},
       .draw = draw_contacts},
      {.name = "impulses",
       .summary = "impact impulses and contact forces as arrows",
       .key = 'i',
       .needs = {.contacts = true},
       .draw = draw_impulses},
      {.name = "velocities", .summary = "velocity of each body", .key = 'v', .draw = draw_velocities},
      {.name = "energy",
       .summary = "kinetic and potential energy over time",
       .key = 'e',
       .panel = show_energy,
       .panel_px = kEnergyPx},
      {.name = "momentum",
       .summary = "momentum and angular momentum over time",
       .key = 'u',
       .panel = show_momentum,
       .panel_px = kMomentumPx},
      {.name = "matrix",
       .summary = "the equations W lambda = b of the selected or largest island",
       .key = 'm',
       .needs = {.contacts = true, .systems = true},
       .draw = draw_matrix_selection,
       .panel = show_matrix,
       .panel_px = kMatrixPx},
      {.name = "checks",
       .summary = "the demo's expectations and what was measured",
       .key = 'h',
       .panel = show_checks,
       .panel_px = kChecksPx},
  };
  return kOverlays;
}

std::vector<std::string> overlay_names() {
  std::vector<std::string> names;
  for (const Overlay& overlay : overlays()) names.emplace_back(overlay.name);
  return names;
}

}  // namespace skerry::sandbox
