// SPDX-License-Identifier: MIT
#include "sandbox/painter.h"

#include <algorithm>

#include "render/egl_context.h"
#include "render/gl_renderer.h"
#include "render/target.h"
#include "render/ui_host.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {

struct Painter::State {
  explicit State(const PaintOptions& given)
      : options(given),
        style(given.style ? *given.style : render::style(given.theme)),
        context(given.device),
        target(given.width, given.height, given.ssaa),
        ui(style) {}

  PaintOptions options;
  render::Style style;
  render::EglContext context;  // first: the rest lives in it
  render::GlRenderer renderer;
  render::Target target;
  render::UiHost ui;
  render::Camera camera;
  render::DrawList list;
  std::vector<const Overlay*> overlays;

  // The panels of one frame; ImGui needs the same calls again until it has settled.
  void panels(const OverlayContext& scene) {
    const double scale = render::ui_scale(options.height);
    ui.begin_frame(options.width, options.height, scale, 1 / options.fps);
    PanelLayout layout(options.width, scale);
    const PanelContext context_of_panel{scene, ui, layout, scale};
    show_header(context_of_panel, options.speed);
    for (const Overlay* overlay : overlays)
      if (overlay->panel) overlay->panel(context_of_panel);
  }
};

Painter::Painter(const PaintOptions& options) : state_(std::make_unique<State>(options)) {}
Painter::~Painter() = default;

void Painter::start(const Demo& demo, const std::vector<std::string>& names) {
  State& state = *state_;
  state.overlays.clear();
  for (const Overlay& overlay : overlays())
    if (std::find(names.begin(), names.end(), overlay.name) != names.end())
      state.overlays.push_back(&overlay);
  const bool column = std::any_of(state.overlays.begin(), state.overlays.end(),
                                  [](const Overlay* overlay) { return overlay->column; });
  const View view = demo.picture().view.value_or(fitted_view(demo.world()));
  state.camera = place_camera(view, state.options.width, state.options.height, column);
  const History empty(demo, false, 1);
  Legend legend(state.camera, state.style, state.list[render::Layer::Labels]);
  for (int i = 0; i < 2; ++i) {
    state.panels({demo, demo.world(), empty, state.style, state.camera, legend});
    state.ui.end_frame();
  }
}

void Painter::paint(const Demo& demo, const History& history, render::Image& image) {
  State& state = *state_;
  state.list.clear();
  Legend legend(state.camera, state.style, state.list[render::Layer::Labels]);
  const OverlayContext scene{demo, demo.world(), history, state.style, state.camera, legend};
  draw_world(scene, state.list);
  for (const Overlay* overlay : state.overlays)
    if (overlay->draw) overlay->draw(scene, state.list);
  state.panels(scene);
  if (state.options.edit) state.options.edit(state.list);
  state.renderer.draw(state.list, state.camera, state.target);
  state.ui.end_frame(state.target);
  state.target.read(image);
}

std::string Painter::driver() const {
  std::string renderer = state_->context.renderer();
  // llvmpipe names the width of its vectors, which must not show in a picture.
  if (const std::size_t width = renderer.rfind(", ");
      width != std::string::npos && renderer.find(" bits)", width) != std::string::npos)
    renderer = renderer.substr(0, width) + ')';
  return renderer + ", " + state_->context.version();
}

Observe needs_of(const std::vector<std::string>& names) {
  Observe needs;
  for (const Overlay& overlay : overlays()) {
    if (std::find(names.begin(), names.end(), overlay.name) == names.end()) continue;
    needs.contacts = needs.contacts || overlay.needs.contacts;
    needs.systems = needs.systems || overlay.needs.systems;
    needs.solve_traces = needs.solve_traces || overlay.needs.solve_traces;
    needs.stage_times = needs.stage_times || overlay.needs.stage_times;
  }
  return needs;
}

}  // namespace skerry::sandbox
