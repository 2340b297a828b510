// SPDX-License-Identifier: MIT
//
// The off-screen picture that everything is drawn on.
#pragma once

#include <cstdint>

#include "render/image.h"

namespace skerry::render {

/// A framebuffer of RGBA8, optionally drawn `ssaa` times finer in each direction and averaged down.
///
/// The scene goes on the fine picture, panels on the final one: begin_scene(), draw, resolve(), user
/// interface, read(). Row 0 of the framebuffer is the top row of the picture, so that reading needs no flip;
/// whoever draws on it maps y accordingly. A context must be current from construction to destruction.
class Target {
 public:
  /// @param width, height  final size [px]
  /// @param ssaa           1 to 4
  /// @throws std::invalid_argument for sizes beyond 1..16384 or another ssaa
  /// @throws EnvironmentError if the driver refuses the size
  Target(int width, int height, int ssaa = 1);
  ~Target();
  Target(const Target&) = delete;
  Target& operator=(const Target&) = delete;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int ssaa() const { return ssaa_; }
  /// Size of the picture the scene is drawn on [px].
  [[nodiscard]] int scene_width() const { return width_ * ssaa_; }
  [[nodiscard]] int scene_height() const { return height_ * ssaa_; }

  /// Binds the fine picture and sets the viewport.
  void begin_scene();
  /// Averages the fine picture into the final one, and binds the final one. With ssaa 1 only binds.
  void resolve();

  /// Copies the final picture of `other` to the upper left corner of this one's; what does not fit is left
  /// out, what is not covered is black.
  void paste(const Target& other);

  /// Copies the final picture; `image` is resized.
  void read(Image& image);

  /// GL name of the final framebuffer, e.g. to blit it to a window (flipped: row 0 is the top).
  [[nodiscard]] unsigned framebuffer() const { return final_framebuffer_; }

 private:
  int width_, height_, ssaa_;
  unsigned scene_framebuffer_ = 0, scene_texture_ = 0;
  unsigned final_framebuffer_ = 0, final_texture_ = 0;
  unsigned program_ = 0, vertex_array_ = 0;
};

}  // namespace skerry::render
