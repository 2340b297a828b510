// SPDX-License-Identifier: MIT
//
// Which rows act on a body, in the interior point for contacts.
#pragma once

#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

namespace skerry {

class ConeIncidence {
 public:
  /// An item of a body, and which of its two bodies that is.
  struct Incident {
    int item;
    bool is_high;
  };

  /// Takes items that have positions `low` and `high`; the ground is the position behind the last node.
  template <class Item>
  void assign(const std::vector<Item>& items, int nodes) {
    const auto at = [](int i) { return static_cast<std::size_t>(i); };
    // First where those of a position end.
    begin_.assign(at(nodes) + 2, 0);
    for (const Item& item : items) {
      ++begin_[at(item.low)];
      ++begin_[at(item.high)];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    incident_.resize(2 * items.size());
    for (int k = static_cast<int>(items.size()); k-- > 0;) {
      incident_[at(--begin_[at(items[at(k)].high)])] = {k, true};
      incident_[at(--begin_[at(items[at(k)].low)])] = {k, false};
    }
  }

  /// Those of a position, ascending.
  std::span<const Incident> of(int position) const {
    const auto p = static_cast<std::size_t>(position);
    const auto first = static_cast<std::size_t>(begin_[p]), last = static_cast<std::size_t>(begin_[p + 1]);
    return std::span(incident_).subspan(first, last - first);
  }

 private:
  std::vector<Incident> incident_;
  std::vector<int> begin_;
};

}  // namespace skerry
