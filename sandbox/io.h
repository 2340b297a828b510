// SPDX-License-Identifier: MIT
//
// Where a command writes: data to `out`, progress and complaints to `err`.
#pragma once

#include <iosfwd>
#include <string>

namespace skerry::sandbox {

struct Io {
  std::ostream& out;
  std::ostream& err;
  bool terminal = false;     ///< `err` is a terminal: progress lines may overwrite themselves
  std::string command_line;  ///< as typed, for reports and metadata
};

/// Whether the user pressed Ctrl-C since `catch_interrupts`.
bool interrupted();
/// From now on Ctrl-C and SIGTERM only set the flag; a second one ends the process at once.
void catch_interrupts();

}  // namespace skerry::sandbox
