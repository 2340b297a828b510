// SPDX-License-Identifier: MIT
#include <csignal>

#include "sandbox/io.h"

namespace skerry::sandbox {
namespace {

volatile std::sig_atomic_t interrupt_seen = 0;

extern "C" void note_interrupt(int signal) {
  interrupt_seen = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

bool interrupted() {
  return interrupt_seen != 0;
}

void catch_interrupts() {
  interrupt_seen = 0;
  std::signal(SIGINT, note_interrupt);
  std::signal(SIGTERM, note_interrupt);
}

}  // namespace skerry::sandbox
