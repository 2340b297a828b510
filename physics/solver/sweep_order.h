// SPDX-License-Identifier: MIT
//
// Which blocks of a Gauss-Seidel sweep are swept side by side, and in which order. A block reads and writes
// the velocities of its two bodies only, so what matters is the order of the blocks that share a body: every
// order that keeps it gives the bits of one block after the other. Of these there are two:
//
// - by levels, as early as the blocks before allow: fills groups best, and puts most of what waits for each
//   other some groups apart;
// - one in which the blocks of a body stand close together: then the next sweep, of another thread, can
//   follow this one at a short distance, which pays where more than one does, or where levels would let it
//   wait until this one is nearly through.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace skerry {

class SweepOrder {
 public:
  static constexpr int kLanes = 4;
  /// Groups of one chunk: some microseconds of a sweep.
  static constexpr int kChunk = 32;
  /// Blocks of one kind that share no body.
  struct Group {
    int kind = 0, count = 0;
    std::array<int, kLanes> block{};  ///< numbers of blocks, `count` of them
  };

  /// Forgets the blocks. @param bodies  how many there are
  void start(std::size_t bodies);
  /// The next block, between bodies `a` and `b`; numbers that are no body's stand for the ground, which
  /// nothing moves.
  void add(int a, int b);
  /// After the last block: what does not depend on what they are like.
  /// @param sweeps  that are made at the same time, each behind the one before it; of more than one, `need`
  /// is known
  void arrange(int sweeps);
  /// Makes the groups. @param kind  by block, below `kinds`
  void finish(std::span<const std::uint8_t> kind, int kinds);

  const std::vector<Group>& groups() const { return groups_; }
  /// By chunk of groups, the last chunk that touches one of its bodies: so far a sweep has to have come
  /// before the next one may begin the chunk. Where several are made at the same time.
  const std::vector<int>& need() const { return need_; }

 private:
  struct Block {
    int number;
    std::array<int, 2> body;  ///< the ground is the number after the last body's
  };
  void go_by_levels();
  int spread();
  void come_late();
  void sort_by_key();
  void fill_groups(std::span<const std::uint8_t> kind, int kinds);
  void find_need();
  int find_open(int kind, int from) const;

  int ground_ = 0;
  bool followed_ = false;
  std::vector<Block> blocks_, sorted_, given_;
  std::vector<int> place_, key_, beginning_;
  std::vector<Group> groups_;
  std::vector<int> need_;
  std::vector<std::uint64_t> open_;  ///< by kind, a bit for each of the last groups: has free lanes
};

}  // namespace skerry
