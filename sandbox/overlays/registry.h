// SPDX-License-Identifier: MIT
//
// The functions of the overlays, one file each; registry.cpp lists them. Heights are those of panel contents
// [px of the style].
#pragma once

#include "sandbox/overlays/overlay.h"
#include "sandbox/overlays/plot.h"

namespace skerry::sandbox {

void draw_contacts(const OverlayContext& context, render::DrawList& list);
void draw_impulses(const OverlayContext& context, render::DrawList& list);
void draw_velocities(const OverlayContext& context, render::DrawList& list);
void draw_islands(const OverlayContext& context, render::DrawList& list);

inline constexpr double kEnergyPx = 168;
inline constexpr double kMomentumPx = 150;
inline constexpr double kChecksPx = 196;
inline constexpr double kMatrixPx = 344;
void show_energy(const PanelContext& context);
void show_momentum(const PanelContext& context);
void show_checks(const PanelContext& context);
void show_matrix(const PanelContext& context);
void draw_matrix_selection(const OverlayContext& context, render::DrawList& list);

/// Selects the row of the shown equations that acts nearest to `point`, within `reach` [m].
/// @return whether there is one
bool select_contact_at(const OverlayContext& context, Vec2 point, double reach);

/// The curves of the energy panel.
Chart energy_chart(const OverlayContext& context);

/// Title, lesson, time and the current note: part of every picture.
void show_header(const PanelContext& context, double speed);

}  // namespace skerry::sandbox
