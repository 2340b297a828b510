// SPDX-License-Identifier: MIT
//
// Script functions for forces that depend on the state (field, drag), prescribed motions (move) and events
// (on_event).
#include <cmath>
#include <stdexcept>

#include "sandbox/errors.h"
#include "sandbox/lua_args.h"
#include "sandbox/script.h"

namespace skerry::sandbox {
namespace {

/// What a callback returned at `index`; a wrong value is an error at the place where it was given.
/// @param place  of that; empty: the line that runs now
double returned(lua_State* L, int index, const std::string& place, const char* what) {
  if (lua_type(L, index) == LUA_TNUMBER && std::isfinite(lua_tonumber(L, index)))
    return lua_tonumber(L, index);
  throw ScriptError((place.empty() ? "" : place + ": ") + what + " returned expected a finite number, got " +
                    describe(L, index));
}

// field(function(x, y, vx, vy, m, t, body) return fx, fy, torque end); field() switches it off
int field(lua_State* L) {
  Script& script = script_to_change(L, "field");
  if (lua_isnoneornil(L, 1)) {
    script.world->set_force_field({});
    return 0;
  }
  const int function = function_argument(L, 1, "field", "force");
  script.world->set_force_field([&script, function, place = script_place(L)](const FieldSample& s) {
    const Asking asking(script, "field");
    script.host.call(function, 3, [&](lua_State* state) {
      for (const double value : {s.position.x, s.position.y, s.velocity.x, s.velocity.y, s.mass, s.time})
        lua_pushnumber(state, value);
      push_body(state, s.body);
      return 7;
    });
    lua_State* state = script.host.state();
    Wrench wrench;
    wrench.force = {returned(state, -3, place, "field: fx"), returned(state, -2, place, "field: fy")};
    if (!lua_isnil(state, -1)) wrench.torque = returned(state, -1, place, "field: torque");
    lua_pop(state, 3);
    return wrench;
  });
  return 0;
}

// drag(body, { linear = c, quadratic = c2, angular = c, angular_quadratic = c2 })
int drag(lua_State* L) {
  Script& script = script_to_change(L, "drag");
  const std::optional<BodyId> body = to_body(L, 1);
  if (!body) throw std::invalid_argument("drag: first expected a body, got " + describe(L, 1));
  const Args args(L, "drag", {"linear", "quadratic", "angular", "angular_quadratic"}, 2);
  Drag drag;
  drag.linear = args.number_from("linear", 0).value_or(0);
  drag.quadratic = args.number_from("quadratic", 0).value_or(0);
  drag.angular = args.number_from("angular", 0).value_or(0);
  drag.angular_quadratic = args.number_from("angular_quadratic", 0).value_or(0);
  script.world->set_drag(*body, drag);
  return 0;
}

/// @param angle  where the function says nothing about it
Placement placement(lua_State* L, const std::string& place, double angle) {
  Placement at;
  at.angle = angle;
  at.position = {returned(L, -3, place, "move: x"), returned(L, -2, place, "move: y")};
  if (!lua_isnil(L, -1)) at.angle = returned(L, -1, place, "move: angle");
  lua_pop(L, 3);
  return at;
}

// move(body, function(t) return x, y, angle end): a kinematic body goes as told
int move(lua_State* L) {
  Script& script = script_to_change(L, "move");
  const std::optional<BodyId> body = to_body(L, 1);
  if (!body) throw std::invalid_argument("move: first expected a body, got " + describe(L, 1));
  const int function = function_argument(L, 2, "move", "place");
  const std::string place = script_place(L);
  // The world asks at once where the body is; a call within this one has the limits and the line of this one.
  const double now = script.world->time(), angle = script.world->angle(*body);
  lua_pushvalue(L, 2);
  lua_pushnumber(L, now);
  {
    const Asking asking(script, "move");
    lua_call(L, 1, 3);
  }
  const Placement here = placement(L, {}, angle);
  script.world->set_motion(*body, [&script, function, place, now, here, angle](double time) {
    if (time == now) return here;
    const Asking asking(script, "move");
    script.host.call(function, 3, [time](lua_State* state) {
      lua_pushnumber(state, time);
      return 1;
    });
    return placement(script.host.state(), place, angle);
  });
  return 0;
}

// on_event(function() return g end, function(t) ... end): when g changes its sign
int on_event(lua_State* L) {
  Script& script = script_to_act(L, "on_event");
  Crossing crossing;
  crossing.place = script_place(L);
  crossing.function = function_argument(L, 1, "on_event", "measure");
  crossing.action = function_argument(L, 2, "on_event", "action");
  script.crossings.push_back(std::move(crossing));
  script.needed.paths = true;
  script.observe();
  return 0;
}

}  // namespace

void add_force_functions(lua_State* state) {
  const luaL_Reg functions[] = {{"field", guarded<field>},
                                {"drag", guarded<drag>},
                                {"move", guarded<move>},
                                {"on_event", guarded<on_event>}};
  for (const luaL_Reg& entry : functions) lua_register(state, entry.name, entry.func);
}

}  // namespace skerry::sandbox
