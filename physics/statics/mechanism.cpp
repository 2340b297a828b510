// SPDX-License-Identifier: MIT
#include "physics/statics/mechanism.h"

#include <cmath>

namespace skerry::statics {

std::string direction_word(Vec2 d) {
  // tan(22.5 degrees): nearer to an axis than to a diagonal.
  constexpr double kNearAxis = 0.41421356237309503;
  std::string vertical = d.y > 0 ? "up" : "down";
  std::string horizontal = d.x > 0 ? "to the right" : "to the left";
  if (std::abs(d.y) <= kNearAxis * std::abs(d.x)) return horizontal;
  if (std::abs(d.x) <= kNearAxis * std::abs(d.y)) return vertical;
  return vertical + " and " + horizontal;
}

Mechanism describe_mechanism(const Structure& structure, const std::vector<std::array<int, 3>>& row_of,
                             const std::vector<Rot>& axes, double arm, const std::vector<double>& motion) {
  Mechanism result;
  const auto component = [&](std::size_t node, std::size_t c) {
    const int row = row_of[node][c];
    return row >= 0 && static_cast<std::size_t>(row) < motion.size() ? motion[static_cast<std::size_t>(row)]
                                                                     : 0.0;
  };
  double largest = 0, fastest = 0;
  std::size_t turning = 0;
  for (std::size_t i = 0; i < structure.nodes.size(); ++i) {
    result.displacement.push_back(rotate(axes[i], {component(i, 0), component(i, 1)}));
    result.rotation.push_back(component(i, 2) / arm);
    // A hair's breadth: of nodes that move alike the first is named.
    const double size = length(result.displacement[i]);
    if (size > largest * (1 + 1e-9)) {
      largest = size;
      result.node = static_cast<int>(i);
    }
    if (std::abs(result.rotation[i]) > fastest) {
      fastest = std::abs(result.rotation[i]);
      turning = i;
    }
  }
  if (largest <= 1e-9) {
    // Nothing but rotation.
    result.node = static_cast<int>(turning);
    result.sentence = node_label(structure, result.node) + " can turn";
    return result;
  }
  // It can move both ways; to the left, or downwards, is the one that is shown.
  const Vec2 most = result.displacement[static_cast<std::size_t>(result.node)];
  const bool sideways = std::abs(most.x) > 1e-9 * largest;
  const double sign = (sideways ? most.x : most.y) > 0 ? -1 : 1;
  for (Vec2& d : result.displacement) d *= sign / largest;
  for (double& r : result.rotation) r *= sign / largest;
  result.sentence = node_label(structure, result.node) + " can move " +
                    direction_word(result.displacement[static_cast<std::size_t>(result.node)]);
  return result;
}

std::string Determinacy::sentence() const {
  if (!mechanisms.empty()) {
    std::string text = "mechanism: " + mechanisms.front().sentence;
    if (mechanisms.size() > 1) text += ", and " + std::to_string(mechanisms.size() - 1) + " more";
    return text;
  }
  if (indeterminacy() == 0) return "statically determinate";
  return std::to_string(indeterminacy()) + (indeterminacy() == 1 ? " time" : " times") +
         " statically indeterminate";
}

}  // namespace skerry::statics
