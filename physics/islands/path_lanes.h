// SPDX-License-Identifier: MIT
//
// Islands in which the rows are a path: row k lies between body k of the path and body k + 1, bodies ascend,
// and no body has a third row (the first body may be the ground). Four bodies at a time, in lanes: what the
// row before a body and the row behind it need of it.
#pragma once

#include <cstring>

#include "physics/islands/island_system.h"
#include "physics/solver/simd.h"

namespace skerry {

/// Whether the first two rows could begin a path in which bodies ascend, so that other islands are known at
/// once.
inline bool may_be_path(const IslandSystem& system) {
  if (system.rows.empty() || !system.compliance.empty()) return false;
  return system.rows.size() == 1 || (system.rows[1].normal < 0 && system.rows[1].a >= system.rows[0].b);
}

/// Whether four bodies at a time are read faster than one.
inline bool lanes_pay(const IslandSystem& system) {
  return system.rows.size() >= 12 && cpu_has_avx2();
}

/// Four bodies of a path, from body `k`.
struct PathLanes {
  Vec4 linear, angular;
  Vec4 ax, ay, aturn;  ///< Ja of the rows behind, k to k + 3
  Vec4 bx, by, bturn;  ///< Jb of the rows before, k - 1 to k + 2
};

/// Reads a path. Rows and bodies beyond its ends are there, too: they can bear no impulse, and the rows move
/// something.
class PathReader {
 public:
  explicit PathReader(const IslandSystem& system)
      : rows_(system.rows.data()), bodies_(system.bodies.data()), count_(system.size()) {}

  /// Whether four bodies from `k` have rows on both sides, all eight.
  bool inside(int k) const { return k > 0 && k + 4 <= count_; }

  /// @return false if the rows before or behind these bodies are no path. Only `inside`.
  SKERRY_ALWAYS_INLINE bool read(int k, PathLanes& to) const {
    const Row* const r = rows_ + k;
    int begin[4];
    bool path = true;
    for (int i = 0; i < 4; ++i) {
      begin[i] = r[i].a;
      path = path && r[i].normal < 0 && r[i].a == r[i - 1].b && r[i].b > r[i].a;
    }
    if (!path) return false;
    gather(r, r + 1, r + 2, r + 3, r - 1, r, r + 1, r + 2, bodies_ + begin[0], bodies_ + begin[1],
           bodies_ + begin[2], bodies_ + begin[3], to);
    return true;
  }

  /// The same for four bodies at an end. @param rows  set to the rows k - 1 to k + 3
  bool read_end(int k, const Row* (&rows)[5], PathLanes& to) const {
    static const Row kNoRow{.Ja = {1, 0, 0}, .Jb = {1, 0, 0}, .upper = 0};
    static const InverseMass kNoBody{1, 1};
    const InverseMass* body[4];
    for (int i = 0; i < 5; ++i) rows[i] = k + i > 0 && k + i <= count_ ? rows_ + (k + i - 1) : &kNoRow;
    for (int i = 0; i < 4; ++i) {
      const Row &before = *rows[i], &behind = *rows[i + 1];
      body[i] = &kNoBody;
      if (k + i < count_) {
        if (behind.normal >= 0 || behind.b <= behind.a || (k + i > 0 && behind.a != before.b)) return false;
        if (behind.a >= 0) body[i] = bodies_ + behind.a;
      } else if (k + i == count_) {
        body[i] = bodies_ + before.b;
      }
    }
    gather(rows[1], rows[2], rows[3], rows[4], rows[0], rows[1], rows[2], rows[3], body[0], body[1], body[2],
           body[3], to);
    if (k == 0 && rows[1]->a < 0) to.ax[0] = to.ay[0] = to.aturn[0] = 0;
    return true;
  }

 private:
  using Pair = double __attribute__((vector_size(16)));

  SKERRY_ALWAYS_INLINE static void pairs(const double* p0, const double* p1, const double* p2,
                                         const double* p3, Vec4& first, Vec4& second) {
    Pair x0, x1, x2, x3;
    std::memcpy(&x0, p0, sizeof(Pair));
    std::memcpy(&x1, p1, sizeof(Pair));
    std::memcpy(&x2, p2, sizeof(Pair));
    std::memcpy(&x3, p3, sizeof(Pair));
    const Vec4 even = __builtin_shufflevector(x0, x2, 0, 1, 2, 3);
    const Vec4 odd = __builtin_shufflevector(x1, x3, 0, 1, 2, 3);
    first = __builtin_shufflevector(even, odd, 0, 4, 2, 6);
    second = __builtin_shufflevector(even, odd, 1, 5, 3, 7);
  }

  SKERRY_ALWAYS_INLINE static void gather(const Row* a0, const Row* a1, const Row* a2, const Row* a3,
                                          const Row* b0, const Row* b1, const Row* b2, const Row* b3,
                                          const InverseMass* m0, const InverseMass* m1, const InverseMass* m2,
                                          const InverseMass* m3, PathLanes& to) {
    pairs(&m0->linear, &m1->linear, &m2->linear, &m3->linear, to.linear, to.angular);
    pairs(a0->Ja.data(), a1->Ja.data(), a2->Ja.data(), a3->Ja.data(), to.ax, to.ay);
    pairs(b0->Jb.data(), b1->Jb.data(), b2->Jb.data(), b3->Jb.data(), to.bx, to.by);
    to.aturn = Vec4{a0->Ja[2], a1->Ja[2], a2->Ja[2], a3->Ja[2]};
    to.bturn = Vec4{b0->Jb[2], b1->Jb[2], b2->Jb[2], b3->Jb[2]};
  }

  const Row* rows_;
  const InverseMass* bodies_;
  int count_;
};

}  // namespace skerry
