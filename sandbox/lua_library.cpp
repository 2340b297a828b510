// SPDX-License-Identifier: MIT
#include "sandbox/lua_library.h"

#include <string>

#include "physics/math.h"
#include "sandbox/lua_host.h"

namespace skerry::sandbox {
namespace {

// --- Deterministic mathematics

int math_sin(lua_State* L) {
  lua_pushnumber(L, sin_cos(luaL_checknumber(L, 1)).sin);
  return 1;
}

int math_cos(lua_State* L) {
  lua_pushnumber(L, sin_cos(luaL_checknumber(L, 1)).cos);
  return 1;
}

int math_tan(lua_State* L) {
  const SinCos sc = sin_cos(luaL_checknumber(L, 1));
  lua_pushnumber(L, sc.sin / sc.cos);
  return 1;
}

// random(): [0, 1); random(n): 1 to n; random(a, b): a to b.
int math_random(lua_State* L) {
  LuaHost& host = LuaHost::of(L);
  lua_Integer low = 1;
  lua_Integer high = 0;
  switch (lua_gettop(L)) {
    case 0:
      lua_pushnumber(L, host.random());
      return 1;
    case 1:
      high = luaL_checkinteger(L, 1);
      break;
    default:
      low = luaL_checkinteger(L, 1);
      high = luaL_checkinteger(L, 2);
  }
  if (low > high) return luaL_error(L, "random: empty interval from %I to %I", low, high);
  const std::uint64_t range = static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low);
  std::uint64_t bits = host.random_bits();
  if (range != ~std::uint64_t{0}) {
    // Draw again where the last, incomplete multiple of the range begins; otherwise low numbers are likelier.
    const std::uint64_t count = range + 1;
    const std::uint64_t reject = (0 - count) % count;
    while (bits < reject) bits = host.random_bits();
    bits %= count;
  }
  const std::uint64_t chosen = static_cast<std::uint64_t>(low) + bits;  // wraps around for negative ones
  lua_pushinteger(L, static_cast<lua_Integer>(chosen));
  return 1;
}

// --- pairs in sorted order

// Numbers before strings before the rest; the rest (booleans) by type.
bool key_less(lua_State* L, int a, int b) {
  const int type_a = lua_type(L, a);
  const int type_b = lua_type(L, b);
  const auto rank = [](int type) { return type == LUA_TNUMBER ? 0 : type == LUA_TSTRING ? 1 : 2; };
  if (rank(type_a) != rank(type_b)) return rank(type_a) < rank(type_b);
  if (rank(type_a) < 2) return lua_compare(L, a, b, LUA_OPLT) != 0;
  return type_a == LUA_TBOOLEAN && type_b == LUA_TBOOLEAN && lua_toboolean(L, a) < lua_toboolean(L, b);
}

// Upvalues: the table, the sorted keys, the position.
int next_sorted(lua_State* L) {
  lua_Integer i = lua_tointeger(L, lua_upvalueindex(3));
  for (;;) {
    lua_pushinteger(L, ++i);
    lua_copy(L, -1, lua_upvalueindex(3));
    lua_pop(L, 1);
    if (lua_rawgeti(L, lua_upvalueindex(2), i) == LUA_TNIL) return 1;
    lua_pushvalue(L, -1);
    if (lua_rawget(L, lua_upvalueindex(1)) != LUA_TNIL) return 2;
    lua_pop(L, 2);  // removed during the walk
  }
}

int sorted_pairs(lua_State* L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  lua_settop(L, 1);
  lua_newtable(L);
  lua_Integer count = 0;
  for (lua_pushnil(L); lua_next(L, 1) != 0;) {
    const int type = lua_type(L, -2);
    if (type != LUA_TNUMBER && type != LUA_TSTRING && type != LUA_TBOOLEAN)
      return luaL_error(L, "pairs: keys are numbers, strings or booleans, got a %s (it has no fixed order)",
                        lua_typename(L, type));
    lua_pop(L, 1);
    lua_pushvalue(L, -1);
    lua_rawseti(L, 2, ++count);
  }
  // Heap sort in place in the Lua table: no copy of the keys outside Lua's own memory limit.
  const auto swap = [L](lua_Integer a, lua_Integer b) {
    lua_rawgeti(L, 2, a);
    lua_rawgeti(L, 2, b);
    lua_rawseti(L, 2, a);
    lua_rawseti(L, 2, b);
  };
  const auto less = [L](lua_Integer a, lua_Integer b) {
    lua_rawgeti(L, 2, a);
    lua_rawgeti(L, 2, b);
    const bool result = key_less(L, -2, -1);
    lua_pop(L, 2);
    return result;
  };
  const auto sift = [&](lua_Integer root, lua_Integer end) {
    for (lua_Integer child; (child = 2 * root) <= end; root = child) {
      if (child < end && less(child, child + 1)) ++child;
      if (!less(root, child)) return;
      swap(root, child);
    }
  };
  for (lua_Integer root = count / 2; root >= 1; --root) sift(root, count);
  for (lua_Integer end = count; end > 1; --end) {
    swap(1, end);
    sift(1, end - 1);
  }
  lua_pushinteger(L, 0);
  lua_pushcclosure(L, next_sorted, 3);
  return 1;
}

// --- Text

// The stock one prints the address of tables and functions, which differs from run to run.
int safe_tostring(lua_State* L) {
  luaL_checkany(L, 1);
  const int type = lua_type(L, 1);
  const bool plain = type == LUA_TTABLE || type == LUA_TFUNCTION || type == LUA_TTHREAD;
  if (plain)
    lua_pushstring(L, lua_typename(L, type));
  else
    luaL_tolstring(L, 1, nullptr);
  return 1;
}

int print_line(lua_State* L) {
  std::string line;
  for (int i = 1, count = lua_gettop(L); i <= count; ++i) {
    lua_pushcfunction(L, safe_tostring);
    lua_pushvalue(L, i);
    lua_call(L, 1, 1);
    std::size_t size = 0;
    const char* text = lua_tolstring(L, -1, &size);
    if (i > 1) line += '\t';
    line.append(text, size);
    lua_pop(L, 1);
  }
  LuaHost::of(L).print(line);
  return 0;
}

// The stock one takes n turns for an empty result, which the instruction limit does not see.
int string_rep(lua_State* L) {
  std::size_t size = 0;
  std::size_t separator_size = 0;
  const char* text = luaL_checklstring(L, 1, &size);
  const lua_Integer count = luaL_checkinteger(L, 2);
  const char* separator = luaL_optlstring(L, 3, "", &separator_size);
  constexpr lua_Integer kMost = 1 << 24;
  if (count > kMost) return luaL_error(L, "rep: at most %I repetitions, got %I", kMost, count);
  luaL_Buffer buffer;
  luaL_buffinit(L, &buffer);
  for (lua_Integer i = 0; i < count; ++i) {
    if (i > 0) luaL_addlstring(&buffer, separator, separator_size);
    luaL_addlstring(&buffer, text, size);
  }
  luaL_pushresult(&buffer);
  return 1;
}

// Removes everything from the table at the top that is not in `names`.
void keep_only(lua_State* L, std::initializer_list<const char*> names) {
  lua_newtable(L);
  for (const char* name : names) {
    lua_getfield(L, -2, name);
    lua_setfield(L, -2, name);
  }
  lua_remove(L, -2);
}

}  // namespace

int open_safe_library(lua_State* L) {
  // Base functions, in a new table that then becomes the table of globals.
  luaL_requiref(L, LUA_GNAME, luaopen_base, 1);
  keep_only(L, {"assert", "error", "ipairs", "select", "tonumber", "type"});
  lua_pushliteral(L, LUA_VERSION);
  lua_setfield(L, -2, "_VERSION");
  const luaL_Reg base[] = {
      {"pairs", sorted_pairs}, {"print", print_line}, {"tostring", safe_tostring}, {nullptr, nullptr}};
  luaL_setfuncs(L, base, 0);

  luaL_requiref(L, LUA_MATHLIBNAME, luaopen_math, 0);
  keep_only(L, {"abs",  "acos", "asin", "atan",      "ceil",       "deg", "exp",        "floor",
                "fmod", "huge", "log",  "max",       "maxinteger", "min", "mininteger", "modf",
                "pi",   "rad",  "sqrt", "tointeger", "type",       "ult"});
  const luaL_Reg math[] = {
      {"sin", math_sin}, {"cos", math_cos}, {"tan", math_tan}, {"random", math_random}, {nullptr, nullptr}};
  luaL_setfuncs(L, math, 0);
  lua_setfield(L, -2, LUA_MATHLIBNAME);

  luaL_requiref(L, LUA_TABLIBNAME, luaopen_table, 0);
  keep_only(L, {"concat", "insert", "pack", "remove", "sort", "unpack"});
  lua_setfield(L, -2, LUA_TABLIBNAME);

  luaL_requiref(L, LUA_STRLIBNAME, luaopen_string, 0);
  keep_only(L, {"byte", "char", "format", "len", "lower", "reverse", "sub", "upper"});
  lua_pushcfunction(L, string_rep);
  lua_setfield(L, -2, "rep");
  // ("x"):rep(3) finds its method through the metatable of strings: give it the same short list.
  lua_pushliteral(L, "");
  lua_getmetatable(L, -1);
  lua_pushvalue(L, -3);
  lua_setfield(L, -2, "__index");
  lua_pop(L, 2);
  lua_setfield(L, -2, LUA_STRLIBNAME);

  // The old globals and the registry of loaded modules go.
  lua_pushvalue(L, -1);
  lua_setfield(L, -2, "_G");
  lua_rawseti(L, LUA_REGISTRYINDEX, LUA_RIDX_GLOBALS);
  lua_pushnil(L);
  lua_setfield(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
  return 0;
}

}  // namespace skerry::sandbox
