// SPDX-License-Identifier: MIT
#include "physics/broadphase/interval_hash.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "physics/broadphase/ray_reach.h"

namespace skerry {

namespace {

/// Far cells coincide, which costs time only.
constexpr double kFarCell = 0x1p60;
/// So does all that is farther away [m]: a length from end to end is still a number.
constexpr double kFarthest = 0x1p1022;

/// Octaves below the mean length that are told apart.
constexpr int kOctavesBelowMean = 12;

double within_reach(double x) {
  return std::clamp(x, -kFarthest, kFarthest);
}

}  // namespace

std::size_t& IntervalHash::count_at(int octave) {
  for (Level& level : levels_) {
    if (level.octave == octave) return level.count;
  }
  return levels_.emplace_back(Level{octave, 0}).count;
}

int IntervalHash::octave_of(Interval interval) const {
  if (kind_ == IntervalCells::Equal) return 0;
  // The power of two at or above the length; the largest is about half of the numbers' range.
  int exponent = 0;
  const double length = within_reach(interval.upper) - within_reach(interval.lower);
  if (!(length < 0x1p1023)) return 1023;
  if (length <= 0) return lowest_octave_;
  const double fraction = std::frexp(length, &exponent);
  return std::clamp(fraction == 0.5 ? exponent - 1 : exponent, lowest_octave_, 1023);
}

IntervalHash::Cells IntervalHash::cells_of(Interval interval, int octave) const {
  const auto index = [&](double end) {
    const double x = within_reach(end);
    const double scaled = kind_ == IntervalCells::Equal ? x / cell_ : std::ldexp(x, -octave);
    return static_cast<std::int64_t>(std::floor(std::clamp(scaled, -kFarCell, kFarCell)));
  };
  return {index(interval.lower), index(interval.upper)};
}

std::size_t IntervalHash::list_of(std::int64_t cell, int octave) const {
  std::uint64_t mixed = static_cast<std::uint64_t>(cell) * 0x9E3779B97F4A7C15 +
                        static_cast<std::uint64_t>(octave + 4096) * 0xC2B2AE3D27D4EB4F;
  mixed = (mixed ^ (mixed >> 32)) * 0xBF58476D1CE4E5B9;
  return static_cast<std::size_t>(mixed >> 32) & (lists_.size() - 1);
}

void IntervalHash::list(ProxyIndex proxy, Place place) {
  for (std::int64_t cell = place.cells.first; cell <= place.cells.last; ++cell) {
    const bool is_first = cell == place.cells.first;
    lists_[list_of(cell, place.octave)].push_back(
        {cell, proxy, static_cast<std::int16_t>(place.octave), is_first});
    ++entries_;
  }
  ++count_at(place.octave);
  places_[proxy] = place;
}

void IntervalHash::unlist(ProxyIndex proxy) {
  const Place place = places_[proxy];
  if (place.cells.first > place.cells.last) return;
  for (std::int64_t cell = place.cells.first; cell <= place.cells.last; ++cell) {
    std::vector<Entry>& list = lists_[list_of(cell, place.octave)];
    const auto at = std::find_if(list.begin(), list.end(), [&](const Entry& e) {
      return e.proxy == proxy && e.cell == cell && e.octave == place.octave;
    });
    *at = list.back();
    list.pop_back();
    --entries_;
  }
  --count_at(place.octave);
  places_[proxy] = {};
}

void IntervalHash::rebuild(const BoxSet& boxes, double wish) {
  double sum = 0, count = 0, lower = kInfinity, upper = -kInfinity;
  for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
    if (!boxes.is_present(p)) continue;
    const Interval i = axis_.project(boxes.box(p));
    sum += std::min(1e300, i.upper - i.lower) / 1e6;
    lower = std::min(lower, i.lower);
    upper = std::max(upper, i.lower);
    ++count;
  }
  double mean = 1e6 * (sum / std::max(count, 1.0));
  // Only points: about one a cell if they are spread evenly.
  if (!(mean > 1e-290)) mean = std::min(1e300, upper - lower) / std::max(count, 1.0);
  if (!(mean > 1e-290)) mean = 1;
  mean = std::min(mean, 1e300);
  lowest_octave_ = std::ilogb(wish > 0 ? wish : mean) - (wish > 0 ? 0 : kOctavesBelowMean);
  cell_ = wish > 0 ? wish : mean;
  if (kind_ == IntervalCells::Equal) {
    for (;; cell_ *= 2) {
      double entries = 0;
      for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
        if (!boxes.is_present(p)) continue;
        const Cells cells = cells_of(axis_.project(boxes.box(p)), 0);
        entries += static_cast<double>(cells.last) - static_cast<double>(cells.first) + 1;
      }
      if (entries <= 8 * count + 32) break;
    }
  }

  lists_.assign(std::max<std::size_t>(16, std::bit_ceil(boxes.size()) / 2), {});
  places_.assign(boxes.limit(), {});
  levels_.clear();
  entries_ = 0;
  range_ = {kInfinity, -kInfinity};
  for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
    if (boxes.is_present(p)) follow(boxes, p);
  }
}

bool IntervalHash::follow(const BoxSet& boxes, ProxyIndex proxy) {
  if (places_.size() < boxes.limit()) places_.resize(boxes.limit());
  if (!boxes.is_present(proxy)) {
    unlist(proxy);
    return true;
  }
  const Interval interval = axis_.project(boxes.box(proxy));
  range_ = {std::min(range_.lower, interval.lower), std::max(range_.upper, interval.upper)};
  const int octave = octave_of(interval);
  const Cells cells = cells_of(interval, octave);
  if (places_[proxy].cells == cells && places_[proxy].octave == octave) return true;
  unlist(proxy);
  const double length = static_cast<double>(cells.last) - static_cast<double>(cells.first) + 1;
  if (static_cast<double>(entries_) + length > 16 * static_cast<double>(boxes.size()) + 64) return false;
  list(proxy, {cells, octave});
  return true;
}

std::size_t IntervalHash::candidates(Interval wanted) const {
  std::size_t sum = 0;
  for (const Level& level : levels_) {
    if (level.count == 0) continue;
    const Cells cells = cells_of(wanted, level.octave);
    if (is_wide(cells)) {
      sum += entries_;
      continue;
    }
    for (std::int64_t c = cells.first; c <= cells.last; ++c) sum += lists_[list_of(c, level.octave)].size();
  }
  return sum;
}

std::size_t IntervalHash::bytes() const {
  std::size_t sum = lists_.capacity() * sizeof(lists_[0]) + places_.capacity() * sizeof(Place);
  for (const std::vector<Entry>& list : lists_) sum += list.capacity() * sizeof(Entry);
  return sum;
}

void IntervalHash::visit_structure(const BoxSet& boxes, int index, StructureVisitor& visitor) const {
  visitor.axis(index, {0, 0}, axis_.direction);
  for (ProxyIndex p = 0; p < places_.size(); ++p) {
    if (places_[p].cells.first > places_[p].cells.last) continue;
    const Interval interval = axis_.project(boxes.box(p));
    visitor.interval(index, p, interval.lower, interval.upper);
  }
}

IntervalHashFinder::IntervalHashFinder(const BroadPhaseOptions& options, IntervalCells kind)
    : wish_(options.cell_size) {
  for (const Axis& axis : make_axes(options.axes)) axes_.emplace_back(axis, kind);
}

void IntervalHashFinder::synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty,
                                     BroadPhaseStats&) {
  const bool resized = boxes.size() > 2 * size_at_rebuild_ || 4 * boxes.size() < size_at_rebuild_;
  if (resized) size_at_rebuild_ = boxes.size();
  for (IntervalHash& axis : axes_) {
    const auto follow = [&](ProxyIndex proxy) { return axis.follow(boxes, proxy); };
    if (resized || !std::all_of(dirty.begin(), dirty.end(), follow)) axis.rebuild(boxes, wish_);
  }
}

/// Calls `visit(proxy)` for the boxes that share a cell with the interval `wanted_on(axis)`, on the axis with
/// the fewest of them.
template <class Wanted, class Visit>
void IntervalHashFinder::for_each_on_best_axis(Wanted wanted_on, Visit visit) const {
  const IntervalHash* best = &axes_.front();
  Interval wanted = wanted_on(best->axis());
  std::size_t fewest = best->candidates(wanted);
  for (std::size_t k = 1; k < axes_.size(); ++k) {
    const Interval here = wanted_on(axes_[k].axis());
    const std::size_t candidates = axes_[k].candidates(here);
    if (candidates < fewest) {
      fewest = candidates;
      best = &axes_[k];
      wanted = here;
    }
  }
  best->for_each(wanted, visit);
}

void IntervalHashFinder::find(const PairRequest& request, std::vector<PairBuffer>& parts,
                              BroadPhaseStats& stats) {
  const BoxSet& boxes = request.boxes;
  if (boxes.size() == 0) return;
  PairBuffer& out = parts.front();
  request.for_each_wanted([&](ProxyIndex proxy) {
    const Aabb& box = boxes.box(proxy);
    const auto wanted = [&](const Axis& axis) { return axis.project(box); };
    for_each_on_best_axis(wanted, [&](ProxyIndex other) {
      if (!request.reports(proxy, other)) return;
      ++stats.box_tests;
      if (overlap(box, boxes.box(other))) {
        out.add(proxy, other);
      } else {
        ++stats.false_pairs;
      }
    });
  });
}

void IntervalHashFinder::query(const BoxSet& boxes, const Aabb& region,
                               std::vector<ProxyIndex>& found) const {
  if (boxes.size() == 0) return;
  const auto wanted = [&](const Axis& axis) { return axis.project(region); };
  for_each_on_best_axis(wanted, [&](ProxyIndex proxy) {
    if (overlap(region, boxes.box(proxy))) found.push_back(proxy);
  });
}

void IntervalHashFinder::ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const {
  if (boxes.size() == 0) return;
  const RayTest test(ray);
  RayReach reach(ray);
  for (const IntervalHash& a : axes_) reach.clip(a.axis(), a.range());
  if (reach.is_empty()) return;
  const auto wanted = [&](const Axis& axis) { return reach.on(axis); };
  for_each_on_best_axis(wanted, [&](ProxyIndex proxy) {
    if (test.meets(boxes.box(proxy))) found.push_back(proxy);
  });
}

std::size_t IntervalHashFinder::bytes() const {
  std::size_t sum = 0;
  for (const IntervalHash& axis : axes_) sum += axis.bytes();
  return sum;
}

void IntervalHashFinder::visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const {
  for (std::size_t k = 0; k < axes_.size(); ++k)
    axes_[k].visit_structure(boxes, static_cast<int>(k), visitor);
}

}  // namespace skerry
