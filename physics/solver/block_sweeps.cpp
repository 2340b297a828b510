// SPDX-License-Identifier: MIT
#include "physics/solver/block_sweeps.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <thread>

#include "physics/spare.h"

namespace skerry {
namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// Fewer blocks leave too many lanes empty.
constexpr std::size_t kFewBlocks = 12;
// Blocks, or chunks of them, that a thread takes at a time where each is by itself.
constexpr std::size_t kBlocksAPiece = 1024, kChunksAPiece = 4;
// With fewer chunks, sweeps that follow each other are soon done.
constexpr std::size_t kManyChunks = 24;
// Looks at another thread's progress, some 50 us, before this one leaves the processor to others.
constexpr int kPatience = 1000;

/// Chunks that a sweep has done, for the thread that makes the next one to see.
struct alignas(64) Progress {
  std::atomic<int> done = 0;

  void wait_for(int chunks) const {
    for (int i = 0; done.load(std::memory_order_acquire) < chunks; ++i) {
      if (i > kPatience) {
        std::this_thread::yield();
        continue;
      }
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    }
  }
};

double dot3(const BodyVector& x, const BodyVector& y) {
  return (x.v[0] * y.v[0] + x.v[1] * y.v[1]) + x.v[2] * y.v[2];
}

}  // namespace

struct BlockSweeps::Kernels {
  /// Sums of the lanes of four vectors.
  static SKERRY_ALWAYS_INLINE void sums(const Vec4& p, const Vec4& q, const Vec4& r, const Vec4& s,
                                        Vec4& out) {
    const Vec4 pq = __builtin_shufflevector(p, q, 0, 4, 2, 6) + __builtin_shufflevector(p, q, 1, 5, 3, 7);
    const Vec4 rs = __builtin_shufflevector(r, s, 0, 4, 2, 6) + __builtin_shufflevector(r, s, 1, 5, 3, 7);
    out = __builtin_shufflevector(pq, rs, 0, 1, 4, 5) + __builtin_shufflevector(pq, rs, 2, 3, 6, 7);
  }

  static SKERRY_ALWAYS_INLINE double clamp(double z, double lower, double upper) {
    const double low = z > lower ? z : lower;
    return low < upper ? low : upper;
  }

  /// One block; `count` is known to the compiler in the hot cases.
  template <Mode kMode>
  static SKERRY_ALWAYS_INLINE void update(const Block& k, const Bounds& bounds, Pattern pattern, int count,
                                          int ground, const Manner& how, Impulses& impulses, BodyVector* y,
                                          double& largest) {
    const Vec4 ya = y[k.a].v, yb = y[k.b_body].v;
    Vec4 t[kRows] = {};
    for (int r = 0; r < count; ++r) t[r] = k.low[r].v * ya + k.high[r].v * yb;
    Vec4 velocity;
    sums(t[0], t[1], t[2], t[3], velocity);
    const Vec4 z = impulses.v - (velocity - (kMode == Mode::Part ? how.load * k.b : k.b));

    // In the order of the rows, each corrected for the changes before it.
    double next[kRows] = {}, d[kRows] = {};
    int entry = 0;
    for (int r = 0; r < count; ++r) {
      double wanted = z[r];
      for (int c = 0; c < r; ++c) wanted -= k.couple[at(entry++)] * d[c];
      double lower = 0, upper = kInfinity;
      if (pattern == Pattern::Rough && (r & 1) != 0) {
        upper = k.mu[at(r)] * next[r - 1];
        lower = -upper;
      } else if (pattern == Pattern::General) {
        const int n = bounds.normal[at(r)];
        const double bound = n < 0 ? 0 : k.mu[at(r)] * std::max(next[n], 0.0);
        lower = bounds.lower[at(r)] - bound;
        upper = bounds.upper[at(r)] + bound;
      }
      if (kMode == Mode::Give) wanted *= how.contact_give;
      if (kMode == Mode::Part) wanted = how.take * wanted + how.keep * impulses.v[r];
      next[r] = clamp(wanted, lower, upper);
      d[r] = next[r] - impulses.v[r];
    }
    for (int r = 0; r < count; ++r) {
      impulses.v[r] = next[r];
      const double change = std::abs(d[r]) * k.speed[at(r)];
      largest = largest < change ? change : largest;
    }
    Vec4 a = ya, b = yb;
    for (int r = 0; r < count; ++r) {
      a += k.low[r].v * d[r];
      b += k.high[r].v * d[r];
    }
    if (k.a != ground) y[k.a].v = a;
    if (k.b_body != ground) y[k.b_body].v = b;
  }

  /// One block of joint rows.
  template <Mode kMode>
  static SKERRY_ALWAYS_INLINE void update_joint(const Block& k, const JointBlock& joint, const Bounds& bounds,
                                                int ground, const Manner& how, Impulses& impulses,
                                                BodyVector* y, double& largest) {
    const bool held = k.pattern == Pattern::Held;
    Vec4 a = y[k.a].v, b = y[k.b_body].v;
    Vec4 t[kRows] = {};
    for (int r = 0; r < k.count; ++r) t[r] = k.low[r].v * a + k.high[r].v * b;
    Vec4 velocity;
    sums(t[0], t[1], t[2], t[3], velocity);
    double d[kRows] = {};
    int entry = 0;
    for (int r = 0; r < k.count; ++r) {
      const double was = impulses.v[r], aim = kMode == Mode::Part ? how.load * k.b[r] : k.b[r];
      double wanted = (held ? was : joint.keep[at(r)] * was) - (velocity[r] - aim);
      for (int c = 0; c < r && !held; ++c) wanted -= k.couple[at(entry++)] * d[c];
      wanted = kMode == Mode::Part ? how.take * wanted + how.keep * was : how.joint_give * wanted;
      const double next = held ? wanted : clamp(wanted, bounds.lower[at(r)], bounds.upper[at(r)]);
      d[r] = next - was;
      impulses.v[r] = next;
      const double change = std::abs(d[r]) * k.speed[at(r)];
      largest = largest < change ? change : largest;
    }
    for (int r = 0; r < k.count; ++r) {
      a += k.low[r].v * d[r];
      b += k.high[r].v * d[r];
    }
    if (k.a != ground) y[k.a].v = a;
    if (k.b_body != ground) y[k.b_body].v = b;
  }

  /// One block with the shape of its rows known to the compiler.
  template <Mode kMode>
  static SKERRY_ALWAYS_INLINE void update_one(BlockSweeps& s, std::size_t k, const Manner& how,
                                              double& largest) {
    const int ground = static_cast<int>(s.mass_.size()) - 1;
    BodyVector* y = s.velocities_.data();
    const Block& block = s.blocks_[k];
    Impulses& impulses = s.impulses_[k];
    const Bounds& bounds = s.bounds_[k];
    if (block.pattern >= Pattern::Held)
      update_joint<kMode>(block, s.joint_of(k), bounds, ground, how, impulses, y, largest);
    else if (block.pattern == Pattern::Rough && block.count == 4)
      update<kMode>(block, bounds, Pattern::Rough, 4, ground, how, impulses, y, largest);
    else if (block.pattern == Pattern::Rough)
      update<kMode>(block, bounds, Pattern::Rough, 2, ground, how, impulses, y, largest);
    else if (block.pattern == Pattern::Smooth && block.count == 2)
      update<kMode>(block, bounds, Pattern::Smooth, 2, ground, how, impulses, y, largest);
    else if (block.pattern == Pattern::Smooth)
      update<kMode>(block, bounds, Pattern::Smooth, 1, ground, how, impulses, y, largest);
    else
      update<kMode>(block, bounds, Pattern::General, block.count, ground, how, impulses, y, largest);
  }

  /// Vectors of four become numbers of four.
  static SKERRY_ALWAYS_INLINE void transpose(Vec4& p, Vec4& q, Vec4& r, Vec4& s) {
    const Vec4 a = __builtin_shufflevector(p, q, 0, 4, 2, 6), b = __builtin_shufflevector(p, q, 1, 5, 3, 7);
    const Vec4 c = __builtin_shufflevector(r, s, 0, 4, 2, 6), d = __builtin_shufflevector(r, s, 1, 5, 3, 7);
    p = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    q = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    r = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    s = __builtin_shufflevector(b, d, 2, 3, 6, 7);
  }

  /// As `update`, of four blocks: the same operations in the same order, lane by lane.
  template <Mode kMode, int N, Pattern pattern>
  static SKERRY_ALWAYS_INLINE void update_four(const Group<N>& k, const Manner& how, BodyVector* y,
                                               BodyVector* x, Vec4& largest) {
    const Vec4 zero{};
    Vec4 a[4], b[4], was[4];
    for (int i = 0; i < 4; ++i) {
      a[i] = y[k.a[at(i)]].v;
      b[i] = y[k.b_body[at(i)]].v;
      was[i] = x[k.block[at(i)]].v;
    }
    transpose(a[0], a[1], a[2], a[3]);
    transpose(b[0], b[1], b[2], b[3]);
    transpose(was[0], was[1], was[2], was[3]);

    Vec4 next[N], d[N], z[N];
    for (int r = 0; r < N; ++r) {
      Vec4 t[3];
      for (int c = 0; c < 3; ++c) t[c] = k.low[r][c].v * a[c] + k.high[r][c].v * b[c];
      const Vec4 velocity = (t[0] + t[1]) + (t[2] + zero);
      z[r] = was[r] - (velocity - (kMode == Mode::Part ? how.load * k.b[r].v : k.b[r].v));
    }
    int entry = 0;
    for (int r = 0; r < N; ++r) {
      Vec4 wanted = z[r];
      for (int c = 0; c < r && pattern != Pattern::Held; ++c) wanted -= k.couple[entry++].v * d[c];
      if (kMode == Mode::Give && pattern != Pattern::Held) wanted *= how.contact_give;
      if (kMode == Mode::Part) wanted = how.take * wanted + how.keep * was[r];
      if (pattern == Pattern::Held) {
        next[r] = kMode == Mode::Part ? wanted : how.joint_give * wanted;
      } else if (pattern == Pattern::Rough && r % 2 == 1) {
        const Vec4 upper = k.mu[r].v * next[r - 1], lower = -upper;
        const Vec4 low = wanted > lower ? wanted : lower;
        next[r] = low < upper ? low : upper;
      } else {
        next[r] = wanted > zero ? wanted : zero;
      }
      d[r] = next[r] - was[r];
    }
    for (int r = 0; r < N; ++r) {
      const Vec4 change = (d[r] < zero ? -d[r] : d[r]) * k.speed[r].v;
      largest = largest < change ? change : largest;
      was[r] = next[r];
      for (int c = 0; c < 3; ++c) {
        a[c] += k.low[r][c].v * d[r];
        b[c] += k.high[r][c].v * d[r];
      }
    }
    transpose(a[0], a[1], a[2], a[3]);
    transpose(b[0], b[1], b[2], b[3]);
    transpose(was[0], was[1], was[2], was[3]);
    for (int i = 0; i < 4; ++i) {
      y[k.to_a[at(i)]].v = a[i];
      y[k.to_b[at(i)]].v = b[i];
      x[k.block[at(i)]].v = was[i];
    }
  }

  /// What a sweep does with four blocks, and with one.
  template <Mode kMode>
  struct Update {
    Manner how;
    template <int N, Pattern pattern>
    SKERRY_ALWAYS_INLINE void four(BlockSweeps& s, const Group<N>& group, Vec4& largest) const {
      update_four<kMode, N, pattern>(group, how, s.velocities_.data(), s.impulses_.data(), largest);
    }
    SKERRY_ALWAYS_INLINE void one(BlockSweeps& s, std::size_t k, double& largest) const {
      update_one<kMode>(s, k, how, largest);
    }
  };

  template <int N, Pattern pattern, class Task, class Sweeps>
  static SKERRY_ALWAYS_INLINE void visit_groups(const Task& task, Sweeps& s,
                                                const std::vector<Group<N>>& groups, const Batch& batch,
                                                Vec4& largest) {
    for (int g = batch.first; g < batch.first + batch.count; ++g)
      task.template four<N, pattern>(s, groups[at(g)], largest);
  }

  /// Goes over some chunks, or where there are none over all blocks, in an order that gives the bits of one
  /// after the other. @return the largest number that the task found
  template <class Task, class Sweeps>
  static SKERRY_ALWAYS_INLINE double visit(const Task& task, Sweeps& s, std::size_t chunk, std::size_t end) {
    if (s.chunks_.empty()) {
      double largest = 0;
      for (std::size_t k = 0; k < s.blocks_.size(); ++k) task.one(s, k, largest);
      return largest;
    }
    double largest = 0;
    Vec4 four{};
    for (int i = s.chunks_[chunk].first; i < s.chunks_[end - 1].end; ++i) {
      const Batch& batch = s.batches_[at(i)];
      switch (batch.kind) {
        case Kind::Rough4:
          visit_groups<4, Pattern::Rough>(task, s, s.groups4_, batch, four);
          break;
        case Kind::Rough2:
          visit_groups<2, Pattern::Rough>(task, s, s.groups2_, batch, four);
          break;
        case Kind::Smooth2:
          visit_groups<2, Pattern::Smooth>(task, s, s.groups2_, batch, four);
          break;
        case Kind::Smooth1:
          visit_groups<1, Pattern::Smooth>(task, s, s.groups1_, batch, four);
          break;
        case Kind::Held3:
          visit_groups<3, Pattern::Held>(task, s, s.groups3_, batch, four);
          break;
        case Kind::Held2:
          visit_groups<2, Pattern::Held>(task, s, s.groups2_, batch, four);
          break;
        case Kind::Held1:
          visit_groups<1, Pattern::Held>(task, s, s.groups1_, batch, four);
          break;
        case Kind::Single:
          for (int g = batch.first; g < batch.first + batch.count; ++g) {
            const SweepOrder::Group& group = s.order_.groups()[at(g)];
            for (int k = 0; k < group.count; ++k) task.one(s, at(group.block[at(k)]), largest);
          }
          break;
      }
    }
    for (int i = 0; i < 4; ++i) largest = std::max(largest, four[i]);
    return largest;
  }

  template <Mode kMode>
  static double sweep_portable(BlockSweeps& s, const Manner& how, std::size_t from, std::size_t to) {
    return visit(Update<kMode>{how}, s, from, to);
  }
  template <Mode kMode>
  SKERRY_AVX2 static double sweep_avx2(BlockSweeps& s, const Manner& how, std::size_t from, std::size_t to) {
    return visit(Update<kMode>{how}, s, from, to);
  }

  /// Fills in the numbers of a block.
  static SKERRY_ALWAYS_INLINE void close(BlockSweeps& s, const IslandSystem& system, std::size_t k) {
    Block& block = s.blocks_[k];
    Bounds& bounds = s.bounds_[k];
    const int first = s.first_[k];
    bool contact = true, rough = block.count % 2 == 0;
    block.b = Vec4{};
    for (int r = 0; r < block.count; ++r) {
      const Row& row = system.rows[at(first + r)];
      const BodyVector low{Vec4{row.Ja[0], row.Ja[1], row.Ja[2], 0} * s.mass_[at(block.a)].v};
      const BodyVector high{Vec4{row.Jb[0], row.Jb[1], row.Jb[2], 0} * s.mass_[at(block.b_body)].v};
      const double D = dot3(low, low) + dot3(high, high);
      const double root = std::sqrt(D), inverse = D > 0 ? 1 / root : 0;
      s.root_[at(first + r)] = root;
      block.speed[at(r)] = root;
      block.low[r].v = inverse * low.v;
      block.high[r].v = inverse * high.v;
      block.b[r] = inverse * system.b[at(first + r)];
      const int n = bounds.normal[at(r)];
      if (n >= 0) {
        const double normal_root = s.root_[at(first + n)];
        block.mu[at(r)] = normal_root > 0 ? row.mu * root / normal_root : 0;
        rough = rough && r % 2 == 1 && n == r - 1;
      } else {
        // What nothing moves stays at zero.
        bounds.lower[at(r)] = D > 0 ? root * row.lower : 0;
        bounds.upper[at(r)] = D > 0 ? root * row.upper : 0;
        rough = rough && r % 2 == 0;
        contact = contact && row.lower == 0 && row.upper == kInfinity && D > 0;
      }
    }
    const bool smooth = block.count <= 2 && bounds.normal[0] < 0 && bounds.normal[1] < 0;
    if (contact && rough)
      block.pattern = Pattern::Rough;
    else if (contact && smooth)
      block.pattern = Pattern::Smooth;
    std::size_t entry = 0;
    for (int r = 1; r < block.count; ++r) {
      for (int c = 0; c < r; ++c)
        block.couple[entry++] = dot3(block.low[r], block.low[c]) + dot3(block.high[r], block.high[c]);
    }
  }

  static SKERRY_ALWAYS_INLINE void close_some(BlockSweeps& s, const IslandSystem& system, std::size_t from,
                                              std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      if (s.first_[k] >= 0) close(s, system, k);
    }
  }
  static void close_portable(BlockSweeps& s, const IslandSystem& system, std::size_t from, std::size_t to) {
    close_some(s, system, from, to);
  }
  SKERRY_AVX2 static void close_avx2(BlockSweeps& s, const IslandSystem& system, std::size_t from,
                                     std::size_t to) {
    close_some(s, system, from, to);
  }

  /// The largest violation, of four blocks and of one.
  struct Violation {
    template <int N, Pattern pattern>
    static SKERRY_ALWAYS_INLINE void four(const BlockSweeps& s, const Group<N>& k, Vec4& worst) {
      const Vec4 zero{};
      Vec4 a[4], b[4], x[4];
      for (int i = 0; i < 4; ++i) {
        a[i] = s.velocities_[at(k.a[at(i)])].v;
        b[i] = s.velocities_[at(k.b_body[at(i)])].v;
        x[i] = s.impulses_[at(k.block[at(i)])].v;
      }
      transpose(a[0], a[1], a[2], a[3]);
      transpose(b[0], b[1], b[2], b[3]);
      transpose(x[0], x[1], x[2], x[3]);
      Vec4 found[N];
      int entry = 0;
      for (int r = 0; r < N; ++r) {
        const Vec4 low = (k.low[r][0].v * a[0] + k.low[r][1].v * a[1]) + k.low[r][2].v * a[2];
        const Vec4 high = (k.high[r][0].v * b[0] + k.high[r][1].v * b[1]) + k.high[r][2].v * b[2];
        const Vec4 w = low + high - k.b[r].v;
        found[r] = w;
        Vec4 inside;
        if (pattern == Pattern::Held) {
          // The row before it was combined with the others.
          inside = k.mu[r].v * w;
          for (int c = 0; c < r; ++c) inside += k.couple[entry++].v * found[c];
        } else if (pattern == Pattern::Rough && r % 2 == 1) {
          const Vec4 bound = k.mu[r].v * (x[r - 1] > zero ? x[r - 1] : zero);
          const Vec4 least = x[r] - bound, most = x[r] + bound;
          const Vec4 above = w < least ? least : w;
          inside = most < above ? most : above;
        } else {
          inside = x[r] < w ? x[r] : w;
        }
        const Vec4 violation = k.speed[r].v * (inside < zero ? -inside : inside);
        worst = worst < violation ? violation : worst;
      }
    }

    static SKERRY_ALWAYS_INLINE void one(const BlockSweeps& s, std::size_t k, double& worst) {
      const Block& block = s.blocks_[k];
      if (block.pattern >= Pattern::Held) {
        worst = std::max(worst, s.violation_of(s.joint_of(k)));
        return;
      }
      for (int r = 0; r < block.count; ++r) {
        const double w = dot3(block.low[r], s.velocities_[at(block.a)]) +
                         dot3(block.high[r], s.velocities_[at(block.b_body)]) - block.b[r];
        const ImpulseBounds bounds = bounds_of(block, s.bounds_[k], s.impulses_[k], r);
        // D |lambda - clamp(lambda - w / D)| in scaled numbers.
        const double low = s.impulses_[k].v[r] - bounds.upper, high = s.impulses_[k].v[r] - bounds.lower;
        worst = std::max(worst, block.speed[at(r)] * std::abs(std::min(std::max(w, low), high)));
      }
    }
  };
  static double violation_portable(const BlockSweeps& s, std::size_t from, std::size_t to) {
    return visit(Violation{}, s, from, to);
  }
  SKERRY_AVX2 static double violation_avx2(const BlockSweeps& s, std::size_t from, std::size_t to) {
    return visit(Violation{}, s, from, to);
  }
};

bool BlockSweeps::assign(const IslandSystem& system, bool joints, ThreadPool* threads) {
  threads_ = threads;
  blocks_.clear();
  bounds_.clear();
  first_.clear();
  joints_.clear();
  rows_ = 0;
  contradiction_ = 0;
  joint_give_ = contact_give_ = 1;
  if (!joints && !system.compliance.empty()) return false;
  const int n = system.size(), ground = static_cast<int>(system.bodies.size());
  root_.resize(at(n));
  blocks_.reserve(at(n) / 2);
  bounds_.reserve(at(n) / 2);
  first_.reserve(at(n) / 2);
  mass_.resize(at(ground + 1));
  for (std::size_t k = 0; k < system.bodies.size(); ++k) {
    const double linear = std::sqrt(system.bodies[k].linear), angular = std::sqrt(system.bodies[k].angular);
    mass_[k].v = Vec4{linear, linear, angular, 0};
  }
  mass_[at(ground)].v = Vec4{};
  if (!add_blocks(system, joints)) {
    blocks_.clear();
    return false;
  }
  share(threads_, blocks_.size(), kBlocksAPiece, [&](std::size_t from, std::size_t to) {
    if (cpu_has_avx2())
      Kernels::close_avx2(*this, system, from, to);
    else
      Kernels::close_portable(*this, system, from, to);
  });
  for (JointBlock& joint : joints_) close_joint(system, joint);
  rows_ = n;
  velocities_.assign(at(ground + 1), BodyVector{});
  impulses_.assign(blocks_.size(), Impulses{});
  group();
  return true;
}

/// Which rows make which block. @return false if they do not
bool BlockSweeps::add_blocks(const IslandSystem& system, bool joints) {
  const int n = system.size();
  const auto same_bodies = [&](int i, int k) {
    return system.rows[at(i)].a == system.rows[at(k)].a && system.rows[at(i)].b == system.rows[at(k)].b;
  };
  const auto is_joint = [&](int i) {
    return system.rows[at(i)].kind >= RowKind::Joint && system.rows[at(i)].normal < 0;
  };
  int i = 0;
  while (i < n) {
    const int first = i;
    if (is_joint(i)) {
      if (!joints) return false;
      while (i < n && is_joint(i) && same_bodies(i, first)) ++i;
      add_joint_blocks(system, first, i);
      continue;
    }
    // A normal row takes its friction and rolling rows along; a second such set of the same bodies joins it.
    Block& block = add_block(system, first);
    Bounds& bounds = bounds_.back();
    while (i < n && block.count < kRows && !is_joint(i)) {
      int end = i + 1;
      while (end < n && system.rows[at(end)].normal == i) ++end;
      if (system.rows[at(i)].kind != RowKind::Normal || end - i > kRows) return false;
      if (i > first && (!same_bodies(i, first) || block.count + end - i > kRows)) break;
      for (int r = i; r < end; ++r) {
        if (!system.compliance.empty() && system.compliance[at(r)] != 0) return false;
        bounds.normal[at(block.count)] = r == i ? std::int8_t{-1} : static_cast<std::int8_t>(i - first);
        ++block.count;
      }
      i = end;
    }
    first_.push_back(first);
  }
  return true;
}

/// A block of the bodies of a row, still without rows.
BlockSweeps::Block& BlockSweeps::add_block(const IslandSystem& system, int row) {
  const int ground = static_cast<int>(system.bodies.size());
  Block& block = blocks_.emplace_back();
  bounds_.emplace_back();
  block.a = system.rows[at(row)].a < 0 ? ground : system.rows[at(row)].a;
  block.b_body = system.rows[at(row)].b < 0 ? ground : system.rows[at(row)].b;
  return block;
}

BlockSweeps::Kind BlockSweeps::kind_of(const Block& block) {
  switch (block.pattern) {
    case Pattern::Rough:
      return block.count == 4 ? Kind::Rough4 : Kind::Rough2;
    case Pattern::Smooth:
      return block.count == 2 ? Kind::Smooth2 : Kind::Smooth1;
    case Pattern::Held:
      return block.count == 1   ? Kind::Held1
             : block.count == 2 ? Kind::Held2
             : block.count == 3 ? Kind::Held3
                                : Kind::Single;
    case Pattern::General:
    case Pattern::Joint:
      return Kind::Single;
  }
  return Kind::Single;
}

/// Four blocks a group.
void BlockSweeps::group() {
  batches_.clear();
  chunks_.clear();
  groups4_.clear();
  groups3_.clear();
  groups2_.clear();
  groups1_.clear();
  if (blocks_.size() < kFewBlocks) return;
  // The ground's number is that of no body.
  order_.start(mass_.size() - 1, kKinds);
  for (const Block& block : blocks_) order_.add(block.a, block.b_body, static_cast<int>(kind_of(block)));
  order_.finish();
  // Where the groups of a kind stand.
  const auto with_groups = [this](Kind kind, auto&& visit) {
    if (kind == Kind::Rough4)
      visit(groups4_);
    else if (kind == Kind::Held3)
      visit(groups3_);
    else if (kind == Kind::Smooth1 || kind == Kind::Held1)
      visit(groups1_);
    else
      visit(groups2_);
  };
  const std::vector<SweepOrder::Group>& ordered = order_.groups();
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    const Kind kind = static_cast<Kind>(ordered[i].kind);
    const bool new_chunk = i % SweepOrder::kChunk == 0;
    if (new_chunk) chunks_.push_back({static_cast<int>(batches_.size()), 0});
    if (new_chunk || batches_.back().kind != kind) {
      const int number = static_cast<int>(i);
      int first = number;
      if (kind != Kind::Single)
        with_groups(kind, [&](auto& groups) { first = static_cast<int>(groups.size()); });
      batches_.push_back({kind, first, 0, number});
    }
    if (kind != Kind::Single) with_groups(kind, [](auto& groups) { groups.emplace_back(); });
    ++batches_.back().count;
    chunks_.back().end = static_cast<int>(batches_.size());
  }
  velocities_.resize(mass_.size() + chunks_.size());
  impulses_.resize(blocks_.size() + chunks_.size());
  share(threads_, chunks_.size(), kChunksAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t c = from; c < to; ++c) {
      for (int i = chunks_[c].first; i < chunks_[c].end; ++i) {
        const Batch& batch = batches_[at(i)];
        if (batch.kind == Kind::Single) continue;
        with_groups(batch.kind, [&](auto& groups) {
          fill_groups(batch, static_cast<int>(c), groups.data() + batch.first);
        });
      }
    }
  });
}

template <int N>
void BlockSweeps::fill_groups(const Batch& batch, int chunk, Group<N>* to) const {
  const int ground = static_cast<int>(mass_.size()) - 1, unread = ground + 1 + chunk;
  for (int i = 0; i < batch.count; ++i) {
    Group<N>& group = *to++;
    const SweepOrder::Group& ordered = order_.groups()[at(batch.ordered + i)];
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const bool none = static_cast<int>(lane) >= ordered.count;
      const int k = none ? static_cast<int>(blocks_.size()) + chunk : ordered.block[lane];
      group.block[lane] = k;
      group.a[lane] = none ? ground : blocks_[at(k)].a;
      group.b_body[lane] = none ? ground : blocks_[at(k)].b_body;
      // What reads the ground does not wait for what wrote it.
      group.to_a[lane] = group.a[lane] == ground ? unread : group.a[lane];
      group.to_b[lane] = group.b_body[lane] == ground ? unread : group.b_body[lane];
      if (none) continue;
      const Block& block = blocks_[at(k)];
      for (int r = 0; r < N; ++r) {
        for (int c = 0; c < 3; ++c) {
          group.low[r][c].v[lane] = block.low[r].v[c];
          group.high[r][c].v[lane] = block.high[r].v[c];
        }
        group.b[r].v[lane] = block.b[r];
        group.mu[r].v[lane] = block.mu[at(r)];
        group.speed[r].v[lane] = block.speed[at(r)];
      }
      if (block.pattern == Pattern::Held) {
        const JointBlock& joint = joint_of(at(k));
        for (int r = 0, e = 0; r < N; ++r) {
          group.mu[r].v[lane] = joint.L[at(r)][at(r)];
          for (int c = 0; c < r; ++c) group.couple[e++].v[lane] = joint.L[at(r)][at(c)];
        }
        continue;
      }
      for (int e = 0; e < N * (N - 1) / 2; ++e) group.couple[e].v[lane] = block.couple[at(e)];
    }
  }
}

/// A given impulse as the sweeps have it.
double BlockSweeps::scaled(std::span<const double> lambda, int row) const {
  const std::size_t i = at(row);
  return i < lambda.size() && std::isfinite(lambda[i]) ? root_[i] * lambda[i] : 0;
}

void BlockSweeps::set(std::span<const double> lambda) {
  share(threads_, blocks_.size(), kBlocksAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      impulses_[k].v = Vec4{};
      if (first_[k] < 0) continue;
      for (int r = 0; r < blocks_[k].count; ++r) {
        const ImpulseBounds bounds = bounds_of(blocks_[k], bounds_[k], impulses_[k], r);
        impulses_[k].v[r] = Kernels::clamp(scaled(lambda, first_[k] + r), bounds.lower, bounds.upper);
      }
    }
  });
  for (const JointBlock& joint : joints_) set_joint(joint, lambda);
  restart();
}

void BlockSweeps::get(const std::vector<Impulses>& from, std::vector<double>& lambda) const {
  lambda.resize(at(rows_));
  share(threads_, blocks_.size(), kBlocksAPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (first_[k] < 0) continue;
      for (int r = 0; r < blocks_[k].count; ++r) {
        const std::size_t row = at(first_[k] + r);
        lambda[row] = root_[row] > 0 ? from[k].v[r] / root_[row] : 0;
      }
    }
  });
  for (const JointBlock& joint : joints_) get_joint(joint, from[at(joint.block)], lambda);
}

void BlockSweeps::restart() {
  std::fill(velocities_.begin(), velocities_.end(), BodyVector{});
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const Block& block = blocks_[k];
    for (int r = 0; r < block.count; ++r) {
      velocities_[at(block.a)].v += block.low[r].v * impulses_[k].v[r];
      velocities_[at(block.b_body)].v += block.high[r].v * impulses_[k].v[r];
    }
  }
}

bool BlockSweeps::large() const {
  return chunks_.size() >= kManyChunks;
}

double BlockSweeps::sweep(int count) {
  const Manner how{.joint_give = joint_give_, .contact_give = contact_give_};
  const auto always = [&](int) { return how; };
  return contact_give_ != 1 ? sweep_all<Mode::Give>(count, always) : sweep_all<Mode::Plain>(count, always);
}

void BlockSweeps::sweep_part(double load, double take) {
  sweep_all<Mode::Part>(2, [&](int sweep) {
    return sweep == 0 ? Manner{.load = load, .take = take, .keep = 1 - take} : Manner{.load = load};
  });
}

template <BlockSweeps::Mode kMode, class MannerOf>
double BlockSweeps::sweep_all(int count, const MannerOf& manner_of) {
  const auto some = [this](const Manner& how, std::size_t from, std::size_t to) {
    return cpu_has_avx2() ? Kernels::sweep_avx2<kMode>(*this, how, from, to)
                          : Kernels::sweep_portable<kMode>(*this, how, from, to);
  };
  double largest = 0;
  if (!large() || threads_ == nullptr || threads_->threads() == 1) {
    for (int i = 0; i < count; ++i) largest = some(manner_of(i), 0, chunks_.size());
    return largest;
  }
  for (int first = 0; first < count; first += kTogether) {
    const int together = std::min(count - first, kTogether);
    std::array<Progress, kTogether> progress;
    threads_->run(at(together), [&](std::size_t sweep) {
      const Manner how = manner_of(first + static_cast<int>(sweep));
      double change = 0;
      for (std::size_t c = 0; c < chunks_.size(); ++c) {
        if (sweep > 0) progress[sweep - 1].wait_for(order_.need()[c] + 1);
        change = std::max(change, some(how, c, c + 1));
        progress[sweep].done.store(static_cast<int>(c) + 1, std::memory_order_release);
      }
      if (sweep + 1 == at(together)) largest = change;
    });
  }
  return largest;
}

ImpulseBounds BlockSweeps::bounds_of(const Block& block, const Bounds& bounds, const Impulses& impulses,
                                     int r) {
  const int n = bounds.normal[at(r)];
  const double bound = n < 0 ? 0 : block.mu[at(r)] * std::max(impulses.v[n], 0.0);
  return {bounds.lower[at(r)] - bound, bounds.upper[at(r)] + bound};
}

double BlockSweeps::violation() const {
  const std::size_t count = std::max<std::size_t>(chunks_.size(), 1);
  Spare<std::vector<double>> found;
  found->assign(count / kChunksAPiece + 1, 0);
  share(threads_, count, kChunksAPiece, [&](std::size_t from, std::size_t to) {
    (*found)[from / kChunksAPiece] = cpu_has_avx2() ? Kernels::violation_avx2(*this, from, to)
                                                    : Kernels::violation_portable(*this, from, to);
  });
  return std::max(contradiction_, *std::max_element(found->begin(), found->end()));
}

}  // namespace skerry
