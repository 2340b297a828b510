// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

namespace skerry {

/// Asks for large pages under memory that was taken and not written to yet, where it is large and the system
/// gives them for the asking (Linux with transparent huge pages at `madvise` or `always`): the first touch of
/// each small one takes longer than filling it does.
void want_large_pages(void* data, std::size_t bytes);

/// Reserves, on such pages.
template <class T>
void reserve_large(std::vector<T>& all, std::size_t size) {
  if (size <= all.capacity()) return;
  std::vector<T> larger;
  larger.reserve(std::max(size, 2 * all.capacity()));
  want_large_pages(larger.data(), larger.capacity() * sizeof(T));
  larger.insert(larger.end(), std::make_move_iterator(all.begin()), std::make_move_iterator(all.end()));
  all.swap(larger);
}

template <class T>
void resize_large(std::vector<T>& all, std::size_t size) {
  reserve_large(all, size);
  all.resize(size);
}

}  // namespace skerry
