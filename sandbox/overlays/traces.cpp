// SPDX-License-Identifier: MIT
//
// The way that bodies went, as a line each. Where the script names an interval also the bodies at its
// multiples, as under a stroboscope: equal distances are equal speeds.
#include <algorithm>
#include <string>

#include "sandbox/layout.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

/// A colour that stands out from the background beside bodies of that hue.
render::Color color_of(const OverlayContext& context, const Trace& trace) {
  return context.world.alive(trace.point.body) ? paint_of(context, trace.point.body.index).outline
                                               : context.style.text_dim;
}

void draw_path(const OverlayContext& context, const Trace& trace, render::Color color,
               render::DrawLayer& layer) {
  const double now = context.demo.shown_time();
  const auto line = [&](Vec2 from, Vec2 to) {
    if (from == to) return;
    layer.lines.push_back({.from = to_point(from),
                           .to = to_point(to),
                           .color = render::faded(color, 0.8),
                           .width_px = context.style.outline_px});
  };
  const std::vector<TracePoint>& path = trace.path.samples();
  // Between steps the picture is older than the last samples.
  std::size_t count = 0;
  while (count < path.size() && path[count].time <= now) ++count;
  for (std::size_t i = 1; i < count; ++i) line(path[i - 1].at, path[i].at);
  if (count == 0 || !context.world.alive(trace.point.body)) return;
  const Transform pose = context.demo.shown(trace.point.body.index).pose();
  line(path[count - 1].at, to_world(pose, trace.point.local));
}

}  // namespace

void draw_traces(const OverlayContext& context, render::DrawList& list) {
  // Bodies of earlier moments stand behind all others; a path is seen wherever it goes.
  render::DrawLayer &behind = list[render::Layer::Background], &above = list[render::Layer::Structure];
  const double now = context.demo.shown_time();
  double interval = 0;
  const std::vector<Trace>& traces = context.history.traces().list();
  for (auto trace = traces.begin(); trace != traces.end(); ++trace) {
    const BodyId body = trace->point.body;
    const render::Color color = color_of(context, *trace);
    draw_path(context, *trace, color, above);
    // Once for a body of which several points are traced.
    const bool outlined =
        context.world.alive(body) &&
        std::none_of(traces.begin(), trace, [&](const Trace& t) { return t.point.body == body; });
    const std::vector<StrobePose>& strobes = trace->strobes.samples();
    if (strobes.size() > 1) interval = std::max(interval, strobes[1].time - strobes[0].time);
    for (const StrobePose& strobe : strobes) {
      if (strobe.time > now) break;
      if (outlined)
        draw_outline(context.world, body.index, strobe.pose, strobe.angle, render::faded(color, 0.45), 1.0f,
                     behind);
      above.markers.push_back(
          {.at = to_point(strobe.at), .fill = color, .outline = color, .radius_px = 2.0f});
    }
  }
  if (interval > 0)
    context.legend.marker(context.style.text, context.style.text, "every " + round_amount(interval, "s"));
}

}  // namespace skerry::sandbox
