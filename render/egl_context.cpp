// SPDX-License-Identifier: MIT
#include "render/egl_context.h"

#include <cstdio>
#include <cstring>
#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "render/error.h"

namespace skerry::render {
namespace {

constexpr const char* kRemedy = "apt install libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri";

std::string egl_error(const char* step) {
  char text[96];
  std::snprintf(text, sizeof text, "%s failed (EGL error 0x%04x)", step,
                static_cast<unsigned>(eglGetError()));
  return text;
}

bool has_word(const char* list, const char* word) {
  if (list == nullptr) return false;
  const std::size_t length = std::strlen(word);
  for (const char* at = std::strstr(list, word); at != nullptr; at = std::strstr(at + 1, word)) {
    const bool starts = at == list || at[-1] == ' ';
    if (starts && (at[length] == ' ' || at[length] == '\0')) return true;
  }
  return false;
}

/// libepoxy ends the process when it cannot load a library, so look first.
std::string missing_library() {
  const auto loads = [](const char* name) { return dlopen(name, RTLD_LAZY | RTLD_LOCAL) != nullptr; };
  if (!loads("libEGL.so.1")) return "libEGL.so.1";
  if (!loads("libOpenGL.so.0") && !loads("libGL.so.1")) return "libGL.so.1";
  return {};
}

struct Candidate {
  std::string way;
  EGLenum platform;
  void* native;
  bool software;
};

/// Every way to a display, in the order in which they are tried.
std::vector<Candidate> candidates(EglDevice wanted, std::vector<EglAttempt>& attempts) {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const bool devices =
      has_word(extensions, "EGL_EXT_device_base") ||
      (has_word(extensions, "EGL_EXT_device_enumeration") && has_word(extensions, "EGL_EXT_device_query"));
  std::vector<Candidate> hardware, software, all;
  if (devices && has_word(extensions, "EGL_EXT_platform_device")) {
    EGLDeviceEXT list[32];
    EGLint count = 0;
    if (!eglQueryDevicesEXT(32, list, &count)) {
      attempts.push_back({"EGL devices", false, egl_error("eglQueryDevicesEXT")});
      count = 0;
    }
    for (EGLint i = 0; i < count; ++i) {
      const char* about = eglQueryDeviceStringEXT(list[i], EGL_EXTENSIONS);
      const bool soft = has_word(about, "EGL_MESA_device_software");
      std::string way = soft ? "software device" : "device " + std::to_string(i);
      if (!soft && has_word(about, "EGL_EXT_device_drm")) {
        if (const char* file = eglQueryDeviceStringEXT(list[i], EGL_DRM_DEVICE_FILE_EXT)) {
          way += std::string(" (") + file + ")";
        }
      }
      (soft ? software : hardware).push_back({way, EGL_PLATFORM_DEVICE_EXT, list[i], soft});
    }
  } else {
    attempts.push_back({"EGL devices", false, "the EGL library cannot list devices"});
  }
  if (wanted == EglDevice::Any) {
    all = hardware;
    if (has_word(extensions, "EGL_MESA_platform_surfaceless")) {
      all.push_back({"surfaceless Mesa", EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, false});
    } else {
      attempts.push_back({"surfaceless Mesa", false, "the EGL library lacks EGL_MESA_platform_surfaceless"});
    }
  }
  all.insert(all.end(), software.begin(), software.end());
  if (software.empty()) attempts.push_back({"software device", false, "the EGL library has none"});
  return all;
}

std::string gl_text(GLenum name) {
  const GLubyte* text = glGetString(name);
  return text == nullptr ? "unknown" : reinterpret_cast<const char*>(text);
}

/// The steps to a current context on one display; on failure `detail` says which step, and nothing stays.
bool open(const Candidate& candidate, EGLDisplay& display, EGLContext& context, std::string& detail) {
  context = EGL_NO_CONTEXT;
  display = eglGetPlatformDisplayEXT(candidate.platform, candidate.native, nullptr);
  if (display == EGL_NO_DISPLAY) {
    detail = egl_error("eglGetPlatformDisplayEXT");
    return false;
  }
  if (!eglInitialize(display, nullptr, nullptr)) {
    detail = egl_error("eglInitialize");
    return false;
  }
  const EGLint config_wish[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  const EGLint context_wish[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 3,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 3,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!has_word(eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context")) {
    detail = "no EGL_KHR_surfaceless_context";
  } else if (!eglBindAPI(EGL_OPENGL_API)) {
    detail = egl_error("eglBindAPI(OpenGL)");
  } else if (!eglChooseConfig(display, config_wish, &config, 1, &count) || count < 1) {
    detail = egl_error("eglChooseConfig");
  } else if ((context = eglCreateContext(display, config, EGL_NO_CONTEXT, context_wish)) == EGL_NO_CONTEXT) {
    detail = egl_error("eglCreateContext(3.3 core)");
  } else if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    detail = egl_error("eglMakeCurrent");
  } else {
    detail = gl_text(GL_VERSION) + ", " + gl_text(GL_RENDERER);
    return true;
  }
  if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
  context = EGL_NO_CONTEXT;
  eglTerminate(display);
  return false;
}

void close(EGLDisplay display, EGLContext context) {
  eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display, context);
  // A display is shared by all contexts that came the same way, and EGL does not count: it stays initialised.
}

}  // namespace

EglContext::EglContext(EglDevice device) {
  const std::string library = missing_library();
  if (!library.empty()) throw EnvironmentError("OpenGL: cannot load " + library + "; " + kRemedy);
  for (const Candidate& candidate : candidates(device, attempts_)) {
    EGLDisplay display;
    EGLContext context;
    std::string detail;
    const bool ok = open(candidate, display, context, detail);
    attempts_.push_back({candidate.way, ok, detail});
    if (!ok) continue;
    display_ = display;
    context_ = context;
    vendor_ = gl_text(GL_VENDOR);
    renderer_ = gl_text(GL_RENDERER);
    version_ = gl_text(GL_VERSION);
    software_ = candidate.software || renderer_.find("llvmpipe") != std::string::npos ||
                renderer_.find("softpipe") != std::string::npos;
    return;
  }
  std::string text = "OpenGL 3.3 without a window: no way works. Tried:";
  for (const EglAttempt& attempt : attempts_) text += "\n  " + attempt.way + ": " + attempt.detail;
  throw EnvironmentError(text + "\n" + kRemedy);
}

EglContext::~EglContext() {
  close(display_, context_);
}

void EglContext::make_current() {
  eglBindAPI(EGL_OPENGL_API);
  if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
    throw EnvironmentError("OpenGL: " + egl_error("eglMakeCurrent"));
  }
}

void EglContext::release() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

void EglContext::finish() {
  glFinish();
}

std::vector<EglAttempt> probe_egl() {
  const std::string library = missing_library();
  if (!library.empty()) return {{"load " + library, false, "not found"}};
  // Whatever is current now stays so.
  const EGLDisplay old_display = eglGetCurrentDisplay();
  const EGLContext old_context = eglGetCurrentContext();
  std::vector<EglAttempt> attempts;
  for (const Candidate& candidate : candidates(EglDevice::Any, attempts)) {
    EGLDisplay display;
    EGLContext context;
    std::string detail;
    const bool ok = open(candidate, display, context, detail);
    attempts.push_back({candidate.way, ok, detail});
    if (ok) close(display, context);
  }
  if (old_context != EGL_NO_CONTEXT) eglMakeCurrent(old_display, EGL_NO_SURFACE, EGL_NO_SURFACE, old_context);
  return attempts;
}

}  // namespace skerry::render
