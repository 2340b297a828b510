// SPDX-License-Identifier: MIT
#include <memory>
#include <ostream>

#include "physics/broadphase/broadphase.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/loop.h"
#include "sandbox/report.h"

namespace skerry::sandbox {
namespace {

/// The state hash after each step, and whether a check failed.
struct Trajectory {
  std::vector<std::uint64_t> hashes;
  bool failed = false;
};

Trajectory follow(const std::string& path, const DemoOptions& options, std::ostream* checks) {
  Demo demo(path, options);
  Trajectory result;
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo& running) { result.hashes.push_back(running.world().state_hash()); };
  run_loop(demo, {}, callbacks);
  result.failed = demo.failed();
  if (checks) print_checks(*checks, demo);
  return result;
}

// Runs a demo with the given broad phase only, or else with the oracle and then with every other one, which
// must not change a bit.
bool passes(const DemoFile& file, const DemoOptions& given, const Io& io) {
  DemoOptions options = given;
  if (given.broad_phase) return !follow(file.path, options, &io.out).failed;
  options.broad_phase = std::string(broad_phases().front().name);
  const Trajectory oracle = follow(file.path, options, &io.out);
  bool good = !oracle.failed;
  for (const BroadPhaseEntry& entry : broad_phases().subspan(1)) {
    if (interrupted()) break;
    options.broad_phase = std::string(entry.name);
    const Trajectory other = follow(file.path, options, nullptr);
    const auto [mine, theirs] =
        std::mismatch(oracle.hashes.begin(), oracle.hashes.end(), other.hashes.begin(), other.hashes.end());
    if (mine == oracle.hashes.end() && theirs == other.hashes.end()) continue;
    good = false;
    io.out << file.name << ": FAIL  with broad phase " << entry.name << " the state differs from that of "
           << broad_phases().front().name << " after step " << mine - oracle.hashes.begin() + 1 << '\n';
  }
  return good;
}

int test(const SharedOptions& shared, const Io& io) {
  const DemoOptions options = shared.checked(io);
  std::vector<DemoFile> files;
  for (const std::string& name : shared.demos) files.push_back(find_demo(name, shared.folder));
  if (files.empty()) files = find_demos(demo_folder(shared.folder));
  catch_interrupts();
  std::vector<std::string> failed;
  for (const DemoFile& file : files) {
    const bool good = passes(file, options, io);
    stop_if_interrupted(file.name + " and what follows were not checked");
    if (!good) failed.push_back(file.name);
  }
  io.out << files.size() - failed.size() << " of " << files.size() << " demos pass";
  for (std::size_t i = 0; i < failed.size(); ++i) io.out << (i == 0 ? "; failed: " : ", ") << failed[i];
  io.out << '\n';
  return failed.empty() ? kGood : kCheckFailed;
}

}  // namespace

Action setup_test(OptionTable& table) {
  auto shared = std::make_shared<SharedOptions>();
  add_shared_options(table, *shared, DemoCount::Any);
  return [shared](const Io& io) { return test(*shared, io); };
}

}  // namespace skerry::sandbox
