// SPDX-License-Identifier: MIT
//
// Sweep and prune on m axes of any direction. On each axis the end points of the boxes' intervals are kept
// sorted from step to step by insertion sort, whose cost is the number of exchanges: few when little moves
// [Baraff 1992; Cohen, Lin, Manocha, Ponamgi 1995; Ericson 2005, sec. 7.5]. An exchange that makes two
// intervals meet proposes the pair; if the intervals meet on the other axes too, it enters a hash table.
// Pairs whose intervals part leave the table when a report next looks at them, so parting costs no lookup.
//
// Boxes that appear, vanish or jump far are not dragged along the axes: they are taken out, merged back in
// one pass, and their pairs found by one sweep. It costs O(n), whatever their number.
#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>

#include "physics/broadphase/axis.h"
#include "physics/broadphase/pair_finder.h"
#include "physics/broadphase/pair_table.h"
#include "physics/broadphase/ray_reach.h"

namespace skerry {

namespace {

/// An end of an interval: the proxy, and in the lowest bit whether it is the upper end.
struct EndPoint {
  double value;
  std::uint32_t key;

  ProxyIndex proxy() const { return key >> 1; }
  bool is_upper() const { return (key & 1) != 0; }
  /// Lower ends come first among equals: intervals are closed.
  friend bool operator<(const EndPoint& a, const EndPoint& b) {
    return a.value != b.value ? a.value < b.value : !a.is_upper() && b.is_upper();
  }
};

struct SortedAxis {
  Axis axis;
  std::vector<EndPoint> ends;
  std::vector<Interval> intervals;       ///< by proxy
  std::vector<std::uint32_t> places[2];  ///< by proxy: index of the lower and the upper end
  double longest = 0;                    ///< no interval is longer
};

class SweepAndPrune final : public PairFinder {
 public:
  explicit SweepAndPrune(const BroadPhaseOptions& options) {
    for (const Axis& axis : make_axes(options.axes)) axes_.emplace_back().axis = axis;
  }

  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats& stats) override {
    listed_.resize(boxes.limit(), kNotListed);
    is_fresh_.resize(boxes.limit(), 0);
    table_.reserve_boxes(boxes.limit());
    for (SortedAxis& a : axes_) a.intervals.resize(boxes.limit());
    sort_changes(boxes, dirty);
    if (!gone_.empty()) take_out_gone();
    if (!moved_.empty()) {
      for (const ProxyIndex proxy : moved_) set_intervals(boxes, proxy);
      for (SortedAxis& a : axes_) {
        if (8 * moved_.size() > boxes.size()) {
          sort_axis(boxes, a, stats);
        } else {
          sort_moved(boxes, a, stats);
        }
      }
    }
    if (!fresh_.empty()) merge_fresh(boxes);
    // Without reports between updates the parted pairs would pile up.
    if (table_.size() > 2 * size_after_filter_ + 8 * boxes.size() + 64) {
      table_.filter_all([&](ProxyIndex a, ProxyIndex b) { return meet(a, b); });
      size_after_filter_ = table_.size();
    }
  }

  void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) override {
    PairBuffer& out = parts.front();
    const BoxSet& boxes = request.boxes;
    const auto check = [&](ProxyIndex a, ProxyIndex b, bool reports) {
      if (!meet(a, b)) return false;
      if (reports) {
        ++stats.box_tests;
        if (overlap(boxes.box(a), boxes.box(b))) {
          out.add(a, b);
        } else {
          ++stats.false_pairs;
        }
      }
      return true;
    };
    if (request.all || 4 * boxes.moved().size() > boxes.size()) {
      table_.filter_all([&](ProxyIndex a, ProxyIndex b) { return check(a, b, request.keeps(a, b)); });
    } else {
      for (const ProxyIndex proxy : boxes.moved()) {
        table_.filter(proxy, [&](ProxyIndex b) { return check(proxy, b, request.reports(proxy, b)); });
      }
    }
    size_after_filter_ = table_.size();
  }

  void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const override {
    for (const EndPoint& end : fewest_candidates([&](const Axis& axis) { return axis.project(region); })) {
      if (!end.is_upper() && overlap(boxes.box(end.proxy()), region)) found.push_back(end.proxy());
    }
  }

  void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const override {
    if (boxes.size() == 0) return;
    const RayTest test(ray);
    RayReach reach(ray);
    for (const SortedAxis& a : axes_) reach.clip(a.axis, {a.ends.front().value, a.ends.back().value});
    if (reach.is_empty()) return;
    // The axis that the ray is most perpendicular to has the shortest interval of it.
    for (const EndPoint& end : fewest_candidates([&](const Axis& axis) { return reach.on(axis); })) {
      if (!end.is_upper() && test.meets(boxes.box(end.proxy()))) found.push_back(end.proxy());
    }
  }

  std::size_t bytes() const override {
    std::size_t sum = table_.bytes() + listed_.capacity() + is_fresh_.capacity();
    for (const SortedAxis& a : axes_) {
      sum += a.ends.capacity() * sizeof(EndPoint) + a.intervals.capacity() * sizeof(Interval) +
             (a.places[0].capacity() + a.places[1].capacity()) * sizeof(std::uint32_t);
    }
    return sum;
  }

  void visit_structure(const BoxSet&, StructureVisitor& visitor) const override {
    for (std::size_t k = 0; k < axes_.size(); ++k) {
      const int index = static_cast<int>(k);
      visitor.axis(index, {0, 0}, axes_[k].axis.direction);
      for (const EndPoint& end : axes_[k].ends) {
        if (end.is_upper()) continue;
        const Interval interval = axes_[k].intervals[end.proxy()];
        visitor.interval(index, end.proxy(), interval.lower, interval.upper);
      }
    }
  }

 private:
  enum : std::uint8_t { kNotListed, kListedMoving, kListedFixed };

  /// The end points among which are the lower ends of all boxes that meet the interval `wanted(axis)`, on the
  /// axis with the fewest: from the longest interval before it to its end.
  template <class Wanted>
  std::span<const EndPoint> fewest_candidates(Wanted wanted_on) const {
    std::span<const EndPoint> fewest = axes_.front().ends;
    for (const SortedAxis& a : axes_) {
      const Interval wanted = wanted_on(a.axis);
      const double reach = wanted.lower - a.longest;
      const double from = reach - 4 * DBL_EPSILON * (std::abs(wanted.lower) + a.longest);
      const auto first =
          std::lower_bound(a.ends.begin(), a.ends.end(), std::isfinite(from) ? from : -kInfinity,
                           [](const EndPoint& end, double value) { return end.value < value; });
      const auto last = std::upper_bound(first, a.ends.end(), wanted.upper,
                                         [](double value, const EndPoint& end) { return value < end.value; });
      const std::span<const EndPoint> candidates(first, last);
      if (candidates.size() < fewest.size()) fewest = candidates;
    }
    return fewest;
  }

  /// True if the intervals meet on all axes.
  bool meet(ProxyIndex a, ProxyIndex b) const {
    return std::all_of(axes_.begin(), axes_.end(),
                       [&](const SortedAxis& s) { return overlap(s.intervals[a], s.intervals[b]); });
  }
  void propose(const BoxSet& boxes, ProxyIndex a, ProxyIndex b) {
    if (meet(a, b) && !(boxes.is_fixed(a) && boxes.is_fixed(b))) table_.add(a, b);
  }
  void set_intervals(const BoxSet& boxes, ProxyIndex proxy) {
    for (SortedAxis& a : axes_) {
      const Interval interval = a.axis.project(boxes.box(proxy));
      a.intervals[proxy] = interval;
      a.longest = std::max(a.longest, interval.upper - interval.lower);
    }
  }

  /// Sorts the changes into boxes to take out, to put in (both for jumps), and to move by exchanges.
  void sort_changes(const BoxSet& boxes, std::span<const ProxyIndex> dirty) {
    gone_.clear();
    fresh_.clear();
    moved_.clear();
    far_.clear();
    // Exchanges that moves would cost if the end points were spread evenly.
    double far_exchanges = 0;
    const double count = static_cast<double>(axes_.front().ends.size());
    for (const ProxyIndex proxy : dirty) {
      const bool present = boxes.is_present(proxy);
      const std::uint8_t kind = !present ? kNotListed : boxes.is_fixed(proxy) ? kListedFixed : kListedMoving;
      if (listed_[proxy] != kind) {
        if (listed_[proxy] != kNotListed) gone_.push_back(proxy);
        if (present) fresh_.push_back(proxy);
        listed_[proxy] = kind;
        continue;
      }
      if (!present) continue;
      double exchanges = 0;
      for (const SortedAxis& a : axes_) {
        const Interval now = a.axis.project(boxes.box(proxy));
        const double range = a.ends.back().value - a.ends.front().value;
        exchanges += count *
                     (std::abs(now.lower - a.intervals[proxy].lower) +
                      std::abs(now.upper - a.intervals[proxy].upper)) /
                     range;
      }
      if (exchanges <= count / 16) {
        moved_.push_back(proxy);
      } else {
        far_exchanges += std::min(exchanges, count);
        far_.push_back(proxy);
      }
    }
    // A merge costs about as much as eight exchanges an end point; once it is due, jumps come with it for
    // free.
    const bool merges = !gone_.empty() || !fresh_.empty() || far_exchanges > 8 * count;
    for (const ProxyIndex proxy : far_) {
      if (merges) {
        gone_.push_back(proxy);
        fresh_.push_back(proxy);
      } else {
        moved_.push_back(proxy);
      }
    }
  }

  void take_out_gone() {
    for (const ProxyIndex proxy : gone_) {
      is_fresh_[proxy] = 1;
      table_.filter(proxy, [](ProxyIndex) { return false; });
    }
    for (SortedAxis& a : axes_) {
      std::erase_if(a.ends, [&](const EndPoint& end) { return is_fresh_[end.proxy()] != 0; });
    }
    for (const ProxyIndex proxy : gone_) is_fresh_[proxy] = 0;
    places_ready_ = false;
  }

  /// Many boxes moved: insertion sort of the whole axis.
  void sort_axis(const BoxSet& boxes, SortedAxis& a, BroadPhaseStats& stats) {
    for (EndPoint& end : a.ends) {
      const Interval interval = a.intervals[end.proxy()];
      end.value = end.is_upper() ? interval.upper : interval.lower;
    }
    for (std::size_t i = 1; i < a.ends.size(); ++i) {
      const EndPoint moving = a.ends[i];
      std::size_t j = i;
      for (; j > 0 && moving < a.ends[j - 1]; --j) {
        a.ends[j] = a.ends[j - 1];
        if (!moving.is_upper() && a.ends[j].is_upper()) propose(boxes, moving.proxy(), a.ends[j].proxy());
      }
      a.ends[j] = moving;
      stats.swaps += i - j;
    }
    places_ready_ = false;
  }

  /// Few boxes moved: each takes its two ends to their new places.
  void sort_moved(const BoxSet& boxes, SortedAxis& a, BroadPhaseStats& stats) {
    if (!places_ready_) {
      for (SortedAxis& axis : axes_) find_places(axis, boxes.limit());
      places_ready_ = true;
    }
    for (const ProxyIndex proxy : moved_) {
      const Interval now = a.intervals[proxy];
      // The end that leads goes first, so that the lower end never has to pass the upper one.
      const bool rises = a.ends[a.places[0][proxy]].value < now.lower;
      for (const int side : rises ? std::array{1, 0} : std::array{0, 1}) {
        const auto s = static_cast<std::size_t>(side);
        a.ends[a.places[s][proxy]].value = side == 1 ? now.upper : now.lower;
        sift(boxes, a, a.places[s][proxy], stats);
      }
    }
  }

  static void find_places(SortedAxis& a, ProxyIndex limit) {
    for (auto& places : a.places) places.resize(limit);
    for (std::uint32_t i = 0; i < a.ends.size(); ++i) {
      a.places[a.ends[i].is_upper() ? 1 : 0][a.ends[i].proxy()] = i;
    }
  }

  /// Moves one end point to its place among sorted ones.
  void sift(const BoxSet& boxes, SortedAxis& a, std::uint32_t at, BroadPhaseStats& stats) {
    const EndPoint moving = a.ends[at];
    const auto pass = [&](std::uint32_t from, bool down) {
      const EndPoint passed = a.ends[from];
      a.ends[at] = passed;
      a.places[passed.is_upper() ? 1 : 0][passed.proxy()] = at;
      at = from;
      ++stats.swaps;
      // Going down a lower end, or going up an upper end, comes to overlap what it passes.
      if (moving.is_upper() != down && passed.is_upper() == down) {
        propose(boxes, moving.proxy(), passed.proxy());
      }
    };
    while (at > 0 && moving < a.ends[at - 1]) pass(at - 1, true);
    while (at + 1 < a.ends.size() && a.ends[at + 1] < moving) pass(at + 1, false);
    a.ends[at] = moving;
    a.places[moving.is_upper() ? 1 : 0][moving.proxy()] = at;
  }

  /// Puts the fresh boxes in and finds their pairs by one sweep along the first axis.
  void merge_fresh(const BoxSet& boxes) {
    for (const ProxyIndex proxy : fresh_) {
      set_intervals(boxes, proxy);
      is_fresh_[proxy] = 1;
    }
    for (SortedAxis& a : axes_) {
      const auto sorted = static_cast<std::ptrdiff_t>(a.ends.size());
      for (const ProxyIndex proxy : fresh_) {
        a.ends.push_back({a.intervals[proxy].lower, proxy << 1});
        a.ends.push_back({a.intervals[proxy].upper, proxy << 1 | 1});
      }
      std::sort(a.ends.begin() + sorted, a.ends.end());
      std::inplace_merge(a.ends.begin(), a.ends.begin() + sorted, a.ends.end());
    }
    places_ready_ = false;

    // Open intervals, those of fresh boxes apart; `open_at` is a box's place in its list.
    std::vector<ProxyIndex> open[2];
    std::vector<std::uint32_t> open_at(boxes.limit());
    for (const EndPoint& end : axes_.front().ends) {
      const ProxyIndex proxy = end.proxy();
      std::vector<ProxyIndex>& own = open[is_fresh_[proxy]];
      if (end.is_upper()) {
        own[open_at[proxy]] = own.back();
        open_at[own.back()] = open_at[proxy];
        own.pop_back();
        continue;
      }
      for (const ProxyIndex other : open[1]) propose(boxes, proxy, other);
      if (is_fresh_[proxy]) {
        for (const ProxyIndex other : open[0]) propose(boxes, proxy, other);
      }
      open_at[proxy] = static_cast<std::uint32_t>(own.size());
      own.push_back(proxy);
    }
    for (const ProxyIndex proxy : fresh_) is_fresh_[proxy] = 0;
  }

  std::vector<SortedAxis> axes_;
  PairTable table_;
  std::vector<std::uint8_t> listed_;    ///< by proxy: not at all, or as which kind
  std::vector<std::uint8_t> is_fresh_;  ///< by proxy: 1 while it is put in or taken out
  std::vector<ProxyIndex> gone_, fresh_, moved_, far_;
  bool places_ready_ = false;
  std::size_t size_after_filter_ = 0;
};

}  // namespace

std::unique_ptr<PairFinder> make_sweep_and_prune(const BroadPhaseOptions& options) {
  return std::make_unique<SweepAndPrune>(options);
}

}  // namespace skerry
