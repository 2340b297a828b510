// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace skerry::sandbox {

/// A series that stays small however long it goes on: samples at equal distances from the first, and the
/// newest one. When there are too many of them every second one goes.
template <class Sample, std::size_t kMost>
class Thinned {
 public:
  void add(const Sample& sample) {
    // Sample k stays if k is a multiple of the stride; the newest is always the last entry.
    if (count_ > 0 && (count_ - 1) % stride_ != 0) samples_.pop_back();
    samples_.push_back(sample);
    const bool stays = count_++ % stride_ == 0;
    if (samples_.size() <= kMost || !stays) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < samples_.size(); i += 2) samples_[kept++] = samples_[i];
    if (samples_.size() % 2 == 0) samples_[kept++] = sample;
    samples_.resize(kept);
    stride_ *= 2;
  }

  /// At most `kMost` + 1 of them.
  const std::vector<Sample>& samples() const { return samples_; }

 private:
  std::vector<Sample> samples_;
  std::uint64_t stride_ = 1, count_ = 0;
};

}  // namespace skerry::sandbox
