// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: parts of a file that use AVX2, beside a version for every processor.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "physics/cpu.h"

// SKERRY_MAY_USE_AVX2: there may be code between SKERRY_AVX2_BEGIN and SKERRY_AVX2_END, to be called if
// `has_avx2`. SKERRY_MUST_HAVE_AVX2: the whole program is compiled for it, so there is no other version.
// (clang 14 can switch it on function by function only, so it has none unless it must.)
#if defined(__AVX2__)
#define SKERRY_MAY_USE_AVX2 1
#define SKERRY_MUST_HAVE_AVX2 1
#define SKERRY_AVX2_BEGIN
#define SKERRY_AVX2_END
#elif defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define SKERRY_MAY_USE_AVX2 1
#define SKERRY_AVX2_BEGIN _Pragma("GCC push_options") _Pragma("GCC target(\"avx2\")")
#define SKERRY_AVX2_END _Pragma("GCC pop_options")
#endif

namespace skerry::narrow {

/// Whether to call what stands between them.
inline bool has_avx2() {
#if defined(SKERRY_MUST_HAVE_AVX2)
  return true;
#elif defined(SKERRY_MAY_USE_AVX2)
  return cpu_has_avx2();
#else
  return false;
#endif
}

}  // namespace skerry::narrow
