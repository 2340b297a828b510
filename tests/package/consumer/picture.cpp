// SPDX-License-Identifier: MIT
#include "render/image.h"
#include "render/svg.h"

int main() {
  const skerry::render::Image image(4, 4, {255, 0, 0, 255});
  return skerry::render::encode_png(image).size() > 40 ? 0 : 1;
}
