// SPDX-License-Identifier: MIT
#include "physics/registry.h"

#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "physics/broadphase/pair_finder.h"

namespace skerry {

namespace {

constexpr std::string_view kNames[] = {"brute_force",     "uniform_grid",   "hierarchical_grid",
                                       "sweep_and_prune", "hash_sort",      "hierarchical_hash_sort",
                                       "aabb_tree",       "neighbour_list", "auto"};

/// Refuses options that no implementation could follow.
void check(const BroadPhaseOptions& options) {
  std::ostringstream text;
  if (!(options.cell_size >= 0 && options.cell_size < kInfinity)) {
    text << "broad phase: cell_size must be finite and not negative, got " << options.cell_size;
  } else if (options.axes.size() > 4) {
    text << "broad phase: there can be 1 to 4 axes, got " << options.axes.size();
  } else if (options.threads < 1 || options.threads > 256) {
    text << "broad phase: threads must be from 1 to 256, got " << options.threads;
  }
  for (const double angle : options.axes) {
    if (!std::isfinite(angle)) text << "broad phase: the angle of an axis must be finite, got " << angle;
  }
  if (!text.str().empty()) throw std::invalid_argument(text.str());
}

template <std::size_t index, std::unique_ptr<PairFinder> (*make)(const BroadPhaseOptions&)>
std::unique_ptr<BroadPhase> make_entry(const BroadPhaseOptions& options) {
  check(options);
  return make_with_finder(kNames[index], make(options));
}

const std::array kEntries = {
    BroadPhaseEntry{kNames[0], "tests every box against every other; the oracle",
                    "all pairs, in packed blocks", &make_entry<0, make_brute_force>},
    BroadPhaseEntry{kNames[1], "cells of one size with lists of boxes, hashed: the world has no bounds",
                    "Ericson 2005, Real-Time Collision Detection, sec. 7.1",
                    &make_entry<1, make_uniform_grid>},
    BroadPhaseEntry{kNames[2], "cells that double from level to level; a box on the smallest that holds it",
                    "Ericson 2005, Real-Time Collision Detection, sec. 7.2",
                    &make_entry<2, make_hierarchical_grid>},
    BroadPhaseEntry{kNames[3], "interval ends on oblique axes, kept sorted from step to step",
                    "Baraff 1992; Cohen, Lin, Manocha, Ponamgi 1995", &make_entry<3, make_sweep_and_prune>},
    BroadPhaseEntry{kNames[4], "a hash table of intervals on each axis; nothing is sorted",
                    "sweep and prune with the sorted lists replaced by hashing",
                    &make_entry<4, make_hash_sort>},
    BroadPhaseEntry{kNames[5], "the same with cells of every power of two",
                    "hash sort with the levels of a hierarchical grid",
                    &make_entry<5, make_hierarchical_hash_sort>},
    BroadPhaseEntry{kNames[6], "dynamic tree of boxes with margins, improved by rotations",
                    "Kopta, Ize, Spjut, Brunvand, Davis, Kensler 2012", &make_entry<6, make_aabb_tree>},
    BroadPhaseEntry{kNames[7], "boxes with margins, and a sorted list of their pairs kept from step to step",
                    "Verlet 1967, Phys. Rev. 159, table of neighbours", &make_entry<7, make_neighbour_list>},
    BroadPhaseEntry{kNames[8], "picks one of the others from the scene, and changes it while running",
                    "the measurements of tests/bench/broadphase_bench.cpp", &make_entry<8, make_auto>},
};

}  // namespace

std::string reason_of(const BroadPhaseChoice& choice) {
  if (choice.reason == BroadPhaseReason::Named) return "by name";
  if (choice.reason == BroadPhaseReason::FewBoxes) return "few boxes";
  std::ostringstream text;
  text.precision(2);
  text << "about " << std::lround(choice.moved) << " of " << choice.boxes << " moved a step, "
       << choice.smallest << " to " << choice.largest << " m, in " << choice.extent.x << " m x "
       << choice.extent.y << " m";
  return text.str();
}

std::span<const BroadPhaseEntry> broad_phases() {
  return kEntries;
}

std::unique_ptr<BroadPhase> make_broad_phase(std::string_view name, const BroadPhaseOptions& options) {
  return find_entry("broad phase", name, broad_phases()).make(options);
}

}  // namespace skerry
