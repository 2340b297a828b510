// SPDX-License-Identifier: MIT
#include "physics/world_report.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "physics/joint_rows.h"
#include "physics/stepping/touching.h"

namespace skerry {
namespace {

bool touches_now(const WorldState& s, const Contact& contact) {
  if (contact.sensor) {
    const Manifold manifold =
        contact_manifold(contact, s.shapes[contact.shape_a].shape, s.bodies.pose(contact.body_a),
                         s.shapes[contact.shape_b].shape, s.bodies.pose(contact.body_b), 0, nullptr, nullptr);
    return manifold.count > 0;
  }
  if (!contact.linked) return false;
  for (int i = 0; i < contact.manifold.count; ++i) {
    if (is_touching(s, contact.manifold.points[i])) return true;
  }
  return false;
}

ContactEvent event_of(const WorldState& s, const Contact& contact, ContactEventKind kind) {
  ContactEvent event;
  event.kind = kind;
  event.shape_a = {contact.shape_a, s.shapes[contact.shape_a].generation};
  event.shape_b = {contact.shape_b, s.shapes[contact.shape_b].generation};
  event.body_a = s.shapes[contact.shape_a].body;
  event.body_b = s.shapes[contact.shape_b].body;
  event.point = contact.hit_point;
  event.normal = contact.hit_normal;
  if (kind != ContactEventKind::Hit) {
    event.point = {};
    event.normal = contact.manifold.normal;
    for (int i = 0; i < contact.manifold.count; ++i) {
      event.point += contact.manifold.points[i].position / contact.manifold.count;
    }
  }
  event.approach_speed = contact.hit_speed;
  for (const PointMemory& memory : contact.points) event.impulse += memory.total_impact;
  event.sensor = contact.sensor;
  return event;
}

void add_events(WorldState& s, const std::vector<Contact>& lost) {
  std::vector<ContactEvent>& events = s.report.events;
  for (Contact& contact : s.contacts) {
    const bool now = touches_now(s, contact);
    if (contact.hit) events.push_back(event_of(s, contact, ContactEventKind::Hit));
    if (now && !contact.touched) events.push_back(event_of(s, contact, ContactEventKind::Begin));
    if (!now && contact.touched) events.push_back(event_of(s, contact, ContactEventKind::End));
    if (now && contact.touched && s.observe.contacts) {
      events.push_back(event_of(s, contact, ContactEventKind::Persist));
    }
    contact.touched = now;
  }
  for (const Contact& contact : lost) {
    if (s.shapes[contact.shape_a].alive && s.shapes[contact.shape_b].alive) {
      events.push_back(event_of(s, contact, ContactEventKind::End));
    }
  }
}

ContactReport report_of(const WorldState& s, const Contact& contact) {
  ContactReport report;
  report.shape_a = {contact.shape_a, s.shapes[contact.shape_a].generation};
  report.shape_b = {contact.shape_b, s.shapes[contact.shape_b].generation};
  report.body_a = s.shapes[contact.shape_a].body;
  report.body_b = s.shapes[contact.shape_b].body;
  report.normal = contact.manifold.normal;
  report.count = contact.manifold.count;
  report.island = std::max(s.bodies.island[contact.body_a], s.bodies.island[contact.body_b]);
  for (int i = 0; i < contact.manifold.count; ++i) {
    const ManifoldPoint& point = contact.manifold.points[i];
    const PointMemory& memory = contact.points[i];
    report.points[i] = {point.position,
                        point.separation,
                        point.feature,
                        memory.total_normal,
                        memory.total_friction,
                        memory.total_impact,
                        memory.total_impact > 0 ? memory.impact_position : point.position};
  }
  return report;
}

void add_contacts(WorldState& s) {
  StepReport& r = s.report;
  for (const Contact& contact : s.contacts) {
    if (!contact.linked || contact.sensor) {
      r.pairs_out_of_reach += contact.sensor ? 0 : 1;
      continue;
    }
    for (const PointMemory& memory : contact.points) {
      r.total_normal_impulse += memory.total_normal + memory.total_impact;
      r.total_friction_impulse += std::abs(memory.total_friction);
    }
    if (contact.touched) {
      ++r.contacts;
      r.contact_points += contact.manifold.count;
    }
    for (int i = 0; i < contact.manifold.count; ++i) {
      r.worst_penetration = std::max(r.worst_penetration, -contact.manifold.points[i].separation);
    }
    if (s.observe.contacts && contact.manifold.count > 0) r.contacts_list.push_back(report_of(s, contact));
  }
}

void set_reactions(WorldState& s) {
  for (JointRecord& joint : s.joints) {
    joint.impulse = {};
    joint.angular_impulse = 0;
    if (!joint.alive) continue;
    const JointEnd b = joint_end(s, joint.def.b.index);
    JointRows rows;
    const int count = joint_rows(joint, joint_end(s, joint.def.a.index), b, rows);
    for (int k = 0; k < count; ++k) {
      const JointReaction reaction = row_reaction(joint, b, rows[k]);
      joint.impulse += joint.row_impulse[k] * reaction.force;
      joint.angular_impulse += joint.row_impulse[k] * reaction.torque;
    }
  }
}

/// Joints that carried too much; the world removes them after the report.
void note_broken_joints(WorldState& s, double h) {
  for (std::uint32_t i = 0; i < s.joints.size(); ++i) {
    const JointRecord& joint = s.joints[i];
    if (!joint.alive) continue;
    const double force = length(joint.impulse) / h, torque = std::abs(joint.angular_impulse) / h;
    if (!(force > joint.def.break_force) && !(torque > joint.def.break_torque)) continue;
    s.report.joint_events.push_back({{i, joint.generation}, joint.def.a, joint.def.b, force, torque});
  }
}

}  // namespace

void write_report(WorldState& s, double h, const std::vector<const Island*>& islands,
                  const std::vector<IslandResult*>& results, const std::vector<Contact>& lost) {
  StepReport& r = s.report;
  r.step = s.steps;
  r.time = s.time;
  r.h = h;
  const BodyArrays& b = s.bodies;
  for (std::size_t i = 0; i < b.size(); ++i) {
    r.bodies += b.alive[i];
    r.dynamic_bodies += b.alive[i] && b.type[i] == BodyType::Dynamic;
  }
  r.shapes = static_cast<int>(
      std::count_if(s.shapes.begin(), s.shapes.end(), [](const auto& x) { return x.alive; }));
  r.joints = static_cast<int>(
      std::count_if(s.joints.begin(), s.joints.end(), [](const auto& x) { return x.alive; }));
  r.pairs = static_cast<int>(s.contacts.size());
  r.islands = static_cast<int>(islands.size());

  for (std::size_t n = 0; n < results.size(); ++n) {
    IslandResult& result = *results[n];
    result.report.bodies = static_cast<int>(islands[n]->bodies.size());
    result.report.contacts = 0;
    for (const std::uint32_t index : islands[n]->contacts) {
      if (s.contacts[index].linked) result.report.contacts += s.contacts[index].manifold.count;
    }
    r.islands_in_flight += result.in_flight;
    r.islands_at_rest += result.at_rest;
    r.rows += result.report.rows;
    r.friction_rows += result.friction_rows;
    r.manifolds_reused += result.manifolds_reused;
    r.substeps = std::max(r.substeps, result.substeps);
    r.impacts += result.impacts;
    r.reflections += result.reflections;
    r.force_solves += result.force_solves;
    r.events_found += result.events_found;
    r.rejected_steps += result.rejected_steps;
    r.fallbacks += result.fallbacks;
    for (MotionEvent event : result.motion_events) {
      event.time += s.time - h;
      r.motion_events.push_back(event);
    }
    r.worst_residual = std::max(r.worst_residual, result.report.residual);
    r.inexact_islands += result.report.status != SolveStatus::Solved;
    r.narrow.pairs += result.narrow.pairs;
    r.narrow.axes_tested += result.narrow.axes_tested;
    r.narrow.axes_skipped += result.narrow.axes_skipped;
    r.narrow.manifolds += result.narrow.manifolds;
    r.work += result.work;
    for (int k = 0; k < kStageCount; ++k) r.stage_seconds[k] += result.stage_seconds[k];
    r.islands_list.push_back(result.report);
    for (IslandTrace& trace : result.traces) {
      trace.island = static_cast<int>(n);
      trace.time += s.time - h;
      r.traces.push_back(std::move(trace));
    }
  }
  add_events(s, lost);
  add_contacts(s);
  set_reactions(s);
  note_broken_joints(s, h);
}

std::string_view stage_name(Stage stage) {
  static constexpr std::array<std::string_view, kStageCount> kNames{
      "forces", "broad phase", "narrow phase", "islands", "assemble", "solve", "impact", "apply", "report"};
  return kNames[static_cast<int>(stage)];
}

}  // namespace skerry
