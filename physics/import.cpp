// SPDX-License-Identifier: MIT
#include "physics/import.h"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "physics/text.h"

namespace skerry {
namespace {

/// Larger sizes than any island; a header beyond them is no contact problem, and must not eat the memory.
constexpr long kMaxRows = 2'000'000, kMaxDense = 20'000;

/// Words of a text, with the line they stand in.
class Words {
 public:
  Words(std::istream& in, const std::string& name) : in_(in), name_(name) {}

  bool next(std::string& word) {
    word.clear();
    for (int c = in_.get(); c != EOF; c = in_.get()) {
      if (std::isspace(c)) {
        if (c == '\n') ++line_;
        if (!word.empty()) {
          if (c == '\n') in_.unget(), --line_;
          return true;
        }
        continue;
      }
      word.push_back(static_cast<char>(c));
    }
    return !word.empty();
  }

  double real(const char* what) {
    std::string word;
    if (!next(word)) fail(std::string("ends before ") + what);
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (end == word.c_str() || *end != '\0')
      fail(std::string(what) + ": expected a number, got \"" + word + '"');
    if (!std::isfinite(value)) fail(std::string(what) + " must be finite, got " + word);
    return value;
  }

  long integer(const char* what, long low, long high) {
    const double value = real(what);
    if (value != std::floor(value) || value < static_cast<double>(low) || value > static_cast<double>(high)) {
      fail(std::string(what) + ": expected an integer from " + std::to_string(low) + " to " +
           std::to_string(high) + ", got " + to_text(value));
    }
    return static_cast<long>(value);
  }

  void skip_line() {
    std::string rest;
    std::getline(in_, rest);
    count_line();
  }
  /// One was read by somebody else.
  void count_line() { ++line_; }

  [[noreturn]] void fail(const std::string& reason) const {
    throw std::invalid_argument(name_ + ":" + std::to_string(line_) + ": " + reason);
  }

 private:
  std::istream& in_;
  std::string name_;
  int line_ = 1;
};

using Triplets = std::vector<Eigen::Triplet<double>>;

void read_dense(Words& words, long n, Triplets& entries) {
  if (n > kMaxDense) words.fail("dense matrix of " + std::to_string(n) + " rows is too large");
  for (long j = 0; j < n; ++j) {
    for (long i = 0; i < n; ++i) {
      const double value = words.real("entry of the matrix");
      if (value != 0) entries.emplace_back(static_cast<int>(i), static_cast<int>(j), value);
    }
  }
}

/// Rows of dense blocks: count of blocks, rows and columns of blocks, their last rows and columns, block
/// index by rows, then each block with its number, by columns.
void read_blocks(Words& words, long n, Triplets& entries) {
  const long blocks = words.integer("number of blocks", 0, kMaxRows);
  if (blocks == 0) return;
  const long block_rows = words.integer("number of block rows", 1, n);
  const long block_columns = words.integer("number of block columns", 1, n);
  std::vector<long> row_end, column_end, first, column;
  for (long i = 0; i < block_rows; ++i) row_end.push_back(words.integer("end of a block row", 0, n));
  for (long i = 0; i < block_columns; ++i) column_end.push_back(words.integer("end of a block column", 0, n));
  const long starts = words.integer("size of the first index", 1, kMaxRows);
  const long columns = words.integer("size of the second index", blocks, kMaxRows);
  for (long i = 0; i < starts; ++i) first.push_back(words.integer("first index", 0, columns));
  for (long i = 0; i < columns; ++i) column.push_back(words.integer("second index", 0, block_columns - 1));
  for (long r = 0; r + 1 < starts; ++r) {
    if (r >= block_rows) words.fail("more index entries than block rows");
    const long top = r > 0 ? row_end[r - 1] : 0;
    for (long k = first[r]; k < first[r + 1]; ++k) {
      words.integer("block number", k, k);
      const long left = column[k] > 0 ? column_end[column[k] - 1] : 0;
      for (long j = left; j < column_end[column[k]]; ++j) {
        for (long i = top; i < row_end[r]; ++i) {
          entries.emplace_back(static_cast<int>(i), static_cast<int>(j), words.real("entry of a block"));
        }
      }
    }
  }
}

/// "col J : locations A to B" followed by "I : value" for each entry, after two lines of heading.
void read_sparse_print(Words& words, long n, Triplets& entries) {
  words.integer("origin of the sparse matrix", 0, 9);
  words.skip_line();
  words.skip_line();
  words.skip_line();
  const auto expect = [&](const char* text) {
    std::string word;
    if (!words.next(word) || word != text)
      words.fail("expected \"" + std::string(text) + "\", got \"" + word + '"');
  };
  for (long j = 0; j < n; ++j) {
    expect("col");
    words.integer("column number", j, j);
    expect(":");
    expect("locations");
    const long from = words.integer("first location", 0, kMaxRows * 100L);
    expect("to");
    const long to = words.integer("last location", from - 1, kMaxRows * 100L);
    for (long k = from; k <= to; ++k) {
      const long i = words.integer("row number", 0, n - 1);
      expect(":");
      entries.emplace_back(static_cast<int>(i), static_cast<int>(j), words.real("entry"));
    }
  }
}

/// Storage type, sizes, and the matrix itself.
Eigen::SparseMatrix<double> read_numerics_matrix(Words& words) {
  const long storage = words.integer("storage type", 0, 2);
  const long n = words.integer("rows", 0, kMaxRows);
  words.integer("columns", n, n);
  Triplets entries;
  if (storage == 0) {
    words.integer("rows", n, n);
    words.integer("columns", n, n);
    read_dense(words, n, entries);
  } else if (storage == 1) {
    read_blocks(words, n, entries);
  } else {
    read_sparse_print(words, n, entries);
  }
  Eigen::SparseMatrix<double> matrix(static_cast<int>(n), static_cast<int>(n));
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

ContactProblem read_friction_problem(std::istream& in, const std::string& name) {
  Words words(in, name);
  words.integer("dimension (only plane problems)", 2, 2);
  const long contacts = words.integer("number of contacts", 0, kMaxRows / 2);
  ContactProblem problem;
  problem.W = read_numerics_matrix(words);
  if (problem.W.rows() != 2 * contacts) words.fail("W must have two rows a contact");
  for (long i = 0; i < 2 * contacts; ++i) problem.b.push_back(-words.real("q"));
  for (long c = 0; c < contacts; ++c) {
    Row normal, friction;
    normal.source = friction.source = static_cast<std::uint64_t>(c);
    friction.kind = RowKind::Friction;
    friction.normal = static_cast<int>(2 * c);
    friction.mu = words.real("friction coefficient");
    if (friction.mu < 0) words.fail("friction coefficient must not be negative, got " + to_text(friction.mu));
    problem.rows.push_back(normal);
    problem.rows.push_back(friction);
  }
  validate(problem);
  return problem;
}

LcpProblem read_lcp(std::istream& in, const std::string& name) {
  Words words(in, name);
  LcpProblem lcp;
  lcp.n = static_cast<int>(words.integer("size", 0, kMaxDense));
  const Eigen::SparseMatrix<double> M = read_numerics_matrix(words);
  if (M.rows() != lcp.n) words.fail("M must have " + std::to_string(lcp.n) + " rows");
  const auto n = static_cast<std::size_t>(lcp.n);
  lcp.M.assign(n * n, 0.0);
  for (int j = 0; j < M.outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(M, j); it; ++it) {
      lcp.M[static_cast<std::size_t>(it.row()) * n + static_cast<std::size_t>(j)] = it.value();
    }
  }
  for (int i = 0; i < lcp.n; ++i) lcp.q.push_back(words.real("q"));
  return lcp;
}

ContactProblem contact_problem(const LcpProblem& lcp) {
  ContactProblem problem;
  Triplets entries;
  for (int i = 0; i < lcp.n; ++i) {
    for (int j = 0; j < lcp.n; ++j) {
      const double value = lcp.M[static_cast<std::size_t>(i) * lcp.n + j];
      if (value != 0) entries.emplace_back(i, j, value);
    }
    problem.b.push_back(-lcp.q[i]);
    Row row;
    row.source = static_cast<std::uint64_t>(i);
    problem.rows.push_back(row);
  }
  problem.W.resize(lcp.n, lcp.n);
  problem.W.setFromTriplets(entries.begin(), entries.end());
  return problem;
}

Eigen::SparseMatrix<double> read_matrix_market(std::istream& in, const std::string& name) {
  Words words(in, name);
  std::string banner, object, format, field, symmetry, line;
  std::getline(in, line);
  std::istringstream(line) >> banner >> object >> format >> field >> symmetry;
  if (banner != "%%MatrixMarket" || object != "matrix") words.fail("no MatrixMarket matrix");
  if (format != "coordinate" && format != "array") words.fail("unknown format \"" + format + '"');
  if (field != "real" && field != "integer" && field != "pattern")
    words.fail("unknown field \"" + field + '"');
  const bool symmetric = symmetry == "symmetric", skew = symmetry == "skew-symmetric";
  if (!symmetric && !skew && symmetry != "general") words.fail("unknown symmetry \"" + symmetry + '"');
  words.count_line();
  while (in.peek() == '%') words.skip_line();

  const long rows = words.integer("rows", 0, kMaxRows), columns = words.integer("columns", 0, kMaxRows);
  if ((symmetric || skew) && rows != columns)
    words.fail("a " + symmetry + " matrix has as many columns as rows, got " + std::to_string(columns) +
               " and " + std::to_string(rows));
  Triplets entries;
  const auto put = [&](long i, long j, double value) {
    entries.emplace_back(static_cast<int>(i), static_cast<int>(j), value);
    if ((symmetric || skew) && i != j) {
      entries.emplace_back(static_cast<int>(j), static_cast<int>(i), skew ? -value : value);
    }
  };
  if (format == "array") {
    if (rows > kMaxDense || columns > kMaxDense) words.fail("dense matrix is too large");
    for (long j = 0; j < columns; ++j) {
      for (long i = symmetric ? j : skew ? j + 1 : 0; i < rows; ++i) put(i, j, words.real("entry"));
    }
  } else {
    const long count = words.integer("number of entries", 0, kMaxRows * 100L);
    for (long k = 0; k < count; ++k) {
      const long i = words.integer("row", 1, rows) - 1, j = words.integer("column", 1, columns) - 1;
      put(i, j, field == "pattern" ? 1 : words.real("entry"));
    }
  }
  Eigen::SparseMatrix<double> matrix(static_cast<int>(rows), static_cast<int>(columns));
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

ImportedProblem read_problem(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot open " + path);
  ImportedProblem problem;
  const int first = (in >> std::ws).peek();
  if (first == '{') {
    ImportedIsland island = read_json(in, path);
    problem.has_bodies = true;
    problem.island = std::move(island.system);
    problem.lambda = std::move(island.lambda);
    return problem;
  }
  if (first == '%') return read_matrix_market_files(path);
  // A friction problem begins "2 contacts storage rows", an LCP "n storage rows": tell them by the rows.
  double head[4] = {-1, -1, -1, -1};
  for (double& value : head) in >> value;
  const bool friction = head[0] == 2 && head[2] >= 0 && head[2] <= 2 && head[3] == 2 * head[1];
  in.clear();
  in.seekg(0);
  problem.contact = friction ? read_friction_problem(in, path) : contact_problem(read_lcp(in, path));
  return problem;
}

}  // namespace skerry
