// SPDX-License-Identifier: MIT
//
// Bridges: members coloured by how much of their strength they use, tension and compression apart; loads and
// reactions as arrows; bending moments of beams; the most loaded member so far.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sandbox/bridge_view.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/labels.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

using statics::Bridge;
using statics::BridgePiece;
using statics::MemberState;

constexpr double kLongestArrow = 0.1;   // of the picture's height
constexpr double kMomentHeight = 0.09;  // of the largest bending moment, likewise

/// Vermilion for compression, blue for tension: apart for every kind of colour vision, and both darker the
/// more a member carries.
render::Color use_color(const render::Style& style, double use) {
  const render::Color neutral = render::mixed(style.background, style.text_dim, 0.28);
  const bool dark = style.theme == render::Theme::Dark;
  const render::Color full = use < 0
                                 ? (dark ? render::Color{255, 134, 64, 255} : render::Color{201, 74, 0, 255})
                                 : (dark ? render::Color{86, 180, 255, 255} : render::Color{0, 98, 180, 255});
  return render::mixed(neutral, full, std::abs(use));
}

std::string force_text(double newton) {
  char text[32];
  const double size = std::abs(newton);
  if (size >= 1e6)
    std::snprintf(text, sizeof text, "%.3g MN", newton / 1e6);
  else if (size >= 999.5)
    std::snprintf(text, sizeof text, "%.*f kN", size < 99950 ? 1 : 0, newton / 1e3);
  else
    std::snprintf(text, sizeof text, "%.0f N", newton);
  return text;
}

std::string percent(double share) {
  char text[24];
  std::snprintf(text, sizeof text, "%.0f %%", 100 * std::abs(share));
  return text;
}

void add_label(const OverlayContext& context, render::DrawLayer& layer, Vec2 at, const std::string& text,
               render::Color color, render::Anchor anchor = render::Anchor::Centre, float offset = 6) {
  layer.labels.push_back({.at = to_point(at),
                          .text = text,
                          .color = color,
                          .halo = context.style.halo,
                          .size_px = context.style.small_text_px,
                          .anchor = anchor,
                          .offset_px = offset});
}

/// Where the ends of a piece are now.
struct PlacedPiece {
  Vec2 from, to;
};
PlacedPiece placed(const World& world, const BridgePiece& piece) {
  const Transform pose = world.pose(piece.body);
  return {to_world(pose, piece.local_from), to_world(pose, piece.local_to)};
}

void draw_members(const OverlayContext& context, const Bridge& bridge, render::DrawLayer& layer) {
  const render::Style& style = context.style;
  for (const BridgePiece& piece : bridge.pieces()) {
    const auto m = static_cast<std::size_t>(piece.member);
    const MemberState& state = bridge.members()[m];
    const PlacedPiece ends = placed(context.world, piece);
    const bool cable = bridge.def().structure.members[m].cable;
    const double radius = (cable ? 0.2 : 0.5) * bridge.def().thickness;
    if (state.slack) {
      layer.lines.push_back({.from = to_point(ends.from),
                             .to = to_point(ends.to),
                             .color = style.text_dim,
                             .width_px = 2,
                             .dash_px = 6});
      continue;
    }
    const render::Color fill =
        state.broken ? use_color(style, bridge.members()[m].peak_use) : use_color(style, state.signed_use);
    layer.capsules.push_back({.from = to_point(ends.from),
                              .to = to_point(ends.to),
                              .radius = radius,
                              .fill = fill,
                              .outline = state.broken ? style.warning : render::mixed(fill, style.text, 0.55),
                              .outline_px = state.broken ? 2.2f : 1.2f});
  }
}

void draw_nodes(const OverlayContext& context, const Bridge& bridge, render::DrawLayer& layer) {
  for (const statics::Node& node : bridge.def().structure.nodes)
    layer.markers.push_back({.at = to_point(node.at),
                             .fill = context.style.background,
                             .outline = context.style.joint,
                             .radius_px = 3.2f});
}

// A triangle for a pin, on a wheel for a roller, a bar for a clamp.
void draw_supports(const OverlayContext& context, const Bridge& bridge, render::DrawLayer& layer) {
  const render::Style& style = context.style;
  const double size = 0.5 * bridge.def().thickness + 0.15;
  for (const statics::Support& support : bridge.def().structure.supports) {
    const Vec2 at = bridge.def().structure.nodes[static_cast<std::size_t>(support.node)].at;
    const Rot turn = Rot::from_angle(support.kind == statics::SupportKind::Roller ? support.angle : 0);
    const auto corner = [&](double x, double y) { return to_point(at + rotate(turn, {x * size, y * size})); };
    if (support.kind == statics::SupportKind::Roller) {
      layer.discs.push_back({.centre = to_point(at),
                             .radius = size,
                             .fill = style.ground.fill,
                             .outline = style.ground.outline});
    } else if (support.kind == statics::SupportKind::Pinned) {
      const render::Point corners[] = {corner(0, 0.2), corner(-1.1, -1), corner(1.1, -1)};
      layer.polygon(corners, 3, style.ground.fill, style.ground.outline);
    } else {
      const render::Point corners[] = {corner(-1.1, -1), corner(1.1, -1), corner(1.1, 0.6),
                                       corner(-1.1, 0.6)};
      layer.polygon(corners, 4, style.ground.fill, style.ground.outline);
    }
  }
}

// The bending moment of a beam on the side that it stretches.
void draw_moments(const OverlayContext& context, const Bridge& bridge, render::DrawLayer& layer) {
  constexpr int kSections = 12;
  const statics::Structure& structure = bridge.def().structure;
  double largest = 0;
  statics::Response ends;
  ends.members.resize(structure.members.size());
  std::vector<std::array<double, kSections + 1>> moments(structure.members.size());
  for (std::size_t m = 0; m < structure.members.size(); ++m) {
    const MemberState& state = bridge.members()[m];
    ends.members[m] = {state.axial, state.moment_a, state.moment_b};
    if (structure.members[m].kind != statics::MemberKind::Beam || state.broken) continue;
    for (int i = 0; i <= kSections; ++i) {
      moments[m][static_cast<std::size_t>(i)] =
          statics::section_force(structure, bridge.load(), ends, static_cast<int>(m),
                                 static_cast<double>(i) / kSections)
              .moment;
      largest = std::max(largest, std::abs(moments[m][static_cast<std::size_t>(i)]));
    }
  }
  if (!(largest > 0)) return;
  const double scale = kMomentHeight * context.camera.height / largest;
  const render::Color color = context.style.force;
  double at_value = 0;
  Vec2 at_place{};
  for (std::size_t m = 0; m < structure.members.size(); ++m) {
    if (structure.members[m].kind != statics::MemberKind::Beam || bridge.members()[m].broken) continue;
    const Vec2 a = structure.nodes[static_cast<std::size_t>(structure.members[m].a)].at;
    const Vec2 b = structure.nodes[static_cast<std::size_t>(structure.members[m].b)].at;
    const Vec2 right = -perp((b - a) / length(b - a));
    Vec2 last = a;
    for (int i = 0; i <= kSections; ++i) {
      const double value = moments[m][static_cast<std::size_t>(i)];
      const Vec2 foot = a + (static_cast<double>(i) / kSections) * (b - a);
      const Vec2 tip = foot + scale * value * right;
      if (i > 0) {
        layer.lines.push_back({.from = to_point(last), .to = to_point(tip), .color = color, .width_px = 2});
        context.labels.avoid(last, tip);
      }
      layer.lines.push_back({.from = to_point(foot),
                             .to = to_point(tip),
                             .color = render::faded(color, 0.35),
                             .width_px = 1.2f});
      last = tip;
      if (std::abs(value) > std::abs(at_value)) {
        at_value = value;
        at_place = tip;
      }
    }
  }
  std::string text = force_text(std::abs(at_value));
  text += " m";  // N m, kN m
  const render::Anchor outside = at_value > 0 ? render::Anchor::Below : render::Anchor::Above;
  context.labels.add(at_place, text, color, {outside, render::Anchor::Right, render::Anchor::Left}, 6);
  context.legend.swatch({render::faded(color, 0.35), color}, "bending moment, on the stretched side");
}

// Axle loads from above, reactions from below.
void draw_forces(const OverlayContext& context, const Bridge& bridge, render::DrawLayer& layer) {
  const render::Style& style = context.style;
  if (bridge.moving() || !bridge.determinacy().stable()) return;
  double largest = 0;
  for (const statics::Reaction& reaction : bridge.response().reactions)
    largest = std::max(largest, length(reaction.force));
  if (!(largest > 0)) return;
  const double longest = kLongestArrow * context.camera.height;
  const double scale = longest / largest;
  const double below = 0.5 * bridge.def().thickness + 0.35;
  for (std::size_t i = 0; i < bridge.response().reactions.size(); ++i) {
    const Vec2 force = bridge.response().reactions[i].force;
    if (length(force) < 0.03 * largest) continue;  // no room for what nobody sees
    const Vec2 at =
        bridge.def().structure.nodes[static_cast<std::size_t>(bridge.def().structure.supports[i].node)].at;
    const Vec2 tip = at - (below / length(force)) * force;
    const Vec2 tail = tip - scale * force;
    layer.arrows.push_back({.from = to_point(tail),
                            .to = to_point(tip),
                            .color = style.force,
                            .width_px = style.arrow_px,
                            .head_px = style.arrow_head_px});
    context.labels.avoid(tail, tip);
    const render::Anchor behind = force.y >= 0 ? render::Anchor::Below : render::Anchor::Above;
    context.labels.add(tail, force_text(length(force)), style.force,
                       {behind, render::Anchor::Left, render::Anchor::Right, render::Anchor::Above}, 4);
  }
  context.legend.arrow(style.force, 24 * render::ui_scale(context.camera.height_px), "support reaction");
}

void draw_numbers(const OverlayContext& context, const Bridge& bridge, render::DrawLayer& layer) {
  for (const BridgePiece& piece : bridge.pieces()) {
    const MemberState& state = bridge.members()[static_cast<std::size_t>(piece.member)];
    if (state.slack || state.broken) continue;
    const PlacedPiece ends = placed(context.world, piece);
    add_label(context, layer, 0.5 * (ends.from + ends.to), force_text(state.axial), context.style.text);
  }
}

// A dot on each member in the colour of its peak, and words at the worst one.
void draw_peaks(const OverlayContext& context, const Bridge& bridge, bool numbers, render::DrawLayer& layer) {
  const render::Style& style = context.style;
  const int worst = bridge.worst();
  for (const BridgePiece& piece : bridge.pieces()) {
    const MemberState& state = bridge.members()[static_cast<std::size_t>(piece.member)];
    if (state.peak_use == 0 || piece.from != 0 || piece.to != 1) continue;
    const PlacedPiece ends = placed(context.world, piece);
    const Vec2 middle = 0.5 * (ends.from + ends.to);
    layer.markers.push_back({.at = to_point(middle),
                             .fill = use_color(style, state.peak_use),
                             .outline = piece.member == worst ? style.warning : style.text_dim,
                             .radius_px = piece.member == worst ? 5.5f : 3.0f});
    if (piece.member != worst) continue;
    // The train is above a beam; below a bar are the diagonals.
    const bool beam = bridge.def().structure.members[static_cast<std::size_t>(piece.member)].kind ==
                      statics::MemberKind::Beam;
    const render::Anchor first = beam ? render::Anchor::Below : render::Anchor::Above;
    const render::Anchor second = beam ? render::Anchor::Above : render::Anchor::Below;
    context.labels.add(middle,
                       "peak " + percent(state.peak_use) + (state.peak_use < 0 ? " compression" : " tension"),
                       style.text, {first, second}, numbers ? 17 : 9);
  }
}

// A bar of colours from full compression to full tension.
void draw_scale(const OverlayContext& context, render::DrawLayer& layer) {
  const render::Camera& camera = context.camera;
  const double scale = render::ui_scale(camera.height_px);
  constexpr int kSteps = 40;
  const double width = 300 * scale, height = 13 * scale;
  const double left = 20 * scale, top = camera.height_px - 74 * scale;
  for (int i = 0; i < kSteps; ++i) {
    const double x0 = left + width * i / kSteps, x1 = left + width * (i + 1) / kSteps;
    const render::Point corners[] = {camera.to_world({x0, top + height}), camera.to_world({x1, top + height}),
                                     camera.to_world({x1, top}), camera.to_world({x0, top})};
    const render::Color color = use_color(context.style, 2.0 * (i + 0.5) / kSteps - 1);
    layer.polygon(corners, 4, color, color, 0, 0.5f);
  }
  const auto word = [&](double x, const std::string& text, render::Anchor anchor) {
    layer.labels.push_back({.at = camera.to_world({x, top - 10 * scale}),
                            .text = text,
                            .color = context.style.text,
                            .halo = context.style.halo,
                            .size_px = context.style.small_text_px,
                            .anchor = anchor,
                            .offset_px = 0});
  };
  word(left, "compression 100 %", render::Anchor::Right);
  word(left + 0.5 * width, "0", render::Anchor::Centre);
  word(left + width, "tension 100 %", render::Anchor::Left);
  word(left + width + 12 * scale, "of strength", render::Anchor::Right);
}

void draw_breaks(const OverlayContext& context, const Bridge& bridge, render::DrawLayer& layer) {
  const render::Camera& camera = context.camera;
  const double scale = render::ui_scale(camera.height_px);
  int row = 0;
  for (const statics::Break& failure : bridge.breaks()) {
    if (row == 4) break;  // the first ones tell the story
    char text[96];
    std::snprintf(text, sizeof text, "member %d broke at %.2f s in %s", failure.member + 1, failure.time,
                  failure.use < 0 ? "compression" : "tension");
    layer.labels.push_back({.at = camera.to_world({20 * scale, camera.height_px - (112 + 20 * row) * scale}),
                            .text = text,
                            .color = context.style.warning,
                            .halo = context.style.halo,
                            .size_px = context.style.small_text_px,
                            .anchor = render::Anchor::Right,
                            .offset_px = 0});
    ++row;
  }
}

}  // namespace

void draw_stresses(const OverlayContext& context, render::DrawList& list) {
  if (context.demo.bridges().empty()) return;
  render::DrawLayer& members = list[render::Layer::Structure];
  render::DrawLayer& marks = list[render::Layer::Contacts];
  render::DrawLayer& words = list[render::Layer::Labels];
  for (const BridgeView& view : context.demo.bridges()) {
    const Bridge& bridge = *view.bridge;
    draw_members(context, bridge, members);
    if (!bridge.moving()) {
      draw_supports(context, bridge, members);
      draw_nodes(context, bridge, marks);
      draw_forces(context, bridge, marks);
      draw_moments(context, bridge, marks);
    }
    draw_peaks(context, bridge, view.numbers, marks);
    if (view.numbers) draw_numbers(context, bridge, words);
    draw_breaks(context, bridge, words);
  }
  draw_scale(context, words);
}

}  // namespace skerry::sandbox
