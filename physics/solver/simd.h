// SPDX-License-Identifier: MIT
//
// Four doubles side by side, for the 3-vectors and 3x3 blocks of the body-space solvers (the fourth lane is
// zero). Hot loops are compiled twice, for the baseline and for AVX2, and chosen once at run time. Both give
// the same bits: only additions, multiplications and divisions lane by lane, never a fused multiply-add.
//
// Vectors are never passed by value: without AVX that has no stable calling convention.
#pragma once

#include "physics/cpu.h"

#define SKERRY_ALWAYS_INLINE inline __attribute__((always_inline))
#if defined(__x86_64__)
#define SKERRY_AVX2 __attribute__((target("avx2")))
#else
#define SKERRY_AVX2
#endif

namespace skerry {

using Vec4 = double __attribute__((vector_size(32)));

/// One vector of the body space: the three components of one body. (A struct, because bare vector
/// types have an alignment that depends on the instruction set.)
struct alignas(32) BodyVector {
  Vec4 v;
};

inline double dot3(const BodyVector& x, const BodyVector& y) {
  return (x.v[0] * y.v[0] + x.v[1] * y.v[1]) + x.v[2] * y.v[2];
}

/// Calls `Kernel::run(arguments...)`, compiled for AVX2 where the processor has it. `run` has to be always
/// inlined, and so has what it calls with vectors.
template <class Kernel, class... Arguments>
SKERRY_AVX2 inline auto kernel_avx2(Arguments&... arguments) {
  return Kernel::run(arguments...);
}
template <class Kernel, class... Arguments>
inline auto kernel_portable(Arguments&... arguments) {
  return Kernel::run(arguments...);
}
template <class Kernel, class... Arguments>
inline auto run_kernel(Arguments&&... arguments) {
  return cpu_has_avx2() ? kernel_avx2<Kernel>(arguments...) : kernel_portable<Kernel>(arguments...);
}

/// Vectors of four become numbers of four.
SKERRY_ALWAYS_INLINE void transpose(Vec4& p, Vec4& q, Vec4& r, Vec4& s) {
  const Vec4 a = __builtin_shufflevector(p, q, 0, 4, 2, 6), b = __builtin_shufflevector(p, q, 1, 5, 3, 7);
  const Vec4 c = __builtin_shufflevector(r, s, 0, 4, 2, 6), d = __builtin_shufflevector(r, s, 1, 5, 3, 7);
  p = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  q = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  r = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  s = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

}  // namespace skerry
