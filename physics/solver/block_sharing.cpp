// SPDX-License-Identifier: MIT
#include "physics/solver/block_sharing.h"

#include <algorithm>
#include <numeric>

#include "physics/index.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Below so many block updates, some 60 us, threads have no more done when they have met.
constexpr std::int64_t kWorthSharing = 20000;

// A subtree has at most one part in so many of the work, for each thread: so they come out even.
constexpr int kSubtreesAThread = 2;
// Panels for each thread, at least.
constexpr int kPanelsAThread = 8;

}  // namespace

void BlockSharing::plan(const BlockPattern& pattern, int threads) {
  threads_ = threads;
  begin_.assign(1, 0);
  column_.clear();
  top_.clear();
  if (threads < 2 || pattern.updates() < kWorthSharing) return;
  cut(pattern);
  // Wide panels read less, but others wait longer for them.
  panel_ = std::clamp(static_cast<int>(top_.size()) / (kPanelsAThread * threads), 1, kPanel);
  find_sources(pattern);
  part_rows(pattern);
}

// What is below a limit of work is a subtree of its own.
void BlockSharing::cut(const BlockPattern& pattern) {
  const int n = pattern.nodes();
  Spare<std::vector<double>> below;  // work of a column and all below it, in block updates
  below->assign(at(n), 0);
  double total = 0;
  for (int j = 0; j < n; ++j) {
    const double size = pattern.column_size(j), own = 0.5 * size * (size + 1) + 2 * size + 4;
    total += own;
    (*below)[at(j)] += own;
    if (const int parent = pattern.parent(j); parent >= 0) (*below)[at(parent)] += (*below)[at(j)];
  }
  const double limit = total / (kSubtreesAThread * threads_);
  // From the roots down, which have the highest numbers. A subtree has the number of its root at first.
  unit_.assign(at(n), -1);
  std::vector<int> roots;
  for (int j = n - 1; j >= 0; --j) {
    if ((*below)[at(j)] > limit) continue;
    const int parent = pattern.parent(j);
    if (parent >= 0 && unit_[at(parent)] >= 0) {
      unit_[at(j)] = unit_[at(parent)];
    } else {
      unit_[at(j)] = j;
      roots.push_back(j);
    }
  }
  std::stable_sort(roots.begin(), roots.end(),
                   [&](int a, int b) { return (*below)[at(a)] > (*below)[at(b)]; });
  std::vector<int> number(at(n), -1);
  for (std::size_t i = 0; i < roots.size(); ++i) number[at(roots[i])] = static_cast<int>(i);

  begin_.assign(roots.size() + 1, 0);
  for (int j = 0; j < n; ++j) {
    int& unit = unit_[at(j)];
    if (unit >= 0) {
      unit = number[at(unit)];
      ++begin_[at(unit) + 1];
    } else {
      unit = static_cast<int>(roots.size() + top_.size());
      top_.push_back(j);
    }
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  column_.resize(at(begin_.back()));
  std::vector<int> fill(begin_.begin(), begin_.end() - 1);
  inside_.resize(at(n));
  for (int j = 0; j < n; ++j) {
    const int unit = unit_[at(j)], first = pattern.begin_[at(j)], size = pattern.column_size(j);
    inside_[at(j)] = size;
    if (unit >= subtrees()) continue;
    column_[at(fill[at(unit)]++)] = j;
    const auto row = pattern.row_.begin() + first;
    inside_[at(j)] = static_cast<int>(
        std::partition_point(row, row + size, [&](int i) { return unit_[at(i)] == unit; }) - row);
  }
}

void BlockSharing::find_sources(const BlockPattern& pattern) {
  // Twice the same walk: how many there are, then which.
  const auto visit = [&](auto&& add) {
    for (int j = 0; j < pattern.nodes();) {
      const bool is_top = unit_[at(j)] >= subtrees();
      int count = pattern.alike(j);
      while ((unit_[at(j + count - 1)] >= subtrees()) != is_top) --count;
      // Above the subtrees to each other as well.
      for (int q = 1; is_top && q < count; ++q)
        add(unit_[at(j + q)] - subtrees(), Source{unit_[at(j + q - 1)], j + q - 1, 0, q});
      const int last = j + count - 1, first = pattern.begin_[at(last)];
      for (int k = is_top ? 0 : inside_[at(last)]; k < pattern.column_size(last); ++k)
        add(unit_[at(pattern.row_[at(first + k)])] - subtrees(), Source{unit_[at(last)], last, k, count});
      j += count;
    }
  };
  source_begin_.assign(top_.size() + 1, 0);
  visit([&](int target, const Source&) { ++source_begin_[at(target) + 1]; });
  std::partial_sum(source_begin_.begin(), source_begin_.end(), source_begin_.begin());
  source_.resize(at(source_begin_.back()));
  std::vector<int> fill(source_begin_.begin(), source_begin_.end() - 1);
  visit([&](int target, const Source& source) { source_[at(fill[at(target)]++)] = source; });
}

// Parts with as many blocks each, of rows in their order.
void BlockSharing::part_rows(const BlockPattern& pattern) {
  const int n = pattern.nodes();
  const auto first_outside = [&](int j) {
    return pattern.begin_[at(j)] + (unit_[at(j)] >= subtrees() ? 0 : inside_[at(j)]);
  };
  Spare<std::vector<std::int64_t>> blocks;  // in each row
  blocks->assign(at(n), 0);
  std::int64_t total = 0;
  for (int j = 0; j < n; ++j) {
    for (int p = first_outside(j); p < pattern.begin_[at(j) + 1]; ++p, ++total)
      ++(*blocks)[at(pattern.row_[at(p)])];
  }
  part_.assign(at(n), -1);
  std::int64_t before = 0;
  for (const int j : top_) {
    part_[at(j)] =
        total > 0 ? static_cast<int>(std::min<std::int64_t>(before * threads_ / total, threads_ - 1)) : 0;
    before += (*blocks)[at(j)];
  }
  // Twice the same walk: how many there are, then which.
  const auto visit = [&](auto&& add) {
    for (int j = 0; j < n; ++j) {
      const int end = pattern.begin_[at(j) + 1];
      int p = first_outside(j);
      if (part_[at(j)] >= 0) add(part_[at(j)], Piece{j, p, p});
      while (p < end) {
        const int first = p, part = part_[at(pattern.row_[at(p)])];
        while (p < end && part_[at(pattern.row_[at(p)])] == part) ++p;
        add(part, Piece{j, first, p});
      }
    }
  };
  part_begin_.assign(at(threads_) + 1, 0);
  visit([&](int part, const Piece&) { ++part_begin_[at(part) + 1]; });
  std::partial_sum(part_begin_.begin(), part_begin_.end(), part_begin_.begin());
  piece_.resize(at(part_begin_.back()));
  std::vector<int> fill(part_begin_.begin(), part_begin_.end() - 1);
  visit([&](int part, const Piece& piece) { piece_[at(fill[at(part)]++)] = piece; });
}

}  // namespace skerry
