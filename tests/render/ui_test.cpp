// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <imgui.h>

#include "render/egl_context.h"
#include "render/gl_renderer.h"
#include "render/ui_host.h"

namespace skerry::render {
namespace {

void panels(UiHost& ui, UiTexture& matrix) {
  ImGui::SetNextWindowPos({900, 20});
  ImGui::SetNextWindowSize({360, 0});
  ImGui::Begin("Island matrix", nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PushFont(ui.bold());
  ImGui::TextUnformatted("W, 4 x 4");
  ImGui::PopFont();
  ImGui::Image(matrix.id(), {200, 200});
  ImGui::PushFont(ui.mono());
  ImGui::TextUnformatted("2.000  -1.000   0.000   0.000");
  ImGui::PopFont();
  static float value = 0.4f;
  ImGui::SliderFloat("friction µ", &value, 0, 1);
  bool on = true;
  ImGui::Checkbox("normals", &on);
  ImGui::SameLine();
  ImGui::Button("Step");
  if (ImGui::BeginTable("t", 3, ImGuiTableFlags_Borders)) {
    ImGui::TableSetupColumn("contact");
    ImGui::TableSetupColumn("impulse [N s]");
    ImGui::TableSetupColumn("gap [m]");
    ImGui::TableHeadersRow();
    for (int i = 0; i < 9; ++i) {
      ImGui::TableNextColumn();
      ImGui::Text("%d", i);
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

TEST(UiHost, DrawsPanels) {
  EglContext context;
  GlRenderer renderer;
  for (Theme theme : {Theme::Light, Theme::Dark}) {
    const Style& s = style(theme);
    Target target(1280, 720);
    UiHost ui(s);
    UiTexture matrix;
    Image heat(4, 4, s.accent);
    heat.set(1, 2, s.warning);
    heat.set(0, 0, s.impulse);
    matrix.upload(heat);
    Camera camera;
    DrawList list;
    list.background = s.background;
    for (int i = 0; i < 2; ++i) {
      ui.begin_frame(1280, 720, 1, 1.0 / 60);
      panels(ui, matrix);
      ui.end_frame();
    }
    renderer.draw(list, camera, target);
    ui.begin_frame(1280, 720, 1, 1.0 / 60);
    panels(ui, matrix);
    ui.end_frame(target);
    Image image;
    target.read(image);
    write_png("/tmp/ui_" + std::string(to_string(theme)) + ".png", image);
  }
}

}  // namespace
}  // namespace skerry::render
