// SPDX-License-Identifier: MIT
//
// A set of pairs that can be found by key and by box: a hash table of records, and through each box a ring of
// its records. Adding, finding and erasing a pair take constant time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "physics/broadphase/pair_buffer.h"

namespace skerry {

/// Pairs of boxes, by pair and by box.
class PairTable {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  /// Boxes below `limit` may be used.
  void reserve_boxes(ProxyIndex limit) { first_.resize(std::max<std::size_t>(first_.size(), limit), kNone); }
  std::size_t size() const { return size_; }

  /// Adds the pair; does nothing if it is present.
  void add(ProxyIndex a, ProxyIndex b) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    const std::uint64_t key = pair_key(a, b);
    std::size_t at = home(key);
    for (; slots_[at].record != kNone; at = (at + 1) & mask()) {
      if (slots_[at].key == key) return;
    }
    std::uint32_t r = free_;
    if (r == kNone) {
      r = static_cast<std::uint32_t>(records_.size());
      records_.emplace_back();
    } else {
      free_ = records_[r].next[0];
    }
    slots_[at] = {key, r};
    records_[r].box[0] = static_cast<ProxyIndex>(key >> 32);
    records_[r].box[1] = static_cast<ProxyIndex>(key);
    for (const int side : {0, 1}) link(2 * r + static_cast<std::uint32_t>(side));
    ++size_;
  }

  /// Calls `keep(other)` for every partner of `box`, and erases the pairs for which it is false.
  template <class Keep>
  void filter(ProxyIndex box, Keep keep) {
    if (box >= first_.size()) return;
    for (std::uint32_t end = first_[box]; end != kNone;) {
      const std::uint32_t next = records_[end / 2].next[end % 2];
      if (!keep(records_[end / 2].box[1 - end % 2])) erase(end / 2);
      end = next;
    }
  }
  /// The same for every pair: `keep(low, high)`.
  template <class Keep>
  void filter_all(Keep keep) {
    for (std::uint32_t r = 0; r < records_.size(); ++r) {
      Record& record = records_[r];
      if (record.box[0] != record.box[1] && !keep(record.box[0], record.box[1])) erase(r);
    }
  }

  std::size_t bytes() const {
    return slots_.capacity() * sizeof(Slot) + records_.capacity() * sizeof(Record) +
           first_.capacity() * sizeof(std::uint32_t);
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t record = kNone;
  };
  /// A link is 2 * record + side. Erased records have two equal boxes.
  struct Record {
    ProxyIndex box[2] = {0, 0};
    std::uint32_t next[2] = {kNone, kNone};
    std::uint32_t previous[2] = {kNone, kNone};
  };

  std::size_t mask() const { return slots_.size() - 1; }
  std::size_t home(std::uint64_t key) const {
    key *= 0x9E3779B97F4A7C15;
    key ^= key >> 32;
    key *= 0xBF58476D1CE4E5B9;
    return static_cast<std::size_t>(key >> 32) & mask();
  }

  void link(std::uint32_t end) {
    Record& record = records_[end / 2];
    std::uint32_t& first = first_[record.box[end % 2]];
    record.previous[end % 2] = kNone;
    record.next[end % 2] = first;
    if (first != kNone) records_[first / 2].previous[first % 2] = end;
    first = end;
  }
  void unlink(std::uint32_t end) {
    const Record& record = records_[end / 2];
    const std::uint32_t next = record.next[end % 2], previous = record.previous[end % 2];
    if (next != kNone) records_[next / 2].previous[next % 2] = previous;
    (previous != kNone ? records_[previous / 2].next[previous % 2] : first_[record.box[end % 2]]) = next;
  }

  void erase(std::uint32_t r) {
    unlink(2 * r);
    unlink(2 * r + 1);
    std::size_t hole = home(pair_key(records_[r].box[0], records_[r].box[1]));
    while (slots_[hole].record != r) hole = (hole + 1) & mask();
    // Close the gap: an entry may move back if its home is not after the hole.
    for (std::size_t at = (hole + 1) & mask(); slots_[at].record != kNone; at = (at + 1) & mask()) {
      if (((at - home(slots_[at].key)) & mask()) >= ((at - hole) & mask())) {
        slots_[hole] = slots_[at];
        hole = at;
      }
    }
    slots_[hole].record = kNone;
    records_[r].box[1] = records_[r].box[0];
    records_[r].next[0] = free_;
    free_ = r;
    --size_;
  }

  void grow() {
    std::vector<Slot> old(std::max<std::size_t>(64, 2 * slots_.size()));
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.record == kNone) continue;
      std::size_t at = home(slot.key);
      while (slots_[at].record != kNone) at = (at + 1) & mask();
      slots_[at] = slot;
    }
  }

  std::vector<Slot> slots_;
  std::vector<Record> records_;
  std::vector<std::uint32_t> first_;  ///< by box
  std::uint32_t free_ = kNone;
  std::size_t size_ = 0;
};

}  // namespace skerry
