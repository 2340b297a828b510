// SPDX-License-Identifier: MIT
#include "render/window_context.h"

// GLFW must not bring its own declarations of OpenGL.
#include <epoxy/gl.h>
//
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <array>
#include <imgui.h>
#include <stdexcept>
#include <utility>

#include "render/error.h"

namespace skerry::render {
namespace {

constexpr const char* kRemedy =
    "a window needs a display server (X11 or Wayland) and OpenGL 3.3; without one use "
    "'capture'; apt install libegl1 libgl1-mesa-dri";

std::string last_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text == nullptr ? "unknown reason" : text;
}

/// GLFW's number, ours, and ImGui's (-1: none).
struct KeyName {
  int glfw, ours, imgui;
};
constexpr KeyName kKeys[] = {
    {GLFW_KEY_ESCAPE, kKeyEscape, ImGuiKey_Escape},
    {GLFW_KEY_ENTER, kKeyEnter, ImGuiKey_Enter},
    {GLFW_KEY_KP_ENTER, kKeyEnter, ImGuiKey_KeyPadEnter},
    {GLFW_KEY_TAB, kKeyTab, ImGuiKey_Tab},
    {GLFW_KEY_BACKSPACE, kKeyBackspace, ImGuiKey_Backspace},
    {GLFW_KEY_DELETE, kKeyDelete, ImGuiKey_Delete},
    {GLFW_KEY_LEFT, kKeyLeft, ImGuiKey_LeftArrow},
    {GLFW_KEY_RIGHT, kKeyRight, ImGuiKey_RightArrow},
    {GLFW_KEY_UP, kKeyUp, ImGuiKey_UpArrow},
    {GLFW_KEY_DOWN, kKeyDown, ImGuiKey_DownArrow},
    {GLFW_KEY_HOME, kKeyHome, ImGuiKey_Home},
    {GLFW_KEY_END, kKeyEnd, ImGuiKey_End},
    {GLFW_KEY_PAGE_UP, kKeyPageUp, ImGuiKey_PageUp},
    {GLFW_KEY_PAGE_DOWN, kKeyPageDown, ImGuiKey_PageDown},
    {GLFW_KEY_SPACE, ' ', ImGuiKey_Space},
};

/// Letters that text fields know with Ctrl.
struct LetterName {
  int ours, imgui;
};
constexpr LetterName kLetters[] = {
    {'A', ImGuiKey_A}, {'C', ImGuiKey_C}, {'V', ImGuiKey_V},
    {'X', ImGuiKey_X}, {'Y', ImGuiKey_Y}, {'Z', ImGuiKey_Z},
};

/// 0 for keys that we do not report.
int our_key(int glfw, int scancode) {
  for (const KeyName& name : kKeys) {
    if (name.glfw == glfw) return name.ours;
  }
  if (glfw >= GLFW_KEY_F1 && glfw <= GLFW_KEY_F12) return kKeyF1 + glfw - GLFW_KEY_F1;
  if (glfw >= GLFW_KEY_KP_0 && glfw <= GLFW_KEY_KP_9) return '0' + glfw - GLFW_KEY_KP_0;
  return glfw > 32 && glfw < 128 ? printed_on(glfw, glfwGetKeyName(glfw, scancode)) : 0;
}

/// Whether the key that this letter is printed on is down.
bool letter_held(GLFWwindow* window, int letter) {
  for (int key = 33; key < 128; ++key) {
    const int scancode = glfwGetKeyScancode(key);
    if (scancode >= 0 && glfwGetKey(window, key) == GLFW_PRESS && our_key(key, scancode) == letter)
      return true;
  }
  return false;
}

void append_utf8(std::string& text, unsigned code) {
  const auto byte = [&](unsigned value) { text += static_cast<char>(value); };
  if (code < 0x80) {
    byte(code);
  } else if (code < 0x800) {
    byte(0xc0 | code >> 6);
    byte(0x80 | (code & 0x3f));
  } else if (code < 0x10000) {
    byte(0xe0 | code >> 12);
    byte(0x80 | (code >> 6 & 0x3f));
    byte(0x80 | (code & 0x3f));
  } else {
    byte(0xf0 | code >> 18);
    byte(0x80 | (code >> 12 & 0x3f));
    byte(0x80 | (code >> 6 & 0x3f));
    byte(0x80 | (code & 0x3f));
  }
}

}  // namespace

int printed_on(int glfw_key, const char* name) {
  if (glfw_key <= 32 || glfw_key >= 128) return 0;
  const bool digit = glfw_key >= GLFW_KEY_0 && glfw_key <= GLFW_KEY_9;
  const bool one = name != nullptr && name[0] > 32 && name[0] < 127 && name[1] == 0;
  if (digit || !one) return glfw_key;
  return name[0] >= 'a' && name[0] <= 'z' ? name[0] - 'a' + 'A' : name[0];
}

struct WindowContext::State {
  GLFWwindow* window = nullptr;
  int width = 1, height = 1;
  double last_time = -1;
  std::string renderer;
  WindowInput next;
  bool down[3] = {false, false, false};      // as the server says now
  bool reported[3] = {false, false, false};  // as the last poll() said
  bool pressed[3] = {false, false, false};   // went down since then, maybe up again
  bool repeating = false;                    // the last key is held

  static State& of(GLFWwindow* window) { return *static_cast<State*>(glfwGetWindowUserPointer(window)); }
  void measure() {
    int w = 0, h = 0;
    glfwGetFramebufferSize(window, &w, &h);
    if (w < 1 || h < 1 || (w == width && h == height)) return;
    width = w;
    height = h;
    next.resized = true;
  }
  void install_callbacks();
};

void WindowContext::State::install_callbacks() {
  glfwSetWindowUserPointer(window, this);
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int scancode, int action, int modifiers) {
    const int ours = our_key(key, scancode);
    of(w).repeating = action == GLFW_REPEAT;
    if (action == GLFW_RELEASE || ours == 0) return;
    of(w).next.keys.push_back({ours, (modifiers & GLFW_MOD_CONTROL) != 0, (modifiers & GLFW_MOD_SHIFT) != 0,
                               (modifiers & GLFW_MOD_ALT) != 0, action == GLFW_REPEAT});
  });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned code) {
    State& state = of(w);
    append_utf8(state.next.ui.text, code);
    if (code == '?') state.next.keys.push_back({.key = '?', .repeated = state.repeating});
  });
  glfwSetScrollCallback(
      window, [](GLFWwindow* w, double, double y) { of(w).next.ui.wheel += static_cast<float>(y); });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int) {
    if (button < 0 || button > 2) return;
    State& state = of(w);
    state.down[button] = action == GLFW_PRESS;
    state.pressed[button] = state.pressed[button] || action == GLFW_PRESS;
  });
}

WindowContext::WindowContext(const std::string& title, int width, int height)
    : state_(std::make_unique<State>()) {
  if (width < 1 || height < 1 || width > 16384 || height > 16384) {
    throw std::invalid_argument("window: sides must be 1 to 16384 px, got " + std::to_string(width) + " x " +
                                std::to_string(height));
  }
  if (!glfwInit()) throw EnvironmentError("window: " + last_error() + "; " + kRemedy);
  glfwWindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  State& s = *state_;
  s.window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (s.window == nullptr) {
    const std::string reason = last_error();
    glfwTerminate();
    throw EnvironmentError("window: " + reason + "; " + kRemedy);
  }
  glfwMakeContextCurrent(s.window);
  glfwSwapInterval(1);
  s.renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  s.install_callbacks();
  s.measure();
  s.next.resized = false;
}

WindowContext::~WindowContext() {
  glfwDestroyWindow(state_->window);
  glfwTerminate();
}

int WindowContext::width() const {
  return state_->width;
}
int WindowContext::height() const {
  return state_->height;
}
const std::string& WindowContext::renderer() const {
  return state_->renderer;
}
void WindowContext::set_title(const std::string& title) {
  glfwSetWindowTitle(state_->window, title.c_str());
}

WindowInput WindowContext::poll(double wait) {
  State& s = *state_;
  if (wait > 0)
    glfwWaitEventsTimeout(wait);
  else
    glfwPollEvents();
  s.measure();
  WindowInput input = std::exchange(s.next, {});
  // A click that was shorter than a frame: down now, up in the next.
  for (int i = 0; i < 3; ++i) {
    const bool hidden_press = s.pressed[i] && !s.reported[i];
    s.reported[i] = input.ui.mouse_down[i] = s.down[i] || hidden_press;
    s.pressed[i] = false;
  }
  double x = 0, y = 0;
  int points_wide = 1, points_high = 1;
  glfwGetCursorPos(s.window, &x, &y);
  glfwGetWindowSize(s.window, &points_wide, &points_high);
  // A drag goes on outside of the window.
  const bool held_down = input.ui.mouse_down[0] || input.ui.mouse_down[1] || input.ui.mouse_down[2];
  if (glfwGetWindowAttrib(s.window, GLFW_HOVERED) || held_down) {
    input.ui.mouse_x = static_cast<float>(x * s.width / std::max(points_wide, 1));
    input.ui.mouse_y = static_cast<float>(y * s.height / std::max(points_high, 1));
  }
  const auto held = [&](int key) { return glfwGetKey(s.window, key) == GLFW_PRESS; };
  for (const KeyName& name : kKeys) {
    const bool pressed = std::any_of(input.keys.begin(), input.keys.end(),
                                     [&](const KeyPress& press) { return press.key == name.ours; });
    if (held(name.glfw) || pressed) input.ui.keys_down.push_back(name.imgui);
  }
  for (const LetterName& name : kLetters) {
    const bool pressed = std::any_of(input.keys.begin(), input.keys.end(),
                                     [&](const KeyPress& press) { return press.key == name.ours; });
    if (pressed || letter_held(s.window, name.ours)) input.ui.keys_down.push_back(name.imgui);
  }
  input.ui.ctrl = held(GLFW_KEY_LEFT_CONTROL) || held(GLFW_KEY_RIGHT_CONTROL);
  input.ui.shift = held(GLFW_KEY_LEFT_SHIFT) || held(GLFW_KEY_RIGHT_SHIFT);
  input.ui.alt = held(GLFW_KEY_LEFT_ALT) || held(GLFW_KEY_RIGHT_ALT);
  input.close = glfwWindowShouldClose(s.window) != 0;
  const double now = glfwGetTime();
  input.seconds = s.last_time < 0 ? 0 : now - s.last_time;
  s.last_time = now;
  return input;
}

void WindowContext::present(Target& target) {
  State& s = *state_;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  const bool same = target.width() == s.width && target.height() == s.height;
  // Row 0 of the target is the top, of the window the bottom: upside down.
  glBlitFramebuffer(0, 0, target.width(), target.height(), 0, s.height, s.width, 0, GL_COLOR_BUFFER_BIT,
                    same ? GL_NEAREST : GL_LINEAR);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  glfwSwapBuffers(s.window);
}

}  // namespace skerry::render
