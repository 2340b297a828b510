// SPDX-License-Identifier: MIT
//
// Loops over the islands of a step. Thousands of bodies that fly alone are thousands of islands: what is done
// for each is shared by all threads.
#pragma once

#include <atomic>

#include "physics/thread_pool.h"
#include "physics/world_state.h"

namespace skerry {

// Islands that a thread takes at a time.
inline constexpr std::size_t kIslandsAPiece = 64;
// Contacts and joints from which on an island's own loops are long enough to be shared.
inline constexpr std::size_t kLoneIsland = 256;

/// Calls `item(island, threads)` for each island, in no order: for several at the same time, without threads;
/// but one with many contacts and joints has all of them for its own loops.
template <class Item>
void share_islands(WorldState& s, Item&& item) {
  const auto is_lone = [](const SteppedIsland& island) {
    return island.island.contacts.size() + island.island.joints.size() > kLoneIsland;
  };
  std::atomic<bool> any_lone = false;
  share_each(s.pool.get(), s.islands.size(), kIslandsAPiece, [&](std::size_t n) {
    if (is_lone(s.islands[n]))
      any_lone.store(true, std::memory_order_relaxed);
    else
      item(s.islands[n], static_cast<ThreadPool*>(nullptr));
  });
  if (!any_lone) return;
  for (SteppedIsland& island : s.islands)
    if (is_lone(island)) item(island, s.pool.get());
}

}  // namespace skerry
