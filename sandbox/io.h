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
/// From now on Ctrl-C, SIGTERM and SIGHUP only set the flag; a second one ends the process at once, without
/// the files that are not complete.
void catch_interrupts();
/// Until then the first one does, and SIGPIPE and SIGQUIT always. Signals that are ignored stay so.
void handle_signals();
/// @param what  became of the outputs: "x.png not written" @throws Interrupted
void stop_if_interrupted(const std::string& what);

}  // namespace skerry::sandbox
