// SPDX-License-Identifier: MIT
//
// How deep bodies are in each other, from where an engine says that they are: the same measure for all,
// whatever an engine knows of its contacts. Bodies that share a hinge are left out.
#pragma once

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "physics/narrowphase/collide.h"
#include "tests/bench/scale_scenes.h"

namespace skerry::scale {

class Overlaps {
 public:
  explicit Overlaps(const Scene& scene) {
    for (std::size_t i = 0; i < scene.items.size(); ++i) {
      const Item& item = scene.items[i];
      for (const Part& part : item.parts) {
        const Shape shape = part.half.y > 0
                                ? make_box({2 * part.half.x, 2 * part.half.y}, part.at, part.angle)
                                : make_disc(part.half.x, part.at);
        parts_.push_back({static_cast<int>(i), item.type == BodyType::Dynamic, shape, {}});
      }
    }
    for (const Hinge& hinge : scene.hinges) hinged_.insert(std::minmax(hinge.a, hinge.b));
  }

  /// @param pose  of every item of the scene
  /// @return depth of the deepest overlap [m], >= 0
  double deepest(const std::vector<Transform>& pose) {
    for (Placed& part : parts_)
      part.box = bounding_box(part.shape, pose[static_cast<std::size_t>(part.item)]);
    order_.resize(parts_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = &parts_[i];
    std::sort(order_.begin(), order_.end(),
              [](const Placed* a, const Placed* b) { return a->box.lower.x < b->box.lower.x; });
    double deepest = 0;
    std::vector<const Placed*> open;  // those that the sweep along x has not left
    for (const Placed* part : order_) {
      std::erase_if(open, [&](const Placed* other) { return other->box.upper.x < part->box.lower.x; });
      for (const Placed* other : open) {
        const bool apart = part->box.upper.y < other->box.lower.y || other->box.upper.y < part->box.lower.y;
        if (apart || part->item == other->item || !(part->moves || other->moves)) continue;
        if (hinged_.count(std::minmax(part->item, other->item)) > 0) continue;
        const Manifold manifold = collide(part->shape, pose[static_cast<std::size_t>(part->item)],
                                          other->shape, pose[static_cast<std::size_t>(other->item)], 0);
        for (int k = 0; k < manifold.count; ++k) deepest = std::max(deepest, -manifold.points[k].separation);
      }
      open.push_back(part);
    }
    return deepest;
  }

 private:
  struct Placed {
    int item;
    bool moves;
    Shape shape;
    Aabb box;
  };
  std::vector<Placed> parts_;
  std::vector<const Placed*> order_;
  std::set<std::pair<int, int>> hinged_;
};

}  // namespace skerry::scale
