// SPDX-License-Identifier: MIT
#include "physics/stepping/local_support.h"

#include <array>
#include <cmath>

#include "physics/index.h"
#include "physics/share_islands.h"
#include "physics/spare.h"
#include "physics/thread_pool.h"

namespace skerry {
namespace {

using Direction = std::array<double, 3>;

// A direction helps that has more than this of what is left; more rounds than this come to nothing.
constexpr double kHelps = 1e-13;
constexpr int kRounds = 50;
// Bodies that a thread takes at a time.
constexpr std::size_t kBodiesAPiece = 128;

double dot(const Direction& x, const Direction& y) {
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

/// Of the cone of some directions, each of length one, the point that is nearest to `w`.
class Cone {
 public:
  std::vector<Direction> directions;

  /// @return its distance; 0 where it is not found
  double distance(const Direction& w) {
    count_ = 0;
    Direction rest = w;
    const double length = std::sqrt(dot(w, w));
    for (int round = 0; round < kRounds; ++round) {
      int best = -1;
      double most = kHelps * length;
      for (int i = 0; i < static_cast<int>(directions.size()); ++i) {
        const double along = dot(directions[at(i)], rest);
        if (along > most && !is_in(i)) {
          most = along;
          best = i;
        }
      }
      if (best < 0) return std::sqrt(dot(rest, rest));
      if (count_ == 3) return 0;  // three of them span everything
      in_[at(count_)] = best;
      share_[at(count_++)] = 0;
      if (!improve(w)) return std::sqrt(dot(rest, rest));
      rest = w;
      for (int k = 0; k < count_; ++k)
        for (std::size_t c = 0; c < 3; ++c) rest[c] -= share_[at(k)] * directions[at(in_[at(k)])][c];
    }
    return 0;
  }

 private:
  bool is_in(int i) const {
    for (int k = 0; k < count_; ++k)
      if (in_[at(k)] == i) return true;
    return false;
  }

  /// Goes from the shares to those of the least squares of the directions that are in; what becomes negative
  /// on the way leaves. @return false if they depend on each other to rounding
  bool improve(const Direction& w) {
    while (count_ > 0) {
      std::array<double, 3> wanted;
      if (!least_squares(w, wanted)) {
        --count_;
        return false;
      }
      double step = 1;
      int leaves = -1;
      for (int k = 0; k < count_; ++k) {
        if (wanted[at(k)] > 0) continue;
        const double own = share_[at(k)] / (share_[at(k)] - wanted[at(k)]);
        if (!(own >= step)) {
          step = own;
          leaves = k;
        }
      }
      for (int k = 0; k < count_; ++k) share_[at(k)] += step * (wanted[at(k)] - share_[at(k)]);
      if (leaves < 0) return true;
      --count_;
      for (int k = leaves; k < count_; ++k) {
        in_[at(k)] = in_[at(k + 1)];
        share_[at(k)] = share_[at(k + 1)];
      }
    }
    return true;
  }

  /// By orthonormal directions, one after the other.
  bool least_squares(const Direction& w, std::array<double, 3>& shares) const {
    std::array<Direction, 3> q;
    std::array<std::array<double, 3>, 3> r{};
    for (int k = 0; k < count_; ++k) {
      Direction own = directions[at(in_[at(k)])];
      for (int pass = 0; pass < 2; ++pass) {
        for (int j = 0; j < k; ++j) {
          const double along = dot(q[at(j)], own);
          r[at(j)][at(k)] += along;
          for (std::size_t c = 0; c < 3; ++c) own[c] -= along * q[at(j)][c];
        }
      }
      const double length = std::sqrt(dot(own, own));
      if (!(length > kHelps)) return false;
      r[at(k)][at(k)] = length;
      for (std::size_t c = 0; c < 3; ++c) q[at(k)][c] = own[c] / length;
    }
    for (int k = count_; k-- > 0;) {
      shares[at(k)] = dot(q[at(k)], w);
      for (int j = k + 1; j < count_; ++j) shares[at(k)] -= r[at(k)][at(j)] * shares[at(j)];
      shares[at(k)] /= r[at(k)][at(k)];
    }
    return true;
  }

  int count_ = 0;
  std::array<int, 3> in_{};
  std::array<double, 3> share_{};
};

/// Rows by body.
struct RowsOfBodies {
  std::vector<int> first, row;
};

void find_rows(const IslandSystem& system, RowsOfBodies& rows) {
  rows.first.assign(system.bodies.size() + 1, 0);
  const auto visit = [&](auto&& take) {
    for (int i = 0; i < system.size(); ++i) {
      const Row& row = system.rows[at(i)];
      // Those of friction come with their normal rows.
      if (row.kind == RowKind::Friction) continue;
      for (const int body : {row.a, row.b})
        if (body >= 0) take(at(body), i);
    }
  };
  visit([&](std::size_t body, int) { ++rows.first[body + 1]; });
  for (std::size_t k = 0; k < system.bodies.size(); ++k) rows.first[k + 1] += rows.first[k];
  rows.row.resize(at(rows.first.back()));
  Spare<std::vector<int>> next;
  next->assign(rows.first.begin(), rows.first.end());
  visit([&](std::size_t body, int i) { rows.row[at((*next)[body]++)] = i; });
}

}  // namespace

bool each_can_be_stopped(const IslandSystem& system, const std::vector<Velocity>& free,
                         const std::vector<double>& radius, double slow, ThreadPool* threads) {
  Spare<RowsOfBodies> rows;
  find_rows(system, *rows);
  return !any_of(threads, system.bodies.size(), kBodiesAPiece, [&](std::size_t k) {
    const InverseMass& mass = system.bodies[k];
    Spare<Cone> cone;
    std::vector<Direction>& all = cone->directions;
    all.clear();
    const auto effect = [&](int i) {
      const Row& row = system.rows[at(i)];
      const std::array<double, 3>& J = row.a == static_cast<int>(k) ? row.Ja : row.Jb;
      return Direction{mass.linear * J[0], mass.linear * J[1], radius[k] * mass.angular * J[2]};
    };
    const auto add = [&](Direction x, double sign, const Direction& y) {
      for (std::size_t c = 0; c < 3; ++c) x[c] = sign * x[c] + y[c];
      const double length = std::sqrt(dot(x, x));
      if (!(length > 0)) return;
      for (double& component : x) component /= length;
      all.push_back(x);
    };
    for (int e = rows->first[k]; e < rows->first[k + 1]; ++e) {
      const int i = rows->row[at(e)];
      const Row& row = system.rows[at(i)];
      const Direction own = effect(i);
      if (row.kind != RowKind::Normal) {
        for (const double sign : {-1.0, 1.0}) add(own, sign, {});
      } else if (i + 1 < system.size() && system.rows[at(i + 1)].kind == RowKind::Friction &&
                 system.rows[at(i + 1)].normal == i) {
        const double mu = system.rows[at(i + 1)].mu;
        for (const double sign : {-mu, mu}) add(effect(i + 1), sign, own);
      } else {
        add(own, 1, {});
      }
    }
    const Velocity& v = free[k];
    return cone->distance({-v[0], -v[1], -radius[k] * v[2]}) > slow;
  });
}

}  // namespace skerry
