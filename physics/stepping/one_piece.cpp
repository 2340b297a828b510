// SPDX-License-Identifier: MIT
#include "physics/stepping/one_piece.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "physics/solver/impact_tools.h"
#include "physics/spare.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/deep_points.h"
#include "physics/stepping/flow_faces.h"
#include "physics/stepping/flow_work.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/joint_stability.h"
#include "physics/stepping/one_piece_joints.h"
#include "physics/stepping/one_piece_positions.h"
#include "physics/stepping/one_piece_rule.h"
#include "physics/stepping/one_piece_store.h"
#include "physics/stepping/one_piece_sweeps.h"
#include "physics/stepping/past_walls.h"
#include "physics/stepping/path.h"
#include "physics/stepping/point_memory.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/solver_memories.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// How deep points end that only the impulses of others close and that join the rows, as a share of the
// smaller body; beside joints, where an answer costs more and, without much work, another one would not be
// had.
constexpr double kMissed = 0.005, kMissedBesideJoints = 0.1;
// What an exact answer may cost, in steps of an island in flow; from so many bodies on more, as a factor
// grows with the power 3/2 of them.
constexpr double kExactWork = 30, kManyBodies = 1e4;
// The same of an island that flows, in which attempts are many and vain; in a large world none that took more
// came to anything.
constexpr double kExactWorkInFlow = 10, kExactWorkInLargeFlow = 2.5;
// Residual of the best that was found for that, up to which flow goes on with it: sweeps leave more.
constexpr double kNearly = 1e-3;
// The same up to which the step goes on as an exact one: reported, but nothing to do without.
constexpr double kAlmost = 1e-8;
// Sweeps over the velocities of an island without joints in a large world, where its rows are so few that its
// work would pay for more: what these leave is less than what nobody foresaw.
constexpr double kMostSweeps = 60;
// A step of which so many visits were thrown away has the usual work where heavy bodies lie on light ones.
constexpr double kMostThrownAway = 2e7;
// A step in flow is cut into pieces no longer than this times what is stable for rods under load; in a small
// world, where that is no price, nor than this times what is stable for hinges, which are steady but take
// part in a blow too late; and into so many at most, for hinges alone.
constexpr double kRodSwing = 0.8, kHingeSwing = 4, kMostPieces = 64, kMostForHinges = 8;
// Where joints contradict each other, and so much of a residual is left, their forces say little; and so many
// visits, which take some 100 ms, are enough for a step.
constexpr double kContradicted = 5e-3, kWorkOfPieces = 3e7, kFewPieces = 4;
// Energy in that of the free motion that an exact answer with bounces may have, by its rounding, and one of
// sweeps, which are not at their end.
constexpr double kRoundedGain = 1 + 1e-9, kWildGain = 1.5;
// Speed of what stuck, in what forces change a velocity in the step, from which on it slides.
constexpr double kSlides = 0.1;
// Contacts or rows that a thread takes at a time.
constexpr std::size_t kItemsAPiece = 256;

/// Rows together with those of points that only the impulses of others close. They have their own spare
/// memory: rows are written over those that are there, and a list that changes its length costs as much as
/// its rows.
struct MoreRows : Assembly {};

class OnePieceStep {
 public:
  enum class Answer { Exact, NearlyExact, Swept };

  /// @param more         times what flow may cost
  /// @param more_pieces  like this one follow in this step
  OnePieceStep(WorldState& state, const Island& island, double from, double to, Answer answer,
               IslandResult& result, double more = 1, double more_pieces = 0)
      : state_(state),
        island_(island),
        from_(from),
        h_(to - from),
        exact_(answer != Answer::Swept),
        nearly_(answer == Answer::NearlyExact && may_flow(state)),
        varying_(has_varying_forces(state, island)),
        more_pieces_(more_pieces),
        result_(result) {
    slow_ = slow_speed(state, island, h_);
    const auto bodies = static_cast<double>(island.bodies.size());
    const double share = !was_in_flow(state, island)   ? kExactWork
                         : works_finely(state, island) ? kExactWorkInFlow
                                                       : kExactWorkInLargeFlow;
    exact_limit_ = share * usual_flow_work(state) * bodies * std::sqrt(std::max(1.0, bodies / kManyBodies));
    // Without flow, sweeps for positions still want a bound.
    double work = more * (may_flow(state) ? flow_work(state, island) : kUsualFlowWork);
    if (!state.config.flow_work && result.thrown_away.visits < kMostThrownAway)
      work = std::max(work, work_for_heavy(state, island));
    const double with_joints = bodies + kJointWork * static_cast<double>(island.joints.size());
    limit_ = work * with_joints;
    if (state.config.flow_work) {
      // As much as the user likes, but no more than an island may cost.
      if (state.config.solve.work_limit > 0) limit_ = std::min(limit_, state.config.solve.work_limit);
      return;
    }
    if (island.joints.empty() && !works_finely(state, island)) most_sweeps_ = more * kMostSweeps;
    if (!island.joints.empty())
      sweep_end_ = {.swept = more * kVelocityShare * kUsualFlowWork * with_joints,
                    .coarse = work < kFineWork};
  }

  /// @return false, and nothing has happened, if an exact answer, or nearly one, was wanted and there is none
  bool run() {
    std::vector<Velocity> before = island_velocities(state_, island_);
    std::vector<Velocity> after = take_spare<std::vector<Velocity>>();
    std::vector<std::uint8_t> pushed = take_spare<std::vector<std::uint8_t>>();
    foresee_faces(state_, island_, from_, h_, slow_);
    const bool lost = varying_ && !foresee_forces(before, after);
    const bool solved = lost || solve(before, after, pushed);
    if (solved && !lost && !(varying_ && are_lost(state_, island_, after))) move_on(before, after, pushed);
    give_spare(std::move(before));
    give_spare(std::move(after));
    give_spare(std::move(pushed));
    return solved;
  }

 private:
  /// Forces that depend on the state are those of the middle of the free motion that they give.
  /// @return false where that leaves the numbers
  bool foresee_forces(const std::vector<Velocity>& before, std::vector<Velocity>& after) {
    after = before;
    take_forces(state_, island_, from_, h_, before, after, *damping_);
    add_free_motion(state_, island_, h_, after);
    if (are_lost(state_, island_, after)) return false;
    take_forces(state_, island_, from_, h_, before, after, *damping_);
    return true;
  }

  void move_on(const std::vector<Velocity>& before, std::vector<Velocity>& after,
               const std::vector<std::uint8_t>& pushed) {
    result_.report.flowing = !exact_;
    result_.one_piece = exact_;
    const IslandEnergy energy(state_, island_, true, from_ + 0.5 * h_);
    if (!exact_ && (!island_.joints.empty() || may_be_given_energy(state_, island_)))
      energy.bound(state_, island_, h_, after);
    if (varying_) take_drag_of_impulses(state_, island_, h_, before, after, *damping_);
    std::vector<PathEnd> start;
    if (state_.observe.paths) {
      start = path_ends(state_, island_.bodies);
      for (std::size_t k = 0; k < start.size(); ++k) {
        if (pushed[k]) start[k].v = after[k];
      }
    }
    // Where the step is made again, nothing has to move before.
    result_.unmoved = foresee(before, after, pushed);
    if (!result_.unmoved) {
      advance(before, after, pushed);
      if (!exact_ || island_.joints.empty()) turn_by_forces(state_, island_, h_, *start_);
      take_overlaps_out(state_, island_, from_, from_ + h_, exact_, limit_, result_);
      if (far_) put_before_walls(state_, island_, *start_, from_, from_ + h_, result_);
      StageTimer timer(state_, result_, Stage::Apply);
      energy.take_gain(state_, island_, h_, brought_);
      if (state_.observe.paths) record_hermite(state_, island_.bodies, from_, h_, start, result_);
    }
    ++result_.substeps;
  }

  /// Points whose gap would close within the step if nothing acted, or nearly so, or as the last round moved
  /// them; for an exact answer all near ones, which are the same from step to step. In flow the deepest
  /// overlap at the beginning of the step is noted.
  void choose_points(std::vector<std::uint8_t>& points) {
    points.assign(island_.contacts.size(), 0);
    std::atomic<double> deepest = 0;
    share(state_.island_threads, points.size(), kItemsAPiece, [&](std::size_t from, std::size_t to) {
      double least = 0;
      for (std::size_t k = from; k < to; ++k) points[k] = near_points(island_.contacts[k], least);
      raise_to(deepest, -least);
    });
    if (!exact_ && from_ == 0) result_.overlap = std::max(result_.overlap, deepest.load());
  }

  /// The points of one contact, a bit each. @param least  becomes the least separation, where it is less
  std::uint8_t near_points(std::uint32_t index, double& least) const {
    const Contact& contact = state_.contacts[index];
    const Vec2 fall = h_ * (acceleration(contact.body_b) - acceleration(contact.body_a));
    const bool off_the_way = from_ == 0 && (is_rerouted(contact.body_a) || is_rerouted(contact.body_b));
    std::uint8_t points = 0;
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[i];
      least = std::min(least, point.separation);
      const Vec2 u = relative_velocity(state_, contact, point.position, from_) + fall;
      double end = point.separation + h_ * dot(contact.manifold.normal, u);
      if (off_the_way)
        end = std::min(
            end, point.separation + h_ * dot(contact.manifold.normal, on_the_way(contact, point.position)));
      const double nearest = exact_ ? std::min(end, point.separation) : end;
      if (nearest <= state_.config.contact_margin) points |= 1u << i;
    }
    return points;
  }

  bool is_rerouted(std::uint32_t body) const {
    return body != BodyId::kNone && state_.local_index[body] >= 0 && state_.rerouted[body] != 0;
  }

  /// Velocity of b against a at a point where both go their ways.
  Vec2 on_the_way(const Contact& contact, Vec2 where) const {
    const auto velocity = [&](std::uint32_t body) {
      if (body == BodyId::kNone || state_.local_index[body] < 0)
        return point_velocity(state_, body, where, from_);
      const Way& way = state_.way[body];
      return way.v + h_ * way.a + (way.omega + h_ * way.alpha) * perp(where - state_.bodies.position[body]);
    };
    return velocity(contact.body_b) - velocity(contact.body_a);
  }

  Vec2 acceleration(std::uint32_t body) const {
    return body != BodyId::kNone && state_.local_index[body] >= 0 ? state_.acceleration[body] : Vec2{};
  }

  /// What an exact answer may cost where what goes without one flows.
  double exact_work() const {
    const double left = is_small(state_, island_) ? work_left_of_all(state_, result_) : 0;
    return left > 0 ? std::min(exact_limit_, left) : exact_limit_;
  }

  /// Velocities at the end of the step, and which bodies an impulse acted on. @return whether they are as
  /// good as asked for
  bool solve(const std::vector<Velocity>& before, std::vector<Velocity>& after,
             std::vector<std::uint8_t>& pushed) {
    pushed.assign(before.size(), 0);
    Spare<std::vector<std::uint8_t>> points;
    Spare<Assembly> spare;
    std::optional<Spare<MoreRows>> more;
    Spare<std::vector<double>> warm;
    choose_points(*points);
    set_up(*points, before, after, *spare, *warm);
    SolveOptions options = state_.config.solve;
    options.work_limit = !exact_            ? velocity_work(spare->system)
                         : may_flow(state_) ? exact_work()
                                            : work_left(state_, result_);
    options.trace = state_.observe.systems && state_.observe.solve_traces;
    options.threads = state_.island_threads;
    const auto answer = [&] {
      return exact_ ? solve_exactly(spare->system, *warm, options)
                    : solve_in_flow(*points, before, after, *spare, more, *warm, options);
    };
    Solution solution = answer();
    // What bounces goes its new way for all of the piece, through whatever nobody foresaw there.
    const bool strays = bounced_ && exact_ && meets_more(spare->system, solution.lambda, after, *points);
    const auto all_rows = [&]() -> const Assembly& { return more ? **more : *spare; };
    if (strays || (bounced_ && gains_energy(all_rows(), solution.lambda, after))) {
      // What is squeezed does not bounce.
      bounces_ = false;
      more.reset();
      if (!strays) choose_points(*points);
      set_up(*points, before, after, *spare, *warm);
      const SolveWork bouncing = solution.work;
      give_spare(std::move(solution.lambda));
      solution = answer();
      solution.work += bouncing;
    }
    const Assembly& assembly = all_rows();
    const IslandSystem& system = assembly.system;
    result_.work += solution.work;
    if (exact_ && solution.status != SolveStatus::Solved && solution.residual > kAlmost) {
      if (!nearly_ || solution.residual > kNearly) return false;
      exact_ = false;
    }
    store(assembly, solution.lambda, before, [&] {
      apply_impulses(system, solution.lambda, after);
      for (std::size_t i = 0; i < solution.lambda.size(); ++i) {
        if (solution.lambda[i] == 0 || assembly.origin[i].joint) continue;
        if (system.rows[i].a >= 0) pushed[static_cast<std::size_t>(system.rows[i].a)] = 1;
        if (system.rows[i].b >= 0) pushed[static_cast<std::size_t>(system.rows[i].b)] = 1;
      }
    });
    if (island_.joints.empty()) {
      brought_ = most_of_drive(state_, assembly, solution.lambda, from_, h_);
    } else {
      keep_spin(before, after);
      bind_jointed(state_, island_, h_, pushed, *lag_);
    }
    note_status(result_, solution.status, solution.residual);
    result_.report.method = solution.method;
    result_.report.iterations = solution.iterations;
    result_.report.rows = system.size();
    if (state_.observe.systems) {
      keep_trace(state_, island_, from_, system, solution.lambda, solution.status, solution.method,
                 solution.residual, false, std::move(solution.trace), result_);
    }
    give_spare(std::move(solution.lambda));
    return true;
  }

  /// What sweeps of velocities may cost [visits].
  double velocity_work(const IslandSystem& system) const {
    const double least = state_.config.flow_work ? 0 : work_of_sweeps(system, kLeastSweeps);
    return std::max(std::min(kVelocityShare * limit_, work_of_sweeps(system, most_sweeps_)), least);
  }

  /// Rows of the chosen points, what they want, and the impulses of the last step.
  /// @param after  set to the velocities of free motion
  void set_up(const std::vector<std::uint8_t>& points, const std::vector<Velocity>& before,
              std::vector<Velocity>& after, Assembly& assembly, std::vector<double>& warm) {
    StageTimer timer(state_, result_, Stage::Assemble);
    after = before;
    add_free_motion(state_, island_, h_, after);
    AssemblyRequest request;
    request.points = &points;
    request.friction = true;
    request.elapsed = from_;
    request.actuators = AssemblyRequest::Actuators::All;
    request.rope_slack = state_.config.contact_margin;
    request.velocities = &after;
    request.ahead = h_;
    assemble(state_, island_, request, assembly);
    IslandSystem& system = assembly.system;
    if (varying_) damp(system, *damping_);
    warm.resize(system.rows.size());
    aim_joints(state_, from_, h_, after, assembly, warm);
    if (!exact_) steady_hinges(state_, h_, warm, assembly);
    const double slides = kSlides * slow_;
    share_each(state_.island_threads, system.rows.size(), kItemsAPiece, [&](std::size_t i) {
      const RowOrigin& origin = assembly.origin[i];
      if (origin.joint) return;
      const Contact& contact = state_.contacts[origin.index];
      const double target =
          origin.kind == RowKind::Normal ? least_speed(assembly, i, contact, before, after) : 0;
      system.b[i] = target - row_velocity(assembly, static_cast<int>(i), after);
      warm[i] = last_impulse(contact, origin, h_);
      if (origin.kind != RowKind::Friction || !(contact.static_friction > contact.friction)) return;
      // What its load turns about is at rest in between.
      const double from = row_velocity(assembly, static_cast<int>(i), before);
      if (from * system.b[i] > 0 || (contact.points[origin.point].sticking && std::abs(from) <= slides))
        system.rows[i].mu = contact.static_friction;
    });
  }

  /// A joint that is open pulls two bodies at two points, and so turns them: an island that nothing else
  /// pushed has the angular momentum that it had.
  void keep_spin(const std::vector<Velocity>& before, std::vector<Velocity>& after) const {
    if (exact_ || !is_unpushed(state_, island_)) return;
    Spare<std::vector<Velocity>> free;
    *free = before;
    add_free_motion(state_, island_, h_, *free);
    store_velocities(state_, island_, *free);
    const double momentum = rigid_motion(state_, island_).momentum;
    store_velocities(state_, island_, after);
    give_spin(state_, island_, momentum - rigid_motion(state_, island_).momentum);
    island_velocities(state_, island_, after);
    store_velocities(state_, island_, before);
  }

  /// Velocity [m/s] that a normal row has to reach: the gap closes at the end of the step at the earliest,
  /// but what lands within it, faster than resting contacts are shaken, bounces. In flow that goes up from
  /// where the step begins, and through all of it: as fast as it takes to get as high as from below.
  /// @param free  velocities at the end of the step without contact forces
  double least_speed(const Assembly& assembly, std::size_t row, const Contact& contact,
                     const std::vector<Velocity>& before, const std::vector<Velocity>& free) const {
    const ManifoldPoint& point =
        contact.manifold.points[static_cast<std::size_t>(assembly.origin[row].point)];
    // Which of several contacts carries is not for gaps of rounding to decide.
    const double gap = exact_ && is_touching(state_, point) ? 0 : std::max(0.0, point.separation);
    const double approach =
        contact.restitution > 0 ? -row_velocity(assembly, static_cast<int>(row), before) : 0;
    if (!bounces_ || !(approach > slow_ && gap < h_ * approach)) return -gap / h_;
    bounced_.store(true, std::memory_order_relaxed);
    if (exact_) return contact.restitution * approach;
    const double e = contact.restitution,
                 weight = std::max(0.0, -row_velocity(assembly, static_cast<int>(row), free) - approach),
                 fall = 2 * weight * gap / h_;
    const double square = weight * weight + e * e * (approach * approach + fall) - fall;
    return std::max(-gap / h_, std::sqrt(std::max(0.0, square)) - weight);
  }

  /// True if impulses leave more energy than the free motion `free` has and ground that moves brings. Those
  /// of Coulomb's law without bounces take some, or nothing; where several bounce at once, one of them may be
  /// driven by the others.
  bool gains_energy(const Assembly& rows, const std::vector<double>& lambda,
                    const std::vector<Velocity>& free) const {
    const bool given = may_be_given_energy(state_, island_);
    if (given && !island_.joints.empty()) return false;
    Spare<std::vector<Velocity>> after;
    *after = free;
    apply_impulses(rows.system, lambda, *after);
    const double most = exact_ ? kRoundedGain : kWildGain;
    const double brought = given ? most_of_drive(state_, rows, lambda, from_, h_) : 0;
    return impact::kinetic_energy(rows.system, *after) - brought >
           most * impact::kinetic_energy(rows.system, free);
  }

  Solution solve_exactly(const IslandSystem& system, std::span<const double> warm,
                         const SolveOptions& options) {
    StageTimer timer(state_, result_, Stage::Solve);
    MemoryLoan memory(state_, result_, SolvePurpose::Forces, system);
    Solution solution = state_.solver->solve(system, warm, options, memory.get());
    return solution;
  }

  /// What is struck runs into bodies that its own motion would not have met: their points join the rest of
  /// the sweeps. @param more  becomes the rows with theirs, if there are any
  Solution solve_in_flow(std::vector<std::uint8_t>& points, const std::vector<Velocity>& before,
                         std::vector<Velocity>& after, Assembly& assembly,
                         std::optional<Spare<MoreRows>>& more, std::vector<double>& warm,
                         SolveOptions options) {
    bool missed = false;
    const auto look = [&](const std::vector<double>& lambda) {
      missed = meets_more(assembly.system, lambda, after, points);
      return missed;
    };
    double astray = kInfinity;
    if (state_.solver->fixed_work && look(warm)) {
      // Rows that join later would want all of its sweeps again: it begins with what the impulses of the last
      // step push on, and far from an answer none join.
      astray = kAstray;
      missed = false;
      set_up(points, before, after, assembly, warm);
    }
    Solution first;
    {
      StageTimer timer(state_, result_, Stage::Solve);
      first = sweep_velocities(assembly.system, warm, options, astray, look);
    }
    if (!missed) return first;
    Assembly& all = *more.emplace();
    set_up(points, before, after, all, warm);
    keep_known(assembly, first.lambda, all, warm);
    options.work_limit =
        std::max(options.work_limit - first.work.visits, (1 - kFirstShare) * options.work_limit);
    StageTimer timer(state_, result_, Stage::Solve);
    Solution rest = sweep_velocities(all.system, warm, options, kInfinity, look_at_nothing);
    rest.work += first.work;
    rest.iterations += first.iterations;
    if (first.trace && rest.trace) {
      *first.trace += *rest.trace;
      rest.trace = std::move(first.trace);
    }
    give_spare(std::move(first.lambda));
    return rest;
  }

  /// Chooses points that end deep with these impulses, too. @return whether there are any
  bool meets_more(const IslandSystem& system, const std::vector<double>& lambda,
                  const std::vector<Velocity>& free, std::vector<std::uint8_t>& points) const {
    Spare<std::vector<Velocity>> then;
    *then = free;
    apply_impulses(system, lambda, *then);
    return add_missed(*then, points);
  }

  /// Chooses points that end deep with these velocities. @return whether there are any
  bool add_missed(const std::vector<Velocity>& after, std::vector<std::uint8_t>& points) const {
    const auto moves = [&](std::uint32_t body, Vec2 where) {
      const int k = body == BodyId::kNone ? -1 : state_.local_index[body];
      if (k < 0) return h_ * point_velocity(state_, body, where, from_);
      const Velocity& v = after[static_cast<std::size_t>(k)];
      return h_ * (Vec2{v[0], v[1]} + v[2] * perp(where - state_.bodies.position[body]));
    };
    const bool beside_joints = !island_.joints.empty() && !works_finely(state_, island_);
    return add_deep_points(state_, island_, beside_joints ? kMissedBesideJoints : kMissed, moves, points);
  }

  /// Velocities by the world's own solver where it is a preview; else by sweeps.
  /// @param astray  residual beyond which the answer of a preview is not looked at
  /// @param look  is shown the impulses once, when `kFirstShare` of the work is done, or all of it (a
  /// preview), and says whether to stop there
  template <class Look>
  Solution sweep_velocities(const IslandSystem& system, std::span<const double> warm,
                            const SolveOptions& options, double astray, Look&& look) const {
    if (state_.solver->exact) return sweep_until_done(system, true, warm, options, {}, look, sweep_end_);
    Solution solution = state_.solver->solve(system, warm, options, nullptr);
    if (!(solution.residual > astray)) look(solution.lambda);
    return solution;
  }

  /// Impulses for the report and for the next step. Rows are in the order of the contacts, whose memory is
  /// gone through once. @param meanwhile  is called while other threads do that
  template <class Meanwhile>
  void store(const Assembly& assembly, const std::vector<double>& lambda, const std::vector<Velocity>& before,
             Meanwhile&& meanwhile) {
    store_joint_impulses(state_, island_, assembly, lambda, h_);
    // In flow what is slow, or carried load before, does not land.
    const PieceAnswer answer{assembly, lambda, before, from_, h_, exact_ ? state_.config.rest_speed : slow_,
                             exact_};
    std::atomic<int> landings = 0, rubbing = 0;
    share_beside(
        state_.island_threads, island_.contacts.size(), kItemsAPiece,
        [&](std::size_t from, std::size_t to) {
          const StoredRows rows = store_contacts(state_, island_, answer, from, to);
          landings += rows.landings;
          rubbing += rows.friction;
        },
        meanwhile);
    result_.friction_rows += rubbing;
    // An exact answer is one impact, as if the contacts were one.
    result_.impacts += exact_ ? std::min<int>(landings, 1) : landings.load();
  }

  /// Notes how far everything will go. @return whether a body will go so much farther than foreseen that the
  /// world has to make the step again
  bool foresee(const std::vector<Velocity>& before, const std::vector<Velocity>& after,
               const std::vector<std::uint8_t>& pushed) {
    std::atomic<bool> leaves = false, far = false;
    share_each(state_.island_threads, after.size(), kItemsAPiece, [&](std::size_t k) {
      const std::uint32_t body = island_.bodies[k];
      const double way = length_of_shift(state_, body, shift_of(k, before, after, pushed));
      note_way(state_, body, way, !exact_);
      if (may_pass_walls(state_, body, way)) far.store(true, std::memory_order_relaxed);
      stray(k, before, after, pushed);
      if (left_its_reach(state_, body)) leaves.store(true, std::memory_order_relaxed);
    });
    far_ = far;
    // Where a whole step goes straight on, the world can tell afterwards what it met.
    if (!leaves || !(exact_ || from_ > 0)) return false;
    // It is not to be made again for each piece that follows.
    for (std::size_t k = 0; more_pieces_ > 0 && k < after.size(); ++k) {
      const std::uint32_t body = island_.bodies[k];
      const Velocity shift = shift_of(k, before, after, pushed);
      note_way(state_, body, more_pieces_ * length_of_shift(state_, body, shift), !exact_);
      stray(k, before, after, pushed, more_pieces_);
    }
    return true;
  }

  void advance(const std::vector<Velocity>& before, const std::vector<Velocity>& after,
               const std::vector<std::uint8_t>& pushed) {
    StageTimer timer(state_, result_, Stage::Apply);
    BodyArrays& all = state_.bodies;
    start_->resize(after.size());
    share_each(state_.island_threads, after.size(), kItemsAPiece, [&](std::size_t k) {
      const std::uint32_t body = island_.bodies[k];
      (*start_)[k] = all.pose(body);
      all.velocity[body] = {after[k][0], after[k][1]};
      all.omega[body] = after[k][2];
      shift_body(state_, body, shift_of(k, before, after, pushed));
    });
  }

  Velocity shift_of(std::size_t k, const std::vector<Velocity>& before, const std::vector<Velocity>& after,
                    const std::vector<std::uint8_t>& pushed) const {
    Velocity shift;
    for (std::size_t c = 0; c < 3; ++c)
      shift[c] = h_ * (pushed[k] ? after[k][c] : 0.5 * (before[k][c] + after[k][c]));
    if (!island_.joints.empty()) {
      shift[0] -= (*lag_)[k].x;
      shift[1] -= (*lag_)[k].y;
    }
    return shift;
  }

  /// A body that an impulse acted on goes straight on with its new velocity; one that none did flies on, off
  /// its way if it was struck earlier in the step.
  /// @param pieces  how many like this one
  void stray(std::size_t k, const std::vector<Velocity>& before, const std::vector<Velocity>& after,
             const std::vector<std::uint8_t>& pushed, double pieces = 1) {
    if (!pushed[k] && from_ == 0) return;
    const std::uint32_t body = island_.bodies[k];
    const Velocity& first = pushed[k] ? after[k] : before[k];
    const double way =
        pieces * h_ *
        std::max(speed_astray(state_, body, first, from_), speed_astray(state_, body, after[k], from_ + h_));
    note_way_astray(state_, body, way, !exact_);
  }

  WorldState& state_;
  const Island& island_;
  double from_, h_;
  bool exact_;   ///< no flow
  bool nearly_;  ///< what is nearly exact serves, too: then the island flows
  bool varying_;
  bool bounces_ = true;                        ///< what lands fast enough does
  mutable std::atomic<bool> bounced_ = false;  ///< something did
  double more_pieces_;
  IslandResult& result_;
  double slow_ = 0;                 ///< what approaches no faster is shaken by the forces of a step [m/s]
  double exact_limit_ = 0;          ///< work for an exact answer
  double limit_ = 0;                ///< work of the step in flow
  double most_sweeps_ = kInfinity;  ///< over velocities
  SweepEnd sweep_end_;              ///< of those of velocities
  Spare<std::vector<Vec2>> lag_;    ///< by body of islands with joints: see `bind_jointed`
  std::optional<double> brought_;   ///< the most that ground brings [J], without joints
  bool far_ = false;                ///< a body goes so far that it may pass a wall
  Spare<std::vector<Transform>> start_;      ///< by body, where the piece began
  Spare<std::vector<InverseMass>> damping_;  ///< by body, where forces depend on the state: `take_forces`
};

/// Exact pieces know the points that touch alone; what flow left carries load across small gaps, too, and
/// sweeps from nothing let a heap fall for a step. Where most of a step is made in one piece after them it
/// begins with what carried in the last step.
void recall_last_step(WorldState& state, const Island& island, double from, double to) {
  constexpr double kMost = 0.5;
  if (!(from > 0 && from < kMost * to)) return;
  share_each(state.island_threads, island.contacts.size(), kItemsAPiece,
             [&](std::size_t k) { recall_impulses(state.contacts[island.contacts[k]]); });
}

bool make_step(WorldState& state, const Island& island, double from, double to, OnePieceStep::Answer answer,
               IslandResult& result) {
  const double before = result.work.visits;
  recall_last_step(state, island, from, to);
  const bool made = OnePieceStep(state, island, from, to, answer, result).run();
  if (result.work_limit > 0) result.work_limit += result.work.visits - before;
  return made;
}

}  // namespace

void step_island_in_flow(WorldState& state, const Island& island, double from, double to,
                         IslandResult& result, double more) {
  recall_last_step(state, island, from, to);
  // Loads that rise meanwhile cut what is left of the step again.
  double made = 0;
  for (double at = from; at < to; ++made) {
    const bool few = result.report.residual > kContradicted ||
                     result.work.visits + result.thrown_away.visits > kWorkOfPieces;
    const auto wanted = [&](double stable, double most) {
      return std::ceil(std::clamp((to - at) / stable, 1.0, std::max(1.0, (few ? kFewPieces : most) - made)));
    };
    double pieces = wanted(kRodSwing * stable_length_of_rods(state, island), kMostPieces);
    if (is_small(state, island)) {
      const double stable = kHingeSwing * stable_length(state, island, (to - at) / kHingeSwing);
      pieces = std::max(pieces, wanted(stable, kMostForHinges));
    }
    const double end = pieces > 1 ? at + (to - at) / pieces : to;
    const double work = state.config.flow_work ? more / pieces : more;
    OnePieceStep(state, island, at, end, OnePieceStep::Answer::Swept, result, work, pieces - 1).run();
    ++result.flow_pieces;
    if (result.unmoved) break;
    at = end;
  }
  result.step_memory.flow = std::max(result.step_memory.flow, 1);
  for (const std::uint32_t i : island.bodies) {
    const int flow = state.step_memory[i].flow;
    if (flow != kMustFlow) result.step_memory.flow = std::max(result.step_memory.flow, flow);
  }
}

bool step_island_exactly(WorldState& state, const Island& island, double from, double to,
                         IslandResult& result) {
  return make_step(state, island, from, to, OnePieceStep::Answer::NearlyExact, result);
}

bool step_island_lightly(WorldState& state, const Island& island, double h, IslandResult& result) {
  StepMemory& memory = result.step_memory;
  if (memory.light_wait > 0) {
    --memory.light_wait;
    return false;
  }
  const bool made = make_step(state, island, 0, h, OnePieceStep::Answer::Exact, result);
  if (made && result.report.status == SolveStatus::Solved) {
    memory.light_failures = 0;
    return true;
  }
  wait_after_failure(state, island, memory);
  // What came almost there may well do so with the next step.
  if (made) --memory.light_wait;
  return made;
}

}  // namespace skerry
