// SPDX-License-Identifier: MIT
#include "sandbox/overlays/panel.h"

#include "render/ui_host.h"

namespace skerry::sandbox {
namespace {

constexpr double kTitlePx = 30;
constexpr double kPadPx = 12;

}  // namespace

Panel::Panel(const PanelContext& context, const char* title, double height)
    : standard_(context.ui.regular()) {
  const double scale = context.scale;
  const double outer = (height + kTitlePx + kPadPx) * scale;
  const PanelLayout::Position at = context.layout.next(outer);
  const auto pad = static_cast<float>(kPadPx * scale);
  const render::Style& style = context.scene.style;
  ImGui::SetNextWindowPos({static_cast<float>(at.x), static_cast<float>(at.y)});
  ImGui::SetNextWindowSize({static_cast<float>(kColumnPx * scale), static_cast<float>(outer)});
  ImGui::Begin(title, nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoFocusOnAppearing);
  draw_ = ImGui::GetWindowDrawList();
  x_ = static_cast<float>(at.x) + pad;
  y_ = static_cast<float>(at.y + kTitlePx * scale);
  width_ = static_cast<float>(kColumnPx * scale) - 2 * pad;
  height_ = static_cast<float>(height * scale);
  text(x_, static_cast<float>(at.y + 8 * scale), style.text, title, context.ui.bold());
}

Panel::~Panel() {
  ImGui::End();
}

void Panel::text(float x, float y, render::Color color, const std::string& words, ImFont* font) const {
  if (!font) font = standard_;
  draw_->AddText(font, font->FontSize, {x, y}, pack(color), words.c_str());
}

void Panel::text_right(float right, float y, render::Color color, const std::string& words,
                       ImFont* font) const {
  if (!font) font = standard_;
  text(right - font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str()).x, y, color, words, font);
}

void Panel::text_centred(float x, float y, render::Color color, const std::string& words,
                         ImFont* font) const {
  if (!font) font = standard_;
  const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str());
  text(x - 0.5f * size.x, y - 0.5f * size.y, color, words, font);
}

}  // namespace skerry::sandbox
