// SPDX-License-Identifier: MIT
//
// Picks an implementation from the scene and changes it while running. Which boxes there are and which moved
// is kept outside of the structures, so a change rebuilds the structure and nothing else: no pair is lost or
// doubled.
//
// The rule comes from tests/bench/broadphase_bench.cpp:
// - up to some dozens of boxes nothing beats testing them all;
// - beyond, the hierarchical grid is the fastest for all distributions of places and sizes, and when few
// boxes move.
#include <sstream>

#include "physics/broadphase/pair_finder.h"

namespace skerry {

namespace {

/// Brute force tests each pair in about 0.4 ns, the grid takes about 30 ns a box: equal at some 100 boxes.
/// The two limits differ so that a count that goes up and down does not rebuild every time.
constexpr std::size_t kGridFrom = 96;
constexpr std::size_t kBruteForceUpTo = 64;

class Auto final : public PairFinder {
 public:
  explicit Auto(const BroadPhaseOptions& options) : options_(options), finder_(make_brute_force(options)) {}

  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats& stats) override {
    size_ = boxes.size();
    const bool wants_grid = uses_grid_ ? size_ > kBruteForceUpTo : size_ >= kGridFrom;
    if (wants_grid == uses_grid_) {
      finder_->synchronise(boxes, dirty, stats);
      return;
    }
    uses_grid_ = wants_grid;
    finder_ = uses_grid_ ? make_hierarchical_grid(options_) : make_brute_force(options_);
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
    std::ostringstream text;
    text << (uses_grid_ ? "hierarchical_grid: " : "brute_force: ") << size_ << " boxes";
    return text.str();
  }
  std::size_t bytes() const override { return finder_->bytes(); }
  void visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const override {
    finder_->visit_structure(boxes, visitor);
  }

 private:
  BroadPhaseOptions options_;
  std::unique_ptr<PairFinder> finder_;
  bool uses_grid_ = false;
  std::size_t size_ = 0;
};

}  // namespace

std::unique_ptr<PairFinder> make_auto(const BroadPhaseOptions& options) {
  return std::make_unique<Auto>(options);
}

}  // namespace skerry
