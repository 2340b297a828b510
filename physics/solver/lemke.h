// SPDX-License-Identifier: MIT
//
// Lemke's complementary pivoting for plain linear complementarity problems.
#pragma once

#include <span>
#include <vector>

namespace skerry {

struct LcpSolution {
  bool solved = false;    ///< a complementary basis was reached and is verified by `residual`
  bool ray = false;       ///< ended on a secondary ray: for copositive-plus M there is no solution
  std::vector<double> z;  ///< n; zeros when not solved
  int pivots = 0;
  double residual = 0;  ///< max_i |min(z_i, w_i)|, w = M z + q
};

/// Finds z with w = M z + q, z >= 0, w >= 0, z'w = 0 [Lemke 1965; Cottle, Pang, Stone 2009, alg. 4.4.5].
///
/// The ratio test is lexicographic (ties within rounding are broken by the rows of the basis inverse), so a
/// degenerate problem does not cycle. After a ray other covering vectors are tried, and up to n = 14 every
/// complementary basis. Runs in double, then, where the residual is not at rounding, in long
/// double. O(n^2) a pivot; meant for n up to some hundreds.
///
/// @param M  n x n, row by row
/// @param q  n
/// @param max_pivots  0: 50 n + 100
/// @throws std::invalid_argument when M does not have n^2 entries or an entry is not finite
LcpSolution solve_lcp(std::span<const double> M, std::span<const double> q, int max_pivots = 0);

}  // namespace skerry
