// SPDX-License-Identifier: MIT
//
// The list of demos with fuzzy search. Titles and lessons are read from the scripts when the list is first
// opened.
#include <filesystem>
#include <imgui.h>
#include <map>

#include "sandbox/window/fuzzy.h"
#include "sandbox/window/gui.h"

namespace skerry::sandbox {
namespace {

struct DemoWords {
  std::string title, lesson, all;
};

DemoWords words_of(const DemoFile& file) {
  DemoWords words;
  try {
    const Demo demo(file.path, DemoOptions{});
    words = {demo.title(), demo.lesson(), ""};
  } catch (const std::exception& error) {
    words = {file.name, error.what(), ""};
  }
  words.all = words.title + ' ' + file.topic + ' ' + words.lesson;
  return words;
}

/// Of every demo, in the order of the list; a script that does not load has its error for a lesson.
/// @param look whether scripts may have changed since the last call
std::vector<DemoWords> words_of(const std::vector<DemoFile>& demos, bool look) {
  struct Known {
    DemoWords words;
    std::filesystem::file_time_type written;
  };
  static std::map<std::string, Known> all;
  std::vector<DemoWords> words;
  for (const DemoFile& file : demos) {
    const auto found = all.find(file.path);
    std::error_code error;
    if (found == all.end() ||
        (look && found->second.written != std::filesystem::last_write_time(file.path, error))) {
      const std::filesystem::file_time_type written = std::filesystem::last_write_time(file.path, error);
      all[file.path] = {words_of(file), written};
    }
    words.push_back(all[file.path].words);
  }
  return words;
}

/// Keeps a std::string in step with an ImGui text field.
int resize(ImGuiInputTextCallbackData* data) {
  if (data->EventFlag != ImGuiInputTextFlags_CallbackResize) return 0;
  auto& text = *static_cast<std::string*>(data->UserData);
  text.resize(static_cast<std::size_t>(data->BufTextLen));
  data->Buf = text.data();
  return 0;
}

std::string topic_title(const std::string& topic) {
  std::string title = topic.empty() ? "other" : topic;
  for (char& c : title)
    if (c == '_') c = ' ';
  if (title[0] >= 'a' && title[0] <= 'z') title[0] = static_cast<char>(title[0] - 'a' + 'A');
  return title;
}

/// Title and lesson as one thing to click. @return chosen
bool entry(const Gui& gui, const DemoFile& file, const DemoWords& words, bool current) {
  const float width = ImGui::GetContentRegionAvail().x, pad = 8 * gui.scale;
  ImFont* small = gui.ui.regular();
  const float small_size = 0.86f * small->FontSize;
  const float wrap = width - 2 * pad;
  const ImVec2 lesson = words.lesson.empty()
                            ? ImVec2(0, 0)
                            : small->CalcTextSizeA(small_size, 1e6f, wrap, words.lesson.c_str());
  const float title_height = 1.25f * small->FontSize;
  const float height = title_height + lesson.y + 1.2f * pad;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const bool chosen =
      ImGui::Selectable(("##" + file.path).c_str(), current, ImGuiSelectableFlags_None, {width, height});
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->AddText(small, small->FontSize, {at.x + pad, at.y + 0.5f * pad}, pack(gui.style.text),
                words.title.c_str());
  draw->AddText(small, small_size, {at.x + pad, at.y + 0.5f * pad + title_height}, pack(gui.style.text_dim),
                words.lesson.c_str(), nullptr, wrap);
  return chosen;
}

}  // namespace

void show_demo_list(const Gui& gui) {
  Workbench& bench = gui.bench;
  Panels& panels = bench.panels;
  const std::vector<DemoFile>& demos = bench.demos();
  const std::vector<DemoWords> words = words_of(demos, panels.focus_search);
  std::vector<FuzzyItem> items;
  for (std::size_t i = 0; i < demos.size(); ++i) items.push_back({demos[i].name, words[i].all});
  begin_side_panel(gui, "Demos", 372);
  if (panels.focus_search) ImGui::SetKeyboardFocusHere();
  panels.focus_search = false;
  ImGui::SetNextItemWidth(-1);
  const bool enter = ImGui::InputTextWithHint(
      "##search", "search", panels.search.data(), panels.search.capacity() + 1,
      ImGuiInputTextFlags_CallbackResize | ImGuiInputTextFlags_EnterReturnsTrue, resize, &panels.search);
  const std::vector<std::size_t> found = fuzzy_find(panels.search, items);
  std::string chosen;
  if (enter && !found.empty()) chosen = demos[found.front()].path;
  ImGui::Dummy({0, 2 * gui.scale});
  ImGui::BeginChild("##list");
  const bool searching = panels.search.find_first_not_of(' ') != std::string::npos;
  std::string topic = "\n";
  for (const std::size_t i : found) {
    if (!searching && demos[i].topic != topic) {
      topic = demos[i].topic;
      ImGui::Dummy({0, 3 * gui.scale});
      ImGui::PushStyleColor(ImGuiCol_Text, pack(gui.style.accent));
      ImGui::TextUnformatted(topic_title(topic).c_str());
      ImGui::PopStyleColor();
    }
    const bool current = bench.has_demo() && bench.player().demo().path() == demos[i].path;
    if (entry(gui, demos[i], words[i], current)) chosen = demos[i].path;
  }
  if (found.empty()) ImGui::TextDisabled("nothing found");
  ImGui::EndChild();
  end_side_panel();
  if (!chosen.empty()) {
    panels.search.clear();
    panels.demos = false;
    bench.open(chosen);
  }
}

}  // namespace skerry::sandbox
