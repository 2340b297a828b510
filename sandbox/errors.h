// SPDX-License-Identifier: MIT
//
// The ways in which a call of `skerry` can go wrong, and the exit code of each.
#pragma once

#include <stdexcept>

namespace skerry::sandbox {

/// What the process returns; scripts may rely on these numbers.
enum ExitCode : int {
  kGood = 0,
  kCheckFailed = 1,       ///< an `expect` does not hold, a body had to be stopped, a problem was not solved
  kUsage = 2,             ///< unknown option, value, command or demo parameter
  kScriptOrFile = 3,      ///< a demo that is not there or has an error; a file that cannot be read or written
  kEnvironmentError = 4,  ///< no EGL, no encoder, disk full
  kInterrupted = 130,     ///< Ctrl-C; SIGTERM is 143: 128 and the number of the signal
};

/// Wrong words on the command line; exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A demo or file that is missing or wrong; exit code 3. For scripts the message begins with `file:line:`.
class ScriptError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A signal asked the command to end before it was done.
class Interrupted : public std::runtime_error {
 public:
  Interrupted(const std::string& what, int exit_code) : std::runtime_error(what), code(exit_code) {}
  const int code;
};

}  // namespace skerry::sandbox
