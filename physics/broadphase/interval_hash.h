// SPDX-License-Identifier: MIT
//
// Intervals on axes in hash tables of cells, in place of sorted lists: the order is implicit in the cells'
// numbers and nothing is ever sorted. `hash_sort` uses cells of one size, `hierarchical_hash_sort` cells of
// any power of two. A box that looks for partners does so on the axis where its cells hold the fewest boxes.
#pragma once

#include <cstdint>
#include <vector>

#include "physics/broadphase/axis.h"
#include "physics/broadphase/pair_finder.h"

namespace skerry {

/// How the cells' sizes are chosen.
enum class IntervalCells {
  Equal,     ///< one size: about the mean length, larger while the lists would exceed eight entries a box
  PerOctave  ///< the smallest power of two that is not below the interval's length: one or two cells each
};

/// The intervals of all boxes on one axis.
class IntervalHash {
 public:
  IntervalHash(Axis axis, IntervalCells kind) : axis_(axis), kind_(kind) {}

  /// Lists all boxes anew, with a size of cells that suits them; `wish` is the size asked for, or 0.
  void rebuild(const BoxSet& boxes, double wish);
  /// Brings one box up to date; false if the lists became too long for the cells' size.
  bool follow(const BoxSet& boxes, ProxyIndex proxy);

  /// An upper bound of the boxes that `for_each` would visit.
  std::size_t candidates(Interval wanted) const;
  /// Calls `visit(proxy)` once for every box that shares a cell with the interval.
  template <class Visit>
  void for_each(Interval wanted, Visit visit) const {
    for (const Level& level : levels_) {
      if (level.count == 0) continue;
      const Cells cells = cells_of(wanted, level.octave);
      if (is_wide(cells)) {
        // More cells than lists: look at all lists; a box's first entry stands for it.
        for (const std::vector<Entry>& list : lists_) {
          for (const Entry& e : list) {
            if (e.octave == level.octave && e.is_first) visit(e.proxy);
          }
        }
        continue;
      }
      for (std::int64_t cell = cells.first; cell <= cells.last; ++cell) {
        for (const Entry& e : lists_[list_of(cell, level.octave)]) {
          // A box that shares several cells counts in the first of them.
          if (e.cell != cell || e.octave != level.octave) continue;
          if (cell == cells.first || e.is_first) visit(e.proxy);
        }
      }
    }
  }

  const Axis& axis() const { return axis_; }
  /// Contains the intervals of all boxes.
  Interval range() const { return range_; }
  std::size_t bytes() const;
  void visit_structure(const BoxSet& boxes, int index, StructureVisitor& visitor) const;

 private:
  struct Entry {
    std::int64_t cell;
    ProxyIndex proxy;
    std::int16_t octave;
    bool is_first;
  };
  struct Cells {
    std::int64_t first, last;
    friend bool operator==(Cells, Cells) = default;
  };
  struct Place {
    Cells cells{0, -1};  ///< none: not listed
    int octave = 0;
  };
  struct Level {
    int octave;
    std::size_t count;
  };

  int octave_of(Interval interval) const;
  Cells cells_of(Interval interval, int octave) const;
  bool is_wide(Cells cells) const {
    return static_cast<std::uint64_t>(cells.last - cells.first) >= lists_.size() / 2 + 4;
  }
  std::size_t list_of(std::int64_t cell, int octave) const;
  void list(ProxyIndex proxy, Place place);
  void unlist(ProxyIndex proxy);
  std::size_t& count_at(int octave);

  Axis axis_;
  IntervalCells kind_;
  Interval range_{kInfinity, -kInfinity};
  double cell_ = 1;        ///< Equal: the size
  int lowest_octave_ = 0;  ///< PerOctave: shorter intervals share this one
  std::vector<std::vector<Entry>> lists_;
  std::vector<Place> places_;  ///< by proxy
  std::vector<Level> levels_;  ///< in the order of first use
  std::size_t entries_ = 0;
};

/// A broad phase on such axes.
class IntervalHashFinder final : public PairFinder {
 public:
  IntervalHashFinder(const BroadPhaseOptions& options, IntervalCells kind);
  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats& stats) override;
  void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) override;
  void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const override;
  void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const override;
  std::size_t bytes() const override;
  void visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const override;

 private:
  template <class Wanted, class Visit>
  void for_each_on_best_axis(Wanted wanted_on, Visit visit) const;

  double wish_;
  std::vector<IntervalHash> axes_;
  std::size_t size_at_rebuild_ = 0;
};

}  // namespace skerry
