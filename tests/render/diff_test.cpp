// SPDX-License-Identifier: MIT
#include <cmath>
#include <functional>
#include <random>

#include "render/image_diff.h"
#include "tests/render/support.h"

namespace skerry::render {
namespace diff_test {

Image with_difference(const Image& image, int x, int y, int amount) {
  Image copy = image;
  Color c = copy.at(x, y);
  c.g = static_cast<std::uint8_t>(c.g + amount);
  copy.set(x, y, c);
  return copy;
}

TEST(ImageDiff, PassesEqualAndRoundedPictures) {
  const Image image(50, 40, {100, 100, 100, 255});
  EXPECT_TRUE(compare(image, image).identical);
  Image rounded = image;
  for (std::size_t i = 0; i < rounded.rgba.size(); ++i) {
    if (i % 4 != 3) rounded.rgba[i] = static_cast<std::uint8_t>(98 + i % 5);
  }
  const DiffResult result = compare(image, rounded);
  EXPECT_TRUE(result.pass);
  EXPECT_FALSE(result.identical);
  EXPECT_EQ(result.max_difference, 2);
  EXPECT_FALSE(compare(image, with_difference(image, 3, 3, 3)).pass);
}

TEST(ImageDiff, FindsBlobsAcrossDiagonalsAndMeasuresTheWorst) {
  const Image image(50, 40, {100, 100, 100, 255});
  Image changed = image;
  for (int i = 0; i < 5; ++i) changed = with_difference(changed, 10 + i, 20 - i, 30);
  changed = with_difference(changed, 40, 5, 9);
  changed = with_difference(changed, 42, 5, 9);
  const DiffResult result = compare(image, changed);
  EXPECT_EQ(result.beyond, 7);
  EXPECT_EQ(result.blobs, 3);
  EXPECT_EQ(result.worst_blob, 5);
  EXPECT_EQ(result.worst_box.x, 10);
  EXPECT_EQ(result.worst_box.y, 16);
  EXPECT_EQ(result.worst_box.width, 5);
  EXPECT_EQ(result.worst_box.height, 5);
  EXPECT_EQ(result.max_difference, 30);
}

TEST(ImageDiff, AnotherDriverMayMoveSinglePixelsOnly) {
  const Image image(100, 100, {100, 100, 100, 255});
  const DiffRule rule{2, true, 64, 6};
  Image changed = image;
  for (int i = 0; i < 64; ++i) changed = with_difference(changed, 3 * (i % 30), 3 * (i / 30), 50);
  EXPECT_TRUE(compare(image, changed, rule).pass);
  EXPECT_FALSE(compare(image, changed).pass);
  EXPECT_FALSE(compare(image, with_difference(changed, 0, 50, 50), rule).pass);
  changed = image;
  for (int i = 0; i < 6; ++i) changed = with_difference(changed, 50 + i, 50, 50);
  EXPECT_TRUE(compare(image, changed, rule).pass);
  EXPECT_FALSE(compare(image, with_difference(changed, 56, 50, 50), rule).pass);
}

TEST(ImageDiff, SizesMustAgree) {
  const DiffResult result = compare(Image(10, 10), Image(10, 11));
  EXPECT_FALSE(result.pass);
  EXPECT_FALSE(result.same_size);
  const Image picture = difference_image(Image(10, 10), Image(12, 8));
  EXPECT_EQ(picture.width, 12);
  EXPECT_EQ(picture.height, 10);
}

TEST(ImageDiff, DifferenceImageShowsWhereAndHowMuch) {
  const Image image(20, 20, {100, 100, 100, 255});
  const Image picture =
      difference_image(image, with_difference(with_difference(image, 5, 6, 2), 15, 16, 100));
  const Color equal = picture.at(0, 0), rounded = picture.at(5, 6), wrong = picture.at(15, 16);
  EXPECT_EQ(equal.r, equal.b);
  EXPECT_GT(rounded.b, rounded.r);
  EXPECT_EQ(wrong.r, 255);
  EXPECT_LT(wrong.g, 100);
}

/// A small scene as the sandbox draws it.
void fill(DrawList& list, Theme theme) {
  const Style& s = style(theme);
  list.clear();
  list.background = s.background;
  for (int i = 0; i < 6; ++i) {
    const Paint& p = body_paint(s, i);
    const double x = -2.5 + i;
    const Point box[] = {{x - 0.4, 0}, {x + 0.4, 0}, {x + 0.4, 0.8}, {x - 0.4, 0.8}};
    list[Layer::Bodies].polygon(box, 4, p.fill, p.outline, 0, s.outline_px);
    list[Layer::Bodies].discs.push_back({{x, 1.2}, 0.4, p.fill, p.outline, s.outline_px, 0.4 * i, true});
    list[Layer::Contacts].arrows.push_back({{x, 0.8}, {x, 1.1}, s.normal, s.normal_px, 8});
    list[Layer::Contacts].markers.push_back({{x, 0.8}, s.contact, s.halo, s.contact_px});
    list[Layer::Labels].labels.push_back(
        {{x, -0.4}, "0." + std::to_string(i) + "31 N s", s.text, s.halo, 15});
  }
  list[Layer::Structure].lines.push_back({{-3, -1}, {3, -1}, s.structure, 1.5f, 6});
}

// Whatever a person could do to a scene must fail, also by the rule for other drivers.
TEST(ImageDiff, EveryPlantedRegressionFails) {
  const EglContext context(test_device());
  GlRenderer renderer;
  Camera camera;
  camera.height = 5;
  Target target(1280, 720);
  const auto draw = [&](const DrawList& list) {
    renderer.draw(list, camera, target);
    Image image;
    target.read(image);
    return image;
  };
  struct Plant {
    const char* what;
    std::function<void(DrawList&)> change;
  };
  const double tenth_px = 0.1 * 5 / 720;
  const std::vector<Plant> plants = {
      {"a normal is missing", [](DrawList& l) { l[Layer::Contacts].arrows.pop_back(); }},
      {"a contact point is missing", [](DrawList& l) { l[Layer::Contacts].markers.pop_back(); }},
      {"a digit changed", [](DrawList& l) { l[Layer::Labels].labels[2].text[3] = '8'; }},
      {"a label is missing", [](DrawList& l) { l[Layer::Labels].labels.pop_back(); }},
      {"a label moved by a pixel", [&](DrawList& l) { l[Layer::Labels].labels[0].at.x += 10 * tenth_px; }},
      {"a disc moved by 0.1 px", [&](DrawList& l) { l[Layer::Bodies].discs[3].centre.x += tenth_px; }},
      {"a box moved by 0.1 px",
       [&](DrawList& l) {
         for (int i = 0; i < 4; ++i) l[Layer::Bodies].points[i].y += tenth_px;
       }},
      {"a disc turned by half a degree", [](DrawList& l) { l[Layer::Bodies].discs[1].angle += 0.0087; }},
      {"a fill off by 12", [](DrawList& l) { l[Layer::Bodies].discs[0].fill.r -= 12; }},
      {"an outline off by 12", [](DrawList& l) { l[Layer::Bodies].polygons[0].outline.g += 12; }},
      {"the background off by 3", [](DrawList& l) { l.background.b -= 3; }},
      {"an outline thicker by 0.2 px", [](DrawList& l) { l[Layer::Bodies].discs[0].outline_px += 0.2f; }},
      {"an arrow shorter by a pixel",
       [&](DrawList& l) { l[Layer::Contacts].arrows[0].to.y -= 10 * tenth_px; }},
      {"an arrow thinner", [](DrawList& l) { l[Layer::Contacts].arrows[0].width_px -= 0.3f; }},
      {"a marker larger", [](DrawList& l) { l[Layer::Contacts].markers[0].radius_px += 0.3f; }},
      {"a line solid instead of dashed", [](DrawList& l) { l[Layer::Structure].lines[0].dash_px = 0; }},
      {"a halo is missing",
       [](DrawList& l) {
         l[Layer::Labels].labels[1].halo.a = 0;
         l.background.r -= 3;
       }},
      {"two bodies in the other order",
       [](DrawList& l) {
         l[Layer::Bodies].discs[0].centre.x += 0.3;
         std::swap(l[Layer::Bodies].discs[0], l[Layer::Bodies].discs[1]);
       }},
  };
  for (const Theme theme : {Theme::Light, Theme::Dark}) {
    DrawList list;
    fill(list, theme);
    const Image expected = draw(list);
    EXPECT_TRUE(compare(expected, draw(list)).identical);
    for (const Plant& plant : plants) {
      fill(list, theme);
      plant.change(list);
      const DiffResult result = compare(expected, draw(list), {2, true, 64, 6});
      EXPECT_FALSE(result.pass) << plant.what << " (" << to_string(theme) << "): " << result.reason;
    }
  }
}

}  // namespace diff_test
}  // namespace skerry::render
