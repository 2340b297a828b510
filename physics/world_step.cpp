// SPDX-License-Identifier: MIT
#include "physics/world_step.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "physics/share_islands.h"
#include "physics/spare.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/joint_limits.h"
#include "physics/text.h"
#include "physics/world_access.h"
#include "physics/world_report.h"

namespace skerry {
namespace {

// A body that can go farther than so many contact margins in a step is fast, unless its velocity alone does
// not take it as far as one.
constexpr double kFast = 4;

// A body in flow will be struck as hard as in the last step, or so many times as hard.
constexpr double kGuess = 2;

// Farther than this in one step [m] a body is lost: products of such lengths still fit a double.
constexpr double kFarthest = 1e100;

/// An empty report in the memory of the old one.
void clear(StepReport& report) {
  StepReport next;
  const auto keep = [](auto& from, auto& to) {
    from.clear();
    to = std::move(from);
  };
  keep(report.contacts_list, next.contacts_list);
  keep(report.islands_list, next.islands_list);
  keep(report.events, next.events);
  keep(report.motion_events, next.motion_events);
  keep(report.joint_events, next.joint_events);
  keep(report.containments, next.containments);
  keep(report.traces, next.traces);
  report = std::move(next);
}

}  // namespace

void Step::run() {
  begin();
  if (s_.active.empty() && s_.contacts.empty()) {
    refresh_links();
    s_.islands.clear();
    s_.graph_known = false;
  } else {
    for (;;) {
      find_pairs();
      link_contacts();
      if (is_through()) break;
      step_islands();
      if (!extend_reach()) break;
    }
  }
  finish();
}

void Step::undo() {
  BodyArrays& b = s_.bodies;
  if (begun_) saved_ = s_.active.size();
  const auto put_back = [&b](std::uint32_t i, const BodyBackup& from) {
    b.position[i] = from.position;
    b.angle[i] = from.angle;
    b.rotation[i] = from.rotation;
    b.velocity[i] = from.velocity;
    b.omega[i] = from.omega;
  };
  for (std::size_t k = 0; k < saved_; ++k) put_back(s_.active[k], s_.backup[s_.active[k]]);
  for (const auto& [body, from] : s_.scratch.before_motion) put_back(body, from);
  // What was touched before the step still is.
  for (const std::uint32_t i : s_.active) {
    s_.touched.push_back(i);
    s_.kept[i] = b.type[i] != BodyType::Dynamic;
    s_.ledger.mark(i);
  }
  for (JointStart& start : s_.joint_start) start.begun = 0;
  put_back_lost();
  forget_resting(s_);
  s_.graph_known = false;
}

void Step::book(Stage stage, Clock::time_point start) {
  if (!s_.observe.stage_times) return;
  s_.report.stage_seconds[static_cast<int>(stage)] +=
      std::chrono::duration<double>(Clock::now() - start).count();
}

/// The working set; accelerations, bounds on the motion, and what a second try needs.
void Step::begin() {
  const auto start = now();
  require_masses();
  clear(s_.report);
  s_.scratch.before_motion.clear();
  s_.scratch.distant.clear();
  s_.scratch.motion_breaks = s_.scratch.motion_jumps = false;
  std::sort(s_.displaced.begin(), s_.displaced.end());
  // Sleep holds for steps of one length, and an observer of the equations wants to see all of them.
  if (!s_.sleepers.none() && (s_.sleepers.h() != h_ || s_.observe.systems)) s_.sleepers.wake_all(s_);
  may_keep_ = h_ == s_.last_h && s_.config.reuse_resting && !s_.observe.systems && !s_.field;
  follow_motions();
  choose_active();
  s_.dynamic_bodies = s_.awake.size() + static_cast<std::size_t>(s_.sleepers.totals().bodies);
  s_.backup.resize(s_.bodies.size());
  s_.joint_start.resize(s_.joints.size());
  s_.held_rows.resize(s_.joints.size());
  begin_all();
  begun_ = true;
  book(Stage::Forces, start);
}

/// Refuses the step before anything is changed.
void Step::require_masses() const {
  for (const std::uint32_t i : s_.awake) {
    if (s_.bodies.inverse_mass[i] > 0) continue;
    throw std::invalid_argument(body_label(s_, i) +
                                " is dynamic but has no mass: give it a mass, or a shape with a density");
  }
}

/// Awake bodies, kinematic ones that move, and what the user touched; with the joints of the awake ones.
void Step::choose_active() {
  const BodyArrays& b = s_.bodies;
  std::vector<std::uint32_t>& others = s_.scratch.others;
  others.clear();
  others.swap(s_.touched);
  for (const std::uint32_t i : s_.kinematic) {
    if (b.velocity[i] != Vec2{} || b.omega[i] != 0) others.push_back(i);
  }
  // Awake bodies are in the set already.
  std::erase_if(others, [&](std::uint32_t i) {
    return !b.alive[i] || (b.type[i] == BodyType::Dynamic && b.asleep[i] == 0);
  });
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  s_.active.clear();
  std::merge(s_.awake.begin(), s_.awake.end(), others.begin(), others.end(), std::back_inserter(s_.active));
  // The joints of the same bodies are the same joints.
  // The same numbers may be those of other joints.
  if (s_.joints_changed) s_.graph_known = false;
  s_.joints_changed = false;
  if (!s_.graph_known || s_.awake != s_.graph_bodies) choose_joints();
}

void Step::choose_joints() {
  s_.active_joints.clear();
  for (const std::uint32_t i : s_.awake)
    s_.active_joints.insert(s_.active_joints.end(), s_.joints_of[i].begin(), s_.joints_of[i].end());
  std::sort(s_.active_joints.begin(), s_.active_joints.end());
  s_.active_joints.erase(std::unique(s_.active_joints.begin(), s_.active_joints.end()),
                         s_.active_joints.end());
}

/// Over the step, by what acts on the body where it begins, but for contacts and joints.
std::array<double, 3> Step::acceleration_at_start(std::uint32_t i) const {
  const BodyArrays& b = s_.bodies;
  const JointEnd start{b.position[i], b.rotation[i], b.angle[i], b.velocity[i], b.omega[i]};
  return damped_motion(s_, i, start, 0, {start.v.x, start.v.y, start.omega}, h_).acceleration;
}

/// How far a body can go by its velocity and the acceleration where the step begins [m].
double Step::reach_at_start(std::uint32_t i) const {
  const BodyBackup& from = s_.backup[i];
  return h_ * (length(from.velocity) + h_ * length(s_.acceleration[i]) +
               (std::abs(from.omega) + h_ * std::abs(s_.angular_acceleration[i])) * s_.radius[i]);
}

/// The bounds on how it moves are those that the next step will begin with, if nothing changes.
bool Step::has_bounds_of_rest(std::uint32_t i) const {
  return s_.travelled[i] == 0 && s_.flight[i] != FlightKind::Fast && s_.reach[i] == reach_at_start(i);
}

/// State and forces are those of the last step, bit by bit; then its reach and its box are, too.
bool Step::is_where_it_was(std::uint32_t i) const {
  if (!may_keep_ || !s_.rests[i] || !has_bounds_of_rest(i)) return false;
  const BodyArrays& b = s_.bodies;
  const BodyBackup& last = s_.backup[i];
  if (b.position[i] != last.position || b.angle[i] != last.angle || b.velocity[i] != last.velocity ||
      b.omega[i] != last.omega) {
    return false;
  }
  const std::array<double, 3> a = acceleration_at_start(i);
  return s_.acceleration[i] == Vec2{a[0], a[1]} && s_.angular_acceleration[i] == a[2];
}

void Step::begin_all() {
  if (s_.field) {
    // What the user's function throws leaves bodies behind that have not begun.
    for (const std::uint32_t i : s_.active) {
      begin(i);
      ++saved_;
    }
    return;
  }
  Spare<std::vector<std::uint8_t>> stopped;
  stopped->assign(s_.active.size(), 0);
  std::atomic<bool> any = false;
  share(s_.pool.get(), s_.active.size(), kBodiesAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      (*stopped)[k] = begin_alone(s_.active[k]);
      if ((*stopped)[k] != 0) any.store(true, std::memory_order_relaxed);
    }
  });
  saved_ = s_.active.size();
  for (std::size_t k = 0; any && k < s_.active.size(); ++k)
    if ((*stopped)[k] != 0) note_contained(s_.active[k], ContainmentCause::TooFar);
}

void Step::begin(std::uint32_t i) {
  if (begin_alone(i)) note_contained(i, ContainmentCause::TooFar);
}

/// Changes nothing but the body. @return whether it had to be stopped
bool Step::begin_alone(std::uint32_t i) {
  BodyArrays& b = s_.bodies;
  s_.kept[i] = b.type[i] == BodyType::Dynamic && is_where_it_was(i);
  if (s_.kept[i]) return false;
  s_.backup[i] = {b.position[i], b.angle[i], b.rotation[i], b.velocity[i], b.omega[i]};
  s_.travelled[i] = s_.strayed[i] = 0;
  s_.acceleration[i] = {};
  s_.angular_acceleration[i] = 0;
  s_.reach[i] = s_.allowance[i] = 0;
  s_.rerouted[i] = 0;
  s_.way[i] = {};
  s_.flight[i] = FlightKind::Bent;
  if (b.type[i] == BodyType::Static) return false;
  if (b.type[i] == BodyType::Dynamic) {
    const std::array<double, 3> a = acceleration_at_start(i);
    s_.acceleration[i] = {a[0], a[1]};
    s_.angular_acceleration[i] = a[2];
  }
  s_.reach[i] = reach_at_start(i);
  if (s_.prescribed[i]) {
    // Between its nodes a smooth motion goes little farther than at them.
    const MotionPath& path = s_.paths[i];
    s_.reach[i] = 1.5 * path.extent() + (path.turn() > 0 ? 1.5 * path.turn() * s_.radius[i] : 0);
  }
  const bool stops = !(s_.reach[i] < kFarthest);
  if (stops) stop(i);
  s_.way[i] = {b.velocity[i], s_.acceleration[i], b.omega[i], s_.angular_acceleration[i]};
  if (!flies_freely(s_, i) && (b.type[i] == BodyType::Dynamic || s_.prescribed[i])) return stops;
  // What rests is not fast, however far a step of its fall may be for its size: what is known of it does not
  // depend on what it was near to before.
  const double goes = h_ * (length(b.velocity[i]) + std::abs(b.omega[i]) * s_.radius[i]);
  const bool fast = s_.config.skips.alike && s_.reach[i] > kFast * s_.config.contact_margin &&
                    goes > s_.config.contact_margin;
  s_.flight[i] = fast ? FlightKind::Fast : FlightKind::Slow;
  s_.allowance[i] = 2 * s_.reach[i];
  if (!fast) return stops;
  // Nothing is known yet that could strike a fast one, but for what the last step was like.
  const double guess = s_.stray_guess[i], pull = s_.joints_of[i].empty() ? 0 : guess_of_joints(i);
  if (guess == kInfinity || guess <= pull) {
    s_.allowance[i] = std::min(s_.allowance[i], pull);
    return stops;
  }
  s_.allowance[i] = std::min(s_.allowance[i], guess);
  s_.reach[i] += s_.allowance[i];
  return stops;
}

void Step::begin(Contact& contact) const {
  for (PointMemory& memory : contact.points)
    memory.total_normal = memory.total_friction = memory.total_impact = 0;
  std::copy(contact.points.begin(), contact.points.end(), contact.points_at_start.begin());
  contact.impulse = contact.impact = {};
  contact.hit = false;
  contact.hit_speed = 0;
  contact.begun = s_.steps + 1;
}

void Step::begin_joint(std::uint32_t i) const {
  JointRecord& joint = s_.joints[i];
  std::fill(std::begin(joint.row_impulse), std::end(joint.row_impulse), 0);
  note_stall(s_, joint, 0);
  JointStart& start = s_.joint_start[i];
  if (start.begun == s_.steps + 1) return;
  std::copy(std::begin(joint.row_force), std::end(joint.row_force), start.row_force.begin());
  start.begun = s_.steps + 1;
}

/// Puts bodies on the ways that are prescribed for this step. Those that go nowhere are begun once more, as
/// what stands still; what sleeps on them wakes when they go.
void Step::follow_motions() {
  s_.active.clear();  // of the last step: nothing has begun if one of the user's functions throws
  for (const std::uint32_t i : s_.kinematic)
    if (s_.prescribed[i]) follow(i);
}

void Step::follow(std::uint32_t i) {
  BodyArrays& b = s_.bodies;
  MotionPath& path = s_.paths[i];
  if (path.moves()) s_.touched.push_back(i);
  path.sample(s_.prescribed[i], s_.time, h_, {b.position[i], b.angle[i]});
  s_.scratch.motion_breaks |= !path.breaks().empty();
  s_.scratch.motion_jumps |= path.begins_with_jump() || path.ends_with_jump();
  s_.scratch.before_motion.push_back(
      {i, {b.position[i], b.angle[i], b.rotation[i], b.velocity[i], b.omega[i]}});
  const KinematicState now = path.at(0);
  b.position[i] = now.p;
  if (b.angle[i] != now.angle) {
    b.angle[i] = now.angle;
    b.rotation[i] = Rot::from_angle(now.angle);
  }
  b.velocity[i] = now.v;
  b.omega[i] = now.omega;
  if (!path.moves()) return;
  s_.touched.push_back(i);
  s_.sleepers.wake_at(s_, i);
}

/// A body that is about to leave the numbers stops where it is.
void Step::contain(std::uint32_t i, ContainmentCause cause) {
  stop(i);
  note_contained(i, cause);
}

void Step::stop(std::uint32_t i) {
  s_.bodies.velocity[i] = s_.backup[i].velocity = {};
  s_.bodies.omega[i] = s_.backup[i].omega = 0;
  s_.acceleration[i] = {};
  s_.angular_acceleration[i] = 0;
  s_.reach[i] = 0;
}

void Step::note_contained(std::uint32_t i, ContainmentCause cause) {
  ++s_.report.contained;
  s_.report.containments.push_back({{i, s_.bodies.generation[i]}, cause});
}

void Step::restore(const std::vector<std::uint32_t>& bodies) {
  BodyArrays& b = s_.bodies;
  for (const std::uint32_t i : bodies) {
    const BodyBackup& from = s_.backup[i];
    b.position[i] = from.position;
    b.angle[i] = from.angle;
    b.rotation[i] = from.rotation;
    b.velocity[i] = from.velocity;
    b.omega[i] = from.omega;
    s_.travelled[i] = s_.strayed[i] = 0;
  }
}

void Step::finish() {
  s_.displaced.clear();
  BodyArrays& b = s_.bodies;
  // Kinematic bodies move as told.
  for (const std::uint32_t i : s_.kinematic) {
    const KinematicState end = kinematic_state(s_, i, h_);
    b.position[i] = end.p;
    b.angle[i] = end.angle;
    if (s_.prescribed[i]) {
      b.position[i] = s_.paths[i].end().position;
      b.angle[i] = s_.paths[i].end().angle;
    }
    b.rotation[i] = Rot::from_angle(b.angle[i]);
    b.velocity[i] = end.v;
    b.omega[i] = end.omega;
  }
  // A body whose new state is not finite goes back to where it was and stops; the others are unaffected.
  for (const std::uint32_t i : s_.awake) {
    if (s_.kept[i] || (is_finite(b.position[i]) && std::isfinite(b.angle[i]) && is_finite(b.velocity[i]) &&
                       std::isfinite(b.omega[i]))) {
      continue;
    }
    restore({i});
    contain(i, ContainmentCause::NotFinite);
  }
  loosen_overrun();
  s_.time += h_;
  ++s_.steps;
  s_.last_h = h_;

  const auto start = now();
  write_report(s_, h_);
  s_.scratch.lost.clear();
  // Rest is where what steppers keep stays, too, so it is looked at before it is stored.
  remember();
  keep_motion();
  for (const std::uint32_t i : s_.active) {
    if (s_.kept[i]) continue;
    s_.ledger.mark(i);
    s_.applied[i] = {b.force[i], b.torque[i]};
    b.force[i] = {};
    b.torque[i] = 0;
    // From now on it is where it is.
    s_.kept[i] = b.type[i] != BodyType::Dynamic;
  }
  book(Stage::Report, start);
}

/// Keeps what the next step can use again: states at rest, solver memories. Islands at rest fall asleep.
void Step::remember() {
  if (std::all_of(s_.islands.begin(), s_.islands.end(), [](const SteppedIsland& i) { return i.kept; }))
    return;
  const auto by_key = [](const auto& x, std::uint64_t key) { return x.key < key; };
  std::vector<RestingIsland>& resting = s_.scratch.resting;
  std::vector<IslandMemory>& memories = s_.scratch.memories;
  std::vector<Sleepers::Candidate> sleepy;
  for (SteppedIsland& island : s_.islands) {
    if (island.flew_alone) {
      s_.rests[island.island.bodies.front()] = 0;
      continue;
    }
    IslandResult& result = island.result();
    std::uint64_t& rest_key = island.outcome->rest_key;
    if (island.kept) {
      // What there is of it goes on.
      auto known = std::lower_bound(s_.resting.begin(), s_.resting.end(), rest_key, by_key);
      for (const std::uint64_t key : known->memory_keys) {
        const auto memory = std::lower_bound(s_.memories.begin(), s_.memories.end(), key, by_key);
        if (memory != s_.memories.end() && memory->key == key) memories.push_back(std::move(*memory));
      }
      resting.push_back(std::move(*known));
      continue;
    }
    std::optional<RestingIsland> known =
        s_.observe.systems ? std::optional<RestingIsland>{} : remember_resting(s_, island.island, h_, result);
    std::vector<IslandMemory>& own = result.memories;
    std::erase_if(own, [](const IslandMemory& memory) { return memory.memory == nullptr; });
    const bool at_rest = known && result.at_rest;
    for (const std::uint32_t i : island.island.bodies) s_.rests[i] = at_rest;
    if (known) rest_key = known->key;
    if (known && may_sleep(island)) {
      sleepy.push_back({&island.island, std::move(*known), std::move(own)});
      continue;
    }
    if (known) resting.push_back(std::move(*known));
    std::move(own.begin(), own.end(), std::back_inserter(memories));
    own.clear();
  }
  const auto ascending = [](const auto& x, const auto& y) { return x.key < y.key; };
  std::sort(resting.begin(), resting.end(), ascending);
  std::sort(memories.begin(), memories.end(), ascending);
  s_.resting.swap(resting);
  s_.memories.swap(memories);
  resting.clear();
  memories.clear();
  s_.sleepers.put_to_sleep(s_, h_, std::move(sleepy));
}

/// At rest twice under the same input, and that input stays: forces of the user last one step only.
bool Step::may_sleep(const SteppedIsland& island) const {
  if (!s_.config.sleep || !island.result().at_rest) return false;
  return std::all_of(island.island.bodies.begin(), island.island.bodies.end(), [this](std::uint32_t i) {
    return s_.bodies.force[i] == Vec2{} && s_.bodies.torque[i] == 0 && has_bounds_of_rest(i);
  });
}

/// How far a body in flow will stray from free flight, if it is struck like in this step.
double Step::guess_stray(std::uint32_t i) const {
  const BodyArrays& b = s_.bodies;
  const BodyBackup& from = s_.backup[i];
  const Vec2 kick = b.velocity[i] - from.velocity - h_ * s_.acceleration[i];
  const double spin = b.omega[i] - from.omega - h_ * s_.angular_acceleration[i];
  return std::max(s_.config.contact_margin, kGuess * h_ * (length(kick) + std::abs(spin) * s_.radius[i]));
}

/// What steppers want to know of this step in the next one, and the paths for whoever asks.
void Step::keep_motion() {
  s_.step_paths.clear();
  s_.paths_known = s_.observe.paths;
  const auto note = [this](const SteppedIsland& island, std::size_t k) {
    const std::uint32_t i = island.island.bodies[k];
    const bool struck = s_.flight[i] == FlightKind::Fast && s_.strayed[i] > 0 && s_.joints_of[i].empty();
    const bool flows = !island.flew_alone && island.result().report.flowing;
    s_.stray_guess[i] = flows ? guess_stray(i) : struck ? kInfinity : 0;
    // What flew alone had nothing to remember, and still has not.
    if (!island.flew_alone) s_.step_memory[i] = island.result().step_memory;
  };
  share_islands(s_, [&](const SteppedIsland& island, ThreadPool* threads) {
    if (island.kept) return;
    share_each(threads, island.island.bodies.size(), kBodiesAPiece, [&](std::size_t k) { note(island, k); });
  });
  if (!s_.paths_known) return;
  for (const SteppedIsland& island : s_.islands) {
    if (island.kept || island.flew_alone) continue;
    const std::vector<PathPiece>& path = island.result().path;
    s_.step_paths.insert(s_.step_paths.end(), path.begin(), path.end());
  }
  for (const std::uint32_t i : s_.active) {
    if (s_.bodies.type[i] != BodyType::Kinematic) continue;
    add_kinematic_path(s_, i, h_, s_.step_paths);
  }
  // Pieces of one body are in the order of time already.
  std::stable_sort(s_.step_paths.begin(), s_.step_paths.end(),
                   [](const PathPiece& x, const PathPiece& y) { return x.body < y.body; });
}

const StepReport& World::step(double h) {
  if (!(h > 0) || !std::isfinite(h))
    throw std::invalid_argument("step: h must be positive and finite, got " + to_text(h));
  Step step(*state_, h);
  StepReport& report = state_->report;
  const auto take_sums = [&] {
    const BodySums sums = state_->ledger.total(state_->bodies, state_->config.gravity, state_->pool.get());
    report.kinetic_energy = sums.kinetic;
    report.potential_energy = sums.potential + spring_energy();
    report.momentum = sums.momentum;
    report.angular_momentum = sums.angular;
    report.state_hash = sums.hash;
  };
  // What a callback threw: nothing has moved.
  const auto undo = [&](const char* cause) {
    step.undo();
    write_report_of_nothing(*state_, cause);
    take_sums();
  };
  try {
    step.run();
  } catch (const std::exception& error) {
    undo(error.what());
    throw;
  } catch (...) {
    undo("what was thrown is no std::exception");
    throw;
  }
  for (const JointEvent& broken : report.joint_events) destroy(broken.joint);
  take_sums();
  return report;
}

}  // namespace skerry
