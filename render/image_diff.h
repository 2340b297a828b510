// SPDX-License-Identifier: MIT
//
// Is this the same picture? The rule of the golden images.
#pragma once

#include <cstdint>
#include <string>

#include "render/image.h"

namespace skerry::render {

/// Limits of the rule. The defaults let pass what processors and drivers do to the same list of shapes, and
/// nothing that a person did: measured on llvmpipe, roundings reach 2/255, another driver moves single pixels
/// of edges, while a missing normal or a changed digit is a connected blob of 26 pixels and more.
struct DiffRule {
  int max_channel = 2;        ///< largest difference that counts as rounding [1/255]
  bool other_driver = false;  ///< the expected picture came from another driver:
  int max_pixels = 64;        ///<   so many pixels may differ by more,
  int max_blob = 6;           ///<   in 8-connected groups of at most this size
};

struct DiffBox {
  int x = 0, y = 0, width = 0, height = 0;  ///< [px]
};

struct DiffResult {
  bool pass = false;
  bool identical = false;    ///< same digest
  bool same_size = false;    ///< if not, the rest is empty
  int max_difference = 0;    ///< over all channels [1/255]
  std::int64_t changed = 0;  ///< pixels that differ at all
  std::int64_t beyond = 0;   ///< pixels that differ by more than max_channel
  int blobs = 0;             ///< 8-connected groups of those
  int worst_blob = 0;        ///< pixels in the largest
  DiffBox worst_box;         ///< around the largest
  std::string reason;        ///< one sentence
};

/// Compares two pictures. Same input, same result; O(pixels).
[[nodiscard]] DiffResult compare(const Image& expected, const Image& actual, const DiffRule& rule = {});

/// The differences, amplified: grey where equal, blue where they differ by rounding, from yellow to red
/// beyond. Pictures of different
/// size are laid over each other at the top left; what only one has is red.
[[nodiscard]] Image difference_image(const Image& expected, const Image& actual, const DiffRule& rule = {});

}  // namespace skerry::render
