// SPDX-License-Identifier: MIT
//
// Stable names for things that live in contiguous arrays: an index and the generation of its slot.
#pragma once

#include <cstdint>

namespace skerry {

/// Names a body, shape or joint of a world. The slot is used again after removal, with a higher generation,
/// so a handle that outlived its object is recognised and refused.
template <class Tag>
struct Handle {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t index = kNone;
  std::uint32_t generation = 0;

  explicit operator bool() const { return index != kNone; }
  friend bool operator==(Handle, Handle) = default;
};

using BodyId = Handle<struct BodyTag>;
using ShapeId = Handle<struct ShapeTag>;
using JointId = Handle<struct JointTag>;

}  // namespace skerry
