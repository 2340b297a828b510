// SPDX-License-Identifier: MIT
//
// The selected body: mass, state, why it is awake, and its free-body diagram: the body alone, with all forces
// on it. Forces are means over the last step; impacts in it are not among them.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

constexpr double kDiagramPx = 168;
constexpr std::size_t kMostForces = 7;
constexpr double kForceRowPx = 17;

/// A force on the body.
struct Force {
  std::string from;
  Vec2 point, force;  ///< world frame [m], [N]
  render::Color color;
};

// Contacts with one body are one entry of the list, but keep their arrows.
std::vector<Force> forces_on(const OverlayContext& context, BodyId body) {
  const World& world = context.world;
  const StepReport& report = world.report();
  const render::Style& style = context.style;
  std::vector<Force> forces;
  const std::size_t slot = body.index;
  const Vec2 weight = world.bodies().mass[slot] * world.bodies().gravity_scale[slot] * world.config().gravity;
  if (length(weight) > 0) forces.push_back({"weight", world.position(body), weight, style.velocity});
  if (report.h <= 0) return forces;
  for (const ContactReport& contact : report.contacts_list) {
    const bool second = contact.body_b == body;
    if (!second && contact.body_a != body) continue;
    const BodyId other = second ? contact.body_a : contact.body_b;
    for (int i = 0; i < contact.count; ++i) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(i)];
      const Vec2 impulse =
          point.normal_impulse * contact.normal + point.friction_impulse * perp(contact.normal);
      const Vec2 force = (second ? 1.0 : -1.0) / report.h * impulse;
      if (length(force) <= context.history.force_floor(world)) continue;
      forces.push_back(
          {body_label(world, other), shown_point(context, contact, point.position), force, style.force});
    }
  }
  for (const JointRecord& joint : world.joints()) {
    if (!joint.alive || (joint.def.a != body && joint.def.b != body)) continue;
    const bool second = joint.def.b == body;
    const Vec2 force = (second ? 1.0 : -1.0) / report.h * joint.impulse;
    if (length(force) <= context.history.force_floor(world)) continue;
    const BodyId other = second ? joint.def.a : joint.def.b;
    forces.push_back({body_label(world, other) + " (joint)",
                      to_world(context.demo.shown(slot).pose(), second ? joint.local_b : joint.local_a),
                      force, style.joint});
  }
  return forces;
}

std::string why_awake(const OverlayContext& context, BodyId body) {
  const World& world = context.world;
  const BodyArrays& bodies = world.bodies();
  if (bodies.type[body.index] == BodyType::Static) return "fixed: never steps";
  if (bodies.type[body.index] == BodyType::Kinematic) return "kinematic: moves as told";
  if (bodies.asleep[body.index]) return "asleep: its island is at rest to the bit and left out of the steps";
  const int island = bodies.island[body.index];
  const auto& islands = world.report().islands_list;
  if (island < 0 || static_cast<std::size_t>(island) >= islands.size()) return "not stepped yet";
  const IslandReport& report = islands[static_cast<std::size_t>(island)];
  if (report.rows == 0 && report.contacts == 0) return "in flight: nothing within reach";
  const double floor = world.config().rest_speed;
  char text[120];
  std::snprintf(text, sizeof text, "awake: moves at %s", si(length(world.velocity(body)), "m/s").c_str());
  if (length(world.velocity(body)) > floor || std::abs(world.omega(body)) > floor) return text;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies.alive[i] || bodies.island[i] != island) continue;
    if (length(bodies.velocity[i]) <= floor && std::abs(bodies.omega[i]) <= floor) continue;
    return "awake: " + body_label(world, world.body_id(i)) + " of its island moves";
  }
  if (world.report().islands_at_rest == world.report().islands)
    return "at rest: nothing changed, last step's forces serve";
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

double reach_of(const World& world, BodyId body) {
  double reach = 0;
  for (const ShapeRecord& shape : world.shapes())
    if (shape.alive && shape.body == body && shape.shape->kind != ShapeKind::HalfPlane)
      reach = std::max(reach, bounding_radius(shape.shape));
  return reach > 0 ? reach : 1;
}

std::string force_text(const Force& force) {
  return si(length(force.force), "N");
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
  std::snprintf(text, sizeof text, "at (%.4g, %.4g) m, angle %.4g rad", p.x, p.y, state.angle);
  line(style.text);
  std::snprintf(text, sizeof text, "velocity (%.3g, %.3g) m/s, %.3g rad/s", v.x, v.y, state.omega);
  line(style.text);
  const int island = world.bodies().island[body.index];
  const std::string where = island >= 0 ? "island " + std::to_string(island + 1) + ", " : "";
  std::snprintf(text, sizeof text, "%s%s", where.c_str(), why_awake(scene, body).c_str());
  line(style.text_dim);

  // The diagram on the left, the forces by origin on the right.
  y += 4;
  const std::vector<Force> forces = forces_on(scene, body);
  double largest = 0;
  Vec2 sum{};
  for (const Force& force : forces) {
    largest = std::max(largest, length(force.force));
    sum += force.force;
  }
  const Diagram diagram{panel, p, 0.24 * kDiagramPx / reach_of(world, body),
                        largest > 0 ? 0.24 * kDiagramPx / largest : 0};
  panel.frame(0, y, kDiagramPx, kDiagramPx, style.panel_border);
  draw_body(scene, diagram, body, y);
  for (const Force& force : forces) draw_force(diagram, force, y);

  const double left = kDiagramPx + 14, right = panel.width();
  panel.text(left, y, style.text_dim, "force on " + name + " from");
  double row = y + kForceRowPx + 2;
  std::vector<Force> listed;
  for (const Force& force : forces) {
    const auto same = std::find_if(listed.begin(), listed.end(),
                                   [&](const Force& other) { return other.from == force.from; });
    if (same == listed.end())
      listed.push_back(force);
    else
      same->force += force.force;
  }
  for (std::size_t i = 0; i < std::min(listed.size(), kMostForces); ++i, row += kForceRowPx) {
    panel.rect(left, row + 4, 9, 9, listed[i].color);
    panel.fitted(left + 14, row, right - left - 90, style.text, listed[i].from);
    panel.text(right, row, style.text, force_text(listed[i]), render::Face::Regular, render::Align::Right);
  }
  if (listed.size() > kMostForces)
    panel.small(left + 14, row, style.text_dim, std::to_string(listed.size() - kMostForces) + " more");
  panel.text(left, y + kDiagramPx - kLinePx, style.text_dim, "sum");
  panel.text(right, y + kDiagramPx - kLinePx, style.text_dim,
             si(length(sum) > 1e-9 * largest ? length(sum) : 0, "N"), render::Face::Regular,
             render::Align::Right);
}

}  // namespace skerry::sandbox
