// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <iostream>
#include <unistd.h>

#include "sandbox/cli.h"

int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  // Alone, where there is a screen, it opens the window with the list of demos; else the help says more.
  if (arguments.empty() && (std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY"))) arguments = {"open"};
  return skerry::sandbox::run_command_line(arguments, std::cout, std::cerr, isatty(STDERR_FILENO) == 1);
}
