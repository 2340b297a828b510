// SPDX-License-Identifier: MIT
//
// The velocity of each dynamic body as an arrow from its centre of mass.
#include <algorithm>

#include "sandbox/layout.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {

void draw_velocities(const OverlayContext& context, render::DrawList& list) {
  const BodyArrays& bodies = context.world.bodies();
  const render::Style& style = context.style;
  const double fastest = context.history.fastest();
  if (fastest <= 0) return;
  // The fastest so far gets an arrow of at most a sixth of the picture's height.
  const double room = context.camera.height / 6;
  const double metres_per_unit = round_down(room / fastest);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const bool moves = bodies.alive[i] && bodies.type[i] == BodyType::Dynamic;
    if (!moves) continue;
    const BodyState shown = context.demo.shown(i);
    if (length(shown.velocity) < 1e-6 * fastest) continue;
    list[render::Layer::Contacts].arrows.push_back(
        {.from = to_point(shown.position),
         .to = to_point(shown.position + metres_per_unit * shown.velocity),
         .color = style.velocity,
         .width_px = style.arrow_px,
         .head_px = style.arrow_head_px});
  }
  const double amount = round_down_125(fastest);
  context.legend.arrow(style.velocity, amount * metres_per_unit * context.camera.pixels_per_metre(),
                       "velocity " + round_amount(amount, "m/s"));
}

}  // namespace skerry::sandbox
