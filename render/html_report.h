// SPDX-License-Identifier: MIT
//
// Pictures that were expected and pictures that came, on one HTML page that needs no other file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/image_diff.h"

namespace skerry::render {

/// One comparison. What the picture shows also has a state, a hash of its own, judged apart: a picture can
/// change because the drawing did or because what is drawn did.
struct ReportScene {
  std::string name;
  std::string about;              ///< one line: what was drawn
  std::string problem;            ///< why there is no picture; then `actual` is empty
  std::optional<Image> expected;  ///< none: there was no picture yet, or it equals `actual`
  Image actual;
  bool picture_good = false;
  DiffResult diff;             ///< of `expected` and `actual`
  std::string picture_reason;  ///< one sentence
  std::string state_expected;  ///< empty: unknown
  std::string state_actual;
  std::string repeat, bless;  ///< commands

  [[nodiscard]] bool state_good() const { return state_expected == state_actual; }
};

struct ReportPage {
  std::string title;
  std::string about;  ///< driver, machine
  DiffRule rule;      ///< its largest channel difference
  std::vector<ReportScene> scenes;
};

/// The page as HTML with pictures, style and script inside.
///
/// Scenes that differ come first, each with both pictures side by side, under a slider, blinking, their
/// difference with a gain, a map of it, and the largest group of wrong pixels enlarged. With `#selftest` in
/// its address the page counts the differing pixels again, works its own controls, and leaves the result in
/// the `data-verdict` of the document: "good: ..." or "bad: ...".
[[nodiscard]] std::string html_report(const ReportPage& page);

/// Bytes in base 64 with padding (RFC 4648, section 4).
[[nodiscard]] std::string base64(const std::vector<std::uint8_t>& bytes);

}  // namespace skerry::render
