// SPDX-License-Identifier: MIT
#include "physics/islands/island_system.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "physics/export.h"
#include "physics/import.h"
#include "physics/islands/delassus.h"
#include "tests/support/draw.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace island_system_test {

IslandSystem mixed_island(unsigned seed) {
  IslandSystem system = scenes::random_island({.bodies = 4, .contacts = 6, .pins = 2},
                                              {.friction = 0.3, .rolling = 0.05, .noise = 1, .seed = seed})
                            .system;
  system.compliance.assign(system.rows.size(), 0.0);
  system.compliance.back() = 0.125;
  return system;
}

/// What `read` says when it refuses the text, or "accepted".
template <class Read>
std::string refusal(Read&& read, const std::string& text, const char* name = "file.dat") {
  std::istringstream in(text);
  try {
    (void)read(in, name);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(IslandSystem, RowVelocitiesByBodiesAgreeWithTheDelassusMatrix) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const IslandSystem system = mixed_island(seed);
    const ContactProblem problem = contact_problem(system);
    std::mt19937_64 random(seed);
    std::vector<double> lambda(system.rows.size());
    for (double& impulse : lambda) impulse = std::normal_distribution<double>()(random);
    const std::vector<double> by_bodies = row_velocities(system, lambda),
                              by_matrix = row_velocities(problem, lambda);
    const std::vector<double> diagonal = inverse_effective_masses(system);
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      ASSERT_NEAR(by_bodies[i], by_matrix[i], 1e-12) << "seed " << seed;
      ASSERT_NEAR(diagonal[i], problem.W.coeff(static_cast<int>(i), static_cast<int>(i)), 1e-13)
          << "seed " << seed;
      for (std::size_t j = 0; j < i; ++j) {
        const int p = static_cast<int>(i), q = static_cast<int>(j);
        ASSERT_EQ(problem.W.coeff(p, q), problem.W.coeff(q, p)) << "seed " << seed;
      }
    }
    ASSERT_NEAR(natural_map_residual(system, lambda), natural_map_residual(problem, lambda), 1e-11);
  }
}

TEST(IslandSystem, ResidualIsTheNaturalMapByItsFormula) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const IslandSystem system = mixed_island(seed);
    std::mt19937_64 random(seed);
    std::vector<double> lambda(system.rows.size());
    for (double& impulse : lambda) impulse = std::normal_distribution<double>()(random);
    const std::vector<double> w = row_velocities(system, lambda), D = inverse_effective_masses(system);
    double worst = 0;
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const Row& row = system.rows[i];
      const double bound = row.normal >= 0 ? row.mu * std::max(0.0, lambda[row.normal]) : 0;
      const double lower = row.normal >= 0 ? -bound : row.lower, upper = row.normal >= 0 ? bound : row.upper;
      worst = std::max(worst, D[i] * std::abs(lambda[i] - std::clamp(lambda[i] - w[i] / D[i], lower, upper)));
    }
    ASSERT_NEAR(natural_map_residual(system, lambda) * largest_magnitude(system.b), worst, 1e-12)
        << "seed " << seed;
  }
}

TEST(IslandSystem, ResidualOfABoxAtRestIsZeroAtItsWeightAndOneWithoutSupport) {
  const IslandSystem system = scenes::box_on_floor().system;
  const double half = 0.5 * 10.0 / 60;
  EXPECT_NEAR(natural_map_residual(system, {half, 0, half, 0}), 0, 1e-16);
  EXPECT_DOUBLE_EQ(natural_map_residual(system, {0, 0, 0, 0}), 1);
  EXPECT_GT(natural_map_residual(system, {-half, 0, half, 0}), 0.1);
}

TEST(IslandSystem, ResidualOfARowThatNothingMovesCountsItsUnexplainedVelocity) {
  IslandSystem system;
  system.bodies.resize(1);
  Row row;
  row.b = 0;
  row.Jb = {0, 1, 0};
  row.upper = kInfinity;
  system.rows.push_back(row);
  system.b = {-2};  // separates: lambda = 0 explains it
  EXPECT_EQ(natural_map_residual(system, {0}), 0);
  system.b = {2};  // approaches, and no impulse can stop it
  EXPECT_EQ(natural_map_residual(system, {0}), 1);
}

TEST(IslandSystem, ValidateNamesTheRowAndTheValue) {
  const IslandSystem good = scenes::box_on_floor().system;
  EXPECT_NO_THROW(validate(good));
  const auto message = [&](auto&& spoil) -> std::string {
    IslandSystem bad = good;
    spoil(bad);
    try {
      validate(bad);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message([](auto& s) { s.rows[2].b = 7; }), testing::HasSubstr("row 2"));
  EXPECT_THAT(message([](auto& s) { s.rows[1].normal = 3; }), testing::HasSubstr("row 1"));
  EXPECT_THAT(message([](auto& s) { s.rows[3].mu = -1; }), testing::HasSubstr("-1"));
  EXPECT_THAT(message([](auto& s) { s.rows[0].lower = -2; }), testing::HasSubstr("-2"));
  EXPECT_THAT(message([](auto& s) { s.b[1] = std::nan(""); }), testing::HasSubstr("row 1"));
  EXPECT_THAT(message([](auto& s) { s.b.pop_back(); }), testing::HasSubstr("got 3"));
  EXPECT_THAT(message([](auto& s) { s.bodies[0].linear = -1; }), testing::HasSubstr("body 0"));
  EXPECT_THAT(message([](auto& s) { s.rows[0].Jb[1] = kInfinity; }), testing::HasSubstr("row 0"));
}

TEST(FactorPattern, MinimumDegreeFillsLessThanTheNaturalOrderOnAPyramid) {
  const IslandSystem system = scenes::pyramid(8).system;
  const FactorPattern natural = factor_pattern(system, Ordering::Natural);
  const FactorPattern ordered = factor_pattern(system, Ordering::ApproximateMinimum);
  EXPECT_GE(natural.fill, 1);
  EXPECT_LT(ordered.fill, natural.fill);
  std::vector<char> seen(system.rows.size(), 0);
  for (const int row : ordered.order) seen[row] = 1;
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), system.size());
  for (std::size_t k = 0; k < ordered.row.size(); ++k) ASSERT_GT(ordered.row[k], ordered.column[k]);
  // Redundant contacts: only the raise of the diagonal keeps the condition finite.
  EXPECT_GT(ordered.condition, 1e8);
}

TEST(FactorPattern, AChainHasNoFillInItsNaturalOrder) {
  const FactorPattern pattern = factor_pattern(scenes::chain(50).system, Ordering::Natural);
  EXPECT_EQ(pattern.fill, 1);
  EXPECT_EQ(pattern.row.size(), 48u);
}

TEST(Export, JsonReadsBackBitForBit) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const IslandSystem system = mixed_island(seed);
    std::vector<double> lambda(system.rows.size(), 0.1);
    std::stringstream text;
    write_json(text, system, lambda);
    const ImportedIsland read = read_json(text);
    EXPECT_EQ(read.system.b, system.b);
    EXPECT_EQ(read.system.compliance, system.compliance);
    EXPECT_EQ(read.lambda, lambda);
    ASSERT_EQ(read.system.rows.size(), system.rows.size());
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      const Row &x = read.system.rows[i], &y = system.rows[i];
      EXPECT_TRUE(x.kind == y.kind && x.a == y.a && x.b == y.b && x.Ja == y.Ja && x.Jb == y.Jb &&
                  x.lower == y.lower && x.upper == y.upper && x.normal == y.normal && x.mu == y.mu &&
                  x.source == y.source)
          << i;
    }
  }
}

TEST(Export, MatrixMarketPartsGiveTheSameOperator) {
  const IslandSystem system = mixed_island(3);
  const auto part = [&](MatrixPart which) {
    std::stringstream text;
    write_matrix_market(text, system, which);
    return Eigen::MatrixXd(read_matrix_market(text));
  };
  const Eigen::MatrixXd W = part(MatrixPart::W), J = part(MatrixPart::J), M = part(MatrixPart::M);
  Eigen::MatrixXd expected = J * M.diagonal().cwiseInverse().asDiagonal() * J.transpose();
  expected.diagonal() += Eigen::Map<const Eigen::VectorXd>(system.compliance.data(), W.rows());
  EXPECT_LT((W - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(W, Eigen::MatrixXd(delassus(system)));
  EXPECT_EQ(part(MatrixPart::b)(1, 0), system.b[1]);
}

TEST(Export, MatrixMarketSetReadsBackAsTheSameIsland) {
  const std::string folder = testing::TempDir();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const IslandSystem system = mixed_island(seed);
    const std::vector<double> lambda(system.rows.size(), 0.1);
    const auto paths = write_matrix_market_files(folder + "island", system, lambda);
    const ImportedProblem read = read_problem(paths.front());
    for (const std::string& path : paths) std::remove(path.c_str());
    ASSERT_TRUE(read.has_bodies);
    EXPECT_EQ(read.island.b, system.b);
    EXPECT_EQ(read.island.compliance, system.compliance);
    EXPECT_EQ(read.lambda, lambda);
    ASSERT_EQ(read.island.size(), system.size());
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      const Row &x = read.island.rows[i], &y = system.rows[i];
      EXPECT_TRUE(x.kind == y.kind && x.lower == y.lower && x.upper == y.upper && x.normal == y.normal &&
                  x.mu == y.mu)
          << i;
    }
    // Masses are written, not their inverses; the ends of a row may be exchanged.
    const std::vector<double> w = row_velocities(system, lambda);
    const std::vector<double> v = row_velocities(read.island, lambda);
    for (std::size_t i = 0; i < w.size(); ++i) EXPECT_NEAR(v[i], w[i], 1e-13) << i;
  }
}

TEST(Export, LeavesNoPartsOfAnotherSystemInItsPlace) {
  const std::string stem = testing::TempDir() + "used";
  IslandSystem system = mixed_island(1);
  system.compliance.assign(system.rows.size(), 0.5);
  write_matrix_market_files(stem, system, std::vector<double>(system.rows.size(), 0.1));
  system.compliance.clear();
  const auto paths = write_matrix_market_files(stem, system, {});
  const ImportedProblem read = read_problem(paths.front());
  for (const std::string& path : paths) std::remove(path.c_str());
  EXPECT_TRUE(read.island.compliance.empty());
  EXPECT_TRUE(read.lambda.empty());
}

TEST(Import, SaysFileAndLineOfWhatItCannotRead) {
  EXPECT_THAT(refusal(read_friction_problem, "2\n1\n0\n2\n2\n2 2\n1 0\n0 x\n"),
              testing::HasSubstr("file.dat:8"));
  EXPECT_THAT(refusal(read_friction_problem, "3\n1\n"), testing::HasSubstr("dimension"));
  EXPECT_THAT(refusal(read_lcp, "2\n0\n2\n3\n"), testing::HasSubstr("file.dat:4"));
  EXPECT_THAT(refusal(read_lcp, "999999999\n"), testing::HasSubstr("size"));
  EXPECT_THAT(refusal(read_json, "{\n\"format\": [}"), testing::HasSubstr("file.dat:2"));
  EXPECT_THAT(refusal(read_json, "{\"format\": \"other\"}"), testing::HasSubstr("other"));
  EXPECT_THAT(refusal(read_json, std::string(100000, '[')), testing::HasSubstr("nested"));
  EXPECT_THAT(
      refusal(read_matrix_market, "%%MatrixMarket matrix array real general\n% a\n% b\n2 1\n0.1\nzz\n"),
      testing::HasSubstr("file.dat:6"));
  EXPECT_THAT(refusal(read_matrix_market, "%%MatrixMarket matrix coordinate complex general\n1 1 0\n"),
              testing::HasSubstr("complex"));
  EXPECT_THAT(refusal(read_lcp, "1x\n"), testing::HasSubstr("expected a number, got \"1x\""));
}

TEST(Import, JsonThatIsNoIslandIsRefusedWithLineAndValue) {
  const auto message = [](const char* what, const char* instead) -> std::string {
    std::string text = R"({ "format": "skerry-island",
  "version": 1,
  "bodies": [{"inverse_mass": 1, "inverse_inertia": 2, "position": [0, 0]}],
  "rows": [
    {"kind": "normal", "a": -1, "b": 0, "Ja": [0, 0, 0], "Jb": [0, 1, 0], "lower": 0, "upper": "inf", "normal": -1, "mu": 0, "source": "1"},
    {"kind": "friction", "a": -1, "b": 0, "Ja": [0, 0, 0], "Jb": [1, 0, 0.5], "lower": 0, "upper": "inf", "normal": 0, "mu": 0.25, "source": "1"}],
  "b": [1, 2],
  "lambda": [0.5, 0.125] })";
    text.replace(text.find(what), std::string_view(what).size(), instead);
    return refusal(read_json, text, "a.json");
  };
  EXPECT_EQ(message("", ""), "accepted");
  EXPECT_EQ(message(R"("version": 1)", R"("version": 99)"), "a.json:2: version must be 1, got 99");
  EXPECT_EQ(message(R"("mu": 0.25)", R"("mu": -1)"), "a.json:6: mu must not be negative, got -1");
  EXPECT_EQ(message(R"("mu": 0,)", R"("mu": -1,)"), "a.json:5: mu must not be negative, got -1");
  EXPECT_EQ(message(R"("mu": 0.25)", R"("mu": "inf")"), "a.json:6: mu must be finite, got inf");
  EXPECT_EQ(message("[0.5, 0.125]", R"(["inf", 0.125])"), "a.json:8: lambda must be finite, got inf");
  EXPECT_EQ(message("[0.5, 0.125]", "[0.5]"), "a.json:8: lambda must have 2 numbers, one a row, got 1");
  EXPECT_EQ(message(R"("b": [1, 2])", R"("b": ["-inf", 2])"), "a.json: row 0: b must be finite, got -inf");
  EXPECT_THAT(message("0.125] }", "0.125] } x"), testing::HasSubstr("text after the end"));
  EXPECT_THAT(message("[0, 0]}", "[0, 0, 0]}"), testing::HasSubstr("position must have two"));
  EXPECT_THAT(message(", \"inverse_inertia\"", " \"inverse_inertia\""), testing::HasSubstr("','"));
  EXPECT_THAT(message("\"1\"", "\"1x\""), testing::HasSubstr("got \"1x\""));
  EXPECT_THAT(message("\"a\": -1", "\"a\": 4294967296"), testing::HasSubstr("a.json:5: expected an integer"));
  EXPECT_THAT(message("\"normal\": -1", "\"normal\": 0.5"),
              testing::HasSubstr("a.json:5: expected an integer"));
}

TEST(Import, AMassMatrixThatIsNoneOfBodiesIsRefused) {
  const scenes::Scene scene = scenes::stack(2);
  const std::string stem = testing::TempDir() + "masses";
  const auto paths = write_matrix_market_files(stem, scene.system);
  const auto message = [&](const char* M) -> std::string {
    std::ofstream(stem + "_M.mtx") << "%%MatrixMarket matrix coordinate real general\n" << M;
    try {
      read_matrix_market_files(stem + "_W.mtx");
    } catch (const std::invalid_argument& error) {
      return std::string(error.what()).substr(stem.size());
    }
    return "accepted";
  };
  EXPECT_EQ(message("6 6 6\n1 1 1\n2 2 1\n3 3 0.5\n4 4 2\n5 5 2\n6 6 1\n"), "accepted");
  EXPECT_THAT(message("6 6 7\n1 1 1\n2 2 1\n3 3 0.5\n4 4 2\n5 5 2\n6 6 1\n3 1 0.25\n"),
              testing::HasSubstr("_M.mtx: must be diagonal, (m, m, I) a body about its centre of mass; entry "
                                 "(3, 1) is 0.25"));
  EXPECT_THAT(message("6 6 6\n1 1 1\n2 2 1\n3 3 0.5\n4 4 2\n5 5 3\n6 6 1\n"),
              testing::HasSubstr("_M.mtx: a body has one mass for x and y; entries 4 and 5 are 2 and 3"));
  for (const std::string& path : paths) std::remove(path.c_str());
}

TEST(Import, ReadsBlockStorageByColumnsOfEachBlock) {
  // Two contacts, two diagonal blocks: index by rows (0 1 2), columns (0 1).
  std::istringstream in(
      "2\n2\n1\n4\n4\n2\n2\n2\n2 4\n2 4\n3\n2\n0 1 2\n0 1\n0\n1\n2\n3\n4\n1\n5\n6\n7\n8\n"
      "-1 -2 -3 -4\n0.5 0.25\n");
  const ContactProblem problem = read_friction_problem(in);
  const Eigen::MatrixXd W(problem.W);
  EXPECT_EQ(W(0, 0), 1);
  EXPECT_EQ(W(1, 0), 2);
  EXPECT_EQ(W(0, 1), 3);
  EXPECT_EQ(W(3, 3), 8);
  EXPECT_EQ(W(0, 2), 0);
  EXPECT_EQ(problem.b, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(problem.rows[3].mu, 0.25);
}

TEST(Import, BlocksThatAreNotThoseOfTheirIndexAreRefused) {
  const auto message = [](const std::string& index, const char* number) {
    return refusal(read_friction_problem, "2\n2\n1\n4\n4\n2\n2\n2\n2 4\n2 4\n" + index + "\n0 1\n" + number +
                                              "\n1\n2\n3\n4\n1\n5\n6\n7\n8\n-1 -2 -3 -4\n0.5 0.25\n");
  };
  EXPECT_EQ(message("3\n2\n0 1 2", "0"), "accepted");
  EXPECT_THAT(message("3\n2\n0 1 2", "1"), testing::HasSubstr("block number"));
  EXPECT_THAT(message("4\n2\n0 1 2 2", "0"), testing::HasSubstr("more index entries"));
}

TEST(Import, MatricesOfEverySymmetryAreRead) {
  const auto matrix_of = [](const std::string& text) {
    std::istringstream in("%%MatrixMarket matrix " + text);
    return Eigen::MatrixXd(read_matrix_market(in));
  };
  const Eigen::MatrixXd skew = matrix_of("array real skew-symmetric\n3 3\n1\n2\n3\n");
  EXPECT_EQ(skew, (Eigen::MatrixXd(3, 3) << 0, -1, -2, 1, 0, -3, 2, 3, 0).finished());
  const Eigen::MatrixXd pattern = matrix_of("coordinate pattern symmetric\n2 2 2\n1 1\n2 1\n");
  EXPECT_EQ(pattern, (Eigen::MatrixXd(2, 2) << 1, 1, 1, 0).finished());
}

TEST(Import, AnLcpOfTwoRowsIsNoFrictionProblem) {
  const std::string path = testing::TempDir() + "lcp_of_two.dat";
  std::ofstream(path) << "2\n0\n2\n2\n2\n2\n2 0\n0 4\n-1 -2\n";
  const ImportedProblem problem = read_problem(path);
  std::remove(path.c_str());
  EXPECT_EQ(problem.contact.rows.size(), 2u);
  EXPECT_EQ(problem.contact.W.coeff(1, 1), 4);
  EXPECT_EQ(problem.contact.b, (std::vector<double>{1, 2}));
}

/// A body that cannot turn against a wall and one that cannot move: bounds on one side, and on none.
IslandSystem pinched() {
  IslandSystem system;
  system.bodies = {{0.5, 0}, {0, 0}};
  for (int k = 0; k < 3; ++k) {
    Row row;
    row.a = -1;
    row.b = 0;
    row.Jb = {k == 0 ? 1.0 : -1.0, 0, 0};
    row.kind = RowKind::Normal;
    row.source = static_cast<std::uint64_t>(k);
    if (k == 2) {
      row.a = 0;
      row.b = 1;
      row.Ja = {-1, 0, 0};
      row.kind = RowKind::Joint;
      row.lower = -kInfinity;
    }
    system.rows.push_back(row);
    system.b.push_back(k);
  }
  return system;
}

/// A folder for the parts of one system that is gone with the test.
class MatrixMarketParts : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string stem() const { return (folder_ / "one").string(); }
  static std::string message(const std::string& path) {
    return refusal([&](std::istream&, const char*) { return read_matrix_market_files(path); }, "");
  }
  void put(const char* part, const std::string& text) const {
    std::ofstream(stem() + "_" + part + ".mtx") << "%%MatrixMarket matrix " << text;
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("parts_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(MatrixMarketParts, KeepBoundsWithoutEndAndMassesWithoutEnd) {
  const IslandSystem system = pinched();
  write_matrix_market_files(stem(), system);
  const ImportedProblem read = read_problem(stem() + "_W.mtx");
  ASSERT_EQ(read.island.rows.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.island.rows[i].lower, system.rows[i].lower) << i;
    EXPECT_EQ(read.island.rows[i].upper, system.rows[i].upper) << i;
  }
  EXPECT_EQ(read.island.bodies[0].linear, 0.5);
  EXPECT_EQ(read.island.bodies[0].angular, 0);
  EXPECT_EQ(read.island.bodies[1].linear, 0);
}

TEST_F(MatrixMarketParts, AreFoundByTheNameOfW) {
  write_matrix_market_files(stem(), pinched());
  EXPECT_EQ(message(stem() + "_W.mtx.txt"),
            stem() + "_W.mtx.txt: expected a name like STEM_W.mtx, with STEM_b.mtx beside it");
  EXPECT_THAT(message((folder_ / "W.mtx").string()), testing::HasSubstr("expected a name like"));
}

TEST_F(MatrixMarketParts, ThatDoNotFitAreRefused) {
  IslandSystem system;
  system.bodies = {{1, 1}};
  for (int k = 0; k < 4; ++k) {
    Row row;
    row.b = 0;
    row.Jb = {k % 2 == 0 ? 0.0 : 1.0, k % 2 == 0 ? 1.0 : 0.0, 0.1 * k};
    if (k % 2 != 0) {
      row.kind = RowKind::Friction;
      row.normal = k - 1;
      row.mu = 0.5;
    }
    row.source = static_cast<std::uint64_t>(k / 2);
    system.rows.push_back(row);
    system.b.push_back(1);
  }
  write_matrix_market_files(stem(), system);
  const std::string W = stem() + "_W.mtx";
  EXPECT_EQ(message(W), "accepted");
  const ImportedProblem read = read_matrix_market_files(W);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(read.island.rows[i].source, i / 2) << i;
  // An entry of zero beside the diagonal is none.
  put("M", "coordinate real general\n3 3 4\n1 1 1\n2 2 1\n3 3 1\n2 1 0\n");
  EXPECT_EQ(message(W), "accepted");
  put("b", "array real general\n3 1\n1\n1\n1\n");
  EXPECT_THAT(message(W), testing::HasSubstr("b must have 4 entries"));
  std::filesystem::remove(stem() + "_M.mtx");
  EXPECT_THAT(message(W), testing::HasSubstr("b must have 4 entries"));
  put("b", "array real general\n4 1\n1\n1\n1\n1\n");
  EXPECT_EQ(message(W), "accepted");
  EXPECT_FALSE(read_matrix_market_files(W).has_bodies);
  // The normal row of the first friction row comes after it.
  std::ifstream in(stem() + "_rows.mtx");
  std::string text(std::istreambuf_iterator<char>(in), {});
  text.replace(text.find("\n0\n1\n0\n3\n"), 9, "\n0\n4\n0\n3\n");
  std::ofstream(stem() + "_rows.mtx") << text;
  EXPECT_THAT(message(W), testing::HasSubstr("must be an earlier one, got 4"));
}

TEST(Export, JsonHasThePlacesOfBodiesAndAnImpulseForEachRow) {
  IslandSystem system = pinched();
  system.positions = {{1, 2}, {-3, 0.1}};
  std::stringstream text;
  write_json(text, system, {});
  const ImportedIsland read = read_json(text);
  ASSERT_EQ(read.system.positions.size(), 2u);
  EXPECT_EQ(read.system.positions[1], (Vec2{-3, 0.1}));
  EXPECT_THROW(write_json(text, system, {1, 2}), std::invalid_argument);
}

TEST(ResidualFloor, CountsWhatComplianceGives) {
  IslandSystem system;
  system.bodies = {{1, 1}};
  Row row;
  row.b = 0;
  row.Jb = {0, 1, 0};
  system.rows = {row};
  system.b = {1};
  system.compliance = {0};
  // Never below a rounding of what is wanted.
  EXPECT_EQ(residual_floor(system, {1e-3}), residual_floor(system, {0}));
  EXPECT_DOUBLE_EQ(residual_floor(system, {1e3}), 1e3 * residual_floor(system, {0}));
  system.compliance = {1e6};
  EXPECT_DOUBLE_EQ(residual_floor(system, {1e3}), (1e9 + 1e3) * residual_floor(system, {0}));
}

TEST(ClampAndJudge, ShowsVelocitiesThatAreNoNumbers) {
  IslandSystem system;
  system.bodies = {{10, 10}, {10, 10}};
  for (int k = 0; k < 2; ++k) {
    Row row;
    row.a = k - 1;
    row.b = k;
    if (k > 0) row.Ja = {0, -1, 0};
    row.Jb = {0, 1, 0};
    system.rows.push_back(row);
    system.b.push_back(1);
  }
  std::vector<double> lambda{1e308, 1e308};
  EXPECT_FALSE(clamp_and_judge(system, lambda) <= 1);
}

/// Rows between bodies that follow each other.
IslandSystem path_of_rows(int rows, test::Draw& draw) {
  IslandSystem system;
  for (int k = 0; k <= rows; ++k) system.bodies.push_back({draw.uniform(0.5, 2), draw.uniform(0.5, 2)});
  for (int k = 0; k < rows; ++k) {
    Row row;
    row.kind = RowKind::Motor;
    row.a = k;
    row.b = k + 1;
    row.Ja = {draw.uniform(-1, 1), 1, draw.uniform(-1, 1)};
    row.Jb = {draw.uniform(-1, 1), -1, draw.uniform(-1, 1)};
    row.lower = -2;
    row.upper = 2;
    system.rows.push_back(row);
    system.b.push_back(draw.uniform(-1, 1));
  }
  return system;
}

TEST(ClampAndJudge, SeesWhatIsNearlyAPathForWhatItIs) {
  // Somewhere along a path there is a row back to an earlier body, one whose bounds another row scales, or
  // one between two bodies that do not move.
  for (unsigned seed = 1; seed <= 300; ++seed) {
    test::Draw draw(seed);
    const int n = seed % 2 == 0 ? 6 : 16 + draw.pick(9), what = static_cast<int>(seed / 2 % 3);
    IslandSystem system = path_of_rows(n, draw);
    std::vector<double> lambda(static_cast<std::size_t>(n));
    for (double& impulse : lambda) impulse = draw.uniform(-1, 1);
    const int at = 2 + draw.pick(n - 3);
    Row& row = system.rows[static_cast<std::size_t>(at)];
    if (what == 0) {
      row.b = draw.pick(at);
      if (at + 1 < n) system.rows[static_cast<std::size_t>(at) + 1].a = row.b;
    } else if (what == 1) {
      row.kind = RowKind::Friction;
      row.normal = draw.pick(at);
      system.rows[static_cast<std::size_t>(row.normal)].kind = RowKind::Normal;
      row.mu = 0.1;
    } else {
      for (const int body : {row.a, row.b}) system.bodies[static_cast<std::size_t>(body)] = {0, 0};
      system.b[static_cast<std::size_t>(at)] = 7;
    }
    std::vector<double> clamped = lambda;
    const double residual = clamp_and_judge(system, clamped);
    ASSERT_EQ(residual, natural_map_residual(system, clamped)) << "seed " << seed;
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const Row& one = system.rows[i];
      const ImpulseBounds bounds =
          impulse_bounds(one, one.normal < 0 ? 0 : clamped[static_cast<std::size_t>(one.normal)]);
      ASSERT_EQ(clamped[i], std::clamp(lambda[i], bounds.lower, bounds.upper)) << "seed " << seed;
    }
  }
}

TEST(ClampAndJudge, SaysOfTheSmallestWhatTheNaturalMapSays) {
  // Below the least scale residuals are absolute, on any path.
  for (const int n : {4, 20}) {
    for (const double size : {1.0, 1e-279, 1e-281, 1e-300}) {
      test::Draw draw(static_cast<unsigned>(n));
      IslandSystem system = path_of_rows(n, draw);
      system.b.assign(system.b.size(), size);
      std::vector<double> lambda(system.b.size(), 0.0);
      EXPECT_EQ(clamp_and_judge(system, lambda), natural_map_residual(system, lambda)) << n << ", " << size;
    }
  }
}

TEST(ClampAndJudge, ShowsWhatIsNoNumberWhereverItIs) {
  // One impulse is given, and nothing is wrong with its row; the velocities beside it are no numbers.
  for (const int n : {6, 24}) {
    for (int at = 1; at + 1 < n; ++at) {
      test::Draw draw(static_cast<unsigned>(at));
      IslandSystem system = path_of_rows(n, draw);
      std::vector<double> lambda(static_cast<std::size_t>(n), 0.0);
      for (const int body : {at, at + 1}) system.bodies[static_cast<std::size_t>(body)] = {100, 100};
      Row& row = system.rows[static_cast<std::size_t>(at)];
      row.lower = row.upper = lambda[static_cast<std::size_t>(at)] = 1e308;
      for (const int beside : {at - 1, at + 1}) {
        Row& other = system.rows[static_cast<std::size_t>(beside)];
        other.Ja = other.Jb = {1, -1, 0};
      }
      row.Ja = row.Jb = {1, 1, 0};
      EXPECT_FALSE(clamp_and_judge(system, lambda) <= 1) << n << " " << at;
    }
  }
}

TEST(ClampAndJudge, SaysInfinityForMoreThanIsWanted) {
  test::Draw draw(2);
  IslandSystem system = path_of_rows(8, draw);
  system.compliance.assign(8, 0.1);
  std::vector<double> lambda(8, 0.3);
  const double residual = clamp_and_judge(system, lambda);
  ASSERT_GT(residual, 0.1);
  EXPECT_EQ(clamp_and_judge(system, lambda, residual), residual);
  EXPECT_EQ(clamp_and_judge(system, lambda, 0.5 * residual), kInfinity);
  EXPECT_EQ(clamp_and_judge(system, lambda, 0), kInfinity);
}

TEST(FactorPattern, ConditionIsThatOfTheOneNorm) {
  // The estimate is never above it, and seldom much below.
  double least = 1;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    IslandSystem system =
        scenes::random_island({.bodies = 4, .contacts = 6, .pins = 2}, {.friction = 0.3, .seed = seed})
            .system;
    system.compliance.assign(system.rows.size(), 0.01);
    Eigen::MatrixXd W(delassus(system));
    W.diagonal() *= 1 + 1e-10;
    const double exact =
        W.cwiseAbs().colwise().sum().maxCoeff() * W.inverse().cwiseAbs().colwise().sum().maxCoeff();
    const double estimate = factor_pattern(system, Ordering::ApproximateMinimum).condition;
    ASSERT_LE(estimate, exact * (1 + 1e-6)) << "seed " << seed;
    least = std::min(least, estimate / exact);
  }
  EXPECT_GT(least, 0.5);
}

TEST(ResidualFloor, OfAMatrixCountsSizesAndIsNoLessThanARounding) {
  ContactProblem problem;
  problem.W.resize(2, 2);
  problem.W.insert(0, 0) = problem.W.insert(1, 1) = 2;
  problem.W.insert(0, 1) = problem.W.insert(1, 0) = -1;
  problem.rows.resize(2);
  problem.b = {0.5, -4};
  EXPECT_DOUBLE_EQ(residual_floor(problem, {8, 16}), kRoundingUnit * (8 + 32) / 4);
  EXPECT_DOUBLE_EQ(residual_floor(problem, {-8, 16}), kRoundingUnit * (8 + 32) / 4);
  EXPECT_DOUBLE_EQ(residual_floor(problem, {1e-3, 0}), kRoundingUnit);
  problem.b = {0, 0};
  EXPECT_DOUBLE_EQ(residual_floor(problem, {8, 16}), kRoundingUnit * 40);
}

TEST(IslandSystem, ResidualOfAMatrixShowsWhatIsNoNumber) {
  ContactProblem problem;
  problem.W.resize(3, 3);
  for (const int i : {0, 1, 2}) problem.W.insert(i, i) = 1;
  problem.rows.resize(3);
  problem.b = {0, 1, 0};
  EXPECT_EQ(natural_map_residual(problem, {0, 0, 0}), 1);
  EXPECT_TRUE(std::isnan(natural_map_residual(problem, {0, NAN, 0})));
  EXPECT_NO_THROW(validate(problem));
  problem.W.coeffRef(1, 1) = NAN;
  EXPECT_THROW(validate(problem), std::invalid_argument);
}

}  // namespace island_system_test
}  // namespace skerry
