// SPDX-License-Identifier: MIT
//
// skerry golden: pictures of known scenes against those that people looked at and blessed.
#include "sandbox/golden.h"

#include <algorithm>
#include <memory>
#include <ostream>

#include "render/error.h"
#include "render/html_report.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/names.h"
#include "sandbox/report.h"

namespace skerry::sandbox {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> scenes;
  std::string folder, demos, report;
  std::string renderer = "auto";
  bool bless = false;
  bool list = false;
};

/// A scene with what came of it.
struct Result {
  GoldenScene scene;
  GoldenShot shot;
  GoldenVerdict verdict;
  std::string problem;  ///< why there is no shot

  bool good() const { return problem.empty() && verdict.picture_good && verdict.state_good; }
};

// The folder of scenes, pictures and digests: beside the demos, unless it is named.
fs::path golden_folder(const Options& options) {
  if (!options.folder.empty()) return options.folder;
  return (demo_folder(options.demos) / ".." / "tests" / "golden").lexically_normal();
}

// The scenes that the command line names: "stack", or "stack*" for all that begin so.
std::vector<GoldenScene> chosen(std::vector<GoldenScene> scenes, const std::vector<std::string>& words) {
  if (words.empty()) return scenes;
  std::vector<std::string> names;
  names.reserve(scenes.size());
  for (const GoldenScene& scene : scenes) names.push_back(scene.name);
  const auto matches = [](const std::string& word, const std::string& name) {
    return word == name ||
           (!word.empty() && word.back() == '*' && name.starts_with(word.substr(0, word.size() - 1)));
  };
  for (const std::string& word : words)
    if (std::none_of(names.begin(), names.end(),
                     [&](const std::string& name) { return matches(word, name); }))
      throw UsageError("no golden scene \"" + word + '"' + suggestion(word, names));
  std::erase_if(scenes, [&](const GoldenScene& scene) {
    return std::none_of(words.begin(), words.end(),
                        [&](const std::string& word) { return matches(word, scene.name); });
  });
  return scenes;
}

Accepted* find(std::vector<Accepted>& list, const std::string& name) {
  const auto at =
      std::find_if(list.begin(), list.end(), [&](const Accepted& entry) { return entry.name == name; });
  return at == list.end() ? nullptr : &*at;
}

Result look_at(const GoldenScene& scene, const Options& options, const fs::path& folder,
               std::vector<Accepted>& accepted) {
  Result result{scene, {}, {}, {}};
  try {
    result.shot = take_golden_shot(scene, options.demos);
    result.verdict = judge(result.shot, find(accepted, scene.name), folder / (scene.name + ".png"));
  } catch (const render::EnvironmentError&) {
    throw;  // no driver: no scene will do better
  } catch (const std::exception& error) {
    result.problem = error.what();
  }
  return result;
}

// "differs, state moved": which of the two judgements failed.
std::string word_of(const Result& result) {
  if (!result.problem.empty()) return "FAIL  " + result.scene.name + ": " + result.problem;
  const GoldenVerdict& verdict = result.verdict;
  const char* picture = verdict.picture_good  ? "picture as blessed"
                        : verdict.picture_new ? "picture new"
                                              : "picture differs";
  const char* state = verdict.state_good  ? "state as blessed"
                      : verdict.state_new ? "state new"
                                          : "state moved";
  return std::string(result.good() ? "ok    " : "FAIL  ") + result.scene.name + ": " + picture + ", " +
         state + " (" + verdict.picture_reason + ')';
}

std::string demos_flag(const Options& options) {
  return options.demos.empty() ? "" : " --demos " + options.demos;
}

render::ReportScene report_scene(Result& result, const Options& options, std::vector<Accepted>& accepted) {
  render::ReportScene scene;
  scene.name = result.scene.name;
  scene.about = result.scene.words;
  scene.problem = result.problem;
  scene.repeat = "skerry capture " + result.scene.words + demos_flag(options) + " -o " + scene.name + ".png";
  scene.bless = "skerry golden" + demos_flag(options) +
                (options.folder.empty() ? "" : " --folder " + options.folder) + " --bless " + scene.name;
  if (!result.problem.empty()) return scene;
  scene.actual = std::move(result.shot.image);
  scene.picture_good = result.verdict.picture_good;
  scene.picture_reason = result.verdict.picture_reason;
  scene.diff = result.verdict.diff;
  if (!scene.picture_good) scene.expected = std::move(result.verdict.expected);
  scene.state_actual = hex(result.shot.state);
  if (const Accepted* entry = find(accepted, scene.name)) scene.state_expected = hex(entry->state);
  return scene;
}

void write_report(std::vector<Result>& results, const Options& options, std::vector<Accepted>& accepted,
                  const Io& io) {
  std::error_code error;
  fs::create_directories(options.report, error);
  if (error) throw ScriptError(options.report + ": cannot be made: " + error.message());
  render::ReportPage page;
  page.title = "Skerry: golden images";
  for (const Result& result : results)
    if (result.problem.empty()) page.about = "drawn by " + result.shot.driver;
  for (Result& result : results) page.scenes.push_back(report_scene(result, options, accepted));
  const std::string html = render::html_report(page);
  const fs::path file = fs::path(options.report) / "index.html";
  render::write_file(file, html.data(), html.size());
  io.out << file.string() << '\n';
}

// Makes the present pictures and states the expected ones. Files that pass stay as they are, so that version
// control shows what moved and nothing else.
void bless(const std::vector<Result>& results, const fs::path& folder, const std::vector<GoldenScene>& all,
           std::vector<Accepted>& accepted, const Io& io) {
  fs::create_directories(folder);
  int pictures = 0;
  int states = 0;
  for (const Result& result : results) {
    if (!result.problem.empty()) continue;
    Accepted* entry = find(accepted, result.scene.name);
    if (!entry) entry = &accepted.emplace_back(Accepted{result.scene.name, result.shot.state, {}, {}});
    const std::uint64_t digest = render::digest(result.shot.image);
    if (!result.verdict.picture_good) {
      const std::vector<std::uint8_t> bytes = render::encode_small_png(result.shot.image);
      render::write_file(folder / (result.scene.name + ".png"), bytes.data(), bytes.size());
      entry->digests = {digest};
      entry->driver = result.shot.driver;
      ++pictures;
    } else if (!result.verdict.by_digest) {
      entry->digests.push_back(digest);
    }
    states += entry->state != result.shot.state || result.verdict.state_new;
    entry->state = result.shot.state;
  }
  // In the order of the scenes; what is no longer a scene goes, with its picture.
  std::vector<Accepted> sorted;
  for (const GoldenScene& scene : all)
    if (const Accepted* entry = find(accepted, scene.name)) sorted.push_back(*entry);
  for (const fs::directory_entry& file : fs::directory_iterator(folder))
    if (file.path().extension() == ".png" && !find(sorted, file.path().stem().string()))
      fs::remove(file.path());
  write_accepted(folder / "accepted.txt", sorted);
  io.out << "blessed " << pictures << " pictures and " << states << " states in " << folder.string() << '\n';
}

int golden(const Options& options, const Io& io) {
  const fs::path folder = golden_folder(options);
  const std::vector<GoldenScene> all = read_golden_scenes(folder / "scenes.txt");
  std::vector<GoldenScene> scenes = chosen(all, options.scenes);
  const std::optional<Renderer> renderer = parse_renderer(options.renderer);
  if (!renderer) throw UsageError("--renderer expected auto, gl or cpu, got \"" + options.renderer + '"');
  if (options.bless && renderer != Renderer::Auto)
    throw UsageError("--bless: what is blessed is drawn by the renderer auto, not " + options.renderer);
  for (GoldenScene& scene : scenes) {
    scene.paint.renderer = *renderer;
    if (renderer == Renderer::OpenGl) scene.paint.device = render::EglDevice::Any;
  }
  if (options.list) {
    for (const GoldenScene& scene : scenes) io.out << scene.name << "  " << scene.words << '\n';
    return kGood;
  }
  std::vector<Accepted> accepted = read_accepted(folder / "accepted.txt");
  catch_interrupts();
  std::vector<Result> results;
  for (const GoldenScene& scene : scenes) {
    results.push_back(look_at(scene, options, folder, accepted));
    stop_if_interrupted("nothing is written");
    if (!results.back().good()) io.out << word_of(results.back()) << '\n';
  }
  const auto count = [&](auto&& condition) {
    return std::count_if(results.begin(), results.end(), condition);
  };
  const auto bad_pictures =
      count([](const Result& r) { return !r.problem.empty() || !r.verdict.picture_good; });
  const auto bad_states = count([](const Result& r) { return !r.problem.empty() || !r.verdict.state_good; });
  const auto broken = count([](const Result& r) { return !r.problem.empty(); });
  io.out << results.size() << " scenes: " << bad_pictures << " pictures and " << bad_states
         << " states are not as blessed\n";
  // Blessed first, since the report takes the pictures; it still shows what was expected before.
  std::vector<Accepted> before = accepted;
  if (options.bless) bless(results, folder, all, accepted, io);
  if (!options.report.empty()) write_report(results, options, before, io);
  if (options.report.empty() && !options.bless && bad_pictures + bad_states > 0)
    io.out << "`skerry golden --report DIR` shows them, `skerry golden --bless` accepts them\n";
  if (broken > 0) return kScriptOrFile;
  return options.bless || bad_pictures + bad_states == 0 ? kGood : kCheckFailed;
}

}  // namespace

Action setup_golden(OptionTable& table) {
  auto options = std::make_shared<Options>();
  table.add("SCENE", options->scenes, "Scenes by name; NAME* for all that begin so (default: all)").type("");
  table
      .add("--report", options->report, "Writes DIR/index.html: what was expected, what came, the difference")
      .type("DIR");
  table.add_flag("--bless", options->bless, "What is drawn now is what is expected from now on");
  table.add_flag("--list", options->list, "Names the scenes and draws nothing");
  table
      .add("--folder", options->folder,
           "Folder with scenes.txt, accepted.txt and the pictures (tests/golden)")
      .type("FOLDER");
  table
      .add("--renderer", options->renderer,
           "Who draws: auto (the built-in rasteriser), cpu (the same) or gl, to compare OpenGL with it, by "
           "the "
           "graphics processor where there is one")
      .type("NAME");
  table.add("--demos", options->demos, "Folder with the demos").type("FOLDER");
  return [options](const Io& io) { return golden(*options, io); };
}

}  // namespace skerry::sandbox
