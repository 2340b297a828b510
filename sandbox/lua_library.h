// SPDX-License-Identifier: MIT
//
// The part of Lua's standard library that demos get.
#pragma once

#include <lua.hpp>

namespace skerry::sandbox {

/// Sets the globals of a fresh state: `assert error ipairs pairs print select tonumber tostring type`, most
/// of `math`, `table` and `string`. Called through `lua_pcall`.
int open_safe_library(lua_State* state);

}  // namespace skerry::sandbox
