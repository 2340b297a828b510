// SPDX-License-Identifier: MIT
//
// Manifolds of many contacts: pairs of boxes and discs, and of either with a half-plane, wait until there are
// enough of a kind for the narrow phase to take them together (narrowphase/collide_batch.h).
#pragma once

#include <array>
#include <cstddef>

#include "physics/contact.h"
#include "physics/narrowphase/collide_batch.h"

namespace skerry {

/// Up to `kMost` contacts of one kind of pair on their way through the narrow phase.
class ContactBatch {
 public:
  static constexpr std::size_t kMost = 64;  ///< these contacts fit into the nearest cache

  using Collide = void (*)(const PairArrays&, NarrowPhaseStats*);
  explicit ContactBatch(Collide collide) : collide_(collide) {}

  bool full() const { return count_ == kMost; }

  void add(Contact& contact, const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
           double margin) {
    shape_a_[count_] = &a;
    shape_b_[count_] = &b;
    pose_a_.row[count_] = pose_a;
    pose_b_.row[count_] = pose_b;
    margin_[count_] = margin;
    cache_[count_] = &contact.cache;
    manifold_[count_] = &contact.manifold;
    contact_[count_] = &contact;
    ++count_;
  }

  /// Makes the manifolds, hands each contact to `finish`, in the order in which they came, and is empty then.
  template <class Finish>
  void run(const Skips& skips, NarrowPhaseStats& stats, Finish finish) {
    const std::size_t n = count_;
    if (n == 0) return;
    collide_({{shape_a_.data(), n},
              {shape_b_.data(), n},
              {pose_a_.row, n},
              {pose_b_.row, n},
              {margin_.data(), n},
              {cache_.data(), skips.axes ? n : 0},
              {manifold_.data(), n}},
             &stats);
    count_ = 0;
    for (std::size_t i = 0; i < n; ++i) {
      adopt_manifold(*contact_[i], pose_a_.row[i], pose_b_.row[i], margin_[i]);
      finish(*contact_[i]);
    }
  }

 private:
  template <class T>
  using Row = std::array<T, kMost>;
  // Left as they are: clearing them would cost as much as a small world's step.
  struct Poses {
    union {
      Transform row[kMost];
    };
    Poses() {}  // NOLINT: see above
  };

  Collide collide_;
  std::size_t count_ = 0;
  Row<const Shape*> shape_a_, shape_b_;
  Poses pose_a_, pose_b_;
  Row<double> margin_;
  Row<SatCache*> cache_;
  Row<Manifold*> manifold_;
  Row<Contact*> contact_;
};

/// Refreshes manifolds in any order. @tparam Finish  called with each contact once its manifold is there
template <class Finish>
class ManifoldRefresh {
 public:
  ManifoldRefresh(const Skips& skips, NarrowPhaseStats& stats, Finish finish)
      : skips_(skips), stats_(stats), finish_(finish) {}

  /// As `refresh_manifold`, but the manifold may come later, by `finish` at the latest. The shapes stay where
  /// they are until then. @return false if nothing had to be done
  bool refresh(Contact& contact, const Shape& a, const Transform& pose_a, const Shape& b,
               const Transform& pose_b, double margin) {
    ContactBatch* const batch = batch_of(a, b);
    if (batch == nullptr) {
      const bool made = refresh_manifold(contact, a, pose_a, b, pose_b, margin, skips_, stats_);
      finish_(contact);
      return made;
    }
    if (keep_manifold(contact, a, pose_a, b, pose_b, margin, skips_)) {
      finish_(contact);
      return false;
    }
    batch->add(contact, a, pose_a, b, pose_b, margin);
    if (batch->full()) batch->run(skips_, stats_, finish_);
    return true;
  }
  void finish() {
    boxes_.run(skips_, stats_, finish_);
    discs_.run(skips_, stats_, finish_);
    planes_.run(skips_, stats_, finish_);
    boxes_and_discs_.run(skips_, stats_, finish_);
  }

 private:
  /// Null for pairs that are done one by one.
  ContactBatch* batch_of(const Shape& a, const Shape& b) {
    const bool box_a = a.rectangle.half.x > 0, box_b = b.rectangle.half.x > 0;
    const bool disc_a = a.kind == ShapeKind::Disc, disc_b = b.kind == ShapeKind::Disc;
    if (box_a && box_b) return &boxes_;
    if (disc_a && disc_b) return &discs_;
    if ((box_a && disc_b) || (disc_a && box_b)) return &boxes_and_discs_;
    const bool with_plane = (a.kind == ShapeKind::HalfPlane && (box_b || disc_b)) ||
                            (b.kind == ShapeKind::HalfPlane && (box_a || disc_a));
    return with_plane ? &planes_ : nullptr;
  }

  const Skips& skips_;
  NarrowPhaseStats& stats_;
  Finish finish_;
  ContactBatch boxes_{collide_boxes}, discs_{collide_discs}, planes_{collide_half_planes},
      boxes_and_discs_{collide_boxes_and_discs};
};

}  // namespace skerry
