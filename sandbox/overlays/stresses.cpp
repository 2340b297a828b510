// SPDX-License-Identifier: MIT
//
// Bridges: members coloured by how much of their strength they use, tension and compression apart; loads and
// reactions as arrows; bending moments of beams; the most loaded member so far.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "render/gl_renderer.h"
#include "sandbox/bridge_view.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/labels.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

using statics::Bridge;
using statics::BridgePiece;
using statics::MemberState;

constexpr double kLongestArrow = 0.12;  // of the largest reaction so far, as a share of the picture's height
constexpr double kMomentHeight = 0.11;  // of the largest bending moment so far, likewise
constexpr std::size_t kMostBreaks = 4;  // the first ones tell the story

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
  if (size >= 999500)
    std::snprintf(text, sizeof text, "%.*f MN", size < 9.995e6 ? 2 : size < 99.95e6 ? 1 : 0, newton / 1e6);
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

/// Where the ends of a piece are now; none for a piece that a user has removed.
struct PlacedPiece {
  Vec2 from, to;
};
std::optional<PlacedPiece> placed(const World& world, const BridgePiece& piece) {
  if (!world.alive(piece.body)) return std::nullopt;
  const Transform pose = world.pose(piece.body);
  return PlacedPiece{to_world(pose, piece.local_from), to_world(pose, piece.local_to)};
}

void draw_members(const OverlayContext& context, const Bridge& bridge, render::DrawLayer& layer) {
  const render::Style& style = context.style;
  for (const BridgePiece& piece : bridge.pieces()) {
    const auto m = static_cast<std::size_t>(piece.member);
    const MemberState& state = bridge.members()[m];
    const std::optional<PlacedPiece> ends = placed(context.world, piece);
    if (!ends) continue;
    const bool cable = bridge.def().structure.members[m].cable;
    const double radius = (cable ? 0.2 : 0.5) * bridge.def().thickness;
    if (state.slack) {
      layer.lines.push_back({.from = to_point(ends->from),
                             .to = to_point(ends->to),
                             .color = style.text_dim,
                             .width_px = 2,
                             .dash_px = 6});
      continue;
    }
    const render::Color fill =
        state.broken ? use_color(style, bridge.members()[m].peak_use) : use_color(style, state.signed_use);
    layer.capsules.push_back({.from = to_point(ends->from),
                              .to = to_point(ends->to),
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

/// Metres in the picture for a unit, by the largest amount so far, and the round amount that the legend
/// shows.
struct Lengths {
  double metres_per_unit = 0;
  double amount = 0;

  Lengths(const OverlayContext& context, double share, double largest) {
    if (!(largest > 0)) return;
    metres_per_unit = round_down(share * context.camera.height / largest);
    amount = round_down_125(largest);
  }
  double legend_px(const OverlayContext& context) const {
    return amount * metres_per_unit * context.camera.pixels_per_metre();
  }
};

/// The largest bending moment of a bridge: where its diagram is, and the value.
struct Summit {
  Vec2 at;
  double value = 0;
};

// The bending moment of a beam on the side that it stretches.
Summit draw_moments(const OverlayContext& context, const Bridge& bridge, const Lengths& lengths,
                    render::DrawLayer& layer) {
  const statics::Structure& structure = bridge.def().structure;
  const std::vector<BendingMoments> moments = bending_moments(bridge);
  const render::Color color = context.style.force;
  Summit summit;
  for (std::size_t m = 0; m < structure.members.size(); ++m) {
    if (structure.members[m].kind != statics::MemberKind::Beam || bridge.members()[m].broken) continue;
    const Vec2 a = structure.nodes[static_cast<std::size_t>(structure.members[m].a)].at;
    const Vec2 b = structure.nodes[static_cast<std::size_t>(structure.members[m].b)].at;
    const Vec2 right = -perp((b - a) / length(b - a));
    Vec2 last = a;
    for (std::size_t i = 0; i <= kMomentSections; ++i) {
      const double value = moments[m][i];
      const Vec2 foot = a + (static_cast<double>(i) / kMomentSections) * (b - a);
      const Vec2 tip = foot + lengths.metres_per_unit * value * right;
      if (i > 0) {
        layer.lines.push_back({.from = to_point(last), .to = to_point(tip), .color = color, .width_px = 2});
        context.labels.avoid(last, tip);
      }
      layer.lines.push_back({.from = to_point(foot),
                             .to = to_point(tip),
                             .color = render::faded(color, 0.35),
                             .width_px = 1.2f});
      last = tip;
      if (std::abs(value) > std::abs(summit.value)) summit = {tip, value};
    }
  }
  return summit;
}

void label_summit(const OverlayContext& context, const Summit& summit) {
  if (summit.value == 0) return;
  const render::Anchor outside = summit.value > 0 ? render::Anchor::Below : render::Anchor::Above;
  context.labels.add(summit.at, force_text(std::abs(summit.value)) + " m",  // N m, kN m
                     context.style.force, {outside, render::Anchor::Right, render::Anchor::Left}, 6);
}

/// A reaction as an arrow towards its support.
struct ReactionArrow {
  Vec2 tail, along;  ///< [m]
  double force = 0;  ///< [N]
  bool up = false;
};

std::vector<ReactionArrow> draw_reactions(const OverlayContext& context, const Bridge& bridge,
                                          const Lengths& lengths, render::DrawLayer& layer) {
  const render::Style& style = context.style;
  const double below = 0.5 * bridge.def().thickness + 0.35;
  std::vector<ReactionArrow> arrows;
  const std::span<const statics::Reaction> reactions = standing_reactions(bridge);
  for (std::size_t i = 0; i < reactions.size(); ++i) {
    const Vec2 force = reactions[i].force;
    // No room for what nobody sees.
    if (!(length(force) > 0.03 * context.history.largest_reaction())) continue;
    const Vec2 at =
        bridge.def().structure.nodes[static_cast<std::size_t>(bridge.def().structure.supports[i].node)].at;
    const Vec2 tip = at - (below / length(force)) * force;
    const Vec2 tail = tip - lengths.metres_per_unit * force;
    layer.arrows.push_back({.from = to_point(tail),
                            .to = to_point(tip),
                            .color = style.force,
                            .width_px = style.arrow_px,
                            .head_px = style.arrow_head_px});
    context.labels.avoid(tail, tip);
    arrows.push_back({tail, tip - tail, length(force), force.y >= 0});
  }
  return arrows;
}

// The largest first: when there is no room for all, the small ones go without.
void label_reactions(const OverlayContext& context, std::vector<ReactionArrow> arrows) {
  std::stable_sort(arrows.begin(), arrows.end(),
                   [](const ReactionArrow& a, const ReactionArrow& b) { return a.force > b.force; });
  using render::Anchor;
  for (const ReactionArrow& arrow : arrows) {
    const std::string text = force_text(arrow.force);
    const render::Color color = context.style.force;
    const Anchor behind = arrow.up ? Anchor::Below : Anchor::Above;
    if (context.labels.add(arrow.tail, text, color, {behind, Anchor::Left, Anchor::Right, Anchor::Above}, 4))
      continue;
    // Beside its shaft.
    const double away = 12 * render::ui_scale(context.camera.height_px) / context.camera.pixels_per_metre();
    const Vec2 side = away / length(arrow.along) * perp(arrow.along);
    for (const Vec2 step : {side, -side})
      if (context.labels.add(arrow.tail + 0.5 * arrow.along + step, text, color,
                             {step.x < 0 ? Anchor::Left : Anchor::Right}, 2))
        break;
  }
}

// Likewise.
void draw_numbers(const OverlayContext& context, const Bridge& bridge) {
  struct Number {
    Vec2 at;
    double force;
  };
  std::vector<Number> numbers;
  for (const BridgePiece& piece : bridge.pieces()) {
    const MemberState& state = bridge.members()[static_cast<std::size_t>(piece.member)];
    if (state.slack || state.broken) continue;
    const std::optional<PlacedPiece> ends = placed(context.world, piece);
    if (!ends) continue;
    numbers.push_back({0.5 * (ends->from + ends->to), state.axial});
  }
  std::stable_sort(numbers.begin(), numbers.end(),
                   [](const Number& a, const Number& b) { return std::abs(a.force) > std::abs(b.force); });
  for (const Number& number : numbers)
    context.labels.add(number.at, force_text(number.force), context.style.text, {render::Anchor::Centre});
}

// A dot on each member in the colour of its peak, and words at the worst one.
void draw_peaks(const OverlayContext& context, const Bridge& bridge, bool numbers, render::DrawLayer& layer) {
  const render::Style& style = context.style;
  const int worst = bridge.worst();
  for (const BridgePiece& piece : bridge.pieces()) {
    const MemberState& state = bridge.members()[static_cast<std::size_t>(piece.member)];
    if (state.peak_use == 0 || piece.from != 0 || piece.to != 1) continue;
    const std::optional<PlacedPiece> ends = placed(context.world, piece);
    if (!ends) continue;
    const Vec2 middle = 0.5 * (ends->from + ends->to);
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
    context.labels.add(
        middle, "peak " + percent(state.peak_use) + (state.peak_use < 0 ? " compression" : " tension"),
        style.text, {first, second, render::Anchor::Right, render::Anchor::Left}, numbers ? 17 : 9);
  }
}

// A bar of colours from full compression to full tension, above the legend. @return its upper edge [px]
double draw_scale(const OverlayContext& context, render::DrawLayer& layer) {
  const render::Camera& camera = context.camera;
  const double scale = render::ui_scale(camera.height_px);
  const double size = context.style.small_text_px;
  constexpr int kSteps = 40;
  constexpr double kEdge = 20, kGap = 12;
  const std::string share = "of strength";
  // In narrow pictures shorter.
  const double room = camera.width_px / scale - 2 * kEdge - kGap - render::text_width(share, size);
  const double width = std::clamp(room, 240.0, 300.0) * scale, height = 13 * scale;
  const double left = kEdge * scale, top = context.legend.top() - 43.5 * scale;
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
  word(left + width + kGap * scale, share, render::Anchor::Right);
  const PixelBox box{left, top - 20 * scale, left + width + (kGap + render::text_width(share, size)) * scale,
                     top + height};
  context.labels.avoid(box);
  context.legend.occupy(box);
  return box.top;
}

/// What broke, above `bottom` [px].
void draw_breaks(const OverlayContext& context, double bottom, render::DrawLayer& layer) {
  std::vector<std::string> lines;
  for (const BridgeView& view : context.demo.bridges()) {
    for (const statics::Break& failure : view.bridge->breaks()) {
      char text[96];
      std::snprintf(text, sizeof text, "member %d broke at %.2f s in %s", failure.member + 1, failure.time,
                    failure.use < 0 ? "compression" : "tension");
      lines.emplace_back(text);
    }
  }
  if (lines.empty()) return;
  if (lines.size() > kMostBreaks) {
    const std::string more = ", and " + std::to_string(lines.size() - kMostBreaks) + " more";
    lines.resize(kMostBreaks);
    lines.back() += more;
  }
  const render::Camera& camera = context.camera;
  const double scale = render::ui_scale(camera.height_px), row = 20 * scale, left = 20 * scale;
  const double top = bottom - static_cast<double>(lines.size()) * row;
  double widest = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    widest = std::max(widest, render::text_width(lines[k], context.style.small_text_px) * scale);
    layer.labels.push_back({.at = camera.to_world({left, top + (static_cast<double>(k) + 0.5) * row}),
                            .text = lines[k],
                            .color = context.style.warning,
                            .halo = context.style.halo,
                            .size_px = context.style.small_text_px,
                            .anchor = render::Anchor::Right,
                            .offset_px = 0});
  }
  const PixelBox box{left, top, left + widest, bottom};
  context.labels.avoid(box);
  context.legend.occupy(box);
}

void add_legend(const OverlayContext& context, const Lengths& reaction, const Lengths& moment) {
  const render::Color color = context.style.force;
  const auto& views = context.demo.bridges();
  if (std::all_of(views.begin(), views.end(), [](const BridgeView& view) { return view.bridge->moving(); }))
    return;
  if (reaction.amount > 0)
    context.legend.arrow(color, reaction.legend_px(context), "support reaction " + si(reaction.amount, "N"));
  if (moment.amount > 0)
    context.legend.bar(color, moment.legend_px(context),
                       "bending moment " + si(moment.amount, "N m") + ", on the stretched side");
}

}  // namespace

void draw_stresses(const OverlayContext& context, render::DrawList& list) {
  if (context.demo.bridges().empty()) return;
  render::DrawLayer& members = list[render::Layer::Structure];
  render::DrawLayer& marks = list[render::Layer::Contacts];
  render::DrawLayer& words = list[render::Layer::Labels];
  const Lengths reaction(context, kLongestArrow, context.history.largest_reaction());
  const Lengths moment(context, kMomentHeight, context.history.largest_moment());
  add_legend(context, reaction, moment);
  draw_breaks(context, draw_scale(context, words) - 6 * render::ui_scale(context.camera.height_px), words);
  // First all lines, then words that keep off them.
  std::vector<ReactionArrow> arrows;
  std::vector<Summit> summits;
  for (const BridgeView& view : context.demo.bridges()) {
    const Bridge& bridge = *view.bridge;
    draw_members(context, bridge, members);
    if (bridge.moving()) continue;
    draw_supports(context, bridge, members);
    draw_nodes(context, bridge, marks);
    const std::vector<ReactionArrow> more = draw_reactions(context, bridge, reaction, marks);
    arrows.insert(arrows.end(), more.begin(), more.end());
    summits.push_back(draw_moments(context, bridge, moment, marks));
  }
  label_reactions(context, arrows);
  for (const Summit& summit : summits) label_summit(context, summit);
  for (const BridgeView& view : context.demo.bridges())
    if (view.numbers) draw_numbers(context, *view.bridge);
  for (const BridgeView& view : context.demo.bridges())
    draw_peaks(context, *view.bridge, view.numbers, marks);
}

}  // namespace skerry::sandbox
