// SPDX-License-Identifier: MIT
//
// A grid of equal cells without bounds: cells are found by hashing, and each holds a list of the boxes that
// it meets. Two traversals find the pairs: by cell, where the bodies outnumber the cells in use, and by body
// otherwise or when only few bodies moved [Ericson 2005, sec. 7.1]. A pair that shares several cells is
// reported in the one that contains the lower corner of the common region.
#include <algorithm>
#include <cmath>

#include "physics/broadphase/pair_finder.h"
#include "physics/broadphase/ray_reach.h"

namespace skerry {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
/// Cell coordinates are kept within 30 bits and sign; far cells coincide, which costs time only.
constexpr double kFarCell = 1 << 30;
/// The lists hold at most this many entries a box, so that memory is linear; the cell is enlarged otherwise.
constexpr double kEntriesPerBox = 8;

struct Cell {
  std::int32_t x, y;
  friend bool operator==(Cell, Cell) = default;
};

/// Cells from `first` to `last`, both included.
struct CellRange {
  Cell first, last;
  friend bool operator==(const CellRange&, const CellRange&) = default;
  double count() const { return (double(last.x) - first.x + 1) * (double(last.y) - first.y + 1); }
};

class UniformGrid final : public PairFinder {
 public:
  explicit UniformGrid(const BroadPhaseOptions& options) : wish_(options.cell_size) {}

  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats&) override {
    ranges_.resize(boxes.limit(), CellRange{});
    listed_.resize(boxes.limit(), 0);
    const bool size_changed = boxes.size() > 2 * size_at_rebuild_ || 4 * boxes.size() < size_at_rebuild_;
    if (size_changed) {
      rebuild(boxes);
      return;
    }
    for (const ProxyIndex proxy : dirty) {
      if (!boxes.is_present(proxy)) {
        unlist(proxy);
        continue;
      }
      world_ = united(world_, boxes.box(proxy));
      const CellRange range = cells_of(boxes.box(proxy));
      if (listed_[proxy] && range == ranges_[proxy]) continue;
      unlist(proxy);
      if (static_cast<double>(entries_) + range.count() > entry_limit(boxes)) {
        rebuild(boxes);
        return;
      }
      list(proxy, range);
    }
  }

  void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) override {
    const BoxSet& boxes = request.boxes;
    const std::size_t wanted = request.all ? boxes.size() : boxes.moved().size();
    if (2 * wanted > boxes.size() && boxes.size() > cells_in_use_) {
      find_by_cell(request, parts.front(), stats);
    } else {
      find_by_body(request, parts.front(), stats);
    }
  }

  void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const override {
    BroadPhaseStats unused;
    for_each_overlap(boxes, region, unused, [&](ProxyIndex proxy) { found.push_back(proxy); });
  }

  /// Row by row along the ray, the cells that it crosses [Amanatides, Woo 1987].
  void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const override {
    if (entries_ == 0) return;
    const RayTest test(ray);
    RayReach reach(ray);
    reach.clip(kAxisX, {world_.lower.x, world_.upper.x});
    reach.clip(kAxisY, {world_.lower.y, world_.upper.y});
    if (reach.is_empty()) return;
    const auto begin = static_cast<std::ptrdiff_t>(found.size());
    const auto look_at = [&](const Node& node) {
      if (test.meets(boxes.box(node.proxy))) found.push_back(node.proxy);
    };
    const Interval x = reach.on(kAxisX), y = reach.on(kAxisY);
    const double pad = cell_ / 64;
    const CellRange range = cells_of({{x.lower - pad, y.lower - pad}, {x.upper + pad, y.upper + pad}});
    const double sides = double(range.last.x) - range.first.x + double(range.last.y) - range.first.y;
    if (2 * sides > static_cast<double>(heads_.size())) {
      // More cells than lists: look at all lists.
      for (const std::uint32_t head : heads_) {
        for (std::uint32_t n = head; n != kNone; n = nodes_[n].next) look_at(nodes_[n]);
      }
    } else {
      for (std::int32_t row = range.first.y; row <= range.last.y; ++row) {
        // Far rows are one.
        const double low = row <= -kFarCell ? -kInfinity : row * cell_ - pad;
        const double high = row >= kFarCell ? kInfinity : (row + 1.0) * cell_ + pad;
        RayReach part = reach;
        part.clip(kAxisY, {low, high});
        if (part.is_empty()) continue;
        const Interval columns = part.on(kAxisX);
        const std::int32_t last = cell_index(columns.upper + pad, inverse_);
        for (std::int32_t column = cell_index(columns.lower - pad, inverse_); column <= last; ++column) {
          for (std::uint32_t n = heads_[bucket({column, row})]; n != kNone; n = nodes_[n].next) {
            if (nodes_[n].cell == Cell{column, row}) look_at(nodes_[n]);
          }
        }
      }
    }
    // A box can be in several of the cells.
    std::sort(found.begin() + begin, found.end());
    found.erase(std::unique(found.begin() + begin, found.end()), found.end());
  }

  std::size_t bytes() const override {
    return heads_.capacity() * sizeof(std::uint32_t) + nodes_.capacity() * sizeof(Node) +
           ranges_.capacity() * sizeof(CellRange) + listed_.capacity();
  }

  void visit_structure(const BoxSet&, StructureVisitor& visitor) const override {
    // A chain may hold several cells; each is shown by its first entry.
    for (const std::uint32_t head : heads_) {
      for (std::uint32_t n = head; n != kNone; n = nodes_[n].next) {
        std::uint32_t before = head;
        while (before != n && nodes_[before].cell != nodes_[n].cell) before = nodes_[before].next;
        if (before != n) continue;
        int count = 0;
        for (std::uint32_t k = n; k != kNone; k = nodes_[k].next) count += nodes_[k].cell == nodes_[n].cell;
        const Vec2 corner{nodes_[n].cell.x * cell_, nodes_[n].cell.y * cell_};
        visitor.cell({corner, corner + Vec2{cell_, cell_}}, 0, count);
      }
    }
  }

 private:
  /// An entry of a cell's list.
  struct Node {
    Cell cell;
    ProxyIndex proxy;
    std::uint32_t next;
  };

  static std::int32_t cell_index(double coordinate, double inverse) {
    const double scaled = std::clamp(coordinate * inverse, -kFarCell, kFarCell);
    const auto truncated = static_cast<std::int32_t>(scaled);
    return truncated - (scaled < truncated ? 1 : 0);
  }
  Cell cell_of(Vec2 point) const { return {cell_index(point.x, inverse_), cell_index(point.y, inverse_)}; }
  CellRange cells_of(const Aabb& box) const { return {cell_of(box.lower), cell_of(box.upper)}; }

  std::size_t bucket(Cell cell) const {
    const std::uint64_t mixed = static_cast<std::uint32_t>(cell.x) * std::uint64_t{0x9E3779B97F4A7C15} ^
                                static_cast<std::uint32_t>(cell.y) * std::uint64_t{0xC2B2AE3D27D4EB4F};
    return static_cast<std::size_t>((mixed ^ (mixed >> 29)) * std::uint64_t{0xBF58476D1CE4E5B9} >> 32) &
           (heads_.size() - 1);
  }

  static double entry_limit(const BoxSet& boxes) {
    return 2 * kEntriesPerBox * static_cast<double>(boxes.size()) + 64;
  }

  /// Chooses the cell: 1.5 times the mean extent, so that an average box meets less than three cells; doubled
  /// while the lists would be too long.
  void choose_cell(const BoxSet& boxes) {
    double sum = 0, count = 0;
    for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
      if (!boxes.is_present(p)) continue;
      const Aabb& box = boxes.box(p);
      sum += std::min(1e300, std::max(box.upper.x - box.lower.x, box.upper.y - box.lower.y)) / 1e6;
      ++count;
    }
    cell_ = wish_ > 0 ? wish_ : 1.5e6 * (sum / std::max(count, 1.0));
    if (!(cell_ > 1e-300)) cell_ = 1;
    cell_ = std::min(cell_, 1e300);
    for (;; cell_ *= 2) {
      inverse_ = 1 / cell_;
      double entries = 0;
      for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
        if (boxes.is_present(p)) entries += cells_of(boxes.box(p)).count();
      }
      if (entries <= kEntriesPerBox * count + 32) return;
    }
  }

  void rebuild(const BoxSet& boxes) {
    choose_cell(boxes);
    std::size_t buckets = 16;
    while (buckets < 2 * boxes.size()) buckets *= 2;
    heads_.assign(buckets, kNone);
    nodes_.clear();
    free_ = kNone;
    entries_ = cells_in_use_ = 0;
    std::fill(listed_.begin(), listed_.end(), std::uint8_t{0});
    world_ = {{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
    for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
      if (!boxes.is_present(p)) continue;
      list(p, cells_of(boxes.box(p)));
      world_ = united(world_, boxes.box(p));
    }
    size_at_rebuild_ = boxes.size();
  }

  template <class Visit>
  static void for_each_cell(const CellRange& range, Visit visit) {
    for (std::int32_t y = range.first.y; y <= range.last.y; ++y) {
      for (std::int32_t x = range.first.x; x <= range.last.x; ++x) visit(Cell{x, y});
    }
  }

  void list(ProxyIndex proxy, const CellRange& range) {
    for_each_cell(range, [&](Cell cell) {
      std::uint32_t& head = heads_[bucket(cell)];
      cells_in_use_ += head == kNone;
      std::uint32_t n = free_;
      if (n == kNone) {
        n = static_cast<std::uint32_t>(nodes_.size());
        nodes_.emplace_back();
      } else {
        free_ = nodes_[n].next;
      }
      nodes_[n] = {cell, proxy, head};
      head = n;
      ++entries_;
    });
    ranges_[proxy] = range;
    listed_[proxy] = 1;
  }

  void unlist(ProxyIndex proxy) {
    if (!listed_[proxy]) return;
    for_each_cell(ranges_[proxy], [&](Cell cell) {
      std::uint32_t& head = heads_[bucket(cell)];
      std::uint32_t* link = &head;
      while (nodes_[*link].proxy != proxy || nodes_[*link].cell != cell) link = &nodes_[*link].next;
      const std::uint32_t n = *link;
      *link = nodes_[n].next;
      nodes_[n].next = free_;
      free_ = n;
      --entries_;
      cells_in_use_ -= head == kNone;
    });
    listed_[proxy] = 0;
  }

  /// True for the one cell in which boxes `a` and `b` are to be compared.
  bool is_home(Cell cell, const Aabb& a, const Aabb& b) const {
    return cell == cell_of({std::max(a.lower.x, b.lower.x), std::max(a.lower.y, b.lower.y)});
  }

  void find_by_cell(const PairRequest& request, PairBuffer& out, BroadPhaseStats& stats) const {
    const BoxSet& boxes = request.boxes;
    for (const std::uint32_t head : heads_) {
      for (std::uint32_t i = head; i != kNone; i = nodes_[i].next) {
        const Node& a = nodes_[i];
        const Aabb& box = boxes.box(a.proxy);
        for (std::uint32_t j = a.next; j != kNone; j = nodes_[j].next) {
          const Node& b = nodes_[j];
          if (a.cell != b.cell) continue;
          ++stats.box_tests;
          if (!overlap(box, boxes.box(b.proxy))) {
            ++stats.false_pairs;
          } else if (is_home(a.cell, box, boxes.box(b.proxy)) && request.keeps(a.proxy, b.proxy)) {
            out.add(a.proxy, b.proxy);
          }
        }
      }
    }
  }

  void find_by_body(const PairRequest& request, PairBuffer& out, BroadPhaseStats& stats) const {
    request.for_each_wanted([&](ProxyIndex proxy) {
      for_each_overlap(request.boxes, request.boxes.box(proxy), stats, [&](ProxyIndex other) {
        if (request.reports(proxy, other)) out.add(proxy, other);
      });
    });
  }

  /// Calls `visit` for every box that overlaps `region`, once.
  template <class Visit>
  void for_each_overlap(const BoxSet& boxes, const Aabb& region, BroadPhaseStats& stats, Visit visit) const {
    if (entries_ == 0) return;
    const auto test = [&](const Node& node) {
      ++stats.box_tests;
      if (!overlap(region, boxes.box(node.proxy))) {
        ++stats.false_pairs;
      } else if (is_home(node.cell, region, boxes.box(node.proxy))) {
        visit(node.proxy);
      }
    };
    const CellRange range = cells_of(region);
    if (range.count() > static_cast<double>(heads_.size())) {
      // A region of more cells than lists: look at all lists.
      for (const std::uint32_t head : heads_) {
        for (std::uint32_t n = head; n != kNone; n = nodes_[n].next) test(nodes_[n]);
      }
      return;
    }
    for_each_cell(range, [&](Cell cell) {
      for (std::uint32_t n = heads_[bucket(cell)]; n != kNone; n = nodes_[n].next) {
        if (nodes_[n].cell == cell) test(nodes_[n]);
      }
    });
  }

  double wish_;
  double cell_ = 1, inverse_ = 1;
  Aabb world_{};                      ///< contains all boxes
  std::vector<std::uint32_t> heads_;  ///< first entry by bucket; a power of two
  std::vector<Node> nodes_;
  std::uint32_t free_ = kNone;
  std::size_t entries_ = 0, cells_in_use_ = 0, size_at_rebuild_ = 0;
  std::vector<CellRange> ranges_;     ///< by proxy: where it is listed
  std::vector<std::uint8_t> listed_;  ///< by proxy
};

}  // namespace

std::unique_ptr<PairFinder> make_uniform_grid(const BroadPhaseOptions& options) {
  return std::make_unique<UniformGrid>(options);
}

}  // namespace skerry
