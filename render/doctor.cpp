// SPDX-License-Identifier: MIT
#include "render/doctor.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/avutil.h>
}
#include <imgui.h>
#include <libdeflate.h>

#include "render/egl_context.h"
#include "render/error.h"
#include "render/font_data.h"

namespace skerry::render {
namespace {

std::string version_text(unsigned version) {
  return std::to_string(version >> 16) + "." + std::to_string(version >> 8 & 0xff) + "." +
         std::to_string(version & 0xff);
}

void examine_gl(std::vector<DoctorLine>& lines) {
  const char* remedy = "apt install libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri";
  bool any = false;
  for (const EglAttempt& attempt : probe_egl()) {
    // One way is enough: the others may fail without harm.
    lines.push_back({"EGL: " + attempt.way, attempt.ok, attempt.detail, attempt.ok ? "" : remedy, false});
    any = any || attempt.ok;
  }
  lines.push_back(
      {"OpenGL 3.3 without a window", any, any ? "works" : "no way works", any ? "" : remedy, true});
  if (!any) return;
  try {
    const EglContext context;
    lines.push_back({"OpenGL vendor", true, context.vendor(), "", false});
    lines.push_back({"OpenGL renderer", true, context.renderer(), "", false});
    lines.push_back({"OpenGL version", true, context.version(), "", false});
  } catch (const EnvironmentError& error) {
    lines.push_back({"OpenGL context", false, error.what(), remedy, true});
  }
}

void examine_encoder(std::vector<DoctorLine>& lines, const char* name, const char* use, bool required) {
  const bool found = avcodec_find_encoder_by_name(name) != nullptr;
  lines.push_back({std::string("encoder ") + name, found,
                   found ? use : std::string("missing; needed for ") + use,
                   found ? "" : "apt install libavcodec59 (Debian's, built with x264 and vpx)", required});
}

}  // namespace

std::vector<DoctorLine> examine() {
  std::vector<DoctorLine> lines;
  examine_gl(lines);
  lines.push_back({"FFmpeg libavcodec", true, version_text(avcodec_version()), "", true});
  lines.push_back({"FFmpeg libavformat", true, version_text(avformat_version()), "", true});
  lines.push_back({"FFmpeg libavutil", true, version_text(avutil_version()), "", true});
  examine_encoder(lines, "libx264", ".mp4 and .mkv", true);
  examine_encoder(lines, "libx264rgb", "lossless .mp4 and .mkv", false);
  examine_encoder(lines, "libvpx-vp9", ".webm", false);
  examine_encoder(lines, "gif", ".gif", false);
  lines.push_back({"Dear ImGui", true, ImGui::GetVersion(), "", true});
  lines.push_back({"libdeflate", true, LIBDEFLATE_VERSION_STRING, "", true});
  const std::size_t size = sans_font().size + sans_bold_font().size + mono_font().size;
  lines.push_back({"fonts in the program", true,
                   "DejaVu Sans, Sans Bold, Sans Mono (" + std::to_string(size / 1024) + " kB)", "", true});
  return lines;
}

}  // namespace skerry::render
