// SPDX-License-Identifier: MIT
#include "physics/stepping/bilateral_forces.h"

#include <algorithm>
#include <cmath>

#include "physics/index.h"

namespace skerry {
namespace {

constexpr int kBlockRows = 3;
// Couplings for each joint; a chain has one, and beyond this the body graph is sparser than that of the
// joints.
constexpr std::size_t kMostCouplings = 3;
// A pivot that cancellation has made this small against its diagonal leaves fewer digits than forces need.
constexpr double kDependent = 1e-9;
// Error relative to b that needs no refinement, and the largest that is an answer.
constexpr double kFine = 1e-14, kUsable = 1e-9;

double product(const std::array<double, 3>& x, const InverseMass& m, const std::array<double, 3>& y) {
  return m.linear * (x[0] * y[0] + x[1] * y[1]) + m.angular * x[2] * y[2];
}

}  // namespace

bool BilateralForces::analyse(std::size_t bodies, std::span<const Row> rows, SolveWork& work) {
  found_.clear();
  for (int i = 0; i < static_cast<int>(rows.size()); ++i) {
    const Row& row = rows[at(i)];
    if (!found_.empty() && found_.back().count < kBlockRows && found_.back().a == row.a &&
        found_.back().b == row.b)
      ++found_.back().count;
    else
      found_.push_back({i, 1, row.a, row.b, 0});
  }
  const bool same =
      bodies == bodies_ && found_.size() == joints_.size() &&
      std::equal(found_.begin(), found_.end(), joints_.begin(), [](const Joint& x, const Joint& y) {
        return x.count == y.count && x.a == y.a && x.b == y.b;
      });
  if (same) {
    ++work.symbolic_skipped;
    return fits_;
  }
  joints_.swap(found_);
  bodies_ = bodies;
  // Joints by body, the lists one behind the other.
  std::vector<std::vector<std::pair<int, bool>>> of(bodies);
  for (int j = 0; j < static_cast<int>(joints_.size()); ++j) {
    if (joints_[at(j)].a >= 0) of[at(joints_[at(j)].a)].push_back({j, false});
    if (joints_[at(j)].b >= 0) of[at(joints_[at(j)].b)].push_back({j, true});
  }
  std::size_t pairs = 0;
  for (const auto& list : of) pairs += list.size() * (list.size() - (list.empty() ? 0 : 1)) / 2;
  fits_ = pairs <= kMostCouplings * joints_.size();
  if (!fits_) return false;
  std::vector<std::array<int, 2>> edges;
  couplings_.clear();
  for (const auto& list : of) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      for (std::size_t k = i + 1; k < list.size(); ++k) {
        edges.push_back({list[i].first, list[k].first});
        couplings_.push_back({list[i].first, list[k].first, list[i].second, list[k].second, 0});
      }
    }
  }
  pattern_.analyse(static_cast<int>(joints_.size()), edges);
  factor_.set_pattern(pattern_);
  ++work.symbolic_analyses;
  for (int j = 0; j < static_cast<int>(joints_.size()); ++j) joints_[at(j)].place = pattern_.position(j);
  for (Coupling& c : couplings_) {
    if (joints_[at(c.low)].place > joints_[at(c.high)].place) {
      std::swap(c.low, c.high);
      std::swap(c.low_b, c.high_b);
    }
    c.block = pattern_.block(joints_[at(c.low)].place, joints_[at(c.high)].place);
  }
  return true;
}

bool BilateralForces::factor(std::span<const InverseMass> bodies, std::span<const Row> rows,
                             SolveWork& work) {
  factor_.clear(false);
  for (const Joint& joint : joints_) {
    Block3& D = factor_.diagonal(joint.place);
    for (int i = 0; i < kBlockRows; ++i) {
      if (i >= joint.count) {
        D.column[i][i] = 1;
        continue;
      }
      const Row& x = rows[at(joint.first + i)];
      for (int k = 0; k <= i; ++k) {
        const Row& y = rows[at(joint.first + k)];
        double w = 0;
        if (joint.a >= 0) w += product(x.Ja, bodies[at(joint.a)], y.Ja);
        if (joint.b >= 0) w += product(x.Jb, bodies[at(joint.b)], y.Jb);
        D.column[k][i] = D.column[i][k] = w;
      }
      whole_[at(joint.first + i)] = D.column[i][i];
    }
  }
  for (const Coupling& c : couplings_) {
    const Joint& low = joints_[at(c.low)];
    const Joint& high = joints_[at(c.high)];
    const InverseMass& mass = bodies[at(c.low_b ? low.b : low.a)];
    Block3& B = factor_.lower(c.block);
    for (int k = 0; k < low.count; ++k) {
      const Row& y = rows[at(low.first + k)];
      for (int i = 0; i < high.count; ++i) {
        const Row& x = rows[at(high.first + i)];
        B.column[k][i] += product(c.high_b ? x.Jb : x.Ja, mass, c.low_b ? y.Jb : y.Ja);
      }
    }
  }
  ++work.factorisations;
  if (!factor_.factor()) return false;
  // The diagonal holds inverse pivots now.
  for (const Joint& joint : joints_) {
    const Block3& D = factor_.diagonal(joint.place);
    for (int i = 0; i < joint.count; ++i) {
      if (!(D.column[i][i] * whole_[at(joint.first + i)] < 1 / kDependent)) return false;
    }
  }
  return true;
}

/// lambda += W^-1 r
void BilateralForces::add_solution(const std::vector<double>& r, std::vector<double>& lambda) {
  for (const Joint& joint : joints_) {
    Vec4 x{};
    for (int i = 0; i < joint.count; ++i) x[i] = r[at(joint.first + i)];
    x_[at(joint.place)].v = x;
  }
  factor_.solve(x_.data());
  for (const Joint& joint : joints_) {
    for (int i = 0; i < joint.count; ++i) lambda[at(joint.first + i)] += x_[at(joint.place)].v[i];
  }
}

/// r = b - W lambda by way of the bodies. @return its largest magnitude; NaN where it has one
double BilateralForces::remainder(std::span<const InverseMass> bodies, std::span<const Row> rows,
                                  const std::vector<double>& lambda, std::vector<double>& r) {
  velocity_.assign(bodies.size(), {});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    if (row.a >= 0) push(bodies[at(row.a)], row.Ja, lambda[i], velocity_[at(row.a)]);
    if (row.b >= 0) push(bodies[at(row.b)], row.Jb, lambda[i], velocity_[at(row.b)]);
  }
  double worst = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    r[i] = row.wanted;
    if (row.a >= 0) r[i] -= along(row.Ja, velocity_[at(row.a)]);
    if (row.b >= 0) r[i] -= along(row.Jb, velocity_[at(row.b)]);
    // A comparison that NaN fails must not hide it.
    if (!(std::abs(r[i]) <= worst)) worst = std::abs(r[i]);
  }
  return worst;
}

bool BilateralForces::solve(std::span<const InverseMass> bodies, std::span<const Row> rows, SolveWork& work,
                            std::vector<double>& lambda) {
  if (!analyse(bodies.size(), rows, work)) return false;
  const std::size_t n = rows.size();
  whole_.resize(n);
  r_.resize(n);
  x_.resize(joints_.size());
  if (!factor(bodies, rows, work)) return false;
  double scale = 0;
  for (std::size_t i = 0; i < n; ++i) {
    r_[i] = rows[i].wanted;
    scale = std::max(scale, std::abs(r_[i]));
  }
  lambda.assign(n, 0);
  if (scale == 0) return true;
  // One refinement takes out what the factor rounded.
  double error = kInfinity;
  for (int step = 0; step < 2 && !(error <= kFine * scale); ++step) {
    add_solution(r_, lambda);
    ++work.resolves;
    error = remainder(bodies, rows, lambda, r_);
  }
  return error <= kUsable * scale;
}

}  // namespace skerry
