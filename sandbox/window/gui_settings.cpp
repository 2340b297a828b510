// SPDX-License-Identifier: MIT
//
// Parameters of the demo, the methods that run it, a ghost with others, overlays and what right clicks make.
#include <cctype>
#include <cmath>
#include <cstdio>
#include <imgui.h>

#include "physics/broadphase/broadphase.h"
#include "physics/solver/impact_law.h"
#include "physics/solver/solver.h"
#include "physics/stepping/stepper.h"
#include "sandbox/lua_args.h"
#include "sandbox/overlays/overlay.h"
#include "sandbox/window/gui.h"

namespace skerry::sandbox {
namespace {

void heading(const Gui& gui, const char* text) {
  ImGui::Dummy({0, 5 * gui.scale});
  ImGui::PushStyleColor(ImGuiCol_Text, pack(gui.style.accent));
  ImGui::TextUnformatted(text);
  ImGui::PopStyleColor();
}

/// A slider that counts when it is let go, so that the scene is not made anew at every pixel.
void parameter(const Gui& gui, const Parameter& parameter) {
  static std::string moving;
  static double value = 0;
  ImGui::PushID(parameter.name.c_str());
  if (!parameter.choices.empty()) {
    if (ImGui::BeginCombo(parameter.name.c_str(), parameter.text().c_str())) {
      for (const std::string& choice : parameter.choices)
        if (ImGui::Selectable(choice.c_str(), choice == parameter.text()))
          gui.bench.set_parameter(parameter.name, choice);
      ImGui::EndCombo();
    }
    ImGui::PopID();
    return;
  }
  double shown = moving == parameter.name ? value : parameter.value;
  const bool wide = parameter.low > 0 && parameter.high / parameter.low > 500;
  std::string format = "%.4g";
  if (!parameter.unit.empty()) format.append(" ").append(parameter.unit);
  // The value stands beside the slider, where the knob does not hide it. Ctrl and a click take a number.
  ImGui::SliderScalar("##slider", ImGuiDataType_Double, &shown, &parameter.low, &parameter.high,
                      ImGui::GetIO().KeyCtrl ? format.c_str() : "",
                      wide ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None);
  const bool active = ImGui::IsItemActive();
  char words[80];
  std::snprintf(words, sizeof words, format.c_str(), shown);
  ImGui::SameLine();
  ImGui::Text("%s = %s", parameter.name.c_str(), words);
  if (active) {
    moving = parameter.name;
    value = shown;
  } else if (moving == parameter.name) {
    moving.clear();
    if (value != parameter.value) {
      // A whole default and bounds mean a number of things.
      const bool whole = std::floor(parameter.standard) == parameter.standard &&
                         std::floor(parameter.low) == parameter.low && parameter.high - parameter.low <= 1000;
      const double chosen = whole ? std::round(value) : std::stod(format_number(value));
      gui.bench.set_parameter(parameter.name, format_number(chosen));
    }
  }
  ImGui::PopID();
}

template <class Rows>
bool choose(const char* label, std::string& name, const Rows& rows) {
  bool changed = false;
  if (!ImGui::BeginCombo(label, name.c_str())) return false;
  for (const auto& row : rows) {
    const std::string candidate(row.name);
    if (ImGui::Selectable(candidate.c_str(), candidate == name) && candidate != name) {
      name = candidate;
      changed = true;
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", std::string(row.summary).c_str());
  }
  ImGui::EndCombo();
  return changed;
}

bool choose_methods(Methods& methods) {
  const bool solver = choose("solver", methods.solver, solvers());
  const bool stepper = choose("stepper", methods.stepper, steppers());
  const bool broad_phase = choose("broad phase", methods.broad_phase, broad_phases());
  const bool law = choose("impact law", methods.impact_law, impact_laws());
  return solver || stepper || broad_phase || law;
}

void show_ghost(const Gui& gui) {
  Workbench& bench = gui.bench;
  bool on = bench.has_ghost();
  if (ImGui::Checkbox("ghost: the same scene with other methods", &on)) bench.toggle_ghost();
  if (!bench.has_ghost()) return;
  ImGui::PushID("ghost");
  Methods methods = bench.ghost_methods();
  if (choose_methods(methods)) bench.set_ghost(methods);
  ImGui::PopID();
  ImGui::TextDisabled("farthest from its ghost: %.3g m", bench.ghost_distance());
}

void show_overlays(const Gui& gui) {
  for (const Overlay& overlay : overlays()) {
    const std::string name(overlay.name);
    bool on = gui.bench.shows(name);
    if (ImGui::Checkbox(name.c_str(), &on)) gui.bench.toggle_overlay(name);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", std::string(overlay.summary).c_str());
    if (overlay.key == 0) continue;
    ImGui::SameLine(0.46f * ImGui::GetWindowWidth());
    ImGui::TextDisabled("%c", std::toupper(overlay.key));
  }
}

}  // namespace

void show_settings(const Gui& gui) {
  Workbench& bench = gui.bench;
  begin_side_panel(gui, "Settings", 372);
  ImGui::BeginChild("##settings");
  ImGui::PushItemWidth(0.56f * ImGui::GetContentRegionAvail().x);
  if (bench.has_demo()) {
    // A copy: setting one makes the demo anew.
    const std::vector<Parameter> parameters = bench.player().demo().parameters();
    if (!parameters.empty()) {
      heading(gui, "Parameters (start again)");
      for (const Parameter& each : parameters) parameter(gui, each);
    }
    heading(gui, "Methods (from now on)");
    Methods methods = methods_of(bench.player().demo().world());
    if (choose_methods(methods)) bench.set_methods(methods);
    heading(gui, "Compare");
    show_ghost(gui);
    heading(gui, "Right click makes");
    for (int i = 0; i < kSpawnKinds; ++i) {
      const auto kind = static_cast<SpawnKind>(i);
      if (i > 0) ImGui::SameLine();
      if (ImGui::RadioButton(std::string(to_string(kind)).c_str(), bench.spawn_kind == kind))
        bench.spawn_kind = kind;
    }
  }
  heading(gui, "Overlays");
  show_overlays(gui);
  heading(gui, "Look");
  const bool light = bench.theme() == render::Theme::Light;
  if (ImGui::RadioButton("light", light)) bench.set_theme(render::Theme::Light);
  ImGui::SameLine();
  if (ImGui::RadioButton("dark", !light)) bench.set_theme(render::Theme::Dark);
  ImGui::PopItemWidth();
  ImGui::EndChild();
  end_side_panel();
}

}  // namespace skerry::sandbox
