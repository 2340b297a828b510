// SPDX-License-Identifier: MIT
#include "physics/thread_pool.h"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace skerry {
namespace {

// Some 400 us: between the loops of a step one thread goes on alone for up to that.
constexpr int kPatience = 8000;

// What a thread does between two looks at what it waits for.
void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

struct ThreadPool::State {
  std::mutex mutex;
  std::condition_variable wake, done;
  std::atomic<std::uint64_t> loop = 0;  ///< number of the present loop; workers wait for it to change
  std::atomic<int> busy = 0;            ///< workers that have not finished the present loop
  bool stop = false;
  int patience = 0;  ///< looks at what it waits for before a thread goes to sleep

  std::size_t count = 0;
  Call call = nullptr;
  const void* item = nullptr;
  std::atomic<std::size_t> next{0};

  std::exception_ptr error;
  std::size_t error_index = 0;

  std::vector<std::thread> workers;

  void work() {
    for (std::size_t i = next.fetch_add(1); i < count; i = next.fetch_add(1)) {
      try {
        call(item, i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (error == nullptr || i < error_index) {
          error = std::current_exception();
          error_index = i;
        }
      }
    }
  }

  /// Loops follow each other within microseconds, waking a thread takes tens of them.
  template <class Ready>
  void spin(Ready&& ready) const {
    for (int i = 0; i < patience && !ready(); ++i) pause_briefly();
  }

  void live() {
    std::uint64_t seen = 0;
    for (;;) {
      spin([&] { return loop.load(std::memory_order_relaxed) != seen; });
      {
        std::unique_lock lock(mutex);
        wake.wait(lock, [&] { return stop || loop != seen; });
        if (stop) return;
        seen = loop;
      }
      work();
      const std::lock_guard lock(mutex);
      if (--busy == 0) done.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  if (threads < 1 || threads > 256) {
    throw std::invalid_argument("threads must be between 1 and 256, got " + std::to_string(threads));
  }
  // More threads than processors would only keep each other from work.
  const bool own = static_cast<unsigned>(threads) <= std::thread::hardware_concurrency();
  state_->patience = own ? kPatience : 0;
  for (int i = 1; i < threads; ++i) state_->workers.emplace_back([state = state_.get()] { state->live(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
  }
  state_->wake.notify_all();
  for (std::thread& worker : state_->workers) worker.join();
}

int ThreadPool::threads() const {
  return static_cast<int>(state_->workers.size()) + 1;
}

void ThreadPool::run(std::size_t count, Call call, const void* item) {
  State& s = *state_;
  if (count == 0) return;
  if (s.workers.empty() || count == 1) {
    std::exception_ptr first;
    for (std::size_t i = 0; i < count; ++i) {
      try {
        call(item, i);
      } catch (...) {
        if (first == nullptr) first = std::current_exception();
      }
    }
    if (first != nullptr) std::rethrow_exception(first);
    return;
  }
  {
    const std::lock_guard lock(s.mutex);
    s.count = count;
    s.call = call;
    s.item = item;
    s.next = 0;
    s.error = nullptr;
    s.busy = static_cast<int>(s.workers.size());
    ++s.loop;
  }
  s.wake.notify_all();
  s.work();
  s.spin([&] { return s.busy.load(std::memory_order_relaxed) == 0; });
  std::unique_lock lock(s.mutex);
  s.done.wait(lock, [&] { return s.busy == 0; });
  if (s.error != nullptr) std::rethrow_exception(s.error);
}

}  // namespace skerry
