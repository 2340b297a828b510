// SPDX-License-Identifier: MIT
//
// Compiled for AVX2 (CMakeLists.txt), and called only where there is one.
#if defined(__AVX2__)
#define SKERRY_EIGHT_LANES
#include "render/raster_table.h"
#else
#include "render/raster_kernels.h"
#endif

namespace skerry::render {

#if defined(__AVX2__)
constinit const RasterKernels* const kEightLanes = &kTable;
#else
constinit const RasterKernels* const kEightLanes = nullptr;
#endif

}  // namespace skerry::render
