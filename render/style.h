// SPDX-License-Identifier: MIT
//
// Colours and sizes of everything that is drawn, for a light and a dark theme. Demos and overlays take
// colours from here only, so that pictures look alike and colour-blind viewers can read them.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "render/draw_list.h"

namespace skerry::render {

enum class Theme : std::uint8_t { Light, Dark };

/// "light" or "dark".
[[nodiscard]] std::string_view to_string(Theme theme);
[[nodiscard]] std::optional<Theme> parse_theme(std::string_view name);

/// Fill and outline that belong together.
struct Paint {
  Color fill, outline;
};

/// Number of hues that viewers with any common colour blindness can tell apart.
inline constexpr int kHueCount = 8;

struct Style {
  Theme theme = Theme::Light;

  Color background;
  Color grid;        ///< one line a metre (or a power of ten)
  Color grid_major;  ///< every tenth line, and the axes

  /// Bodies: hues after Okabe and Ito (2008), "Color universal design", with calmer fills.
  std::array<Paint, kHueCount> bodies;
  Paint ground;    ///< static bodies
  Paint asleep;    ///< bodies of a sleeping island
  Paint selected;  ///< the picked body

  Color contact;   ///< contact points
  Color normal;    ///< contact normals
  Color impulse;   ///< normal impulses [N s]
  Color friction;  ///< friction impulses [N s]
  Color velocity;
  Color force;  ///< applied forces
  Color joint;
  Color structure;  ///< cells, trees and axes of the broad phase
  Color warning;    ///< residual too large, quarantined body

  Color text, text_dim;
  Color halo;          ///< behind labels; the background, nearly opaque
  Color panel;         ///< background of ImGui windows
  Color panel_border;  ///< and their frames
  Color accent;        ///< sliders, checks, headers

  // Sizes in pixels of a 720-line picture.
  float outline_px = 1.6f;
  float normal_px = 2.0f;    ///< shaft of contact normals
  float arrow_px = 2.6f;     ///< shaft of impulses, forces, velocities
  float arrow_head_px = 11;  ///< length of their heads
  float joint_px = 2.5f;
  float contact_px = 3.5f;  ///< radius of contact points
  float text_px = 15;
  float small_text_px = 13;
  float title_px = 21;
};

/// The built-in style of a theme.
[[nodiscard]] const Style& style(Theme theme);

/// Paint number `index` of the body palette; any index, negative too, wraps around.
[[nodiscard]] const Paint& body_paint(const Style& style, long index);

/// Factor from the pixels of the style (720 lines) to those of a picture with `height` lines, never below
/// 0.6: smaller text cannot be read.
[[nodiscard]] double ui_scale(int height);

/// `color` with its alpha multiplied by `factor` in [0, 1].
[[nodiscard]] Color faded(Color color, double factor);

/// Straight mix, `t` = 0 gives a, 1 gives b.
[[nodiscard]] Color mixed(Color a, Color b, double t);

}  // namespace skerry::render
