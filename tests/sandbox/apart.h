// SPDX-License-Identifier: MIT
//
// The program as a process of its own.
#pragma once

#include <csignal>
#include <cstdio>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {

/// Runs the program in a process of its own, so that limits and signals hit nothing else.
/// @param prepare called in the child before it starts
/// @return the exit code; -1 if it did not end by itself
template <class Prepare, class Meanwhile>
int run_apart(std::vector<std::string> arguments, const std::string& messages, Prepare prepare,
              Meanwhile meanwhile) {
  arguments.insert(arguments.begin(), program());
  std::vector<char*> words;
  words.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    if (!freopen(messages.c_str(), "w", stderr)) _exit(125);
    // Whoever runs the tests in the background may ignore it.
    signal(SIGINT, SIG_DFL);
    prepare();
    execv(words.front(), words.data());
    _exit(126);
  }
  meanwhile(child);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Size of the files in a folder that have no name yet.
inline std::uintmax_t unfinished_bytes(const TemporaryFolder& folder) {
  std::uintmax_t sum = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "")) {
    std::error_code error;
    const std::uintmax_t size = entry.path().extension() == ".part" ? entry.file_size(error) : 0;
    if (!error) sum += size;
  }
  return sum;
}

}  // namespace skerry::sandbox
