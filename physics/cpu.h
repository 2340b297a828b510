// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdlib>

namespace skerry {

/// How many doubles this processor works on side by side: 8 with AVX-512 (F, DQ, VL), 4 with AVX2, else 2.
/// `SKERRY_LANES` in the environment takes fewer, as older processors have; bits do not depend on it.
inline int cpu_lanes() {
  static const int lanes = [] {
    int has = 2;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) has = 4;
    if (has == 4 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
      has = 8;
#endif
    const char* most = std::getenv("SKERRY_LANES");
    return most == nullptr ? has : std::min(has, std::atoi(most));
  }();
  return lanes;
}

/// Whether code that was compiled for AVX2 may run.
inline bool cpu_has_avx2() {
  return cpu_lanes() >= 4;
}

/// The same for AVX-512.
inline bool cpu_has_avx512() {
  return cpu_lanes() >= 8;
}

}  // namespace skerry
