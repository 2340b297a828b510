// SPDX-License-Identifier: MIT
//
// Separating axes of a picked pair: the projections of both shapes on the normal of every edge, beside the
// pair. The axis with the largest gap, or the smallest overlap, gives the contact normal.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "sandbox/overlays/labels.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

constexpr std::size_t kMostAxes = 8;

/// A convex shape at its place.
struct Placed {
  const Shape* shape;
  Transform pose;
  BodyId body;

  bool is_half_plane() const { return shape->kind == ShapeKind::HalfPlane; }
  // Farthest coordinate along a direction; endless for half-planes.
  double support(Vec2 direction) const {
    if (is_half_plane()) {
      const Vec2 normal = rotate(pose.q, shape->normals.front());
      if (dot(normal, direction) < 1 - 1e-12) return HUGE_VAL;
    }
    double most = -HUGE_VAL;
    for (const Vec2 vertex : shape->vertices) most = std::max(most, dot(to_world(pose, vertex), direction));
    return most + shape->radius;
  }
};

/// One axis: how far B is beyond A along it.
struct TestedAxis {
  Vec2 direction;
  std::string from;
  double gap;
};

// The pair of the selection, else the one that overlaps most.
std::optional<std::pair<Placed, Placed>> picked_pair(const OverlayContext& context) {
  const World& world = context.world;
  const ContactReport* best = nullptr;
  double least = HUGE_VAL;
  for (const ContactReport& contact : world.report().contacts_list) {
    if (contact.count == 0) continue;
    const Selection& s = context.selection;
    const auto has = [&](BodyId body) { return contact.body_a == body || contact.body_b == body; };
    if (s.body && !has(s.body)) continue;
    if (s.body && s.other && !has(s.other)) continue;
    const ShapeRecord& a = world.shapes()[contact.shape_a.index];
    const ShapeRecord& b = world.shapes()[contact.shape_b.index];
    if (a.shape->kind == ShapeKind::Chain || b.shape->kind == ShapeKind::Chain) continue;
    double separation = contact.points[0].separation;
    if (contact.count > 1) separation = std::min(separation, contact.points[1].separation);
    // Rounding noise must not make the choice flicker.
    if (best && separation > least - 1e-9) continue;
    least = separation;
    best = &contact;
  }
  if (!best) return std::nullopt;
  const auto placed = [&](ShapeId id, BodyId body) {
    return Placed{&*world.shapes()[id.index].shape, context.demo.shown(body.index).pose(), body};
  };
  return std::pair(placed(best->shape_a, best->body_a), placed(best->shape_b, best->body_b));
}

Vec2 nearest_vertex(const Placed& shape, Vec2 to) {
  Vec2 best = to_world(shape.pose, shape.shape->vertices.front());
  for (const Vec2 vertex : shape.shape->vertices) {
    const Vec2 p = to_world(shape.pose, vertex);
    if (length(p - to) < length(best - to)) best = p;
  }
  return best;
}

std::vector<TestedAxis> axes_of(const World& world, const Placed& a, const Placed& b) {
  std::vector<TestedAxis> axes;
  const auto add = [&](Vec2 direction, std::string from) {
    // From A to B: the gap is where B begins minus where A ends.
    const double gap = -b.support(-direction) - a.support(direction);
    if (!std::isfinite(gap)) return;
    for (TestedAxis& other : axes) {
      if (dot(other.direction, direction) < 1 - 1e-9) continue;
      other.from += ", " + from;
      return;
    }
    axes.push_back({direction, std::move(from), gap});
  };
  const auto add_edges = [&](const Placed& of, double sign) {
    const std::string name = body_label(world, of.body);
    for (std::size_t i = 0; i < of.shape->normals.size(); ++i)
      add(sign * rotate(of.pose.q, of.shape->normals[i]), name + " edge " + std::to_string(i + 1));
  };
  add_edges(a, 1);
  add_edges(b, -1);
  // Round corners: the line between the nearest corners is an axis, too.
  const bool round = a.shape->radius > 0 || b.shape->radius > 0;
  if (round && !a.is_half_plane() && !b.is_half_plane()) {
    Vec2 q = nearest_vertex(b, a.pose.p);
    const Vec2 p = nearest_vertex(a, q);
    q = nearest_vertex(b, p);
    if (length(q - p) > 0) add((1 / length(q - p)) * (q - p), "corners");
  }
  std::stable_sort(axes.begin(), axes.end(),
                   [](const TestedAxis& x, const TestedAxis& y) { return x.gap > y.gap; });
  if (axes.size() > kMostAxes) axes.resize(kMostAxes);
  return axes;
}

double radius_of(const Placed& shape) {
  return shape.is_half_plane() ? 0 : bounding_radius(*shape.shape);
}

std::string gap_text(double gap) {
  return (gap > 0 ? "gap " : "overlap ") + si(std::abs(gap), "m");
}

}  // namespace

void draw_sat(const OverlayContext& context, render::DrawList& list) {
  const auto pair = picked_pair(context);
  if (!pair) return;
  const auto& [a, b] = *pair;
  const std::vector<TestedAxis> axes = axes_of(context.world, a, b);
  const render::Style& style = context.style;
  render::DrawLayer& layer = list[render::Layer::Contacts];
  const double pixel = render::ui_scale(context.camera.height_px) / context.camera.pixels_per_metre();
  const Vec2 middle = a.is_half_plane()   ? b.pose.p
                      : b.is_half_plane() ? a.pose.p
                                          : 0.5 * (a.pose.p + b.pose.p);
  const double reach = std::max(
      {radius_of(a) + length(a.pose.p - middle), radius_of(b) + length(b.pose.p - middle), 40 * pixel});
  const render::Color color_a = style.friction, color_b = style.impulse;
  // The four best axes; more would hide the pair.
  for (std::size_t i = std::min<std::size_t>(axes.size(), 4); i-- > 0;) {
    const Vec2 d = axes[i].direction;
    Vec2 side = perp(d);
    // Above the pair, or at its right: rounding of an upright axis must not decide.
    if (side.y < -1e-6 || (side.y < 1e-6 && side.x < 0)) side = -side;
    const Vec2 base = middle + (reach + (18 + 6 * static_cast<double>(i)) * pixel) * side;
    const double zero = dot(base, d);
    const auto at = [&](double along, double away) {
      const double shift = std::clamp(along - zero, -1.3 * reach, 1.3 * reach);
      return to_point(base + shift * d + away * side);
    };
    const double brightness = i == 0 ? 1 : 0.45;
    layer.lines.push_back({.from = at(-HUGE_VAL, 0),
                           .to = at(HUGE_VAL, 0),
                           .color = render::faded(style.text_dim, brightness),
                           .width_px = 1});
    const auto bar = [&](const Placed& shape, double away, render::Color color) {
      layer.lines.push_back({.from = at(-shape.support(-d), away * pixel),
                             .to = at(shape.support(d), away * pixel),
                             .color = render::faded(color, brightness),
                             .width_px = i == 0 ? 4.5f : 3.0f});
    };
    bar(a, 4, color_a);
    bar(b, -4, color_b);
    if (i == 0) {
      const double edge = 0.5 * (a.support(d) - b.support(-d));
      const render::Point contact = at(edge, 0);
      context.labels.add({contact.x, contact.y}, gap_text(axes[0].gap), style.text);
    }
  }
  context.legend.swatch({color_a, color_a}, "projection of " + body_label(context.world, a.body));
  context.legend.swatch({color_b, color_b}, "projection of " + body_label(context.world, b.body));
}

void show_sat(const PanelContext& context) {
  constexpr double kRowPx = 18;
  static_assert(kRowPx * (kMostAxes + 1) <= kSatPx);
  const render::Style& style = context.scene.style;
  const auto pair = picked_pair(context.scene);
  if (!pair) {
    const Panel panel(context, "Separating axes", 24);
    panel.text(0, 0, style.text_dim, "no pair is near");
    return;
  }
  const World& world = context.scene.world;
  const std::vector<TestedAxis> axes = axes_of(world, pair->first, pair->second);
  const Panel panel(context, "Separating axes", kRowPx * static_cast<double>(axes.size() + 1));
  panel.text(0, 0, style.text_dim,
             "from " + body_label(world, pair->first.body) + " to " + body_label(world, pair->second.body) +
                 ", the largest first");
  double y = kRowPx;
  for (std::size_t i = 0; i < axes.size(); ++i, y += kRowPx) {
    const render::Color color = i == 0 ? style.text : style.text_dim;
    panel.fitted(0, y, panel.width() - 150, color, (i == 0 ? "\xE2\x86\x92 " : "") + axes[i].from);
    panel.text(panel.width(), y, color, gap_text(axes[i].gap), render::Face::Regular, render::Align::Right);
  }
}

}  // namespace skerry::sandbox
