// SPDX-License-Identifier: MIT
//
// Random numbers that are the same with every standard library, unlike those of its distributions.
#pragma once

#include <random>

namespace skerry::test {

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }
  int pick(int count) { return static_cast<int>(uniform(0, count)); }
  bool one_in(int count) { return pick(count) == 0; }

 private:
  std::mt19937 random_;
};

}  // namespace skerry::test
