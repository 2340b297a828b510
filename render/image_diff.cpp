// SPDX-License-Identifier: MIT
#include "render/image_diff.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace skerry::render {
namespace {

/// Largest difference over the channels.
int difference(const Image& a, const Image& b, std::size_t pixel) {
  int largest = 0;
  for (std::size_t k = 4 * pixel; k < 4 * pixel + 4; ++k) {
    largest = std::max(largest, std::abs(static_cast<int>(a.rgba[k]) - static_cast<int>(b.rgba[k])));
  }
  return largest;
}

/// Finds the 8-connected groups of marked pixels by flooding, and the largest of them.
void find_blobs(std::vector<std::uint8_t>& marked, int width, int height, DiffResult& result) {
  std::vector<int> stack;
  for (int start = 0; start < width * height; ++start) {
    if (!marked[static_cast<std::size_t>(start)]) continue;
    ++result.blobs;
    marked[static_cast<std::size_t>(start)] = 0;
    stack.assign(1, start);
    int size = 0, left = width, right = -1, top = height, bottom = -1;
    while (!stack.empty()) {
      const int at = stack.back(), x = at % width, y = at / width;
      stack.pop_back();
      ++size;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
      for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, height - 1); ++ny) {
        for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, width - 1); ++nx) {
          std::uint8_t& mark = marked[static_cast<std::size_t>(ny) * width + nx];
          if (!mark) continue;
          mark = 0;
          stack.push_back(ny * width + nx);
        }
      }
    }
    if (size > result.worst_blob) {
      result.worst_blob = size;
      result.worst_box = {left, top, right - left + 1, bottom - top + 1};
    }
  }
}

std::string size_text(const Image& image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height);
}

}  // namespace

DiffResult compare(const Image& expected, const Image& actual, const DiffRule& rule) {
  DiffResult result;
  result.same_size = expected.width == actual.width && expected.height == actual.height;
  if (!result.same_size) {
    result.reason = "the picture has " + size_text(actual) + " px, expected " + size_text(expected);
    return result;
  }
  if (expected.rgba == actual.rgba) {
    result.pass = result.identical = true;
    result.reason = "identical";
    return result;
  }
  const std::size_t pixels = static_cast<std::size_t>(expected.width) * expected.height;
  std::vector<std::uint8_t> marked(pixels, 0);
  for (std::size_t i = 0; i < pixels; ++i) {
    const int d = difference(expected, actual, i);
    result.max_difference = std::max(result.max_difference, d);
    result.changed += d > 0;
    if (d <= rule.max_channel) continue;
    ++result.beyond;
    marked[i] = 1;
  }
  if (result.beyond == 0) {
    result.pass = true;
    result.reason = "rounding only: " + std::to_string(result.changed) + " pixels differ by at most " +
                    std::to_string(result.max_difference);
    return result;
  }
  find_blobs(marked, expected.width, expected.height, result);
  result.pass = rule.other_driver && result.beyond <= rule.max_pixels && result.worst_blob <= rule.max_blob;
  const DiffBox& box = result.worst_box;
  result.reason = std::to_string(result.beyond) + " pixels differ by more than " +
                  std::to_string(rule.max_channel) + " (at most " + std::to_string(result.max_difference) +
                  "), in " + std::to_string(result.blobs) + " groups; the largest has " +
                  std::to_string(result.worst_blob) + " at (" + std::to_string(box.x) + ", " +
                  std::to_string(box.y) + "), " + std::to_string(box.width) + " x " +
                  std::to_string(box.height) + " px";
  if (result.pass) result.reason += "; accepted, the expected picture is from another driver";
  return result;
}

Image difference_image(const Image& expected, const Image& actual, const DiffRule& rule) {
  Image out(std::max({expected.width, actual.width, 1}), std::max({expected.height, actual.height, 1}),
            {220, 30, 30, 255});
  const int width = std::min(expected.width, actual.width), height = std::min(expected.height, actual.height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Color a = expected.at(x, y), b = actual.at(x, y);
      const int d =
          std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b), std::abs(a.a - b.a)});
      if (d == 0) {
        // What is equal stays visible, pale, so that one sees where one is.
        const int grey = (a.r * 2 + a.g * 5 + a.b) / 8;
        const auto pale = static_cast<std::uint8_t>(40 + grey / 4);
        out.set(x, y, {pale, pale, pale, 255});
      } else if (d <= rule.max_channel) {
        out.set(x, y, {60, 110, 160, 255});
      } else {
        // Yellow for small, red for large differences.
        const auto green = static_cast<std::uint8_t>(std::max(0, 220 - 3 * d));
        out.set(x, y, {255, green, 40, 255});
      }
    }
  }
  return out;
}

}  // namespace skerry::render
