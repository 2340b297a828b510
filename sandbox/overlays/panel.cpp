// SPDX-License-Identifier: MIT
#include "sandbox/overlays/panel.h"

#include <cmath>
#include <cstdio>
#include <imgui.h>

#include "render/ui_host.h"

namespace skerry::sandbox {

Panel::Panel(const PanelContext& context, const char* title, double height)
    : context_(context), height_(height), first_(context.sheet.size()) {
  const double outer = height + kPanelTitlePx + kPanelPadPx;
  const PanelLayout::Position place = context.layout.place(context.place, outer);
  const double scale = context.scale;
  const auto x = static_cast<float>(place.x), y = static_cast<float>(place.y);
  const auto wide = static_cast<float>(kColumnPx * scale), high = static_cast<float>(outer * scale);
  // The window takes the mouse; its frame and all marks are ours, so that figures show the same.
  ImGui::SetNextWindowPos({x, y});
  ImGui::SetNextWindowSize({wide, high});
  ImGui::Begin(title, nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBackground);
  x_ = place.x + kPanelPadPx * scale;
  y_ = place.y + kPanelTitlePx * scale;
  const render::Style& style = context.scene.style;
  const auto rounding = static_cast<float>(6 * scale);
  context.sheet.rect({x, y}, {x + wide, y + high}, style.panel, rounding);
  context.sheet.frame({x, y}, {x + wide, y + high}, style.panel_border,
                      std::max(1.0f, std::round(static_cast<float>(scale))), rounding);
  // ImGui's name of the window may go on after ###.
  const std::string name = title;
  text(0, 8 - kPanelTitlePx, style.text, name.substr(0, name.find("###")), render::Face::Bold);
}

Panel::~Panel() {
  // The frame lies where ImGui keeps its own padding.
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.PushClipRectFullScreen();
  render::draw_sheet(context_.sheet, first_, context_.sheet.size(), context_.ui, list);
  list.PopClipRect();
  ImGui::End();
}

render::Pixel Panel::at(double x, double y) const {
  return {static_cast<float>(x_ + x * context_.scale), static_cast<float>(y_ + y * context_.scale)};
}

void Panel::text(double x, double y, render::Color color, const std::string& words, render::Face face,
                 render::Align align, double line) const {
  // Whole pixels: fonts are baked for them.
  context_.sheet.text(at(x, y), words, color, static_cast<float>(std::round(line * context_.scale)), face,
                      align);
}

double Panel::text_width(const std::string& words, double line) const {
  const auto size = static_cast<float>(std::round(line * context_.scale));
  return static_cast<double>(context_.ui.regular()->CalcTextSizeA(size, 1e6f, 0, words.c_str()).x) /
         context_.scale;
}

namespace {

bool goes_on(char byte) {
  return (static_cast<unsigned char>(byte) & 0xc0) == 0x80;
}

// Takes one character away, all bytes of it.
void pop_character(std::string& text) {
  while (text.size() > 1 && goes_on(text.back())) text.pop_back();
  if (!text.empty()) text.pop_back();
}

// The same at the front.
void pop_front_character(std::string& text) {
  std::size_t bytes = 1;
  while (bytes < text.size() && goes_on(text[bytes])) ++bytes;
  text.erase(0, bytes);
}

}  // namespace

void Panel::fitted(double x, double y, double width, render::Color color, const std::string& words) const {
  if (text_width(words) <= width) {
    text(x, y, color, words);
    return;
  }
  std::string cut = words;
  while (cut.size() > 1 && text_width(cut + "..") > width) pop_character(cut);
  text(x, y, color, cut + "..");
}

void Panel::squeezed(double x, double y, double width, render::Color color, const std::string& words) const {
  std::size_t place = words.rfind(' ');
  if (place == std::string::npos) place = words.size() / 2;
  while (place < words.size() && goes_on(words[place])) ++place;
  std::string head = words.substr(0, place), tail = words.substr(place);
  std::string cut = words;
  while (text_width(cut) > width && head.size() + tail.size() > 2) {
    if (head.size() + 1 >= tail.size())
      pop_character(head);
    else
      pop_front_character(tail);
    cut = head;
    cut += "..";
    cut += tail;
  }
  text(x, y, color, cut);
}

std::vector<std::string> Panel::wrapped(const std::string& words, double width, std::size_t lines) const {
  std::vector<std::string> result;
  std::string line;
  for (std::size_t i = 0; i < words.size();) {
    const std::size_t end = std::min(words.find(' ', i), words.size());
    const std::string word = words.substr(i, end - i);
    i = end + 1;
    const std::string longer = line.empty() ? word : line + ' ' + word;
    if (line.empty() || text_width(longer) <= width) {
      line = longer;
      continue;
    }
    if (result.size() + 1 == lines) {
      while (line.size() > 1 && text_width(line + "..") > width) pop_character(line);
      result.push_back(line + "..");
      return result;
    }
    result.push_back(line);
    line = word;
  }
  if (!line.empty()) result.push_back(line);
  return result;
}

void Panel::rect(double x, double y, double width, double height, render::Color fill, double rounding) const {
  context_.sheet.rect(at(x, y), at(x + width, y + height), fill,
                      static_cast<float>(rounding * context_.scale));
}

void Panel::frame(double x, double y, double width, double height, render::Color color, double line) const {
  context_.sheet.frame(at(x, y), at(x + width, y + height), color, static_cast<float>(line * context_.scale));
}

void Panel::line(double x0, double y0, double x1, double y1, render::Color color, double width) const {
  context_.sheet.line(at(x0, y0), at(x1, y1), color, static_cast<float>(width * context_.scale));
}

void Panel::triangle(double x0, double y0, double x1, double y1, double x2, double y2,
                     render::Color fill) const {
  const render::Pixel corners[] = {at(x0, y0), at(x1, y1), at(x2, y2)};
  context_.sheet.fill(corners, 3, fill);
}

void Panel::curve(const std::vector<render::Pixel>& points, render::Color color, double width) const {
  context_.sheet.polyline(points.data(), points.size(), color, static_cast<float>(width * context_.scale));
}

bool Panel::hovered(double& x, double& y) const {
  if (!ImGui::IsWindowHovered()) return false;
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  x = (static_cast<double>(mouse.x) - x_) / context_.scale;
  y = (static_cast<double>(mouse.y) - y_) / context_.scale;
  return true;
}

bool Panel::clicked() const {
  return ImGui::IsWindowHovered() && ImGui::IsMouseClicked(0);
}

std::string si(double value, const char* unit) {
  if (!(std::abs(value) >= 1e-13)) return std::string("0 ") + unit;
  if (!std::isfinite(value)) return std::string("infinite ") + unit;
  constexpr const char* kPrefixes[] = {"p", "n", "\xC2\xB5", "m", "", "k", "M", "G", "T"};
  const double size = std::abs(value);
  int third = static_cast<int>(std::floor(std::log10(size) / 3 + 1e-12));
  third = std::max(-4, std::min(4, third));
  char text[48];
  std::snprintf(text, sizeof text, "%.3g %s", value / std::pow(1000.0, third), kPrefixes[third + 4]);
  return std::string(text) + unit;
}

}  // namespace skerry::sandbox
