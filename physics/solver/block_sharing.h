// SPDX-License-Identifier: MIT
//
// How threads share an elimination. Subtrees of the elimination tree know nothing of each other, so each is
// one thread's; the columns above them all are taken a few at a time, in ascending order, and what is to be
// subtracted from such columns is fetched, in the order of one thread: the bits are the same
// [Liu 1986; Heath, Ng & Peyton 1991, sec. 4].
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "physics/solver/block_pattern.h"

namespace skerry {

class BlockSharing {
 public:
  /// Columns that are alike: `last`, which is done with its unit and after the `count` - 1 before it, from
  /// row number `k` of `last` on.
  struct Source {
    int unit, last, k, count;
  };
  /// Blocks `first` to `end` - 1 of the pattern, of column `column`, in rows above the subtrees.
  struct Piece {
    int column, first, end;
  };

  /// Plans for so many threads; nothing where that would not pay.
  void plan(const BlockPattern& pattern, int threads);
  void clear() { threads_ = 0; }
  /// Of the last plan; 0: there is none.
  int threads() const { return threads_; }
  bool pays() const { return !top_.empty(); }

  int subtrees() const { return static_cast<int>(begin_.size()) - 1; }
  /// Columns of subtree `i`, ascending; the subtrees with most work come first.
  std::span<const int> subtree(int i) const {
    const auto b = static_cast<std::size_t>(begin_[static_cast<std::size_t>(i)]),
               e = static_cast<std::size_t>(begin_[static_cast<std::size_t>(i) + 1]);
    return std::span(column_).subspan(b, e - b);
  }
  /// Columns above the subtrees, ascending.
  const std::vector<int>& top() const { return top_; }
  /// What others wait for: a subtree, or a column above them.
  std::size_t units() const { return begin_.size() - 1 + top_.size(); }
  /// Columns above the subtrees that are one task, at most: a source is read once for all of them.
  static constexpr int kPanel = 4;
  /// Numbers in `top()` of the first column of panel `i` and of the one behind its last.
  std::array<int, 2> panel(int i) const {
    return {i * panel_, std::min((i + 1) * panel_, static_cast<int>(top_.size()))};
  }
  /// Subtrees, and panels.
  std::size_t tasks() const {
    const auto panel = static_cast<std::size_t>(panel_);
    return begin_.size() - 1 + (top_.size() + panel - 1) / panel;
  }
  /// Number of rows of column `j` that are columns of its subtree; they come first. Of a column above them:
  /// all.
  int inside(int j) const { return inside_[static_cast<std::size_t>(j)]; }
  /// The columns above the subtrees as rows of L, in as many parts as threads: all pieces of part `i`,
  /// ascending, with an empty one in front of those of a column whose own row is in the part.
  std::span<const Piece> part(int i) const {
    const auto b = static_cast<std::size_t>(part_begin_[static_cast<std::size_t>(i)]),
               e = static_cast<std::size_t>(part_begin_[static_cast<std::size_t>(i) + 1]);
    return std::span(piece_).subspan(b, e - b);
  }
  /// The part that has the row of column `j`; -1 in a subtree.
  int part_of(int j) const { return part_[static_cast<std::size_t>(j)]; }
  /// What is subtracted from `top()[i]`, ascending.
  std::span<const Source> sources(int i) const {
    const auto b = static_cast<std::size_t>(source_begin_[static_cast<std::size_t>(i)]),
               e = static_cast<std::size_t>(source_begin_[static_cast<std::size_t>(i) + 1]);
    return std::span(source_).subspan(b, e - b);
  }

 private:
  void cut(const BlockPattern& pattern);
  void find_sources(const BlockPattern& pattern);
  void part_rows(const BlockPattern& pattern);

  int threads_ = 0, panel_ = 1;
  std::vector<int> begin_{0}, column_, top_, inside_, unit_;
  std::vector<int> source_begin_;
  std::vector<Source> source_;
  std::vector<int> part_, part_begin_;
  std::vector<Piece> piece_;
};

}  // namespace skerry
