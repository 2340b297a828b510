// SPDX-License-Identifier: MIT
#include "physics/registry.h"

#include "physics/solver/solver.h"

namespace skerry {

// In the order of the menus: the ladder first, then its rungs, references and previews.
extern const SolverEntry kAutoEntry;
extern const SolverEntry kClosedFormEntry;
extern const SolverEntry kTridiagonalEntry;
extern const SolverEntry kBilateralEntry;
extern const SolverEntry kSmallExactEntry;
extern const SolverEntry kBodySpaceEntry;
extern const SolverEntry kConvexStepEntry;
extern const SolverEntry kDenseLuEntry;
extern const SolverEntry kIncrementalLdltEntry;
extern const SolverEntry kSparseContactEntry;
extern const SolverEntry kLemkeEntry;
extern const SolverEntry kPgsEntry;
extern const SolverEntry kNncgEntry;
extern const SolverEntry kTgsSoftEntry;

namespace {

std::span<const SolverEntry> table() {
  // Copied at the first call: other files may not be initialised when this one is.
  static const SolverEntry entries[] = {
      kAutoEntry,      kClosedFormEntry, kTridiagonalEntry, kBilateralEntry,       kSmallExactEntry,
      kBodySpaceEntry, kConvexStepEntry, kDenseLuEntry,     kIncrementalLdltEntry, kSparseContactEntry,
      kLemkeEntry,     kPgsEntry,        kNncgEntry,        kTgsSoftEntry,
  };
  return entries;
}

}  // namespace

std::string_view to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::Solved:
      return "solved";
    case SolveStatus::Inexact:
      return "inexact";
    case SolveStatus::Singular:
      return "singular";
    case SolveStatus::Unsupported:
      return "unsupported";
    case SolveStatus::Failed:
      return "failed";
  }
  return "unknown";
}

std::span<const SolverEntry> solvers() {
  return table();
}

const SolverEntry& find_solver(std::string_view name) {
  return find_entry("solver", name, solvers());
}

}  // namespace skerry
