// SPDX-License-Identifier: MIT
#include <memory>
#include <ostream>

#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/output.h"
#include "sandbox/progress.h"
#include "sandbox/window/recording.h"

namespace skerry::sandbox {
namespace {

struct Options {
  SharedOptions shared;
  std::string out;
};

int run(const Options& options, const Io& io) {
  const DemoFile file = find_demo(options.shared.demos.front(), options.shared.folder);
  Player player(file.path, options.shared.checked(io));
  player.seek(player.demo().total_steps());
  const std::string out = options.out.empty() ? file.name + ".skerry" : options.out;
  const std::vector<std::byte> bytes = save_recording(record(player));
  write_results(io, {{out, text_of(bytes)}});
  words_beside(io, out) << out << ": " << player.end() << " steps, " << format_bytes(bytes.size()) << '\n';
  return player.demo().failed() ? kCheckFailed : kGood;
}

}  // namespace

Action setup_record(OptionTable& table) {
  auto options = std::make_shared<Options>();
  add_shared_options(table, options->shared, DemoCount::One);
  table.add("-o,--out", options->out, "File to write (default: DEMO.skerry)").type("FILE");
  return [options](const Io& io) { return run(*options, io); };
}

}  // namespace skerry::sandbox
