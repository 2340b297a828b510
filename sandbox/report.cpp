// SPDX-License-Identifier: MIT
#include "sandbox/report.h"

#include <cinttypes>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

#include "physics/text.h"
#include "sandbox/lua_args.h"

namespace skerry::sandbox {
namespace {

using Json = nlohmann::ordered_json;

Json pair(Vec2 v) {
  return Json::array({v.x, v.y});
}

Json bodies_of(const World& world) {
  Json list = Json::array();
  const BodyArrays& bodies = world.bodies();
  static constexpr const char* kTypes[] = {"static", "kinematic", "dynamic"};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies.alive[i]) continue;
    Json body;
    body["name"] = std::string(world.name(world.body_id(i)));
    body["type"] = kTypes[static_cast<std::size_t>(bodies.type[i])];
    body["mass"] = bodies.mass[i];
    body["inertia"] = bodies.inertia[i];
    body["position"] = pair(bodies.position[i]);
    body["angle"] = bodies.angle[i];
    body["velocity"] = pair(bodies.velocity[i]);
    body["omega"] = bodies.omega[i];
    list.push_back(std::move(body));
  }
  return list;
}

Json checks_of(const Demo& demo) {
  Json list = Json::array();
  for (const Check& check : demo.checks()) {
    Json entry;
    entry["what"] = check.what;
    entry["condition"] = check.condition();
    entry["unit"] = check.unit;
    entry["place"] = check.place;
    entry["state"] = state_word(check.state);
    if (check.state != CheckState::Waiting) {
      entry["value"] = check.value;
      entry["time"] = check.time;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

void append(std::string& text, double value) {
  text += ',';
  text += to_text(value);
}

// A field of a CSV line, quoted where it must be (RFC 4180).
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace

std::string hex(std::uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, "%016" PRIx64, value);
  return text;
}

std::string state_word(CheckState state) {
  switch (state) {
    case CheckState::Holds:
      return "ok";
    case CheckState::Fails:
      return "FAIL";
    case CheckState::Unmeasured:
      return "not measured";
    default:
      return "not reached";
  }
}

void print_checks(std::ostream& out, const Demo& demo) {
  int holding = 0;
  for (const Check& check : demo.checks()) {
    holding += check.state == CheckState::Holds;
    out << "  " << state_word(check.state) << "  " << check.what;
    if (check.state != CheckState::Waiting) out << ": " << format_number(check.value);
    out << " (expected " << check.condition();
    if (check.state == CheckState::Fails)
      out << ", at " << format_number(check.time) << " s, " << check.place;
    out << ")\n";
  }
  const StepReport& report = demo.world().report();
  out << demo.name() << ": " << holding << " of " << demo.checks().size() << " checks hold, "
      << demo.steps_done() << " steps, " << format_number(demo.time()) << " s, state "
      << hex(demo.world().state_hash());
  if (report.contained > 0) out << ", " << report.contained << " bodies stopped: state not finite";
  out << '\n';
}

std::string json_report(const Demo& demo, const std::string& command_line) {
  const World& world = demo.world();
  const StepReport& report = world.report();
  Json json;
  json["skerry"] = SKERRY_VERSION;
  json["command"] = command_line;
  json["demo"] = demo.name();
  json["file"] = demo.path();
  json["title"] = demo.title();
  json["lesson"] = demo.lesson();
  const WorldConfig& config = world.config();
  json["config"] = {{"dt", demo.dt()},
                    {"solver", config.solver},
                    {"broad_phase", config.broad_phase},
                    {"impact_law", config.impact_law},
                    {"stepper", config.stepper},
                    {"budget", config.solve.work_limit / 1e6},
                    {"flow_work", config.flow_work ? Json(*config.flow_work) : Json(nullptr)},
                    {"sleep_speed", config.sleep_speed},
                    {"accuracy", config.accuracy ? Json(*config.accuracy) : Json(nullptr)},
                    {"gravity", pair(config.gravity)}};
  Json parameters = Json::object();
  for (const Parameter& parameter : demo.parameters()) {
    if (parameter.choices.empty())
      parameters[parameter.name] = parameter.value;
    else
      parameters[parameter.name] = parameter.text();
  }
  json["parameters"] = std::move(parameters);
  json["steps"] = demo.steps_done();
  json["time"] = demo.time();
  json["passed"] = !demo.failed();
  json["checks"] = checks_of(demo);
  json["kinetic_energy"] = world.kinetic_energy();
  json["potential_energy"] = world.potential_energy();
  json["momentum"] = pair(world.momentum());
  json["angular_momentum"] = world.angular_momentum();
  json["accuracy"] = {{"worst_residual", report.worst_residual},
                      {"inexact_islands", report.inexact_islands},
                      {"solver_visits", report.work.visits},
                      {"worst_penetration", report.worst_penetration},
                      {"contained", report.contained}};
  const BroadPhaseChoice& pairs_by = report.broad_phase;
  json["broad_phase"] = {
      {"name", pairs_by.name}, {"reason", reason_of(pairs_by)}, {"switches", pairs_by.switches}};
  json["counts"] = {{"bodies", report.bodies},
                    {"pairs", report.pairs},
                    {"contact_points", report.contact_points},
                    {"islands", report.islands},
                    {"rows", report.rows}};
  const RunTotals& totals = demo.totals();
  json["stepping"] = {{"islands_by_events", totals.islands_by_events},
                      {"islands_by_time_stepping", totals.islands_by_time_stepping},
                      {"islands_at_rest", totals.islands_at_rest},
                      {"islands_in_flight", totals.islands_in_flight},
                      {"islands_in_flow", totals.islands_in_flow},
                      {"islands_in_one_piece", totals.islands_in_one_piece},
                      {"substeps", totals.substeps},
                      {"inner_steps", totals.inner_steps},
                      {"rejected_steps", totals.rejected_steps},
                      {"force_solves", totals.force_solves},
                      {"events", totals.events_found},
                      {"impacts", totals.impacts},
                      {"fallbacks", totals.fallbacks},
                      {"error_estimate", totals.error_estimate}};
  json["state_hash"] = hex(world.state_hash());
  json["bodies"] = bodies_of(world);
  // Script texts may hold any bytes; invalid UTF-8 is replaced rather than refused.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

Series::Series(const Demo& demo) {
  text_ =
      "time [s],kinetic energy [J],potential energy [J],momentum x [kg m/s],momentum y [kg m/s],"
      "angular momentum [kg m^2/s],contact points,islands,impacts,worst residual,worst penetration [m]";
  for (const Watch& watch : demo.watches())
    text_ += ',' + csv_field(watch.unit.empty() ? watch.what : watch.what + " [" + watch.unit + ']');
  text_ += '\n';
}

void Series::add(Demo& demo) {
  const StepReport& report = demo.world().report();
  text_ += to_text(demo.time());
  for (const double value : {report.kinetic_energy, report.potential_energy, report.momentum.x,
                             report.momentum.y, report.angular_momentum})
    append(text_, value);
  for (const int value : {report.contact_points, report.islands, report.impacts})
    text_ += ',' + std::to_string(value);
  append(text_, report.worst_residual);
  append(text_, report.worst_penetration);
  for (const double value : demo.watch_values()) append(text_, value);
  text_ += '\n';
}

}  // namespace skerry::sandbox
