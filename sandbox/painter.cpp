// SPDX-License-Identifier: MIT
#include "sandbox/painter.h"

#include <algorithm>

#include "render/canvas.h"
#include "render/egl_context.h"
#include "render/gl_renderer.h"
#include "render/svg.h"
#include "render/target.h"
#include "render/ui_host.h"
#include "sandbox/overlays/labels.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {

Composer::Composer(const render::Style& style, int width_px, int height_px)
    : style_(&style), width_px_(width_px), height_px_(height_px), layout_(width_px, height_px) {}

void Composer::show(const std::vector<std::string>& names, int width_px, int height_px) {
  width_px_ = width_px;
  height_px_ = height_px;
  words_ = height_px >= kLeastLinesForWords;
  header_ = words_ ? kHeaderPx : 0;
  footer_ = words_ ? kFooterPx : 0;
  shown_.clear();
  left_out_.clear();
  for (const Overlay& overlay : overlays()) {
    if (std::find(names.begin(), names.end(), overlay.name) == names.end()) continue;
    shown_.push_back({&overlay, -1});
    if (words_) footer_ += overlay.footer_px;
  }
  layout_ = PanelLayout(width_px, height_px, footer_);
  for (Shown& shown : shown_) {
    if (shown.overlay->panel_px <= 0) continue;
    shown.place = layout_.reserve(shown.overlay->panel_px + kPanelTitlePx + kPanelPadPx);
    if (shown.place < 0) left_out_.emplace_back(shown.overlay->name);
  }
}

render::Camera Composer::camera(const Demo& demo) const {
  View view = demo.picture().view.value_or(fitted_view(demo.world()));
  // A view without a width is meant for the whole of a 16:9 picture: beside panels and in narrower pictures,
  // what moves has to fit at least.
  if (view.width <= 0) {
    const bool wide = 9 * width_px_ >= 16 * height_px_;
    const double whole = wide ? view.height * width_px_ / height_px_ : view.height * 16 / 9;
    view.width = std::min(whole, moving_width(demo.world(), view.centre.x));
  }
  return place_camera(view, width_px_, height_px_, layout_.columns(), footer_, header_);
}

void Composer::scene(const Demo& demo, const History& history, const render::Camera& camera,
                     Selection& selection, render::DrawList& list) {
  list.clear();
  render::DrawLayer nowhere;
  render::DrawLayer& words = words_ ? list[render::Layer::Labels] : nowhere;
  Legend legend(camera, *style_, words, layout_.scene_right(), footer_ - kFooterPx);
  LabelPlacer labels(camera, *style_, words);
  const OverlayContext context{demo, demo.world(), history, *style_, camera, legend, labels, selection};
  draw_world(context, list);
  for (const Shown& shown : shown_)
    if (shown.overlay->draw) shown.overlay->draw(context, list);
  legend_ = legend.boxes();
}

void Composer::panels(const Demo& demo, const History& history, const render::Camera& camera,
                      Selection& selection, render::UiHost& ui, double speed) {
  const double scale = render::ui_scale(camera.height_px);
  sheet_.clear();
  layout_.begin_frame();
  if (!words_) return;
  render::DrawLayer nowhere;
  Legend legend(camera, *style_, nowhere, 0);  // panels have none
  LabelPlacer labels(camera, *style_, nowhere);
  const OverlayContext scene{demo, demo.world(), history, *style_, camera, legend, labels, selection};
  note_top_ = show_header({scene, ui, layout_, sheet_, scale}, speed, footer_, legend_);
  for (const Shown& shown : shown_) {
    const bool fits = shown.place >= 0 || shown.overlay->panel_px <= 0;
    if (shown.overlay->panel && fits) shown.overlay->panel({scene, ui, layout_, sheet_, scale, shown.place});
  }
}

std::optional<Renderer> parse_renderer(const std::string& name) {
  if (name == "auto") return Renderer::Auto;
  if (name == "gl") return Renderer::OpenGl;
  if (name == "cpu") return Renderer::Cpu;
  return std::nullopt;
}

struct Painter::State {
  explicit State(const PaintOptions& given)
      : options(given),
        style(given.style ? *given.style : render::style(given.theme)),
        context(given.device),
        ui(style),
        composer(style, given.width, given.height) {
    const bool cpu =
        given.renderer == Renderer::Cpu || (given.renderer == Renderer::Auto && context.software());
    if (cpu) {
      canvas.emplace(given.width, given.height, given.ssaa);
    } else {
      renderer.emplace();
      target.emplace(given.width, given.height, given.ssaa);
    }
  }

  void draw(render::Image& image) {
    if (canvas) {
      canvas->draw(list, camera);
      ui.end_frame(*canvas);
      canvas->take(image);
    } else {
      renderer->draw(list, camera, *target);
      ui.end_frame(*target);
      target->read(image);
    }
  }

  PaintOptions options;
  render::Style style;
  render::EglContext context;            // before all that lives in it
  std::optional<render::Canvas> canvas;  // or the next two
  std::optional<render::GlRenderer> renderer;
  std::optional<render::Target> target;
  render::UiHost ui;
  Composer composer;
  render::Camera camera;
  Selection selection;
  render::DrawList list, last_list;
  render::Sheet last_sheet;
  bool painted = false;

  void panels(const Demo& demo, const History& history) {
    ui.begin_frame(options.width, options.height, render::ui_scale(options.height), 1 / options.fps);
    composer.panels(demo, history, camera, selection, ui, options.speed);
  }
};

Painter::Painter(const PaintOptions& options) : state_(std::make_unique<State>(options)) {}
Painter::~Painter() = default;

void Painter::start(const Demo& demo, const std::vector<std::string>& names) {
  State& state = *state_;
  state.composer.show(names, state.options.width, state.options.height);
  state.camera = state.composer.camera(demo);
  state.painted = false;
  // ImGui needs two frames until it has settled.
  const History empty(demo, false, 1);
  for (int i = 0; i < 2; ++i) {
    state.panels(demo, empty);
    state.ui.end_frame();
  }
}

void Painter::select(const Selection& selection) {
  state_->selection = selection;
}

bool Painter::paint(const Demo& demo, const History& history, render::Image& image) {
  State& state = *state_;
  state.composer.scene(demo, history, state.camera, state.selection, state.list);
  state.panels(demo, history);
  const render::Sheet& sheet = state.composer.sheet();
  if (state.options.edit) state.options.edit(state.list);
  if (state.painted && state.options.reuse && !state.options.edit && state.list == state.last_list &&
      sheet == state.last_sheet) {
    state.ui.end_frame();
    return false;
  }
  state.draw(image);
  state.painted = true;
  std::swap(state.list, state.last_list);
  state.last_sheet = sheet;
  return true;
}

std::string Painter::svg(const std::string& title) const {
  return render::to_svg(state_->last_list, state_->camera, title, &state_->last_sheet);
}

const Composer& Painter::composer() const {
  return state_->composer;
}

std::string Painter::driver() const {
  if (state_->canvas) return "built-in rasteriser";
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
    needs.paths = needs.paths || overlay.needs.paths;
  }
  return needs;
}

}  // namespace skerry::sandbox
