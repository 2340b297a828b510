// SPDX-License-Identifier: MIT
//
// A Lua 5.4 state in which a demo script can do no harm and always does the same.
//
// There is no io, os, package, debug, coroutine or load, no pattern matching (its worst case is exponential
// and cannot be interrupted), no metatables (finalizers run without the instruction limit). Memory and
// instructions are limited. `math.random` is a generator of our own with the caller's seed, `math.sin`, `cos`
// and `tan` give the same bits on every machine, and `pairs` goes in sorted order. The library is the C++
// build of Lua: errors are C++ exceptions and run destructors.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <lua.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "sandbox/lua_arena.h"

namespace skerry::sandbox {

/// What a body or a joint counts, of the instructions.
inline constexpr std::uint64_t kInstructionsOfABody = 400;

struct LuaLimits {
  std::size_t memory = 64u << 20;                 ///< [bytes] of all Lua objects together
  std::uint64_t load_instructions = 200'000'000;  ///< virtual machine instructions to run the script
  std::uint64_t call_instructions = 20'000'000;   ///< of one callback
};

/// All variables of a script at a moment, and where its random numbers were.
struct LuaImage {
  LuaArenaImage arena;
  std::size_t used = 0;
  std::array<std::uint64_t, 4> random{};
};

class LuaHost {
 public:
  /// @param path as it shall appear in messages. @param seed of `math.random`.
  LuaHost(std::string path, std::uint64_t seed, LuaLimits limits = {});
  ~LuaHost();
  LuaHost(const LuaHost&) = delete;
  LuaHost& operator=(const LuaHost&) = delete;

  lua_State* state() const { return state_; }
  const std::string& path() const { return path_; }

  /// Compiles and runs `source`. @throws ScriptError `file:line: ...`
  void run(std::string_view source);
  /// Calls the function kept under registry reference `function`, which leaves `results` values on the stack.
  /// @throws ScriptError
  void call(int function, int results);
  /// Calls with arguments: `push` puts them on the stack and returns their number.
  void call(int function, int results, const std::function<int(lua_State*)>& push);

  /// Where printed lines go; without it they are dropped.
  void on_print(std::function<void(std::string_view)> sink) { print_ = std::move(sink); }
  /// Bytes held by Lua objects now.
  std::size_t memory() const { return used_; }
  /// A number in [0, 1) of the script's generator, and its 64 bits.
  double random();
  std::uint64_t random_bits();

  /// Copies the state of the script; not from within a call.
  LuaImage save() const { return {arena_.save(), used_, random_}; }
  /// Goes back to an image of this host.
  void restore(const LuaImage& image);

  /// The host of a state, for C functions.
  static LuaHost& of(lua_State* state);
  /// What a script may use again: the C++ object that `attach` stored, or null.
  void attach(void* context) { context_ = context; }
  void* context() const { return context_; }
  /// Counts instructions for what is kept outside of Lua, as the world keeps bodies: a loop without an end
  /// would fill the machine before it has used its own.
  void spend(std::uint64_t instructions) { left_ -= std::min(left_, instructions); }
  /// Passes one printed line on.
  void print(std::string_view line);

 private:
  static void* allocate(void* host, void* block, std::size_t old_size, std::size_t new_size);
  static void count_hook(lua_State* state, lua_Debug* info);
  void protected_call(int arguments, int results, std::uint64_t budget);
  [[noreturn]] void fail_with_top();

  std::string path_;
  LuaLimits limits_;
  std::size_t used_ = 0;
  std::uint64_t left_ = 0;  ///< instructions
  std::array<std::uint64_t, 4> random_{};
  LuaArena arena_;
  std::function<void(std::string_view)> print_;
  void* context_ = nullptr;
  lua_State* state_ = nullptr;
};

}  // namespace skerry::sandbox
