// SPDX-License-Identifier: MIT
//
// What small islands must share to be solved side by side: their bodies, and rows in groups between two of
// them. Found in one pass over the rows.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "physics/index.h"
#include "physics/solver/small_exact.h"

namespace skerry::small {

/// Rows of a pair of bodies that are taken together, and the most such groups: the plane graph of eight
/// bodies and the ground has 21 edges.
inline constexpr int kTogether = 4;
inline constexpr int kGroups = 24;

/// What bounds the rows of a group.
enum class Bounds : signed char {
  Normal,    // zero
  Joint,     // nothing
  Contacts,  // normal rows, each followed by its friction
  Mixed
};

/// Up to four successive rows between two bodies.
struct Group {
  signed char a, b;          // a < b; a is -1 for the ground
  signed char first, count;  // rows
  signed char slot;          // of the first row where each has its own: two or four of them
  Bounds bounds;

  bool operator==(const Group&) const = default;
  int slots() const { return count > 2 ? 4 : 2; }
};

/// In place of the row whose impulse bounds this one.
inline constexpr signed char kNormalRow = -1, kJointRow = -2;

/// What islands must share to be solved side by side. (Nothing has initial values: setting what is not there
/// would cost a box a tenth of its time.)
struct Topology {
  int bodies, rows, groups, slots;
  std::array<unsigned, kSmallBodies> below;  // rows of each column of the factor, as bits
  std::array<Group, kGroups> group;          // the first `groups` are set
  // Of each row: what bounds it, its group and its place in it.
  std::array<signed char, kSmallRows> normal, group_of, lane;
  // Every body stands on one edge of an earlier one, or of the ground: which group that is. Set where
  // `tower`.
  bool tower;
  std::array<signed char, kSmallBodies> support;

  bool operator==(const Topology& o) const {
    return bodies == o.bodies && rows == o.rows && groups == o.groups && tower == o.tower &&
           std::equal(group.begin(), group.begin() + groups, o.group.begin()) &&
           (tower || std::equal(normal.begin(), normal.begin() + rows, o.normal.begin()));
  }
};

/// Topology of an island. @return false if the fast path does not apply
bool read_topology(const IslandSystem& system, Topology& topology);

/// Topology of a tower. @return false if the island is none
bool read_tower(const IslandSystem& system, Topology& topology);

/// Whether four rows, from row `first` of an island, are an edge as `stick_edge` wants it.
inline bool is_edge(const Row* rows, int first) {
  const bool swapped = rows[0].a > rows[0].b;
  for (int i = 0; i < 4; ++i) {
    const Row& row = rows[i];
    if (row.a != rows[0].a || row.b != rows[0].b) return false;
    const bool friction = row.normal == first + i - 1;
    const bool contact =
        row.normal < 0 && row.kind == RowKind::Normal && row.lower == 0 && row.upper == kInfinity;
    if (i % 2 == 0 ? !contact : !friction) return false;
  }
  const auto direction = [&](int i) -> const std::array<double, 3>& {
    return swapped ? rows[i].Ja : rows[i].Jb;
  };
  const auto &n = direction(0), &t = direction(1), &n2 = direction(2), &t2 = direction(3);
  const bool one_direction = n[0] == n2[0] && n[1] == n2[1] && t[0] == t2[0] && t[1] == t2[1];
  return one_direction && ((t[0] == -n[1] && t[1] == n[0]) || (t[0] == n[1] && t[1] == -n[0]));
}

/// Whether a body stands on an edge of the ground.
inline bool is_edge(const IslandSystem& system) {
  if (system.rows.size() != 4 || system.bodies.size() != 1 || !system.compliance.empty()) return false;
  const InverseMass& body = system.bodies[0];
  return body.linear > 0 && body.angular > 0 && is_edge(system.rows.data(), 0);
}

}  // namespace skerry::small
