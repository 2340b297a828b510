// SPDX-License-Identifier: MIT
#include "sandbox/delassus_cells.h"

#include <algorithm>
#include <cmath>

namespace skerry::sandbox {
namespace {

// What body `body` adds to W between two rows: J_i M^-1 J_j'.
double share(const IslandSystem& system, const Row& i, const Row& j, int body) {
  const InverseMass& mass = system.bodies[static_cast<std::size_t>(body)];
  const std::array<double, 3>& Ji = i.a == body ? i.Ja : i.Jb;
  const std::array<double, 3>& Jj = j.a == body ? j.Ja : j.Jb;
  return mass.linear * (Ji[0] * Jj[0] + Ji[1] * Jj[1]) + mass.angular * Ji[2] * Jj[2];
}

}  // namespace

CellGrid delassus_cells(const IslandSystem& system, int most) {
  const int n = system.size();
  CellGrid grid;
  grid.size = std::min(n, most);
  grid.values.assign(static_cast<std::size_t>(grid.size) * static_cast<std::size_t>(grid.size), 0.0);

  std::vector<std::vector<int>> rows_of(system.bodies.size());
  for (int i = 0; i < n; ++i) {
    const Row& row = system.rows[static_cast<std::size_t>(i)];
    if (row.a >= 0) rows_of[static_cast<std::size_t>(row.a)].push_back(i);
    if (row.b >= 0) rows_of[static_cast<std::size_t>(row.b)].push_back(i);
  }
  const auto cell_of = [&](int i) { return static_cast<int>(static_cast<long long>(i) * grid.size / n); };

  std::vector<double> line(static_cast<std::size_t>(n), 0.0);
  std::vector<char> seen(static_cast<std::size_t>(n), 0);
  for (int i = 0; i < n; ++i) {
    const Row& row = system.rows[static_cast<std::size_t>(i)];
    std::vector<int> touched;
    const auto add = [&](int j, double value) {
      const auto at = static_cast<std::size_t>(j);
      if (!seen[at]) touched.push_back(j);
      seen[at] = 1;
      line[at] += value;
    };
    for (const int body : {row.a, row.b}) {
      if (body < 0) continue;
      for (const int j : rows_of[static_cast<std::size_t>(body)])
        add(j, share(system, row, system.rows[static_cast<std::size_t>(j)], body));
    }
    if (!system.compliance.empty()) add(i, system.compliance[static_cast<std::size_t>(i)]);
    for (const int j : touched) {
      const auto at = static_cast<std::size_t>(j);
      double& cell = grid.values[static_cast<std::size_t>(cell_of(i)) * static_cast<std::size_t>(grid.size) +
                                 static_cast<std::size_t>(cell_of(j))];
      if (std::abs(line[at]) > std::abs(cell)) cell = line[at];
      grid.largest = std::max(grid.largest, std::abs(line[at]));
      line[at] = 0;
      seen[at] = 0;
    }
    grid.nonzeros += static_cast<int>(touched.size());
  }
  return grid;
}

}  // namespace skerry::sandbox
