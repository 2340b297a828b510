// SPDX-License-Identifier: MIT
//
// The boxes of a broad phase, with what all implementations share: validation, kinds, and the marks "moved
// since the last pair report" and "changed since the structure was last brought up to date".
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/broadphase/broadphase.h"

namespace skerry {

/// Boxes by proxy number. Memory is in proportion to the largest number in use.
class BoxSet {
 public:
  /// Numbers at or above this are refused: two bits of a 32-bit word are kept for marks.
  static constexpr ProxyIndex kMaxProxies = 1u << 30;

  /// Adds a box and marks it as moved. @throws std::invalid_argument as `BroadPhase::insert`.
  void insert(ProxyIndex proxy, const Aabb& box, ProxyKind kind);
  /// Removes a box. @throws std::invalid_argument if `proxy` is not present.
  void remove(ProxyIndex proxy);
  /// Changes boxes and marks them as moved; all are checked first. @throws std::invalid_argument
  void update(std::span<const BoxUpdate> moved);

  std::size_t size() const { return size_; }
  /// How many of them are fixed.
  std::size_t fixed_count() const { return fixed_count_; }
  /// One more than the largest number that was ever used.
  ProxyIndex limit() const { return static_cast<ProxyIndex>(boxes_.size()); }
  bool is_present(ProxyIndex proxy) const { return proxy < limit() && (state_[proxy] & kPresent) != 0; }
  bool is_fixed(ProxyIndex proxy) const { return (state_[proxy] & kFixed) != 0; }
  /// The same with less to look up, for a loop over many.
  class View {
   public:
    explicit View(const BoxSet& set) : boxes_(set.boxes_.data()), state_(set.state_.data()) {}
    const Aabb& box(ProxyIndex proxy) const { return boxes_[proxy]; }
    /// True if the proxy, below `limit`, is present and not fixed.
    bool is_moving(ProxyIndex proxy) const { return (state_[proxy] & (kPresent | kFixed)) == kPresent; }

   private:
    const Aabb* boxes_;
    const std::uint8_t* state_;
  };
  bool is_moved(ProxyIndex proxy) const { return (state_[proxy] & kMoved) != 0; }
  /// The box of a proxy that is present.
  const Aabb& box(ProxyIndex proxy) const { return boxes_[proxy]; }

  /// Proxies that are present and moved, each once, in the order of their first move.
  std::span<const ProxyIndex> moved() const { return moved_; }
  /// Drops removed proxies from `moved()`; to be called before it is read.
  void tidy_moved();
  /// Forgets which boxes moved.
  void clear_moved();

  /// Proxies that were inserted, changed or removed since `clear_dirty`, each once.
  std::span<const ProxyIndex> dirty() const { return dirty_; }
  void clear_dirty();

  /// Grows with every change of the boxes or the marks.
  std::uint64_t version() const { return version_; }
  /// Grows with every insertion and removal.
  std::uint64_t membership() const { return membership_; }
  std::size_t bytes() const;

 private:
  enum : std::uint8_t { kPresent = 1, kFixed = 2, kMoved = 4, kMovedListed = 8, kDirty = 16 };
  void mark(ProxyIndex proxy);

  std::vector<Aabb> boxes_;
  std::vector<std::uint8_t> state_;
  std::vector<ProxyIndex> moved_;
  std::vector<ProxyIndex> dirty_;
  std::size_t size_ = 0;
  std::size_t fixed_count_ = 0;
  std::size_t removed_moved_ = 0;
  std::uint64_t version_ = 0;
  std::uint64_t membership_ = 0;
};

/// Tests boxes against one ray: the slab test within the ray's bounds, with one formula for all
/// implementations. It is monotone in the box even after rounding, so a box around a met box is met as well.
class RayTest {
 public:
  explicit RayTest(const Ray& ray);
  bool meets(const Aabb& box) const;
  /// A box that contains the ray and overlaps all that it meets; may be unbounded.
  const Aabb& bounds() const { return bounds_; }

 private:
  Ray ray_;
  Aabb bounds_;
};

}  // namespace skerry
