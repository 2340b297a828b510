// SPDX-License-Identifier: MIT
//
// Grids whose cells double from level to level. A box lives on the smallest level where it covers at most
// four cells, that is, whose cell is at least as large as the box, and is listed once: in the cell of its
// lower corner. On its own level it can only meet boxes of the nine cells around; across levels, the side
// that has fewer rows of cells to look at looks for the other.
//
// All levels share one array of boxes in single precision, sorted by level, row and column, so that three
// neighbouring cells of a row are one contiguous range. When many boxes changed it is rebuilt by a counting
// sort in the order of the last build, which is almost sorted already; when few did, they are moved one by
// one, into a free place of their cell or into its overflow list.
//
// A table of cells is as large as the world while that is at most eight cells a box; beyond, rows and columns
// are wrapped around (a hash that keeps neighbours together), so that memory is linear whatever the extent.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "physics/broadphase/float_box.h"
#include "physics/broadphase/pair_finder.h"
#include "physics/broadphase/workers.h"

namespace skerry {

namespace grid {

/// Marks in the upper bits of a listed proxy number.
inline constexpr std::uint32_t kFixedMark = 1u << 31;
inline constexpr std::uint32_t kMovedMark = 1u << 30;
inline constexpr std::uint32_t kNumber = kMovedMark - 1;

/// Cells this far from the origin, and further, coincide.
inline constexpr double kFarCell = 0x1p44;

/// Column or row of a coordinate.
inline std::int64_t cell_coordinate(double x, double origin, double inverse) {
  const double scaled = (x - origin) * inverse;
  if (!(scaled > -kFarCell)) return std::isnan(scaled) ? 0 : -static_cast<std::int64_t>(kFarCell);
  const auto truncated = static_cast<std::int64_t>(std::min(scaled, kFarCell));
  return truncated - (scaled < static_cast<double>(truncated) ? 1 : 0);
}

/// `coordinate` modulo the number of columns or rows.
inline std::int64_t wrap(std::int64_t coordinate, std::int64_t count) {
  if (static_cast<std::uint64_t>(coordinate) < static_cast<std::uint64_t>(count)) return coordinate;
  const std::int64_t rest = coordinate % count;
  return rest < 0 ? rest + count : rest;
}

}  // namespace grid

/// One level of cells.
struct GridLevel {
  double size = 1;           ///< edge of a cell [m]; no box of this level is larger
  double inverse = 1;        ///< 1 / size, or 0 when one cell is the world
  std::int64_t columns = 4;  ///< of the table, at least 3
  std::int64_t rows = 4;     ///< of the table, at least 3
  std::uint32_t base = 0;    ///< number of the first cell
  std::uint32_t count = 0;   ///< boxes at the last build
  std::uint32_t first_slot = 0;
  bool wrapped = false;  ///< boxes may be in columns or rows that are not theirs alone
  double heights = 0;    ///< sum of the boxes' heights [m]
};

/// See the top of this file. [Ericson 2005, Real-Time Collision Detection, sec. 7.2]
class HierarchicalGrid final : public PairFinder {
 public:
  /// @param wide_tests  use wide vector instructions where the processor has them; the results are the same
  /// @param workers  threads to share with others; null: own ones
  explicit HierarchicalGrid(const BroadPhaseOptions& options, bool wide_tests = true,
                            std::shared_ptr<Workers> workers = nullptr);

  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats& stats) override;
  void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) override;
  void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const override;
  void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const override;
  std::size_t bytes() const override;
  void visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const override;
  /// Appends the pairs of each box in `around` with what overlaps it; not with itself, nor fixed with fixed.
  /// A pair of two boxes in `around` comes twice. @param parts  may get more buffers, one a thread
  void find_around(const BoxSet& boxes, std::span<const ProxyIndex> around, std::vector<PairBuffer>& parts,
                   BroadPhaseStats& stats) const;

 private:
  struct Search;
  /// Slots to test, and the cells that they belong to.
  struct Run {
    std::uint32_t begin, end, first_cell, last_cell;
  };
  /// Boxes that are searched for together.
  static constexpr std::size_t kBatch = 16;
  struct Batch {
    std::vector<Run> runs;
    std::array<std::size_t, kBatch + 1> ends{};  ///< of the runs of each box, after a zero
  };

  // Build (hierarchical_grid_build.cpp).
  void rebuild(const BoxSet& boxes);
  void choose_levels(const BoxSet& boxes);
  double best_phase(const BoxSet& boxes) const;
  /// @param extent  of the corners of all boxes; @param own  of those on this level
  void choose_table(GridLevel& level, Vec2 extent, Vec2 own);
  int octave_of(double extent) const;
  const GridLevel* level_of(double extent) const;
  std::uint32_t cell_of(const GridLevel& level, Vec2 corner) const;
  std::uint32_t cell_inside(const GridLevel& level, Vec2 corner) const;
  void prepare_places(const BoxSet& boxes);
  bool place(const BoxSet& boxes, ProxyIndex proxy);
  void take_out(std::uint32_t slot);
  std::uint32_t free_place(std::uint32_t cell);

  template <class Visit>
  void for_each_run(const GridLevel& level, std::int64_t row, std::int64_t left, std::int64_t right,
                    Visit visit) const;
  template <class Visit>
  void for_each_range(const GridLevel& level, const Aabb& region, Visit visit) const;
  template <class Visit>
  void for_each_overflow(std::uint32_t first, std::uint32_t last, Visit visit) const;
  template <class Visit>
  void for_each_overlap(const BoxSet& boxes, const Aabb& region, BroadPhaseStats& stats, Visit visit) const;
  template <class Reports>
  void search_around(const BoxSet& boxes, std::span<const ProxyIndex> around, std::vector<PairBuffer>& parts,
                     BroadPhaseStats& stats, Reports reports) const;
  template <class Reports>
  void search_around(const BoxSet& boxes, std::span<const ProxyIndex> around, PairBuffer& out,
                     BroadPhaseStats& stats, Reports reports) const;
  void find_all(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats);
  void find_part(const BoxSet& boxes, bool all, std::size_t part, std::size_t parts, PairBuffer& out,
                 BroadPhaseStats& stats) const;
  void search_level(const GridLevel& level, std::uint32_t begin, std::uint32_t end, Search& search) const;
  void search_wrapped_level(const GridLevel& level, std::uint32_t begin, std::uint32_t end,
                            Search& search) const;
  void search_across(const GridLevel& to, std::uint32_t begin, std::uint32_t end, Search& search) const;

  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint8_t kNoLevel = 255;
  /// Boxes are tested in blocks; the last block may read so many unused places.
  static constexpr std::uint32_t kPadding = 4;

  double wish_;  ///< the finest cell that the user asked for, or 0
  bool wide_tests_;
  std::shared_ptr<Workers> workers_;
  Vec2 origin_;     ///< lower corner of the world at the last build
  Aabb bounds_{};   ///< contains all boxes
  double top_ = 1;  ///< size of the coarsest octave's boxes; octave k holds those down to top_ / 2^(k+1)
  int last_octave_ = 0;
  std::vector<GridLevel> levels_;              ///< those with boxes, from fine to coarse
  std::vector<std::uint8_t> level_of_octave_;  ///< index into `levels_`
  std::vector<std::uint8_t> octave_of_box_;    ///< by proxy, in the last build, if it had several levels
  std::vector<std::uint32_t> start_;           ///< first slot by cell, then the end
  // By slot: packed first, with unused places at the end, then the overflow.
  std::vector<FloatBox> box_;
  std::vector<std::uint32_t> id_;  ///< proxy with marks, or kNone
  std::vector<std::uint32_t> cell_;
  std::uint32_t packed_ = 0;
  // For changes of few boxes.
  bool places_ready_ = false;
  std::vector<std::uint32_t> slot_of_;       ///< by proxy
  std::vector<std::uint32_t> head_;          ///< first overflow slot by cell
  std::vector<std::uint64_t> has_overflow_;  ///< a bit a cell: small enough for the first-level cache
  std::vector<std::uint32_t> next_;          ///< by slot - packed_: next in its cell, or next free
  std::uint32_t free_overflow_ = kNone;
  std::size_t unused_ = 0;  ///< free slots among the packed ones
  std::uint64_t built_version_ = 0, built_membership_ = 0;
  // Kept between calls.
  std::vector<FloatBox> new_box_;
  std::vector<std::uint32_t> new_id_, new_cell_;
};

}  // namespace skerry
