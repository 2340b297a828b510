// SPDX-License-Identifier: MIT
//
// What all sinks have in common, and their makers; used inside of render/ only.
#pragma once

#include <memory>
#include <string>

#include "render/frame_sink.h"

namespace skerry::render {

/// Checks the order of the calls and the sizes, and counts. Derived classes implement open, put, again,
/// finish.
class SinkBase : public FrameSink {
 public:
  explicit SinkBase(std::string name) : name_(std::move(name)) {}

  void begin(const StreamInfo& info) final;
  void frame(const Image& image) final;
  void repeat() final;
  void chapter(const std::string& title) override;
  SinkReport end() final;

 protected:
  virtual void open() = 0;
  virtual void put(const Image& image) = 0;
  virtual void again() = 0;
  /// Fills in bytes and format.
  virtual void finish(SinkReport& report) = 0;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const StreamInfo& info() const { return info_; }
  [[nodiscard]] std::int64_t frames() const { return frames_; }

 private:
  enum class Phase { New, Open, Done };
  void expect_open(const char* call) const;

  std::string name_;
  StreamInfo info_;
  std::int64_t frames_ = 0, repeats_ = 0;
  Phase phase_ = Phase::New;
};

enum class VideoKind { Mp4, Mkv, Webm, Gif };

/// Video through libavcodec and libavformat.
[[nodiscard]] std::unique_ptr<FrameSink> make_video_sink(const std::string& path, VideoKind kind,
                                                         const SinkOptions& options);

}  // namespace skerry::render
