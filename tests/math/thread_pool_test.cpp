// SPDX-License-Identifier: MIT
#include "physics/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "physics/progress.h"

namespace skerry {
namespace thread_pool_test {

TEST(ThreadPool, CallsEveryItemOnceForAnyNumberOfThreads) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (int round = 0; round < 200; ++round) {
      std::vector<int> calls(static_cast<std::size_t>(round), 0);
      pool.run(calls.size(), [&](std::size_t i) { ++calls[i]; });
      EXPECT_EQ(std::accumulate(calls.begin(), calls.end(), 0), round);
      for (const int count : calls) ASSERT_EQ(count, 1);
    }
  }
}

// Loops of all lengths, at once and after rests in which threads fall asleep; also more threads than
// processors.
TEST(ThreadPool, LosesNoItemWhateverTheOthersAreAt) {
  const auto processors = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  for (const int threads : {2, 3, processors + 1}) {
    ThreadPool pool(threads);
    std::mt19937_64 random(static_cast<std::uint64_t>(threads));
    std::uint64_t sum = 0, expected = 0;
    for (int round = 0; round < 5000; ++round) {
      const std::size_t count = random() % 9;
      const std::uint64_t work = random() % 200;
      const auto value_of = [&](std::size_t i) {
        std::uint64_t value = i + 1;
        for (std::uint64_t k = 0; k < work; ++k) value = value * 2862933555777941757u + k;
        return value;
      };
      std::vector<std::uint64_t> values(count, 0);
      pool.run(count, [&](std::size_t i) { values[i] += value_of(i); });
      for (std::size_t i = 0; i < count; ++i) expected += value_of(i);
      sum = std::accumulate(values.begin(), values.end(), sum);
      ASSERT_EQ(sum, expected) << threads << " threads, loop " << round;
      if (random() % 100 == 0) std::this_thread::sleep_for(std::chrono::microseconds(random() % 2000));
    }
  }
}

TEST(ThreadPool, LetsItemsWaitForLowerOnes) {
  for (const int threads : {2, 5}) {
    ThreadPool pool(threads);
    for (int round = 0; round < 200; ++round) {
      std::vector<Progress> done(7);
      std::vector<int> value(done.size(), 0);
      pool.run(done.size(), [&](std::size_t i) {
        if (i > 0) {
          done[i - 1].wait_for(1);
          value[i] = value[i - 1] + 1;
        }
        done[i].reached(1);
      });
      ASSERT_EQ(value.back(), 6) << threads << " threads, loop " << round;
    }
  }
}

TEST(ThreadPool, RefusesASillyNumberOfThreads) {
  EXPECT_THROW(ThreadPool(0), std::invalid_argument);
  EXPECT_THROW(ThreadPool(100000), std::invalid_argument);
}

/// Loops of which the shared way takes so many times as long. @return how many of `count` were shared
int shared_of(Pace& pace, double ratio, int count) {
  int shared = 0;
  for (int i = 0; i < count; ++i) {
    const bool share = pace.share();
    pace.note(share, (share ? ratio : 1) * 1e-6 * 100, 100);
    shared += share;
  }
  return shared;
}

TEST(Pace, GoesTheFasterWayAndTriesTheOtherOneNowAndThen) {
  for (const bool gains : {true, false}) {
    Pace pace;
    EXPECT_TRUE(pace.share());
    pace.note(true, gains ? 0.5 : 2, 1);
    EXPECT_FALSE(pace.share());
    pace.note(false, 1, 1);
    int shared = 0;
    for (int i = 0; i < 640; ++i) {
      const bool share = pace.share();
      pace.note(share, share == gains ? 0.7 : 1, 1);
      shared += share;
    }
    EXPECT_EQ(shared, gains ? 630 : 10);
  }
}

TEST(Pace, NoticesThatItChanged) {
  Pace pace;
  EXPECT_GE(shared_of(pace, 0.7, 650), 635);
  // A loop that was interrupted says little.
  EXPECT_TRUE(pace.share());
  pace.note(true, 1, 100);
  EXPECT_GE(shared_of(pace, 0.7, 100), 90);
  // Other programs run.
  shared_of(pace, 3, 100);
  EXPECT_LE(shared_of(pace, 3, 640), 15);
  // It takes some tries until it is known that they do not any more.
  shared_of(pace, 0.5, 6400);
  EXPECT_GE(shared_of(pace, 0.5, 640), 620);
}

TEST(Pace, IsKeptByPowersOfTwoOfTheSize) {
  ThreadPool pool(2);
  EXPECT_EQ(&pool.pace(1000), &pool.pace(513));
  EXPECT_NE(&pool.pace(1000), &pool.pace(2000));
  EXPECT_NE(&pool.pace(0), &pool.pace(1));
}

/// For a moment at most: true as soon as `ready` is.
template <class Ready>
bool waits_for(Ready&& ready) {
  const auto begin = std::chrono::steady_clock::now();
  while (!ready()) {
    if (std::chrono::steady_clock::now() - begin > std::chrono::milliseconds(300)) return false;
    std::this_thread::yield();
  }
  return true;
}

TEST(ThreadPool, ThrowsTheFirstExceptionAfterAllItemsEnded) {
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    std::vector<int> calls(100, 0);
    try {
      pool.run(calls.size(), [&](std::size_t i) {
        ++calls[i];
        if (i % 10 == 7) throw std::runtime_error("item " + std::to_string(i));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "item 7");
    }
    EXPECT_EQ(std::accumulate(calls.begin(), calls.end(), 0), 100);
    // And it still works.
    pool.run(4, [&](std::size_t i) { calls[i] = -1; });
    EXPECT_EQ(calls[3], -1);
  }
}

TEST(ThreadPool, ThrowsThatOfTheLowestItemThoughItComesLater) {
  ThreadPool pool(2);
  int later = 0;
  for (int round = 0; round < 5; ++round) {
    std::atomic<bool> thrown = false;
    try {
      pool.run(2, [&](std::size_t i) {
        if (i == 0 && waits_for([&] { return thrown.load(); })) {
          ++later;
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        if (i == 1) thrown = true;
        throw std::runtime_error("item " + std::to_string(i));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "item 0");
    }
  }
  EXPECT_GT(later, 0);
}

/// With more threads than processors the caller sleeps while another one is at the last item.
TEST(ThreadPool, TheCallerComesBackWhenTheOthersAreThrough) {
  ThreadPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())) + 1);
  const std::thread::id caller = std::this_thread::get_id();
  int helped = 0;
  for (int round = 0; round < 5; ++round) {
    std::atomic<bool> begun = false;
    std::atomic<int> done = 0;
    pool.run(2, [&](std::size_t) {
      if (std::this_thread::get_id() == caller) {
        helped += waits_for([&] { return begun.load(); });
      } else {
        begun = true;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
      ++done;
    });
    EXPECT_EQ(done, 2);
  }
  EXPECT_GT(helped, 0);
}

}  // namespace thread_pool_test
}  // namespace skerry
