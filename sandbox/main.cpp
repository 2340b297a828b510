// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <iostream>
#include <unistd.h>

#include "sandbox/cli.h"
#include "sandbox/errors.h"

int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  // Alone, where there is a screen, it opens the window with the list of demos; else the help says more.
  if (arguments.empty() && (std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY"))) arguments = {"open"};
  skerry::sandbox::handle_signals();
  const int code =
      skerry::sandbox::run_command_line(arguments, std::cout, std::cerr, isatty(STDERR_FILENO) == 1);
  // What was asked for and did not arrive is no success.
  if (!std::cout.flush()) {
    std::cerr << "skerry: cannot write to standard output\n";
    return code == skerry::sandbox::kGood ? skerry::sandbox::kEnvironmentError : code;
  }
  return code;
}
