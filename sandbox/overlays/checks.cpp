// SPDX-License-Identifier: MIT
//
// What the demo expects and what was measured.
#include "sandbox/lua_args.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

void show_checks(const PanelContext& context) {
  constexpr double kRowPx = 38;
  const std::vector<Check>& checks = context.scene.demo.checks();
  const render::Style& style = context.scene.style;
  const Panel panel(context, "Expected and measured",
                    kRowPx * static_cast<double>(std::max<std::size_t>(checks.size(), 1)));
  const auto scale = static_cast<float>(context.scale);
  float y = panel.y();
  if (checks.empty()) panel.text(panel.x(), y, style.text_dim, "no expectations");
  for (const Check& check : checks) {
    const bool waiting = check.state == CheckState::Waiting;
    const bool fails = check.state == CheckState::Fails;
    // Signs besides colours: readable without telling red from green.
    const char* mark = waiting ? "\xC2\xB7" : fails ? "\xC3\x97" : "\xE2\x9C\x93";
    const render::Color color = waiting ? style.text_dim : fails ? style.warning : style.accent;
    panel.text(panel.x(), y, color, mark);
    panel.text(panel.x() + 18 * scale, y, style.text, check.what);
    const std::string value = waiting ? "" : format_number(check.value) + "   ";
    panel.text(panel.x() + 18 * scale, y + 17 * scale, style.text_dim,
               value + "(expected " + check.condition() + ")");
    y += static_cast<float>(kRowPx) * scale;
  }
}

}  // namespace skerry::sandbox
