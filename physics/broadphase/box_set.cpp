// SPDX-License-Identifier: MIT
#include "physics/broadphase/box_set.h"

#include <cfloat>
#include <sstream>
#include <stdexcept>

#include "physics/broadphase/float_box.h"

namespace skerry {

namespace {

/// False for inverted boxes, infinities and NaN.
bool is_valid(const Aabb& b) {
#if defined(__SSE2__)
  const __m128d lower = _mm_loadu_pd(&b.lower.x), upper = _mm_loadu_pd(&b.upper.x);
  const __m128d above = _mm_cmpge_pd(lower, _mm_set1_pd(-DBL_MAX));
  const __m128d below = _mm_cmple_pd(upper, _mm_set1_pd(DBL_MAX));
  return _mm_movemask_pd(_mm_and_pd(_mm_and_pd(above, below), _mm_cmple_pd(lower, upper))) == 3;
#else
  return b.lower.x >= -DBL_MAX && b.lower.y >= -DBL_MAX && b.upper.x <= DBL_MAX && b.upper.y <= DBL_MAX &&
         b.lower.x <= b.upper.x && b.lower.y <= b.upper.y;
#endif
}

[[noreturn]] void refuse(ProxyIndex proxy, const Aabb& b, const char* call) {
  std::ostringstream text;
  text.precision(17);
  text << "BroadPhase::" << call << ": the box of proxy " << proxy << " is not finite or is inverted: x from "
       << b.lower.x << " to " << b.upper.x << ", y from " << b.lower.y << " to " << b.upper.y;
  throw std::invalid_argument(text.str());
}

[[noreturn]] void refuse(ProxyIndex proxy, const char* call, const char* why) {
  std::ostringstream text;
  text << "BroadPhase::" << call << ": proxy " << proxy << ' ' << why;
  throw std::invalid_argument(text.str());
}

/// Narrows the parameters [enter, leave] to those where `origin + t * direction` lies in [lower, upper].
bool clip_slab(double origin, double direction, double lower, double upper, double& enter, double& leave) {
  if (direction == 0) return lower <= origin && origin <= upper;
  const double a = ((direction > 0 ? lower : upper) - origin) / direction;
  const double b = ((direction > 0 ? upper : lower) - origin) / direction;
  enter = std::max(enter, a);
  leave = std::min(leave, b);
  return enter <= leave;
}

/// The coordinates that the ray reaches on one axis, grown by more than the rounding of the slab test.
void reach(double origin, double direction, double t_max, double& lower, double& upper) {
  lower = upper = origin;
  if (direction == 0) return;
  const double end = origin + t_max * direction;
  const double margin = 16 * DBL_EPSILON * (std::abs(origin) + std::abs(end)) + DBL_MIN;
  (direction > 0 ? upper : lower) = end;
  lower -= std::isfinite(margin) ? margin : kInfinity;
  upper += std::isfinite(margin) ? margin : kInfinity;
}

}  // namespace

void BoxSet::mark(ProxyIndex proxy) {
  const std::uint8_t old = state_[proxy];
  if ((old & kMovedListed) == 0) moved_.push_back(proxy);
  if ((old & kDirty) == 0) dirty_.push_back(proxy);
  state_[proxy] = old | kMoved | kMovedListed | kDirty;
}

void BoxSet::insert(ProxyIndex proxy, const Aabb& box, ProxyKind kind) {
  if (proxy >= kMaxProxies) refuse(proxy, "insert", "is too large a number");
  if (is_present(proxy)) refuse(proxy, "insert", "is present already");
  if (!is_valid(box)) refuse(proxy, box, "insert");
  if (proxy >= limit()) {
    state_.resize(proxy + std::size_t{1}, 0);
    boxes_.resize(proxy + std::size_t{1});
  }
  if (state_[proxy] & kMovedListed) --removed_moved_;
  state_[proxy] = static_cast<std::uint8_t>((state_[proxy] & ~kFixed) | kPresent |
                                            (kind == ProxyKind::Fixed ? kFixed : 0));
  boxes_[proxy] = box;
  ++size_;
  fixed_count_ += kind == ProxyKind::Fixed;
  ++membership_;
  ++version_;
  mark(proxy);
}

void BoxSet::remove(ProxyIndex proxy) {
  if (!is_present(proxy)) refuse(proxy, "remove", "is not present");
  if ((state_[proxy] & kDirty) == 0) dirty_.push_back(proxy);
  if (state_[proxy] & kMovedListed) ++removed_moved_;
  fixed_count_ -= is_fixed(proxy);
  state_[proxy] = static_cast<std::uint8_t>((state_[proxy] & kMovedListed) | kDirty);
  --size_;
  ++membership_;
  ++version_;
}

void BoxSet::update(std::span<const BoxUpdate> moved) {
  // Local copies of the pointers: a stored byte could otherwise change them, as far as the compiler knows.
  const ProxyIndex count = limit();
  std::uint8_t* const state = state_.data();
  Aabb* const boxes = boxes_.data();
  for (const BoxUpdate& u : moved) {
    if (u.proxy >= count || (state[u.proxy] & kPresent) == 0) refuse(u.proxy, "update", "is not present");
    if (!is_valid(u.box)) refuse(u.proxy, u.box, "update");
  }
  // List the proxies without branches: room for all first, then what was not needed is given back.
  constexpr std::uint8_t marks = kMoved | kMovedListed | kDirty;
  std::size_t moved_end = moved_.size(), dirty_end = dirty_.size();
  moved_.resize(moved_end + moved.size());
  dirty_.resize(dirty_end + moved.size());
  ProxyIndex *const moved_list = moved_.data(), *const dirty_list = dirty_.data();
  constexpr std::size_t kAhead = 16;
  const std::size_t last = moved.size() - 1;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    prefetch(&boxes[moved[std::min(i + kAhead, last)].proxy]);
    const BoxUpdate& u = moved[i];
    boxes[u.proxy] = u.box;
    const std::uint8_t old = state[u.proxy];
    moved_list[moved_end] = u.proxy;
    moved_end += (old & kMovedListed) == 0;
    dirty_list[dirty_end] = u.proxy;
    dirty_end += (old & kDirty) == 0;
    state[u.proxy] = old | marks;
  }
  moved_.resize(moved_end);
  dirty_.resize(dirty_end);
  ++version_;
}

void BoxSet::tidy_moved() {
  if (removed_moved_ == 0) return;
  std::size_t kept = 0;
  for (const ProxyIndex proxy : moved_) {
    if (state_[proxy] & kMoved) {
      moved_[kept++] = proxy;
    } else {
      state_[proxy] &= static_cast<std::uint8_t>(~kMovedListed);
    }
  }
  moved_.resize(kept);
  removed_moved_ = 0;
}

void BoxSet::clear_moved() {
  constexpr auto keep = static_cast<std::uint8_t>(~(kMoved | kMovedListed));
  for (const ProxyIndex proxy : moved_) state_[proxy] &= keep;
  if (!moved_.empty()) ++version_;
  moved_.clear();
  removed_moved_ = 0;
}

void BoxSet::clear_dirty() {
  for (const ProxyIndex proxy : dirty_) state_[proxy] &= static_cast<std::uint8_t>(~kDirty);
  dirty_.clear();
}

std::size_t BoxSet::bytes() const {
  return boxes_.capacity() * sizeof(Aabb) + state_.capacity() +
         (moved_.capacity() + dirty_.capacity()) * sizeof(ProxyIndex);
}

RayTest::RayTest(const Ray& ray) : ray_(ray) {
  reach(ray.origin.x, ray.direction.x, ray.t_max, bounds_.lower.x, bounds_.upper.x);
  reach(ray.origin.y, ray.direction.y, ray.t_max, bounds_.lower.y, bounds_.upper.y);
}

bool RayTest::meets(const Aabb& box) const {
  // The bounds matter where a division underflows.
  if (!overlap(bounds_, box)) return false;
  double enter = 0, leave = ray_.t_max;
  return clip_slab(ray_.origin.x, ray_.direction.x, box.lower.x, box.upper.x, enter, leave) &&
         clip_slab(ray_.origin.y, ray_.direction.y, box.lower.y, box.upper.y, enter, leave);
}

}  // namespace skerry
