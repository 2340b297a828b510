// SPDX-License-Identifier: MIT
//
// What solvers keep of an island from solve to solve and from step to step, found again by the rows.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "physics/hash.h"
#include "physics/world_state.h"

namespace skerry {

/// For what a system is solved: systems of the same rows do not share their memory.
enum class SolvePurpose : std::uint8_t { Forces, Positions, Velocities, Welds, Midpoints };

inline std::uint64_t memory_key(SolvePurpose purpose, const IslandSystem& system) {
  Fnv1a key;
  if (purpose != SolvePurpose::Forces) key.add(static_cast<std::uint32_t>(purpose));
  for (const Row& row : system.rows) key.add(row.source);
  return key.value();
}

/// What this step or the last one kept for the rows of a system, null if there is nothing, on its way through
/// a solve: as it is when the loan ends, it is kept for the next. Islands share no rows, and rows stay the
/// same meanwhile.
class MemoryLoan {
 public:
  MemoryLoan(WorldState& state, IslandResult& result, SolvePurpose purpose, const IslandSystem& system)
      : result_(result), purpose_(purpose), system_(system), keeps_(state.config.skips.factors) {
    // Small systems leave nothing to remember, and nothing to look for.
    if (!keeps_ || (state.memories.empty() && result.memories.empty())) return;
    const std::uint64_t key = key_.emplace(memory_key(purpose, system));
    const auto own = std::find_if(result.memories.begin(), result.memories.end(),
                                  [key](const IslandMemory& kept) { return kept.key == key; });
    if (own != result.memories.end()) {
      memory_ = std::move(own->memory);
      result.memories.erase(own);
      return;
    }
    const auto found =
        std::lower_bound(state.memories.begin(), state.memories.end(), key,
                         [](const IslandMemory& kept, std::uint64_t k) { return kept.key < k; });
    if (found != state.memories.end() && found->key == key) memory_ = std::move(found->memory);
  }
  ~MemoryLoan() {
    if (memory_ != nullptr && keeps_)
      result_.memories.push_back({key_ ? *key_ : memory_key(purpose_, system_), std::move(memory_)});
  }
  MemoryLoan(const MemoryLoan&) = delete;
  MemoryLoan& operator=(const MemoryLoan&) = delete;

  std::unique_ptr<SolverMemory>* get() { return &memory_; }

 private:
  IslandResult& result_;
  SolvePurpose purpose_;
  const IslandSystem& system_;
  bool keeps_;
  std::optional<std::uint64_t> key_;
  std::unique_ptr<SolverMemory> memory_;
};

}  // namespace skerry
