// SPDX-License-Identifier: MIT
//
// How far a thread has come, for others that wait for it.
#pragma once

#include <atomic>
#include <thread>

namespace skerry {

/// A count that one thread raises and others wait for. What was written before it was raised is seen by those
/// that waited.
struct alignas(64) Progress {
  std::atomic<int> done = 0;

  void wait_for(int count) const {
    // Others are microseconds away, or, with more threads than processors, not running.
    constexpr int kPatience = 1000;
    for (int i = 0; done.load(std::memory_order_acquire) < count; ++i) {
      if (i > kPatience) {
        std::this_thread::yield();
        continue;
      }
#if defined(__x86_64__)
      __builtin_ia32_pause();
#endif
    }
  }
  void reached(int count) {
    done.store(count, std::memory_order_release);
  }
};

}  // namespace skerry
