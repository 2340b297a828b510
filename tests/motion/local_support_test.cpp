// SPDX-License-Identifier: MIT
//
// Whether what touches a body could stop it, against all faces of the cone of what its rows can do.
#include "physics/stepping/local_support.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "physics/thread_pool.h"

namespace skerry {
namespace local_support_test {

using Direction = Eigen::Vector3d;

/// Distance of a point to the cone of some directions: the nearest point lies in the span of three of them at
/// most, with positive shares, and there the others do not lead nearer.
double distance_by_faces(const std::vector<Direction>& all, const Direction& w) {
  const int n = static_cast<int>(all.size());
  double least = w.norm();
  const auto try_face = [&](const std::vector<int>& face) {
    Eigen::MatrixXd A(3, face.size());
    for (std::size_t k = 0; k < face.size(); ++k)
      A.col(static_cast<int>(k)) = all[static_cast<std::size_t>(face[k])];
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
    if (qr.rank() < static_cast<int>(face.size())) return;
    const Eigen::VectorXd shares = qr.solve(w);
    if (shares.minCoeff() >= -1e-12) least = std::min(least, (w - A * shares).norm());
  };
  for (int i = 0; i < n; ++i) {
    try_face({i});
    for (int j = i + 1; j < n; ++j) {
      try_face({i, j});
      for (int k = j + 1; k < n; ++k) try_face({i, j, k});
    }
  }
  return least;
}

/// A body with some rows, and the directions in which they act, its ends at `radius`.
struct Sample {
  IslandSystem system;
  std::vector<Direction> directions;

  void add(RowKind kind, std::array<double, 3> J, double mu, double radius, bool as_b) {
    Row row;
    row.kind = kind;
    (as_b ? row.b : row.a) = 0;
    (as_b ? row.Jb : row.Ja) = J;
    row.mu = mu;
    if (kind == RowKind::Friction) row.normal = system.size() - 1;
    if (kind == RowKind::Joint) row.lower = -kInfinity;
    system.rows.push_back(row);
    const InverseMass& mass = system.bodies[0];
    effects_.emplace_back(mass.linear * J[0], mass.linear * J[1], radius * mass.angular * J[2]);
  }
  void close() {
    for (std::size_t i = 0; i < effects_.size(); ++i) {
      const bool rough = i + 1 < effects_.size() && system.rows[i + 1].kind == RowKind::Friction;
      switch (system.rows[i].kind) {
        case RowKind::Normal:
          if (!rough) directions.push_back(effects_[i]);
          break;
        case RowKind::Friction:
          for (const double sign : {-1.0, 1.0})
            directions.push_back(effects_[i - 1] + sign * system.rows[i].mu * effects_[i]);
          break;
        default:
          for (const double sign : {-1.0, 1.0}) directions.push_back(sign * effects_[i]);
      }
    }
  }

 private:
  std::vector<Direction> effects_;
};

TEST(LocalSupport, IsTheDistanceToTheConeOfWhatRowsCanDo) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  int held = 0, free = 0;
  for (int sample = 0; sample < 20000; ++sample) {
    SCOPED_TRACE("sample " + std::to_string(sample));
    Sample one;
    one.system.bodies.push_back({1 + 0.9 * number(random), 3 + 2 * number(random)});
    const double radius = 0.5 + 0.4 * number(random);
    const int points = static_cast<int>(random() % 5);
    for (int k = 0; k < points; ++k) {
      // Coordinates that coincide: parallel normals, equal arms, points twice.
      const double angle =
          random() % 2 == 0 ? kPi / 4 * static_cast<double>(random() % 8) : kPi * number(random);
      const Vec2 n{std::cos(angle), std::sin(angle)};
      const Vec2 arm = random() % 2 == 0 ? Vec2{0.5 * static_cast<double>(random() % 3) - 0.5, -0.5}
                                         : Vec2{number(random), number(random)};
      const bool as_b = random() % 2 == 0, joint = random() % 8 == 0;
      one.add(joint ? RowKind::Joint : RowKind::Normal, {n.x, n.y, cross(arm, n)}, 0, radius, as_b);
      if (!joint && random() % 3 != 0)
        one.add(RowKind::Friction, {-n.y, n.x, cross(arm, perp(n))}, 0.6, radius, as_b);
    }
    one.close();
    one.system.b.assign(one.system.rows.size(), 0);
    const Velocity v =
        random() % 2 == 0 ? Velocity{0, -0.16, 0} : Velocity{number(random), number(random), number(random)};
    const double distance = distance_by_faces(one.directions, {-v[0], -v[1], -radius * v[2]});
    const auto stops = [&](double slow) {
      return each_can_be_stopped(one.system, {v}, {radius}, slow, nullptr);
    };
    EXPECT_TRUE(stops(1.0001 * distance + 1e-7));
    if (distance > 1e-6) {
      EXPECT_FALSE(stops(0.9999 * distance));
      ++free;
    } else {
      ++held;
    }
  }
  EXPECT_GT(held, 1000);
  EXPECT_GT(free, 1000);
}

TEST(LocalSupport, IsAskedOfEachBody) {
  // Two bodies on the ground and one in the air.
  IslandSystem system;
  system.bodies.assign(3, {1, 1});
  const std::vector<Velocity> fall(3, {0, -1, 0});
  const auto stand = [&](int body) {
    Row row;
    row.a = body;
    row.Ja = {0, 1, 0};
    system.rows.push_back(row);
    system.b.push_back(1);
  };
  stand(0);
  stand(2);
  ThreadPool pool(2);
  for (ThreadPool* threads : {static_cast<ThreadPool*>(nullptr), &pool}) {
    EXPECT_FALSE(each_can_be_stopped(system, fall, {1, 1, 1}, 0.5, threads));
    EXPECT_TRUE(each_can_be_stopped(system, fall, {1, 1, 1}, 1.5, threads));
  }
  stand(1);
  EXPECT_TRUE(each_can_be_stopped(system, fall, {1, 1, 1}, 1e-9, nullptr));
  EXPECT_TRUE(each_can_be_stopped({}, {}, {}, 1e-9, nullptr));
}

}  // namespace local_support_test
}  // namespace skerry
