// SPDX-License-Identifier: MIT
//
// The selected body: mass, state, why it is awake, and its free-body diagram: the body alone, with all forces
// on it (physics/body_forces.h). They are means over the last step; impacts of contacts are not among them.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "physics/body_forces.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

constexpr double kDiagramPx = 168;
constexpr std::size_t kMostForces = 7;
constexpr double kForceRowPx = 17;
constexpr double kTorquePx = 13, kNextTorquePx = 7;  // radius of the arc that shows which way a torque turns
constexpr double kNoise = 1e-10;  // share of a quantity below which a part of it is rounding

/// A force on the body, as the panel shows it.
struct Force {
  ForceSource source;
  BodyId other;
  std::string from;
  Vec2 point, force;  ///< world frame [m], [N]
  double torque = 0;  ///< [N m]
  render::Color color;
};

std::string source_name(const World& world, const BodyForce& force) {
  switch (force.source) {
    case ForceSource::Weight:
      return "own weight";  // there may be a body of that name
    case ForceSource::Contact:
      return body_label(world, force.other);
    case ForceSource::Joint:
      return body_label(world, force.other) + " (joint)";
    case ForceSource::Applied:
      return "applied";
    case ForceSource::Field:
      return "field";
    case ForceSource::Drag:
      return "drag";
  }
  return "";
}

render::Color source_color(const render::Style& style, ForceSource source) {
  switch (source) {
    case ForceSource::Contact:
      return style.force;
    case ForceSource::Joint:
      return style.joint;
    case ForceSource::Weight:
      return style.velocity;
    case ForceSource::Applied:
      return style.friction;
    case ForceSource::Field:
      return style.impulse;
    case ForceSource::Drag:
      break;
  }
  return render::body_paint(style, 1).outline;
}

double reach_of(const World& world, BodyId body) {
  double reach = 0;
  for (const ShapeRecord& shape : world.shapes())
    if (shape.alive && shape.body == body && shape.shape->kind != ShapeKind::HalfPlane)
      reach = std::max(reach, bounding_radius(shape.shape));
  return reach > 0 ? reach : 1;
}

std::vector<Force> shown_forces(const OverlayContext& context, BodyId body) {
  const World& world = context.world;
  const Transform then = world.pose(body), now = context.demo.shown(body.index).pose();
  const double floor = context.history.force_floor(world), reach = reach_of(world, body);
  std::vector<Force> forces;
  for (const BodyForce& force : forces_on(world, body)) {
    Vec2 at = force.point;
    double torque = force.torque;
    const double size = length(force.force);
    // A force that was applied off the centre is drawn on its line, where that meets the body.
    if (force.source == ForceSource::Applied && size > floor && std::abs(torque) <= size * reach) {
      at += torque / (size * size) * perp(force.force);
      torque = 0;
    }
    if (size <= floor && std::abs(torque) <= floor * reach) continue;
    forces.push_back({force.source, force.other, source_name(world, force), to_world(now, to_local(then, at)),
                      force.force, std::abs(torque) > floor * reach ? torque : 0,
                      source_color(context.style, force.source)});
  }
  return forces;
}

std::string why_awake(const OverlayContext& context, BodyId body) {
  const World& world = context.world;
  const BodyArrays& bodies = world.bodies();
  if (bodies.type[body.index] == BodyType::Static) return "fixed: never steps";
  if (bodies.type[body.index] == BodyType::Kinematic) return "kinematic: moves as told";
  if (bodies.asleep[body.index]) return "asleep: at rest to the bit, not stepped";
  const int island = bodies.island[body.index];
  const auto& islands = world.report().islands_list;
  if (island < 0 || static_cast<std::size_t>(island) >= islands.size()) return "not stepped yet";
  const IslandReport& report = islands[static_cast<std::size_t>(island)];
  if (report.rows == 0 && report.contacts == 0) return "in flight: nothing within reach";
  const double floor = world.config().rest_speed;
  const double speed = length(world.velocity(body)), turn = std::abs(world.omega(body));
  if (speed > floor) return "awake: moves at " + si(speed, "m/s");
  if (turn > floor) return "awake: turns at " + si(turn, "rad/s");
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies.alive[i] || bodies.island[i] != island) continue;
    if (length(bodies.velocity[i]) <= floor && std::abs(bodies.omega[i]) <= floor) continue;
    return "awake: " + body_label(world, world.body_id(i)) + " of its island moves";
  }
  if (world.report().islands_at_rest == world.report().islands)
    return "at rest: nothing changed, forces kept";
  return "at rest: nothing of its island moves";
}

/// From the world to the diagram: the body fills its middle, arrows reach to the rim.
struct Diagram {
  const Panel& panel;
  Vec2 centre;
  double metres, newtons;  ///< pixels of the style for each

  double x(Vec2 p) const { return 0.5 * kDiagramPx + metres * (p.x - centre.x); }
  double y(Vec2 p, double top) const { return top + 0.5 * kDiagramPx - metres * (p.y - centre.y); }
};

void draw_body(const OverlayContext& context, const Diagram& diagram, BodyId body, double top) {
  const Transform pose = context.demo.shown(body.index).pose();
  for (const ShapeRecord& shape : context.world.shapes()) {
    if (!shape.alive || shape.body != body) continue;
    const Shape& s = shape.shape;
    std::vector<render::Pixel> outline;
    const auto add = [&](Vec2 local) {
      const Vec2 p = to_world(pose, local);
      outline.push_back(diagram.panel.at(diagram.x(p), diagram.y(p, top)));
    };
    constexpr int kRound = 48;
    if (s.kind == ShapeKind::Disc || s.kind == ShapeKind::Capsule) {
      const Vec2 axis = s.vertices.size() > 1 ? s.vertices[1] - s.vertices[0] : Vec2{0, 0};
      for (int k = 0; k <= kRound; ++k) {
        const SinCos sc = sin_cos(2 * kPi * k / kRound);
        const Vec2 out{sc.cos, sc.sin};
        add((dot(out, axis) > 0 ? s.vertices.back() : s.vertices.front()) + s.radius * out);
      }
    } else if (s.kind == ShapeKind::Polygon) {
      for (const Vec2 vertex : s.vertices) add(vertex);
      add(s.vertices.front());
    }
    diagram.panel.curve(outline, context.style.text, 1.6);
  }
}

void draw_force(const Diagram& diagram, const Force& force, double top) {
  const double x0 = diagram.x(force.point), y0 = diagram.y(force.point, top);
  const double dx = diagram.newtons * force.force.x, dy = -diagram.newtons * force.force.y;
  const double size = std::hypot(dx, dy);
  if (size < 2) return;
  const double ux = dx / size, uy = dy / size, head = std::min(9.0, size);
  const double x1 = x0 + dx, y1 = y0 + dy;
  diagram.panel.line(x0, y0, x1 - ux * 0.7 * head, y1 - uy * 0.7 * head, force.color, 2.4);
  diagram.panel.triangle(x1, y1, x1 - head * ux - 0.42 * head * uy, y1 - head * uy + 0.42 * head * ux,
                         x1 - head * ux + 0.42 * head * uy, y1 - head * uy - 0.42 * head * ux, force.color);
}

void draw_torque(const Diagram& diagram, const Force& force, double radius, double top) {
  const double x = diagram.x(force.point), y = diagram.y(force.point, top);
  const double way = force.torque > 0 ? 1 : -1;
  constexpr int kSteps = 24;
  constexpr double kTurn = 1.5 * kPi, kHead = 7;
  std::vector<render::Pixel> arc;
  SinCos end{};
  for (int k = 0; k <= kSteps; ++k) {
    end = sin_cos(way * (kTurn * k / kSteps - 0.75 * kPi) + 0.5 * kPi);
    arc.push_back(diagram.panel.at(x + radius * end.cos, y - radius * end.sin));
  }
  diagram.panel.curve(arc, force.color, 2.4);
  // The head goes on along the tangent.
  const double ex = x + radius * end.cos, ey = y - radius * end.sin;
  const double ux = -way * end.sin, uy = -way * end.cos;
  diagram.panel.triangle(ex + kHead * ux, ey + kHead * uy, ex - 0.6 * kHead * uy, ey + 0.6 * kHead * ux,
                         ex + 0.6 * kHead * uy, ey - 0.6 * kHead * ux, force.color);
}

/// "3 N", "2 N m" or both.
std::string force_text(const Force& force) {
  if (force.torque == 0) return si(length(force.force), "N");
  const std::string torque = si(std::abs(force.torque), "N m");
  return force.force == Vec2{} ? torque : si(length(force.force), "N") + ", " + torque;
}

/// Without what rounding leaves beside quantities of this size.
double quiet(double value, double size) {
  return std::abs(value) <= kNoise * size ? 0 : value;
}

}  // namespace

void show_inspector(const PanelContext& context) {
  const OverlayContext& scene = context.scene;
  const render::Style& style = scene.style;
  const World& world = scene.world;
  const BodyId body = scene.selection.body;
  if (!body || !world.alive(body)) {
    const Panel panel(context, "Inspector", 24);
    panel.text(0, 0, style.text_dim, "no body is selected");
    return;
  }
  const std::string name = body_label(world, body);
  const Panel panel(context, ("Body " + name + "###inspector").c_str(), kInspectorPx);
  const BodyState state = scene.demo.shown(body.index);
  const Vec2 p = state.position, v = state.velocity;
  char text[160];
  double y = 0;
  const auto line = [&](render::Color color) {
    panel.fitted(0, y, panel.width(), color, text);
    y += kLinePx + 1;
  };
  if (world.mass(body) > 0)
    std::snprintf(text, sizeof text, "mass %.4g kg, inertia %.4g kg m\xC2\xB2", world.mass(body),
                  world.inertia(body));
  else
    std::snprintf(text, sizeof text, "infinite mass");
  line(style.text);
  // Slower than 1e-12 m/s, or turned less than 1e-12 rad, is at rest to people.
  const double reach = reach_of(world, body);
  const double size = std::max(length(p), reach);
  const double speed = std::max({length(v), std::abs(state.omega) * reach, 0.01});
  std::snprintf(text, sizeof text, "at (%.4g, %.4g) m, angle %.4g rad", quiet(p.x, size), quiet(p.y, size),
                quiet(state.angle, 0.01));
  line(style.text);
  std::snprintf(text, sizeof text, "velocity (%.3g, %.3g) m/s, %.3g rad/s", quiet(v.x, speed),
                quiet(v.y, speed), quiet(state.omega, speed / reach));
  line(style.text);
  const int island = world.bodies().island[body.index];
  const std::string where = island >= 0 ? "island " + std::to_string(island + 1) + ", " : "";
  std::snprintf(text, sizeof text, "%s%s", where.c_str(), why_awake(scene, body).c_str());
  line(style.text_dim);

  // The diagram on the left, the forces by origin on the right.
  y += 4;
  const std::vector<Force> forces = shown_forces(scene, body);
  double largest = 0;
  Vec2 sum{};
  for (const Force& force : forces) {
    largest = std::max(largest, length(force.force));
    sum += force.force;
  }
  const Diagram diagram{panel, p, 0.24 * kDiagramPx / reach, largest > 0 ? 0.24 * kDiagramPx / largest : 0};
  panel.frame(0, y, kDiagramPx, kDiagramPx, style.panel_border);
  draw_body(scene, diagram, body, y);
  double radius = kTorquePx;  // of the next one: they often have one centre
  for (const Force& force : forces) {
    draw_force(diagram, force, y);
    if (force.torque == 0) continue;
    draw_torque(diagram, force, radius, y);
    radius += kNextTorquePx;
  }

  const double left = kDiagramPx + 14, right = panel.width();
  panel.text(left, y, style.text_dim, "force on " + name + " from");
  double row = y + kForceRowPx + 2;
  std::vector<Force> listed;
  for (const Force& force : forces) {
    const auto same = std::find_if(listed.begin(), listed.end(), [&](const Force& other) {
      return other.source == force.source && other.other == force.other;
    });
    if (same == listed.end()) {
      listed.push_back(force);
    } else {
      same->force += force.force;
      same->torque += force.torque;
    }
  }
  for (std::size_t i = 0; i < std::min(listed.size(), kMostForces); ++i, row += kForceRowPx) {
    panel.rect(left, row + 4, 9, 9, listed[i].color);
    const std::string value = force_text(listed[i]);
    panel.fitted(left + 14, row, right - left - 24 - panel.text_width(value), style.text, listed[i].from);
    panel.text(right, row, style.text, value, render::Face::Regular, render::Align::Right);
  }
  if (listed.size() > kMostForces)
    panel.small(left + 14, row, style.text_dim, std::to_string(listed.size() - kMostForces) + " more");
  panel.text(left, y + kDiagramPx - kLinePx, style.text_dim, "sum");
  panel.text(right, y + kDiagramPx - kLinePx, style.text_dim,
             si(length(sum) > 1e-9 * largest ? length(sum) : 0, "N"), render::Face::Regular,
             render::Align::Right);
}

}  // namespace skerry::sandbox
