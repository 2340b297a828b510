// SPDX-License-Identifier: MIT
//
// Third-party problems with known answers; they run where the data folder lies beside the checkout.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "physics/import.h"
#include "physics/solver/lemke.h"
#include "physics/solver/solver.h"
#include "tests/support/paths.h"

namespace skerry {
namespace siconos_test {

/// Folder with lcp/ and fc2d/, or empty.
std::string data_folder() {
  std::vector<std::string> candidates{std::string(source_dir()) + "/../shared/data/siconos",
                                      std::string(source_dir()) + "/../../shared/data/siconos"};
  if (const char* folder = std::getenv("SKERRY_DATA")) candidates.insert(candidates.begin(), folder);
  for (const std::string& folder : candidates) {
    if (std::filesystem::is_directory(folder + "/lcp")) return folder;
  }
  return {};
}

class SiconosProblems : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = data_folder();
    if (folder_.empty())
      GTEST_SKIP() << "data/siconos is not beside the checkout; set SKERRY_DATA to its folder";
  }
  LcpProblem lcp(const std::string& name) const {
    std::ifstream in(folder_ + "/lcp/lcp_" + name + ".dat");
    return read_lcp(in, name);
  }
  std::vector<double> solution(const std::string& name) const {
    const LcpProblem problem = lcp(name);
    const LcpSolution answer = solve_lcp(problem.M, problem.q);
    EXPECT_TRUE(answer.solved) << name;
    EXPECT_LE(answer.residual, 1e-10) << name;
    return answer.z;
  }
  ContactProblem friction(const std::string& name) const {
    return read_problem(folder_ + "/fc2d/" + name + ".dat").contact;
  }
  std::string folder_;
};

TEST_F(SiconosProblems, LinearComplementarityProblemsHaveTheirKnownSolutions) {
  const std::vector<double> degenerate = solution("CPS_1");
  EXPECT_NEAR(degenerate[0] + degenerate[1], 1, 1e-14);  // every point of z1 + z2 = 1 solves it

  const std::vector<double> murty = solution("exp_murty");
  // By columns the matrix is upper triangular with a unit diagonal: the last variable alone carries q.
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(murty[i], i == 5 ? 1 : 0, 1e-14) << i;

  for (const char* name : {"CPS_2", "CPS_3", "CPS_4", "CPS_4bis", "CPS_5", "enum_fails", "mmc", "trivial"}) {
    solution(name);
  }
}

double sum_of_normal_impulses(const std::vector<double>& lambda) {
  double sum = 0;
  for (std::size_t i = 0; i < lambda.size(); i += 2) sum += lambda[i];
  return sum;
}

TEST_F(SiconosProblems, SmallFrictionProblemsAreSolvedToRounding) {
  for (const char* name : {"FC2D_SliderCrankLagrangian00000", "FC2D_SliderCrankLagrangian00001",
                           "FrictionContactProblem00374", "FrictionContactProblem00394"}) {
    const ContactProblem problem = friction(name);
    for (const char* solver : {"lemke", "sparse_contact"}) {
      const Solution answer = find_solver(solver).solve_contact(problem, {}, {}, nullptr);
      EXPECT_EQ(answer.status, SolveStatus::Solved) << name << ' ' << solver;
      EXPECT_LE(answer.residual, 1e-10) << name << ' ' << solver;
    }
  }
}

TEST_F(SiconosProblems, GranularFlowOf2020ContactsHasItsKnownImpulse) {
  const ContactProblem problem = friction("fc2d_granularflowonwall_02020_00213");
  const Solution answer = find_solver("lemke").solve_contact(problem, {}, {}, nullptr);
  EXPECT_EQ(answer.status, SolveStatus::Solved);
  EXPECT_LE(answer.residual, 1e-10);
  EXPECT_NEAR(sum_of_normal_impulses(answer.lambda), 5.554270280309e-02, 1e-11);
}

TEST_F(SiconosProblems, GranularFlowOf7002ContactsIsSolvedToRounding) {
  const ContactProblem problem = friction("fc2d_granularflowonwall_07002_00801");
  const Solution answer = find_solver("sparse_contact").solve_contact(problem, {}, {}, nullptr);
  EXPECT_EQ(answer.status, SolveStatus::Solved);
  EXPECT_LE(answer.residual, 1e-10);
}

}  // namespace siconos_test
}  // namespace skerry
