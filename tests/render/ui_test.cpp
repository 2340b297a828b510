// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <imgui.h>

#include "render/doctor.h"
#include "render/ui_host.h"
#include "tests/render/support.h"

namespace skerry::render {
namespace ui_test {

class Panels : public GlTest {
 protected:
  Panels() : GlTest(640, 360) {}

  /// Drawn by OpenGL; the built-in rasteriser has to agree.
  template <class Content>
  Image frame(UiHost& ui, const Content& content, const UiInput& input = {}, double scale = 1) {
    Target target(640, 360);
    renderer.draw(list, camera, target);
    ui.begin_frame(640, 360, scale, 1.0 / 60, input);
    content();
    ui.end_frame(target);
    Image image, own;
    target.read(image);
    Canvas canvas(640, 360);
    canvas.draw(list, camera);
    ui.end_frame(canvas);
    canvas.take(own);
    expect_agreement(image, own);
    return image;
  }
};

TEST_F(Panels, DrawOverThePictureWhereTheyWerePut) {
  UiHost ui(style(Theme::Light));
  const auto panel = [&] {
    ImGui::SetNextWindowPos({400, 40});
    ImGui::SetNextWindowSize({200, 100});
    ImGui::Begin("Matrix", nullptr, ImGuiWindowFlags_NoCollapse);
    ImGui::TextUnformatted("W \xce\xbb = b");
    ImGui::End();
  };
  for (int i = 0; i < 2; ++i) frame(ui, panel);
  list.background = {10, 60, 10, 255};
  const Image image = frame(ui, panel);
  EXPECT_EQ(image.at(300, 200), list.background);
  const Color inside = image.at(590, 120), panel_color = style(Theme::Light).panel;
  EXPECT_NEAR(inside.r, panel_color.r, 20);  // the panel is nearly opaque
  EXPECT_EQ(image.at(590, 320), list.background);
  // Text: something dark inside of the window.
  int dark = 0;
  for (int y = 62; y < 90; ++y) {
    for (int x = 405; x < 500; ++x) dark += image.at(x, y).r < 100;
  }
  EXPECT_GT(dark, 30);
  EXPECT_EQ(image, frame(ui, panel));
}

TEST_F(Panels, CostNothingWhenThereAreNone) {
  UiHost ui(style(Theme::Dark));
  const Image image = frame(ui, [] {});
  EXPECT_EQ(image, Image(640, 360, list.background));
}

// All letters of all fonts would take so much room then that they are baked coarser and smaller.
TEST_F(Panels, LettersOfVeryLargePicturesAreThereAndAsLargeAsAsked) {
  UiHost ui(style(Theme::Light));
  list.background = kWhite;
  double small = 0;
  for (const int lines : {720, 16384}) {
    const double scale = ui_scale(lines);
    const auto letters = [&] {
      ImDrawList& to = *ImGui::GetForegroundDrawList();
      ImFont* const fonts[] = {ui.regular(), ui.bold(), ui.title(), ui.mono()};
      for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(fonts[i]->FontSize, std::round((i < 2 ? 16 : i == 2 ? 23 : 15) * scale));
        to.AddText(fonts[i], 80, {150.0f * static_cast<float>(i) + 10, 20}, IM_COL32_BLACK, "Wg");
        to.AddText(fonts[i], 80, {150.0f * static_cast<float>(i) + 10, 150}, IM_COL32_BLACK, "\u2264e");
      }
    };
    const Image image = frame(ui, letters, {}, scale);
    for (int i = 0; i < 4; ++i) {
      for (int half = 0; half < 4; ++half) {
        double dark = 0;
        for (int y = 0; y < 110; ++y)
          for (int x = 0; x < 60; ++x)
            dark += 255 - image.at(150 * i + 10 + 60 * (half % 2) + x, 20 + 130 * (half / 2) + y).r;
        EXPECT_GT(dark, 255 * 300) << lines << " lines, font " << i << ", letter " << half;
      }
    }
    if (lines == 720) small = ink(image);
    EXPECT_NEAR(ink(image), small, 0.05 * small) << lines;
  }
}

TEST_F(Panels, ShowTexturesPixelByPixel) {
  UiHost ui(style(Theme::Light));
  UiTexture texture;
  Image cells(3, 2, kRed);
  cells.set(2, 1, kBlue);
  texture.upload(cells);
  const auto panel = [&] { ImGui::GetForegroundDrawList()->AddImage(texture.id(), {100, 100}, {160, 140}); };
  const Image image = frame(ui, panel);
  EXPECT_EQ(image.at(101, 101), kRed);
  EXPECT_EQ(image.at(159, 139), kBlue);
  EXPECT_EQ(image.at(141, 121), kBlue);
  EXPECT_EQ(image.at(138, 121), kRed);
  EXPECT_EQ(image.at(141, 118), kRed);
}

// Shapes of every kind that ImGui makes, see-through and on odd coordinates: agreement is checked by frame().
TEST_F(Panels, TheTwoRenderersAgreeOnAllThatImGuiDraws) {
  UiHost ui(style(Theme::Light));
  UiTexture smooth(true);
  Image cells(5, 4, kRed);
  for (int i = 0; i < 20; ++i) cells.set(i % 5, i / 5, {static_cast<std::uint8_t>(12 * i), 90, 200, 160});
  smooth.upload(cells);
  list.background = {230, 240, 250, 255};
  const auto shapes = [&] {
    ImDrawList& to = *ImGui::GetForegroundDrawList();
    const ImU32 pale = IM_COL32(200, 30, 60, 100), dark = IM_COL32(10, 60, 90, 255);
    to.AddRectFilled({10.3f, 10.7f}, {120.9f, 60.2f}, pale, 9);
    to.AddRect({20.5f, 20.5f}, {100.5f, 50.5f}, dark, 4, 0, 2);
    to.AddRectFilledMultiColor({140, 10}, {240, 60}, pale, dark, IM_COL32_WHITE, dark);
    to.AddCircleFilled({300.2f, 40.4f}, 25.3f, pale, 40);
    to.AddCircle({360, 40}, 20, dark, 0, 3);
    to.AddTriangleFilled({400, 10}, {470.4f, 33.3f}, {420.7f, 66}, pale);
    to.AddNgonFilled({520, 40}, 28, dark, 7);
    for (int i = 0; i < 12; ++i) {
      const float at = static_cast<float>(i);
      to.AddLine({20 + 3.3f * at, 90}, {20 + 9.1f * at, 150 + 1.7f * at}, dark, 0.5f + 0.4f * at);
    }
    to.AddBezierCubic({160, 90}, {220, 200}, {260, 60}, {320, 150}, pale, 4);
    to.AddImage(smooth.id(), {340.5f, 90.5f}, {440.2f, 160.7f});
    to.AddImage(smooth.id(), {460, 90}, {560, 160}, {0.2f, 0.9f}, {0.8f, 0.1f}, pale);
    to.AddText({20.5f, 180.2f}, dark, "Every letter W \xce\xbb = b at odd places, 0123456789");
    to.AddText(ui.title(), 31, {20, 210}, pale, "Larger than it was baked");
    to.PushClipRect({300.5f, 200.5f}, {360.5f, 230.5f}, true);
    to.AddCircleFilled({330, 215}, 60, pale);
    to.PopClipRect();
    // Beyond the picture on all sides, and of no size.
    to.AddRectFilled({-50, 300}, {900, 320}, pale);
    to.AddTriangleFilled({-100, 340}, {700, 330}, {300, 900}, dark);
    to.AddTriangleFilled({10, 340}, {10, 340}, {10, 340}, dark);
  };
  EXPECT_NE(frame(ui, shapes), Image(640, 360, list.background));
}

TEST_F(Panels, FollowTheThemeAndTheScale) {
  UiHost ui(style(Theme::Light));
  ui.begin_frame(640, 360, 1, 0.01);
  const float small = ui.regular()->FontSize;
  ui.end_frame();
  ui.begin_frame(640, 360, 1.5, 0.01);
  EXPECT_NEAR(ui.regular()->FontSize, 1.5f * small, 0.6f);
  const ImVec4 light = ImGui::GetStyle().Colors[ImGuiCol_WindowBg];
  ui.end_frame();
  ui.set_style(style(Theme::Dark));
  EXPECT_LT(ImGui::GetStyle().Colors[ImGuiCol_WindowBg].x, light.x);
  EXPECT_NE(ui.bold(), ui.regular());
  EXPECT_THROW(ui.begin_frame(0, 10, 1, 0.1), std::invalid_argument);
  EXPECT_THROW(ui.begin_frame(10, 10, 1, 0), std::invalid_argument);
}

TEST_F(Panels, TakeMouseAndKeys) {
  UiHost ui(style(Theme::Light));
  int clicks = 0;
  bool focus = false;
  char text[32] = "";
  const auto panel = [&] {
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({300, 200});
    ImGui::Begin("p", nullptr, ImGuiWindowFlags_NoTitleBar);
    clicks += ImGui::Button("press", {100, 30});
    if (focus) ImGui::SetKeyboardFocusHere();
    ImGui::InputText("t", text, sizeof text);
    ImGui::End();
  };
  UiInput input;
  input.mouse_x = 50;
  input.mouse_y = 25;
  for (int i = 0; i < 3; ++i) frame(ui, panel, input);
  EXPECT_TRUE(ui.wants_mouse());
  input.mouse_down[0] = true;
  frame(ui, panel, input);
  input.mouse_down[0] = false;
  frame(ui, panel, input);
  frame(ui, panel, input);
  EXPECT_EQ(clicks, 1);
  focus = true;
  for (int i = 0; i < 3; ++i) frame(ui, panel);
  focus = false;
  input = {};
  input.text = "ab";
  frame(ui, panel, input);
  frame(ui, panel);
  EXPECT_STREQ(text, "ab");
  EXPECT_FALSE(ui.wants_mouse());
}

TEST(Doctor, FindsWhatTheTestsNeedAndNamesRemediesForTheRest) {
  bool gl = false, x264 = false;
  for (const DoctorLine& line : examine()) {
    EXPECT_FALSE(line.what.empty());
    EXPECT_EQ(line.ok, line.remedy.empty()) << line.what;
    if (line.required) {
      EXPECT_TRUE(line.ok) << line.what << ": " << line.detail;
    }
    gl = gl || (line.ok && line.what == "OpenGL renderer");
    x264 = x264 || (line.ok && line.what == "encoder libx264");
  }
  EXPECT_TRUE(gl);
  EXPECT_TRUE(x264);
}

TEST(Cameras, MapPixelsAndWorldBackAndForth) {
  Camera camera;
  camera.centre = {3, -2};
  camera.height = 7.2;
  const Point p = camera.to_pixels({4, -1});
  EXPECT_DOUBLE_EQ(p.x, 740);
  EXPECT_DOUBLE_EQ(p.y, 260);
  const Point w = camera.to_world({123, 456});
  EXPECT_NEAR(camera.to_pixels(w).x, 123, 1e-9);
  EXPECT_NEAR(camera.to_pixels(w).y, 456, 1e-9);
  camera.zoom_at({123, 456}, 2.5);
  EXPECT_NEAR(camera.to_pixels(w).x, 123, 1e-9);
  EXPECT_NEAR(camera.to_pixels(w).y, 456, 1e-9);
  EXPECT_NEAR(camera.height, 7.2 / 2.5, 1e-12);
  camera.pan(10, 20);
  EXPECT_NEAR(camera.to_pixels(w).x, 133, 1e-9);
  EXPECT_NEAR(camera.to_pixels(w).y, 476, 1e-9);
  camera.frame({-10, 0}, {10, 1}, 0.05);
  EXPECT_NEAR(camera.to_pixels({-10, 0}).x, 64, 1e-9);
  EXPECT_NEAR(camera.to_pixels({10, 0}).x, 1216, 1e-9);
  camera.frame({5, 5}, {5, 5});
  EXPECT_EQ(camera.height, 1);
  EXPECT_THROW(camera.zoom_at({0, 0}, 0), std::invalid_argument);
}

/// Perceived distance of two colours: CIE 1976 L*a*b*, after an optional simulation of a colour blindness.
struct Lab {
  double l, a, b;
};
Lab lab(double r, double g, double b) {
  const double x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505, y = 0.2126 * r + 0.7152 * g + 0.0722 * b,
               z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  return {116 * f(y) - 16, 500 * (f(x) - f(y)), 200 * (f(y) - f(z))};
}

// Machado, Oliveira, Fernandes 2009, severity 1.0: protanopia, deuteranopia, tritanopia.
constexpr double kBlindness[4][9] = {
    {1, 0, 0, 0, 1, 0, 0, 0, 1},
    {0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998},
    {0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.011820, 0.042940, 0.968881},
    {1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.303900}};

Lab seen(Color color, const double (&m)[9]) {
  const auto linear = [](int v) {
    const double c = v / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  const double r = linear(color.r), g = linear(color.g), b = linear(color.b);
  const auto clamp = [](double v) { return std::clamp(v, 0.0, 1.0); };
  return lab(clamp(m[0] * r + m[1] * g + m[2] * b), clamp(m[3] * r + m[4] * g + m[5] * b),
             clamp(m[6] * r + m[7] * g + m[8] * b));
}

double distance(Lab a, Lab b) {
  return std::hypot(a.l - b.l, a.a - b.a, a.b - b.b);
}

TEST(Styles, BodiesAndArrowsCanBeToldApartWithAnyColourVision) {
  for (const Theme theme : {Theme::Light, Theme::Dark}) {
    const Style& s = style(theme);
    for (const auto& blindness : kBlindness) {
      const auto apart = [&](Color a, Color b) { return distance(seen(a, blindness), seen(b, blindness)); };
      for (int i = 0; i < kHueCount; ++i) {
        EXPECT_GT(apart(s.bodies[i].fill, s.background), 12) << to_string(theme) << i;
        EXPECT_GT(apart(s.bodies[i].fill, s.bodies[i].outline), 20) << to_string(theme) << i;
        for (int k = 0; k < i; ++k) {
          // Fill and outline together tell two bodies apart.
          EXPECT_GT(
              apart(s.bodies[i].fill, s.bodies[k].fill) + apart(s.bodies[i].outline, s.bodies[k].outline), 14)
              << to_string(theme) << ": " << i << " and " << k << " with matrix " << blindness[0];
        }
      }
      EXPECT_GT(apart(s.impulse, s.friction), 25);
      // Arrows stand on each other; 2.3 is just noticeable [Mahy, Van Eycken, Oosterlinck 1994].
      const Color arrows[] = {s.normal, s.impulse, s.friction, s.velocity, s.force};
      for (std::size_t i = 0; i < std::size(arrows); ++i) {
        EXPECT_GT(apart(arrows[i], s.background), 40) << to_string(theme) << i;
        EXPECT_GT(apart(arrows[i], s.ground.fill), 30) << to_string(theme) << i;
        for (std::size_t k = 0; k < i; ++k)
          EXPECT_GT(apart(arrows[i], arrows[k]), 11)
              << to_string(theme) << ": arrows " << i << " and " << k << " with matrix " << blindness[0];
      }
      EXPECT_GT(apart(s.text, s.background), 60);
      EXPECT_GT(apart(s.text_dim, s.background), 35);
    }
  }
}

TEST(Styles, HaveNamesAndWrapAround) {
  EXPECT_EQ(parse_theme("light"), Theme::Light);
  EXPECT_EQ(parse_theme(to_string(Theme::Dark)), Theme::Dark);
  EXPECT_FALSE(parse_theme("pink").has_value());
  const Style& s = style(Theme::Light);
  EXPECT_EQ(body_paint(s, -1).fill, s.bodies[kHueCount - 1].fill);
  EXPECT_EQ(body_paint(s, 17).fill, s.bodies[1].fill);
  EXPECT_EQ(ui_scale(1080), 1.5);
  EXPECT_EQ(ui_scale(100), 0.6);
  EXPECT_EQ(faded({1, 2, 3, 200}, 0.5), (Color{1, 2, 3, 100}));
  EXPECT_EQ(mixed({0, 0, 0, 0}, {200, 100, 50, 255}, 0.5), (Color{100, 50, 25, 128}));
}

// Letters keep what they cover from frame to frame: the picture is that of a host that never drew before, and
// that of a processor with fewer lanes.
TEST_F(Panels, LettersThatStayAndLettersThatMoveAreTheSameBits) {
  const auto picture = [&](UiHost& ui, float x, float y, double scale, bool avx2) {
    ui.begin_frame(640, 360, scale, 1.0 / 60);
    ImDrawList& out = *ImGui::GetBackgroundDrawList();
    out.AddText({x, y}, IM_COL32(20, 30, 40, 255), "resting contacts: W \xce\xbb = b, 0123456789");
    out.AddText({x + 500.3f, y + 3}, IM_COL32(200, 30, 40, 120), "cut by the edge of the picture");
    out.AddText({-9.6f, y + 40}, IM_COL32(0, 0, 200, 255), "and by the left one");
    out.AddRectFilled({x, y + 60}, {x + 90.5f, y + 90.25f}, IM_COL32(40, 90, 10, 130), 6);
    out.AddRect({x, y + 60}, {x + 90.5f, y + 90.25f}, IM_COL32(40, 90, 10, 255), 6, 0, 1);
    for (int i = 0; i < 60; ++i)  // slivers
      out.AddLine({x + 0.2f * static_cast<float>(i), y + 120},
                  {x + 0.2f * static_cast<float>(i + 1), y + 121.5f}, IM_COL32(90, 0, 90, 255), 1.8f);
    Canvas canvas(640, 360, 1, avx2);
    canvas.draw(list, camera);
    ui.end_frame(canvas);
    Image image;
    canvas.take(image);
    return image;
  };
  UiHost kept(style(Theme::Light));
  list.background = {240, 240, 230, 255};
  for (const auto& [x, y, scale] :
       {std::array{20.0, 30.0, 1.0}, std::array{20.0, 30.0, 1.0}, std::array{27.0, 31.0, 1.0},
        std::array{27.37, 31.0, 1.0}, std::array{20.0, 30.0, 1.5}, std::array{20.0, 30.0, 1.0}}) {
    UiHost fresh(style(Theme::Light)), plain(style(Theme::Light));
    const auto left = static_cast<float>(x), top = static_cast<float>(y);
    const Image expected = picture(fresh, left, top, scale, true);
    EXPECT_EQ(picture(kept, left, top, scale, true), expected) << x << ", " << scale;
    EXPECT_EQ(picture(plain, left, top, scale, false), expected) << x << ", " << scale;
  }
}

}  // namespace ui_test
}  // namespace skerry::render
