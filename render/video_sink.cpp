// SPDX-License-Identifier: MIT
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "render/bounded_queue.h"
#include "render/error.h"
#include "render/output_file.h"
#include "render/palette.h"
#include "render/sink_base.h"
#include "render/yuv.h"

namespace skerry::render {
namespace {

struct FreeCodec {
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
};
struct FreeFrame {
  void operator()(AVFrame* p) const { av_frame_free(&p); }
};
struct FreePacket {
  void operator()(AVPacket* p) const { av_packet_free(&p); }
};
struct FreeFormat {
  void operator()(AVFormatContext* p) const {
    if (p->pb != nullptr) avio_closep(&p->pb);
    avformat_free_context(p);
  }
};
using Frame = std::unique_ptr<AVFrame, FreeFrame>;

std::string av_message(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = "";
  av_strerror(error, text, sizeof text);
  return text;
}

/// What to encode with, by kind and options.
struct Recipe {
  std::string encoder;
  const char* container;
  AVPixelFormat format;
  const char* package;
};

Recipe usual_recipe(VideoKind kind, const SinkOptions& options) {
  switch (kind) {
    case VideoKind::Gif:
      return {"gif", "gif", AV_PIX_FMT_PAL8, "libavcodec59"};
    case VideoKind::Webm:
      return {"libvpx-vp9", "webm",
              options.lossless ? AV_PIX_FMT_GBRP
              : options.sharp  ? AV_PIX_FMT_YUV444P
                               : AV_PIX_FMT_YUV420P,
              "libavcodec59"};
    default:
      return {options.lossless ? "libx264rgb" : "libx264", kind == VideoKind::Mp4 ? "mp4" : "matroska",
              options.lossless ? AV_PIX_FMT_BGR0
              : options.sharp  ? AV_PIX_FMT_YUV444P
                               : AV_PIX_FMT_YUV420P,
              "libavcodec59"};
  }
}

Recipe choose(VideoKind kind, const SinkOptions& options) {
  Recipe recipe = usual_recipe(kind, options);
  if (!options.encoder.empty() && kind != VideoKind::Gif) recipe.encoder = options.encoder;
  return recipe;
}

/// Pixels of `image` in the format of `frame`; 8-bit copies, or YUV by BT.709.
void convert(const Image& image, AVFrame& frame) {
  YuvPlanes planes;
  for (int k = 0; k < 3; ++k) {
    planes.plane[k] = frame.data[k];
    planes.stride[k] = frame.linesize[k];
  }
  const std::uint8_t* from = image.rgba.data();
  switch (frame.format) {
    case AV_PIX_FMT_YUV420P:
      to_yuv420(image, planes);
      break;
    case AV_PIX_FMT_YUV444P:
      to_yuv444(image, planes);
      break;
    case AV_PIX_FMT_BGR0:
      for (int y = 0; y < image.height; ++y) {
        std::uint8_t* to = frame.data[0] + static_cast<std::ptrdiff_t>(y) * frame.linesize[0];
        for (int x = 0; x < image.width; ++x, from += 4, to += 4) {
          to[0] = from[2];
          to[1] = from[1];
          to[2] = from[0];
          to[3] = 255;
        }
      }
      break;
    default:  // GBRP
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x, from += 4) {
          for (int k = 0; k < 3; ++k)
            frame.data[k][static_cast<std::ptrdiff_t>(y) * frame.linesize[k] + x] = from[(k + 1) % 3];
        }
      }
  }
}

class VideoSink final : public SinkBase {
 public:
  VideoSink(const std::string& path, VideoKind kind, const SinkOptions& options)
      : SinkBase(path), kind_(kind), options_(options), recipe_(choose(kind, options)) {}

  ~VideoSink() override {
    filled_.abandon();
    if (encoder_.joinable()) encoder_.join();
    // The GIF writer of FFmpeg 5.1 frees the frame it holds back only here.
    if (header_written_ && kind_ == VideoKind::Gif) av_write_trailer(format_.get());
    // Closed before it is removed.
    format_.reset();
  }

 private:
  void open() override;
  void put(const Image& image) override;
  void again() override;
  void finish(SinkReport& report) override;

  void open_encoder();
  void check_encoder(const AVCodec& codec) const;
  void open_file();
  void add_chapters();
  void fill_gif(const Image& image, AVFrame& frame);
  Frame empty_frame();
  void encode_loop();
  void encode(const AVFrame* frame);
  void send(Frame frame);
  [[noreturn]] void fail(const char* what, int error) const {
    throw EnvironmentError(name() + ": " + what + ": " + av_message(error));
  }

  const VideoKind kind_;
  const SinkOptions options_;
  const Recipe recipe_;
  std::optional<OutputFile> file_;
  bool header_written_ = false;  // and no trailer yet

  std::unique_ptr<AVFormatContext, FreeFormat> format_;
  std::unique_ptr<AVCodecContext, FreeCodec> codec_;
  std::unique_ptr<AVPacket, FreePacket> packet_;
  AVStream* stream_ = nullptr;

  Palette palette_;
  int keep_every_ = 1;  // GIF: frames that are left out, see open_encoder()
  Frame last_;          // for again()
  BoundedQueue<Frame> filled_{4};
  std::mutex mutex_;         // guards free_ and failure_
  std::vector<Frame> free_;  // buffers for the next frames
  std::exception_ptr failure_;
  std::thread encoder_;
};

void VideoSink::open() {
  // Messages of the libraries would end up between ours; errors come back as codes.
  av_log_set_level(AV_LOG_FATAL);
  open_encoder();
  open_file();
  encoder_ = std::thread([this] { encode_loop(); });
}

/// FFmpeg itself says only that an argument is invalid.
void VideoSink::check_encoder(const AVCodec& codec) const {
  if (codec.type != AVMEDIA_TYPE_VIDEO)
    throw std::invalid_argument(name() + ": the encoder " + recipe_.encoder + " is none for video");
  if (codec.pix_fmts == nullptr) return;
  std::string known;
  for (const AVPixelFormat* format = codec.pix_fmts; *format != AV_PIX_FMT_NONE; ++format) {
    if (*format == recipe_.format) return;
    known += std::string(known.empty() ? "" : " ") + av_get_pix_fmt_name(*format);
  }
  throw std::invalid_argument(name() + ": the encoder " + recipe_.encoder + " does not take the pixels " +
                              av_get_pix_fmt_name(recipe_.format) + " of this " + recipe_.container +
                              (options_.lossless ? " without loss"
                               : options_.sharp  ? " in full colour"
                                                 : "") +
                              ", only " + known);
}

void VideoSink::open_encoder() {
  const bool halved = recipe_.format == AV_PIX_FMT_YUV420P;
  if (halved && (info().width % 2 != 0 || info().height % 2 != 0)) {
    const int w = std::max(info().width & ~1, 2), h = std::max(info().height & ~1, 2);
    throw std::invalid_argument(name() + ": this format halves the colour and needs even sides, got " +
                                std::to_string(info().width) + " x " + std::to_string(info().height) +
                                " px; use " + std::to_string(w) + " x " + std::to_string(h) + ", or sharp");
  }
  const AVCodec* codec = avcodec_find_encoder_by_name(recipe_.encoder.c_str());
  if (codec == nullptr) {
    const std::string remedy = options_.encoder.empty() ? std::string("; apt install ") + recipe_.package +
                                                              ", or write .mkv, .webm, .gif or a PNG sequence"
                                                        : "; `ffmpeg -encoders` lists those there are";
    throw EnvironmentError(name() + ": FFmpeg on this machine lacks the encoder " + recipe_.encoder + remedy);
  }
  check_encoder(*codec);
  codec_.reset(avcodec_alloc_context3(codec));
  packet_.reset(av_packet_alloc());
  if (!codec_ || !packet_) throw std::bad_alloc();
  codec_->width = info().width;
  codec_->height = info().height;
  codec_->pix_fmt = recipe_.format;
  codec_->time_base = {1, info().fps};
  codec_->framerate = {info().fps, 1};
  codec_->sample_aspect_ratio = {1, 1};
  codec_->gop_size = 2 * info().fps;  // a key frame every two seconds: quick to scrub
  codec_->flags |= AV_CODEC_FLAG_BITEXACT;
  // Not the number of cores: the stream depends on the number of threads, and should not on the machine.
  codec_->thread_count = 4;
  if (recipe_.format == AV_PIX_FMT_YUV420P || recipe_.format == AV_PIX_FMT_YUV444P) {
    codec_->color_range = AVCOL_RANGE_MPEG;
    codec_->colorspace = AVCOL_SPC_BT709;
    codec_->color_primaries = AVCOL_PRI_BT709;
    codec_->color_trc = AVCOL_TRC_BT709;
    if (halved) codec_->chroma_sample_location = AVCHROMA_LOC_CENTER;
  }
  if (recipe_.format == AV_PIX_FMT_GBRP || recipe_.format == AV_PIX_FMT_BGR0) {
    codec_->colorspace = AVCOL_SPC_RGB;
    codec_->color_range = AVCOL_RANGE_JPEG;
    codec_->color_primaries = AVCOL_PRI_BT709;
    codec_->color_trc = AVCOL_TRC_IEC61966_2_1;
  }
  AVDictionary* dictionary = nullptr;
  const auto set = [&](const char* key, const std::string& value) {
    av_dict_set(&dictionary, key, value.c_str(), 0);
  };
  if (kind_ == VideoKind::Gif) {
    // Delays are hundredths of a second and viewers slow down below two: above 50 frames/s leave some out.
    keep_every_ = (info().fps + 49) / 50;
    codec_->time_base = {1, 100};
    codec_->framerate = {info().fps, keep_every_};
    codec_->thread_count = 1;
  } else if (kind_ == VideoKind::Webm) {
    set("deadline", "good");
    set("cpu-used", "5");
    set("row-mt", "1");
    codec_->bit_rate = 0;
    if (options_.lossless) {
      set("lossless", "1");
    } else {
      set("crf", std::to_string(options_.quality + 8));  // about the same look as the CRF of x264
    }
  } else {
    set("preset", options_.lossless ? "ultrafast" : "veryfast");
    // x264 (core 164) reads memory that was never written in its macroblock tree: with it the file depends on
    // what the process did before (seen at 320 x 180 with MALLOC_PERTURB_). Without it the bits repeat.
    set("mbtree", "0");
    set(options_.lossless ? "qp" : "crf", std::to_string(options_.lossless ? 0 : options_.quality));
  }
  if (!options_.encoder.empty()) {
    // Encoders without a CRF understand a fixed quantiser at best.
    codec_->flags |= AV_CODEC_FLAG_QSCALE;
    codec_->global_quality = FF_QP2LAMBDA * std::max(1, options_.quality / 6);
  }
  const AVOutputFormat* container = av_guess_format(recipe_.container, nullptr, nullptr);
  if (container != nullptr && (container->flags & AVFMT_GLOBALHEADER) != 0) {
    codec_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  }
  const int error = avcodec_open2(codec_.get(), codec, &dictionary);
  // What an encoder does not know stays in the dictionary.
  const bool knows_lossless =
      kind_ == VideoKind::Webm && av_dict_get(dictionary, "lossless", nullptr, 0) == nullptr;
  av_dict_free(&dictionary);
  if (error < 0) fail(("cannot start the encoder " + recipe_.encoder).c_str(), error);
  if (!options_.lossless || options_.encoder.empty() || knows_lossless) return;
  const AVCodecDescriptor* descriptor = avcodec_descriptor_get(codec->id);
  const int kinds = descriptor == nullptr ? 0 : descriptor->props;
  const bool never_loses = (kinds & AV_CODEC_PROP_LOSSLESS) != 0 && (kinds & AV_CODEC_PROP_LOSSY) == 0;
  if (!never_loses && recipe_.encoder != usual_recipe(kind_, options_).encoder)
    throw std::invalid_argument(name() + ": the encoder " + recipe_.encoder +
                                " has no option lossless and may lose some of the picture; " +
                                "leave it out, or take ffv1 in .mkv");
}

void VideoSink::open_file() {
  file_.emplace(name());
  if (kind_ == VideoKind::Mp4 && file_->in_place())
    throw std::invalid_argument(name() +
                                ": MP4 is completed at its beginning, which a FIFO or device does not "
                                "allow; use .mkv, .webm or .gif");
  const char* target = file_->target().c_str();
  AVFormatContext* format = nullptr;
  int error = avformat_alloc_output_context2(&format, nullptr, recipe_.container, target);
  if (error < 0) fail((std::string("no container ") + recipe_.container).c_str(), error);
  format_.reset(format);
  format->flags |= AVFMT_FLAG_BITEXACT;  // no random identifiers: same frames, same file
  stream_ = avformat_new_stream(format, nullptr);
  if (stream_ == nullptr) throw std::bad_alloc();
  stream_->time_base = codec_->time_base;
  stream_->avg_frame_rate = stream_->r_frame_rate = codec_->framerate;
  error = avcodec_parameters_from_context(stream_->codecpar, codec_.get());
  if (error < 0) fail("cannot describe the stream", error);
  if (!info().title.empty()) av_dict_set(&format->metadata, "title", info().title.c_str(), 0);
  if (!info().comment.empty()) av_dict_set(&format->metadata, "comment", info().comment.c_str(), 0);
  error = avio_open(&format->pb, target, AVIO_FLAG_WRITE);
  if (error < 0) fail("cannot create", error);
  AVDictionary* dictionary = nullptr;
  if (kind_ == VideoKind::Mp4) av_dict_set(&dictionary, "movflags", "+faststart", 0);
  if (kind_ == VideoKind::Gif) av_dict_set(&dictionary, "loop", "0", 0);
  error = avformat_write_header(format, &dictionary);
  av_dict_free(&dictionary);
  if (error < 0) fail("cannot write", error);
  header_written_ = true;
}

/// Chapters are known when the video has ended; the containers write them into the trailer.
void VideoSink::add_chapters() {
  const double length = static_cast<double>(frames()) / info().fps;
  std::vector<Chapter> chapters;
  for (const Chapter& chapter : info().chapters) {
    if (chapter.seconds >= 0 && chapter.seconds < length) chapters.push_back(chapter);
  }
  if (chapters.empty() || kind_ == VideoKind::Gif) return;
  std::stable_sort(chapters.begin(), chapters.end(),
                   [](const Chapter& a, const Chapter& b) { return a.seconds < b.seconds; });
  // Players take the first chapter to begin at 0 whatever it says.
  if (chapters.front().seconds > 0) chapters.insert(chapters.begin(), {0, "Start"});
  auto** list = static_cast<AVChapter**>(av_calloc(chapters.size(), sizeof(AVChapter*)));
  if (list == nullptr) throw std::bad_alloc();
  format_->chapters = list;
  const auto stamp = [](double seconds) { return std::int64_t{std::llround(seconds * 1000)}; };
  for (std::size_t i = 0; i < chapters.size(); ++i) {
    auto* chapter = static_cast<AVChapter*>(av_mallocz(sizeof(AVChapter)));
    if (chapter == nullptr) throw std::bad_alloc();
    list[i] = chapter;
    format_->nb_chapters = static_cast<unsigned>(i + 1);
    chapter->id = static_cast<std::int64_t>(i + 1);
    chapter->time_base = {1, 1000};
    chapter->start = stamp(chapters[i].seconds);
    chapter->end = stamp(i + 1 < chapters.size() ? chapters[i + 1].seconds : length);
    av_dict_set(&chapter->metadata, "title", chapters[i].title.c_str(), 0);
  }
}

Frame VideoSink::empty_frame() {
  {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    if (!free_.empty()) {
      Frame frame = std::move(free_.back());
      free_.pop_back();
      // The encoder may still hold the pixels; then this makes new ones.
      if (av_frame_make_writable(frame.get()) < 0) throw std::bad_alloc();
      return frame;
    }
  }
  Frame frame(av_frame_alloc());
  if (!frame) throw std::bad_alloc();
  frame->width = info().width;
  frame->height = info().height;
  frame->format = recipe_.format;
  frame->color_range = codec_->color_range;
  frame->colorspace = codec_->colorspace;
  frame->color_primaries = codec_->color_primaries;
  frame->color_trc = codec_->color_trc;
  if (av_frame_get_buffer(frame.get(), 0) < 0) throw std::bad_alloc();
  return frame;
}

void VideoSink::fill_gif(const Image& image, AVFrame& frame) {
  // A palette serves until it fails one pixel in 500: fewer palettes make smaller files and no flicker.
  if (palette_.size() == 0 || palette_.map(image, frame.data[0], frame.linesize[0]) > 0.002) {
    palette_ = Palette(image);
    palette_.map(image, frame.data[0], frame.linesize[0]);
  }
  auto* entries = reinterpret_cast<std::uint32_t*>(frame.data[1]);
  for (std::size_t i = 0; i < 256; ++i) {
    const Color c = palette_.colors()[i];
    entries[i] =
        0xff000000u | static_cast<std::uint32_t>(c.r) << 16 | static_cast<std::uint32_t>(c.g) << 8 | c.b;
  }
}

void VideoSink::put(const Image& image) {
  last_.reset();  // so that its buffer can be used again
  Frame frame = empty_frame();
  if (kind_ == VideoKind::Gif) {
    fill_gif(image, *frame);
  } else {
    convert(image, *frame);
  }
  last_.reset(av_frame_clone(frame.get()));
  send(std::move(frame));
}

void VideoSink::again() {
  {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
  }
  // Shares the pixels with the frame before.
  send(Frame(av_frame_clone(last_.get())));
}

void VideoSink::send(Frame frame) {
  if (!frame) throw std::bad_alloc();
  if (kind_ == VideoKind::Gif && frames() % keep_every_ != 0) return;
  frame->pts = kind_ == VideoKind::Gif ? (frames() * 100 + info().fps / 2) / info().fps : frames();
  frame->pict_type = AV_PICTURE_TYPE_NONE;
  filled_.push(std::move(frame));
}

void VideoSink::encode_loop() {
  try {
    while (std::optional<Frame> frame = filled_.pop()) {
      encode(frame->get());
      const std::lock_guard lock(mutex_);
      if (free_.size() < 6) free_.push_back(std::move(*frame));
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    filled_.abandon();
  }
}

void VideoSink::encode(const AVFrame* frame) {
  int error = avcodec_send_frame(codec_.get(), frame);
  if (error < 0) fail("cannot encode", error);
  while ((error = avcodec_receive_packet(codec_.get(), packet_.get())) >= 0) {
    if (packet_->duration == 0 && kind_ != VideoKind::Gif) packet_->duration = 1;
    av_packet_rescale_ts(packet_.get(), codec_->time_base, stream_->time_base);
    packet_->stream_index = stream_->index;
    error = av_interleaved_write_frame(format_.get(), packet_.get());
    if (error >= 0) error = format_->pb->error;
    if (error < 0) fail("cannot write", error);
  }
  if (error != AVERROR(EAGAIN) && error != AVERROR_EOF) fail("cannot encode", error);
}

void VideoSink::finish(SinkReport& report) {
  filled_.close();
  encoder_.join();
  if (failure_) std::rethrow_exception(failure_);
  if (frames() == 0) throw std::logic_error(name() + ": no frame was drawn");
  encode(nullptr);
  add_chapters();
  header_written_ = false;
  int error = av_write_trailer(format_.get());
  if (error >= 0) error = format_->pb->error;
  if (error < 0) fail("cannot write", error);
  report.bytes =
      static_cast<std::uint64_t>(file_->in_place() ? avio_tell(format_->pb) : avio_size(format_->pb));
  error = avio_closep(&format_->pb);
  if (error < 0) fail("cannot write", error);
  file_->finish();
  const char* pixels = recipe_.format == AV_PIX_FMT_PAL8      ? "256 colours"
                       : recipe_.format == AV_PIX_FMT_YUV420P ? "yuv420p"
                       : recipe_.format == AV_PIX_FMT_YUV444P ? "yuv444p"
                                                              : "lossless rgb";
  const std::string codec = !options_.encoder.empty()  ? options_.encoder
                            : kind_ == VideoKind::Gif  ? "gif"
                            : kind_ == VideoKind::Webm ? "vp9"
                                                       : "h264";
  report.format = codec + " " + pixels + " in " + recipe_.container;
}

}  // namespace

std::unique_ptr<FrameSink> make_video_sink(const std::string& path, VideoKind kind,
                                           const SinkOptions& options) {
  return std::make_unique<VideoSink>(path, kind, options);
}

}  // namespace skerry::render
