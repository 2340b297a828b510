// SPDX-License-Identifier: MIT
#include "physics/solver/small_topology.h"

#include <bit>

namespace skerry::small {
namespace {

// What bounds a row; false if the fast path does not know it.
bool read_bounds(const Row& row, signed char& normal) {
  normal = static_cast<signed char>(row.normal);
  if (row.normal >= 0) return true;
  if (row.kind == RowKind::Normal && row.lower == 0 && row.upper == kInfinity) {
    normal = kNormalRow;
    return true;
  }
  normal = kJointRow;
  return row.kind == RowKind::Joint && row.lower == -kInfinity && row.upper == kInfinity;
}

// Of the rows that the group has so far and a further one.
Bounds bounds_with(const Group& group, std::size_t row, signed char normal) {
  if (group.count == 0)
    return normal == kNormalRow ? Bounds::Normal : normal == kJointRow ? Bounds::Joint : Bounds::Mixed;
  const bool own_friction = normal == static_cast<signed char>(row) - 1;
  switch (group.bounds) {
    case Bounds::Normal:
      if (normal == kNormalRow) return Bounds::Normal;
      return group.count == 1 && own_friction ? Bounds::Contacts : Bounds::Mixed;
    case Bounds::Joint:
      return normal == kJointRow ? Bounds::Joint : Bounds::Mixed;
    case Bounds::Contacts:
      return group.count % 2 == 0 ? (normal == kNormalRow ? Bounds::Contacts : Bounds::Mixed)
                                  : (own_friction ? Bounds::Contacts : Bounds::Mixed);
    case Bounds::Mixed:
      break;
  }
  return Bounds::Mixed;
}

// No more rows come.
void close(Topology& t, Group& group) {
  t.slots += group.slots();
  if (group.bounds == Bounds::Contacts && group.count % 2 != 0) group.bounds = Bounds::Mixed;
}

}  // namespace

bool read_topology(const IslandSystem& system, Topology& t) {
  const std::size_t rows = system.rows.size(), bodies = system.bodies.size();
  if (rows == 0 || rows > kSmallRows || bodies > kSmallBodies || !system.compliance.empty()) return false;
  for (const InverseMass& m : system.bodies)
    if (!(m.linear > 0 && m.angular > 0)) return false;
  t.bodies = static_cast<int>(bodies);
  t.rows = static_cast<int>(rows);
  t.groups = t.slots = 0;
  t.tower = false;
  for (std::size_t j = 0; j < bodies; ++j) t.below[j] = 0;
  Group* group = nullptr;
  for (std::size_t i = 0; i < rows; ++i) {
    const Row& row = system.rows[i];
    if (!read_bounds(row, t.normal[i])) return false;
    const int a = std::min(row.a, row.b), b = std::max(row.a, row.b);
    // Rows of a group name its bodies in the same order.
    if (!group || group->count == kTogether || group->a != a || group->b != b ||
        row.a != system.rows[i - 1].a) {
      if (t.groups == kGroups || b < 0) return false;
      if (group) close(t, *group);
      group = &t.group[at(t.groups++)];
      *group = {static_cast<signed char>(a),       static_cast<signed char>(b),
                static_cast<signed char>(i),       0,
                static_cast<signed char>(t.slots), Bounds::Mixed};
      if (a >= 0) t.below[at(a)] |= 1u << b;
    }
    group->bounds = bounds_with(*group, i, t.normal[i]);
    t.group_of[i] = static_cast<signed char>(t.groups - 1);
    t.lane[i] = group->count++;
  }
  close(t, *group);
  for (std::size_t j = 0; j < bodies; ++j)
    if (t.below[j]) {
      const int parent = std::countr_zero(t.below[j]);
      t.below[at(parent)] |= t.below[j] & ~(1u << parent);
    }
  return true;
}
// Topology of a tower. @return false if the island is none
bool read_tower(const IslandSystem& system, Topology& t) {
  const std::size_t bodies = system.bodies.size();
  if (bodies > kSmallBodies || system.rows.size() != 4 * bodies || bodies == 0 || !system.compliance.empty())
    return false;
  for (const InverseMass& m : system.bodies)
    if (!(m.linear > 0 && m.angular > 0)) return false;
  t.bodies = t.groups = static_cast<int>(bodies);
  t.rows = t.slots = 4 * t.bodies;
  t.tower = true;
  unsigned stands = 0;
  for (int k = 0; k < t.groups; ++k) {
    const Row* const rows = system.rows.data() + 4 * k;
    const int a = std::min(rows[0].a, rows[0].b), b = std::max(rows[0].a, rows[0].b);
    if (b < 0 || (stands >> b & 1) != 0 || !is_edge(rows, 4 * k)) return false;
    stands |= 1u << b;
    t.support[at(b)] = static_cast<signed char>(k);
    t.group[at(k)] = {static_cast<signed char>(a),     static_cast<signed char>(b),
                      static_cast<signed char>(4 * k), 4,
                      static_cast<signed char>(4 * k), Bounds::Contacts};
  }
  return true;
}

}  // namespace skerry::small
