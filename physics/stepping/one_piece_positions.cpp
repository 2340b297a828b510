// SPDX-License-Identifier: MIT
#include "physics/stepping/one_piece_positions.h"

#include <algorithm>
#include <atomic>
#include <optional>

#include "physics/spare.h"
#include "physics/stepping/deep_points.h"
#include "physics/stepping/flow_work.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/one_piece_joints.h"
#include "physics/stepping/one_piece_sweeps.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/squeezed.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Overlaps below these shares of the smaller body stay: in flow, and where all is exact.
constexpr double kOverlapFloor = 1e-7, kFineOverlapFloor = 1e-9;
// How far a shift may move a jointed body, as a share of its size.
constexpr double kFarthestShift = 0.5;
// In flow joints that are off by this share of a body's size are closed before all else, and there is a
// second round where they still are: shifts are straight lines. Where contacts of uneven masses were, there
// are more, as long as there is work left, or up to so many visits, which take some milliseconds.
constexpr double kTorn = 0.05, kDeep = 0.05, kSmallWork = 8e5;
constexpr int kFlowSeparations = 2, kDeepSeparations = 4;
// How deep points may be pushed that are not among the rows, as a share of the smaller body. Where there is
// much work, what is shifted farther than a share of its radius, by which straight lines bend, is looked at
// once more.
constexpr double kPushedInto = 0.05, kFinelyPushedInto = 1e-5, kBends = 0.003;
constexpr int kFineSeparations = 2;
// Sweeps that leave more than this of the overlaps have not found out where bodies can go to: in a deep crush
// each is pushed out of its neighbours and into the next ones, and so is less of it, in proportion.
constexpr double kAmiss = 0.2;
// Shift, as a share of a body's radius, from which on its manifolds are made anew.
constexpr double kFar = 0.05;
// Masses that differ by more than this count as equal where bodies in flow are pushed out of each other.
constexpr double kUneven = 100;
// Rounds of taking them out where all is exact: corners that turn do not go along straight lines.
constexpr int kSeparations = 8;
// Contacts or rows that a thread takes at a time.
constexpr std::size_t kItemsAPiece = 256;

/// Rows for positions, without friction. They have their own spare memory: rows are written over those that
/// are there, and a list that changes its length costs as much as its rows.
struct PositionRows : Assembly {};
/// The same with those of points that others are pushed into.
struct MorePositionRows : Assembly {};

class OnePiecePositions {
 public:
  OnePiecePositions(WorldState& state, const Island& island, double from, double to, bool exact, double work,
                    IslandResult& result)
      : state_(state), island_(island), to_(to), h_(to - from), exact_(exact), work_(work), result_(result) {}

  void run() {
    int round = 0;
    // Joints hold to rounding where all is exact.
    const bool rigid = exact_ && !island_.joints.empty();
    if (!exact_) mend_joints(state_, island_, to_, kTorn);
    do {
      StageTimer timer(state_, result_, Stage::Narrow);
      result_.manifolds_reused += update_manifolds(state_, island_, to_, result_.narrow);
    } while (!rigid && separate() && goes_on(++round));
    // Manifolds do not follow what was shifted far: what they say of who touches would be wrong. Beside
    // joints the next step's forces begin elsewhere then, and of 260 random mechanisms two threw a body off
    // at 130 m/s.
    if (!exact_ && island_.joints.empty() && farthest_ > kFar) {
      StageTimer timer(state_, result_, Stage::Narrow);
      result_.manifolds_reused += update_manifolds(state_, *shifted_, to_, result_.narrow);
    }
    if (!rigid) return;
    StageTimer timer(state_, result_, Stage::Apply);
    Spare<PositionRows> rows;
    project_positions(state_, island_, to_, result_, *rows);
  }

 private:
  bool goes_on(int round) const {
    if (exact_) return round < kSeparations;
    const bool has_work =
        uneven_ && state_.solver->exact && result_.work.visits < std::max(work_, kSmallWork);
    if (deep_ && round < kDeepSeparations && has_work) return true;
    if (works_finely() && island_.joints.empty() && farthest_ > kBends && round < kFineSeparations)
      return true;
    return round < kFlowSeparations && joints_are_off(state_, island_, to_, kTorn);
  }

  /// The world does, or heavy bodies among light ones have as much work.
  bool works_finely() const {
    return skerry::works_finely(state_, island_) ||
           (uneven_ && island_.joints.empty() &&
            work_ >= kFineWork * static_cast<double>(island_.bodies.size()));
  }

  /// Takes overlaps out of the positions: the smallest shift, in the norm of the masses (see `even_out`),
  /// with J shift >= -separation. @return whether there were any
  bool separate() {
    StageTimer timer(state_, result_, Stage::Apply);
    Spare<std::vector<std::uint8_t>> points;
    points->assign(island_.contacts.size(), 0);
    std::atomic<bool> any = !island_.joints.empty(), deep = false;
    share_each(state_.island_threads, points->size(), kItemsAPiece, [&](std::size_t k) {
      const Contact& contact = state_.contacts[island_.contacts[k]];
      const double size =
          std::min(size_in_island(state_, contact.body_a), size_in_island(state_, contact.body_b));
      const double floor = (exact_ ? kFineOverlapFloor : kOverlapFloor) * size;
      for (int i = 0; i < contact.manifold.count; ++i) {
        const double separation = contact.manifold.points[i].separation;
        if (separation > state_.config.contact_margin) continue;
        (*points)[k] |= 1u << i;
        if (separation < -floor) any.store(true, std::memory_order_relaxed);
        if (separation < -kDeep * size) deep.store(true, std::memory_order_relaxed);
      }
    });
    deep_ = deep;
    farthest_ = 0;
    if (!any) return false;
    Spare<PositionRows> spare;
    std::optional<Spare<MorePositionRows>> more;
    set_up(*points, *spare);
    SolveOptions options;
    options.tolerance = 1e-4;
    options.welds_as_one = state_.config.solve.welds_as_one;
    options.threads = state_.island_threads;
    // A preview saves what is left.
    options.work_limit = (1 - kVelocityShare) * work_;
    if (state_.solver->exact && island_.joints.empty())
      options.work_limit = std::max(options.work_limit, work_ - result_.work.visits);
    if (!state_.config.flow_work)
      options.work_limit = std::max(options.work_limit, work_of_sweeps(spare->system, kLeastShiftSweeps));
    Solution solution = find_shift(*points, *spare, more, options);
    result_.work += solution.work;
    const bool crushed = !exact_ && island_.joints.empty() && solution.residual > kAmiss;
    if (crushed) {
      for (double& impulse : solution.lambda) impulse *= kAmiss / solution.residual;
    }
    const Assembly& assembly = more ? static_cast<Assembly&>(**more) : *spare;
    const IslandSystem& system = assembly.system;
    std::vector<Velocity> shift = take_spare<std::vector<Velocity>>();
    Spare<std::vector<double>> most;
    share(state_.island_threads, 2, 1, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        if (i == 0) {
          shift.assign(island_.bodies.size(), Velocity{});
          apply_impulses(system, solution.lambda, shift);
        } else {
          find_limits(assembly, *most);
        }
      }
    });
    const bool free = is_off_ground(state_, island_);
    if (crushed) step_aside(state_, assembly, shift);
    limit_shift(*most, shift);
    if (free) keep_centre(shift);
    // Moving bodies changes their angular momentum; a free island gets it back as a common rotation.
    const double momentum = free ? rigid_motion(state_, island_).momentum : 0;
    std::atomic<double> farthest = 0;
    far_->assign(shift.size(), 0);
    share_each(state_.island_threads, shift.size(), kItemsAPiece, [&](std::size_t k) {
      const std::uint32_t body = island_.bodies[k];
      const double way = length_of_shift(state_, body, shift[k]);
      raise_to(farthest, way / state_.radius[body]);
      (*far_)[k] = way > kFar * state_.radius[body];
      shift_body(state_, body, shift[k]);
      if (uneven_ && !exact_ && !free && island_.joints.empty()) lose_what_was_taken_back(body, shift[k]);
      note_way(state_, body, way, !exact_);
      note_way_astray(state_, body, way, !exact_);
    });
    farthest_ = farthest;
    if (free) give_spin(state_, island_, momentum - rigid_motion(state_, island_).momentum);
    follow(assembly, shift);
    if (!exact_ && island_.joints.empty()) note_shifted(assembly);
    give_spare(std::move(shift));
    give_spare(std::move(solution.lambda));
    return true;
  }

  /// Rows of the chosen points, and what they want.
  void set_up(const std::vector<std::uint8_t>& points, Assembly& assembly) {
    AssemblyRequest request;
    request.points = &points;
    request.rope_slack = state_.config.contact_margin;
    request.elapsed = to_;
    assemble(state_, island_, request, assembly);
    IslandSystem& system = assembly.system;
    share_each(state_.island_threads, system.b.size(), kItemsAPiece,
               [&](std::size_t i) { system.b[i] = -assembly.origin[i].error; });
    uneven_ = even_out(system.bodies);
  }

  /// What is pushed out of one body may be pushed into another: the points where that happens join the rest
  /// of the sweeps. @param more  becomes the rows with theirs, if there are any
  Solution find_shift(std::vector<std::uint8_t>& points, Assembly& assembly,
                      std::optional<Spare<MorePositionRows>>& more, SolveOptions options) {
    const bool standard = state_.solver->exact;
    const Give give = island_.joints.empty() ? Give{} : kShiftGive;
    if (exact_) return sweep_until_done(assembly.system, standard, {}, options, give, look_at_nothing);
    bool missed = false;
    const auto look = [&](const std::vector<double>& lambda) {
      Spare<std::vector<Velocity>> shift;
      shift->assign(island_.bodies.size(), Velocity{});
      apply_impulses(assembly.system, lambda, *shift);
      missed = add_missed(*shift, points);
      return missed;
    };
    Solution first = sweep_until_done(assembly.system, standard, {}, options, give, look);
    if (!missed) return first;
    Assembly& all = *more.emplace();
    set_up(points, all);
    Spare<std::vector<double>> warm;
    keep_known(assembly, first.lambda, all, *warm);
    options.work_limit =
        std::max(options.work_limit - first.work.visits, (1 - kFirstShare) * options.work_limit);
    Solution rest = sweep_until_done(all.system, standard, *warm, options, give, look_at_nothing);
    rest.work += first.work;
    give_spare(std::move(first.lambda));
    return rest;
  }

  /// Chooses points that are pushed deep by these shifts. @return whether there are any
  bool add_missed(const std::vector<Velocity>& shift, std::vector<std::uint8_t>& points) const {
    const auto moves = [&](std::uint32_t body, Vec2 where) {
      const int k = body == BodyId::kNone ? -1 : state_.local_index[body];
      if (k < 0) return Vec2{};
      const Velocity& s = shift[static_cast<std::size_t>(k)];
      return Vec2{s[0], s[1]} + s[2] * perp(where - state_.bodies.position[body]);
    };
    return add_deep_points(state_, island_, works_finely() ? kFinelyPushedInto : kPushedInto, moves, points);
  }

  /// Positions carry no momentum. In the norm of the masses what is light between heavy bodies is shifted far
  /// to the side, by more than holds along straight lines, before those give way a little, and sweeps take
  /// thousands for it.
  static bool even_out(std::vector<InverseMass>& bodies) {
    double least = kInfinity, most = 0;
    for (const InverseMass& body : bodies) {
      least = std::min(least, body.linear);
      most = std::max(most, body.linear);
    }
    if (!(most > kUneven * least) || !(least > 0)) return false;
    for (InverseMass& body : bodies) {
      body.angular *= most / body.linear;
      body.linear = most;
    }
    return true;
  }

  /// How far each body may be shifted: jointed ones no farther than half their size; others than what the
  /// next step finds, or than they overlap themselves.
  void find_limits(const Assembly& assembly, std::vector<double>& most) const {
    for (const std::uint32_t body : island_.bodies)
      most.push_back(island_.joints.empty() ? room_of(body) : kFarthestShift * state_.radius[body]);
    for (int i = 0; island_.joints.empty() && i < assembly.system.size(); ++i) {
      for (const int k : {assembly.system.rows[i].a, assembly.system.rows[i].b}) {
        if (k < 0) continue;
        double& own = most[static_cast<std::size_t>(k)];
        own = std::max(own, -assembly.origin[i].error);
      }
    }
  }

  /// What is passed on beyond the limits comes in later steps. Sweeps that have not come to an answer push on
  /// what lands in others, and throw what is light between heavy bodies out of the world.
  void limit_shift(const std::vector<double>& most, std::vector<Velocity>& shift) const {
    for (std::size_t k = 0; k < shift.size(); ++k) {
      const double way = length_of_shift(state_, island_.bodies[k], shift[k]);
      if (!(way > most[k])) continue;
      for (double& x : shift[k]) x *= most[k] / way;
    }
  }

  /// Where a body is pushed back from, it should not have gone: it loses the velocity that took it there.
  /// Sweeps that do not tell a heavy body that it lies on anything leave it the speed of its fall.
  void lose_what_was_taken_back(std::uint32_t body, const Velocity& shift) const {
    BodyArrays& all = state_.bodies;
    const double m = all.mass[body], inertia = all.inertia[body];
    const Vec2 s{shift[0], shift[1]};
    const double square = m * length_squared(s) + inertia * shift[2] * shift[2];
    const double product = m * dot(s, all.velocity[body]) + inertia * shift[2] * all.omega[body];
    if (!(product < 0)) return;
    const double share = std::min(-product / square, 1 / h_);
    all.velocity[body] += share * s;
    all.omega[body] += share * shift[2];
  }

  /// The centre of mass of a free island stays where it is.
  void keep_centre(std::vector<Velocity>& shift) const {
    Vec2 moment;
    double mass = 0;
    for (std::size_t k = 0; k < shift.size(); ++k) {
      const double own = state_.bodies.mass[island_.bodies[k]];
      mass += own;
      moment += own * Vec2{shift[k][0], shift[k][1]};
    }
    if (!(mass > 0)) return;
    for (Velocity& one : shift) {
      one[0] -= moment.x / mass;
      one[1] -= moment.y / mass;
    }
  }

  /// How much farther a body can be moved so that the next step finds whom it met.
  double room_of(std::uint32_t body) const {
    double room = state_.reach[body] - state_.travelled[body];
    if (state_.flight[body] == FlightKind::Fast)
      room = std::min(room, state_.allowance[body] - state_.strayed[body]);
    return std::clamp(room, 0.0, state_.radius[body]) + overrun(state_, body);
  }

  /// Notes the contacts with points among the rows of bodies that were shifted far.
  void note_shifted(const Assembly& assembly) {
    shifted_->contacts.clear();
    if (!(farthest_ > kFar)) return;
    const auto is_far = [&](int body) { return body >= 0 && (*far_)[static_cast<std::size_t>(body)] != 0; };
    for (std::size_t i = 0; i < assembly.system.rows.size(); ++i) {
      const Row& row = assembly.system.rows[i];
      const RowOrigin& origin = assembly.origin[i];
      if (origin.joint || !(is_far(row.a) || is_far(row.b))) continue;
      std::vector<std::uint32_t>& noted = shifted_->contacts;
      if (noted.empty() || noted.back() != origin.index) noted.push_back(origin.index);
    }
  }

  /// The shifts are small: to first order the manifolds follow, and the next step makes them anew, also where
  /// a shift is below the rounding of a place.
  void follow(const Assembly& assembly, const std::vector<Velocity>& shift) {
    const std::vector<RowOrigin>& origins = assembly.origin;
    const auto are_of_one = [](const RowOrigin& a, const RowOrigin& b) {
      return !a.joint && !b.joint && a.index == b.index;
    };
    // The first row of a contact does the work of all.
    share_each(state_.island_threads, origins.size(), kItemsAPiece, [&](std::size_t first) {
      if (origins[first].joint || (first > 0 && are_of_one(origins[first - 1], origins[first]))) return;
      Contact& contact = state_.contacts[origins[first].index];
      for (std::size_t i = first; i < origins.size() && are_of_one(origins[first], origins[i]); ++i) {
        const Row& row = assembly.system.rows[i];
        double closer = 0;
        if (row.a >= 0) closer += along(row.Ja, shift[static_cast<std::size_t>(row.a)]);
        if (row.b >= 0) closer += along(row.Jb, shift[static_cast<std::size_t>(row.b)]);
        if (closer == 0) continue;
        contact.manifold.points[origins[i].point].separation += closer;
        forget_poses(contact);
      }
    });
  }

  WorldState& state_;
  const Island& island_;
  double to_, h_;
  bool exact_;
  double work_;
  IslandResult& result_;
  bool deep_ = false, uneven_ = false;  ///< overlaps of the last round, and masses
  double farthest_ = 0;                 ///< largest shift of the last round, as a share of the body's radius
  Spare<std::vector<std::uint8_t>> far_;  ///< by body: shifted far in the last round
  Spare<Island> shifted_;                 ///< contacts of those
};

}  // namespace

void take_overlaps_out(WorldState& state, const Island& island, double from, double to, bool exact,
                       double work, IslandResult& result) {
  OnePiecePositions(state, island, from, to, exact, work, result).run();
}

}  // namespace skerry
