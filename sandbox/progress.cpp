// SPDX-License-Identifier: MIT
#include "sandbox/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>

namespace skerry::sandbox {

std::string format_seconds(double seconds) {
  char text[40];
  if (seconds < 60) {
    std::snprintf(text, sizeof text, "%.1f s", seconds);
  } else {
    const auto whole = static_cast<long>(std::lround(seconds));
    std::snprintf(text, sizeof text, "%ld min %02ld s", whole / 60, whole % 60);
  }
  return text;
}

std::string format_bytes(std::uint64_t bytes) {
  char text[40];
  const double size = static_cast<double>(bytes);
  if (bytes < 1024)
    std::snprintf(text, sizeof text, "%d B", static_cast<int>(bytes));
  else if (size < 1024.0 * 1024)
    std::snprintf(text, sizeof text, "%.1f KiB", size / 1024);
  else
    std::snprintf(text, sizeof text, "%.1f MiB", size / (1024.0 * 1024));
  return text;
}

Progress::Progress(const Io& io, std::string what, std::uint64_t total)
    : io_(io), what_(std::move(what)), total_(total), start_(Clock::now()), next_(start_) {}

Progress::~Progress() {
  if (shown_) io_.err << "\r\033[K" << std::flush;
}

double Progress::elapsed() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

std::string Progress::line(const std::string& what, std::uint64_t done, std::uint64_t total, double seconds) {
  constexpr int kBar = 20;
  const double share = total > 0 ? static_cast<double>(done) / static_cast<double>(total) : 1;
  const int filled = std::clamp(static_cast<int>(share * kBar), 0, kBar);
  std::string text = what + "  [" + std::string(static_cast<std::size_t>(filled), '#') +
                     std::string(static_cast<std::size_t>(kBar - filled), '.') + "]  " +
                     std::to_string(done) + '/' + std::to_string(total) + " frames";
  if (done == 0 || seconds <= 0) return text;
  const double rate = static_cast<double>(done) / seconds;
  char tail[80];
  std::snprintf(tail, sizeof tail, "  %.0f frames/s  ", rate);
  return text + tail + format_seconds(static_cast<double>(total - std::min(done, total)) / rate) + " left";
}

void Progress::at(std::uint64_t done) {
  if (!io_.terminal) return;
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  shown_ = true;
  io_.err << '\r' << line(what_, done, total_, elapsed()) << "\033[K" << std::flush;
}

}  // namespace skerry::sandbox
