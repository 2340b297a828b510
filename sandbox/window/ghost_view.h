// SPDX-License-Identifier: MIT
//
// Marks over the scene that only the window has: a ghost of the same world, the hand, the picked body.
#pragma once

#include "render/draw_list.h"
#include "render/style.h"
#include "sandbox/window/user_input.h"

namespace skerry::sandbox {

/// Outlines of all dynamic bodies of `world`.
void draw_ghost(const World& world, const render::Style& style, render::DrawList& list);
/// The spring from the grip to the pointer.
void draw_hand(const World& world, const Hand& hand, const render::Style& style, render::DrawList& list);
/// A bright outline around the body, if there is one.
void draw_selection(const World& world, BodyId body, const render::Style& style, render::DrawList& list);

}  // namespace skerry::sandbox
