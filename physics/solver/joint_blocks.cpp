// SPDX-License-Identifier: MIT
//
// Blocks of joint rows for Gauss-Seidel sweeps: which rows make one, and their orthonormal combinations.
#include <algorithm>
#include <cmath>

#include "physics/index.h"
#include "physics/solver/block_sweeps.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// What is left of a unit row less than this, squared, after others of its block is rounding.
constexpr double kDependent = 1e-13;

/// A row that holds both ways and does not give.
bool is_free(const IslandSystem& system, int i) {
  const Row& row = system.rows[at(i)];
  return row.lower == -kInfinity && row.upper == kInfinity &&
         (system.compliance.empty() || system.compliance[at(i)] == 0);
}

}  // namespace

/// Joint rows `first` up to `end` of the same two bodies: those without bounds first, as the others are made
/// orthogonal to them.
void BlockSweeps::add_joint_blocks(const IslandSystem& system, int first, int end) {
  int count = kRows;
  for (const bool free : {true, false}) {
    for (int i = first; i < end; ++i) {
      if (is_free(system, i) != free) continue;
      if (count == kRows) {
        set_block(system, first, first, blocks_.emplace_back());
        blocks_.back().first = -1 - static_cast<int>(joints_.size());
        add_numbers(blocks_.size() - 1);
        joints_.emplace_back().block = static_cast<int>(blocks_.size()) - 1;
        count = 0;
      }
      joints_.back().row[at(count++)] = i;
      joints_.back().free += free;
      blocks_.back().count = static_cast<std::int16_t>(count);
    }
  }
}

/// Fills in the numbers of a block of joint rows.
void BlockSweeps::close_joint(const IslandSystem& system, JointBlock& joint) {
  Block& block = blocks_[at(joint.block)];
  Numbers& numbers = numbers_[at(block.numbers)];
  numbers.b = Vec4{};
  int free = 0;
  for (int r = 0; r < block.count; ++r) {
    const int i = joint.row[at(r)];
    const Row& row = system.rows[at(i)];
    BodyVector low{Vec4{row.Ja[0], row.Ja[1], row.Ja[2], 0} * mass_[at(block.a)].v};
    BodyVector high{Vec4{row.Jb[0], row.Jb[1], row.Jb[2], 0} * mass_[at(block.b_body)].v};
    const double soft = system.compliance.empty() ? 0 : system.compliance[at(i)];
    const double D = dot3(low, low) + dot3(high, high) + soft;
    const double root = std::sqrt(D), inverse = D > 0 ? 1 / root : 0;
    root_[at(i)] = root;
    numbers.speed[at(r)] = root;
    low.v *= inverse;
    high.v *= inverse;
    double b = inverse * system.b[at(i)];
    // Twice, for what rounding leaves of rows that nearly depend on each other.
    std::array<double, kRows>& L = joint.L[at(r)];
    for (int pass = 0; pass < 2; ++pass) {
      for (int c = 0; c < free; ++c) {
        const double share = dot3(low, numbers.low[c]) + dot3(high, numbers.high[c]);
        low.v -= share * numbers.low[c].v;
        high.v -= share * numbers.high[c].v;
        b -= share * numbers.b[c];
        L[at(c)] += share;
      }
    }
    const double stiff = dot3(low, low) + dot3(high, high), rest = stiff + inverse * inverse * soft;
    const bool depends = !(rest > kDependent);
    if (depends) {
      // The others hold it, or nothing can: then it counts whole, if it asks for an impulse that it may have.
      const double wanted = system.b[at(i)];
      const bool asks = wanted > 0 ? row.upper > 0 : wanted < 0 && row.lower < 0;
      const double left = D > 0  ? root * std::abs(std::clamp(b, root * row.lower, root * row.upper))
                          : asks ? std::abs(wanted)
                                 : 0;
      contradiction_ = std::max(contradiction_, left);
      low = high = BodyVector{};
      b = 0;
    }
    const double length = depends ? 0 : std::sqrt(rest), shrink = depends ? 0 : 1 / length;
    L[at(r)] = length;
    numbers.low[r].v = shrink * low.v;
    numbers.high[r].v = shrink * high.v;
    numbers.b[r] = shrink * b;
    joint.keep[at(r)] = depends ? 1 : stiff / rest;
    if (is_free(system, i)) ++free;
    numbers.lower[at(r)] = depends ? 0 : length * root * row.lower;
    numbers.upper[at(r)] = depends ? 0 : length * root * row.upper;
  }
  block.pattern = free == block.count ? Pattern::Held : Pattern::Joint;
  std::size_t entry = 0;
  for (int r = 1; r < block.count; ++r) {
    for (int c = 0; c < r; ++c, ++entry) {
      if (c >= free)
        numbers.couple[entry] = dot3(numbers.low[r], numbers.low[c]) + dot3(numbers.high[r], numbers.high[c]);
    }
  }
}

/// Joints whose rows without bounds may be of a line.
void BlockSweeps::choose_lines() {
  Spare<std::vector<JointLines::Joint>> all;
  for (const JointBlock& joint : joints_) {
    const Block& block = blocks_[at(joint.block)];
    if (joint.free > 0) all->push_back({joint.block, block.a, block.b_body, joint.free});
  }
  lines_.choose(*all, static_cast<int>(mass_.size()) - 1);
}

/// Joints that have nothing but rows of a line need not be swept.
void BlockSweeps::factor_lines() {
  if (lines_.empty()) return;
  for (std::size_t k = 0; k < lines_.joints().size(); ++k) {
    const Numbers& numbers = numbers_of(blocks_[at(lines_.joints()[k].block)]);
    lines_.take(k, {numbers.b, numbers.low, numbers.high, numbers.speed.data()});
  }
  Spare<std::vector<std::uint8_t>> held;
  lines_.eliminate(0, *held);
  for (std::size_t k = 0; k < lines_.joints().size(); ++k) {
    Block& block = blocks_[at(lines_.joints()[k].block)];
    if ((*held)[k] != 0 && block.pattern == Pattern::Held) block.pattern = Pattern::Lined;
  }
}

/// Impulses of Q are L' lambda; bounded rows, which are clamped, have a diagonal there only.
void BlockSweeps::set_joint(const JointBlock& joint, std::span<const double> lambda) {
  const std::size_t k = at(joint.block);
  const Numbers& numbers = numbers_of(blocks_[k]);
  for (int r = 0; r < blocks_[k].count; ++r) {
    const std::array<double, kRows>& L = joint.L[at(r)];
    const double length = L[at(r)];
    if (!(length > 0)) continue;
    const double x =
        std::clamp(length * scaled(lambda, joint.row[at(r)]), numbers.lower[at(r)], numbers.upper[at(r)]) /
        length;
    for (int c = 0; c <= r; ++c) impulses_[k].v[c] += L[at(c)] * x;
  }
}

void BlockSweeps::get_joint(const JointBlock& joint, const Impulses& from,
                            std::vector<double>& lambda) const {
  std::array<double, kRows> x{};
  for (int r = 0; r < kRows; ++r) x[at(r)] = from.v[r];
  for (int r = blocks_[at(joint.block)].count - 1; r >= 0; --r) {
    const std::array<double, kRows>& L = joint.L[at(r)];
    const std::size_t row = at(joint.row[at(r)]);
    const double own = L[at(r)] > 0 ? x[at(r)] / L[at(r)] : 0;
    for (int c = 0; c < r; ++c) x[at(c)] -= L[at(c)] * own;
    lambda[row] = root_[row] > 0 ? own / root_[row] : 0;
  }
}

/// Largest violation of the natural map of the rows of a joint block [m/s].
double BlockSweeps::violation_of(const JointBlock& joint) const {
  const std::size_t k = at(joint.block);
  const Block& block = blocks_[k];
  const Numbers& numbers = numbers_of(block);
  double worst = 0;
  std::array<double, kRows> w{};
  for (int r = 0; r < block.count; ++r) {
    const double x = impulses_[k].v[r], length = joint.L[at(r)][at(r)];
    if (!(length > 0)) continue;
    w[at(r)] = dot3(numbers.low[r], velocities_[at(block.a)]) +
               dot3(numbers.high[r], velocities_[at(block.b_body)]) + (1 - joint.keep[at(r)]) * x -
               numbers.b[r];
    double own = 0;
    for (int c = 0; c <= r; ++c) own += joint.L[at(r)][at(c)] * w[at(c)];
    // As for contacts, of the row as it was before it was combined.
    const double low = (x - numbers.upper[at(r)]) / length, high = (x - numbers.lower[at(r)]) / length;
    worst = std::max(worst, numbers.speed[at(r)] * std::abs(std::min(std::max(own, low), high)));
  }
  return worst;
}

}  // namespace skerry
