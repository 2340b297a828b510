// SPDX-License-Identifier: MIT
//
// Picks an implementation from the scene and changes it while running. Which boxes there are and which moved
// is kept outside of the structures, so a change rebuilds the structure and nothing else: no pair is lost or
// doubled.
//
// The rule is a rough model of the cost (`broadphase_bench` checks it against the best). Three of the
// implementations are ever the best: testing every box that moved against all, where there are few boxes or
// where a handful of a few hundred move; the hierarchical grid, where a handful of many move, whose pairs are
// not worth a list; and the neighbour list for all else, whatever the places, sizes, extent and share of
// sleepers.
#include <algorithm>

#include "physics/broadphase/pair_finder.h"
#include "physics/shape.h"

namespace skerry {

namespace {

/// Expected time of a step [ns] with `moved` of `count` boxes in motion.
double brute_force_cost(double count, double moved) {
  return moved < count ? 1.6 * count * moved : 0.8 * count * count;
}
double grid_cost(double count, double moved) {
  return 4 * moved > count ? 500 + 42 * count : 100 + 130 * moved;
}
double list_cost(double count, double moved) {
  return 4 * moved > count ? 400 + 26 * count : 500 + 60 * moved;
}
/// Another one has to be this much cheaper, so that a scene on the border does not change with every step.
constexpr double kWorthChanging = 0.7;
/// Up to so many boxes nothing costs less than the first choice, however many move.
constexpr std::size_t kFew = 16;
/// Share of the last step in the running mean of moved boxes.
constexpr double kNewest = 0.125;

/// What there is to choose from; the first is used at first.
struct Choice {
  std::string_view name;
  double (*cost)(double count, double moved);
  std::unique_ptr<PairFinder> (*make)(const BroadPhaseOptions&);
};
constexpr Choice kChoices[] = {{"brute_force", brute_force_cost, make_brute_force},
                               {"hierarchical_grid", grid_cost, make_hierarchical_grid},
                               {"neighbour_list", list_cost, make_neighbour_list}};

class Auto final : public PairFinder {
 public:
  explicit Auto(const BroadPhaseOptions& options) : options_(options), finder_(make_brute_force(options)) {}

  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats& stats) override {
    const auto count = static_cast<double>(boxes.size());
    const double moved = std::min(count, static_cast<double>(dirty.size()));
    mean_moved_ += kNewest * (moved - mean_moved_);
    // So few that no model is needed.
    if (choice_ == kChoices && boxes.size() <= kFew) return finder_->synchronise(boxes, dirty, stats);
    const Choice* best = choice_;
    for (const Choice& choice : kChoices) {
      if (choice.cost(count, mean_moved_) < best->cost(count, mean_moved_)) best = &choice;
    }
    // It has to be so with somewhat more and somewhat fewer moves as well.
    const auto is_worth_it = [&](double moves) {
      return best->cost(count, moves) < kWorthChanging * choice_->cost(count, moves);
    };
    if (!is_worth_it(0.75 * mean_moved_) || !is_worth_it(std::min(count, 1.25 * mean_moved_))) {
      finder_->synchronise(boxes, dirty, stats);
      return;
    }
    choice_ = best;
    finder_ = choice_->make(options_);
    describe(boxes);
    ++described_.switches;
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
  bool in_order() const override { return finder_->in_order(); }
  void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const override {
    finder_->ray_cast(boxes, ray, found);
  }
  BroadPhaseChoice choice() const override { return described_; }
  std::size_t bytes() const override { return finder_->bytes(); }
  void visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const override {
    finder_->visit_structure(boxes, visitor);
  }

 private:
  /// Writes down the scene that led to the choice.
  void describe(const BoxSet& boxes) {
    described_.name = choice_->name;
    described_.reason = BroadPhaseReason::Cheapest;
    described_.boxes = boxes.size();
    described_.moved = mean_moved_;
    described_.smallest = kInfinity;
    described_.largest = 0;
    Aabb world{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
    for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
      if (!boxes.is_present(p)) continue;
      const Aabb& box = boxes.box(p);
      const double extent = std::max(box.upper.x - box.lower.x, box.upper.y - box.lower.y);
      if (extent > kEndless) continue;  // of a half-plane
      described_.smallest = std::min(described_.smallest, extent);
      described_.largest = std::max(described_.largest, extent);
      world = united(world, box);
    }
    described_.extent = world.upper - world.lower;
  }

  BroadPhaseOptions options_;
  std::unique_ptr<PairFinder> finder_;
  const Choice* choice_ = kChoices;
  double mean_moved_ = 0;
  BroadPhaseChoice described_{.name = kChoices[0].name, .reason = BroadPhaseReason::FewBoxes};
};

}  // namespace

std::unique_ptr<PairFinder> make_auto(const BroadPhaseOptions& options) {
  return std::make_unique<Auto>(options);
}

}  // namespace skerry
