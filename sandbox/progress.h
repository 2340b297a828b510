// SPDX-License-Identifier: MIT
//
// The line that tells how far a capture is.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "sandbox/io.h"

namespace skerry::sandbox {

/// Rewrites one line on a terminal at most ten times a second; writes nothing anywhere else.
///
///   newtons_cradle  [########............]  120/300 frames  84 frames/s  2.1 s left
class Progress {
 public:
  Progress(const Io& io, std::string what, std::uint64_t total);
  ~Progress();  ///< removes the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void at(std::uint64_t done);
  /// Wall time since the construction [s].
  double elapsed() const;

  /// The text for a given state; apart so that it can be tested. @param seconds elapsed
  static std::string line(const std::string& what, std::uint64_t done, std::uint64_t total, double seconds);

 private:
  using Clock = std::chrono::steady_clock;
  const Io& io_;
  std::string what_;
  std::uint64_t total_;
  Clock::time_point start_, next_;
  bool shown_ = false;
};

/// "12.3 s", "2 min 05 s"
std::string format_seconds(double seconds);
/// "640 B", "12.3 KiB", "1.2 MiB"
std::string format_bytes(std::uint64_t bytes);

}  // namespace skerry::sandbox
