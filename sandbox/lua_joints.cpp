// SPDX-License-Identifier: MIT
//
// Script functions that join bodies (rod, rope, hinge), and the joint object.
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
  const JointId joint = script.world->create_joint(def);
  *static_cast<JointId*>(lua_newuserdatauv(L, sizeof(JointId), 0)) = joint;
  luaL_setmetatable(L, kJointType);
  return 1;
}

int line_joint(lua_State* L, const char* function, JointKind kind) {
  static const std::vector<std::string> keys{"from", "to", "length", "collide"};
  const Args args(L, function, keys);
  Script& script = script_with_world(L, function);
  const End from = read_end(L, args, "from", *script.world);
  const End to = read_end(L, args, "to", *script.world);
  JointDef def;
  def.kind = kind;
  def.a = from.body;
  def.b = to.body;
  def.anchor_a = from.anchor;
  def.anchor_b = to.anchor;
  def.length = args.number("length");
  if (def.length && *def.length <= 0)
    throw std::invalid_argument(std::string(function) + ": length must be positive, got " +
                                format_number(*def.length));
  def.collide = args.flag("collide").value_or(false);
  return push_joint(L, script, def);
}

int rod(lua_State* L) {
  return line_joint(L, "rod", JointKind::Distance);
}

int rope(lua_State* L) {
  return line_joint(L, "rope", JointKind::Rope);
}

// hinge{ a = body, b = body, at = {x, y} }; without b it turns about a fixed point
int hinge(lua_State* L) {
  static const std::vector<std::string> keys{"a", "b", "at", "collide"};
  const Args args(L, "hinge", keys);
  Script& script = script_with_world(L, "hinge");
  const std::optional<BodyId> a = args.body("a");
  if (!a) throw std::invalid_argument("hinge: a expected a body, got nothing");
  JointDef def;
  def.kind = JointKind::Revolute;
  // The ground is the first of the two, as for rods that hang from a point.
  def.b = *a;
  def.a = args.body("b").value_or(BodyId{});
  def.anchor_a = def.anchor_b = args.required_pair("at");
  def.collide = args.flag("collide").value_or(false);
  return push_joint(L, script, def);
}

JointId self(lua_State* L) {
  const void* object = luaL_testudata(L, 1, kJointType);
  if (!object) throw std::invalid_argument("joint: call its methods with a colon, as in rod:remove()");
  return *static_cast<const JointId*>(object);
}

int joint_remove(lua_State* L) {
  World& world = *script_with_world(L, "remove").world;
  const JointId joint = self(L);
  if (world.alive(joint)) world.destroy(joint);
  return 0;
}

int joint_index(lua_State* L) {
  const World& world = *script_with_world(L, "joint").world;
  const JointId joint = self(L);
  const std::string key = text_argument(L, 2, "joint", "field");
  static const std::vector<std::string> names{"force", "fx", "fy", "length", "alive", "remove"};
  if (key == "remove") {
    lua_pushcfunction(L, guarded<joint_remove>);
    return 1;
  }
  const bool alive = world.alive(joint);
  if (key == "alive") {
    lua_pushboolean(L, alive);
    return 1;
  }
  if (!alive) throw std::invalid_argument("joint: \"" + key + "\" of a removed joint");
  const JointRecord& record = world.joints()[joint.index];
  // Mean force on the second body over the last step [N].
  const double h = world.report().h;
  const Vec2 force = h > 0 ? record.impulse / h : Vec2{};
  if (key == "force")
    lua_pushnumber(L, length(force));
  else if (key == "fx")
    lua_pushnumber(L, force.x);
  else if (key == "fy")
    lua_pushnumber(L, force.y);
  else if (key == "length")
    lua_pushnumber(L, record.length);
  else
    throw std::invalid_argument("joint: no field \"" + key + '"' + suggestion(key, names));
  return 1;
}

}  // namespace

void add_joint_functions(lua_State* state) {
  luaL_newmetatable(state, kJointType);
  lua_pushcfunction(state, guarded<joint_index>);
  lua_setfield(state, -2, "__index");
  lua_pop(state, 1);
  const luaL_Reg functions[] = {{"rod", guarded<rod>}, {"rope", guarded<rope>}, {"hinge", guarded<hinge>}};
  for (const luaL_Reg& entry : functions) lua_register(state, entry.name, entry.func);
}

}  // namespace skerry::sandbox
