// SPDX-License-Identifier: MIT
//
// Statics of the bodies as they are: the line of thrust, centres of pressure, and, where limit analysis is
// there, the way it would collapse under a push sideways.
#include <algorithm>
#include <cmath>

#include "physics/statics/stability.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

constexpr double kGhost = 0.06;         // largest motion of the mechanism, as a share of the picture's height
constexpr int kMostForMechanism = 600;  // rows; larger programmes take too long for every frame

// Outlines of the bodies, moved by the mechanism.
void draw_mechanism(const OverlayContext& context, const statics::RestAnalysis& rest,
                    const statics::Stability& stability, render::DrawLayer& layer) {
  const auto& mechanism = stability.limit.mechanism;
  if (mechanism.empty()) return;
  double fastest = 0;
  const auto moved = [&](std::size_t k, Vec2 p) {
    const Vec2 centre = rest.system.positions[k];
    return Vec2{mechanism[k][0], mechanism[k][1]} + mechanism[k][2] * perp(p - centre);
  };
  const auto each = [&](auto&& use) {
    for (const ShapeRecord& shape : context.world.shapes()) {
      if (!shape.alive || shape.shape->kind != ShapeKind::Polygon) continue;
      const auto body = std::find(rest.bodies.begin(), rest.bodies.end(), shape.body);
      if (body != rest.bodies.end()) use(static_cast<std::size_t>(body - rest.bodies.begin()), shape);
    }
  };
  each([&](std::size_t k, const ShapeRecord& shape) {
    const Transform pose = context.world.pose(shape.body);
    for (const Vec2 corner : shape.shape->vertices)
      fastest = std::max(fastest, length(moved(k, to_world(pose, corner))));
  });
  if (!(fastest > 0)) return;
  const double scale = kGhost * context.camera.height / fastest;
  each([&](std::size_t k, const ShapeRecord& shape) {
    const Transform pose = context.world.pose(shape.body);
    const std::vector<Vec2>& corners = shape.shape->vertices;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 from = to_world(pose, corners[i]), to = to_world(pose, corners[(i + 1) % corners.size()]);
      layer.lines.push_back({.from = to_point(from + scale * moved(k, from)),
                             .to = to_point(to + scale * moved(k, to)),
                             .color = render::faded(context.style.warning, 0.7),
                             .width_px = 1.4f,
                             .dash_px = 5});
    }
  });
  context.legend.swatch({render::faded(context.style.warning, 0.15), context.style.warning},
                        "collapse at " + si(100 * stability.margin, "%") + " of gravity " +
                            (stability.to_left ? "to the left" : "to the right") +
                            // The limit load's friction is associated: see physics/README.md.
                            (stability.slides ? " at the latest; what slides is drawn as if it lifted" : ""));
}

}  // namespace

void draw_thrust(const OverlayContext& context, render::DrawList& list) {
  const render::Style& style = context.style;
  render::DrawLayer& layer = list[render::Layer::Contacts];
  const statics::RestAnalysis rest = statics::analyse_rest(context.world, {.uniqueness = false});
  const std::vector<statics::ThrustSegment> line = statics::thrust_line(rest);
  double largest = 0;
  for (const statics::ThrustSegment& segment : line) largest = std::max(largest, segment.force);
  for (const statics::ThrustSegment& segment : line) {
    layer.lines.push_back({.from = to_point(segment.from),
                           .to = to_point(segment.to),
                           .color = style.force,
                           .width_px = static_cast<float>(1.5 + 4 * segment.force / largest)});
  }
  for (const statics::PairForce& pair : statics::pair_forces(rest)) {
    if (!(pair.normal > 1e-9 * largest)) continue;
    // At the edge of its joint the resultant makes a hinge.
    const bool hinge = pair.eccentricity > 0.999;
    layer.markers.push_back({.at = to_point(pair.at),
                             .fill = hinge ? style.warning : style.background,
                             .outline = style.force,
                             .radius_px = hinge ? 4.5f : 3.0f});
  }
  context.legend.swatch({style.force, style.force}, "line of thrust, thicker with force");
  if (!rest.stands || rest.system.size() > kMostForMechanism || !statics::limit_load_available()) return;
  const statics::Stability stability = statics::stability_of(rest);
  if (stability.status == statics::LimitStatus::Optimal) draw_mechanism(context, rest, stability, layer);
}

}  // namespace skerry::sandbox
