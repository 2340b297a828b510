// SPDX-License-Identifier: MIT
//
// The two sides of a contact with a chain.
#pragma once

#include "physics/contact.h"
#include "physics/world_state.h"

namespace skerry {

inline bool is_on_chain(const WorldState& state, const Contact& contact) {
  return state.shapes[contact.shape_a].shape->kind == ShapeKind::Chain ||
         state.shapes[contact.shape_b].shape->kind == ShapeKind::Chain;
}

/// A chain and what meets it.
struct ChainSide {
  bool of_a;           ///< the chain is shape a of the contact
  const Shape& chain;  ///< in the frame of its body
  const Shape& other;
  Vec2 middle;  ///< of the other shape: the mean of its corners, in the frame of its body [m]
};

/// The mean of the corners [m].
inline Vec2 middle_of(const Shape& shape) {
  Vec2 middle;
  for (const Vec2 corner : shape.vertices) middle += corner / static_cast<double>(shape.vertices.size());
  return middle;
}

/// @pre is_on_chain
inline ChainSide chain_side(const WorldState& state, const Contact& contact) {
  const bool of_a = state.shapes[contact.shape_a].shape->kind == ShapeKind::Chain;
  const Shape& chain = state.shapes[of_a ? contact.shape_a : contact.shape_b].shape;
  const Shape& other = state.shapes[of_a ? contact.shape_b : contact.shape_a].shape;
  return {of_a, chain, other, middle_of(other)};
}

}  // namespace skerry
