// SPDX-License-Identifier: MIT
#include "render/gl_program.h"

#include <algorithm>

#include "render/error.h"

namespace skerry::render {
namespace {

GLuint compile(const char* name, GLenum kind, const std::string& source) {
  const std::string text = "#version 330 core\n" + source;
  const char* pointer = text.c_str();
  const GLuint shader = glCreateShader(kind);
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok) return shader;
  char log[2048] = "";
  glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  glDeleteShader(shader);
  throw EnvironmentError(std::string("OpenGL: the driver rejects the shader '") + name + "': " + log);
}

}  // namespace

GLuint make_program(const char* name, const std::string& vertex, const std::string& fragment) {
  const GLuint first = compile(name, GL_VERTEX_SHADER, vertex);
  GLuint second = 0;
  try {
    second = compile(name, GL_FRAGMENT_SHADER, fragment);
  } catch (...) {
    glDeleteShader(first);
    throw;
  }
  const GLuint program = glCreateProgram();
  glAttachShader(program, first);
  glAttachShader(program, second);
  glLinkProgram(program);
  glDeleteShader(first);
  glDeleteShader(second);
  GLint ok = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &ok);
  if (ok) return program;
  char log[2048] = "";
  glGetProgramInfoLog(program, sizeof log, nullptr, log);
  glDeleteProgram(program);
  throw EnvironmentError(std::string("OpenGL: the driver cannot link '") + name + "': " + log);
}

void StreamBuffer::upload(const void* data, std::size_t bytes) {
  glBindBuffer(target_, name_);
  if (bytes > capacity_) capacity_ = std::max<std::size_t>(bytes + bytes / 2, 4096);
  glBufferData(target_, static_cast<GLsizeiptr>(capacity_), nullptr, GL_STREAM_DRAW);
  glBufferSubData(target_, 0, static_cast<GLsizeiptr>(bytes), data);
}

}  // namespace skerry::render
