// SPDX-License-Identifier: MIT
#include "physics/solver/run_pooling.h"

namespace skerry {

void RunPooling::solve(double* impulse) const {
  const double* const push = push_.data();
  impulse[n_] = 0;
  each_at_rest([&](int k) { impulse[k] = 0; });
  // The row that was last, in registers: most rows stand just before it.
  int last = n_;
  double of_last = 0;
  for (const Joined* j = join_.data() + joined_; j-- != join_.data();) {
    const double behind = j->behind == last ? of_last : impulse[j->behind];
    const double left = j->left * push[j->before], right = j->right * push[j->behind - 1];
    of_last = (j->g + left * impulse[j->before]) + right * behind;
    last = j->row;
    impulse[last] = of_last;
  }
}

}  // namespace skerry
