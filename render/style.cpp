// SPDX-License-Identifier: MIT
#include "render/style.h"

#include <algorithm>
#include <cmath>

namespace skerry::render {
namespace {

constexpr Color rgb(std::uint32_t hex, int alpha = 255) {
  return {static_cast<std::uint8_t>(hex >> 16), static_cast<std::uint8_t>(hex >> 8),
          static_cast<std::uint8_t>(hex), static_cast<std::uint8_t>(alpha)};
}

// Hues of Okabe and Ito: sky, orange, green, vermilion, purple, yellow, blue, grey. On light ground the fills
// are tints and the outlines shades of the hue, so that neighbours differ in lightness too.
Style light_style() {
  Style s;
  s.theme = Theme::Light;
  s.background = rgb(0xfbfbf9);
  s.grid = rgb(0xeceae4);
  s.grid_major = rgb(0xd8d5cc);
  s.bodies = {{{rgb(0x9fd2f0), rgb(0x2a7fb0)},
               {rgb(0xf1b955), rgb(0x986000)},
               {rgb(0x84cfb4), rgb(0x00765a)},
               {rgb(0xf0a582), rgb(0xb04a08)},
               {rgb(0xe2b1cd), rgb(0x9a5580)},
               {rgb(0xf6ee90), rgb(0x958a00)},
               {rgb(0x8fb4dc), rgb(0x00538a)},
               {rgb(0xa9afb9), rgb(0x444c57)}}};
  s.ground = {rgb(0xd9d6ce), rgb(0x77736a)};
  s.asleep = {rgb(0xdfe2e6), rgb(0x8a929c)};
  s.selected = {rgb(0xfff0b0), rgb(0x202020)};
  s.contact = rgb(0x1d1d1f);
  s.normal = rgb(0x3a3f47);
  s.impulse = rgb(0xc8321f);
  s.friction = rgb(0x0064ad);
  s.velocity = rgb(0x00805f);
  s.force = rgb(0x8a3a78);
  s.joint = rgb(0x5a5148);
  s.structure = rgb(0x0072b2, 110);
  s.warning = rgb(0xc40f3a);
  s.text = rgb(0x1b1c1f);
  s.text_dim = rgb(0x6a6f78);
  s.halo = rgb(0xfbfbf9, 225);
  s.panel = rgb(0xffffff, 238);
  s.panel_border = rgb(0xcfccc4);
  s.accent = rgb(0x0072b2);
  return s;
}

Style dark_style() {
  Style s;
  s.theme = Theme::Dark;
  s.background = rgb(0x15181d);
  s.grid = rgb(0x20252c);
  s.grid_major = rgb(0x313842);
  s.bodies = {{{rgb(0x2c6f96), rgb(0x8fd0f5)},
               {rgb(0x8a5c14), rgb(0xf2b043)},
               {rgb(0x1c705a), rgb(0x5fd3b0)},
               {rgb(0x8f4a24), rgb(0xf59a6c)},
               {rgb(0x7c4a6a), rgb(0xe6a9cb)},
               {rgb(0x8f872c), rgb(0xfbf18a)},
               {rgb(0x265380), rgb(0x84b6ea)},
               {rgb(0x424952), rgb(0x98a1ad)}}};
  s.ground = {rgb(0x2b313a), rgb(0x7f8a98)};
  s.asleep = {rgb(0x2a2f37), rgb(0x626c79)};
  s.selected = {rgb(0x6b5d1c), rgb(0xffffff)};
  s.contact = rgb(0xf4f6f8);
  s.normal = rgb(0xc9d0d9);
  s.impulse = rgb(0xff6a52);
  s.friction = rgb(0x57b4ff);
  s.velocity = rgb(0x4fd8ae);
  s.force = rgb(0xe79bd3);
  s.joint = rgb(0xc4b8a6);
  s.structure = rgb(0x56b4e9, 120);
  s.warning = rgb(0xff4f74);
  s.text = rgb(0xeef1f4);
  s.text_dim = rgb(0x98a2af);
  s.halo = rgb(0x15181d, 225);
  s.panel = rgb(0x1d2127, 238);
  s.panel_border = rgb(0x3a424d);
  s.accent = rgb(0x56b4e9);
  return s;
}

}  // namespace

std::string_view to_string(Theme theme) {
  return theme == Theme::Light ? "light" : "dark";
}

std::optional<Theme> parse_theme(std::string_view name) {
  if (name == "light") return Theme::Light;
  if (name == "dark") return Theme::Dark;
  return std::nullopt;
}

const Style& style(Theme theme) {
  static const Style light = light_style(), dark = dark_style();
  return theme == Theme::Light ? light : dark;
}

const Paint& body_paint(const Style& style, long index) {
  const long hue = (index % kHueCount + kHueCount) % kHueCount;
  return style.bodies[static_cast<std::size_t>(hue)];
}

double ui_scale(int height) {
  return std::max(height / 720.0, 0.6);
}

Color faded(Color color, double factor) {
  color.a = static_cast<std::uint8_t>(std::lround(color.a * std::clamp(factor, 0.0, 1.0)));
  return color;
}

Color mixed(Color a, Color b, double t) {
  t = std::clamp(t, 0.0, 1.0);
  const auto mix = [t](int from, int to) {
    return static_cast<std::uint8_t>(std::lround(from + (to - from) * t));
  };
  return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b), mix(a.a, b.a)};
}

}  // namespace skerry::render
