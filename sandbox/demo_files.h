// SPDX-License-Identifier: MIT
//
// Where demos are, and which file a name means.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace skerry::sandbox {

/// A demo by its short name.
struct DemoFile {
  std::string name;   ///< "stack"
  std::string topic;  ///< folder below the demo folder, "" for none
  std::string path;   ///< as it appears in messages, relative to the working directory where that is shorter
};

/// The demo folder: `given` if not empty, else `demos` in the working directory, else the one of the source
/// tree or installation this program comes from. @throws ScriptError if there is none.
std::filesystem::path demo_folder(const std::string& given);

/// All `*.lua` below `folder`, sorted by topic, then name.
std::vector<DemoFile> find_demos(const std::filesystem::path& folder);

/// The file that `word` means: a path that exists, or the name of a demo in `folder`.
/// @throws ScriptError with the nearest names.
DemoFile find_demo(const std::string& word, const std::string& folder);

}  // namespace skerry::sandbox
