// SPDX-License-Identifier: MIT
#include "render/gl_renderer.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <epoxy/gl.h>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/gl_program.h"
#include "render/glyphs.h"
#include "render/shape_batch.h"

namespace skerry::render {
namespace {

// All shapes: something that covers the grown box, and a signed distance for each pixel in it. Colours become
// premultiplied. Where a pixel is in the frame of the box follows from its coordinates, not from an
// interpolated input: that is exact, however the box is covered.
//
// How it is covered decides most of the cost on llvmpipe, which shades blocks of 4 x 4 pixels, those along
// the common edge of two triangles twice:
//   POINT  one square, for what is about as wide as high
//   ARROW  seven corners: two triangles for the shaft, one for the head; they overlap a little, and `seam`
//          says who draws there, so that see-through arrows have no darker pixels
//   else   two triangles
constexpr const char* kShapeVertex = R"(
layout(location = 0) in vec4 frame;
layout(location = 1) in vec4 dims;
layout(location = 2) in vec4 fill;
layout(location = 3) in vec4 line;
layout(location = 4) in uvec2 corners;
uniform vec2 to_clip;
uniform vec3 extent;  // 0 or 1: whether box and radius count for the size of the quad; margin [px]
flat out vec4 place, box;
flat out vec4 fill_color, line_color;
flat out uvec2 range;
#ifdef ARROW
flat out vec4 head_plane;  // normal of the upper side of the head, sign of the part that this is, seam
#endif
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
  vec2 half_size = dims.xy * extent.x + dims.z * extent.y + extent.z;
#if defined POINT
  vec2 turned = abs(frame.zw);
  if (extent.x == 0.0) turned = vec2(1.0, 0.0);
  gl_PointSize = 2.0 * max(dot(half_size, turned), dot(half_size, turned.yx)) + 1.0;
  vec2 local = vec2(0.0);
#elif defined ARROW
  int corner = gl_VertexID % 7;
  float head = dims.w, back = dims.x - head;
  vec2 normal = normalize(vec2(dims.y, head));
  // Short ones are one quad: a third triangle would cost more than it saves.
  bool one = dims.x < 20.0;
  float seam = one ? 1e9 : back - 0.5;
  bool of_head = corner > 3;
  // The head with its half pixel of shade; its sides meet at the tip.
  float tip = dims.x + 0.5 / normal.x + 0.1, low = back - 0.6;
  float wide = (tip - low) * normal.x / normal.y;
  float tail = min(-dims.x, back) - extent.z;
  float x = of_head ? (corner == 6 || one ? tip : low) : corner < 2 ? min(tail, low) : one ? dims.x + 1.0 : low + 0.2;
  float y = of_head ? (corner == 6 ? 0.0 : wide) : one ? dims.y + 1.0 : dims.z + extent.z;
  vec2 local = vec2(x, (corner & 1) == 0 ? -y : y);
  head_plane = vec4(normal, of_head ? 1.0 : -1.0, seam);
#else
  vec2 local = (vec2(gl_VertexID & 1, gl_VertexID >> 1 & 1) * 2.0 - 1.0) * half_size;
#endif
  vec2 at = frame.xy + local.x * frame.zw + local.y * vec2(-frame.w, frame.z);
  gl_Position = vec4(at * to_clip - 1.0, 0.0, 1.0);
  place = frame;
  box = dims;
  fill_color = vec4(fill.rgb * fill.a, fill.a);
  line_color = vec4(line.rgb * line.a, line.a);
  range = corners;
})";

// From a signed distance in pixels to colour: the outline is the band of width box.w inside of the rim.
constexpr const char* kPaint = R"(
flat in vec4 place, box;
flat in vec4 fill_color, line_color;
flat in uvec2 range;
out vec4 color;
vec2 local_point() {
  vec2 d = gl_FragCoord.xy - place.xy;
  return vec2(dot(d, place.zw), dot(d, vec2(-place.w, place.z)));
}
vec4 paint(float d) {
  float whole = clamp(0.5 - d, 0.0, 1.0);
  float inner = clamp(0.5 - d - box.w, 0.0, 1.0);
  return fill_color * inner + line_color * (whole - inner);
}
float rounded_box(vec2 local) {
  vec2 q = abs(local) - box.xy;
  return length(max(q, 0.0)) + min(max(q.x, q.y), 0.0) - box.z;
})";

constexpr const char* kRoundedFragment = R"(
void main() { color = paint(rounded_box(local_point())); }
)";

// A disc with a radius line towards (box.x, box.y).
constexpr const char* kSpokeFragment = R"(
void main() {
  vec2 local = local_point();
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
  vec2 local = local_point();
  vec4 four = edge_x[0] * local.x + edge_y[0] * local.y - edge_d[0];
  for (int i = 1; i < EDGES / 4; ++i) four = max(four, edge_x[i] * local.x + edge_y[i] * local.y - edge_d[i]);
  float distance = max(max(four.x, four.y), max(four.z, four.w));
  color = paint(range.y == 0u ? rounded_box(local) : distance);
}
)";

// Rounded polygons: distance to the edges, inside by the side of all of them; a box where there are no
// corners.
constexpr const char* kPolygonFragment = R"(
uniform samplerBuffer edges;
void main() {
  vec2 local = local_point();
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
  color = paint(range.y == 0u ? rounded_box(local) : (side > 0.0 ? distance : -distance) - box.z);
}
)";

// A shaft with a round end, and a triangular head of length box.w at the right.
constexpr const char* kArrowFragment = R"(
flat in vec4 head_plane;
void main() {
  vec2 local = local_point();
  float head = box.w, back = box.x - head;
  float left = min(-box.x + box.z, back);
  float shaft = length(vec2(local.x - clamp(local.x, left, back + 0.25 * head), local.y)) - box.z;
  if (head >= 2.0 * box.x - 0.01) shaft = 1e9;
  float tip = max(dot(vec2(local.x - box.x, abs(local.y)), head_plane.xy), back - local.x);
  float whole = clamp(0.5 - min(shaft, tip), 0.0, 1.0);
  bool of_head = local.x >= head_plane.w;
  color = of_head == (head_plane.z > 0.0) ? fill_color * whole : vec4(0.0);
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
  vec2 step = vec2(gl_VertexID & 1, gl_VertexID >> 1 & 1) * vec2(source.zw);
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
  for (GLuint i = 0; i < attributes; ++i) glEnableVertexAttribArray(i);
  return name;
}

// Corners of a shape, and the triangles between them.
constexpr int kQuad[] = {0, 1, 2, 2, 1, 3};
constexpr int kArrow[] = {0, 1, 2, 2, 1, 3, 4, 5, 6};
constexpr std::size_t kQuadCorners = 4, kArrowCorners = 7;

std::size_t corners_of(const Batch& batch) {
  if (batch.points) return 1;
  return batch.program == Program::Arrow ? kArrowCorners : kQuadCorners;
}

/// Indices of the triangles of many shapes, one after the other; grows with the largest batch.
class TriangleIndices {
 public:
  TriangleIndices(const int* pattern, std::size_t length, std::size_t corners)
      : pattern_(pattern), length_(length), corners_(corners) {
    glGenBuffers(1, &name_);
  }
  ~TriangleIndices() { glDeleteBuffers(1, &name_); }
  TriangleIndices(const TriangleIndices&) = delete;
  TriangleIndices& operator=(const TriangleIndices&) = delete;

  /// Draws; the vertex array is bound.
  void draw(std::size_t shapes) {
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, name_);
    if (shapes > shapes_) {
      shapes_ = std::max(shapes + shapes / 2, std::size_t{256});
      std::vector<std::uint32_t> indices;
      indices.reserve(shapes_ * length_);
      for (std::size_t shape = 0; shape < shapes_; ++shape)
        for (std::size_t i = 0; i < length_; ++i)
          indices.push_back(static_cast<std::uint32_t>(shape * corners_) +
                            static_cast<std::uint32_t>(pattern_[i]));
      glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof indices[0]),
                   indices.data(), GL_STATIC_DRAW);
    }
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(shapes * length_), GL_UNSIGNED_INT, nullptr);
  }

 private:
  const int* pattern_;
  std::size_t length_, corners_, shapes_ = 0;
  GLuint name_ = 0;
};

}  // namespace

struct GlRenderer::State {
  GlyphAtlas atlas;
  ShapeBatches frame;
  GLuint programs[kProgramCount] = {},
         points[kProgramCount] = {};  // by Program; text and arrows are no points
  GLuint shape_array = 0, glyph_array = 0;
  GLuint edge_texture = 0, atlas_texture = 0;
  int atlas_height = 0;
  StreamBuffer shapes{GL_ARRAY_BUFFER}, glyphs{GL_ARRAY_BUFFER}, edges{GL_TEXTURE_BUFFER};
  TriangleIndices quads{kQuad, std::size(kQuad), kQuadCorners};
  TriangleIndices arrows{kArrow, std::size(kArrow), kArrowCorners};
  std::vector<ShapeInstance> shape_corners;  // each instance once a corner
  std::vector<GlyphInstance> glyph_corners;

  State();
  ~State();
  void upload();
  /// @param first corner of the batch in its buffer
  void draw(const Batch& batch, std::size_t first);
  void delete_programs() const;
};

GlRenderer::State::State() {
  const std::string paint = kPaint, vertex = kShapeVertex;
  const auto make = [&](Program which, const char* name, const char* defines, const char* fragment) {
    const std::string head = defines;
    programs[static_cast<int>(which)] = make_program(name, head + vertex, head + paint + fragment);
    if (which == Program::Arrow) return;
    points[static_cast<int>(which)] =
        make_program(name, head + "#define POINT\n" + vertex, head + paint + fragment);
  };
  try {
    make(Program::Rounded, "rounded", "", kRoundedFragment);
    make(Program::Spoke, "spoke", "", kSpokeFragment);
    make(Program::Convex4, "convex 4", "#define EDGES 4\n", kConvexFragment);
    make(Program::Convex8, "convex 8", "#define EDGES 8\n", kConvexFragment);
    make(Program::Polygon, "polygon", "", kPolygonFragment);
    make(Program::Arrow, "arrow", "#define ARROW\n", kArrowFragment);
    programs[static_cast<int>(Program::Text)] = make_program("text", kTextVertex, kTextFragment);
  } catch (...) {
    delete_programs();
    throw;
  }
  GLfloat sizes[2] = {1, 1};
  glGetFloatv(GL_POINT_SIZE_RANGE, sizes);
  frame.largest_point = static_cast<double>(sizes[1]);
  shape_array = make_vertex_array(5);
  glyph_array = make_vertex_array(4);
  glGenTextures(1, &edge_texture);
  glGenTextures(1, &atlas_texture);
}

void GlRenderer::State::delete_programs() const {
  for (const GLuint name : programs) glDeleteProgram(name);
  for (const GLuint name : points) glDeleteProgram(name);
}

GlRenderer::State::~State() {
  delete_programs();
  glDeleteVertexArrays(1, &shape_array);
  glDeleteVertexArrays(1, &glyph_array);
  glDeleteTextures(1, &edge_texture);
  glDeleteTextures(1, &atlas_texture);
}

// Instances are repeated for each corner: llvmpipe runs its whole vertex pipeline anew for each instance of
// an instanced draw, which costs more than a small shape itself; corners of a plain draw go through it by the
// thousand.
void GlRenderer::State::upload() {
  shape_corners.clear();
  glyph_corners.clear();
  for (const Batch& batch : frame.batches) {
    for (std::size_t i = batch.first; i < batch.first + batch.count; ++i) {
      if (batch.program == Program::Text)
        glyph_corners.insert(glyph_corners.end(), kQuadCorners, frame.glyphs[i]);
      else
        shape_corners.insert(shape_corners.end(), corners_of(batch), frame.shapes[i]);
    }
  }
  if (!shape_corners.empty())
    shapes.upload(shape_corners.data(), shape_corners.size() * sizeof(ShapeInstance));
  if (!glyph_corners.empty())
    glyphs.upload(glyph_corners.data(), glyph_corners.size() * sizeof(GlyphInstance));
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

void GlRenderer::State::draw(const Batch& batch, std::size_t first) {
  glUseProgram((batch.points ? points : programs)[static_cast<int>(batch.program)]);
  // The attributes start at the batch, so that a corner's number tells its place in the shape.
  if (batch.program == Program::Text) {
    glBindVertexArray(glyph_array);
    glBindBuffer(GL_ARRAY_BUFFER, glyphs.name());
    constexpr std::size_t kStride = sizeof(GlyphInstance);
    const std::size_t start = first * kStride;
    point_at(0, 2, GL_FLOAT, false, kStride, start + offsetof(GlyphInstance, corner));
    point_at_integers(1, 4, GL_UNSIGNED_SHORT, kStride, start + offsetof(GlyphInstance, texel));
    point_at(2, 4, GL_UNSIGNED_BYTE, true, kStride, start + offsetof(GlyphInstance, color));
    point_at_integers(3, 1, GL_UNSIGNED_INT, kStride, start + offsetof(GlyphInstance, channel));
  } else {
    glBindVertexArray(shape_array);
    glBindBuffer(GL_ARRAY_BUFFER, shapes.name());
    constexpr std::size_t kStride = sizeof(ShapeInstance);
    const std::size_t start = first * kStride;
    point_at(0, 4, GL_FLOAT, false, kStride, start + offsetof(ShapeInstance, centre));
    point_at(1, 4, GL_FLOAT, false, kStride, start + offsetof(ShapeInstance, half));
    point_at(2, 4, GL_UNSIGNED_BYTE, true, kStride, start + offsetof(ShapeInstance, fill));
    point_at(3, 4, GL_UNSIGNED_BYTE, true, kStride, start + offsetof(ShapeInstance, line));
    point_at_integers(4, 2, GL_UNSIGNED_INT, kStride, start + offsetof(ShapeInstance, first));
  }
  if (batch.points)
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(batch.count));
  else
    (batch.program == Program::Arrow ? arrows : quads).draw(batch.count);
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
  glEnable(GL_PROGRAM_POINT_SIZE);
  for (int i = 0; i < kProgramCount; ++i) {
    const auto which = static_cast<Program>(i);
    for (const GLuint program : {s.programs[i], s.points[i]}) {
      if (program == 0) continue;
      glUseProgram(program);
      glUniform2f(glGetUniformLocation(program, "to_clip"), 2.0f / static_cast<float>(target.scene_width()),
                  2.0f / static_cast<float>(target.scene_height()));
      glUniform3f(glGetUniformLocation(program, "extent"), which == Program::Spoke ? 0.0f : 1.0f, 1.0f,
                  static_cast<float>(margin_px(which)));
    }
  }
  std::size_t shape_corner = 0, glyph_corner = 0;
  for (const Batch& batch : s.frame.batches) {
    std::size_t& first = batch.program == Program::Text ? glyph_corner : shape_corner;
    s.draw(batch, first);
    first += batch.count * corners_of(batch);
  }
  glBindVertexArray(0);
  target.resolve();
  return {static_cast<int>(s.frame.shapes.size() + s.frame.glyphs.size()), s.frame.culled,
          static_cast<int>(s.frame.batches.size())};
}

}  // namespace skerry::render
