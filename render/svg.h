// SPDX-License-Identifier: MIT
//
// Draw lists as vector graphics, for papers.
#pragma once

#include <string>

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/sheet.h"

namespace skerry::render {

/// The picture that GlRenderer draws, as SVG 1.1: same order, colours and sizes, one user unit a pixel of the
/// camera. Same list, same bytes. Shapes are cut to the picture and left out as there; text refers to DejaVu
/// Sans by name.
/// @param title   goes into the <title> element; may be empty
/// @param panels  drawn over it; may be null
/// @throws std::invalid_argument for a bad camera
[[nodiscard]] std::string to_svg(const DrawList& list, const Camera& camera, const std::string& title = {},
                                 const Sheet* panels = nullptr);

/// A sheet alone, `width` x `height` pixels on `background`: a plot.
[[nodiscard]] std::string to_svg(const Sheet& sheet, int width, int height, Color background,
                                 const std::string& title = {});

}  // namespace skerry::render
