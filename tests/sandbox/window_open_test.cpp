// SPDX-License-Identifier: MIT
//
// `skerry open` with the events of a real display, under Xvfb.
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <set>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "render/image.h"
#include "sandbox/demo.h"
#include "sandbox/painter.h"
#include "sandbox/window/recording.h"
#include "sandbox/window/window_fit.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace window_open_test {

std::string shell(const std::string& command, int& status) {
  std::string out;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  char buffer[256];
  while (pipe && fgets(buffer, sizeof buffer, pipe)) out += buffer;
  status = pipe ? pclose(pipe) : -1;
  return out;
}

/// `skerry open` in a process of its own on an X server of its own. The program is started anew: a copy of
/// this process would believe in the driver's threads, which fork() leaves behind.
class OpenCommand : public testing::Test {
 protected:
  void SetUp() override {
    int channel[2];
    ASSERT_EQ(pipe(channel), 0);
    server_ = fork();
    if (server_ == 0) {
      close(channel[0]);
      execlp("Xvfb", "Xvfb", "-displayfd", std::to_string(channel[1]).c_str(), "-screen", "0", "1280x720x24",
             "-nolisten", "tcp", "-noreset", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(channel[1]);
    char c = 0;
    while (read(channel[0], &c, 1) == 1 && c != '\n') display_ += c;
    close(channel[0]);
    ASSERT_FALSE(display_.empty()) << "Xvfb is needed (apt install xvfb)";
  }
  void TearDown() override {
    for (const pid_t process : {window_, server_}) {
      if (process <= 0) continue;
      kill(process, SIGTERM);
      waitpid(process, nullptr, 0);
    }
  }
  void open(const std::string& demo) {
    const std::string skerry = program(), errors = folder_ / "errors.txt", demos = demo_tree();
    window_ = fork();
    if (window_ != 0) return;
    setenv("DISPLAY", (":" + display_).c_str(), 1);
#ifdef __SANITIZE_ADDRESS__
    setenv("ASAN_OPTIONS", "detect_leaks=0", 1);  // the driver keeps memory
#endif
    if (chdir((folder_ / "").c_str()) != 0 || !freopen(errors.c_str(), "w", stderr)) _exit(125);
    execl(skerry.c_str(), skerry.c_str(), "open", demo.c_str(), "--demos", demos.c_str(), "--close-after",
          "60", static_cast<char*>(nullptr));
    _exit(126);
  }
  /// Acts as a user, until `done` holds, for at most ten seconds.
  bool act(const std::string& events, const std::function<bool()>& done) {
    int status = 0;
    const std::string out = shell("DISPLAY=:" + display_ + " xdotool " + events, status);
    EXPECT_EQ(status, 0) << events << ": " << out;
    for (int i = 0; i < 1000; ++i) {
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  std::string title() {
    int status = 0;
    return shell("DISPLAY=:" + display_ + " xdotool search --name Skerry getwindowname", status);
  }

  TemporaryFolder folder_;
  pid_t server_ = -1, window_ = -1;
  std::string display_;
};

TEST_F(OpenCommand, ServesAUserWithMouseAndKeys) {
  open("newtons_cradle");
  const auto exists = [&](const char* name) { return std::filesystem::exists(folder_ / name); };
  const auto always = [] { return true; };
  ASSERT_TRUE(act("search --sync --onlyvisible --name Skerry",
                  [&] { return title().find("Skerry") != std::string::npos; }));
  ASSERT_TRUE(act("search --onlyvisible --name Skerry windowfocus --sync", always));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_TRUE(act("key space", always));
  EXPECT_TRUE(act("key Right Right Right", always));
  // Take hold in the middle of the scene, move, let go.
  EXPECT_TRUE(
      act("mousemove 500 400 sleep 0.2 mousedown 1 sleep 0.2 mousemove 560 360 sleep 0.2 mouseup 1", always));
  EXPECT_TRUE(act("mousemove 300 200 sleep 0.2 click 3 sleep 0.2", always));
  EXPECT_TRUE(act("key F12", [&] { return exists("newtons_cradle.png"); }));
  EXPECT_TRUE(act("key F8", [&] { return exists("newtons_cradle.skerry"); }));
  const render::Image image = render::read_png(folder_ / "newtons_cradle.png");
  EXPECT_EQ(image.width, 1280);
  EXPECT_EQ(image.height, 720);
  // The play button is a disc of the accent colour; paused, its triangle points right.
  const render::Style& style = render::style(render::Theme::Light);
  int accent = 0;
  std::set<std::uint32_t> colors;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const render::Color color = image.at(x, y);
      colors.insert(color.r << 16 | color.g << 8 | color.b);
      accent += y > 665 && color == style.accent;
    }
  }
  EXPECT_GT(accent, 600);
  EXPECT_GT(colors.size(), 50u);
  const Recording recording = load_recording(read_bytes(folder_ / "newtons_cradle.skerry"));
  EXPECT_GE(recording.steps(), 3u);
  EXPECT_TRUE(std::any_of(recording.inputs.begin(), recording.inputs.end(),
                          [](const UserInput& input) { return input.kind == InputKind::Spawn; }));
  // Search: Tab, letters, Enter.
  EXPECT_TRUE(act("key Tab sleep 0.5 type --delay 60 seesaw", always));
  EXPECT_TRUE(act("sleep 0.3 key Return", [&] { return title().find("Newton") == std::string::npos; }));
  EXPECT_NE(title().find("Skerry"), std::string::npos);
  EXPECT_TRUE(act("key ctrl+q", always));
  int status = 0;
  EXPECT_EQ(waitpid(window_, &status, 0), window_);
  window_ = -1;
  EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 0) << read_file(folder_ / "errors.txt");
}

// The mouse over a cell of the matrix: its two contacts light up with lines between them. A click on a
// contact point: its row and column. Judged by what the screen shows.
TEST_F(OpenCommand, MatrixAndContactsPointAtEachOther) {
  const std::string demo =
      folder_.write("two.lua",
                    "demo{ title = 'Two', view = { x = 0, y = 1.5, height = 5, width = 5 } }\n"
                    "ground{ y = 0 }\nlocal a = box{ at = {0, 0.5}, size = {1, 1}, mass = 1 }\n"
                    "box{ at = {0, 1.5}, size = {1, 1}, mass = 1 }\nshow{ 'contacts', 'matrix' }\n");
  open(demo);
  const auto exists = [&](const std::string& name) { return std::filesystem::exists(folder_ / name); };
  const auto always = [] { return true; };
  ASSERT_TRUE(act("search --sync --onlyvisible --name Skerry",
                  [&] { return title().find("Skerry") != std::string::npos; }));
  ASSERT_TRUE(
      act("search --onlyvisible --name Skerry windowfocus --sync sleep 1.5 key space sleep 0.3", always));
  int shots = 0;
  const auto screen = [&] {
    const std::string name = ++shots == 1 ? "two.png" : "two-" + std::to_string(shots) + ".png";
    EXPECT_TRUE(act("sleep 0.2 key F12", [&] { return exists(name); })) << name;
    // Until the message with the name of the file has gone it may cover something.
    return render::read_png(folder_ / name);
  };
  // Where things are follows from the same layout.
  Demo same(demo, {.seconds = 0.5});
  const int bar = static_cast<int>(std::lround(kToolbarPx * 720 / (720 + kToolbarPx)));
  Composer composer(render::style(render::Theme::Light), 1280, 720 - bar);
  composer.show({"contacts", "matrix"}, 1280, 720 - bar);
  const render::Camera camera = composer.camera(same);
  const render::Color accent = render::style(render::Theme::Light).accent;
  const auto near = [&](const render::Image& image, double x0, double x1, double y0, double y1) {
    int count = 0;
    for (int y = std::max(0, static_cast<int>(y0)); y < std::min<int>(image.height, static_cast<int>(y1));
         ++y)
      for (int x = std::max(0, static_cast<int>(x0)); x < std::min<int>(image.width, static_cast<int>(x1));
           ++x) {
        const render::Color c = image.at(x, y);
        count +=
            std::abs(c.r - accent.r) < 24 && std::abs(c.g - accent.g) < 24 && std::abs(c.b - accent.b) < 24;
      }
    return count;
  };
  const auto around = [&](const render::Image& image, double x, double y) {
    const render::Point p = camera.to_pixels({x, y});
    return near(image, p.x - 14, p.x + 14, p.y - 14, p.y + 14);
  };
  const render::Image before = screen();
  // The first strong red of the panel is the cell of row 1 and column 1.
  int left = 0, top = 0;
  for (int y = 80; y < 640 && left == 0; ++y)
    for (int x = 870; x < 1270 && left == 0; ++x) {
      const render::Color c = before.at(x, y);
      if (c.r > 180 && c.g < 110 && c.b < 110) left = x, top = y;
    }
  ASSERT_GT(left, 0) << "no matrix on the screen";
  // Along the first row: over some cell two different contacts are lit.
  const double contacts[][2] = {{-0.5, 0}, {0.5, 0}, {-0.5, 1}, {0.5, 1}};
  const auto lit = [&](const render::Image& image) {
    int count = 0;
    for (const auto& c : contacts) count += around(image, c[0], c[1]) > around(before, c[0], c[1]) + 20;
    return count;
  };
  const auto move = [&](int x, int y) {
    EXPECT_TRUE(act("mousemove " + std::to_string(x) + " " + std::to_string(y) + " sleep 0.3", always));
  };
  int most = 0;
  for (const int column : {2, 4, 6}) {
    move(left + 4 + column * 19, top + 4);
    const render::Image image = screen();
    most = std::max(most, lit(image));
    if (most == 2) break;
  }
  EXPECT_EQ(most, 2) << "a cell lights up its two contacts";
  // Away: dark again.
  move(300, 100);
  EXPECT_EQ(lit(screen()), 0);
  // A click on a contact: one ring, and frames of row and column in the matrix.
  const int frames = near(before, left - 4, 1280, top - 4, top + 200);
  const render::Point p = camera.to_pixels({0.5, 1});
  move(static_cast<int>(std::lround(p.x)), static_cast<int>(std::lround(p.y)));
  EXPECT_TRUE(act("mousedown 1 sleep 0.2 mouseup 1 sleep 0.2", always));
  const render::Image clicked = screen();
  EXPECT_EQ(lit(clicked), 1);
  EXPECT_GT(near(clicked, left - 4, 1280, top - 4, top + 200), frames + 200);
  EXPECT_TRUE(act("key ctrl+q", always));
  int status = 0;
  EXPECT_EQ(waitpid(window_, &status, 0), window_);
  window_ = -1;
  EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 0) << read_file(folder_ / "errors.txt");
}

TEST(OpenCommandErrors, WithoutADisplayTheExitCodeIs4AndTheSentenceHelps) {
  const char* before = std::getenv("DISPLAY");
  const std::string kept = before ? before : "";
  unsetenv("DISPLAY");
  const Outcome outcome = run({"open", "stack", "--demos", demo_tree()});
  EXPECT_EQ(outcome.code, 4);
  EXPECT_NE(outcome.err.find("display"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("capture"), std::string::npos) << outcome.err;
  EXPECT_EQ(run({"open", "no_such_demo", "--demos", demo_tree()}).code, 3);
  EXPECT_EQ(run({"open", "stack", "--demos", demo_tree(), "--size", "10"}).code, 2);
  if (before) setenv("DISPLAY", kept.c_str(), 1);
}

}  // namespace window_open_test
}  // namespace skerry::sandbox
