// SPDX-License-Identifier: MIT
//
// The GL driver keeps memory until the process ends; it is not ours to free.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libEGL_mesa\nleak:libgallium\nleak:swrast_dri\nleak:libLLVM\nleak:libdrm\n";
}
