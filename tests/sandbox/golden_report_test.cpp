// SPDX-License-Identifier: MIT
//
// The page of `skerry golden --report`: what it says, and in a real browser that it works.
#include <cstdio>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/html_report.h"
#include "sandbox/errors.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace golden_report_test {

using render::Color;
using render::Image;
using render::ReportPage;
using render::ReportScene;
using testing::HasSubstr;

Image plain(int width, int height) {
  Image image(width, height, {230, 230, 230, 255});
  for (int i = 0; i < 40; ++i) image.set(20 + i, 30, {20, 90, 160, 255});
  return image;
}

ReportScene differing(const std::string& name) {
  ReportScene scene;
  scene.name = name;
  scene.about = "stack --at 1 <&>";
  scene.expected = plain(160, 90);
  scene.actual = plain(160, 90);
  for (int i = 0; i < 12; ++i) scene.actual.set(100 + i % 4, 60 + i / 4, {200, 40, 40, 255});
  scene.actual.set(3, 3, {229, 230, 230, 255});
  scene.diff = render::compare(*scene.expected, scene.actual);
  scene.picture_reason = scene.diff.reason;
  scene.state_expected = scene.state_actual = "0123456789abcdef";
  scene.repeat = "skerry capture stack";
  scene.bless = "skerry golden --bless " + name;
  return scene;
}

ReportPage page() {
  ReportPage page;
  page.title = "Golden";
  page.about = "a driver";
  page.scenes.push_back(differing("one"));
  ReportScene moved = differing("two");
  moved.state_actual = "fedcba9876543210";
  page.scenes.push_back(moved);
  ReportScene fresh;
  fresh.name = "three";
  fresh.actual = plain(160, 90);
  fresh.state_actual = "1";
  page.scenes.push_back(fresh);
  ReportScene good;
  good.name = "four";
  good.actual = plain(160, 90);
  good.picture_good = true;
  good.state_expected = good.state_actual = "2";
  page.scenes.push_back(good);
  ReportScene resized = differing("five");
  resized.actual = plain(80, 90);
  resized.diff = render::compare(*resized.expected, resized.actual);
  resized.picture_reason = resized.diff.reason;
  page.scenes.push_back(resized);
  ReportScene broken;
  broken.name = "six";
  broken.problem = "no demo \"stak\"";
  page.scenes.push_back(broken);
  return page;
}

std::string shell(const std::string& command) {
  std::string text;
  FILE* pipe = popen((command + " 2>/dev/null").c_str(), "r");
  char buffer[4096];
  while (const std::size_t count = fread(buffer, 1, sizeof buffer, pipe)) text.append(buffer, count);
  pclose(pipe);
  return text;
}

std::string browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    if (!shell(std::string("command -v ") + name).empty()) return name;
  return "";
}

// What the page finds when it works itself in the browser.
std::string verdict(const TemporaryFolder& folder, const std::string& html) {
  const std::string path = folder.write("index.html", html);
  const std::string dom =
      shell("timeout 60 " + browser() +
            " --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking"
            " --user-data-dir=" +
            (folder / "profile") + " --virtual-time-budget=20000 --dump-dom 'file://" + path + "#selftest'");
  const std::string key = "data-verdict=\"";
  const std::size_t begin = dom.find(key);
  if (begin == std::string::npos) return "no verdict";
  const std::size_t end = dom.find('"', begin + key.size());
  return dom.substr(begin + key.size(), end - begin - key.size());
}

// Pages are too long for a failure message.
bool contains(const std::string& html, const std::string& part) {
  return html.find(part) != std::string::npos;
}

TEST(GoldenReport, NamesBothJudgementsAndTheCommands) {
  const std::string html = render::html_report(page());
  EXPECT_TRUE(contains(html, "<b class=\"\">6</b>scenes"));
  EXPECT_TRUE(contains(html, "<b class=\"bad\">3</b>pictures differ"));
  EXPECT_TRUE(contains(html, "<b class=\"bad\">1</b>states moved"));
  EXPECT_TRUE(contains(html, "<b class=\"new\">1</b>new"));
  EXPECT_TRUE(contains(html, "<b class=\"bad\">1</b>without a picture"));
  EXPECT_TRUE(contains(html, "the largest has 12 at (100, 60), 4 x 3 px"));
  EXPECT_TRUE(contains(html, "expected <code>0123456789abcdef</code>, got <code>fedcba9876543210</code>"));
  EXPECT_TRUE(contains(html, "skerry golden --bless two"));
  EXPECT_TRUE(contains(html, "the picture has 80 x 90 px, expected 160 x 90"));
  EXPECT_TRUE(contains(html, "no demo &quot;stak&quot;"));
  EXPECT_TRUE(contains(html, "stack --at 1 &lt;&amp;&gt;"));
  // Nothing comes from elsewhere.
  EXPECT_FALSE(contains(html, "http"));
  EXPECT_FALSE(contains(html, "<link"));
}

TEST(GoldenReport, Base64FollowsTheStandard) {
  const auto text = [](const char* plain) {
    return render::base64(std::vector<std::uint8_t>(plain, plain + std::char_traits<char>::length(plain)));
  };
  // RFC 4648, section 10.
  EXPECT_EQ(text(""), "");
  EXPECT_EQ(text("f"), "Zg==");
  EXPECT_EQ(text("fo"), "Zm8=");
  EXPECT_EQ(text("foo"), "Zm9v");
  EXPECT_EQ(text("foobar"), "Zm9vYmFy");
}

TEST(GoldenReport, WorksInABrowser) {
  if (browser().empty()) GTEST_SKIP() << "no browser; apt install chromium";
  const TemporaryFolder folder;
  EXPECT_EQ(verdict(folder, render::html_report(page())), "good: 2 comparisons, 18 pictures");
}

TEST(GoldenReport, BrowserCountsForItself) {
  if (browser().empty()) GTEST_SKIP() << "no browser; apt install chromium";
  const TemporaryFolder folder;
  ReportPage wrong = page();
  wrong.scenes[0].diff.beyond = 11;
  EXPECT_EQ(verdict(folder, render::html_report(wrong)), "bad: one: pixels beyond 12");
}

TEST(GoldenReport, CommandWritesOnePage) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "golden");
  folder.write("golden/scenes.txt", "small stack --at 0.1 --size 400x225\n");
  const Outcome outcome =
      run({"golden", "--demos", demo_tree(), "--folder", folder / "golden", "--report", folder / "r"});
  EXPECT_EQ(outcome.code, kCheckFailed);
  EXPECT_THAT(outcome.out, HasSubstr("index.html"));
  const std::string html = read_file(folder / "r/index.html");
  EXPECT_TRUE(contains(html, "skerry capture stack --at 0.1 --size 400x225 --demos "));
  EXPECT_TRUE(contains(html, "drawn by built-in rasteriser"));
}

}  // namespace golden_report_test
}  // namespace skerry::sandbox
