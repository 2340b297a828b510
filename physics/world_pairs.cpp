// SPDX-License-Identifier: MIT
//
// The stage of a step that finds pairs: boxes that bound the motion -> broad phase -> contact table.
#include <algorithm>
#include <tuple>
#include <type_traits>

#include "physics/narrowphase/chain.h"
#include "physics/spare.h"
#include "physics/world_step.h"

namespace skerry {
namespace {

/// Neighbouring contacts that stay neighbours: where they are in the table, and where they go.
struct ContactRun {
  std::size_t from, to, count;
};

/// A contact that is new, and where it goes in the table.
struct FreshContact {
  ContactKey key;
  std::size_t place;
};

/// Each contact moves once at most. A run that goes to the front lands behind where those before it were, so
/// such runs can be moved first, from the front; the others then from the back.
template <class Row>
void move_runs(std::vector<Row>& table, const std::vector<ContactRun>& runs) {
  static_assert(std::is_trivially_copyable_v<Row>);
  const auto at = [&](std::size_t i) { return table.begin() + static_cast<std::ptrdiff_t>(i); };
  for (const ContactRun& run : runs) {
    if (run.to < run.from) std::copy(at(run.from), at(run.from + run.count), at(run.to));
  }
  for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
    if (run->to > run->from)
      std::copy_backward(at(run->from), at(run->from + run->count), at(run->to + run->count));
  }
}

}  // namespace

/// Boxes where the step begins, and those that bound the motion.
void Step::find_pairs() {
  const auto start = now();
  s_.shape_moved.assign(s_.shapes.size(), 0);
  if (rounds_ == 0) {
    s_.start_box.resize(s_.shapes.size());
    share(s_.pool.get(), s_.active.size(), kBodiesAPiece, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) {
        const std::uint32_t body = s_.active[k];
        if (s_.kept[body]) continue;
        const Transform at{s_.backup[body].position, s_.backup[body].rotation};
        for (const std::uint32_t i : s_.shapes_of[body])
          s_.start_box[i] = bounding_box(s_.shapes[i].shape, at);
      }
    });
  }
  const bool moved = place_boxes(rounds_ == 0 ? s_.active : s_.scratch.left);
  s_.loose_shapes.clear();
  s_.broad_phase->moved_pairs(s_.pairs);
  if (rounds_ == 0) {
    expect_blows();
    if (!s_.scratch.left.empty()) add_pairs_of_expecting();
  }
  merge_pairs(moved);
  book(Stage::Broad, start);
}

/// A box that contains all that the shape can go through: never more than its reach, and where the body is
/// fast, what lies along its way.
Aabb Step::box_of(std::uint32_t shape, std::uint32_t body) const {
  const Aabb& start = s_.start_box[shape];
  const double margin = s_.config.contact_margin;
  const Aabb all = grown(start, s_.reach[body] + margin);
  // What was struck in the last step will be struck again, but by whom is not known before there are pairs.
  if (s_.flight[body] != FlightKind::Fast || (rounds_ == 0 && s_.stray_guess[body] == kInfinity)) return all;
  const Way& way = s_.way[body];
  const double turn = std::abs(way.omega) + h_ * std::abs(way.alpha);
  const double astray = margin + s_.allowance[body] + (turn > 0 ? h_ * turn * s_.radius[body] : 0);
  // A parabola lies between its control points.
  const Vec2 middle = 0.5 * h_ * way.v, end = h_ * (way.v + 0.5 * h_ * way.a);
  const auto low = [](double x, double y) { return std::min({0.0, x, y}); };
  const auto high = [](double x, double y) { return std::max({0.0, x, y}); };
  return {{std::max(all.lower.x, start.lower.x + low(middle.x, end.x) - astray),
           std::max(all.lower.y, start.lower.y + low(middle.y, end.y) - astray)},
          {std::min(all.upper.x, start.upper.x + high(middle.x, end.x) + astray),
           std::min(all.upper.y, start.upper.y + high(middle.y, end.y) + astray)}};
}

/// @return whether a box is new
bool Step::place_boxes(const std::vector<std::uint32_t>& bodies) {
  s_.box_updates.clear();
  bool moved = false;
  const BodyArrays& b = s_.bodies;
  Spare<std::vector<Aabb>> boxes;
  boxes->resize(s_.shapes.size());
  share(s_.pool.get(), bodies.size(), kBodiesAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      if (s_.kept[bodies[k]]) continue;
      for (const std::uint32_t i : s_.shapes_of[bodies[k]]) (*boxes)[i] = box_of(i, bodies[k]);
    }
  });
  for (const std::uint32_t body : bodies) {
    if (s_.kept[body]) continue;
    for (const std::uint32_t i : s_.shapes_of[body]) {
      ShapeRecord& shape = s_.shapes[i];
      Aabb box = (*boxes)[i];
      // What was found in this step already is not lost.
      if (rounds_ > 0) {
        box.lower = {std::min(box.lower.x, shape.box.lower.x), std::min(box.lower.y, shape.box.lower.y)};
        box.upper = {std::max(box.upper.x, shape.box.upper.x), std::max(box.upper.y, shape.box.upper.y)};
      }
      if (!shape.in_broad_phase) {
        s_.broad_phase->insert(i, box,
                               b.type[body] == BodyType::Static ? ProxyKind::Fixed : ProxyKind::Moving);
        shape.in_broad_phase = true;
      } else if (box.lower != shape.box.lower || box.upper != shape.box.upper ||
                 (rounds_ == 0 && s_.flight[body] == FlightKind::Fast)) {
        s_.box_updates.push_back({i, box});
      } else {
        continue;
      }
      shape.box = box;
      s_.shape_moved[i] = 1;
      moved = true;
    }
  }
  if (!s_.box_updates.empty()) s_.broad_phase->update(s_.box_updates);
  return moved;
}

/// Bodies that may be struck can meet more than those on their way.
void Step::add_pairs_of_expecting() {
  place_boxes(s_.scratch.left);
  std::vector<Pair>&more = s_.scratch.more, &pairs = s_.pairs;
  s_.broad_phase->moved_pairs(more);
  std::vector<PairLook>& looks = s_.scratch.looks;
  // Both are sorted; the larger boxes contain the others.
  const std::size_t before = pairs.size();
  auto known = pairs.begin();
  std::erase_if(more, [&](const Pair& pair) {
    while (known != pairs.end() && *known < pair) ++known;
    return known != pairs.end() && *known == pair;
  });
  pairs.resize(before + more.size());
  looks.resize(pairs.size());
  std::size_t to = pairs.size(), old = before;
  for (std::size_t k = more.size(); k-- > 0;) {
    for (; old > 0 && more[k] < pairs[old - 1]; --old) {
      --to;
      pairs[to] = pairs[old - 1];
      looks[to] = looks[old - 1];
    }
    pairs[--to] = more[k];
    looks[to] = look_at(more[k]);
  }
}

/// Contacts of boxes that did not change stay; the others are those that the broad phase reports.
void Step::merge_pairs(bool moved) {
  if (s_.pairs.empty() && !moved && s_.scratch.distant.empty()) return;
  refresh_links();
  if (rounds_ == 0 && are_pairs_of_table()) return;
  std::vector<ContactKey>& wanted = s_.scratch.wanted;
  wanted.clear();
  // Those that the last rounds left out; the others of a box that is new are reported again.
  std::vector<Pair>& distant = s_.scratch.distant;
  std::erase_if(distant, [&](const Pair& pair) {
    if (s_.shape_moved[pair.low] || s_.shape_moved[pair.high]) return true;
    if (rounds_ > 0 && !s_.scratch.dirty[s_.shapes[pair.low].body.index] &&
        !s_.scratch.dirty[s_.shapes[pair.high].body.index]) {
      return false;
    }
    if (!is_near(pair, look_at(pair))) return false;
    add_wanted(pair);
    return true;
  });
  const bool unsorted = !wanted.empty();
  Spare<std::vector<PairVerdict>> verdicts;
  if (rounds_ == 0) judge_pairs(*verdicts);
  auto known = s_.links.begin();
  for (std::size_t k = 0; k < s_.pairs.size(); ++k) {
    const Pair& pair = s_.pairs[k];
    if (rounds_ > 0) {
      // Contacts stay to the end of the step.
      while (known != s_.links.end() && known->pair() < pair) ++known;
      if (known != s_.links.end() && known->pair() == pair && !is_chain(pair)) continue;
    }
    const PairVerdict verdict = rounds_ == 0 ? (*verdicts)[k] : judge(pair, look_at(pair));
    if (verdict == PairVerdict::Near) wanted.push_back({pair.low, pair.high, 0});
    if (verdict == PairVerdict::NearChain) add_wanted(pair);
    if (verdict == PairVerdict::Distant) distant.push_back(pair);
  }
  if (unsorted) std::sort(wanted.begin(), wanted.end());
  if (rounds_ > 0) {
    const auto is_there = [](const ContactLink& link, const ContactKey& key) { return link.key() < key; };
    auto place = s_.links.begin();
    std::erase_if(wanted, [&](const ContactKey& key) {
      place = std::lower_bound(place, s_.links.end(), key, is_there);
      return place != s_.links.end() && place->key() == key;
    });
    if (wanted.empty()) return;
  }
  // Contacts are large, so it is found out first where each of them goes, and runs of them move at once.
  Spare<std::vector<ContactRun>> runs;
  Spare<std::vector<FreshContact>> fresh;
  std::vector<Contact>& table = s_.contacts;
  std::vector<ContactLink>& links = s_.links;
  std::size_t old = 0, place = 0;
  const auto keep = [&] {
    if (runs->empty() || runs->back().from + runs->back().count != old ||
        runs->back().to + runs->back().count != place) {
      runs->push_back({old, place, 0});
    }
    ++runs->back().count;
    ++old;
    ++place;
  };
  const auto pass = [&] {
    if (rounds_ > 0 || (!s_.shape_moved[links[old].shape_a] && !s_.shape_moved[links[old].shape_b]))
      return keep();
    if (table[old].touched) s_.scratch.lost.push_back(table[old]);
    ++old;
  };
  for (const ContactKey& key : wanted) {
    while (old < links.size() && links[old].key() < key) pass();
    if (old < links.size() && links[old].key() == key) {
      keep();
    } else {
      fresh->push_back({key, place++});
    }
  }
  while (old < links.size()) pass();
  if (place == table.size() && fresh->empty()) return;
  graph_changed_ = true;
  table.resize(std::max(place, table.size()));
  links.resize(table.size());
  move_runs(table, *runs);
  move_runs(links, *runs);
  for (const FreshContact& contact : *fresh) {
    table[contact.place] = make_contact(contact.key);
    links[contact.place] = link_of(table[contact.place]);
  }
  table.resize(place);
  links.resize(place);
}

PairVerdict Step::judge(const Pair& pair, const PairLook& look) const {
  if (!look.may_touch) return PairVerdict::Never;
  if (!is_near(pair, look)) return PairVerdict::Distant;
  return look.chain ? PairVerdict::NearChain : PairVerdict::Near;
}

/// What the first round makes of each pair.
void Step::judge_pairs(std::vector<PairVerdict>& verdicts) const {
  verdicts.resize(s_.pairs.size());
  share(s_.pool.get(), verdicts.size(), kPairsAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) verdicts[k] = judge(s_.pairs[k], s_.scratch.looks[k]);
  });
}

/// Every pair has its contact already, and every contact its pair: nothing comes or goes.
bool Step::are_pairs_of_table() const {
  if (!s_.scratch.distant.empty() || s_.pairs.size() != s_.contacts.size()) return false;
  for (std::size_t k = 0; k < s_.pairs.size(); ++k) {
    const Pair& pair = s_.pairs[k];
    const PairLook& look = s_.scratch.looks[k];
    if (s_.links[k].pair() != pair || look.chain || !look.may_touch || !is_near(pair, look)) {
      return false;
    }
  }
  return true;
}

bool Step::is_chain(const Pair& pair) const {
  return s_.shapes[pair.low].shape.kind == ShapeKind::Chain ||
         s_.shapes[pair.high].shape.kind == ShapeKind::Chain;
}

/// One contact, or one for each near segment of a chain.
void Step::add_wanted(const Pair& pair) {
  std::vector<ContactKey>& wanted = s_.scratch.wanted;
  const ShapeRecord& a = s_.shapes[pair.low];
  const ShapeRecord& b = s_.shapes[pair.high];
  const bool a_chain = a.shape.kind == ShapeKind::Chain;
  const bool b_chain = b.shape.kind == ShapeKind::Chain;
  if (a_chain == b_chain) {
    // Terrain does not meet terrain.
    if (!a_chain) wanted.push_back({pair.low, pair.high, 0});
    return;
  }
  const ShapeRecord& chain = a_chain ? a : b;
  const BodyBackup& at = s_.backup[chain.body.index];
  const double reach = s_.reach[chain.body.index] + s_.config.contact_margin;
  chain_segments_near(chain.shape, {at.position, at.rotation}, grown((a_chain ? b : a).box, reach),
                      s_.scratch.segments);
  for (const int segment : s_.scratch.segments) {
    wanted.push_back({pair.low, pair.high, segment});
  }
}

bool Step::may_touch(const ShapeRecord& a, const ShapeRecord& b) const {
  if (a.body == b.body || !may_collide(a.filter, b.filter)) return false;
  const bool dynamic =
      s_.bodies.type[a.body.index] == BodyType::Dynamic || s_.bodies.type[b.body.index] == BodyType::Dynamic;
  if (!dynamic && !a.sensor && !b.sensor) return false;
  for (const std::uint32_t j : s_.joints_of[b.body.index]) {
    const JointDef& def = s_.joints[j].def;
    if (!def.collide && (def.a == a.body || def.b == a.body)) return false;
  }
  return true;
}

Contact Step::make_contact(const ContactKey& key) const {
  Contact contact;
  std::tie(contact.shape_a, contact.shape_b, contact.child) = key;
  const ShapeRecord& a = s_.shapes[contact.shape_a];
  const ShapeRecord& b = s_.shapes[contact.shape_b];
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

}  // namespace skerry
