// SPDX-License-Identifier: MIT
#pragma once

namespace skerry {

/// Whether code that was compiled for AVX2 may run on this processor.
inline bool cpu_has_avx2() {
#if defined(__x86_64__)
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
#else
  return false;
#endif
}

}  // namespace skerry
