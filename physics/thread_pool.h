// SPDX-License-Identifier: MIT
//
// A small pool: a fixed number of threads that share the items of one loop at a time.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace skerry {

/// Runs loops on `threads` threads, the caller's among them. With one thread nothing is started and nothing
/// is locked.
class ThreadPool {
 public:
  /// @throws std::invalid_argument unless 1 <= threads <= 256
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const;
  /// Calls `item(i)` once for each i in [0, count), in any order and at the same time, and returns when all
  /// are done. Items must not touch each other's data; then the result does not depend on the number of
  /// threads. If items throw, the exception of the lowest i is thrown here, after all others have ended. Not
  /// to be called from within an item.
  void run(std::size_t count, const std::function<void(std::size_t)>& item);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace skerry
