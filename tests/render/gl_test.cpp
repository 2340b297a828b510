// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "render/egl_context.h"
#include "render/gl_renderer.h"
#include "render/image.h"
#include "render/style.h"

namespace skerry::render {
namespace {

DrawList gallery(Theme theme) {
  const Style& s = style(theme);
  DrawList list;
  list.background = s.background;
  DrawLayer& back = list[Layer::Background];
  for (int i = -20; i <= 20; ++i) {
    const Color c = i % 10 == 0 ? s.grid_major : s.grid;
    back.lines.push_back({{i * 1.0, -100}, {i * 1.0, 100}, c, 1});
    back.lines.push_back({{-100, i * 1.0}, {100, i * 1.0}, c, 1});
  }
  DrawLayer& b = list[Layer::Bodies];
  const Point ground[] = {{-1e9, -1e6}, {1e9, -1e6}, {1e9, 0}, {-1e9, 0}};
  b.polygon(ground, 4, s.ground.fill, s.ground.outline, 0, s.outline_px);
  for (int i = 0; i < kHueCount; ++i) {
    const double x = -7 + 2 * i, a = 0.2 * i;
    Point corners[64];
    const int n = 3 + i;
    for (int k = 0; k < n; ++k) corners[k] = {x + 0.7 * std::cos(a + 6.2831853 * k / n), 4.2 + 0.7 * std::sin(a + 6.2831853 * k / n)};
    const Paint& p = body_paint(s, i);
    b.polygon(corners, n, p.fill, p.outline, i % 2 ? 0.1 : 0, s.outline_px);
    b.discs.push_back({{x, 2.5}, 0.6, p.fill, p.outline, s.outline_px, a, true});
    b.capsules.push_back({{x - 0.4, 6}, {x + 0.4, 6 + 0.1 * i}, 0.25, p.fill, p.outline, s.outline_px});
    const double c = std::cos(a), d = std::sin(a);
    const Point box[] = {{x - 0.5 * c + 0.3 * d, 0.8 - 0.5 * d - 0.3 * c}, {x + 0.5 * c + 0.3 * d, 0.8 + 0.5 * d - 0.3 * c},
                         {x + 0.5 * c - 0.3 * d, 0.8 + 0.5 * d + 0.3 * c}, {x - 0.5 * c - 0.3 * d, 0.8 - 0.5 * d + 0.3 * c}};
    b.polygon(box, 4, p.fill, p.outline, 0, s.outline_px);
    DrawLayer& k = list[Layer::Contacts];
    k.arrows.push_back({{x, 2.5}, {x + 0.8 * std::cos(a * 2), 2.5 + 0.8 * std::sin(a * 2)}, i % 2 ? s.impulse : s.friction, s.arrow_px, s.arrow_head_px});
    k.arrows.push_back({{x, 0}, {x, 0.1 * i}, s.impulse, s.arrow_px, s.arrow_head_px});
    k.markers.push_back({{x, 0}, s.contact, s.halo, s.contact_px});
    list[Layer::Labels].labels.push_back({{x, 3.2}, "j = " + std::to_string(i) + ".25 N s", s.text, s.halo, s.text_px, Anchor::Centre});
    list[Layer::Labels].labels.push_back({{x, 5.2}, "Body µ·" + std::to_string(i), s.text, s.halo, s.small_text_px, Anchor::Above});
  }
  list[Layer::Structure].lines.push_back({{-8, 7}, {8, 7.5}, s.structure, 2, 8});
  list[Layer::Structure].lines.push_back({{-8, 6.9}, {8, 7.4}, s.joint, s.joint_px, 0});
  list[Layer::Labels].labels.push_back({{0, -0.6}, "Newton's cradle: momentum is kept, energy too", s.text, s.halo, s.title_px, Anchor::Centre});
  list[Layer::Labels].labels.push_back({{0, -1.0}, "right of the point", s.text_dim, s.halo, s.text_px, Anchor::Right});
  list[Layer::Labels].labels.push_back({{0, -1.0}, "left of the point", s.text_dim, s.halo, s.text_px, Anchor::Left});
  list[Layer::Contacts].markers.push_back({{0, -1.0}, s.warning, s.text, 4});
  return list;
}

TEST(GlRenderer, DrawsTheGallery) {
  EglContext context;
  for (const auto& a : context.attempts()) printf("%s: %d %s\n", a.way.c_str(), a.ok, a.detail.c_str());
  GlRenderer renderer;
  for (int ssaa : {1, 2}) {
  Target target(1280, 720, ssaa);
  Camera camera;
  camera.centre = {0, 3.2};
  camera.height = 9.5;
  for (Theme theme : {Theme::Light, Theme::Dark}) {
    renderer.draw(gallery(theme), camera, target);
    Image image;
    target.read(image);
    write_png("/tmp/r_" + std::string(to_string(theme)) + std::to_string(ssaa) + ".png", image);
  }}
}

}  // namespace
}  // namespace skerry::render
