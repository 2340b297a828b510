// SPDX-License-Identifier: MIT
#include "physics/solver/sweep_levels.h"

#include <algorithm>

namespace skerry {

void SweepLevels::start(std::size_t bodies, int kinds) {
  kinds_ = kinds;
  next_.assign(bodies, 0);
  place_.clear();
  beginning_.clear();
  order_.clear();
  runs_.clear();
}

void SweepLevels::add(int a, int b, int kind) {
  const auto is_body = [this](int i) { return i >= 0 && static_cast<std::size_t>(i) < next_.size(); };
  int level = 0;
  for (const int body : {a, b}) {
    if (is_body(body)) level = std::max(level, next_[static_cast<std::size_t>(body)]);
  }
  for (const int body : {a, b}) {
    if (is_body(body)) next_[static_cast<std::size_t>(body)] = level + 1;
  }
  place_.push_back(static_cast<std::size_t>(level) * static_cast<std::size_t>(kinds_) +
                   static_cast<std::size_t>(kind));
}

void SweepLevels::finish() {
  if (place_.empty()) return;
  // Sorted by counting, which leaves equals in their order.
  beginning_.assign(*std::max_element(place_.begin(), place_.end()) + 2, 0);
  for (const std::size_t place : place_) ++beginning_[place + 1];
  for (std::size_t i = 1; i < beginning_.size(); ++i) beginning_[i] += beginning_[i - 1];
  for (std::size_t i = 0; i + 1 < beginning_.size(); ++i) {
    if (beginning_[i] == beginning_[i + 1]) continue;
    const int kind = static_cast<int>(i % static_cast<std::size_t>(kinds_));
    runs_.push_back({kind, beginning_[i], beginning_[i + 1]});
  }
  order_.resize(place_.size());
  for (std::size_t k = 0; k < place_.size(); ++k) order_[beginning_[place_[k]]++] = static_cast<int>(k);
}

}  // namespace skerry
