// SPDX-License-Identifier: MIT
//
// Script functions that join bodies (rod, rope, spring, hinge, slider, ...), and the joint object.
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sandbox/lua_args.h"
#include "sandbox/names.h"
#include "sandbox/script.h"

namespace skerry::sandbox {
namespace {

constexpr const char* kJointType = "joint";

/// One end of a rod or rope: a body (none: the ground) and a point of it, world frame at creation.
struct End {
  BodyId body;
  Vec2 anchor;
};

// {x, y}: a point of the ground; body: its centre of mass; {body, {x, y}}: a point of the body.
End read_end(lua_State* L, const Args& args, const char* key, const World& world) {
  lua_getfield(L, args.index(), key);
  End end;
  if (const std::optional<Vec2> point = to_pair(L, -1)) {
    end.anchor = *point;
  } else if (const std::optional<BodyId> body = to_body(L, -1)) {
    end = {*body, world.position(*body)};
  } else {
    constexpr const char* kForms = "{x, y}, a body, or {body, {x, y}}";
    if (lua_type(L, -1) != LUA_TTABLE || lua_rawlen(L, -1) != 2) args.fail(key, kForms, -1);
    lua_rawgeti(L, -1, 1);
    lua_rawgeti(L, -2, 2);
    const std::optional<BodyId> owner = to_body(L, -2);
    const std::optional<Vec2> anchor = to_pair(L, -1);
    lua_pop(L, 2);
    if (!owner || !anchor) args.fail(key, kForms, -1);
    end = {*owner, *anchor};
  }
  lua_pop(L, 1);
  return end;
}

int push_joint(lua_State* L, Script& script, const JointDef& def) {
  LuaHost::of(L).spend(kInstructionsOfABody);
  const JointId joint = script.world->create_joint(def);
  *static_cast<JointId*>(lua_newuserdatauv(L, sizeof(JointId), 0)) = joint;
  luaL_setmetatable(L, kJointType);
  return 1;
}

/// What all joints have: limits, motor, spring, breaking loads, where the kind has them.
const std::vector<std::string> kCommon{"limits",  "speed",       "motor_limit",  "stiffness",
                                       "damping", "break_force", "break_torque", "collide"};

std::vector<std::string> joint_keys(std::vector<std::string> own) {
  own.insert(own.end(), kCommon.begin(), kCommon.end());
  return own;
}

void read_common(const Args& args, JointDef& def) {
  if (const std::optional<Vec2> limits = args.pair("limits", "{lower, upper}")) {
    if (limits->x > limits->y)
      throw std::invalid_argument(args.function() + ": limits expected {lower, upper}, got {" +
                                  format_number(limits->x) + ", " + format_number(limits->y) + "}");
    def.lower = limits->x;
    def.upper = limits->y;
  }
  def.motor_speed = args.number("speed");
  def.motor_limit = args.number_from("motor_limit", 0).value_or(kInfinity);
  if (args.has("motor_limit") && !def.motor_speed)
    throw std::invalid_argument(args.function() + ": motor_limit needs a speed");
  def.stiffness = args.number_from("stiffness", 0).value_or(0);
  def.damping = args.number_from("damping", 0).value_or(0);
  def.break_force = args.number_from("break_force", 0).value_or(kInfinity);
  def.break_torque = args.number_from("break_torque", 0).value_or(kInfinity);
  def.collide = args.flag("collide").value_or(false);
}

/// The bodies of a joint: `a` is held by `b`, or by the ground.
void read_bodies(const Args& args, JointDef& def) {
  const std::optional<BodyId> a = args.body("a");
  if (!a) throw std::invalid_argument(args.function() + ": a expected a body, got nothing");
  // The ground is the first of the two, as for rods that hang from a point.
  def.b = *a;
  def.a = args.body("b").value_or(BodyId{});
}

int line_joint(lua_State* L, const char* function, JointKind kind) {
  static const std::vector<std::string> keys = joint_keys({"from", "to", "length"});
  const Args args(L, function, keys);
  Script& script = script_to_change(L, function);
  const End from = read_end(L, args, "from", *script.world);
  const End to = read_end(L, args, "to", *script.world);
  JointDef def;
  def.kind = kind;
  def.a = from.body;
  def.b = to.body;
  def.anchor_a = from.anchor;
  def.anchor_b = to.anchor;
  // The moving end is the second one.
  if (!def.b) {
    std::swap(def.a, def.b);
    std::swap(def.anchor_a, def.anchor_b);
  }
  if (!def.b) throw std::invalid_argument(std::string(function) + ": one end must be a body");
  def.length = args.number("length");
  const double least = kind == JointKind::Spring ? 0 : 1e-300;
  if (def.length && *def.length < least)
    throw std::invalid_argument(std::string(function) + ": length must be positive, got " +
                                format_number(*def.length));
  read_common(args, def);
  return push_joint(L, script, def);
}

int rod(lua_State* L) {
  return line_joint(L, "rod", JointKind::Distance);
}

int rope(lua_State* L) {
  return line_joint(L, "rope", JointKind::Rope);
}

int spring(lua_State* L) {
  return line_joint(L, "spring", JointKind::Spring);
}

/// Joints at a point: hinge, slider, weld, wheel. @param own  arguments besides a, b, at
int point_joint(lua_State* L, const char* function, JointKind kind, const std::vector<std::string>& keys) {
  const Args args(L, function, keys);
  Script& script = script_to_change(L, function);
  JointDef def;
  def.kind = kind;
  read_bodies(args, def);
  const bool needs_point = kind == JointKind::Revolute || kind == JointKind::Weld;
  def.anchor_a =
      needs_point ? args.required_pair("at") : args.pair("at").value_or(script.world->position(def.b));
  def.anchor_b = def.anchor_a;
  if (kind == JointKind::Prismatic)
    def.axis = args.required_pair("axis");
  else if (kind == JointKind::Wheel)
    def.axis = args.pair("axis").value_or(Vec2{0, 1});
  if (def.axis == Vec2{}) throw std::invalid_argument(std::string(function) + ": axis must not be {0, 0}");
  read_common(args, def);
  return push_joint(L, script, def);
}

// hinge{ a = body, b = body, at = {x, y} }; without b it turns about a fixed point
int hinge(lua_State* L) {
  static const std::vector<std::string> keys = joint_keys({"a", "b", "at"});
  return point_joint(L, "hinge", JointKind::Revolute, keys);
}

// slider{ a = body, b = body, axis = {x, y} }: a slides along an axis of b
int slider(lua_State* L) {
  static const std::vector<std::string> keys = joint_keys({"a", "b", "at", "axis"});
  return point_joint(L, "slider", JointKind::Prismatic, keys);
}

int weld(lua_State* L) {
  static const std::vector<std::string> keys = joint_keys({"a", "b", "at"});
  return point_joint(L, "weld", JointKind::Weld, keys);
}

// wheel{ a = wheel, b = chassis, axis = {0, 1}, stiffness = k, damping = c }
int wheel(lua_State* L) {
  static const std::vector<std::string> keys = joint_keys({"a", "b", "at", "axis"});
  return point_joint(L, "wheel", JointKind::Wheel, keys);
}

// motor{ a = body, b = body, speed = w, motor_limit = torque }
int motor(lua_State* L) {
  static const std::vector<std::string> keys = joint_keys({"a", "b"});
  const Args args(L, "motor", keys);
  Script& script = script_to_change(L, "motor");
  JointDef def;
  def.kind = JointKind::Motor;
  read_bodies(args, def);
  args.required_number("speed");
  def.anchor_a = def.anchor_b = script.world->position(def.b);
  // It says nothing about where the bodies are, so nothing against their touching.
  read_common(args, def);
  def.collide = args.flag("collide").value_or(true);
  return push_joint(L, script, def);
}

// gear{ a = driving, b = driven, ratio = ra / rb }: b turns by -ratio for each turn of a
int gear(lua_State* L) {
  static const std::vector<std::string> keys = joint_keys({"a", "b", "ratio"});
  const Args args(L, "gear", keys);
  Script& script = script_to_change(L, "gear");
  JointDef def;
  def.kind = JointKind::Gear;
  const std::optional<BodyId> a = args.body("a"), b = args.body("b");
  if (!a) throw std::invalid_argument("gear: a expected a body, got nothing");
  if (!b) throw std::invalid_argument("gear: b expected a body, got nothing");
  def.a = *a;
  def.b = *b;
  def.anchor_a = script.world->position(*a);
  def.anchor_b = script.world->position(*b);
  def.ratio = args.required_number("ratio");
  read_common(args, def);
  return push_joint(L, script, def);
}

// rack{ a = pinion, b = bar, axis = {x, y}, radius = r }
int rack(lua_State* L) {
  static const std::vector<std::string> keys = joint_keys({"a", "b", "axis", "radius"});
  const Args args(L, "rack", keys);
  Script& script = script_to_change(L, "rack");
  JointDef def;
  def.kind = JointKind::Rack;
  const std::optional<BodyId> a = args.body("a"), b = args.body("b");
  if (!a) throw std::invalid_argument("rack: a expected the pinion, got nothing");
  if (!b) throw std::invalid_argument("rack: b expected the bar, got nothing");
  def.a = *a;
  def.b = *b;
  def.anchor_a = script.world->position(*a);
  def.anchor_b = script.world->position(*b);
  def.axis = args.required_pair("axis");
  def.ratio = args.required_number("radius");
  read_common(args, def);
  return push_joint(L, script, def);
}

// pulley{ from = end, to = end, over = {{x, y}, {x, y}}, ratio = 1 }
int pulley(lua_State* L) {
  static const std::vector<std::string> keys = joint_keys({"from", "to", "over", "ratio"});
  const Args args(L, "pulley", keys);
  Script& script = script_to_change(L, "pulley");
  const End from = read_end(L, args, "from", *script.world);
  const End to = read_end(L, args, "to", *script.world);
  if (!from.body || !to.body) throw std::invalid_argument("pulley: from and to expected ends on bodies");
  const std::vector<Vec2> over = args.points("over");
  if (over.size() != 2)
    throw std::invalid_argument("pulley: over expected {{x, y}, {x, y}}, got " + std::to_string(over.size()) +
                                " points");
  JointDef def;
  def.kind = JointKind::Pulley;
  def.a = from.body;
  def.b = to.body;
  def.anchor_a = from.anchor;
  def.anchor_b = to.anchor;
  def.pulley_a = over[0];
  def.pulley_b = over[1];
  def.ratio = args.number("ratio", 1);
  read_common(args, def);
  def.collide = args.flag("collide").value_or(true);
  return push_joint(L, script, def);
}

JointId joint_self(lua_State* L) {
  const void* object = luaL_testudata(L, 1, kJointType);
  if (!object) throw std::invalid_argument("joint: call its methods with a colon, as in rod:remove()");
  return *static_cast<const JointId*>(object);
}

int joint_remove(lua_State* L) {
  World& world = *script_to_change(L, "remove").world;
  const JointId joint = joint_self(L);
  if (world.alive(joint)) world.destroy(joint);
  return 0;
}

// joint:set_speed(speed [, limit])
int joint_set_speed(lua_State* L) {
  World& world = *script_to_change(L, "set_speed").world;
  const JointId joint = joint_self(L);
  const double speed = number_argument(L, 2, "set_speed", "speed");
  std::optional<double> limit;
  if (!lua_isnoneornil(L, 3)) limit = number_argument(L, 3, "set_speed", "limit");
  world.set_motor(joint, speed, limit);
  return 0;
}

/// A number of a joint that can be set.
struct JointField {
  const char* name;
  double (*get)(const JointRecord& joint);
  void (*set)(JointDef& def, std::optional<double> value);
  bool optional;  ///< nil takes it away, and is what is read where there is none
  bool may_be_endless = false;
};

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

constexpr JointField kJointFields[] = {
    {"length", [](const JointRecord& j) { return j.length; },
     [](JointDef& d, std::optional<double> v) { d.length = v; }, false},
    {"lower", [](const JointRecord& j) { return j.def.lower.value_or(kNone); },
     [](JointDef& d, std::optional<double> v) { d.lower = v; }, true},
    {"upper", [](const JointRecord& j) { return j.def.upper.value_or(kNone); },
     [](JointDef& d, std::optional<double> v) { d.upper = v; }, true},
    {"stiffness", [](const JointRecord& j) { return j.def.stiffness; },
     [](JointDef& d, std::optional<double> v) { d.stiffness = *v; }, false},
    {"damping", [](const JointRecord& j) { return j.def.damping; },
     [](JointDef& d, std::optional<double> v) { d.damping = *v; }, false},
    {"motor_limit", [](const JointRecord& j) { return j.def.motor_limit; },
     [](JointDef& d, std::optional<double> v) { d.motor_limit = *v; }, false, true},
    {"break_force", [](const JointRecord& j) { return j.def.break_force; },
     [](JointDef& d, std::optional<double> v) { d.break_force = *v; }, false, true},
    {"break_torque", [](const JointRecord& j) { return j.def.break_torque; },
     [](JointDef& d, std::optional<double> v) { d.break_torque = *v; }, false, true},
};

/// Mean force [N] and torque [N m] of the last step on the body that is held, and the coordinate with its
/// rate.
struct JointReading {
  const char* name;
  double (*get)(const World& world, JointId joint);
};

constexpr JointReading kJointReadings[] = {
    {"force", [](const World& w, JointId j) { return length(w.joint_force(j)); }},
    {"fx", [](const World& w, JointId j) { return w.joint_force(j).x; }},
    {"fy", [](const World& w, JointId j) { return w.joint_force(j).y; }},
    {"torque", [](const World& w, JointId j) { return w.joint_torque(j); }},
    {"position", [](const World& w, JointId j) { return w.joint_position(j); }},
    {"speed", [](const World& w, JointId j) { return w.joint_speed(j); }},
};

std::vector<std::string> joint_names() {
  std::vector<std::string> names{"alive", "remove", "set_speed"};
  for (const JointReading& reading : kJointReadings) names.emplace_back(reading.name);
  for (const JointField& field : kJointFields) names.emplace_back(field.name);
  return names;
}

int joint_index(lua_State* L) {
  const World& world = *script_with_world(L, "joint").world;
  const JointId joint = joint_self(L);
  const std::string key = text_argument(L, 2, "joint", "field");
  if (key == "remove" || key == "set_speed") {
    lua_pushcfunction(L, key == "remove" ? guarded<joint_remove> : guarded<joint_set_speed>);
    return 1;
  }
  const bool alive = world.alive(joint);
  if (key == "alive") {
    lua_pushboolean(L, alive);
    return 1;
  }
  if (!alive) throw std::invalid_argument("joint: \"" + key + "\" of a joint that was removed or broke");
  for (const JointReading& reading : kJointReadings) {
    if (key != reading.name) continue;
    lua_pushnumber(L, reading.get(world, joint));
    return 1;
  }
  for (const JointField& field : kJointFields) {
    if (key != field.name) continue;
    const double value = field.get(world.joints()[joint.index]);
    if (std::isnan(value))
      lua_pushnil(L);
    else
      lua_pushnumber(L, value);
    return 1;
  }
  throw std::invalid_argument("joint: no field \"" + key + '"' + suggestion(key, joint_names()));
}

int joint_newindex(lua_State* L) {
  World& world = *script_to_change(L, "joint").world;
  const JointId joint = joint_self(L);
  const std::string key = text_argument(L, 2, "joint", "field");
  std::vector<std::string> settable;
  for (const JointField& field : kJointFields) {
    settable.emplace_back(field.name);
    if (key != field.name) continue;
    if (!world.alive(joint))
      throw std::invalid_argument("joint: \"" + key + "\" of a joint that was removed or broke");
    JointDef def = world.joints()[joint.index].def;
    std::optional<double> value;
    // A largest force may be none.
    const bool endless =
        field.may_be_endless && lua_type(L, 3) == LUA_TNUMBER && lua_tonumber(L, 3) == kInfinity;
    if (endless)
      value = kInfinity;
    else if (!field.optional || !lua_isnil(L, 3))
      value = number_argument(L, 3, "joint", key);
    field.set(def, value);
    world.set_joint(joint, def);
    return 0;
  }
  throw std::invalid_argument("joint: \"" + key + "\" cannot be set; these can: " + join(settable));
}

}  // namespace

void add_joint_functions(lua_State* state) {
  luaL_newmetatable(state, kJointType);
  lua_pushcfunction(state, guarded<joint_index>);
  lua_setfield(state, -2, "__index");
  lua_pushcfunction(state, guarded<joint_newindex>);
  lua_setfield(state, -2, "__newindex");
  lua_pop(state, 1);
  const luaL_Reg functions[] = {
      {"rod", guarded<rod>},     {"rope", guarded<rope>},     {"spring", guarded<spring>},
      {"hinge", guarded<hinge>}, {"slider", guarded<slider>}, {"weld", guarded<weld>},
      {"wheel", guarded<wheel>}, {"motor", guarded<motor>},   {"gear", guarded<gear>},
      {"rack", guarded<rack>},   {"pulley", guarded<pulley>}};
  for (const luaL_Reg& entry : functions) lua_register(state, entry.name, entry.func);
}

}  // namespace skerry::sandbox
