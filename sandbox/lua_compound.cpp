// SPDX-License-Identifier: MIT
//
// The script function that makes bodies of several shapes: compound.
#include <algorithm>
#include <stdexcept>

#include "sandbox/lua_bodies.h"
#include "sandbox/names.h"

namespace skerry::sandbox {
namespace {

/// A shape that a part may have.
struct PartShape {
  const char* name;
  const std::vector<std::string>& (*keys)();
  Shape (*read)(const Args& args);
};

constexpr PartShape kPartShapes[] = {{"box", &box_keys, &read_box},
                                     {"disc", &disc_keys, &read_disc},
                                     {"polygon", &polygon_keys, &read_polygon},
                                     {"capsule", &capsule_keys, &read_capsule}};

const PartShape& part_shape(const std::string& name, const std::string& function) {
  std::vector<std::string> names;
  for (const PartShape& shape : kPartShapes) {
    if (name == shape.name) return shape;
    names.emplace_back(shape.name);
  }
  throw std::invalid_argument(function + ": no shape \"" + name + '"' + suggestion(name, names));
}

std::vector<std::string> part_keys(const PartShape& shape) {
  std::vector<std::string> keys = shape.keys();
  for (const char* key : {"shape", "at", "angle", "density", "friction", "static_friction", "restitution",
                          "rolling_resistance", "surface_speed", "sensor"})
    keys.emplace_back(key);
  return keys;
}

/// The shape turned by `pose` and moved.
Shape placed(const Shape& shape, const Transform& pose) {
  std::vector<Vec2> corners;
  for (const Vec2 corner : shape.vertices) corners.push_back(to_world(pose, corner));
  switch (shape.kind) {
    case ShapeKind::Disc:
      return make_disc(shape.radius, corners[0]);
    case ShapeKind::Capsule:
      return make_capsule(corners[0], corners[1], shape.radius);
    default:
      return make_polygon(corners, shape.radius);
  }
}

/// The part at `index` of the stack. @param whole  what parts have that do not say otherwise
ShapeDef read_part(lua_State* L, int index, const std::string& function, const ShapeDef& whole) {
  if (lua_type(L, index) != LUA_TTABLE)
    throw std::invalid_argument(function + " expected a table, as in { shape = \"disc\", radius = 1 }, got " +
                                describe(L, index));
  lua_getfield(L, index, "shape");
  const PartShape& kind = part_shape(text_argument(L, -1, function, "shape"), function);
  lua_pop(L, 1);
  const Args args(L, function, part_keys(kind), index);
  ShapeDef part = whole;
  part.shape =
      placed(kind.read(args), {args.pair("at").value_or(Vec2{}), Rot::from_angle(args.number("angle", 0))});
  part.material = read_material(args, whole.material);
  part.sensor = args.flag("sensor").value_or(whole.sensor);
  // A feeler weighs nothing unless it says so.
  const bool feeler = part.sensor && !whole.sensor;
  if (args.has("density") || !feeler)
    part.density = read_density(args, whole.density);
  else
    part.density = 0;
  return part;
}

// compound{ { shape = "box", ... }, { shape = "disc", ... }, at = {x, y}, ... }
int compound(lua_State* L) {
  Script& script = script_to_change(L, "compound");
  if (lua_type(L, 1) != LUA_TTABLE)
    throw std::invalid_argument(
        "compound: expected a table, as in compound{ { shape = \"disc\", radius = 1 }, ... }, got " +
        describe(L, 1));
  // The list of the parts and the named arguments, apart so that both are checked.
  const lua_Unsigned count = lua_rawlen(L, 1);
  lua_newtable(L);
  const int named = lua_gettop(L);
  for (lua_pushnil(L); lua_next(L, 1) != 0; lua_pop(L, 1)) {
    if (lua_isinteger(L, -2) && lua_tointeger(L, -2) >= 1 &&
        static_cast<lua_Unsigned>(lua_tointeger(L, -2)) <= count)
      continue;
    lua_pushvalue(L, -2);
    lua_pushvalue(L, -2);
    lua_rawset(L, named);
  }
  static const std::vector<std::string> keys = with_common({});
  const Args args(L, "compound", keys, named);
  if (count == 0) throw std::invalid_argument("compound: expected at least one part, got none");
  BodyDef def = read_body(args);
  ShapeDef whole;
  whole.density = read_density(args, whole.density);
  whole.material = read_material(args, script.material);
  whole.filter = read_filter(L, args, script);
  whole.sensor = args.flag("sensor").value_or(false);
  const int color = read_color(args);
  std::vector<ShapeDef> parts;
  for (lua_Unsigned i = 1; i <= count; ++i) {
    lua_rawgeti(L, 1, static_cast<lua_Integer>(i));
    parts.push_back(read_part(L, lua_gettop(L), "compound: part " + std::to_string(i), whole));
    lua_pop(L, 1);
  }
  if (std::all_of(parts.begin(), parts.end(), [](const ShapeDef& part) { return part.density == 0; }))
    throw std::invalid_argument(
        "compound: all parts are sensors, which weigh nothing; set sensor = true for the whole body");
  add_body(L, script, def, parts, color);
  return 1;
}

}  // namespace

void add_compound_function(lua_State* state) {
  lua_register(state, "compound", guarded<compound>);
}

}  // namespace skerry::sandbox
