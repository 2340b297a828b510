// SPDX-License-Identifier: MIT
//
// Title and lesson at the top, the time at the right, the script's latest note above the footer.
#include <algorithm>
#include <cstdio>
#include <imgui.h>

#include "render/ui_host.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr double kNoteSeconds = 3;  // of the video

// Breaks `words` into lines of at most `width` pixels, `size` of the font's size.
std::vector<std::string> broken(ImFont* font, const std::string& words, float width, float size = 1) {
  std::vector<std::string> lines;
  const char* at = words.c_str();
  const char* end = at + words.size();
  while (at < end) {
    const char* next = std::max(font->CalcWordWrapPositionA(size, at, end, width), at + 1);
    lines.emplace_back(at, next);
    at = next;
    while (at < end && *at == ' ') ++at;
  }
  return lines;
}

// A title that is too long for its line is smaller, down to the size of other text, and then cut.
void show_title(const PanelContext& context, float left, float top, float width) {
  ImFont* font = context.ui.title();
  std::string words = context.scene.demo.title();
  const auto needs = [&] { return font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str()).x; };
  const float least = context.ui.regular()->FontSize / font->FontSize;
  const float size = std::clamp(width / std::max(needs(), 1.0f), least, 1.0f);
  if (size * needs() > 1.001f * width) {
    const std::vector<std::string> lines = broken(font, words, 0.95f * width, size);
    words = lines.front() + " ..";
  }
  const float smaller = font->FontSize * (1 - size);
  context.sheet.text({left, top + 0.8f * smaller}, words, context.scene.style.text, size * font->FontSize,
                     render::Face::Title);
}

/// The lesson's lines and the size of their text, in units of the font's.
struct Lesson {
  std::vector<std::string> lines;
  float size = 1;
};

// The header has room for two lines beside the clock; where they are too short, for two below it, or three
// of smaller text.
Lesson lesson_of(const PanelContext& context, float beside, float whole) {
  ImFont* font = context.ui.regular();
  const std::string& words = context.scene.demo.lesson();
  Lesson lesson{broken(font, words, beside)};
  if (lesson.lines.size() <= 2) return lesson;
  lesson.lines = broken(font, words, whole);
  if (lesson.lines.size() <= 2) return lesson;
  lesson.size = 0.8f;
  lesson.lines = broken(font, words, whole, lesson.size);
  if (lesson.lines.size() > 3) {
    lesson.lines.resize(3);
    lesson.lines.back() += " ..";
  }
  return lesson;
}

float show_note(const PanelContext& context, double speed, float bottom,
                const std::vector<PixelBox>& legend) {
  const std::vector<Note>& notes = context.scene.demo.notes();
  if (notes.empty() || context.scene.demo.time() - notes.back().time > kNoteSeconds * speed) return bottom;
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
  for (const PixelBox& box : legend)
    if (box.left < static_cast<double>(middle + 0.5f * widest + pad) &&
        box.right > static_cast<double>(middle - 0.5f * widest - pad))
      bottom = std::min(bottom, static_cast<float>(box.top));
  const float top = bottom - high - 2 * pad;
  context.sheet.rect({middle - 0.5f * widest - pad, top - pad},
                     {middle + 0.5f * widest + pad, top + high + pad}, style.panel, pad);
  for (std::size_t i = 0; i < lines.size(); ++i)
    context.sheet.text({middle, top + static_cast<float>(i) * line}, lines[i], style.text, line,
                       render::Face::Bold, render::Align::Centre);
  return top - pad;
}

}  // namespace

float show_header(const PanelContext& context, double speed, double footer,
                  const std::vector<PixelBox>& legend) {
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

  const auto top = static_cast<float>(8 * context.scale);
  show_title(context, margin, top, width - 3 * margin - clock_width);
  const float line = context.ui.regular()->FontSize;
  float y = top + 1.25f * context.ui.title()->FontSize;
  const Lesson lesson = lesson_of(context, width - 3 * margin - clock_width, width - 2 * margin);
  for (const std::string& text : lesson.lines) {
    context.sheet.text({margin, y}, text, scene.style.text_dim, lesson.size * line);
    y += lesson.size * line;
  }
  const float note = show_note(context, speed, height - static_cast<float>(footer * context.scale), legend);
  render::draw_sheet(context.sheet, first, context.sheet.size(), context.ui, *ImGui::GetBackgroundDrawList());
  return note;
}

}  // namespace skerry::sandbox
