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
// Rows, blocks, or chunks of them, that a thread takes at a time where each is by itself.
constexpr std::size_t kRowsAPiece = 4096, kBlocksAPiece = 1024, kChunksAPiece = 4;
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

bool is_joint(const Row& row) {
  return row.kind >= RowKind::Joint && row.normal < 0;
}

bool have_same_bodies(const Row& x, const Row& y) {
  return x.a == y.a && x.b == y.b;
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
  static SKERRY_ALWAYS_INLINE void update(const Block& block, const Numbers& k, Pattern pattern, int count,
                                          int ground, const Manner& how, Impulses& impulses, BodyVector* y,
                                          double& largest) {
    const Vec4 ya = y[block.a].v, yb = y[block.b_body].v;
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
        const int n = k.normal[at(r)];
        const double bound = n < 0 ? 0 : k.mu[at(r)] * std::max(next[n], 0.0);
        lower = k.lower[at(r)] - bound;
        upper = k.upper[at(r)] + bound;
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
    if (block.a != ground) y[block.a].v = a;
    if (block.b_body != ground) y[block.b_body].v = b;
  }

  /// One block of joint rows.
  template <Mode kMode>
  static SKERRY_ALWAYS_INLINE void update_joint(const Block& block, const Numbers& k, const JointBlock& joint,
                                                int ground, const Manner& how, Impulses& impulses,
                                                BodyVector* y, double& largest) {
    const bool held = block.pattern == Pattern::Held;
    Vec4 a = y[block.a].v, b = y[block.b_body].v;
    Vec4 t[kRows] = {};
    for (int r = 0; r < block.count; ++r) t[r] = k.low[r].v * a + k.high[r].v * b;
    Vec4 velocity;
    sums(t[0], t[1], t[2], t[3], velocity);
    double d[kRows] = {};
    int entry = 0;
    for (int r = 0; r < block.count; ++r) {
      const double was = impulses.v[r], aim = kMode == Mode::Part ? how.load * k.b[r] : k.b[r];
      double wanted = (held ? was : joint.keep[at(r)] * was) - (velocity[r] - aim);
      for (int c = 0; c < r && !held; ++c) wanted -= k.couple[at(entry++)] * d[c];
      wanted = kMode == Mode::Part ? how.take * wanted + how.keep * was : how.joint_give * wanted;
      const double next = held ? wanted : clamp(wanted, k.lower[at(r)], k.upper[at(r)]);
      d[r] = next - was;
      impulses.v[r] = next;
      const double change = std::abs(d[r]) * k.speed[at(r)];
      largest = largest < change ? change : largest;
    }
    for (int r = 0; r < block.count; ++r) {
      a += k.low[r].v * d[r];
      b += k.high[r].v * d[r];
    }
    if (block.a != ground) y[block.a].v = a;
    if (block.b_body != ground) y[block.b_body].v = b;
  }

  /// One block with the shape of its rows known to the compiler.
  template <Mode kMode>
  static SKERRY_ALWAYS_INLINE void update_one(BlockSweeps& s, std::size_t k, const Manner& how,
                                              double& largest) {
    const int ground = static_cast<int>(s.mass_.size()) - 1;
    BodyVector* y = s.velocities_.data();
    const Block& block = s.blocks_[k];
    Impulses& impulses = s.impulses_[k];
    const Numbers& numbers = s.numbers_of(block);
    if (block.pattern >= Pattern::Held)
      update_joint<kMode>(block, numbers, s.joint_of(k), ground, how, impulses, y, largest);
    else if (block.pattern == Pattern::Rough && block.count == 4)
      update<kMode>(block, numbers, Pattern::Rough, 4, ground, how, impulses, y, largest);
    else if (block.pattern == Pattern::Rough)
      update<kMode>(block, numbers, Pattern::Rough, 2, ground, how, impulses, y, largest);
    else if (block.pattern == Pattern::Smooth && block.count == 2)
      update<kMode>(block, numbers, Pattern::Smooth, 2, ground, how, impulses, y, largest);
    else if (block.pattern == Pattern::Smooth)
      update<kMode>(block, numbers, Pattern::Smooth, 1, ground, how, impulses, y, largest);
    else
      update<kMode>(block, numbers, Pattern::General, block.count, ground, how, impulses, y, largest);
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

  /// A row on a body, for the velocities of which one is the root of the mass.
  static SKERRY_ALWAYS_INLINE void scale(const std::array<double, 3>& J, const BodyVector& mass,
                                         BodyVector& row) {
    row.v = Vec4{J[0], J[1], J[2], 0} * mass.v;
  }

  /// D^1/2 of the rows of a contact, and in which pattern they are.
  static SKERRY_ALWAYS_INLINE void measure(BlockSweeps& s, const IslandSystem& system, Block& block) {
    bool contact = true, rough = block.count % 2 == 0, smooth = block.count <= 2;
    const BodyVector &mass_a = s.mass_[at(block.a)], &mass_b = s.mass_[at(block.b_body)];
    for (int r = 0; r < block.count; ++r) {
      const Row& row = system.rows[at(block.first + r)];
      BodyVector low, high;
      scale(row.Ja, mass_a, low);
      scale(row.Jb, mass_b, high);
      const double D = dot3(low, low) + dot3(high, high);
      s.root_[at(block.first + r)] = std::sqrt(D);
      if (row.normal >= 0) {
        rough = rough && r % 2 == 1 && row.normal == block.first + r - 1;
        smooth = false;
      } else {
        rough = rough && r % 2 == 0;
        contact = contact && row.lower == 0 && row.upper == kInfinity && D > 0;
      }
    }
    if (contact && rough)
      block.pattern = Pattern::Rough;
    else if (contact && smooth)
      block.pattern = Pattern::Smooth;
  }

  static SKERRY_ALWAYS_INLINE void measure_some(BlockSweeps& s, const IslandSystem& system, std::size_t from,
                                                std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      if (s.blocks_[k].first >= 0) measure(s, system, s.blocks_[k]);
    }
  }
  static void measure_portable(BlockSweeps& s, const IslandSystem& system, std::size_t from, std::size_t to) {
    measure_some(s, system, from, to);
  }
  SKERRY_AVX2 static void measure_avx2(BlockSweeps& s, const IslandSystem& system, std::size_t from,
                                       std::size_t to) {
    measure_some(s, system, from, to);
  }

  /// Fills in the numbers of a contact that is swept by itself.
  static void close(BlockSweeps& s, const IslandSystem& system, Numbers& numbers) {
    const Block& block = s.blocks_[at(numbers.block)];
    numbers.b = Vec4{};
    for (int r = 0; r < block.count; ++r) {
      const Row& row = system.rows[at(block.first + r)];
      const double root = s.root_[at(block.first + r)], inverse = root > 0 ? 1 / root : 0;
      scale(row.Ja, s.mass_[at(block.a)], numbers.low[r]);
      scale(row.Jb, s.mass_[at(block.b_body)], numbers.high[r]);
      numbers.low[r].v *= inverse;
      numbers.high[r].v *= inverse;
      numbers.speed[at(r)] = root;
      numbers.b[r] = inverse * system.b[at(block.first + r)];
      if (row.normal >= 0) {
        const double normal_root = s.root_[at(row.normal)];
        numbers.normal[at(r)] = static_cast<std::int8_t>(row.normal - block.first);
        numbers.mu[at(r)] = normal_root > 0 ? row.mu * root / normal_root : 0;
      } else {
        // What nothing moves stays at zero.
        numbers.lower[at(r)] = root > 0 ? root * row.lower : 0;
        numbers.upper[at(r)] = root > 0 ? root * row.upper : 0;
      }
    }
    std::size_t entry = 0;
    for (int r = 1; r < block.count; ++r) {
      for (int c = 0; c < r; ++c)
        numbers.couple[entry++] =
            dot3(numbers.low[r], numbers.low[c]) + dot3(numbers.high[r], numbers.high[c]);
    }
  }

  /// The same of four blocks, straight from their rows.
  template <int N>
  static SKERRY_ALWAYS_INLINE void fill_contacts(const BlockSweeps& s, const IslandSystem& system,
                                                 const SweepOrder::Group& ordered, Group<N>& group) {
    static constexpr Row kNone{};
    const Vec4 zero{};
    Vec4 roots[N];
    for (int r = 0; r < N; ++r) {
      BodyVector low[4], high[4];
      Vec4 root{}, b{}, mu{};
      for (int lane = 0; lane < 4; ++lane) {
        const bool none = lane >= ordered.count;
        const int i = none ? 0 : s.blocks_[at(ordered.block[at(lane)])].first + r;
        const Row& row = none ? kNone : system.rows[at(i)];
        scale(row.Ja, s.mass_[at(group.a[at(lane)])], low[lane]);
        scale(row.Jb, s.mass_[at(group.b_body[at(lane)])], high[lane]);
        if (none) continue;
        root[lane] = s.root_[at(i)];
        b[lane] = system.b[at(i)];
        mu[lane] = row.mu;
      }
      transpose(low[0].v, low[1].v, low[2].v, low[3].v);
      transpose(high[0].v, high[1].v, high[2].v, high[3].v);
      const Vec4 inverse = root > zero ? 1 / root : zero;
      for (int c = 0; c < 3; ++c) {
        group.low[r][c].v = inverse * low[c].v;
        group.high[r][c].v = inverse * high[c].v;
      }
      roots[r] = root;
      group.b[r].v = inverse * b;
      group.speed[r].v = root;
      // Of no use to normal rows.
      const Vec4 normal = roots[r % 2 == 1 ? r - 1 : r];
      group.mu[r].v = normal > zero ? mu * root / normal : zero;
    }
    int entry = 0;
    for (int r = 1; r < N; ++r) {
      for (int c = 0; c < r; ++c) {
        const Lanes *p = group.low[r], *q = group.low[c], *u = group.high[r], *v = group.high[c];
        group.couple[entry++].v = ((p[0].v * q[0].v + p[1].v * q[1].v) + p[2].v * q[2].v) +
                                  ((u[0].v * v[0].v + u[1].v * v[1].v) + u[2].v * v[2].v);
      }
    }
  }

  /// Four blocks of joints, whose numbers are known.
  template <int N>
  static SKERRY_ALWAYS_INLINE void fill_joints(const BlockSweeps& s, const SweepOrder::Group& ordered,
                                               Group<N>& group) {
    for (int lane = 0; lane < 4; ++lane) {
      const bool none = lane >= ordered.count;
      const std::size_t k = none ? 0 : at(ordered.block[at(lane)]);
      const Numbers* numbers = none ? nullptr : &s.numbers_of(s.blocks_[k]);
      const JointBlock* joint = none ? nullptr : &s.joint_of(k);
      int entry = 0;
      for (int r = 0; r < N; ++r) {
        for (int c = 0; c < 3; ++c) {
          group.low[r][c].v[lane] = none ? 0 : numbers->low[r].v[c];
          group.high[r][c].v[lane] = none ? 0 : numbers->high[r].v[c];
        }
        group.b[r].v[lane] = none ? 0 : numbers->b[r];
        group.speed[r].v[lane] = none ? 0 : numbers->speed[at(r)];
        group.mu[r].v[lane] = none ? 0 : joint->L[at(r)][at(r)];
        for (int c = 0; c < r; ++c) group.couple[entry++].v[lane] = none ? 0 : joint->L[at(r)][at(c)];
      }
    }
  }

  template <int N>
  static SKERRY_ALWAYS_INLINE void fill(BlockSweeps& s, const IslandSystem& system, const Batch& batch,
                                        int chunk, std::vector<Group<N>>& groups) {
    const int ground = static_cast<int>(s.mass_.size()) - 1, unread = ground + 1 + chunk;
    for (int i = 0; i < batch.count; ++i) {
      Group<N>& group = groups[at(batch.first + i)];
      const SweepOrder::Group& ordered = s.order_.groups()[at(batch.ordered + i)];
      for (int lane = 0; lane < 4; ++lane) {
        const bool none = lane >= ordered.count;
        const int k = none ? static_cast<int>(s.blocks_.size()) + chunk : ordered.block[at(lane)];
        const int a = none ? ground : s.blocks_[at(k)].a, b = none ? ground : s.blocks_[at(k)].b_body;
        group.block[at(lane)] = k;
        group.a[at(lane)] = a;
        group.b_body[at(lane)] = b;
        // What reads the ground does not wait for what wrote it.
        group.to_a[at(lane)] = a == ground ? unread : a;
        group.to_b[at(lane)] = b == ground ? unread : b;
      }
      if (batch.kind == Kind::Held1 || batch.kind == Kind::Held2 || batch.kind == Kind::Held3)
        fill_joints(s, ordered, group);
      else
        fill_contacts(s, system, ordered, group);
    }
  }

  static SKERRY_ALWAYS_INLINE void fill_some(BlockSweeps& s, const IslandSystem& system, std::size_t from,
                                             std::size_t to) {
    for (std::size_t c = from; c < to; ++c) {
      for (int i = s.chunks_[c].first; i < s.chunks_[c].end; ++i) {
        const Batch& batch = s.batches_[at(i)];
        // Not by `with_groups`: what is in a lambda is compiled for any processor.
        const int chunk = static_cast<int>(c);
        switch (batch.kind) {
          case Kind::Rough4:
            fill(s, system, batch, chunk, s.groups4_);
            break;
          case Kind::Held3:
            fill(s, system, batch, chunk, s.groups3_);
            break;
          case Kind::Rough2:
          case Kind::Smooth2:
          case Kind::Held2:
            fill(s, system, batch, chunk, s.groups2_);
            break;
          case Kind::Smooth1:
          case Kind::Held1:
            fill(s, system, batch, chunk, s.groups1_);
            break;
          case Kind::Single:
            break;
        }
      }
    }
  }
  static void fill_portable(BlockSweeps& s, const IslandSystem& system, std::size_t from, std::size_t to) {
    fill_some(s, system, from, to);
  }
  SKERRY_AVX2 static void fill_avx2(BlockSweeps& s, const IslandSystem& system, std::size_t from,
                                    std::size_t to) {
    fill_some(s, system, from, to);
  }

  /// Given impulses of contacts, scaled and clamped to their bounds: of four blocks and of one.
  struct Start {
    std::span<const double> lambda;
    template <int N, Pattern pattern>
    SKERRY_ALWAYS_INLINE void four(BlockSweeps& s, const Group<N>& k, Vec4&) const {
      if (pattern == Pattern::Held || lambda.empty()) return;
      const Vec4 zero{};
      Vec4 x[4] = {};
      const int count = static_cast<int>(s.blocks_.size());
      for (int lane = 0; lane < 4; ++lane) {
        const int block = k.block[at(lane)];
        for (int r = 0; r < N && block < count; ++r)
          x[r][lane] = s.scaled(lambda, s.blocks_[at(block)].first + r);
      }
      for (int r = 0; r < N; ++r) {
        if (pattern == Pattern::Rough && r % 2 == 1) {
          const Vec4 upper = k.mu[r].v * x[r - 1], lower = -upper;
          const Vec4 low = x[r] > lower ? x[r] : lower;
          x[r] = low < upper ? low : upper;
        } else {
          x[r] = x[r] > zero ? x[r] : zero;
        }
      }
      transpose(x[0], x[1], x[2], x[3]);
      for (int i = 0; i < 4; ++i) s.impulses_[at(k.block[at(i)])].v = x[i];
    }
    SKERRY_ALWAYS_INLINE void one(BlockSweeps& s, std::size_t k, double&) const {
      const Block& block = s.blocks_[k];
      if (block.first < 0) return;
      Impulses& x = s.impulses_[k];
      x.v = Vec4{};
      for (int r = 0; r < block.count; ++r) {
        const ImpulseBounds bounds = bounds_of(s.numbers_of(block), x, r);
        x.v[r] = clamp(s.scaled(lambda, block.first + r), bounds.lower, bounds.upper);
      }
    }
  };
  static void start_portable(BlockSweeps& s, std::span<const double> lambda, std::size_t from,
                             std::size_t to) {
    visit(Start{lambda}, s, from, to);
  }
  SKERRY_AVX2 static void start_avx2(BlockSweeps& s, std::span<const double> lambda, std::size_t from,
                                     std::size_t to) {
    visit(Start{lambda}, s, from, to);
  }

  /// Adds what the impulses do to the velocities.
  struct Push {
    template <int N, Pattern pattern>
    static SKERRY_ALWAYS_INLINE void four(BlockSweeps& s, const Group<N>& k, Vec4&) {
      BodyVector* y = s.velocities_.data();
      Vec4 a[4], b[4], x[4];
      for (int i = 0; i < 4; ++i) {
        a[i] = y[k.a[at(i)]].v;
        b[i] = y[k.b_body[at(i)]].v;
        x[i] = s.impulses_[at(k.block[at(i)])].v;
      }
      transpose(a[0], a[1], a[2], a[3]);
      transpose(b[0], b[1], b[2], b[3]);
      transpose(x[0], x[1], x[2], x[3]);
      for (int r = 0; r < N; ++r) {
        for (int c = 0; c < 3; ++c) {
          a[c] += k.low[r][c].v * x[r];
          b[c] += k.high[r][c].v * x[r];
        }
      }
      transpose(a[0], a[1], a[2], a[3]);
      transpose(b[0], b[1], b[2], b[3]);
      for (int i = 0; i < 4; ++i) {
        y[k.to_a[at(i)]].v = a[i];
        y[k.to_b[at(i)]].v = b[i];
      }
    }
    static SKERRY_ALWAYS_INLINE void one(BlockSweeps& s, std::size_t k, double&) {
      const Block& block = s.blocks_[k];
      const Numbers& numbers = s.numbers_of(block);
      for (int r = 0; r < block.count; ++r) {
        s.velocities_[at(block.a)].v += numbers.low[r].v * s.impulses_[k].v[r];
        s.velocities_[at(block.b_body)].v += numbers.high[r].v * s.impulses_[k].v[r];
      }
    }
  };
  static void push_portable(BlockSweeps& s) { visit(Push{}, s, 0, s.chunks_.size()); }
  SKERRY_AVX2 static void push_avx2(BlockSweeps& s) { visit(Push{}, s, 0, s.chunks_.size()); }

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
      const Numbers& numbers = s.numbers_of(block);
      for (int r = 0; r < block.count; ++r) {
        const double w = dot3(numbers.low[r], s.velocities_[at(block.a)]) +
                         dot3(numbers.high[r], s.velocities_[at(block.b_body)]) - numbers.b[r];
        const ImpulseBounds bounds = bounds_of(numbers, s.impulses_[k], r);
        // D |lambda - clamp(lambda - w / D)| in scaled numbers.
        const double low = s.impulses_[k].v[r] - bounds.upper, high = s.impulses_[k].v[r] - bounds.lower;
        worst = std::max(worst, numbers.speed[at(r)] * std::abs(std::min(std::max(w, low), high)));
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
  numbers_.clear();
  joints_.clear();
  rows_ = 0;
  contradiction_ = 0;
  joint_give_ = contact_give_ = 1;
  if (!joints && !system.compliance.empty()) return false;
  const int n = system.size(), ground = static_cast<int>(system.bodies.size());
  root_.resize(at(n));
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
      Kernels::measure_avx2(*this, system, from, to);
    else
      Kernels::measure_portable(*this, system, from, to);
  });
  for (JointBlock& joint : joints_) close_joint(system, joint);
  rows_ = n;
  velocities_.assign(at(ground + 1), BodyVector{});
  impulses_.assign(blocks_.size(), Impulses{});
  group();
  share(threads_, chunks_.size(), kChunksAPiece, [&](std::size_t from, std::size_t to) {
    if (cpu_has_avx2())
      Kernels::fill_avx2(*this, system, from, to);
    else
      Kernels::fill_portable(*this, system, from, to);
  });
  share(threads_, numbers_.size(), kBlocksAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      if (blocks_[at(numbers_[i].block)].first >= 0) Kernels::close(*this, system, numbers_[i]);
    }
  });
  return true;
}

/// Which rows make which block. @return false if they do not
bool BlockSweeps::add_blocks(const IslandSystem& system, bool joints) {
  if (threads_ != nullptr && threads_->threads() > 1 && system.rows.size() > kRowsAPiece)
    return add_blocks_of_pieces(system, joints);
  for (int i = 0; i < system.size();) {
    const int next = end_of_block(system, i, joints);
    if (next < 0) return false;
    if (is_joint(system.rows[at(i)]))
      add_joint_blocks(system, i, next);
    else
      set_block(system, i, next, blocks_.emplace_back());
    i = next;
  }
  return true;
}

/// The same by pieces of the rows, where joints come first.
bool BlockSweeps::add_blocks_of_pieces(const IslandSystem& system, bool joints) {
  const int n = system.size();
  int begin = 0;
  while (begin < n && is_joint(system.rows[at(begin)])) {
    const int next = end_of_block(system, begin, joints);
    if (next < 0) return false;
    add_joint_blocks(system, begin, next);
    begin = next;
  }
  // A piece ends where the bodies change, at a row that is no bound's.
  const auto beginning_of = [&](std::size_t piece) {
    int i = begin + std::min(static_cast<int>(piece * kRowsAPiece), n - begin);
    while (i > begin && i < n &&
           (system.rows[at(i)].normal >= 0 || have_same_bodies(system.rows[at(i)], system.rows[at(i - 1)]))) {
      ++i;
    }
    return i;
  };
  // Calls `visit(first, end)` for the blocks of a piece. @return false if its rows make none
  const auto visit_blocks = [&](std::size_t piece, auto&& visit) {
    const int end = beginning_of(piece + 1);
    for (int i = beginning_of(piece); i < end;) {
      const int next = is_joint(system.rows[at(i)]) ? -1 : end_of_block(system, i, joints);
      if (next < 0) return false;
      visit(i, next);
      i = next;
    }
    return true;
  };
  const std::size_t pieces = (at(n - begin) + kRowsAPiece - 1) / kRowsAPiece;
  Spare<std::vector<std::size_t>> first;
  first->assign(pieces + 1, 0);
  std::atomic<bool> all = true;
  share(threads_, pieces, 1, [&](std::size_t from, std::size_t to) {
    for (std::size_t piece = from; piece < to; ++piece) {
      std::size_t count = 0;
      if (!visit_blocks(piece, [&](int, int) { ++count; })) all = false;
      (*first)[piece + 1] = count;
    }
  });
  if (!all) {
    // Joints that stand among contacts, or rows that make no block.
    blocks_.clear();
    numbers_.clear();
    joints_.clear();
    ThreadPool* const threads = threads_;
    threads_ = nullptr;
    const bool made = add_blocks(system, joints);
    threads_ = threads;
    return made;
  }
  first->front() = blocks_.size();
  for (std::size_t piece = 0; piece < pieces; ++piece) (*first)[piece + 1] += (*first)[piece];
  blocks_.resize(first->back());
  share(threads_, pieces, 1, [&](std::size_t from, std::size_t to) {
    for (std::size_t piece = from; piece < to; ++piece) {
      std::size_t k = (*first)[piece];
      visit_blocks(piece, [&](int row, int end) { set_block(system, row, end, blocks_[k++]); });
    }
  });
  return true;
}

/// The row after those of the block, or of the blocks of joint rows, that begin at a row; -1 if they make
/// none.
int BlockSweeps::end_of_block(const IslandSystem& system, int first, bool joints) {
  const int n = system.size();
  const Row& head = system.rows[at(first)];
  int i = first;
  if (is_joint(head)) {
    if (!joints) return -1;
    while (i < n && is_joint(system.rows[at(i)]) && have_same_bodies(system.rows[at(i)], head)) ++i;
    return i;
  }
  // A normal row takes its friction and rolling rows along; a second such set of the same bodies joins it.
  while (i < n && i - first < kRows && !is_joint(system.rows[at(i)])) {
    int end = i + 1;
    while (end < n && system.rows[at(end)].normal == i) ++end;
    if (system.rows[at(i)].kind != RowKind::Normal || end - i > kRows) return -1;
    if (i > first && (!have_same_bodies(system.rows[at(i)], head) || end - first > kRows)) break;
    for (int r = i; r < end; ++r)
      if (!system.compliance.empty() && system.compliance[at(r)] != 0) return -1;
    i = end;
  }
  return i;
}

/// A block of contact rows.
void BlockSweeps::set_block(const IslandSystem& system, int first, int end, Block& block) {
  const int ground = static_cast<int>(system.bodies.size());
  const Row& row = system.rows[at(first)];
  block = {};
  block.a = row.a < 0 ? ground : row.a;
  block.b_body = row.b < 0 ? ground : row.b;
  block.first = first;
  block.count = static_cast<std::int16_t>(end - first);
}

void BlockSweeps::add_numbers(std::size_t block) {
  blocks_[block].numbers = static_cast<int>(numbers_.size());
  numbers_.emplace_back().block = static_cast<int>(block);
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

/// Where the groups of a kind stand.
template <class Visit>
void BlockSweeps::with_groups(Kind kind, Visit&& visit) {
  if (kind == Kind::Rough4)
    visit(groups4_);
  else if (kind == Kind::Held3)
    visit(groups3_);
  else if (kind == Kind::Smooth1 || kind == Kind::Held1)
    visit(groups1_);
  else if (kind != Kind::Single)
    visit(groups2_);
}

/// Four blocks a group.
void BlockSweeps::group() {
  batches_.clear();
  chunks_.clear();
  groups4_.clear();
  groups3_.clear();
  groups2_.clear();
  groups1_.clear();
  const bool few = blocks_.size() < kFewBlocks;
  // The ground's number is that of no body.
  if (!few) order_.start(mass_.size() - 1, kKinds);
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const Kind kind = kind_of(blocks_[k]);
    if ((few || kind == Kind::Single) && blocks_[k].numbers < 0) add_numbers(k);
    if (!few) order_.add(blocks_[k].a, blocks_[k].b_body, static_cast<int>(kind));
  }
  if (few) return;
  order_.finish();
  const std::vector<SweepOrder::Group>& ordered = order_.groups();
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    const Kind kind = static_cast<Kind>(ordered[i].kind);
    const bool new_chunk = i % SweepOrder::kChunk == 0;
    if (new_chunk) chunks_.push_back({static_cast<int>(batches_.size()), 0});
    if (new_chunk || batches_.back().kind != kind) {
      const int number = static_cast<int>(i);
      int first = number;
      with_groups(kind, [&](auto& groups) { first = static_cast<int>(groups.size()); });
      batches_.push_back({kind, first, 0, number});
    }
    with_groups(kind, [](auto& groups) { groups.emplace_back(); });
    ++batches_.back().count;
    chunks_.back().end = static_cast<int>(batches_.size());
  }
  velocities_.resize(mass_.size() + chunks_.size());
  impulses_.resize(blocks_.size() + chunks_.size());
}

/// A given impulse as the sweeps have it.
double BlockSweeps::scaled(std::span<const double> lambda, int row) const {
  const std::size_t i = at(row);
  return i < lambda.size() && std::isfinite(lambda[i]) ? root_[i] * lambda[i] : 0;
}

void BlockSweeps::set(std::span<const double> lambda) {
  std::fill(impulses_.begin(), impulses_.end(), Impulses{});
  const std::size_t count = std::max<std::size_t>(chunks_.size(), 1);
  share(threads_, count, kChunksAPiece, [&](std::size_t from, std::size_t to) {
    if (cpu_has_avx2())
      Kernels::start_avx2(*this, lambda, from, to);
    else
      Kernels::start_portable(*this, lambda, from, to);
  });
  for (const JointBlock& joint : joints_) set_joint(joint, lambda);
  restart();
}

void BlockSweeps::get(const std::vector<Impulses>& from, std::vector<double>& lambda) const {
  lambda.resize(at(rows_));
  share(threads_, blocks_.size(), kBlocksAPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (blocks_[k].first < 0) continue;
      for (int r = 0; r < blocks_[k].count; ++r) {
        const std::size_t row = at(blocks_[k].first + r);
        lambda[row] = root_[row] > 0 ? from[k].v[r] / root_[row] : 0;
      }
    }
  });
  for (const JointBlock& joint : joints_) get_joint(joint, from[at(joint.block)], lambda);
}

void BlockSweeps::restart() {
  std::fill(velocities_.begin(), velocities_.end(), BodyVector{});
  const auto acts = [](const Impulses& x) {
    return x.v[0] != 0 || x.v[1] != 0 || x.v[2] != 0 || x.v[3] != 0;
  };
  if (std::none_of(impulses_.begin(), impulses_.end(), acts)) return;
  if (cpu_has_avx2())
    Kernels::push_avx2(*this);
  else
    Kernels::push_portable(*this);
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

ImpulseBounds BlockSweeps::bounds_of(const Numbers& numbers, const Impulses& impulses, int r) {
  const int n = numbers.normal[at(r)];
  const double bound = n < 0 ? 0 : numbers.mu[at(r)] * std::max(impulses.v[n], 0.0);
  return {numbers.lower[at(r)] - bound, numbers.upper[at(r)] + bound};
}

double BlockSweeps::violation() const {
  // What is no number is no larger than anything.
  Vec4 none{};
  for (const BodyVector& y : velocities_) none += 0 * y.v;
  if (none[0] + none[1] + none[2] != 0) return kInfinity;
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
