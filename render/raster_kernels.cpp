// SPDX-License-Identifier: MIT
#include "render/raster_kernels.h"

#include "render/raster_table.h"

namespace skerry::render {
namespace {

bool cpu_has_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") != 0;
#else
  return false;
#endif
}

}  // namespace

const RasterKernels kFourLanes = kTable;

const RasterKernels& raster_kernels(bool avx2) {
  static const bool has = kEightLanes != nullptr && cpu_has_avx2();
  return avx2 && has ? *kEightLanes : kFourLanes;
}

}  // namespace skerry::render
