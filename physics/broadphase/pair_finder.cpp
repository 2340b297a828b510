// SPDX-License-Identifier: MIT
#include "physics/broadphase/pair_finder.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace skerry {

namespace {

/// Joins a box set and a finder. The structure is brought up to date by the first call that needs it, so it
/// is mutable: a query after an update looks at the new boxes.
class FinderBroadPhase final : public BroadPhase {
 public:
  FinderBroadPhase(std::string_view name, std::unique_ptr<PairFinder> finder)
      : name_(name), finder_(std::move(finder)) {}

  std::string_view name() const override { return name_; }
  BroadPhaseChoice choice() const override {
    BroadPhaseChoice chosen = finder_->choice();
    if (chosen.name.empty()) chosen.name = name_;
    return chosen;
  }
  void insert(ProxyIndex proxy, const Aabb& box, ProxyKind kind) override { boxes_.insert(proxy, box, kind); }
  void remove(ProxyIndex proxy) override { boxes_.remove(proxy); }
  void update(std::span<const BoxUpdate> moved) override { boxes_.update(moved); }

  void moved_pairs(std::vector<Pair>& pairs) override {
    report(pairs, false);
    boxes_.clear_moved();
  }
  void all_pairs(std::vector<Pair>& pairs) override { report(pairs, true); }

  void query(const Aabb& box, std::vector<ProxyIndex>& found) const override {
    const bool sound = box.lower.x <= box.upper.x && box.lower.y <= box.upper.y && box.lower.x < kInfinity &&
                       box.lower.y < kInfinity && box.upper.x > -kInfinity && box.upper.y > -kInfinity;
    if (!sound) refuse_region(box);
    found.clear();
    synchronise();
    finder_->query(boxes_, box, found);
    std::sort(found.begin(), found.end());
  }
  void query(Vec2 point, std::vector<ProxyIndex>& found) const override { query(Aabb{point, point}, found); }
  void ray_cast(const Ray& ray, std::vector<ProxyIndex>& found) const override {
    if (!is_finite(ray.origin) || !is_finite(ray.direction) || ray.direction == Vec2{} || !(ray.t_max >= 0)) {
      refuse_ray(ray);
    }
    found.clear();
    synchronise();
    finder_->ray_cast(boxes_, ray, found);
    std::sort(found.begin(), found.end());
  }

  std::size_t size() const override { return boxes_.size(); }
  BroadPhaseStats stats() const override {
    BroadPhaseStats stats = stats_;
    stats.bytes = boxes_.bytes() + finder_->bytes() + scratch_.bytes();
    for (const PairBuffer& part : parts_) stats.bytes += part.bytes();
    return stats;
  }
  void visit_structure(StructureVisitor& visitor) const override {
    synchronise();
    finder_->visit_structure(boxes_, visitor);
  }

 private:
  void synchronise() const {
    if (boxes_.dirty().empty()) return;
    finder_->synchronise(boxes_, boxes_.dirty(), pending_);
    boxes_.clear_dirty();
  }

  void report(std::vector<Pair>& pairs, bool all) {
    boxes_.tidy_moved();
    synchronise();
    stats_ = pending_;
    pending_ = {};
    for (PairBuffer& part : parts_) part.clear();
    if (parts_.empty()) parts_.resize(1);
    finder_->find({boxes_, all}, parts_, stats_);
    if (finder_->in_order()) {
      join_pairs(parts_, pairs);
    } else {
      sort_pairs(parts_, boxes_.limit(), scratch_, pairs);
    }
    stats_.pairs = pairs.size();
  }

  [[noreturn]] static void refuse_region(const Aabb& box) {
    std::ostringstream text;
    text << "BroadPhase::query: the region is inverted, not a number, or at infinity: x from " << box.lower.x
         << " to " << box.upper.x << ", y from " << box.lower.y << " to " << box.upper.y;
    throw std::invalid_argument(text.str());
  }
  [[noreturn]] static void refuse_ray(const Ray& ray) {
    std::ostringstream text;
    text << "BroadPhase::ray_cast: origin and direction must be finite, the direction not zero, t_max >= 0; "
            "got "
         << "origin (" << ray.origin.x << ", " << ray.origin.y << "), direction (" << ray.direction.x << ", "
         << ray.direction.y << "), t_max " << ray.t_max;
    throw std::invalid_argument(text.str());
  }

  std::string_view name_;
  mutable BoxSet boxes_;
  std::unique_ptr<PairFinder> finder_;
  std::vector<PairBuffer> parts_;
  PairSortScratch scratch_;
  BroadPhaseStats stats_;
  mutable BroadPhaseStats
      pending_;  ///< work of bringing the structure up to date, counted with the next report
};

}  // namespace

void PairFinder::ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const {
  const std::size_t before = found.size();
  const RayTest test(ray);
  query(boxes, test.bounds(), found);
  const auto missed = [&](ProxyIndex proxy) { return !test.meets(boxes.box(proxy)); };
  found.erase(std::remove_if(found.begin() + static_cast<std::ptrdiff_t>(before), found.end(), missed),
              found.end());
}

std::unique_ptr<BroadPhase> make_with_finder(std::string_view name, std::unique_ptr<PairFinder> finder) {
  return std::make_unique<FinderBroadPhase>(name, std::move(finder));
}

}  // namespace skerry
