// SPDX-License-Identifier: MIT
#include "physics/solver/block_pattern.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "physics/index.h"
#include "physics/large_pages.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Block updates a node from which on nested dissection is tried: it takes some 0.7 us a node, minimum degree
// 0.25, and an update 3 ns, of which it saves a twelfth to two fifths where bodies stand in rows. Heaps of
// thousands of bodies have a hundred and fewer, and their structure would gain nothing.
constexpr std::int64_t kManyUpdates = 150;

// What an analysis needs for a moment.
struct AnalysisVectors {
  std::vector<int> start, neighbour, fill, finish, mark, first_child, next_child, order;
};

// Sums of coordinates that are less are finite.
constexpr double kFarthest = 1e300;

bool are_finite(std::span<const Vec2> places) {
  return std::all_of(places.begin(), places.end(),
                     [](Vec2 p) { return std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest; });
}

}  // namespace

void BlockPattern::analyse(int nodes, std::span<const std::array<int, 2>> edges,
                           std::span<const Vec2> places) {
  const std::size_t n = at(nodes);
  // Adjacency in compressed form, both directions, sorted, without repeats.
  Spare<AnalysisVectors> vectors;
  std::vector<int>&start = vectors->start, &neighbour = vectors->neighbour, &fill = vectors->fill,
  &finish = vectors->finish;
  start.assign(n + 1, 0);
  neighbour.resize(2 * edges.size());
  for (const auto& e : edges) {
    ++start[at(e[0]) + 1];
    ++start[at(e[1]) + 1];
  }
  for (std::size_t i = 0; i < n; ++i) start[i + 1] += start[i];
  fill.assign(start.begin(), start.end() - 1);
  for (const auto& e : edges) {
    neighbour[at(fill[at(e[0])]++)] = e[1];
    neighbour[at(fill[at(e[1])]++)] = e[0];
  }
  finish.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto first = neighbour.begin() + start[i], last = neighbour.begin() + start[i + 1];
    std::sort(first, last);
    finish[i] = static_cast<int>(std::unique(first, last) - neighbour.begin());
  }

  // Fill-reducing order; a handful of nodes needs none.
  order_.resize(n);
  position_.resize(n);
  for (std::size_t i = 0; i < n; ++i) order_[i] = static_cast<int>(i);
  if (nodes > 3) {
    Eigen::SparseMatrix<double> graph(nodes, nodes);
    std::size_t entries = n;
    for (std::size_t i = 0; i < n; ++i) entries += at(finish[i] - start[i]);
    graph.reserve(static_cast<Eigen::Index>(entries));
    for (std::size_t j = 0; j < n; ++j) {
      const int column = static_cast<int>(j);
      graph.startVec(column);
      bool diagonal = false;
      for (int p = start[j]; p < finish[j]; ++p) {
        if (!diagonal && neighbour[at(p)] > column) {
          graph.insertBack(column, column) = 1;
          diagonal = true;
        }
        graph.insertBack(neighbour[at(p)], column) = 1;
      }
      if (!diagonal) graph.insertBack(column, column) = 1;
    }
    graph.finalize();
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
    Eigen::AMDOrdering<int>()(graph, permutation);
    for (std::size_t i = 0; i < n; ++i) order_[i] = permutation.indices()[static_cast<Eigen::Index>(i)];
  }
  const Adjacency graph{std::span(start).first(n), finish, neighbour};
  find_structure(graph);
  if (places.size() == n && count_updates() > kManyUpdates * nodes && are_finite(places)) {
    const std::int64_t updates = count_updates();
    vectors->order = order_;
    dissect(graph, places, position_, order_);
    find_structure(graph);
    if (count_updates() > updates) {
      order_.swap(vectors->order);
      find_structure(graph);
    }
  }

  // Where the outer product of each column goes.
  update_begin_.assign(n + 1, 0);
  for (std::size_t j = 0; j < n; ++j) {
    const std::int64_t d = begin_[j + 1] - begin_[j];
    update_begin_[j + 1] = update_begin_[j] + d * (d - 1) / 2;
  }
  resize_large(update_, static_cast<std::size_t>(update_begin_[n]));
  int* target = update_.data();
  for (std::size_t j = 0; j < n; ++j)
    for (int k = begin_[j]; k < begin_[j + 1]; ++k) {
      int p = begin_[at(row_[at(k)])];
      for (int i = k + 1; i < begin_[j + 1]; ++i) {
        while (row_[at(p)] < row_[at(i)]) ++p;
        *target++ = p;
      }
    }
}

// The structure of L: column j has its own neighbours and what its children in the elimination tree hand up.
void BlockPattern::find_structure(const Adjacency& graph) {
  const std::size_t n = order_.size();
  for (std::size_t i = 0; i < n; ++i) position_[at(order_[i])] = static_cast<int>(i);
  Spare<AnalysisVectors> vectors;
  std::vector<int>&mark = vectors->mark, &first_child = vectors->first_child,
  &next_child = vectors->next_child;
  for (std::vector<int>* list : {&mark, &first_child, &next_child}) list->assign(n, -1);
  begin_.assign(n + 1, 0);
  row_.clear();
  for (std::size_t j = 0; j < n; ++j) {
    const int column = static_cast<int>(j);
    mark[j] = column;
    const std::size_t first = row_.size();
    const std::size_t node = at(order_[j]);
    for (int p = graph.start[node]; p < graph.finish[node]; ++p) {
      const int i = position_[at(graph.neighbour[at(p)])];
      if (i > column && mark[at(i)] != column) {
        mark[at(i)] = column;
        row_.push_back(i);
      }
    }
    for (int child = first_child[j]; child >= 0; child = next_child[at(child)])
      for (int p = begin_[at(child)]; p < begin_[at(child) + 1]; ++p) {
        const int i = row_[at(p)];
        if (mark[at(i)] != column) {
          mark[at(i)] = column;
          row_.push_back(i);
        }
      }
    std::sort(row_.begin() + static_cast<std::ptrdiff_t>(first), row_.end());
    begin_[j + 1] = static_cast<int>(row_.size());
    if (row_.size() > first) {
      const std::size_t parent = at(row_[first]);
      next_child[j] = first_child[parent];
      first_child[parent] = column;
    }
  }
}

std::int64_t BlockPattern::count_updates() const {
  std::int64_t count = 0;
  for (int j = 0; j < nodes(); ++j) count += std::int64_t{column_size(j)} * (column_size(j) - 1) / 2;
  return count;
}

int BlockPattern::alike(int j) const {
  int count = 1;
  while (count < kMostAlike && column_size(j + count - 1) > 0 && parent(j + count - 1) == j + count &&
         column_size(j + count) + 1 == column_size(j + count - 1))
    ++count;
  return count;
}

int BlockPattern::block(int low, int high) const {
  const auto first = row_.begin() + begin_[at(low)], last = row_.begin() + begin_[at(low) + 1];
  const auto it = std::lower_bound(first, last, high);
  return it != last && *it == high ? static_cast<int>(it - row_.begin()) : -1;
}

}  // namespace skerry
