// SPDX-License-Identifier: MIT
#include "sandbox/layout.h"

#include <algorithm>
#include <cmath>

#include "render/gl_renderer.h"
#include "sandbox/lua_args.h"
#include "sandbox/overlays/panel.h"

namespace skerry::sandbox {

namespace {

double round_down_to(double value, std::initializer_list<double> mantissas) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  double result = power;
  // 4.9999999 is 5 that was rounded.
  for (const double mantissa : mantissas)
    if (value / power >= mantissa * (1 - 1e-9)) result = mantissa * power;
  return result;
}

}  // namespace

std::string round_amount(double amount, const char* unit) {
  return amount >= 0.1 && amount < 1000 ? format_number(amount) + ' ' + unit : si(amount, unit);
}

double round_down_125(double value) {
  return round_down_to(value, {1, 2, 5, 10});
}

double round_down(double value) {
  return round_down_to(value, {1, 1.5, 2, 3, 5, 7, 10});
}

render::Camera place_camera(const View& view, int width_px, int height_px, int columns, double footer,
                            double header) {
  const double ui = render::ui_scale(height_px);
  const double left = 0;
  const double taken = columns > 0 ? (columns * (kColumnPx + kMarginPx) + kMarginPx) * ui : 0;
  const double right = width_px - taken;
  const double top = header * ui;
  const double bottom = height_px - footer * ui;
  double scale = (bottom - top) / view.height;  // [px/m]
  if (view.width > 0) scale = std::min(scale, (right - left) / view.width);
  render::Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.height = height_px / scale;
  camera.centre = {view.centre.x - (0.5 * (left + right) - 0.5 * width_px) / scale,
                   view.centre.y + (0.5 * (top + bottom) - 0.5 * height_px) / scale};
  return camera;
}

View fitted_view(const World& world) {
  Aabb all{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
  for (const ShapeRecord& shape : world.shapes()) {
    if (!shape.alive || shape.shape->kind == ShapeKind::HalfPlane) continue;
    const Aabb box = bounding_box(shape.shape, world.pose(shape.body));
    all = united(all, box);
  }
  if (!(all.lower.x <= all.upper.x)) return {{0, 0}, 10, 0};
  const Vec2 size = all.upper - all.lower;
  // A fifth of air around, and something to see around a single tiny body.
  return {0.5 * (all.lower + all.upper), std::max(1.2 * size.y, 0.1), 1.2 * size.x};
}

double moving_width(const World& world, double centre) {
  double half = 0;
  for (const ShapeRecord& shape : world.shapes()) {
    if (!shape.alive || world.bodies().type[shape.body.index] != BodyType::Dynamic) continue;
    const Aabb box = bounding_box(shape.shape, world.pose(shape.body));
    half = std::max({half, centre - box.lower.x, box.upper.x - centre});
  }
  return 2.1 * half;  // and a little air
}

PanelLayout::PanelLayout(int width_px, int height_px, double footer)
    : width_(width_px), scale_(render::ui_scale(height_px)), room_(height_px / scale_ - kHeaderPx - footer) {
  // A third of the picture stays for the scene; beside a single column a seventh will do.
  const double column = (kColumnPx + kMarginPx) * scale_;
  const bool one = height_px >= kLeastLinesForWords && width_ - column - kMarginPx * scale_ >= width_ / 7;
  most_columns_ = one ? static_cast<std::size_t>(std::max(1.0, std::floor(width_ * 2 / 3 / column))) : 0;
}

int PanelLayout::reserve(double height) {
  // It would leave the picture. Few panels get as high as they may, so a little too much is let pass.
  if (height > room_ + 2 * kFooterPx) return -1;
  std::size_t column = 0;
  while (column < used_.size() && used_[column] + height > room_) ++column;
  if (column == most_columns_) return -1;
  if (column == used_.size()) used_.push_back(0);
  used_[column] += height + kMarginPx;
  column_.push_back(column);
  return static_cast<int>(column_.size()) - 1;
}

double PanelLayout::scene_right() const {
  return width_ - (static_cast<double>(used_.size()) * (kColumnPx + kMarginPx) + kMarginPx) * scale_;
}

void PanelLayout::begin_frame() {
  next_.assign(used_.size(), kHeaderPx * scale_);
}

PanelLayout::Position PanelLayout::place(int index, double height) {
  const std::size_t column = column_.at(static_cast<std::size_t>(index));
  const double x = width_ - static_cast<double>(column + 1) * (kColumnPx + kMarginPx) * scale_;
  const Position position{x, next_[column]};
  next_[column] += (height + kMarginPx) * scale_;
  return position;
}

Legend::Legend(const render::Camera& camera, const render::Style& style, render::DrawLayer& layer,
               double scene_right, double below)
    : scene_right_(scene_right),
      camera_(camera),
      style_(style),
      layer_(layer),
      scale_(render::ui_scale(camera.height_px)) {
  x_ = kMarginPx * scale_;
  y_ = bottom_ = camera.height_px - (0.5 * kFooterPx + below) * scale_;
  right_ = camera.width_px - kMarginPx * scale_;
}

void Legend::make_room(double width) {
  begin_ = x_;
  if (x_ + width <= right_ || x_ <= kMarginPx * scale_) return;
  begin_ = x_ = kMarginPx * scale_;
  y_ -= kLegendRowPx * scale_;
  right_ = scene_right_;
}

void Legend::text(const std::string& text) {
  layer_.labels.push_back({.at = at(x_, y_),
                           .text = text,
                           .color = style_.text,
                           .halo = style_.halo,
                           .size_px = style_.small_text_px,
                           .anchor = render::Anchor::Right,
                           .offset_px = 0});
  const double right = x_ + render::text_width(text, style_.small_text_px) * scale_;
  const double half = 0.5 * kLegendRowPx * scale_;
  boxes_.push_back({begin_, y_ - half, right, y_ + half});
  x_ = right + 26 * scale_;
}

void Legend::arrow(render::Color color, double length_px, const std::string& words) {
  make_room(length_px + (8 + render::text_width(words, style_.small_text_px)) * scale_);
  layer_.arrows.push_back({.from = at(x_, y_),
                           .to = at(x_ + length_px, y_),
                           .color = color,
                           .width_px = style_.arrow_px,
                           .head_px = style_.arrow_head_px});
  x_ += length_px + 8 * scale_;
  text(words);
}

void Legend::marker(render::Color fill, render::Color outline, const std::string& words) {
  make_room((14 + render::text_width(words, style_.small_text_px)) * scale_);
  x_ += 4 * scale_;
  layer_.markers.push_back(
      {.at = at(x_, y_), .fill = fill, .outline = outline, .radius_px = style_.contact_px});
  x_ += 10 * scale_;
  text(words);
}

void Legend::swatch(render::Paint paint, const std::string& words) {
  const double size = 12 * scale_;
  make_room(size + (7 + render::text_width(words, style_.small_text_px)) * scale_);
  const render::Point corners[] = {at(x_, y_ + 0.5 * size), at(x_ + size, y_ + 0.5 * size),
                                   at(x_ + size, y_ - 0.5 * size), at(x_, y_ - 0.5 * size)};
  layer_.polygon(corners, 4, paint.fill, paint.outline);
  x_ += size + 7 * scale_;
  text(words);
}

void Legend::bar(render::Color color, double length_px, const std::string& words) {
  make_room(length_px + (8 + render::text_width(words, style_.small_text_px)) * scale_);
  ticked(x_, x_ + length_px, y_, color);
  x_ += length_px + 8 * scale_;
  text(words);
}

void Legend::ticked(double left, double right, double y, render::Color color) {
  const double tick = 4 * scale_;
  const auto line = [&](render::Point from, render::Point to) {
    layer_.lines.push_back({.from = from, .to = to, .color = color, .width_px = 1.5f});
  };
  line(at(left, y), at(right, y));
  line(at(left, y - tick), at(left, y + tick));
  line(at(right, y - tick), at(right, y + tick));
}

void Legend::length_bar(double metres, double right_edge_px) {
  const double length = metres * camera_.pixels_per_metre();
  const double right = right_edge_px - kMarginPx * scale_;
  const double left = right - length;
  const std::string text = round_amount(metres, "m");
  right_ = left - (16 + render::text_width(text, style_.small_text_px)) * scale_;
  ticked(left, right, bottom_, style_.text);
  layer_.labels.push_back({.at = at(left, bottom_),
                           .text = text,
                           .color = style_.text,
                           .halo = style_.halo,
                           .size_px = style_.small_text_px,
                           .anchor = render::Anchor::Left,
                           .offset_px = 6});
}

}  // namespace skerry::sandbox
