// SPDX-License-Identifier: MIT
#include "sandbox/lua_library.h"

#include <algorithm>
#include <cstring>
#include <limits>
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

// --- Lists in order

/// Merge sort of the list at `list`: what is equal keeps its order. Its memory is the script's own.
/// @param less(a, b)  whether the value at stack index a goes before that at b; leaves the stack as it was
template <class Less>
void sort_list(lua_State* L, int list, lua_Integer count, Less less) {
  luaL_checkstack(L, 8, "sort");
  const int top = lua_gettop(L);
  lua_createtable(L, static_cast<int>(std::min<lua_Integer>(count, std::numeric_limits<int>::max())), 0);
  int from = list, to = top + 1;
  for (lua_Integer width = 1; width < count; width *= 2) {
    for (lua_Integer low = 0; low < count; low += 2 * width) {
      const lua_Integer middle = std::min(low + width, count), end = std::min(low + 2 * width, count);
      lua_Integer left = low, right = middle;
      for (lua_Integer k = low; k < end; ++k) {
        bool second = left == middle;
        if (!second && right < end) {
          lua_rawgeti(L, from, right + 1);
          lua_rawgeti(L, from, left + 1);
          second = less(top + 2, top + 3);
          lua_settop(L, top + 1);
        }
        lua_rawgeti(L, from, (second ? right++ : left++) + 1);
        lua_rawseti(L, to, k + 1);
      }
    }
    std::swap(from, to);
  }
  for (lua_Integer k = 1; from != list && k <= count; ++k) {
    lua_rawgeti(L, from, k);
    lua_rawseti(L, list, k);
  }
  lua_settop(L, top);
}

// sort(list [, less]). The stock one picks pivots by the clock where a list is long and lopsided: then what
// is equal is in another order in each run.
int table_sort(lua_State* L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  const bool by_function = !lua_isnoneornil(L, 2);
  if (by_function) luaL_checktype(L, 2, LUA_TFUNCTION);
  lua_settop(L, 2);
  sort_list(L, 1, static_cast<lua_Integer>(lua_rawlen(L, 1)), [&](int a, int b) {
    if (!by_function) {
      // Asked from C, the stock comparison would refuse them without a line.
      const int type = lua_type(L, a), other = lua_type(L, b);
      if (type != other || (type != LUA_TNUMBER && type != LUA_TSTRING))
        luaL_error(L, "sort: attempt to compare %s with %s", lua_typename(L, type), lua_typename(L, other));
      return lua_compare(L, a, b, LUA_OPLT) != 0;
    }
    lua_pushvalue(L, 2);
    lua_pushvalue(L, a);
    lua_pushvalue(L, b);
    lua_call(L, 2, 1);
    return lua_toboolean(L, -1) != 0;
  });
  return 0;
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
  sort_list(L, 2, count, [L](int a, int b) { return key_less(L, a, b); });
  lua_pushinteger(L, 0);
  lua_pushcclosure(L, next_sorted, 3);
  return 1;
}

int next_in_list(lua_State* L) {
  const lua_Integer i = lua_tointeger(L, 2) + 1;
  lua_pushinteger(L, i);
  return lua_geti(L, 1, i) == LUA_TNIL ? 1 : 2;
}

// The stock one takes anything, and fails at the first step with what it could not index.
int list_pairs(lua_State* L) {
  luaL_checktype(L, 1, LUA_TTABLE);
  lua_pushcfunction(L, next_in_list);
  lua_pushvalue(L, 1);
  lua_pushinteger(L, 0);
  return 3;
}

// --- Text

// The stock one prints the address of tables, functions and objects, which differs from run to run.
int safe_tostring(lua_State* L) {
  luaL_checkany(L, 1);
  const int type = lua_type(L, 1);
  const bool plain = type == LUA_TTABLE || type == LUA_TFUNCTION || type == LUA_TTHREAD;
  if (plain)
    lua_pushstring(L, lua_typename(L, type));
  else if (type == LUA_TUSERDATA && luaL_getmetafield(L, 1, "__tostring") == LUA_TNIL)
    luaL_getmetafield(L, 1, "__name");
  else
    luaL_tolstring(L, 1, nullptr);
  return 1;
}

// format(form, ...): no addresses either. The stock one is upvalue 1.
int string_format(lua_State* L) {
  const char* form = luaL_checkstring(L, 1);
  const int count = lua_gettop(L);
  int argument = 1;
  while ((form = std::strchr(form, '%')) != nullptr) {
    form += 1 + std::strspn(form + 1, "-+ #0123456789.");
    if (*form == 'p') return luaL_error(L, "format: %%p is not there: addresses differ from run to run");
    if (*form == '\0') break;
    if (*form++ == '%' || ++argument > count || form[-1] != 's') continue;
    lua_pushcfunction(L, safe_tostring);
    lua_pushvalue(L, argument);
    lua_call(L, 1, 1);
    lua_replace(L, argument);
  }
  // As if the script had called it: its errors name the line and the function.
  return lua_tocfunction(L, lua_upvalueindex(1))(L);
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
  keep_only(L, {"assert", "error", "select", "tonumber", "type"});
  lua_pushliteral(L, LUA_VERSION);
  lua_setfield(L, -2, "_VERSION");
  const luaL_Reg base[] = {{"pairs", sorted_pairs},
                           {"ipairs", list_pairs},
                           {"print", print_line},
                           {"tostring", safe_tostring},
                           {nullptr, nullptr}};
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
  keep_only(L, {"concat", "insert", "pack", "remove", "unpack"});
  lua_pushcfunction(L, table_sort);
  lua_setfield(L, -2, "sort");
  lua_setfield(L, -2, LUA_TABLIBNAME);

  luaL_requiref(L, LUA_STRLIBNAME, luaopen_string, 0);
  keep_only(L, {"byte", "char", "format", "len", "lower", "reverse", "sub", "upper"});
  lua_getfield(L, -1, "format");
  lua_pushcclosure(L, string_format, 1);
  lua_setfield(L, -2, "format");
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
