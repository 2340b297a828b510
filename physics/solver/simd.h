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

}  // namespace skerry
