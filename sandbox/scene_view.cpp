// SPDX-License-Identifier: MIT
#include "sandbox/scene_view.h"

#include <cmath>
#include <vector>

#include "sandbox/layout.h"

namespace skerry::sandbox {
namespace {

using render::Layer;

// Whole metres, or a power of ten of them when the view is much larger or smaller.
double grid_step(const render::Camera& camera) {
  return std::pow(10.0, std::floor(std::log10(camera.height / 3)));
}

// Beyond 2^40 steps from the origin the numbers of lines lose their meaning.
bool is_countable(double coordinate, double step) {
  return std::abs(coordinate / step) <= 1e12;
}

void draw_grid(const OverlayContext& context, render::DrawLayer& layer) {
  const render::Camera& camera = context.camera;
  const double step = grid_step(camera);
  const auto lines = [&](double middle, double extent, auto&& add) {
    const auto first = static_cast<long long>(std::floor((middle - 0.5 * extent) / step));
    const auto last = static_cast<long long>(std::ceil((middle + 0.5 * extent) / step));
    for (long long i = first; i <= last; ++i) {
      const bool major = i % 10 == 0;
      add(static_cast<double>(i) * step, major ? context.style.grid_major : context.style.grid);
    }
  };
  const double left = camera.centre.x - 0.5 * camera.width();
  const double low = camera.centre.y - 0.5 * camera.height;
  if (!is_countable(left, step) || !is_countable(low, step)) return;
  lines(camera.centre.x, camera.width(), [&](double x, render::Color color) {
    layer.lines.push_back(
        {.from = {x, low}, .to = {x, low + camera.height}, .color = color, .width_px = 1.0f});
  });
  lines(camera.centre.y, camera.height, [&](double y, render::Color color) {
    layer.lines.push_back(
        {.from = {left, y}, .to = {left + camera.width(), y}, .color = color, .width_px = 1.0f});
  });
}

/// @param moves  has marks along its edge, which would not show otherwise
void draw_half_plane(const OverlayContext& context, const Shape& shape, const Transform& pose, bool moves,
                     render::Paint paint, render::DrawLayer& layer) {
  const Vec2 normal = rotate(pose.q, shape.normals.front());
  const Vec2 anchor = to_world(pose, shape.vertices.front());
  const render::Camera& camera = context.camera;
  // The part of its edge that is nearest to the middle of the picture, long enough to leave it on both sides.
  const Vec2 along = -perp(normal);
  const Vec2 centre{camera.centre.x, camera.centre.y};
  const Vec2 foot = anchor + dot(centre - anchor, along) * along;
  const double reach = 2 * (camera.width() + camera.height) + std::abs(dot(centre - anchor, normal));
  const Vec2 left = foot - reach * along;
  const Vec2 right = foot + reach * along;
  const Vec2 down = -reach * normal;
  const render::Point corners[] = {to_point(left + down), to_point(right + down), to_point(right),
                                   to_point(left)};
  layer.polygon(corners, 4, paint.fill, paint.outline);
  const double step = 0.5 * grid_step(camera), middle = dot(foot - anchor, along);
  if (!moves || !is_countable(middle, step)) return;
  const double half = 0.5 * (camera.width() + camera.height);
  const auto first = static_cast<long long>(std::ceil((middle - half) / step));
  const auto last = static_cast<long long>(std::floor((middle + half) / step));
  for (long long i = first; i <= last; ++i) {
    const Vec2 at = anchor + (static_cast<double>(i) * step) * along;
    layer.lines.push_back({.from = to_point(at),
                           .to = to_point(at - 0.35 * step * (normal + along)),
                           .color = paint.outline,
                           .width_px = context.style.outline_px});
  }
}

/// A line with a band on its solid side; a sensor has none and is dashed.
void draw_chain(const OverlayContext& context, const Shape& shape, bool sensor, const Transform& pose,
                render::Paint paint, render::DrawLayer& layer) {
  // Corners that are less than half a pixel from the last one would not show.
  const double pixel = 1 / context.camera.pixels_per_metre();
  std::vector<Vec2> way;
  for (const Vec2 vertex : shape.vertices) {
    const Vec2 corner = to_world(pose, vertex);
    if (way.empty() || length(corner - way.back()) >= 0.5 * pixel) way.push_back(corner);
  }
  if (!shape.closed && way.size() > 1) way.back() = to_world(pose, shape.vertices.back());
  const std::size_t count = way.size(), segments = shape.closed ? count : count - 1;
  if (count < 2) return;
  const double width = context.camera.height / 60;
  const auto fill = [&](std::initializer_list<Vec2> area) {
    std::vector<render::Point> corners;
    for (const Vec2 corner : area) corners.push_back(to_point(corner));
    layer.polygon(corners.data(), corners.size(), paint.fill, paint.fill, 0, 1);
  };
  const auto right_of = [&](std::size_t i) {
    const Vec2 edge = way[(i + 1) % count] - way[i];
    return (-width / length(edge)) * perp(edge);
  };
  for (std::size_t i = 0; i < segments && !sensor; ++i) {
    const Vec2 from = way[i], to = way[(i + 1) % count], side = right_of(i);
    fill({from, from + side, to + side, to});
    // The wedge where the way turns to the left, away from what is solid.
    if (i + 1 == segments && !shape.closed) continue;
    const Vec2 next = right_of((i + 1) % segments);
    if (cross(side, next) > 0) fill({to, to + side, to + next});
  }
  for (std::size_t i = 0; i < segments; ++i)
    layer.lines.push_back({.from = to_point(way[i]),
                           .to = to_point(way[(i + 1) % count]),
                           .color = paint.outline,
                           .width_px = 2 * context.style.outline_px,
                           .dash_px = sensor ? 6.0f : 0.0f});
}

using Grounds = std::vector<const ShapeRecord*>;  // half-planes

/// Whether a fixed disc sticks in the ground.
bool sticks_in_ground(const World& world, const Grounds& grounds, const ShapeRecord& record) {
  if (world.bodies().type[record.body.index] != BodyType::Static) return false;
  const Vec2 centre = to_world(world.pose(record.body), record.shape->vertices.front());
  for (const ShapeRecord* ground : grounds) {
    const Transform pose = world.pose(ground->body);
    const double height = dot(rotate(pose.q, ground->shape->normals.front()),
                              centre - to_world(pose, ground->shape->vertices.front()));
    if (std::abs(height) < record.shape->radius) return true;
  }
  return false;
}

void draw_shape(const OverlayContext& context, const ShapeRecord& record, const Transform& pose,
                render::Paint paint, double angle, const Grounds& grounds, render::DrawLayer& layer) {
  const Shape& shape = record.shape;
  if (record.sensor) paint.fill = render::faded(paint.fill, 0.25);
  const float outline = context.style.outline_px;
  switch (shape.kind) {
    case ShapeKind::Disc: {
      const Vec2 centre = to_world(pose, shape.vertices.front());
      // Discs are drawn after polygons; a bump of the ground has to come before it. 64 corners are round
      // to a tenth of a pixel up to this size.
      if (shape.radius * context.camera.pixels_per_metre() < 80 &&
          sticks_in_ground(context.world, grounds, record)) {
        std::vector<render::Point> corners;
        for (int k = 0; k < 64; ++k) {
          const SinCos sc = sin_cos(2 * kPi * k / 64);
          corners.push_back(to_point(centre + shape.radius * Vec2{sc.cos, sc.sin}));
        }
        layer.polygon(corners.data(), corners.size(), paint.fill, paint.outline, 0, outline);
        break;
      }
      layer.discs.push_back({.centre = to_point(centre),
                             .radius = shape.radius,
                             .fill = paint.fill,
                             .outline = paint.outline,
                             .outline_px = outline,
                             .angle = angle,
                             .spoke = context.world.bodies().type[record.body.index] != BodyType::Static});
      break;
    }
    case ShapeKind::Capsule:
      layer.capsules.push_back({.from = to_point(to_world(pose, shape.vertices[0])),
                                .to = to_point(to_world(pose, shape.vertices[1])),
                                .radius = shape.radius,
                                .fill = paint.fill,
                                .outline = paint.outline,
                                .outline_px = outline});
      break;
    case ShapeKind::Polygon: {
      std::vector<render::Point> corners;
      for (const Vec2 corner : shape.vertices) corners.push_back(to_point(to_world(pose, corner)));
      layer.polygon(corners.data(), corners.size(), paint.fill, paint.outline, shape.radius, outline);
      break;
    }
    case ShapeKind::HalfPlane:
      draw_half_plane(context, shape, pose,
                      context.world.bodies().type[record.body.index] == BodyType::Kinematic, paint, layer);
      break;
    case ShapeKind::Chain:
      draw_chain(context, shape, record.sensor, pose, paint, layer);
      break;
  }
}

/// Draws one joint: pins where it turns, lines where it pulls, a zigzag where it springs.
class JointPicture {
 public:
  JointPicture(const OverlayContext& context, const JointRecord& joint, render::DrawLayer& layer)
      : style_(context.style), joint_(joint), layer_(layer) {
    const auto anchor = [&](BodyId body, Vec2 local) {
      return body ? to_world(context.demo.shown(body.index).pose(), local) : local;
    };
    a_ = anchor(joint.def.a, joint.local_a);
    b_ = anchor(joint.def.b, joint.local_b);
    const Rot turn = joint.def.a ? context.demo.shown(joint.def.a.index).pose().q : Rot{};
    axis_ = joint.def.kind == JointKind::Rack ? joint.local_axis : rotate(turn, joint.local_axis);
  }

  void draw() {
    const JointDef& def = joint_.def;
    switch (def.kind) {
      case JointKind::Revolute:
        return pin(b_);
      case JointKind::Motor:
        return pin(b_);
      case JointKind::Weld:
        return mark(b_, style_.joint);
      case JointKind::Distance:
        if (def.stiffness > 0 || def.damping > 0) return zigzag(a_, b_);
        line(a_, b_, 0);
        pin(a_);
        return pin(b_);
      case JointKind::Rope: {
        // A slack rope is dashed: it pulls only when it is straight.
        const bool slack = length(b_ - a_) < joint_.length * (1 - 1e-6);
        line(a_, b_, slack ? 6 : 0);
        pin(a_);
        return pin(b_);
      }
      case JointKind::Spring:
        return zigzag(a_, b_);
      case JointKind::Prismatic:
        rail();
        return mark(b_, style_.joint);
      case JointKind::Wheel:
        zigzag(b_ + reach() * axis_, b_);
        return pin(b_);
      case JointKind::Pulley:
        line(a_, def.pulley_a, 0);
        line(def.pulley_a, def.pulley_b, 0);
        line(def.pulley_b, b_, 0);
        pin(def.pulley_a);
        return pin(def.pulley_b);
      case JointKind::Gear:
        return line(a_, b_, 6);
      case JointKind::Rack:
        return line(a_, b_, 6);
    }
  }

 private:
  void mark(Vec2 at, render::Color fill) {
    layer_.markers.push_back({.at = to_point(at), .fill = fill, .outline = style_.joint, .radius_px = 4.5f});
  }
  /// Open where something turns; full where it does not.
  void pin(Vec2 at) { mark(at, style_.background); }

  void line(Vec2 from, Vec2 to, float dash) {
    layer_.lines.push_back({.from = to_point(from),
                            .to = to_point(to),
                            .color = style_.joint,
                            .width_px = style_.joint_px,
                            .dash_px = dash});
  }

  /// The way of a slider, between its limits where it has some.
  void rail() {
    const double low = joint_.def.lower.value_or(-reach()), high = joint_.def.upper.value_or(reach());
    line(a_ + low * axis_, a_ + high * axis_, joint_.def.lower || joint_.def.upper ? 0.0f : 6.0f);
  }

  double reach() const { return 0.5; }

  /// Eight turns whose width follows from the length at rest, so that stretching shows.
  void zigzag(Vec2 from, Vec2 to) {
    constexpr int kTurns = 8;
    const Vec2 d = to - from;
    const double distance = length(d);
    const double rest = joint_.length > 0 ? joint_.length : distance;
    const Vec2 side = distance > 0 ? (std::min(0.06 * rest, 0.12) / distance) * perp(d) : Vec2{};
    Vec2 last = from;
    for (int i = 0; i <= kTurns; ++i) {
      const Vec2 next = from + ((i + 0.5) / (kTurns + 1)) * d + (i % 2 == 0 ? side : -side);
      line(last, next, 0);
      last = next;
    }
    line(last, to, 0);
    pin(from);
    pin(to);
  }

  const render::Style& style_;
  const JointRecord& joint_;
  render::DrawLayer& layer_;
  Vec2 a_, b_, axis_;
};

}  // namespace

Vec2 shown_point(const OverlayContext& context, const ContactReport& contact, Vec2 point) {
  const BodyArrays& bodies = context.world.bodies();
  const bool second = bodies.type[contact.body_b.index] == BodyType::Dynamic;
  const std::size_t body = second ? contact.body_b.index : contact.body_a.index;
  return point + (context.demo.shown(body).position - bodies.position[body]);
}

render::Paint paint_of(const OverlayContext& context, std::size_t body) {
  const BodyArrays& bodies = context.world.bodies();
  const int color = context.demo.picture().colors.of(context.world.body_id(body));
  render::Paint paint = render::body_paint(context.style, 0);
  if (color >= 0)
    paint = render::body_paint(context.style, color);
  else if (bodies.type[body] != BodyType::Dynamic)
    paint = context.style.ground;
  if (context.selection.body && context.selection.body.index == body)
    paint.outline = context.style.selected.outline;
  return paint;
}

void draw_outline(const World& world, std::size_t body, const Transform& pose, double angle,
                  render::Color color, float width_px, render::DrawLayer& layer) {
  const render::Color clear = render::faded(color, 0);
  for (const ShapeRecord& record : world.shapes()) {
    if (!record.alive || record.body.index != body) continue;
    const Shape& shape = record.shape;
    if (shape.kind == ShapeKind::Disc) {
      layer.discs.push_back({.centre = to_point(to_world(pose, shape.vertices.front())),
                             .radius = shape.radius,
                             .fill = clear,
                             .outline = color,
                             .outline_px = width_px,
                             .angle = angle,
                             .spoke = true});
    } else if (shape.kind == ShapeKind::Capsule) {
      layer.capsules.push_back({.from = to_point(to_world(pose, shape.vertices[0])),
                                .to = to_point(to_world(pose, shape.vertices[1])),
                                .radius = shape.radius,
                                .fill = clear,
                                .outline = color,
                                .outline_px = width_px});
    } else if (shape.kind == ShapeKind::Polygon) {
      std::vector<render::Point> corners;
      for (const Vec2 corner : shape.vertices) corners.push_back(to_point(to_world(pose, corner)));
      layer.polygon(corners.data(), corners.size(), clear, color, shape.radius, width_px);
    }
  }
}

void draw_world(const OverlayContext& context, render::DrawList& list) {
  list.background = context.style.background;
  draw_grid(context, list[Layer::Background]);
  Grounds grounds;
  for (const ShapeRecord& shape : context.world.shapes())
    if (shape.alive && shape.shape->kind == ShapeKind::HalfPlane) grounds.push_back(&shape);
  // Static shapes, then the endless ground that they may stick in, then all that moves.
  enum class Turn { Static, Ground, Moving };
  for (const Turn turn : {Turn::Static, Turn::Ground, Turn::Moving}) {
    for (const ShapeRecord& shape : context.world.shapes()) {
      if (!shape.alive) continue;
      const std::size_t body = shape.body.index;
      const bool fixed = context.world.bodies().type[body] == BodyType::Static;
      const Turn its = shape.shape->kind == ShapeKind::HalfPlane ? Turn::Ground
                       : fixed                                   ? Turn::Static
                                                                 : Turn::Moving;
      if (its != turn) continue;
      const BodyState shown = context.demo.shown(body);
      draw_shape(context, shape, shown.pose(), paint_of(context, body), shown.angle, grounds,
                 list[Layer::Bodies]);
    }
  }
  for (const JointRecord& joint : context.world.joints())
    if (joint.alive) JointPicture(context, joint, list[Layer::Structure]).draw();

  context.legend.length_bar(round_down_125(context.camera.height / 5), context.camera.width_px);
}

}  // namespace skerry::sandbox
