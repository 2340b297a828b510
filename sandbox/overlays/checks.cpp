// SPDX-License-Identifier: MIT
//
// What the demo expects and what was measured.
#include "sandbox/lua_args.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

void show_checks(const PanelContext& context) {
  constexpr double kRowPx = 36;
  constexpr std::size_t kMost = 5;
  static_assert(kRowPx * kMost + kSmallLinePx <= kChecksPx);
  const std::vector<Check>& checks = context.scene.demo.checks();
  const render::Style& style = context.scene.style;
  const std::size_t shown = std::min(checks.size(), kMost);
  const bool more = checks.size() > shown;
  const Panel panel(
      context, "Expected and measured",
      kRowPx * static_cast<double>(std::max<std::size_t>(shown, 1)) + (more ? kSmallLinePx : 0));
  if (checks.empty()) panel.text(0, 0, style.text_dim, "no expectations");
  double y = 0;
  for (std::size_t i = 0; i < shown; ++i) {
    const Check& check = checks[i];
    const bool waiting = check.state == CheckState::Waiting;
    const bool fails = check.state == CheckState::Fails;
    const bool lost = check.state == CheckState::Unmeasured;
    // Signs besides colours: readable without telling red from green.
    const char* mark = waiting || lost ? "\xC2\xB7" : fails ? "\xC3\x97" : "\xE2\x9C\x93";
    const render::Color color = waiting || lost ? style.text_dim : fails ? style.warning : style.accent;
    panel.text(0, y, color, mark);
    panel.fitted(18, y, panel.width() - 18, style.text, check.what);
    const std::string value =
        waiting ? "" : (lost ? "cannot be measured" : format_number(check.value)) + "   ";
    panel.fitted(18, y + kLinePx, panel.width() - 18, style.text_dim,
                 value + "(expected " + check.condition() + ")");
    y += kRowPx;
  }
  if (more) panel.small(18, y, style.text_dim, "and " + std::to_string(checks.size() - shown) + " more");
}

}  // namespace skerry::sandbox
