// SPDX-License-Identifier: MIT
//
// Where frames go: video, PNG sequence, GIF, hashes, nowhere.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "render/image.h"

namespace skerry::render {

/// A named point in time of the video.
struct Chapter {
  double seconds = 0;
  std::string title;
};

struct StreamInfo {
  int width = 0, height = 0;  ///< [px]
  int fps = 60;               ///< frames per second, constant
  std::string title;          ///< metadata
  std::string comment;        ///< metadata: the command line that makes this file
  std::vector<Chapter> chapters;
};

/// What came out.
struct SinkReport {
  std::string path;          ///< of the file, or the pattern
  std::int64_t frames = 0;   ///< that were put in
  std::int64_t repeats = 0;  ///< of them: the frame before once more, neither converted nor copied
  std::uint64_t bytes = 0;   ///< written
  std::string format;        ///< e.g. "h264 yuv420p in mp4"
};

/// Takes frames in order: begin(), frame() any number of times, end().
///
/// Nothing appears under the final name before end() has succeeded; a sink that is destroyed without end()
/// removes what it had written. Encoders work in their own threads behind a short queue, so a failure (disk
/// full) may be thrown by a later frame() or by end().
class FrameSink {
 public:
  virtual ~FrameSink() = default;

  /// @throws std::invalid_argument for sizes or rates that the format cannot hold, with the values
  /// @throws EnvironmentError with the file's name
  virtual void begin(const StreamInfo& info) = 0;

  /// Takes a copy of `image`; it may be reused at once.
  /// @throws std::invalid_argument if its size is not that of begin()
  /// @throws EnvironmentError with the file's name
  virtual void frame(const Image& image) = 0;

  /// The last frame once more; cheaper than frame() with the same picture.
  virtual void repeat() = 0;

  /// Starts a chapter at the next frame. Formats without chapters ignore it.
  virtual void chapter(const std::string& title);

  /// Finishes the file and gives it its name. After that, and after it failed, nothing else may be called.
  /// @throws EnvironmentError with the file's name
  virtual SinkReport end() = 0;
};

struct SinkOptions {
  bool sharp = false;     ///< 4:4:4: thin coloured lines keep their colour; some players cannot show it
  bool lossless = false;  ///< every bit of the converted picture (for mp4, mkv, webm); implies sharp
  int quality = 18;       ///< CRF of x264, 0..51; lower is better
  /// An encoder of FFmpeg for mp4, mkv and webm, such as libx265 or mpeg4; empty: the usual one.
  std::string encoder{};
};

/// Chooses by name: `.mp4 .mkv` H.264, `.webm` VP9, `.gif`, `.png` with a `%06d`-like pattern or (one file)
/// without, a directory (existing, or with a trailing slash): `frame_%06d.png` in it, `.txt` or `.hash`: one
/// digest a line, `null:` counts only.
/// @throws std::invalid_argument for an unknown extension, with the list of known ones
[[nodiscard]] std::unique_ptr<FrameSink> make_sink(const std::filesystem::path& path,
                                                   const SinkOptions& options = {});

/// Whether the name of a PNG has a counter in its last part, such as %06d, for a file of each frame. Other
/// '%' are themselves.
/// @throws std::invalid_argument for several counters, or one that is none, such as %s
[[nodiscard]] bool counts_frames(const std::filesystem::path& path);

/// Several sinks fed at once, e.g. a video and its hashes. Reports are those of the first.
[[nodiscard]] std::unique_ptr<FrameSink> tee(std::vector<std::unique_ptr<FrameSink>> sinks);

}  // namespace skerry::render
