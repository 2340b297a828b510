// SPDX-License-Identifier: MIT
//
// The contact table: which of the pairs that the broad phase found make a contact of the step, and where each
// contact stands.
#include <algorithm>
#include <span>
#include <tuple>
#include <type_traits>

#include "physics/narrowphase/chain.h"
#include "physics/spare.h"
#include "physics/world_access.h"
#include "physics/world_step.h"

namespace skerry {
namespace {

// With fewer contacts a second thread costs more than it moves.
constexpr std::size_t kManyContacts = 2048;

/// Neighbouring contacts that stay neighbours: where they are in the table, and where they go.
struct ContactRun {
  std::size_t from, to, count;
};

/// A contact that is new, and where it goes in the table.
struct FreshContact {
  ContactKey key;
  std::size_t place;
};

/// How the table changes.
struct TablePlan {
  std::vector<ContactRun> runs;
  std::vector<FreshContact> fresh;

  void clear() {
    runs.clear();
    fresh.clear();
  }
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

/// A part of the table that one thread fills: runs that come from within it, and rows that come from
/// elsewhere, `from` their place among the copies of those.
template <class Row>
struct TablePart {
  std::vector<ContactRun> inside, outside;
  std::vector<Row> copies;

  /// Of the runs that go to places from `first` on and before `last`.
  void choose(const std::vector<Row>& table, const std::vector<ContactRun>& runs, std::size_t first,
              std::size_t last) {
    inside.clear();
    outside.clear();
    copies.clear();
    const auto copy = [&](std::size_t from, std::size_t end, std::size_t to) {
      if (from >= end) return;
      outside.push_back({copies.size(), to, end - from});
      const auto at = [&](std::size_t i) { return table.begin() + static_cast<std::ptrdiff_t>(i); };
      copies.insert(copies.end(), at(from), at(end));
    };
    auto run = std::partition_point(runs.begin(), runs.end(),
                                    [&](const ContactRun& r) { return r.to + r.count <= first; });
    for (; run != runs.end() && run->to < last; ++run) {
      const std::size_t to = std::max(run->to, first), from = run->from + (to - run->to);
      const std::size_t end = from + (std::min(run->to + run->count, last) - to);
      const std::size_t begin_inside = std::clamp(first, from, end);
      const std::size_t end_inside = std::clamp(last, begin_inside, end);
      copy(from, begin_inside, to);
      if (begin_inside < end_inside)
        inside.push_back({begin_inside, to + (begin_inside - from), end_inside - begin_inside});
      copy(end_inside, end, to + (end_inside - from));
    }
  }
  void fill(std::vector<Row>& table) const {
    move_runs(table, inside);
    for (const ContactRun& run : outside)
      std::copy_n(copies.begin() + static_cast<std::ptrdiff_t>(run.from), run.count,
                  table.begin() + static_cast<std::ptrdiff_t>(run.to));
  }
};

template <class Row>
struct TableParts {
  std::vector<TablePart<Row>> all;
};

/// The same by several threads, where there are many. @param size  of the new table
template <class Row>
void move_runs(ThreadPool& pool, std::vector<Row>& table, const std::vector<ContactRun>& runs,
               std::size_t size) {
  const auto threads = static_cast<std::size_t>(pool.threads());
  if (threads == 1 || size < kManyContacts) return move_runs(table, runs);
  Spare<TableParts<Row>> parts;
  parts->all.resize(threads);
  const auto beginning_of = [&](std::size_t part) { return size * part / threads; };
  pool.run(threads, [&](std::size_t part) {
    parts->all[part].choose(table, runs, beginning_of(part), beginning_of(part + 1));
  });
  pool.run(threads, [&](std::size_t part) { parts->all[part].fill(table); });
}

/// What was apart where the step began, and is together again in a later round, has touched all the time.
void find_again(WorldState& s, const std::vector<FreshContact>& fresh) {
  std::vector<Contact>& lost = s.scratch.lost;
  for (std::size_t k = 0; k < fresh.size() && !lost.empty(); ++k) {
    ContactLink& link = s.links[fresh[k].place];
    const auto before = std::find_if(lost.begin(), lost.end(),
                                     [&](const Contact& contact) { return contact.key() == link.key(); });
    if (before == lost.end()) continue;
    link.touched = s.contacts[fresh[k].place].touched = true;
    lost.erase(before);
  }
}

}  // namespace

/// Contacts of boxes that did not change stay; the others are those that the broad phase reports.
void Step::merge_pairs(bool moved) {
  if (s_.pairs.empty() && !moved && s_.scratch.distant.empty()) return;
  refresh_links();
  if (rounds_ == 0 && are_pairs_of_table()) return;
  choose_wanted();
  if (rounds_ > 0) {
    drop_known(s_.scratch.wanted);
    if (s_.scratch.wanted.empty()) return;
  }
  update_table();
}

/// The contacts of the pairs that are near, by key.
void Step::choose_wanted() {
  std::vector<ContactKey>& wanted = s_.scratch.wanted;
  wanted.clear();
  Spare<std::vector<PairVerdict>> verdicts;
  // Those that the last rounds left out; the others of a box that is new are reported again.
  std::vector<Pair>& distant = s_.scratch.distant;
  judge_distant(*verdicts);
  std::size_t left = 0;
  for (std::size_t k = 0; k < distant.size(); ++k) {
    if ((*verdicts)[k] == PairVerdict::Distant)
      distant[left++] = distant[k];
    else if ((*verdicts)[k] != PairVerdict::Never)
      add_wanted(distant[k]);
  }
  distant.resize(left);
  const bool unsorted = !wanted.empty();
  judge_pairs(*verdicts);
  for (std::size_t k = 0; k < s_.pairs.size(); ++k) {
    const Pair& pair = s_.pairs[k];
    const PairVerdict verdict = (*verdicts)[k];
    if (verdict == PairVerdict::Near) wanted.push_back({pair.low, pair.high, 0});
    if (verdict == PairVerdict::NearChain) add_wanted(pair);
    if (verdict == PairVerdict::Distant) distant.push_back(pair);
  }
  if (unsorted) std::sort(wanted.begin(), wanted.end());
}

/// Those that the table has already.
void Step::drop_known(std::vector<ContactKey>& wanted) const {
  const auto is_there = [](const ContactLink& link, const ContactKey& key) { return link.key() < key; };
  auto place = s_.links.begin();
  std::erase_if(wanted, [&](const ContactKey& key) {
    place = std::lower_bound(place, s_.links.end(), key, is_there);
    return place != s_.links.end() && place->key() == key;
  });
}

/// Contacts are large, so it is found out first where each of them goes, and runs of them move at once.
void Step::update_table() {
  std::vector<Contact>& table = s_.contacts;
  std::vector<ContactLink>& links = s_.links;
  Spare<TablePlan> plan;
  std::size_t old = 0, place = 0;
  ContactRun run{0, 0, 0};
  const auto keep = [&] {
    if (run.from + run.count != old || run.to + run.count != place) {
      if (run.count > 0) plan->runs.push_back(run);
      run = {old, place, 0};
    }
    ++run.count;
    ++old;
    ++place;
  };
  const auto pass = [&] {
    if (rounds_ > 0 || (!s_.shape_moved[links[old].shape_a] && !s_.shape_moved[links[old].shape_b]))
      return keep();
    if (links[old].touched) s_.scratch.lost.push_back(table[old]);
    ++old;
  };
  for (const ContactKey& key : s_.scratch.wanted) {
    while (old < links.size() && links[old].key() < key) pass();
    if (old < links.size() && links[old].key() == key) {
      keep();
    } else {
      plan->fresh.push_back({key, place++});
    }
  }
  while (old < links.size()) pass();
  if (run.count > 0) plan->runs.push_back(run);
  if (place == table.size() && plan->fresh.empty()) return;
  graph_changed_ = true;
  resize_with_room(table, std::max(place, table.size()));
  resize_with_room(links, table.size());
  move_runs(*s_.pool, table, plan->runs, place);
  move_runs(*s_.pool, links, plan->runs, place);
  share(s_.pool.get(), plan->fresh.size(), kPairsAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      const FreshContact& contact = plan->fresh[k];
      table[contact.place] = make_contact(contact.key);
      links[contact.place] = link_of(table[contact.place]);
    }
  });
  table.resize(place);
  links.resize(place);
  if (rounds_ > 0) find_again(s_, plan->fresh);
}

/// Of a step that is undone: what touched before it still does, until a step that is through finds it apart.
void Step::put_back_lost() {
  std::vector<Contact>& table = s_.contacts;
  std::vector<Contact>& lost = s_.scratch.lost;
  if (lost.empty()) return;
  const auto middle = static_cast<std::ptrdiff_t>(table.size());
  table.insert(table.end(), lost.begin(), lost.end());
  std::inplace_merge(table.begin(), table.begin() + middle, table.end(),
                     [](const Contact& x, const Contact& y) { return x.key() < y.key(); });
  // Their boxes are apart already, and contacts of boxes that do not change would stay.
  for (const Contact& contact : lost)
    s_.shapes[contact.shape_a].pairs_changed = s_.shapes[contact.shape_b].pairs_changed = true;
  s_.table_changed = true;
  lost.clear();
}

PairVerdict Step::judge(const Pair& pair, const PairLook& look) const {
  if (!look.may_touch) return PairVerdict::Never;
  if (!is_near(pair, look)) return PairVerdict::Distant;
  return look.chain ? PairVerdict::NearChain : PairVerdict::Near;
}

/// What becomes of each pair. After the first round contacts stay to the end of the step.
void Step::judge_pairs(std::vector<PairVerdict>& verdicts) const {
  verdicts.resize(s_.pairs.size());
  share(s_.pool.get(), verdicts.size(), kPairsAPiece, [&](std::size_t from, std::size_t to) {
    if (rounds_ == 0) {
      for (std::size_t k = from; k < to; ++k) verdicts[k] = judge(s_.pairs[k], s_.scratch.looks[k]);
      return;
    }
    const auto before = [](const ContactLink& link, const Pair& pair) { return link.pair() < pair; };
    auto known = std::lower_bound(s_.links.begin(), s_.links.end(), s_.pairs[from], before);
    for (std::size_t k = from; k < to; ++k) {
      const Pair& pair = s_.pairs[k];
      while (known != s_.links.end() && known->pair() < pair) ++known;
      const bool stays = known != s_.links.end() && known->pair() == pair && !is_chain(pair);
      verdicts[k] = stays ? PairVerdict::Never : judge(pair, look_at(pair));
    }
  });
}

/// What becomes of the pairs that the last rounds left out.
void Step::judge_distant(std::vector<PairVerdict>& verdicts) const {
  const std::vector<Pair>& distant = s_.scratch.distant;
  verdicts.resize(distant.size());
  share(s_.pool.get(), verdicts.size(), kPairsAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      const Pair& pair = distant[k];
      if (s_.shape_moved[pair.low] || s_.shape_moved[pair.high]) {
        verdicts[k] = PairVerdict::Never;
        continue;
      }
      const bool as_before = rounds_ > 0 && !s_.scratch.dirty[s_.shapes[pair.low].body.index] &&
                             !s_.scratch.dirty[s_.shapes[pair.high].body.index];
      verdicts[k] = as_before || !is_near(pair, look_at(pair)) ? PairVerdict::Distant : PairVerdict::Near;
    }
  });
}

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
  return s_.shapes[pair.low].shape->kind == ShapeKind::Chain ||
         s_.shapes[pair.high].shape->kind == ShapeKind::Chain;
}

/// One contact, or one for each near segment of a chain.
void Step::add_wanted(const Pair& pair) {
  std::vector<ContactKey>& wanted = s_.scratch.wanted;
  const ShapeRecord& a = s_.shapes[pair.low];
  const ShapeRecord& b = s_.shapes[pair.high];
  const bool a_chain = a.shape->kind == ShapeKind::Chain;
  const bool b_chain = b.shape->kind == ShapeKind::Chain;
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

Contact Step::make_contact(const ContactKey& key) const {
  Contact contact;
  std::tie(contact.shape_a, contact.shape_b, contact.child) = key;
  const ShapeRecord& a = s_.shapes[contact.shape_a];
  const ShapeRecord& b = s_.shapes[contact.shape_b];
  contact.body_a = a.body.index;
  contact.body_b = b.body.index;
  mix_materials(contact, a, b);
  contact.sensor = a.sensor || b.sensor;
  return contact;
}

void mix_materials(Contact& contact, const ShapeRecord& a, const ShapeRecord& b) {
  contact.friction =
      mix(std::max(a.friction_rule, b.friction_rule), a.material.friction, b.material.friction);
  contact.static_friction = mix(std::max(a.friction_rule, b.friction_rule),
                                a.material.static_friction.value_or(a.material.friction),
                                b.material.static_friction.value_or(b.material.friction));
  contact.restitution =
      mix(std::max(a.restitution_rule, b.restitution_rule), a.material.restitution, b.material.restitution);
  contact.rolling_resistance = std::max(a.material.rolling_resistance, b.material.rolling_resistance);
  contact.surface_velocity = a.material.surface_velocity + b.material.surface_velocity;
}

}  // namespace skerry
