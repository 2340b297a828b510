// SPDX-License-Identifier: MIT
#include "physics/solver/local_update.h"

#include <algorithm>
#include <cmath>

#include "physics/index.h"

namespace skerry {
namespace {

constexpr int kSide = 3 * LocalUpdate::kMostNodes;

std::size_t entry(int row, int column) {
  return at(column) * at(kSide) + at(row);
}
std::size_t dense(int row, int column) {
  return at(column) * at(LocalUpdate::kMostRows) + at(row);
}

double dot(const BodyVector& x, const BodyVector& y) {
  return x.v[0] * y.v[0] + x.v[1] * y.v[1] + x.v[2] * y.v[2];
}

}  // namespace

void LocalUpdate::reset() {
  rows_.clear();
  place_.clear();
  nodes_.clear();
  known_ = 0;
  active_ = false;
}

void LocalUpdate::start() {
  G_.resize(at(kSide) * at(kSide));
  lu_.resize(at(kMostRows) * at(kMostRows));
  rows_.clear();
  place_.clear();
  active_ = false;
}

int LocalUpdate::node(int position) {
  if (position < 0) return -1;
  const auto number = std::find(nodes_.begin(), nodes_.end(), position) - nodes_.begin();
  if (at(static_cast<int>(number)) == nodes_.size()) nodes_.push_back(position);
  return static_cast<int>(number);
}

bool LocalUpdate::add(const Row& row) {
  if (rows_.size() == at(kMostRows)) return false;
  const std::size_t before = nodes_.size();
  place_.push_back({node(row.low), node(row.high)});
  if (nodes_.size() > at(kMostNodes)) {
    nodes_.resize(before);
    return false;
  }
  rows_.push_back(row);
  return true;
}

bool LocalUpdate::finish(const BlockPattern& pattern, const BlockFactor& factor) {
  const int count = static_cast<int>(nodes_.size());
  visited_ = 0;
  if (known_ < count) {
    // The paths of all nodes to the root.
    slot_.assign(at(pattern.nodes()), -1);
    columns_.clear();
    for (const int start : nodes_)
      for (int j = start; j >= 0 && slot_[at(j)] < 0; j = pattern.parent(j)) {
        slot_[at(j)] = 0;
        columns_.push_back(j);
      }
    std::sort(columns_.begin(), columns_.end());
    double blocks = 0;
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      slot_[at(columns_[k])] = static_cast<int>(k);
      blocks += pattern.column_size(columns_[k]);
    }
    paths_.resize(columns_.size());
    // G is symmetric where the factor is; otherwise old columns lack the rows of new nodes.
    const int first = factor.is_general() ? 0 : known_;
    for (int j = first; j < count; ++j) {
      factor.solve_unit(columns_, slot_, nodes_[at(j)], paths_.data());
      visited_ += 2 * blocks;
      for (int i = 0; i < count; ++i) {
        const Block3& transposed = paths_[at(slot_[at(nodes_[at(i)])])];
        for (int c = 0; c < 3; ++c)
          for (int r = 0; r < 3; ++r) {
            const double g = transposed.column[r][c];
            G_[entry(3 * i + r, 3 * j + c)] = g;
            if (first > 0) G_[entry(3 * j + c, 3 * i + r)] = g;
          }
      }
    }
    known_ = count;
  }
  active_ = factor_dense();
  return active_;
}

bool LocalUpdate::factor_dense() {
  const int n = static_cast<int>(rows_.size());
  // R G C^T by way of G C^T of one row, at all nodes.
  std::vector<BodyVector>& velocity = velocity_;
  velocity.resize(nodes_.size());
  for (int j = 0; j < n; ++j) {
    std::fill(velocity.begin(), velocity.end(), BodyVector{});
    add_response(j, 1, velocity.data());
    for (int i = 0; i < n; ++i) {
      double sum = i == j ? 1 / rows_[at(i)].size : 0;
      if (place_[at(i)][0] >= 0) sum += dot(rows_[at(i)].R_low, velocity[at(place_[at(i)][0])]);
      if (place_[at(i)][1] >= 0) sum += dot(rows_[at(i)].R_high, velocity[at(place_[at(i)][1])]);
      lu_[dense(i, j)] = sum;
    }
  }
  // LU with partial pivoting, whole rows exchanged.
  pivot_.resize(at(n));
  for (int k = 0; k < n; ++k) {
    double* const column = &lu_[dense(0, k)];
    int best = k;
    for (int i = k + 1; i < n; ++i)
      if (std::fabs(column[i]) > std::fabs(column[best])) best = i;
    pivot_[at(k)] = best;
    if (!(std::fabs(column[best]) > 0) || !std::isfinite(column[best])) return false;
    if (best != k)
      for (int j = 0; j < n; ++j) std::swap(lu_[dense(k, j)], lu_[dense(best, j)]);
    const double inverse = 1 / column[k];
    for (int i = k + 1; i < n; ++i) column[i] *= inverse;
    for (int j = k + 1; j < n; ++j) {
      double* const to = &lu_[dense(0, j)];
      const double factor = to[k];
      if (factor == 0) continue;
      for (int i = k + 1; i < n; ++i) to[i] -= column[i] * factor;
    }
  }
  return true;
}

// Adds the velocities of the nodes that an impulse at a row gives.
void LocalUpdate::add_response(int row, double impulse, BodyVector* velocity) const {
  const Row& from = rows_[at(row)];
  for (const bool high : {false, true}) {
    const int place = place_[at(row)][high];
    if (place < 0) continue;
    for (int c = 0; c < 3; ++c) {
      const double s = (high ? from.C_high : from.C_low).v[c] * impulse;
      const double* const g = &G_[entry(0, 3 * place + c)];
      for (std::size_t k = 0; k < nodes_.size(); ++k)
        velocity[k].v += Vec4{g[3 * k], g[3 * k + 1], g[3 * k + 2], 0} * s;
    }
  }
}

void LocalUpdate::respond(const std::vector<double>& z, BodyVector* v) const {
  velocity_.assign(nodes_.size(), BodyVector{});
  for (std::size_t i = 0; i < rows_.size(); ++i)
    if (z[i] != 0) add_response(static_cast<int>(i), z[i], velocity_.data());
  for (std::size_t k = 0; k < nodes_.size(); ++k) v[nodes_[k]] = velocity_[k];
}

void LocalUpdate::solve(const BodyVector* x, std::vector<double>& z) const {
  const int n = static_cast<int>(rows_.size());
  for (int i = 0; i < n; ++i) {
    const Row& row = rows_[at(i)];
    double sum = z[at(i)] / row.size;
    if (x != nullptr && row.low >= 0) sum -= dot(row.R_low, x[row.low]);
    if (x != nullptr && row.high >= 0) sum -= dot(row.R_high, x[row.high]);
    z[at(i)] = sum;
  }
  for (int k = 0; k < n; ++k) std::swap(z[at(k)], z[at(pivot_[at(k)])]);
  for (int k = 0; k < n; ++k)
    for (int i = k + 1; i < n; ++i) z[at(i)] -= lu_[dense(i, k)] * z[at(k)];
  for (int k = n - 1; k >= 0; --k) {
    z[at(k)] /= lu_[dense(k, k)];
    for (int i = 0; i < k; ++i) z[at(i)] -= lu_[dense(i, k)] * z[at(k)];
  }
}

}  // namespace skerry
