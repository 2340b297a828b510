// SPDX-License-Identifier: MIT
//
// The shapes of a world. Many of its bodies look alike, and those have one shape between them: a pile of
// thousands of equal boxes looks at a few cache lines, where copies would fill the nearer caches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <utility>

#include "physics/shape.h"

namespace skerry {

/// A shape that others may have, too. It never changes; a new one takes its place.
class SharedShape {
 public:
  /// An empty one, without corners.
  SharedShape() : shape_(std::shared_ptr<const Shape>(), &kEmpty) {}
  explicit SharedShape(Shape shape) : shape_(std::make_shared<const Shape>(std::move(shape))) {}

  const Shape& operator*() const { return *shape_; }
  const Shape* operator->() const { return shape_.get(); }
  operator const Shape&() const { return *shape_; }  // NOLINT: it is one

 private:
  friend class ShapePool;
  static const Shape kEmpty;
  std::shared_ptr<const Shape> shape_;
};

/// Finds a shape that is there already, bit for bit.
class ShapePool {
 public:
  /// Gives `shape` the copy that others have of it, if there is one.
  void share(SharedShape& shape);
  /// Different shapes that somebody has.
  std::size_t size() const;

 private:
  void forget_unused();

  /// By hash of what decides the rest. Of different shapes with one hash the last one is known.
  std::unordered_map<std::uint64_t, std::weak_ptr<const Shape>> known_;
  std::size_t most_ = 64;  ///< with more entries, those that nobody has are looked for
};

}  // namespace skerry
