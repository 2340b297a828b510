// SPDX-License-Identifier: MIT
#include "sandbox/picture_options.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <tuple>

#include "sandbox/errors.h"
#include "sandbox/names.h"

namespace skerry::sandbox {

namespace {

constexpr int kMostSide = 16384;
constexpr std::int64_t kMostPoints = std::int64_t{kMostSide} * kMostSide;

}  // namespace

std::pair<int, int> parse_size(const std::string& text, int least_width, int least_height) {
  int width = 0, height = 0;
  const char* const last = text.data() + text.size();
  const auto [middle, error] = std::from_chars(text.data(), last, width);
  if (error == std::errc() && middle != last && *middle == 'x') {
    const auto [end, other] = std::from_chars(middle + 1, last, height);
    if (other == std::errc() && end == last && width >= least_width && height >= least_height &&
        width <= kMostSide && height <= kMostSide)
      return {width, height};
  }
  const auto by = [](int w, int h) { return std::to_string(w) + 'x' + std::to_string(h); };
  throw UsageError("--size expected WIDTHxHEIGHT from " + by(least_width, least_height) + " to " +
                   by(kMostSide, kMostSide) + " pixels, got \"" + text + '"');
}

std::string PictureOptions::needs_picture() const {
  const PictureOptions usual;
  if (size != usual.size) return "--size";
  if (renderer != usual.renderer) return "--renderer";
  if (ssaa != usual.ssaa) return "--ssaa";
  if (!overlays.empty()) return "--overlay";
  if (matrix) return "--matrix";
  return select.empty() ? "" : "--select";
}

PaintOptions PictureOptions::paint() const {
  PaintOptions paint;
  std::tie(paint.width, paint.height) = parse_size(size, 16, 16);
  if (static_cast<std::int64_t>(paint.width) * ssaa * paint.height * ssaa > kMostPoints)
    throw UsageError("--ssaa " + std::to_string(ssaa) + " makes " + size + " pixels too many; at most " +
                     std::to_string(kMostPoints) + " finer ones");
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
  table.add("--ssaa", options.ssaa, "Draws the scene so many times finer, 1 to 4").whole(1, 4).group(group);
  table
      .add("--renderer", options.renderer,
           "Who draws: gl (OpenGL), cpu (the built-in rasteriser), or auto: gl where there is a graphics "
           "processor, else cpu, which is then faster")
      .type("NAME")
      .group(group);
  table.add("--theme", options.theme, "light or dark").type("THEME").group(group);
}

}  // namespace skerry::sandbox
