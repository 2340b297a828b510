// SPDX-License-Identifier: MIT
#include <csignal>

#include "render/output_file.h"
#include "sandbox/errors.h"
#include "sandbox/io.h"

namespace skerry::sandbox {
namespace {

volatile std::sig_atomic_t interrupt_seen = 0;  // number of the signal
volatile std::sig_atomic_t catching = 0;

extern "C" void note_interrupt(int signal) {
  const bool stops = signal != SIGPIPE && signal != SIGQUIT;  // as Ctrl-C does
  if (stops && catching != 0 && interrupt_seen == 0) {
    interrupt_seen = signal;
    return;
  }
  render::remove_unfinished_files();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

bool interrupted() {
  return interrupt_seen != 0;
}

void stop_if_interrupted(const std::string& what) {
  constexpr int kSignalled = 128;  // as shells say it
  if (interrupted()) throw Interrupted("interrupted; " + what, kSignalled + interrupt_seen);
}

void handle_signals() {
  // A file that reaches its limit is a write that fails.
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGQUIT}) {
    // Who started the program so that it goes on (nohup) means it.
    if (std::signal(signal, note_interrupt) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
}

void catch_interrupts() {
  interrupt_seen = 0;
  catching = 1;
  handle_signals();
}

}  // namespace skerry::sandbox
