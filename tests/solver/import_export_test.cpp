// SPDX-License-Identifier: MIT
//
// Islands written to files and read back, problems of others, and files that are none.
#include <Eigen/Dense>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "physics/export.h"
#include "physics/import.h"
#include "physics/islands/delassus.h"
#include "physics/islands/island_system.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace import_export_test {

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

TEST(Export, JsonReadsBackBitForBit) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const IslandSystem system = scenes::mixed_island(seed);
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
  const IslandSystem system = scenes::mixed_island(3);
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
    const IslandSystem system = scenes::mixed_island(seed);
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
  IslandSystem system = scenes::mixed_island(1);
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

/// W is symmetric, the matrix of an LCP need not be.
TEST(Import, AnLcpKeepsItsRowsAndColumns) {
  const Eigen::Matrix2d expected = (Eigen::Matrix2d() << 1, 3, 2, 4).finished();
  for (const char* text : {"2\n0\n2\n2\n2\n2\n1 2\n3 4\n-1 -2\n",
                           "2\n2\n2\n2\n0\nsparse\n2 by 2\ncol 0 : locations 0 to 1\n0 : 1\n1 : 2\n"
                           "col 1 : locations 2 to 3\n0 : 3\n1 : 4\n-1 -2\n",
                           "2\n1\n2\n2\n1\n1\n1\n2\n2\n2\n1\n0 1\n0\n0\n1 2 3 4\n-1 -2\n"}) {
    std::istringstream in(text);
    const LcpProblem lcp = read_lcp(in);
    EXPECT_EQ(lcp.M, (std::vector<double>{1, 3, 2, 4})) << text;
    EXPECT_EQ(lcp.q, (std::vector<double>{-1, -2})) << text;
    const ContactProblem problem = contact_problem(lcp);
    EXPECT_EQ(Eigen::MatrixXd(problem.W), expected) << text;
    EXPECT_EQ(problem.b, (std::vector<double>{1, 2})) << text;
  }
}

TEST(Import, TextThatIsNoProblemIsRefusedWithTheLine) {
  EXPECT_THAT(refusal(read_lcp, "1\n0\n1\n1\n1\n1\ninf\n-1\n"),
              testing::HasSubstr("file.dat:7: entry of the matrix must be finite, got inf"));
  EXPECT_THAT(refusal(read_lcp, "2\n0\n3\n3\n3\n3\n1 0 0\n0 1 0\n0 0 1\n-1 -1\n"),
              testing::HasSubstr("M must have 2 rows"));
  EXPECT_THAT(refusal(read_friction_problem, "2\n2\n0\n2\n2\n2\n2\n1 0\n0 1\n-1 -1 -1 -1\n1 1\n"),
              testing::HasSubstr("W must have two rows a contact"));
  EXPECT_THAT(refusal(read_friction_problem, "2\n1\n0\n2\n2\n2\n2\n1 0\n0 1\n-1 -1\n-0.5\n"),
              testing::HasSubstr("file.dat:11: friction coefficient must not be negative, got -0.5"));
  EXPECT_THAT(refusal(read_matrix_market, "%%MatrixMarket vector array real general\n1 1\n1\n"),
              testing::HasSubstr("no MatrixMarket matrix"));
  EXPECT_THAT(refusal(read_matrix_market, "%%MatrixMarket matrix dense real general\n1 1\n1\n"),
              testing::HasSubstr("unknown format \"dense\""));
  // The mirror of its last entry is in no column.
  for (const char* kind : {"symmetric", "skew-symmetric"})
    EXPECT_THAT(refusal(read_matrix_market,
                        "%%MatrixMarket matrix coordinate real " + std::string(kind) + "\n7 2 1\n6 2 1\n"),
                testing::HasSubstr(std::string("file.dat:2: a ") + kind +
                                   " matrix has as many columns as rows, got 2 and 7"));
}

TEST(Import, RowsOfAFrictionProblemHaveTheNumberOfTheirContact) {
  std::istringstream in("2\n2\n0\n4\n4\n4\n4\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n-1 -1 -1 -1\n1 1\n");
  const ContactProblem problem = read_friction_problem(in);
  ASSERT_EQ(problem.rows.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(problem.rows[i].source, i / 2) << i;
}

TEST(Import, MatricesOfEverySymmetryAreReadFromArraysOfNumbersOfAnyKind) {
  const auto matrix_of = [](const std::string& text) {
    std::istringstream in("%%MatrixMarket matrix " + text);
    return Eigen::MatrixXd(read_matrix_market(in));
  };
  const Eigen::MatrixXd symmetric = matrix_of("array integer symmetric\n2 2\n1\n2\n4\n");
  EXPECT_EQ(symmetric, (Eigen::MatrixXd(2, 2) << 1, 2, 2, 4).finished());
}

TEST(Import, WhatAFileHoldsIsKnownBehindBlankLines) {
  const std::string path = testing::TempDir() + "blank_lines.json";
  {
    std::ofstream out(path);
    out << "\n  \n";
    write_json(out, pinched(), {});
  }
  EXPECT_EQ(read_problem(path).island.rows.size(), 3u);
  std::remove(path.c_str());
}

TEST(Import, JsonThatIsNearlyAnIslandIsRefused) {
  const auto message = [](const char* what, const char* instead) -> std::string {
    std::string text = R"({ "format": "skerry-island",
  "bodies": [{"inverse_mass": 1, "inverse_inertia": 2, "position": [0, 0]}],
  "rows": [
    {"kind": "normal", "a": -1, "b": 0, "Ja": [0, 0, 0], "Jb": [0, 1, 0], "lower": 0, "upper": "inf", "normal": -1, "mu": 0, "source": "1"}],
  "b": [1],
  "lambda": [0.5] })";
    text.replace(text.find(what), std::string_view(what).size(), instead);
    return refusal(read_json, text, "a.json");
  };
  EXPECT_EQ(message("", ""), "accepted");
  EXPECT_EQ(message("[0, 1, 0]", "[0, 1, 0, 0]"), "a.json:4: expected three numbers, got 4");
  EXPECT_EQ(message("[0, 1, 0]", "[0, 1]"), "a.json:4: expected three numbers, got 2");
  EXPECT_THAT(message("[0, 1, 0]", "[0, 1 0]"), testing::HasSubstr("a.json:4: expected ','"));
  EXPECT_EQ(message("[0.5]", "0.5"), "a.json:6: expected a list");
  EXPECT_EQ(message("[0, 0]}", "[nan, 0]}"), "a.json:2: expected a finite number, got \"nan\"");
  EXPECT_EQ(message("[{\"inverse_mass\": 1, \"inverse_inertia\": 2, \"position\": [0, 0]}]", "[5]"),
            "a.json:2: expected an object");
  EXPECT_THAT(message("\"normal\", \"a\"", "\"nor\\u006dal\", \"a\""), testing::HasSubstr("holds an escape"));
  EXPECT_THAT(message("\"rows\"", "\"rows"), testing::HasSubstr("a.json:3: text is not closed"));
}

TEST_F(MatrixMarketParts, KeepRowsOfEveryKind) {
  IslandSystem system = pinched();
  for (const RowKind kind : {RowKind::Limit, RowKind::Motor, RowKind::Friction, RowKind::Rolling}) {
    Row row = system.rows[0];
    row.kind = kind;
    if (kind == RowKind::Motor) row.lower = -3;
    if (kind == RowKind::Motor) row.upper = 4;
    if (kind == RowKind::Friction || kind == RowKind::Rolling) {
      row.normal = 1;
      row.mu = 0.25;
    }
    system.rows.push_back(row);
    system.b.push_back(1);
  }
  write_matrix_market_files(stem(), system);
  const ImportedProblem read = read_matrix_market_files(stem() + "_W.mtx");
  ASSERT_EQ(read.island.rows.size(), system.rows.size());
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    EXPECT_EQ(read.island.rows[i].kind, system.rows[i].kind) << i;
    EXPECT_EQ(read.island.rows[i].upper, system.rows[i].upper) << i;
  }
}

TEST_F(MatrixMarketParts, ThatAreOfNoBodiesAreRefused) {
  write_matrix_market_files(stem(), pinched());
  const std::string W = stem() + "_W.mtx";
  const auto text_of = [&](const char* part) {
    std::ifstream in(stem() + "_" + part + ".mtx");
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  /// With another part in its place.
  const auto with = [&](const char* part, const std::string& other) {
    const std::string text = text_of(part);
    put(part, other);
    std::string said = message(W);
    std::ofstream(stem() + "_" + part + ".mtx") << text;
    return said;
  };
  ASSERT_EQ(message(W), "accepted");
  EXPECT_THAT(with("M", "coordinate real general\n6 6 6\n1 1 -2\n2 2 -2\n3 3 0\n4 4 0\n5 5 0\n6 6 0\n"),
              testing::HasSubstr("_M.mtx: masses must not be negative, got -2"));
  EXPECT_THAT(with("M", "coordinate real general\n3 3 3\n1 1 2\n2 2 2\n3 3 0\n"),
              testing::HasSubstr("_M.mtx: expected one row and column for each column of J, 6"));
  EXPECT_THAT(with("J", "coordinate real general\n3 5 3\n1 1 1\n2 1 -1\n3 4 1\n"),
              testing::HasSubstr("_J.mtx: expected three columns a body, got 5"));
  const std::string M = text_of("M");
  put("M", "coordinate real general\n9 9 9\n1 1 2\n2 2 2\n3 3 0\n4 4 2\n5 5 2\n6 6 0\n7 7 2\n8 8 2\n9 9 0\n");
  EXPECT_THAT(with("J", "coordinate real general\n3 9 5\n1 1 1\n2 1 -1\n3 1 1\n3 4 1\n3 7 1\n"),
              testing::HasSubstr("_J.mtx: row 3 has entries of more than two bodies"));
  std::ofstream(stem() + "_M.mtx") << M;
  EXPECT_THAT(with("b", "array real general\n3 2\n0\n1\n2\n0\n0\n0\n"),
              testing::HasSubstr("_b.mtx: expected 3 x 1, got 3 x 2"));
  const std::string zeros = "0\n0\n0\n0\n0\n0\n0\n0\n0\n1\n1\n1\n";
  EXPECT_EQ(with("rows", "array real general\n3 5\n0\n0\n0\n" + zeros), "accepted");
  EXPECT_THAT(with("rows", "array real general\n2 5\n0\n0\n0\n0\n0\n0\n0\n0\n1\n1\n"),
              testing::HasSubstr("_rows.mtx: expected 3 x 5, got 2 x 5"));
  EXPECT_THAT(with("rows", "array real general\n3 5\n0\n0.5\n0\n" + zeros),
              testing::HasSubstr("_rows.mtx: row 2: no kind 0.5"));
  EXPECT_THAT(with("rows", "array real general\n3 5\n0\n6\n0\n" + zeros),
              testing::HasSubstr("_rows.mtx: row 2: no kind 6"));
  EXPECT_THAT(
      with("rows", "array real general\n3 5\n0\n1\n0\n0\n2\n0\n0\n0\n0\n0\n0\n0\n1\n1\n1\n"),
      testing::HasSubstr("_rows.mtx: row 2: the row that scales its bounds must be an earlier one, got 2"));
}

TEST(Export, RefusesImpulsesOfAnotherSystem) {
  std::stringstream text;
  EXPECT_THROW(write_matrix_market(text, pinched(), MatrixPart::lambda, {1, 2}), std::invalid_argument);
}

/// As the format has it; other readers take nothing else.
TEST(Export, MatrixMarketHasTheLowerTriangleOfWhatIsSymmetric) {
  std::stringstream text;
  write_matrix_market(text, pinched(), MatrixPart::W);
  std::string banner;
  std::getline(text, banner);
  EXPECT_EQ(banner, "%%MatrixMarket matrix coordinate real symmetric");
  int rows = 0, columns = 0, entries = 0, read = 0, row = 0, column = 0;
  text >> rows >> columns >> entries;
  for (double value = 0; text >> row >> column >> value; ++read) EXPECT_GE(row, column);
  EXPECT_EQ(read, 6);
  EXPECT_EQ(entries, 6);
}

TEST(Export, WritesWhatIsNoNumberAsSuch) {
  IslandSystem system = pinched();
  system.b[1] = std::numeric_limits<double>::quiet_NaN();
  std::stringstream text;
  write_json(text, system, {});
  EXPECT_THAT(text.str(), testing::HasSubstr("\"b\": [0, \"nan\", 2]"));
  EXPECT_THROW((void)read_json(text), std::invalid_argument);
}

}  // namespace import_export_test
}  // namespace skerry
