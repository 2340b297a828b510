// SPDX-License-Identifier: MIT
//
// Script function `bridge`, and the bridge object.
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "sandbox/bridge_view.h"
#include "sandbox/lua_args.h"
#include "sandbox/names.h"
#include "sandbox/script.h"

namespace skerry::sandbox {
namespace {

using namespace statics;

constexpr const char* kBridgeType = "bridge";

/// Calls `read` for each element of the list `key`, which lies on top of the stack then.
template <class Read>
void for_each(lua_State* L, const Args& args, const char* key, const char* form, Read&& read) {
  const int type = lua_getfield(L, args.index(), key);
  if (type != LUA_TNIL && type != LUA_TTABLE) args.fail(key, form, -1);
  if (type == LUA_TTABLE) {
    const int list = lua_gettop(L);
    for (lua_Unsigned i = 1; i <= lua_rawlen(L, list); ++i) {
      lua_rawgeti(L, list, static_cast<lua_Integer>(i));
      read(static_cast<int>(i));
      lua_settop(L, list);
    }
  }
  lua_pop(L, 1);
}

std::string place_in(const char* list, int index) {
  return std::string("bridge: ") + list + "[" + std::to_string(index) + "]";
}

/// Takes the first `count` values of the list on top of the stack out of it, so that the rest has names only.
void split(lua_State* L, const std::string& what, int count, const char* form) {
  if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != static_cast<lua_Unsigned>(count))
    throw std::invalid_argument(what + " expected " + form + ", got " + describe(L, -1));
  const int from = lua_gettop(L);
  lua_newtable(L);
  for (lua_pushnil(L); lua_next(L, from) != 0; lua_pop(L, 1)) {
    if (lua_type(L, -2) == LUA_TNUMBER) continue;
    lua_pushvalue(L, -2);
    lua_pushvalue(L, -2);
    lua_settable(L, from + 1);
  }
}

/// A node by its number or its name.
int node_number(lua_State* L, int index, const std::string& what, const Structure& structure) {
  if (lua_isinteger(L, index)) {
    const lua_Integer number = lua_tointeger(L, index);
    if (number < 1 || number > static_cast<lua_Integer>(structure.nodes.size()))
      throw std::invalid_argument(what + ": no node " + std::to_string(number) + ", there are " +
                                  std::to_string(structure.nodes.size()));
    return static_cast<int>(number) - 1;
  }
  if (lua_type(L, index) == LUA_TSTRING) {
    const std::string name = lua_tostring(L, index);
    std::vector<std::string> names;
    for (std::size_t i = 0; i < structure.nodes.size(); ++i) {
      if (structure.nodes[i].name == name) return static_cast<int>(i);
      if (!structure.nodes[i].name.empty()) names.push_back(structure.nodes[i].name);
    }
    throw std::invalid_argument(what + ": no node \"" + name + '"' + suggestion(name, names));
  }
  throw std::invalid_argument(what + " expected a node's number or name, got " + describe(L, index));
}

const std::vector<std::string>& section_keys() {
  static const std::vector<std::string> keys{"area",    "second_moment", "depth",   "modulus", "strength",
                                             "density", "beam",          "hinge_a", "hinge_b", "cable"};
  return keys;
}

void read_section(const Args& args, Member& member) {
  member.area = args.number_from("area", 0).value_or(member.area);
  member.second_moment = args.number_from("second_moment", 0).value_or(member.second_moment);
  member.depth = args.number_from("depth", 0).value_or(member.depth);
  member.modulus = args.number_from("modulus", 0).value_or(member.modulus);
  member.strength = args.number("strength", member.strength);
  member.density = args.number_from("density", 0).value_or(member.density);
  if (const std::optional<bool> beam = args.flag("beam"))
    member.kind = *beam ? MemberKind::Beam : MemberKind::Bar;
  member.hinge_a = args.flag("hinge_a").value_or(member.hinge_a);
  member.hinge_b = args.flag("hinge_b").value_or(member.hinge_b);
  member.cable = args.flag("cable").value_or(member.cable);
}

void read_nodes(lua_State* L, const Args& args, Structure& structure) {
  for_each(L, args, "nodes", "a list {{x, y}, ...}", [&](int i) {
    Node node;
    const std::string what = place_in("nodes", i);
    const int list = lua_gettop(L);
    split(L, what, 2, "{x, y}");
    const std::optional<Vec2> at = to_pair(L, list);
    if (!at) throw std::invalid_argument(what + " expected {x, y}, got " + describe(L, list));
    node.at = *at;
    node.name = Args(L, what, {"name"}, list + 1).text("name").value_or("");
    structure.nodes.push_back(node);
  });
}

void read_members(lua_State* L, const Args& args, Structure& structure) {
  Member standard;
  if (lua_getfield(L, args.index(), "section") != LUA_TNIL)
    read_section(Args(L, "bridge: section", section_keys(), lua_gettop(L)), standard);
  lua_pop(L, 1);
  for_each(L, args, "members", "a list {{node, node, ...}, ...}", [&](int i) {
    Member member = standard;
    const std::string what = place_in("members", i);
    const int list = lua_gettop(L);
    split(L, what, 2, "{node, node}");
    lua_rawgeti(L, list, 1);
    lua_rawgeti(L, list, 2);
    member.a = node_number(L, -2, what, structure);
    member.b = node_number(L, -1, what, structure);
    lua_pop(L, 2);
    read_section(Args(L, what, section_keys(), list + 1), member);
    structure.members.push_back(member);
  });
}

void read_supports(lua_State* L, const Args& args, Structure& structure) {
  static const std::vector<std::string> kinds{"pinned", "roller", "fixed"};
  for_each(L, args, "supports", "a list {{node, \"pinned\"}, ...}", [&](int i) {
    Support support;
    const std::string what = place_in("supports", i);
    const int list = lua_gettop(L);
    split(L, what, 2, "{node, \"pinned\", \"roller\" or \"fixed\"}");
    lua_rawgeti(L, list, 1);
    support.node = node_number(L, -1, what, structure);
    lua_rawgeti(L, list, 2);
    const std::string kind = text_argument(L, -1, what, "kind");
    lua_pop(L, 2);
    const auto found = std::find(kinds.begin(), kinds.end(), kind);
    if (found == kinds.end())
      throw std::invalid_argument(what + ": no kind \"" + kind + '"' + suggestion(kind, kinds));
    support.kind = static_cast<SupportKind>(found - kinds.begin());
    support.angle = Args(L, what, {"angle"}, list + 1).number("angle", 0);
    structure.supports.push_back(support);
  });
}

void read_loads(lua_State* L, const Args& args, const Structure& structure, Load& load) {
  for_each(L, args, "loads", "a list {{node, {fx, fy}}, ...}", [&](int i) {
    const std::string what = place_in("loads", i);
    const int list = lua_gettop(L);
    split(L, what, 2, "{node, {fx, fy}}");
    lua_rawgeti(L, list, 1);
    lua_rawgeti(L, list, 2);
    const std::optional<Vec2> force = to_pair(L, -1);
    if (!force) throw std::invalid_argument(what + " expected {node, {fx, fy}}, got " + describe(L, -1));
    load.nodes.push_back({node_number(L, -2, what, structure), *force});
  });
}

void read_train(lua_State* L, const Args& args, Train& train) {
  if (lua_getfield(L, args.index(), "train") == LUA_TNIL) {
    lua_pop(L, 1);
    return;
  }
  const Args given(L, "bridge: train", {"axles", "gaps", "speed", "start", "wheel_radius"}, lua_gettop(L));
  const auto numbers = [&](const char* key, std::vector<double>& list) {
    for_each(L, given, key, "a list of numbers", [&](int i) {
      list.push_back(
          number_argument(L, -1, "bridge: train", std::string(key) + "[" + std::to_string(i) + "]"));
    });
  };
  numbers("axles", train.axles);
  numbers("gaps", train.gaps);
  train.speed = given.number("speed", train.speed);
  train.start = given.number("start", train.start);
  train.wheel_radius = given.number("wheel_radius", train.wheel_radius);
  lua_pop(L, 1);
}

// Wagons stand out from the ground that kinematic bodies look like; they are new bodies once they are let go.
void color_wagons(Script& script, const Bridge& bridge) {
  constexpr int kYellow = 5;
  for (const BodyId wagon : bridge.wagons()) script.picture.colors.set(wagon, kYellow);
}

// bridge{ nodes = ..., members = ..., supports = ..., deck = ..., train = ... } -> bridge
int make_bridge(lua_State* L) {
  const Args args(L, "bridge",
                  {"nodes", "members", "section", "supports", "deck", "train", "loads", "method", "breaks",
                   "thickness", "ground", "numbers", "influence"});
  Script& script = script_to_change(L, "bridge");
  BridgeDef def;
  read_nodes(L, args, def.structure);
  read_members(L, args, def.structure);
  read_supports(L, args, def.structure);
  read_loads(L, args, def.structure, def.fixed);
  read_train(L, args, def.train);
  for_each(L, args, "deck", "a list of nodes",
           [&](int i) { def.deck.push_back(node_number(L, -1, place_in("deck", i), def.structure)); });
  static const std::vector<std::string> methods{"static", "dynamic"};
  const std::string method = args.text("method").value_or("static");
  if (std::find(methods.begin(), methods.end(), method) == methods.end())
    throw std::invalid_argument("bridge: no method \"" + method + '"' + suggestion(method, methods));
  def.dynamic = method == "dynamic";
  def.breaks = args.flag("breaks").value_or(true);
  def.thickness = args.number("thickness", def.thickness);
  def.ground = args.number("ground");
  BridgeView view;
  view.numbers = args.flag("numbers").value_or(false);
  if (const std::optional<double> member = args.number("influence")) {
    const double last = static_cast<double>(def.structure.members.size());
    if (!(*member >= 1 && *member <= last) || *member != std::floor(*member))
      throw std::invalid_argument("bridge: influence expected the number of a member, 1 to " +
                                  format_number(last) + ", got " + format_number(*member));
    view.influence = Quantity{Quantity::Kind::Axial, static_cast<int>(*member) - 1};
  }
  view.bridge = std::make_unique<Bridge>(std::move(def), *script.world);
  if (view.influence) view.bridge->solver().influence(*view.influence);  // refuses members that are not there
  color_wagons(script, *view.bridge);
  script.bridges.push_back(std::move(view));
  *static_cast<std::size_t*>(lua_newuserdatauv(L, sizeof(std::size_t), 0)) = script.bridges.size() - 1;
  luaL_setmetatable(L, kBridgeType);
  return 1;
}

Bridge& bridge_self(lua_State* L) {
  const void* object = luaL_testudata(L, 1, kBridgeType);
  if (!object) throw std::invalid_argument("bridge: call its methods with a colon, as in bridge:force(3)");
  return *script_of(L).bridges[*static_cast<const std::size_t*>(object)].bridge;
}

int member_argument(lua_State* L, const Bridge& bridge, const char* function) {
  const double number = number_argument(L, 2, function, "member");
  if (!(number >= 1 && number <= static_cast<double>(bridge.members().size())) ||
      number != static_cast<int>(number))
    throw std::invalid_argument(std::string(function) + ": no member " + format_number(number) +
                                ", there are " + std::to_string(bridge.members().size()));
  return static_cast<int>(number) - 1;
}

const MemberState& member(lua_State* L, const char* function) {
  const Bridge& bridge = bridge_self(L);
  return bridge.members()[static_cast<std::size_t>(member_argument(L, bridge, function))];
}

int bridge_force(lua_State* L) {
  lua_pushnumber(L, member(L, "force").axial);
  return 1;
}

int bridge_use(lua_State* L) {
  lua_pushnumber(L, member(L, "use").signed_use);
  return 1;
}

int bridge_peak(lua_State* L) {
  const MemberState& state = member(L, "peak");
  lua_pushnumber(L, state.peak_use);
  lua_pushnumber(L, state.peak_time);
  return 2;
}

int bridge_stress(lua_State* L) {
  const MemberState& state = member(L, "stress");
  lua_pushnumber(
      L, state.stress.tension > state.stress.compression ? state.stress.tension : -state.stress.compression);
  return 1;
}

// bridge:moment(member, share): bending moment
int bridge_moment(lua_State* L) {
  Bridge& bridge = bridge_self(L);
  const int number = member_argument(L, bridge, "moment");
  const double share = number_argument(L, 3, "moment", "share");
  const MemberState& state = bridge.members()[static_cast<std::size_t>(number)];
  Response ends;
  ends.members.resize(bridge.members().size());
  ends.members[static_cast<std::size_t>(number)] = {state.axial, state.moment_a, state.moment_b};
  lua_pushnumber(L, section_force(bridge.def().structure, bridge.load(), ends, number, share).moment);
  return 1;
}

// bridge:reaction(node) -> fx, fy, moment
int bridge_reaction(lua_State* L) {
  Bridge& bridge = bridge_self(L);
  const Structure& structure = bridge.def().structure;
  const int node = node_number(L, 2, "reaction", structure);
  for (std::size_t i = 0; i < structure.supports.size(); ++i) {
    if (structure.supports[i].node != node) continue;
    const Reaction& reaction = bridge.response().reactions[i];
    lua_pushnumber(L, reaction.force.x);
    lua_pushnumber(L, reaction.force.y);
    lua_pushnumber(L, reaction.moment);
    return 3;
  }
  throw std::invalid_argument("reaction: " + node_label(structure, node) + " has no support");
}

// bridge:influence(member, x): axial force for a unit load downwards at x along the deck
int bridge_influence(lua_State* L) {
  Bridge& bridge = bridge_self(L);
  const int number = member_argument(L, bridge, "influence");
  const double x = number_argument(L, 3, "influence", "x");
  if (!(x >= 0 && x <= bridge.deck_length()))
    throw std::invalid_argument("influence: x must be from 0 to " + format_number(bridge.deck_length()) +
                                ", got " + format_number(x));
  lua_pushnumber(L, bridge.influence_at({Quantity::Kind::Axial, number}, x));
  return 1;
}

int bridge_index(lua_State* L) {
  const Bridge& bridge = bridge_self(L);
  const std::string key = text_argument(L, 2, "bridge", "field");
  static const std::map<std::string, lua_CFunction> methods{
      {"force", guarded<bridge_force>},        {"use", guarded<bridge_use>},
      {"peak", guarded<bridge_peak>},          {"stress", guarded<bridge_stress>},
      {"moment", guarded<bridge_moment>},      {"reaction", guarded<bridge_reaction>},
      {"influence", guarded<bridge_influence>}};
  const auto method = methods.find(key);
  if (method != methods.end()) {
    lua_pushcfunction(L, method->second);
    return 1;
  }
  if (key == "members") {
    lua_pushinteger(L, static_cast<lua_Integer>(bridge.members().size()));
  } else if (key == "breaks") {
    lua_pushinteger(L, static_cast<lua_Integer>(bridge.breaks().size()));
  } else if (key == "moving") {
    lua_pushboolean(L, bridge.moving());
  } else if (key == "worst") {
    lua_pushinteger(L, bridge.worst() + 1);
  } else if (key == "determinacy") {
    lua_pushstring(L, bridge.determinacy().sentence().c_str());
  } else if (key == "residual") {
    lua_pushnumber(L, bridge.response().residual);
  } else {
    std::vector<std::string> names{"members", "breaks", "moving", "worst", "determinacy", "residual"};
    for (const auto& [name, function] : methods) names.push_back(name);
    throw std::invalid_argument("bridge: no field \"" + key + '"' + suggestion(key, names));
  }
  return 1;
}

}  // namespace

void advance_bridges(Script& script) {
  for (BridgeView& view : script.bridges) {
    view.bridge->advance(*script.world, script.time());
    color_wagons(script, *view.bridge);
  }
}

void add_statics_functions(lua_State* state) {
  luaL_newmetatable(state, kBridgeType);
  lua_pushcfunction(state, guarded<bridge_index>);
  lua_setfield(state, -2, "__index");
  lua_pop(state, 1);
  lua_register(state, "bridge", guarded<make_bridge>);
}

}  // namespace skerry::sandbox
