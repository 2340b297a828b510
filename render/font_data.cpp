// SPDX-License-Identifier: MIT
#include "render/font_data.h"

// The assembler copies the files into the read-only section: no generated source, no time to compile it.
#define SKERRY_EMBED(symbol, file)                      \
  __asm__(                                              \
      ".pushsection .rodata\n"                          \
      ".balign 16\n"                                    \
      ".global skerry_" #symbol "\nskerry_" #symbol     \
      ":\n"                                             \
      ".incbin \"" SKERRY_FONT_DIR "/" file             \
      "\"\n"                                            \
      ".global skerry_" #symbol "_end\nskerry_" #symbol \
      "_end:\n.byte 0\n"                                \
      ".popsection\n");                                 \
  extern "C" {                                          \
  extern const std::uint8_t skerry_##symbol[];          \
  extern const std::uint8_t skerry_##symbol##_end[];    \
  }

SKERRY_EMBED(dejavu_sans, "DejaVuSans.ttf")
SKERRY_EMBED(dejavu_sans_bold, "DejaVuSans-Bold.ttf")
SKERRY_EMBED(dejavu_sans_mono, "DejaVuSansMono.ttf")

namespace skerry::render {
namespace {

FontData between(const std::uint8_t* begin, const std::uint8_t* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

FontData sans_font() {
  return between(skerry_dejavu_sans, skerry_dejavu_sans_end);
}
FontData sans_bold_font() {
  return between(skerry_dejavu_sans_bold, skerry_dejavu_sans_bold_end);
}
FontData mono_font() {
  return between(skerry_dejavu_sans_mono, skerry_dejavu_sans_mono_end);
}

}  // namespace skerry::render
