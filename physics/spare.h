// SPDX-License-Identifier: MIT
//
// Memory that is used again: what a step needs for a moment comes from a stack of spare vectors of its thread
// and goes back there, so that a steady step allocates nothing and large islands touch warm pages.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "physics/large_pages.h"

namespace skerry {

namespace spare {

// More than any step has in hand at a time; what is given beyond is freed.
inline constexpr std::size_t kMost = 16;

template <class T>
std::vector<T>& stack() {
  thread_local std::vector<T> all = [] {
    std::vector<T> empty;
    empty.reserve(kMost);
    return empty;
  }();
  return all;
}

}  // namespace spare

/// An empty T (a vector, or a struct of vectors whose user empties it) in the memory of an earlier one.
template <class T>
T take_spare() {
  std::vector<T>& all = spare::stack<T>();
  if (all.empty()) return T{};
  T one = std::move(all.back());
  all.pop_back();
  return one;
}

/// Gives memory back to this thread. What is in `used` does not matter.
template <class T>
requires(!std::is_reference_v<T>) void give_spare(T&& used) {
  using Plain = std::remove_cvref_t<T>;
  std::vector<Plain>& all = spare::stack<Plain>();
  if constexpr (requires { used.clear(); }) used.clear();
  if (all.size() < spare::kMost) all.push_back(std::forward<T>(used));
}

/// Resizes a vector that is used again and again. Where it has to take memory, it takes four times what it
/// needs: what is a little longer each time would else take new pages every time, and these take longer than
/// filling them does. Pages that are not used yet are none.
template <class T>
void resize_with_room(std::vector<T>& all, std::size_t size) {
  if (size > all.capacity()) reserve_large(all, 4 * size);
  all.resize(size);
}

/// A spare T for the length of a scope, empty if it has `clear`. It stays where it is: structs of many
/// vectors cost no more than one.
template <class T>
class Spare {
 public:
  Spare() {
    std::vector<std::unique_ptr<T>>& all = pool();
    if (all.empty()) {
      one_ = new T{};
    } else {
      one_ = all.back().release();
      all.pop_back();
    }
  }
  ~Spare() {
    std::vector<std::unique_ptr<T>>& all = pool();
    if constexpr (requires { one_->clear(); }) one_->clear();
    if (all.size() < spare::kMost)
      all.emplace_back(one_);
    else
      delete one_;
  }
  Spare(const Spare&) = delete;
  Spare& operator=(const Spare&) = delete;

  T& operator*() { return *one_; }
  const T& operator*() const { return *one_; }
  T* operator->() { return one_; }
  const T* operator->() const { return one_; }

 private:
  static std::vector<std::unique_ptr<T>>& pool() { return spare::stack<std::unique_ptr<T>>(); }

  T* one_;
};

}  // namespace skerry
