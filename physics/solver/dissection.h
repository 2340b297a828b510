// SPDX-License-Identifier: MIT
//
// Nested dissection of the body graph by straight cuts through the places of the bodies. Of large regular
// structures (nets, walls, pyramids) it leaves less fill than minimum degree, and a tree whose branches are
// alike, which threads can share.
#pragma once

#include <span>
#include <vector>

#include "physics/math.h"

namespace skerry {

/// A graph in compressed form: the neighbours of node i are `neighbour[start[i]]` to
/// `neighbour[finish[i] - 1]`, without i itself.
struct Adjacency {
  std::span<const int> start, finish, neighbour;
};

/// Order of elimination by nested dissection [George 1973]: the nodes on one side of a cut, those on the
/// other side, and at last those that part them. Of a few directions and the middle two fifths of the places
/// along each, the cut is taken that needs fewest of the last kind, less so the farther it is from the
/// middle.
/// @param places    of the nodes, finite [m]
/// @param position  of each node in another order, which small parts keep
/// @param order     becomes the nodes in the order of their elimination
void dissect(const Adjacency& graph, std::span<const Vec2> places, std::span<const int> position,
             std::vector<int>& order);

}  // namespace skerry
