// SPDX-License-Identifier: MIT
//
// `skerry solve`: formats, answers written back, exit codes.
#include <cmath>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "physics/export.h"
#include "physics/import.h"
#include "physics/solver/solver.h"
#include "sandbox/errors.h"
#include "tests/sandbox/temporary.h"
#include "tests/support/island_scenes.h"

namespace skerry::sandbox {
namespace solve_test {

using testing::HasSubstr;

class SolveCommand : public testing::Test {
 protected:
  std::vector<double> impulses(const std::string& path) {
    std::istringstream in(read_file(path));
    const auto matrix = read_matrix_market(in, path);
    std::vector<double> values(static_cast<std::size_t>(matrix.rows()), 0.0);
    for (int j = 0; j < matrix.outerSize(); ++j)
      for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, j); it; ++it) values[it.row()] = it.value();
    return values;
  }

  TemporaryFolder folder_;
  IslandSystem pyramid_ = scenes::pyramid(4, {.noise = 0.1, .seed = 3}).system;
};

TEST_F(SolveCommand, AnswersTheSameFromEveryFormat) {
  std::ofstream json(folder_ / "pyramid.json");
  write_json(json, pyramid_);
  json.close();
  write_matrix_market_files(folder_ / "set", pyramid_);
  // W, b and the table of rows alone: no bodies.
  write_matrix_market_files(folder_ / "alone", pyramid_);
  std::filesystem::remove(folder_ / "alone_J.mtx");
  std::filesystem::remove(folder_ / "alone_M.mtx");
  for (const char* file : {"pyramid.json", "set_W.mtx", "set_b.mtx", "alone_W.mtx"}) {
    const std::string answer = folder_ / "lambda.mtx";
    const Outcome outcome = run({"solve", folder_ / file, "-o", answer});
    EXPECT_EQ(outcome.code, kGood) << file << outcome.err << outcome.out;
    EXPECT_THAT(outcome.out, HasSubstr("status      solved"));
    EXPECT_LE(natural_map_residual(pyramid_, impulses(answer)), 1e-10) << file;
  }
}

TEST_F(SolveCommand, SolvesWhatExportWrote) {
  const std::string demo = folder_.write("tower.lua",
                                         "demo{ title = 'T', seconds = 0.1 }\nground{}\nfor k = 1, 3 do box{ "
                                         "at = {0, k - 0.5}, size = {1, 1} } end\n"
                                         "box{ at = {5, 0.5}, size = {1, 1} }");
  const Outcome written = run(
      {"export", demo, "--at", "0.05", "--matrix-market", folder_ / "set", "--json", folder_ / "tower.json"});
  ASSERT_EQ(written.code, kGood) << written.err;
  for (const char* file : {"set/tower_W.mtx", "tower.json"}) {
    const Outcome outcome = run({"solve", folder_ / file, "--warm", "--json"});
    EXPECT_EQ(outcome.code, kGood) << outcome.err;
    const auto report = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(report["bodies"], 3) << "the largest island";
    EXPECT_EQ(report["factorisations"], 0) << "the impulses that came with it are the answer";
  }
  const Outcome small = run({"export", demo, "--island", "2", "--json", folder_ / "box.json"});
  EXPECT_EQ(small.code, kGood) << small.err;
  EXPECT_THAT(run({"solve", folder_ / "box.json"}).out, HasSubstr("1 bodies"));
  // From 1, as pictures and --select count them.
  EXPECT_THAT(small.out, HasSubstr("forces of island 2 at "));
  EXPECT_EQ(run({"export", demo, "--select", "island=2", "--json", folder_ / "same.json"}).code, kGood);
  EXPECT_EQ(read_file(folder_ / "box.json"), read_file(folder_ / "same.json"));
  EXPECT_THAT(run({"export", demo, "--island", "0", "--json", folder_ / "x.json"}).err,
              HasSubstr("--island: expected a whole number from 1 to 2147483647, got 0"));
  EXPECT_EQ(run({"export", demo, "--island", "7", "--json", folder_ / "x.json"}).code, kUsage);
}

TEST_F(SolveCommand, ReportsAsJsonWhatItFound) {
  std::ofstream json(folder_ / "pyramid.json");
  write_json(json, pyramid_);
  json.close();
  const Outcome outcome =
      run({"solve", folder_ / "pyramid.json", "--solver", "body_space", "--json", "--trace"});
  ASSERT_EQ(outcome.code, kGood) << outcome.err;
  const auto report = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(report["bodies"], 10);
  EXPECT_EQ(report["rows"], pyramid_.size());
  EXPECT_EQ(report["contacts"], pyramid_.size() / 2);
  EXPECT_EQ(report["status"], "solved");
  EXPECT_FALSE(report["notes"].empty());
  const auto lambda = report["lambda"].get<std::vector<double>>();
  EXPECT_EQ(report["residual"].get<double>(), natural_map_residual(pyramid_, lambda));
}

TEST_F(SolveCommand, PrintsNoHeadingOverATraceWithoutRows) {
  std::ofstream json(folder_ / "pyramid.json");
  write_json(json, pyramid_);
  json.close();
  const std::string file = folder_ / "pyramid.json", heading = "iteration  residual";
  EXPECT_THAT(run({"solve", file, "--solver", "lemke", "--trace"}).out, HasSubstr(heading));
  // It refuses what is no chain before its first iteration.
  const Outcome refused = run({"solve", file, "--solver", "tridiagonal", "--trace"});
  EXPECT_EQ(refused.code, kCheckFailed);
  EXPECT_THAT(refused.out, HasSubstr("unsupported"));
  EXPECT_THAT(refused.out, testing::Not(HasSubstr(heading)));
}

TEST_F(SolveCommand, StartsFromTheImpulsesOfTheFileWhenAsked) {
  const Solution solution = find_solver("body_space").solve(pyramid_, {}, {}, nullptr);
  write_matrix_market_files(folder_ / "cold", pyramid_);
  write_matrix_market_files(folder_ / "warm", pyramid_, solution.lambda);
  const auto factorisations = [&](const std::vector<std::string>& words) {
    return nlohmann::json::parse(run(words).out)["factorisations"].get<int>();
  };
  EXPECT_GT(factorisations({"solve", folder_ / "warm_W.mtx", "--json"}), 0);
  EXPECT_EQ(factorisations({"solve", folder_ / "warm_W.mtx", "--json", "--warm"}), 0);
  const Outcome cold = run({"solve", folder_ / "cold_W.mtx", "--warm"});
  EXPECT_EQ(cold.code, kUsage);
  EXPECT_THAT(cold.err, HasSubstr("without impulses"));
}

TEST_F(SolveCommand, AProblemThatIsNotSolvedIsCodeOne) {
  write_matrix_market_files(folder_ / "set", pyramid_);
  const Outcome outcome = run({"solve", folder_ / "set_W.mtx", "--solver", "pgs", "--iterations", "2"});
  EXPECT_EQ(outcome.code, kCheckFailed);
  EXPECT_THAT(outcome.out, HasSubstr("inexact"));
}

TEST_F(SolveCommand, WrongWordsAndFilesSayWhatIsWrong) {
  write_matrix_market_files(folder_ / "set", pyramid_);
  const auto complains = [](const std::vector<std::string>& words, int code, const std::string& expected) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.code, code) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(expected));
  };
  complains({"solve"}, kUsage, "FILE is required");
  complains({"solve", folder_ / "set_W.mtx", "--solver", "bodyspace"}, kUsage,
            "did you mean \"body_space\"?");
  complains({"solve", folder_ / "absent.json"}, kScriptOrFile, "cannot open");
  complains({"solve", folder_.write("x.json", "{\n\"format\": 3")}, kScriptOrFile, "x.json:2");
  complains({"solve", folder_ / "set_W.mtx", "-o", "/proc/skerry/x.mtx"}, kScriptOrFile, "/proc/skerry");
  complains({"solve", folder_.write("alone.mtx", "%%MatrixMarket matrix array real general\n1 1\n1\n")},
            kScriptOrFile, "STEM_W.mtx");
  std::filesystem::remove(folder_ / "set_J.mtx");
  complains({"solve", folder_ / "set_W.mtx", "--solver", "body_space"}, kUsage, "needs the bodies");
  std::filesystem::remove(folder_ / "set_b.mtx");
  complains({"solve", folder_ / "set_W.mtx"}, kScriptOrFile, "set_b.mtx");
  folder_.write("set_b.mtx", "%%MatrixMarket matrix array real general\n1 1\n1\n");
  complains({"solve", folder_ / "set_W.mtx"}, kScriptOrFile, "entries");
  folder_.write("set_rows.mtx", "%%MatrixMarket matrix array real general\n1 1\n1\n");
  complains({"solve", folder_ / "set_W.mtx"}, kScriptOrFile, "set_rows.mtx: expected");
}

}  // namespace solve_test
}  // namespace skerry::sandbox
