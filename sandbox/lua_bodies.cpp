// SPDX-License-Identifier: MIT
//
// Script functions that make bodies (ground, chain, box, disc, polygon, capsule), and the body object.
#include "sandbox/lua_bodies.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sandbox/names.h"

namespace skerry::sandbox {
namespace {

constexpr const char* kBodyType = "body";

const std::vector<std::string>& type_names() {
  static const std::vector<std::string> names{"static", "kinematic", "dynamic"};
  return names;
}

/// @param types  that are allowed, from static on
BodyType to_type(const std::string& type, std::span<const std::string> types, const std::string& function) {
  const auto found = std::find(types.begin(), types.end(), type);
  if (found == types.end())
    throw std::invalid_argument(function + ": no type \"" + type + '"' + suggestion(type, types));
  return static_cast<BodyType>(found - types.begin());
}

/// @param types  that are allowed, from static on
BodyType read_type(const Args& args, std::span<const std::string> types, const char* standard) {
  return to_type(args.text("type").value_or(standard), types, args.function());
}

void read_velocity(const Args& args, BodyDef& def) {
  def.velocity = args.pair("velocity").value_or(Vec2{});
  def.omega = args.number("omega", 0);
  if (def.type == BodyType::Static && (def.velocity != Vec2{} || def.omega != 0))
    throw std::invalid_argument(args.function() +
                                ": what is static has no velocity and no omega; try type = \"kinematic\"");
}

/// Index into the palette. @throws std::invalid_argument for a name that is not there
int to_color(const std::string& name, const std::string& function) {
  const std::vector<std::string>& names = color_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    throw std::invalid_argument(function + ": no color \"" + name + '"' + suggestion(name, names));
  return static_cast<int>(found - names.begin());
}

void of_the_living(const World& world, BodyId body, const char* field) {
  if (!world.alive(body))
    throw std::invalid_argument(std::string("body: \"") + field + "\" of a body that was removed");
}

/// The name of its colour, or nil.
void push_color(lua_State* L, const Script& script, BodyId body) {
  of_the_living(*script.world, body, "color");
  const int color = script.picture.colors.of(body);
  if (color < 0)
    lua_pushnil(L);
  else
    lua_pushstring(L, color_names()[static_cast<std::size_t>(color)].c_str());
}

double positive(const Args& args, const char* key, double value) {
  if (value <= 0)
    throw std::invalid_argument(args.function() + ": " + key + " must be positive, got " +
                                format_number(value));
  return value;
}

// Makes a body of one shape, given in the body's frame, from the common arguments; leaves it on the stack.
int make_body(lua_State* L, const Args& args, Shape shape) {
  Script& script = script_to_change(L, args.function().c_str());
  const BodyDef def = read_body(args);
  ShapeDef part;
  part.shape = std::move(shape);
  part.density = read_density(args, part.density);
  part.material = read_material(args, script.material);
  part.filter = read_filter(L, args, script);
  part.sensor = args.flag("sensor").value_or(false);
  add_body(L, script, def, std::span(&part, 1), read_color(args));
  return 1;
}

int box(lua_State* L) {
  static const std::vector<std::string> keys = with_common(box_keys());
  const Args args(L, "box", keys);
  return make_body(L, args, read_box(args));
}

int disc(lua_State* L) {
  static const std::vector<std::string> keys = with_common(disc_keys());
  const Args args(L, "disc", keys);
  return make_body(L, args, read_disc(args));
}

int polygon(lua_State* L) {
  static const std::vector<std::string> keys = with_common(polygon_keys());
  const Args args(L, "polygon", keys);
  return make_body(L, args, read_polygon(args));
}

int capsule(lua_State* L) {
  static const std::vector<std::string> keys = with_common(capsule_keys());
  const Args args(L, "capsule", keys);
  return make_body(L, args, read_capsule(args));
}

/// Arguments of what is static or kinematic, besides those of its own.
std::vector<std::string> of_what_is_laid(std::vector<std::string> keys) {
  keys.insert(keys.end(),
              {"type", "velocity", "omega", "friction", "static_friction", "restitution",
               "rolling_resistance", "surface_speed", "name", "group", "category", "ignores", "sensor"});
  return keys;
}

// ground{ y = 0, tilt = 0 }: everything below a line
int ground(lua_State* L) {
  static const std::vector<std::string> keys = of_what_is_laid({"y", "x", "tilt"});
  const Args args(L, "ground", keys);
  Script& script = script_to_change(L, "ground");
  ShapeDef part;
  part.shape = make_half_plane({0, 0}, {0, 1});
  part.material = read_material(args, script.material);
  part.filter = read_filter(L, args, script);
  part.sensor = args.flag("sensor").value_or(false);
  BodyDef def;
  def.type = read_type(args, std::span(type_names()).first(2), "static");
  def.position = {args.number("x", 0), args.number("y", 0)};
  def.angle = args.number("tilt", 0);
  read_velocity(args, def);
  def.name = args.text("name").value_or("ground");
  add_body(L, script, def, std::span(&part, 1), -1);
  return 1;
}

/// The corners of a chain. What is wrong with them is said with their numbers in the script.
std::vector<Vec2> read_track(const Args& args, bool loop) {
  std::vector<Vec2> points = args.points("points");
  const std::size_t least = loop ? 3 : 2;
  const auto name = [](std::size_t i) { return "points[" + std::to_string(i + 1) + "]"; };
  if (points.size() < least)
    throw std::invalid_argument("chain: points expected at least " + std::to_string(least) +
                                (loop ? " for a loop" : "") + ", got " + std::to_string(points.size()));
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i] == points[i - 1])
      throw std::invalid_argument("chain: " + name(i) + " repeats " + name(i - 1) + ", {" +
                                  format_number(points[i].x) + ", " + format_number(points[i].y) + "}");
  }
  if (loop && points.back() == points.front())
    throw std::invalid_argument("chain: " + name(points.size() - 1) + " repeats " + name(0) +
                                "; a loop goes on from the last to the first without that");
  return points;
}

// chain{ points = {{0, 0}, ...}, loop = false }: a track of segments, solid on the right of the way
int chain(lua_State* L) {
  static const std::vector<std::string> keys = of_what_is_laid({"points", "loop", "at", "angle", "color"});
  const Args args(L, "chain", keys);
  Script& script = script_to_change(L, "chain");
  ShapeDef part;
  const bool loop = args.flag("loop").value_or(false);
  part.shape = make_chain(read_track(args, loop), loop);
  part.material = read_material(args, script.material);
  part.filter = read_filter(L, args, script);
  part.sensor = args.flag("sensor").value_or(false);
  BodyDef def;
  def.type = read_type(args, std::span(type_names()).first(2), "static");
  def.position = args.pair("at").value_or(Vec2{});
  def.angle = args.number("angle", 0);
  read_velocity(args, def);
  def.name = args.text("name").value_or("chain");
  add_body(L, script, def, std::span(&part, 1), read_color(args));
  return 1;
}

// --- The body object

BodyId self(lua_State* L, const char* what) {
  const std::optional<BodyId> body = to_body(L, 1);
  if (!body)
    throw std::invalid_argument(std::string(what) + ": call it with a colon, as in body:" + what + "(...)");
  return *body;
}

using Getter = double (*)(const Script&, BodyId);
using Setter = void (*)(World&, BodyId, double);

struct Field {
  const char* name;
  Getter get;
  Setter set;          ///< null: read only
  bool moves = false;  ///< a body that is told where to go has it from there
};

/// That of the first shape of a body.
const Material& material_of(const Script& s, BodyId body) {
  static const Material none;
  const ShapeRecord* shape = first_shape(*s.world, body);
  return shape ? shape->material : none;
}

/// Changes that of all shapes of a body.
template <class Change>
void change_material(World& world, BodyId body, Change change) {
  for (const ShapeId shape : shapes_of(world, body)) {
    Material material = world.shapes()[shape.index].material;
    change(material);
    world.set_material(shape, material);
  }
}

/// A number of the material that is read and set as it is.
template <double Material::*Number>
constexpr Field material_field(const char* name) {
  return {name, [](const Script& s, BodyId b) { return material_of(s, b).*Number; },
          [](World& w, BodyId b, double v) { change_material(w, b, [v](Material& m) { m.*Number = v; }); }};
}

void set_inertia(World& world, BodyId body, double inertia) {
  if (!(inertia > 0)) throw std::invalid_argument("inertia must be positive, got " + format_number(inertia));
  const double mass = world.mass(body);
  if (mass == 0) throw std::invalid_argument("only what is dynamic has one");
  world.set_mass(body, mass, inertia);
}

constexpr Field kFields[] = {
    {"x", [](const Script& s, BodyId b) { return s.state_of(b).position.x; },
     [](World& w, BodyId b, double v) {
       w.set_pose(b, {v, w.position(b).y}, w.angle(b));
     },
     true},
    {"y", [](const Script& s, BodyId b) { return s.state_of(b).position.y; },
     [](World& w, BodyId b, double v) {
       w.set_pose(b, {w.position(b).x, v}, w.angle(b));
     },
     true},
    {"angle", [](const Script& s, BodyId b) { return s.state_of(b).angle; },
     [](World& w, BodyId b, double v) { w.set_pose(b, w.position(b), v); }, true},
    {"vx", [](const Script& s, BodyId b) { return s.state_of(b).velocity.x; },
     [](World& w, BodyId b, double v) {
       w.set_velocity(b, {v, w.velocity(b).y}, w.omega(b));
     },
     true},
    {"vy", [](const Script& s, BodyId b) { return s.state_of(b).velocity.y; },
     [](World& w, BodyId b, double v) {
       w.set_velocity(b, {w.velocity(b).x, v}, w.omega(b));
     },
     true},
    {"omega", [](const Script& s, BodyId b) { return s.state_of(b).omega; },
     [](World& w, BodyId b, double v) { w.set_velocity(b, w.velocity(b), v); }, true},
    {"friction", [](const Script& s, BodyId b) { return material_of(s, b).friction; },
     [](World& w, BodyId b, double v) {
       change_material(w, b, [v](Material& m) {
         m.friction = v;
         m.static_friction.reset();
       });
     }},
    {"static_friction",
     [](const Script& s, BodyId b) {
       const Material& m = material_of(s, b);
       return m.static_friction.value_or(m.friction);
     },
     [](World& w, BodyId b, double v) {
       change_material(w, b, [v](Material& m) { m.static_friction = v; });
     }},
    material_field<&Material::restitution>("restitution"),
    material_field<&Material::rolling_resistance>("rolling_resistance"),
    material_field<&Material::surface_velocity>("surface_speed"),
    {"speed", [](const Script& s, BodyId b) { return length(s.state_of(b).velocity); }, nullptr},
    {"ax", [](const Script& s, BodyId b) { return s.acceleration_of(b).linear.x; }, nullptr},
    {"ay", [](const Script& s, BodyId b) { return s.acceleration_of(b).linear.y; }, nullptr},
    {"alpha", [](const Script& s, BodyId b) { return s.acceleration_of(b).angular; }, nullptr},
    {"mass", [](const Script& s, BodyId b) { return s.world->mass(b); },
     [](World& w, BodyId b, double v) { w.set_mass(b, v); }},
    {"inertia", [](const Script& s, BodyId b) { return s.world->inertia(b); }, &set_inertia},
    {"gravity_scale", [](const Script& s, BodyId b) { return s.world->bodies().gravity_scale[b.index]; },
     [](World& w, BodyId b, double v) { w.set_gravity_scale(b, v); }},
    {"kinetic_energy",
     [](const Script& s, BodyId b) {
       const BodyState now = s.state_of(b);
       return 0.5 *
              (s.world->mass(b) * length_squared(now.velocity) + s.world->inertia(b) * now.omega * now.omega);
     },
     nullptr},
};

std::vector<std::string> field_names() {
  std::vector<std::string> names;
  for (const Field& field : kFields) names.emplace_back(field.name);
  names.insert(names.end(), filter_fields().begin(), filter_fields().end());
  for (const char* name : {"type", "color", "name", "alive", "force", "torque", "impulse", "point", "remove"})
    names.emplace_back(name);
  return names;
}

// The point of application: a third argument {x, y} in the world frame, else the centre of mass.
Vec2 point_of_application(lua_State* L, const World& world, BodyId body, const char* function) {
  if (lua_isnoneornil(L, 4)) return world.position(body);
  const std::optional<Vec2> point = to_pair(L, 4);
  if (!point)
    throw std::invalid_argument(std::string(function) + ": point expected {x, y}, got " + describe(L, 4));
  return *point;
}

int body_force(lua_State* L) {
  World& world = *script_to_change(L, "force").world;
  const BodyId body = self(L, "force");
  const Vec2 force{number_argument(L, 2, "force", "x"), number_argument(L, 3, "force", "y")};
  world.apply_force(body, force, point_of_application(L, world, body, "force"));
  return 0;
}

int body_impulse(lua_State* L) {
  World& world = *script_to_change(L, "impulse").world;
  const BodyId body = self(L, "impulse");
  const Vec2 impulse{number_argument(L, 2, "impulse", "x"), number_argument(L, 3, "impulse", "y")};
  world.apply_impulse(body, impulse, point_of_application(L, world, body, "impulse"));
  return 0;
}

int body_torque(lua_State* L) {
  World& world = *script_to_change(L, "torque").world;
  world.apply_torque(self(L, "torque"), number_argument(L, 2, "torque", "torque"));
  return 0;
}

// Where a point of the body, given in its frame from the centre of mass, is now.
int body_point(lua_State* L) {
  const Script& script = script_with_world(L, "point");
  const BodyId body = self(L, "point");
  const Vec2 local{number_argument(L, 2, "point", "x"), number_argument(L, 3, "point", "y")};
  const BodyState now = script.state_of(body);
  const Vec2 point = to_world({now.position, Rot::from_angle(now.angle)}, local);
  lua_pushnumber(L, point.x);
  lua_pushnumber(L, point.y);
  return 2;
}

int body_remove(lua_State* L) {
  World& world = *script_to_change(L, "remove").world;
  const BodyId body = self(L, "remove");
  if (world.alive(body)) world.destroy(body);
  return 0;
}

int body_index(lua_State* L) {
  const Script& script = script_with_world(L, "body");
  const World& world = *script.world;
  const BodyId body = self(L, "field");
  const std::string key = text_argument(L, 2, "body", "field");
  for (const Field& field : kFields) {
    if (key != field.name) continue;
    lua_pushnumber(L, field.get(script, body));
    return 1;
  }
  if (key == "alive") {
    lua_pushboolean(L, world.alive(body));
    return 1;
  }
  if (key == "type") {
    of_the_living(world, body, "type");
    const std::uint8_t type = static_cast<std::uint8_t>(world.bodies().type[body.index]);
    lua_pushstring(L, type_names()[type].c_str());
    return 1;
  }
  if (key == "name") {
    const std::string_view name = world.name(body);
    lua_pushlstring(L, name.data(), name.size());
    return 1;
  }
  if (key == "color") {
    push_color(L, script, body);
    return 1;
  }
  if (push_filter_field(L, script, body, key)) return 1;
  // Methods are upvalue 1.
  if (lua_getfield(L, lua_upvalueindex(1), key.c_str()) != LUA_TNIL) return 1;
  throw std::invalid_argument("body: no field \"" + key + '"' + suggestion(key, field_names()));
}

int body_newindex(lua_State* L) {
  Script& script = script_to_change(L, "body");
  World& world = *script.world;
  const BodyId body = self(L, "field");
  const std::string key = text_argument(L, 2, "body", "field");
  if (key == "type") {
    world.set_type(body, to_type(text_argument(L, 3, "body", key), type_names(), "body"));
    return 0;
  }
  if (key == "color") {
    of_the_living(world, body, "color");
    script.picture.colors.set(body,
                              lua_isnil(L, 3) ? -1 : to_color(text_argument(L, 3, "body", key), "body"));
    return 0;
  }
  if (set_filter_field(L, script, body, key, 3)) return 0;
  std::vector<std::string> settable{"type", "color", "group", "category", "ignores"};
  for (const Field& field : kFields) {
    if (!field.set) continue;
    settable.emplace_back(field.name);
    if (key != field.name) continue;
    const double value = number_argument(L, 3, "body", key);
    if (field.moves && world.alive(body) && world.has_motion(body))
      throw std::invalid_argument("body: \"" + key + "\" of a body that goes as `move` told it");
    try {
      field.set(world, body, value);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("body: " + key + ": " + error.what());
    }
    return 0;
  }
  throw std::invalid_argument("body: \"" + key + "\" cannot be set; these can: " + join(settable));
}

int body_tostring(lua_State* L) {
  const Script& script = script_with_world(L, "body");
  const BodyId body = self(L, "tostring");
  std::string name = script.world->alive(body) ? std::string(script.world->name(body)) : "removed";
  if (name.empty()) name = std::to_string(body.index);
  lua_pushfstring(L, "body %s", name.c_str());
  return 1;
}

int body_equal(lua_State* L) {
  lua_pushboolean(L, to_body(L, 1) == to_body(L, 2));
  return 1;
}

}  // namespace

std::vector<std::string> with_common(std::vector<std::string> keys) {
  for (const char* key : {"at",
                          "angle",
                          "velocity",
                          "omega",
                          "mass",
                          "inertia",
                          "density",
                          "friction",
                          "static_friction",
                          "restitution",
                          "rolling_resistance",
                          "surface_speed",
                          "type",
                          "gravity_scale",
                          "group",
                          "category",
                          "ignores",
                          "sensor",
                          "name",
                          "color"})
    keys.emplace_back(key);
  return keys;
}

Material read_material(const Args& args, const Material& standard) {
  Material material = standard;
  material.friction = args.number_from("friction", 0).value_or(standard.friction);
  // A friction of its own goes with a static one of its own.
  if (args.has("friction")) material.static_friction.reset();
  if (const std::optional<double> held = args.number_from("static_friction", 0)) {
    if (*held < material.friction)
      throw std::invalid_argument(args.function() + ": static_friction must be at least friction, got " +
                                  format_number(*held) + " and " + format_number(material.friction));
    material.static_friction = held;
  }
  material.restitution = args.number_from("restitution", 0).value_or(standard.restitution);
  material.rolling_resistance =
      args.number_from("rolling_resistance", 0).value_or(standard.rolling_resistance);
  material.surface_velocity = args.number("surface_speed", standard.surface_velocity);
  return material;
}

BodyDef read_body(const Args& args) {
  BodyDef def;
  def.type = read_type(args, type_names(), "dynamic");
  def.position = args.pair("at").value_or(Vec2{});
  def.angle = args.number("angle", 0);
  read_velocity(args, def);
  if ((def.mass = args.number("mass"))) positive(args, "mass", *def.mass);
  if ((def.inertia = args.number("inertia"))) positive(args, "inertia", *def.inertia);
  def.gravity_scale = args.number("gravity_scale", 1);
  def.name = args.text("name").value_or("");
  return def;
}

double read_density(const Args& args, double standard) {
  return positive(args, "density", args.number("density", standard));
}

int read_color(const Args& args) {
  const std::optional<std::string> name = args.text("color");
  return name ? to_color(*name, args.function()) : -1;
}

const std::vector<std::string>& box_keys() {
  static const std::vector<std::string> keys{"size", "rounding"};
  return keys;
}
const std::vector<std::string>& disc_keys() {
  static const std::vector<std::string> keys{"radius"};
  return keys;
}
const std::vector<std::string>& polygon_keys() {
  static const std::vector<std::string> keys{"corners", "rounding"};
  return keys;
}
const std::vector<std::string>& capsule_keys() {
  static const std::vector<std::string> keys{"from", "to", "radius"};
  return keys;
}

Shape read_box(const Args& args) {
  const Vec2 size = args.required_pair("size", "{w, h}");
  if (size.x <= 0 || size.y <= 0)
    throw std::invalid_argument(args.function() + ": size must be positive, got {" + format_number(size.x) +
                                ", " + format_number(size.y) + "}");
  return make_box(size, {}, 0, args.number_from("rounding", 0).value_or(0));
}

Shape read_disc(const Args& args) {
  return make_disc(positive(args, "radius", args.required_number("radius")));
}

Shape read_polygon(const Args& args) {
  return make_polygon(args.points("corners"), args.number_from("rounding", 0).value_or(0));
}

Shape read_capsule(const Args& args) {
  const double radius = positive(args, "radius", args.required_number("radius"));
  return make_capsule(args.required_pair("from"), args.required_pair("to"), radius);
}

BodyId add_body(lua_State* L, Script& script, const BodyDef& def, std::span<const ShapeDef> parts,
                int color) {
  World& world = *script.world;
  LuaHost::of(L).spend(kInstructionsOfABody);
  const BodyId body = world.create_body(def);
  try {
    for (const ShapeDef& part : parts) world.add_shape(body, part);
    // Shapes may have moved the centre of mass off the point whose velocity it was.
    if (def.type != BodyType::Static && world.velocity(body) != def.velocity)
      world.set_velocity(body, def.velocity, def.omega);
  } catch (...) {
    world.destroy(body);
    throw;
  }
  script.picture.colors.set(body, color);
  push_body(L, body);
  return body;
}

std::vector<ShapeId> shapes_of(const World& world, BodyId body) {
  std::vector<ShapeId> found;
  for (std::uint32_t i = 0; i < world.shapes().size(); ++i) {
    const ShapeRecord& shape = world.shapes()[i];
    if (shape.alive && shape.body == body) found.push_back({i, shape.generation});
  }
  return found;
}

const ShapeRecord* first_shape(const World& world, BodyId body) {
  for (const ShapeRecord& shape : world.shapes()) {
    if (shape.alive && shape.body == body) return &shape;
  }
  return nullptr;
}

std::optional<BodyId> to_body(lua_State* state, int index) {
  const void* object = luaL_testudata(state, index, kBodyType);
  if (!object) return {};
  return *static_cast<const BodyId*>(object);
}

void push_body(lua_State* state, BodyId body) {
  *static_cast<BodyId*>(lua_newuserdatauv(state, sizeof(BodyId), 0)) = body;
  luaL_setmetatable(state, kBodyType);
}

void add_body_functions(lua_State* state) {
  luaL_newmetatable(state, kBodyType);
  lua_newtable(state);
  const luaL_Reg methods[] = {{"force", guarded<body_force>},     {"torque", guarded<body_torque>},
                              {"impulse", guarded<body_impulse>}, {"point", guarded<body_point>},
                              {"remove", guarded<body_remove>},   {nullptr, nullptr}};
  luaL_setfuncs(state, methods, 0);
  lua_pushcclosure(state, guarded<body_index>, 1);
  lua_setfield(state, -2, "__index");
  const luaL_Reg meta[] = {{"__newindex", guarded<body_newindex>},
                           {"__tostring", guarded<body_tostring>},
                           {"__eq", guarded<body_equal>},
                           {nullptr, nullptr}};
  luaL_setfuncs(state, meta, 0);
  lua_pop(state, 1);

  const luaL_Reg functions[] = {{"ground", guarded<ground>},   {"box", guarded<box>},
                                {"disc", guarded<disc>},       {"polygon", guarded<polygon>},
                                {"capsule", guarded<capsule>}, {"chain", guarded<chain>}};
  for (const luaL_Reg& entry : functions) lua_register(state, entry.name, entry.func);
}

}  // namespace skerry::sandbox
