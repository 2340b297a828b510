// SPDX-License-Identifier: MIT
//
// How safely a world at rest stands: the horizontal acceleration, as a share of gravity, that it bears to
// either side (what tilting the ground slowly would do), and how it would go then.
#pragma once

#include "physics/statics/limit_load.h"
#include "physics/statics/rest.h"

namespace skerry::statics {

struct Stability {
  LimitStatus status = LimitStatus::Failed;
  double margin =
      0;  ///< smaller of the two sides' accelerations over gravity [1]; infinite: nothing can move
  bool to_left = false;  ///< the weaker side
  LimitLoad limit;       ///< of the weaker side, with the mechanism
  int contact = -1;      ///< in RestAnalysis::contacts: the one that moves most in the mechanism
  bool slides = false;   ///< it slides; otherwise it opens
};

/// Limit analysis of the contacts and joints of `rest`, which stands, with its own loads dead (springs and
/// forces stay what they are), and the weights of its bodies sideways live. Without weights: `NoLoad`.
Stability stability_of(const RestAnalysis& rest);

}  // namespace skerry::statics
