// SPDX-License-Identifier: MIT
//
// Every box against every other, four numbers in one comparison: the oracle for the rest, and the fastest of
// all for some dozens of boxes. Boxes are compared in single precision and, where that leaves a doubt, in
// double.
#include "physics/broadphase/float_box.h"
#include "physics/broadphase/pair_finder.h"

namespace skerry {

namespace {

class BruteForce final : public PairFinder {
 public:
  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats&) override {
    slot_.resize(boxes.limit(), kNoSlot);
    for (const ProxyIndex proxy : dirty) {
      if (boxes.is_present(proxy)) {
        if (slot_[proxy] == kNoSlot) append(proxy);
        store(packed_[slot_[proxy]], boxes.box(proxy), kOrigin);
      } else if (slot_[proxy] != kNoSlot) {
        erase(proxy);
      }
    }
  }

  void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) override {
    PairBuffer& out = parts.front();
    const BoxSet& boxes = request.boxes;
    if (request.all || boxes.moved().size() == boxes.size()) {
      // Each box against those after it.
      for (std::size_t i = 0; i < proxies_.size(); ++i) {
        for_each_overlap(boxes, boxes.box(proxies_[i]), i + 1, stats, [&](ProxyIndex other) {
          if (request.keeps(proxies_[i], other)) out.add(proxies_[i], other);
        });
      }
      return;
    }
    for (const ProxyIndex proxy : boxes.moved()) {
      for_each_overlap(boxes, boxes.box(proxy), 0, stats, [&](ProxyIndex other) {
        if (request.reports(proxy, other)) out.add(proxy, other);
      });
    }
  }

  void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const override {
    BroadPhaseStats unused;
    for_each_overlap(boxes, region, 0, unused, [&](ProxyIndex proxy) { found.push_back(proxy); });
  }

  std::size_t bytes() const override {
    return (proxies_.capacity() + slot_.capacity()) * sizeof(ProxyIndex) +
           packed_.capacity() * sizeof(FloatBox);
  }

  void visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const override {
    for (const ProxyIndex proxy : proxies_) visitor.cell(boxes.box(proxy), 0, 1);
  }

 private:
  static constexpr std::uint32_t kNoSlot = ~std::uint32_t{0};
  static constexpr Vec2 kOrigin{};

  void append(ProxyIndex proxy) {
    slot_[proxy] = static_cast<std::uint32_t>(proxies_.size());
    proxies_.push_back(proxy);
    packed_.emplace_back();
  }
  void erase(ProxyIndex proxy) {
    const std::uint32_t slot = slot_[proxy];
    packed_[slot] = packed_.back();
    packed_.pop_back();
    proxies_[slot] = proxies_.back();
    slot_[proxies_[slot]] = slot;
    proxies_.pop_back();
    slot_[proxy] = kNoSlot;
  }

  /// Calls `visit` for every box from slot `begin` on that overlaps `box`.
  template <class Visit>
  void for_each_overlap(const BoxSet& boxes, const Aabb& box, std::size_t begin, BroadPhaseStats& stats,
                        Visit visit) const {
    const FloatLimits limits(box, kOrigin);
    const std::size_t count = proxies_.size();
    std::uint64_t overlaps = 0;
    for (std::size_t slot = begin; slot < count; ++slot) {
      const FloatOverlap found = limits.compare(packed_[slot]);
      if (!found.maybe) continue;
      if (!found.certain && !overlap(box, boxes.box(proxies_[slot]))) continue;
      ++overlaps;
      visit(proxies_[slot]);
    }
    if (begin < count) {
      stats.box_tests += count - begin;
      stats.false_pairs += count - begin - overlaps;
    }
  }

  std::vector<FloatBox> packed_;     ///< by slot
  std::vector<ProxyIndex> proxies_;  ///< by slot
  std::vector<std::uint32_t> slot_;  ///< by proxy
};

}  // namespace

std::unique_ptr<PairFinder> make_brute_force(const BroadPhaseOptions&) {
  return std::make_unique<BruteForce>();
}

}  // namespace skerry
