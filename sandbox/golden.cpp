// SPDX-License-Identifier: MIT
#include "sandbox/golden.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "render/error.h"
#include "sandbox/cli.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/history.h"
#include "sandbox/loop.h"
#include "sandbox/report.h"

namespace skerry::sandbox {
namespace fs = std::filesystem;
namespace {

constexpr const char* kSize = "640x360";  // readable, and small in the repository

bool parse_hex(const std::string& text, std::uint64_t& value) {
  if (text.size() != 16) return false;
  std::istringstream stream(text);
  return static_cast<bool>(stream >> std::hex >> value) && stream.peek() == EOF;
}

// Calls `use` with each line that is not empty or a comment; errors of a line are named by file and number.
template <class Use>
void each_line(std::istream& stream, const fs::path& file, Use&& use) {
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string::npos || line[first] == '#') continue;
    try {
      use(line.substr(first));
    } catch (const std::exception& error) {
      throw ScriptError(file.string() + ':' + std::to_string(number) + ": " + error.what());
    }
  }
}

}  // namespace

GoldenScene golden_scene(const std::string& name, const std::string& words) {
  GoldenScene scene;
  scene.name = name;
  SharedOptions shared;
  scene.picture.size = kSize;
  const auto describe = [&](OptionTable& table) {
    add_shared_options(table, shared, DemoCount::One);
    table.add("--at", scene.at, "").required().range(0, kLongestRun);
    add_picture_options(table, scene.picture);
  };
  bool sized = false;
  try {
    sized = !parse_options(words, describe, {"--size"}).empty();
    scene.picture.check();
    scene.paint = scene.picture.paint();
  } catch (const UsageError& error) {
    throw UsageError(name + ": " + error.what());
  }
  scene.paint.device = render::EglDevice::Software;
  scene.demo = shared.demos.front();
  scene.options = shared.demo;
  scene.words = words + (sized ? "" : std::string(" --size ") + kSize);
  return scene;
}

std::vector<GoldenScene> read_golden_scenes(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) throw ScriptError(file.string() + ": cannot be read");
  std::vector<GoldenScene> scenes;
  each_line(stream, file, [&](const std::string& line) {
    std::istringstream text(line);
    std::string name;
    std::string words;
    text >> name >> std::ws;
    std::getline(text, words);
    if (name.find('/') != std::string::npos) throw UsageError("a scene's name becomes a file: " + name);
    for (const GoldenScene& other : scenes)
      if (other.name == name) throw UsageError("two scenes called " + name);
    scenes.push_back(golden_scene(name, words));
  });
  return scenes;
}

GoldenShot take_golden_shot(const GoldenScene& scene, const std::string& folder) {
  DemoOptions options = scene.options;
  options.print = [](std::string_view) {};
  Demo demo(find_demo(scene.demo, folder).path, options);
  const std::vector<std::string> names = scene.picture.overlays_for(demo);
  const Observe needs = needs_of(names);
  History history(demo, needs.systems, kFlashSeconds);
  demo.observe(needs);
  Painter painter(scene.paint);
  painter.start(demo, names);
  const Selection selection = scene.picture.selection_for(demo);
  painter.select(selection);
  history.follow_island(selection.island);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo&) { history.update(demo); };
  run_loop(demo, {.until = scene.at}, callbacks);
  GoldenShot shot;
  painter.paint(demo, history, shot.image);
  shot.state = demo.world().state_hash();
  shot.driver = painter.driver();
  return shot;
}

std::vector<Accepted> read_accepted(const fs::path& file) {
  std::vector<Accepted> list;
  std::ifstream stream(file);
  each_line(stream, file, [&](const std::string& line) {
    std::istringstream text(line);
    Accepted entry;
    std::string state;
    std::string digests;
    text >> entry.name >> state >> digests >> std::ws;
    std::getline(text, entry.driver);
    bool good = parse_hex(state, entry.state);
    std::istringstream parts(digests);
    for (std::string part; std::getline(parts, part, ',');) {
      entry.digests.push_back(0);
      good = good && parse_hex(part, entry.digests.back());
    }
    if (!good || entry.digests.empty() || entry.driver.empty())
      throw ScriptError("expected NAME STATE DIGEST[,DIGEST...] DRIVER, got \"" + line + '"');
    list.push_back(std::move(entry));
  });
  return list;
}

void write_accepted(const fs::path& file, const std::vector<Accepted>& list) {
  std::string text =
      "# What was blessed (`skerry golden --bless`): scene, state hash, digests of pictures that pass at "
      "once,\n"
      "# and what drew the PNG file of that name.\n";
  for (const Accepted& entry : list) {
    text += entry.name + ' ' + hex(entry.state) + ' ';
    for (std::size_t i = 0; i < entry.digests.size(); ++i) {
      if (i > 0) text += ',';
      text += hex(entry.digests[i]);
    }
    text += ' ' + entry.driver + '\n';
  }
  render::write_file(file, text.data(), text.size());
}

render::DiffRule golden_rule(const GoldenShot& shot, const Accepted& accepted) {
  render::DiffRule rule;
  rule.other_driver = shot.driver != accepted.driver;
  return rule;
}

GoldenVerdict judge(const GoldenShot& shot, const Accepted* accepted, const fs::path& png) {
  GoldenVerdict verdict;
  verdict.state_new = verdict.picture_new = accepted == nullptr;
  if (!accepted) {
    verdict.picture_reason = "nothing was blessed";
    return verdict;
  }
  verdict.state_good = shot.state == accepted->state;
  const std::uint64_t digest = render::digest(shot.image);
  const auto& digests = accepted->digests;
  if (std::find(digests.begin(), digests.end(), digest) != digests.end()) {
    verdict.picture_good = verdict.by_digest = true;
    verdict.picture_reason = "accepted digest " + hex(digest);
    return verdict;
  }
  if (!fs::exists(png)) {
    verdict.picture_new = true;
    verdict.picture_reason = png.string() + " is missing";
    return verdict;
  }
  verdict.expected = render::read_png(png);
  verdict.diff = render::compare(*verdict.expected, shot.image, golden_rule(shot, *accepted));
  verdict.picture_good = verdict.diff.pass;
  verdict.picture_reason = verdict.diff.reason;
  return verdict;
}

}  // namespace skerry::sandbox
