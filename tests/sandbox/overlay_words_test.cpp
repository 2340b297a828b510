// SPDX-License-Identifier: MIT
//
// What overlays say: the forces of the inspector, numbers without noise, words that are not cut where they
// matter, values beside what they belong to.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>
#include <tuple>

#include "render/gl_renderer.h"
#include "sandbox/loop.h"
#include "sandbox/overlays/labels.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/painter.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace overlay_words_test {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// A demo that has run, and its picture.
class Shown {
 public:
  Shown(const std::string& script, const std::vector<std::string>& names, double seconds, int width = 1280,
        int height = 720)
      : demo(folder_.write("scene.lua", script), {.seconds = seconds}),
        painter({.width = width, .height = height}) {
    const Observe needs = needs_of(names);
    demo.observe(needs);
    history.emplace(demo, needs.systems, kFlashSeconds);
    LoopCallbacks callbacks;
    callbacks.step = [&](Demo&) { history->update(demo); };
    run_loop(demo, {}, callbacks);
    painter.start(demo, names);
    painter.select(resolve(demo.picture().selection, demo.world()));
    render::Image image;
    painter.paint(demo, *history, image);
  }

  const render::Sheet& sheet() const { return painter.composer().sheet(); }
  /// All texts of header and panels.
  std::vector<std::string> words() const {
    std::vector<std::string> result;
    for (const render::Mark& mark : sheet().marks())
      if (mark.kind == render::MarkKind::Text) result.emplace_back(sheet().words(mark));
    return result;
  }
  /// The text that follows another one.
  std::string after(const std::string& text) const {
    const std::vector<std::string> all = words();
    const auto found = std::find(all.begin(), all.end(), text);
    return found == all.end() || found + 1 == all.end() ? "" : *(found + 1);
  }

 private:
  TemporaryFolder folder_;

 public:
  Demo demo;
  std::optional<History> history;
  Painter painter;
};

TEST(InspectorWords, ListAppliedForcesFieldAndDragSoThatRestSumsToNothing) {
  const Shown pushed(
      "demo{ title = 'Pushed' }\nground{ y = 0 }\n"
      "local b = box{ at = {0, 0.5}, size = {1, 1}, mass = 1 }\n"
      "on_step(function() b:force(3, 0) end)\nhighlight{ body = b }\n",
      {"inspector"}, 0.5);
  EXPECT_EQ(pushed.after("applied"), "3 N");
  EXPECT_EQ(pushed.after("sum"), "0 N");
  const Shown falls(
      "demo{ title = 'Falls', view = { x = 0, y = 0, height = 10 } }\n"
      "local b = disc{ at = {0, 0}, radius = 0.5, mass = 1 }\ndrag(b, { linear = 1 })\n"
      "field(function() return 0, 2 end)\nhighlight{ body = b }\n",
      {"inspector"}, 60);
  EXPECT_EQ(falls.after("field"), "2 N");
  EXPECT_EQ(falls.after("drag"), "7.81 N");
  EXPECT_EQ(falls.after("sum"), "0 N");
}

TEST(InspectorWords, EachKindOfForceHasAColourOfItsOwn) {
  const Shown shown(
      "demo{ title = 'All', view = { x = 0, y = 0, height = 10 } }\n"
      "local b = disc{ at = {0, 0}, radius = 0.5, mass = 1 }\ndrag(b, { linear = 1 })\n"
      "field(function() return 2, 0 end)\non_step(function() b:force(3, 0) end)\nhighlight{ body = b }\n",
      {"inspector"}, 1);
  // Heads of arrows are filled; words of the list have the colour of text.
  std::set<std::tuple<float, float, float>> colors;
  const render::Style& style = render::style(render::Theme::Light);
  for (const render::Mark& mark : shown.sheet().marks())
    if (mark.kind == render::MarkKind::Stroke && !(mark.color == style.panel_border))
      colors.insert({mark.color.r, mark.color.g, mark.color.b});
  for (const render::Color& color :
       {style.velocity, style.friction, style.impulse, render::body_paint(style, 1).outline})
    EXPECT_TRUE(colors.contains({color.r, color.g, color.b}));
}

TEST(InspectorWords, ABodyThatIsCalledWeightIsNotTheWeight) {
  const Shown shown(
      "demo{ title = 'Weights' }\nground{ y = 0 }\n"
      "local b = box{ at = {0, 0.5}, size = {1, 1}, mass = 1 }\n"
      "box{ at = {0, 1.5}, size = {1, 1}, mass = 2, name = 'weight' }\nhighlight{ body = b }\n",
      {"inspector"}, 0.5);
  EXPECT_EQ(shown.after("own weight"), "9.81 N");
  EXPECT_EQ(shown.after("weight"), "19.6 N");
  EXPECT_EQ(shown.after("ground"), "29.4 N");
}

TEST(InspectorWords, TorquesHaveTheirUnit) {
  const Shown shown(
      "demo{ title = 'Rack', gravity = {0, 0} }\n"
      "local p = disc{ at = {0, 0}, radius = 0.3, mass = 2 }\n"
      "local bar = box{ at = {0.4, 0}, size = {0.2, 1}, mass = 3, name = 'bar' }\n"
      "hinge{ a = p, at = {0, 0} }\nslider{ a = bar, axis = {0, 1} }\n"
      "rack{ a = p, b = bar, axis = {0, 1}, radius = 0.3 }\n"
      "on_step(function() p:torque(1) end)\nhighlight{ body = p }\n",
      {"inspector"}, 0.2);
  EXPECT_EQ(shown.after("bar (joint)"), "750 mN m");
  EXPECT_EQ(shown.after("applied"), "1 N m");
  EXPECT_EQ(shown.after("sum"), "0 N");
}

TEST(InspectorWords, HaveNoRoundingNoiseAndAreNotCut) {
  const std::string slides =
      "demo{ title = 'Slides' }\nground{ y = 0 }\n"
      "local b = box{ at = {0, 0.5}, size = {1, 1}, mass = 1, velocity = {1, 0} }\nhighlight{ body = b }\n";
  for (const auto& [width, height] : {std::pair(1280, 720), std::pair(640, 360)}) {
    const Shown moving(slides, {"inspector"}, 0.1, width, height);
    EXPECT_THAT(moving.words(), Contains(HasSubstr(", 0) m/s, 0 rad/s")));
    EXPECT_THAT(moving.words(), Contains(HasSubstr("angle 0 rad")));
    const Shown still(slides, {"inspector"}, 3, width, height);
    ASSERT_TRUE(still.demo.world().bodies().asleep[1]);
    EXPECT_THAT(still.words(), Contains("island 1, asleep: at rest to the bit, not stepped"));
    for (const std::string& text : still.words()) EXPECT_THAT(text, Not(testing::EndsWith(".."))) << width;
  }
}

TEST(IslandsAlone, AreThereWhileTheySleep) {
  const std::vector<std::string> names{"islands"};
  Shown shown("demo{ title = 'One' }\nground{ y = 0 }\nbox{ at = {0, 0.5}, size = {1, 1}, mass = 1 }\n",
              names, 1);
  ASSERT_TRUE(shown.demo.world().bodies().asleep[1]);
  Composer composer(render::style(render::Theme::Light), 1280, 720);
  composer.show(names, 1280, 720);
  Selection selection;
  render::DrawList list;
  composer.scene(shown.demo, *shown.history, composer.camera(shown.demo), selection, list);
  const auto& labels = list[render::Layer::Labels].labels;
  EXPECT_TRUE(std::any_of(labels.begin(), labels.end(),
                          [](const render::Label& label) { return label.text == "1 island"; }));
}

TEST(SkipsWords, BarsStayInTheirFramesWhereAStepHasManyPieces) {
  // A row of balls that collide several times within a step, beside a stack that stands.
  const Shown shown(
      "demo{ title = 'Busy', dt = 1 / 30, restitution = 1 }\nground{ y = 0 }\n"
      "for i = 0, 5 do box{ at = {0, 0.5 + i}, size = {1, 1}, mass = 1 } end\n"
      "for i = 0, 5 do box{ at = {1 + i, 0.5}, size = {1, 1}, mass = 1 } end\n"
      "box{ at = {9, 0.5}, size = {1, 1}, velocity = {-20, 0}, mass = 1 }\n",
      {"skips"}, 0.1);
  const StepReport& report = shown.demo.world().report();
  ASSERT_GT(report.manifolds_reused, report.pairs);
  const render::Color accent = render::style(render::Theme::Light).accent;
  int bars = 0;
  for (const render::Mark& mark : shown.sheet().marks()) {
    if (mark.kind != render::MarkKind::Rect || !(mark.color == accent)) continue;
    const render::Pixel* p = shown.sheet().points(mark);
    EXPECT_LE(std::abs(p[1].x - p[0].x), 60.01f);
    ++bars;
  }
  EXPECT_GT(bars, 1);
  EXPECT_EQ(shown.after("manifolds kept"),
            std::to_string(report.manifolds_reused) + " / " +
                std::to_string(static_cast<std::uint64_t>(report.manifolds_reused) + report.narrow.pairs));
}

TEST(MatrixWords, NamesOfRowsThatAreCutStillDiffer) {
  const Shown shown(
      "demo{ title = 'Names' }\nground{ y = 0 }\n"
      "disc{ at = {0, 0.5}, radius = 0.5, mass = 1, name = 'an awfully long name' }\n",
      {"matrix"}, 0.05);
  ASSERT_EQ(shown.history->system()->row_names.size(), 2u);
  std::set<std::string> names;
  for (const std::string& text : shown.words())
    if (text.starts_with("an awf") && text.find("..") != std::string::npos) names.insert(text);
  EXPECT_EQ(names.size(), 2u);
  for (const std::string& name : names) EXPECT_TRUE(name.ends_with(" n") || name.ends_with(" t")) << name;
}

TEST(BroadPhaseWords, TheReasonHasTheRoomThatItNeeds) {
  const Shown shown(
      "demo{ title = 'Many', gravity = {0, 0} }\nground{ y = -5 }\n"
      "for i = 1, 300 do disc{ at = { i, 0 }, radius = 0.1, mass = 1, velocity = {0, 1} } end\n",
      {"broadphase"}, 0.3);
  std::string all;
  for (const std::string& text : shown.words()) {
    EXPECT_THAT(text, Not(testing::EndsWith(".."))) << text;
    all += text + ' ';
  }
  EXPECT_THAT(all,
              testing::ContainsRegex("about [0-9]+ of 301 moved a step, 0.24 to 0.24 m, in 3e\\+02 m x "));
}

TEST(MomentumWords, AngularMomentumIsCountedInAUnitThatFillsTheChart) {
  const auto words = [](const char* radius) {
    return Shown(std::string("demo{ title = 'Far', gravity = {0, 0}, view = { x = 0, y = 0, height = 9 } }\n"
                             "disc{ at = {0, ") +
                     radius + "}, radius = 0.5, mass = 1, velocity = {2, 0} }\n",
                 {"momentum"}, 0.1)
        .words();
  };
  EXPECT_THAT(words("1"), Contains("[kg m/s]; angular, about the origin [kg m\xC2\xB2/s]"));
  EXPECT_THAT(words("1000"), Contains("[kg m/s]; angular, about the origin [1000 kg m\xC2\xB2/s]"));
  EXPECT_THAT(words("1000"), Contains("angular -2"));
  // On its line of flight it has none, but for rounding.
  EXPECT_THAT(words("0"), Contains("angular 0"));
}

TEST(ShownSystem, AnImpactMakesRoomForTheForcesOfALargerIsland) {
  // A ball bounces off the ground beside a stack that keeps the solver busy.
  const auto shown = [](int boxes) {
    return std::make_unique<Shown>(
        "demo{ title = 'Beside', restitution = 0 }\nground{ y = 0 }\n"
        "for i = 1, " +
            std::to_string(boxes) +
            " do box{ at = {0.01 * i, i - 0.5}, size = {1, 1}, mass = 1 } end\n"
            "disc{ at = {5, 1}, radius = 0.5, mass = 1, restitution = 0.8 }\n",
        std::vector<std::string>{"matrix"}, 0.35);
  };
  const auto alone = shown(0), beside = shown(5);
  EXPECT_TRUE(alone->history->system()->impact);
  EXPECT_FALSE(beside->history->system()->impact);
  EXPECT_GT(beside->history->system()->system.size(), 10);
}

TEST(Amounts, ArePlainNumbersWhereTheseAreShort) {
  EXPECT_EQ(round_amount(0.5, "m"), "0.5 m");
  EXPECT_EQ(round_amount(500, "N"), "500 N");
  EXPECT_EQ(round_amount(5e-6, "N"), "5 \xC2\xB5N");
  EXPECT_EQ(round_amount(1e5, "N"), "100 kN");
}

// What a label covers [px].
struct Box {
  double left, top, right, bottom;
};

TEST(ContactValues, StandOffTheEdgesAndPointsThatTheyBelongTo) {
  const std::vector<std::string> names{"contacts"};
  for (const char* body : {"low", "high"}) {
    Shown shown(std::string("demo{ title = 'Two', view = { x = 0, y = 1, height = 5 } }\nground{ y = 0 }\n"
                            "box{ at = {0, 0.5}, size = {1, 1}, mass = 10, name = 'low' }\n"
                            "box{ at = {0, 1.5}, size = {1, 1}, mass = 10, name = 'high' }\n"
                            "highlight{ body = '") +
                    body + "' }\n",
                names, 0.2);
    Composer composer(render::style(render::Theme::Light), 1280, 720);
    composer.show(names, 1280, 720);
    const render::Camera camera = composer.camera(shown.demo);
    Selection selection = resolve(shown.demo.picture().selection, shown.demo.world());
    render::DrawList list;
    composer.scene(shown.demo, *shown.history, camera, selection, list);
    int values = 0;
    for (const render::Label& label : list[render::Layer::Labels].labels) {
      if (!label.text.ends_with(" N")) continue;
      ++values;
      const render::Point at = camera.to_pixels(label.at);
      const double width = render::text_width(label.text, static_cast<double>(label.size_px));
      const auto gap = static_cast<double>(label.offset_px);
      using render::Anchor;
      const double left = label.anchor == Anchor::Right  ? at.x + gap
                          : label.anchor == Anchor::Left ? at.x - gap - width
                                                         : at.x - 0.5 * width;
      const double middle = label.anchor == Anchor::Below   ? at.y + gap + 7
                            : label.anchor == Anchor::Above ? at.y - gap - 7
                                                            : at.y;
      const Box box{left, middle - 6, left + width, middle + 6};
      for (const double y : {0.0, 1.0, 2.0}) {
        const double edge = camera.to_pixels({0, y}).y;
        EXPECT_FALSE(box.top < edge && edge < box.bottom) << label.text << " on the edge at " << y;
      }
      for (const double x : {-0.5, 0.5}) {
        const render::Point upper = camera.to_pixels({x, 2}), lower = camera.to_pixels({x, 0});
        EXPECT_FALSE(box.left < upper.x && upper.x < box.right && box.top < lower.y) << label.text;
      }
    }
    EXPECT_EQ(values, std::string(body) == "low" ? 4 : 2);
  }
}

}  // namespace overlay_words_test
}  // namespace skerry::sandbox
