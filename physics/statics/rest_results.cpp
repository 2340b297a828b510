// SPDX-License-Identifier: MIT
//
// What the forces of a world at rest say: how it begins to move, resultants of joints, the line of thrust.
#include <algorithm>
#include <cmath>

#include "physics/statics/rest.h"

namespace skerry::statics {
namespace {

// A pair with less than this share of the largest normal force carries nothing: it is what solves leave.
constexpr double kCarries = 1e-7;

}  // namespace

const char* to_string(Fate fate) {
  switch (fate) {
    case Fate::Stands:
      return "stands";
    case Fate::Slides:
      return "slides";
    case Fate::Tips:
      return "tips";
    case Fate::Falls:
      return "falls";
    case Fate::Collapses:
      return "collapses";
  }
  return "";
}

Fate fate_of(const RestAnalysis& rest) {
  if (rest.stands) return Fate::Stands;
  std::vector<std::uint8_t> supported(rest.bodies.size(), 0);
  for (const Row& row : rest.system.rows) {
    if (row.a >= 0) supported[static_cast<std::size_t>(row.a)] = 1;
    if (row.b >= 0) supported[static_cast<std::size_t>(row.b)] = 1;
  }
  int turning = 0, sliding = 0, falling = 0;
  for (std::size_t k = 0; k < rest.bodies.size(); ++k) {
    const std::array<double, 3>& a = rest.acceleration[k];
    const double size = rest.size(k, a);
    if (size <= rest.rounding[k]) continue;
    if (!supported[k])
      ++falling;
    else if (rest.size(k, {0, 0, a[2]}) > std::max(rest.rounding[k], 1e-6 * size))
      ++turning;
    else
      ++sliding;
  }
  if (turning == 0) return sliding > 0 ? Fate::Slides : Fate::Falls;
  return turning == 1 && sliding == 0 ? Fate::Tips : Fate::Collapses;
}

std::vector<PairForce> pair_forces(const RestAnalysis& rest) {
  double largest = 0;
  for (const RestContact& c : rest.contacts) largest = std::max(largest, c.normal_force);
  std::vector<PairForce> result;
  for (std::size_t i = 0; i < rest.contacts.size();) {
    PairForce pair;
    pair.first = static_cast<int>(i);
    Vec2 moment_point{}, middle{};
    double mu = 0;
    std::size_t end = i;
    for (; end < rest.contacts.size() && rest.contacts[end].pair == rest.contacts[i].pair; ++end) {
      const RestContact& c = rest.contacts[end];
      pair.normal += c.normal_force;
      pair.friction += c.friction_force;
      pair.force += c.normal_force * c.normal + c.friction_force * perp(c.normal);
      moment_point += c.normal_force * c.position;
      middle += c.position;
      mu = c.mu;
    }
    pair.count = static_cast<int>(end - i);
    const auto number = static_cast<std::size_t>(rest.contacts[i].pair);
    pair.unique = number >= rest.pair_unique.size() || rest.pair_unique[number] != 0;
    middle = middle / static_cast<double>(pair.count);
    const bool carries = pair.normal > kCarries * largest;
    pair.at = carries ? moment_point / pair.normal : middle;
    const double half =
        pair.count == 2 ? 0.5 * length(rest.contacts[i + 1].position - rest.contacts[i].position) : 0;
    pair.eccentricity = half > 0 ? length(pair.at - middle) / half : 0;
    pair.grip = carries && mu > 0 ? std::abs(pair.friction) / (mu * pair.normal) : 0;
    result.push_back(pair);
    i = end;
  }
  return result;
}

std::vector<ThrustSegment> thrust_line(const RestAnalysis& rest) {
  const std::vector<PairForce> pairs = pair_forces(rest);
  double largest = 0;
  for (const PairForce& pair : pairs) largest = std::max(largest, length(pair.force));
  std::vector<ThrustSegment> result;
  for (const BodyId body : rest.bodies) {
    std::vector<const PairForce*> loaded;
    for (const PairForce& pair : pairs) {
      const RestContact& c = rest.contacts[static_cast<std::size_t>(pair.first)];
      if ((c.body_a == body || c.body_b == body) && length(pair.force) > 1e-9 * largest)
        loaded.push_back(&pair);
    }
    if (loaded.size() != 2) continue;
    result.push_back(
        {body, loaded[0]->at, loaded[1]->at, 0.5 * (length(loaded[0]->force) + length(loaded[1]->force))});
  }
  return result;
}

}  // namespace skerry::statics
