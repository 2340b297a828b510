// SPDX-License-Identifier: MIT
#include "physics/solver/block_sweeps.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "physics/index.h"
#include "physics/progress.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Blocks, or chunks of them, that a thread takes at a time where each is by itself.
constexpr std::size_t kBlocksAPiece = 256, kChunksAPiece = 4;
// With fewer blocks, some 24 chunks of them, sweeps that follow each other are soon done.
constexpr std::size_t kManyBlocks = 2200;

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
    if (block.pattern == Pattern::Lined) return;
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
      if constexpr (pattern != Pattern::Lined)
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
        case Kind::Lined3:
          visit_groups<3, Pattern::Lined>(task, s, s.groups3_, batch, four);
          break;
        case Kind::Lined2:
          visit_groups<2, Pattern::Lined>(task, s, s.groups2_, batch, four);
          break;
        case Kind::Lined1:
          visit_groups<1, Pattern::Lined>(task, s, s.groups1_, batch, four);
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

  /// Given impulses of contacts, scaled and clamped to their bounds: of four blocks and of one.
  struct Start {
    std::span<const double> lambda;
    template <int N, Pattern pattern>
    SKERRY_ALWAYS_INLINE void four(BlockSweeps& s, const Group<N>& k, Vec4&) const {
      if (pattern == Pattern::Held || pattern == Pattern::Lined || lambda.empty()) return;
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
  static void push_portable(BlockSweeps& s, std::size_t from, std::size_t to) { visit(Push{}, s, from, to); }
  SKERRY_AVX2 static void push_avx2(BlockSweeps& s, std::size_t from, std::size_t to) {
    visit(Push{}, s, from, to);
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
        if (pattern == Pattern::Held || pattern == Pattern::Lined) {
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

/// A given impulse as the sweeps have it.
double BlockSweeps::scaled(std::span<const double> lambda, int row) const {
  const std::size_t i = at(row);
  return i < lambda.size() && std::isfinite(lambda[i]) ? root_[i] * lambda[i] : 0;
}

void BlockSweeps::set(std::span<const double> lambda) {
  std::fill(impulses_.begin(), impulses_.end(), Impulses{});
  std::fill(velocities_.begin(), velocities_.end(), BodyVector{});
  if (lambda.empty()) return;
  for (const JointBlock& joint : joints_) set_joint(joint, lambda);
  // A body takes the impulses of its blocks in their order: what a thread has scaled it pushes on as soon as
  // all before it is.
  const std::size_t chunks = std::max<std::size_t>(chunks_.size(), 1);
  Progress pushed;
  share(threads_, (chunks + kChunksAPiece - 1) / kChunksAPiece, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end; ++piece) {
      const std::size_t from = piece * kChunksAPiece, to = std::min(from + kChunksAPiece, chunks);
      if (cpu_has_avx2())
        Kernels::start_avx2(*this, lambda, from, to);
      else
        Kernels::start_portable(*this, lambda, from, to);
      pushed.wait_for(static_cast<int>(piece));
      push(from, to);
      pushed.reached(static_cast<int>(piece) + 1);
    }
  });
}

void BlockSweeps::push(std::size_t from, std::size_t to) {
  if (cpu_has_avx2())
    Kernels::push_avx2(*this, from, to);
  else
    Kernels::push_portable(*this, from, to);
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
  push(0, chunks_.size());
}

/// Whatever the number of threads, on which the order and how groups are filled depend.
bool BlockSweeps::large() const {
  return blocks_.size() >= kManyBlocks;
}

/// Sweeps, one a thread.
int BlockSweeps::at_the_same_time() const {
  return shared_ ? std::min(threads_->threads(), kTogether) : 1;
}

void BlockSweeps::soften(double joints, double contacts) {
  joint_give_ = 1 / (1 + joints);
  contact_give_ = 1 / (1 + contacts);
  if (lines_.empty() || joints == 0) return;
  Spare<std::vector<std::uint8_t>> held;
  lines_.eliminate(joints, *held);
}

double BlockSweeps::sweep(int count) {
  const Manner how{.joint_give = joint_give_, .contact_give = contact_give_};
  const auto always = [&](int) { return how; };
  const auto make = [&](int times) {
    return contact_give_ != 1 ? sweep_all<Mode::Give>(times, always) : sweep_all<Mode::Plain>(times, always);
  };
  if (lines_.empty()) return make(count);
  double largest = 0;
  for (int i = 0; i < count; ++i) {
    largest = make(1);
    largest = std::max(largest, lines_.answer(impulses_, velocities_));
  }
  return largest;
}

void BlockSweeps::sweep_part(double load, double take) {
  sweep_all<Mode::Part>(2, [&](int sweep) {
    return sweep == 0 ? Manner{.load = load, .take = take, .keep = 1 - take} : Manner{.load = load};
  });
}

template <BlockSweeps::Mode kMode, class MannerOf>
double BlockSweeps::sweep_all(int count, const MannerOf& manner_of) {
  if (!may_share()) return sweep_alone<kMode>(count, manner_of);
  const auto start = std::chrono::steady_clock::now();
  const double largest =
      shared_ ? sweep_shared<kMode>(count, manner_of) : sweep_alone<kMode>(count, manner_of);
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
  threads_->pace(blocks_.size()).note(shared_, time.count(), count * static_cast<double>(blocks_.size()));
  return largest;
}

template <BlockSweeps::Mode kMode>
double BlockSweeps::sweep_some(const Manner& how, std::size_t from, std::size_t to) {
  return cpu_has_avx2() ? Kernels::sweep_avx2<kMode>(*this, how, from, to)
                        : Kernels::sweep_portable<kMode>(*this, how, from, to);
}

template <BlockSweeps::Mode kMode, class MannerOf>
double BlockSweeps::sweep_alone(int count, const MannerOf& manner_of) {
  double largest = 0;
  for (int i = 0; i < count; ++i) largest = sweep_some<kMode>(manner_of(i), 0, chunks_.size());
  return largest;
}

template <BlockSweeps::Mode kMode, class MannerOf>
double BlockSweeps::sweep_shared(int count, const MannerOf& manner_of) {
  double largest = 0;
  for (int first = 0; first < count; first += kTogether) {
    const int together = std::min(count - first, kTogether);
    std::array<Progress, kTogether> progress;
    threads_->run(at(together), [&](std::size_t sweep) {
      const Manner how = manner_of(first + static_cast<int>(sweep));
      double change = 0;
      for (std::size_t c = 0; c < chunks_.size(); ++c) {
        if (sweep > 0) progress[sweep - 1].wait_for(order_.need()[c] + 1);
        change = std::max(change, sweep_some<kMode>(how, c, c + 1));
        progress[sweep].reached(static_cast<int>(c) + 1);
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
