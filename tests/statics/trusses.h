// SPDX-License-Identifier: MIT
//
// Structures for tests and benchmarks.
#pragma once

#include <random>
#include <vector>

#include "physics/statics/structure_solver.h"

namespace skerry::statics::test {

/// A Pratt truss of `panels` panels, 2 m long and 2 m high: 4 panels - 3 members; bottom nodes first.
inline Structure pratt(int panels) {
  Structure s;
  const double side = 2;
  for (int i = 0; i <= panels; ++i) s.nodes.push_back({{side * i, 0}});
  for (int i = 1; i < panels; ++i) s.nodes.push_back({{side * i, side}});
  const auto top = [&](int i) { return panels + i; };
  for (int i = 0; i < panels; ++i) s.members.push_back({i, i + 1});
  for (int i = 1; i + 1 < panels; ++i) s.members.push_back({top(i), top(i + 1)});
  for (int i = 1; i < panels; ++i) s.members.push_back({i, top(i)});
  s.members.push_back({0, top(1)});
  s.members.push_back({top(panels - 1), panels});
  for (int i = 1; i + 1 < panels; ++i) {
    const bool left = 2 * i < panels;
    s.members.push_back(left ? Member{top(i), i + 1} : Member{i, top(i + 1)});
  }
  for (Member& m : s.members) {
    m.area = 0.01;
    m.modulus = 2e11;
  }
  s.supports = {{0, SupportKind::Pinned}, {panels, SupportKind::Roller}};
  return s;
}

/// A truss that grows by two bars and a node at a time: determinate by construction. Node k + 2 hangs on the
/// bars 2 k + 1 and 2 k + 2.
inline Structure random_truss(std::mt19937_64& random, int nodes) {
  Structure s;
  std::uniform_real_distribution<double> unit(-1, 1);
  s.nodes = {{{0, 0}}, {{4, 0.3 * unit(random)}}};
  s.members.push_back({0, 1});
  while (static_cast<int>(s.nodes.size()) < nodes) {
    std::uniform_int_distribution<int> any(std::max(0, static_cast<int>(s.nodes.size()) - 4),
                                           static_cast<int>(s.nodes.size()) - 1);
    const int a = any(random), b = any(random);
    if (a == b) continue;
    const Vec2 pa = s.nodes[static_cast<std::size_t>(a)].at, pb = s.nodes[static_cast<std::size_t>(b)].at;
    const Vec2 at = 0.5 * (pa + pb) + Vec2{3 * unit(random), 3 * unit(random)};
    const double la = length(at - pa), lb = length(at - pb);
    // Bars that nearly lie in one line carry huge forces; real trusses avoid them.
    if (la < 0.5 || lb < 0.5 || std::abs(cross(at - pa, at - pb)) < 0.4 * la * lb) continue;
    s.nodes.push_back({at});
    const int c = static_cast<int>(s.nodes.size()) - 1;
    s.members.push_back({a, c});
    s.members.push_back({b, c});
  }
  std::uniform_real_distribution<double> area(0.001, 0.1);
  for (Member& m : s.members) {
    m.area = area(random);
    m.modulus = 2e11;
  }
  s.supports = {{0, SupportKind::Pinned}, {1, SupportKind::Roller, 0.5 * unit(random)}};
  return s;
}

inline Load random_load(std::mt19937_64& random, const Structure& s) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Load load;
  for (int i = 0; i < static_cast<int>(s.nodes.size()); ++i)
    load.nodes.push_back({i, {1000 * unit(random), 1000 * unit(random)}});
  return load;
}

/// Beams along the x axis through `stations`, all of the same section, on supports that may turn.
inline Structure continuous_beam(const std::vector<double>& stations) {
  Structure s;
  for (const double x : stations) s.nodes.push_back({{x, 0}});
  for (int i = 0; i + 1 < static_cast<int>(stations.size()); ++i) {
    Member m{i, i + 1, MemberKind::Beam};
    m.modulus = 2e11;
    m.area = 0.02;
    m.second_moment = 3e-4;
    m.depth = 0.4;
    s.members.push_back(m);
  }
  for (int i = 0; i < static_cast<int>(stations.size()); ++i)
    s.supports.push_back({i, i == 0 ? SupportKind::Pinned : SupportKind::Roller});
  return s;
}

}  // namespace skerry::statics::test
