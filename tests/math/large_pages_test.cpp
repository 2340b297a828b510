// SPDX-License-Identifier: MIT
#include "physics/large_pages.h"

#include <cstdint>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace skerry {
namespace large_pages_test {

TEST(LargePages, WhatGrowsKeepsItsElementsAndGrowsSeldom) {
  std::vector<std::unique_ptr<int>> all;
  resize_large(all, 3);
  for (int i = 0; i < 3; ++i) all[static_cast<std::size_t>(i)] = std::make_unique<int>(i);
  const std::size_t room = all.capacity();
  reserve_large(all, room);
  EXPECT_EQ(all.capacity(), room);
  reserve_large(all, room + 1);
  EXPECT_GE(all.capacity(), 2 * room);
  ASSERT_EQ(all.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(*all[static_cast<std::size_t>(i)], i);
  resize_large(all, 2);
  EXPECT_EQ(all.size(), 2u);
}

#ifdef __linux__
/// What /proc/self/smaps says of the memory around an address.
std::string flags_of(const void* address) {
  const auto place = reinterpret_cast<std::uintptr_t>(address);
  std::ifstream maps("/proc/self/smaps");
  bool within = false;
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t begin = 0, end = 0;
    char dash = 0;
    if (std::istringstream range(line); range >> std::hex >> begin >> dash >> end && dash == '-')
      within = begin <= place && place < end;
    if (within && line.rfind("VmFlags:", 0) == 0) return line + " ";
  }
  return {};
}

TEST(LargePages, AreAskedForUnderWhatIsLarge) {
  if (!std::ifstream("/sys/kernel/mm/transparent_hugepage/enabled")) GTEST_SKIP() << "a system without them";
  constexpr std::size_t kSize = std::size_t{16} << 20;
  std::vector<char> large, usual;
  reserve_large(large, kSize);
  usual.reserve(kSize);
  if (flags_of(usual.data() + kSize / 2).find(" hg ") != std::string::npos)
    GTEST_SKIP() << "all memory has them";
  EXPECT_NE(flags_of(large.data() + kSize / 2).find(" hg "), std::string::npos);
}
#endif

}  // namespace large_pages_test
}  // namespace skerry
