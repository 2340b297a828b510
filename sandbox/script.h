// SPDX-License-Identifier: MIT
//
// What the script functions build: the state behind a `Demo`. Included by demo.cpp and the lua_*.cpp files
// only.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/pair_forces.h"
#include "sandbox/bridge_view.h"
#include "sandbox/demo.h"
#include "sandbox/lua_host.h"

namespace skerry::sandbox {

/// A callback at a moment.
struct Appointment {
  double time = 0;
  int function = 0;
  bool done = false;
};

/// A function of the state whose change of sign is an event.
struct Crossing {
  int function = 0, action = 0;
  std::string place;
  double last = 0;     ///< value at the end of the last step
  bool known = false;  ///< there was one since the function was given
};

/// Functions that are called when a body begins to touch others, and when it ends.
struct TouchWatch {
  BodyId first, second;  ///< second none: whatever it touches
  int began = 0, ended = 0;
  bool known = false;            ///< a step was looked at
  std::vector<BodyId> touching;  ///< whose beginning was told, ascending
};

/// A function that is called when a body is struck.
struct BlowWatch {
  BodyId first, second;  ///< second none: by whatever strikes it
  int action = 0;
  double least = 0;  ///< slower ones are not told [m/s]
};

/// A call of a function of `TouchWatch`.
struct TouchCall {
  std::size_t watch = 0;  ///< which
  BodyId other;
  bool began = true;
};

/// A call of an action within the last step.
struct Moment {
  double back = 0;  ///< before its end [s]
  std::function<void()> call;
};

/// What `attract` made.
struct Attraction {
  std::optional<PairForces> forces;  ///< none: removed
  std::string place;
};

/// Change of velocity over the last step, by its length.
struct MeanAcceleration {
  std::uint32_t generation = 0;  ///< of the body that was in the slot
  Vec2 linear;                   ///< [m/s^2]
  double angular = 0;            ///< [rad/s^2]
};

/// What changes while a demo runs, besides its world and its Lua variables.
struct ScriptProgress {
  Picture picture;
  std::vector<Check> checks;
  std::vector<Watch> watches;
  std::vector<Note> notes;
  std::vector<int> step_callbacks;
  std::vector<Appointment> appointments;
  std::vector<Crossing> crossings;
  std::vector<TouchWatch> touches;
  std::vector<BlowWatch> blows;
  Material material;                    ///< of shapes that do not say otherwise
  std::vector<std::string> categories;  ///< of bodies; bit 0 is that of those without one, then in this order
  std::vector<JointId> joints;
  std::vector<Attraction> attractions;
  std::vector<MeanAcceleration> accelerations;  ///< by body slot
  Observe needed;                               ///< by the script's own sensors
  std::uint64_t steps = 0;
  RunTotals totals;
  bool body_removed = false;  ///< by a user: the script may name a body that is no more
  bool told_loss = false;     ///< the first error since then was noted
};

struct Script : ScriptProgress {
  Script(const std::string& file, const DemoOptions& given)
      : options(given), path(file), host(file, given.seed) {
    host.attach(this);
    host.on_print(given.print);
  }

  DemoOptions options;
  std::string name, path, title, lesson;
  std::uint64_t hash = 0;   ///< of the text that was run
  double seconds = 5;       ///< length of the run
  double full_seconds = 5;  ///< as the script says, whatever the command line
  double dt = 1.0 / 60;
  std::vector<Parameter> parameters;
  std::optional<World> world;                 ///< made by `demo{...}`
  std::vector<BridgeView> bridges;            ///< their states are part of a demo's state, too
  std::vector<MeanAcceleration> before_step;  ///< velocities, by body slot
  Observe wanted;                             ///< by the overlays
  std::optional<double> shown_time;           ///< of pictures, if it is not that of the last step
  std::optional<double> look_back;            ///< bodies are as so long before the end of the last step [s]
  std::string highlight_place;                ///< of a `highlight` whose labels nobody has looked up yet
  std::string usage_error;                    ///< a `--set` value that the script refused
  const char* asked = nullptr;  ///< whose function is asked for an answer now, and may change nothing
  LuaHost host;

  double time() const { return static_cast<double>(steps) * dt; }
  /// The step, from 1, at whose end or within which a time [s] is; the first one has its beginning, too.
  std::uint64_t step_with(double moment) const { return std::max<std::uint64_t>(1, steps_until(moment, dt)); }
  /// How long before the end of that step it is [s]; 0: at its end.
  double before_step_end(double moment) const {
    const double back = static_cast<double>(step_with(moment)) * dt - moment;
    return back > 1e-6 * dt ? std::min(back, dt) : 0;
  }
  /// A body as the script's functions see it. @throws std::invalid_argument for a body that is no more
  BodyState state_of(BodyId body) const {
    if (look_back) return world->interpolated(body, world->time() - *look_back);
    return {world->position(body), world->angle(body), world->velocity(body), world->omega(body)};
  }
  /// Zero for what has not made a step yet. @throws std::invalid_argument for a body that is no more
  MeanAcceleration acceleration_of(BodyId body) const {
    world->mass(body);  // refuses ids that do not exist
    if (body.index >= accelerations.size()) return {};
    const MeanAcceleration& found = accelerations[body.index];
    return found.generation == body.generation ? found : MeanAcceleration{};
  }
  void observe() {
    if (!world) return;
    world->observe({.contacts = needed.contacts || wanted.contacts,
                    .systems = needed.systems || wanted.systems,
                    .solve_traces = needed.solve_traces || wanted.solve_traces,
                    .stage_times = needed.stage_times || wanted.stage_times,
                    .paths = needed.paths || wanted.paths});
  }
};

/// While it lives, a function of the script is asked for an answer: a world that steps cannot be changed, and
/// what is only looked at must not be.
class Asking {
 public:
  Asking(Script& script, const char* whose) : script_(script), before_(std::exchange(script.asked, whose)) {}
  ~Asking() { script_.asked = before_; }
  Asking(const Asking&) = delete;
  Asking& operator=(const Asking&) = delete;

 private:
  Script& script_;
  const char* before_;
};

/// While it lives, functions of the script see the bodies and `time()` as they were `back` [s] before the end
/// of the last step, until they change the world.
class LookingBack {
 public:
  LookingBack(Script& script, double back) : script_(script) {
    if (back > 0) script.look_back = back;
  }
  ~LookingBack() { script_.look_back.reset(); }
  LookingBack(const LookingBack&) = delete;
  LookingBack& operator=(const LookingBack&) = delete;

 private:
  Script& script_;
};

/// What the command line says goes before the script and what was saved.
void take_options(const DemoOptions& given, WorldConfig& config);

/// The script of a state; its world must exist. @throws std::invalid_argument when `demo{...}` was not called
/// yet.
Script& script_with_world(lua_State* state, const char* function);
/// The same for functions that it may not call while it is asked for an answer. @throws std::invalid_argument
Script& script_to_act(lua_State* state, const char* function);
/// The same for functions that change the world: from here on bodies are seen as they are.
Script& script_to_change(lua_State* state, const char* function);
/// The script of a state.
Script& script_of(lua_State* state);

/// Brings the bridges to the end of the step.
void advance_bridges(Script& script);

/// What was struck in the last step, for `on_hit`, by watch and body.
void find_blows(Script& script, std::vector<Moment>& moments);
/// What began and ended in the last step, for `on_touch`: by watch, endings first, then by the other's slot.
std::vector<TouchCall> find_touches(Script& script);
/// Makes the call, unless one before it has removed what began to touch.
void tell_touch(Script& script, const TouchCall& call);
/// Drops what waits for bodies that are no more.
void forget_watches(Script& script);

/// Adds the forces of `attract` for the next step. @return whether there are any
bool apply_attractions(Script& script);

/// Adds the functions of demos/README.md to a host, group by group.
void add_scene_functions(lua_State* state);   ///< demo, param, choice, show, expect, watch, note, at, on_step
void add_body_functions(lua_State* state);    ///< ground, chain, box, disc, polygon, ...
void add_joint_functions(lua_State* state);   ///< rod, rope, spring, hinge, slider, weld, wheel, ...
void add_sensor_functions(lua_State* state);  ///< contact, time, gravity, energy, momentum, ...
void add_touch_functions(lua_State* state);   ///< on_touch, on_hit
void add_query_functions(lua_State* state);   ///< ray, bodies_at, nearest
void add_compound_function(lua_State* state);    ///< compound
void add_force_functions(lua_State* state);      ///< field, drag, move, on_event
void add_attraction_function(lua_State* state);  ///< attract
void add_statics_functions(lua_State* state);    ///< bridge
void add_truss_function(lua_State* state);       ///< truss

}  // namespace skerry::sandbox
