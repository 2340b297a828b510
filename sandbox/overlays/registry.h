// SPDX-License-Identifier: MIT
//
// The functions of the overlays, one file each; registry.cpp lists them.
#pragma once

#include "sandbox/overlays/overlay.h"

namespace skerry::sandbox {

void draw_contacts(const OverlayContext& context, render::DrawList& list);
void draw_impulses(const OverlayContext& context, render::DrawList& list);
void draw_velocities(const OverlayContext& context, render::DrawList& list);
void draw_islands(const OverlayContext& context, render::DrawList& list);
void show_matrix(const PanelContext& context);
void show_energy(const PanelContext& context);
void show_checks(const PanelContext& context);

/// Title, lesson, time and the current note: part of every picture.
void show_header(const PanelContext& context, double speed);

}  // namespace skerry::sandbox
