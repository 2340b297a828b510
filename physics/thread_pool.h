// SPDX-License-Identifier: MIT
//
// A small pool: a fixed number of threads that share the items of one loop at a time.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <type_traits>

namespace skerry {

/// Finds out by the clock whether loops of one kind are done sooner by all threads or by the caller alone:
/// where what one processor wrote takes long to get to the next one, short loops that hand on much gain
/// nothing. It decides who computes something, never what.
class Pace {
 public:
  /// Whether to share the next loop: one is, one is not, and then what took less time; the other way is tried
  /// again now and then.
  bool share();
  /// @param seconds  that it took for so much work
  void note(bool shared, double seconds, double work);

 private:
  unsigned turn_ = 0;
  double alone_ = 0, shared_ = 0;  ///< seconds for a unit of work; 0: not known yet
};

/// Runs loops on `threads` threads, the caller's among them. With one thread nothing is started and nothing
/// is locked. Threads that wait look for the next loop for some 400 us before they sleep, unless there are
/// more of them than processors.
class ThreadPool {
 public:
  /// @throws std::invalid_argument unless 1 <= threads <= 256
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const;
  /// That of loops over about so many things, for one kind of loop.
  Pace& pace(std::size_t size);
  /// Calls `item(i)` once for each i in [0, count), at the same time, and returns when all are done. Items
  /// must not touch each other's data; then the result does not depend on the number of threads. They begin
  /// in ascending order: an item may wait for lower ones. If items throw, the exception of the lowest i is
  /// thrown here, after all others have ended. Not to be called from within an item.
  template <class Item>
  void run(std::size_t count, Item&& item) {
    using Plain = std::remove_reference_t<Item>;
    // A pointer to the item and a function that calls it: nothing is allocated.
    run(
        count, [](const void* it, std::size_t i) { (*static_cast<const Plain*>(it))(i); }, &item);
  }

 private:
  using Call = void (*)(const void* item, std::size_t i);
  void run(std::size_t count, Call call, const void* item);

  struct State;
  std::unique_ptr<State> state_;
};

/// Calls `item(begin, end)` for pieces of [0, count), `piece` long, shared by the threads of `pool`; without
/// a pool, or where there is but one piece, once for all. What it does must not depend on how it is cut.
template <class Item>
void share(ThreadPool* pool, std::size_t count, std::size_t piece, Item&& item) {
  if (pool == nullptr || pool->threads() == 1 || count <= piece) {
    if (count > 0) item(std::size_t{0}, count);
    return;
  }
  pool->run((count + piece - 1) / piece, [&](std::size_t i) {
    const std::size_t from = i * piece;
    item(from, from + piece < count ? from + piece : count);
  });
}

/// Calls `item(i)` for each i below `count` in this way.
template <class Item>
void share_each(ThreadPool* pool, std::size_t count, std::size_t piece, Item&& item) {
  share(pool, count, piece, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) item(i);
  });
}

/// As `share`, and calls `other` once meanwhile, which shares nothing with the items that is written: what
/// only one thread can do costs no time as long as the others have pieces.
template <class Item, class Other>
void share_beside(ThreadPool* pool, std::size_t count, std::size_t piece, Item&& item, Other&& other) {
  if (pool == nullptr || pool->threads() == 1 || count <= piece) {
    other();
    if (count > 0) item(std::size_t{0}, count);
    return;
  }
  pool->run((count + piece - 1) / piece + 1, [&](std::size_t i) {
    if (i == 0) return other();
    const std::size_t from = (i - 1) * piece;
    item(from, from + piece < count ? from + piece : count);
  });
}

/// Whether `test(i)` holds for any i below `count`; not all of them are asked, as soon as one does.
template <class Test>
bool any_of(ThreadPool* pool, std::size_t count, std::size_t piece, Test&& test) {
  std::atomic<bool> any = false;
  share(pool, count, piece, [&](std::size_t from, std::size_t to) {
    if (any.load(std::memory_order_relaxed)) return;
    for (std::size_t i = from; i < to; ++i) {
      if (!test(i)) continue;
      any.store(true, std::memory_order_relaxed);
      return;
    }
  });
  return any;
}

/// Makes `most` at least `value`, whichever threads do so at the same time.
inline void raise_to(std::atomic<double>& most, double value) {
  double known = most;
  while (known < value && !most.compare_exchange_weak(known, value)) {
  }
}

/// The largest of what `item(begin, end)` gives for pieces of [0, count) as those of `share`, at least 0; a
/// NaN does not count.
template <class Item>
double largest_of(ThreadPool* pool, std::size_t count, std::size_t piece, Item&& item) {
  std::atomic<double> largest = 0;
  share(pool, count, piece, [&](std::size_t from, std::size_t to) { raise_to(largest, item(from, to)); });
  return largest;
}

}  // namespace skerry
