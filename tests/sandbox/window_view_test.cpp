// SPDX-License-Identifier: MIT
//
// The window's frames with made-up events and no display.
#include "sandbox/window/window_view.h"

#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <imgui.h>
#include <map>
#include <set>
#include <sstream>

#include "render/egl_context.h"
#include "render/image.h"
#include "sandbox/overlays/overlay.h"
#include "sandbox/painter.h"
#include "sandbox/window/actions.h"
#include "sandbox/window/gui.h"
#include "sandbox/window/recording.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace window_view_test {

constexpr const char* kBoxes =
    "demo{ title = 'Boxes', seconds = 2, view = { x = 0, y = 2, height = 6 } }\n"
    "local mu = param('mu', 0.5, 0, 1)\nground{ y = 0, friction = mu }\n"
    "box{ at = {-2, 0.5}, size = {1, 1}, name = 'left' }\nbox{ at = {2, 0.5}, size = {1, 1}, name = 'right' "
    "}\n"
    "at(0.5, function() note('half') end)\n";

/// A window that is not there.
class WindowViewTest : public testing::Test {
 protected:
  WindowViewTest() {
    previous_ = std::filesystem::current_path();
    path_ = folder_.write("boxes.lua", kBoxes);
    folder_.write("other.lua",
                  "demo{ title = 'Another one', seconds = 1 }\nground{ y = 0 }\n"
                  "disc{ at = {0, 2}, radius = 0.5 }\n");
    std::filesystem::current_path(folder_ / "");
    bench_ = std::make_unique<Workbench>(find_demos(folder_ / ""), DemoOptions{});
    view_ = std::make_unique<WindowView>(*bench_);
    input_.seconds = 1.0 / 60;
  }
  ~WindowViewTest() override { std::filesystem::current_path(previous_); }

  void frames(int count = 1) {
    for (int i = 0; i < count; ++i) {
      view_->frame(input_, 1280, 720);
      input_.keys.clear();
      input_.ui.text.clear();
      input_.ui.wheel = 0;
    }
  }
  void key(int code, bool shift = false) {
    render::KeyPress press;
    press.key = code;
    press.shift = shift;
    input_.keys = {press};
    frames();
  }
  void mouse(Vec2 at) {
    const render::Point px = bench_->camera.to_pixels({at.x, at.y});
    input_.ui.mouse_x = static_cast<float>(px.x);
    input_.ui.mouse_y = static_cast<float>(px.y);
    frames();
  }
  void button(int number, bool down) {
    input_.ui.mouse_down[number] = down;
    frames();
  }
  Player& player() { return bench_->player(); }

  TemporaryFolder folder_;
  std::filesystem::path previous_;
  std::string path_;
  render::EglContext context_;
  std::unique_ptr<Workbench> bench_;
  std::unique_ptr<WindowView> view_;
  render::WindowInput input_;
};

TEST_F(WindowViewTest, TimeIsControlledByKeys) {
  bench_->open(path_);
  frames(10);
  EXPECT_EQ(player().step(), 10u);
  key(' ');
  const std::uint64_t here = player().step();
  frames(5);
  EXPECT_EQ(player().step(), here);
  key(render::kKeyRight);
  EXPECT_EQ(player().step(), here + 1);
  key(render::kKeyLeft);
  key(render::kKeyLeft);
  EXPECT_EQ(player().step(), here - 1);
  key(render::kKeyRight, true);
  EXPECT_EQ(player().step(), here + 9);
  key(render::kKeyHome);
  EXPECT_EQ(player().step(), 0u);
  key(render::kKeyEnd);
  EXPECT_EQ(player().step(), player().end());
  key(render::kKeyUp);
  EXPECT_EQ(bench_->time().speed(), 2);
  EXPECT_EQ(player().divergence(), std::nullopt);
  frames(200);
  EXPECT_TRUE(view_->idle());
}

TEST_F(WindowViewTest, ABodyIsDraggedAndTheSessionReplays) {
  bench_->open(path_);
  frames(2);
  mouse({-2, 0.5});
  button(0, true);
  EXPECT_TRUE(player().hand().holds());
  EXPECT_EQ(bench_->selection.body.index, 1u);
  for (int i = 0; i < 60; ++i) mouse({-2 + i * 0.03, 0.5 + i * 0.04});
  frames(60);
  const World& world = player().demo().world();
  EXPECT_NEAR(world.bodies().position[1].x, -2 + 59 * 0.03, 0.02);
  EXPECT_NEAR(world.bodies().position[1].y, 0.5 + 59 * 0.04, 0.02);
  button(0, false);
  EXPECT_FALSE(player().hand().holds());
  frames(60);
  EXPECT_LT(world.bodies().position[1].y, 1.0) << "it fell down again";
  key(render::kKeyF1 + 7);
  const Recording recording = load_recording(read_bytes("boxes.skerry"));
  EXPECT_GE(recording.inputs.size(), 50u);
  EXPECT_EQ(replay(recording), std::nullopt);
  // Back to before the drag, by the timeline: the box stands where it stood.
  bench_->scrub(1);
  EXPECT_NEAR(player().demo().world().bodies().position[1].x, -2, 1e-9);
  EXPECT_EQ(player().divergence(), std::nullopt);
}

TEST_F(WindowViewTest, TheViewMovesAndZoomsAndComesBack) {
  bench_->open(path_);
  key(' ');
  const render::Camera before = bench_->camera;
  mouse({0, 3});
  input_.ui.wheel = 2;
  frames();
  EXPECT_LT(bench_->camera.height, before.height);
  const render::Point px{input_.ui.mouse_x, input_.ui.mouse_y};
  EXPECT_NEAR(bench_->camera.to_world(px).x, 0, 1e-3);
  button(0, true);
  input_.ui.mouse_x += 100;
  frames();
  EXPECT_NEAR(bench_->camera.to_world({px.x + 100, px.y}).x, 0, 1e-3);
  button(0, false);
  key('0');
  EXPECT_NEAR(bench_->camera.height, before.height, 1e-12);
  EXPECT_NEAR(bench_->camera.centre.x, before.centre.x, 1e-12);
}

TEST_F(WindowViewTest, RightClicksMakeBodiesAndDeleteRemovesThem) {
  bench_->open(path_);
  key(' ');
  key('2');
  const std::size_t bodies = player().demo().world().bodies().size();
  mouse({0, 3});
  button(1, true);
  button(1, false);
  const BodyArrays& all = player().demo().world().bodies();
  ASSERT_EQ(all.size(), bodies + 1);
  EXPECT_NEAR(all.position[bodies].y, 3, 0.02);
  button(0, true);
  button(0, false);
  EXPECT_EQ(bench_->selection.body.index, bodies);
  key(render::kKeyDelete);
  EXPECT_EQ(player().demo().world().bodies().alive[bodies], 0);
}

TEST_F(WindowViewTest, F7HoldsTheSelectedBodyAndLetsItGo) {
  bench_->open(path_);
  key(' ');
  mouse({0, 3});
  button(1, true);
  button(1, false);
  const auto made = static_cast<std::uint32_t>(player().demo().world().bodies().size() - 1);
  const auto height = [&] { return player().demo().world().bodies().position[made].y; };
  const auto click = [&] {
    button(0, true);
    button(0, false);
  };
  click();
  key(render::kKeyF1 + 6);
  key(render::kKeyEscape);
  const double held = height();
  key(render::kKeyRight);
  EXPECT_EQ(height(), held);
  click();
  EXPECT_EQ(bench_->selection.body.index, made);
  key(render::kKeyF1 + 6);
  key(render::kKeyRight);
  EXPECT_LT(height(), held);
  EXPECT_EQ(player().inputs().back().kind, InputKind::Hold);
  key(render::kKeyEscape);
  key(render::kKeyF1 + 6);
  EXPECT_EQ(player().demo().world().bodies().type[made], BodyType::Dynamic) << "nothing is selected";
}

TEST_F(WindowViewTest, DemosAreFoundByTyping) {
  frames(3);
  EXPECT_TRUE(bench_->panels.demos);
  input_.ui.text = "anot";
  frames(2);
  EXPECT_EQ(bench_->panels.search, "anot");
  input_.ui.keys_down = {ImGuiKey_Enter};
  key(render::kKeyEnter);
  input_.ui.keys_down.clear();
  frames(2);
  EXPECT_FALSE(bench_->panels.settings) << "Enter belongs to the search";
  ASSERT_TRUE(bench_->has_demo());
  EXPECT_EQ(player().demo().title(), "Another one");
  bench_->open(path_);
  EXPECT_EQ(player().demo().title(), "Boxes");
  key(render::kKeyTab);
  EXPECT_TRUE(bench_->panels.demos);
  key(render::kKeyEscape);
  EXPECT_FALSE(bench_->panels.demos);
}

TEST_F(WindowViewTest, ASavedScriptIsLoadedAgainAndABrokenOneIsTold) {
  bench_->open(path_);
  frames(5);
  std::string text = kBoxes;
  text.replace(text.find("'Boxes'"), 7, "'Fresh'");
  folder_.write("boxes.lua", text);
  std::filesystem::last_write_time(path_,
                                   std::filesystem::file_time_type::clock::now() + std::chrono::seconds(2));
  frames(30);
  EXPECT_EQ(player().demo().title(), "Fresh");
  folder_.write("boxes.lua", "demo{ title = ");
  std::filesystem::last_write_time(path_,
                                   std::filesystem::file_time_type::clock::now() + std::chrono::seconds(4));
  frames(30);
  ASSERT_TRUE(bench_->message());
  EXPECT_TRUE(bench_->message()->trouble);
  EXPECT_NE(bench_->message()->text.find("boxes.lua:1:"), std::string::npos) << bench_->message()->text;
  EXPECT_EQ(player().demo().title(), "Fresh") << "what ran goes on";
}

TEST_F(WindowViewTest, MethodsParametersAndGhosts) {
  bench_->open(path_);
  frames(5);
  bench_->set_parameter("mu", "0.25");
  EXPECT_EQ(player().demo().parameters().front().value, 0.25);
  EXPECT_EQ(player().step(), 0u);
  frames(20);
  Methods methods = methods_of(player().demo().world());
  methods.solver = "pgs";
  methods.broad_phase = "sweep_and_prune";
  bench_->set_methods(methods);
  EXPECT_EQ(player().demo().world().config().solver, "pgs");
  frames(20);
  key(render::kKeyF1 + 5);
  ASSERT_TRUE(bench_->has_ghost());
  EXPECT_EQ(bench_->ghost().step(), player().step());
  frames(10);
  EXPECT_EQ(bench_->ghost().step(), player().step());
  EXPECT_LT(bench_->ghost_distance(), 0.1);
  bench_->scrub(3);
  EXPECT_EQ(bench_->ghost().step(), 3u);
  key(render::kKeyF1 + 5);
  EXPECT_FALSE(bench_->has_ghost());
}

/// Clicks all over the settings: each of them is somewhere, and does what it says.
TEST_F(WindowViewTest, SettingsAreChangedWithTheMouse) {
  bench_->open(path_);
  frames(2);
  key(render::kKeyEnter);
  ASSERT_TRUE(bench_->panels.settings);
  const auto settings = [&] {
    std::map<std::string, std::string> now;
    for (const Overlay& overlay : overlays())
      now[std::string(overlay.name)] = std::to_string(bench_->shows(std::string(overlay.name)));
    const Methods methods = methods_of(player().demo().world());
    now["solver"] = methods.solver;
    now["stepper"] = methods.stepper;
    now["broad phase"] = methods.broad_phase;
    now["impact law"] = methods.impact_law;
    now["ghost"] = std::to_string(bench_->has_ghost());
    now["mu"] = std::to_string(player().demo().parameters().front().value);
    now["right click"] = std::string(to_string(bench_->spawn_kind));
    now["theme"] = bench_->theme() == render::Theme::Light ? "light" : "dark";
    return now;
  };
  std::set<std::string> changed;
  const auto click = [&](float x, float y) {
    const std::map<std::string, std::string> before = settings();
    input_.ui.mouse_x = x;
    input_.ui.mouse_y = y;
    button(0, true);
    button(0, false);
    for (const auto& [name, value] : settings())
      if (before.at(name) != value) changed.insert(name);
  };
  const auto sweep = [&](int from, int to, int by, int below) {
    for (int row = from; row < to; row += by) {
      const auto y = static_cast<float>(row);
      click(24, y);
      frames();
      click(30, y + static_cast<float>(below));  // what a list that has opened offers
      click(90, y);
    }
  };
  sweep(70, 360, 11, 40);
  sweep(200, 360, 11, 52);
  sweep(470, 600, 16, 40);
  input_.ui.mouse_x = 100;
  input_.ui.mouse_y = 400;
  input_.ui.wheel = -30;
  frames();
  sweep(70, 640, 16, 40);
  for (const auto& [name, value] : settings()) EXPECT_EQ(changed.count(name), 1u) << name;
  EXPECT_EQ(player().divergence(), std::nullopt);
}

TEST_F(WindowViewTest, HelpCanBeOpenedAndClosed) {
  bench_->open(path_);
  frames(2);
  key(render::kKeyF1);
  EXPECT_TRUE(bench_->panels.help);
  frames(3);
  key(render::kKeyEscape);
  EXPECT_FALSE(bench_->panels.help);
}

TEST_F(WindowViewTest, EveryKeyDoesSomethingOnceAndAppearsInTheTable) {
  std::set<std::tuple<int, bool, bool>> seen;
  for (const KeyAction& action : actions())
    EXPECT_TRUE(seen.insert({action.key, action.ctrl, action.shift}).second) << action.what;
  std::set<char> letters;
  for (const Overlay& overlay : overlays()) {
    if (overlay.key == 0) continue;
    EXPECT_TRUE(letters.insert(overlay.key).second) << overlay.name;
  }
  bench_->open(path_);
  key(' ');
  for (const Overlay& overlay : overlays()) {
    if (overlay.key == 0) continue;
    const std::string name(overlay.name);
    const bool before = bench_->shows(name);
    key(std::toupper(overlay.key));
    EXPECT_NE(bench_->shows(name), before) << name;
    frames();
  }
  EXPECT_EQ(player().divergence(), std::nullopt);
  // The README shows the same table; overlays, which have one letter each, are left to `--keys`.
  const std::string readme = read_file(std::string(source_dir()) + "/README.md");
  std::istringstream table(keys_table());
  for (std::string line; std::getline(table, line);) {
    const bool overlay = line.size() > 4 && std::isupper(line[2]) && line[3] == ' ';
    if (overlay) continue;
    EXPECT_NE(readme.find(line), std::string::npos) << "README.md lacks: " << line;
  }
}

TEST_F(WindowViewTest, FilmsAndScreenshotsAreWholeFiles) {
  bench_->open(path_);
  frames(3);
  key(render::kKeyF1 + 8);
  frames(20);
  key(render::kKeyF1 + 8);
  frames();
  EXPECT_GT(std::filesystem::file_size("boxes.mp4"), 1000u);
  key(render::kKeyF1 + 11);
  frames();
  const render::Image image = render::read_png("boxes.png");
  EXPECT_EQ(image.width, 1280);
  EXPECT_EQ(image.height, 720);
}

TEST_F(WindowViewTest, ABodyIsRemovedUnderEveryOverlay) {
  bench_->open(find_demo("failing_bridge", demo_tree()).path);
  const std::uint64_t broken = 270;
  bench_->scrub(broken);
  const World& world = player().demo().world();
  std::vector<std::string> before = bench_->overlays();
  for (const std::string& name : before) bench_->toggle_overlay(name);
  std::size_t removed = 0;
  for (const Overlay& overlay : overlays()) {
    bench_->toggle_overlay(std::string(overlay.name));
    bench_->scrub(broken);
    bench_->say("");
    frames(1);
    for (std::size_t i = 0; i < world.bodies().size(); ++i) {
      if (!world.bodies().alive[i] || world.bodies().type[i] != BodyType::Dynamic) continue;
      bench_->selection = {};
      bench_->selection.body = world.body_id(i);
      bench_->remove_selected();
      ++removed;
    }
    frames(1);
    EXPECT_FALSE(bench_->message() && bench_->message()->trouble)
        << overlay.name << ": " << bench_->message()->text;
    bench_->step(1);
    frames(1);
    EXPECT_FALSE(bench_->message() && bench_->message()->trouble)
        << overlay.name << ": " << bench_->message()->text;
    bench_->toggle_overlay(std::string(overlay.name));
    // Back to before, where the bodies are still there.
    bench_->scrub(broken - 1);
    player().forget_future();
  }
  EXPECT_GT(removed, 2 * overlays().size());
}

TEST_F(WindowViewTest, WhatCannotBeDrawnIsToldAndTheSessionGoesOn) {
  bench_->open(path_);
  frames(3);
  bench_->camera.height = std::nan("");
  frames();
  ASSERT_TRUE(bench_->message());
  EXPECT_NE(bench_->message()->text.find("camera"), std::string::npos) << bench_->message()->text;
  EXPECT_TRUE(bench_->time().playing());
  bench_->fit_view = true;
  frames(400);
  EXPECT_FALSE(bench_->message());
  // No wheel turns so far that nothing can be seen or made.
  mouse({0, 3});
  for (const float wheel : {-1.0f, 1.0f}) {
    for (int i = 0; i < 400; ++i) {
      input_.ui.wheel = 3 * wheel;
      frames();
      if (bench_->camera.height < 1e-5 || bench_->camera.height > 1e8) break;
    }
    for (int i = 0; i < 60; ++i) {
      input_.ui.wheel = 3 * wheel;
      view_->frame(input_, 1280, 720);
    }
    button(1, true);
    button(1, false);
    EXPECT_FALSE(bench_->message() && bench_->message()->trouble) << bench_->message()->text;
    EXPECT_GE(bench_->camera.height, 1e-6 * (1 - 1e-9));
    EXPECT_LE(bench_->camera.height, 1e9 * (1 + 1e-9));
    key('0');
  }
}

TEST_F(WindowViewTest, ADemoThatDoesNotOpenLeavesTheOtherAlone) {
  bench_->open(path_);
  frames(20);
  const std::string broken = folder_.write("zbroken.lua", "demo{ title = ");
  std::filesystem::last_write_time(broken,
                                   std::filesystem::file_time_type::clock::now() - std::chrono::seconds(60));
  bench_->open(broken);
  frames(60);
  ASSERT_TRUE(bench_->message());
  EXPECT_NE(bench_->message()->text.find("zbroken.lua:1:"), std::string::npos) << bench_->message()->text;
  EXPECT_EQ(player().demo().title(), "Boxes");
  EXPECT_EQ(player().step(), 20u) << "paused, not begun again";
}

TEST_F(WindowViewTest, TheListShowsScriptsAsTheyAreNow) {
  const std::string path = folder_.write("zbroken.lua", "demo{ title = ");
  bench_ = std::make_unique<Workbench>(find_demos(folder_ / ""), DemoOptions{});
  view_.reset();
  view_ = std::make_unique<WindowView>(*bench_);
  frames(3);
  bench_->open(path_);
  folder_.write("zbroken.lua", "demo{ title = 'Quagga' }\ndisc{ at = {0, 0}, radius = 1 }\n");
  std::filesystem::last_write_time(path,
                                   std::filesystem::file_time_type::clock::now() + std::chrono::seconds(2));
  key(render::kKeyTab);
  frames(3);
  const double speed = bench_->time().speed();
  input_.ui.text = "quagga";
  frames(2);
  key(render::kKeyDown);
  key(render::kKeyUp);
  key(render::kKeyDown);
  EXPECT_EQ(bench_->time().speed(), speed) << "keys of the field are not those of time";
  input_.ui.keys_down = {ImGuiKey_Enter};
  key(render::kKeyEnter);
  input_.ui.keys_down.clear();
  frames(2);
  EXPECT_EQ(player().demo().title(), "Quagga");
}

TEST_F(WindowViewTest, AnInputInThePastOfADragLetsGo) {
  bench_->open(path_);
  frames(2);
  key(' ');
  const auto body = player().demo().world().body_id(1);
  bench_->grab(body, {-2, 0.5});
  for (int i = 0; i < 30; ++i) {
    bench_->drag({-2, 0.5 + 0.1 * i});
    bench_->seek(player().step() + 1);
  }
  bench_->release();
  key(render::kKeyF1 + 5);
  ASSERT_TRUE(bench_->has_ghost());
  bench_->scrub(20);
  ASSERT_TRUE(player().hand().holds());
  Methods methods = methods_of(player().demo().world());
  methods.solver = "pgs";
  bench_->set_methods(methods);
  EXPECT_FALSE(player().hand().holds());
  EXPECT_FALSE(bench_->ghost().hand().holds());
  EXPECT_EQ(bench_->ghost().end(), 20u);
  for (int i = 0; i < 120; ++i) bench_->seek(player().step() + 1);
  EXPECT_LT(player().demo().world().bodies().position[1].y, 0.6) << "it fell down";
  EXPECT_LT(bench_->ghost_distance(), 0.05) << "the ghost does what the user does";
  // A body that is made meanwhile, the same; and while the button is down the hand stays.
  bench_->scrub(10);
  ASSERT_TRUE(player().hand().holds());
  bench_->spawn({0, 3});
  EXPECT_FALSE(player().hand().holds());
  bench_->grab(body, player().demo().world().position(body));
  bench_->spawn({1, 3});
  EXPECT_TRUE(player().hand().holds());
  bench_->release();
  EXPECT_EQ(player().divergence(), std::nullopt);
}

TEST_F(WindowViewTest, AGhostPrintsNothingAndStaysWithItsDemo) {
  int lines = 0;
  DemoOptions options;
  options.print = [&](std::string_view) { ++lines; };
  const std::string path = folder_.write(
      "p.lua", "demo{ title = 'P' }\ndisc{ at = {0, 0}, radius = 1 }\non_step(function() print('x') end)\n");
  view_.reset();
  bench_ = std::make_unique<Workbench>(find_demos(folder_ / ""), options);
  view_ = std::make_unique<WindowView>(*bench_);
  bench_->open(path);
  frames(5);
  Methods methods = methods_of(player().demo().world());
  methods.stepper = "time_stepping";
  bench_->set_ghost(methods);
  frames(5);
  EXPECT_EQ(lines, 10);
  bench_->open(path_);
  EXPECT_FALSE(bench_->has_ghost());
  bench_->toggle_ghost();
  EXPECT_EQ(bench_->ghost_methods().solver, "pgs") << "the usual one, not that of another demo";
}

TEST_F(WindowViewTest, PicturesDoNotShowTheMessages) {
  bench_->open(path_);
  frames(3);
  key(' ');
  frames(5);
  key(render::kKeyF1 + 11);
  ASSERT_TRUE(bench_->message());
  bench_->say("something to read");
  frames(3);
  key(render::kKeyF1 + 11);
  const render::Image first = render::read_png("boxes.png"), second = render::read_png("boxes-2.png");
  EXPECT_TRUE(first == second);
  render::Image window;
  view_->target().read(window);
  EXPECT_FALSE(window == second) << "the window shows it";
}

}  // namespace window_view_test
}  // namespace skerry::sandbox
