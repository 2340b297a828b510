// SPDX-License-Identifier: MIT
#include "physics/stepping/one_piece_store.h"

#include <algorithm>

#include "physics/stepping/point_memory.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

/// Landings: contacts that carried nothing and were struck. @return whether this is one
bool note_hit(const PieceAnswer& answer, std::size_t row, Contact& contact) {
  const RowOrigin& origin = answer.assembly.origin[row];
  PointMemory& memory = contact.points[static_cast<std::size_t>(origin.point)];
  const double lambda = answer.lambda[row];
  const double u = row_velocity(answer.assembly, static_cast<int>(row), answer.before);
  if ((memory.normal_impulse > 0 && !answer.exact) || u > -answer.slow) {
    memory.total_normal += lambda;
    return false;
  }
  memory.total_impact += lambda;
  contact.impact += lambda * push_on_b(answer.assembly.system.rows[row]);
  memory.impact_position = contact.manifold.points[static_cast<std::size_t>(origin.point)].position;
  contact.hit = true;
  if (-u <= contact.hit_speed) return true;
  contact.hit_speed = -u;
  contact.hit_time = answer.from + std::min(answer.h, std::max(0.0, origin.error) / -u);
  contact.hit_point = memory.impact_position;
  contact.hit_normal = contact.manifold.normal;
  return true;
}

}  // namespace

StoredRows store_contacts(WorldState& state, const Island& island, const PieceAnswer& answer,
                          std::size_t from, std::size_t to) {
  const Assembly& assembly = answer.assembly;
  const auto first_of = [&](std::uint32_t index) {
    const auto row = std::partition_point(
        assembly.origin.begin(), assembly.origin.end(),
        [index](const RowOrigin& origin) { return origin.joint || origin.index < index; });
    return static_cast<std::size_t>(row - assembly.origin.begin());
  };
  StoredRows stored;
  std::size_t i = first_of(island.contacts[from]);
  for (std::size_t k = from; k < to; ++k) {
    const std::uint32_t index = island.contacts[k];
    Contact& contact = state.contacts[index];
    const std::size_t first = i;
    while (i < answer.lambda.size() && assembly.origin[i].index == index) ++i;
    for (std::size_t row = first; row < i; ++row) {
      if (assembly.origin[row].kind == RowKind::Normal && answer.lambda[row] > 0)
        stored.landings += note_hit(answer, row, contact);
    }
    forget_impulses(contact, answer.h);
    for (std::size_t row = first; row < i; ++row) {
      stored.friction += assembly.origin[row].kind == RowKind::Friction;
      remember_impulse(assembly.origin[row], assembly.system.rows[row], answer.lambda[row], contact);
    }
  }
  return stored;
}

}  // namespace skerry
