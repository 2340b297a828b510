// SPDX-License-Identifier: MIT
#include "sandbox/window/actions.h"

#include <cctype>

#include "sandbox/overlays/overlay.h"

namespace skerry::sandbox {
namespace {

void show_demos(Workbench& bench) {
  bench.panels.demos = !bench.panels.demos;
  bench.panels.settings = false;
  bench.panels.focus_search = bench.panels.demos;
}

void show_settings(Workbench& bench) {
  bench.panels.settings = !bench.panels.settings;
  bench.panels.demos = false;
}

void close_panels(Workbench& bench) {
  bench.panels.help = bench.panels.settings = false;
  if (bench.has_demo()) bench.panels.demos = false;
  bench.selection = {};
}

void toggle_help(Workbench& bench) {
  bench.panels.help = !bench.panels.help;
}

void toggle_theme(Workbench& bench) {
  const bool light = bench.theme() == render::Theme::Light;
  bench.set_theme(light ? render::Theme::Dark : render::Theme::Light);
}

}  // namespace

std::span<const KeyAction> actions() {
  static constexpr KeyAction kActions[] = {
      {.key = ' ', .keys = "Space", .what = "play or pause", .run = [](Workbench& b) { b.time().toggle(); }},
      {.key = render::kKeyRight,
       .repeats = true,
       .keys = "Right",
       .what = "one step on",
       .run = [](Workbench& b) { b.step(1); }},
      {.key = render::kKeyLeft,
       .repeats = true,
       .keys = "Left",
       .what = "one step back",
       .run = [](Workbench& b) { b.step(-1); }},
      {.key = render::kKeyRight,
       .shift = true,
       .repeats = true,
       .keys = "Shift Right",
       .what = "ten steps on",
       .run = [](Workbench& b) { b.step(10); }},
      {.key = render::kKeyLeft,
       .shift = true,
       .repeats = true,
       .keys = "Shift Left",
       .what = "ten steps back",
       .run = [](Workbench& b) { b.step(-10); }},
      {.key = render::kKeyHome,
       .keys = "Home",
       .what = "to the beginning",
       .run = [](Workbench& b) { b.scrub(0); }},
      {.key = render::kKeyEnd,
       .keys = "End",
       .what = "to the last state that is known",
       .run =
           [](Workbench& b) {
             if (b.has_demo()) b.scrub(b.player().end());
           }},
      {.key = render::kKeyUp,
       .keys = "Up",
       .what = "twice as fast",
       .run = [](Workbench& b) { b.time().faster(); }},
      {.key = render::kKeyDown,
       .keys = "Down",
       .what = "half as fast",
       .run = [](Workbench& b) { b.time().slower(); }},
      {.key = render::kKeyTab, .keys = "Tab", .what = "list of demos, with search", .run = show_demos},
      {.key = render::kKeyEnter,
       .keys = "Enter",
       .what = "parameters, methods, overlays",
       .run = show_settings},
      {.key = render::kKeyF1, .keys = "F1 or ?", .what = "this help", .run = toggle_help},
      {.key = '?', .keys = "", .what = "", .run = toggle_help},
      {.key = render::kKeyF1 + 3, .keys = "F4", .what = "light or dark", .run = toggle_theme},
      {.key = render::kKeyF1 + 4,
       .keys = "F5",
       .what = "load the script again (saving it does so, too)",
       .run = [](Workbench& b) { b.restart(); }},
      {.key = render::kKeyF1 + 5,
       .keys = "F6",
       .what = "ghost: the same scene with other methods",
       .run = [](Workbench& b) { b.toggle_ghost(); }},
      {.key = render::kKeyF1 + 6,
       .keys = "F7",
       .what = "hold the selected body where it is, or let it go",
       .run = [](Workbench& b) { b.hold_selected(); }},
      {.key = render::kKeyF1 + 7,
       .keys = "F8",
       .what = "save the session (skerry replay)",
       .run = [](Workbench& b) { b.save_recording(); }},
      {.key = render::kKeyF1 + 8,
       .keys = "F9",
       .what = "record a video, or end it",
       .run = [](Workbench& b) { b.record_video = !b.record_video; }},
      {.key = render::kKeyF1 + 11,
       .keys = "F12",
       .what = "screenshot",
       .run = [](Workbench& b) { b.take_screenshot = true; }},
      {.key = '0',
       .keys = "0",
       .what = "the demo's own view",
       .run = [](Workbench& b) { b.fit_view = true; }},
      {.key = '1',
       .keys = "1 2 3 4",
       .what = "right click makes discs, boxes, capsules, hexagons",
       .run = [](Workbench& b) { b.spawn_kind = SpawnKind::Disc; }},
      {.key = '2', .keys = "", .what = "", .run = [](Workbench& b) { b.spawn_kind = SpawnKind::Box; }},
      {.key = '3', .keys = "", .what = "", .run = [](Workbench& b) { b.spawn_kind = SpawnKind::Capsule; }},
      {.key = '4', .keys = "", .what = "", .run = [](Workbench& b) { b.spawn_kind = SpawnKind::Hexagon; }},
      {.key = render::kKeyDelete,
       .keys = "Delete",
       .what = "remove the selected body",
       .run = [](Workbench& b) { b.remove_selected(); }},
      {.key = 'Q',
       .ctrl = true,
       .keys = "Ctrl Q",
       .what = "quit",
       .run = [](Workbench& b) { b.quit = true; }},
      {.key = render::kKeyEscape,
       .keys = "Escape",
       .what = "close panels, select nothing",
       .run = close_panels},
  };
  return kActions;
}

bool press(Workbench& workbench, const render::KeyPress& key) {
  if (key.alt) return false;
  for (const KeyAction& action : actions()) {
    if (action.key != key.key || action.ctrl != key.ctrl || action.shift != key.shift) continue;
    if (!key.repeated || action.repeats) action.run(workbench);
    return true;
  }
  if (key.ctrl || key.shift || key.repeated || key.key > 127) return false;
  for (const Overlay& overlay : overlays()) {
    if (overlay.key == 0 || std::toupper(overlay.key) != key.key) continue;
    workbench.toggle_overlay(std::string(overlay.name));
    return true;
  }
  return false;
}

std::string keys_table() {
  std::string table = "| key | |\n| --- | --- |\n";
  const auto row = [&](std::string_view keys, std::string_view what) {
    table += "| " + std::string(keys) + " | " + std::string(what) + " |\n";
  };
  row("left button",
      "on a body: drag it; on a contact with the matrix open: its row and column; elsewhere: move the view");
  row("right button", "a new body; drag: move the view");
  row("wheel", "zoom");
  for (const KeyAction& action : actions())
    if (!action.keys.empty()) row(action.keys, action.what);
  for (const Overlay& overlay : overlays()) {
    if (overlay.key == 0) continue;
    const char letter[] = {static_cast<char>(std::toupper(overlay.key)), '\0'};
    row(letter, std::string(overlay.name) + ": " + std::string(overlay.summary));
  }
  return table;
}

}  // namespace skerry::sandbox
