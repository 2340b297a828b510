// SPDX-License-Identifier: MIT
//
// The flags of commands that make pictures.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sandbox/cli.h"
#include "sandbox/painter.h"

namespace skerry::sandbox {

/// --size --theme --renderer --ssaa --overlay --matrix --select
struct PictureOptions {
  std::string size = "1280x720";
  std::string theme = "light";
  std::string renderer = "auto";
  int ssaa = 1;
  std::vector<std::string> overlays;
  bool matrix = false;
  std::string select;

  /// Size, theme, renderer and supersampling as the painter wants them. @throws UsageError
  PaintOptions paint() const;
  /// The first of the given options that needs a picture of the scene, for commands that make none; "": none.
  std::string needs_picture() const;
  /// @throws UsageError for unknown overlays and malformed selections
  void check() const;
  /// Overlays of the demo and of the command line, each once; "none" drops those of the demo.
  std::vector<std::string> overlays_for(const Demo& demo) const;
  /// The demo's selection, changed by --select.
  Selection selection_for(const Demo& demo) const;
};

/// Reads "1280x720". @throws UsageError unless the sides are from the least ones to 16384
std::pair<int, int> parse_size(const std::string& text, int least_width, int least_height);

void add_picture_options(OptionTable& table, PictureOptions& options);

}  // namespace skerry::sandbox
