// SPDX-License-Identifier: MIT
//
// Paints frames of a demo: scene, overlays, panels. `Composer` makes the parts as data, for whoever draws
// them (captures, the window, figures); `Painter` draws them without a window.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/draw_list.h"
#include "render/egl_context.h"
#include "render/image.h"
#include "render/style.h"
#include "sandbox/demo.h"
#include "sandbox/history.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/overlay.h"

namespace skerry::sandbox {

/// The overlays that are on, and who of them stands where.
class Composer {
 public:
  Composer(const render::Style& style, int width_px, int height_px);

  void set_style(const render::Style& style) { style_ = &style; }
  /// Turns overlays on; all others are off. @param names rows of the overlay registry
  void show(const std::vector<std::string>& names, int width_px, int height_px);
  /// A camera that shows the demo's view, or everything, in the part that panels leave free.
  render::Camera camera(const Demo& demo) const;

  /// Fills the scene: world and overlays.
  void scene(const Demo& demo, const History& history, const render::Camera& camera, Selection& selection,
             render::DrawList& list);
  /// Fills header and panels; between `begin_frame` and `end_frame` of `ui`.
  /// @param speed of the video; 1 is not mentioned
  void panels(const Demo& demo, const History& history, const render::Camera& camera, Selection& selection,
              render::UiHost& ui, double speed);
  /// The marks of the last `panels`.
  const render::Sheet& sheet() const { return sheet_; }
  /// Upper edge of the note of the last `panels`; without a note, of what stands below the scene [px].
  float note_top() const { return note_top_; }
  /// Overlays whose panels found no room.
  const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  struct Shown {
    const Overlay* overlay;
    int place;  ///< in the layout; -1: no panel in a column
  };

  const render::Style* style_;
  int width_px_, height_px_;
  double header_ = kHeaderPx, footer_ = kFooterPx;
  bool words_ = true;  ///< header, legends and panels; not in tiny pictures
  std::vector<Shown> shown_;
  std::vector<std::string> left_out_;
  float note_top_ = 0;
  std::vector<PixelBox> legend_;  ///< what the legend of the last `scene` covers
  PanelLayout layout_;
  render::Sheet sheet_;
};

/// Who draws. The built-in rasteriser is several times as fast as a driver that has no graphics processor.
enum class Renderer {
  Auto,    ///< OpenGL where there is a graphics processor, else the built-in rasteriser
  OpenGl,  ///< whatever the driver is
  Cpu      ///< the built-in rasteriser
};
/// @param name "auto", "gl" or "cpu"
std::optional<Renderer> parse_renderer(const std::string& name);

struct PaintOptions {
  int width = 1280, height = 720;  ///< [px]
  int ssaa = 1;                    ///< the scene is drawn so many times finer in each direction
  render::Theme theme = render::Theme::Light;
  double fps = 60;
  double speed = 1;
  render::EglDevice device = render::EglDevice::Any;
  Renderer renderer = Renderer::Auto;
  std::optional<render::Style> style{};  ///< in place of the theme's
  bool reuse = true;  ///< a frame like the last one is not drawn again; off for tests and benchmarks
  /// Sees each frame when all of it is there and nothing is drawn: the list, and the panels as ImGui windows.
  /// What it changes is drawn; the self-test of the golden images plants its regressions here.
  std::function<void(render::DrawList&)> edit{};
};

class Painter {
 public:
  /// @throws render::EnvironmentError without EGL or OpenGL 3.3
  explicit Painter(const PaintOptions& options);
  ~Painter();

  /// Prepares for a demo: camera and overlays. @param names rows of the overlay registry
  void start(const Demo& demo, const std::vector<std::string>& names);
  void select(const Selection& selection);
  /// @return false: the picture is that of the last call, and `image`, which must be the same, was not
  /// touched
  bool paint(const Demo& demo, const History& history, render::Image& image);
  /// The picture of the last `paint` as SVG.
  std::string svg(const std::string& title) const;
  const Composer& composer() const;

  /// What draws, without what cannot show in a picture: "built-in rasteriser", or "llvmpipe (LLVM 15.0.6),
  /// 4.5 (Core Profile) Mesa 22.3.6".
  std::string driver() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What the overlays called `names` need from the world.
Observe needs_of(const std::vector<std::string>& names);

}  // namespace skerry::sandbox
