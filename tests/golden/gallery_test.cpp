// SPDX-License-Identifier: MIT
//
// captures/: every demo has its still and its row, and nothing else lies there.
#include <gtest/gtest.h>
#include <set>

#include "render/image.h"
#include "sandbox/demo_files.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace gallery_test {

std::string captures() {
  return std::string(source_dir()) + "/captures";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Gallery, EveryDemoHasItsStillAndItsCommand) {
  const std::string page = read_file(captures() + "/README.md");
  for (const DemoFile& demo : find_demos(demo_tree())) {
    const std::string hint = demo.name + ": run captures/stills.sh " + demo.name;
    EXPECT_TRUE(contains(page, "](" + demo.name + ".png)")) << hint;
    EXPECT_TRUE(contains(page, "`skerry capture " + demo.name + " --at ")) << hint;
    ASSERT_TRUE(std::filesystem::exists(captures() + '/' + demo.name + ".png")) << hint;
    const render::Image still = render::read_png(captures() + '/' + demo.name + ".png");
    EXPECT_EQ(still.width, 960) << hint;
    EXPECT_EQ(still.height, 540) << hint;
  }
}

TEST(Gallery, DemosHaveDifferentNamesTitlesAndLessons) {
  std::set<std::string> names;
  std::set<std::string> titles;
  for (const DemoFile& file : find_demos(demo_tree())) {
    EXPECT_TRUE(names.insert(file.name).second) << "two demos are called " << file.name;
    const Demo demo(file.path, DemoOptions{});
    EXPECT_TRUE(titles.insert(demo.title()).second) << "two demos have the title " << demo.title();
    EXPECT_FALSE(demo.lesson().empty()) << file.path;
    EXPECT_FALSE(demo.checks().empty()) << file.path;
    EXPECT_TRUE(demo.picture().view) << file.path << " has no framing";
    EXPECT_FALSE(file.topic.empty()) << file.path << " is in no topic";
  }
  EXPECT_GE(names.size(), 20u);
}

TEST(Gallery, HoldsNothingElseAndStaysSmall) {
  std::set<std::string> names;
  for (const DemoFile& demo : find_demos(demo_tree())) names.insert(demo.name);
  std::uintmax_t bytes = 0;
  for (const auto& file : std::filesystem::directory_iterator(captures())) {
    if (file.path().extension() != ".png") continue;
    if (file.path().stem() == "window") continue;  // of the README
    EXPECT_TRUE(names.contains(file.path().stem().string())) << file.path() << " belongs to no demo";
    bytes += file.file_size();
  }
  EXPECT_LT(bytes, 3u << 20) << "what is in the repository stays in its history";
}

}  // namespace gallery_test
}  // namespace skerry::sandbox
