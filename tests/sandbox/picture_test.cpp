// SPDX-License-Identifier: MIT
//
// What a picture says has to be legible and true: labels of bridges and their scales, time axes, words in
// portrait pictures.
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/gl_renderer.h"
#include "sandbox/demo_files.h"
#include "sandbox/loop.h"
#include "sandbox/overlays/labels.h"
#include "sandbox/overlays/plot.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/painter.h"
#include "sandbox/window/window_fit.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace picture_test {

using testing::Contains;
using testing::HasSubstr;

/// A demo at a moment, and its picture as data.
class Shot {
 public:
  Shot(const std::string& path, double at, const std::vector<std::string>& names,
       const PaintOptions& paint = {}, LoopClock clock = {})
      : demo_(path, {}), history_(demo_, needs_of(names).systems, kFlashSeconds), paint_(paint) {
    demo_.observe(needs_of(names));
    clock.until = at;
    LoopCallbacks callbacks;
    callbacks.step = [&](Demo&) { history_.update(demo_); };
    run_loop(demo_, clock, callbacks);
    painter_.start(demo_, names);
    painter_.paint(demo_, history_, image_);
    Composer composer(render::style(render::Theme::Light), paint.width, paint.height);
    composer.show(names, paint.width, paint.height);
    camera_ = composer.camera(demo_);
    Selection selection;
    composer.scene(demo_, history_, camera_, selection, list_);
  }

  const render::Camera& camera() const { return camera_; }
  const render::DrawList& list() const { return list_; }
  const render::Sheet& sheet() const { return painter_.composer().sheet(); }

  std::vector<std::string> words() const {
    std::vector<std::string> result;
    for (const render::Mark& mark : sheet().marks())
      if (mark.kind == render::MarkKind::Text) result.emplace_back(sheet().words(mark));
    return result;
  }
  std::vector<std::string> labels() const {
    std::vector<std::string> result;
    for (const render::Label& label : list_[render::Layer::Labels].labels) result.push_back(label.text);
    return result;
  }
  /// What a label covers [px].
  PixelBox box(const render::Label& label) const {
    const double scale = render::ui_scale(camera_.height_px);
    const double width = render::text_width(label.text, static_cast<double>(label.size_px)) * scale,
                 height = static_cast<double>(label.size_px) * scale,
                 gap = static_cast<double>(label.offset_px) * scale;
    const render::Point at = camera_.to_pixels(label.at);
    double x = at.x - 0.5 * width, y = at.y - 0.5 * height;
    if (label.anchor == render::Anchor::Right) x = at.x + gap;
    if (label.anchor == render::Anchor::Left) x = at.x - gap - width;
    if (label.anchor == render::Anchor::Above) y = at.y - gap - height;
    if (label.anchor == render::Anchor::Below) y = at.y + gap;
    return {x, y, x + width, y + height};
  }
  /// The same for a text of the panels and the header.
  PixelBox box(const render::Mark& mark) const {
    const auto high = static_cast<double>(mark.width);
    const double width = render::text_width(sheet().words(mark), high * render::kSheetEm);
    const double shift = mark.align == render::Align::Left ? 0 : mark.align == render::Align::Right ? 1 : 0.5;
    const auto x = static_cast<double>(sheet().points(mark)->x) - shift * width,
               y = static_cast<double>(sheet().points(mark)->y);
    return {x, y, x + width, y + high};
  }

 private:
  Demo demo_;
  History history_;
  PaintOptions paint_;
  Painter painter_{paint_};
  render::Image image_;
  render::Camera camera_;
  render::DrawList list_;
};

bool overlap(const PixelBox& a, const PixelBox& b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

std::string demo_path(const std::string& name) {
  return find_demo(name, demo_tree()).path;
}

void expect_apart(const Shot& shot) {
  const std::vector<render::Label>& labels = shot.list()[render::Layer::Labels].labels;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const PixelBox box = shot.box(labels[i]);
    EXPECT_GE(box.left, 0) << labels[i].text;
    EXPECT_LE(box.right, shot.camera().width_px) << labels[i].text;
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_FALSE(overlap(box, shot.box(labels[k]))) << labels[i].text << " / " << labels[k].text;
  }
}

TEST(Bridges, TheLargestReactionsHaveTheirNumbersAtTheirArrows) {
  const Shot shot(demo_path("suspension_bridge"), 7.2, {"stresses"});
  const std::vector<std::string> labels = shot.labels();
  EXPECT_EQ(std::count(labels.begin(), labels.end(), "1.25 MN"), 2) << "both anchors";
  EXPECT_THAT(labels, Contains("1.20 MN"));
  expect_apart(shot);
}

TEST(Bridges, NumbersKeepOffTheScaleOfColoursAndEachOther) {
  for (const auto& [width, height] : {std::pair(1280, 720), std::pair(640, 360), std::pair(720, 1280)}) {
    const PaintOptions paint{.width = width, .height = height};
    const Shot arch(demo_path("arch_bridge"), 1.5, {"stresses"}, paint);
    EXPECT_THAT(arch.labels(), Contains("331 kN"));
    expect_apart(arch);
    expect_apart(Shot(demo_path("howe_truss"), 4, {"stresses"}, paint));
    expect_apart(Shot(demo_path("warren_truss"), 4, {"stresses", "timeline"}, paint));
  }
}

// Length of a newton's arrow [m]: by the legend, and by the largest reaction.
TEST(Bridges, ArrowsAndMomentsKeepTheScaleOfTheLargestSoFar) {
  const std::string path = demo_path("arch_bridge");
  const auto legend_length = [](const Shot& shot) {
    return std::abs(shot.list()[render::Layer::Labels].arrows.front().to.x -
                    shot.list()[render::Layer::Labels].arrows.front().from.x);
  };
  const auto longest = [](const Shot& shot) {
    double length = 0;
    for (const render::Arrow& arrow : shot.list()[render::Layer::Contacts].arrows)
      length = std::max(length, std::hypot(arrow.to.x - arrow.from.x, arrow.to.y - arrow.from.y));
    return length;
  };
  const Shot loaded(path, 6, {"stresses"}), empty(path, 10, {"stresses"});
  EXPECT_THAT(empty.labels(), Contains("support reaction 500 kN"));
  EXPECT_THAT(empty.labels(), Contains("bending moment 500 kN m, on the stretched side"));
  EXPECT_THAT(empty.labels(), Contains("125 kN"));
  EXPECT_NEAR(longest(empty), 0.25 * legend_length(empty), 0.01 * legend_length(empty));
  EXPECT_GT(longest(loaded), legend_length(loaded));
  EXPECT_NEAR(legend_length(loaded), legend_length(empty), 1e-12);
  // A frame of a video shows what a picture of that moment does.
  const Shot video(path, 10, {"stresses"}, {}, {.fps = 30, .speed = 0.5});
  EXPECT_EQ(video.list(), empty.list());
}

TEST(Bridges, SaysHowManyMoreMembersBroke) {
  const Shot shot(demo_path("failing_bridge"), 6, {"stresses"});
  EXPECT_THAT(shot.labels(),
              Contains(testing::MatchesRegex("member .* broke at .* s in .*, and [1-9][0-9]* more")));
}

TEST(Influence, AxlesAreStraightStrokes) {
  const Shot shot(demo_path("warren_truss"), 6, {"influence"});
  int strokes = 0;
  for (const render::Mark& mark : shot.sheet().marks()) {
    if (mark.kind != render::MarkKind::Stroke) continue;
    const render::Pixel* p = shot.sheet().points(mark);
    for (std::uint32_t k = 2; k < mark.count; ++k) EXPECT_FALSE(p[k] == p[k - 2]) << "a stroke and back";
    if (mark.color == render::style(render::Theme::Light).force && mark.count == 2 && p[0].x == p[1].x)
      ++strokes;
  }
  EXPECT_EQ(strokes, 6);
}

TEST(TimeAxes, ShowHowMuchOfTheDemoAStillIs) {
  const TemporaryFolder folder;
  const std::string path =
      folder.write("fall.lua",
                   "demo{ title = 'Fall', seconds = 4, dt = 0.1, view = { x = 0, y = 0, height = 5 } }\n"
                   "disc{ at = {0, 2}, radius = 0.5, mass = 1e6 }\n");
  const render::Style& style = render::style(render::Theme::Light);
  // Width of the curve that has the colour of text.
  const auto width_of = [&](const Shot& shot) {
    for (const render::Mark& mark : shot.sheet().marks()) {
      const render::Pixel* p = shot.sheet().points(mark);
      if (mark.kind == render::MarkKind::Stroke && mark.color == style.text && mark.count > 2)
        return p[mark.count - 1].x - p[0].x;
    }
    return 0.0f;
  };
  for (const char* panel : {"energy", "momentum"}) {
    const std::vector<std::string> names{panel, "timeline"};
    const Shot half(path, 2, names), whole(path, 4, names), beyond(path, 8, names);
    EXPECT_THAT(half.words(), Contains("4 s")) << "the timeline's end";
    EXPECT_GT(width_of(whole), 100);
    EXPECT_NEAR(width_of(half), 0.5f * width_of(whole), 10) << "numbers at the axis are of other widths";
    // Past the end the axis grows with the time.
    EXPECT_THAT(beyond.words(), Contains("8 s"));
    EXPECT_NEAR(width_of(beyond), width_of(whole), 20);
  }
  // All curves are named, with numbers as long as there is room.
  const Shot shot(path, 2, {"energy"});
  for (const char* name : {"kinetic ", "potential ", "sum "})
    EXPECT_THAT(shot.words(), Contains(testing::StartsWith(name)));
}

TEST(Plot, NumbersAreShort) {
  EXPECT_EQ(short_number(17340.6, 4), "17341");
  EXPECT_EQ(short_number(-123456, 4), "-123456");
  EXPECT_EQ(short_number(1.7341e7, 4), "1.734e7");
  EXPECT_EQ(short_number(-2.1e-12, 4), "-2.1e-12");
  EXPECT_EQ(short_number(1.5e-7, 4), "1.5e-7");
  EXPECT_EQ(short_number(0, 4), "0");
  EXPECT_EQ(short_number(355.34, 4), "355.3");
  EXPECT_EQ(short_number(HUGE_VAL, 4), "inf");
}

TEST(Loop, EndsAtAMomentAndTheDemoKeepsItsLength) {
  for (const double at : {0.0, 0.525, 3.5, 7.0}) {
    Demo demo(demo_path("bounce_to_rest"), {});
    const double seconds = demo.seconds();
    EXPECT_TRUE(run_loop(demo, {.until = at}, {}));
    EXPECT_EQ(demo.steps_done(), steps_until(at, demo.dt()));
    EXPECT_EQ(demo.seconds(), seconds);
    EXPECT_GE(demo.time(), at - 1e-9);
  }
}

TEST(Portrait, WordsDoNotCoverEachOther) {
  const PaintOptions paint{.width = 720, .height = 1280};
  const Shot shot(demo_path("see_saw"), 1, {"contacts", "impulses"}, paint);
  std::vector<PixelBox> texts;
  for (const render::Mark& mark : shot.sheet().marks()) {
    if (mark.kind != render::MarkKind::Text) continue;
    const PixelBox box = shot.box(mark);
    EXPECT_GE(box.left, 0) << shot.sheet().words(mark);
    EXPECT_LE(box.right, 720) << shot.sheet().words(mark);
    for (const PixelBox& other : texts) EXPECT_FALSE(overlap(box, other)) << shot.sheet().words(mark);
    texts.push_back(box);
  }
  ASSERT_GE(texts.size(), 5u) << "title, clock, lesson, note";
  for (const render::Label& label : shot.list()[render::Layer::Labels].labels)
    for (const PixelBox& text : texts) EXPECT_FALSE(overlap(shot.box(label), text)) << label.text;
  EXPECT_LE(std::count_if(texts.begin(), texts.end(), [](const PixelBox& box) { return box.bottom < 139; }),
            5);
  for (const std::string& words : shot.words()) EXPECT_THAT(words, testing::Not(HasSubstr(".."))) << "cut";
}

TEST(Portrait, AViewWithoutAWidthStillShowsWhatMoves) {
  const PaintOptions paint{.width = 720, .height = 1280};
  const Shot shot(demo_path("newtons_cradle"), 0, {}, paint);
  for (const render::Disc& disc : shot.list()[render::Layer::Bodies].discs) {
    EXPECT_GT(shot.camera().to_pixels({disc.centre.x - disc.radius, 0}).x, 0);
    EXPECT_LT(shot.camera().to_pixels({disc.centre.x + disc.radius, 0}).x, 720);
  }
}

TEST(WindowFit, ToolbarHasMoreRowsInNarrowWindows) {
  EXPECT_EQ(fit_window(1280, 720).rows, 1);
  EXPECT_DOUBLE_EQ(fit_window(1280, 720).scale, 720 / (720 + kToolbarPx));
  EXPECT_EQ(fit_window(800, 600).rows, 1);
  EXPECT_EQ(fit_window(720, 1280).rows, 2);
  EXPECT_EQ(fit_window(400, 1280).rows, 3);
  for (int width = 320; width < 2000; width += 40) {
    for (int height = 240; height < 2000; height += 40) {
      const WindowFit fit = fit_window(width, height);
      EXPECT_GE(fit.scale, 0.6);
      EXPECT_GE(fit.scale * (720 + fit.toolbar_px()), height - 1e-9);
    }
  }
}

}  // namespace picture_test
}  // namespace skerry::sandbox
