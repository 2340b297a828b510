// SPDX-License-Identifier: MIT
#include "sandbox/picture_options.h"

#include <algorithm>
#include <cstdio>

#include "sandbox/errors.h"
#include "sandbox/names.h"

namespace skerry::sandbox {

PaintOptions PictureOptions::paint() const {
  PaintOptions paint;
  int used = 0;
  const bool read = std::sscanf(size.c_str(), "%dx%d%n", &paint.width, &paint.height, &used) == 2;
  if (!read || used != static_cast<int>(size.size()) || paint.width < 16 || paint.height < 16 ||
      paint.width > 16384 || paint.height > 16384)
    throw UsageError("--size expected WIDTHxHEIGHT from 16x16 to 16384x16384 pixels, got \"" + size + '"');
  const std::optional<render::Theme> chosen = render::parse_theme(theme);
  if (!chosen) throw UsageError("--theme expected light or dark, got \"" + theme + '"');
  paint.theme = *chosen;
  const std::optional<Renderer> who = parse_renderer(renderer);
  if (!who) throw UsageError("--renderer expected auto, gl or cpu, got \"" + renderer + '"');
  paint.renderer = *who;
  paint.ssaa = ssaa;
  return paint;
}

void PictureOptions::check() const {
  std::vector<std::string> known = overlay_names();
  known.emplace_back("none");
  for (const std::string& name : overlays)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError("--overlay: no \"" + name + '"' + suggestion(name, known));
  parse_selection(select);
}

std::vector<std::string> PictureOptions::overlays_for(const Demo& demo) const {
  std::vector<std::string> wanted;
  if (std::find(overlays.begin(), overlays.end(), "none") == overlays.end()) wanted = demo.picture().overlays;
  wanted.insert(wanted.end(), overlays.begin(), overlays.end());
  if (matrix) wanted.emplace_back("matrix");
  std::vector<std::string> names;
  for (const std::string& name : wanted)
    if (name != "none" && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  return names;
}

Selection PictureOptions::selection_for(const Demo& demo) const {
  return resolve(merged(demo.picture().selection, parse_selection(select)), demo.world());
}

void add_picture_options(OptionTable& table, PictureOptions& options) {
  const std::string group = "Picture";
  table
      .add("--size", options.size,
           "WIDTHxHEIGHT in pixels (default 1280x720); below 160 lines the scene alone, without words")
      .type("SIZE")
      .group(group);
  table
      .add("--overlay", options.overlays,
           "Adds overlays: " + join(overlay_names()) + "; none drops the demo's own")
      .type("NAME,...")
      .repeatable(',')
      .group(group);
  table.add_flag("--matrix", options.matrix, "Same as --overlay matrix").group(group);
  table.add("--select", options.select, "Lights up row=3,col=5, body=A, body=A,other=B or island=2")
      .type("NAME=VALUE,...")
      .group(group);
  table.add("--ssaa", options.ssaa, "Draws the scene so many times finer, 1 to 4").range(1, 4).group(group);
  table
      .add("--renderer", options.renderer,
           "Who draws: gl (OpenGL), cpu (the built-in rasteriser), or auto: gl where there is a graphics "
           "processor, else cpu, which is then faster")
      .type("NAME")
      .group(group);
  table.add("--theme", options.theme, "light or dark").type("THEME").group(group);
}

}  // namespace skerry::sandbox
