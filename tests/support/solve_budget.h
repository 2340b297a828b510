// SPDX-License-Identifier: MIT
//
// Budgets for parts of solvers, for tests.
#pragma once

#include "physics/solver/body_space_active_set.h"

namespace skerry::test {

inline SolveBudget factors(int most) {
  SolveBudget budget;
  budget.factorisations = most;
  return budget;
}

}  // namespace skerry::test
