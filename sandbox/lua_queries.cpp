// SPDX-License-Identifier: MIT
//
// Script functions that ask what is where: ray, bodies_at, nearest.
#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "physics/narrowphase/queries.h"
#include "sandbox/lua_bodies.h"

namespace skerry::sandbox {
namespace {

/// What a question leaves out.
struct LeftOut {
  Filter filter;  ///< categories
  std::vector<BodyId> bodies;
  bool sensors = true;

  bool has(const ShapeRecord& shape) const {
    if (!may_collide(shape.filter, filter) || (sensors && shape.sensor)) return true;
    return std::find(bodies.begin(), bodies.end(), shape.body) != bodies.end();
  }
};

/// A world to look at. While it makes a step nothing in it is anywhere yet.
Script& script_to_ask(lua_State* L, const char* function) {
  Script& script = script_with_world(L, function);
  const std::string_view asked = script.asked ? script.asked : "";
  if (asked == "field" || asked == "move")
    throw std::invalid_argument(std::string(function) + ": the function of " + script.asked +
                                " must depend on its arguments alone");
  return script;
}

std::vector<std::string> with_left_out(std::vector<std::string> keys) {
  keys.insert(keys.end(), {"skip", "ignores", "sensors"});
  return keys;
}

/// skip = ball, or { ball, wheel }
std::vector<BodyId> read_skipped(lua_State* L, const Args& args) {
  const int type = lua_getfield(L, args.index(), "skip");
  const int value = lua_gettop(L);
  std::vector<BodyId> bodies;
  if (const std::optional<BodyId> single = to_body(L, value)) {
    bodies.push_back(*single);
  } else if (type != LUA_TNIL) {
    if (type != LUA_TTABLE) args.fail("skip", "a body or a list of bodies", value);
    bodies = args.bodies("skip").value_or(bodies);
  }
  lua_pop(L, 1);
  return bodies;
}

LeftOut read_left_out(lua_State* L, const Args& args, const Script& script) {
  LeftOut out;
  out.bodies = read_skipped(L, args);
  out.sensors = !args.flag("sensors").value_or(false);
  if (lua_getfield(L, args.index(), "ignores") != LUA_TNIL)
    out.filter.mask = known_categories(L, lua_gettop(L), script, args.function() + ": ignores");
  lua_pop(L, 1);
  return out;
}

// ray{ from = {x, y}, to = {x, y} } -> body, x, y, nx, ny
int ray(lua_State* L) {
  const Script& script = script_to_ask(L, "ray");
  static const std::vector<std::string> keys = with_left_out({"from", "to"});
  const Args args(L, "ray", keys);
  const Vec2 from = args.required_pair("from"), to = args.required_pair("to");
  if (from == to)
    throw std::invalid_argument("ray: to must not be where from is, {" + format_number(to.x) + ", " +
                                format_number(to.y) + "}");
  const LeftOut out = read_left_out(L, args, script);
  const World& world = *script.world;
  for (const QueryHit& hit : world.ray_cast_all({from, to - from, 1})) {
    if (out.has(world.shapes()[hit.shape.index])) continue;
    push_body(L, hit.body);
    for (const double value : {hit.point.x, hit.point.y, hit.normal.x, hit.normal.y})
      lua_pushnumber(L, value);
    return 5;
  }
  lua_pushnil(L);
  return 1;
}

/// The named arguments after x and y, which need not be there: an empty table then.
int options_after_point(lua_State* L) {
  lua_settop(L, 3);
  if (lua_isnil(L, 3)) {
    lua_newtable(L);
    lua_replace(L, 3);
  }
  return 3;
}

// bodies_at(x, y [, {...}]) -> list
int bodies_at(lua_State* L) {
  const Script& script = script_to_ask(L, "bodies_at");
  const Vec2 point{number_argument(L, 1, "bodies_at", "x"), number_argument(L, 2, "bodies_at", "y")};
  static const std::vector<std::string> keys = with_left_out({});
  const LeftOut out = read_left_out(L, Args(L, "bodies_at", keys, options_after_point(L)), script);
  const World& world = *script.world;
  std::vector<BodyId> found;
  for (const ShapeId shape : world.shapes_at(point)) {
    const ShapeRecord& record = world.shapes()[shape.index];
    const bool known = std::find(found.begin(), found.end(), record.body) != found.end();
    if (!known && !out.has(record)) found.push_back(record.body);
  }
  lua_createtable(L, static_cast<int>(found.size()), 0);
  lua_Integer place = 0;
  for (const BodyId body : found) {
    push_body(L, body);
    lua_rawseti(L, -2, ++place);
  }
  return 1;
}

struct Nearest {
  BodyId body;
  ClosestPoint at;
};

// nearest(x, y [, {...}]) -> body, distance, x, y
int nearest(lua_State* L) {
  const Script& script = script_to_ask(L, "nearest");
  const Vec2 point{number_argument(L, 1, "nearest", "x"), number_argument(L, 2, "nearest", "y")};
  static const std::vector<std::string> keys = with_left_out({"within"});
  const Args args(L, "nearest", keys, options_after_point(L));
  const double within = args.number_from("within", 0).value_or(kInfinity);
  const LeftOut out = read_left_out(L, args, script);
  const World& world = *script.world;
  std::optional<Nearest> best;
  const auto look_at = [&](const ShapeRecord& shape) {
    if (!shape.alive || out.has(shape)) return;
    const ClosestPoint at = closest_point(shape.shape, world.pose(shape.body), point);
    if (at.distance <= within && (!best || at.distance < best->at.distance)) best = {shape.body, at};
  };
  if (within < kInfinity) {
    const Vec2 reach{within, within};
    for (const ShapeId shape : world.shapes_in_box({point - reach, point + reach}))
      look_at(world.shapes()[shape.index]);
  } else {
    for (const ShapeRecord& shape : world.shapes()) look_at(shape);
  }
  if (!best) {
    lua_pushnil(L);
    return 1;
  }
  push_body(L, best->body);
  for (const double value : {best->at.distance, best->at.point.x, best->at.point.y}) lua_pushnumber(L, value);
  return 4;
}

}  // namespace

void add_query_functions(lua_State* state) {
  lua_register(state, "ray", guarded<ray>);
  lua_register(state, "bodies_at", guarded<bodies_at>);
  lua_register(state, "nearest", guarded<nearest>);
}

}  // namespace skerry::sandbox
