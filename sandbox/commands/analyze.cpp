// SPDX-License-Identifier: MIT
//
// Will it stand? Forces of a moment of a demo, what begins to move, how much is missing to that, and bridges.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>

#include "physics/statics/stability.h"
#include "physics/text.h"
#include "render/image.h"
#include "render/sheet.h"
#include "render/svg.h"
#include "sandbox/bridge_view.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/loop.h"
#include "sandbox/lua_args.h"
#include "sandbox/names.h"
#include "sandbox/output.h"
#include "sandbox/overlays/plot.h"
#include "sandbox/picture_options.h"
#include "sandbox/progress.h"

namespace skerry::sandbox {
namespace {

using namespace statics;
using Json = nlohmann::ordered_json;

struct Options {
  SharedOptions shared;
  PictureOptions picture;
  double at = 0;
  bool json = false;
  std::string output, influence_csv;
  int member = 0;
};

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string contact_label(const World& world, const RestContact& contact) {
  return body_label(world, contact.body_a) + "-" + body_label(world, contact.body_b);
}

/// "47.0 %"; three digits are what a reader can use.
std::string percent(double share) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100 * share);
  return text;
}

Json pair_json(Vec2 v) {
  return Json::array({v.x, v.y});
}

void analyse_bodies(const Demo& demo, bool pushed, Json& json, std::ostream& text) {
  const World& world = demo.world();
  const RestAnalysis rest = analyse_rest(world);
  if (rest.bodies.empty()) return;
  const Fate fate = fate_of(rest);
  json["fate"] = to_string(fate);
  json["bodies"] = rest.bodies.size();
  json["degree_of_indeterminacy"] = rest.indeterminacy;
  json["largest_acceleration"] = rest.largest_acceleration;
  json["residual"] = rest.residual;
  text << demo.name() << ": " << to_string(fate) << " (" << rest.bodies.size() << " bodies, "
       << rest.contacts.size() << " contact points";
  if (rest.indeterminacy > 0) text << ", " << rest.indeterminacy << " times statically indeterminate";
  text << ")\n";
  std::vector<std::string> more;
  if (world.callbacks().field) more.emplace_back("the force field, as it acts on what rests");
  if (pushed) more.emplace_back("the forces of on_step and attract at this moment");
  json["loads_of_the_script"] = more;
  if (!more.empty()) text << "  among the loads: " << join(more, "; ") << '\n';
  double speed = 0;
  for (const BodyId body : rest.bodies)
    speed = std::max(speed, length(world.velocity(body)) + std::abs(world.omega(body)));
  if (speed > 1e-6)
    text << "  it moves at up to " << format_number(speed) << " m/s; the forces are those of rest\n";
  if (fate != Fate::Stands)
    text << "  accelerations up to " << format_number(rest.largest_acceleration) << " m/s^2\n";

  const std::vector<PairForce> pairs = pair_forces(rest);
  Json list = Json::array();
  double grip = 0, edge = 0;
  std::string grip_at, edge_at;
  for (const PairForce& pair : pairs) {
    const RestContact& first = rest.contacts[static_cast<std::size_t>(pair.first)];
    const std::string name = contact_label(world, first);
    list.push_back({{"contact", name},
                    {"normal_force", pair.normal},
                    {"friction_force", pair.friction},
                    {"at", pair_json(pair.at)},
                    {"share_of_friction_limit", pair.grip},
                    {"eccentricity", pair.eccentricity},
                    {"unique", pair.unique}});
    if (pair.normal > 0 && pair.grip > grip) {
      grip = pair.grip;
      grip_at = name;
    }
    if (pair.normal > 0 && pair.count == 2 && pair.eccentricity > edge) {
      edge = pair.eccentricity;
      edge_at = name;
    }
  }
  json["contacts"] = std::move(list);
  Json joints = Json::array();
  for (const RestJoint& joint : rest.joints)
    joints.push_back({{"joint", joint.slot}, {"force", pair_json(joint.force)}, {"unique", joint.unique}});
  json["joints"] = std::move(joints);
  // Below a millionth it is rounding: nothing pushes sideways, or the force runs through the middle.
  constexpr double kNoticed = 1e-6;
  if (grip > kNoticed)
    text << "  nearest to sliding: " << grip_at << ", " << percent(grip) << " of its friction\n";
  if (edge > kNoticed)
    text << "  nearest to opening: " << edge_at << ", its force at " << percent(edge)
         << " of the way from the middle to the edge\n";

  if (!rest.stands) return;
  if (!limit_load_available()) {
    text << "  margin: " << limit_load_missing() << '\n';
    return;
  }
  const Stability stability = stability_of(rest);
  json["margin"] = {{"status", to_string(stability.status)}};
  if (stability.status == LimitStatus::NoLoad) {
    text << "  margin: none, nothing has a weight\n";
    return;
  }
  if (stability.status == LimitStatus::Unbounded) {
    text << "  margin: no push sideways moves it\n";
    return;
  }
  if (stability.status != LimitStatus::Optimal) {
    text << "  margin: not found (" << to_string(stability.status) << ")\n";
    return;
  }
  const std::string side = stability.to_left ? "to the left" : "to the right";
  const std::string governing =
      stability.contact < 0
          ? std::string("none")
          : contact_label(world, rest.contacts[static_cast<std::size_t>(stability.contact)]);
  json["margin"]["horizontal_acceleration_over_gravity"] = stability.margin;
  json["margin"]["direction"] = side;
  json["margin"]["governing_contact"] = governing;
  const std::string mode = stability.contact < 0 ? "none" : stability.slides ? "slides" : "opens";
  json["margin"]["mode"] = mode;
  json["margin"]["upper_bound"] = stability.slides;
  char tilt[32];
  std::snprintf(tilt, sizeof tilt, "%.1f", std::atan(stability.margin) * 180 / kPi);
  text << "  margin: " << percent(stability.margin) << " of gravity sideways (a tilt of " << tilt
       << " degrees), weakest " << side;
  // Without a contact it goes in its joints, or hangs on springs.
  if (stability.contact >= 0) text << "; then " << governing << ' ' << mode;
  text << '\n';
  if (stability.slides) text << "  where contacts slide the margin is an upper bound (associated flow)\n";
}

void analyse_bridges(const Demo& demo, Json& json, std::ostream& text) {
  if (demo.bridges().empty()) return;
  Json list = Json::array();
  for (const BridgeView& view : demo.bridges()) {
    const Bridge& bridge = *view.bridge;
    Json entry;
    entry["determinacy"] = bridge.determinacy().sentence();
    entry["moving"] = bridge.moving();
    entry["residual"] = bridge.response().residual;
    Json members = Json::array();
    for (const MemberState& state : bridge.members())
      members.push_back({{"axial", state.axial},
                         {"use", state.signed_use},
                         {"peak", state.peak_use},
                         {"peak_time", state.peak_time},
                         {"broken", state.broken}});
    entry["members"] = std::move(members);
    const int worst = bridge.worst();
    text << demo.name() << ": bridge of " << bridge.members().size() << " members, "
         << bridge.determinacy().sentence() << '\n';
    for (const Break& failure : bridge.breaks())
      text << "  member " << failure.member + 1 << " broke at " << format_number(failure.time) << " s\n";
    if (worst >= 0) {
      const MemberState& state = bridge.members()[static_cast<std::size_t>(worst)];
      entry["governing_member"] = worst + 1;
      text << "  governing: member " << worst + 1 << ", " << percent(std::abs(state.peak_use))
           << " of its strength in " << (state.peak_use < 0 ? "compression" : "tension") << " at "
           << format_number(state.peak_time) << " s\n";
    }
    list.push_back(std::move(entry));
  }
  json["bridges"] = std::move(list);
}

// Influence line of a member as CSV or as a plot.
void write_influence(const Options& options, const Demo& demo, const Io& io) {
  if (demo.bridges().empty()) throw UsageError("analyze: --influence needs a demo with a bridge");
  const Bridge& bridge = *demo.bridges().front().bridge;
  if (options.member < 1 || options.member > static_cast<int>(bridge.members().size()))
    throw UsageError("analyze: --member expected 1 to " + std::to_string(bridge.members().size()) + ", got " +
                     std::to_string(options.member));
  const Bridge::Line line = bridge.influence_line({Quantity::Kind::Axial, options.member - 1}, 200);
  std::string text;
  if (ends_with(options.influence_csv, ".svg")) {
    const render::Style& style = render::style(options.picture.paint().theme);
    Chart chart;
    chart.x_name = "load at x [m]";
    chart.x_high = bridge.deck_length();
    chart.last_values = false;
    chart.curves = {{"force of member " + std::to_string(options.member) + " per unit of load",
                     style.friction, line.x, line.value}};
    constexpr int kWidthPx = 640, kHeightPx = 320, kMarginPx = 16, kTitlePx = 40;
    render::Sheet sheet;
    sheet.text({kMarginPx, 10}, demo.title(), style.text, 18, render::Face::Bold);
    draw_chart(chart, style, {kMarginPx, kTitlePx}, kWidthPx - 2 * kMarginPx,
               kHeightPx - kTitlePx - kMarginPx, 1, sheet);
    text = render::to_svg(sheet, kWidthPx, kHeightPx, style.background, demo.title());
  } else {
    text = "x [m],force per unit of load\n";
    for (std::size_t i = 0; i < line.x.size(); ++i)
      text += to_text(line.x[i]) + ',' + to_text(line.value[i]) + '\n';
  }
  const Output output{options.influence_csv, std::move(text)};
  write_outputs(io, {&output, 1});
  io.err << options.influence_csv << ": " << format_bytes(output.bytes.size()) << '\n';
}

// The force diagram: line of thrust, stresses, contact forces.
void write_picture(const Options& options, const Demo& demo, const History& history, const Io& io) {
  const bool svg = ends_with(options.output, ".svg");
  std::vector<std::string> names = options.picture.overlays_for(demo);
  const auto want = [&](const char* name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  };
  want(demo.bridges().empty() ? "thrust" : "stresses");
  Painter painter(options.picture.paint());
  painter.start(demo, names);
  painter.select(options.picture.selection_for(demo));
  render::Image image;
  painter.paint(demo, history, image);
  Output output{options.output, {}};
  if (svg) {
    output.bytes = painter.svg(demo.title());
  } else {
    const std::vector<std::uint8_t> bytes = render::encode_png(image);
    output.bytes.assign(bytes.begin(), bytes.end());
  }
  write_outputs(io, {&output, 1});
  io.err << options.output << " written\n";
}

int analyze(const Options& options, const Io& io) {
  options.picture.check();
  if (!options.output.empty() && !ends_with(options.output, ".svg") && !ends_with(options.output, ".png"))
    throw UsageError("-o expected a .svg or .png file, got \"" + options.output + '"');
  const std::string unused = options.output.empty() ? options.picture.needs_picture() : "";
  if (!unused.empty()) throw UsageError("analyze: " + unused + " needs -o FILE");
  check_outputs({{"-o", options.output}, {"--influence", options.influence_csv}});
  const DemoFile file = find_demo(options.shared.demos.front(), options.shared.folder);
  Demo demo(file.path, options.shared.checked(io));
  demo.observe({.contacts = true});
  History history(demo, false, kFlashSeconds);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo& running) { history.update(running); };
  catch_interrupts();
  // At 0 the world is looked at as the script made it, before any step.
  if (options.at > 0) run_loop(demo, {.until = options.at}, callbacks);

  // The next step would begin with it.
  const bool pushed = demo.call_before_step();

  Json json;
  std::ostringstream text;
  json["demo"] = demo.name();
  json["time"] = demo.time();
  analyse_bridges(demo, json, text);
  analyse_bodies(demo, pushed, json, text);
  if (text.str().empty()) text << demo.name() << ": nothing that could move\n";
  stop_if_interrupted("nothing is written");
  if (options.json)
    io.out << json.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  else
    io.out << text.str();
  if (!options.influence_csv.empty()) write_influence(options, demo, io);
  if (!options.output.empty()) write_picture(options, demo, history, io);
  return kGood;
}

}  // namespace

Action setup_analyze(OptionTable& table) {
  auto options = std::make_shared<Options>();
  add_shared_options(table, options->shared, DemoCount::One);
  const std::string group = "Analysis";
  table.add("--at", options->at, "The moment [s] (default 0: as the script made it)")
      .range(0, kLongestRun)
      .group(group);
  table.add_flag("--json", options->json, "Prints everything as JSON").group(group);
  table.add("-o,--out", options->output, "Writes the force diagram, .svg or .png").type("FILE").group(group);
  const OptionRow influence =
      table.add("--influence", options->influence_csv, "Writes a member's influence line, .csv or .svg")
          .type("FILE")
          .group(group);
  table.add("--member", options->member, "Whose influence line, from 1").needs(influence).group(group);
  add_picture_options(table, options->picture);
  return [options](const Io& io) { return analyze(*options, io); };
}

}  // namespace skerry::sandbox
