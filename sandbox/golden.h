// SPDX-License-Identifier: MIT
//
// Golden images: scenes by name, what of them was accepted, and the judgement of a new picture.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/image_diff.h"
#include "sandbox/demo.h"
#include "sandbox/painter.h"
#include "sandbox/picture_options.h"

namespace skerry::sandbox {

/// One row of `scenes.txt`: a name, and words as after `skerry capture`.
struct GoldenScene {
  std::string name;
  std::string words;  ///< "stack --at 0.5 --overlay none,contacts", with the size
  std::string demo;   ///< name or path
  DemoOptions options{};
  double at = 0;             ///< [s]
  PictureOptions picture{};  ///< overlays as typed, selection
  PaintOptions paint{};
};

/// Reads `scenes.txt`: a scene a line, `#` begins a comment.
/// @throws ScriptError with file and line for a line it cannot use, for a name twice
std::vector<GoldenScene> read_golden_scenes(const std::filesystem::path& file);

/// A scene as words. @throws UsageError for options it does not know and values out of range
GoldenScene golden_scene(const std::string& name, const std::string& words);

/// What a scene looks like now.
struct GoldenShot {
  render::Image image;
  std::uint64_t state = 0;  ///< hash of the world
  std::string driver;
};

/// Runs the demo up to the scene's moment and paints it with the software rasteriser: the picture that
/// `skerry capture` makes of the same words. @param folder with the demos, "" for the usual one
GoldenShot take_golden_shot(const GoldenScene& scene, const std::string& folder);

/// What was blessed for a scene: a line of `accepted.txt`.
struct Accepted {
  std::string name;
  std::uint64_t state = 0;
  /// Pictures that pass at once: that of the PNG file first, then those that differed from it by rounding.
  std::vector<std::uint64_t> digests;
  std::string driver;  ///< that drew the PNG file
};

/// Reads and writes `accepted.txt`. A missing file is an empty list. @throws ScriptError with file and line
std::vector<Accepted> read_accepted(const std::filesystem::path& file);
void write_accepted(const std::filesystem::path& file, const std::vector<Accepted>& list);

/// A picture and a state, each judged without the other.
struct GoldenVerdict {
  bool picture_good = false;
  bool picture_new = false;               ///< nothing was blessed
  bool by_digest = false;                 ///< passed at once
  std::optional<render::Image> expected;  ///< where pixels had to be compared
  render::DiffResult diff;
  std::string picture_reason;
  bool state_good = false;
  bool state_new = false;
};

/// The rule of the golden images: an accepted digest passes; else every channel of every pixel must be within
/// 2/255 of the PNG, or, when another driver drew that, but for 64 pixels in groups of at most 6.
GoldenVerdict judge(const GoldenShot& shot, const Accepted* accepted, const std::filesystem::path& png);

/// The rule with the allowance for other drivers where `shot` needs it.
render::DiffRule golden_rule(const GoldenShot& shot, const Accepted& accepted);

}  // namespace skerry::sandbox
