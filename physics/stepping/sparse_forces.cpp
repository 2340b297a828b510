// SPDX-License-Identifier: MIT
#include "physics/stepping/sparse_forces.h"

#include <algorithm>
#include <cmath>

namespace skerry {
namespace {

// Each step leaves eta D / (eta D + s) of an error along a direction with the eigenvalue s of W. 1e-9 leaves
// rounding after two or three steps where s is 1e-4 of D (a chain of 100 links), and seven digits to the
// factor.
constexpr double kEta = 1e-9;
constexpr int kMaxSteps = 40;

}  // namespace

bool SparseForces::solve(const IslandSystem& system, int unknowns, SolveWork& work,
                         std::vector<double>& lambda) {
  const std::size_t n = system.rows.size();
  const std::size_t m = static_cast<std::size_t>(unknowns);
  model_.assign(system, work);
  std::vector<double> g(n, 0), h(n, 0), w(n), k(n), change(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Row& row = system.rows[i];
    const BodySpaceModel::RowInfo& info = model_.row(static_cast<int>(i));
    if (i < m)
      g[i] = info.dead ? 0 : 1 / (kEta * info.D);
    else
      h[i] = row.mu * g[static_cast<std::size_t>(row.normal)];
  }
  if (!model_.factor(g.data(), h.data(), work)) return false;

  const auto violation = [&](const std::vector<double>& at) {
    model_.evaluate(at.data(), w.data());
    double worst = 0;
    for (std::size_t i = 0; i < m; ++i) worst = std::max(worst, std::abs(w[i]));
    return worst;
  };
  double worst = violation(lambda);
  std::vector<double> next(n);
  for (int step = 0; step < kMaxSteps && worst > 0; ++step) {
    for (std::size_t i = 0; i < m; ++i) k[i] = -g[i] * w[i];
    for (std::size_t i = m; i < n; ++i)
      k[i] = system.rows[i].mu * k[static_cast<std::size_t>(system.rows[i].normal)];
    model_.solve(k.data(), g.data(), h.data(), change.data(), work);
    for (std::size_t i = 0; i < n; ++i) next[i] = lambda[i] + change[i];
    const double then = violation(next);
    if (!(then < worst)) break;
    lambda.swap(next);
    // What no longer falls by half is rounding.
    const bool settled = then > 0.5 * worst;
    worst = then;
    if (settled) break;
  }
  return worst <= 1e-9 * model_.scale();
}

}  // namespace skerry
