// SPDX-License-Identifier: MIT
#include "render/gl_renderer.h"

#include <cstddef>
#include <epoxy/gl.h>
#include <stdexcept>
#include <string>

#include "render/gl_program.h"
#include "render/glyphs.h"
#include "render/shape_batch.h"

namespace skerry::render {
namespace {

// All shapes: a quad around the grown box; `local` are pixels in the frame of the box. Colours become
// premultiplied. `local` is not noperspective, though w is 1: Mesa's clipper divides by a difference that may
// be rounding then, and large tilted quads lose their distances.
constexpr const char* kShapeVertex = R"(
layout(location = 0) in vec4 frame;
layout(location = 1) in vec4 dims;
layout(location = 2) in vec4 fill;
layout(location = 3) in vec4 line;
layout(location = 4) in uvec2 corners;
uniform vec2 to_clip;
uniform vec2 extent;  // 0 or 1: whether the box and the radius count for the size of the quad
out vec2 local;
flat out vec4 box;
flat out vec4 fill_color, line_color;
flat out uvec2 range;
#ifdef EDGES
uniform samplerBuffer edges;
flat out vec4 edge_x[EDGES / 4], edge_y[EDGES / 4], edge_d[EDGES / 4];
#endif
void main() {
#ifdef EDGES
  // Edges that the polygon does not have are far away.
  for (int i = 0; i < EDGES; ++i) {
    vec4 edge = uint(i) < corners.y ? texelFetch(edges, int(corners.x) + i) : vec4(0.0, 0.0, 1e30, 0.0);
    edge_x[i / 4][i % 4] = edge.x;
    edge_y[i / 4][i % 4] = edge.y;
    edge_d[i / 4][i % 4] = edge.z;
  }
#endif
  vec2 sign = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  local = sign * (dims.xy * extent.x + dims.z * extent.y + 1.0);
  vec2 at = frame.xy + local.x * frame.zw + local.y * vec2(-frame.w, frame.z);
  gl_Position = vec4(at * to_clip - 1.0, 0.0, 1.0);
  box = dims;
  fill_color = vec4(fill.rgb * fill.a, fill.a);
  line_color = vec4(line.rgb * line.a, line.a);
  range = corners;
})";

// From a signed distance in pixels to colour: the outline is the band of width box.w inside of the rim.
constexpr const char* kPaint = R"(
in vec2 local;
flat in vec4 box;
flat in vec4 fill_color, line_color;
flat in uvec2 range;
out vec4 color;
vec4 paint(float d) {
  float whole = clamp(0.5 - d, 0.0, 1.0);
  float inner = clamp(0.5 - d - box.w, 0.0, 1.0);
  return fill_color * inner + line_color * (whole - inner);
}
float rounded_box() {
  vec2 q = abs(local) - box.xy;
  return length(max(q, 0.0)) + min(max(q.x, q.y), 0.0) - box.z;
})";

constexpr const char* kRoundedFragment = R"(
void main() { color = paint(rounded_box()); }
)";

// A disc with a radius line towards (box.x, box.y).
constexpr const char* kSpokeFragment = R"(
void main() {
  float distance = length(local);
  vec4 disc = paint(distance - box.z);
  float along = dot(local, box.xy), across = dot(local, vec2(-box.y, box.x));
  float spoke = length(vec2(along - clamp(along, 0.0, box.z - box.w), across)) - 0.5 * max(box.w, 1.0);
  float cover = clamp(0.5 - spoke, 0.0, 1.0) * min(box.w, 1.0);
  color = disc * (1.0 - line_color.a * cover) + line_color * cover;
}
)";

// Sharp convex polygons of at most EDGES corners: the largest of the distances to the lines through the
// edges; a box where there are none. Fetching the edges here instead of once a corner of the quad takes twice
// the time.
constexpr const char* kConvexFragment = R"(
flat in vec4 edge_x[EDGES / 4], edge_y[EDGES / 4], edge_d[EDGES / 4];
void main() {
  vec4 four = edge_x[0] * local.x + edge_y[0] * local.y - edge_d[0];
  for (int i = 1; i < EDGES / 4; ++i) four = max(four, edge_x[i] * local.x + edge_y[i] * local.y - edge_d[i]);
  float distance = max(max(four.x, four.y), max(four.z, four.w));
  color = paint(range.y == 0u ? rounded_box() : distance);
}
)";

// Rounded polygons: distance to the edges, inside by the side of all of them; a box where there are no
// corners.
constexpr const char* kPolygonFragment = R"(
uniform samplerBuffer edges;
void main() {
  float square = 1e30, side = -1e30;
  int last = int(range.x + range.y);
  for (int i = int(range.x); i < last; ++i) {
    vec4 edge = texelFetch(edges, i);
    vec2 to = local - edge.xy;
    float across = to.x * edge.w - to.y * edge.z;
    float size = max(dot(edge.zw, edge.zw), 1e-12);
    vec2 gap = to - edge.zw * clamp(dot(to, edge.zw) / size, 0.0, 1.0);
    square = min(square, dot(gap, gap));
    side = max(side, across);
  }
  float distance = sqrt(square);
  color = paint(range.y == 0u ? rounded_box() : (side > 0.0 ? distance : -distance) - box.z);
}
)";

// A shaft with a round end, and a triangular head of length box.w at the right.
constexpr const char* kArrowFragment = R"(
void main() {
  float head = box.w, back = box.x - head;
  float left = min(-box.x + box.z, back);
  float shaft = length(vec2(local.x - clamp(local.x, left, back + 0.25 * head), local.y)) - box.z;
  if (head >= 2.0 * box.x - 0.01) shaft = 1e9;
  vec2 normal = normalize(vec2(box.y, head));
  float tip = max(dot(vec2(local.x - box.x, abs(local.y)), normal), back - local.x);
  float whole = clamp(0.5 - min(shaft, tip), 0.0, 1.0);
  color = fill_color * whole;
}
)";

constexpr const char* kTextVertex = R"(
layout(location = 0) in vec2 corner;
layout(location = 1) in uvec4 source;  // texel, size
layout(location = 2) in vec4 ink;
layout(location = 3) in uint channel;
uniform vec2 to_clip;
noperspective out vec2 texel;
flat out vec4 ink_color;
flat out uint picked;
void main() {
  vec2 step = vec2(gl_VertexID & 1, gl_VertexID >> 1) * vec2(source.zw);
  texel = vec2(source.xy) + step;
  gl_Position = vec4((corner + step) * to_clip - 1.0, 0.0, 1.0);
  ink_color = vec4(ink.rgb * ink.a, ink.a);
  picked = channel;
})";

constexpr const char* kTextFragment = R"(
noperspective in vec2 texel;
flat in vec4 ink_color;
flat in uint picked;
uniform sampler2D atlas;
out vec4 color;
void main() {
  vec2 both = texelFetch(atlas, ivec2(texel), 0).rg;
  color = ink_color * (picked == 0u ? both.r : both.g);
})";

void point_at(GLuint location, GLint size, GLenum type, bool normalised, std::size_t stride,
              std::size_t offset) {
  glVertexAttribPointer(location, size, type, normalised ? GL_TRUE : GL_FALSE, static_cast<GLsizei>(stride),
                        reinterpret_cast<const void*>(offset));
}

void point_at_integers(GLuint location, GLint size, GLenum type, std::size_t stride, std::size_t offset) {
  glVertexAttribIPointer(location, size, type, static_cast<GLsizei>(stride),
                         reinterpret_cast<const void*>(offset));
}

GLuint make_vertex_array(GLuint attributes) {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  glBindVertexArray(name);
  for (GLuint i = 0; i < attributes; ++i) {
    glEnableVertexAttribArray(i);
    glVertexAttribDivisor(i, 1);
  }
  return name;
}

}  // namespace

struct GlRenderer::State {
  GlyphAtlas atlas;
  ShapeBatches frame;
  GLuint programs[kProgramCount] = {};  // by Program
  GLuint shape_array = 0, glyph_array = 0;
  GLuint edge_texture = 0, atlas_texture = 0;
  int atlas_height = 0;
  StreamBuffer shapes{GL_ARRAY_BUFFER}, glyphs{GL_ARRAY_BUFFER}, edges{GL_TEXTURE_BUFFER};

  State();
  ~State();
  void upload();
  void draw(const Batch& batch);
  GLuint& program(Program which) { return programs[static_cast<int>(which)]; }
};

GlRenderer::State::State() {
  try {
    const std::string paint = kPaint;
    program(Program::Rounded) = make_program("rounded", kShapeVertex, paint + kRoundedFragment);
    program(Program::Spoke) = make_program("spoke", kShapeVertex, paint + kSpokeFragment);
    const std::string four = "#define EDGES 4\n", eight = "#define EDGES 8\n";
    program(Program::Convex4) = make_program("convex 4", four + kShapeVertex, four + paint + kConvexFragment);
    program(Program::Convex8) =
        make_program("convex 8", eight + kShapeVertex, eight + paint + kConvexFragment);
    program(Program::Polygon) = make_program("polygon", kShapeVertex, paint + kPolygonFragment);
    program(Program::Arrow) = make_program("arrow", kShapeVertex, paint + kArrowFragment);
    program(Program::Text) = make_program("text", kTextVertex, kTextFragment);
  } catch (...) {
    for (const GLuint name : programs) glDeleteProgram(name);
    throw;
  }
  shape_array = make_vertex_array(5);
  glyph_array = make_vertex_array(4);
  glGenTextures(1, &edge_texture);
  glGenTextures(1, &atlas_texture);
}

GlRenderer::State::~State() {
  for (const GLuint name : programs) glDeleteProgram(name);
  glDeleteVertexArrays(1, &shape_array);
  glDeleteVertexArrays(1, &glyph_array);
  glDeleteTextures(1, &edge_texture);
  glDeleteTextures(1, &atlas_texture);
}

void GlRenderer::State::upload() {
  if (!frame.shapes.empty()) shapes.upload(frame.shapes.data(), frame.shapes.size() * sizeof(ShapeInstance));
  if (!frame.glyphs.empty()) glyphs.upload(frame.glyphs.data(), frame.glyphs.size() * sizeof(GlyphInstance));
  if (!frame.corners.empty()) {
    edges.upload(frame.corners.data(), frame.corners.size() * sizeof(float));
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_BUFFER, edge_texture);
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, edges.name());
  }
  const GlyphAtlas::Rows dirty = atlas.take_dirty_rows();
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, atlas_texture);
  if (dirty.first >= dirty.last) return;
  glPixelStorei(GL_UNPACK_ALIGNMENT, 2);
  if (atlas_height != atlas.height()) {
    atlas_height = atlas.height();
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RG8, GlyphAtlas::kWidth, atlas_height, 0, GL_RG, GL_UNSIGNED_BYTE,
                 atlas.texels().data());
  } else {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, dirty.first, GlyphAtlas::kWidth, dirty.last - dirty.first, GL_RG,
                    GL_UNSIGNED_BYTE,
                    atlas.texels().data() + static_cast<std::size_t>(dirty.first) * GlyphAtlas::kWidth * 2);
  }
}

void GlRenderer::State::draw(const Batch& batch) {
  glUseProgram(program(batch.program));
  // No base instance in 3.3: the attributes start at the batch.
  if (batch.program == Program::Text) {
    glBindVertexArray(glyph_array);
    glBindBuffer(GL_ARRAY_BUFFER, glyphs.name());
    constexpr std::size_t kStride = sizeof(GlyphInstance);
    const std::size_t start = batch.first * kStride;
    point_at(0, 2, GL_FLOAT, false, kStride, start + offsetof(GlyphInstance, corner));
    point_at_integers(1, 4, GL_UNSIGNED_SHORT, kStride, start + offsetof(GlyphInstance, texel));
    point_at(2, 4, GL_UNSIGNED_BYTE, true, kStride, start + offsetof(GlyphInstance, color));
    point_at_integers(3, 1, GL_UNSIGNED_INT, kStride, start + offsetof(GlyphInstance, channel));
  } else {
    glBindVertexArray(shape_array);
    glBindBuffer(GL_ARRAY_BUFFER, shapes.name());
    constexpr std::size_t kStride = sizeof(ShapeInstance);
    const std::size_t start = batch.first * kStride;
    point_at(0, 4, GL_FLOAT, false, kStride, start + offsetof(ShapeInstance, centre));
    point_at(1, 4, GL_FLOAT, false, kStride, start + offsetof(ShapeInstance, half));
    point_at(2, 4, GL_UNSIGNED_BYTE, true, kStride, start + offsetof(ShapeInstance, fill));
    point_at(3, 4, GL_UNSIGNED_BYTE, true, kStride, start + offsetof(ShapeInstance, line));
    point_at_integers(4, 2, GL_UNSIGNED_INT, kStride, start + offsetof(ShapeInstance, first));
  }
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(batch.count));
}

GlRenderer::GlRenderer() : state_(std::make_unique<State>()) {}
GlRenderer::~GlRenderer() = default;

DrawStats GlRenderer::draw(const DrawList& list, const Camera& camera, Target& target) {
  camera.validate();
  if (camera.width_px != target.width() || camera.height_px != target.height()) {
    throw std::invalid_argument("renderer: the camera is for " + std::to_string(camera.width_px) + " x " +
                                std::to_string(camera.height_px) + " px, the target has " +
                                std::to_string(target.width()) + " x " + std::to_string(target.height()));
  }
  State& s = *state_;
  s.frame.build(list, camera, target.ssaa(), s.atlas);
  target.begin_scene();
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glClearColor(list.background.r / 255.0f, list.background.g / 255.0f, list.background.b / 255.0f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  s.upload();
  // Row 0 of the framebuffer is the top of the picture: pixels y down go to clip space y up unflipped.
  for (int i = 0; i < kProgramCount; ++i) {
    const auto which = static_cast<Program>(i);
    const GLuint program = s.program(which);
    glUseProgram(program);
    glUniform2f(glGetUniformLocation(program, "to_clip"), 2.0f / static_cast<float>(target.scene_width()),
                2.0f / static_cast<float>(target.scene_height()));
    glUniform2f(glGetUniformLocation(program, "extent"), which == Program::Spoke ? 0.0f : 1.0f,
                which == Program::Arrow ? 0.0f : 1.0f);
  }
  for (const Batch& batch : s.frame.batches) s.draw(batch);
  glBindVertexArray(0);
  target.resolve();
  return {static_cast<int>(s.frame.shapes.size() + s.frame.glyphs.size()), s.frame.culled,
          static_cast<int>(s.frame.batches.size())};
}

}  // namespace skerry::render
