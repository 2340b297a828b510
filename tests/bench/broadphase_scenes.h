// SPDX-License-Identifier: MIT
//
// Scenes of the broad-phase benchmark: boxes that move, and which of them do.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "physics/broadphase/broadphase.h"

namespace skerry::bench {

/// Boxes and their motion. Distributions, all with about three overlaps a box:
/// U  equal boxes, all move by a tenth of their size a step;
/// M  sizes from 1 to 300 by a power law (density size^-3), all move;
/// C  a pile of dense rows on a floor, all but the floor tremble by a tenth of their size;
/// S  as U, but 99 % are asleep;
/// F  as U, all asleep but one that flies five of its sizes a step;
/// R  as U, all asleep; a hundred rays are cast, each a tenth of the world long.
class BoxScene {
 public:
  BoxScene(char distribution, std::size_t count);

  const std::vector<Aabb>& boxes() const { return boxes_; }
  const std::vector<std::uint32_t>& active() const { return active_; }
  bool is_fixed(std::size_t i) const { return floor_ && i == 0; }
  Aabb world() const { return world_; }
  /// Moves the active boxes by one step and returns their new places.
  const std::vector<BoxUpdate>& advance();
  const std::vector<Ray>& rays() const { return rays_; }

 private:
  void add(Vec2 centre, Vec2 half, Vec2 velocity);

  std::vector<Aabb> boxes_;
  std::vector<Vec2> velocity_;
  std::vector<std::uint32_t> active_;
  std::vector<BoxUpdate> updates_;
  std::vector<Ray> rays_;
  Aabb world_{};
  bool floor_ = false;
  bool trembles_ = false;
};

/// Something that finds pairs: one of ours, or a peer.
class PairBench {
 public:
  virtual ~PairBench() = default;
  virtual void build(const BoxScene& scene) = 0;
  /// Takes the new boxes and finds the pairs; returns their number (peers that report changes only: the
  /// changes).
  virtual std::size_t step(const BoxScene& scene, const std::vector<BoxUpdate>& updates) = 0;
};

/// A row of the comparison.
struct BenchEntry {
  std::string name;
  std::size_t most;  ///< larger scenes are skipped: they would take minutes
  std::function<std::unique_ptr<PairBench>()> make;
  bool is_ours = false;  ///< gets distribution R as well
  bool by_wall = false;  ///< uses several threads
};

/// The peers that were found when this was built, with versions in the names.
std::vector<BenchEntry> peers();

}  // namespace skerry::bench
