// SPDX-License-Identifier: MIT
#pragma once

#include <bit>
#include <cstdint>

namespace skerry {

/// 64-bit FNV-1a over words rather than bytes: fast enough to hash every body at every step.
class Fnv1a {
 public:
  void add(std::uint64_t word) {
    // A plain FNV round spreads upwards only; folding the high half back lets the last words reach every bit.
    state_ = (state_ ^ word) * 0x100000001b3ull;
    state_ ^= state_ >> 32;
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(std::uint32_t value) { add(static_cast<std::uint64_t>(value)); }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325ull;
};

}  // namespace skerry
