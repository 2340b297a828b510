// SPDX-License-Identifier: MIT
//
// What a snapshot holds of each structure. Every list binds all members: a member that is added elsewhere
// stops the compiler here. Then either archive it, or leave it out of the call with a word why; and raise
// kSnapshotVersion in snapshot.cpp.
#pragma once

#include "physics/archive.h"
#include "physics/world_state.h"

namespace skerry {

inline void fields(Archive& a, Vec2& v) {
  auto& [x, y] = v;
  a(x, y);
}
inline void fields(Archive& a, Rot& v) {
  auto& [c, s] = v;
  a(c, s);
}
inline void fields(Archive& a, Transform& v) {
  auto& [p, q] = v;
  a(p, q);
}
inline void fields(Archive& a, Aabb& v) {
  auto& [lower, upper] = v;
  a(lower, upper);
}
template <class Tag>
void fields(Archive& a, Handle<Tag>& v) {
  auto& [index, generation] = v;
  a(index, generation);
}
inline void fields(Archive& a, Material& v) {
  auto& [friction, restitution, rolling_resistance, surface_velocity, static_friction] = v;
  a(friction, restitution, rolling_resistance, surface_velocity, static_friction);
}
inline void fields(Archive& a, Drag& v) {
  auto& [linear, quadratic, angular, angular_quadratic] = v;
  a(linear, quadratic, angular, angular_quadratic);
}
inline void fields(Archive& a, Wrench& v) {
  auto& [force, torque] = v;
  a(force, torque);
}
inline void fields(Archive& a, Filter& v) {
  auto& [category, mask, group] = v;
  a(category, mask, group);
}
inline void fields(Archive& a, Shape::Rectangle& v) {
  auto& [middle, half] = v;
  a(middle, half);
}
inline void fields(Archive& a, Shape& v) {
  auto& [kind, radius, vertices, normals, closed, tree, rectangle] = v;
  a(kind, radius, vertices, normals, closed, tree, rectangle);
}
inline void fields(Archive& a, SharedShape& v) {
  Shape shape = *v;
  fields(a, shape);
  if (a.reading()) v = SharedShape(std::move(shape));
}

// --- World
// ----------------------------------------------------------------------------------------------------------
inline void fields(Archive& a, BroadPhaseOptions& v) {
  [[maybe_unused]] auto& [cell_size, axes, threads, pool] = v;
  a(cell_size, axes, threads);
}
inline void fields(Archive& a, SolveOptions& v) {
  [[maybe_unused]] auto& [tolerance, max_iterations, work_limit, time_budget, trace, welds_as_one, threads] =
      v;
  a(tolerance, max_iterations, work_limit, time_budget, trace, welds_as_one);
}
inline void fields(Archive& a, Skips& v) {
  auto& [manifolds, axes, factors, smooth_rows, alike, flight] = v;
  a(manifolds, axes, factors, smooth_rows, alike, flight);
}
inline void fields(Archive& a, WorldConfig& v) {
  auto& [gravity, broad_phase, broad_phase_options, solver, impact_law, stepper, solve, flow_work,
         contact_margin, touch_tolerance, rest_speed, accuracy, max_impacts_per_step, reuse_resting, sleep,
         sleep_speed, skips, threads] = v;
  a(gravity, broad_phase, broad_phase_options, solver, impact_law, stepper, solve, flow_work, contact_margin,
    touch_tolerance, rest_speed, accuracy, max_impacts_per_step, reuse_resting, sleep, sleep_speed, skips,
    threads);
}
inline void fields(Archive& a, Observe& v) {
  auto& [contacts, systems, solve_traces, stage_times, paths] = v;
  a(contacts, systems, solve_traces, stage_times, paths);
}
inline void fields(Archive& a, BodyArrays& v) {
  auto& [position, angle, rotation, velocity, omega, force, torque, mass, inertia, inverse_mass,
         inverse_inertia, gravity_scale, type, alive, asleep, island, generation, number, numbered] = v;
  a(position, angle, rotation, velocity, omega, force, torque, mass, inertia, inverse_mass, inverse_inertia,
    gravity_scale, type, alive, asleep, island, generation, number, numbered);
}
inline void fields(Archive& a, ShapeRecord& v) {
  auto& [shape, body, filter, generation, sensor, alive, in_broad_phase, pairs_changed, friction_rule,
         restitution_rule, box, density, material] = v;
  a(shape, density, material, friction_rule, restitution_rule, filter, sensor, alive, in_broad_phase,
    pairs_changed, body, generation, box);
}
inline void fields(Archive& a, JointDef& v) {
  auto& [kind, body_a, body_b, anchor_a, anchor_b, length, collide, axis, ratio, pulley_a, pulley_b, lower,
         upper, motor_speed, motor_limit, stiffness, damping, break_force, break_torque] = v;
  a(kind, body_a, body_b, anchor_a, anchor_b, length, collide, axis, ratio, pulley_a, pulley_b, lower, upper,
    motor_speed, motor_limit, stiffness, damping, break_force, break_torque);
}
inline void fields(Archive& a, JointRecord& v) {
  // Not archived: whether it is stalled, which follows from where the bodies are.
  auto& [def, local_a, local_b, local_axis, length, reference_angle, alive, stalled, generation, impulse,
         angular_impulse, row_force, row_impulse] = v;
  a(def, local_a, local_b, local_axis, length, reference_angle, alive, generation, impulse, angular_impulse,
    row_force, row_impulse);
}

// --- Contacts
// ---------------------------------------------------------------------------------------------------------
inline void fields(Archive& a, PointForces& v) {
  auto& [feature, sticking, normal_impulse, friction_impulse, rolling_impulse, h] = v;
  a(feature, sticking, normal_impulse, friction_impulse, rolling_impulse, h);
}
inline void fields(Archive& a, PointMemory& v) {
  static_assert(sizeof(PointMemory) == sizeof(PointForces) + 3 * sizeof(double) + 2 * sizeof(Vec2));
  fields(a, static_cast<PointForces&>(v));
  // Not archived: its normal, which lives as long as a piece of a step.
  a(v.total_normal, v.total_friction, v.total_impact, v.impact_position);
}
inline void fields(Archive& a, SatCache& v) {
  auto& [axis, partner, state, exchanged, slack, reach, reach_b, offset, turn, turn_b] = v;
  a(axis, partner, state, exchanged, slack, reach, reach_b, offset, turn, turn_b);
}
inline void fields(Archive& a, ManifoldPoint& v) {
  auto& [position, separation, feature] = v;
  a(position, separation, feature);
}
inline void fields(Archive& a, Manifold& v) {
  auto& [normal, points, count] = v;
  a(normal, points, count);
}
inline void fields(Archive& a, Contact& v) {
  auto& [shape_a, shape_b, child, body_a, body_b, friction, restitution, rolling_resistance, surface_velocity,
         static_friction, sensor, linked, touched, woken, hit, manifold_reused, hit_speed, hit_point,
         hit_normal, hit_time, margin, pose_a, pose_b, begun, cache, manifold, points, points_at_start,
         impulse, impact] = v;
  a(shape_a, shape_b, child, body_a, body_b, friction, restitution, rolling_resistance, surface_velocity,
    static_friction, sensor, linked, touched, woken, hit, manifold_reused, hit_speed, hit_point, hit_normal,
    hit_time, margin, pose_a, pose_b, begun, cache, manifold, points, points_at_start, impulse, impact);
}

// --- What is kept of islands
// ------------------------------------------------------------------------------------------
inline void fields(Archive& a, IslandReport& v) {
  auto& [bodies, contacts, rows, stepper, status, method, residual, iterations, flowing, error_estimate] = v;
  a(bodies, contacts, rows, stepper, status, method, residual, iterations, flowing, error_estimate);
}
inline void fields(Archive& a, RestingIsland& v) {
  auto& [key, report, friction_rows, memory_keys, strayed] = v;
  a(key, report, friction_rows, memory_keys, strayed);
}
inline void fields(Archive& a, StepMemory& v) {
  auto& [busy, flow, light_failures, light_wait, near_rest, held, stopped, slow, inner_step] = v;
  a(busy, flow, light_failures, light_wait, near_rest, held, stopped, slow, inner_step);
}
inline void fields(Archive& a, PathPiece& v) {
  auto& [body, generation, begin, length, c] = v;
  a(body, generation, begin, length, c);
}
inline void fields(Archive& a, IslandMemory& v) {
  auto& [key, memory] = v;
  a(key, memory);
}

inline void fields(Archive& a, SleepTotals& v) {
  auto& [islands, bodies, pairs, contacts, contact_points, pairs_out_of_reach, rows, friction_rows, inexact,
         worst_residual, worst_penetration, normal_impulse, friction_impulse] = v;
  a(islands, bodies, pairs, contacts, contact_points, pairs_out_of_reach, rows, friction_rows, inexact,
    worst_residual, worst_penetration, normal_impulse, friction_impulse);
}
inline void fields(Archive& a, SleepingIsland& v) {
  auto& [bodies, joints, contacts, memories, rest, keepers, totals] = v;
  a(bodies, joints, contacts, memories, rest, keepers, totals);
}
inline void fields(Archive& a, Sleepers& v) {
  a(v.islands_, v.free_places_, v.place_of_, v.held_, v.totals_, v.stale_totals_, v.h_);
}

// --- The last report: scripts and pictures look at it before the next step
// -------------------------------------------------------------
inline void fields(Archive& a, BroadPhaseChoice& v) {
  auto& [name, reason, switches, boxes, moved, smallest, largest, extent] = v;
  a(name, reason, switches, boxes, moved, smallest, largest, extent);
}
inline void fields(Archive& a, NarrowPhaseStats& v) {
  auto& [pairs, axes_tested, axes_skipped, manifolds] = v;
  a(pairs, axes_tested, axes_skipped, manifolds);
}
inline void fields(Archive& a, SolveWork& v) {
  auto& [factorisations, partial_factorisations, resolves, pivots, symbolic_analyses, symbolic_skipped,
         rows_left_out, visits] = v;
  a(factorisations, partial_factorisations, resolves, pivots, symbolic_analyses, symbolic_skipped,
    rows_left_out, visits);
}
inline void fields(Archive& a, ContactEvent& v) {
  auto& [kind, shape_a, shape_b, body_a, body_b, point, normal, approach_speed, impulse, time, segment,
         sensor] = v;
  a(kind, shape_a, shape_b, body_a, body_b, point, normal, approach_speed, impulse, time, segment, sensor);
}
inline void fields(Archive& a, MotionEvent& v) {
  auto& [kind, time, body_a, body_b] = v;
  a(kind, time, body_a, body_b);
}
inline void fields(Archive& a, JointEvent& v) {
  auto& [joint, body_a, body_b, force, torque] = v;
  a(joint, body_a, body_b, force, torque);
}
inline void fields(Archive& a, Containment& v) {
  auto& [body, cause] = v;
  a(body, cause);
}
inline void fields(Archive& a, ContactPointReport& v) {
  auto& [position, separation, feature, normal_impulse, friction_impulse, impact_impulse, impact_position] =
      v;
  a(position, separation, feature, normal_impulse, friction_impulse, impact_impulse, impact_position);
}
inline void fields(Archive& a, ContactReport& v) {
  auto& [shape_a, shape_b, body_a, body_b, normal, impulse, impact_normal, points, count, island] = v;
  a(shape_a, shape_b, body_a, body_b, normal, impulse, impact_normal, points, count, island);
}
inline void fields(Archive& a, StepReport& v) {
  [[maybe_unused]] auto& [step, time, h, interrupted,
                          stage_seconds,  // measured, of that run
                          bodies, dynamic_bodies, shapes, joints, pairs, contacts, contact_points, islands,
                          rows, substeps, impacts, reflections, friction_rows, broad_phase, narrow, work,
                          force_solves, events_found, inner_steps, rejected_steps, paradoxes, fallbacks,
                          islands_by_events, islands_by_time_stepping, islands_in_flow, islands_in_one_piece,
                          island_retries, islands_asleep, bodies_asleep, islands_in_flight, islands_at_rest,
                          manifolds_reused, pairs_out_of_reach, field_keeps_awake, field_wants_one_thread,
                          worst_residual, error_estimate, inexact_islands, worst_penetration, contained,
                          kinetic_energy, potential_energy, momentum, angular_momentum, total_normal_impulse,
                          total_friction_impulse, state_hash, contacts_list, islands_list, events,
                          motion_events, joint_events, containments,
                          traces  // large, and for an observer only
  ] = v;
  a(step, time, h, interrupted, bodies, dynamic_bodies, shapes, joints, pairs, contacts, contact_points,
    islands, rows, substeps, impacts, reflections, friction_rows, broad_phase, narrow, work, force_solves,
    events_found, inner_steps, rejected_steps, paradoxes, fallbacks, islands_by_events,
    islands_by_time_stepping, islands_in_flow, islands_in_one_piece, island_retries, islands_asleep,
    bodies_asleep, islands_in_flight, islands_at_rest, manifolds_reused, pairs_out_of_reach,
    field_keeps_awake, field_wants_one_thread, worst_residual, error_estimate, inexact_islands,
    worst_penetration, contained, kinetic_energy, potential_energy, momentum, angular_momentum,
    total_normal_impulse, total_friction_impulse, state_hash, contacts_list, islands_list, events,
    motion_events, joint_events, containments);
}

/// The parts of a world, one archive each: settings, bodies, shapes, joints, contacts, islands, report.
struct WorldArchives {
  Archive &config, &bodies, &shapes, &joints, &contacts, &islands, &report;
};

inline void fields(WorldArchives a, WorldState& v) {
  // Not archived: the broad phase and the threads, made again from the configuration and the shapes' boxes;
  // which shapes are equal, looked for again; sums, which the next step takes anew; the working set, which
  // follows from the bodies; what every step fills before it looks; islands and flags that a step looks for
  // anew where it does not find them; the methods, looked up by name; the callbacks (prescribed, field with
  // its threads), which only the caller has (`World::adopt`).
  auto& [config, observe, bodies, names, given_mass, given_inertia, shapes_of, joints_of, centre, radius,
         thickness, stray_guess, free_bodies, drag, applied, prescribed, field, shapes, shape_pool,
         free_shapes, joints, free_joints, broad_phase, pool, island_threads, island_builder, islands,
         graph_bodies, graph_joints, links, contacts, parted, memories, resting, step_memory, support,
         step_paths, sleepers, ledger, field_threads, graph_known, table_changed, joints_changed, paths_known,
         springs, awake, kinematic, touched, displaced, last_h, rests, kept, dynamic_bodies, active,
         active_joints, acceleration, angular_acceleration, paths, reach, travelled, way, allowance, strayed,
         flight, went, rerouted, start_box, local_index, backup, joint_start, held_rows, pairs, box_updates,
         shape_moved, loose_shapes, scratch, solver, impact_law, stepper, report, time, steps] = v;
  a.config(config, observe, time, steps);
  a.bodies(bodies, names, given_mass, given_inertia, shapes_of, joints_of, centre, radius, thickness,
           stray_guess, support, free_bodies, touched, displaced, reach, drag, applied);
  a.shapes(shapes, free_shapes, loose_shapes);
  a.joints(joints, free_joints);
  a.contacts(contacts, parted);
  a.islands(memories, resting, step_memory, step_paths, paths_known, sleepers);
  a.report(report);
}

}  // namespace skerry
