// SPDX-License-Identifier: MIT
#include "render/palette.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>

namespace skerry::render {
namespace {

constexpr int kCells = 1 << 15;

int cell_of(const std::uint8_t* p) {
  return (p[0] >> 3) << 10 | (p[1] >> 3) << 5 | p[2] >> 3;
}

/// A cell of the histogram: how many pixels, and the sum of their colours.
struct Cell {
  std::int64_t count = 0;
  std::int64_t sum[3] = {0, 0, 0};
  [[nodiscard]] double mean(int channel) const {
    return static_cast<double>(sum[channel]) / static_cast<double>(count);
  }
};

/// Cells first..last of the sorted list that share a colour.
struct Box {
  std::size_t first, last;
  int channel;    // of largest spread
  double spread;  // sum of squared distances to the mean in that channel
};

Box measure(const std::vector<Cell>& cells, std::size_t first, std::size_t last) {
  Box box{first, last, 0, 0};
  for (int channel = 0; channel < 3; ++channel) {
    double weight = 0, sum = 0, square = 0;
    for (std::size_t i = first; i < last; ++i) {
      const double count = static_cast<double>(cells[i].count), mean = cells[i].mean(channel);
      weight += count;
      sum += count * mean;
      square += count * mean * mean;
    }
    const double spread = square - sum * sum / weight;
    if (spread > box.spread) {
      box.spread = spread;
      box.channel = channel;
    }
  }
  return box;
}

}  // namespace

Palette::Palette(const Image& image) : cells_(kCells, -1) {
  std::vector<Cell> all(kCells), used;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    const std::uint8_t* p = &image.rgba[i];
    Cell& cell = all[static_cast<std::size_t>(cell_of(p))];
    ++cell.count;
    for (int k = 0; k < 3; ++k) cell.sum[k] += p[k];
  }
  std::copy_if(all.begin(), all.end(), std::back_inserter(used),
               [](const Cell& cell) { return cell.count > 0; });
  if (used.empty()) return;

  // Split the box with the largest spread at its mean until there are 256.
  std::vector<Box> boxes{measure(used, 0, used.size())};
  while (boxes.size() < colors_.size()) {
    const auto widest = std::max_element(boxes.begin(), boxes.end(),
                                         [](const Box& a, const Box& b) { return a.spread < b.spread; });
    if (widest->last - widest->first < 2 || !(widest->spread > 0)) break;
    const Box box = *widest;
    double weight = 0, sum = 0;
    for (std::size_t i = box.first; i < box.last; ++i) {
      weight += static_cast<double>(used[i].count);
      sum += static_cast<double>(used[i].sum[box.channel]);
    }
    const double mean = sum / weight;
    const auto begin = used.begin() + static_cast<std::ptrdiff_t>(box.first);
    const auto end = used.begin() + static_cast<std::ptrdiff_t>(box.last);
    const auto middle =
        std::stable_partition(begin, end, [&](const Cell& cell) { return cell.mean(box.channel) < mean; });
    const auto split = static_cast<std::size_t>(middle - used.begin());
    if (split == box.first || split == box.last) {
      widest->spread = 0;
      continue;
    }
    *widest = measure(used, box.first, split);
    boxes.push_back(measure(used, split, box.last));
  }
  for (const Box& box : boxes) {
    Cell total;
    for (std::size_t i = box.first; i < box.last; ++i) {
      total.count += used[i].count;
      for (int k = 0; k < 3; ++k) total.sum[k] += used[i].sum[k];
    }
    const auto rounded = [&](int k) { return static_cast<std::uint8_t>(std::lround(total.mean(k))); };
    colors_[static_cast<std::size_t>(size_++)] = {rounded(0), rounded(1), rounded(2), 255};
  }
}

std::uint8_t Palette::nearest(int r, int g, int b) const {
  int best = 0, least = 1 << 30;
  for (int i = 0; i < size_; ++i) {
    const Color c = colors_[static_cast<std::size_t>(i)];
    const int dr = c.r - r, dg = c.g - g, db = c.b - b;
    // Weights of the luma: green errors show most.
    const int error = 2 * dr * dr + 4 * dg * dg + db * db;
    if (error < least) {
      least = error;
      best = i;
    }
  }
  return static_cast<std::uint8_t>(best);
}

double Palette::map(const Image& image, std::uint8_t* indices, std::ptrdiff_t stride) {
  std::int64_t wrong = 0;
  const std::uint8_t* p = image.rgba.data();
  for (int y = 0; y < image.height; ++y) {
    std::uint8_t* row = indices + y * stride;
    for (int x = 0; x < image.width; ++x, p += 4) {
      std::int16_t& index = cells_[static_cast<std::size_t>(cell_of(p))];
      if (index < 0) index = nearest((p[0] & 0xf8) | 4, (p[1] & 0xf8) | 4, (p[2] & 0xf8) | 4);
      row[x] = static_cast<std::uint8_t>(index);
      const Color c = colors_[row[x]];
      wrong += std::abs(c.r - p[0]) > 16 || std::abs(c.g - p[1]) > 16 || std::abs(c.b - p[2]) > 16;
    }
  }
  return static_cast<double>(wrong) / (static_cast<double>(image.width) * image.height);
}

}  // namespace skerry::render
