// SPDX-License-Identifier: MIT
//
// Small helpers for GL objects, used inside of render/ only.
#pragma once

#include <epoxy/gl.h>
#include <string>

namespace skerry::render {

/// Compiles and links; "#version 330 core" is put before both sources.
/// @throws EnvironmentError with `name` and the driver's log
[[nodiscard]] GLuint make_program(const char* name, const std::string& vertex, const std::string& fragment);

/// A buffer that is filled anew for each draw: grows, never shrinks, and is orphaned before it is written, so
/// that the driver need not wait for the last draw.
class StreamBuffer {
 public:
  explicit StreamBuffer(GLenum target) : target_(target) { glGenBuffers(1, &name_); }
  ~StreamBuffer() { glDeleteBuffers(1, &name_); }
  StreamBuffer(const StreamBuffer&) = delete;
  StreamBuffer& operator=(const StreamBuffer&) = delete;

  /// Binds and fills.
  void upload(const void* data, std::size_t bytes);
  [[nodiscard]] GLuint name() const { return name_; }

 private:
  GLenum target_;
  GLuint name_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace skerry::render
