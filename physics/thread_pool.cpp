// SPDX-License-Identifier: MIT
#include "physics/thread_pool.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
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

// The gate of the present loop in one word: its number, whether it may be entered, how many workers are
// inside.
constexpr std::uint64_t kOpen = 1u << 16, kInside = kOpen - 1;
constexpr int kNumberShift = 17;

std::uint64_t number_of(std::uint64_t gate) {
  return gate >> kNumberShift;
}

}  // namespace

// Nothing is locked as long as nobody sleeps. The caller opens the gate, works, closes it and waits for those
// inside: a worker that comes late, or that the system does not run, keeps nobody waiting.
namespace {

// After so many loops the slower way is tried once more.
constexpr unsigned kTryAgain = 64;
// Share of the last one in the mean of times, and how much longer than that it counts at most.
constexpr double kLast = 0.125, kLongest = 2;

}  // namespace

bool Pace::share() {
  const unsigned turn = turn_++;
  if (shared_ == 0) return true;
  if (alone_ == 0) return false;
  return (shared_ <= alone_) != (turn % kTryAgain == 0);
}

void Pace::note(bool shared, double seconds, double work) {
  double& mean = shared ? shared_ : alone_;
  const double now = seconds / work;
  mean = mean == 0 ? now : mean + kLast * (std::min(now, kLongest * mean) - mean);
}

struct ThreadPool::State {
  std::array<Pace, 64> pace;  ///< by power of two
  alignas(64) std::atomic<std::uint64_t> gate = 0;
  alignas(64) std::atomic<std::size_t> next = 0;  ///< item that nobody has yet
  std::atomic<std::size_t> count = 0;
  Call call = nullptr;
  const void* item = nullptr;

  alignas(64) std::atomic<int> asleep = 0;  ///< workers
  std::atomic<bool> caller_sleeps = false, stop = false;
  int patience = 0;  ///< looks at what it waits for before a thread goes to sleep
  std::mutex mutex;  ///< for those who sleep, and the next two
  std::condition_variable wake, done;
  std::exception_ptr error;
  std::size_t error_index = 0;

  std::vector<std::thread> workers;

  void work() {
    const std::size_t end = count.load(std::memory_order_relaxed);
    for (std::size_t i = next.fetch_add(1); i < end; i = next.fetch_add(1)) {
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
  bool spin(Ready&& ready) const {
    for (int i = 0; i < patience; ++i) {
      if (ready()) return true;
      pause_briefly();
    }
    return ready();
  }

  bool is_new(std::uint64_t seen) const {
    const std::uint64_t now = gate;
    return (now & kOpen) != 0 && number_of(now) != seen;
  }

  /// False when the loop is over, or has no item left.
  bool enter(std::uint64_t number) {
    if (next.load(std::memory_order_relaxed) >= count.load(std::memory_order_relaxed)) return false;
    std::uint64_t now = gate;
    while ((now & kOpen) != 0 && number_of(now) == number)
      if (gate.compare_exchange_weak(now, now + 1)) return true;
    return false;
  }

  void leave() {
    const std::uint64_t before = gate.fetch_sub(1);
    if ((before & kOpen) != 0 || (before & kInside) > 1 || !caller_sleeps) return;
    const std::lock_guard lock(mutex);
    done.notify_one();
  }

  void live() {
    std::uint64_t seen = 0;
    for (;;) {
      const std::uint64_t known = number_of(gate);
      if (!spin([&] { return is_new(seen); })) {
        // Up again for any later loop, also when it is over by then: the next ones are near.
        std::unique_lock lock(mutex);
        ++asleep;
        wake.wait(lock, [&] { return stop || number_of(gate) != known; });
        --asleep;
        if (stop) return;
      }
      const std::uint64_t number = number_of(gate);
      if (enter(number)) {
        work();
        leave();
      }
      seen = number;
    }
  }

  /// Opens the gate for a loop whose items are set, and wakes as many as it has work for.
  void open() {
    gate = ((number_of(gate.load(std::memory_order_relaxed)) + 1) << kNumberShift) | kOpen;
    const auto sleeping = static_cast<std::size_t>(asleep);
    if (sleeping == 0) return;
    // Who has just found the gate closed sleeps before this goes on.
    { const std::lock_guard lock(mutex); }
    const std::size_t helpers = count.load(std::memory_order_relaxed) - 1;
    if (helpers >= sleeping) return wake.notify_all();
    for (std::size_t i = 0; i < helpers; ++i) wake.notify_one();
  }

  void close() {
    const auto empty = [&] { return (gate & kInside) == 0; };
    gate.fetch_and(~kOpen);
    if (spin(empty)) return;
    std::unique_lock lock(mutex);
    caller_sleeps = true;
    done.wait(lock, empty);
    caller_sleeps = false;
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

Pace& ThreadPool::pace(std::size_t size) {
  return state_->pace[static_cast<std::size_t>(std::bit_width(size)) % state_->pace.size()];
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
  s.count.store(count, std::memory_order_relaxed);
  s.call = call;
  s.item = item;
  s.next.store(0, std::memory_order_relaxed);
  s.open();
  s.work();
  s.close();
  if (s.error != nullptr) std::rethrow_exception(std::exchange(s.error, nullptr));
}

}  // namespace skerry
