// SPDX-License-Identifier: MIT
//
// What solvers keep of an island from solve to solve and from step to step, found again by the rows.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "physics/hash.h"
#include "physics/world_state.h"

namespace skerry {

/// For what a system is solved: systems of the same rows do not share their memory.
enum class SolvePurpose : std::uint8_t { Forces, Positions, Velocities };

inline std::uint64_t memory_key(SolvePurpose purpose, const IslandSystem& system) {
  Fnv1a key;
  if (purpose != SolvePurpose::Forces) key.add(static_cast<std::uint32_t>(purpose));
  for (const Row& row : system.rows) key.add(row.source);
  return key.value();
}

/// Takes what this step or the last one kept for the rows of `system`; null if there is nothing. Islands
/// share no rows.
inline std::unique_ptr<SolverMemory> take_memory(WorldState& state, IslandResult& result,
                                                 SolvePurpose purpose, const IslandSystem& system) {
  // Small systems leave nothing to remember, and nothing to look for.
  if (!state.config.skips.factors || (state.memories.empty() && result.memories.empty())) return nullptr;
  const std::uint64_t key = memory_key(purpose, system);
  const auto own = std::find_if(result.memories.begin(), result.memories.end(),
                                [key](const IslandMemory& kept) { return kept.key == key; });
  if (own != result.memories.end()) {
    std::unique_ptr<SolverMemory> memory = std::move(own->memory);
    result.memories.erase(own);
    return memory;
  }
  const auto found = std::lower_bound(state.memories.begin(), state.memories.end(), key,
                                      [](const IslandMemory& kept, std::uint64_t k) { return kept.key < k; });
  if (found == state.memories.end() || found->key != key) return nullptr;
  return std::move(found->memory);
}

inline void keep_memory(const WorldState& state, IslandResult& result, SolvePurpose purpose,
                        const IslandSystem& system, std::unique_ptr<SolverMemory> memory) {
  if (memory != nullptr && state.config.skips.factors)
    result.memories.push_back({memory_key(purpose, system), std::move(memory)});
}

}  // namespace skerry
