// SPDX-License-Identifier: MIT
#include <iostream>
#include <unistd.h>

#include "sandbox/cli.h"

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return skerry::sandbox::run_command_line(arguments, std::cout, std::cerr, isatty(STDERR_FILENO) == 1);
}
