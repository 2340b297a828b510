// SPDX-License-Identifier: MIT
#include "physics/stepping/projection_rows.h"

#include <algorithm>
#include <cmath>

#include "physics/solver/auto.h"
#include "physics/solver/bilateral.h"
#include "physics/solver/welded_bodies.h"
#include "physics/spare.h"
#include "physics/stepping/island_notes.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Residual of the solves, relative to the error that they take out; and the share of what counts as rounding
// that they may leave.
constexpr double kTolerance = 1e-12, kShareOfFloor = 0.1;
// Rows from which on what stays open is left out: the shortest shift costs little for fewer.
constexpr std::size_t kManyRows = 64;
// Solves without what stays open, at most; the share of the rows that may join in one of them, as what lands
// is many; and the share of the error that they may leave, which Newton's iteration takes out.
constexpr int kClosedRounds = 10;
constexpr double kFewChanges = 0.05, kShareLeft = 0.1;

/// @param floor   errors below this are rounding, in the unit of the right-hand side
/// @param lambda  exchanged for the answer
void solve_rows(WorldState& state, SolvePurpose purpose, const IslandSystem& system, double floor,
                IslandResult& result, std::vector<double>& lambda) {
  SolveOptions options;
  // Redundant rows contradict each other by rounding: of an error that is hardly more, no solver leaves less.
  options.tolerance = std::max(kTolerance, kShareOfFloor * floor / largest_magnitude(system.b));
  // One joint or contact is the most frequent case, and there is nothing to choose.
  if (state.solver->solve == solve_auto &&
      solve_few_without_bounds(system, options.tolerance, lambda, result.work))
    return;
  options.work_limit = work_left(state, result);
  options.threads = state.island_threads;
  options.welds_as_one = state.config.solve.welds_as_one;
  MemoryLoan memory(state, result, purpose, system);
  Solution solution = state.solver->solve(system, {}, options, memory.get());
  note_work(result, solution.work, solution.status);
  lambda.swap(solution.lambda);
  give_spare(std::move(solution.lambda));
}

/// What `solve_closed_rows` needs for a moment.
struct ClosedScratch {
  std::vector<std::uint8_t> closed;  ///< by row
  std::vector<std::size_t> chosen;   ///< rows of `part`
  IslandSystem part;
  std::vector<Velocity> shift;
};

/// The rows that are closed, as rows that hold both ways.
void select_closed(const IslandSystem& system, ClosedScratch& scratch) {
  IslandSystem& part = scratch.part;
  scratch.chosen.clear();
  part.rows.clear();
  part.b.clear();
  part.bodies = system.bodies;
  part.positions = system.positions;
  for (std::size_t i = 0; i < scratch.closed.size(); ++i) {
    if (scratch.closed[i] == 0) continue;
    scratch.chosen.push_back(i);
    Row& row = part.rows.emplace_back(system.rows[i]);
    row.kind = RowKind::Joint;
    row.lower = -kInfinity;
    part.b.push_back(system.b[i]);
  }
}

/// Answers rows that hold both ways, and rows with lambda >= 0 of which most stay open, without these: what
/// is closed has no bounds, and its problem is linear. Of overlaps those stay that want to be pushed apart,
/// and what the answer would close joins until nothing does. That is an answer, though perhaps not the
/// shortest shift.
/// @param floor   errors below this are rounding, in the unit of the right-hand side
/// @param lambda  becomes the answer, if there is one; it may leave some of the error
/// @return false where there are few rows, or there is none: other bounds, too much that joins, rows that
/// contradict each other
bool solve_closed_rows(WorldState& state, const IslandSystem& system, double floor, IslandResult& result,
                       std::vector<double>& lambda) {
  if (state.solver->solve != solve_auto || !system.compliance.empty()) return false;
  if (system.rows.size() < kManyRows) return false;
  Spare<ClosedScratch> scratch;
  std::vector<std::uint8_t>& closed = scratch->closed;
  closed.assign(system.rows.size(), 0);
  bool all = true;
  for (std::size_t i = 0; i < closed.size(); ++i) {
    const Row& row = system.rows[i];
    const bool holds = row.lower == -kInfinity;
    if (row.normal >= 0 || row.upper < kInfinity || !(holds || row.lower == 0)) return false;
    closed[i] = holds || system.b[i] > 0;
    all &= holds;
  }
  if (all) return false;
  SolveOptions options;
  options.threads = state.island_threads;
  options.welds_as_one = state.config.solve.welds_as_one;
  for (int round = 0; round < kClosedRounds; ++round) {
    select_closed(system, *scratch);
    const double largest = largest_magnitude(scratch->part.b);
    options.tolerance = std::max(kTolerance, kShareOfFloor * floor / largest);
    lambda.assign(closed.size(), 0);
    MemoryLoan memory(state, result, SolvePurpose::Positions, scratch->part);
    Solution solution = solve_without_bounds(scratch->part, options, memory.get());
    result.work += solution.work;
    for (std::size_t k = 0; k < scratch->chosen.size(); ++k) lambda[scratch->chosen[k]] = solution.lambda[k];
    give_spare(std::move(solution.lambda));
    if (!(solution.residual * residual_scale(largest) <= std::max(kShareLeft * largest, floor))) return false;
    scratch->shift.assign(system.bodies.size(), Velocity{});
    apply_impulses(system, lambda, scratch->shift);
    std::size_t changes = 0;
    for (std::size_t i = 0; i < closed.size(); ++i) {
      const Row& row = system.rows[i];
      if (row.lower < 0) continue;
      const bool opens = round == 0 && closed[i] != 0 && lambda[i] < 0;
      double u = -system.b[i];
      if (row.a >= 0) u += along(row.Ja, scratch->shift[static_cast<std::size_t>(row.a)]);
      if (row.b >= 0) u += along(row.Jb, scratch->shift[static_cast<std::size_t>(row.b)]);
      const bool closes = closed[i] == 0 && u < -floor;
      if (opens || closes) closed[i] = closes;
      changes += opens || closes;
    }
    if (changes == 0) return true;
    if (static_cast<double>(changes) > kFewChanges * static_cast<double>(closed.size())) return false;
  }
  return false;
}

}  // namespace

bool is_kept_closed(const WorldState& state, const RowOrigin& origin) {
  if (origin.kind == RowKind::Limit) return (state.held_rows[origin.index] >> origin.point & 1) != 0;
  return origin.kind == RowKind::Normal &&
         state.contacts[origin.index].points[origin.point].normal_impulse > 0;
}

void open_row(WorldState& state, const RowOrigin& origin) {
  if (origin.joint) {
    state.held_rows[origin.index] &= static_cast<std::uint8_t>(~(1u << origin.point));
    return;
  }
  state.contacts[origin.index].points[origin.point].let_go();
}

void solve_for_motion(WorldState& state, SolvePurpose purpose, const Assembly& assembly, double floor,
                      IslandResult& result, std::vector<double>& lambda, std::vector<Velocity>& motion) {
  const IslandSystem& system = assembly.system;
  const auto solve = [&](const IslandSystem& rows, std::vector<double>& answer) {
    if (purpose == SolvePurpose::Positions && solve_closed_rows(state, rows, floor, result, answer)) return;
    solve_rows(state, purpose, rows, floor, result, answer);
  };
  const auto contact = std::find_if(assembly.origin.begin(), assembly.origin.end(),
                                    [](const RowOrigin& origin) { return !origin.joint; });
  Spare<WeldedBodies> welded;
  if (state.solver->solve != solve_auto || !state.config.solve.welds_as_one ||
      !welded->find(system, static_cast<int>(contact - assembly.origin.begin()))) {
    solve(system, lambda);
    apply_impulses(system, lambda, motion);
    return;
  }
  std::vector<double> own = take_spare<std::vector<double>>();
  solve(welded->groups(), own);
  result.work.rows_left_out += welded->rows_less();
  if (purpose == SolvePurpose::Velocities) {
    SolveOptions options = state.config.solve;
    options.threads = state.island_threads;
    MemoryLoan memory(state, result, SolvePurpose::Welds, welded->welds());
    welded->expand(own, options, memory.get(), lambda, result.work);
  } else {
    lambda.assign(system.rows.size(), 0);
    for (std::size_t k = 0; k < own.size(); ++k) lambda[static_cast<std::size_t>(welded->rows()[k])] = own[k];
  }
  welded->move(own, motion);
  give_spare(std::move(own));
}

}  // namespace skerry
