// SPDX-License-Identifier: MIT
#include "physics/statics/structure_solver.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "physics/statics/mechanism.h"
#include "physics/statics/null_space.h"
#include "physics/statics/redundants.h"
#include "physics/statics/span.h"
#include "physics/statics/sparse_lu.h"
#include "physics/text.h"

namespace skerry::statics {
namespace {

// Nonzeros of the self-stress states, a member, up to which the force method is used: a stiffness factor of a
// plane truss has about twenty.
constexpr std::size_t kLocalStates = 12;
// Entries of A are direction cosines and ratios of lengths: of order 1. A structure whose pivots are smaller
// than this moves by 1e10 of its size before it carries.
constexpr double kDependent = 1e-10;

/// Kind of an unknown: axial force or an end moment (over the member's length).
enum class Unknown : std::uint8_t { Axial, MomentA, MomentB };

struct Column {
  int member = 0;
  Unknown unknown = Unknown::Axial;
};

}  // namespace

const char* to_string(ForceMethod method) {
  switch (method) {
    case ForceMethod::Equilibrium:
      return "equilibrium";
    case ForceMethod::Stiffness:
      return "stiffness";
    case ForceMethod::MinimumNorm:
      return "minimum norm";
    case ForceMethod::None:
      return "none";
  }
  return "";
}

struct StructureSolver::State {
  Structure structure;
  Determinacy determinacy;
  ForceMethod method = ForceMethod::None;
  bool stiff = true;

  // Rows of A: the free displacements, then those that supports hold.
  std::vector<std::array<int, 3>> row_of;  // by node: along its axes, turning; -1: no such displacement
  std::vector<Rot> axes;                   // of each node: the x axis along its roller
  int free_rows = 0, rows = 0;
  double arm = 1;  // a moment over this length stands in the equations of turning [m]

  // Columns of A, compressed.
  std::vector<Column> columns;
  std::vector<std::array<int, 3>> column_of;  // by member: axial, moment a, moment b; -1: none
  std::vector<int> begin;
  std::vector<int> entry_row;
  std::vector<double> entry_value;
  std::vector<double> lengths;
  // The same row by row: equilibrium is looked at after every solve.
  std::vector<int> row_begin, row_column;
  std::vector<double> row_value;

  SparseLu lu;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt;
  Redundants redundants;
  bool by_redundants = false;  // forces come from them; displacements and influence lines from `ldlt`
  bool strained = false;       // the load bends members between their ends
  std::vector<double> p, s, strain, work;
  Eigen::VectorXd rhs, d;

  explicit State(Structure given) : structure(std::move(given)) {
    validate(structure);
    number();
    fill();
    analyse();
  }

  void number() {
    const std::size_t count = structure.nodes.size();
    row_of.assign(count, {-1, -1, -1});
    axes.assign(count, Rot{});
    std::vector<std::array<char, 3>> held(count, {0, 0, 0});
    std::vector<char> turns(count, 0);
    for (const Member& m : structure.members) {
      if (m.kind != MemberKind::Beam) continue;
      if (!m.hinge_a) turns[static_cast<std::size_t>(m.a)] = 1;
      if (!m.hinge_b) turns[static_cast<std::size_t>(m.b)] = 1;
    }
    for (const Support& support : structure.supports) {
      const auto i = static_cast<std::size_t>(support.node);
      held[i] = {support.kind != SupportKind::Roller, 1, support.kind == SupportKind::Fixed};
      if (support.kind == SupportKind::Roller) axes[i] = Rot::from_angle(support.angle);
    }
    for (const bool free : {true, false}) {
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          if (c == 2 && !turns[i]) continue;
          if ((held[i][c] == 0) == free) row_of[i][c] = rows++;
        }
      }
      if (free) free_rows = rows;
    }
  }

  void fill() {
    double sum = 0;
    for (std::size_t m = 0; m < structure.members.size(); ++m) {
      lengths.push_back(member_length(structure, static_cast<int>(m)));
      sum += lengths.back();
    }
    if (!lengths.empty()) arm = sum / static_cast<double>(lengths.size());
    begin.push_back(0);
    for (std::size_t m = 0; m < structure.members.size(); ++m) {
      const Member& member = structure.members[m];
      column_of.push_back({-1, -1, -1});
      const Vec2 along = (structure.nodes[static_cast<std::size_t>(member.b)].at -
                          structure.nodes[static_cast<std::size_t>(member.a)].at) /
                         lengths[m];
      // Forces of the nodes on the member, for one unit of each unknown.
      const auto add = [&](Unknown unknown, Vec2 on_a, Vec2 on_b, double turn_a, double turn_b) {
        column_of.back()[static_cast<std::size_t>(unknown)] = static_cast<int>(columns.size());
        columns.push_back({static_cast<int>(m), unknown});
        add_end(member.a, on_a, turn_a * lengths[m] / arm);
        add_end(member.b, on_b, turn_b * lengths[m] / arm);
        begin.push_back(static_cast<int>(entry_row.size()));
      };
      add(Unknown::Axial, -along, along, 0, 0);
      const bool beam = member.kind == MemberKind::Beam;
      const Vec2 across = perp(along);
      if (beam && !member.hinge_a) add(Unknown::MomentA, -across, across, -1, 0);
      if (beam && !member.hinge_b) add(Unknown::MomentB, across, -across, 0, 1);
      const bool elastic = member.modulus * member.area > 0 && (!beam || (member.hinge_a && member.hinge_b) ||
                                                                member.modulus * member.second_moment > 0);
      stiff = stiff && elastic;
    }
    row_begin.assign(static_cast<std::size_t>(rows) + 1, 0);
    for (const int row : entry_row) ++row_begin[static_cast<std::size_t>(row) + 1];
    for (std::size_t i = 0; i < static_cast<std::size_t>(rows); ++i) row_begin[i + 1] += row_begin[i];
    row_column.resize(entry_row.size());
    row_value.resize(entry_row.size());
    std::vector<int> next = row_begin;
    for (int c = 0; c < unknowns(); ++c) {
      for (int i = begin[static_cast<std::size_t>(c)]; i < begin[static_cast<std::size_t>(c) + 1]; ++i) {
        const auto at = static_cast<std::size_t>(
            next[static_cast<std::size_t>(entry_row[static_cast<std::size_t>(i)])]++);
        row_column[at] = c;
        row_value[at] = entry_value[static_cast<std::size_t>(i)];
      }
    }
  }

  /// Sum of A s in one row.
  double row_times_forces(int row) const {
    double sum = 0;
    const int end = row_begin[static_cast<std::size_t>(row) + 1];
    for (int i = row_begin[static_cast<std::size_t>(row)]; i < end; ++i)
      sum += row_value[static_cast<std::size_t>(i)] *
             s[static_cast<std::size_t>(row_column[static_cast<std::size_t>(i)])];
    return sum;
  }

  void add_end(int node, Vec2 force, double turn) {
    const auto i = static_cast<std::size_t>(node);
    const Vec2 local = inverse_rotate(axes[i], force);
    const double values[] = {local.x, local.y, turn};
    for (std::size_t c = 0; c < 3; ++c) {
      if (row_of[i][c] < 0 || values[c] == 0) continue;
      entry_row.push_back(row_of[i][c]);
      entry_value.push_back(values[c]);
    }
  }

  int unknowns() const { return static_cast<int>(columns.size()); }

  std::vector<Entry> entries(bool transposed) const {
    std::vector<Entry> list;
    list.reserve(entry_row.size());
    for (int c = 0; c < unknowns(); ++c) {
      for (int i = begin[static_cast<std::size_t>(c)]; i < begin[static_cast<std::size_t>(c) + 1]; ++i) {
        const int row = entry_row[static_cast<std::size_t>(i)];
        if (row >= free_rows) continue;
        const double value = entry_value[static_cast<std::size_t>(i)];
        list.push_back(transposed ? Entry{c, row, value} : Entry{row, c, value});
      }
    }
    return list;
  }

  void analyse() {
    determinacy.equations = free_rows;
    determinacy.unknowns = unknowns();
    // A square matrix with good pivots needs no further look.
    if (free_rows == unknowns() && lu.factor(free_rows, entries(false), kDependent)) {
      determinacy.rank = free_rows;
      method = ForceMethod::Equilibrium;
      return;
    }
    if (free_rows < unknowns() && surely_stable()) {
      determinacy.rank = free_rows;
    } else {
      const NullSpace motions = null_space(unknowns(), free_rows, entries(true), kDependent);
      determinacy.rank = motions.rank;
      for (const std::vector<double>& motion : motions.basis)
        determinacy.mechanisms.push_back(describe_mechanism(structure, row_of, axes, arm, motion));
      if (!determinacy.stable()) return;
    }
    ldlt.compute(stiffness_matrix());
    method = stiff ? ForceMethod::Stiffness : ForceMethod::MinimumNorm;
    // Where self-stress states are local, the force method needs fewer operations and loses fewer digits.
    by_redundants = redundants.factor(free_rows, unknowns(), entries(false), flexibility(),
                                      kLocalStates * columns.size());
  }

  /// F = S^-1, the identity where the minimum norm is wanted.
  std::vector<Entry> flexibility() const {
    std::vector<Entry> list;
    for (std::size_t i = 0; i < structure.members.size(); ++i) {
      const Member& m = structure.members[i];
      const double length = lengths[i];
      const double stretch = stiff ? length / (m.modulus * m.area) : 1;
      list.push_back({column_of[i][0], column_of[i][0], stretch});
      const double bend = stiff ? length * length * length / (6 * m.modulus * m.second_moment) : 0.5;
      for (const int c1 : {column_of[i][1], column_of[i][2]}) {
        for (const int c2 : {column_of[i][1], column_of[i][2]}) {
          if (c1 < 0 || c2 < 0 || (c1 != c2 && !stiff)) continue;
          list.push_back({c1, c2, (c1 == c2 ? 2 : 1) * bend});
        }
      }
    }
    return list;
  }

  /// Good pivots of A A^T, which are squares, spare the rank-revealing factorisation of A.
  bool surely_stable() {
    constexpr double kGoodPivot = 1e-9;
    if (free_rows == 0) return true;
    const bool given = stiff;
    stiff = false;  // every member counts alike
    ldlt.compute(stiffness_matrix());
    stiff = given;
    return ldlt.info() == Eigen::Success && ldlt.vectorD().minCoeff() > kGoodPivot;
  }

  /// A S A^T, assembled column by column.
  Eigen::SparseMatrix<double> stiffness_matrix() const {
    std::vector<Eigen::Triplet<double>> triplets;
    for (std::size_t m = 0; m < structure.members.size(); ++m) {
      for (const int c1 : column_of[m]) {
        for (const int c2 : column_of[m]) {
          if (c1 < 0 || c2 < 0) continue;
          const double k = stiffness(c1, c2);
          if (k != 0) add_product(static_cast<std::size_t>(c1), k, static_cast<std::size_t>(c2), triplets);
        }
      }
    }
    Eigen::SparseMatrix<double> matrix(free_rows, free_rows);
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    return matrix;
  }

  /// Column c1 times k times the transposed column c2.
  void add_product(std::size_t c1, double k, std::size_t c2, std::vector<Eigen::Triplet<double>>& out) const {
    for (int i = begin[c1]; i < begin[c1 + 1]; ++i) {
      for (int j = begin[c2]; j < begin[c2 + 1]; ++j) {
        const int row = entry_row[static_cast<std::size_t>(i)],
                  column = entry_row[static_cast<std::size_t>(j)];
        if (row < free_rows && column < free_rows)
          out.emplace_back(
              row, column,
              entry_value[static_cast<std::size_t>(i)] * k * entry_value[static_cast<std::size_t>(j)]);
      }
    }
  }

  /// Entry of S; the identity where the minimum norm is wanted.
  double stiffness(int c1, int c2) const {
    if (!stiff) return c1 == c2 ? 1 : 0;
    const Column& one = columns[static_cast<std::size_t>(c1)];
    const Column& two = columns[static_cast<std::size_t>(c2)];
    const auto i = static_cast<std::size_t>(one.member);
    const Member& m = structure.members[i];
    const double length = lengths[i];
    if (one.unknown == Unknown::Axial || two.unknown == Unknown::Axial)
      return one.unknown == two.unknown ? m.modulus * m.area / length : 0;
    // Clamped at both ends 4 and 2 E I / L, at one 3 E I / L; moments and rotations are scaled by L.
    const double unit = m.modulus * m.second_moment / (length * length * length);
    if (column_of[i][1] < 0 || column_of[i][2] < 0) return 3 * unit;
    return (c1 == c2 ? 4 : -2) * unit;
  }

  /// S x of the unknowns of one member, added to `out`.
  template <class X, class Out>
  void times_stiffness(X&& x, Out&& out) const {
    for (std::size_t m = 0; m < structure.members.size(); ++m) {
      for (const int c1 : column_of[m]) {
        if (c1 < 0) continue;
        double sum = 0;
        for (const int c2 : column_of[m])
          if (c2 >= 0) sum += stiffness(c1, c2) * x(static_cast<std::size_t>(c2));
        out(static_cast<std::size_t>(c1), sum);
      }
    }
  }

  template <class Vector>
  double transposed_times(std::size_t column, const Vector& d_free) const {
    double sum = 0;
    for (int i = begin[column]; i < begin[column + 1]; ++i) {
      const int row = entry_row[static_cast<std::size_t>(i)];
      if (row < free_rows) sum += entry_value[static_cast<std::size_t>(i)] * d_free[row];
    }
    return sum;
  }

  // --- Loads ---

  void add_force(int node, Vec2 force, double moment) {
    const auto i = static_cast<std::size_t>(node);
    const Vec2 local = inverse_rotate(axes[i], force);
    p[static_cast<std::size_t>(row_of[i][0])] += local.x;
    p[static_cast<std::size_t>(row_of[i][1])] += local.y;
    if (moment == 0) return;
    if (row_of[i][2] < 0)
      throw std::invalid_argument("load: a moment of " + to_text(moment) + " N m on " +
                                  node_label(structure, node) + ", where no beam is clamped");
    p[static_cast<std::size_t>(row_of[i][2])] += moment / arm;
  }

  void add_strain(int member, Vec2 turn) {
    const auto i = static_cast<std::size_t>(member);
    const Member& m = structure.members[i];
    if (!stiff || !(m.modulus * m.second_moment > 0)) return;
    const double factor = lengths[i] / (m.modulus * m.second_moment);
    if (column_of[i][1] >= 0) strain[static_cast<std::size_t>(column_of[i][1])] += factor * turn.x;
    if (column_of[i][2] >= 0) strain[static_cast<std::size_t>(column_of[i][2])] += factor * turn.y;
    // A hinge at the other end does not hold its rotation: the clamped one meets phi_a alone.
  }

  void gather(const Load& load) {
    p.assign(static_cast<std::size_t>(rows), 0);
    strain.assign(columns.size(), 0);
    strained = !load.spans.empty() || !load.lines.empty();
    for (const NodeLoad& l : load.nodes) add_force(l.node, l.force, l.moment);
    for (const SpanLoad& l : load.spans) {
      const Member& m = structure.members[static_cast<std::size_t>(l.member)];
      add_force(m.a, (1 - l.share) * l.force, 0);
      add_force(m.b, l.share * l.force, 0);
      const Span span(structure, l.member);
      add_strain(l.member, span.end_turn_of_force(l.share, dot(span.across, l.force)));
    }
    for (const LineLoad& l : load.lines) {
      const Member& m = structure.members[static_cast<std::size_t>(l.member)];
      const Span span(structure, l.member);
      const Vec2 half = 0.5 * span.length * l.force_per_length;
      add_force(m.a, half, 0);
      add_force(m.b, half, 0);
      add_strain(l.member, span.end_turn_of_line(dot(span.across, l.force_per_length)));
    }
  }

  double residual_of(std::vector<double>& r) const {
    r.resize(static_cast<std::size_t>(free_rows));
    double largest = 0, error = 0;
    for (const double force : s) largest = std::max(largest, std::abs(force));
    for (int row = 0; row < free_rows; ++row) {
      const auto i = static_cast<std::size_t>(row);
      r[i] = p[i] - row_times_forces(row);
      largest = std::max(largest, std::abs(p[i]));
      error = std::max(error, std::abs(r[i]));
    }
    return largest > 0 ? error / largest : 0;
  }

  /// @return the residual of equilibrium
  double solve_redundants() {
    redundants.solve(p, strained ? &strain : nullptr, s);
    const double residual = residual_of(work);
    // Self-stress states are in equilibrium to rounding of their own largest force. A correction costs as
    // much as the solve; a tenth of the 1e-12 that forces are promised to is not worth one.
    if (residual <= 1e-13) return residual;
    redundants.correct(work, s);
    return residual_of(work);
  }

  void solve_stiffness() {
    rhs = Eigen::VectorXd::Map(p.data(), free_rows);
    times_stiffness([&](std::size_t c) { return strain[c]; },
                    [&](std::size_t c, double value) {
                      for (int i = begin[c]; i < begin[c + 1]; ++i) {
                        const int row = entry_row[static_cast<std::size_t>(i)];
                        if (row < free_rows) rhs[row] += entry_value[static_cast<std::size_t>(i)] * value;
                      }
                    });
    d = ldlt.solve(rhs);
    s.resize(columns.size());
    times_stiffness([&](std::size_t c) { return transposed_times(c, d) - strain[c]; },
                    [&](std::size_t c, double value) { s[c] = value; });
    // Corrections are added to the forces, not to displacements of much larger size.
    for (int pass = 0; pass < 3 && residual_of(work) > 1e-15; ++pass) {
      const Eigen::VectorXd change = ldlt.solve(Eigen::VectorXd::Map(work.data(), free_rows));
      d += change;
      times_stiffness([&](std::size_t c) { return transposed_times(c, change); },
                      [&](std::size_t c, double value) { s[c] += value; });
    }
  }

  /// Displacements of a determinate structure, A^T d = S^-1 s + e0.
  void displace() {
    std::vector<double> e = strain;
    for (std::size_t i = 0; i < structure.members.size(); ++i) {
      const Member& m = structure.members[i];
      const double length = lengths[i];
      e[static_cast<std::size_t>(column_of[i][0])] +=
          s[static_cast<std::size_t>(column_of[i][0])] * length / (m.modulus * m.area);
      const double bend = length * length * length / (6 * m.modulus * m.second_moment);
      for (const int c1 : {column_of[i][1], column_of[i][2]}) {
        for (const int c2 : {column_of[i][1], column_of[i][2]}) {
          if (c1 >= 0 && c2 >= 0)
            e[static_cast<std::size_t>(c1)] += (c1 == c2 ? 2 : 1) * bend * s[static_cast<std::size_t>(c2)];
        }
      }
    }
    lu.solve_transposed(e, work);
    d = Eigen::VectorXd::Map(e.data(), free_rows);
  }

  void report(Response& out, bool displacements) const {
    out.members.resize(structure.members.size());
    const auto of = [&](int column) { return column < 0 ? 0 : s[static_cast<std::size_t>(column)]; };
    for (std::size_t m = 0; m < structure.members.size(); ++m) {
      const std::array<int, 3>& c = column_of[m];
      out.members[m] = {of(c[0]), of(c[1]) * lengths[m], of(c[2]) * lengths[m]};
    }
    out.reactions.resize(structure.supports.size());
    for (std::size_t k = 0; k < structure.supports.size(); ++k) {
      const auto node = static_cast<std::size_t>(structure.supports[k].node);
      const auto at = [&](std::size_t c) {
        const int row = row_of[node][c];
        // Held displacements: support + p = force on the members.
        return row < free_rows ? 0.0 : row_times_forces(row) - p[static_cast<std::size_t>(row)];
      };
      out.reactions[k] = {rotate(axes[node], {at(0), at(1)}), arm * at(2)};
    }
    out.displacements.clear();
    if (!displacements || !stiff) return;
    for (std::size_t node = 0; node < structure.nodes.size(); ++node) {
      const auto at = [&](std::size_t c) {
        const int row = row_of[node][c];
        return row >= 0 && row < free_rows ? d[row] : 0.0;
      };
      out.displacements.push_back({rotate(axes[node], {at(0), at(1)}), at(2) / arm});
    }
  }
};

StructureSolver::StructureSolver(Structure structure)
    : state_(std::make_unique<State>(std::move(structure))) {}
StructureSolver::~StructureSolver() = default;
StructureSolver::StructureSolver(StructureSolver&&) noexcept = default;
StructureSolver& StructureSolver::operator=(StructureSolver&&) noexcept = default;

const Structure& StructureSolver::structure() const {
  return state_->structure;
}
const Determinacy& StructureSolver::determinacy() const {
  return state_->determinacy;
}
ForceMethod StructureSolver::method() const {
  return state_->method;
}
bool StructureSolver::has_stiffness() const {
  return state_->stiff;
}

void StructureSolver::solve(const Load& load, Response& response, bool displacements) {
  State& state = *state_;
  validate(state.structure, load);
  if (state.method == ForceMethod::None) {
    response.members.assign(state.structure.members.size(), {});
    response.reactions.assign(state.structure.supports.size(), {});
    response.displacements.clear();
    response.residual = 0;
    return;
  }
  state.gather(load);
  if (state.by_redundants && !displacements) {
    response.residual = state.solve_redundants();
  } else {
    if (state.method == ForceMethod::Equilibrium) {
      state.s.assign(state.p.begin(), state.p.begin() + state.free_rows);
      state.lu.solve(state.s, state.work);
      if (displacements && state.stiff) state.displace();
    } else {
      state.solve_stiffness();
    }
    response.residual = state.residual_of(state.work);
  }
  state.report(response, displacements);
}

Response StructureSolver::solve(const Load& load, bool displacements) {
  Response response;
  solve(load, response, displacements);
  return response;
}

StructureSolver::Influence StructureSolver::influence(const Quantity& q) {
  State& state = *state_;
  const Structure& structure = state.structure;
  const bool of_member = q.kind <= Quantity::Kind::Moment;
  const std::size_t count = of_member ? structure.members.size() : structure.supports.size();
  if (q.index < 0 || static_cast<std::size_t>(q.index) >= count)
    throw std::invalid_argument(std::string("influence: no ") + (of_member ? "member " : "support ") +
                                std::to_string(q.index + 1) + ", there are " + std::to_string(count));
  if (!(q.share >= 0 && q.share <= 1))
    throw std::invalid_argument("influence: share must be from 0 to 1, got " + to_text(q.share));
  Influence out;
  out.quantity = q;
  out.force.assign(structure.nodes.size(), {});
  out.moment.assign(structure.nodes.size(), 0);
  out.strain.assign(state.columns.size(), 0);
  if (state.method == ForceMethod::None) return out;

  // The quantity is c' s + g' p.
  std::vector<double> c(state.columns.size(), 0), g(static_cast<std::size_t>(state.rows), 0);
  const auto index = static_cast<std::size_t>(q.index);
  if (of_member) {
    const std::array<int, 3>& columns = state.column_of[index];
    const double length = state.lengths[index];
    const auto set = [&](std::size_t which, double value) {
      if (columns[which] >= 0) c[static_cast<std::size_t>(columns[which])] = value;
    };
    if (q.kind == Quantity::Kind::Axial) set(0, 1);
    if (q.kind == Quantity::Kind::Shear) {
      set(1, -1);
      set(2, 1);
    }
    if (q.kind == Quantity::Kind::Moment) {
      set(1, (1 - q.share) * length);
      set(2, q.share * length);
    }
  } else {
    // A component of the support's force in the world's axes, from those of the node.
    const auto node = static_cast<std::size_t>(structure.supports[index].node);
    Vec2 direction{};
    if (q.kind == Quantity::Kind::ReactionX) direction = inverse_rotate(state.axes[node], {1, 0});
    if (q.kind == Quantity::Kind::ReactionY) direction = inverse_rotate(state.axes[node], {0, 1});
    const double weights[] = {direction.x, direction.y,
                              q.kind == Quantity::Kind::ReactionMoment ? state.arm : 0};
    for (std::size_t k = 0; k < 3; ++k) {
      const int row = state.row_of[node][k];
      if (row >= state.free_rows) g[static_cast<std::size_t>(row)] = -weights[k];
    }
    for (std::size_t col = 0; col < state.columns.size(); ++col) {
      for (int i = state.begin[col]; i < state.begin[col + 1]; ++i)
        c[col] -= state.entry_value[static_cast<std::size_t>(i)] *
                  g[static_cast<std::size_t>(state.entry_row[static_cast<std::size_t>(i)])];
    }
  }

  // y: the value per unit of p on the free displacements.
  Eigen::VectorXd y;
  if (state.method == ForceMethod::Equilibrium) {
    std::vector<double> x = c;
    state.lu.solve_transposed(x, state.work);
    y = Eigen::VectorXd::Map(x.data(), state.free_rows);
  } else {
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(state.free_rows);
    std::vector<double> weighted(c.size(), 0);
    state.times_stiffness([&](std::size_t k) { return c[k]; },
                          [&](std::size_t k, double value) { weighted[k] = value; });
    for (std::size_t col = 0; col < c.size(); ++col) {
      for (int i = state.begin[col]; i < state.begin[col + 1]; ++i) {
        const int row = state.entry_row[static_cast<std::size_t>(i)];
        if (row < state.free_rows) rhs[row] += state.entry_value[static_cast<std::size_t>(i)] * weighted[col];
      }
    }
    y = state.ldlt.solve(rhs);
    // q = y' (p + A S e0) - c' S e0
    state.times_stiffness([&](std::size_t k) { return state.transposed_times(k, y) - c[k]; },
                          [&](std::size_t k, double value) { out.strain[k] = value; });
  }
  for (std::size_t node = 0; node < structure.nodes.size(); ++node) {
    const auto at = [&](std::size_t k) {
      const int row = state.row_of[node][k];
      return row < 0 ? 0.0 : (row < state.free_rows ? y[row] : 0.0) + g[static_cast<std::size_t>(row)];
    };
    out.force[node] = rotate(state.axes[node], {at(0), at(1)});
    out.moment[node] = at(2) / state.arm;
  }
  return out;
}

double StructureSolver::value(const Influence& influence, const Load& load) const {
  State& state = *state_;
  validate(state.structure, load);
  double sum = 0;
  const auto at_node = [&](int node, Vec2 force) {
    sum += dot(influence.force[static_cast<std::size_t>(node)], force);
  };
  for (const NodeLoad& l : load.nodes) {
    at_node(l.node, l.force);
    sum += influence.moment[static_cast<std::size_t>(l.node)] * l.moment;
  }
  // Loads between the ends: their lever share at the nodes, the turning of the ends, and, on the member
  // itself, the forces of the simple beam.
  state.strain.assign(state.columns.size(), 0);
  const bool of_member = influence.quantity.kind <= Quantity::Kind::Moment;
  for (const SpanLoad& l : load.spans) {
    const Member& m = state.structure.members[static_cast<std::size_t>(l.member)];
    at_node(m.a, (1 - l.share) * l.force);
    at_node(m.b, l.share * l.force);
    const Span span(state.structure, l.member);
    state.add_strain(l.member, span.end_turn_of_force(l.share, dot(span.across, l.force)));
    if (of_member && l.member == influence.quantity.index)
      sum += span.part(span.of_force(l.share, l.force, influence.quantity.share), influence.quantity.kind);
  }
  for (const LineLoad& l : load.lines) {
    const Member& m = state.structure.members[static_cast<std::size_t>(l.member)];
    const Span span(state.structure, l.member);
    at_node(m.a, 0.5 * span.length * l.force_per_length);
    at_node(m.b, 0.5 * span.length * l.force_per_length);
    state.add_strain(l.member, span.end_turn_of_line(dot(span.across, l.force_per_length)));
    if (of_member && l.member == influence.quantity.index)
      sum += span.part(span.of_line(l.force_per_length, influence.quantity.share), influence.quantity.kind);
  }
  for (std::size_t c = 0; c < state.columns.size(); ++c) sum += influence.strain[c] * state.strain[c];
  return sum;
}

std::vector<std::vector<MemberForce>> StructureSolver::self_stresses() const {
  const State& state = *state_;
  const NullSpace space = null_space(state.free_rows, state.unknowns(), state.entries(false), kDependent);
  std::vector<std::vector<MemberForce>> result;
  for (const std::vector<double>& vector : space.basis) {
    const auto of = [&](int column) { return column < 0 ? 0 : vector[static_cast<std::size_t>(column)]; };
    std::vector<MemberForce>& forces = result.emplace_back(state.structure.members.size());
    for (std::size_t m = 0; m < forces.size(); ++m) {
      const std::array<int, 3>& c = state.column_of[m];
      forces[m] = {of(c[0]), of(c[1]) * state.lengths[m], of(c[2]) * state.lengths[m]};
    }
  }
  return result;
}

}  // namespace skerry::statics
