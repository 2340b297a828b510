// SPDX-License-Identifier: MIT
//
// The golden scenes of the tree: every one as it was blessed, and none forgotten.
//
// After a change that people looked at (`skerry golden --report DIR`): `skerry golden --bless`.
#include <algorithm>
#include <gtest/gtest.h>
#include <optional>
#include <set>

#include "sandbox/demo_files.h"
#include "sandbox/golden.h"
#include "sandbox/report.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {

// Parameters are named, not dumped, in the names of tests.
static void PrintTo(const GoldenScene& scene, std::ostream* out) {
  *out << scene.name;
}

namespace pictures_test {

std::string golden_tree() {
  return std::string(source_dir()) + "/tests/golden";
}

std::vector<GoldenScene> scenes() {
  return read_golden_scenes(golden_tree() + "/scenes.txt");
}

class GoldenScenesOf : public testing::TestWithParam<GoldenScene> {
 protected:
  void SetUp() override {
    for (Accepted& entry : read_accepted(golden_tree() + "/accepted.txt"))
      if (entry.name == GetParam().name) accepted_ = std::move(entry);
    ASSERT_TRUE(accepted_) << "nothing was blessed: skerry golden --bless " << GetParam().name;
  }
  std::optional<Accepted> accepted_;
};

// Digests are set aside here, so that the PNG in the tree is what passes.
TEST_P(GoldenScenesOf, PictureAndStateAreAsBlessed) {
  const GoldenShot shot = take_golden_shot(GetParam(), demo_tree());
  Accepted by_pixels = *accepted_;
  by_pixels.digests = {0};
  const GoldenVerdict verdict = judge(shot, &by_pixels, golden_tree() + '/' + GetParam().name + ".png");
  EXPECT_TRUE(verdict.picture_good) << "the picture differs: " << verdict.picture_reason
                                    << "\nskerry golden --report DIR " << GetParam().name;
  EXPECT_TRUE(verdict.state_good) << "the state moved: expected " << hex(accepted_->state) << ", got "
                                  << hex(shot.state);
}

INSTANTIATE_TEST_SUITE_P(Golden, GoldenScenesOf, testing::ValuesIn(scenes()),
                         [](const auto& row) { return row.param.name; });

TEST(GoldenScenes, AreManyInBothThemesWithAndWithoutOverlays) {
  std::size_t dark = 0;
  std::size_t bare = 0;
  const std::vector<GoldenScene> all = scenes();
  for (const GoldenScene& scene : all) {
    dark += scene.paint.theme == render::Theme::Dark;
    bare += scene.picture.overlays == std::vector<std::string>{"none"};
  }
  EXPECT_GE(all.size(), 25u);
  EXPECT_GE(dark, 6u);
  EXPECT_GE(bare, 4u);
  EXPECT_GE(all.size() - dark, 6u);
}

// A scene counts for an overlay when the picture would be another one without it.
TEST(GoldenScenes, EveryOverlayHasOne) {
  std::vector<std::string> missing = overlay_names();
  for (const GoldenScene& scene : scenes()) {
    std::optional<render::Image> whole;  // once for all overlays of the scene
    for (const std::string& name : scene.picture.overlays) {
      const auto wanted = std::find(missing.begin(), missing.end(), name);
      if (wanted == missing.end()) continue;
      GoldenScene without = scene;
      std::erase(without.picture.overlays, name);
      if (!whole) whole = take_golden_shot(scene, demo_tree()).image;
      if (!(*whole == take_golden_shot(without, demo_tree()).image)) missing.erase(wanted);
    }
  }
  EXPECT_TRUE(missing.empty()) << "tests/golden/scenes.txt needs a scene that shows "
                               << testing::PrintToString(missing);
}

TEST(GoldenScenes, PicturesAreThoseOfTheListAndSmall) {
  std::set<std::string> names;
  for (const GoldenScene& scene : scenes()) names.insert(scene.name);
  std::uintmax_t bytes = 0;
  for (const auto& file : std::filesystem::directory_iterator(golden_tree())) {
    if (file.path().extension() != ".png") continue;
    EXPECT_TRUE(names.contains(file.path().stem().string())) << file.path() << " belongs to no scene";
    bytes += file.file_size();
  }
  EXPECT_LT(bytes, 2u << 20) << "what is in the repository stays in its history";
}

}  // namespace pictures_test
}  // namespace skerry::sandbox
