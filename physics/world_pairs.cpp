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

/// Each contact moves once at most. A run that goes to the front lands behind where those before it were, so
/// such runs can be moved first, from the front; the others then from the back.
void move_runs(std::vector<Contact>& table, const std::vector<ContactRun>& runs) {
  static_assert(std::is_trivially_copyable_v<Contact>);
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

void Step::find_pairs() {
  const auto start = now();
  s_.box_updates.clear();
  s_.shape_moved.assign(s_.shapes.size(), 0);
  bool moved = false;
  const BodyArrays& b = s_.bodies;
  for (const std::uint32_t body : s_.active) {
    if (s_.kept[body]) continue;
    const BodyBackup& from = s_.backup[body];
    for (const std::uint32_t i : s_.shapes_of[body]) {
      ShapeRecord& shape = s_.shapes[i];
      const Aabb box = grown(bounding_box(shape.shape, {from.position, from.rotation}),
                             s_.reach[body] + s_.config.contact_margin);
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
  s_.loose_shapes.clear();
  if (!s_.box_updates.empty()) s_.broad_phase->update(s_.box_updates);
  s_.broad_phase->moved_pairs(s_.pairs);
  if (rounds_ == 0) expect_blows();
  merge_pairs(moved);
  book(Stage::Broad, start);
}

/// Contacts of boxes that did not change stay; the others are those that the broad phase reports.
void Step::merge_pairs(bool moved) {
  if (s_.pairs.empty() && !moved && s_.scratch.distant.empty()) return;
  if (are_pairs_of_table()) return;
  std::vector<ContactKey>& wanted = s_.scratch.wanted;
  wanted.clear();
  // Those that the last rounds left out; the others of a box that is new are reported again.
  std::vector<Pair>& distant = s_.scratch.distant;
  std::erase_if(distant, [&](const Pair& pair) {
    if (s_.shape_moved[pair.low] || s_.shape_moved[pair.high]) return true;
    if (!is_near(pair, look_at(pair))) return false;
    add_wanted(pair);
    return true;
  });
  const bool unsorted = !wanted.empty();
  for (std::size_t k = 0; k < s_.pairs.size(); ++k) {
    const Pair& pair = s_.pairs[k];
    if (!may_touch(pair)) continue;
    if (is_near(pair, rounds_ == 0 ? s_.scratch.looks[k] : look_at(pair)))
      add_wanted(pair);
    else
      distant.push_back(pair);
  }
  if (unsorted) std::sort(wanted.begin(), wanted.end());
  // Contacts are large, so it is found out first where each of them goes, and runs of them move at once.
  Spare<std::vector<ContactRun>> runs;
  Spare<std::vector<std::size_t>> fresh_places;
  std::vector<Contact>& fresh = s_.scratch.fresh;
  fresh.clear();
  std::vector<Contact>& table = s_.contacts;
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
    if (!s_.shape_moved[table[old].shape_a] && !s_.shape_moved[table[old].shape_b]) return keep();
    if (table[old].touched) s_.scratch.lost.push_back(table[old]);
    ++old;
  };
  for (const ContactKey& key : wanted) {
    while (old < table.size() && table[old].key() < key) pass();
    if (old < table.size() && table[old].key() == key) {
      keep();
    } else {
      fresh.push_back(make_contact(key));
      fresh_places->push_back(place++);
    }
  }
  while (old < table.size()) pass();
  if (place == table.size() && fresh.empty()) return;
  s_.table_changed = true;
  table.resize(std::max(place, table.size()));
  move_runs(table, *runs);
  for (std::size_t k = 0; k < fresh.size(); ++k) table[(*fresh_places)[k]] = fresh[k];
  table.resize(place);
}

/// Every pair has its contact already, and every contact its pair: nothing comes or goes.
bool Step::are_pairs_of_table() const {
  if (!s_.scratch.distant.empty() || s_.pairs.size() != s_.contacts.size()) return false;
  for (std::size_t k = 0; k < s_.pairs.size(); ++k) {
    const Pair& pair = s_.pairs[k];
    const Contact& contact = s_.contacts[k];
    if (contact.shape_a != pair.low || contact.shape_b != pair.high ||
        s_.shapes[pair.low].shape.kind == ShapeKind::Chain ||
        s_.shapes[pair.high].shape.kind == ShapeKind::Chain || !may_touch(pair) ||
        !is_near(pair, rounds_ == 0 ? s_.scratch.looks[k] : look_at(pair))) {
      return false;
    }
  }
  return true;
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

bool Step::may_touch(const Pair& pair) const {
  const ShapeRecord& a = s_.shapes[pair.low];
  const ShapeRecord& b = s_.shapes[pair.high];
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
