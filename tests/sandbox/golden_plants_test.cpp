// SPDX-License-Identifier: MIT
//
// The judge of the golden images, judged: whatever a person could break in a picture must fail, even by the
// rule for other drivers. Regressions are planted in finished frames of real scenes.
#include "tests/sandbox/golden_plants.h"

#include <gtest/gtest.h>
#include <optional>

#include "sandbox/demo_files.h"
#include "sandbox/golden.h"
#include "sandbox/history.h"
#include "sandbox/layout.h"
#include "sandbox/loop.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace golden_plants_test {

using render::DrawList;
using render::Image;

struct PlantScene {
  const char* name;
  const char* words;
};

void PrintTo(const PlantScene& scene, std::ostream* out) {
  *out << scene.name;
}

class PlantedRegression : public testing::TestWithParam<PlantScene> {
 protected:
  PlantedRegression() : scene_(golden_scene("planted", GetParam().words)) {
    scene_.paint.edit = [this](DrawList& list) {
      if (!plant_) return;
      applied_ = plant_->change({list, pixel_});
    };
    demo_.emplace(find_demo(scene_.demo, demo_tree()).path, scene_.options);
    const std::vector<std::string> names = scene_.picture.overlays_for(*demo_);
    const Observe needs = needs_of(names);
    demo_->observe(needs);
    history_.emplace(*demo_, needs.systems, kFlashSeconds);
    painter_.emplace(scene_.paint);
    painter_->start(*demo_, names);
    LoopCallbacks callbacks;
    callbacks.step = [this](Demo&) { history_->update(*demo_); };
    run_loop(*demo_, {.until = scene_.at}, callbacks);
    // The scene fills what header and footer leave of the picture's height.
    pixel_ = demo_->picture().view->height /
             (scene_.paint.height - (kHeaderPx + kFooterPx) * render::ui_scale(scene_.paint.height));
  }

  Image paint(const Plant* plant = nullptr) {
    plant_ = plant;
    applied_ = false;
    Image image;
    painter_->paint(*demo_, *history_, image);
    return image;
  }

  GoldenScene scene_;
  const Plant* plant_ = nullptr;
  bool applied_ = false;
  double pixel_ = 1;
  std::optional<Demo> demo_;
  std::optional<History> history_;
  std::optional<Painter> painter_;
};

TEST_P(PlantedRegression, FailsByTheMostForgivingRule) {
  constexpr render::DiffRule kForgiving{2, true, 64, 6};
  const Image expected = paint();
  ASSERT_TRUE(render::compare(expected, paint()).identical);
  int planted = 0;
  for (const std::vector<Plant>& kind :
       {body_plants(), joint_plants(), contact_plants(), label_plants(), panel_plants()}) {
    for (const Plant& plant : kind) {
      const Image actual = paint(&plant);
      if (!applied_) continue;
      ++planted;
      const render::DiffResult result = render::compare(expected, actual, kForgiving);
      EXPECT_FALSE(result.pass) << plant.what << ": " << result.reason;
    }
  }
  for (const ImagePlant& plant : image_plants()) {
    Image actual = expected;
    plant.change(actual);
    ++planted;
    const render::DiffResult result = render::compare(expected, actual, kForgiving);
    EXPECT_FALSE(result.pass) << plant.what << ": " << result.reason;
  }
  EXPECT_GE(planted, 50) << "the scene lacks things that could break";
  EXPECT_TRUE(render::compare(expected, paint()).identical) << "a plant outlived its frame";
}

const PlantScene kPlantScenes[] = {
    {"ImpactWithMatrix", "four_body_chain --at 1.05 --overlay contacts,impulses,matrix,islands"},
    {"RestDark", "see_saw --at 0.2 --theme dark --overlay none,contacts,impulses,matrix"},
    {"CradleWithEnergy", "newtons_cradle --at 0.6"},
};

INSTANTIATE_TEST_SUITE_P(Golden, PlantedRegression, testing::ValuesIn(kPlantScenes),
                         [](const auto& row) { return row.param.name; });

}  // namespace golden_plants_test
}  // namespace skerry::sandbox
