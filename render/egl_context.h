// SPDX-License-Identifier: MIT
//
// OpenGL without a window, a display server or environment variables.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace skerry::render {

enum class EglDevice : std::uint8_t {
  Any,       ///< hardware if there is any, else software
  Software,  ///< the software rasteriser even where there is hardware: golden images
};

/// One way to a context, and how far it went.
struct EglAttempt {
  std::string way;     ///< e.g. "device 0 (/dev/dri/renderD128)", "surfaceless Mesa", "software device"
  bool ok = false;     ///< a context was made
  std::string detail;  ///< the step that failed with EGL's error; or the GL version
};

/// An OpenGL 3.3 core context that is current on the thread that made it, with no surface.
///
/// Tries EGL devices that are hardware, then surfaceless Mesa, then the software device; never the default
/// display, which depends on the environment. For each: initialise, desktop OpenGL, a config, 3.3 core,
/// current without surface; the first that passes stays.
class EglContext {
 public:
  /// @throws EnvironmentError naming each way that was tried and the packages that help
  explicit EglContext(EglDevice device = EglDevice::Any);
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  /// Makes the context current on the calling thread; it may be current on one thread only.
  void make_current();
  void release();

  /// Waits until everything that was drawn is done: to measure, or before another thread reads.
  void finish();

  [[nodiscard]] const std::vector<EglAttempt>& attempts() const { return attempts_; }
  [[nodiscard]] const std::string& vendor() const { return vendor_; }
  [[nodiscard]] const std::string& renderer() const { return renderer_; }
  [[nodiscard]] const std::string& version() const { return version_; }
  /// The processor draws (llvmpipe): buffers are plain memory, read-back is a copy.
  [[nodiscard]] bool software() const { return software_; }

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
  std::vector<EglAttempt> attempts_;
  std::string vendor_, renderer_, version_;
  bool software_ = false;
};

/// Tries every way and keeps none: for `skerry doctor`. Never throws for want of a driver.
[[nodiscard]] std::vector<EglAttempt> probe_egl();

}  // namespace skerry::render
