// SPDX-License-Identifier: MIT
#include "physics/stepping/flight_queue.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "physics/spare.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/flush_faces.h"
#include "physics/stepping/free_flight.h"
#include "physics/stepping/island_impact.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Below this the whole island is looked at after each impact: that costs no more then.
constexpr std::size_t kFewestBodies = 8;
// Touching points that part more slowly [m/s], or hop no higher than so many touch tolerances, are no flight.
constexpr double kParting = 1e-8;
constexpr double kHop = 16;
// Contacts, and bodies, that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 256, kBodiesAPiece = 512;

class FlightQueue {
 public:
  FlightQueue(WorldState& state, const Island& island, double from, double to, bool note_events,
              IslandResult& result)
      : state_(state),
        island_(island),
        from_(from),
        to_(to),
        note_events_(note_events),
        varying_(has_varying_forces(state, island)),
        result_(result) {}

  /// True if every pair that touches is about to bounce or parts, and none overlaps.
  bool applies() const {
    if (island_.bodies.size() < kFewestBodies || !island_.joints.empty()) return false;
    // Events want flights that are no parabolas to the last digit.
    if ((varying_ && note_events_) || meets_prescribed_motion(state_, island_)) return false;
    return !any_of(state_.island_threads, island_.contacts.size(), kContactsAPiece, [this](std::size_t k) {
      const Contact& contact = state_.contacts[island_.contacts[k]];
      return !(parts(contact, from_) || approaches(contact, from_)) || overlaps(state_, contact);
    });
  }

  double run() {
    for (const std::uint32_t body : island_.bodies)
      if (varying_ && !take_forces_of_flight(state_, body, from_, to_ - from_)) return from_;
    link();
    forget_loads();
    Spare<std::vector<double>> times;
    times->resize(island_.contacts.size());
    share(state_.island_threads, times->size(), kContactsAPiece, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) (*times)[k] = time_of_meeting(k, from_);
    });
    for (std::size_t k = 0; k < times->size(); ++k) enter(k, (*times)[k]);
    double now = from_;
    bool flies = true;
    while (flies && !queue_.empty()) {
      const Meeting next = queue_.top();
      queue_.pop();
      if (next.version != version_[next.contact]) continue;
      now = std::max(now, next.time);
      flies = meet(next.contact, now);
    }
    if (flies) now = to_;
    // What is recorded of them is one list.
    ThreadPool* threads = state_.observe.paths ? nullptr : state_.island_threads;
    share_each(threads, island_.bodies.size(), kBodiesAPiece, [&](std::size_t k) { bring(k, now); });
    result_.manifolds_reused += update_manifolds(state_, island_, now, result_.narrow);
    ++result_.substeps;
    return now;
  }

 private:
  /// A pair is foretold to touch; void when it was foretold anew since.
  struct Meeting {
    double time;
    std::uint32_t contact;  ///< number in the island
    std::uint32_t version;
    /// Of those at one time the first of the table.
    bool operator<(const Meeting& other) const {
      return time != other.time ? time > other.time : contact > other.contact;
    }
  };

  Contact& contact_at(std::size_t k) { return state_.contacts[island_.contacts[k]]; }

  /// Whether all touching points of a contact part fast enough to call it a flight.
  bool parts(const Contact& contact, double time) const {
    const double a = pull(contact.body_a) + pull(contact.body_b);
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[static_cast<std::size_t>(i)];
      if (!is_touching(state_, point)) continue;
      const double slow =
          std::max(kParting, std::sqrt(2 * a * kHop * touch_tolerance(state_, point.position)));
      if (normal_velocity(state_, contact, point.position, time) <= slow) return false;
    }
    return true;
  }
  /// Magnitude of what external forces do to the points of a body [m/s^2].
  double pull(std::uint32_t body) const {
    if (state_.local_index[body] < 0) return 0;
    return length(state_.acceleration[body]) +
           std::abs(state_.angular_acceleration[body]) * state_.radius[body];
  }
  bool approaches(const Contact& contact, double time) const {
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[static_cast<std::size_t>(i)];
      if (is_touching(state_, point) &&
          normal_velocity(state_, contact, point.position, time) < -state_.config.rest_speed)
        return true;
    }
    return false;
  }

  /// Which contacts a body has.
  void link() {
    const std::size_t n = island_.bodies.size();
    clock_.assign(n, from_);
    struck_.assign(n, 0);
    version_.assign(island_.contacts.size(), 0);
    first_.assign(n + 1, 0);
    const auto each_end = [this](std::size_t k, auto&& visit) {
      const ContactLink& link = state_.links[island_.contacts[k]];
      for (const std::uint32_t body : {link.body_a, link.body_b}) {
        if (state_.local_index[body] >= 0) visit(static_cast<std::size_t>(state_.local_index[body]));
      }
    };
    for (std::size_t k = 0; k < island_.contacts.size(); ++k)
      each_end(k, [&](std::size_t i) { ++first_[i + 1]; });
    for (std::size_t i = 0; i < n; ++i) first_[i + 1] += first_[i];
    contacts_of_.resize(first_[n]);
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t k = 0; k < island_.contacts.size(); ++k)
      each_end(k, [&](std::size_t i) { contacts_of_[next[i]++] = static_cast<std::uint32_t>(k); });
  }

  /// In flight nothing is held.
  void forget_loads() {
    share_each(state_.island_threads, island_.contacts.size(), kContactsAPiece, [this](std::size_t k) {
      for (PointMemory& memory : contact_at(k).points) memory.let_go();
    });
  }

  /// Flight of a body with its clock at `time`; the body itself stays at its own clock.
  Motion flight(std::uint32_t body, double time) const {
    const int k = state_.local_index[body];
    if (k < 0) return free_flight(state_, body, time);
    const Motion m = free_flight(state_, body, time);
    const double ahead = time - clock_[static_cast<std::size_t>(k)];
    return ahead > 0 ? later(m, ahead) : m;
  }

  Transform pose(std::uint32_t body, double time) const {
    const Motion m = flight(body, time);
    return {m.p0, m.omega == 0 && m.alpha == 0 ? state_.bodies.rotation[body] : Rot::from_angle(m.angle0)};
  }

  /// When a pair meets next, by what is known now; infinite if that is not before the end.
  double time_of_meeting(std::size_t k, double now) const {
    const Contact& contact = state_.contacts[island_.contacts[k]];
    const ImpactTime impact =
        landing_time(state_, contact, flight(contact.body_a, now), flight(contact.body_b, now), to_ - now);
    return impact.hit && now + impact.t < to_ ? now + impact.t : kInfinity;
  }
  /// Enters the next meeting of a pair, and voids the one that was foretold before.
  void enter(std::size_t k, double time) {
    ++version_[k];
    if (time < kInfinity) queue_.push({time, static_cast<std::uint32_t>(k), version_[k]});
  }
  void foretell(std::size_t k, double now) { enter(k, time_of_meeting(k, now)); }

  /// Brings a body to `time`.
  void bring(std::size_t k, double time) {
    const double t = time - clock_[k];
    if (!(t > 0)) return;
    const std::uint32_t body = island_.bodies[k];
    std::vector<PathEnd> start;
    if (state_.observe.paths) start = path_ends(state_, {body});
    Velocity change{};
    if (varying_ && time < to_) change = change_of_cut(body, clock_[k], t);
    fly(state_, body, clock_[k], t);
    state_.bodies.velocity[body] += Vec2{change[0], change[1]};
    state_.bodies.omega[body] += change[2];
    if (state_.observe.paths) record_hermite(state_, {body}, clock_[k], t, start, result_);
    clock_[k] = time;
  }

  /// Forces that depend on the state were those of a flight to the end. @return what those of one that ends
  /// after a time `t` make of the velocity besides; the path is the same but for the third order
  Velocity change_of_cut(std::uint32_t body, double from, double t) {
    const Vec2 a = state_.acceleration[body];
    const double alpha = state_.angular_acceleration[body];
    Velocity change{};
    if (take_forces_of_flight(state_, body, from, t)) {
      const Vec2 more = t * (state_.acceleration[body] - a);
      change = {more.x, more.y, t * (state_.angular_acceleration[body] - alpha)};
    }
    state_.acceleration[body] = a;
    state_.angular_acceleration[body] = alpha;
    return change;
  }

  /// The pair `k` touches: an impact of all that touch one another. @return false if that is no flight any
  /// more
  bool meet(std::size_t k, double now) {
    gather(k, now);
    // The impact law sees the cluster as an island of its own.
    for (std::size_t i = 0; i < cluster_.bodies.size(); ++i)
      state_.local_index[cluster_.bodies[i]] = static_cast<std::int32_t>(i);
    apply_impact(state_, cluster_, now, {}, result_);
    for (std::size_t i = 0; i < members_.size(); ++i)
      state_.local_index[island_.bodies[members_[i]]] = static_cast<std::int32_t>(members_[i]);
    if (note_events_) note(contact_at(k), now);
    bool flies = !is_spent(state_, result_);
    for (const std::uint32_t index : cluster_.contacts) flies &= parts(state_.contacts[index], now);
    for (const std::size_t member : members_) flies &= ++struck_[member] < state_.config.max_impacts_per_step;
    for (const std::uint32_t body : cluster_.bodies)
      flies &= !varying_ || take_forces_of_flight(state_, body, now, to_ - now);
    if (!flies) return false;
    for (const std::size_t member : members_) {
      for (std::size_t i = first_[member]; i < first_[member + 1]; ++i) foretell(contacts_of_[i], now);
    }
    return true;
  }

  /// All that touches the pair `k`, directly or by others: bodies and contacts, brought to `now`.
  void gather(std::size_t k, double now) {
    members_.clear();
    cluster_ = {};
    const auto join = [&](std::uint32_t body) {
      const int number = state_.local_index[body];
      if (number < 0) return;
      const auto member = static_cast<std::size_t>(number);
      if (std::find(members_.begin(), members_.end(), member) != members_.end()) return;
      bring(member, now);
      members_.push_back(member);
    };
    join(contact_at(k).body_a);
    join(contact_at(k).body_b);
    for (std::size_t next = 0; next < members_.size(); ++next) {
      for (std::size_t i = first_[members_[next]]; i < first_[members_[next] + 1]; ++i) {
        const std::uint32_t index = island_.contacts[contacts_of_[i]];
        Contact& contact = state_.contacts[index];
        result_.manifolds_reused +=
            !refresh_manifold(contact, state_.shapes[contact.shape_a].shape, pose(contact.body_a, now),
                              state_.shapes[contact.shape_b].shape, pose(contact.body_b, now), contact.margin,
                              state_.config.skips, result_.narrow);
        if (!touches(state_, contact)) continue;
        cluster_.contacts.push_back(index);
        join(contact.body_a);
        join(contact.body_b);
      }
    }
    std::sort(members_.begin(), members_.end());
    for (const std::size_t member : members_) cluster_.bodies.push_back(island_.bodies[member]);
    std::sort(cluster_.contacts.begin(), cluster_.contacts.end());
    cluster_.contacts.erase(std::unique(cluster_.contacts.begin(), cluster_.contacts.end()),
                            cluster_.contacts.end());
  }

  void note(const Contact& contact, double now) {
    result_.motion_events.push_back({MotionEventKind::Landing, now, state_.shapes[contact.shape_a].body,
                                     state_.shapes[contact.shape_b].body});
    ++result_.events_found;
  }

  WorldState& state_;
  const Island& island_;
  const double from_, to_;
  const bool note_events_, varying_;
  IslandResult& result_;

  std::vector<double> clock_;               ///< by body of the island: time of its state [s]
  std::vector<int> struck_;                 ///< by body: impacts so far
  std::vector<std::size_t> first_;          ///< by body: where its contacts begin in `contacts_of_`
  std::vector<std::uint32_t> contacts_of_;  ///< numbers in the island
  std::vector<std::uint32_t> version_;      ///< by contact
  std::priority_queue<Meeting> queue_;
  std::vector<std::size_t> members_;  ///< of the cluster, as numbers in the island
  Island cluster_;
};

}  // namespace

double fly_by_queue(WorldState& state, const Island& island, double from, double to, bool note_events,
                    IslandResult& result) {
  FlightQueue queue(state, island, from, to, note_events, result);
  return queue.applies() ? queue.run() : from;
}

}  // namespace skerry
