// SPDX-License-Identifier: MIT
//
// The command line of `skerry`: from words to a command, from exceptions to exit codes.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sandbox/demo.h"
#include "sandbox/io.h"
#include "sandbox/option_table.h"

namespace skerry::sandbox {

/// Runs one command line. @param arguments without the program's name
/// @return an `ExitCode`; complaints are on `err`, one sentence a problem
int run_command_line(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
                     bool terminal);

/// What a command does once its options are read.
using Action = std::function<int(const Io&)>;

/// One row of the command registry.
struct Command {
  std::string_view name;
  std::string_view summary;
  std::string_view example;
  /// Adds options to the subcommand; they live in the returned action.
  Action (*setup)(OptionTable& table);
};

std::span<const Command> commands();

/// Options that all commands with a demo share.
struct SharedOptions {
  std::vector<std::string> demos;  ///< names or paths
  std::string folder;              ///< of --demos
  DemoOptions demo;

  /// Demo options with script output on `io.err`. @throws UsageError for unknown solvers, broad phases etc.
  DemoOptions checked(const Io& io) const;
};

enum class DemoCount { One, AtLeastOne, Any };

/// Adds DEMO and the shared flags (--seed --dt --steps --seconds --stepper --accuracy --solver --broadphase
/// --impact --set) to a command.
void add_shared_options(OptionTable& table, SharedOptions& options, DemoCount count);
/// Only `--demos FOLDER`.
void add_folder_option(OptionTable& table, SharedOptions& options);

}  // namespace skerry::sandbox
