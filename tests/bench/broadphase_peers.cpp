// SPDX-License-Identifier: MIT
#include "tests/bench/broadphase_scenes.h"

namespace skerry::bench {

std::vector<BenchEntry> peers() {
  return {};
}

}  // namespace skerry::bench
