// SPDX-License-Identifier: MIT
//
// Picks an implementation from the scene and changes it while running. Which boxes there are and which moved
// is kept outside of the structures, so a change rebuilds the structure and nothing else: no pair is lost or
// doubled.
//
// The rule is a model of the cost, fitted to tests/bench/broadphase_bench.cpp. Of the eight implementations
// two are ever the best: testing every box that moved against all, where there are few boxes or where a
// handful of a few hundred move; and the hierarchical grid for all else, whatever the places, sizes, extent
// and share of sleepers (a mixture of sizes 1:300 costs it twice as much as equal sizes, but the next best
// four times as much).
#include <algorithm>
#include <cmath>
#include <sstream>

#include "physics/broadphase/pair_finder.h"

namespace skerry {

namespace {

/// Expected time of a step [ns] with `moved` of `count` boxes in motion.
double brute_force_cost(double count, double moved) {
  return moved < count ? 1.6 * count * moved : 0.8 * count * count;
}
double grid_cost(double count, double moved) {
  return 4 * moved > count ? 500 + 42 * count : 100 + 180 * moved;
}
/// The other one has to be this much cheaper, so that a scene on the border does not change with every step.
constexpr double kWorthChanging = 0.6;
/// Share of the last step in the running mean of moved boxes.
constexpr double kNewest = 0.125;

class Auto final : public PairFinder {
 public:
  explicit Auto(const BroadPhaseOptions& options) : options_(options), finder_(make_brute_force(options)) {}

  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats& stats) override {
    const auto count = static_cast<double>(boxes.size());
    const double moved = std::min(count, static_cast<double>(dirty.size()));
    mean_moved_ += kNewest * (moved - mean_moved_);
    const double brute = brute_force_cost(count, mean_moved_), grid = grid_cost(count, mean_moved_);
    const bool changes = uses_grid_ ? brute < kWorthChanging * grid : grid < kWorthChanging * brute;
    if (!changes) {
      finder_->synchronise(boxes, dirty, stats);
      return;
    }
    uses_grid_ = !uses_grid_;
    finder_ = uses_grid_ ? make_hierarchical_grid(options_) : make_brute_force(options_);
    describe(boxes);
    std::vector<ProxyIndex> present;
    for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
      if (boxes.is_present(p)) present.push_back(p);
    }
    finder_->synchronise(boxes, present, stats);
  }
  void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) override {
    finder_->find(request, parts, stats);
  }
  void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const override {
    finder_->query(boxes, region, found);
  }
  void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const override {
    finder_->ray_cast(boxes, ray, found);
  }
  std::string choice() const override {
    return (uses_grid_ ? "hierarchical_grid: " : "brute_force: ") + reason_;
  }
  std::size_t bytes() const override { return finder_->bytes(); }
  void visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const override {
    finder_->visit_structure(boxes, visitor);
  }

 private:
  /// Writes down the scene that led to the choice.
  void describe(const BoxSet& boxes) {
    double least = kInfinity, most = 0;
    Aabb world{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
    for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
      if (!boxes.is_present(p)) continue;
      const Aabb& box = boxes.box(p);
      const double extent = std::max(box.upper.x - box.lower.x, box.upper.y - box.lower.y);
      least = std::min(least, extent);
      most = std::max(most, extent);
      world = united(world, box);
    }
    std::ostringstream text;
    text << boxes.size() << " boxes of " << least << " to " << most << " m in "
         << world.upper.x - world.lower.x << " m x " << world.upper.y - world.lower.y << " m, about "
         << std::lround(mean_moved_) << " moved a step";
    reason_ = text.str();
  }

  BroadPhaseOptions options_;
  std::unique_ptr<PairFinder> finder_;
  bool uses_grid_ = false;
  double mean_moved_ = 0;
  std::string reason_ = "few boxes";
};

}  // namespace

std::unique_ptr<PairFinder> make_auto(const BroadPhaseOptions& options) {
  return std::make_unique<Auto>(options);
}

}  // namespace skerry
