// SPDX-License-Identifier: MIT
#pragma once

namespace skerry {

/// Work that a step leaves out because its result is known, each with a switch, so that what it saves can be
/// measured and that it changes nothing can be tested. All on is right; off is for tests and benchmarks.
/// `WorldConfig::reuse_resting`, `sleep` and `solve.welds_as_one` are three more.
struct Skips {
  bool manifolds =
      true;             ///< bodies that did not move by a bit keep their manifold (resting islands need this)
  bool axes = true;     ///< separating axes of the last step are tried first; the same bits without
  bool factors = true;  ///< solvers keep factors and states from step to step; the same to rounding
  bool smooth_rows = true;  ///< no friction rows where mu is 0; the same to the solver's tolerance
  bool alike = true;  ///< bodies that fly alike are no pair until something strikes one; the same to rounding
  bool flight = true;  ///< islands without contacts, whose joints do nothing, fly in closed form; to rounding
};

}  // namespace skerry
