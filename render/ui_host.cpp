// SPDX-License-Identifier: MIT
#include "render/ui_host.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <epoxy/gl.h>
#include <imgui.h>
#include <stdexcept>

#include "render/error.h"
#include "render/font_data.h"
#include "render/gl_program.h"
#include "render/ui_raster.h"

namespace skerry::render {
namespace {

// ImGui's own backend draws bottom row first; our pictures have the top row first (see target.h).
constexpr const char* kVertex = R"(
layout(location = 0) in vec2 at;
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 tint;
uniform vec2 to_clip;
out vec2 texel;
out vec4 ink;
void main() {
  texel = uv;
  ink = tint;
  gl_Position = vec4(at * to_clip - 1.0, 0.0, 1.0);
})";

constexpr const char* kFragment = R"(
in vec2 texel;
in vec4 ink;
uniform sampler2D image;
out vec4 color;
void main() {
  vec4 both = ink * texture(image, texel);
  color = vec4(both.rgb * both.a, both.a);
})";

// The same where the texel is white: sampling is most of the cost on llvmpipe.
constexpr const char* kSolidFragment = R"(
in vec4 ink;
out vec4 color;
void main() { color = vec4(ink.rgb * ink.a, ink.a); }
)";

// Solid triangles of at least so many pixels get a call of their own: the backgrounds of panels.
constexpr float kLargeSolid = 4096;

// Whether the triangle at `index` is large and has the same white texel at all corners.
bool is_large_solid(const ImDrawList& list, const ImDrawCmd& command, unsigned index, ImVec2 white) {
  ImVec2 p[3];
  for (unsigned k = 0; k < 3; ++k) {
    const auto corner = list.IdxBuffer[static_cast<int>(command.IdxOffset + index + k)];
    const ImDrawVert& vertex = list.VtxBuffer[static_cast<int>(command.VtxOffset + corner)];
    if (vertex.uv.x != white.x || vertex.uv.y != white.y) return false;
    p[k] = vertex.pos;
  }
  const float area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
  return std::abs(area) > kLargeSolid;
}

ImVec4 to_imgui(Color color) {
  return {static_cast<float>(color.r) / 255, static_cast<float>(color.g) / 255,
          static_cast<float>(color.b) / 255, static_cast<float>(color.a) / 255};
}

/// The characters of our panels: Latin, Greek, arrows, mathematics, geometric shapes.
constexpr ImWchar kRanges[] = {0x0020, 0x017f, 0x0370, 0x03ff, 0x2010, 0x2027, 0x2070, 0x209c, 0x2190,
                               0x21ff, 0x2200, 0x22ff, 0x25a0, 0x25ff, 0x2713, 0x2717, 0};

// Sizes of the fonts at scale 1 [px].
constexpr double kRegular = 16, kTitle = 23, kMono = 15;

/// How the letters of all panels are baked into one texture.
struct Baking {
  int width = 2048;    ///< [texels]
  int oversample = 4;  ///< quarter pixels, as in the labels
  double share = 1;    ///< of the size in the picture; the letters of very large pictures are magnified
};

/// @param most  texels that a side of a texture may have
Baking baking_for(double scale, int most) {
  constexpr double kTexels = 430e3;  // that the four fonts take, at scale 1 and not oversampled
  constexpr int kTallest = 16384;    // ImGui leaves out letters, silently, not far beyond
  constexpr int kWidths[] = {2048, 4096};
  const double height = std::min(most, kTallest);
  for (const int oversample : {4, 2, 1}) {
    for (const int width : kWidths)
      if (width <= most && kTexels * scale * scale * oversample <= width * height)
        return {width, oversample, 1};
  }
  const int width = std::min(most, kWidths[1]);
  return {width, 1, std::sqrt(width * height / kTexels) / scale};
}

/// Magnifies what was baked too small.
void magnify(ImFont& font, float size) {
  const float factor = size / font.FontSize;
  for (ImFontGlyph& glyph : font.Glyphs) {
    for (float* number : {&glyph.X0, &glyph.X1, &glyph.Y0, &glyph.Y1, &glyph.AdvanceX}) *number *= factor;
  }
  font.FontSize = size;
  font.Ascent *= factor;
  font.Descent *= factor;
  font.BuildLookupTable();
}

void apply(const Style& style, double scale) {
  ImGuiStyle look;
  const bool light = style.theme == Theme::Light;
  if (light) {
    ImGui::StyleColorsLight(&look);
  } else {
    ImGui::StyleColorsDark(&look);
  }
  const auto set = [&](ImGuiCol which, Color color) { look.Colors[which] = to_imgui(color); };
  const Color body = mixed(style.panel, style.text, 0.06), hover = mixed(style.panel, style.accent, 0.28);
  const Color pressed = mixed(style.panel, style.accent, 0.45);
  set(ImGuiCol_Text, style.text);
  set(ImGuiCol_TextDisabled, style.text_dim);
  set(ImGuiCol_WindowBg, style.panel);
  set(ImGuiCol_PopupBg, style.panel);
  set(ImGuiCol_Border, style.panel_border);
  set(ImGuiCol_BorderShadow, {0, 0, 0, 0});
  set(ImGuiCol_TitleBg, body);
  set(ImGuiCol_TitleBgActive, body);
  set(ImGuiCol_TitleBgCollapsed, body);
  set(ImGuiCol_FrameBg, body);
  set(ImGuiCol_FrameBgHovered, hover);
  set(ImGuiCol_FrameBgActive, pressed);
  set(ImGuiCol_Button, body);
  set(ImGuiCol_ButtonHovered, hover);
  set(ImGuiCol_ButtonActive, pressed);
  set(ImGuiCol_Header, mixed(style.panel, style.accent, 0.18));
  set(ImGuiCol_HeaderHovered, hover);
  set(ImGuiCol_HeaderActive, pressed);
  set(ImGuiCol_CheckMark, style.accent);
  set(ImGuiCol_SliderGrab, style.accent);
  set(ImGuiCol_SliderGrabActive, style.accent);
  set(ImGuiCol_PlotLines, style.accent);
  set(ImGuiCol_PlotHistogram, style.accent);
  set(ImGuiCol_Separator, style.panel_border);
  set(ImGuiCol_TableHeaderBg, body);
  set(ImGuiCol_TableBorderStrong, style.panel_border);
  set(ImGuiCol_TableBorderLight, mixed(style.panel, style.panel_border, 0.5));
  look.WindowRounding = 6;
  look.FrameRounding = 4;
  look.GrabRounding = 4;
  look.PopupRounding = 5;
  look.ScrollbarRounding = 6;
  look.WindowBorderSize = 1;
  look.WindowPadding = {10, 9};
  look.FramePadding = {7, 4};
  look.ItemSpacing = {8, 5};
  look.CellPadding = {6, 2};
  look.WindowMenuButtonPosition = ImGuiDir_None;
  look.ScaleAllSizes(static_cast<float>(scale));
  // Borders of whole pixels stay sharp.
  look.WindowBorderSize = std::max(1.0f, std::round(static_cast<float>(scale)));
  ImGui::GetStyle() = look;
}

}  // namespace

struct UiHost::State {
  ImGuiContext* context = nullptr;
  const Style* style = nullptr;
  double scale = 0;
  GLuint program = 0, solid_program = 0, vertex_array = 0;
  UiPixels fonts;
  LetterCache letters;
  StreamBuffer vertices{GL_ARRAY_BUFFER}, indices{GL_ELEMENT_ARRAY_BUFFER};
  ImFont* regular = nullptr;
  ImFont* bold = nullptr;
  ImFont* title = nullptr;
  ImFont* mono = nullptr;

  void build_fonts();
  void draw(const ImDrawData& data, int first_list, int end_list, Target& target);
};

UiHost::UiHost(const Style& style) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.program = make_program("panels", kVertex, kFragment);
  s.solid_program = make_program("panels, solid", kVertex, kSolidFragment);
  s.style = &style;
  s.context = ImGui::CreateContext();
  ImGui::SetCurrentContext(s.context);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.BackendPlatformName = "skerry";
  io.BackendRendererName = "skerry";
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  io.ConfigWindowsMoveFromTitleBarOnly = true;
  glGenVertexArrays(1, &s.vertex_array);
  glGenTextures(1, &s.fonts.name);
}

UiHost::~UiHost() {
  State& s = *state_;
  ImGui::DestroyContext(s.context);
  glDeleteProgram(s.program);
  glDeleteProgram(s.solid_program);
  glDeleteVertexArrays(1, &s.vertex_array);
  glDeleteTextures(1, &s.fonts.name);
}

void UiHost::State::build_fonts() {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  atlas.Clear();
  letters.clear();
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  const Baking baking = baking_for(scale, most);
  const auto pixels_of = [&](double size) { return static_cast<float>(std::round(size * scale)); };
  const auto add = [&](FontData data, double size) {
    ImFontConfig config;
    config.FontDataOwnedByAtlas = false;
    config.OversampleH = baking.oversample;
    config.OversampleV = 1;
    config.PixelSnapH = false;
    config.GlyphRanges = kRanges;
    const double share = baking.share;
    const float baked = share < 1 ? static_cast<float>(std::floor(size * scale * share)) : pixels_of(size);
    // ImGui only reads the bytes, although it asks for a pointer to mutable ones.
    return atlas.AddFontFromMemoryTTF(const_cast<std::uint8_t*>(data.bytes), static_cast<int>(data.size),
                                      baked, &config);
  };
  // ImGui counts from the ascent to the descent, 1.164 em in this font: 16 is the size of 13.7 px in a
  // browser.
  regular = add(sans_font(), kRegular);
  bold = add(sans_bold_font(), kRegular);
  title = add(sans_bold_font(), kTitle);
  mono = add(mono_font(), kMono);
  atlas.TexDesiredWidth = baking.width;
  // A power of two of rows may be more than there can be.
  atlas.Flags = baking.width > Baking().width ? ImFontAtlasFlags_NoPowerOfTwoHeight : ImFontAtlasFlags_None;
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  atlas.GetTexDataAsRGBA32(&pixels, &width, &height);
  if (height > most)
    throw EnvironmentError("panels: letters at scale " + std::to_string(scale) + " take a texture of " +
                           std::to_string(width) + " x " + std::to_string(height) +
                           ", the driver allows sides of up to " + std::to_string(most));
  if (baking.share < 1) {
    magnify(*regular, pixels_of(kRegular));
    magnify(*bold, pixels_of(kRegular));
    magnify(*title, pixels_of(kTitle));
    magnify(*mono, pixels_of(kMono));
  }
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, fonts.name);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
  // All texels are white; what they cover is enough for who draws without a driver.
  fonts.width = width;
  fonts.height = height;
  fonts.channels = 1;
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  fonts.texels.resize(count);
  for (std::size_t i = 0; i < count; ++i) fonts.texels[i] = pixels[4 * i + 3];
  atlas.SetTexID(&fonts);
  atlas.ClearTexData();
}

void UiHost::begin_frame(int width, int height, double scale, double dt, const UiInput& input) {
  if (width < 1 || height < 1 || !(scale > 0) || !(dt > 0) || !std::isfinite(scale * dt)) {
    throw std::invalid_argument("panels: size, scale and dt must be positive, got " + std::to_string(width) +
                                " x " + std::to_string(height) + " px, scale " + std::to_string(scale) +
                                ", dt " + std::to_string(dt) + " s");
  }
  State& s = *state_;
  ImGui::SetCurrentContext(s.context);
  if (scale != s.scale) {
    s.scale = scale;
    s.build_fonts();
    apply(*s.style, scale);
  }
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
  io.DeltaTime = static_cast<float>(dt);
  io.MousePos = input.mouse_x < -1e5f ? ImVec2(-FLT_MAX, -FLT_MAX) : ImVec2(input.mouse_x, input.mouse_y);
  for (int i = 0; i < 3; ++i) io.MouseDown[i] = input.mouse_down[i];
  io.MouseWheel = input.wheel;
  io.KeyCtrl = input.ctrl;
  io.KeyShift = input.shift;
  io.KeyAlt = input.alt;
  std::fill(std::begin(io.KeysDown), std::end(io.KeysDown), false);
  for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;
  for (const int key : input.keys_down) {
    if (key >= 0 && key < ImGuiKey_COUNT) io.KeysDown[key] = true;
  }
  if (!input.text.empty()) io.AddInputCharactersUTF8(input.text.c_str());
  ImGui::NewFrame();
}

void UiHost::end_frame() {
  ImGui::EndFrame();
}

void UiHost::end_frame(Target& target, const std::function<void()>& before_front) {
  ImGui::Render();
  const ImDrawData* data = ImGui::GetDrawData();
  const int lists = data != nullptr ? data->CmdListsCount : 0;
  // ImGui puts it last, and leaves it out while it is empty.
  const bool front = lists > 0 && data->CmdLists[lists - 1] == ImGui::GetForegroundDrawList();
  const int behind = front ? lists - 1 : lists;
  if (behind > 0) state_->draw(*data, 0, behind, target);
  if (before_front) before_front();
  if (front) state_->draw(*data, behind, lists, target);
}

void UiHost::end_frame(Canvas& canvas) {
  ImGui::Render();
  const ImDrawData* data = ImGui::GetDrawData();
  if (data == nullptr || data->TotalVtxCount == 0) return;
  const ImVec2 white = ImGui::GetIO().Fonts->TexUvWhitePixel;
  draw_panels(canvas.surface(), canvas.kernels(), *data, state_->fonts, state_->letters, white.x, white.y);
}

void UiHost::State::draw(const ImDrawData& data, int first_list, int end_list, Target& target) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  glViewport(0, 0, target.width(), target.height());
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glDisable(GL_CULL_FACE);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_SCISSOR_TEST);
  for (const GLuint which : {solid_program, program}) {
    glUseProgram(which);
    glUniform2f(glGetUniformLocation(which, "to_clip"), 2 / data.DisplaySize.x, 2 / data.DisplaySize.y);
  }
  glUniform1i(glGetUniformLocation(program, "image"), 0);
  const ImVec2 white = ImGui::GetIO().Fonts->TexUvWhitePixel;
  glActiveTexture(GL_TEXTURE0);
  glBindVertexArray(vertex_array);
  for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
  for (int n = first_list; n < end_list; ++n) {
    const ImDrawList& list = *data.CmdLists[n];
    vertices.upload(list.VtxBuffer.Data, static_cast<std::size_t>(list.VtxBuffer.size_in_bytes()));
    indices.upload(list.IdxBuffer.Data, static_cast<std::size_t>(list.IdxBuffer.size_in_bytes()));
    const auto offset = [](std::size_t bytes) { return reinterpret_cast<const void*>(bytes); };
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, sizeof(ImDrawVert), offset(offsetof(ImDrawVert, pos)));
    glVertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, sizeof(ImDrawVert), offset(offsetof(ImDrawVert, uv)));
    glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(ImDrawVert),
                          offset(offsetof(ImDrawVert, col)));
    for (const ImDrawCmd& command : list.CmdBuffer) {
      if (command.UserCallback != nullptr) {
        if (command.UserCallback != ImDrawCallback_ResetRenderState) command.UserCallback(&list, &command);
        continue;
      }
      const ImVec4 clip = command.ClipRect;
      const int left = std::max(0, static_cast<int>(clip.x)), top = std::max(0, static_cast<int>(clip.y));
      const int right = static_cast<int>(clip.z), bottom = static_cast<int>(clip.w);
      if (right <= left || bottom <= top) continue;
      glScissor(left, top, right - left, bottom - top);
      const auto* texture = static_cast<const UiPixels*>(command.GetTexID());
      glBindTexture(GL_TEXTURE_2D, texture->name);
      const bool text = texture == &fonts;
      for (unsigned first = 0; first < command.ElemCount;) {
        const bool solid = text && is_large_solid(list, command, first, white);
        unsigned last = first + 3;
        while (last < command.ElemCount && solid == (text && is_large_solid(list, command, last, white)))
          last += 3;
        glUseProgram(solid ? solid_program : program);
        glDrawElementsBaseVertex(GL_TRIANGLES, static_cast<GLsizei>(last - first),
                                 sizeof(ImDrawIdx) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT,
                                 offset((command.IdxOffset + first) * sizeof(ImDrawIdx)),
                                 static_cast<GLint>(command.VtxOffset));
        first = last;
      }
    }
  }
  glDisable(GL_SCISSOR_TEST);
  glBindVertexArray(0);
}

void UiHost::set_style(const Style& style) {
  state_->style = &style;
  ImGui::SetCurrentContext(state_->context);
  if (state_->scale > 0) apply(style, state_->scale);
}

bool UiHost::wants_mouse() const {
  return ImGui::GetIO().WantCaptureMouse;
}
bool UiHost::wants_keys() const {
  return ImGui::GetIO().WantCaptureKeyboard;
}
bool UiHost::wants_text() const {
  return ImGui::GetIO().WantTextInput;
}
ImFont* UiHost::regular() const {
  return state_->regular;
}
ImFont* UiHost::bold() const {
  return state_->bold;
}
ImFont* UiHost::title() const {
  return state_->title;
}
ImFont* UiHost::mono() const {
  return state_->mono;
}

UiTexture::UiTexture(bool smooth) : pixels_(std::make_unique<UiPixels>()) {
  pixels_->smooth = smooth;
  glGenTextures(1, &pixels_->name);
  glBindTexture(GL_TEXTURE_2D, pixels_->name);
  const GLint filter = smooth ? GL_LINEAR : GL_NEAREST;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

UiTexture::~UiTexture() {
  glDeleteTextures(1, &pixels_->name);
}

void UiTexture::upload(const Image& image) {
  pixels_->width = image.width;
  pixels_->height = image.height;
  pixels_->texels = image.rgba;
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, pixels_->name);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               image.rgba.data());
}

void* UiTexture::id() const {
  return pixels_.get();
}

}  // namespace skerry::render
