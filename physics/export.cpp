// SPDX-License-Identifier: MIT
#include "physics/export.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <ostream>
#include <sstream>
#include <stdexcept>

namespace skerry {
namespace {

/// Shortest text that reads back to the same bits.
std::string number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);
  return {text, end.ptr};
}

std::string json_number(double value) {
  if (std::isfinite(value)) return number(value);
  return std::isnan(value) ? "\"nan\"" : value > 0 ? "\"inf\"" : "\"-inf\"";
}

template <typename Values>
std::string json_array(const Values& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + json_number(value);
  return text + "]";
}

void write_array(std::ostream& out, std::size_t columns, const std::vector<double>& values) {
  out << "%%MatrixMarket matrix array real general\n" << values.size() / columns << ' ' << columns << '\n';
  for (const double value : values) out << number(value) << '\n';
}

/// Kinds, normal rows, mu, lower and upper bounds, column by column.
std::vector<double> row_table(const IslandSystem& system) {
  // The exchange format has no infinity.
  const auto finite = [](double bound) {
    constexpr double kLargest = std::numeric_limits<double>::max();
    return std::clamp(bound, -kLargest, kLargest);
  };
  std::vector<double> table;
  for (const Row& row : system.rows) table.push_back(static_cast<double>(row.kind));
  for (const Row& row : system.rows) table.push_back(row.normal + 1);
  for (const Row& row : system.rows) table.push_back(row.mu);
  for (const Row& row : system.rows) table.push_back(finite(row.lower));
  for (const Row& row : system.rows) table.push_back(finite(row.upper));
  return table;
}

struct Entry {
  int row, column;
  double value;
};

void write_entries(std::ostream& out, const char* symmetry, int rows, int columns,
                   const std::vector<Entry>& entries) {
  out << "%%MatrixMarket matrix coordinate real " << symmetry << '\n'
      << rows << ' ' << columns << ' ' << entries.size() << '\n';
  for (const Entry& entry : entries) {
    out << entry.row + 1 << ' ' << entry.column + 1 << ' ' << number(entry.value) << '\n';
  }
}

std::vector<Entry> lower_triangle(const Eigen::SparseMatrix<double>& W) {
  std::vector<Entry> entries;
  for (int j = 0; j < W.outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(W, j); it; ++it) {
      if (it.row() >= j) entries.push_back({static_cast<int>(it.row()), j, it.value()});
    }
  }
  return entries;
}

std::vector<Entry> jacobian(const IslandSystem& system) {
  std::vector<Entry> entries;
  for (int i = 0; i < system.size(); ++i) {
    const Row& row = system.rows[i];
    for (const auto& [body, J] : {std::pair{row.a, &row.Ja}, std::pair{row.b, &row.Jb}}) {
      for (int c = 0; body >= 0 && c < 3; ++c) {
        if ((*J)[c] != 0) entries.push_back({i, 3 * body + c, (*J)[c]});
      }
    }
  }
  return entries;
}

std::vector<Entry> masses(const IslandSystem& system) {
  std::vector<Entry> entries;
  for (int k = 0; k < static_cast<int>(system.bodies.size()); ++k) {
    const InverseMass& body = system.bodies[k];
    const double mass = body.linear > 0 ? 1 / body.linear : 0,
                 inertia = body.angular > 0 ? 1 / body.angular : 0;
    entries.push_back({3 * k, 3 * k, mass});
    entries.push_back({3 * k + 1, 3 * k + 1, mass});
    entries.push_back({3 * k + 2, 3 * k + 2, inertia});
  }
  return entries;
}

const char* kind_name(RowKind kind) {
  switch (kind) {
    case RowKind::Normal:
      return "normal";
    case RowKind::Friction:
      return "friction";
    case RowKind::Rolling:
      return "rolling";
    case RowKind::Joint:
      return "joint";
    case RowKind::Limit:
      return "limit";
    case RowKind::Motor:
      return "motor";
  }
  return "unknown";
}

void check_impulses(const IslandSystem& system, const std::vector<double>& lambda) {
  if (lambda.size() == system.rows.size()) return;
  throw std::invalid_argument("lambda must have " + std::to_string(system.rows.size()) + " entries, got " +
                              std::to_string(lambda.size()));
}

}  // namespace

std::string_view to_string(MatrixPart part) {
  switch (part) {
    case MatrixPart::W:
      return "W";
    case MatrixPart::J:
      return "J";
    case MatrixPart::M:
      return "M";
    case MatrixPart::b:
      return "b";
    case MatrixPart::rows:
      return "rows";
    case MatrixPart::compliance:
      return "compliance";
    case MatrixPart::lambda:
      return "lambda";
  }
  return "unknown";
}

void write_matrix_market(std::ostream& out, const IslandSystem& system, MatrixPart part,
                         const std::vector<double>& lambda) {
  const int n = system.size(), columns = 3 * static_cast<int>(system.bodies.size());
  switch (part) {
    case MatrixPart::W:
      write_entries(out, "symmetric", n, n, lower_triangle(delassus(system)));
      break;
    case MatrixPart::J:
      write_entries(out, "general", n, columns, jacobian(system));
      break;
    case MatrixPart::M:
      write_entries(out, "general", columns, columns, masses(system));
      break;
    case MatrixPart::b:
      write_array(out, 1, system.b);
      break;
    case MatrixPart::rows:
      write_array(out, 5, row_table(system));
      break;
    case MatrixPart::compliance:
      write_array(out, 1, system.compliance);
      break;
    case MatrixPart::lambda:
      check_impulses(system, lambda);
      write_array(out, 1, lambda);
      break;
  }
  if (!out) throw std::runtime_error("cannot write matrix " + std::string(to_string(part)));
}

void write_matrix_market(std::ostream& out, const std::vector<double>& values) {
  write_array(out, 1, values);
  if (!out) throw std::runtime_error("cannot write vector");
}

std::vector<MatrixMarketFile> matrix_market_files(const std::string& stem, const IslandSystem& system,
                                                  const std::vector<double>& lambda) {
  std::vector<MatrixMarketFile> files;
  for (const MatrixPart part : {MatrixPart::W, MatrixPart::J, MatrixPart::M, MatrixPart::b, MatrixPart::rows,
                                MatrixPart::compliance, MatrixPart::lambda}) {
    MatrixMarketFile& file = files.emplace_back();
    file.path = stem + "_" + std::string(to_string(part)) + ".mtx";
    if (part == MatrixPart::compliance && system.compliance.empty()) continue;
    if (part == MatrixPart::lambda && lambda.empty()) continue;
    std::ostringstream text;
    write_matrix_market(text, system, part, lambda);
    file.text = std::move(text).str();
  }
  return files;
}

std::vector<std::string> write_matrix_market_files(const std::string& stem, const IslandSystem& system,
                                                   const std::vector<double>& lambda) {
  std::vector<std::string> paths;
  for (const MatrixMarketFile& file : matrix_market_files(stem, system, lambda)) {
    if (file.text.empty()) {
      std::filesystem::remove(file.path);
      continue;
    }
    std::ofstream out(file.path, std::ios::binary);
    if (!out) throw std::runtime_error("cannot open " + file.path + " for writing");
    out << file.text;
    out.close();
    if (!out) {
      std::error_code error;
      if (std::filesystem::is_regular_file(file.path, error)) std::filesystem::remove(file.path, error);
      throw std::runtime_error("cannot write " + file.path);
    }
    paths.push_back(file.path);
  }
  return paths;
}

void write_json(std::ostream& out, const IslandSystem& system, const std::vector<double>& lambda) {
  if (!lambda.empty()) check_impulses(system, lambda);
  out << "{\n  \"format\": \"skerry-island\", \"version\": 1,\n  \"bodies\": [";
  for (std::size_t k = 0; k < system.bodies.size(); ++k) {
    out << (k ? ",\n    " : "\n    ") << "{\"inverse_mass\": " << number(system.bodies[k].linear)
        << ", \"inverse_inertia\": " << number(system.bodies[k].angular);
    if (!system.positions.empty()) {
      out << ", \"position\": " << json_array(std::array{system.positions[k].x, system.positions[k].y});
    }
    out << '}';
  }
  out << "],\n  \"rows\": [";
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    out << (i ? ",\n    " : "\n    ") << "{\"kind\": \"" << kind_name(row.kind) << "\", \"a\": " << row.a
        << ", \"b\": " << row.b << ", \"Ja\": " << json_array(row.Ja) << ", \"Jb\": " << json_array(row.Jb)
        << ", \"lower\": " << json_number(row.lower) << ", \"upper\": " << json_number(row.upper)
        << ", \"normal\": " << row.normal << ", \"mu\": " << number(row.mu) << ", \"source\": \""
        << row.source << "\"}";
  }
  out << "],\n  \"b\": " << json_array(system.b);
  if (!system.compliance.empty()) out << ",\n  \"compliance\": " << json_array(system.compliance);
  if (!lambda.empty()) out << ",\n  \"lambda\": " << json_array(lambda);
  out << "\n}\n";
  if (!out) throw std::runtime_error("cannot write JSON");
}

}  // namespace skerry
