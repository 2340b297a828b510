// SPDX-License-Identifier: MIT
//
// One step of a world as a list of stages. Pairs are sorted and islands numbered canonically, so the result
// depends neither on the broad phase nor on the order in which islands are stepped.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "physics/islands/island_builder.h"
#include "physics/narrowphase/chain.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/touching.h"
#include "physics/text.h"
#include "physics/world_report.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Farther than this in one step [m] a body is lost: products of such lengths still fit a double.
constexpr double kFarthest = 1e100;

// Enough manifolds to be worth a thread's attention: about 50 us of work.
constexpr std::size_t kContactsPerChunk = 256;

struct SteppedIsland {
  Island island;
  IslandResult result;
};

class Step {
 public:
  Step(WorldState& state, double h) : s_(state), h_(h) {}

  void run() {
    begin();
    std::vector<SteppedIsland> islands;
    if (!s_.active.empty() || !s_.contacts.empty()) {
      std::vector<std::uint8_t> dirty(s_.bodies.size(), 1);
      for (;;) {
        find_pairs();
        link_contacts(dirty);
        step_islands(dirty, islands);
        if (!extend_reach(dirty)) break;
      }
    }
    finish(islands);
  }

  /// Puts all bodies back to where the step found them.
  void undo() {
    BodyArrays& b = s_.bodies;
    if (begun_) saved_ = s_.active.size();
    for (std::size_t k = 0; k < saved_; ++k) {
      const std::uint32_t i = s_.active[k];
      b.position[i] = s_.backup[i].position;
      b.angle[i] = s_.backup[i].angle;
      b.rotation[i] = s_.backup[i].rotation;
      b.velocity[i] = s_.backup[i].velocity;
      b.omega[i] = s_.backup[i].omega;
    }
    // What was touched before the step still is.
    s_.touched.insert(s_.touched.end(), s_.active.begin(), s_.active.end());
    s_.resting.clear();
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// The clock is read only for an observer: it costs as much as a body.
  Clock::time_point now() const { return s_.observe.stage_times ? Clock::now() : Clock::time_point{}; }

  void book(Stage stage, Clock::time_point start) {
    if (!s_.observe.stage_times) return;
    s_.report.stage_seconds[static_cast<int>(stage)] +=
        std::chrono::duration<double>(Clock::now() - start).count();
  }

  /// The working set; accelerations, bounds on the motion, and what a second try needs.
  void begin() {
    const auto start = now();
    require_masses();
    s_.report = {};
    // Sleep holds for steps of one length, and an observer of the equations wants to see all of them.
    if (!s_.sleepers.none() && (s_.sleepers.h() != h_ || s_.observe.systems)) s_.sleepers.wake_all(s_);
    choose_active();
    s_.backup.resize(s_.bodies.size());
    for (const std::uint32_t i : s_.active) {
      begin(i);
      ++saved_;
    }
    begun_ = true;
    for (Contact& contact : s_.contacts) begin(contact);
    for (const std::uint32_t j : s_.active_joints) begin(s_.joints[j]);
    book(Stage::Forces, start);
  }

  /// Refuses the step before anything is changed.
  void require_masses() const {
    for (const std::uint32_t i : s_.awake) {
      if (s_.bodies.inverse_mass[i] > 0) continue;
      throw std::invalid_argument("body " + std::to_string(i) +
                                  (s_.names[i].empty() ? "" : " '" + s_.names[i] + "'") +
                                  " is dynamic but has no mass: give it a mass, or a shape with a density");
    }
  }

  /// Awake bodies, kinematic ones that move, and what the user touched; with the joints of the awake ones.
  void choose_active() {
    const BodyArrays& b = s_.bodies;
    std::vector<std::uint32_t> others = std::move(s_.touched);
    s_.touched.clear();
    for (const std::uint32_t i : s_.kinematic) {
      if (b.velocity[i] != Vec2{} || b.omega[i] != 0 || s_.prescribed[i]) others.push_back(i);
    }
    // Awake bodies are in the set already.
    std::erase_if(others, [&](std::uint32_t i) {
      return !b.alive[i] || (b.type[i] == BodyType::Dynamic && b.asleep[i] == 0);
    });
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    s_.active.clear();
    std::merge(s_.awake.begin(), s_.awake.end(), others.begin(), others.end(), std::back_inserter(s_.active));
    s_.active_joints.clear();
    for (const std::uint32_t i : s_.awake) add_joints_of(i);
    sort_joints();
  }

  void add_joints_of(std::uint32_t body) {
    s_.active_joints.insert(s_.active_joints.end(), s_.joints_of[body].begin(), s_.joints_of[body].end());
  }

  void sort_joints() {
    std::sort(s_.active_joints.begin(), s_.active_joints.end());
    s_.active_joints.erase(std::unique(s_.active_joints.begin(), s_.active_joints.end()),
                           s_.active_joints.end());
  }

  void begin(std::uint32_t i) {
    BodyArrays& b = s_.bodies;
    if (s_.prescribed[i]) follow(i);
    s_.backup[i] = {b.position[i], b.angle[i], b.rotation[i], b.velocity[i], b.omega[i]};
    s_.travelled[i] = 0;
    s_.acceleration[i] = {};
    s_.angular_acceleration[i] = 0;
    s_.reach[i] = 0;
    s_.ledger.mark(i);
    if (b.type[i] == BodyType::Static) return;
    if (b.type[i] == BodyType::Dynamic) {
      const std::array<double, 3> a = applied_acceleration(
          s_, i, {b.position[i], b.rotation[i], b.angle[i], b.velocity[i], b.omega[i]}, 0);
      s_.acceleration[i] = {a[0], a[1]};
      s_.angular_acceleration[i] = a[2];
    }
    s_.reach[i] = h_ * (length(b.velocity[i]) + h_ * length(s_.acceleration[i]) +
                        (std::abs(b.omega[i]) + h_ * std::abs(s_.angular_acceleration[i])) * s_.radius[i]);
    if (s_.prescribed[i]) {
      // Between its nodes a smooth motion goes little farther than at them.
      const MotionPath& path = s_.paths[i];
      s_.reach[i] = 1.5 * path.extent() + (path.turn() > 0 ? 1.5 * path.turn() * s_.radius[i] : 0);
    }
    if (!(s_.reach[i] < kFarthest)) contain(i);
  }

  static void begin(Contact& contact) {
    for (PointMemory& memory : contact.points)
      memory.total_normal = memory.total_friction = memory.total_impact = 0;
    contact.points_at_start = contact.points;
    contact.hit = false;
    contact.hit_speed = 0;
  }

  /// Puts a body on the way that is prescribed for this step.
  void follow(std::size_t i) {
    BodyArrays& b = s_.bodies;
    s_.paths[i].sample(s_.prescribed[i], s_.time, h_);
    const KinematicState now = s_.paths[i].at(0);
    b.position[i] = now.p;
    if (b.angle[i] != now.angle) {
      b.angle[i] = now.angle;
      b.rotation[i] = Rot::from_angle(now.angle);
    }
    b.velocity[i] = now.v;
    b.omega[i] = now.omega;
  }

  static void begin(JointRecord& joint) {
    std::fill(std::begin(joint.row_impulse), std::end(joint.row_impulse), 0);
  }

  /// A body that is about to leave the numbers stops where it is.
  void contain(std::size_t i) {
    s_.bodies.velocity[i] = s_.backup[i].velocity = {};
    s_.bodies.omega[i] = s_.backup[i].omega = 0;
    s_.acceleration[i] = {};
    s_.angular_acceleration[i] = 0;
    s_.reach[i] = 0;
    ++s_.report.contained;
  }

  /// Boxes that bound the motion within the step -> broad phase -> contact table.
  void find_pairs() {
    const auto start = now();
    s_.box_updates.clear();
    s_.shape_moved.assign(s_.shapes.size(), 0);
    const BodyArrays& b = s_.bodies;
    for (const std::uint32_t body : s_.active) {
      const BodyBackup& from = s_.backup[body];
      for (const std::uint32_t i : s_.shapes_of[body]) {
        ShapeRecord& shape = s_.shapes[i];
        const Aabb box = grown(bounding_box(shape.shape, {from.position, from.rotation}),
                               s_.reach[body] + s_.config.contact_margin);
        if (!shape.in_broad_phase) {
          s_.broad_phase->insert(i, box,
                                 b.type[body] == BodyType::Static ? ProxyKind::Fixed : ProxyKind::Moving);
          shape.in_broad_phase = true;
        } else if (box.lower != shape.box.lower || box.upper != shape.box.upper) {
          s_.box_updates.push_back({i, box});
        } else {
          continue;
        }
        shape.box = box;
        s_.shape_moved[i] = 1;
      }
    }
    s_.loose_shapes.clear();
    if (!s_.box_updates.empty()) s_.broad_phase->update(s_.box_updates);
    s_.broad_phase->moved_pairs(s_.pairs);
    merge_pairs();
    book(Stage::Broad, start);
  }

  /// Contacts of boxes that did not change stay; the others are those that the broad phase reports.
  void merge_pairs() {
    const bool moved = std::find(s_.shape_moved.begin(), s_.shape_moved.end(), 1) != s_.shape_moved.end();
    if (s_.pairs.empty() && !moved) return;
    std::vector<Contact> wanted;
    for (const Pair& pair : s_.pairs) {
      if (may_touch(pair)) add_wanted(pair, wanted);
    }
    std::vector<Contact> next;
    next.reserve(s_.contacts.size() + wanted.size());
    auto old = s_.contacts.begin();
    const auto pass = [&] {
      if (!s_.shape_moved[old->shape_a] && !s_.shape_moved[old->shape_b]) {
        next.push_back(*old);
      } else if (old->touched) {
        lost_.push_back(*old);
      }
      ++old;
    };
    for (const Contact& contact : wanted) {
      while (old != s_.contacts.end() && old->key() < contact.key()) pass();
      if (old != s_.contacts.end() && old->key() == contact.key()) {
        next.push_back(*old);
        ++old;
      } else {
        next.push_back(contact);
      }
    }
    while (old != s_.contacts.end()) pass();
    s_.contacts = std::move(next);
  }

  /// One contact, or one for each near segment of a chain.
  void add_wanted(const Pair& pair, std::vector<Contact>& wanted) {
    Contact contact = make_contact(pair);
    const ShapeRecord& a = s_.shapes[pair.low];
    const ShapeRecord& b = s_.shapes[pair.high];
    const bool a_chain = a.shape.kind == ShapeKind::Chain;
    const bool b_chain = b.shape.kind == ShapeKind::Chain;
    if (a_chain == b_chain) {
      // Terrain does not meet terrain.
      if (!a_chain) wanted.push_back(contact);
      return;
    }
    const ShapeRecord& chain = a_chain ? a : b;
    const BodyBackup& at = s_.backup[chain.body.index];
    const double reach = s_.reach[chain.body.index] + s_.config.contact_margin;
    chain_segments_near(chain.shape, {at.position, at.rotation}, grown((a_chain ? b : a).box, reach),
                        segments_);
    for (const int segment : segments_) {
      contact.child = segment;
      wanted.push_back(contact);
    }
  }

  bool may_touch(const Pair& pair) const {
    const ShapeRecord& a = s_.shapes[pair.low];
    const ShapeRecord& b = s_.shapes[pair.high];
    if (a.body == b.body || !may_collide(a.filter, b.filter)) return false;
    const bool dynamic = s_.bodies.type[a.body.index] == BodyType::Dynamic ||
                         s_.bodies.type[b.body.index] == BodyType::Dynamic;
    if (!dynamic && !a.sensor && !b.sensor) return false;
    for (const std::uint32_t j : s_.joints_of[b.body.index]) {
      const JointDef& def = s_.joints[j].def;
      if (!def.collide && (def.a == a.body || def.b == a.body)) return false;
    }
    return true;
  }

  Contact make_contact(const Pair& pair) const {
    const ShapeRecord& a = s_.shapes[pair.low];
    const ShapeRecord& b = s_.shapes[pair.high];
    Contact contact;
    contact.shape_a = pair.low;
    contact.shape_b = pair.high;
    contact.body_a = a.body.index;
    contact.body_b = b.body.index;
    contact.friction =
        mix(std::max(a.friction_rule, b.friction_rule), a.material.friction, b.material.friction);
    contact.static_friction =
        std::max(contact.friction, mix(std::max(a.friction_rule, b.friction_rule),
                                       a.material.static_friction.value_or(a.material.friction),
                                       b.material.static_friction.value_or(b.material.friction)));
    contact.restitution =
        mix(std::max(a.restitution_rule, b.restitution_rule), a.material.restitution, b.material.restitution);
    contact.rolling_resistance = std::max(a.material.rolling_resistance, b.material.rolling_resistance);
    contact.surface_velocity = a.material.surface_velocity + b.material.surface_velocity;
    contact.sensor = a.sensor || b.sensor;
    return contact;
  }

  struct LinkCount {
    NarrowPhaseStats narrow;
    int reused = 0;
    std::vector<std::uint32_t> newly;  ///< bodies of contacts that became linked
  };

  /// A pair belongs to the step if its shapes can meet within it. After the first round only pairs of dirty
  /// bodies can become linked; islands that gained one are then the dirty ones.
  void link_contacts(std::vector<std::uint8_t>& dirty) {
    const auto start = now();
    const bool first = rounds_++ == 0;
    // Chunks of neighbouring contacts: each contact is touched by one thread, counters are summed in chunk
    // order.
    const std::size_t chunks = (s_.contacts.size() + kContactsPerChunk - 1) / kContactsPerChunk;
    std::vector<LinkCount> counts(chunks);
    s_.pool->run(chunks, [&](std::size_t chunk) {
      const std::size_t end = std::min((chunk + 1) * kContactsPerChunk, s_.contacts.size());
      for (std::size_t i = chunk * kContactsPerChunk; i < end; ++i) {
        link(s_.contacts[i], first, dirty, counts[chunk]);
        s_.contacts[i].woken = false;
      }
    });
    while (wake_linked(first, dirty, counts)) {
    }
    std::vector<std::uint8_t> newly(s_.bodies.size(), 0);
    for (const LinkCount& count : counts) {
      s_.report.manifolds_reused += count.reused;
      s_.report.narrow.pairs += count.narrow.pairs;
      s_.report.narrow.axes_tested += count.narrow.axes_tested;
      s_.report.narrow.axes_skipped += count.narrow.axes_skipped;
      s_.report.narrow.manifolds += count.narrow.manifolds;
      for (const std::uint32_t body : count.newly) newly[body] = 1;
    }
    if (!first) dirty = newly;
    book(Stage::Narrow, start);
  }

  /// Sleeping islands that something can reach come back, as if they had been awake all the time; their own
  /// contacts may reach others. @return false if there were none
  bool wake_linked(bool first, const std::vector<std::uint8_t>& dirty, std::vector<LinkCount>& counts) {
    if (s_.sleepers.none()) return false;
    std::vector<std::uint32_t> struck;
    for (const Contact& contact : s_.contacts) {
      if (!contact.linked) continue;
      for (const std::uint32_t body : {contact.body_a, contact.body_b}) {
        if (s_.bodies.asleep[body]) struck.push_back(body);
      }
    }
    const std::vector<std::uint32_t> woken = s_.sleepers.wake(s_, struck);
    if (woken.empty()) return false;
    for (const std::uint32_t body : woken) {
      begin(body);
      add_joints_of(body);
      for (const std::uint32_t j : s_.joints_of[body]) begin(s_.joints[j]);
    }
    sort_joints();
    const auto middle = static_cast<std::ptrdiff_t>(s_.active.size());
    s_.active.insert(s_.active.end(), woken.begin(), woken.end());
    std::inplace_merge(s_.active.begin(), s_.active.begin() + middle, s_.active.end());
    LinkCount count;
    for (Contact& contact : s_.contacts) {
      if (!contact.woken) continue;
      contact.woken = false;
      begin(contact);
      // In later rounds they are what the first would have made of them.
      if (first) link(contact, first, dirty, count);
    }
    counts.push_back(std::move(count));
    return true;
  }

  void link(Contact& contact, bool first, const std::vector<std::uint8_t>& dirty, LinkCount& count) const {
    if (first) contact.linked = false;
    if (contact.sensor || contact.linked || (!dirty[contact.body_a] && !dirty[contact.body_b])) return;
    const double margin = 2 * s_.config.contact_margin + s_.reach[contact.body_a] + s_.reach[contact.body_b];
    const BodyBackup& a = s_.backup[contact.body_a];
    const BodyBackup& b = s_.backup[contact.body_b];
    contact.manifold_reused = !refresh_manifold(
        contact, s_.shapes[contact.shape_a].shape, {a.position, a.rotation}, s_.shapes[contact.shape_b].shape,
        {b.position, b.rotation}, margin, s_.config.skips, count.narrow);
    count.reused += contact.manifold_reused;
    if (first) {
      contact.linked = contact.manifold.count > 0;
      return;
    }
    // The paths are known now: shapes that were farther apart than both went cannot have met.
    double gap = margin;
    for (int i = 0; i < contact.manifold.count; ++i)
      gap = std::min(gap, contact.manifold.points[i].separation);
    const double paths = s_.travelled[contact.body_a] + s_.travelled[contact.body_b];
    contact.linked = gap <= paths + s_.config.touch_tolerance && contact.manifold.count > 0;
    if (contact.linked) count.newly.insert(count.newly.end(), {contact.body_a, contact.body_b});
  }

  void step_islands(std::vector<std::uint8_t>& dirty, std::vector<SteppedIsland>& stepped) {
    const auto start = now();
    const BodyArrays& b = s_.bodies;
    const auto dynamic = [&b](std::uint32_t i) { return b.type[i] == BodyType::Dynamic; };
    std::vector<IslandEdge> edges;
    for (std::uint32_t i = 0; i < s_.contacts.size(); ++i) {
      const Contact& c = s_.contacts[i];
      if (c.linked) edges.push_back({c.body_a, c.body_b, dynamic(c.body_a), dynamic(c.body_b), i, false});
    }
    for (const std::uint32_t i : s_.active_joints) {
      const JointRecord& joint = s_.joints[i];
      const bool ground = !joint.def.a;
      const std::uint32_t a = ground ? joint.def.b.index : joint.def.a.index;
      edges.push_back({a, joint.def.b.index, !ground && dynamic(a), dynamic(joint.def.b.index), i, true});
    }
    std::vector<Island> islands = s_.island_builder.build(s_.awake, edges);
    for (std::size_t n = 0; n < islands.size(); ++n) {
      for (std::size_t k = 0; k < islands[n].bodies.size(); ++k) {
        s_.local_index[islands[n].bodies[k]] = static_cast<std::int32_t>(k);
        s_.bodies.island[islands[n].bodies[k]] = static_cast<std::int32_t>(n);
      }
    }
    book(Stage::Islands, start);

    std::vector<SteppedIsland> next(islands.size());
    to_step_.clear();
    for (std::size_t n = 0; n < islands.size(); ++n) {
      next[n].island = std::move(islands[n]);
      const std::vector<std::uint32_t>& bodies = next[n].island.bodies;
      const bool again =
          std::any_of(bodies.begin(), bodies.end(), [&](std::uint32_t i) { return dirty[i] != 0; });
      if (!again) {
        // The same bodies as before: a merger would have made them dirty.
        const auto same = std::lower_bound(stepped.begin(), stepped.end(), bodies.front(),
                                           [](const SteppedIsland& island, std::uint32_t body) {
                                             return island.island.bodies.front() < body;
                                           });
        next[n].result = std::move(same->result);
        continue;
      }
      restore(bodies);
      if (rounds_ > 1) begin_again(next[n].island);
      if (rounds_ == 1 && reuse_resting(s_, next[n].island, h_, next[n].result)) continue;
      to_step_.push_back(n);
    }
    // Islands share nothing that is written, so their order does not matter.
    const auto step = [&](std::size_t k) {
      SteppedIsland& island = next[to_step_[k]];
      s_.stepper->step(s_, island.island, h_, island.result);
    };
    if (s_.field) {
      // A callback is asked in one order, by one thread.
      for (std::size_t k = 0; k < to_step_.size(); ++k) step(k);
    } else {
      s_.pool->run(to_step_.size(), step);
    }
    stepped = std::move(next);
  }

  /// A second try begins from the contacts of the beginning of the step.
  void begin_again(const Island& island) {
    ++s_.report.island_retries;
    for (const std::uint32_t i : island.contacts) {
      Contact& contact = s_.contacts[i];
      contact.points = contact.points_at_start;
      match_points(contact);
      contact.hit = false;
      contact.hit_speed = 0;
    }
    for (const std::uint32_t i : island.joints)
      std::fill(std::begin(s_.joints[i].row_impulse), std::end(s_.joints[i].row_impulse), 0);
    s_.report.manifolds_reused += update_manifolds(s_, island, 0, s_.report.narrow);
  }

  void restore(const std::vector<std::uint32_t>& bodies) {
    BodyArrays& b = s_.bodies;
    for (const std::uint32_t i : bodies) {
      const BodyBackup& from = s_.backup[i];
      b.position[i] = from.position;
      b.angle[i] = from.angle;
      b.rotation[i] = from.rotation;
      b.velocity[i] = from.velocity;
      b.omega[i] = from.omega;
      s_.travelled[i] = 0;
    }
  }

  /// A body that was struck may have left the box that was foreseen for it. Its reach grows; whether it did
  /// meet more than was known shows in the next round. Reaches only grow and islands only merge, so this
  /// ends.
  bool extend_reach(std::vector<std::uint8_t>& dirty) {
    bool any = false;
    std::fill(dirty.begin(), dirty.end(), 0);
    for (const std::uint32_t i : s_.active) {
      if (!(s_.travelled[i] > s_.reach[i] + 0.5 * s_.config.contact_margin)) continue;
      if (!std::isfinite(s_.travelled[i])) continue;
      s_.reach[i] = 1.25 * s_.travelled[i];
      dirty[i] = 1;
      any = true;
    }
    return any;
  }

  void finish(std::vector<SteppedIsland>& islands) {
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
      if (is_finite(b.position[i]) && std::isfinite(b.angle[i]) && is_finite(b.velocity[i]) &&
          std::isfinite(b.omega[i])) {
        continue;
      }
      restore({i});
      contain(i);
    }
    s_.time += h_;
    ++s_.steps;

    const auto start = now();
    std::vector<IslandResult*> results;
    std::vector<const Island*> members;
    for (SteppedIsland& island : islands) {
      results.push_back(&island.result);
      members.push_back(&island.island);
    }
    write_report(s_, h_, members, results, lost_);
    book(Stage::Report, start);

    keep_motion(members, results);
    remember(islands);
    for (const std::uint32_t i : s_.active) {
      b.force[i] = {};
      b.torque[i] = 0;
    }
  }

  /// Keeps what the next step can use again: states at rest, solver memories. Islands at rest fall asleep.
  void remember(std::vector<SteppedIsland>& islands) {
    std::vector<RestingIsland> resting;
    std::vector<Sleepers::Candidate> sleepy;
    s_.memories.clear();
    for (SteppedIsland& island : islands) {
      std::optional<RestingIsland> known;
      if (!s_.observe.systems) known = remember_resting(s_, island.island, h_, island.result);
      std::vector<IslandMemory>& memories = island.result.memories;
      std::erase_if(memories, [](const IslandMemory& memory) { return memory.memory == nullptr; });
      if (known && may_sleep(island)) {
        sleepy.push_back({&island.island, std::move(*known), std::move(memories)});
        continue;
      }
      if (known) resting.push_back(std::move(*known));
      std::move(memories.begin(), memories.end(), std::back_inserter(s_.memories));
    }
    std::sort(resting.begin(), resting.end(),
              [](const RestingIsland& x, const RestingIsland& y) { return x.key < y.key; });
    s_.resting = std::move(resting);
    std::sort(s_.memories.begin(), s_.memories.end(),
              [](const IslandMemory& x, const IslandMemory& y) { return x.key < y.key; });
    s_.sleepers.put_to_sleep(s_, h_, std::move(sleepy));
  }

  /// At rest twice under the same input, and that input stays: forces of the user last one step only.
  bool may_sleep(const SteppedIsland& island) const {
    if (!s_.config.sleep || !island.result.at_rest) return false;
    return std::all_of(island.island.bodies.begin(), island.island.bodies.end(), [this](std::uint32_t i) {
      return s_.bodies.force[i] == Vec2{} && s_.bodies.torque[i] == 0;
    });
  }

  /// What steppers want to know of this step in the next one, and the paths for whoever asks.
  void keep_motion(const std::vector<const Island*>& islands, const std::vector<IslandResult*>& results) {
    s_.step_paths.clear();
    s_.paths_known = s_.observe.paths;
    for (std::size_t n = 0; n < results.size(); ++n) {
      for (const std::uint32_t i : islands[n]->bodies) s_.step_memory[i] = results[n]->step_memory;
      s_.step_paths.insert(s_.step_paths.end(), results[n]->path.begin(), results[n]->path.end());
    }
    // Pieces of one body are in the order of time already.
    std::stable_sort(s_.step_paths.begin(), s_.step_paths.end(),
                     [](const PathPiece& x, const PathPiece& y) { return x.body < y.body; });
  }

  WorldState& s_;
  const double h_;
  int rounds_ = 0;
  std::size_t saved_ = 0;  ///< of the active bodies: those whose backup is that of this step
  bool begun_ = false;     ///< all of them are
  std::vector<int> segments_;
  std::vector<std::size_t> to_step_;  ///< islands of this round
  std::vector<Contact> lost_;         ///< touching contacts whose boxes parted
};

}  // namespace

const StepReport& World::step(double h) {
  if (!(h > 0) || !std::isfinite(h))
    throw std::invalid_argument("step: h must be positive, got " + to_text(h));
  Step step(*state_, h);
  try {
    step.run();
  } catch (...) {
    // What a callback threw: nothing has moved.
    step.undo();
    throw;
  }
  StepReport& report = state_->report;
  for (const JointEvent& broken : report.joint_events) destroy(broken.joint);
  const BodySums sums = state_->ledger.total(state_->bodies, state_->config.gravity);
  report.kinetic_energy = sums.kinetic;
  report.potential_energy = sums.potential + spring_energy();
  report.momentum = sums.momentum;
  report.angular_momentum = sums.angular;
  report.state_hash = sums.hash;
  return state_->report;
}

}  // namespace skerry
