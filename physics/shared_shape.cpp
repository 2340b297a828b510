// SPDX-License-Identifier: MIT
#include "physics/shared_shape.h"

#include <algorithm>
#include <bit>

#include "physics/hash.h"

namespace skerry {

const Shape SharedShape::kEmpty{};

namespace {

// Zeros of either sign are equal, but what is computed from them need not be.
bool same_bits(double x, double y) {
  return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
}

bool same_bits(Vec2 x, Vec2 y) {
  return same_bits(x.x, y.x) && same_bits(x.y, y.y);
}

bool same_bits(const std::vector<Vec2>& x, const std::vector<Vec2>& y) {
  return std::equal(x.begin(), x.end(), y.begin(), y.end(), [](Vec2 a, Vec2 b) { return same_bits(a, b); });
}

bool same_bits(const Shape& x, const Shape& y) {
  return x.kind == y.kind && same_bits(x.radius, y.radius) && same_bits(x.vertices, y.vertices) &&
         same_bits(x.normals, y.normals) && x.closed == y.closed && same_bits(x.tree, y.tree) &&
         same_bits(x.rectangle.middle, y.rectangle.middle) && same_bits(x.rectangle.half, y.rectangle.half);
}

/// Of what decides all the rest.
std::uint64_t hash_of(const Shape& shape) {
  Fnv1a hash;
  hash.add(std::uint64_t{static_cast<std::uint8_t>(shape.kind)} << 1 | shape.closed);
  hash.add(shape.radius);
  for (const Vec2 v : shape.vertices) {
    hash.add(v.x);
    hash.add(v.y);
  }
  return hash.value();
}

}  // namespace

void ShapePool::share(SharedShape& shape) {
  std::weak_ptr<const Shape>& known = known_[hash_of(*shape)];
  std::shared_ptr<const Shape> other = known.lock();
  if (other && same_bits(*other, *shape)) {
    shape.shape_ = std::move(other);
    return;
  }
  known = shape.shape_;
  if (known_.size() > most_) forget_unused();
}

void ShapePool::forget_unused() {
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  most_ = std::max<std::size_t>(64, 2 * known_.size());
}

std::size_t ShapePool::size() const {
  return static_cast<std::size_t>(
      std::count_if(known_.begin(), known_.end(), [](const auto& entry) { return !entry.second.expired(); }));
}

}  // namespace skerry
