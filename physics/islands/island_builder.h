// SPDX-License-Identifier: MIT
//
// Islands: connected components of dynamic bodies over the contacts and joints of this step. Static and
// kinematic bodies do not connect. The numbering is canonical, so it depends neither on the broad phase nor
// on threads.
#pragma once

#include <cstdint>
#include <vector>

namespace skerry {

/// One island as slots; all three lists ascend.
struct Island {
  std::vector<std::uint32_t> bodies;    ///< dynamic bodies
  std::vector<std::uint32_t> contacts;  ///< indices into the contact table
  std::vector<std::uint32_t> joints;
  bool alone = false;  ///< stepped by the rules of a small world, however large this one is

  friend bool operator==(const Island&, const Island&) = default;
};

/// An edge of the contact graph: contact or joint `index` between two bodies, of which only the dynamic ones
/// connect.
struct IslandEdge {
  std::uint32_t a, b;
  bool a_dynamic, b_dynamic;
  std::uint32_t index;
  bool joint;
};

/// Finds the connected components by union-find with path halving [Tarjan & van Leeuwen 1984]. Keeps its
/// tables, so that a world that is mostly asleep costs nothing for those who sleep.
class IslandBuilder {
 public:
  /// @param bodies  slots of the dynamic bodies that take part, ascending
  /// @param edges   in ascending order of index, contacts and joints each; dynamic ends are in `bodies`
  /// @return islands in the order of their smallest body; edges between two bodies that are not dynamic
  /// belong to none
  std::vector<Island> build(const std::vector<std::uint32_t>& bodies, const std::vector<IslandEdge>& edges);
  /// The same into the memory of other islands.
  void build(const std::vector<std::uint32_t>& bodies, const std::vector<IslandEdge>& edges,
             std::vector<Island>& islands);

 private:
  std::vector<std::uint32_t> parent_, number_;  ///< by slot; only those of the present bodies mean something
};

}  // namespace skerry
