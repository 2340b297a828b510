// SPDX-License-Identifier: MIT
#include "physics/solver/still_rows.h"

#include <algorithm>
#include <cmath>

#include "physics/solver/contact_states.h"

namespace skerry {
namespace {

bool is_still(const IslandSystem& system, std::size_t i) {
  const Row& row = system.rows[i];
  const auto moves = [&](int body, const std::array<double, 3>& J) {
    return body >= 0 && inverse_mass_along(system.bodies[static_cast<std::size_t>(body)], J) > 0;
  };
  const bool soft = !system.compliance.empty() && system.compliance[i] > 0;
  return !soft && !moves(row.a, row.Ja) && !moves(row.b, row.Jb) &&
         !(row.kind == RowKind::Normal && row.lower > 0);
}

}  // namespace

bool StillRows::find(const IslandSystem& system) {
  const auto holds = [](const InverseMass& body) { return !(body.linear > 0) || !(body.angular > 0); };
  if (std::none_of(system.bodies.begin(), system.bodies.end(), holds)) return false;
  system_ = &system;
  place_.assign(system.rows.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < place_.size(); ++i) {
    const Row& row = system.rows[i];
    // A contact that nothing can open or close is not pressed, and rubs as little.
    const bool rests = is_scaled(row) && place_[static_cast<std::size_t>(row.normal)] < 0;
    if (!rests && !is_still(system, i)) place_[i] = count++;
  }
  if (count == system.size()) return false;
  others_.bodies = system.bodies;
  others_.positions = system.positions;
  others_.rows.clear();
  others_.b.clear();
  others_.compliance.clear();
  for (std::size_t i = 0; i < place_.size(); ++i) {
    if (place_[i] < 0) continue;
    others_.rows.push_back(system.rows[i]);
    Row& row = others_.rows.back();
    if (is_scaled(row)) row.normal = place_[static_cast<std::size_t>(row.normal)];
    others_.b.push_back(system.b[i]);
    if (!system.compliance.empty()) others_.compliance.push_back(system.compliance[i]);
  }
  return true;
}

void StillRows::restrict(std::span<const double> lambda, std::vector<double>& others) const {
  others.clear();
  if (lambda.size() != place_.size()) return;
  for (std::size_t i = 0; i < place_.size(); ++i)
    if (place_[i] >= 0) others.push_back(lambda[i]);
}

void StillRows::expand(Solution& solution, const SolveOptions& options) const {
  std::vector<double> lambda(place_.size(), 0.0);
  for (std::size_t i = 0; i < place_.size(); ++i) {
    const Row& row = system_->rows[i];
    if (place_[i] >= 0) {
      lambda[i] = solution.lambda[static_cast<std::size_t>(place_[i])];
      continue;
    }
    const double normal_impulse = is_scaled(row) ? lambda[static_cast<std::size_t>(row.normal)] : 0;
    const ImpulseBounds bounds = impulse_bounds(row, normal_impulse);
    const double b = system_->b[i], wanted = b > 0 ? bounds.upper : b < 0 ? bounds.lower : 0;
    lambda[i] = std::isfinite(wanted) ? std::clamp(wanted, bounds.lower, bounds.upper) : 0;
  }
  const SolveStatus of_others = solution.status;
  solution.lambda = std::move(lambda);
  conclude(*system_, options, solution);
  if (of_others != SolveStatus::Solved && solution.status != SolveStatus::Solved) solution.status = of_others;
}

}  // namespace skerry
