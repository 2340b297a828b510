// SPDX-License-Identifier: MIT
//
// Gauss-Seidel sweeps over an island packed for speed. Rows are scaled so that W has a unit diagonal,
// velocities by the roots of the masses, so that a row is read and pushed along with the same numbers:
//
//   Jbar = D^-1/2 J M^-1/2,   z = lambda - (Jbar y - b),   lambda = clamp(z),   y += Jbar' (change of lambda)
//
// Up to four rows of one pair of bodies (two points with friction) make a block. They read the velocities
// once and are corrected for each other by their own entries of W: the numbers of a row-by-row sweep, without
// waiting for each other's stores. Of large islands four blocks at a time that share no body are swept side
// by side, one a lane (`sweep_order.h`); that changes no bit. Nor does it where several threads make one
// sweep each: a sweep begins a chunk of blocks as soon as the one before it has done with all of their
// bodies.
//
// Up to four rows of joints between one pair of bodies make a block, too. Rows without bounds are replaced by
// orthonormal combinations of theirs, and the others made orthogonal to those:
//
//   Jbar = L Q,   Q Q' = 1 among rows without bounds,   lambda_Q = L' lambda
//
// so that the same sweep over the rows of Q solves a block with at most one bounded row exactly. Of long
// chains and trees of joints the rows without bounds may be one block, which is answered at the end of each
// sweep (`joint_lines.h`).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/islands/island_system.h"
#include "physics/solver/joint_lines.h"
#include "physics/solver/simd.h"
#include "physics/solver/sweep_order.h"
#include "physics/thread_pool.h"

namespace skerry {

class BlockSweeps {
 public:
  /// Impulses of one block, scaled: D^1/2 lambda; rows that it has not are zero.
  using Impulses = BodyVector;

  /// Packs `system`. @param joints  rows of joints, and compliant ones among them, are taken
  /// @param threads  share the work until the next `assign`; null: the caller alone
  /// @param lines    long chains and trees of joints are answered as a whole: `sweep` only
  /// @return false, with nothing packed, if there are such rows that are not, compliant contacts, or a row
  /// that stands apart from the normal row that scales its bounds
  bool assign(const IslandSystem& system, bool joints = false, ThreadPool* threads = nullptr,
              bool lines = false);
  /// Rows give by so many times their own part of W, which bounds their impulses where what they want
  /// contradicts the rest: rows of joints, and of contacts. From the next `assign` on they do not.
  void soften(double joints, double contacts);

  std::size_t blocks() const { return blocks_.size(); }
  bool lined() const { return !lines_.empty(); }  ///< there are chains or trees that are long
  int rows() const { return rows_; }
  /// Scaled impulses (of joints: of the rows of Q), one vector a block, and scaled changes of velocity,
  /// one a body, and zeros for the ground and for lanes without a block. Whoever changes the
  /// first has to change the second with them, or `restart`.
  std::vector<Impulses>& impulses() { return impulses_; }
  std::vector<BodyVector>& velocities() { return velocities_; }

  void set(std::span<const double> lambda);  ///< clamped to the bounds; restarts
  void get(const std::vector<Impulses>& from, std::vector<double>& lambda) const;
  void restart();  ///< velocities from the impulses

  /// How many sweeps should be made at a time: more than one of large islands, whatever the number of
  /// threads, which are given one each.
  int together() const { return large() ? kTogether : 1; }
  /// Sweeps in the order of the blocks. @return largest change of a row's velocity in the last of them [m/s],
  /// an estimate of the residual
  double sweep(int count = 1);
  /// Two sweeps where only a share `load` of b is wanted: the first goes a share `take` of the way from the
  /// impulses to those that a row wants, the second all of it. `soften` does not count.
  void sweep_part(double load, double take);

  /// Largest violation of the natural map (islands/island_system.h) [m/s]; infinite where velocities are not
  /// finite. Where rows contradict each other, what is sure to be left of them counts: no more than that is
  /// known.
  double violation() const;
  bool contradicts() const { return contradiction_ > 0; }

 private:
  struct Kernels;
  struct Packing;  ///< block_packing.cpp
  static constexpr int kRows = 4;
  static constexpr int kTogether = 4;
  /// N or NN; NF or NFNF; other contacts; joints without bounds, and those that lines hold; other joints.
  enum class Pattern : std::uint8_t { Smooth, Rough, General, Held, Lined, Joint };
  struct Block {
    int a = 0, b_body = 0;
    int first = 0;     ///< row of a contact; of joints: -1 - its number in `joints_`
    int numbers = -1;  ///< in `numbers_`; -1: they are in its group only
    std::int16_t count = 0;
    Pattern pattern = Pattern::General;
  };
  /// What a block needs that is swept by itself.
  struct alignas(32) Numbers {
    BodyVector low[kRows], high[kRows];  ///< rows on both bodies
    Vec4 b;
    std::array<double, 6> couple{};     ///< W below its diagonal: 10, 20, 21, 30, 31, 32
    std::array<double, kRows> mu{};     ///< scaled
    std::array<double, kRows> speed{};  ///< D^1/2: of a change, as a velocity
    std::array<double, kRows> lower{}, upper{};
    std::array<std::int8_t, kRows> normal{-1, -1, -1, -1};
    int block = 0;
  };
  /// What else there is to know of a block of joint rows.
  struct JointBlock {
    int block = 0;
    int free = 0;                                      ///< rows without bounds, which come first
    std::array<int, kRows> row{};                      ///< of the system
    std::array<std::array<double, kRows>, kRows> L{};  ///< lower triangle
    std::array<double, kRows> keep{1, 1, 1, 1};        ///< 1 - compliance / (diagonal of W)
  };
  /// Four blocks of `N` rows, one a lane; lanes without a block have rows of zeros on the ground.
  struct alignas(32) Lanes {
    Vec4 v;
  };
  template <int N>
  struct Group {
    Lanes low[N][3], high[N][3];
    Lanes b[N], speed[N];
    Lanes mu[N];                                 ///< of joints: the diagonal of L
    Lanes couple[N == 1 ? 1 : N * (N - 1) / 2];  ///< W (of joints: L) below its diagonal, row by row
    std::array<int, 4> block;
    std::array<int, 4> a, b_body;   ///< where velocities are read
    std::array<int, 4> to_a, to_b;  ///< and written

    Group() {}  ///< leaves the numbers to `fill`: they are many
  };
  /// How rows give way in a sweep: not at all (joints may), by `soften`, or as `sweep_part` says.
  enum class Mode : std::uint8_t { Plain, Give, Part };
  /// The numbers for that, of which a mode reads its own.
  struct Manner {
    double joint_give = 1, contact_give = 1;
    double load = 1;            ///< share of b
    double take = 1, keep = 0;  ///< shares of what is wanted and of what was
  };
  /// Groups that go through the kernels in one way.
  enum class Kind : std::uint8_t {
    Rough4,
    Rough2,
    Smooth2,
    Smooth1,
    Held3,
    Held2,
    Held1,
    Lined3,
    Lined2,
    Lined1,
    Single
  };
  static constexpr int kKinds = 11;
  struct Batch {
    Kind kind;
    int first, count;  ///< groups of that kind, of single blocks those of the order
    int ordered;       ///< the first one in the order
  };
  /// Some batches. Lanes without a block write to one place a chunk: no two threads sweep the same.
  struct Chunk {
    int first, end;
  };

  static Kind kind_of(const Block& block);
  static int rows_of(Kind kind);
  bool add_blocks(const IslandSystem& system, bool joints);
  bool add_blocks_of_pieces(const IslandSystem& system, bool joints);
  static int end_of_block(const IslandSystem& system, int first, bool joints);
  static void set_block(const IslandSystem& system, int first, int end, Block& block);
  void add_numbers(std::size_t block);
  void add_joint_blocks(const IslandSystem& system, int first, int end);
  void close_joint(const IslandSystem& system, JointBlock& joint);
  const JointBlock& joint_of(std::size_t block) const {
    return joints_[static_cast<std::size_t>(-1 - blocks_[block].first)];
  }
  const Numbers& numbers_of(const Block& block) const {
    return numbers_[static_cast<std::size_t>(block.numbers)];
  }
  void choose_lines();
  void factor_lines();
  double scaled(std::span<const double> lambda, int row) const;
  void set_joint(const JointBlock& joint, std::span<const double> lambda);
  void get_joint(const JointBlock& joint, const Impulses& from, std::vector<double>& lambda) const;
  double violation_of(const JointBlock& joint) const;
  bool are_few() const;
  void arrange();
  void group();
  void push(std::size_t from, std::size_t to);
  bool large() const;
  /// Lines want a whole sweep before them.
  bool may_share() const {
    return threads_ != nullptr && threads_->threads() > 1 && large() && lines_.empty();
  }
  int at_the_same_time() const;
  template <Mode kMode, class MannerOf>
  double sweep_all(int count, const MannerOf& manner_of);
  template <Mode kMode>
  double sweep_some(const Manner& how, std::size_t from, std::size_t to);
  template <Mode kMode, class MannerOf>
  double sweep_alone(int count, const MannerOf& manner_of);
  template <Mode kMode, class MannerOf>
  double sweep_shared(int count, const MannerOf& manner_of);
  static ImpulseBounds bounds_of(const Numbers& numbers, const Impulses& impulses, int r);

  int rows_ = 0;
  std::vector<Block> blocks_;
  std::vector<Numbers> numbers_;
  std::vector<JointBlock> joints_;
  JointLines lines_;
  double joint_give_ = 1, contact_give_ = 1;  ///< of an impulse, what stays
  /// Of rows of one block that depend on each other, or that nothing can follow [m/s].
  double contradiction_ = 0;
  std::vector<double> root_;      ///< D^1/2 by row
  std::vector<BodyVector> mass_;  ///< M^-1/2 by body, and the ground's
  std::vector<Impulses> impulses_;
  std::vector<BodyVector> velocities_;
  SweepOrder order_;
  std::vector<Batch> batches_;
  std::vector<Chunk> chunks_;  ///< empty: one block after the other
  std::vector<Group<4>> groups4_;
  std::vector<Group<3>> groups3_;
  std::vector<Group<2>> groups2_;  ///< rough, smooth and held ones
  std::vector<Group<1>> groups1_;
  ThreadPool* threads_ = nullptr;
  bool shared_ = false;  ///< sweeps follow each other, one a thread
};

}  // namespace skerry
