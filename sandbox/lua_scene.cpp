// SPDX-License-Identifier: MIT
//
// Script functions that describe the demo: demo, param, choice, show, expect, watch, note, at, on_step.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "sandbox/lua_args.h"
#include "sandbox/names.h"
#include "sandbox/overlays/overlay.h"
#include "sandbox/script.h"
#include "sandbox/traces.h"

namespace skerry::sandbox {
namespace {

constexpr double kBudgetUnit = 1e6;  // of `SolveWork::visits`

/// view = { x = 0, y = 2, height = 6 }
View read_view(lua_State* L, const Args& demo) {
  lua_getfield(L, demo.index(), "view");
  const Args args(L, "demo: view", {"x", "y", "height", "width"}, lua_gettop(L));
  const View view{{args.number("x", 0), args.number("y", 0)},
                  args.required_number("height"),
                  args.number_from("width", 0).value_or(0)};
  lua_pop(L, 1);
  if (view.height <= 0)
    throw std::invalid_argument("demo: view.height must be positive, got " + format_number(view.height));
  return view;
}

int demo(lua_State* L) {
  Script& script = script_of(L);
  const Args args(
      L, "demo",
      {"title", "lesson", "seconds", "dt", "view", "gravity", "friction", "restitution", "rolling_resistance",
       "solver", "broad_phase", "impact_law", "stepper", "accuracy", "budget", "flow_work", "sleep_speed"});
  if (script.world) throw std::invalid_argument("demo: called a second time");
  script.title = args.text("title").value_or("");
  if (script.title.empty()) throw std::invalid_argument("demo: title expected a string, got nothing");
  script.lesson = args.text("lesson").value_or("");
  script.seconds = args.number("seconds", script.seconds);
  if (script.seconds < kShortestStep || script.seconds > kLongestRun)
    throw std::invalid_argument("demo: seconds expected a number from " + format_number(kShortestStep) +
                                " to " + format_number(kLongestRun) + ", got " +
                                format_number(script.seconds));
  script.dt = args.number("dt", script.dt);
  if (script.dt < kShortestStep || script.dt > kLongestStep)
    throw std::invalid_argument("demo: dt expected a number from " + format_number(kShortestStep) + " to " +
                                format_number(kLongestStep) + ", got " + format_number(script.dt));
  if (args.has("view")) script.picture.view = read_view(L, args);
  script.material.friction = args.number_from("friction", 0).value_or(script.material.friction);
  script.material.restitution = args.number_from("restitution", 0).value_or(script.material.restitution);
  script.material.rolling_resistance = args.number_from("rolling_resistance", 0).value_or(0);

  const DemoOptions& given = script.options;
  if (given.dt) script.dt = *given.dt;
  WorldConfig config;
  config.gravity = args.pair("gravity").value_or(config.gravity);
  config.threads = given.threads;
  config.solver = args.text("solver").value_or(config.solver);
  config.broad_phase = args.text("broad_phase").value_or(config.broad_phase);
  config.impact_law = args.text("impact_law").value_or(config.impact_law);
  config.stepper = args.text("stepper").value_or(config.stepper);
  config.accuracy = args.number("accuracy");
  if (const auto budget = args.number_from("budget", 0)) config.solve.work_limit = kBudgetUnit * *budget;
  if (const auto work = args.number_from("flow_work", 0)) config.flow_work = *work;
  config.sleep_speed = args.number_from("sleep_speed", 0).value_or(config.sleep_speed);
  take_options(given, config);
  script.world.emplace(config);
  return 0;
}

Parameter& add_parameter(lua_State* L, const char* function) {
  Script& script = script_of(L);
  Parameter parameter;
  parameter.name = text_argument(L, 1, function, "name");
  const auto same = [&](const Parameter& other) { return other.name == parameter.name; };
  if (std::any_of(script.parameters.begin(), script.parameters.end(), same))
    throw std::invalid_argument(std::string(function) + ": a second parameter \"" + parameter.name + '"');
  return script.parameters.emplace_back(std::move(parameter));
}

// A wrong value on the command line is not the script's fault: `Demo` reports it as a usage error.
[[noreturn]] void refuse_value(Script& script, const std::string& message) {
  script.usage_error = message;
  throw std::invalid_argument(message);
}

const std::string* given_value(const Script& script, const std::string& name) {
  const std::string* value = nullptr;
  for (const auto& [key, text] : script.options.parameters)
    if (key == name) value = &text;
  return value;
}

// param(name, standard, low, high [, unit]) -> number
int param(lua_State* L) {
  Script& script = script_of(L);
  Parameter& parameter = add_parameter(L, "param");
  parameter.standard = number_argument(L, 2, "param", "default");
  parameter.low = number_argument(L, 3, "param", "minimum");
  parameter.high = number_argument(L, 4, "param", "maximum");
  if (!lua_isnoneornil(L, 5)) parameter.unit = text_argument(L, 5, "param", "unit");
  if (!(parameter.low <= parameter.standard && parameter.standard <= parameter.high))
    throw std::invalid_argument("param: default " + format_number(parameter.standard) +
                                " is not between minimum " + format_number(parameter.low) + " and maximum " +
                                format_number(parameter.high));
  parameter.value = parameter.standard;
  if (const std::string* text = given_value(script, parameter.name)) {
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), parameter.value);
    const bool number = error == std::errc() && end == text->data() + text->size();
    if (!number || !(parameter.low <= parameter.value && parameter.value <= parameter.high))
      refuse_value(script, "--set \"" + parameter.name + "=" + *text + "\": expected a number from " +
                               format_number(parameter.low) + " to " + format_number(parameter.high) +
                               (parameter.unit.empty() ? "" : " " + parameter.unit));
  }
  // A whole number by default is one to count with: `for i = 1, count` prints and indexes as expected.
  lua_Integer whole = 0;
  if (lua_isinteger(L, 2) && lua_numbertointeger(parameter.value, &whole) &&
      static_cast<double>(whole) == parameter.value)
    lua_pushinteger(L, whole);
  else
    lua_pushnumber(L, parameter.value);
  return 1;
}

// choice(name, {first, second, ...}) -> string; the first is the default
int choice(lua_State* L) {
  Script& script = script_of(L);
  Parameter& parameter = add_parameter(L, "choice");
  if (lua_type(L, 2) != LUA_TTABLE || lua_rawlen(L, 2) < 2)
    throw std::invalid_argument("choice: expected a list of at least two strings, got " + describe(L, 2));
  for (lua_Unsigned i = 1; i <= lua_rawlen(L, 2); ++i) {
    lua_rawgeti(L, 2, static_cast<lua_Integer>(i));
    parameter.choices.push_back(text_argument(L, -1, "choice", "word"));
    lua_pop(L, 1);
  }
  parameter.high = static_cast<double>(parameter.choices.size() - 1);
  if (const std::string* text = given_value(script, parameter.name)) {
    const auto found = std::find(parameter.choices.begin(), parameter.choices.end(), *text);
    if (found == parameter.choices.end())
      refuse_value(script, "--set \"" + parameter.name + "=" + *text + "\": no such choice" +
                               suggestion(*text, parameter.choices));
    parameter.value = static_cast<double>(found - parameter.choices.begin());
  }
  lua_pushstring(L, parameter.choices[static_cast<std::size_t>(parameter.value)].c_str());
  return 1;
}

/// ball, { ball, wheel } or { { wheel, {0.5, 0} } }: bodies, or points in their frames.
std::vector<TracedPoint> traced_points(lua_State* L, const Args& args) {
  constexpr const char* kForm = "a list of bodies or {body, {x, y}}";
  std::vector<TracedPoint> points;
  const int type = lua_getfield(L, args.index(), "trace");
  const int list = lua_gettop(L);
  if (const std::optional<BodyId> single = to_body(L, list)) {
    points.push_back({*single, {}});
  } else if (type != LUA_TNIL) {
    if (type != LUA_TTABLE) args.fail("trace", kForm, list);
    for (lua_Unsigned i = 1; i <= lua_rawlen(L, list); ++i) {
      lua_rawgeti(L, list, static_cast<lua_Integer>(i));
      const int entry = lua_gettop(L);
      TracedPoint point;
      if (const std::optional<BodyId> body = to_body(L, entry)) {
        point.body = *body;
      } else {
        if (lua_type(L, entry) != LUA_TTABLE) args.fail("trace", kForm, entry);
        lua_rawgeti(L, entry, 1);
        lua_rawgeti(L, entry, 2);
        const std::optional<BodyId> whose = to_body(L, -2);
        const std::optional<Vec2> local = to_pair(L, -1);
        if (!whose || !local) args.fail("trace", kForm, list);
        point = {*whose, *local};
      }
      points.push_back(point);
      lua_settop(L, list);
    }
    if (points.empty()) throw std::invalid_argument("show: trace names no body");
  }
  if (points.size() > kMostTraces)
    throw std::invalid_argument("show: trace expected at most " + std::to_string(kMostTraces) +
                                " bodies, got " + std::to_string(points.size()));
  lua_settop(L, list - 1);
  return points;
}

// show{ "contacts", "matrix", impulse_scale = 2 }
int show(lua_State* L) {
  Script& script = script_of(L);
  if (lua_type(L, 1) != LUA_TTABLE)
    throw std::invalid_argument("show: expected a list as in show{ \"contacts\" }, got " + describe(L, 1));
  // Split the list from the named arguments so that both are checked.
  lua_newtable(L);
  const int named = lua_gettop(L);
  for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1)) {
    if (lua_type(L, -2) == LUA_TNUMBER) continue;
    lua_pushvalue(L, -2);
    lua_pushvalue(L, -2);
    lua_rawset(L, named);
  }
  const Args args(L, "show", {"impulse_scale", "force_scale", "trace", "strobe"}, named);
  for (const char* key : {"impulse_scale", "force_scale"}) {
    const std::optional<double> scale = args.number(key);
    if (!scale) continue;
    if (*scale <= 0)
      throw std::invalid_argument(std::string("show: ") + key + " must be positive, got " +
                                  format_number(*scale));
    (key[0] == 'i' ? script.picture.impulse_scale : script.picture.force_scale) = scale;
  }
  if (args.has("trace")) script.picture.traced = traced_points(L, args);
  if (const std::optional<double> strobe = args.number("strobe")) {
    // Shorter ones would not be told apart.
    if (*strobe < 1e-3 * script.seconds)
      throw std::invalid_argument("show: strobe must be at least a thousandth of the demo's " +
                                  format_number(script.seconds) + " s, got " + format_number(*strobe));
    script.picture.strobe = *strobe;
  }
  for (lua_Unsigned i = 1; i <= lua_rawlen(L, 1); ++i) {
    lua_rawgeti(L, 1, static_cast<lua_Integer>(i));
    const std::string name = text_argument(L, -1, "show", "overlay");
    lua_pop(L, 1);
    const std::vector<std::string> known = overlay_names();
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw std::invalid_argument("show: no overlay \"" + name + '"' + suggestion(name, known));
    script.picture.overlays.push_back(name);
  }
  return 0;
}

// highlight{ row = 3, col = 5, body = plank, other = "A", island = 1 }
int highlight(lua_State* L) {
  Script& script = script_with_world(L, "highlight");
  const Args args(L, "highlight", {"row", "col", "body", "other", "island"});
  SelectionText selection;
  const auto whole = [&](const char* key) -> std::optional<int> {
    const std::optional<double> value = args.number_from(key, 1);
    if (value && (*value > 1e6 || *value != std::floor(*value)))
      throw std::invalid_argument(std::string("highlight: ") + key + " expected a whole number from 1, got " +
                                  format_number(*value));
    return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
  };
  const auto body = [&](const char* key) -> SelectedBody {
    const int type = lua_getfield(L, args.index(), key);
    lua_pop(L, 1);
    if (type == LUA_TSTRING) return {args.text(key).value_or(""), {}};
    return {{}, args.body(key).value_or(BodyId{})};
  };
  selection.row = whole("row");
  selection.column = whole("col");
  selection.island = whole("island");
  selection.body = body("body");
  selection.other = body("other");
  if (selection.column && !selection.row) throw std::invalid_argument("highlight: col needs row");
  if (!selection.other.empty() && selection.body.empty())
    throw std::invalid_argument("highlight: other needs body");
  script.picture.selection = selection;
  script.highlight_place = script_place(L);
  return 0;
}

// expect(what, function, { at = 4, below = 1e-6, unit = "m" })
int expect(lua_State* L) {
  Script& script = script_with_world(L, "expect");
  Check check;
  check.what = text_argument(L, 1, "expect", "what");
  check.place = script_place(L);
  const Args args(L, "expect", {"at", "always", "below", "above", "equals", "within", "unit"}, 3);
  check.at = args.number_from("at", 0);
  check.always = args.flag("always").value_or(false);
  check.below = args.number("below");
  check.above = args.number("above");
  check.equals = args.number("equals");
  check.within = args.number_from("within", 0).value_or(0);
  check.unit = args.text("unit").value_or("");
  if (!check.below && !check.above && !check.equals)
    throw std::invalid_argument("expect: one of below, above, equals is needed for \"" + check.what + '"');
  if (check.equals && !args.has("within"))
    throw std::invalid_argument("expect: equals needs within = tolerance for \"" + check.what + '"');
  if (check.at && check.always)
    throw std::invalid_argument("expect: at and always exclude each other for \"" + check.what + '"');
  if (check.at && *check.at > script.seconds + 1e-9)
    throw std::invalid_argument("expect: at = " + format_number(*check.at) + " s is after the end, " +
                                format_number(script.seconds) + " s");
  check.function = function_argument(L, 2, "expect", "measure");
  if (check.at && script.before_step_end(*check.at) > 0) {
    script.needed.paths = true;
    script.observe();
  }
  script.checks.push_back(std::move(check));
  return 0;
}

// watch(what, function [, unit])
int watch(lua_State* L) {
  Script& script = script_with_world(L, "watch");
  Watch column;
  column.what = text_argument(L, 1, "watch", "what");
  if (!lua_isnoneornil(L, 3)) column.unit = text_argument(L, 3, "watch", "unit");
  column.function = function_argument(L, 2, "watch", "measure");
  script.watches.push_back(std::move(column));
  return 0;
}

int note(lua_State* L) {
  Script& script = script_of(L);
  script.notes.push_back({script.time(), text_argument(L, 1, "note", "text")});
  return 0;
}

int at(lua_State* L) {
  Script& script = script_with_world(L, "at");
  const double time = number_argument(L, 1, "at", "time");
  if (time < 0) throw std::invalid_argument("at: time must be at least 0, got " + format_number(time));
  script.appointments.push_back({time, function_argument(L, 2, "at", "action")});
  return 0;
}

int on_step(lua_State* L) {
  Script& script = script_with_world(L, "on_step");
  script.step_callbacks.push_back(function_argument(L, 1, "on_step", "action"));
  return 0;
}

}  // namespace

Script& script_of(lua_State* state) {
  return *static_cast<Script*>(LuaHost::of(state).context());
}

Script& script_with_world(lua_State* state, const char* function) {
  Script& script = script_of(state);
  if (!script.world) throw std::invalid_argument(std::string(function) + ": call demo{ title = ... } first");
  return script;
}

Script& script_to_act(lua_State* state, const char* function) {
  Script& script = script_with_world(state, function);
  if (script.asked)
    throw std::invalid_argument(std::string(function) + ": the function of " + script.asked +
                                " is asked for an answer, it must not change the world");
  return script;
}

Script& script_to_change(lua_State* state, const char* function) {
  Script& script = script_to_act(state, function);
  script.look_back.reset();
  return script;
}

void take_options(const DemoOptions& given, WorldConfig& config) {
  config.solver = given.solver.value_or(config.solver);
  config.broad_phase = given.broad_phase.value_or(config.broad_phase);
  config.impact_law = given.impact_law.value_or(config.impact_law);
  config.stepper = given.stepper.value_or(config.stepper);
  if (given.accuracy) config.accuracy = given.accuracy;
  if (given.budget) config.solve.work_limit = kBudgetUnit * *given.budget;
  if (given.flow_work) config.flow_work = given.flow_work;
  config.sleep_speed = given.sleep_speed.value_or(config.sleep_speed);
}

void add_scene_functions(lua_State* state) {
  const luaL_Reg functions[] = {{"demo", guarded<demo>},       {"param", guarded<param>},
                                {"choice", guarded<choice>},   {"show", guarded<show>},
                                {"expect", guarded<expect>},   {"watch", guarded<watch>},
                                {"note", guarded<note>},       {"at", guarded<at>},
                                {"on_step", guarded<on_step>}, {"highlight", guarded<highlight>}};
  for (const luaL_Reg& entry : functions) lua_register(state, entry.name, entry.func);
}

}  // namespace skerry::sandbox
