// SPDX-License-Identifier: MIT
#include "physics/thread_pool.h"

#include <gtest/gtest.h>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace skerry {
namespace {

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

TEST(ThreadPool, ThrowsTheFirstExceptionAfterAllItemsEnded) {
  ThreadPool pool(3);
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

TEST(ThreadPool, RefusesASillyNumberOfThreads) {
  EXPECT_THROW(ThreadPool(0), std::invalid_argument);
  EXPECT_THROW(ThreadPool(100000), std::invalid_argument);
}

}  // namespace
}  // namespace skerry
