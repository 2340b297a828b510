// SPDX-License-Identifier: MIT
#include "physics/solver/sweep_order.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "physics/index.h"

namespace skerry {
namespace {

// Of this many times 64 groups, the last ones, those with free lanes are remembered: more of them fill some
// percent more lanes, but lengthen the distance between sweeps.
constexpr int kWords = 2, kWord = 64;

// So many sweeps at the same time may go by levels, where the second one stands no farther behind the first
// than such a share of a sweep: four sweeps of two threads are then 1.7 times as fast as those of one, and in
// the other order 1.9 times, with a seventh more groups.
constexpr int kByLevels = 2;
constexpr double kFarthestBehind = 1.0 / 3;

}  // namespace

void SweepOrder::start(std::size_t bodies) {
  ground_ = static_cast<int>(bodies);
  blocks_.clear();
  groups_.clear();
}

void SweepOrder::add(int a, int b) {
  const auto known = [this](int i) { return i >= 0 && i < ground_ ? i : ground_; };
  blocks_.push_back({static_cast<int>(blocks_.size()), {known(a), known(b)}});
}

void SweepOrder::arrange(int sweeps) {
  followed_ = sweeps > 1;
  if (!followed_) return go_by_levels();
  if (sweeps <= kByLevels) {
    given_ = blocks_;
    go_by_levels();
    if (spread() <= kFarthestBehind * static_cast<double>(blocks_.size())) return;
    blocks_.swap(given_);
  }
  // Contacts with a fixed body stand before all others, far from those that they hold up. Going there once
  // they may end before another such contact's old place.
  come_late();
  come_late();
}

void SweepOrder::finish(std::span<const std::uint8_t> kind, int kinds) {
  fill_groups(kind, kinds);
  need_.clear();
  if (followed_) find_need();
}

/// A block has the first level after those of the blocks before it that share a body with it.
void SweepOrder::go_by_levels() {
  place_.assign(at(ground_) + 1, 0);
  key_.resize(blocks_.size());
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const auto [a, b] = blocks_[i].body;
    const int level = std::max(place_[at(a)], place_[at(b)]);
    key_[i] = level;
    if (a < ground_) place_[at(a)] = level + 1;
    if (b < ground_) place_[at(b)] = level + 1;
  }
  sort_by_key();
}

/// How far behind the first block of a body its last one stands at most.
int SweepOrder::spread() {
  int most = 0;
  place_.assign(at(ground_) + 1, -1);  // by body: its first block
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for (const int body : blocks_[i].body) {
      if (body == ground_) continue;
      int& first = place_[at(body)];
      if (first < 0) first = static_cast<int>(i);
      most = std::max(most, static_cast<int>(i) - first);
    }
  }
  return most;
}

/// Moves each block to just before the first later one that shares a body with it.
void SweepOrder::come_late() {
  // The key of a block is less than the place of what follows it, and that not more than the key of that:
  // sorted by keys, blocks that share a body keep their order.
  const int n = static_cast<int>(blocks_.size());
  place_.assign(at(ground_) + 1, n);
  key_.resize(at(n));
  for (int i = n - 1; i >= 0; --i) {
    const auto [a, b] = blocks_[at(i)].body;
    const int next = std::min(place_[at(a)], place_[at(b)]);
    key_[at(i)] = next < n ? next - 1 : i;
    if (a < ground_) place_[at(a)] = i;
    if (b < ground_) place_[at(b)] = i;
  }
  sort_by_key();
}

/// Keys are below the number of blocks; those of one key keep their order.
void SweepOrder::sort_by_key() {
  const int n = static_cast<int>(blocks_.size());
  beginning_.assign(at(n) + 1, 0);
  for (const int key : key_) ++beginning_[at(key) + 1];
  for (int i = 0; i < n; ++i) beginning_[at(i) + 1] += beginning_[at(i)];
  sorted_.resize(at(n));
  for (int i = 0; i < n; ++i) sorted_[at(beginning_[at(key_[at(i)])]++)] = blocks_[at(i)];
  blocks_.swap(sorted_);
}

/// Each block goes to the first group of its kind with a free lane after those of its bodies.
void SweepOrder::fill_groups(std::span<const std::uint8_t> kind, int kinds) {
  place_.assign(at(ground_) + 1, 0);  // by body: first group after its blocks
  open_.assign(at(kinds * kWords), 0);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    const auto [a, b] = block.body;
    const int own = kind[at(block.number)];
    int place = find_open(own, std::max(place_[at(a)], place_[at(b)]));
    const auto word_of = [&](int of) -> std::uint64_t& {
      return open_[at(of * kWords + place / kWord % kWords)];
    };
    if (place < 0) {
      place = static_cast<int>(groups_.size());
      groups_.push_back({.kind = own});
      if (place % kWord == 0) {
        for (int k = 0; k < kinds; ++k) word_of(k) = 0;
      }
      word_of(own) |= std::uint64_t{1} << (place % kWord);
    }
    Group& group = groups_[at(place)];
    group.block[at(group.count++)] = block.number;
    if (group.count == kLanes) word_of(own) &= ~(std::uint64_t{1} << (place % kWord));
    key_[i] = place;
    if (a < ground_) place_[at(a)] = place + 1;
    if (b < ground_) place_[at(b)] = place + 1;
  }
}

/// The first remembered group of that kind with a free lane, not before `from`; -1: none.
int SweepOrder::find_open(int kind, int from) const {
  const int count = static_cast<int>(groups_.size());
  const int words = (count + kWord - 1) / kWord;
  from = std::max(from, (words - kWords) * kWord);
  for (int word = from / kWord; word < words; ++word) {
    std::uint64_t open = open_[at(kind * kWords + word % kWords)];
    if (word == from / kWord) open &= ~std::uint64_t{0} << (from % kWord);
    if (open != 0) return word * kWord + std::countr_zero(open);
  }
  return -1;
}

void SweepOrder::find_need() {
  // What is left of filling the groups: by block its group, by body the first group after its blocks.
  need_.assign((groups_.size() + kChunk - 1) / kChunk, 0);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    int& need = need_[at(key_[i] / kChunk)];
    need = std::max(need, key_[i] / kChunk);
    for (const int body : blocks_[i].body) {
      if (body < ground_) need = std::max(need, (place_[at(body)] - 1) / kChunk);
    }
  }
}

}  // namespace skerry
