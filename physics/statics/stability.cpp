// SPDX-License-Identifier: MIT
#include "physics/statics/stability.h"

#include <cmath>
#include <utility>

namespace skerry::statics {

Stability stability_of(const RestAnalysis& rest) {
  Stability result;
  result.margin = kInfinity;
  // What is left of the accelerations (springs settle to rounding only) would be a load that nothing carries.
  BodyLoads dead = rest.load;
  for (std::size_t k = 0; k < dead.size(); ++k) {
    const InverseMass& m = rest.system.bodies[k];
    for (std::size_t c = 0; c < 3; ++c) {
      const double inverse = c == 2 ? m.angular : m.linear;
      if (inverse > 0) dead[k][c] -= rest.acceleration[k][c] / inverse;
    }
  }
  for (const bool to_left : {false, true}) {
    BodyLoads live;
    for (const double weight : rest.weight) live.push_back({to_left ? -weight : weight, 0, 0});
    LimitLoad limit = limit_load(rest.system, dead, live);
    const bool optimal = limit.status == LimitStatus::Optimal;
    if (!optimal && limit.status != LimitStatus::Unbounded) {
      result.status = limit.status;
      result.margin = 0;
      return result;
    }
    if (result.status == LimitStatus::Failed) result.status = limit.status;
    // Rounding does not choose a side: of two that are alike the right one is named.
    if (optimal && limit.factor < result.margin * (1 - 1e-9)) {
      result.status = limit.status;
      result.margin = limit.factor;
      result.to_left = to_left;
      result.limit = std::move(limit);
    }
  }
  // The contact with the largest relative motion governs.
  double largest = 0;
  const auto speed = [&](std::size_t index) {
    const Row& row = rest.system.rows[index];
    double sum = 0;
    if (row.a >= 0) sum += along(row.Ja, result.limit.mechanism[static_cast<std::size_t>(row.a)]);
    if (row.b >= 0) sum += along(row.Jb, result.limit.mechanism[static_cast<std::size_t>(row.b)]);
    return std::abs(sum);
  };
  for (std::size_t i = 0; i < rest.contacts.size() && !result.limit.mechanism.empty(); ++i) {
    const auto row = static_cast<std::size_t>(rest.contacts[i].row);
    const double opening = speed(row), sliding = rest.contacts[i].held_mu > 0 ? speed(row + 1) : 0;
    // Associated flow opens by mu times the slip: that much is sliding.
    const bool slides = sliding > 0 && opening <= rest.contacts[i].mu * sliding * (1 + 1e-6);
    const double size = slides ? sliding : opening;
    if (size <= largest * (1 + 1e-9)) continue;
    largest = size;
    result.contact = static_cast<int>(i);
    result.slides = slides;
  }
  return result;
}

}  // namespace skerry::statics
