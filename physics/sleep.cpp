// SPDX-License-Identifier: MIT
#include "physics/sleep.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "physics/large_pages.h"
#include "physics/spare.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Contacts that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 4096;

bool by_contact_key(const Contact& x, const Contact& y) {
  return x.key() < y.key();
}

template <class T>
bool by_key(const T& x, const T& y) {
  return x.key < y.key;
}

/// Merges what was appended to the first `sorted` ones, which are sorted.
template <class T, class Less>
void merge_tail(std::vector<T>& all, std::size_t sorted, Less less) {
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(sorted);
  if (!std::is_sorted(middle, all.end(), less)) std::sort(middle, all.end(), less);
  std::inplace_merge(all.begin(), middle, all.end(), less);
}

/// Moves `more` into the sorted `all`.
template <class T, class Less>
void merge_in(std::vector<T>& all, std::vector<T> more, Less less) {
  const std::size_t sorted = all.size();
  std::move(more.begin(), more.end(), std::back_inserter(all));
  merge_tail(all, sorted, less);
}

SleepTotals count_contacts(const std::vector<Contact>& contacts) {
  SleepTotals t;
  for (const Contact& contact : contacts) {
    ++t.pairs;
    if (!contact.linked) {
      t.pairs_out_of_reach += contact.sensor ? 0 : 1;
      continue;
    }
    for (const PointMemory& memory : contact.points) {
      t.normal_impulse += memory.total_normal;
      t.friction_impulse += std::abs(memory.total_friction);
    }
    if (contact.touched) {
      ++t.contacts;
      t.contact_points += contact.manifold.count;
    }
    for (int i = 0; i < contact.manifold.count; ++i)
      t.worst_penetration = std::max(t.worst_penetration, -contact.manifold.points[i].separation);
  }
  return t;
}

}  // namespace

void Sleepers::grow(const WorldState& s) {
  place_of_.resize(s.bodies.size(), -1);
  held_.resize(s.bodies.size(), 0);
}

/// Counts the contacts and joints of the island at bodies that cannot sleep.
void Sleepers::hold(const WorldState& s, const SleepingIsland& island, int sign) {
  const auto count = [&](std::uint32_t body) {
    if (body != BodyId::kNone && s.bodies.type[body] != BodyType::Dynamic) held_[body] += sign;
  };
  for (const Contact& contact : island.contacts) {
    count(contact.body_a);
    count(contact.body_b);
  }
  for (const std::uint32_t joint : island.joints) {
    count(s.joints[joint].def.a.index);
    count(s.joints[joint].def.b.index);
  }
}

void Sleepers::put_to_sleep(WorldState& s, double h, std::vector<Candidate> candidates) {
  if (candidates.empty()) return;
  grow(s);
  h_ = h;
  std::vector<std::uint32_t> places;
  for (Candidate& candidate : candidates) {
    std::uint32_t place = static_cast<std::uint32_t>(islands_.size());
    if (free_places_.empty()) {
      islands_.emplace_back();
    } else {
      place = free_places_.back();
      free_places_.pop_back();
    }
    places.push_back(place);
    SleepingIsland& island = islands_[place];
    island.bodies = candidate.island->bodies;
    island.joints = candidate.island->joints;
    island.rest = std::move(candidate.rest);
    island.memories = std::move(candidate.memories);
    for (const std::uint32_t body : island.bodies) {
      place_of_[body] = static_cast<std::int32_t>(place);
      s.bodies.asleep[body] = 1;
      s.bodies.island[body] = -1;
      s.local_index[body] = -1;
      s.rests[body] = s.kept[body] = 0;
    }
  }
  std::erase_if(s.awake, [&](std::uint32_t body) { return s.bodies.asleep[body] != 0; });

  // A contact leaves with its bodies: when neither of them has to be looked at any more.
  std::sort(places.begin(), places.end());
  const auto newly = [&](std::uint32_t body) {
    return place_of_[body] >= 0 &&
           std::binary_search(places.begin(), places.end(), static_cast<std::uint32_t>(place_of_[body]));
  };
  const auto idle = [&](std::uint32_t body) {
    if (s.bodies.type[body] == BodyType::Dynamic) return s.bodies.asleep[body] != 0;
    return s.bodies.velocity[body] == Vec2{} && s.bodies.omega[body] == 0;
  };
  // They are large, too: counted first, they find memory of the right size.
  Spare<std::vector<std::int32_t>> keeper_of;
  keeper_of->resize(s.contacts.size());
  share(s.pool.get(), s.contacts.size(), kContactsAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      const std::uint32_t a = s.contacts[k].body_a, b = s.contacts[k].body_b;
      const bool leaves = idle(a) && idle(b) && (newly(a) || newly(b));
      (*keeper_of)[k] = leaves ? place_of_[newly(a) ? a : b] : -1;
    }
  });
  std::vector<std::size_t> count(islands_.size(), 0);
  for (const std::int32_t keeper : *keeper_of)
    if (keeper >= 0) ++count[static_cast<std::size_t>(keeper)];
  for (const std::uint32_t place : places) reserve_large(islands_[place].contacts, count[place]);
  s.table_changed = true;
  std::size_t left = 0;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    const Contact& contact = s.contacts[k];
    const std::int32_t keeper = (*keeper_of)[k];
    if (keeper < 0) {
      s.contacts[left++] = contact;
      continue;
    }
    const std::uint32_t a = contact.body_a, b = contact.body_b;
    const auto place = static_cast<std::uint32_t>(keeper);
    islands_[place].contacts.push_back(contact);
    const std::int32_t other = place_of_[newly(a) ? b : a];
    if (other >= 0 && other != keeper) {
      std::vector<std::uint32_t>& keepers = islands_[static_cast<std::size_t>(other)].keepers;
      if (std::find(keepers.begin(), keepers.end(), place) == keepers.end()) keepers.push_back(place);
    }
  }
  s.contacts.resize(left);
  for (const std::uint32_t place : places) {
    hold(s, islands_[place], 1);
    islands_[place].totals = count_contacts(islands_[place].contacts);
  }
  stale_totals_ = true;
}

std::vector<std::uint32_t> Sleepers::wake(WorldState& s, std::span<const std::uint32_t> bodies) {
  std::vector<std::uint32_t> places;
  for (const std::uint32_t body : bodies) {
    if (body < place_of_.size() && place_of_[body] >= 0)
      places.push_back(static_cast<std::uint32_t>(place_of_[body]));
  }
  return wake_places(s, std::move(places));
}

void Sleepers::wake_all(WorldState& s) {
  std::vector<std::uint32_t> places;
  for (std::uint32_t place = 0; place < islands_.size(); ++place) {
    if (!islands_[place].bodies.empty()) places.push_back(place);
  }
  wake_places(s, std::move(places));
}

void Sleepers::wake_at(WorldState& s, std::uint32_t body) {
  if (body >= held_.size() || held_[body] == 0) return;
  std::vector<std::uint32_t> places;
  for (std::uint32_t place = 0; place < islands_.size(); ++place) {
    const SleepingIsland& island = islands_[place];
    const bool touches = std::any_of(island.contacts.begin(), island.contacts.end(),
                                     [&](const Contact& c) { return c.body_a == body || c.body_b == body; });
    const bool jointed = std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t joint) {
      return s.joints[joint].def.a.index == body || s.joints[joint].def.b.index == body;
    });
    if (touches || jointed) places.push_back(place);
  }
  wake_places(s, std::move(places));
}

std::vector<std::uint32_t> Sleepers::wake_places(WorldState& s, std::vector<std::uint32_t> places) {
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  std::vector<std::uint32_t> bodies;
  if (places.empty()) return bodies;

  // Contacts are large: they go to the end of the table, where there is memory from before they slept.
  const std::size_t awake = s.contacts.size();
  std::size_t contacts = awake;
  for (const std::uint32_t place : places) contacts += islands_[place].contacts.size();
  reserve_large(s.contacts, contacts);
  std::vector<RestingIsland> resting;
  std::vector<IslandMemory> memories;
  for (const std::uint32_t place : places) {
    SleepingIsland& island = islands_[place];
    hold(s, island, -1);
    for (const std::uint32_t body : island.bodies) {
      place_of_[body] = -1;
      s.bodies.asleep[body] = 0;
    }
    bodies.insert(bodies.end(), island.bodies.begin(), island.bodies.end());
    s.contacts.insert(s.contacts.end(), island.contacts.begin(), island.contacts.end());
    resting.push_back(std::move(island.rest));
    std::move(island.memories.begin(), island.memories.end(), std::back_inserter(memories));
  }
  // What others keep of these bodies comes along.
  std::sort(bodies.begin(), bodies.end());
  const auto woke = [&](std::uint32_t body) {
    return std::binary_search(bodies.begin(), bodies.end(), body);
  };
  for (const std::uint32_t place : places) {
    for (const std::uint32_t keeper : islands_[place].keepers) {
      SleepingIsland& other = islands_[keeper];
      if (other.bodies.empty() || std::binary_search(places.begin(), places.end(), keeper)) continue;
      hold(s, other, -1);
      std::erase_if(other.contacts, [&](const Contact& contact) {
        if (!woke(contact.body_a) && !woke(contact.body_b)) return false;
        s.contacts.push_back(contact);
        return true;
      });
      hold(s, other, 1);
      other.totals = count_contacts(other.contacts);
    }
  }
  for (const std::uint32_t place : places) {
    islands_[place] = {};
    free_places_.push_back(place);
  }
  for (std::size_t k = awake; k < s.contacts.size(); ++k) s.contacts[k].woken = true;
  s.table_changed = true;
  merge_tail(s.contacts, awake, by_contact_key);
  merge_in(s.resting, std::move(resting), by_key<RestingIsland>);
  merge_in(s.memories, std::move(memories), by_key<IslandMemory>);
  merge_in(s.awake, bodies, std::less<>());
  stale_totals_ = true;
  return bodies;
}

const SleepTotals& Sleepers::totals() {
  if (!stale_totals_) return totals_;
  stale_totals_ = false;
  totals_ = {};
  for (const SleepingIsland& island : islands_) {
    if (island.bodies.empty()) continue;
    const SleepTotals& one = island.totals;
    ++totals_.islands;
    totals_.bodies += static_cast<int>(island.bodies.size());
    totals_.pairs += one.pairs;
    totals_.contacts += one.contacts;
    totals_.contact_points += one.contact_points;
    totals_.pairs_out_of_reach += one.pairs_out_of_reach;
    totals_.rows += island.rest.report.rows;
    totals_.friction_rows += island.rest.friction_rows;
    totals_.inexact += island.rest.report.status != SolveStatus::Solved;
    totals_.worst_residual = std::max(totals_.worst_residual, island.rest.report.residual);
    totals_.worst_penetration = std::max(totals_.worst_penetration, one.worst_penetration);
    totals_.normal_impulse += one.normal_impulse;
    totals_.friction_impulse += one.friction_impulse;
  }
  return totals_;
}

bool is_valid(const Sleepers& sleepers, const WorldState& s) {
  const std::size_t n = s.bodies.size();
  const std::size_t places = sleepers.islands_.size();
  const auto below = [](const std::vector<std::uint32_t>& list, std::size_t limit) {
    return std::all_of(list.begin(), list.end(), [limit](std::uint32_t i) { return i < limit; });
  };
  if (sleepers.place_of_.size() > n || sleepers.held_.size() != sleepers.place_of_.size()) return false;
  if (!below(sleepers.free_places_, places)) return false;
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t place = i < sleepers.place_of_.size() ? sleepers.place_of_[i] : -1;
    if (place < -1 || place >= static_cast<std::int64_t>(places) || (place >= 0) != (s.bodies.asleep[i] != 0))
      return false;
  }
  return std::all_of(sleepers.islands_.begin(), sleepers.islands_.end(), [&](const SleepingIsland& island) {
    return below(island.bodies, sleepers.place_of_.size()) && below(island.joints, s.joints.size()) &&
           below(island.keepers, places);
  });
}

}  // namespace skerry
