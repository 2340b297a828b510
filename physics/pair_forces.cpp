// SPDX-License-Identifier: MIT
#include "physics/pair_forces.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "physics/text.h"
#include "physics/world.h"

namespace skerry {
namespace {

struct Member {
  BodyId body;
  Vec2 position;
  double weight;
};

/// x^n for a whole n, the same everywhere.
double whole_power(double x, int n) {
  double result = 1;
  for (double factor = n < 0 ? 1 / x : x; n != 0; n /= 2, factor *= factor) {
    if (n % 2 != 0) result *= factor;
  }
  return result;
}

/// square^(-exponent / 2). Whole exponents do not depend on the machine.
double falling(double square, double exponent) {
  constexpr double kMost = 64;
  if (exponent != std::floor(exponent) || std::abs(exponent) > kMost)
    return std::pow(square, -0.5 * exponent);
  const int n = static_cast<int>(exponent);
  return n % 2 == 0 ? whole_power(square, -n / 2) : whole_power(std::sqrt(square), -n);
}

double square_between(const PairLaw& law, Vec2 way) {
  return length_squared(way) + law.softening * law.softening;
}

/// Energy of a pair whose root distance has this square.
double energy_of(const PairLaw& law, double square) {
  if (law.power == 1) return 0.5 * law.strength * std::log(square);
  return law.strength * falling(square, law.power - 1) / (1 - law.power);
}

std::string words_of(const Member& a, const Member& b) {
  return "bodies " + std::to_string(a.body.index) + " and " + std::to_string(b.body.index) + ", " +
         to_text(length(b.position - a.position)) + " m apart";
}

/// What acts on each other now. @param ahead  where it is after so long with its velocity [s]
std::vector<Member> members(const World& world, const std::vector<std::pair<BodyId, double>>& named,
                            bool by_mass, double ahead) {
  std::vector<Member> all;
  const auto add = [&](BodyId body, double weight) {
    all.push_back({body, world.position(body) + ahead * world.velocity(body), weight});
  };
  if (by_mass) {
    const BodyArrays& bodies = world.bodies();
    for (std::size_t i = 0; i < bodies.type.size(); ++i) {
      if (bodies.alive[i] == 0 || bodies.type[i] != BodyType::Dynamic) continue;
      const BodyId body = world.body_id(i);
      add(body, world.mass(body));
    }
  } else {
    for (const auto& [body, weight] : named) {
      if (world.alive(body)) add(body, weight);
    }
  }
  return all;
}

}  // namespace

PairForces::PairForces(const PairLaw& law) {
  set_law(law);
}

void PairForces::set_law(const PairLaw& law) {
  const auto refuse = [](const char* what, double value) {
    throw std::invalid_argument(std::string("PairForces: ") + what + ", got " + to_text(value));
  };
  if (!std::isfinite(law.strength)) refuse("strength must be finite", law.strength);
  if (!std::isfinite(law.power)) refuse("power must be finite", law.power);
  if (!std::isfinite(law.softening) || law.softening < 0)
    refuse("softening must be finite and at least 0", law.softening);
  law_ = law;
}

void PairForces::set_weight(BodyId body, double weight) {
  if (!std::isfinite(weight))
    throw std::invalid_argument("PairForces::set_weight: weight must be finite, got " + to_text(weight));
  by_mass_ = false;
  const auto at = std::lower_bound(named_.begin(), named_.end(), body, [](const auto& one, BodyId id) {
    return std::pair(one.first.index, one.first.generation) < std::pair(id.index, id.generation);
  });
  if (at != named_.end() && at->first == body)
    at->second = weight;
  else
    named_.insert(at, {body, weight});
}

void PairForces::apply(World& world, double h) const {
  if (!std::isfinite(h) || h < 0)
    throw std::invalid_argument("PairForces::apply: h must be finite and at least 0, got " + to_text(h));
  const std::vector<Member> all = members(world, named_, by_mass_, 0.5 * h);
  std::vector<Vec2> force(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const Vec2 way = all[j].position - all[i].position;
      const double square = square_between(law_, way);
      if (!(square > 0)) continue;
      const double weights = all[i].weight * all[j].weight;
      const Vec2 pull = law_.strength * weights * falling(square, law_.power + 1) * way;
      if (!std::isfinite(pull.x) || !std::isfinite(pull.y))
        throw std::invalid_argument("PairForces::apply: force between " + words_of(all[i], all[j]) +
                                    ", is not finite");
      force[i] += pull;
      force[j] -= pull;
    }
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const BodyId body = all[i].body;
    if (world.bodies().type[body.index] == BodyType::Dynamic)
      world.apply_force(body, force[i], world.position(body));
  }
}

double PairForces::potential_energy(const World& world) const {
  const std::vector<Member> all = members(world, named_, by_mass_, 0);
  double energy = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const double square = square_between(law_, all[j].position - all[i].position);
      if (square > 0) energy += all[i].weight * all[j].weight * energy_of(law_, square);
    }
  }
  return energy;
}

}  // namespace skerry
