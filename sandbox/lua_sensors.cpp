// SPDX-License-Identifier: MIT
//
// Script functions that look at the world: contact sensors, energy, momentum, time; and gravity.
#include <stdexcept>

#include "sandbox/lua_args.h"
#include "sandbox/names.h"
#include "sandbox/script.h"

namespace skerry::sandbox {
namespace {

constexpr const char* kContactType = "contact";

/// Looks at what happens between two bodies; `second` none: between the first and all others.
struct Sensor {
  BodyId first, second;
};

// contact(a [, b]) -> sensor
int contact(lua_State* L) {
  Script& script = script_with_world(L, "contact");
  const std::optional<BodyId> first = to_body(L, 1);
  const std::optional<BodyId> second = to_body(L, 2);
  if (!first) throw std::invalid_argument("contact: expected a body, got " + describe(L, 1));
  if (!second && !lua_isnoneornil(L, 2))
    throw std::invalid_argument("contact: second expected a body, got " + describe(L, 2));
  if (!script.needed.contacts) {
    script.needed.contacts = true;
    script.observe();
  }
  *static_cast<Sensor*>(lua_newuserdatauv(L, sizeof(Sensor), 0)) = {*first, second.value_or(BodyId{})};
  luaL_setmetatable(L, kContactType);
  return 1;
}

/// What the last step says about a sensor's contacts.
struct Reading {
  Vec2 impulse;         ///< on the first body, friction and impacts included [N s]
  double normal = 0;    ///< sum of normal impulses, impacts included [N s]
  double least = 0;     ///< smallest normal impulse of a point [N s]
  double friction = 0;  ///< sum along perp(normal) [N s]
  double gap = kInfinity;
  int points = 0;
  int overlaps = 0;  ///< pairs of shapes of which one is a sensor
};

/// Overlaps with sensors push nothing, so they count where one is asked for: it is the first body's, or the
/// second body is named.
int count_overlaps(const Sensor& sensor, const World& world) {
  int count = 0;
  for (const ContactEvent& event : world.report().events) {
    if (!event.sensor || event.kind == ContactEventKind::End) continue;
    const bool forward = event.body_a == sensor.first;
    if (!forward && event.body_b != sensor.first) continue;
    const BodyId other = forward ? event.body_b : event.body_a;
    const ShapeId own = forward ? event.shape_a : event.shape_b;
    const bool asked =
        sensor.second ? other == sensor.second : world.alive(own) && world.shapes()[own.index].sensor;
    count += asked;
  }
  return count;
}

Reading read(const Sensor& sensor, const World& world) {
  Reading reading;
  for (const ContactReport& report : world.report().contacts_list) {
    const bool forward = report.body_a == sensor.first;
    if (!forward && report.body_b != sensor.first) continue;
    const BodyId other = forward ? report.body_b : report.body_a;
    if (sensor.second && other != sensor.second) continue;
    reading.impulse += forward ? -report.impulse : report.impulse;
    for (int i = 0; i < report.count; ++i) {
      const ContactPointReport& point = report.points[static_cast<std::size_t>(i)];
      const double normal = point.normal_impulse + point.impact_impulse;
      reading.normal += normal;
      reading.least = reading.points == 0 ? normal : std::min(reading.least, normal);
      reading.friction += point.friction_impulse;
      reading.gap = std::min(reading.gap, point.separation);
      ++reading.points;
    }
  }
  reading.overlaps = count_overlaps(sensor, world);
  return reading;
}

int contact_index(lua_State* L) {
  const World& world = *script_with_world(L, "contact").world;
  const Sensor& sensor = *static_cast<const Sensor*>(luaL_checkudata(L, 1, kContactType));
  const std::string key = text_argument(L, 2, "contact", "field");
  static const std::vector<std::string> names{"impulse", "force", "least",  "friction", "fx",
                                              "fy",      "gap",   "points", "touching"};
  const Reading reading = read(sensor, world);
  const double h = world.report().h;
  const auto push_mean = [&](double impulse) { lua_pushnumber(L, h > 0 ? impulse / h : 0); };
  if (key == "impulse")
    lua_pushnumber(L, reading.normal);
  else if (key == "force")
    push_mean(reading.normal);
  else if (key == "least")
    lua_pushnumber(L, reading.least);
  else if (key == "friction")
    push_mean(reading.friction);
  else if (key == "fx")
    push_mean(reading.impulse.x);
  else if (key == "fy")
    push_mean(reading.impulse.y);
  else if (key == "gap")
    lua_pushnumber(L, reading.gap);
  else if (key == "points")
    lua_pushinteger(L, reading.points + reading.overlaps);
  else if (key == "touching")
    lua_pushboolean(L, reading.normal > 0 || reading.overlaps > 0);
  else
    throw std::invalid_argument("contact: no field \"" + key + '"' + suggestion(key, names));
  return 1;
}

/// What is known of all bodies together takes no argument: one that is given means something else.
const World& world_of_all(lua_State* L, const char* function) {
  if (lua_gettop(L) > 0)
    throw std::invalid_argument(std::string(function) + ": is of all bodies and takes nothing, got " +
                                describe(L, 1));
  return *script_with_world(L, function).world;
}

int energy(lua_State* L) {
  const World& world = world_of_all(L, "energy");
  lua_pushnumber(L, world.kinetic_energy() + world.potential_energy());
  return 1;
}

int kinetic_energy(lua_State* L) {
  lua_pushnumber(L, world_of_all(L, "kinetic_energy").kinetic_energy());
  return 1;
}

int momentum(lua_State* L) {
  const Vec2 momentum = world_of_all(L, "momentum").momentum();
  lua_pushnumber(L, momentum.x);
  lua_pushnumber(L, momentum.y);
  return 2;
}

int angular_momentum(lua_State* L) {
  lua_pushnumber(L, world_of_all(L, "angular_momentum").angular_momentum());
  return 1;
}

int time(lua_State* L) {
  const Script& script = script_of(L);
  lua_pushnumber(L, script.time() - script.look_back.value_or(0));
  return 1;
}

int penetration(lua_State* L) {
  lua_pushnumber(L, world_of_all(L, "penetration").report().worst_penetration);
  return 1;
}

int impact_law(lua_State* L) {
  lua_pushstring(L, script_with_world(L, "impact_law").world->config().impact_law.c_str());
  return 1;
}

// gravity(x, y) from now on
int gravity(lua_State* L) {
  World& world = *script_to_change(L, "gravity").world;
  world.set_gravity({number_argument(L, 1, "gravity", "x"), number_argument(L, 2, "gravity", "y")});
  return 0;
}

}  // namespace

void add_sensor_functions(lua_State* state) {
  luaL_newmetatable(state, kContactType);
  lua_pushcfunction(state, guarded<contact_index>);
  lua_setfield(state, -2, "__index");
  lua_pop(state, 1);
  const luaL_Reg functions[] = {{"contact", guarded<contact>},
                                {"energy", guarded<energy>},
                                {"kinetic_energy", guarded<kinetic_energy>},
                                {"momentum", guarded<momentum>},
                                {"angular_momentum", guarded<angular_momentum>},
                                {"time", guarded<time>},
                                {"penetration", guarded<penetration>},
                                {"impact_law", guarded<impact_law>},
                                {"gravity", guarded<gravity>}};
  for (const luaL_Reg& entry : functions) lua_register(state, entry.name, entry.func);
}

}  // namespace skerry::sandbox
