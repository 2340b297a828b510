// SPDX-License-Identifier: MIT
//
// Title and lesson at the top, the time at the right, the script's latest note above the footer.
#include <cstdio>
#include <imgui.h>

#include "render/ui_host.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr double kNoteSeconds = 3;  // of the video

// Breaks `words` into lines of at most `width` pixels.
std::vector<std::string> broken(ImFont* font, const std::string& words, float width) {
  std::vector<std::string> lines;
  const char* at = words.c_str();
  const char* end = at + words.size();
  while (at < end) {
    const char* next = std::max(font->CalcWordWrapPositionA(1, at, end, width), at + 1);
    lines.emplace_back(at, next);
    at = next;
    while (at < end && *at == ' ') ++at;
  }
  return lines;
}

void show_note(const PanelContext& context, double speed, float bottom) {
  const std::vector<Note>& notes = context.scene.demo.notes();
  if (notes.empty() || context.scene.demo.time() - notes.back().time > kNoteSeconds * speed) return;
  const render::Style& style = context.scene.style;
  ImFont* font = context.ui.bold();
  // In the middle of what panels leave free.
  const auto width = static_cast<float>(context.layout.scene_right());
  const float pad = static_cast<float>(8 * context.scale);
  const float line = font->FontSize;
  const std::vector<std::string> lines = broken(font, notes.back().text, 0.9f * width);
  float widest = 0;
  for (const std::string& text : lines)
    widest = std::max(widest, font->CalcTextSizeA(line, 1e6f, 0, text.c_str()).x);
  const float high = line * static_cast<float>(lines.size());
  const float middle = 0.5f * width;
  const float top = bottom - high - 2 * pad;
  context.sheet.rect({middle - 0.5f * widest - pad, top - pad},
                     {middle + 0.5f * widest + pad, top + high + pad}, style.panel, pad);
  for (std::size_t i = 0; i < lines.size(); ++i)
    context.sheet.text({middle, top + static_cast<float>(i) * line}, lines[i], style.text, line,
                       render::Face::Bold, render::Align::Centre);
}

}  // namespace

void show_header(const PanelContext& context, double speed, double footer) {
  const OverlayContext& scene = context.scene;
  const std::size_t first = context.sheet.size();
  const auto width = static_cast<float>(scene.camera.width_px);
  const auto height = static_cast<float>(scene.camera.height_px);
  const auto margin = static_cast<float>(kMarginPx * context.scale);
  // A veil keeps the words readable when bodies fly through the header.
  context.sheet.rect({0, 0}, {width, static_cast<float>(kHeaderPx * context.scale)},
                     render::faded(scene.style.halo, 0.85));

  char clock[64];
  if (speed == 1)
    std::snprintf(clock, sizeof clock, "t = %.2f s", scene.demo.shown_time());
  else
    std::snprintf(clock, sizeof clock, "t = %.3f s  (speed %g)", scene.demo.shown_time(), speed);
  ImFont* mono = context.ui.mono();
  const float clock_width = mono->CalcTextSizeA(mono->FontSize, width, 0, clock).x;
  context.sheet.text({width - margin, margin}, clock, scene.style.text_dim, mono->FontSize,
                     render::Face::Mono, render::Align::Right);

  ImFont* title = context.ui.title();
  const auto top = static_cast<float>(8 * context.scale);
  context.sheet.text({margin, top}, scene.demo.title(), scene.style.text, title->FontSize,
                     render::Face::Title);
  ImFont* regular = context.ui.regular();
  float y = top + 1.25f * title->FontSize;
  std::vector<std::string> lesson = broken(regular, scene.demo.lesson(), width - 3 * margin - clock_width);
  // The header has room for two lines.
  if (lesson.size() > 2) {
    lesson.resize(2);
    lesson.back() += " ..";
  }
  for (const std::string& text : lesson) {
    context.sheet.text({margin, y}, text, scene.style.text_dim, regular->FontSize);
    y += regular->FontSize;
  }
  show_note(context, speed, height - static_cast<float>(footer * context.scale));
  render::draw_sheet(context.sheet, first, context.sheet.size(), context.ui, *ImGui::GetBackgroundDrawList());
}

}  // namespace skerry::sandbox
