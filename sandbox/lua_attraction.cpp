// SPDX-License-Identifier: MIT
//
// Script function for forces between bodies that do not touch: attract.
#include <stdexcept>

#include "physics/pair_forces.h"
#include "sandbox/errors.h"
#include "sandbox/lua_args.h"
#include "sandbox/names.h"
#include "sandbox/script.h"

namespace skerry::sandbox {
namespace {

constexpr const char* kAttractionType = "attraction";

/// { 1, -1 }
std::vector<double> read_weights(lua_State* L, const Args& args, int value) {
  if (lua_type(L, value) != LUA_TTABLE) args.fail("weights", "a list of numbers", value);
  std::vector<double> weights;
  for (lua_Unsigned i = 1; i <= lua_rawlen(L, value); ++i) {
    lua_rawgeti(L, value, static_cast<lua_Integer>(i));
    weights.push_back(number_argument(L, -1, "attract", "weights[" + std::to_string(i) + "]"));
    lua_pop(L, 1);
  }
  return weights;
}

// attract{ strength = k, power = 2, softening = 0, bodies = {...}, weights = {...} }
int attract(lua_State* L) {
  Script& script = script_to_change(L, "attract");
  const Args args(L, "attract", {"strength", "power", "softening", "bodies", "weights"});
  PairForces forces({.strength = args.required_number("strength"),
                     .power = args.number("power", 2),
                     .softening = args.number_from("softening", 0).value_or(0)});
  const std::optional<std::vector<BodyId>> named = args.bodies("bodies");
  const std::vector<BodyId> bodies = named.value_or(std::vector<BodyId>{});
  const bool weighed = lua_getfield(L, args.index(), "weights") != LUA_TNIL;
  const std::vector<double> weights = weighed ? read_weights(L, args, lua_gettop(L)) : std::vector<double>{};
  lua_pop(L, 1);
  if (named && bodies.size() < 2)
    throw std::invalid_argument("attract: bodies expected two or more, got " + std::to_string(bodies.size()));
  if (weighed && weights.size() != bodies.size())
    throw std::invalid_argument("attract: weights expected one for each of " + std::to_string(bodies.size()) +
                                " bodies, got " + std::to_string(weights.size()));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double weight = weighed ? weights[i] : script.world->mass(bodies[i]);
    if (!weighed && weight == 0)
      throw std::invalid_argument("attract: bodies[" + std::to_string(i + 1) +
                                  "] is not dynamic and has no mass; give weights");
    forces.set_weight(bodies[i], weight);
  }
  script.attractions.push_back({std::move(forces), script_place(L)});
  *static_cast<std::size_t*>(lua_newuserdatauv(L, sizeof(std::size_t), 0)) = script.attractions.size() - 1;
  luaL_setmetatable(L, kAttractionType);
  return 1;
}

/// @throws std::invalid_argument if it was removed
PairForces& attraction_self(lua_State* L, Script& script) {
  const auto number = *static_cast<const std::size_t*>(luaL_checkudata(L, 1, kAttractionType));
  std::optional<PairForces>& forces = script.attractions.at(number).forces;
  if (!forces) throw std::invalid_argument("attraction: it was removed");
  return *forces;
}

// attraction:remove()
int attraction_remove(lua_State* L) {
  Script& script = script_to_change(L, "remove");
  attraction_self(L, script);
  script.attractions[*static_cast<const std::size_t*>(lua_touserdata(L, 1))].forces.reset();
  return 0;
}

int attraction_index(lua_State* L) {
  Script& script = script_with_world(L, "attraction");
  const std::string key = text_argument(L, 2, "attraction", "field");
  static const std::vector<std::string> names{"strength", "power", "softening", "energy", "remove"};
  if (key == "remove") {
    lua_pushcfunction(L, guarded<attraction_remove>);
    return 1;
  }
  const PairForces& forces = attraction_self(L, script);
  if (key == "strength")
    lua_pushnumber(L, forces.law().strength);
  else if (key == "power")
    lua_pushnumber(L, forces.law().power);
  else if (key == "softening")
    lua_pushnumber(L, forces.law().softening);
  else if (key == "energy")
    lua_pushnumber(L, forces.potential_energy(*script.world));
  else
    throw std::invalid_argument("attraction: no field \"" + key + '"' + suggestion(key, names));
  return 1;
}

int attraction_newindex(lua_State* L) {
  PairForces& forces = attraction_self(L, script_to_change(L, "attraction"));
  const std::string key = text_argument(L, 2, "attraction", "field");
  PairLaw law = forces.law();
  if (key == "strength")
    law.strength = number_argument(L, 3, "attraction", key);
  else if (key == "power")
    law.power = number_argument(L, 3, "attraction", key);
  else if (key == "softening" && number_argument(L, 3, "attraction", key) < 0)
    throw std::invalid_argument("attraction: softening must be at least 0, got " + describe(L, 3));
  else if (key == "softening")
    law.softening = number_argument(L, 3, "attraction", key);
  else
    throw std::invalid_argument("attraction: \"" + key +
                                "\" cannot be set; these can: strength, power, softening");
  forces.set_law(law);
  return 0;
}

}  // namespace

bool apply_attractions(Script& script) {
  bool any = false;
  for (const Attraction& attraction : script.attractions) {
    if (!attraction.forces) continue;
    any = true;
    try {
      attraction.forces->apply(*script.world, script.dt);
    } catch (const std::invalid_argument& error) {
      throw ScriptError(attraction.place + ": attract: " + error.what());
    }
  }
  return any;
}

void add_attraction_function(lua_State* state) {
  luaL_newmetatable(state, kAttractionType);
  lua_pushcfunction(state, guarded<attraction_index>);
  lua_setfield(state, -2, "__index");
  lua_pushcfunction(state, guarded<attraction_newindex>);
  lua_setfield(state, -2, "__newindex");
  lua_pop(state, 1);
  lua_register(state, "attract", guarded<attract>);
}

}  // namespace skerry::sandbox
