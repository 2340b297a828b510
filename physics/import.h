// SPDX-License-Identifier: MIT
//
// Contact problems from text: our own JSON, MatrixMarket, and the text formats of Siconos for plane friction
// problems and linear complementarity problems. Readers say file and line of what they cannot read.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "physics/islands/delassus.h"

namespace skerry {

/// An island as `write_json` wrote it.
struct ImportedIsland {
  IslandSystem system;
  std::vector<double> lambda;  ///< empty when the file has none
};
/// @throws std::invalid_argument with line and reason; the system is validated.
ImportedIsland read_json(std::istream& in, const std::string& name = "input");

/// Reads a MatrixMarket matrix: coordinate or array; real, integer or pattern; general, symmetric or
/// skew-symmetric [Boisvert, Pozo, Remington 1996].
/// @throws std::invalid_argument with line and reason
Eigen::SparseMatrix<double> read_matrix_market(std::istream& in, const std::string& name = "input");

/// Reads a plane friction problem: dimension (2), number of contacts, storage (0 dense by columns, 1 blocks,
/// 2 sparse as printed by CSparse, six digits), W, q, mu a contact. Rows (normal, tangent) a contact;
/// u = W r + q, so b = -q.
/// @throws std::invalid_argument with line and reason
ContactProblem read_friction_problem(std::istream& in, const std::string& name = "input");

/// A plain LCP: w = M z + q, w, z >= 0, z'w = 0.
struct LcpProblem {
  int n = 0;
  std::vector<double> M;  ///< n x n, row by row
  std::vector<double> q;  ///< n
};
/// Reads a dense LCP: size, storage 0, rows and columns, M by columns, q; what follows is a remark.
/// @throws std::invalid_argument with line and reason
LcpProblem read_lcp(std::istream& in, const std::string& name = "input");

/// Returns the LCP as a contact problem of normal rows alone, b = -q.
ContactProblem contact_problem(const LcpProblem& lcp);

/// What a file turned out to hold: an island with its bodies, or a problem by its W.
struct ImportedProblem {
  bool has_bodies = false;
  IslandSystem island;         ///< when has_bodies
  ContactProblem contact;      ///< otherwise
  std::vector<double> lambda;  ///< impulses that came with it, or empty
};

/// Reads the files that `write_matrix_market_files` wrote, given the path of any one of them (STEM_W.mtx).
/// With STEM_J and STEM_M the problem has bodies, else STEM_W is read. STEM_b is needed; without STEM_rows
/// all rows are normal ones: a plain LCP. Sources are numbered by contact.
/// @throws std::invalid_argument with file and reason, std::runtime_error when a file that is needed is not
/// there
ImportedProblem read_matrix_market_files(const std::string& path);

/// Opens a file and reads whatever of the above it is: JSON by its brace, MatrixMarket by its "%%", a
/// friction problem by its leading "2", number of contacts, storage and matrix size that agree, else an LCP.
/// @throws std::invalid_argument when it is none of them, std::runtime_error when it cannot be opened
ImportedProblem read_problem(const std::string& path);

}  // namespace skerry
