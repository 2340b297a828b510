// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <gtest/gtest.h>
#include <signal.h>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include "render/error.h"
#include "render/window_context.h"
#include "tests/render/support.h"

namespace skerry::render {
namespace window_test {

/// An X server without a screen, that ends with the test. The events come from xdotool, as a user's would.
class Window : public testing::Test {
 protected:
  void SetUp() override {
    int channel[2];
    ASSERT_EQ(pipe(channel), 0);
    server_ = fork();
    if (server_ == 0) {
      close(channel[0]);
      const std::string number = std::to_string(channel[1]);
      // No window manager: windows lie at the top left corner.
      execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "1280x800x24", "-nolisten", "tcp",
             "-noreset", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(channel[1]);
    std::string display;
    char c = 0;
    while (read(channel[0], &c, 1) == 1 && c != '\n') display += c;
    close(channel[0]);
    ASSERT_FALSE(display.empty()) << "Xvfb is needed (apt install xvfb)";
    const char* before = std::getenv("DISPLAY");
    before_ = before == nullptr ? "" : before;
    setenv("DISPLAY", (":" + display).c_str(), 1);
  }

  void TearDown() override {
    if (server_ > 0) {
      kill(server_, SIGTERM);
      waitpid(server_, nullptr, 0);
    }
    if (before_.empty()) {
      unsetenv("DISPLAY");
    } else {
      setenv("DISPLAY", before_.c_str(), 1);
    }
  }

  /// Runs xdotool and polls until `done` or for five seconds.
  static bool act(WindowContext& window, const std::string& command,
                  const std::function<bool(const WindowInput&)>& done) {
    const Output output = run("xdotool " + command);
    EXPECT_EQ(output.status, 0) << "xdotool is needed (apt install xdotool)";
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (std::chrono::steady_clock::now() < end) {
      if (done(window.poll())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }

  pid_t server_ = -1;
#ifdef __SANITIZE_ADDRESS__
  // The driver behind a window is unloaded with memory in its hands; a library that is gone cannot be named
  // in a suppression.
  __lsan::ScopedDisabler driver_keeps_memory_;
#endif
  std::string before_;
};

TEST_F(Window, ReportsMouseKeysAndTextOfAUser) {
  WindowContext window("Skerry test", 640, 480);
  EXPECT_EQ(window.width(), 640);
  EXPECT_EQ(window.height(), 480);
  EXPECT_FALSE(window.renderer().empty());
  EXPECT_TRUE(act(window, "mousemove 100 50", [](const WindowInput& in) {
    return std::abs(in.ui.mouse_x - 100) < 2 && std::abs(in.ui.mouse_y - 50) < 2;
  }));
  // A click shorter than a frame is seen down once, then up.
  int down = 0;
  EXPECT_TRUE(act(window, "click 1", [&](const WindowInput& in) {
    down += in.ui.mouse_down[0];
    return down > 0 && !in.ui.mouse_down[0];
  }));
  EXPECT_EQ(down, 1);
  EXPECT_TRUE(act(window, "mousedown 3",
                  [](const WindowInput& in) { return in.ui.mouse_down[1] || in.ui.mouse_down[2]; }));
  EXPECT_TRUE(act(window, "mouseup 3", [](const WindowInput& in) { return !in.ui.mouse_down[1]; }));
  EXPECT_TRUE(act(window, "click 4", [](const WindowInput& in) { return in.ui.wheel > 0; }));
  std::string text;
  std::vector<KeyPress> keys;
  const auto collect = [&](const WindowInput& in) {
    text += in.ui.text;
    keys.insert(keys.end(), in.keys.begin(), in.keys.end());
    return !in.keys.empty();
  };
  EXPECT_TRUE(act(window, "windowfocus $(xdotool search --name 'Skerry test') key r", collect));
  EXPECT_EQ(text, "r");
  ASSERT_EQ(keys.size(), 1u);
  EXPECT_EQ(keys[0].key, 'R');
  keys.clear();
  EXPECT_TRUE(act(window, "key ctrl+Right", [&](const WindowInput& in) {
    collect(in);
    return std::any_of(keys.begin(), keys.end(),
                       [](const KeyPress& k) { return k.key == kKeyRight && k.ctrl; });
  }));
  EXPECT_TRUE(act(window, "windowsize $(xdotool search --name 'Skerry test') 500 300",
                  [&](const WindowInput& in) { return in.resized && window.width() == 500; }));
  EXPECT_EQ(window.height(), 300);
}

TEST_F(Window, ShowsThePictureTheRightWayUp) {
  WindowContext window("Skerry test", 640, 480);
  GlRenderer renderer;
  Target target(window.width(), window.height());
  Camera camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.height = 4.8;
  DrawList list;
  list[Layer::Bodies].discs.push_back({{-1, 1}, 0.5, kRed, kRed, 0});
  Image drawn;
  for (int i = 0; i < 5; ++i) {
    window.poll();
    renderer.draw(list, camera, target);
    target.read(drawn);
    window.present(target);
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  // What the screen shows, seen by another program.
  const Scratch scratch;
  const Output grab =
      run("ffmpeg -v error -f x11grab -video_size 640x480 -draw_mouse 0 -i " +
          std::string(std::getenv("DISPLAY")) + " -frames:v 1 " + (scratch / "s.png").string());
  ASSERT_EQ(grab.status, 0) << "ffmpeg is needed (apt install ffmpeg)";
  const Image screen = read_png(scratch / "s.png");
  EXPECT_EQ(screen.at(220, 140), kRed);
  EXPECT_EQ(screen.at(220, 340), kWhite);
  EXPECT_EQ(screen, drawn);
}

TEST(WindowErrors, NoDisplayIsAnErrorThatNamesTheRemedy) {
  const char* before = std::getenv("DISPLAY");
  const std::string kept = before == nullptr ? "" : before;
  unsetenv("DISPLAY");
  try {
    const WindowContext window("none", 100, 100);
    ADD_FAILURE() << "a window without a display";
  } catch (const EnvironmentError& error) {
    EXPECT_NE(std::string(error.what()).find("apt install"), std::string::npos);
  }
  EXPECT_THROW(WindowContext("none", 0, 100), std::invalid_argument);
  if (before != nullptr) setenv("DISPLAY", kept.c_str(), 1);
}

TEST(Keys, AreWhatIsPrintedOnThem) {
  // In the numbers of GLFW, which are those of an American keyboard.
  EXPECT_EQ(printed_on('Q', "q"), 'Q');
  EXPECT_EQ(printed_on('Q', "a"), 'A') << "French";
  EXPECT_EQ(printed_on(';', "m"), 'M') << "French";
  EXPECT_EQ(printed_on('1', "&"), '1') << "French: the digit needs Shift";
  EXPECT_EQ(printed_on('Y', "z"), 'Z') << "German";
  EXPECT_EQ(printed_on('/', "-"), '-') << "German";
  EXPECT_EQ(printed_on('Q', "\xD0\xB9"), 'Q') << "Russian: by the place";
  EXPECT_EQ(printed_on('Q', nullptr), 'Q');
  EXPECT_EQ(printed_on(300, nullptr), 0);
}

}  // namespace window_test
}  // namespace skerry::render
