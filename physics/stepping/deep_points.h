// SPDX-License-Identifier: MIT
//
// Points of an island in one piece that nothing was to close, and that an answer without them closes.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <vector>

#include "physics/stepping/touching.h"
#include "physics/thread_pool.h"
#include "physics/world_state.h"

namespace skerry {

/// Chooses points that are not chosen and end deep. @param share  of the smaller body: deeper than that
/// @param moves  (body, point) -> how far the body takes the point [m] @param points  a bit each, by contact
/// @return whether there are any
template <class Moves>
bool add_deep_points(const WorldState& state, const Island& island, double share, const Moves& moves,
                     std::vector<std::uint8_t>& points) {
  // Contacts that a thread takes at a time.
  constexpr std::size_t kContactsAPiece = 256;
  std::atomic<bool> any = false;
  share_each(state.island_threads, points.size(), kContactsAPiece, [&](std::size_t k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    for (int i = 0; i < contact.manifold.count; ++i) {
      if (points[k] & (1u << i)) continue;
      const ManifoldPoint& point = contact.manifold.points[i];
      const Vec2 closer = moves(contact.body_b, point.position) - moves(contact.body_a, point.position);
      const double end = point.separation + dot(contact.manifold.normal, closer);
      const double size =
          std::min(size_in_island(state, contact.body_a), size_in_island(state, contact.body_b));
      if (!(end < -share * size)) continue;
      points[k] |= 1u << i;
      any.store(true, std::memory_order_relaxed);
    }
  });
  return any;
}

}  // namespace skerry
