// SPDX-License-Identifier: MIT
#include "render/frame_sink.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "render/bounded_queue.h"
#include "render/error.h"
#include "render/output_file.h"
#include "render/sink_base.h"
#include "render/utf8.h"

namespace skerry::render {

void FrameSink::chapter(const std::string&) {}

void SinkBase::begin(const StreamInfo& info) {
  if (phase_ != Phase::New) throw std::logic_error(name_ + ": begin() was called before");
  if (info.width < 1 || info.height < 1 || info.width > 16384 || info.height > 16384 || info.fps < 1 ||
      info.fps > 1000) {
    throw std::invalid_argument(name_ + ": needs 1 to 16384 px a side and 1 to 1000 frames/s, got " +
                                std::to_string(info.width) + " x " + std::to_string(info.height) + " px, " +
                                std::to_string(info.fps) + " frames/s");
  }
  info_ = info;
  info_.title = valid_utf8(info.title);
  info_.comment = valid_utf8(info.comment);
  for (Chapter& chapter : info_.chapters) chapter.title = valid_utf8(chapter.title);
  open();
  phase_ = Phase::Open;
}

void SinkBase::expect_open(const char* call) const {
  if (phase_ != Phase::Open) throw std::logic_error(name_ + ": " + call + " outside of begin() and end()");
}

void SinkBase::frame(const Image& image) {
  expect_open("frame()");
  if (image.width != info_.width || image.height != info_.height) {
    throw std::invalid_argument(name_ + ": frame " + std::to_string(frames_) + " has " +
                                std::to_string(image.width) + " x " + std::to_string(image.height) +
                                " px, begin() said " + std::to_string(info_.width) + " x " +
                                std::to_string(info_.height));
  }
  put(image);
  ++frames_;
}

void SinkBase::repeat() {
  expect_open("repeat()");
  if (frames_ == 0) throw std::logic_error(name_ + ": repeat() before the first frame");
  again();
  ++frames_;
  ++repeats_;
}

void SinkBase::chapter(const std::string& title) {
  info_.chapters.push_back({static_cast<double>(frames_) / info_.fps, valid_utf8(title)});
}

SinkReport SinkBase::end() {
  expect_open("end()");
  SinkReport report;
  report.path = name_;
  report.frames = frames_;
  report.repeats = repeats_;
  phase_ = Phase::Done;  // whether or not it succeeds
  finish(report);
  return report;
}

namespace {

class NullSink final : public SinkBase {
 public:
  using SinkBase::SinkBase;

 private:
  void open() override {}
  void put(const Image&) override {}
  void again() override {}
  void finish(SinkReport& report) override { report.format = "nothing"; }
};

/// "INDEX DIGEST" a line, the size first: small enough to commit, and enough to see which frame moved.
class HashSink final : public SinkBase {
 public:
  using SinkBase::SinkBase;

 private:
  void open() override {
    text_ = "# " + std::to_string(info().width) + " x " + std::to_string(info().height) + " px, " +
            std::to_string(info().fps) + " frames/s\n";
  }
  void put(const Image& image) override {
    last_ = digest(image);
    again();
  }
  void again() override {
    char line[64];
    std::snprintf(line, sizeof line, "%06lld %016llx\n", static_cast<long long>(frames()),
                  static_cast<unsigned long long>(last_));
    text_ += line;
  }
  void finish(SinkReport& report) override {
    write_file(name(), text_.data(), text_.size());
    report.bytes = text_.size();
    report.format = "digests";
  }

  std::string text_;
  std::uint64_t last_ = 0;
};

/// The last frame as one picture.
class StillSink final : public SinkBase {
 public:
  using SinkBase::SinkBase;

 private:
  void open() override {}
  void put(const Image& image) override { last_ = image; }
  void again() override {}
  void finish(SinkReport& report) override {
    if (frames() == 0) throw std::logic_error(name() + ": no frame was drawn");
    const std::vector<std::uint8_t> bytes = encode_png(last_);
    write_file(name(), bytes.data(), bytes.size());
    report.bytes = bytes.size();
    report.format = "png";
  }

  Image last_;
};

/// Where a name has its %d, %6d or %06d: the number of the frame.
struct Counter {
  std::size_t first = 0, size = 0;  // 0: it has none
};

/// Looks at what comes after the last '/'. Other '%' are themselves, but not where one means a conversion.
/// @throws std::invalid_argument
Counter counter_in(const std::string& name) {
  Counter counter;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const std::size_t folder = name.rfind('/');
  for (std::size_t i = name.find('%', folder == std::string::npos ? 0 : folder); i != std::string::npos;
       i = name.find('%', i + 1)) {
    std::size_t end = i + 1;
    while (end < name.size() && is_digit(name[end])) ++end;
    if (end >= name.size() || !is_letter(name[end])) continue;
    if (name[end] != 'd' || end - i > 3 || counter.size > 0)
      throw std::invalid_argument(name + ": a pattern has exactly one %d, such as frame_%06d.png");
    counter = {i, end + 1 - i};
  }
  return counter;
}

/// A PNG file for each frame, by several threads. None has its name before all of them are written.
class PngSequenceSink final : public SinkBase {
 public:
  explicit PngSequenceSink(const std::string& name) : SinkBase(name), counter_(counter_in(name)) {}
  ~PngSequenceSink() override {
    if (threads_.empty()) return;
    queue_.abandon();
    join();
  }

 private:
  struct Job {
    std::int64_t index;
    std::shared_ptr<const Image> image;
  };

  [[nodiscard]] std::string file_name(std::int64_t index) const {
    char number[128];
    const std::string format = name().substr(counter_.first, counter_.size);
    std::snprintf(number, sizeof number, format.c_str(), static_cast<int>(index));
    return name().substr(0, counter_.first) + number + name().substr(counter_.first + counter_.size);
  }

  void open() override {
    const std::filesystem::path folder = std::filesystem::path(name()).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !std::filesystem::is_directory(folder, ignored)) {
      throw EnvironmentError(name() + ": no such directory: " + folder.string());
    }
    const unsigned count = std::clamp(std::thread::hardware_concurrency(), 1u, 8u);
    for (unsigned i = 0; i < count; ++i) threads_.emplace_back([this] { work(); });
  }

  void work() {
    while (std::optional<Job> job = queue_.pop()) {
      try {
        const std::vector<std::uint8_t> bytes = encode_png(*job->image);
        auto file = std::make_unique<OutputFile>(file_name(job->index));
        file->write(bytes.data(), bytes.size());
        const std::lock_guard lock(mutex_);
        bytes_ += bytes.size();
        written_.push_back(std::move(file));
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
      }
    }
  }

  void rethrow() {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
  }

  void put(const Image& image) override {
    last_ = std::make_shared<const Image>(image);
    again();
  }
  void again() override {
    rethrow();
    queue_.push({frames(), last_});
  }

  void join() {
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

  void finish(SinkReport& report) override {
    queue_.close();
    join();
    if (failure_) std::rethrow_exception(failure_);
    for (const auto& file : written_) file->finish();
    report.bytes = bytes_;
    report.format = "png sequence";
  }

  const Counter counter_;
  BoundedQueue<Job> queue_{6};
  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::exception_ptr failure_;
  std::uint64_t bytes_ = 0;
  std::vector<std::unique_ptr<OutputFile>> written_;
  std::shared_ptr<const Image> last_;
};

class TeeSink final : public FrameSink {
 public:
  explicit TeeSink(std::vector<std::unique_ptr<FrameSink>> sinks) : sinks_(std::move(sinks)) {
    if (sinks_.empty()) throw std::invalid_argument("tee: needs at least one sink");
  }
  void begin(const StreamInfo& info) override {
    for (auto& sink : sinks_) sink->begin(info);
  }
  void frame(const Image& image) override {
    for (auto& sink : sinks_) sink->frame(image);
  }
  void repeat() override {
    for (auto& sink : sinks_) sink->repeat();
  }
  void chapter(const std::string& title) override {
    for (auto& sink : sinks_) sink->chapter(title);
  }
  SinkReport end() override {
    SinkReport first = sinks_.front()->end();
    for (std::size_t i = 1; i < sinks_.size(); ++i) sinks_[i]->end();
    return first;
  }

 private:
  std::vector<std::unique_ptr<FrameSink>> sinks_;
};

}  // namespace

bool counts_frames(const std::filesystem::path& path) {
  return counter_in(path.string()).size > 0;
}

std::unique_ptr<FrameSink> make_sink(const std::filesystem::path& path, const SinkOptions& options) {
  namespace fs = std::filesystem;
  const std::string name = path.string();
  if (name == "null:") return std::make_unique<NullSink>(name);
  if (options.quality < 0 || options.quality > 51) {
    throw std::invalid_argument("quality must be 0 to 51, got " + std::to_string(options.quality));
  }
  std::error_code ignored;
  if (!name.empty() && (name.back() == '/' || fs::is_directory(path, ignored))) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error) throw EnvironmentError(name + ": cannot create: " + error.message());
    return std::make_unique<PngSequenceSink>((path / "frame_%06d.png").string());
  }
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  if (extension == ".png") {
    if (counts_frames(path)) return std::make_unique<PngSequenceSink>(name);
    return std::make_unique<StillSink>(name);
  }
  if (extension == ".mp4") return make_video_sink(name, VideoKind::Mp4, options);
  if (extension == ".mkv") return make_video_sink(name, VideoKind::Mkv, options);
  if (extension == ".webm") return make_video_sink(name, VideoKind::Webm, options);
  if (extension == ".gif") return make_video_sink(name, VideoKind::Gif, options);
  if (extension == ".txt" || extension == ".hash") return std::make_unique<HashSink>(name);
  throw std::invalid_argument(
      name + ": unknown kind of output; known are .mp4 .mkv .webm .gif .png, a pattern such as " +
      "frame_%06d.png, a directory ending in /, .txt or .hash for digests, and null:");
}

std::unique_ptr<FrameSink> tee(std::vector<std::unique_ptr<FrameSink>> sinks) {
  return std::make_unique<TeeSink>(std::move(sinks));
}

}  // namespace skerry::render
