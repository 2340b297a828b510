// SPDX-License-Identifier: MIT
//
// The functions of the overlays, one file each; registry.cpp lists them. Heights are those of panel contents
// [px of the style].
#pragma once

#include "sandbox/layout.h"
#include "sandbox/overlays/overlay.h"
#include "sandbox/overlays/plot.h"

namespace skerry::sandbox {

void draw_contacts(const OverlayContext& context, render::DrawList& list);
void draw_impulses(const OverlayContext& context, render::DrawList& list);
void draw_traces(const OverlayContext& context, render::DrawList& list);
void draw_velocities(const OverlayContext& context, render::DrawList& list);
void draw_islands(const OverlayContext& context, render::DrawList& list);
void draw_thrust(const OverlayContext& context, render::DrawList& list);
void draw_stresses(const OverlayContext& context, render::DrawList& list);
void draw_broadphase(const OverlayContext& context, render::DrawList& list);
void draw_sat(const OverlayContext& context, render::DrawList& list);

inline constexpr double kEnergyPx = 158;
inline constexpr double kMomentumPx = 150;
inline constexpr double kInfluencePx = 190;
inline constexpr double kChecksPx = 196;
inline constexpr double kMatrixPx = 340;
inline constexpr double kFactorPx = 276;
inline constexpr double kSolverPx = 316;
inline constexpr double kBroadPhasePx = 166;
inline constexpr double kComparePx = 520;
inline constexpr double kSatPx = 164;
inline constexpr double kInspectorPx = 244;
inline constexpr double kProfilePx = 182;
inline constexpr double kSkipsPx = 182;
inline constexpr double kTimelinePx = 44;  ///< below the scene, over the whole width
void show_energy(const PanelContext& context);
void show_momentum(const PanelContext& context);
void show_influence(const PanelContext& context);
void show_checks(const PanelContext& context);
void show_matrix(const PanelContext& context);
void show_factor(const PanelContext& context);
void show_solver(const PanelContext& context);
void show_broadphase(const PanelContext& context);
void show_compare(const PanelContext& context);
void show_sat(const PanelContext& context);
void show_inspector(const PanelContext& context);
void show_profile(const PanelContext& context);
void show_skips(const PanelContext& context);
void show_timeline(const PanelContext& context);
void draw_matrix_selection(const OverlayContext& context, render::DrawList& list);

/// Selects the row of the shown equations that acts nearest to `point`, within `reach` [m].
/// @return whether there is one
bool select_contact_at(const Demo& demo, const History& history, Vec2 point, double reach,
                       Selection& selection);

/// The curves of the energy panel.
Chart energy_chart(const OverlayContext& context);

/// Title, lesson, time and the current note: part of every picture.
/// @param footer height of what stands below the scene [px of the style]
/// @param legend what it covers of the scene; the note stands above that
/// @return the upper edge of the note, or of what stands below the scene [px]
float show_header(const PanelContext& context, double speed, double footer,
                  const std::vector<PixelBox>& legend);

}  // namespace skerry::sandbox
