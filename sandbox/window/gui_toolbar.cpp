// SPDX-License-Identifier: MIT
//
// The bar at the bottom: play, step, speed, the timeline with its marks, and buttons for the panels.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <imgui.h>

#include "sandbox/window/gui.h"

namespace skerry::sandbox {
namespace {

enum class Icon { Play, Pause, Next, Back, First };

/// Icons are drawn, not letters: sharp at every scale, the same in every font.
void draw_icon(ImDrawList* draw, Icon icon, ImVec2 c, float r, ImU32 color) {
  const auto right = [&](float x) {
    draw->AddTriangleFilled({x - 0.7f * r, c.y - r}, {x + r, c.y}, {x - 0.7f * r, c.y + r}, color);
  };
  const auto left = [&](float x) {
    draw->AddTriangleFilled({x + 0.7f * r, c.y - r}, {x + 0.7f * r, c.y + r}, {x - r, c.y}, color);
  };
  const auto bar = [&](float x, float w) { draw->AddRectFilled({x - w, c.y - r}, {x + w, c.y + r}, color); };
  switch (icon) {
    case Icon::Play:
      right(c.x);
      break;
    case Icon::Pause:
      bar(c.x - 0.5f * r, 0.28f * r);
      bar(c.x + 0.5f * r, 0.28f * r);
      break;
    case Icon::Next:
      right(c.x - 0.25f * r);
      bar(c.x + r, 0.2f * r);
      break;
    case Icon::Back:
      left(c.x + 0.25f * r);
      bar(c.x - r, 0.2f * r);
      break;
    case Icon::First:
      left(c.x - 0.35f * r);
      left(c.x + 0.95f * r);
      bar(c.x - 1.45f * r, 0.2f * r);
      break;
  }
}

void tooltip(const char* text) {
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", text);
}

/// A round button. @return pressed
bool icon_button(const Gui& gui, const char* id, Icon icon, float radius, bool filled, const char* hint) {
  const float side = 2 * radius * gui.scale;
  const bool pressed = ImGui::InvisibleButton(id, {side, side});
  const ImVec2 low = ImGui::GetItemRectMin();
  const ImVec2 c(low.x + 0.5f * side, low.y + 0.5f * side);
  const bool hot = ImGui::IsItemHovered(), down = ImGui::IsItemActive();
  const render::Style& style = gui.style;
  ImDrawList* draw = ImGui::GetWindowDrawList();
  if (filled)
    draw->AddCircleFilled(c, radius * gui.scale,
                          pack(hot ? render::mixed(style.accent, style.text, 0.18) : style.accent), 32);
  else if (hot || down)
    draw->AddCircleFilled(c, radius * gui.scale,
                          pack(render::mixed(style.panel, style.accent, down ? 0.45 : 0.22)), 32);
  const render::Color ink = filled ? style.panel : style.text;
  draw_icon(draw, icon, c, (filled ? 0.42f : 0.36f) * radius * gui.scale, pack({ink.r, ink.g, ink.b, 255}));
  tooltip(hint);
  return pressed;
}

bool text_button(const Gui& gui, const char* label, bool on, const char* hint) {
  if (on) ImGui::PushStyleColor(ImGuiCol_Button, pack(render::mixed(gui.style.panel, gui.style.accent, 0.3)));
  const bool pressed = ImGui::Button(label, {0, 30 * gui.scale});
  if (on) ImGui::PopStyleColor();
  tooltip(hint);
  return pressed;
}

std::string speed_text(double speed) {
  char text[16];
  if (speed < 1)
    std::snprintf(text, sizeof text, "1/%d", static_cast<int>(std::lround(1 / speed)));
  else
    std::snprintf(text, sizeof text, "%g", speed);
  return std::string(text) + " \xC3\x97";
}

/// Where the mouse is on the timeline, with what happened there.
void timeline_tooltip(const Gui& gui, double at, double reach) {
  const Player& player = gui.bench.player();
  const double dt = player.demo().dt();
  char line[160];
  std::snprintf(line, sizeof line, "%.2f s, step %lld", at * dt, static_cast<long long>(std::llround(at)));
  std::string text = line;
  for (const Note& note : player.demo().notes()) {
    if (std::abs(note.time / dt - at) < reach) text.append("\n").append(note.text);
  }
  const auto inputs = std::count_if(
      player.inputs().begin(), player.inputs().end(),
      [&](const UserInput& input) { return std::abs(static_cast<double>(input.step) - at) < reach; });
  if (inputs > 0) {
    std::snprintf(line, sizeof line, "\n%d %s", static_cast<int>(inputs), inputs == 1 ? "input" : "inputs");
    text += line;
  }
  ImGui::SetTooltip("%s", text.c_str());
}

/// Known states filled, unknown ones open, notes as ticks above, inputs as dots below, a knob where we are.
void show_timeline(const Gui& gui, float width) {
  Workbench& bench = gui.bench;
  const Player& player = bench.player();
  const render::Style& style = gui.style;
  const float height = 34 * gui.scale;
  ImGui::InvisibleButton("##timeline", {std::max(20.0f, width), height});
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  const float pad = 8 * gui.scale, left = low.x + pad, right = high.x - pad, y = 0.5f * (low.y + high.y);
  const auto last = static_cast<double>(std::max(player.end(), player.demo().total_steps()));
  const auto place = [&](double step) {
    return left + (right - left) * static_cast<float>(last > 0 ? step / last : 0);
  };
  const auto step_at = [&](float x) {
    return std::clamp(static_cast<double>((x - left) / std::max(1.0f, right - left)), 0.0, 1.0) * last;
  };
  const float mouse = ImGui::GetIO().MousePos.x;
  if (ImGui::IsItemActive()) bench.scrub(static_cast<std::uint64_t>(std::llround(step_at(mouse))));
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const float thick = 3 * gui.scale;
  const auto track = [&](float from, float to, render::Color color) {
    draw->AddRectFilled({from, y - thick}, {to, y + thick}, pack(color), thick);
  };
  const auto now = static_cast<double>(player.step());
  track(left, right, render::mixed(style.panel, style.text, 0.12));
  track(left, place(static_cast<double>(player.end())), render::mixed(style.panel, style.accent, 0.4));
  track(left, place(now), style.accent);
  for (const Note& note : player.demo().notes()) {
    const float x = place(note.time / player.demo().dt());
    draw->AddRectFilled({x - gui.scale, y - 12 * gui.scale}, {x + gui.scale, y - 5 * gui.scale},
                        pack(style.text_dim));
  }
  float drawn = -1e9f;
  for (const UserInput& input : player.inputs()) {
    const float x = place(static_cast<double>(input.step));
    if (x < drawn + 3 * gui.scale) continue;
    draw->AddCircleFilled({x, y + 9 * gui.scale}, 2 * gui.scale, pack(style.impulse));
    drawn = x;
  }
  const bool hot = ImGui::IsItemHovered() || ImGui::IsItemActive();
  const float knob = (hot ? 8.0f : 7.0f) * gui.scale;
  draw->AddCircleFilled({place(now), y}, knob, pack(style.accent), 24);
  draw->AddCircleFilled({place(now), y}, 0.45f * knob, pack(style.panel), 24);
  if (hot) timeline_tooltip(gui, step_at(mouse), 5 * gui.scale * last / std::max(1.0f, right - left));
}

void show_time(const Gui& gui, float width) {
  const Player& player = gui.bench.player();
  char text[64];
  std::snprintf(text, sizeof text, "%.2f / %.4g s", player.demo().time(), player.demo().seconds());
  ImFont* font = gui.ui.mono();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e6f, 0, text);
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const float line = 30 * gui.scale;
  draw->AddText(font, font->FontSize, {at.x + 0.5f * (width - size.x), at.y + 0.5f * (line - size.y)},
                pack(player.divergence() ? gui.style.warning : gui.style.text), text);
  ImGui::Dummy({width, line});
  tooltip(player.divergence() ? "a state came out differently when it was made again"
                              : "time; every state is reached again bit by bit");
}

/// To the middle line of a row of the toolbar, for something so high.
void centre(const Gui& gui, double height_px, int row) {
  ImGui::SetCursorPosY(static_cast<float>(0.5 * (kToolbarPx - height_px) + row * kToolbarRowPx) * gui.scale);
}

constexpr float kEdgePx = 12, kGapPx = 6, kTimePx = 136;
// Room for the buttons at the right, and what is left for them in a narrow window.
constexpr float kButtonsPx = 236, kTightButtonsPx = 190;

void show_steps(const Gui& gui, int row) {
  Workbench& bench = gui.bench;
  centre(gui, 30, row);
  if (icon_button(gui, "##first", Icon::First, 15, false, "to the beginning (Home)")) bench.scrub(0);
  ImGui::SameLine();
  centre(gui, 30, row);
  if (icon_button(gui, "##back", Icon::Back, 15, false, "one step back (Left)")) bench.step(-1);
  ImGui::SameLine();
  centre(gui, 38, row);
  const bool playing = bench.time().playing();
  if (icon_button(gui, "##play", playing ? Icon::Pause : Icon::Play, 19, true, "play or pause (Space)"))
    bench.time().toggle();
  ImGui::SameLine();
  centre(gui, 30, row);
  if (icon_button(gui, "##next", Icon::Next, 15, false, "one step on (Right)")) bench.step(1);
}

void show_speed(const Gui& gui, int row) {
  Workbench& bench = gui.bench;
  centre(gui, 30, row);
  if (text_button(gui, "\xE2\x88\x92", false, "half as fast (Down)")) bench.time().slower();
  ImGui::SameLine(0, 2 * gui.scale);
  centre(gui, 30, row);
  const std::string speed = speed_text(bench.time().speed());
  if (ImGui::Button((speed + "##speed").c_str(), {54 * gui.scale, 30 * gui.scale})) bench.time().normal();
  tooltip("speed; a click makes it 1");
  ImGui::SameLine(0, 2 * gui.scale);
  centre(gui, 30, row);
  if (text_button(gui, "+", false, "twice as fast (Up)")) bench.time().faster();
}

/// At the right edge.
void show_buttons(const Gui& gui, int row) {
  const float demos = ImGui::CalcTextSize("Demos").x, settings = ImGui::CalcTextSize("Settings").x,
              help = ImGui::CalcTextSize("?").x, frame = 2 * ImGui::GetStyle().FramePadding.x;
  ImGui::SetCursorPosX(gui.width - demos - settings - help - 3 * frame - (kEdgePx + 2 * kGapPx) * gui.scale);
  centre(gui, 30, row);
  Panels& panels = gui.bench.panels;
  if (text_button(gui, "Demos", panels.demos, "all demos (Tab)")) {
    panels.demos = panels.focus_search = !panels.demos;
    panels.settings = false;
  }
  ImGui::SameLine();
  centre(gui, 30, row);
  if (text_button(gui, "Settings", panels.settings, "parameters, methods, overlays (Enter)")) {
    panels.settings = !panels.settings;
    panels.demos = false;
  }
  ImGui::SameLine();
  centre(gui, 30, row);
  if (text_button(gui, "?", panels.help, "keys (F1)")) panels.help = !panels.help;
}

/// The timeline up to so far from the right edge.
void show_timeline_before(const Gui& gui, float right_px, int row) {
  centre(gui, 34, row);
  show_timeline(gui, gui.width - ImGui::GetCursorPosX() - right_px * gui.scale);
}

/// All in a row; in narrow windows in two, the timeline above the controls of time; in very narrow ones in
/// three.
void show_controls(const Gui& gui) {
  const int rows = gui.fit.rows;
  const float gap = kGapPx * gui.scale, apart = 2 * gap;
  if (rows > 1) {
    show_timeline_before(gui, rows == 2 ? kTightButtonsPx : kEdgePx, 0);
    if (rows == 2) {
      ImGui::SameLine();
      show_buttons(gui, 0);
    }
  }
  const int row = rows == 1 ? 0 : 1;
  show_steps(gui, row);
  ImGui::SameLine(0, apart);
  show_speed(gui, row);
  if (rows == 1) {
    ImGui::SameLine(0, apart);
    show_timeline_before(gui, kTimePx + kButtonsPx + 3 * kGapPx, 0);
  }
  if (rows < 3) {
    ImGui::SameLine();
    // At the right edge of its row.
    if (rows == 2) ImGui::SetCursorPosX(gui.width - (kTimePx + kEdgePx) * gui.scale);
  }
  centre(gui, 30, rows - 1);
  show_time(gui, kTimePx * gui.scale);
  if (rows == 2) return;
  ImGui::SameLine();
  show_buttons(gui, rows - 1);
}

}  // namespace

void show_toolbar(const Gui& gui) {
  const float height = static_cast<float>(gui.fit.toolbar_px()) * gui.scale;
  // Whole pixels, and its frame outside at three sides.
  const float top = std::floor(gui.height - height);
  ImGui::SetNextWindowPos({-1, top});
  ImGui::SetNextWindowSize({gui.width + 2, gui.height - top + 1});
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(kEdgePx * gui.scale, 0));
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, ImVec2(kGapPx * gui.scale, 0));
  ImGui::Begin("##toolbar", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoBringToFrontOnFocus);
  if (gui.bench.has_demo())
    show_controls(gui);
  else
    show_buttons(gui, 0);
  ImGui::End();
  ImGui::PopStyleVar(3);
}

}  // namespace skerry::sandbox
