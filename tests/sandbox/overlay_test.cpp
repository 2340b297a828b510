// SPDX-License-Identifier: MIT
//
// Overlays: what their rows promise, what they draw, that nothing leaves its panel, that frames repeat.
#include <algorithm>
#include <cstdio>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "physics/snapshot.h"
#include "render/gl_renderer.h"
#include "sandbox/errors.h"
#include "sandbox/loop.h"
#include "sandbox/overlays/plot.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/painter.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace overlay_test {

using testing::HasSubstr;

// Stacked boxes, a disc on them, a hinge, an impact, a bridge with a train, notes, checks: something for
// every overlay.
constexpr const char* kScene = R"(
demo{ title = "Everything", lesson = "A bit of all.", seconds = 1, view = { x = 0, y = 2, height = 6 } }
ground{ y = 0 }
local low = box{ at = {0, 0.5}, size = {2, 1}, mass = 2, name = "low" }
local high = box{ at = {0.1, 1.5}, size = {1, 1}, mass = 1 }
disc{ at = {0.1, 2.5}, radius = 0.3, mass = 1, velocity = {0, -1} }
local bob = disc{ at = {3, 2}, radius = 0.2, mass = 1 }
hinge{ a = bob, at = {2, 2} }
bridge{
  nodes = { {-3.5, 1}, {-1.9, 1}, {-2.7, 2} }, members = { {1, 2}, {2, 3}, {1, 3} }, deck = { 1, 2 },
  section = { area = 0.008, second_moment = 4e-5, modulus = 2.1e11, strength = 2.35e8, density = 7850 },
  supports = { { 1, "pinned" }, { 2, "roller" } },
  train = { axles = { 1e5 }, speed = 2, start = -1 }, influence = 1, thickness = 0.1,
}
note("begins")
at(0.3, function() note("goes on") end)
expect("low stays", function() return low.y end, { equals = 0.5, within = 0.1, unit = "m" })
highlight{ row = 1, col = 2, body = low }
)";

struct Shot {
  render::Image image;
  std::string svg;
  std::vector<std::string> left_out;
};

Shot shoot(const std::string& path, const std::vector<std::string>& names, PaintOptions paint = {},
           DemoOptions options = {}) {
  Demo demo(path, options);
  const Observe needs = needs_of(names);
  demo.observe(needs);
  History history(demo, needs.systems, kFlashSeconds);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo&) { history.update(demo); };
  run_loop(demo, {}, callbacks);
  Painter painter(paint);
  painter.start(demo, names);
  painter.select(resolve(demo.picture().selection, demo.world()));
  Shot shot;
  painter.paint(demo, history, shot.image);
  EXPECT_FALSE(painter.paint(demo, history, shot.image)) << "an unchanged frame is not drawn again";
  shot.svg = painter.svg(demo.title());
  shot.left_out = painter.composer().left_out();
  return shot;
}

class OverlayRow : public testing::TestWithParam<std::string> {
 protected:
  TemporaryFolder folder_;
  std::string scene_ = folder_.write("scene.lua", kScene);
  std::string name_ = GetParam();
  const Overlay& row_ = *std::find_if(overlays().begin(), overlays().end(),
                                      [&](const Overlay& overlay) { return overlay.name == name_; });
};

TEST_P(OverlayRow, ChangesThePictureInBothThemesAndTheFigure) {
  for (const render::Theme theme : {render::Theme::Light, render::Theme::Dark}) {
    const PaintOptions paint{.width = 960, .height = 540, .theme = theme};
    const DemoOptions half{.seconds = 0.5};
    const Shot bare = shoot(scene_, {}, paint, half);
    const Shot with = shoot(scene_, {name_}, paint, half);
    EXPECT_TRUE(with.left_out.empty());
    EXPECT_FALSE(with.image == bare.image);
    EXPECT_NE(with.svg, bare.svg);
  }
}

// Profile shows wall time, which nobody can repeat.
TEST_P(OverlayRow, DrawsTheSameFrameForAnyNumberOfThreads) {
  if (name_ == "profile") GTEST_SKIP() << "shows wall time";
  const PaintOptions paint{.width = 640, .height = 360};
  const Shot first = shoot(scene_, {name_}, paint, {.seconds = 0.4, .threads = 1});
  for (const int threads : {1, 2, 4}) {
    const Shot again = shoot(scene_, {name_}, paint, {.seconds = 0.4, .threads = threads});
    EXPECT_EQ(render::digest(again.image), render::digest(first.image)) << threads;
    EXPECT_EQ(again.svg, first.svg) << threads;
  }
}

TEST_P(OverlayRow, TurnsOnOnlyWhatItNeeds) {
  const Observe none = needs_of({});
  EXPECT_FALSE(none.contacts || none.systems || none.solve_traces || none.stage_times);
  const Observe needs = needs_of({name_});
  EXPECT_EQ(needs.contacts, row_.needs.contacts);
  EXPECT_EQ(needs.systems, row_.needs.systems);
  EXPECT_EQ(needs.stage_times, row_.needs.stage_times);
}

INSTANTIATE_TEST_SUITE_P(All, OverlayRow, testing::ValuesIn(overlay_names()),
                         [](const auto& row) { return row.param; });

TEST(OverlayRegistry, NamesAndHotkeysAreUnique) {
  std::set<std::string_view> names;
  std::set<char> keys;
  for (const Overlay& overlay : overlays()) {
    EXPECT_TRUE(names.insert(overlay.name).second) << overlay.name;
    EXPECT_TRUE(overlay.key >= 'a' && overlay.key <= 'z') << overlay.name;
    EXPECT_TRUE(keys.insert(overlay.key).second) << overlay.name << ' ' << overlay.key;
    EXPECT_TRUE(overlay.draw || overlay.panel) << overlay.name;
  }
}

// --- Panels keep to themselves
// ----------------------------------------------------------------------------------------------

struct Rect {
  float left, top, right, bottom;
};

// What a mark covers; the width of its text by the label font, which has the metrics of the panels' fonts.
Rect extent(const render::Sheet& sheet, const render::Mark& mark) {
  const render::Pixel* p = sheet.points(mark);
  Rect r{p[0].x, p[0].y, p[0].x, p[0].y};
  for (std::uint32_t i = 1; i < mark.count; ++i) {
    r = {std::min(r.left, p[i].x), std::min(r.top, p[i].y), std::max(r.right, p[i].x),
         std::max(r.bottom, p[i].y)};
  }
  if (mark.kind != render::MarkKind::Text) return r;
  const double em = static_cast<double>(mark.width) * render::kSheetEm;
  const auto width = static_cast<float>(render::text_width(sheet.words(mark), em));
  const float shift = mark.align == render::Align::Left ? 0 : mark.align == render::Align::Right ? 1 : 0.5f;
  r.left -= shift * width;
  r.right = r.left + width;
  r.bottom += mark.width;
  return r;
}

TEST(Panels, TextAndCurvesStayInsideTheirPanelAndPanelsApart) {
  const TemporaryFolder folder;
  const std::string path = folder.write("scene.lua", kScene);
  std::vector<std::vector<std::string>> groups;
  for (const Overlay& overlay : overlays())
    if (overlay.panel_px > 0) groups.push_back({std::string(overlay.name)});
  groups.push_back({"inspector", "energy", "momentum", "matrix"});
  groups.push_back({"broadphase", "sat", "skips", "solver"});
  groups.push_back({"factor", "checks"});
  for (const std::vector<std::string>& names : groups) {
    Demo demo(path, {.seconds = 0.5});
    const Observe needs = needs_of(names);
    demo.observe(needs);
    History history(demo, needs.systems, kFlashSeconds);
    LoopCallbacks callbacks;
    callbacks.step = [&](Demo&) { history.update(demo); };
    run_loop(demo, {}, callbacks);
    Painter painter({});
    painter.start(demo, names);
    painter.select(resolve(demo.picture().selection, demo.world()));
    render::Image image;
    painter.paint(demo, history, image);
    EXPECT_TRUE(painter.composer().left_out().empty()) << testing::PrintToString(names);

    const render::Sheet& sheet = painter.composer().sheet();
    const render::Color panel_color = render::style(render::Theme::Light).panel;
    std::vector<Rect> panels;
    for (const render::Mark& mark : sheet.marks()) {
      const Rect r = extent(sheet, mark);
      const bool opens = mark.kind == render::MarkKind::Rect && mark.color == panel_color &&
                         mark.rounding > 0 && mark.width == 0;
      if (opens) {
        for (const Rect& other : panels)
          EXPECT_TRUE(r.left >= other.right || other.left >= r.right || r.top >= other.bottom ||
                      other.top >= r.bottom)
              << testing::PrintToString(names);
        EXPECT_GE(r.top, kHeaderPx);
        EXPECT_LE(r.bottom, 720 - kFooterPx);
        EXPECT_LE(r.right, 1280);
        panels.push_back(r);
      }
      if (panels.empty()) continue;
      const Rect& panel = panels.back();
      const bool inside = r.left >= panel.left - 1 && r.right <= panel.right + 1 && r.top >= panel.top - 1 &&
                          r.bottom <= panel.bottom + 2;
      EXPECT_TRUE(inside) << testing::PrintToString(names) << " \"" << sheet.words(mark) << "\" "
                          << r.left - panel.left << ' ' << r.top - panel.top << ' ' << r.right - panel.right
                          << ' ' << r.bottom - panel.bottom;
    }
    EXPECT_EQ(panels.size(), names.size() + 1) << "and the note";
  }
}

TEST(Panels, ThoseWithoutRoomAreNamed) {
  std::vector<std::string> all;
  for (const Overlay& overlay : overlays()) all.emplace_back(overlay.name);
  Composer composer(render::style(render::Theme::Light), 1280, 720);
  composer.show(all, 1280, 720);
  EXPECT_FALSE(composer.left_out().empty());
  const TemporaryFolder folder;
  const Outcome outcome = run({"capture", folder.write("scene.lua", kScene), "-o", folder / "x.png", "--at",
                               "0.1", "--overlay", "matrix,solver,factor,compare"});
  EXPECT_EQ(outcome.code, kGood) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("no room for solver, compare"));
}

TEST(PanelLayout, KeepsPanelsApartForAnyHeights) {
  std::mt19937 random(20240613);
  std::uniform_real_distribution<double> height(20, 300);
  for (int trial = 0; trial < 50; ++trial) {
    PanelLayout layout(1920, 1080);
    std::vector<int> places;
    std::vector<double> most;
    for (int i = 0; i < 8; ++i) {
      const double h = height(random);
      const int place = layout.reserve(h);
      if (place < 0) continue;
      places.push_back(place);
      most.push_back(h);
    }
    ASSERT_GE(places.size(), 2u);
    // Frame by frame panels may be lower than they said, never higher.
    for (int frame = 0; frame < 3; ++frame) {
      layout.begin_frame();
      std::vector<Rect> rects;
      for (std::size_t i = 0; i < places.size(); ++i) {
        const double h = frame == 0 ? most[i] : most[i] * (0.4 + 0.2 * frame);
        const PanelLayout::Position p = layout.place(places[i], h);
        const Rect r{static_cast<float>(p.x), static_cast<float>(p.y),
                     static_cast<float>(p.x + kColumnPx * layout.scale()),
                     static_cast<float>(p.y + h * layout.scale())};
        for (const Rect& other : rects)
          EXPECT_TRUE(r.left >= other.right || other.left >= r.right || r.top >= other.bottom ||
                      other.top >= r.bottom);
        EXPECT_LE(r.bottom, 1080 - kFooterPx * layout.scale());
        EXPECT_GE(r.left, layout.scene_right());
        rects.push_back(r);
      }
    }
  }
}

TEST(PanelLayout, APanelHigherThanThePictureIsLeftOut) {
  PanelLayout low(320, 181);
  EXPECT_EQ(low.reserve(382), -1);
  EXPECT_EQ(low.reserve(150), 0);
  EXPECT_EQ(low.columns(), 1);
}

TEST(Legend, EntriesDoNotRunIntoEachOtherOrTheLengthBar) {
  render::Camera camera;
  render::DrawLayer layer;
  const render::Style& style = render::style(render::Theme::Light);
  Legend legend(camera, style, layer, 862);
  legend.length_bar(1, 1280);
  for (int i = 0; i < 12; ++i) legend.arrow(style.impulse, 60, "entry number " + std::to_string(i));
  std::vector<Rect> rects;
  for (const render::Label& label : layer.labels) {
    const render::Point at = camera.to_pixels(label.at);
    const double width = render::text_width(label.text, static_cast<double>(label.size_px));
    const bool left = label.anchor == render::Anchor::Left;
    const auto x0 = static_cast<float>(left ? at.x - static_cast<double>(label.offset_px) - width : at.x);
    const Rect r{x0, static_cast<float>(at.y) - 6, x0 + static_cast<float>(width),
                 static_cast<float>(at.y) + 6};
    for (const Rect& other : rects)
      EXPECT_TRUE(r.left >= other.right || other.left >= r.right || r.top >= other.bottom ||
                  other.top >= r.bottom)
          << label.text;
    rects.push_back(r);
  }
  EXPECT_EQ(rects.size(), 13u);
}

// --- Selection
// --------------------------------------------------------------------------------------------------------------

TEST(SelectionText, ReadsWhatPeopleWriteAndExplainsWhatItRefuses) {
  const SelectionText cell = parse_selection("row=3,col=5");
  EXPECT_EQ(cell.row, 3);
  EXPECT_EQ(cell.column, 5);
  const SelectionText pair = parse_selection("body=left,other=B,island=2");
  EXPECT_EQ(pair.body.label, "left");
  EXPECT_EQ(pair.other.label, "B");
  EXPECT_EQ(pair.island, 2);
  EXPECT_EQ(parse_selection(""), SelectionText{});
  for (const char* bad : {"row", "row=0", "row=x", "col=2", "other=A", "cell=1", "row=1,,col=2", "island=-1"})
    EXPECT_THROW(parse_selection(bad), UsageError) << bad;
}

TEST(SelectionText, BodiesAreFoundByTheirLabels) {
  const TemporaryFolder folder;
  const std::string path = folder.write("scene.lua", kScene);
  const Demo demo(path, {});
  const World& world = demo.world();
  for (std::size_t i = 0; i < world.bodies().size(); ++i) {
    const BodyId body = world.body_id(i);
    if (i > 0 && world.bodies().type[i] == BodyType::Static) continue;  // "ground" is the first of them
    EXPECT_EQ(resolve({.body = {.label = body_label(world, body), .id = {}}}, world).body, body) << i;
  }
  EXPECT_EQ(world.name(demo.picture().selection.body.id), "low");
  const Outcome outcome =
      run({"capture", path, "-o", folder / "x.png", "--at", "0.1", "--select", "body=lov"});
  EXPECT_EQ(outcome.code, kUsage);
  EXPECT_THAT(outcome.err, HasSubstr("did you mean \"low\""));
}

TEST(SelectionText, LettersStayWithTheirBodiesWhileOthersAreHeldOrGo) {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::Static});
  std::vector<BodyId> bodies;
  for (int i = 0; i < 4; ++i) bodies.push_back(world.create_body({}));
  const auto labels = [&] {
    std::string all;
    for (const BodyId body : bodies) all += body_label(world, body) + ' ';
    return all;
  };
  EXPECT_EQ(labels(), "A B C D ");
  world.set_type(bodies[1], BodyType::Static);
  EXPECT_EQ(labels(), "A B C D ");
  world.destroy(bodies[0]);
  EXPECT_EQ(labels(), "ground B C D ");
  bodies[0] = world.create_body({});
  EXPECT_EQ(labels(), "A B C D ") << "the slot is used anew";
  EXPECT_EQ(body_label(world, ground), "ground");
  world.set_type(ground, BodyType::Dynamic);
  bodies.push_back(ground);
  EXPECT_EQ(labels(), "A B C D E ");
  const World copy = load_snapshot(save_snapshot(world));
  EXPECT_EQ(body_label(copy, ground), "E");
}

TEST(SelectionText, HighlightInAScriptNamesItsMistakes) {
  const TemporaryFolder folder;
  for (const auto& [line, message] :
       {std::pair("highlight{ col = 2 }", "col needs row"), std::pair("highlight{ row = 0 }", "row"),
        std::pair("highlight{ row = 1.5 }", "whole number"), std::pair("highlight{ bodi = 'A' }", "body")}) {
    const std::string path = folder.write("h.lua", "demo{ title = 'T' }\n" + std::string(line));
    const Outcome outcome = run({"run", path});
    EXPECT_EQ(outcome.code, kScriptOrFile) << line;
    EXPECT_THAT(outcome.err, HasSubstr("h.lua:2"));
    EXPECT_THAT(outcome.err, HasSubstr(message));
  }
}

TEST(MatrixSelection, LightsUpBothContactsAndJoinsThemThroughTheSharedBody) {
  const TemporaryFolder folder;
  const std::string path = folder.write("scene.lua", kScene);
  const std::vector<std::string> names{"matrix"};
  Demo demo(path, {.seconds = 0.5});
  demo.observe(needs_of(names));
  History history(demo, true, kFlashSeconds);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo&) { history.update(demo); };
  run_loop(demo, {}, callbacks);
  const SystemRecord* record = history.system();
  ASSERT_NE(record, nullptr);
  ASSERT_EQ(record->anchors.size(), record->system.rows.size());
  // Every normal row stands where a contact of the report is.
  const auto& contacts = demo.world().report().contacts_list;
  for (std::size_t i = 0; i < record->anchors.size(); ++i) {
    if (record->system.rows[i].kind != RowKind::Normal) continue;
    double nearest = 1e9;
    for (const ContactReport& contact : contacts)
      for (int k = 0; k < contact.count; ++k)
        nearest = std::min(nearest, length(contact.points[static_cast<std::size_t>(k)].position -
                                           anchor_point(demo, record->anchors[i])));
    EXPECT_LT(nearest, 1e-9) << i;
  }
  Composer composer(render::style(render::Theme::Light), 1280, 720);
  composer.show(names, 1280, 720);
  const render::Camera camera = composer.camera(demo);
  const auto draw = [&](Selection selection) {
    render::DrawList list;
    composer.scene(demo, history, camera, selection, list);
    return list[render::Layer::Labels];
  };
  const render::DrawLayer bare = draw({});
  Selection cell;
  cell.row = 0;
  cell.column = 2;
  const render::DrawLayer lit = draw(cell);
  EXPECT_EQ(lit.markers.size(), bare.markers.size() + 2);
  EXPECT_EQ(lit.lines.size(), bare.lines.size() + 2) << "contact - body - contact";
  cell.column = -1;
  EXPECT_EQ(draw(cell).markers.size(), bare.markers.size() + 1);
  cell.row = 100000;
  EXPECT_EQ(draw(cell), bare);
}

TEST(MatrixSelection, AContactThatIsPointedAtSelectsItsRow) {
  const TemporaryFolder folder;
  Demo demo(folder.write("scene.lua", kScene), {.seconds = 0.5});
  demo.observe(needs_of({"matrix"}));
  History history(demo, true, kFlashSeconds);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo&) { history.update(demo); };
  run_loop(demo, {}, callbacks);
  const SystemRecord* record = history.system();
  ASSERT_NE(record, nullptr);
  int normals = 0;
  for (std::size_t i = 0; i < record->anchors.size(); ++i) {
    if (record->system.rows[i].kind != RowKind::Normal) continue;
    ++normals;
    const Vec2 at = anchor_point(demo, record->anchors[i]);
    Selection selection;
    ASSERT_TRUE(select_contact_at(demo, history, at + Vec2{1e-4, 0}, 0.01, selection));
    EXPECT_LT(length(anchor_point(demo, record->anchors[static_cast<std::size_t>(selection.row)]) - at),
              1e-9);
    EXPECT_EQ(selection.column, -1);
  }
  EXPECT_GT(normals, 1);
  Selection none;
  EXPECT_FALSE(select_contact_at(demo, history, {50, 50}, 0.01, none));
  EXPECT_EQ(none, Selection{});
}

TEST(Islands, CarryTheNumberThatInspectorAndMatrixUse) {
  const TemporaryFolder folder;
  const std::string path =
      folder.write("two.lua",
                   "demo{ title = 'Two', view = { x = 0, y = 1, height = 5 } }\n"
                   "ground{ y = 0 }\nbox{ at = {-2, 0.5}, size = {1, 1} }\n"
                   "box{ at = {2, 0.5}, size = {1, 1} }\nbox{ at = {2, 1.5}, size = {1, 1} }\n");
  const std::vector<std::string> names{"islands", "matrix"};
  Demo demo(path, {.seconds = 0.1});
  demo.observe(needs_of(names));
  History history(demo, true, kFlashSeconds);
  history.follow_body(demo.world().body_id(3));
  Painter painter({.width = 1280, .height = 720});
  painter.start(demo, names);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo&) { history.update(demo); };
  run_loop(demo, {}, callbacks);
  Selection selection;
  render::DrawList list;
  Composer composer(render::style(render::Theme::Light), 1280, 720);
  composer.show(names, 1280, 720);
  composer.scene(demo, history, composer.camera(demo), selection, list);
  const std::vector<int>& island = demo.world().bodies().island;
  ASSERT_NE(island[1], island[3]);
  EXPECT_EQ(island[2], island[3]);
  for (const std::size_t body : {1u, 3u}) {
    const std::string number = std::to_string(island[body] + 1);
    const double x = demo.world().bodies().position[body].x;
    const auto& labels = list[render::Layer::Labels].labels;
    EXPECT_TRUE(std::any_of(labels.begin(), labels.end(), [&](const render::Label& label) {
      return label.text == number && std::abs(label.at.x - x) < 0.01;
    })) << body;
  }
  render::Image image;
  painter.paint(demo, history, image);
  EXPECT_THAT(painter.svg("two"), HasSubstr(", island " + std::to_string(island[3] + 1)));
}

TEST(Inspector, ShowsTheMomentBetweenStepsInSlowMotion) {
  const TemporaryFolder folder;
  const std::string path =
      folder.write("fall.lua",
                   "demo{ title = 'Fall', seconds = 0.4, dt = 0.1, view = { x = 0, y = 1, height = 5 } }\n"
                   "disc{ at = {0, 2}, radius = 0.5, mass = 1, name = 'ball' }\n");
  const std::vector<std::string> names{"inspector"};
  Demo demo(path, {});
  demo.observe(needs_of(names));
  History history(demo, false, kFlashSeconds);
  Painter painter({.width = 1280, .height = 720, .speed = 0.1});
  painter.start(demo, names);
  painter.select(resolve({.body = {.label = "ball", .id = {}}}, demo.world()));
  render::Image image;
  int frames = 0;
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo&) { history.update(demo); };
  callbacks.frame = [&](const Demo& running) {
    if (++frames % 20 != 7) return;
    painter.paint(demo, history, image);
    const double t = running.shown_time();
    char words[80];
    std::snprintf(words, sizeof words, "at (%.4g, %.4g) m", 0.0, 2 - 0.5 * 9.81 * t * t);
    EXPECT_THAT(painter.svg("fall"), HasSubstr(words)) << t;
    std::snprintf(words, sizeof words, "velocity (%.3g, %.3g) m/s", 0.0, -9.81 * t);
    EXPECT_THAT(painter.svg("fall"), HasSubstr(words)) << t;
  };
  run_loop(demo, {60, 0.1}, callbacks);
  EXPECT_GT(frames, 200);
}

// --- Plots and history
// ------------------------------------------------------------------------------------------------------

TEST(Plot, TicksAreRoundAndInside) {
  EXPECT_EQ(ticks(0, 1, 5), (std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1}));
  EXPECT_TRUE(ticks(1, 1, 4).empty());
  EXPECT_TRUE(ticks(0, HUGE_VAL, 4).empty());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> exponent(-9, 9), shift(-3, 3);
  for (int i = 0; i < 1000; ++i) {
    const double span = std::pow(10, exponent(random)), low = shift(random) * span;
    const std::vector<double> marks = ticks(low, low + span, 4);
    ASSERT_GE(marks.size(), 1u);
    ASSERT_LE(marks.size(), 5u);
    EXPECT_GE(marks.front(), low - 1e-9 * span);
    EXPECT_LE(marks.back(), low + span * (1 + 1e-9));
  }
}

TEST(Plot, ThinningKeepsEndsAndPeaks) {
  std::vector<double> values(10000, 0.0);
  values[1234] = 5;
  values[7777] = -3;
  const std::vector<std::size_t> kept = thinned(values, 100);
  EXPECT_LE(kept.size(), 100u);
  EXPECT_EQ(kept.front(), 0u);
  EXPECT_EQ(kept.back(), 9999u);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  for (const std::size_t peak : {1234u, 7777u}) EXPECT_EQ(std::count(kept.begin(), kept.end(), peak), 1);
  EXPECT_EQ(thinned({1, 2, 3}, 100).size(), 3u);
}

TEST(Plot, LegendNamesAllCurvesOrSaysHowManyMore) {
  const auto words_of = [](int curves, double height) {
    Chart chart;
    chart.x_name = "t [s]";
    for (int i = 0; i < curves; ++i)
      chart.curves.push_back({"height of ball " + std::to_string(i), {}, {0, 1}, {0, 1.0 * i}});
    render::Sheet sheet;
    draw_chart(chart, render::style(render::Theme::Light), {0, 0}, 600, height, 1, sheet);
    std::vector<std::string> words;
    std::vector<std::pair<float, float>> places;
    for (const render::Mark& mark : sheet.marks()) {
      if (mark.kind != render::MarkKind::Text) continue;
      const std::string text(sheet.words(mark));
      if (text.rfind("height", 0) != 0 && text.rfind("+ ", 0) != 0) continue;
      words.push_back(text);
      const render::Pixel at = sheet.points(mark)[0];
      EXPECT_GE(at.x, 0);
      EXPECT_LE(at.x, 600);
      EXPECT_LE(at.y, height);
      places.emplace_back(at.x, at.y);
    }
    std::sort(places.begin(), places.end());
    EXPECT_EQ(std::adjacent_find(places.begin(), places.end()), places.end());
    return words;
  };
  for (const int curves : {1, 4, 6, 14}) {
    const std::vector<std::string> words = words_of(curves, 320);
    ASSERT_EQ(words.size(), static_cast<std::size_t>(curves));
    EXPECT_EQ(words.back().rfind("height of ball " + std::to_string(curves - 1), 0), 0u);
  }
  // What would leave the curves no room is counted.
  const std::vector<std::string> words = words_of(60, 190);
  ASSERT_GT(words.size(), 4u);
  ASSERT_LT(words.size(), 60u);
  EXPECT_EQ(words.back(), "+ " + std::to_string(60 - (words.size() - 1)) + " more");
}

TEST(History, StaysSmallHoweverLongTheRun) {
  const TemporaryFolder folder;
  Demo demo(folder.write("d.lua", "demo{ title = 'T', seconds = 60 }\ndisc{ at = {0, 0}, radius = 1 }"),
            {.dt = 0.001, .seconds = 20.0});
  History history(demo, false, kFlashSeconds);
  while (demo.steps_done() < demo.total_steps()) {
    demo.step();
    history.update(demo);
    ASSERT_LE(history.ledger().size(), 4098u);
    ASSERT_EQ(history.ledger().back().time, demo.time());
  }
  const auto& samples = history.ledger();
  EXPECT_GE(samples.size(), 2048u);
  for (std::size_t i = 2; i + 1 < samples.size(); ++i)
    EXPECT_NEAR(samples[i].time - samples[i - 1].time, samples[1].time - samples[0].time, 1e-9);
}

}  // namespace overlay_test
}  // namespace skerry::sandbox
