// SPDX-License-Identifier: MIT
//
// Hierarchical grid: choice of the levels, the build by counting sort, and the move of single boxes.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "physics/broadphase/hierarchical_grid.h"

namespace skerry {

namespace {

/// A box may be 1/64 smaller than its cell at most: rounding of cell coordinates up to 2^44 stays below that.
constexpr double kRoom = 65.0 / 64;
/// Larger worlds are one cell.
constexpr double kLargestCell = 1e300;
/// Octaves of sizes below the largest box; smaller boxes share the last one. More where one box is far larger
/// than most (a half-plane): octaves without boxes cost nothing.
constexpr int kOctaves = 24;
constexpr int kMostOctaves = 60;
/// So many boxes ahead the processor is told what will be needed.
constexpr std::size_t kAhead = 12;
/// A table covers its world up to so many cells a box.
constexpr double kCellsPerBox = 8;

double extent_of(const Aabb& box) {
  return std::max(box.upper.x - box.lower.x, box.upper.y - box.lower.y);
}

/// Median of a sample of the boxes' extents, at least the smallest normal number.
double middle_extent(const BoxSet& boxes) {
  std::vector<double> sample;
  const ProxyIndex stride = boxes.limit() / 256 + 1;
  for (ProxyIndex p = 0; p < boxes.limit(); p += stride) {
    if (boxes.is_present(p)) sample.push_back(extent_of(boxes.box(p)));
  }
  if (sample.empty()) return 1;
  const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
  std::nth_element(sample.begin(), middle, sample.end());
  return std::max(*middle, std::numeric_limits<double>::min());
}

/// A number not divisible by small primes, so that regular patterns do not fall on the same columns.
std::int64_t without_small_factors(std::int64_t n) {
  while (std::gcd(n, std::int64_t{2 * 3 * 5 * 7 * 11 * 13}) != 1) ++n;
  return n;
}

}  // namespace

using namespace grid;

HierarchicalGrid::HierarchicalGrid(const BroadPhaseOptions& options, bool wide_tests,
                                   std::shared_ptr<Workers> workers)
    : wish_(options.cell_size),
      wide_tests_(wide_tests),
      workers_(workers ? std::move(workers) : std::make_shared<Workers>(options.threads, options.pool)) {}

/// Number of octaves that `extent` is below the largest box.
int HierarchicalGrid::octave_of(double extent) const {
  if (extent > 0.5 * top_) return 0;
  const double ratio = top_ / extent;
  if (!(ratio < 0x1p62)) return last_octave_;
  return std::min(last_octave_, static_cast<int>(std::bit_cast<std::uint64_t>(ratio) >> 52) - 1023);
}

/// The finest level in use whose cells are large enough, or null.
const GridLevel* HierarchicalGrid::level_of(double extent) const {
  if (levels_.empty() || extent > top_) return nullptr;
  const std::uint8_t level = level_of_octave_[static_cast<std::size_t>(octave_of(extent))];
  return level == kNoLevel ? nullptr : &levels_[level];
}

std::uint32_t HierarchicalGrid::cell_of(const GridLevel& level, Vec2 corner) const {
  // One column and one row are left free on the lower sides, so that neighbours of a table without wrap
  // exist.
  const std::int64_t column = wrap(cell_coordinate(corner.x, origin_.x, level.inverse) + 1, level.columns);
  const std::int64_t row = wrap(cell_coordinate(corner.y, origin_.y, level.inverse) + 1, level.rows);
  return level.base + static_cast<std::uint32_t>(row * level.columns + column);
}

/// The same for a corner that is known to lie in a table without wrap.
std::uint32_t HierarchicalGrid::cell_inside(const GridLevel& level, Vec2 corner) const {
  const auto column = static_cast<std::int32_t>((corner.x - origin_.x) * level.inverse) + 1;
  const auto row = static_cast<std::int32_t>((corner.y - origin_.y) * level.inverse) + 1;
  return level.base + static_cast<std::uint32_t>(row * static_cast<std::int32_t>(level.columns) + column);
}

void HierarchicalGrid::choose_table(GridLevel& level, Vec2 extent, Vec2 own) {
  level.inverse = level.size < kLargestCell ? 1 / level.size : 0;
  // Two more than the cells in use: the margin that makes the neighbours of border cells empty.
  const double columns = std::floor(extent.x * level.inverse) + 3;
  const double rows = std::floor(extent.y * level.inverse) + 3;
  const double budget = kCellsPerBox * level.count + 256;
  level.wrapped = !(columns * rows <= budget);
  if (!level.wrapped) {
    level.columns = static_cast<std::int64_t>(columns);
    level.rows = static_cast<std::int64_t>(rows);
    return;
  }
  // Wrap the longer side first: a long row of boxes stays a row, however large the world of other levels is.
  const double own_columns = std::floor(own.x * level.inverse) + 3;
  const double own_rows = std::floor(own.y * level.inverse) + 3;
  const double target = 0.5 * budget;
  const double side = std::sqrt(target);
  const double kept_rows = own_rows < side ? own_rows : own_columns < side ? target / own_columns : side;
  level.rows = without_small_factors(std::max<std::int64_t>(3, static_cast<std::int64_t>(kept_rows)));
  level.columns = without_small_factors(
      std::max<std::int64_t>(3, static_cast<std::int64_t>(target / static_cast<double>(level.rows))));
}

/// Factor from 1 to 2 by which the coarsest cells should be larger than the largest box, so that the octaves
/// fall well on the sizes: the fewest rows of cells to look at between levels. A quarter octave is told
/// apart.
double HierarchicalGrid::best_phase(const BoxSet& boxes) const {
  constexpr double kQuarters[] = {1, 1.189207115002721, 1.4142135623730951, 1.681792830507429};
  std::uint32_t counts[4 * (kMostOctaves + 1)] = {};
  // A sample is enough, and costs little.
  const ProxyIndex stride = boxes.limit() / 512 + 1;
  for (ProxyIndex p = 0; p < boxes.limit(); p += stride) {
    if (!boxes.is_present(p)) continue;
    const int octave = octave_of(extent_of(boxes.box(p)));
    const double rest = std::ldexp(top_, -octave) / extent_of(boxes.box(p));
    const int quarter = (rest >= kQuarters[1]) + (rest >= kQuarters[2]) + (rest >= kQuarters[3]);
    ++counts[4 * octave + quarter];
  }
  double best = 1, least = kInfinity;
  for (int phase = 0; phase < 4; ++phase) {
    // The count of each octave if the top goes up by `phase` quarters.
    double levels[kMostOctaves + 2] = {};
    for (int k = 0; k < 4 * (kMostOctaves + 1); ++k) levels[(k + phase) / 4] += counts[k];
    double rows = 0;
    for (int fine = 0; fine <= kMostOctaves; ++fine) {
      if (levels[fine] == 0) continue;
      rows += 2 * levels[fine];
      for (int coarse = 0; coarse < fine; ++coarse) {
        if (levels[coarse] == 0) continue;
        rows += std::min(3 * levels[fine], levels[coarse] * (2 + std::ldexp(1.0, fine - coarse)));
      }
    }
    if (rows < least) {
      least = rows;
      best = kQuarters[phase];
    }
  }
  return best;
}

/// Measures the boxes and lays out the levels and their tables.
void HierarchicalGrid::choose_levels(const BoxSet& boxes) {
  Vec2 lower{kInfinity, kInfinity}, upper{-kInfinity, -kInfinity};
  double largest = 0, smallest = kInfinity, heights = 0;
  bounds_ = {{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
  for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
    if (!boxes.is_present(p)) continue;
    const Aabb& box = boxes.box(p);
    lower = {std::min(lower.x, box.lower.x), std::min(lower.y, box.lower.y)};
    upper = {std::max(upper.x, box.lower.x), std::max(upper.y, box.lower.y)};
    bounds_.upper = {std::max(bounds_.upper.x, box.upper.x), std::max(bounds_.upper.y, box.upper.y)};
    const double extent = extent_of(box);
    largest = std::max(largest, extent);
    smallest = std::min(smallest, extent);
    heights += box.upper.y - box.lower.y;
  }
  // A box that moves changes its extent by rounding; that must not ask for another level.
  largest *= 1 + 1.0 / 1024;
  origin_ = bounds_.lower = lower;
  const Vec2 world = upper - lower;
  // Half of the boxes get cells of their size.
  const double octaves_to_middle = std::ceil(std::log2(std::max(1.0, largest / middle_extent(boxes))));
  last_octave_ = static_cast<int>(std::clamp(octaves_to_middle + 4, kOctaves - 1.0, double{kMostOctaves}));
  top_ = largest;
  if (wish_ > 0) {
    // The finest cell is given; the top is a power of two above it.
    const double octaves = std::ceil(std::log2(std::max(1.0, largest * kRoom / wish_)));
    last_octave_ = static_cast<int>(std::min(octaves, double{kMostOctaves}));
    top_ = std::max(largest, std::ldexp(wish_, last_octave_) / kRoom);
  }
  if (!(top_ > 1e-290)) {
    // Only points: about one a cell if they are spread evenly.
    const double spread = std::max(world.x, world.y) / std::sqrt(static_cast<double>(boxes.size()));
    top_ = spread > 1e-290 ? std::min(spread, kLargestCell) : 1;
    last_octave_ = 0;
  }

  std::uint32_t counts[kMostOctaves + 1] = {};
  double sums[kMostOctaves + 1] = {};
  Vec2 lowest[kMostOctaves + 1], highest[kMostOctaves + 1];  // corners of each octave's boxes
  if (octave_of(smallest) == 0) {
    counts[0] = static_cast<std::uint32_t>(boxes.size());
    sums[0] = heights;
    lowest[0] = lower;
    highest[0] = upper;
  } else {
    if (!(wish_ > 0)) top_ *= best_phase(boxes);
    octave_of_box_.resize(boxes.limit());
    for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
      if (!boxes.is_present(p)) continue;
      const Aabb& box = boxes.box(p);
      const int octave = octave_of(extent_of(box));
      octave_of_box_[p] = static_cast<std::uint8_t>(octave);
      Vec2& low = lowest[octave];
      Vec2& high = highest[octave];
      if (counts[octave]++ == 0) low = high = box.lower;
      low = {std::min(low.x, box.lower.x), std::min(low.y, box.lower.y)};
      high = {std::max(high.x, box.lower.x), std::max(high.y, box.lower.y)};
      sums[octave] += box.upper.y - box.lower.y;
    }
  }

  levels_.clear();
  level_of_octave_.assign(static_cast<std::size_t>(last_octave_) + 1, 0);
  std::uint32_t cells = 0, slots = 0;
  for (int octave = last_octave_; octave >= 0; --octave) {
    if (counts[octave] > 0) {
      GridLevel level;
      level.size = std::ldexp(top_, -octave) * kRoom;
      level.count = counts[octave];
      level.heights = sums[octave];
      choose_table(level, world, highest[octave] - lowest[octave]);
      level.base = cells;
      level.first_slot = slots;
      cells += static_cast<std::uint32_t>(level.columns * level.rows);
      slots += level.count;
      levels_.push_back(level);
    }
  }
  // An octave without boxes uses the next coarser level.
  std::uint8_t level = kNoLevel;
  auto next_level = static_cast<std::uint8_t>(levels_.size());
  for (int octave = 0; octave <= last_octave_; ++octave) {
    if (counts[octave] > 0) level = --next_level;
    level_of_octave_[static_cast<std::size_t>(octave)] = level;
  }
  start_.assign(std::size_t{cells} + 2, 0);
}

void HierarchicalGrid::rebuild(const BoxSet& boxes) {
  const std::size_t count = boxes.size();
  places_ready_ = false;
  unused_ = 0;
  built_version_ = boxes.version();
  if (count == 0) {
    levels_.clear();
    packed_ = 0;
    id_.clear();
    box_.clear();
    cell_.clear();
    next_.clear();
    start_.assign(2, 0);
    return;
  }
  choose_levels(boxes);

  // Boxes in the order of the last build, which neighbours in memory as in space; the cells' counts.
  new_box_.resize(count);
  new_id_.resize(count);
  new_cell_.resize(count);
  std::size_t k = 0;
  const auto take = [&](ProxyIndex p) {
    const Aabb& box = boxes.box(p);
    const GridLevel& level =
        levels_.size() == 1 ? levels_.front() : levels_[level_of_octave_[octave_of_box_[p]]];
    const std::uint32_t cell = level.wrapped ? cell_of(level, box.lower) : cell_inside(level, box.lower);
    store(new_box_[k], box, origin_);
    new_id_[k] = p | (boxes.is_fixed(p) ? kFixedMark : 0) | (boxes.is_moved(p) ? kMovedMark : 0);
    new_cell_[k] = cell;
    ++start_[cell + 2];
    ++k;
  };
  if (built_membership_ == boxes.membership()) {
    for (std::size_t i = 0; i < id_.size(); ++i) {
      if (i + kAhead < id_.size() && id_[i + kAhead] != kNone)
        prefetch(&boxes.box(id_[i + kAhead] & kNumber));
      if (id_[i] != kNone) take(id_[i] & kNumber);
    }
  } else {
    for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
      if (boxes.is_present(p)) take(p);
    }
  }
  built_membership_ = boxes.membership();

  // start_[cell + 1] counts up from the cell's first slot to the next cell's.
  std::uint32_t sum = 0;
  for (std::size_t c = 2; c < start_.size(); ++c) sum = start_[c] += sum;
  packed_ = static_cast<std::uint32_t>(count) + kPadding;
  box_.assign(packed_, kNoFloatBox);
  id_.assign(packed_, kNone);
  cell_.resize(packed_);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t slot = start_[new_cell_[i] + 1]++;
    box_[slot] = new_box_[i];
    id_[slot] = new_id_[i];
    cell_[slot] = new_cell_[i];
  }
}

/// Makes ready for moves of single boxes: the slot of each box, and empty overflow lists.
void HierarchicalGrid::prepare_places(const BoxSet& boxes) {
  slot_of_.assign(boxes.limit(), kNone);
  for (std::uint32_t slot = 0; slot < packed_; ++slot) {
    if (id_[slot] == kNone) continue;
    id_[slot] &= kNumber;
    slot_of_[id_[slot]] = slot;
  }
  head_.assign(start_.size(), kNone);
  has_overflow_.assign(start_.size() / 64 + 1, 0);
  next_.clear();
  free_overflow_ = kNone;
  places_ready_ = true;
}

void HierarchicalGrid::take_out(std::uint32_t slot) {
  slot_of_[id_[slot]] = kNone;
  id_[slot] = kNone;
  box_[slot] = kNoFloatBox;
  if (slot < packed_) {
    ++unused_;
    return;
  }
  // Out of its list: a search looks at all of that.
  const std::uint32_t cell = cell_[slot];
  std::uint32_t* link = &head_[cell];
  while (*link != slot) link = &next_[*link - packed_];
  *link = next_[slot - packed_];
  if (head_[cell] == kNone) has_overflow_[cell / 64] &= ~(std::uint64_t{1} << cell % 64);
  next_[slot - packed_] = free_overflow_;
  free_overflow_ = slot;
}

/// A free slot that belongs to `cell`; the overflow grows if there is none.
std::uint32_t HierarchicalGrid::free_place(std::uint32_t cell) {
  for (std::uint32_t slot = start_[cell]; slot < start_[cell + 1]; ++slot) {
    if (id_[slot] == kNone) return --unused_, slot;
  }
  if (free_overflow_ == kNone) {
    free_overflow_ = static_cast<std::uint32_t>(id_.size());
    id_.push_back(kNone);
    box_.push_back(kNoFloatBox);
    cell_.push_back(cell);
    next_.push_back(kNone);
  }
  const std::uint32_t slot = free_overflow_;
  free_overflow_ = next_[slot - packed_];
  cell_[slot] = cell;
  next_[slot - packed_] = head_[cell];
  head_[cell] = slot;
  has_overflow_[cell / 64] |= std::uint64_t{1} << cell % 64;
  return slot;
}

/// Brings one box up to date; false if there is no level for it.
bool HierarchicalGrid::place(const BoxSet& boxes, ProxyIndex proxy) {
  const std::uint32_t old = slot_of_[proxy];
  if (!boxes.is_present(proxy)) {
    if (old != kNone) take_out(old);
    return true;
  }
  const Aabb& box = boxes.box(proxy);
  const GridLevel* level = level_of(extent_of(box));
  if (level == nullptr) return false;
  bounds_ = united(bounds_, box);
  const std::uint32_t cell = cell_of(*level, box.lower);
  if (old != kNone && cell_[old] == cell) {
    store(box_[old], box, origin_);
    return true;
  }
  if (old != kNone) take_out(old);
  const std::uint32_t slot = free_place(cell);
  id_[slot] = proxy;
  slot_of_[proxy] = slot;
  store(box_[slot], box, origin_);
  return true;
}

void HierarchicalGrid::synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats&) {
  if (levels_.empty() || 4 * dirty.size() > boxes.size()) return rebuild(boxes);
  if (!places_ready_) prepare_places(boxes);
  slot_of_.resize(std::max<std::size_t>(slot_of_.size(), boxes.limit()), kNone);
  // A rebuild costs as much as some ten moves a box, so it waits until a quarter of the boxes is out of
  // order.
  const std::size_t limit = boxes.size() / 4 + 64;
  for (std::size_t i = 0; i < dirty.size(); ++i) {
    // What the next boxes need is fetched meanwhile: they are scattered in memory.
    if (i + 2 * kAhead < dirty.size()) {
      prefetch(&slot_of_[dirty[i + 2 * kAhead]]);
      prefetch(&boxes.box(dirty[i + 2 * kAhead]));
    }
    if (i + kAhead < dirty.size() && slot_of_[dirty[i + kAhead]] != kNone) {
      prefetch(&cell_[slot_of_[dirty[i + kAhead]]]);
      prefetch(&box_[slot_of_[dirty[i + kAhead]]]);
    }
    if (!place(boxes, dirty[i]) || next_.size() > limit || unused_ > 2 * limit) return rebuild(boxes);
  }
  built_membership_ = boxes.membership();
}

std::unique_ptr<PairFinder> make_hierarchical_grid(const BroadPhaseOptions& options) {
  return std::make_unique<HierarchicalGrid>(options);
}

}  // namespace skerry
