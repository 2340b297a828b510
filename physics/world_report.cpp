// SPDX-License-Identifier: MIT
#include "physics/world_report.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>

#include "physics/share_islands.h"
#include "physics/spare.h"
#include "physics/stepping/touching.h"

namespace skerry {

JointEnd halfway(const WorldState& s, std::uint32_t body) {
  JointEnd end = joint_end(s, body);
  if (body == BodyId::kNone || s.bodies.type[body] == BodyType::Static) return end;
  const BodyBackup& start = s.backup[body];
  end.p = 0.5 * (start.position + end.p);
  if (start.angle == end.angle) return end;
  end.angle = 0.5 * (start.angle + end.angle);
  end.q = Rot::from_angle(end.angle);
  return end;
}

namespace {

// Contacts, pairs and joints that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 1024, kPairsAPiece = 4096, kJointsAPiece = 256;

// At any distance two shapes have points that are nearest to each other [m].
constexpr double kAnyDistance = 1e100;

/// Where the shapes are now, through chains from either side. @param margin  as far apart as that [m]
Manifold manifold_now(const WorldState& s, const Contact& contact, double margin) {
  return crossing_manifold(contact, s.shapes[contact.shape_a].shape, s.bodies.pose(contact.body_a),
                           s.shapes[contact.shape_b].shape, s.bodies.pose(contact.body_b), margin);
}

/// Sensors keep none.
Manifold manifold_of_sensor(const WorldState& s, const Contact& contact) {
  return manifold_now(s, contact, 0);
}

bool touches_now(const WorldState& s, const Contact& contact) {
  if (contact.sensor) return manifold_of_sensor(s, contact).count > 0;
  if (!contact.linked) return false;
  for (int i = 0; i < contact.manifold.count; ++i) {
    if (is_touching(s, contact.manifold.points[i])) return true;
  }
  return false;
}

}  // namespace

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
    const Manifold manifold = contact.sensor ? manifold_of_sensor(s, contact) : contact.manifold;
    event.point = {};
    event.normal = manifold.normal;
    for (int i = 0; i < manifold.count; ++i) event.point += manifold.points[i].position / manifold.count;
  }
  event.approach_speed = contact.hit_speed;
  event.time = kind == ContactEventKind::Hit ? s.time - s.report.h + contact.hit_time : s.time;
  for (const PointMemory& memory : contact.points) event.impulse += memory.total_impact;
  const auto is_chain = [&s](std::uint32_t shape) { return s.shapes[shape].shape->kind == ShapeKind::Chain; };
  if (is_chain(contact.shape_a) || is_chain(contact.shape_b)) event.segment = contact.child;
  event.sensor = contact.sensor;
  return event;
}

namespace {

/// Both bodies are where they were, and so is everything else of the contact.
bool is_kept(const WorldState& s, const ContactLink& link) {
  return s.kept[link.body_a] && s.kept[link.body_b];
}

std::uint8_t bit_of(ContactEventKind kind) {
  return static_cast<std::uint8_t>(1u << static_cast<unsigned>(kind));
}

/// What happened at a contact, a bit for each kind of event.
std::uint8_t events_of(const WorldState& s, Contact& contact) {
  const bool now = touches_now(s, contact), before = contact.touched;
  contact.touched = now;
  // What others have turned away before it took anything was not struck.
  const bool struck = contact.hit && contact.impact != Vec2{};
  std::uint8_t events = struck ? bit_of(ContactEventKind::Hit) : std::uint8_t{0};
  if (now && !before) events |= bit_of(ContactEventKind::Begin);
  if (!now && before) events |= bit_of(ContactEventKind::End);
  if (now && before && s.observe.contacts) events |= bit_of(ContactEventKind::Persist);
  return events;
}

struct EventPlace {
  std::uint32_t contact, place;
};

void add_events(WorldState& s) {
  std::vector<ContactEvent>& events = s.report.events;
  events.insert(events.end(), s.parted.begin(), s.parted.end());
  s.parted.clear();
  Spare<std::vector<std::uint8_t>> kinds;
  kinds->assign(s.links.size(), 0);
  share(s.pool.get(), s.links.size(), kContactsAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      if (is_kept(s, s.links[i]) && !s.observe.contacts) continue;
      (*kinds)[i] = events_of(s, s.contacts[i]);
      s.links[i].touched = s.contacts[i].touched;
    }
  });
  // Contacts with events, and where those stand in the list.
  Spare<std::vector<EventPlace>> places;
  std::size_t count = events.size();
  for (std::size_t i = 0; i < s.links.size(); ++i) {
    if ((*kinds)[i] == 0) continue;
    places->push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(count)});
    count += static_cast<std::size_t>(std::popcount((*kinds)[i]));
  }
  resize_with_room(events, count);
  share(s.pool.get(), places->size(), kContactsAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      auto [contact, place] = (*places)[k];
      using enum ContactEventKind;
      for (const ContactEventKind kind : {Hit, Begin, End, Persist})
        if (((*kinds)[contact] & bit_of(kind)) != 0) events[place++] = event_of(s, s.contacts[contact], kind);
    }
  });
  for (const Contact& contact : s.scratch.lost) events.push_back(event_of(s, contact, ContactEventKind::End));
}

ContactReport report_of(const WorldState& s, const Contact& contact) {
  ContactReport report;
  report.shape_a = {contact.shape_a, s.shapes[contact.shape_a].generation};
  report.shape_b = {contact.shape_b, s.shapes[contact.shape_b].generation};
  report.body_a = s.shapes[contact.shape_a].body;
  report.body_b = s.shapes[contact.shape_b].body;
  Manifold manifold = contact.manifold;
  if (manifold.count == 0) {
    // What it gave is all with its first point.
    manifold = manifold_now(s, contact, kAnyDistance);
    manifold.count = 1;
    const PointMemory& memory = contact.points[0];
    if (memory.total_impact > 0) manifold.points[0].position = memory.impact_position;
  }
  report.normal = manifold.normal;
  report.impulse = contact.impulse;
  const double impact = length(contact.impact);
  report.impact_normal = impact > 0 ? contact.impact / impact : manifold.normal;
  report.count = manifold.count;
  report.island = std::max(s.bodies.island[contact.body_a], s.bodies.island[contact.body_b]);
  for (int i = 0; i < manifold.count; ++i) {
    const ManifoldPoint& point = manifold.points[i];
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

/// Of some of the island's contacts.
IslandTotals totals_of(const WorldState& s, const Island& island, std::size_t from, std::size_t to) {
  IslandTotals t;
  for (std::size_t k = from; k < to; ++k) {
    const Contact& contact = s.contacts[island.contacts[k]];
    for (const PointMemory& memory : contact.points) {
      t.normal_impulse += memory.total_normal + memory.total_impact;
      t.friction_impulse += std::abs(memory.total_friction);
    }
    t.points += contact.manifold.count;
    if (contact.touched) {
      ++t.touching;
      t.touching_points += contact.manifold.count;
    }
    for (int i = 0; i < contact.manifold.count; ++i)
      t.worst_penetration = std::max(t.worst_penetration, -contact.manifold.points[i].separation);
  }
  return t;
}

/// Sums of pieces, whatever the number of threads: the same bits for any.
IslandTotals totals_of(const WorldState& s, const Island& island, ThreadPool* threads) {
  const std::size_t count = island.contacts.size();
  if (count <= kContactsAPiece) return totals_of(s, island, 0, count);
  Spare<std::vector<IslandTotals>> pieces;
  pieces->resize((count + kContactsAPiece - 1) / kContactsAPiece);
  share(threads, pieces->size(), 1, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      const std::size_t first = k * kContactsAPiece;
      (*pieces)[k] = totals_of(s, island, first, std::min(first + kContactsAPiece, count));
    }
  });
  IslandTotals t;
  for (const IslandTotals& piece : *pieces) {
    t.normal_impulse += piece.normal_impulse;
    t.friction_impulse += piece.friction_impulse;
    t.points += piece.points;
    t.touching += piece.touching;
    t.touching_points += piece.touching_points;
    t.worst_penetration = std::max(t.worst_penetration, piece.worst_penetration);
  }
  return t;
}

/// After the events, which say what touches.
void add_contacts(WorldState& s) {
  StepReport& r = s.report;
  std::size_t linked = 0;
  share_islands(s, [&](SteppedIsland& island, ThreadPool* threads) {
    if (!island.kept && !island.flew_alone) island.outcome->totals = totals_of(s, island.island, threads);
  });
  for (const SteppedIsland& island : s.islands) {
    if (island.flew_alone) continue;
    const IslandTotals& t = island.outcome->totals;
    linked += island.island.contacts.size();
    r.total_normal_impulse += t.normal_impulse;
    r.total_friction_impulse += t.friction_impulse;
    r.contacts += t.touching;
    r.contact_points += t.touching_points;
    r.worst_penetration = std::max(r.worst_penetration, t.worst_penetration);
  }
  const auto solid =
      std::count_if(s.links.begin(), s.links.end(), [](const ContactLink& l) { return !l.sensor; });
  const std::vector<Pair>& distant = s.scratch.distant;
  std::atomic<std::size_t> solid_distant = 0;
  share(s.pool.get(), distant.size(), kPairsAPiece, [&](std::size_t from, std::size_t to) {
    std::size_t count = 0;
    for (std::size_t k = from; k < to; ++k)
      count += !s.shapes[distant[k].low].sensor && !s.shapes[distant[k].high].sensor;
    solid_distant += count;
  });
  r.pairs_out_of_reach +=
      static_cast<int>(solid) + static_cast<int>(solid_distant) - static_cast<int>(linked);
}

/// It touches, nearly, or has pushed in this step.
bool is_listed(const Contact& contact) {
  if (!contact.linked || contact.sensor) return false;
  return contact.manifold.count > 0 || contact.impulse != Vec2{} || contact.points[0].total_impact != 0;
}

void list_contacts(WorldState& s) {
  for (const Contact& contact : s.contacts) {
    if (is_listed(contact)) s.report.contacts_list.push_back(report_of(s, contact));
  }
}

/// Sleeping islands count as they did when they fell asleep.
void add_sleepers(const SleepTotals& asleep, StepReport& r) {
  r.islands_asleep = r.islands_at_rest = asleep.islands;
  r.bodies_asleep = asleep.bodies;
  r.contacts = asleep.contacts;
  r.contact_points = asleep.contact_points;
  r.pairs_out_of_reach = asleep.pairs_out_of_reach;
  r.rows = asleep.rows;
  r.friction_rows = asleep.friction_rows;
  r.inexact_islands = asleep.inexact;
  r.worst_residual = asleep.worst_residual;
  r.worst_penetration = asleep.worst_penetration;
  r.total_normal_impulse = asleep.normal_impulse;
  r.total_friction_impulse = asleep.friction_impulse;
}

/// For an observer, islands and contacts of sleepers follow those of the awake.
void list_sleepers(WorldState& s) {
  StepReport& r = s.report;
  for (const SleepingIsland& island : s.sleepers.islands()) {
    if (island.bodies.empty()) continue;
    for (const std::uint32_t body : island.bodies) {
      s.bodies.island[body] = static_cast<std::int32_t>(r.islands_list.size());
    }
    r.islands_list.push_back(island.rest.report);
    for (const Contact& contact : island.contacts) {
      if (contact.touched) r.events.push_back(event_of(s, contact, ContactEventKind::Persist));
      if (is_listed(contact)) r.contacts_list.push_back(report_of(s, contact));
    }
  }
}

/// The joint's island is kept, and so is its reaction.
bool is_kept(const WorldState& s, const JointRecord& joint) {
  const std::uint32_t b = joint.def.b.index;
  return s.kept[s.bodies.type[b] == BodyType::Dynamic ? b : joint.def.a.index] != 0;
}

void set_reaction(const WorldState& s, JointRecord& joint) {
  joint.angular_impulse = 0;
  if (joint.def.kind == JointKind::Revolute && held_rows(joint.def) == 2) {
    // Its rows are the axes of the world through the anchor.
    joint.impulse = {joint.row_impulse[0], joint.row_impulse[1]};
    return;
  }
  joint.impulse = {};
  const JointEnd b = halfway(s, joint.def.b.index);
  JointRows rows;
  const int count = joint_geometry(joint, halfway(s, joint.def.a.index), b, rows);
  for (int k = 0; k < count; ++k) {
    const JointReaction reaction = row_reaction(joint, b, rows[k]);
    joint.impulse += joint.row_impulse[k] * reaction.force;
    joint.angular_impulse += joint.row_impulse[k] * reaction.torque;
  }
}

/// Mean force and torque over a step, in magnitude [N, N m].
std::array<double, 2> load_of(const JointRecord& joint, double h) {
  return {length(joint.impulse) / h, std::abs(joint.angular_impulse) / h};
}

bool breaks(const JointRecord& joint, double h) {
  const auto [force, torque] = load_of(joint, h);
  return force > joint.def.break_force || torque > joint.def.break_torque;
}

/// Joints that carried too much are noted; the world removes them after the report.
void set_reactions(WorldState& s, double h) {
  std::atomic<bool> any = false;
  share(s.pool.get(), s.active_joints.size(), kJointsAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      JointRecord& joint = s.joints[s.active_joints[k]];
      if (is_kept(s, joint)) continue;
      set_reaction(s, joint);
      if (breaks(joint, h)) any.store(true, std::memory_order_relaxed);
    }
  });
  if (!any) return;
  for (const std::uint32_t i : s.active_joints) {
    const JointRecord& joint = s.joints[i];
    if (is_kept(s, joint) || !breaks(joint, h)) continue;
    const auto [force, torque] = load_of(joint, h);
    s.report.joint_events.push_back({{i, joint.generation}, joint.def.a, joint.def.b, force, torque});
  }
}

/// What there is, and how far it came.
void count_everything(WorldState& s) {
  StepReport& r = s.report;
  r.step = s.steps;
  r.time = s.time;
  r.bodies = static_cast<int>(s.bodies.size() - s.free_bodies.size());
  r.dynamic_bodies = static_cast<int>(s.awake.size()) + s.sleepers.totals().bodies;
  r.shapes = static_cast<int>(s.shapes.size() - s.free_shapes.size());
  r.joints = static_cast<int>(s.joints.size() - s.free_joints.size());
}

}  // namespace

void write_report_of_nothing(WorldState& s, const char* cause) {
  s.report = {};
  s.report.interrupted = cause;
  count_everything(s);
}

void write_report(WorldState& s, double h) {
  StepReport& r = s.report;
  count_everything(s);
  r.h = h;
  const SleepTotals& asleep = s.sleepers.totals();
  r.pairs = static_cast<int>(s.contacts.size() + s.scratch.distant.size()) + asleep.pairs;
  r.islands = static_cast<int>(s.islands.size()) + asleep.islands;
  r.broad_phase = s.broad_phase->choice();
  r.field_keeps_awake = static_cast<bool>(s.field);
  r.field_wants_one_thread = s.field && s.field_threads == FieldThreads::One;
  add_sleepers(asleep, r);

  add_events(s);
  add_contacts(s);
  IslandReport alone;
  alone.bodies = 1;
  for (std::size_t n = 0; n < s.islands.size(); ++n) {
    SteppedIsland& island = s.islands[n];
    if (island.flew_alone) {
      ++r.islands_in_flight;
      r.substeps = std::max(r.substeps, 1);
      r.islands_list.push_back(alone);
      continue;
    }
    IslandResult& result = island.result();
    result.report.bodies = static_cast<int>(island.island.bodies.size());
    result.report.contacts = island.outcome->totals.points;
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
    r.inner_steps += result.inner_steps;
    r.rejected_steps += result.rejected_steps;
    r.islands_by_events += !result.at_rest && result.report.stepper == "event_driven";
    r.islands_by_time_stepping += !result.at_rest && result.report.stepper == "time_stepping";
    r.islands_in_flow += result.report.flowing;
    r.islands_in_one_piece += result.one_piece;
    r.worst_penetration = std::max(r.worst_penetration, result.overlap);
    r.error_estimate = std::max(r.error_estimate, result.report.error_estimate);
    r.fallbacks += result.fallbacks;
    for (MotionEvent event : result.motion_events) {
      event.time += s.time - h;
      r.motion_events.push_back(event);
      r.paradoxes += event.kind == MotionEventKind::Paradox;
    }
    r.worst_residual = std::max(r.worst_residual, result.report.residual);
    r.inexact_islands += result.report.status != SolveStatus::Solved;
    r.narrow += result.narrow;
    r.work += result.work;
    r.work += result.thrown_away;
    if (s.observe.stage_times) {
      for (int k = 0; k < kStageCount; ++k) r.stage_seconds[k] += result.stage_seconds[k];
    }
    r.islands_list.push_back(result.report);
    for (IslandTrace& trace : result.traces) {
      trace.island = static_cast<int>(n);
      trace.time += s.time - h;
      r.traces.push_back(std::move(trace));
    }
    result.traces.clear();
  }
  if (s.observe.contacts) {
    list_contacts(s);
    list_sleepers(s);
  }
  set_reactions(s, h);
}

std::string_view to_string(ContainmentCause cause) {
  return cause == ContainmentCause::TooFar ? "too far in one step" : "state not finite";
}

std::string_view stage_name(Stage stage) {
  static constexpr std::array<std::string_view, kStageCount> kNames{
      "forces", "broad phase", "narrow phase", "islands", "assemble", "solve", "impact", "apply", "report"};
  return kNames[static_cast<int>(stage)];
}

}  // namespace skerry
