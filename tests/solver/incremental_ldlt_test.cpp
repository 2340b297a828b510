// SPDX-License-Identifier: MIT
#include "physics/solver/incremental_ldlt.h"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/support/scale.h"

namespace skerry {
namespace incremental_ldlt_test {

/// Random J M^-1 J' with `rank` columns: singular for more rows than that.
Eigen::MatrixXd random_delassus(int rows, int rank, double mass_ratio, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0, 1);
  Eigen::MatrixXd J(rows, rank);
  for (double& entry : J.reshaped()) entry = normal(random);
  Eigen::VectorXd inverse_mass(rank);
  for (double& entry : inverse_mass) entry = std::pow(mass_ratio, -unit(random));
  return J * inverse_mass.asDiagonal() * J.transpose();
}

struct Kept {
  IncrementalLdlt factor;
  std::vector<int> rows;

  bool add(const Eigen::MatrixXd& A, int row) {
    std::vector<double> column;
    for (const int other : rows) column.push_back(A(other, row));
    if (factor.add(column, A(row, row)) == IncrementalLdlt::Added::Redundant) return false;
    rows.push_back(row);
    return true;
  }
};

/// |x - A^-1 b| is judged by |b - A x|, which a fresh factorisation must not beat by much.
double backward_error(const Eigen::MatrixXd& A, const Eigen::VectorXd& x, const Eigen::VectorXd& b) {
  const double scale =
      A.cwiseAbs().rowwise().sum().maxCoeff() * x.cwiseAbs().maxCoeff() + b.cwiseAbs().maxCoeff();
  return scale > 0 ? (b - A * x).cwiseAbs().maxCoeff() / scale : 0;
}

TEST(IncrementalLdlt, AgreesWithAFreshFactorisationOverRandomAdditionsAndRemovals) {
  const unsigned seed = 505;
  std::mt19937_64 random(seed);
  const int sequences = test_scale(10000);
  for (int sequence = 0; sequence < sequences; ++sequence) {
    std::uniform_int_distribution<int> any_size(1, 14);
    const int n = any_size(random);
    const double ratio = sequence % 3 == 0 ? 1e6 : 10;
    const Eigen::MatrixXd A = random_delassus(n, n + 2, ratio, random);
    Kept kept;
    std::vector<int> outside(n);
    for (int i = 0; i < n; ++i) outside[i] = i;
    for (int change = 0; change < 3 * n; ++change) {
      const bool grow = !outside.empty() && (kept.rows.empty() || random() % 5 < 3);
      if (grow) {
        const auto pick = static_cast<std::ptrdiff_t>(random() % outside.size());
        if (kept.add(A, outside[pick])) outside.erase(outside.begin() + pick);
      } else if (!kept.rows.empty()) {
        const auto pick = static_cast<std::ptrdiff_t>(random() % kept.rows.size());
        kept.factor.remove(static_cast<int>(pick));
        outside.push_back(kept.rows[pick]);
        kept.rows.erase(kept.rows.begin() + pick);
      }
    }
    ASSERT_EQ(kept.factor.size(), static_cast<int>(kept.rows.size()));
    if (kept.rows.empty()) continue;
    const Eigen::MatrixXd block = A(kept.rows, kept.rows);
    Eigen::VectorXd b(block.rows());
    for (double& entry : b) entry = std::normal_distribution<double>()(random);
    const std::vector<double> solved = kept.factor.solve({b.data(), static_cast<std::size_t>(b.size())});
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(solved.data(), b.size());
    ASSERT_LT(backward_error(block, x, b), 1e-13) << "sequence " << sequence << " seed " << seed;
    const Eigen::LDLT<Eigen::MatrixXd> fresh(block);
    const Eigen::VectorXd y = fresh.solve(b);
    // The forward error is the backward error times the condition.
    const double condition = 1 / std::max(fresh.rcond(), 1e-15);
    ASSERT_LT((x - y).norm(), 1e-13 * condition * (y.norm() + 1e-300))
        << "sequence " << sequence << " seed " << seed;
  }
}

TEST(IncrementalLdlt, CallsDependentRowsRedundantAndKeepsTheRest) {
  std::mt19937_64 random(7);
  const Eigen::MatrixXd A = random_delassus(9, 4, 100, random);
  Kept kept;
  int added = 0;
  for (int i = 0; i < 9; ++i) added += kept.add(A, i);
  EXPECT_EQ(added, 4);
  EXPECT_EQ(kept.factor.size(), 4);
}

TEST(IncrementalLdlt, LetsARowBackInAfterTheRowItRepeatedLeft) {
  Eigen::MatrixXd A(2, 2);
  A << 2, 2, 2, 2;
  Kept kept;
  ASSERT_TRUE(kept.add(A, 0));
  ASSERT_FALSE(kept.add(A, 1));
  kept.factor.remove(0);
  kept.rows.clear();
  ASSERT_TRUE(kept.add(A, 1));
  EXPECT_DOUBLE_EQ(kept.factor.solve(std::vector<double>{3})[0], 1.5);
}

TEST(IncrementalLdlt, RefinesOrRefactorsNearlyDependentRows) {
  // Two contacts 1e-5 apart: relative pivot 1e-10, let in on purpose.
  for (const double gap : {1e-5, 1e-6, 1e-7}) {
    IncrementalLdlt factor;
    ASSERT_EQ(factor.add({}, 1.0), IncrementalLdlt::Added::Independent);
    ASSERT_EQ(factor.add(std::vector<double>{1.0}, 1 + gap * gap, 1e-15),
              IncrementalLdlt::Added::Independent);
    ASSERT_EQ(factor.add(std::vector<double>{0.3, 0.3}, 2.0), IncrementalLdlt::Added::Independent);
    const std::vector<double> x = factor.solve(std::vector<double>{1, 1, -1});
    EXPECT_LT(factor.backward_error(), 1e-13) << gap;
    for (const double value : x) EXPECT_TRUE(std::isfinite(value));
  }
}

TEST(IncrementalLdlt, RefactorsWithPivotingWhenGrowthIsLarge) {
  IncrementalLdlt factor;
  // A tiny first pivot beside a large second one: L_21 = 1e5.
  ASSERT_EQ(factor.add({}, 1e-10), IncrementalLdlt::Added::Independent);
  ASSERT_EQ(factor.add(std::vector<double>{1e-5}, 2.0), IncrementalLdlt::Added::Independent);
  EXPECT_GT(factor.growth(), 1e4);
  const std::vector<double> x = factor.solve(std::vector<double>{1e-5, 1});
  EXPECT_EQ(factor.refactorisations(), 1);
  // [1e-10 1e-5; 1e-5 2] x = (1e-5, 1): x = (1e5, 0).
  EXPECT_NEAR(x[0], 1e5, 1e-9);
  EXPECT_NEAR(x[1], 0, 1e-12);
}

TEST(IncrementalLdlt, RejectsWrongSizesAndKeepsItsRows) {
  IncrementalLdlt factor;
  ASSERT_EQ(factor.add({}, 4.0), IncrementalLdlt::Added::Independent);
  EXPECT_THROW(factor.add({}, 1.0), std::invalid_argument);
  EXPECT_THROW(factor.add(std::vector<double>{std::nan("")}, 1.0), std::invalid_argument);
  EXPECT_THROW(factor.remove(1), std::invalid_argument);
  EXPECT_THROW(factor.solve({}), std::invalid_argument);
  EXPECT_DOUBLE_EQ(factor.solve(std::vector<double>{2})[0], 0.5);
}

}  // namespace incremental_ldlt_test
}  // namespace skerry
