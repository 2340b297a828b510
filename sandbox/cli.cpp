// SPDX-License-Identifier: MIT
#include "sandbox/cli.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>

#include "render/error.h"
#include "sandbox/errors.h"
#include "sandbox/names.h"

namespace skerry::sandbox {
namespace {

std::string quoted(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_of(" \t\"'$&|;<>()*?\\") == std::string::npos;
  return plain ? word : '\'' + word + '\'';
}

// The long options of a command, for "did you mean".
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

// Words that nobody wanted: an unknown command or an unknown option. The first is the one to explain.
void refuse_leftovers(CLI::App& app, const CLI::App* chosen) {
  const std::vector<std::string> rest = app.remaining(true);
  if (rest.empty()) return;
  std::vector<std::string> names;
  for (const Command& command : commands()) names.emplace_back(command.name);
  const std::string& word = rest.front();
  if (word.starts_with('-')) {
    const std::string name = word.substr(0, word.find('='));
    const CLI::App& owner = chosen ? *chosen : app;
    throw UsageError("unknown option " + name + suggestion(name, option_names(owner)));
  }
  if (!chosen) throw UsageError("no command \"" + word + '"' + suggestion(word, names));
  throw UsageError("one argument too many: \"" + word + '"');
}

std::string examples() {
  std::string text = "Examples:\n";
  for (const Command& command : commands()) text += "  " + std::string(command.example) + '\n';
  return text +
         "\nExit codes: 0 good, 1 a check failed, 2 usage, 3 script or file error, 4 environment, 130 "
         "Ctrl-C.\n"
         "`skerry COMMAND --help` lists the options of a command.\n";
}

int dispatch(const std::vector<std::string>& arguments, const Io& io) {
  CLI::App app("Exact 2D rigid-body physics: run demos, check their numbers, record videos.", "skerry");
  app.set_version_flag("--version", "skerry " SKERRY_VERSION);
  app.footer(examples());
  app.allow_extras();
  std::vector<std::pair<CLI::App*, Action>> actions;
  for (const Command& command : commands()) {
    CLI::App* sub = app.add_subcommand(std::string(command.name), std::string(command.summary));
    sub->footer("\nExample:\n  " + std::string(command.example));
    sub->allow_extras();
    OptionTable table(*sub);
    actions.emplace_back(sub, command.setup(table));
  }
  try {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // CLI11 wants the last first
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, io.out, io.err) == 0 ? kGood : kUsage;
    const auto subcommands = app.get_subcommands();
    refuse_leftovers(app, subcommands.empty() ? nullptr : subcommands.front());
    throw UsageError(error.what());
  }
  for (const auto& [sub, action] : actions) {
    if (!*sub) continue;
    refuse_leftovers(app, sub);
    return action(io);
  }
  refuse_leftovers(app, nullptr);
  io.err << app.help();
  return kUsage;
}

}  // namespace

int run_command_line(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err,
                     bool terminal) {
  Io io{out, err, terminal, "skerry"};
  for (const std::string& word : arguments) io.command_line += ' ' + quoted(word);
  const auto complain = [&](const std::exception& error, int code) {
    err << "skerry: " << error.what() << '\n';
    return code;
  };
  try {
    return dispatch(arguments, io);
  } catch (const UsageError& error) {
    return complain(error, kUsage);
  } catch (const ScriptError& error) {
    return complain(error, kScriptOrFile);
  } catch (const Interrupted& error) {
    return complain(error, error.code);
  } catch (const render::EnvironmentError& error) {
    return complain(error, kEnvironmentError);
  } catch (const std::invalid_argument& error) {
    return complain(error, kUsage);
  } catch (const std::exception& error) {
    return complain(error, kEnvironmentError);
  }
}

}  // namespace skerry::sandbox
