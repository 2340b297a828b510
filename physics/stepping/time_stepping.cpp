// SPDX-License-Identifier: MIT
#include "physics/stepping/time_stepping.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "physics/spare.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/flight_queue.h"
#include "physics/stepping/flow.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_impact.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/joint_stability.h"
#include "physics/stepping/next_contact.h"
#include "physics/stepping/paradox.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/sliding_stop.h"
#include "physics/stepping/solver_memories.h"
#include "physics/stepping/step_doubling.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Pieces of a step at most for the sake of stability: a load of 1e6 times the links' mass wants 130 at 1/60
// s.
constexpr double kStablePieces = 256;

// Contact points, summed over the pieces of a step, after which landings are plastic; but so many pieces
// always.
constexpr int kPieceBudget = 512;
constexpr int kFewPieces = 4;
// Ends of sliding that cut a step; further ones are of first order.
constexpr int kMostStops = 4;
// A piece in which nothing rests needs no solve and costs this much less.
constexpr int kFlightShare = 32;

class IslandStep {
 public:
  IslandStep(WorldState& state, const Island& island, IslandResult& result)
      : state_(state),
        island_(island),
        result_(result),
        resting_(take_spare<std::vector<std::uint8_t>>()),
        varying_(has_varying_forces(state, island)),
        told_(meets_prescribed_motion(state, island)),
        modes_(take_spare<std::vector<std::uint8_t>>()) {
    resting_.resize(island.contacts.size());
  }
  ~IslandStep() {
    give_spare(std::move(resting_));
    give_spare(std::move(modes_));
  }
  IslandStep(const IslandStep&) = delete;
  IslandStep& operator=(const IslandStep&) = delete;

  /// Brings the island from one time of the step to another [s].
  void run(double from, double to) {
    elapsed_ = from;
    // A piece costs in proportion to the island, and much less where nothing rests, so busy islands get
    // fewer: a heap of 100 contacts is cut 5 times, a row of balls or a gas as often as its bounces want.
    int points = 0, spent = 0;
    for (const std::uint32_t index : island_.contacts) points += state_.contacts[index].manifold.count;
    // The manifolds of the beginning are those by which the island was found.
    int piece = 1;
    int flights = 0;
    while (elapsed_ < to) {
      // A gas goes from impact to impact, and no impact costs a piece.
      if (flights < kMostFlights) {
        const double there = fly_by_queue(state_, island_, elapsed_, to, false, result_);
        if (there > elapsed_) {
          ++flights;
          elapsed_ = there;
          continue;
        }
      }
      // After too many cuts the rest of the step takes landings as plastic, at its end.
      const bool last =
          piece > state_.config.max_impacts_per_step || (piece > kFewPieces && spent >= kPieceBudget);
      if (!last) apply_impact(state_, island_, elapsed_, {}, result_);
      // Joints that shake light bodies get shorter pieces, which are not cuts.
      const double stable = std::max(stable_length(state_, island_), (to - from) / kStablePieces);
      const bool whole = to - elapsed_ <= stable;
      const double length = whole ? to - elapsed_ : (to - elapsed_) / std::ceil((to - elapsed_) / stable);
      choose_resting(last);
      std::vector<Velocity> before = island_velocities(state_, island_);
      std::vector<Velocity> after = solve_forces(length, before, last);
      double hit = last ? length : next_hit(length, before, after);
      // Points that would go down from where they are join the solve; each round adds at least one.
      while (sinking_) {
        give_spare(std::move(after));
        after = solve_forces(length, before, last);
        hit = next_hit(length, before, after);
      }
      // The end of sliding is an end of the piece.
      if (stop_ < hit) {
        hit = stop_;
        ++stops_;
      }
      spent += solved_ ? points : points / kFlightShare;
      if (state_.observe.paths) remember_start(last, after);
      const double start = elapsed_;
      const std::optional<IslandEnergy> energy =
          last ? std::optional<IslandEnergy>(std::in_place, state_, island_) : std::nullopt;
      advance(hit, length, before, after, last);
      elapsed_ = hit < length || !whole ? elapsed_ + hit : to;
      if (hit < length || whole) ++piece;
      refresh_manifolds();
      {
        StageTimer timer(state_, result_, Stage::Apply);
        const std::optional<IslandEnergy> carried =
            moving_ ? std::optional<IslandEnergy>(std::in_place, state_, island_) : std::nullopt;
        Spare<Assembly> rows;
        project_positions(state_, island_, elapsed_, result_, &*rows);
        const double work =
            moving_ ? project_velocities(state_, island_, elapsed_, true, result_, &*rows) : 0;
        if (carried) carried->keep(state_, island_, work);
        // The plastic end of a step is of first order and lifts what it lets sink in.
        if (energy) energy->take_gain(state_, island_);
      }
      if (state_.observe.paths) record_hermite(state_, island_.bodies, start, hit, start_, result_);
      ++result_.substeps;
      give_spare(std::move(before));
      give_spare(std::move(after));
    }
  }

 private:
  /// Where the path of a piece begins; the plastic end of a step moves with its final velocity throughout.
  void remember_start(bool plastic, const std::vector<Velocity>& after) {
    start_ = path_ends(state_, island_.bodies);
    for (std::size_t k = 0; plastic && k < start_.size(); ++k) start_[k].v = after[k];
  }

  void refresh_manifolds() {
    StageTimer timer(state_, result_, Stage::Narrow);
    result_.manifolds_reused += update_manifolds(state_, island_, elapsed_, result_.narrow);
  }

  /// Points that touch and do not separate take part in the force solve; in the plastic end of a step all
  /// near ones.
  void choose_resting(bool all_near) {
    for (std::size_t k = 0; k < resting_.size(); ++k) {
      const Contact& contact = state_.contacts[island_.contacts[k]];
      resting_[k] = 0;
      for (int i = 0; i < contact.manifold.count; ++i) {
        const ManifoldPoint& point = contact.manifold.points[i];
        const bool rests =
            is_touching(state_, point) &&
            normal_velocity(state_, contact, point.position, elapsed_) <= state_.config.rest_speed;
        if (rests || (all_near && point.separation <= contact.margin)) resting_[k] |= 1u << i;
      }
    }
  }

  /// Geometry half-way through the piece, if anything moves enough to matter.
  bool midpoint(double h, const std::vector<Velocity>& v, std::vector<Transform>& poses,
                std::vector<double>& angles, std::vector<Manifold>& manifolds) {
    double largest = 0;
    poses.resize(v.size());
    angles.resize(v.size());
    for (std::size_t k = 0; k < v.size(); ++k) {
      const std::uint32_t body = island_.bodies[k];
      angles[k] = state_.bodies.angle[body] + 0.5 * h * v[k][2];
      poses[k] = {state_.bodies.position[body] + 0.5 * h * Vec2{v[k][0], v[k][1]},
                  Rot::from_angle(angles[k])};
      largest = std::max(largest, 0.5 * h * (length(Vec2{v[k][0], v[k][1]}) + std::abs(v[k][2])));
    }
    // Below this the Jacobian changes by less than rounding.
    if (largest < 1e-12 && !told_) return false;
    const auto pose = [&](std::uint32_t body) {
      const int local = state_.local_index[body];
      return local >= 0 ? poses[local] : pose_at(state_, body, elapsed_ + 0.5 * h);
    };
    manifolds.resize(resting_.size());
    for (std::size_t k = 0; k < resting_.size(); ++k) {
      Contact& contact = state_.contacts[island_.contacts[k]];
      manifolds[k] = contact.manifold;
      if (resting_[k] == 0) continue;
      const Manifold mid =
          contact_manifold(contact, state_.shapes[contact.shape_a].shape, pose(contact.body_a),
                           state_.shapes[contact.shape_b].shape, pose(contact.body_b), contact.margin,
                           state_.config.skips.axes ? &contact.cache : nullptr, &result_.narrow);
      // Points keep their numbers; where the features changed on the way the old geometry serves.
      int found = 0;
      Manifold same = contact.manifold;
      for (int i = 0; i < same.count; ++i) {
        for (int j = 0; j < mid.count; ++j) {
          if (mid.points[j].feature != same.points[i].feature) continue;
          same.points[i].position = mid.points[j].position;
          ++found;
        }
      }
      same.normal = mid.normal;
      if (found == same.count) manifolds[k] = same;
    }
    return true;
  }

  /// Velocities at the end of a piece of length `h`. Forces that depend on the state are those of its middle,
  /// found from the velocities that they give: second order, and with the contact forces in them.
  std::vector<Velocity> solve_forces(double h, const std::vector<Velocity>& before, bool plastic) {
    if (!varying_) return solve_once(h, before, plastic);
    std::vector<Velocity> after = before;
    for (int pass = 0; pass < 3; ++pass) {
      for (std::size_t k = 0; k < after.size(); ++k) {
        const std::uint32_t body = island_.bodies[k];
        std::array<double, 3> mid{}, path{};
        for (std::size_t c = 0; c < 3; ++c) {
          mid[c] = 0.5 * (before[k][c] + after[k][c]);
          path[c] = 0.25 * h * (before[k][c] + mid[c]);
        }
        const double angle = state_.bodies.angle[body] + path[2];
        const JointEnd middle{state_.bodies.position[body] + Vec2{path[0], path[1]},
                              Rot::from_angle(angle),
                              angle,
                              {mid[0], mid[1]},
                              mid[2]};
        const std::array<double, 3> a = applied_acceleration(state_, body, middle, elapsed_ + 0.5 * h);
        state_.acceleration[body] = {a[0], a[1]};
        state_.angular_acceleration[body] = a[2];
      }
      // The first guess needs no contact forces: the second pass has them.
      if (pass == 0) {
        add_free_motion(state_, island_, h, after);
      } else {
        after = solve_once(h, before, plastic);
      }
    }
    return after;
  }

  std::vector<Velocity> solve_once(double h, const std::vector<Velocity>& before, bool plastic) {
    std::vector<Velocity> after = take_spare<std::vector<Velocity>>();
    after = before;
    add_free_motion(state_, island_, h, after);

    Spare<Assembly> spare_start, spare_mid;
    Assembly &start = *spare_start, &mid = *spare_mid;
    {
      StageTimer timer(state_, result_, Stage::Assemble);
      AssemblyRequest request;
      request.points = &resting_;
      request.friction = true;
      request.elapsed = elapsed_;
      request.rope_slack = kInfinity;
      request.actuators = AssemblyRequest::Actuators::All;
      assemble(state_, island_, request, start);
      Spare<std::vector<Transform>> poses;
      Spare<std::vector<double>> angles;
      Spare<std::vector<Manifold>> manifolds;
      if (!plastic && midpoint(h, before, *poses, *angles, *manifolds)) {
        request.poses = &*poses;
        request.angles = &*angles;
        request.elapsed = elapsed_ + 0.5 * h;
        request.manifolds = &*manifolds;
        assemble(state_, island_, request, mid);
      }
    }
    moving_ = mid.system.size() == start.system.size() && mid.system.size() > 0;
    stop_ = h;
    Assembly& assembly = moving_ ? mid : start;
    IslandSystem& system = assembly.system;
    solved_ = !system.rows.empty();
    if (!solved_) {
      // What flies carries no load any more: the projection must not pull it back.
      store_impulses(assembly, {}, h);
      return after;
    }

    for (int i = 0; i < system.size(); ++i) {
      const RowOrigin& origin = assembly.origin[i];
      double target = 0;
      // The average of both ends obeys the midpoint's constraint; what is not explained by the geometry is
      // not kept.
      if (origin.spring()) {
        target = add_spring(assembly, i, start.origin[i].error, before, h);
      } else {
        const bool stays = origin.kind == RowKind::Normal || origin.kind == RowKind::Joint ||
                           origin.kind == RowKind::Motor || sticks(origin) || rests(start, i, before);
        if (moving_ && stays) target = row_velocity(start, i, before) - row_velocity(mid, i, before);
        if (plastic && origin.kind == RowKind::Normal) target = -std::max(0.0, origin.error) / h;
        if (origin.kind == RowKind::Limit && !rests(start, i, before))
          target = -std::max(0.0, origin.error) / h;
        if (origin.kind == RowKind::Motor) {
          system.rows[i].lower *= h;
          system.rows[i].upper *= h;
        }
      }
      system.b[i] = target - row_velocity(assembly, i, after);
    }

    Spare<std::vector<double>> warm;
    warm_start(assembly, h, *warm);
    const std::uint64_t key = memory_key(SolvePurpose::Forces, system);
    std::unique_ptr<SolverMemory> memory = take_memory(state_, result_, key);
    SolveOptions options = state_.config.solve;
    options.work_limit = work_left(state_, result_);
    options.trace = state_.observe.systems && state_.observe.solve_traces;
    Solution solution;
    {
      StageTimer timer(state_, result_, Stage::Solve);
      std::vector<int> held = held_rows(start, assembly, before);
      solution = state_.solver->solve(system, *warm, options, &memory);
      // What static friction cannot hold slides, and pulls less from then on, so that others may follow; each
      // round at least one fewer is held.
      while (let_go(assembly, solution.lambda, held)) {
        const SolveWork before_it = solution.work;
        solution = state_.solver->solve(system, solution.lambda, options, &memory);
        solution.work += before_it;
      }
      if (!plastic && stops_ < kMostStops)
        stop_ = slide_to_stop(state_, {start, assembly, before, after, h}, options, &memory, solution);
    }
    keep_memory(state_, result_, key, std::move(memory));
    note_paradoxes(start, before, solution.lambda);
    apply_impulses(system, solution.lambda, after);
    quieten(h, after);
    store_impulses(assembly, solution.lambda, h);
    note_solution(solution, system);
    if (state_.observe.systems) {
      keep_trace(state_, island_, elapsed_, system, solution.lambda, solution.status, solution.method,
                 solution.residual, false, std::move(solution.trace), result_);
    }
    give_spare(std::move(solution.lambda));
    return after;
  }

  /// @param start  rows where the piece begins
  void note_paradoxes(const Assembly& start, const std::vector<Velocity>& before,
                      const std::vector<double>& lambda) {
    for (int i = 0; i < start.system.size(); ++i) {
      const Row& row = start.system.rows[i];
      if (row.kind != RowKind::Friction || !(lambda[row.normal] > 0)) continue;
      const double sliding = row_velocity(start, i, before);
      if (std::abs(sliding) <= state_.config.rest_speed || !is_paradoxical(start.system, row, sliding))
        continue;
      const Contact& contact = state_.contacts[start.origin[i].index];
      result_.motion_events.push_back({MotionEventKind::Paradox, elapsed_,
                                       state_.shapes[contact.shape_a].body,
                                       state_.shapes[contact.shape_b].body});
    }
  }

  /// Friction rows that static friction holds: they stuck, or do not slide at the beginning. Gives them its
  /// coefficient.
  std::vector<int> held_rows(const Assembly& start, Assembly& assembly,
                             const std::vector<Velocity>& before) const {
    std::vector<int> held;
    for (int i = 0; i < assembly.system.size(); ++i) {
      const RowOrigin& origin = assembly.origin[i];
      if (origin.joint || origin.kind != RowKind::Friction) continue;
      const Contact& contact = state_.contacts[origin.index];
      if (!(contact.static_friction > contact.friction)) continue;
      const bool still = std::abs(row_velocity(start, i, before)) <= state_.config.rest_speed;
      if (!still && !contact.points[origin.point].sticking) continue;
      assembly.system.rows[i].mu = contact.static_friction;
      held.push_back(i);
    }
    return held;
  }

  /// Gives the rows of `held` that slide in spite of it the coefficient of sliding. One point of a face at
  /// its bound says nothing: its neighbour may hold for both. @return whether there were any
  bool let_go(Assembly& assembly, const std::vector<double>& lambda, std::vector<int>& held) const {
    if (held.empty()) return false;
    const std::vector<double> w = row_velocities(assembly.system, lambda);
    const double slip = 1e-8 * largest_magnitude(assembly.system.b);
    return std::erase_if(held, [&](int i) {
             if (!(std::abs(w[static_cast<std::size_t>(i)]) > slip)) return false;
             assembly.system.rows[static_cast<std::size_t>(i)].mu =
                 state_.contacts[assembly.origin[static_cast<std::size_t>(i)].index].friction;
             return true;
           }) > 0;
  }

  /// A joint limit that is reached and is not about to be left.
  bool rests(const Assembly& start, int i, const std::vector<Velocity>& v) const {
    const RowOrigin& origin = start.origin[i];
    return origin.kind == RowKind::Limit && origin.error <= state_.config.touch_tolerance &&
           row_velocity(start, i, v) <= state_.config.rest_speed;
  }

  /// A spring by the midpoint rule: its force is that of the stretch and the speed half-way,
  ///
  ///   lambda = -h (k (C + h u / 2) + c u),   u = (J v0 + J v1) / 2,   so with  g = 4 / (h^2 k + 2 h c)
  ///   J v1 + g lambda = -J v0 - g h k C
  ///
  /// a row with compliance g. For a linear oscillator without damper the energy is that of the beginning
  /// [Hairer, Lubich & Wanner 2006, sec. II.1.2, IV.2]; of second order in general.
  /// @param stretch  C at the beginning of the piece
  static double add_spring(Assembly& assembly, int i, double stretch, const std::vector<Velocity>& before,
                           double h) {
    const RowOrigin& origin = assembly.origin[i];
    const double g = 4 / (h * (h * origin.stiffness + 2 * origin.damping));
    assembly.system.compliance.resize(assembly.system.rows.size(), 0);
    assembly.system.compliance[i] = g;
    return -row_velocity(assembly, i, before) - g * h * origin.stiffness * stretch;
  }

  /// What the impulses leave of the weight they balance is rounding, not motion: bodies that are slower than
  /// that are at rest to the bit, so that nothing of them has to be computed again.
  void quieten(double h, std::vector<Velocity>& v) const {
    double fastest = 0;
    for (const std::uint32_t body : island_.bodies) {
      fastest = std::max(fastest, length(state_.acceleration[body]) +
                                      std::abs(state_.angular_acceleration[body]) * state_.radius[body]);
    }
    const double floor = 1e-10 * h * fastest;  // the solvers' tolerance
    for (std::size_t k = 0; k < v.size(); ++k) {
      const double turn = std::abs(v[k][2]) * state_.radius[island_.bodies[k]];
      if (std::max({std::abs(v[k][0]), std::abs(v[k][1]), turn}) < floor) v[k] = {0, 0, 0};
    }
  }

  bool sticks(const RowOrigin& origin) const {
    if (origin.joint || origin.kind != RowKind::Friction) return false;
    return state_.contacts[origin.index].points[origin.point].sticking;
  }

  void warm_start(const Assembly& assembly, double h, std::vector<double>& warm) const {
    warm.assign(assembly.origin.size(), 0);
    for (std::size_t i = 0; i < warm.size(); ++i) {
      const RowOrigin& origin = assembly.origin[i];
      if (origin.joint) {
        warm[i] = state_.joints[origin.index].row_force[origin.point] * h;
        continue;
      }
      const PointMemory& memory = state_.contacts[origin.index].points[origin.point];
      if (!(memory.h > 0)) continue;
      const double impulse = origin.kind == RowKind::Normal     ? memory.normal_impulse
                             : origin.kind == RowKind::Friction ? memory.friction_impulse
                                                                : memory.rolling_impulse;
      warm[i] = impulse * (h / memory.h);
    }
  }

  void store_impulses(const Assembly& assembly, const std::vector<double>& lambda, double h) {
    modes_.clear();
    for (const std::uint32_t index : island_.contacts) {
      for (PointMemory& memory : state_.contacts[index].points) {
        modes_.push_back(mode_of(memory));
        memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
        memory.h = h;
        memory.sticking = false;
      }
    }
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const RowOrigin& origin = assembly.origin[i];
      if (origin.joint) {
        state_.joints[origin.index].row_force[origin.point] = lambda[i] / h;
        continue;
      }
      PointMemory& memory = state_.contacts[origin.index].points[origin.point];
      if (origin.kind == RowKind::Normal) memory.normal_impulse = lambda[i];
      if (origin.kind == RowKind::Rolling) memory.rolling_impulse = lambda[i];
      if (origin.kind != RowKind::Friction) continue;
      memory.friction_impulse = lambda[i];
      memory.sticking =
          memory.normal_impulse > 0 &&
          std::abs(lambda[i]) < assembly.system.rows[i].mu * memory.normal_impulse * (1 - 1e-12);
    }
    auto mode = modes_.begin();
    for (const std::uint32_t index : island_.contacts) {
      for (const PointMemory& memory : state_.contacts[index].points)
        result_.mode_changes += mode_of(memory) != *mode++;
    }
  }

  /// 0 open, 1 slipping, 2 sticking
  static std::uint8_t mode_of(const PointMemory& memory) {
    return memory.normal_impulse > 0 ? 1 + memory.sticking : 0;
  }

  /// Time until the next landing within the piece, or its length. Points that sink are made resting ones.
  double next_hit(double h, const std::vector<Velocity>& before, const std::vector<Velocity>& after) {
    StageTimer timer(state_, result_, Stage::Narrow);
    const auto motion = [&](std::uint32_t body) {
      const BodyArrays& all = state_.bodies;
      Motion m;
      m.p0 = all.position[body];
      m.angle0 = all.angle[body];
      const int k = state_.local_index[body];
      if (k >= 0) {
        m.v = {before[k][0], before[k][1]};
        m.omega = before[k][2];
        m.a = Vec2{after[k][0] - before[k][0], after[k][1] - before[k][1]} / h;
        m.alpha = (after[k][2] - before[k][2]) / h;
      } else if (all.type[body] == BodyType::Kinematic) {
        const KinematicState now = kinematic_state(state_, body, elapsed_);
        m = {now.p, now.angle, now.v, now.omega, now.a, now.alpha};
      }
      return m;
    };
    double first = h;
    sinking_ = false;
    for (std::size_t k = 0; k < resting_.size(); ++k) {
      const std::uint32_t index = island_.contacts[k];
      const Contact& contact = state_.contacts[index];
      if (!moves(contact.body_a, before, after) && !moves(contact.body_b, before, after)) continue;
      const NextContact next = next_contact_time(state_, index, motion(contact.body_a),
                                                 motion(contact.body_b), resting_[k], first);
      first = std::min(first, next.t);
      if (!next.sinks) continue;
      for (int i = 0; i < contact.manifold.count; ++i) {
        const std::uint8_t bit = 1u << i;
        if ((resting_[k] & bit) != 0 || !is_touching(state_, contact.manifold.points[i])) continue;
        resting_[k] |= bit;
        sinking_ = true;
      }
    }
    return first;
  }

  bool moves(std::uint32_t body, const std::vector<Velocity>& before,
             const std::vector<Velocity>& after) const {
    const int k = state_.local_index[body];
    if (k >= 0) return before[k] != Velocity{} || after[k] != Velocity{};
    return state_.bodies.type[body] == BodyType::Kinematic;
  }

  void advance(double t, double h, const std::vector<Velocity>& before, const std::vector<Velocity>& after,
               bool plastic) {
    StageTimer timer(state_, result_, Stage::Apply);
    const double share = t < h ? t / h : 1;
    double excess = 0;  // of angular momentum
    for (std::size_t k = 0; k < before.size(); ++k) {
      const std::uint32_t body = island_.bodies[k];
      Velocity v = after[k];
      Velocity path = after[k];
      for (int c = 0; c < 3; ++c) {
        if (share < 1) v[c] = before[k][c] + share * (after[k][c] - before[k][c]);
        if (!plastic) path[c] = 0.5 * (before[k][c] + v[c]);
      }
      BodyArrays& all = state_.bodies;
      if (share < 1) {
        // The impulses act at the middle of the whole piece; where it is cut that is not the middle any more.
        const Vec2 v0{before[k][0], before[k][1]};
        const Vec2 push = Vec2{v[0], v[1]} - v0 - t * state_.acceleration[body];
        excess += 0.5 * (t - h) * all.mass[body] * cross(v0, push);
      }
      all.position[body] += t * Vec2{path[0], path[1]};
      if (path[2] != 0) {
        all.angle[body] += t * path[2];
        all.rotation[body] = Rot::from_angle(all.angle[body]);
      }
      all.velocity[body] = {v[0], v[1]};
      all.omega[body] = v[2];
      const double speed = std::max(length(Vec2{before[k][0], before[k][1]}), length(Vec2{v[0], v[1]}));
      const double turn = std::max(std::abs(before[k][2]), std::abs(v[2]));
      state_.travelled[body] += t * (speed + turn * state_.radius[body]);
    }
    give_spin(state_, island_, -excess);
    for (const std::uint32_t index : island_.contacts) {
      for (PointMemory& memory : state_.contacts[index].points) {
        memory.total_normal += share * memory.normal_impulse;
        memory.total_friction += share * memory.friction_impulse;
      }
    }
    for (const std::uint32_t slot : island_.joints) {
      JointRecord& joint = state_.joints[slot];
      for (int k = 0; k < kMaxJointRows; ++k) joint.row_impulse[k] += t * joint.row_force[k];
    }
  }

  void note_solution(const Solution& solution, const IslandSystem& system) {
    note_status(result_, solution.status, solution.residual);
    result_.report.method = solution.method;
    result_.report.iterations += solution.iterations;
    result_.report.rows = system.size();
    result_.friction_rows += static_cast<int>(std::count_if(
        system.rows.begin(), system.rows.end(), [](const Row& r) { return r.kind == RowKind::Friction; }));
    result_.work += solution.work;
  }

  WorldState& state_;
  const Island& island_;
  IslandResult& result_;
  std::vector<std::uint8_t> resting_;  ///< per contact of the island: bits of the points in the force solve
  bool varying_;                       ///< forces depend on the state
  bool told_;                          ///< something here moves as prescribed

  std::vector<std::uint8_t> modes_;  ///< of the contact points before a solve
  double stop_ = 0;                  ///< when sliding ends in the piece, or its length [s]
  int stops_ = 0;                    ///< of the step
  double elapsed_ = 0;               ///< since the beginning of the step [s]
  bool solved_ = false;              ///< the piece has contacts or joints that act
  bool moving_ = false;              ///< the geometry changes within the piece
  bool sinking_ = false;             ///< `next_hit` found points that the solve has to hold
  std::vector<PathEnd> start_;       ///< of the piece, for the paths
};

}  // namespace

void step_island_by_time_stepping(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (fly_freely(state, island, h, result)) return;
  result.report.stepper = "time_stepping";
  if (state.config.accuracy)
    step_with_error_control(state, island, h, *state.config.accuracy, result);
  else if (is_in_flow(state, island, h))
    step_island_in_flow(state, island, h, result);
  else {
    IslandStep(state, island, result).run(0, h);
    result.step_memory.flow = restlessness(result);
  }
}

void advance_island(WorldState& state, const Island& island, double from, double to, IslandResult& result) {
  IslandStep(state, island, result).run(from, to);
}

bool fly_freely(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (!state.config.skips.flight || !island.contacts.empty() || !island.joints.empty() ||
      has_varying_forces(state, island)) {
    return false;
  }
  std::vector<PathEnd> start;
  if (state.observe.paths) start = path_ends(state, island.bodies);
  for (const std::uint32_t body : island.bodies) fly(state, body, h);
  if (state.observe.paths) record_hermite(state, island.bodies, 0, h, start, result);
  result.in_flight = true;
  result.substeps = 1;
  return true;
}

void fly(WorldState& state, std::uint32_t body, double h) {
  BodyArrays& all = state.bodies;
  const Vec2 v0 = all.velocity[body];
  const double w0 = all.omega[body];
  all.velocity[body] = v0 + h * state.acceleration[body];
  all.omega[body] = w0 + h * state.angular_acceleration[body];
  all.position[body] += 0.5 * h * (v0 + all.velocity[body]);
  const double turn = 0.5 * h * (w0 + all.omega[body]);
  if (turn != 0) {
    all.angle[body] += turn;
    all.rotation[body] = Rot::from_angle(all.angle[body]);
  }
  const double speed = std::max(length(v0), length(all.velocity[body]));
  state.travelled[body] +=
      h * (speed + std::max(std::abs(w0), std::abs(all.omega[body])) * state.radius[body]);
}

}  // namespace skerry
