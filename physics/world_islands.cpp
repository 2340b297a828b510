// SPDX-License-Identifier: MIT
//
// The stages of a step between pairs and motion: which contacts belong to it, the islands that they make, and
// the steps of those that have to be made.
#include <algorithm>
#include <cmath>

#include "physics/contact_batch.h"
#include "physics/narrowphase/chain.h"
#include "physics/share_islands.h"
#include "physics/stepping/coming_to_rest.h"
#include "physics/stepping/flow_work.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/motion_breaks.h"
#include "physics/stepping/one_piece.h"
#include "physics/stepping/one_piece_rule.h"
#include "physics/stepping/past_chains.h"
#include "physics/stepping/travel.h"
#include "physics/world_step.h"

namespace skerry {
namespace {

// Enough manifolds to be worth a thread's attention: about 50 us of work.
constexpr std::size_t kContactsPerChunk = 256;

// Contacts from which on an island may have all threads to itself.
constexpr std::size_t kLargeIsland = 1000;
// What a thread takes at a time of small islands: bodies that fly alone; a contact takes as long as some.
constexpr std::size_t kPiece = 64, kContactSize = 8;

// Rounds of a step after which islands that may flow do, and how many times the work of flow a round may cost
// for the next one to be exact, too.
constexpr int kExactRounds = 3;
constexpr double kDearRound = 10;

void clear(LinkCount& count) {
  count.narrow = {};
  count.reused = 0;
  count.relinked = false;
  count.newly.clear();
  count.disturbed.clear();
}

bool is_dynamic(const WorldState& s, std::uint32_t body) {
  return s.bodies.type[body] == BodyType::Dynamic;
}

/// The smallest separation that the manifold reports [m]; infinite: none.
double gap_of(const Contact& contact) {
  double gap = kInfinity;
  for (int i = 0; i < contact.manifold.count; ++i) gap = std::min(gap, contact.manifold.points[i].separation);
  return gap;
}

}  // namespace

/// The small table of who touches whom follows the contacts.
void Step::refresh_links() {
  if (!s_.table_changed) return;
  s_.links.clear();
  for (const Contact& contact : s_.contacts) s_.links.push_back(link_of(contact));
  s_.table_changed = false;
  graph_changed_ = true;
}

/// A pair belongs to the step if its shapes can meet within it. After the first round only pairs of dirty
/// bodies can become linked; islands that gained one are then the dirty ones.
void Step::link_contacts() {
  const auto start = now();
  const bool first = rounds_ == 0;
  newly_linked_ = false;
  refresh_links();
  // Chunks of neighbouring contacts: each contact is touched by one thread, counters are summed in chunk
  // order.
  std::vector<LinkCount>& counts = s_.scratch.counts;
  const std::size_t chunks = (s_.links.size() + kContactsPerChunk - 1) / kContactsPerChunk;
  if (counts.size() < std::max<std::size_t>(chunks, 1)) counts.resize(std::max<std::size_t>(chunks, 1));
  for (LinkCount& count : counts) clear(count);
  s_.pool->run(chunks, [&](std::size_t chunk) {
    const std::size_t from = chunk * kContactsPerChunk;
    const std::size_t to = std::min(from + kContactsPerChunk, s_.links.size());
    if (first) return link_together(from, to, counts[chunk]);
    for (std::size_t i = from; i < to; ++i) {
      const ContactLink& at = s_.links[i];
      if (s_.scratch.dirty[at.body_a] || s_.scratch.dirty[at.body_b])
        link(s_.contacts[i], first, counts[chunk]);
    }
  });
  while (wake_linked(first)) {
  }
  refresh_links();
  if (!first) s_.scratch.dirty.assign(s_.bodies.size(), 0);
  for (const LinkCount& count : counts) {
    s_.report.manifolds_reused += count.reused;
    s_.report.narrow += count.narrow;
    graph_changed_ |= count.relinked;
    for (const std::uint32_t body : count.newly) s_.scratch.dirty[body] = 1;
    newly_linked_ |= !count.newly.empty();
    for (const std::uint32_t body : count.disturbed) s_.kept[body] = 0;
  }
  ++rounds_;
  book(Stage::Narrow, start);
}

/// Sleeping islands that something can reach come back, as if they had been awake all the time; their own
/// contacts may reach others. @return false if there were none
bool Step::wake_linked(bool first) {
  if (s_.sleepers.none()) return false;
  refresh_links();
  std::vector<std::uint32_t> struck;
  for (std::size_t i = 0; i < s_.links.size(); ++i) {
    for (const std::uint32_t body : {s_.links[i].body_a, s_.links[i].body_b}) {
      if (s_.bodies.asleep[body] && s_.links[i].linked) struck.push_back(body);
    }
  }
  const std::vector<std::uint32_t> woken = s_.sleepers.wake(s_, struck);
  if (woken.empty()) return false;
  for (const std::uint32_t body : woken) {
    // In later rounds the last one left it where it is, off its fall.
    const double strayed = s_.strayed[body];
    begin(body);
    if (!first) s_.strayed[body] = strayed;
    s_.bodies.island[body] = -1;
    for (const std::uint32_t j : s_.joints_of[body]) begin_joint(j);
  }
  choose_joints();
  const auto middle = static_cast<std::ptrdiff_t>(s_.active.size());
  s_.active.insert(s_.active.end(), woken.begin(), woken.end());
  std::inplace_merge(s_.active.begin(), s_.active.begin() + middle, s_.active.end());
  LinkCount& count = s_.scratch.counts.front();
  for (Contact& contact : s_.contacts) {
    if (!contact.woken) continue;
    contact.woken = false;
    begin(contact);
    // In later rounds they are what the first would have made of them.
    if (first) link(contact, first, count);
  }
  return true;
}

/// Contacts of the first round. Boxes and discs go through the narrow phase in batches.
void Step::link_together(std::size_t from, std::size_t to, LinkCount& count) const {
  const auto settle = [&](Contact& contact) {
    set_linked(contact, gap_of(contact) < kInfinity || may_come_over(contact), count);
  };
  ManifoldRefresh manifolds(s_.config.skips, count.narrow, settle);
  for (std::size_t i = from; i < to; ++i) {
    const ContactLink& at = s_.links[i];
    // Two bodies that are where they were have the manifold that they had.
    if (s_.kept[at.body_a] && s_.kept[at.body_b]) {
      count.reused += !at.sensor;
      continue;
    }
    Contact& contact = s_.contacts[i];
    contact.woken = false;
    begin(contact);
    if (at.sensor) {
      set_linked(contact, false, count);
      continue;
    }
    const BodyBackup &a = s_.backup[at.body_a], &b = s_.backup[at.body_b];
    const bool made = manifolds.refresh(contact, s_.shapes[contact.shape_a].shape, {a.position, a.rotation},
                                        s_.shapes[contact.shape_b].shape, {b.position, b.rotation},
                                        margin_of(contact.body_a, contact.body_b));
    contact.manifold_reused = !made;
    count.reused += contact.manifold_reused;
  }
  manifolds.finish();
}

void Step::set_linked(Contact& contact, bool linked, LinkCount& count) const {
  count.relinked |= contact.linked != linked;
  contact.linked = linked;
  note_linked(contact);
  if (!linked) return;
  // What rests on a body that moves, or was moved, has to be looked at.
  for (const std::uint32_t body : {contact.body_a, contact.body_b}) {
    if (is_dynamic(s_, body) && s_.kept[body]) count.disturbed.push_back(body);
  }
}

/// Unless the small table will be made anew.
void Step::note_linked(const Contact& contact) const {
  if (!s_.table_changed)
    s_.links[static_cast<std::size_t>(&contact - s_.contacts.data())].linked = contact.linked;
}

void Step::link(Contact& contact, bool first, LinkCount& count) const {
  if (first) {
    begin(contact);
    const bool near =
        !contact.sensor && (make_manifold(contact, count) < kInfinity || may_come_over(contact));
    return set_linked(contact, near, count);
  }
  if (contact.sensor || contact.linked) return;
  // The paths are known now: shapes that were farther apart than both went cannot have met.
  const double paths = closest_approach(contact.body_a, contact.body_b);
  const double gap = make_manifold(contact, count);
  // Beyond the end of a segment its neighbour has the corner between them; on its way it may come over it.
  const bool may_meet = gap == kInfinity ? may_come_over(contact) : gap <= paths + s_.config.touch_tolerance;
  if (!may_meet || !meet_deeply(contact)) return;
  contact.linked = count.relinked = true;
  note_linked(contact);
  count.newly.insert(count.newly.end(), {contact.body_a, contact.body_b});
}

/// The manifold where the step begins. @return its smallest gap [m], infinite if the shapes are farther apart
/// than the step can bring them
double Step::make_manifold(Contact& contact, LinkCount& count) const {
  const BodyBackup& a = s_.backup[contact.body_a];
  const BodyBackup& b = s_.backup[contact.body_b];
  contact.manifold_reused = !refresh_manifold(
      contact, s_.shapes[contact.shape_a].shape, {a.position, a.rotation}, s_.shapes[contact.shape_b].shape,
      {b.position, b.rotation}, margin_of(contact.body_a, contact.body_b), s_.config.skips, count.narrow);
  count.reused += contact.manifold_reused;
  return gap_of(contact);
}

/// A corner that leaves a segment of a chain is a point of the next one only once it is past the corner
/// between the two, and until then the next has none: whether it is near as well, by boxes.
bool Step::may_come_over(const Contact& contact) const {
  if (contact.manifold.count > 0) return false;
  const bool a_chain = s_.shapes[contact.shape_a].shape->kind == ShapeKind::Chain;
  if (!a_chain && s_.shapes[contact.shape_b].shape->kind != ShapeKind::Chain) return false;
  const Shape& chain = s_.shapes[a_chain ? contact.shape_a : contact.shape_b].shape;
  const BodyBackup& at = s_.backup[a_chain ? contact.body_a : contact.body_b];
  const Aabb& other = s_.start_box[a_chain ? contact.shape_b : contact.shape_a];
  const Transform pose{at.position, at.rotation};
  const double margin = margin_of(contact.body_a, contact.body_b);
  if (!overlap(grown(chain_segment_box(chain, contact.child, pose), margin), other)) return false;
  const auto segment = static_cast<std::size_t>(contact.child);
  const Vec2 n = rotate(at.rotation, chain.normals[segment]);
  const Vec2 half = 0.5 * (other.upper - other.lower);
  const double height = dot(n, 0.5 * (other.lower + other.upper) - to_world(pose, chain.vertices[segment]));
  const double reach = std::abs(n.x) * half.x + std::abs(n.y) * half.y;
  return height - reach < margin && height + reach > -margin;
}

void Step::find_islands() {
  std::vector<IslandEdge>& edges = s_.scratch.edges;
  edges.clear();
  for (std::uint32_t i = 0; i < s_.links.size(); ++i) {
    const ContactLink& at = s_.links[i];
    if (!at.linked) continue;
    edges.push_back({at.body_a, at.body_b, is_dynamic(s_, at.body_a), is_dynamic(s_, at.body_b), i, false});
  }
  for (const std::uint32_t i : s_.active_joints) {
    const JointRecord& joint = s_.joints[i];
    const bool ground = !joint.def.a;
    const std::uint32_t a = ground ? joint.def.b.index : joint.def.a.index;
    edges.push_back(
        {a, joint.def.b.index, !ground && is_dynamic(s_, a), is_dynamic(s_, joint.def.b.index), i, true});
  }
  // The lists of islands that are gone serve for the new ones.
  std::vector<Island>& graph = s_.scratch.graph;
  s_.island_builder.build(s_.awake, edges, graph);
  if (rounds_ > 1) s_.scratch.last_round.swap(s_.islands);
  s_.islands.resize(graph.size());
  share_each(s_.pool.get(), graph.size(), kIslandsAPiece, [&](std::size_t n) {
    for (std::size_t k = 0; k < graph[n].bodies.size(); ++k) {
      s_.local_index[graph[n].bodies[k]] = static_cast<std::int32_t>(k);
      s_.bodies.island[graph[n].bodies[k]] = static_cast<std::int32_t>(n);
    }
    std::swap(s_.islands[n].island, graph[n]);
    s_.islands[n].kept = false;
  });
  s_.graph_bodies = s_.awake;
  s_.graph_joints = s_.active_joints;
}

void Step::step_islands() {
  const auto start = now();
  const bool known = rounds_ == 1 && !graph_changed_ && s_.graph_known && s_.awake == s_.graph_bodies &&
                     s_.active_joints == s_.graph_joints;
  if (!known) find_islands();
  if (rounds_ > 1) give_exact_rounds_up();
  graph_changed_ = false;
  // Until the step is through: what throws leaves islands behind that mean nothing.
  s_.graph_known = false;

  if (rounds_ == 1) {
    share_islands(s_, [&](SteppedIsland& island, ThreadPool* threads) {
      island.kept = known && stays(island);
      if (!island.kept) prepare(island, threads);
    });
  }
  // What later rounds prepare one island after the other all threads may share.
  s_.island_threads = s_.pool.get();
  std::vector<std::size_t>& to_step = s_.scratch.to_step;
  to_step.clear();
  auto last = s_.scratch.last_round.begin();
  for (std::size_t n = 0; n < s_.islands.size(); ++n) {
    SteppedIsland& island = s_.islands[n];
    if (rounds_ == 1) {
      if (island.kept || island.flew_alone || reuse_resting(s_, island.island, h_, island.result())) continue;
    } else {
      const std::vector<std::uint32_t>& bodies = island.island.bodies;
      const auto is_dirty = [this](std::uint32_t i) { return s_.scratch.dirty[i] != 0; };
      const bool same = std::none_of(bodies.begin(), bodies.end(), is_dirty);
      // The same bodies as before: a merger would have made them dirty. Both lists are in their order.
      while (same && last->island.bodies.front() < bodies.front()) ++last;
      island.again = !same || (!last->flew_alone && last->result().unmoved);
      if (!island.again) {
        std::swap(island.outcome, last->outcome);
        island.flew_alone = last->flew_alone;
        island.kept = last->kept;
        continue;
      }
      prepare_again(island);
      if (island.flew_alone) continue;
    }
    to_step.push_back(n);
  }
  if (rounds_ > 1) count_last_round();
  s_.island_threads = nullptr;
  book(Stage::Islands, start);
  // Islands share nothing that is written, so their order does not matter.
  const auto step = [&](std::size_t k) {
    SteppedIsland& island = s_.islands[to_step[k]];
    IslandResult& result = island.result();
    if (!stop_if_slow(s_, island.island, h_, result)) {
      follow_jump(s_, island.island, StepEnd::Beginning, h_, result);
      s_.stepper->step(s_, island.island, h_, result);
      follow_jump(s_, island.island, StepEnd::End, h_, result);
    }
    put_in_front_of_chains(s_, island.island, h_, result);
    note_slowness(s_, island.island, h_, result);
    note_parted(s_, island.island, h_, result);
  };
  if (s_.field && s_.field_threads == FieldThreads::One) {
    // A callback is asked in one order, by one thread.
    for (std::size_t k = 0; k < to_step.size(); ++k) step(k);
  } else {
    const std::size_t large = put_large_ones_first(to_step);
    s_.island_threads = s_.pool.get();
    for (std::size_t k = 0; k < large; ++k) step(k);
    s_.island_threads = nullptr;
    const std::vector<std::size_t>& pieces = cut_into_pieces(to_step, large);
    s_.pool->run(pieces.size() - 1, [&](std::size_t piece) {
      for (std::size_t k = pieces[piece]; k < pieces[piece + 1]; ++k) step(k);
    });
  }
  s_.graph_known = true;
}

/// Islands with more contacts and joints than a thread's share of all would keep the others waiting: they go
/// first, one after the other, and threads share their loops. @return how many there are
std::size_t Step::put_large_ones_first(std::vector<std::size_t>& to_step) const {
  const auto threads = static_cast<std::size_t>(s_.pool->threads());
  if (threads == 1) return 0;
  const auto size = [this](std::size_t n) {
    return s_.islands[n].island.contacts.size() + s_.islands[n].island.joints.size();
  };
  std::size_t all = 0;
  for (const std::size_t n : to_step) all += size(n);
  const auto end = std::stable_partition(to_step.begin(), to_step.end(), [&](std::size_t n) {
    return size(n) >= kLargeIsland && size(n) * threads > all;
  });
  return static_cast<std::size_t>(end - to_step.begin());
}

/// Small islands that follow each other, whose bodies often lie side by side, are for one thread: where two
/// write in turn what shares a cache line, it goes to and fro. @return where pieces begin, and the end
const std::vector<std::size_t>& Step::cut_into_pieces(const std::vector<std::size_t>& to_step,
                                                      std::size_t from) {
  std::vector<std::size_t>& pieces = s_.scratch.pieces;
  pieces.assign(1, from);
  std::size_t size = 0;
  for (std::size_t k = from; k < to_step.size(); ++k) {
    const Island& island = s_.islands[to_step[k]].island;
    size += island.bodies.size() + kContactSize * (island.contacts.size() + island.joints.size());
    if (size < kPiece && k + 1 < to_step.size()) continue;
    pieces.push_back(k + 1);
    size = 0;
  }
  return pieces;
}

/// A later round found nothing that met but what is known already: the islands are right as they are.
bool Step::is_through() const {
  return rounds_ > 1 && !newly_linked_ && !graph_changed_ &&
         std::none_of(s_.islands.begin(), s_.islands.end(), [](const SteppedIsland& island) {
           return !island.flew_alone && island.result().unmoved;
         });
}

/// A blow that spreads by a layer of bodies a round throws the work of each round away: where that was dear,
/// the next one goes in flow.
void Step::give_exact_rounds_up() {
  for (const SteppedIsland& last : s_.scratch.last_round) {
    const std::vector<std::uint32_t>& bodies = last.island.bodies;
    // What bounces well goes exactly for as many rounds as it takes, while all of them together are not dear.
    const bool bounces = !last.flew_alone && last.result().bounces_well;
    const double usual = usual_flow_work(s_) * static_cast<double>(bodies.size());
    const double visits =
        last.flew_alone ? 0 : last.result().work.visits + (bounces ? last.result().thrown_away.visits : 0);
    const bool dear = visits > kDearRound * usual;
    if (!dear && (bounces || rounds_ <= kExactRounds)) continue;
    // What met nothing is made again where it did not move, and has the same exact answer, if it has one.
    const bool vain = !last.flew_alone && last.result().unmoved && !last.result().one_piece;
    if (!vain &&
        std::none_of(bodies.begin(), bodies.end(), [this](std::uint32_t i) { return s_.scratch.dirty[i]; }))
      continue;
    for (const std::uint32_t i : bodies) {
      s_.step_memory[i].flow = kMustFlow;
      if (dear) wait_after_failure(s_, last.island, s_.step_memory[i]);
    }
  }
}

/// What islands took that are stepped again is part of what their bodies' islands take.
void Step::count_last_round() {
  for (const SteppedIsland& last : s_.scratch.last_round) {
    if (last.flew_alone) continue;
    const SteppedIsland& now =
        s_.islands[static_cast<std::size_t>(s_.bodies.island[last.island.bodies.front()])];
    if (!now.again || now.flew_alone) continue;
    SolveWork& thrown_away = now.result().thrown_away;
    thrown_away += last.result().thrown_away;
    thrown_away += last.result().work;
  }
}

/// Known to change nothing, and neither its bodies nor what they lean on changed since.
bool Step::stays(const SteppedIsland& island) const {
  if (!may_keep_ || island.flew_alone || !island.result().at_rest) return false;
  const std::vector<std::uint32_t>& bodies = island.island.bodies;
  if (!std::all_of(bodies.begin(), bodies.end(), [this](std::uint32_t i) { return s_.kept[i] != 0; }))
    return false;
  return std::all_of(island.island.joints.begin(), island.island.joints.end(), [this](std::uint32_t i) {
    const JointDef& def = s_.joints[i].def;
    return (!def.a || s_.kept[def.a.index]) && s_.kept[def.b.index];
  });
}

/// Whether an island is one body in free flight of which nothing is asked, and no counter runs on.
bool Step::flies_alone(const Island& island) const {
  return island.bodies.size() == 1 && is_in_flight(s_, island) && !s_.observe.paths &&
         s_.step_memory[island.bodies.front()] == StepMemory{};
}

/// Ready to be stepped; a body that flies alone is through.
void Step::set_off(SteppedIsland& island) const {
  island.flew_alone = flies_alone(island.island);
  if (island.flew_alone)
    fly(s_, island.island.bodies.front(), 0, h_);
  else
    island.begin();
}

/// For the first try of a step.
void Step::prepare(SteppedIsland& island, ThreadPool* threads) const {
  for (const std::uint32_t i : island.island.bodies) {
    s_.kept[i] = 0;
    // What was kept has this of an earlier step.
    s_.travelled[i] = s_.strayed[i] = 0;
  }
  set_off(island);
  const std::vector<std::uint32_t>& contacts = island.island.contacts;
  share(threads, contacts.size(), kContactsPerChunk, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      Contact& contact = s_.contacts[contacts[k]];
      if (contact.begun == s_.steps + 1) continue;
      // Its two bodies are where they were.
      begin(contact);
      contact.manifold_reused = true;
    }
  });
  const std::vector<std::uint32_t>& joints = island.island.joints;
  share_each(threads, joints.size(), kBodiesAPiece, [&](std::size_t k) { begin_joint(joints[k]); });
}

/// A second try begins from the contacts of the beginning of the step.
void Step::prepare_again(SteppedIsland& island) {
  ++s_.report.island_retries;
  s_.went.resize(s_.bodies.size());
  for (const std::uint32_t i : island.island.bodies)
    s_.went[i] = {s_.travelled[i], s_.strayed[i], s_.bodies.position[i], s_.bodies.angle[i]};
  restore(island.island.bodies);
  for (const std::uint32_t i : island.island.bodies) s_.kept[i] = 0;
  set_off(island);
  const std::vector<std::uint32_t>& contacts = island.island.contacts;
  share(s_.pool.get(), contacts.size(), kContactsPerChunk, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      Contact& contact = s_.contacts[contacts[k]];
      if (contact.begun != s_.steps + 1) begin(contact);
      for (std::size_t point = 0; point < contact.points.size(); ++point)
        contact.points[point] = {contact.points_at_start[point], 0, 0, 0, {}, {}};
      match_points(contact);
      contact.impulse = contact.impact = {};
      contact.hit = false;
      contact.hit_speed = 0;
    }
  });
  // Their forces go on from those of the last try, which are nearer to what will be.
  const std::vector<std::uint32_t>& joints = island.island.joints;
  share_each(s_.pool.get(), joints.size(), kBodiesAPiece, [&](std::size_t k) { begin_joint(joints[k]); });
  s_.report.manifolds_reused += update_manifolds(s_, island.island, 0, s_.report.narrow);
}

}  // namespace skerry
