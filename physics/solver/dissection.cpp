// SPDX-License-Identifier: MIT
#include "physics/solver/dissection.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "physics/index.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Across which cuts are tried: whole numbers, so that bodies in rows are in one line to the last bit. Parts
// of fewer than `kFew` nodes try the first four.
constexpr std::array<Vec2, 8> kDirections{
    {{1, 0}, {0, 1}, {1, 1}, {1, -1}, {2, 1}, {1, 2}, {2, -1}, {1, -2}}};
constexpr std::size_t kFewDirections = 4;
constexpr int kFew = 400;
// Parts of so many nodes and fewer are not cut.
constexpr int kSmall = 10;
// How far from the middle a part may be cut, as a share of its nodes; and what that costs: 1 + kUneven of the
// square.
constexpr double kWindow = 0.2, kUneven = 4;
// Digits by which places are sorted.
constexpr int kDigit = 2048;

struct DissectionVectors {
  std::array<std::vector<int>, kDirections.size()> along;
  std::vector<int> part, rank, low, high, aside;
  std::vector<std::uint32_t> key;
};

class Dissection {
 public:
  Dissection(const Adjacency& graph, std::span<const int> position, std::vector<int>& order)
      : graph_(graph), position_(position), order_(order) {}

  void run(std::span<const Vec2> places) {
    const std::size_t n = places.size();
    all_->part.assign(n, 0);
    all_->rank.resize(n);
    for (std::size_t d = 0; d < kDirections.size(); ++d) sort_along(places, kDirections[d], all_->along[d]);
    order_.clear();
    order_.reserve(n);
    cut(0, static_cast<int>(n), 0, kDirections.size());
  }

 private:
  struct Cut {
    double cost = kInfinity;
    std::size_t direction = 0;
    int before = 0;  ///< how many nodes are on the first side, with those that part if they are from there
    bool first = false;  ///< the nodes that part are of the first side
  };

  /// All nodes, by how far they are in a direction, in `kDigit`^2 classes of equal width, and by their
  /// numbers.
  void sort_along(std::span<const Vec2> places, Vec2 direction, std::vector<int>& sorted) {
    double least = kInfinity, most = -kInfinity;
    for (const Vec2 p : places) {
      least = std::min(least, dot(direction, p));
      most = std::max(most, dot(direction, p));
    }
    const double width = most > least ? most - least : 1;
    std::vector<std::uint32_t>& key = all_->key;
    key.resize(places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
      key[i] =
          static_cast<std::uint32_t>((dot(direction, places[i]) - least) / width * (kDigit * kDigit - 1));
    std::vector<int>& half = all_->aside;
    half.resize(places.size());
    sorted.resize(places.size());
    for (std::size_t i = 0; i < half.size(); ++i) sorted[i] = static_cast<int>(i);
    sort_by_digit(sorted, half, 1);
    sort_by_digit(half, sorted, kDigit);
  }

  void sort_by_digit(const std::vector<int>& from, std::vector<int>& to, std::uint32_t unit) {
    std::array<int, kDigit + 1> begin{};
    for (const int i : from) ++begin[all_->key[at(i)] / unit % kDigit + 1];
    for (std::size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
    for (const int i : from) to[at(begin[all_->key[at(i)] / unit % kDigit]++)] = i;
  }

  /// Appends the nodes that the lists hold from `first` to `last` - 1, which are part number `part`.
  void cut(int first, int last, int part, std::size_t directions) {
    const int count = last - first;
    if (count <= kSmall) return append_small(first, last);
    if (count < kFew) directions = std::min(directions, kFewDirections);
    Cut best;
    for (std::size_t d = 0; d < directions; ++d) try_direction(first, last, part, d, best);
    const std::array<int, 2> sizes = divide(first, last, part, directions, best);
    const int middle = first + sizes[0], end = middle + sizes[1];
    // What parts them ends in the order of the first list.
    const int sides = parts_ - 1;
    cut(first, middle, sides, directions);
    cut(middle, end, sides + 1, directions);
    order_.insert(order_.end(), all_->along[0].begin() + end, all_->along[0].begin() + last);
  }

  void append_small(int first, int last) {
    const auto begin = all_->along[0].begin() + first, end = all_->along[0].begin() + last;
    std::sort(begin, end, [this](int i, int j) { return position_[at(i)] < position_[at(j)]; });
    order_.insert(order_.end(), begin, end);
  }

  void rank_along(const int* list, int count) {
    for (int i = 0; i < count; ++i) all_->rank[at(list[i])] = i;
  }

  /// A node of the first side parts where a neighbour is on the other side, so in all cuts between itself and
  /// its last neighbour; one of the second side in those between its first neighbour and itself.
  void try_direction(int first, int last, int part, std::size_t direction, Cut& best) {
    const int count = last - first;
    const int* const list = all_->along[direction].data() + first;
    rank_along(list, count);
    std::vector<int>&of_first = all_->low, &of_second = all_->high;
    of_first.assign(at(count) + 2, 0);
    of_second.assign(at(count) + 2, 0);
    for (int i = 0; i < count; ++i) {
      int low = i, high = i;
      for (int p = graph_.start[at(list[i])]; p < graph_.finish[at(list[i])]; ++p) {
        const int j = graph_.neighbour[at(p)];
        if (all_->part[at(j)] != part) continue;
        low = std::min(low, all_->rank[at(j)]);
        high = std::max(high, all_->rank[at(j)]);
      }
      ++of_first[at(i) + 1];
      --of_first[at(high) + 1];
      ++of_second[at(low) + 1];
      --of_second[at(i) + 1];
    }
    const int from = static_cast<int>((0.5 - kWindow) * count),
              to = static_cast<int>((0.5 + kWindow) * count);
    int first_parts = 0, second_parts = 0;
    for (int k = 0; k <= to; ++k) {
      first_parts += of_first[at(k)];
      second_parts += of_second[at(k)];
      if (k < from) continue;
      const double off = static_cast<double>(k) / count - 0.5;
      const double cost = (1 + kUneven * off * off) * (1 + std::min(first_parts, second_parts));
      if (cost < best.cost) best = {cost, direction, k, first_parts <= second_parts};
    }
  }

  /// Parts the lists. @return how many nodes are on each side; they come first, side by side, and then those
  /// that part them
  std::array<int, 2> divide(int first, int last, int part, std::size_t directions, const Cut& by) {
    const int count = last - first;
    const int* const list = all_->along[by.direction].data() + first;
    rank_along(list, count);
    std::vector<int>& side = all_->low;
    side.assign(at(count), 0);
    for (int i = 0; i < count; ++i) {
      const bool is_first = i < by.before;
      side[at(i)] = is_first ? 1 : 2;
      if (is_first != by.first) continue;
      for (int p = graph_.start[at(list[i])]; p < graph_.finish[at(list[i])]; ++p) {
        const int j = graph_.neighbour[at(p)];
        if (all_->part[at(j)] == part && (all_->rank[at(j)] < by.before) != is_first) side[at(i)] = 0;
      }
    }
    const std::array<int, 3> numbers{-1, parts_ + 1, parts_ + 2};
    parts_ += 2;
    std::array<int, 2> sizes{};
    for (int i = 0; i < count; ++i) {
      all_->part[at(list[i])] = numbers[at(side[at(i)])];
      if (side[at(i)] > 0) ++sizes[at(side[at(i)]) - 1];
    }
    std::vector<int>& old = all_->aside;
    for (std::size_t d = 0; d < directions; ++d) {
      int* const sorted = all_->along[d].data() + first;
      old.assign(sorted, sorted + count);
      int* next[3] = {sorted + sizes[0] + sizes[1], sorted, sorted + sizes[0]};
      for (const int i : old) {
        const int number = all_->part[at(i)];
        *next[number < 0 ? 0 : number == numbers[1] ? 1 : 2]++ = i;
      }
    }
    return sizes;
  }

  const Adjacency& graph_;
  std::span<const int> position_;
  std::vector<int>& order_;
  Spare<DissectionVectors> all_;
  int parts_ = 0;  ///< numbers of parts that were given
};

}  // namespace

void dissect(const Adjacency& graph, std::span<const Vec2> places, std::span<const int> position,
             std::vector<int>& order) {
  Dissection(graph, position, order).run(places);
}

}  // namespace skerry
