// SPDX-License-Identifier: MIT
//
// Threads for pair finding: those of the caller, or a pool of its own that is started by the first loop that
// is large enough for it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <memory>

#include "physics/thread_pool.h"

namespace skerry {

/// The threads that one broad phase may use.
class Workers {
 public:
  /// @param pool  threads of the caller, in place of `threads` own ones; may be null
  explicit Workers(int threads, ThreadPool* pool = nullptr)
      : threads_(pool != nullptr ? pool->threads() : threads), pool_(pool) {}

  /// Into how many shares a loop of `items` is cut: one a thread, and none smaller than `least`.
  std::size_t shares(std::size_t items, std::size_t least) const {
    return std::min(static_cast<std::size_t>(threads_), items / least + 1);
  }
  /// Calls `share(k)` for every k < count, at the same time; the caller takes part.
  void run(std::size_t count, const std::function<void(std::size_t)>& share) {
    if (count == 1) return share(0);
    if (pool_ == nullptr) {
      own_ = std::make_unique<ThreadPool>(threads_);
      pool_ = own_.get();
    }
    pool_->run(count, share);
  }

 private:
  int threads_;
  ThreadPool* pool_;
  std::unique_ptr<ThreadPool> own_;
};

}  // namespace skerry
