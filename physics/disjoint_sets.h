// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "physics/spare.h"

namespace skerry {

/// Disjoint sets of the numbers below a count, each by itself at first: union-find with path halving
/// [Tarjan & van Leeuwen 1984].
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) {
    parent_->resize(count);
    for (std::size_t k = 0; k < count; ++k) (*parent_)[k] = static_cast<int>(k);
  }

  /// The least number of the set of `k`.
  int root(int k) {
    std::vector<int>& parent = *parent_;
    while (parent[static_cast<std::size_t>(k)] != k) {
      int& up = parent[static_cast<std::size_t>(k)];
      k = up = parent[static_cast<std::size_t>(up)];
    }
    return k;
  }
  /// @return false if both were of one set
  bool join(int a, int b) {
    a = root(a);
    b = root(b);
    (*parent_)[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    return a != b;
  }

 private:
  Spare<std::vector<int>> parent_;
};

}  // namespace skerry
