// SPDX-License-Identifier: MIT
#include "sandbox/demo.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "physics/hash.h"
#include "physics/root.h"
#include "physics/snapshot.h"
#include "sandbox/errors.h"
#include "sandbox/lua_args.h"
#include "sandbox/names.h"
#include "sandbox/script.h"

namespace skerry::sandbox {
namespace {

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) throw ScriptError(path + ": cannot be read");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// Called through lua_pcall, so that running out of memory here is an error like any other.
int add_functions(lua_State* state) {
  add_scene_functions(state);
  add_body_functions(state);
  add_joint_functions(state);
  add_compound_function(state);
  add_sensor_functions(state);
  add_touch_functions(state);
  add_query_functions(state);
  add_force_functions(state);
  add_attraction_function(state);
  add_statics_functions(state);
  add_truss_function(state);
  return 0;
}

void add_totals(const StepReport& report, RunTotals& to) {
  const auto add = [](std::uint64_t& sum, int count) { sum += static_cast<std::uint64_t>(count); };
  add(to.islands_by_events, report.islands_by_events);
  add(to.islands_by_time_stepping, report.islands_by_time_stepping);
  add(to.islands_at_rest, report.islands_at_rest);
  add(to.islands_in_flight, report.islands_in_flight);
  add(to.islands_in_flow, report.islands_in_flow);
  add(to.islands_in_one_piece, report.islands_in_one_piece);
  add(to.substeps, report.substeps);
  add(to.inner_steps, report.inner_steps);
  add(to.rejected_steps, report.rejected_steps);
  add(to.force_solves, report.force_solves);
  add(to.events_found, report.events_found);
  add(to.impacts, report.impacts);
  add(to.fallbacks, report.fallbacks);
  to.error_estimate += report.error_estimate;
}

double measure(LuaHost& host, int function, const std::string& place, const std::string& what) {
  host.call(function, 1);
  lua_State* state = host.state();
  const bool number = lua_type(state, -1) == LUA_TNUMBER;
  const bool yes_no = lua_type(state, -1) == LUA_TBOOLEAN;
  const double value = yes_no ? lua_toboolean(state, -1) : lua_tonumber(state, -1);
  const std::string got = describe(state, -1);
  lua_pop(state, 1);
  if (!number && !yes_no) throw ScriptError(place + ": \"" + what + "\" expected a number, got " + got);
  return value;
}

/// Calls what may name a body that a user has removed: its error does not end the run then, it is noted once.
template <class Function>
void call_forgiving(Script& script, const Function& function) {
  try {
    function();
  } catch (const ScriptError& error) {
    if (!script.body_removed) throw;
    if (!std::exchange(script.told_loss, true)) script.notes.push_back({script.time(), error.what()});
  }
}

/// @param back  how long before the end of the last step [s]
void evaluate(Script& script, std::size_t i, double back = 0) {
  // Vectors may grow while the function runs.
  const Check due = script.checks[i];
  double value = 0;
  try {
    const LookingBack looking(script, back);
    value = measure(script.host, due.function, due.place, due.what);
  } catch (const ScriptError&) {
    if (!script.body_removed) throw;
    script.checks[i].state = CheckState::Unmeasured;
    script.checks[i].time = script.time() - back;
    return;
  }
  Check& check = script.checks[i];
  check.value = value;
  check.time = script.time() - back;
  check.state = check.accepts(value) ? CheckState::Holds : CheckState::Fails;
}

/// The function of event `i` with the bodies as they were `back` [s] before the end of the last step.
double measure_crossing(Script& script, std::size_t i, double back) {
  const Asking asking(script, "on_event");
  const LookingBack looking(script, back);
  return measure(script.host, script.crossings[i].function, script.crossings[i].place, "on_event");
}

/// Whether what was highlighted since the last call is there. The script names bodies before it makes them.
void check_highlight(Script& script) {
  if (script.highlight_place.empty()) return;
  const std::string place = std::exchange(script.highlight_place, {});
  try {
    resolve(script.picture.selection, *script.world, "highlight");
  } catch (const UsageError& error) {
    throw ScriptError(place + ": " + error.what());
  }
}

bool changes_sign(double before, double after) {
  return (before < 0 && after >= 0) || (before > 0 && after <= 0);
}

/// How long before the end of the last step the function of event `i` changed its sign [s].
/// @param before, after  its values at the two ends
double find_crossing(Script& script, std::size_t i, double before, double after) {
  const double dt = script.dt;
  // What does not follow the bodies within the step (forces, sums of the report): by a straight line.
  const double begin = measure_crossing(script, i, dt);
  if (!changes_sign(begin, after)) return dt * after / (after - before);
  const double sign = begin > 0 ? 1 : -1;
  const auto value = [&](double t) { return sign * measure_crossing(script, i, dt - t); };
  return dt - falling_root(value, 0, sign * begin, dt, sign * after);
}

/// The events whose function changed its sign during the last step.
void find_crossings(Script& script, std::vector<Moment>& moments) {
  // Vectors may grow while callbacks run, hence the indices.
  for (std::size_t i = 0; i < script.crossings.size(); ++i) {
    const double value = measure_crossing(script, i, 0);
    if (script.crossings[i].known && changes_sign(script.crossings[i].last, value)) {
      const double back = find_crossing(script, i, script.crossings[i].last, value);
      const auto act = [&script, action = script.crossings[i].action, at = script.time() - back] {
        script.host.call(action, 0, [at](lua_State* state) {
          lua_pushnumber(state, at);
          return 1;
        });
      };
      moments.push_back({back, act});
    }
    script.crossings[i].last = value;
    script.crossings[i].known = true;
  }
}

/// Calls the actions of what happened within the last step, in the order of time, then those of what touches
/// at its end.
void tell_events(Script& script) {
  std::vector<Moment> moments;
  call_forgiving(script, [&] { find_crossings(script, moments); });
  find_blows(script, moments);
  // Before an action removes something.
  const std::vector<TouchCall> touches = find_touches(script);
  std::stable_sort(moments.begin(), moments.end(),
                   [](const Moment& x, const Moment& y) { return x.back > y.back; });
  for (const Moment& moment : moments) {
    call_forgiving(script, [&] {
      const LookingBack looking(script, moment.back);
      moment.call();
    });
  }
  for (const TouchCall& touch : touches) call_forgiving(script, [&] { tell_touch(script, touch); });
  forget_watches(script);
}

void note_velocities(Script& script) {
  const BodyArrays& b = script.world->bodies();
  script.before_step.resize(b.size());
  for (std::size_t i = 0; i < b.size(); ++i)
    script.before_step[i] = {b.generation[i], b.velocity[i], b.omega[i]};
}

void find_accelerations(Script& script) {
  const BodyArrays& b = script.world->bodies();
  script.accelerations = script.before_step;
  for (std::size_t i = 0; i < script.accelerations.size(); ++i) {
    MeanAcceleration& mean = script.accelerations[i];
    mean.linear = (b.velocity[i] - mean.linear) / script.dt;
    mean.angular = (b.omega[i] - mean.angular) / script.dt;
  }
}

}  // namespace

std::string Parameter::text() const {
  return choices.empty() ? format_number(value) : choices[static_cast<std::size_t>(value)];
}

bool Check::accepts(double measured) const {
  // Written so that NaN is refused by each of them.
  if (below && !(measured < *below)) return false;
  if (above && !(measured > *above)) return false;
  if (equals && !(std::abs(measured - *equals) <= within)) return false;
  return true;
}

std::string Check::condition() const {
  std::vector<std::string> parts;
  if (equals) parts.push_back(format_number(*equals) + " +- " + format_number(within));
  if (above) parts.push_back("above " + format_number(*above));
  if (below) parts.push_back("below " + format_number(*below));
  return join(parts, " and ") + (unit.empty() ? "" : " " + unit);
}

std::uint64_t text_hash(std::string_view text) {
  Fnv1a hash;
  for (const char c : text) hash.add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
  return hash.value();
}

void BodyColors::set(BodyId body, int color) {
  if (given_.size() <= body.index) given_.resize(body.index + 1, {{}, -1});
  given_[body.index] = {body, color};
}

int BodyColors::of(BodyId body) const {
  return body.index < given_.size() && given_[body.index].body == body ? given_[body.index].color : -1;
}

const std::vector<std::string>& color_names() {
  // In the order of render::Style::bodies.
  static const std::vector<std::string> names{"sky",  "orange", "green", "vermilion",
                                              "pink", "yellow", "blue",  "grey"};
  return names;
}

Demo::Demo(const std::string& path, const DemoOptions& options)
    : script_(std::make_unique<Script>(path, options)) {
  Script& script = *script_;
  script.name = std::filesystem::path(path).stem().string();
  const std::string source = read_text(path);
  script.hash = text_hash(source);
  lua_State* state = script.host.state();
  lua_pushcfunction(state, &add_functions);
  if (lua_pcall(state, 0, 0, 0) != LUA_OK) throw ScriptError(path + ": no memory for the script functions");
  try {
    script.host.run(source);
  } catch (const ScriptError&) {
    if (!script.usage_error.empty()) throw UsageError(script.usage_error);
    throw;
  }
  if (!script.world) throw ScriptError(path + ": the script does not call demo{ title = ... }");

  std::vector<std::string> names;
  for (const Parameter& parameter : script.parameters) names.push_back(parameter.name);
  for (const auto& [name, value] : options.parameters)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UsageError("--set: " + script.name + " has no parameter \"" + name + '"' +
                       (names.empty() ? std::string() : suggestion(name, names)));
  script.full_seconds = script.seconds;
  if (options.seconds) script.seconds = *options.seconds;
  if (options.steps) script.seconds = static_cast<double>(*options.steps) * script.dt;
  if (!(script.seconds / script.dt <= static_cast<double>(kMostSteps)))
    throw UsageError(script.name + ": " + format_number(script.seconds) + " s in steps of " +
                     format_number(script.dt) + " s; at most " + std::to_string(kMostSteps) + " steps");
  check_highlight(script);
}

Demo::~Demo() = default;
Demo::Demo(Demo&&) noexcept = default;

const std::string& Demo::name() const {
  return script_->name;
}
const std::string& Demo::path() const {
  return script_->path;
}
std::uint64_t Demo::script_hash() const {
  return script_->hash;
}
const std::string& Demo::title() const {
  return script_->title;
}
const std::string& Demo::lesson() const {
  return script_->lesson;
}
double Demo::seconds() const {
  return script_->seconds;
}
double Demo::dt() const {
  return script_->dt;
}
const Picture& Demo::picture() const {
  return script_->picture;
}
const std::vector<Parameter>& Demo::parameters() const {
  return script_->parameters;
}
const std::vector<Check>& Demo::checks() const {
  return script_->checks;
}
const std::vector<Watch>& Demo::watches() const {
  return script_->watches;
}
const std::vector<Note>& Demo::notes() const {
  return script_->notes;
}
const World& Demo::world() const {
  return *script_->world;
}
const RunTotals& Demo::totals() const {
  return script_->totals;
}
const std::vector<BridgeView>& Demo::bridges() const {
  return script_->bridges;
}
std::uint64_t Demo::steps_done() const {
  return script_->steps;
}
std::uint64_t steps_until(double time, double dt) {
  return static_cast<std::uint64_t>(std::ceil(std::max(time, 0.0) / dt - 1e-6));
}

double Demo::time() const {
  return script_->time();
}

std::uint64_t Demo::total_steps() const {
  // A step may be longer than the whole run.
  return std::max<std::uint64_t>(1, steps_until(script_->seconds, script_->dt));
}

void Demo::keep_paths() {
  script_->needed.paths = true;
  script_->observe();
}

void Demo::show_at(double time) {
  script_->shown_time = time;
}

double Demo::shown_time() const {
  return script_->shown_time.value_or(time());
}

BodyState Demo::shown(std::size_t slot) const {
  return state_at(slot, shown_time());
}

bool Demo::knows_paths() const {
  return script_->needed.paths || script_->wanted.paths;
}

BodyState Demo::state_at(std::size_t slot, double at) const {
  const World& world = *script_->world;
  const BodyArrays& b = world.bodies();
  const double back = time() - at;
  // The world counts its time in sums, the demo in products. The report may name bodies that a user has
  // removed since.
  if (knows_paths() && back > 1e-6 * dt() && b.alive[slot])
    return world.interpolated(world.body_id(slot), world.time() - back);
  return {b.position[slot], b.angle[slot], b.velocity[slot], b.omega[slot]};
}

void Demo::observe(Observe what) {
  script_->wanted = what;
  script_->observe();
}

bool Demo::call_before_step() {
  Script& script = *script_;
  const double time = script.time();
  // Vectors may grow while callbacks run, hence the indices.
  for (std::size_t i = 0; i < script.step_callbacks.size(); ++i)
    call_forgiving(script, [&] {
      script.host.call(script.step_callbacks[i], 0, [&](lua_State* state) {
        lua_pushnumber(state, time);
        lua_pushnumber(state, script.dt);
        return 2;
      });
    });
  const bool attracted = apply_attractions(script);
  return attracted || !script.step_callbacks.empty();
}

void Demo::step() {
  Script& script = *script_;
  const double time = script.time();
  const double half = 0.5 * script.dt;
  // Vectors may grow while callbacks run, hence the indices.
  for (std::size_t i = 0; i < script.appointments.size(); ++i) {
    if (script.appointments[i].done || script.appointments[i].time > time + half) continue;
    script.appointments[i].done = true;
    call_forgiving(script, [&] { script.host.call(script.appointments[i].function, 0); });
  }
  call_before_step();
  call_forgiving(script, [&] { check_highlight(script); });
  // From here on they are looked for.
  for (std::size_t i = 0; i < script.crossings.size(); ++i) {
    if (script.crossings[i].known) continue;
    call_forgiving(script, [&] {
      script.crossings[i].last = measure_crossing(script, i, 0);
      script.crossings[i].known = true;
    });
  }
  script.shown_time.reset();
  note_velocities(script);
  const bool paths = script.needed.paths || script.wanted.paths;
  add_totals(script.world->step(script.dt), script.totals);
  find_accelerations(script);
  ++script.steps;
  advance_bridges(script);
  tell_events(script);
  call_forgiving(script, [&] { check_highlight(script); });

  for (std::size_t i = 0; i < script.checks.size(); ++i) {
    const Check& due = script.checks[i];
    const bool open = due.state != CheckState::Fails && due.state != CheckState::Unmeasured;
    if (due.always && open) {
      evaluate(script, i);
    } else if (due.at && due.state == CheckState::Waiting && script.steps >= script.step_with(*due.at)) {
      // What was asked for later than that moment is measured now.
      const bool within = paths && script.steps == script.step_with(*due.at);
      evaluate(script, i, within ? script.before_step_end(*due.at) : 0);
    }
  }
}

void Demo::finish() {
  Script& script = *script_;
  // The numbers of the end belong to the whole demo; a run that was cut short does not reach them.
  if (script.time() + 1e-6 * script.dt < script.full_seconds) return;
  for (std::size_t i = 0; i < script.checks.size(); ++i) {
    const Check& check = script.checks[i];
    if (!check.at && !check.always && check.state == CheckState::Waiting) evaluate(script, i);
  }
}

bool Demo::failed() const {
  const auto fails = [](const Check& check) { return check.state == CheckState::Fails; };
  return std::any_of(script_->checks.begin(), script_->checks.end(), fails) || world().report().contained > 0;
}

namespace {

std::vector<BridgeView> copies_of(const std::vector<BridgeView>& views) {
  std::vector<BridgeView> copies;
  copies.reserve(views.size());
  for (const BridgeView& view : views)
    copies.push_back({std::make_unique<statics::Bridge>(*view.bridge), view.numbers, view.influence});
  return copies;
}

/// Whether the command line says how to solve.
bool given_methods(const DemoOptions& options) {
  return options.solver || options.broad_phase || options.impact_law || options.stepper || options.accuracy ||
         options.budget || options.flow_work || options.sleep_speed;
}

/// Whether there are the same bodies with the same shapes, wherever they are.
bool are_same_bodies(const World& x, const World& y) {
  const BodyArrays &a = x.bodies(), &b = y.bodies();
  const auto same = [](const ShapeRecord& one, const ShapeRecord& other) {
    if (!one.alive || !other.alive) return one.alive == other.alive;
    return one.body == other.body && one.shape->kind == other.shape->kind &&
           one.shape->radius == other.shape->radius && one.shape->vertices == other.shape->vertices;
  };
  return a.alive == b.alive && a.type == b.type && a.mass == b.mass && a.inertia == b.inertia &&
         std::equal(x.shapes().begin(), x.shapes().end(), y.shapes().begin(), y.shapes().end(), same);
}

}  // namespace

/// What DemoState hides.
struct DemoMoment {
  const Script* script = nullptr;
  std::vector<std::byte> world;
  WorldCallbacks callbacks;
  LuaImage lua;
  ScriptProgress progress;
  std::vector<BridgeView> bridges;
};

std::uint64_t DemoState::step() const {
  return moment_->progress.steps;
}

std::size_t DemoState::bytes() const {
  return sizeof(DemoMoment) + moment_->world.size() + moment_->lua.arena.bytes.size() +
         moment_->progress.accelerations.size() * sizeof(MeanAcceleration);
}

DemoState Demo::save() const {
  const Script& script = *script_;
  DemoState state;
  state.moment_ = std::make_shared<const DemoMoment>(DemoMoment{&script, save_snapshot(*script.world),
                                                                script.world->callbacks(), script.host.save(),
                                                                script, copies_of(script.bridges)});
  return state;
}

void Demo::restore(const DemoState& state) {
  if (!state.moment_ || state.moment_->script != script_.get())
    throw std::invalid_argument("restore: the state is not of this demo");
  const DemoMoment& moment = *state.moment_;
  World world = load_snapshot(moment.world);
  // Its functions are those of then: they may have been changed since.
  world.adopt(moment.callbacks);
  *script_->world = std::move(world);
  script_->bridges = copies_of(moment.bridges);
  script_->host.restore(moment.lua);
  static_cast<ScriptProgress&>(*script_) = moment.progress;
  script_->shown_time.reset();
  // What overlays want to see is the viewer's business, not the past's.
  script_->observe();
}

World& Demo::world_for_input() {
  return *script_->world;
}

void Demo::adopt(World world) {
  Script& script = *script_;
  world.adopt(script.world->callbacks());
  if (!are_same_bodies(world, *script.world))
    throw std::invalid_argument("the snapshot has other bodies than " + script.name +
                                " (other script, or other values of --set)");
  const std::uint64_t steps = world.report().step;
  const double time = static_cast<double>(steps) * script.dt;
  if (std::abs(world.time() - time) > 1e-6 * std::max(time, world.time()))
    throw std::invalid_argument("the snapshot is of " + format_number(world.time()) + " s after " +
                                std::to_string(steps) + " steps, and " + script.name + " has steps of " +
                                format_number(script.dt) + " s; give the --dt that it was saved with");
  WorldConfig config = world.config();
  take_options(script.options, config);
  if (given_methods(script.options)) world.reconfigure(config);
  *script.world = std::move(world);
  script.steps = steps;
  script.accelerations.clear();
  std::erase_if(script.checks, [&](const Check& check) { return check.at && *check.at <= script.time(); });
  script.observe();
}

void Demo::body_was_removed() {
  script_->body_removed = true;
}

const Material& Demo::material() const {
  return script_->material;
}

bool Demo::has_callbacks() const {
  const Script& script = *script_;
  return !script.step_callbacks.empty() || !script.appointments.empty() || !script.crossings.empty() ||
         !script.touches.empty() || !script.blows.empty() || !script.bridges.empty();
}

std::vector<double> Demo::watch_values() {
  std::vector<double> values;
  const Asking asking(*script_, "watch");
  for (const Watch& watch : script_->watches)
    values.push_back(measure(script_->host, watch.function, script_->path, watch.what));
  return values;
}

}  // namespace skerry::sandbox
