// SPDX-License-Identifier: MIT
//
// Every box against every other, in packed blocks that the compiler vectorises: the oracle for the rest, and
// the fastest of all for some dozens of boxes.
#include "physics/broadphase/pair_finder.h"

namespace skerry {

namespace {

constexpr std::size_t kBlock = 32;

class BruteForce final : public PairFinder {
 public:
  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats&) override {
    slot_.resize(boxes.limit(), kNoSlot);
    for (const ProxyIndex proxy : dirty) {
      if (boxes.is_present(proxy)) {
        if (slot_[proxy] == kNoSlot) append(proxy);
        write(slot_[proxy], boxes.box(proxy));
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
        for_each_overlap(boxes.box(proxies_[i]), i + 1, stats, [&](ProxyIndex other) {
          if (request.keeps(proxies_[i], other)) out.add(proxies_[i], other);
        });
      }
      return;
    }
    for (const ProxyIndex proxy : boxes.moved()) {
      for_each_overlap(boxes.box(proxy), 0, stats, [&](ProxyIndex other) {
        if (request.reports(proxy, other)) out.add(proxy, other);
      });
    }
  }

  void query(const BoxSet&, const Aabb& region, std::vector<ProxyIndex>& found) const override {
    BroadPhaseStats unused;
    for_each_overlap(region, 0, unused, [&](ProxyIndex proxy) { found.push_back(proxy); });
  }

  std::size_t bytes() const override {
    return (proxies_.capacity() + slot_.capacity()) * sizeof(ProxyIndex) +
           (lower_x_.capacity() + lower_y_.capacity() + upper_x_.capacity() + upper_y_.capacity()) *
               sizeof(double);
  }

  void visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const override {
    for (const ProxyIndex proxy : proxies_) visitor.cell(boxes.box(proxy), 0, 1);
  }

 private:
  static constexpr std::uint32_t kNoSlot = ~std::uint32_t{0};

  void append(ProxyIndex proxy) {
    slot_[proxy] = static_cast<std::uint32_t>(proxies_.size());
    proxies_.push_back(proxy);
    for (std::vector<double>* column : {&lower_x_, &lower_y_, &upper_x_, &upper_y_}) column->emplace_back();
  }
  void erase(ProxyIndex proxy) {
    const std::uint32_t slot = slot_[proxy];
    for (std::vector<double>* column : {&lower_x_, &lower_y_, &upper_x_, &upper_y_}) {
      (*column)[slot] = column->back();
      column->pop_back();
    }
    proxies_[slot] = proxies_.back();
    slot_[proxies_[slot]] = slot;
    proxies_.pop_back();
    slot_[proxy] = kNoSlot;
  }
  void write(std::uint32_t slot, const Aabb& box) {
    lower_x_[slot] = box.lower.x;
    lower_y_[slot] = box.lower.y;
    upper_x_[slot] = box.upper.x;
    upper_y_[slot] = box.upper.y;
  }

  /// Calls `visit` for every box from slot `begin` on that overlaps `box`.
  template <class Visit>
  void for_each_overlap(const Aabb& box, std::size_t begin, BroadPhaseStats& stats, Visit visit) const {
    const std::size_t count = proxies_.size();
    std::uint64_t overlaps = 0;
    std::size_t first = begin;
    // A block has no branches and a fixed length: a few vector instructions.
    for (; first + kBlock <= count; first += kBlock) {
      const double* lx = lower_x_.data() + first;
      const double* ly = lower_y_.data() + first;
      const double* ux = upper_x_.data() + first;
      const double* uy = upper_y_.data() + first;
      std::int64_t hit[kBlock];
      std::int64_t any = 0;
      for (std::size_t k = 0; k < kBlock; ++k) {
        const std::int64_t x = (lx[k] <= box.upper.x ? -1 : 0) & (box.lower.x <= ux[k] ? -1 : 0);
        const std::int64_t y = (ly[k] <= box.upper.y ? -1 : 0) & (box.lower.y <= uy[k] ? -1 : 0);
        hit[k] = x & y;
        any |= hit[k];
      }
      if (any == 0) continue;
      for (std::size_t k = 0; k < kBlock; ++k) {
        if (hit[k] == 0) continue;
        ++overlaps;
        visit(proxies_[first + k]);
      }
    }
    for (; first < count; ++first) {
      const Aabb other{{lower_x_[first], lower_y_[first]}, {upper_x_[first], upper_y_[first]}};
      if (!overlap(box, other)) continue;
      ++overlaps;
      visit(proxies_[first]);
    }
    if (begin < count) {
      stats.box_tests += count - begin;
      stats.false_pairs += count - begin - overlaps;
    }
  }

  std::vector<double> lower_x_, lower_y_, upper_x_, upper_y_;
  std::vector<ProxyIndex> proxies_;  ///< by slot
  std::vector<std::uint32_t> slot_;  ///< by proxy
};

}  // namespace

std::unique_ptr<PairFinder> make_brute_force(const BroadPhaseOptions&) {
  return std::make_unique<BruteForce>();
}

}  // namespace skerry
