// SPDX-License-Identifier: MIT
#include "sandbox/demo_files.h"

#include <algorithm>
#include <tuple>

#include "sandbox/errors.h"
#include "sandbox/names.h"

namespace skerry::sandbox {
namespace fs = std::filesystem;
namespace {

std::string shown(const fs::path& path) {
  std::error_code error;
  const std::string relative = fs::proximate(path, error).generic_string();
  const std::string whole = path.lexically_normal().generic_string();
  return error || relative.empty() || relative.size() >= whole.size() ? whole : relative;
}

bool has_demos(const fs::path& folder) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, error))
    if (entry.path().extension() == ".lua") return true;
  return false;
}

}  // namespace

fs::path demo_folder(const std::string& given) {
  if (!given.empty()) {
    if (!fs::is_directory(given)) throw ScriptError(given + ": no such folder");
    return given;
  }
  // The working folder, an installed program's own, the checkout that it was built from.
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error).parent_path();
  const fs::path installed = (program / SKERRY_INSTALLED_DEMOS).lexically_normal();
  for (const fs::path& folder : {fs::path("demos"), installed, fs::path(SKERRY_DEMO_DIR)})
    if (has_demos(folder)) return folder;
  throw ScriptError("no demos found, neither in ./demos nor in " + installed.string() +
                    " nor in " SKERRY_DEMO_DIR "; use --demos FOLDER");
}

std::vector<DemoFile> find_demos(const fs::path& folder) {
  std::vector<DemoFile> demos;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().extension() != ".lua") continue;
    const std::string topic = entry.path().parent_path().lexically_relative(folder).generic_string();
    demos.push_back({entry.path().stem().string(), topic == "." ? "" : topic, shown(entry.path())});
  }
  std::sort(demos.begin(), demos.end(), [](const DemoFile& a, const DemoFile& b) {
    return std::tie(a.topic, a.name) < std::tie(b.topic, b.name);
  });
  return demos;
}

DemoFile find_demo(const std::string& word, const std::string& folder) {
  if (fs::is_regular_file(word)) return {fs::path(word).stem().string(), "", shown(word)};
  const bool is_path = word.find('/') != std::string::npos || fs::path(word).extension() == ".lua";
  const fs::path root = demo_folder(folder);
  std::vector<std::string> names;
  for (DemoFile& demo : find_demos(root)) {
    if (demo.name == word || demo.topic + '/' + demo.name == word) return demo;
    names.push_back(is_path ? demo.path : demo.name);
  }
  if (is_path) throw ScriptError(word + ": no such file" + suggestion(word, names));
  throw ScriptError("no demo \"" + word + '"' + suggestion(word, names));
}

}  // namespace skerry::sandbox
