// SPDX-License-Identifier: MIT
#include <cstdio>
#include <filesystem>
#include <memory>
#include <ostream>

#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/window/recording.h"

namespace skerry::sandbox {
namespace {

struct Options {
  std::string file, folder;
};

int run(const Options& options, const Io& io) {
  Recording recording;
  try {
    recording = load_recording(read_bytes(options.file));
  } catch (const ArchiveError& error) {
    throw ScriptError(options.file + ": " + error.what());
  }
  // The script may lie elsewhere here than where the recording was made.
  std::string path = recording.path;
  if (!std::filesystem::is_regular_file(path))
    path = find_demo(std::filesystem::path(path).stem().string(), options.folder).path;
  if (file_hash(path) != recording.script_hash)
    io.err << "skerry: " << path << " is not the script that was recorded\n";
  recording.options.print = [&io](std::string_view line) { io.err << line << '\n'; };
  const std::optional<Difference> difference = replay(recording, path);
  if (difference) {
    io.out << "  FAIL  " << options.file << ": " << difference->text() << '\n';
    return kCheckFailed;
  }
  char hash[24];
  std::snprintf(hash, sizeof hash, "%016llx",
                static_cast<unsigned long long>(recording.states.empty() ? 0 : recording.states.back().hash));
  io.out << "  ok  " << options.file << ": " << recording.steps() << " steps of " << path << " with "
         << recording.inputs.size() << " inputs, every state the same by the bit, state " << hash << '\n';
  return kGood;
}

}  // namespace

Action setup_replay(OptionTable& table) {
  auto options = std::make_shared<Options>();
  table.add("FILE", options->file, "Recording of the window or of `skerry record`").required().type("");
  table.add("--demos", options->folder, "Folder with the demos").type("FOLDER");
  return [options](const Io& io) { return run(*options, io); };
}

}  // namespace skerry::sandbox
