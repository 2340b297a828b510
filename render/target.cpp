// SPDX-License-Identifier: MIT
#include "render/target.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "render/error.h"
#include "render/gl_program.h"

namespace skerry::render {
namespace {

// One triangle over the whole picture.
constexpr const char* kFullVertex = R"(
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
})";

// Mean of factor x factor texels, exact texel fetches: no filtering differs between drivers.
constexpr const char* kAverageFragment = R"(
uniform sampler2D fine;
uniform int factor;
out vec4 color;
void main() {
  ivec2 corner = ivec2(gl_FragCoord.xy) * factor;
  vec4 sum = vec4(0.0);
  for (int y = 0; y < factor; ++y)
    for (int x = 0; x < factor; ++x) sum += texelFetch(fine, corner + ivec2(x, y), 0);
  color = sum / float(factor * factor);
})";

void make_framebuffer(int width, int height, GLuint& framebuffer, GLuint& texture) {
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  if (glGetError() != GL_NO_ERROR || glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &texture);
    throw EnvironmentError("OpenGL: the driver refuses a picture of " + std::to_string(width) + " x " +
                           std::to_string(height) + " px");
  }
}

}  // namespace

Target::Target(int width, int height, int ssaa) : width_(width), height_(height), ssaa_(ssaa) {
  if (width < 1 || height < 1 || width > 16384 || height > 16384 || ssaa < 1 || ssaa > 4) {
    throw std::invalid_argument("target: sides must be 1 to 16384 px and ssaa 1 to 4, got " +
                                std::to_string(width) + " x " + std::to_string(height) + " px, ssaa " +
                                std::to_string(ssaa));
  }
  while (glGetError() != GL_NO_ERROR) {
  }
  make_framebuffer(width, height, final_framebuffer_, final_texture_);
  if (ssaa == 1) {
    scene_framebuffer_ = final_framebuffer_;
    return;
  }
  try {
    make_framebuffer(scene_width(), scene_height(), scene_framebuffer_, scene_texture_);
    program_ = make_program("average", kFullVertex, kAverageFragment);
  } catch (...) {
    if (scene_texture_ != 0) {
      glDeleteFramebuffers(1, &scene_framebuffer_);
      glDeleteTextures(1, &scene_texture_);
    }
    glDeleteFramebuffers(1, &final_framebuffer_);
    glDeleteTextures(1, &final_texture_);
    throw;
  }
  glGenVertexArrays(1, &vertex_array_);
}

Target::~Target() {
  if (ssaa_ != 1) {
    glDeleteFramebuffers(1, &scene_framebuffer_);
    glDeleteTextures(1, &scene_texture_);
    glDeleteProgram(program_);
    glDeleteVertexArrays(1, &vertex_array_);
  }
  glDeleteFramebuffers(1, &final_framebuffer_);
  glDeleteTextures(1, &final_texture_);
}

void Target::begin_scene() {
  glBindFramebuffer(GL_FRAMEBUFFER, scene_framebuffer_);
  glViewport(0, 0, scene_width(), scene_height());
}

void Target::resolve() {
  glBindFramebuffer(GL_FRAMEBUFFER, final_framebuffer_);
  glViewport(0, 0, width_, height_);
  if (ssaa_ == 1) return;
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glUseProgram(program_);
  glUniform1i(glGetUniformLocation(program_, "factor"), ssaa_);
  glUniform1i(glGetUniformLocation(program_, "fine"), 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, scene_texture_);
  glBindVertexArray(vertex_array_);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Target::paste(const Target& other) {
  const int width = std::min(width_, other.width_), height = std::min(height_, other.height_);
  glBindFramebuffer(GL_FRAMEBUFFER, final_framebuffer_);
  glViewport(0, 0, width_, height_);
  glDisable(GL_SCISSOR_TEST);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, other.final_framebuffer_);
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, final_framebuffer_);
}

void Target::read(Image& image) {
  image.width = width_;
  image.height = height_;
  image.rgba.resize(static_cast<std::size_t>(width_) * height_ * 4);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, final_framebuffer_);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
}

}  // namespace skerry::render
