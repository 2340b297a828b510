// SPDX-License-Identifier: MIT
//
// Dynamic tree of bounding boxes. Leaves hold boxes with a margin, so that a small move changes nothing. A
// leaf that leaves its margin is put in again where it adds the least perimeter, and the path back to the
// root is improved by rotations [Kopta, Ize, Spjut, Brunvand, Davis, Kensler 2012]. When many leave theirs at
// once, all inner boxes are refitted instead, and the tree is rebuilt from medians once its boxes have become
// too large. Pairs of many moved boxes come from one descent of the tree against itself, those of few from a
// query each.
#include <algorithm>
#include <array>
#include <bit>

#include "physics/broadphase/pair_finder.h"

namespace skerry {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
/// Margin of a leaf relative to the box's extent: a tenth is a typical move of a fast body in one step.
constexpr double kMargin = 0.15;
/// The tree is rebuilt when the sum of its perimeters has grown by this factor.
constexpr double kWorn = 1.4;

struct Node {
  Aabb box;
  std::uint32_t parent = kNone;
  std::uint32_t child[2] = {kNone, kNone};
  ProxyIndex proxy = kNone;  ///< of a leaf
  int height = 0;

  bool is_leaf() const { return child[0] == kNone; }
};

double perimeter(const Aabb& box) {
  return (box.upper.x - box.lower.x) + (box.upper.y - box.lower.y);
}

constexpr bool encloses(const Aabb& outer, const Aabb& inner) {
  return outer.lower.x <= inner.lower.x && outer.lower.y <= inner.lower.y && inner.upper.x <= outer.upper.x &&
         inner.upper.y <= outer.upper.y;
}

Aabb with_margin(const Aabb& box) {
  return grown(box, kMargin * std::max(box.upper.x - box.lower.x, box.upper.y - box.lower.y));
}

class AabbTree final : public PairFinder {
 public:
  void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty, BroadPhaseStats&) override {
    leaf_of_.resize(boxes.limit(), kNone);
    left_.clear();
    std::size_t fresh = 0;
    for (const ProxyIndex proxy : dirty) {
      const std::uint32_t leaf = leaf_of_[proxy];
      if (!boxes.is_present(proxy)) {
        if (leaf != kNone) erase(leaf);
      } else if (leaf == kNone || !encloses(nodes_[leaf].box, boxes.box(proxy))) {
        fresh += leaf == kNone;
        left_.push_back(proxy);
      }
    }
    if (4 * fresh > boxes.size()) return rebuild(boxes);
    if (fresh == 0 && 8 * left_.size() > boxes.size()) {
      for (const ProxyIndex proxy : left_) nodes_[leaf_of_[proxy]].box = with_margin(boxes.box(proxy));
      if (!(refit() <= kWorn * cost_when_built_)) rebuild(boxes);
      return;
    }
    for (const ProxyIndex proxy : left_) {
      if (leaf_of_[proxy] != kNone) erase(leaf_of_[proxy]);
      insert(proxy, with_margin(boxes.box(proxy)));
    }
    // Boxes at one place can make a list of the tree.
    if (root_ != kNone && nodes_[root_].height > 4 * static_cast<int>(std::bit_width(boxes.size())) + 16)
      rebuild(boxes);
  }

  void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) override {
    PairBuffer& out = parts.front();
    const BoxSet& boxes = request.boxes;
    if (request.all || 4 * boxes.moved().size() > boxes.size()) return find_all(request, out, stats);
    for (const ProxyIndex proxy : boxes.moved()) {
      const Aabb& box = boxes.box(proxy);
      descend([&](const Aabb& outer) { return overlap(outer, box); },
              [&](ProxyIndex other) {
                if (!request.reports(proxy, other)) return;
                ++stats.box_tests;
                if (overlap(box, boxes.box(other))) {
                  out.add(proxy, other);
                } else {
                  ++stats.false_pairs;
                }
              });
    }
  }

  void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const override {
    descend([&](const Aabb& outer) { return overlap(outer, region); },
            [&](ProxyIndex proxy) {
              if (overlap(boxes.box(proxy), region)) found.push_back(proxy);
            });
  }

  void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const override {
    const RayTest test(ray);
    descend([&](const Aabb& outer) { return test.meets(outer); },
            [&](ProxyIndex proxy) {
              if (test.meets(boxes.box(proxy))) found.push_back(proxy);
            });
  }

  std::size_t bytes() const override {
    return nodes_.capacity() * sizeof(Node) +
           (leaf_of_.capacity() + left_.capacity() + free_.capacity() + order_.capacity()) *
               sizeof(std::uint32_t) +
           stack_.capacity() * sizeof(stack_[0]);
  }

  void visit_structure(const BoxSet&, StructureVisitor& visitor) const override {
    if (root_ == kNone) return;
    std::vector<std::uint32_t> counts(nodes_.size(), 1), order{root_};
    for (std::size_t i = 0; i < order.size(); ++i) {
      const Node& node = nodes_[order[i]];
      if (!node.is_leaf()) order.insert(order.end(), {node.child[0], node.child[1]});
    }
    for (auto i = order.rbegin(); i != order.rend(); ++i) {
      const Node& node = nodes_[*i];
      if (!node.is_leaf()) counts[*i] = counts[node.child[0]] + counts[node.child[1]];
      visitor.cell(node.box, node.height, static_cast<int>(counts[*i]));
    }
  }

 private:
  /// Calls `visit(proxy)` for the leaves below boxes that `enter` accepts.
  template <class Enter, class Visit>
  void descend(Enter enter, Visit visit) const {
    if (root_ == kNone) return;
    std::vector<std::uint32_t>& stack = descent_;
    stack.assign(1, root_);
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      stack.pop_back();
      if (!enter(node.box)) continue;
      if (node.is_leaf()) {
        visit(node.proxy);
      } else {
        stack.push_back(node.child[0]);
        stack.push_back(node.child[1]);
      }
    }
  }

  /// The tree against itself: two different nodes with a common point are opened, the larger one first.
  void find_all(const PairRequest& request, PairBuffer& out, BroadPhaseStats& stats) {
    if (root_ == kNone) return;
    stack_.assign(1, {root_, root_});
    while (!stack_.empty()) {
      const auto [i, j] = stack_.back();
      stack_.pop_back();
      const Node &a = nodes_[i], &b = nodes_[j];
      if (i == j) {
        if (a.is_leaf()) continue;
        stack_.push_back({a.child[0], a.child[0]});
        stack_.push_back({a.child[1], a.child[1]});
        push_if_meeting(a.child[0], a.child[1]);
      } else if (a.is_leaf() && b.is_leaf()) {
        if (!request.keeps(a.proxy, b.proxy)) continue;
        ++stats.box_tests;
        if (overlap(request.boxes.box(a.proxy), request.boxes.box(b.proxy))) {
          out.add(a.proxy, b.proxy);
        } else {
          ++stats.false_pairs;
        }
      } else {
        const bool opens_a = b.is_leaf() || (!a.is_leaf() && perimeter(a.box) >= perimeter(b.box));
        const Node& opened = opens_a ? a : b;
        for (const std::uint32_t child : opened.child) push_if_meeting(child, opens_a ? j : i);
      }
    }
  }
  void push_if_meeting(std::uint32_t i, std::uint32_t j) {
    if (overlap(nodes_[i].box, nodes_[j].box)) stack_.push_back({i, j});
  }

  std::uint32_t new_node() {
    if (free_.empty()) {
      nodes_.emplace_back();
      return static_cast<std::uint32_t>(nodes_.size() - 1);
    }
    const std::uint32_t n = free_.back();
    free_.pop_back();
    nodes_[n] = Node{};
    return n;
  }

  void update_from_children(std::uint32_t n) {
    Node& node = nodes_[n];
    const Node &a = nodes_[node.child[0]], &b = nodes_[node.child[1]];
    node.box = united(a.box, b.box);
    node.height = 1 + std::max(a.height, b.height);
  }

  void replace_child(std::uint32_t parent, std::uint32_t old, std::uint32_t fresh) {
    if (parent == kNone) {
      root_ = fresh;
    } else {
      nodes_[parent].child[nodes_[parent].child[1] == old ? 1 : 0] = fresh;
    }
    nodes_[fresh].parent = parent;
  }

  /// Puts a leaf beside the node where the perimeters grow least, found by a greedy descent.
  void insert(ProxyIndex proxy, const Aabb& box) {
    const std::uint32_t leaf = new_node();
    nodes_[leaf].box = box;
    nodes_[leaf].proxy = proxy;
    leaf_of_[proxy] = leaf;
    if (root_ == kNone) {
      root_ = leaf;
      return;
    }
    std::uint32_t at = root_;
    while (!nodes_[at].is_leaf()) {
      // Here: a new parent. Below: this box grows, and so does the child that is entered.
      const double here = perimeter(united(nodes_[at].box, box));
      const double inherited = here - perimeter(nodes_[at].box);
      double below[2];
      for (const int side : {0, 1}) {
        const Node& child = nodes_[nodes_[at].child[side]];
        const double joined = perimeter(united(child.box, box));
        below[side] = inherited + (child.is_leaf() ? joined : joined - perimeter(child.box));
      }
      if (here <= std::min(below[0], below[1])) break;
      at = nodes_[at].child[below[1] < below[0] ? 1 : 0];
    }
    const std::uint32_t parent = new_node();
    replace_child(nodes_[at].parent, at, parent);
    nodes_[parent].child[0] = at;
    nodes_[parent].child[1] = leaf;
    nodes_[at].parent = nodes_[leaf].parent = parent;
    improve_upwards(parent);
  }

  void erase(std::uint32_t leaf) {
    leaf_of_[nodes_[leaf].proxy] = kNone;
    const std::uint32_t parent = nodes_[leaf].parent;
    free_.push_back(leaf);
    if (parent == kNone) {
      root_ = kNone;
      return;
    }
    const std::uint32_t sibling = nodes_[parent].child[nodes_[parent].child[0] == leaf ? 1 : 0];
    const std::uint32_t above = nodes_[parent].parent;
    replace_child(above, parent, sibling);
    free_.push_back(parent);
    for (std::uint32_t n = above; n != kNone; n = nodes_[n].parent) update_from_children(n);
  }

  void improve_upwards(std::uint32_t n) {
    for (; n != kNone; n = nodes_[n].parent) {
      rotate(n);
      update_from_children(n);
    }
  }

  /// Swaps a child of `n` with a grandchild on the other side where that shrinks the other child most.
  void rotate(std::uint32_t n) {
    double best = 0;
    int best_side = -1, best_grandchild = 0;
    for (const int side : {0, 1}) {
      const Node& moved = nodes_[nodes_[n].child[side]];
      const Node& other = nodes_[nodes_[n].child[1 - side]];
      if (other.is_leaf()) continue;
      for (const int g : {0, 1}) {
        // Grandchild g goes up; `moved` takes its place beside the other grandchild.
        const Aabb joined = united(nodes_[other.child[1 - g]].box, moved.box);
        const double gain = perimeter(other.box) - perimeter(joined);
        if (gain > best) {
          best = gain;
          best_side = side;
          best_grandchild = g;
        }
      }
    }
    if (best_side < 0) return;
    const std::uint32_t moved = nodes_[n].child[best_side], other = nodes_[n].child[1 - best_side];
    const std::uint32_t grandchild = nodes_[other].child[best_grandchild];
    nodes_[n].child[best_side] = grandchild;
    nodes_[grandchild].parent = n;
    nodes_[other].child[best_grandchild] = moved;
    nodes_[moved].parent = other;
    update_from_children(other);
  }

  /// Recomputes all inner boxes. @return the sum of their perimeters
  double refit() {
    order_.assign(1, root_);
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const Node& node = nodes_[order_[i]];
      if (!node.is_leaf()) order_.insert(order_.end(), {node.child[0], node.child[1]});
    }
    double cost = 0;
    for (auto i = order_.rbegin(); i != order_.rend(); ++i) {
      if (nodes_[*i].is_leaf()) continue;
      update_from_children(*i);
      cost += perimeter(nodes_[*i].box);
    }
    return cost;
  }

  /// Builds the tree from the top, each time at the median of the centres along the longer side.
  void rebuild(const BoxSet& boxes) {
    struct Item {
      Vec2 centre;
      ProxyIndex proxy;
    };
    struct Task {
      std::size_t begin, end;
      std::uint32_t parent;
      int side;
    };
    std::vector<Item> items;
    for (ProxyIndex p = 0; p < boxes.limit(); ++p) {
      if (!boxes.is_present(p)) continue;
      const Aabb& b = boxes.box(p);
      items.push_back({0.5 * b.lower + 0.5 * b.upper, p});
    }
    nodes_.clear();
    free_.clear();
    root_ = kNone;
    if (items.empty()) return;
    std::vector<Task> tasks{{0, items.size(), kNone, 0}};
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      const std::uint32_t n = new_node();
      nodes_[n].parent = task.parent;
      (task.parent == kNone ? root_ : nodes_[task.parent].child[task.side]) = n;
      if (task.end - task.begin == 1) {
        const ProxyIndex proxy = items[task.begin].proxy;
        nodes_[n].proxy = proxy;
        nodes_[n].box = with_margin(boxes.box(proxy));
        leaf_of_[proxy] = n;
        continue;
      }
      Aabb centres{items[task.begin].centre, items[task.begin].centre};
      for (std::size_t i = task.begin; i < task.end; ++i) {
        centres = united(centres, {items[i].centre, items[i].centre});
      }
      const bool along_x = centres.upper.x - centres.lower.x >= centres.upper.y - centres.lower.y;
      const std::size_t middle = task.begin + (task.end - task.begin) / 2;
      const auto at = [&](std::size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); };
      std::nth_element(at(task.begin), at(middle), at(task.end), [&](const Item& a, const Item& b) {
        return along_x ? a.centre.x < b.centre.x : a.centre.y < b.centre.y;
      });
      tasks.push_back({middle, task.end, n, 1});
      tasks.push_back({task.begin, middle, n, 0});
    }
    cost_when_built_ = refit();
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> free_;
  std::uint32_t root_ = kNone;
  std::vector<std::uint32_t> leaf_of_;  ///< by proxy
  double cost_when_built_ = 0;
  std::vector<ProxyIndex> left_;  ///< scratch: boxes that are new or left their margin
  std::vector<std::uint32_t> order_;
  std::vector<std::array<std::uint32_t, 2>> stack_;
  mutable std::vector<std::uint32_t> descent_;
};

}  // namespace

std::unique_ptr<PairFinder> make_aabb_tree(const BroadPhaseOptions&) {
  return std::make_unique<AabbTree>();
}

}  // namespace skerry
