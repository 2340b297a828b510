// SPDX-License-Identifier: MIT
#include "physics/stepping/island_impact.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "physics/solver/impact_law.h"
#include "physics/solver/impact_laws.h"
#include "physics/solver/impact_tools.h"
#include "physics/solver/welded_bodies.h"
#include "physics/spare.h"
#include "physics/stepping/chain_side.h"
#include "physics/stepping/flush_faces.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/joint_limits.h"
#include "physics/stepping/solver_memories.h"
#include "physics/stepping/touching.h"
#include "physics/thread_pool.h"

namespace skerry {

namespace {

// Points within so many touch tolerances are met with what they are flush with: normals whose cosine is this
// near to 1.
constexpr double kNearlyMet = 16, kFlush = 1e-9;
// Contacts, or joints, that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 1024;

/// Makes the problem that of the groups of welded bodies.
void see_groups(const WeldedBodies& welded, ImpactProblem& problem) {
  problem.system = welded.groups();
  for (std::size_t k = 0; k < welded.rows().size(); ++k) {
    const auto i = static_cast<std::size_t>(welded.rows()[k]);
    problem.drive[k] = problem.drive[i] + welded.told(k, problem.velocity);
    problem.restitution[k] = problem.restitution[i];
  }
  problem.drive.resize(welded.rows().size());
  problem.restitution.resize(welded.rows().size());
  Spare<std::vector<Velocity>> groups;
  welded.join(problem.velocity, *groups);
  problem.velocity = *groups;
}

/// Which two bodies meet, where what is static is one body, and the normal towards the second one.
struct Meeting {
  std::uint32_t first, second;
  Vec2 normal;
};

Meeting meeting_of(const WorldState& state, const Contact& contact) {
  const auto which = [&](std::uint32_t body) {
    return state.bodies.type[body] == BodyType::Static ? BodyId::kNone : body;
  };
  const std::uint32_t a = which(contact.body_a), b = which(contact.body_b);
  return a < b ? Meeting{a, b, contact.manifold.normal} : Meeting{b, a, -contact.manifold.normal};
}

bool operator<(const Meeting& x, const Meeting& y) {
  return x.first != y.first ? x.first < y.first : x.second < y.second;
}

/// Whether the two bodies may meet in several contacts.
bool may_meet_in_several(const WorldState& state, const Contact& contact) {
  const auto has_several = [&](std::uint32_t body) {
    return state.bodies.type[body] == BodyType::Static || state.shapes_of[body].size() > 1;
  };
  return has_several(contact.body_a) || has_several(contact.body_b) || is_on_chain(state, contact);
}

/// A face that comes down on one that is made of several, such as tiles, meets their seams and its corners at
/// once: those within rounding of a piece of the step are struck together, as the corners are on one face.
void join_flush_contacts(const WorldState& state, const Island& island, double elapsed,
                         std::vector<std::uint8_t>& touching) {
  const auto contact_at = [&](std::size_t k) -> const Contact& { return state.contacts[island.contacts[k]]; };
  Spare<std::vector<Meeting>> spare;
  std::vector<Meeting>& met = *spare;
  met.clear();
  for (std::size_t k = 0; k < touching.size(); ++k) {
    if (touching[k] != 0 && may_meet_in_several(state, contact_at(k)))
      met.push_back(meeting_of(state, contact_at(k)));
  }
  if (met.empty()) return;
  std::sort(met.begin(), met.end());
  for (std::size_t k = 0; k < touching.size(); ++k) {
    const Contact& contact = contact_at(k);
    // Its own points alone do not make it one of several.
    const int own = touching[k] != 0 ? 1 : 0;
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[i];
      if ((touching[k] >> i & 1) != 0 ||
          !(point.separation <= kNearlyMet * touch_tolerance(state, point.position)) ||
          !(normal_velocity(state, contact, point.position, elapsed) < -state.config.rest_speed))
        continue;
      const Meeting here = meeting_of(state, contact);
      const auto [first, last] = std::equal_range(met.begin(), met.end(), here);
      const auto flush = std::count_if(
          first, last, [&](const Meeting& m) { return dot(here.normal, m.normal) > 1 - kFlush; });
      if (flush > own) touching[k] |= 1u << i;
    }
  }
}

}  // namespace

bool is_struck(const WorldState& state, const Island& island, double elapsed) {
  if (any_of(state.island_threads, island.joints.size(), kContactsAPiece,
             [&](std::size_t k) { return has_limits(state.joints[island.joints[k]].def); })) {
    return true;
  }
  return any_of(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[i];
      if (is_touching(state, point) &&
          normal_velocity(state, contact, point.position, elapsed) < -state.config.rest_speed) {
        return true;
      }
    }
    return false;
  });
}

ImpactOutcome apply_impact(WorldState& state, const Island& island, double elapsed,
                           const ImpactOptions& options, IslandResult& result) {
  ImpactOutcome outcome;
  if (!is_struck(state, island, elapsed)) return outcome;
  if (pass_flush_faces(state, island, elapsed) && !is_struck(state, island, elapsed)) return outcome;
  StageTimer timer(state, result, Stage::Impact);
  Spare<std::vector<std::uint8_t>> spare;
  std::vector<std::uint8_t>& touching = *spare;
  touching.assign(island.contacts.size(), 0);
  for (std::size_t k = 0; k < touching.size(); ++k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[i];
      if (is_touching(state, point)) touching[k] |= 1u << i;
    }
  }
  join_flush_contacts(state, island, elapsed, touching);

  Spare<Assembly> spare_assembly;
  Assembly& assembly = *spare_assembly;
  AssemblyRequest request;
  request.points = &touching;
  request.friction = true;
  request.elapsed = elapsed;
  request.rope_slack = state.config.touch_tolerance;
  request.actuators = AssemblyRequest::Actuators::Rigid;
  assemble(state, island, request, assembly);

  Spare<ImpactProblem> spare_problem;
  ImpactProblem& problem = *spare_problem;
  problem.restitution.clear();
  // Bounces lower than this [m] are summed: their flights are short enough for a constant acceleration.
  const double low = 16 * state.config.touch_tolerance;
  const auto settle = [&](int i, double u) {
    const RowOrigin& origin = assembly.origin[i];
    const double e = problem.restitution.back();
    const double g = -options.normal_acceleration(origin.index, origin.point);
    if (!(u < -state.config.rest_speed) || !(e > 0 && e < 1) || !(g > 0)) return;
    if (e * u * (e * u) > 2 * g * low) return;
    problem.restitution.back() = 0;
    outcome.settled.push_back({origin.index, -2 * e * u / (g * (1 - e))});
  };
  island_velocities(state, island, problem.velocity);
  bool approaching = false, driven = false;
  double fastest = 0;
  Spare<std::vector<int>> spare_held;
  std::vector<int>& held = *spare_held;
  held.clear();
  for (int i = 0; i < assembly.system.size(); ++i) {
    Row& row = assembly.system.rows[i];
    if (row.kind == RowKind::Limit) row.kind = RowKind::Normal;
    if (row.kind == RowKind::Motor) {
      row.kind = RowKind::Joint;
      driven |= assembly.drive[i] != 0;
    }
    const RowOrigin& origin = assembly.origin[i];
    if (origin.kind == RowKind::Friction && !origin.joint) {
      const Contact& contact = state.contacts[origin.index];
      if (contact.static_friction > contact.friction &&
          std::abs(row_velocity(assembly, i, problem.velocity)) <= state.config.rest_speed) {
        row.mu = contact.static_friction;
        held.push_back(i);
      }
    }
    const bool contact_row = row.kind == RowKind::Normal && !origin.joint;
    problem.restitution.push_back(contact_row ? state.contacts[origin.index].restitution : 0);
    const double u = row_velocity(assembly, i, problem.velocity);
    if (contact_row && options.normal_acceleration) settle(i, u);
    if (row.kind != RowKind::Normal || u >= -state.config.rest_speed) continue;
    approaching = true;
    fastest = std::max(fastest, -u);
    if (-u < options.slow && problem.restitution.back() < 1) problem.restitution.back() = 0;
    if (!contact_row) continue;
    Contact& contact = state.contacts[origin.index];
    contact.hit = true;
    if (-u <= contact.hit_speed) continue;
    contact.hit_speed = -u;
    contact.hit_time = elapsed;
    contact.hit_point = contact.manifold.points[origin.point].position;
    contact.hit_normal = contact.manifold.normal;
  }
  if (!approaching) return outcome;
  // What a slow blow hits in turn does not bounce either.
  if (fastest < options.slow) {
    for (double& e : problem.restitution) e = e < 1 ? 0 : e;
  }
  // The sources' right-hand side, for whoever looks at the system: the wanted change of each relative
  // velocity.
  for (int i = 0; i < assembly.system.size(); ++i) {
    assembly.system.b[i] = -(1 + problem.restitution[i]) * row_velocity(assembly, i, problem.velocity);
  }

  problem.drive = assembly.drive;
  problem.ground_speed = may_be_given_energy(state, island) ? told_speed(state, island, 0) : 0;
  problem.rest_speed = state.config.rest_speed;
  problem.solver = state.solver;
  problem.threads = state.island_threads;
  // Impacts are not what an island may be too busy for: they have their own budget.
  problem.work_limit = problem.most_work = work_left_of_all(state, result);
  if (options.work_limit > 0 && !(problem.work_limit > 0 && problem.work_limit < options.work_limit))
    problem.work_limit = options.work_limit;
  problem.welds_as_one = state.config.solve.welds_as_one;
  Spare<WeldedBodies> welded;
  // Bodies that a motor drives against each other hang together by as many rows as a weld, but do not move as
  // one.
  const bool as_one = problem.welds_as_one && !driven && welded->find(assembly.system);
  std::vector<Velocity> bodies;
  if (as_one) {
    bodies = problem.velocity;
    see_groups(*welded, problem);
  } else {
    std::swap(problem.system, assembly.system);
  }
  const double limit = problem.work_limit;
  ImpactResult impact = state.impact_law->apply(problem);
  const auto runs_away = [&](double most) {
    return !(impact::kinetic_energy(problem.system, impact.velocity) <= most);
  };
  const auto instead = [&](ImpactResult other) {
    other.work += impact.work;
    impact = std::move(other);
  };
  const auto try_again = [&](ImpactFn law) {
    if (limit > 0) problem.work_limit = std::max(limit / 16, limit - impact.work.visits);
    instead(law(problem));
  };
  // What static friction cannot hold slides, and rubs less.
  while (!as_one && !held.empty()) {
    const auto slips = [&](int i) {
      return std::abs(impact::row_velocity(problem, i, impact.velocity)) > state.config.rest_speed;
    };
    const auto first = std::partition(held.begin(), held.end(), [&](int i) { return !slips(i); });
    if (first == held.end()) break;
    for (auto i = first; i != held.end(); ++i)
      problem.system.rows[*i].mu = state.contacts[assembly.origin[*i].index].friction;
    held.erase(first, held.end());
    try_again(state.impact_law->apply);
  }
  if (impact::exceeds_bounce(problem, impact.velocity)) {
    // What is squeezed does not bounce.
    std::fill(problem.restitution.begin(), problem.restitution.end(), 0.0);
    try_again(state.impact_law->apply);
    // Laws that know no jam.
    if (runs_away(impact::most_of_push(problem, impact::kWedge))) try_again(impact::apply_reflections);
    if (runs_away(kInfinity)) {
      ImpactResult none;
      none.velocity = problem.velocity;
      none.lambda.resize(problem.system.rows.size());
      none.status = SolveStatus::Inexact;
      none.residual = 1;
      instead(std::move(none));
    }
  }
  IslandSystem& whole = as_one ? assembly.system : problem.system;
  if (as_one) {
    std::vector<double> of_groups;
    of_groups.swap(impact.lambda);
    SolveOptions solve = state.config.solve;
    solve.threads = state.island_threads;
    solve.work_limit = work_left_of_all(state, result, impact.work.visits);
    MemoryLoan memory(state, result, SolvePurpose::Welds, welded->welds());
    welded->expand(of_groups, solve, memory.get(), impact.lambda, impact.work);
    impact.work.rows_left_out += welded->rows_less();
    welded->spread(impact.velocity, bodies);
    impact.velocity = std::move(bodies);
  }
  // Joints that contradict each other may want any velocity, and so may what is squeezed. Fields do no work
  // in no time.
  const bool jointed = !island.joints.empty();
  std::optional<IslandEnergy> energy;
  if ((jointed || may_be_given_energy(state, island)) && !state.impact_law->may_create_energy)
    energy.emplace(state, island, true, elapsed);
  store_velocities(state, island, impact.velocity);
  if (energy && !jointed) energy->take_push(state, island, 0);
  if (energy && jointed) {
    const bool solved = impact.status == SolveStatus::Solved;
    double passed = 0;
    energy->take_much(state, island, 0, solved ? work_of_drive(assembly, impact.lambda) : 0, passed);
  }
  for (int i = 0; i < whole.size(); ++i) {
    const RowOrigin& origin = assembly.origin[i];
    if (origin.joint) {
      state.joints[origin.index].row_impulse[origin.point] += impact.lambda[i];
      continue;
    }
    Contact& contact = state.contacts[origin.index];
    PointMemory& memory = contact.points[origin.point];
    const Vec2 push = impact.lambda[i] * push_on_b(whole.rows[i]);
    contact.impulse += push;
    if (origin.kind == RowKind::Normal && impact.lambda[i] != 0) {
      memory.total_impact += impact.lambda[i];
      memory.impact_position = contact.manifold.points[origin.point].position;
      contact.impact += push;
    }
    if (origin.kind == RowKind::Friction) memory.total_friction += impact.lambda[i];
  }
  outcome.applied = true;
  outcome.spent = impact.status != SolveStatus::Solved && limit > 0 && impact.work.visits > limit;
  ++result.impacts;
  result.reflections += impact.reflections;
  note_status(result, impact.status, impact.residual);
  note_work(result, impact.work, impact.status);
  if (result.work_limit > 0) result.work_limit += impact.work.visits;
  if (state.observe.systems) {
    keep_trace(state, island, elapsed, std::move(whole), std::move(impact.lambda), impact.status,
               state.impact_law->name, impact.residual, true, nullptr, result);
  }
  give_spare(std::move(impact.lambda));
  give_spare(std::move(impact.velocity));
  return outcome;
}

}  // namespace skerry
