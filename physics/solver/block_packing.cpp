// SPDX-License-Identifier: MIT
//
// Packing of an island for Gauss-Seidel sweeps: which rows make a block, which blocks stand side by side, and
// their scaled numbers.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "physics/index.h"
#include "physics/solver/block_sweeps.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Fewer blocks leave too many lanes empty.
constexpr std::size_t kFewBlocks = 12;
// Rows, blocks, or chunks of them, that a thread takes at a time where each is by itself.
constexpr std::size_t kRowsAPiece = 4096, kBlocksAPiece = 256, kChunksAPiece = 4;

bool is_joint(const Row& row) {
  return row.kind >= RowKind::Joint && row.normal < 0;
}

bool have_same_bodies(const Row& x, const Row& y) {
  return x.a == y.a && x.b == y.b;
}

}  // namespace

struct BlockSweeps::Packing {
  static constexpr bool is_of_joints(Kind kind) { return kind >= Kind::Held3 && kind <= Kind::Lined1; }

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
      if (is_of_joints(batch.kind))
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
        const int chunk = static_cast<int>(c);
        switch (batch.kind) {
          case Kind::Rough4:
            fill(s, system, batch, chunk, s.groups4_);
            break;
          case Kind::Held3:
          case Kind::Lined3:
            fill(s, system, batch, chunk, s.groups3_);
            break;
          case Kind::Rough2:
          case Kind::Smooth2:
          case Kind::Held2:
          case Kind::Lined2:
            fill(s, system, batch, chunk, s.groups2_);
            break;
          case Kind::Smooth1:
          case Kind::Held1:
          case Kind::Lined1:
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
};

bool BlockSweeps::assign(const IslandSystem& system, bool joints, ThreadPool* threads, bool lines) {
  threads_ = threads;
  blocks_.clear();
  numbers_.clear();
  joints_.clear();
  lines_.clear();
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
  if (lines) choose_lines();
  share_beside(
      threads_, blocks_.size(), kBlocksAPiece,
      [&](std::size_t from, std::size_t to) {
        if (cpu_has_avx2())
          Packing::measure_avx2(*this, system, from, to);
        else
          Packing::measure_portable(*this, system, from, to);
      },
      [&] {
        arrange();
        velocities_.assign(at(ground + 1), BodyVector{});
        impulses_.assign(blocks_.size(), Impulses{});
      });
  for (JointBlock& joint : joints_) close_joint(system, joint);
  factor_lines();
  rows_ = n;
  group();
  share(threads_, chunks_.size(), kChunksAPiece, [&](std::size_t from, std::size_t to) {
    if (cpu_has_avx2())
      Packing::fill_avx2(*this, system, from, to);
    else
      Packing::fill_portable(*this, system, from, to);
  });
  share(threads_, numbers_.size(), kBlocksAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      if (blocks_[at(numbers_[i].block)].first >= 0) Packing::close(*this, system, numbers_[i]);
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
    case Pattern::Lined:
      return block.count == 1   ? Kind::Lined1
             : block.count == 2 ? Kind::Lined2
             : block.count == 3 ? Kind::Lined3
                                : Kind::Single;
    case Pattern::General:
    case Pattern::Joint:
      return Kind::Single;
  }
  return Kind::Single;
}

/// Rows of a block of a kind whose groups have lists; 0: it is swept by itself.
int BlockSweeps::rows_of(Kind kind) {
  switch (kind) {
    case Kind::Rough4:
      return 4;
    case Kind::Held3:
    case Kind::Lined3:
      return 3;
    case Kind::Rough2:
    case Kind::Smooth2:
    case Kind::Held2:
    case Kind::Lined2:
      return 2;
    case Kind::Smooth1:
    case Kind::Held1:
    case Kind::Lined1:
      return 1;
    case Kind::Single:
      return 0;
  }
  return 0;
}

/// Those of few blocks are swept one after the other.
bool BlockSweeps::are_few() const {
  return blocks_.size() < kFewBlocks;
}

/// The order of the blocks, as far as it follows from their bodies.
void BlockSweeps::arrange() {
  shared_ = may_share() && threads_->pace(blocks_.size()).share();
  if (are_few()) return;
  // The ground's number is that of no body.
  order_.start(mass_.size() - 1);
  for (const Block& block : blocks_) order_.add(block.a, block.b_body);
  order_.arrange(at_the_same_time());
}

/// Four blocks a group.
void BlockSweeps::group() {
  batches_.clear();
  chunks_.clear();
  groups4_.clear();
  groups3_.clear();
  groups2_.clear();
  groups1_.clear();
  Spare<std::vector<std::uint8_t>> kinds;
  kinds->resize(blocks_.size());
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const Kind kind = kind_of(blocks_[k]);
    if ((are_few() || kind == Kind::Single) && blocks_[k].numbers < 0) add_numbers(k);
    (*kinds)[k] = static_cast<std::uint8_t>(kind);
  }
  if (are_few()) return;
  order_.finish(*kinds, kKinds);
  const std::vector<SweepOrder::Group>& ordered = order_.groups();
  std::array<int, kRows + 1> count{};
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    const Kind kind = static_cast<Kind>(ordered[i].kind);
    const int number = static_cast<int>(i);
    int& next = count[at(rows_of(kind))];
    const bool new_chunk = i % SweepOrder::kChunk == 0;
    if (new_chunk) chunks_.push_back({static_cast<int>(batches_.size()), 0});
    if (new_chunk || batches_.back().kind != kind)
      batches_.push_back({kind, kind == Kind::Single ? number : next, 0, number});
    ++next;
    ++batches_.back().count;
    chunks_.back().end = static_cast<int>(batches_.size());
  }
  resize_with_room(groups4_, at(count[4]));
  resize_with_room(groups3_, at(count[3]));
  resize_with_room(groups2_, at(count[2]));
  resize_with_room(groups1_, at(count[1]));
  velocities_.resize(mass_.size() + chunks_.size());
  impulses_.resize(blocks_.size() + chunks_.size());
}

}  // namespace skerry
