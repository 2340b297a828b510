// SPDX-License-Identifier: MIT
//
// Reading of script arguments, with messages that name the function, the argument and what was expected.
// Everything here throws std::invalid_argument; `guarded` puts `file:line:` in front and hands it to Lua.
#pragma once

#include <functional>
#include <initializer_list>
#include <lua.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "physics/handle.h"
#include "physics/math.h"

namespace skerry::sandbox {

/// Wraps a function so that its C++ exceptions become Lua errors at the calling line.
template <int (*Function)(lua_State*)>
int guarded(lua_State* state) {
  try {
    return Function(state);
  } catch (const std::exception& error) {
    // Lua's own errors are thrown pointers and pass by here.
    luaL_where(state, 1);
    lua_pushstring(state, error.what());
  }
  lua_concat(state, 2);
  return lua_error(state);
}

/// The table argument of a call like `box{ at = {0, 1}, size = {1, 1} }`.
class Args {
 public:
  /// @param index of the table on the stack. @param allowed keys; others are refused with the nearest name.
  Args(lua_State* state, std::string function, const std::vector<std::string>& allowed, int index = 1);

  bool has(const char* key) const;
  std::optional<double> number(const char* key) const;
  double number(const char* key, double otherwise) const { return number(key).value_or(otherwise); }
  double required_number(const char* key) const;
  /// At least `least`; for sizes, masses and so on whose sign is a frequent slip.
  std::optional<double> number_from(const char* key, double least) const;
  /// @param form how the pair is written, for the message: "{x, y}"
  std::optional<Vec2> pair(const char* key, const char* form = "{x, y}") const;
  Vec2 required_pair(const char* key, const char* form = "{x, y}") const;
  std::vector<Vec2> points(const char* key) const;
  std::optional<std::string> text(const char* key) const;
  std::optional<bool> flag(const char* key) const;
  /// A function, kept in the registry; 0 when absent.
  int callback(const char* key) const;
  std::optional<BodyId> body(const char* key) const;
  /// A list of them.
  std::optional<std::vector<BodyId>> bodies(const char* key) const;

  const std::string& function() const { return function_; }
  int index() const { return index_; }
  /// @throws std::invalid_argument("box: size expected {w, h}, got a number")
  [[noreturn]] void fail(const char* key, std::string_view expected, int got_index) const;

 private:
  lua_State* state_;
  std::string function_;
  int index_;
};

/// The two numbers of the table at `index`, or nothing if it is not such a table.
std::optional<Vec2> to_pair(lua_State* state, int index);
/// A finite number argument by position. @throws std::invalid_argument naming `function` and `what`.
double number_argument(lua_State* state, int index, std::string_view function, std::string_view what);
std::string text_argument(lua_State* state, int index, std::string_view function, std::string_view what);
/// Keeps the function at `index` in the registry.
int function_argument(lua_State* state, int index, std::string_view function, std::string_view what);
/// "a number", "a string", "nothing": with the value where it is short.
std::string describe(lua_State* state, int index);
/// file:line of the running script line.
std::string script_place(lua_State* state);
/// Shortest text of a number that reads well in a message.
std::string format_number(double value);

/// The body object at `index`, or nothing.
std::optional<BodyId> to_body(lua_State* state, int index);
void push_body(lua_State* state, BodyId body);

}  // namespace skerry::sandbox
