// SPDX-License-Identifier: MIT
#include "tests/broadphase/scenes.h"

#include <cmath>

namespace skerry::broadphase_test {

namespace {

using Boxes = std::vector<Aabb>;

/// Calls `one(i)` for each of `count` boxes.
template <class One>
Boxes repeat(int count, One one) {
  Boxes boxes;
  for (int i = 0; i < count; ++i) boxes.push_back(one(i));
  return boxes;
}

Boxes random_boxes(Random& random, int count) {
  const double side = std::sqrt(count * 1.3) * 1.0;
  return repeat(count, [&](int) {
    return box_at(uniform(random, 0, side), uniform(random, 0, side), uniform(random, 0, 0.6),
                  uniform(random, 0, 0.6));
  });
}

Boxes equal_boxes(Random& random, int count) {
  const double side = std::sqrt(count * 4 / 3.0);
  return repeat(count,
                [&](int) { return box_at(uniform(random, 0, side), uniform(random, 0, side), 0.5, 0.5); });
}

Boxes clusters(Random& random, int count) {
  Vec2 centre;
  return repeat(count, [&](int i) {
    if (i % 40 == 0) centre = {uniform(random, -1e6, 1e6), uniform(random, -1e6, 1e6)};
    std::normal_distribution<double> normal(0, 3);
    return box_at(centre.x + normal(random), centre.y + normal(random), 0.5, uniform(random, 0.1, 0.5));
  });
}

Boxes power_law(Random& random, int count) {
  const double side = std::sqrt(count) * 4;
  return repeat(count, [&](int) {
    const double size = std::pow(10.0, uniform(random, 0, 1) * uniform(random, 0, 4)) * 0.5;
    return box_at(uniform(random, 0, side), uniform(random, 0, side), size, size * uniform(random, 0.2, 1));
  });
}

Boxes one_large_among_small(Random& random, int count) {
  return repeat(count, [&](int i) {
    return i % 100 == 3 ? box_at(uniform(random, -1e4, 1e4), uniform(random, -1e4, 1e4), 1e4, 1e4)
                        : box_at(uniform(random, -50, 50), uniform(random, -50, 50), 1, 1);
  });
}

Boxes floor_under_pile(Random& random, int count) {
  const double width = std::sqrt(count) * 3;
  return repeat(count, [&](int i) {
    return i == 0 ? box_at(0, -0.5, width * 20, 0.5)
                  : box_at(uniform(random, -width, width), i / 20 + 0.5, 0.5, 0.5);
  });
}

Boxes one_cell(Random& random, int count) {
  return repeat(count,
                [&](int) { return box_at(uniform(random, 0, 1e-3), uniform(random, 0, 1e-3), 1e-5, 2e-5); });
}

Boxes coincident(Random&, int count) {
  return repeat(count > 60 ? 60 : count, [&](int) { return box_at(3, -7, 0.5, 0.25); });
}

Boxes one_column(Random& random, int count) {
  return repeat(count, [&](int) { return box_at(0.25, uniform(random, 0, count), 0.5, 0.9); });
}

Boxes one_row(Random& random, int count) {
  return repeat(count, [&](int) { return box_at(uniform(random, 0, count), -11, 0.9, 0.5); });
}

Boxes touching_lattice(Random&, int count) {
  const int columns = static_cast<int>(std::sqrt(count)) + 1;
  return repeat(count, [&](int i) { return box_at(i % columns, i / columns, 0.5, 0.5); });
}

Boxes almost_touching(Random& random, int count) {
  // Gaps and overlaps of one unit in the last place: beyond what single precision can tell.
  const int columns = static_cast<int>(std::sqrt(count)) + 1;
  return repeat(count, [&](int i) {
    Aabb box = box_at(i % columns + 1000, i / columns + 1000, 0.5, 0.5);
    const auto nudge = [&](double& value) { value = std::nextafter(value, uniform(random, -1, 1) * 1e9); };
    nudge(box.lower.x);
    nudge(box.lower.y);
    nudge(box.upper.x);
    nudge(box.upper.y);
    return box;
  });
}

Boxes sparse_lattice(Random&, int count) {
  // Equal steps that are powers of two: cells of a wrapped table could all coincide.
  const int columns = static_cast<int>(std::sqrt(count)) + 1;
  return repeat(
      count, [&](int i) { return box_at(1024.0 * (i / 2 % columns), 4096.0 * (i / 2 / columns), 0.5, 0.5); });
}

Boxes zero_size(Random& random, int count) {
  return repeat(count, [&](int i) {
    const int side = static_cast<int>(std::sqrt(count)) + 1;
    const double x = std::floor(uniform(random, 0, side)), y = std::floor(uniform(random, 0, side));
    return i % 7 == 0 ? box_at(x, y, 1, 1) : Aabb{{x, y}, {x, y}};
  });
}

Boxes points_only(Random& random, int count) {
  return repeat(count, [&](int) {
    const double x = std::floor(uniform(random, 0, 30)), y = std::floor(uniform(random, 0, 30));
    return Aabb{{x, y}, {x, y}};
  });
}

Boxes segments(Random& random, int count) {
  return repeat(count, [&](int i) {
    const double x = uniform(random, 0, 40), y = uniform(random, 0, 40);
    return i % 2 ? box_at(x, y, 3, 0) : box_at(x, y, 0, 3);
  });
}

Boxes far_away(Random& random, int count) {
  const double side = std::sqrt(count * 1.3);
  return repeat(count, [&](int) {
    return box_at(1e9 + uniform(random, 0, side), -1e9 + uniform(random, 0, side), 0.5, 0.5);
  });
}

Boxes wide_world(Random& random, int count) {
  return repeat(count, [&](int i) {
    const double x = uniform(random, -1e9, 1e9), y = uniform(random, -1e9, 1e9);
    return i % 3 == 0 ? box_at(x, y, 1e7, 1e7) : box_at(x, y, 1e-3, 1e-3);
  });
}

Boxes extreme_numbers(Random& random, int count) {
  return repeat(count, [&](int i) {
    const double far = std::pow(10.0, uniform(random, -300, 307));
    if (i % 5 == 0) return Aabb{{-far, -far}, {far, far}};
    if (i % 5 == 1) return Aabb{{far, -1}, {far * 1.5, 1}};
    if (i % 5 == 2) return Aabb{{-far, far}, {-far, far}};
    return box_at(uniform(random, -2, 2), uniform(random, -2, 2), 1 / (1 + far), 0.1);
  });
}

}  // namespace

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all = {
      {"Random", random_boxes},
      {"Equal", equal_boxes},
      {"Clusters", clusters},
      {"PowerLaw", power_law},
      {"LargeAmongSmall", one_large_among_small},
      {"FloorUnderPile", floor_under_pile},
      {"OneCell", one_cell},
      {"Coincident", coincident},
      {"OneColumn", one_column},
      {"OneRow", one_row},
      {"TouchingLattice", touching_lattice},
      {"AlmostTouching", almost_touching},
      {"SparseLattice", sparse_lattice},
      {"ZeroSize", zero_size},
      {"PointsOnly", points_only},
      {"Segments", segments},
      {"FarAway", far_away},
      {"WideWorld", wide_world},
      {"ExtremeNumbers", extreme_numbers},
  };
  return all;
}

}  // namespace skerry::broadphase_test
