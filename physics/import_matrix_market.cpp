// SPDX-License-Identifier: MIT
//
// Puts a contact problem together from the MatrixMarket files of its parts.
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>

#include "physics/export.h"
#include "physics/import.h"
#include "physics/text.h"

namespace skerry {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

class PartFiles {
 public:
  /// @param path  of any one part
  explicit PartFiles(const std::string& path) {
    const std::size_t end = path.rfind(".mtx"), cut = path.rfind('_'), slash = path.rfind('/');
    const bool in_folder = slash != std::string::npos && cut != std::string::npos && cut < slash;
    if (end == std::string::npos || cut == std::string::npos || end + 4 != path.size() || cut > end ||
        in_folder) {
      throw std::invalid_argument(path + ": expected a name like STEM_W.mtx, with STEM_b.mtx beside it");
    }
    stem_ = path.substr(0, cut);
  }

  std::string path(MatrixPart part) const { return stem_ + '_' + std::string(to_string(part)) + ".mtx"; }

  std::optional<Matrix> read_if_there(MatrixPart part) const {
    std::ifstream in(path(part));
    if (!in) return std::nullopt;
    return read_matrix_market(in, path(part));
  }

  Matrix read(MatrixPart part) const {
    std::optional<Matrix> matrix = read_if_there(part);
    if (!matrix) throw std::runtime_error("cannot open " + path(part));
    return *std::move(matrix);
  }

  /// A matrix of the given size as dense columns.
  std::vector<double> dense(MatrixPart part, const Matrix& matrix, Eigen::Index rows,
                            Eigen::Index columns) const {
    if (matrix.rows() != rows || matrix.cols() != columns) {
      fail(part, "expected " + std::to_string(rows) + " x " + std::to_string(columns) + ", got " +
                     std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()));
    }
    std::vector<double> values(static_cast<std::size_t>(rows * columns), 0.0);
    for (Eigen::Index j = 0; j < columns; ++j) {
      for (Matrix::InnerIterator it(matrix, j); it; ++it) {
        values[static_cast<std::size_t>(j * rows + it.row())] = it.value();
      }
    }
    return values;
  }

  [[noreturn]] void fail(MatrixPart part, const std::string& reason) const {
    throw std::invalid_argument(path(part) + ": " + reason);
  }

 private:
  std::string stem_;
};

/// Kind, normal row, mu and bounds of each row; normal rows alone when there is no table.
std::vector<Row> read_rows(const PartFiles& files, Eigen::Index n) {
  std::vector<Row> rows(static_cast<std::size_t>(n));
  const std::optional<Matrix> matrix = files.read_if_there(MatrixPart::rows);
  const std::vector<double> table =
      matrix ? files.dense(MatrixPart::rows, *matrix, n, 5) : std::vector<double>();
  const auto infinite = [](double bound) {
    constexpr double kLargest = std::numeric_limits<double>::max();
    return std::abs(bound) < kLargest ? bound : std::copysign(kInfinity, bound);
  };
  std::uint64_t contacts = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Row& row = rows[i];
    if (!table.empty()) {
      const auto entry = [&](int column) {
        return table[i + rows.size() * static_cast<std::size_t>(column)];
      };
      const double kind = entry(0), normal = entry(1);
      if (!(kind >= 0 && kind <= static_cast<double>(RowKind::Motor)) || kind != std::floor(kind)) {
        files.fail(MatrixPart::rows, "row " + std::to_string(i + 1) + ": no kind " + to_text(kind));
      }
      if (!(normal >= 0 && normal <= static_cast<double>(i)) || normal != std::floor(normal)) {
        files.fail(MatrixPart::rows, "row " + std::to_string(i + 1) +
                                         ": the row that scales its bounds must be " +
                                         "an earlier one, got " + to_text(normal));
      }
      row.kind = static_cast<RowKind>(kind);
      row.normal = static_cast<int>(normal) - 1;
      row.mu = entry(2);
      row.lower = infinite(entry(3));
      row.upper = infinite(entry(4));
    }
    row.source = row.normal >= 0 ? rows[static_cast<std::size_t>(row.normal)].source : contacts++;
  }
  return rows;
}

/// Bodies from the diagonal of M, blocks of the rows from J.
IslandSystem read_island(const PartFiles& files, const Matrix& J, const Matrix& M) {
  IslandSystem system;
  if (J.cols() % 3 != 0)
    files.fail(MatrixPart::J, "expected three columns a body, got " + std::to_string(J.cols()));
  if (M.rows() != J.cols() || M.cols() != J.cols()) {
    files.fail(MatrixPart::M,
               "expected one row and column for each column of J, " + std::to_string(J.cols()));
  }
  for (Eigen::Index column = 0; column < M.cols(); ++column) {
    for (Matrix::InnerIterator it(M, column); it; ++it) {
      if (it.row() == column || it.value() == 0) continue;
      files.fail(MatrixPart::M, "must be diagonal, (m, m, I) a body about its centre of mass; entry (" +
                                    std::to_string(it.row() + 1) + ", " + std::to_string(column + 1) +
                                    ") is " + to_text(it.value()));
    }
  }
  for (Eigen::Index k = 0; k < M.cols(); k += 3) {
    if (M.coeff(k, k) == M.coeff(k + 1, k + 1)) continue;
    files.fail(MatrixPart::M, "a body has one mass for x and y; entries " + std::to_string(k + 1) + " and " +
                                  std::to_string(k + 2) + " are " + to_text(M.coeff(k, k)) + " and " +
                                  to_text(M.coeff(k + 1, k + 1)));
  }
  const auto inverse = [&](Eigen::Index i) {
    const double mass = M.coeff(i, i);
    if (!(mass >= 0)) files.fail(MatrixPart::M, "masses must not be negative, got " + to_text(mass));
    return mass > 0 ? 1 / mass : 0;
  };
  for (Eigen::Index k = 0; k < J.cols(); k += 3) system.bodies.push_back({inverse(k), inverse(k + 2)});
  system.rows = read_rows(files, J.rows());
  for (Eigen::Index column = 0; column < J.cols(); ++column) {
    const int body = static_cast<int>(column / 3);
    for (Matrix::InnerIterator it(J, column); it; ++it) {
      Row& row = system.rows[static_cast<std::size_t>(it.row())];
      if (row.a < 0) row.a = body;
      if (row.a != body && row.b < 0) row.b = body;
      if (row.a != body && row.b != body) {
        files.fail(MatrixPart::J,
                   "row " + std::to_string(it.row() + 1) + " has entries of more than two bodies");
      }
      (row.a == body ? row.Ja : row.Jb)[static_cast<std::size_t>(column % 3)] = it.value();
    }
  }
  if (const auto compliance = files.read_if_there(MatrixPart::compliance)) {
    system.compliance = files.dense(MatrixPart::compliance, *compliance, J.rows(), 1);
  }
  return system;
}

}  // namespace

ImportedProblem read_matrix_market_files(const std::string& path) {
  const PartFiles files(path);
  ImportedProblem problem;
  const Matrix b = files.read(MatrixPart::b);
  const std::vector<double> wanted = files.dense(MatrixPart::b, b, b.rows(), 1);
  const auto J = files.read_if_there(MatrixPart::J), M = files.read_if_there(MatrixPart::M);
  if (J && M) {
    problem.has_bodies = true;
    problem.island = read_island(files, *J, *M);
    problem.island.b = wanted;
    validate(problem.island);
  } else {
    problem.contact.W = files.read(MatrixPart::W);
    problem.contact.rows = read_rows(files, problem.contact.W.rows());
    problem.contact.b = wanted;
    validate(problem.contact);
  }
  if (const auto lambda = files.read_if_there(MatrixPart::lambda)) {
    problem.lambda = files.dense(MatrixPart::lambda, *lambda, b.rows(), 1);
  }
  return problem;
}

}  // namespace skerry
