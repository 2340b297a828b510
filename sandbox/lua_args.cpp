// SPDX-License-Identifier: MIT
#include "sandbox/lua_args.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "sandbox/lua_host.h"
#include "sandbox/names.h"

namespace skerry::sandbox {

std::string format_number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string describe(lua_State* L, int index) {
  switch (lua_type(L, index)) {
    case LUA_TNONE:
    case LUA_TNIL:
      return "nothing";
    case LUA_TNUMBER:
      return "the number " + format_number(lua_tonumber(L, index));
    case LUA_TSTRING:
      return "the string \"" + std::string(lua_tostring(L, index)) + '"';
    case LUA_TBOOLEAN:
      return lua_toboolean(L, index) ? "true" : "false";
    case LUA_TTABLE: {
      const std::size_t count = lua_rawlen(L, index);
      return count > 0 ? "a table of " + std::to_string(count) : "a table";
    }
    case LUA_TUSERDATA:
      return to_body(L, index) ? "a body" : "an object";
    default:
      return std::string("a ") + luaL_typename(L, index);
  }
}

std::string script_place(lua_State* L) {
  lua_Debug info;
  if (!lua_getstack(L, 1, &info) || !lua_getinfo(L, "l", &info)) return LuaHost::of(L).path();
  return LuaHost::of(L).path() + ':' + std::to_string(info.currentline);
}

std::optional<Vec2> to_pair(lua_State* L, int index) {
  index = lua_absindex(L, index);
  if (lua_type(L, index) != LUA_TTABLE || lua_rawlen(L, index) != 2) return {};
  lua_rawgeti(L, index, 1);
  lua_rawgeti(L, index, 2);
  const bool numbers = lua_type(L, -2) == LUA_TNUMBER && lua_type(L, -1) == LUA_TNUMBER;
  const Vec2 pair{lua_tonumber(L, -2), lua_tonumber(L, -1)};
  lua_pop(L, 2);
  if (!numbers || !is_finite(pair)) return {};
  return pair;
}

double number_argument(lua_State* L, int index, std::string_view function, std::string_view what) {
  if (lua_type(L, index) != LUA_TNUMBER || !std::isfinite(lua_tonumber(L, index)))
    throw std::invalid_argument(std::string(function) + ": " + std::string(what) +
                                " expected a finite number, got " + describe(L, index));
  return lua_tonumber(L, index);
}

std::string text_argument(lua_State* L, int index, std::string_view function, std::string_view what) {
  if (lua_type(L, index) != LUA_TSTRING)
    throw std::invalid_argument(std::string(function) + ": " + std::string(what) +
                                " expected a string, got " + describe(L, index));
  return lua_tostring(L, index);
}

int function_argument(lua_State* L, int index, std::string_view function, std::string_view what) {
  if (lua_type(L, index) != LUA_TFUNCTION)
    throw std::invalid_argument(std::string(function) + ": " + std::string(what) +
                                " expected a function, got " + describe(L, index));
  lua_pushvalue(L, index);
  return luaL_ref(L, LUA_REGISTRYINDEX);
}

Args::Args(lua_State* L, std::string function, const std::vector<std::string>& allowed, int index)
    : state_(L), function_(std::move(function)), index_(index) {
  if (lua_type(L, index) != LUA_TTABLE)
    throw std::invalid_argument(function_ + ": expected a table, as in " + function_ + "{ " +
                                allowed.front() + " = ... }, got " + describe(L, index));
  for (lua_pushnil(L); lua_next(L, index) != 0; lua_pop(L, 1)) {
    if (lua_type(L, -2) != LUA_TSTRING)
      throw std::invalid_argument(function_ + ": the arguments have names, as in " + allowed.front() +
                                  " = ...; got one without: " + describe(L, -1));
    const std::string key = lua_tostring(L, -2);
    if (std::find(allowed.begin(), allowed.end(), key) == allowed.end())
      throw std::invalid_argument(function_ + ": no argument \"" + key + '"' + suggestion(key, allowed));
  }
}

void Args::fail(const char* key, std::string_view expected, int got_index) const {
  throw std::invalid_argument(function_ + ": " + key + " expected " + std::string(expected) + ", got " +
                              describe(state_, got_index));
}

bool Args::has(const char* key) const {
  const bool present = lua_getfield(state_, index_, key) != LUA_TNIL;
  lua_pop(state_, 1);
  return present;
}

std::optional<double> Args::number(const char* key) const {
  const int type = lua_getfield(state_, index_, key);
  const double value = lua_tonumber(state_, -1);
  if (type != LUA_TNIL && (type != LUA_TNUMBER || !std::isfinite(value))) fail(key, "a finite number", -1);
  lua_pop(state_, 1);
  if (type == LUA_TNIL) return {};
  return value;
}

double Args::required_number(const char* key) const {
  const std::optional<double> value = number(key);
  if (!value) throw std::invalid_argument(function_ + ": " + key + " expected a number, got nothing");
  return *value;
}

std::optional<double> Args::number_from(const char* key, double least) const {
  const std::optional<double> value = number(key);
  if (value && *value < least)
    throw std::invalid_argument(function_ + ": " + key + " must be at least " + format_number(least) +
                                ", got " + format_number(*value));
  return value;
}

std::optional<Vec2> Args::pair(const char* key, const char* form) const {
  const int type = lua_getfield(state_, index_, key);
  const std::optional<Vec2> value = to_pair(state_, -1);
  if (type != LUA_TNIL && !value) fail(key, form, -1);
  lua_pop(state_, 1);
  return value;
}

Vec2 Args::required_pair(const char* key, const char* form) const {
  const std::optional<Vec2> value = pair(key, form);
  if (!value) throw std::invalid_argument(function_ + ": " + key + " expected " + form + ", got nothing");
  return *value;
}

std::vector<Vec2> Args::points(const char* key) const {
  std::vector<Vec2> result;
  if (lua_getfield(state_, index_, key) != LUA_TTABLE) fail(key, "a list of points {{x, y}, ...}", -1);
  const int list = lua_gettop(state_);
  for (lua_Unsigned i = 1; i <= lua_rawlen(state_, list); ++i) {
    lua_rawgeti(state_, list, static_cast<lua_Integer>(i));
    const std::optional<Vec2> point = to_pair(state_, -1);
    if (!point) fail((std::string(key) + "[" + std::to_string(i) + "]").c_str(), "{x, y}", -1);
    result.push_back(*point);
    lua_pop(state_, 1);
  }
  lua_pop(state_, 1);
  return result;
}

std::optional<std::string> Args::text(const char* key) const {
  const int type = lua_getfield(state_, index_, key);
  if (type != LUA_TNIL && type != LUA_TSTRING) fail(key, "a string", -1);
  std::optional<std::string> value;
  if (type == LUA_TSTRING) value = lua_tostring(state_, -1);
  lua_pop(state_, 1);
  return value;
}

std::optional<bool> Args::flag(const char* key) const {
  const int type = lua_getfield(state_, index_, key);
  if (type != LUA_TNIL && type != LUA_TBOOLEAN) fail(key, "true or false", -1);
  std::optional<bool> value;
  if (type == LUA_TBOOLEAN) value = lua_toboolean(state_, -1) != 0;
  lua_pop(state_, 1);
  return value;
}

int Args::callback(const char* key) const {
  const int type = lua_getfield(state_, index_, key);
  if (type != LUA_TNIL && type != LUA_TFUNCTION) fail(key, "a function", -1);
  if (type == LUA_TFUNCTION) return luaL_ref(state_, LUA_REGISTRYINDEX);
  lua_pop(state_, 1);
  return 0;
}

std::optional<BodyId> Args::body(const char* key) const {
  const int type = lua_getfield(state_, index_, key);
  const std::optional<BodyId> value = to_body(state_, -1);
  if (type != LUA_TNIL && !value) fail(key, "a body", -1);
  lua_pop(state_, 1);
  return value;
}

std::optional<std::vector<BodyId>> Args::bodies(const char* key) const {
  if (lua_getfield(state_, index_, key) == LUA_TNIL) {
    lua_pop(state_, 1);
    return {};
  }
  const int list = lua_gettop(state_);
  if (lua_type(state_, list) != LUA_TTABLE) fail(key, "a list of bodies", list);
  std::vector<BodyId> found;
  for (lua_Unsigned i = 1; i <= lua_rawlen(state_, list); ++i) {
    lua_rawgeti(state_, list, static_cast<lua_Integer>(i));
    const std::optional<BodyId> body = to_body(state_, -1);
    if (!body) fail((std::string(key) + '[' + std::to_string(i) + ']').c_str(), "a body", lua_gettop(state_));
    found.push_back(*body);
    lua_pop(state_, 1);
  }
  lua_pop(state_, 1);
  return found;
}

}  // namespace skerry::sandbox
