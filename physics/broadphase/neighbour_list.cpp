// SPDX-License-Identifier: MIT
//
// Neighbour list: every box gets a margin, and the pairs of these fat boxes are kept, sorted, from step to
// step. As long as the boxes stay within their margins, the kept pairs contain all that overlap, and a step
// is one pass over them: nothing is searched and nothing is sorted, for what a sorted list lets through is
// sorted [Verlet 1967, Computer "experiments" on classical fluids I, sec. on the table of neighbours]. A
// hierarchical grid over the fat boxes makes the list; a box that leaves its margin gets a new one and its
// new pairs join the list; where many leave, the list is made anew.
//
// What falls or flies together does not meet by that: margins go along with the common motion of the boxes,
// which is predicted from the last step. They live in a frame of their own, and reach ahead of what moves in
// it, as what does not move in the world does there. Going over to the frame, a difference of doubles, keeps
// the order of numbers, so boxes that overlap overlap in the frame.
//
// While few boxes move, the list has the pairs of these only, and their margins reach ahead in the direction
// of their flight, so that a few of them leave in each step.
#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <utility>

#include "physics/broadphase/candidate_tests.h"
#include "physics/broadphase/float_box.h"
#include "physics/broadphase/hierarchical_grid.h"
#include "physics/broadphase/pair_finder.h"

namespace skerry {

namespace {

/// Margin on each side, relative to the size of the box, and steps that it reaches ahead of a box that moves
/// (relative to the frame). Wide margins let the list live longer and make it longer.
constexpr double kMargin = 0.28, kAheadInMass = 2;
/// Margin of thin boxes, relative to their longer side.
constexpr double kThinMargin = 0.03;
/// The same where few boxes move. A box that moves by a tenth of its size a step leaves its margin after
/// thirteen steps; reaching farther ahead costs more in tests of partners than it saves in searches.
constexpr double kSmallMargin = 0.1;
/// Steps that such a margin reaches ahead of a moving box.
constexpr double kStepsAhead = 20;
/// Where a box leaves its margin, those that will leave theirs within so many steps get new ones, too: the
/// list is mended for many at once, and not in every step.
constexpr float kStepsSoon = 6;
/// Larger margins would only overflow.
constexpr double kLargestMargin = 1e300;
/// So many lists one after the other that live for one step only are worth nothing: no margins for so many
/// steps then.
constexpr int kShortLists = 3, kStepsWithoutMargin = 15;
/// The list is made anew when one box of so many has left its margin since.
constexpr std::size_t kShareThatLeft = 16;
/// Below so many candidates a second thread costs more than it tests.
constexpr std::size_t kCandidatesPerThread = 50000;
/// The same of boxes that moved.
constexpr std::size_t kFollowedPerThread = 2000;
/// The margins go along with the boxes where such a share of them shifted alike, and no farther than this
/// [m]: a finite number less the frame is finite.
constexpr double kCommon = 0.8, kFarthestFrame = 1e9;
/// And where the squares of the differences from the common shift, and of its change, are no larger shares of
/// its own.
constexpr double kAlike = 0.1, kSteady = 0.25;
/// So many boxes say what that is.
constexpr std::size_t kSample = 64;
/// Steps for which fixed boxes have margins in a frame that moves.
constexpr double kFixedAhead = 8;
/// Where some boxes move once more in a step in which most did, the list serves for them, too, if it has
/// fewer candidates for each of them.
constexpr std::size_t kWorthList = 100;
/// So many boxes in single precision stay in the second-level cache, wherever they are (512 KiB).
constexpr std::size_t kBoxesInCache = 1u << 15;
/// So many changes ahead the processor is told which box will be needed.
constexpr std::size_t kAhead = 24;

constexpr bool encloses(const Aabb& outer, const Aabb& inner) {
  // One branch instead of four.
  return (static_cast<int>(outer.lower.x <= inner.lower.x) &
          static_cast<int>(outer.lower.y <= inner.lower.y) &
          static_cast<int>(inner.upper.x <= outer.upper.x) &
          static_cast<int>(inner.upper.y <= outer.upper.y)) != 0;
}

class NeighbourList final : public PairFinder {
 public:
  NeighbourList(const BroadPhaseOptions& options, bool wide_tests)
      : workers_(std::make_shared<Workers>(options.threads, options.pool)),
        grid_(std::make_unique<HierarchicalGrid>(options, wide_tests, workers_)),
        wide_tests_(wide_tests) {}

  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats&) override {
    tight_.resize(boxes.limit(), kNoFloatBox);
    margin_.resize(boxes.limit(), kNoFloatBox);
    in_motion_.resize(boxes.limit(), kAtRest);
    was_moving_.resize(boxes.limit(), 0);
    left_.clear();
    leaving_.clear();
    const bool in_mass = moves_in_mass(boxes, dirty.size());
    const bool drifts = in_mass && drift_ != Vec2{};
    if (drifts) {
      frame_ += drift_;
      forget_few();
    }
    follow(boxes, dirty);
    if (drifts) look_for_left(boxes);
    if (in_mass || many_left(boxes, left_.size())) note_shifts(boxes, dirty);
    if (in_mass) predict_drift(boxes, dirty);
    updates_.clear();
    if (many_left(boxes, left_.size())) {
      // The rest of those that move will follow soon: new margins for all of them.
      is_complete_ = false;
      count_short_lists();
      const bool all = frame_ != Vec2{} || drift_ != Vec2{};
      frame_ = {};
      const auto renew = [&](ProxyIndex proxy) {
        if (boxes.is_present(proxy))
          updates_.push_back({proxy, fattened(boxes, proxy, shifts_[proxy] - drift_)});
      };
      if (all) {
        for (ProxyIndex proxy = 0; proxy < boxes.limit(); ++proxy) renew(proxy);
      } else {
        for (const ProxyIndex proxy : dirty) renew(proxy);
      }
    } else if (in_mass) {
      for (const Leaver& l : left_)
        updates_.push_back({l.proxy, fattened(boxes, l.proxy, shifts_[l.proxy] - drift_)});
    } else if (!left_.empty()) {
      find_leaving(boxes, dirty);
      for (const Leaver& l : left_)
        updates_.push_back({l.proxy, with_margin_ahead(boxes.box(l.proxy), l.shift)});
      for (const Leaver& l : leaving_) {
        const Aabb& box = boxes.box(l.proxy);
        if (is_steady(box, l.shift)) updates_.push_back({l.proxy, with_margin_ahead(box, l.shift)});
      }
    }
    for (const BoxUpdate& update : updates_) {
      rest(update.proxy);
      set_margin(update.proxy, update.box, boxes.is_fixed(update.proxy));
    }
    fat_.update(updates_);
  }

  void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) override {
    const BoxSet& boxes = request.boxes;
    const bool in_mass = moves_in_mass(boxes, boxes.moved().size());
    const bool again = after_mass_ && is_complete_ && !many_left(boxes, fat_.moved().size()) &&
                       list_.size() < kWorthList * boxes.moved().size();
    if (!request.all) after_mass_ = in_mass;
    if (!request.all && !in_mass && !again) {
      return find_moved(request, parts.front(), stats);
    }
    // From here on boxes may leave their margins unseen by the list of the few.
    if (!request.all) forget_few();
    if (!is_complete_ || many_left(boxes, fat_.moved().size())) {
      list_all(parts, stats);
    } else if (!fat_.moved().empty()) {
      list_more(parts, stats);
    }
    if (!request.all && in_mass) {
      ++list_age_;
      steps_without_margin_ -= steps_without_margin_ > 0;
    }
    test_list(request, parts, stats);
  }
  bool in_order() const override { return true; }

  void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const override {
    refresh_grid();
    const std::size_t before = found.size();
    grid_->query(fat_, in_frame(region), found);
    keep(found, before, [&](ProxyIndex proxy) { return overlap(boxes.box(proxy), region); });
  }

  void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const override {
    refresh_grid();
    const std::size_t before = found.size();
    const RayTest test(ray);
    // A shifted ray would be another one after rounding.
    if (frame_ == Vec2{})
      grid_->ray_cast(fat_, ray, found);
    else
      grid_->query(fat_, in_frame(test.bounds()), found);
    keep(found, before, [&](ProxyIndex proxy) { return test.meets(boxes.box(proxy)); });
  }

  std::size_t bytes() const override {
    return fat_.bytes() + grid_->bytes() +
           (tight_.capacity() + margin_.capacity() + before_.capacity()) * sizeof(FloatBox) +
           (list_.capacity() + more_.capacity() + found_.capacity()) * sizeof(Pair) +
           (left_.capacity() + leaving_.capacity()) * sizeof(Leaver) +
           updates_.capacity() * sizeof(BoxUpdate) +
           (shifts_.capacity() + sample_.capacity()) * sizeof(Vec2) + merged_.bytes() + scratch_.bytes() +
           in_motion_.capacity() + was_moving_.capacity() +
           (few_.capacity() + old_few_.capacity()) * sizeof(Pair) + bytes_of(few_keys_);
  }

  void visit_structure(const BoxSet&, StructureVisitor& visitor) const override {
    for (ProxyIndex proxy = 0; proxy < fat_.limit(); ++proxy) {
      if (!fat_.is_present(proxy)) continue;
      const Aabb& fat = fat_.box(proxy);
      visitor.cell({fat.lower + frame_, fat.upper + frame_}, 0, 1);
    }
  }

 private:
  static std::size_t bytes_of(const std::vector<PairBuffer>& parts) {
    std::size_t sum = 0;
    for (const PairBuffer& part : parts) sum += part.bytes();
    return sum;
  }
  static bool many_left(const BoxSet& boxes, std::size_t left) {
    return left > boxes.size() / kShareThatLeft + 4;
  }

  /// True if so many boxes move that the list is worth its upkeep.
  static bool moves_in_mass(const BoxSet& boxes, std::size_t moved) { return 4 * moved > boxes.size(); }

  template <class Keep>
  static void keep(std::vector<ProxyIndex>& found, std::size_t before, Keep keeps) {
    found.erase(std::remove_if(found.begin() + static_cast<std::ptrdiff_t>(before), found.end(),
                               [&](ProxyIndex proxy) { return !keeps(proxy); }),
                found.end());
  }

  /// Whether the next list is worth margins, after how long the last ones lived.
  void count_short_lists() {
    if (steps_without_margin_ > 0) return;
    short_lists_ = list_age_ < 2 ? short_lists_ + 1 : 0;
    if (short_lists_ < kShortLists) return;
    short_lists_ = 0;
    steps_without_margin_ = kStepsWithoutMargin;
  }

  /// Where a box is for the margins. Each number goes over by a function that keeps their order.
  Aabb in_frame(const Aabb& box) const { return {box.lower - frame_, box.upper - frame_}; }

  /// The box with its margin; fixed boxes have none, but for how the frame will go over them.
  /// @param shift  of its middle against the frame in the last step [m]
  Aabb fattened(const BoxSet& boxes, ProxyIndex proxy, Vec2 shift) const {
    const Aabb box = in_frame(boxes.box(proxy));
    if (steps_without_margin_ > 0) return box;
    if (boxes.is_fixed(proxy)) return along(box, -kFixedAhead * drift_);
    const double width = box.upper.x - box.lower.x, height = box.upper.y - box.lower.y;
    const double margin =
        std::max(kMargin * std::sqrt(width * height), kThinMargin * std::max(width, height));
    return if_finite(along(grown(box, margin <= kLargestMargin ? margin : 0), kAheadInMass * shift), box);
  }
  /// What the box covers on its way.
  static Aabb along(const Aabb& box, Vec2 way) {
    return {box.lower + Vec2{std::min(way.x, 0.0), std::min(way.y, 0.0)},
            box.upper + Vec2{std::max(way.x, 0.0), std::max(way.y, 0.0)}};
  }
  static Aabb if_finite(const Aabb& fat, const Aabb& box) {
    return std::isfinite(fat.upper.x - fat.lower.x) && std::isfinite(fat.upper.y - fat.lower.y) ? fat : box;
  }

  /// True if a box that moved by `shift` in a step can be expected to go on so.
  static bool is_steady(const Aabb& box, Vec2 shift) {
    const double size = std::sqrt((box.upper.x - box.lower.x) * (box.upper.y - box.lower.y));
    // One that flies farther than its size in a step would have to look at all that lies in its way. Far from
    // the origin the shift is mostly rounding of single precision.
    const double far = std::max({-box.lower.x, -box.lower.y, box.upper.x, box.upper.y});
    return std::abs(shift.x) + std::abs(shift.y) <= 0.5 * size && kStepsAhead * FLT_EPSILON * far <= size;
  }

  /// The box with a small margin that reaches ahead. @param shift  how far the box moved in the last step
  Aabb with_margin_ahead(const Aabb& world_box, Vec2 shift) const {
    const Aabb box = in_frame(world_box);
    const double width = box.upper.x - box.lower.x, height = box.upper.y - box.lower.y;
    const double size = std::sqrt(width * height);
    const double margin = std::max(kSmallMargin * size, kThinMargin * std::max(width, height));
    const Aabb fat = grown(box, margin <= kLargestMargin ? margin : 0);
    return if_finite(is_steady(box, shift) ? along(fat, kStepsAhead * shift) : fat, box);
  }

  /// Brings the copies of the boxes up to date, and says in `left_` which have left their margins. What they
  /// were is in `before_`, in the order of `dirty`.
  void follow(const BoxSet& boxes, std::span<const ProxyIndex> dirty) {
    before_.resize(dirty.size());
    const std::size_t count = workers_->shares(dirty.size(), kFollowedPerThread);
    if (wanting_.size() < count) wanting_.resize(count);
    workers_->run(count, [&](std::size_t part) {
      wanting_[part].clear();
      follow_part(boxes, dirty, dirty.size() * part / count, dirty.size() * (part + 1) / count,
                  wanting_[part]);
    });
    for (std::size_t part = 0; part < count; ++part)
      for (const std::uint32_t i : wanting_[part]) follow_closely(boxes, dirty[i], before_[i]);
  }
  /// @param wanting  gets the places in `dirty` of those that want a closer look
  void follow_part(const BoxSet& boxes, std::span<const ProxyIndex> dirty, std::size_t from, std::size_t to,
                   std::vector<std::uint32_t>& wanting) {
    const BoxSet::View view(boxes);
    FloatBox *const tight = tight_.data(), *const before = before_.data();
    const FloatBox* const margin = margin_.data();
    const bool moves_along = frame_ != Vec2{};
    for (std::size_t i = from; i < to; ++i) {
      const ProxyIndex ahead = dirty[std::min(i + kAhead, dirty.size() - 1)];
      prefetch(&margin[ahead]);
      prefetch(&tight[ahead]);
      const ProxyIndex proxy = dirty[i];
      before[i] = tight[proxy];
      if (view.is_moving(proxy)) {
        store(tight[proxy], view.box(proxy), {});
        if (is_within(margin[proxy], moves_along ? float_in_frame(view.box(proxy)) : tight[proxy])) continue;
      }
      wanting.push_back(static_cast<std::uint32_t>(i));
    }
  }
  FloatBox float_in_frame(const Aabb& box) const {
    FloatBox there;
    store(there, box, frame_);
    return there;
  }
  /// The same but for rounding, where nothing but time hangs on it.
  FloatBox about_in_frame(const FloatBox& box) const {
    const auto x = static_cast<float>(frame_.x), y = static_cast<float>(frame_.y);
    return {{box.v[0] - x, box.v[1] - y, box.v[2] + x, box.v[3] + y}};
  }
  /// Where the frame moved, boxes that did not move can have left their margins.
  void look_for_left(const BoxSet& boxes) {
    left_.clear();
    const BoxSet::View view(boxes);
    for (ProxyIndex proxy = 0; proxy < boxes.limit(); ++proxy) {
      if (view.is_moving(proxy) && is_within(margin_[proxy], float_in_frame(view.box(proxy)))) continue;
      if (boxes.is_present(proxy) && !encloses(fat_.box(proxy), in_frame(boxes.box(proxy))))
        left_.push_back({proxy, {}});
    }
  }
  /// How far the middles of boxes went in the last step.
  void note_shifts(const BoxSet& boxes, std::span<const ProxyIndex> dirty) {
    shifts_.assign(boxes.limit(), Vec2{});
    for (std::size_t i = 0; i < dirty.size(); ++i) {
      const FloatBox &before = before_[i], &now = tight_[dirty[i]];
      if (before.v[0] == kNoFloatBox.v[0] || now.v[0] == kNoFloatBox.v[0]) continue;
      const Vec2 shift = 0.5 * Vec2{(double{now.v[0]} - before.v[0]) - (double{now.v[2]} - before.v[2]),
                                    (double{now.v[1]} - before.v[1]) - (double{now.v[3]} - before.v[3])};
      // What is beyond single precision has none.
      if (is_finite(shift)) shifts_[dirty[i]] = shift;
    }
  }
  /// The common shift of the last step, where most boxes had it and it was about that of the step before.
  void predict_drift(const BoxSet& boxes, std::span<const ProxyIndex> dirty) {
    drift_ = {};
    if (steps_without_margin_ > 0) return;
    sample_.clear();
    for (std::size_t i = 0; i < dirty.size(); i += dirty.size() / kSample + 1)
      sample_.push_back(shifts_[dirty[i]]);
    const Vec2 common = {median_of_sample(&Vec2::x), median_of_sample(&Vec2::y)};
    const auto alike = std::count_if(sample_.begin(), sample_.end(), [&](Vec2 shift) {
      return length_squared(shift - common) < kAlike * length_squared(common);
    });
    const double share = static_cast<double>(alike) / static_cast<double>(sample_.size()) *
                         static_cast<double>(dirty.size()) /
                         std::max(1.0, static_cast<double>(boxes.size() - boxes.fixed_count()));
    const Vec2 there = frame_ + common, change = common - last_common_;
    last_common_ = common;
    if (share > kCommon && length_squared(change) < kSteady * length_squared(common) &&
        std::abs(there.x) < kFarthestFrame && std::abs(there.y) < kFarthestFrame) {
      drift_ = common;
    }
  }
  double median_of_sample(double Vec2::*part) {
    const auto middle = sample_.begin() + static_cast<std::ptrdiff_t>(sample_.size() / 2);
    std::nth_element(sample_.begin(), middle, sample_.end(),
                     [part](Vec2 p, Vec2 q) { return p.*part < q.*part; });
    return (*middle).*part;
  }
  /// Says in `leaving_` which boxes are still in their margins, and will not be soon.
  void find_leaving(const BoxSet& boxes, std::span<const ProxyIndex> dirty) {
    for (std::size_t i = 0; i < dirty.size(); ++i) {
      const ProxyIndex proxy = dirty[i];
      const FloatBox &now = tight_[proxy], &margin = margin_[proxy];
      const FloatBox soon = ahead_of(before_[i], now, kStepsSoon);
      if (is_within(margin, about_in_frame(now)) && !is_within(margin, about_in_frame(soon))) {
        leaving_.push_back({proxy, shift_of(boxes.box(proxy), before_[i])});
      }
    }
  }
  static Vec2 shift_of(const Aabb& box, const FloatBox& before) {
    return {box.lower.x - double{before.v[0]}, box.lower.y - double{before.v[1]}};
  }

  /// Follows one box where it takes more than a glance.
  void follow_closely(const BoxSet& boxes, ProxyIndex proxy, const FloatBox& before) {
    if (!boxes.is_present(proxy)) {
      tight_[proxy] = margin_[proxy] = kNoFloatBox;
      rest(proxy);
      if (fat_.is_present(proxy)) fat_.remove(proxy);
      return;
    }
    const Aabb& box = boxes.box(proxy);
    store(tight_[proxy], box, {});
    if (fat_.is_present(proxy)) {
      if (fat_.is_fixed(proxy) == boxes.is_fixed(proxy)) {
        if (!encloses(fat_.box(proxy), in_frame(box))) left_.push_back({proxy, shift_of(box, before)});
        return;
      }
      rest(proxy);
      fat_.remove(proxy);
    }
    // The list may have pairs of this number with fixed boxes from when it was moving, long removed or not;
    // they must not stay when it is fixed.
    const bool is_fixed = boxes.is_fixed(proxy);
    if (is_fixed && was_moving_[proxy] != 0) is_complete_ = false;
    was_moving_[proxy] = is_fixed ? 0 : 1;
    fat_.insert(proxy, fattened(boxes, proxy, {}), is_fixed ? ProxyKind::Fixed : ProxyKind::Moving);
    set_margin(proxy, fat_.box(proxy), is_fixed);
  }
  void set_margin(ProxyIndex proxy, const Aabb& fat, bool is_fixed) {
    if (is_fixed) {
      margin_[proxy] = kNoFloatBox;
    } else {
      store(margin_[proxy], fat, {});
    }
  }

  void refresh_grid() const {
    if (fat_.dirty().empty()) return;
    BroadPhaseStats unused;
    grid_->synchronise(fat_, fat_.dirty(), unused);
    fat_.clear_dirty();
  }

  /// Finds pairs of fat boxes; `parts` is left empty. The tests count, what they find does not.
  void find_fat(bool all, std::vector<PairBuffer>& parts, std::vector<Pair>& pairs, BroadPhaseStats& stats) {
    fat_.tidy_moved();
    refresh_grid();
    grid_->find({fat_, all}, parts, stats);
    sort_pairs(parts, fat_.limit(), scratch_, pairs, workers_.get());
    for (PairBuffer& part : parts) part.clear();
    fat_.clear_moved();
  }
  void list_all(std::vector<PairBuffer>& parts, BroadPhaseStats& stats) {
    find_fat(true, parts, list_, stats);
    list_.insert(list_.end(), kCandidatePadding, {});
    more_.clear();
    is_complete_ = true;
    list_age_ = 0;
  }
  void list_more(std::vector<PairBuffer>& parts, BroadPhaseStats& stats) {
    find_fat(false, parts, found_, stats);
    drop_listed(found_);
    if (!more_.empty()) more_.resize(more_.size() - kCandidatePadding);
    const auto known = static_cast<std::ptrdiff_t>(more_.size());
    more_.insert(more_.end(), found_.begin(), found_.end());
    std::inplace_merge(more_.begin(), more_.begin() + known, more_.end());
    more_.erase(std::unique(more_.begin(), more_.end()), more_.end());
    more_.insert(more_.end(), kCandidatePadding, {});
    if (4 * more_.size() > list_.size() + 64) list_all(parts, stats);
  }

  /// Drops those that the list has already, of a large box that leaves its margin most of them.
  void drop_listed(std::vector<Pair>& found) const {
    auto place = list_.begin();
    const auto end = list_.end() - static_cast<std::ptrdiff_t>(kCandidatePadding);
    std::erase_if(found, [&](const Pair& pair) {
      // The next one is near.
      std::ptrdiff_t step = 1;
      auto next = place;
      while (end - next > step && next[step] < pair) {
        next += step;
        step *= 2;
      }
      place = std::lower_bound(next, end - next > step ? next + step + 1 : end, pair);
      return place != end && *place == pair;
    });
  }

  /// The candidates of a list without the places after them.
  static std::span<const Pair> candidates_of(const std::vector<Pair>& list) {
    return {list.data(), list.size() - kCandidatePadding};
  }

  /// True if every box moved that is not fixed: then every pair of the list has a box that moved.
  static bool all_moved(const BoxSet& boxes) {
    const std::size_t least = boxes.size() - boxes.fixed_count();
    if (boxes.moved().size() < least) return false;
    const auto is_fixed = [&](ProxyIndex proxy) { return boxes.is_fixed(proxy); };
    const auto fixed = std::count_if(boxes.moved().begin(), boxes.moved().end(), is_fixed);
    return boxes.moved().size() - static_cast<std::size_t>(fixed) == least;
  }

  void test_list(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) {
    const std::span<const Pair> candidates = candidates_of(list_);
    const std::size_t count = workers_->shares(candidates.size(), kCandidatesPerThread);
    const CandidateTests tests{request, tight_, !request.all && !all_moved(request.boxes), false,
                               wide_tests_};
    if (parts.size() < count) parts.resize(count);
    work_.assign(count, {});
    workers_->run(count, [&](std::size_t part) {
      const std::size_t begin = candidates.size() * part / count;
      const std::size_t end = candidates.size() * (part + 1) / count;
      tests.run(candidates.subspan(begin, end - begin), parts[part], work_[part]);
    });
    for (const BroadPhaseStats& work : work_) {
      stats.box_tests += work.box_tests;
      stats.false_pairs += work.false_pairs;
    }
    if (more_.empty()) return;
    // A pair can be in both lists: its boxes left their margins and met again.
    PairBuffer& front = parts.front();
    for (std::size_t part = 1; part < count; ++part) {
      std::uint64_t* to = front.reserve(parts[part].size());
      front.advance_to(std::copy_n(parts[part].data(), parts[part].size(), to));
      parts[part].clear();
    }
    extra_.clear();
    tests.run(candidates_of(more_), extra_, stats);
    merged_.clear();
    std::uint64_t* to = merged_.reserve(front.size() + extra_.size());
    merged_.advance_to(std::set_union(front.data(), front.data() + front.size(), extra_.data(),
                                      extra_.data() + extra_.size(), to));
    std::swap(merged_, front);
  }

  /// A box that moves again will be searched for anew.
  void rest(ProxyIndex proxy) {
    if (in_motion_[proxy] == kAtRest) return;
    --count_in_motion_;
    in_motion_[proxy] = kAtRest;
    few_rested_ = true;
  }
  void forget_few() {
    if (few_.empty()) return;
    few_.clear();
    std::fill(in_motion_.begin(), in_motion_.end(), kAtRest);
    count_in_motion_ = 0;
  }

  /// Brings the list of the few up to date. It has the pairs of boxes in motion whose margins meet, and of a
  /// margin with a box at rest: that one gets its own pairs when it begins to move.
  void list_few(const BoxSet& boxes, BroadPhaseStats& stats) {
    // Where most have come to rest the others start again.
    if (count_in_motion_ > 2 * boxes.moved().size() + 16) forget_few();
    anew_.clear();
    for (const ProxyIndex proxy : boxes.moved()) {
      if (in_motion_[proxy] == kAtRest) {
        in_motion_[proxy] = kAnew;
        anew_.push_back(proxy);
      }
    }
    count_in_motion_ += anew_.size();
    if (anew_.empty()) return;
    refresh_grid();
    for (PairBuffer& keys : few_keys_) keys.clear();
    grid_->find_around(fat_, anew_, few_keys_, stats);
    for (const PairBuffer& keys : few_keys_) stats.false_pairs += keys.size();
    workers_->run(few_keys_.size(), [&](std::size_t part) { keep_few(boxes, few_keys_[part]); });
    sort_pairs(few_keys_, boxes.limit(), scratch_, found_);
    found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
    // What the list had of these boxes and of those at rest goes, and what was found joins it.
    old_few_.swap(few_);
    if (old_few_.empty()) old_few_.resize(kCandidatePadding);
    few_.resize(old_few_.size() + found_.size());
    const Pair *next = found_.data(), *const last = next + found_.size();
    const Pair* old = old_few_.data();
    const Pair* const old_last = old + candidates_of(old_few_).size();
    Pair* to = few_.data();
    const auto stays = [this](const Pair& pair) {
      return (in_motion_[pair.low] | in_motion_[pair.high]) == kInMotion;
    };
    while (old < old_last && next < last) {
      // Without branches: which of the two comes next cannot be predicted.
      const std::uint64_t a = to_key(*old), b = to_key(*next);
      const bool is_old = a < b;
      *to = *(is_old ? old : next);
      to += static_cast<unsigned>(!is_old) | static_cast<unsigned>(stays(*old));
      old += is_old;
      next += !is_old;
    }
    for (; old < old_last; ++old) {
      *to = *old;
      to += stays(*old) ? 1 : 0;
    }
    to = std::copy(next, last, to);
    few_.resize(static_cast<std::size_t>(to - few_.data()) + kCandidatePadding);
    for (const ProxyIndex proxy : anew_) in_motion_[proxy] = kInMotion;
    few_rested_ = false;
  }

  /// Drops pairs of a margin with a box at rest that lies in that box's margin only.
  void keep_few(const BoxSet& boxes, PairBuffer& keys) const {
    std::uint64_t* to = keys.data();
    const std::uint64_t* const last = keys.data() + keys.size();
    const bool moves_along = frame_ != Vec2{};
    for (const std::uint64_t* k = keys.data(); k < last; ++k) {
      const std::uint64_t ahead = k[std::min<std::ptrdiff_t>(kAhead, last - 1 - k)];
      prefetch(&tight_[ahead >> 32]);
      prefetch(&tight_[static_cast<ProxyIndex>(ahead)]);
      const auto low = static_cast<ProxyIndex>(*k >> 32), high = static_cast<ProxyIndex>(*k);
      // By masks: which of the two it is cannot be predicted.
      const ProxyIndex exchange = in_motion_[low] == kAnew ? 0 : low ^ high;
      const ProxyIndex from = low ^ exchange, other = high ^ exchange;
      const FloatLimits reach(fat_.box(from), {});
      const bool meets = reach.compare(moves_along ? float_in_frame(boxes.box(other)) : tight_[other]).maybe;
      *to = *k;
      to += static_cast<unsigned>(meets) | static_cast<unsigned>(in_motion_[other] != kAtRest);
    }
    keys.advance_to(to);
  }

  /// Few boxes moved: a look at the pairs that they may have, in proportion to their number.
  void find_moved(const PairRequest& request, PairBuffer& out, BroadPhaseStats& stats) {
    list_few(request.boxes, stats);
    // Boxes in motion that did not move in this step are those beyond the ones that did.
    const bool by_mark = few_rested_ || count_in_motion_ != request.boxes.moved().size();
    if (few_.empty()) return;
    const bool scattered = tight_.size() > kBoxesInCache;
    CandidateTests{request, tight_, by_mark, scattered, wide_tests_}.run(candidates_of(few_), out, stats);
  }

  mutable BoxSet fat_;  ///< the boxes with their margins; marked as moved: those that the list does not know
  std::shared_ptr<Workers> workers_;
  std::unique_ptr<HierarchicalGrid> grid_;  ///< over `fat_`
  std::vector<FloatBox> tight_;             ///< by proxy: the boxes themselves
  std::vector<FloatBox> margin_;            ///< by proxy: as in `fat_`; `kNoFloatBox` where fixed or absent
  std::vector<Pair> list_;                  ///< pairs of fat boxes, sorted
  std::vector<Pair> more_;                  ///< those found since it was made, sorted
  std::vector<Pair> few_;                   ///< pairs of the boxes in motion while these are few, sorted
  /// By proxy: its pairs are not in the list of the few, are to be found, or are in the list.
  enum : std::uint8_t { kAtRest = 0, kAnew = 1, kInMotion = 2 };
  std::vector<std::uint8_t> in_motion_;
  std::size_t count_in_motion_ = 0;
  bool few_rested_ = false;  ///< the list of the few has pairs of boxes that were in motion when it was made
  std::vector<std::uint8_t> was_moving_;  ///< by proxy: the kind with which it was inserted last
  bool is_complete_ = false;              ///< false: the list has to be made anew
  bool wide_tests_;
  bool after_mass_ = false;  ///< most boxes moved in the last report
  int list_age_ = 2;         ///< reports from the list
  int short_lists_ = 0;      ///< in a row
  int steps_without_margin_ = 0;
  Vec2 frame_;        ///< how far the margins went since all of them were made [m]
  Vec2 last_common_;  ///< shift in the last step in which most moved [m]
  Vec2 drift_;        ///< how far they go in the next step [m]
  // Kept between calls.
  struct Leaver {
    ProxyIndex proxy;
    Vec2 shift;  ///< in the last step [m]
  };
  std::vector<Leaver> left_, leaving_;
  std::vector<FloatBox> before_;
  std::vector<Vec2> sample_;                         ///< of them
  std::vector<Vec2> shifts_;                         ///< by proxy; see `note_shifts`
  std::vector<std::vector<std::uint32_t>> wanting_;  ///< by thread
  std::vector<ProxyIndex> anew_;
  std::vector<PairBuffer> few_keys_ = std::vector<PairBuffer>(1);  ///< by thread
  std::vector<Pair> old_few_;
  std::vector<BoxUpdate> updates_;
  std::vector<Pair> found_;
  std::vector<BroadPhaseStats> work_;
  PairBuffer extra_, merged_;
  PairSortScratch scratch_;
};

}  // namespace

std::unique_ptr<PairFinder> make_neighbour_list(const BroadPhaseOptions& options) {
  return make_neighbour_list(options, true);
}

std::unique_ptr<PairFinder> make_neighbour_list(const BroadPhaseOptions& options, bool wide_tests) {
  return std::make_unique<NeighbourList>(options, wide_tests);
}

}  // namespace skerry
