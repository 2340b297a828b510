// SPDX-License-Identifier: MIT
//
// Box scenes for the broad-phase tests: a named cause of trouble each, from a printed seed.
#pragma once

#include <cstdlib>
#include <functional>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include "physics/broadphase/broadphase.h"

namespace skerry {
inline void PrintTo(const BroadPhaseEntry& entry, std::ostream* out) {
  *out << entry.name;
}
}  // namespace skerry

namespace skerry::broadphase_test {

using Random = std::mt19937_64;

/// Makes `count` boxes.
struct Scene {
  std::string name;
  std::function<std::vector<Aabb>(Random&, int count)> make;
};

const std::vector<Scene>& scenes();

// Parameters are named, not dumped, in the names of tests.
inline void PrintTo(const Scene& scene, std::ostream* out) {
  *out << scene.name;
}

/// Factor for the amount of work, from the environment variable SKERRY_TEST_SCALE.
inline double test_scale() {
  const char* text = std::getenv("SKERRY_TEST_SCALE");
  return text != nullptr ? std::atof(text) : 1.0;
}

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// A box by centre and half extents.
inline Aabb box_at(double x, double y, double half_width, double half_height) {
  return {{x - half_width, y - half_height}, {x + half_width, y + half_height}};
}

inline Aabb shifted(const Aabb& box, Vec2 by) {
  return {box.lower + by, box.upper + by};
}

}  // namespace skerry::broadphase_test
