// SPDX-License-Identifier: MIT
#include "sandbox/lua_host.h"

#include <cstring>

#include "sandbox/errors.h"
#include "sandbox/lua_library.h"

namespace skerry::sandbox {
namespace {

constexpr int kHookInterval = 1000;  // instructions between two looks at the budget; costs under 1 %

std::uint64_t rotate_left(std::uint64_t x, int k) {
  return (x << k) | (x >> (64 - k));
}

// SplitMix64 spreads a small seed over the whole state [Steele, Lea, Flood 2014].
std::uint64_t split_mix(std::uint64_t& x) {
  x += 0x9e3779b97f4a7c15u;
  std::uint64_t z = x;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

// Handler of errors: what functions of the library do not allow (ipairs(nil)), and what `assert` says, comes
// without a place. It gets that of the innermost line of the script.
int add_place(lua_State* state) {
  lua_Debug info;
  if (lua_type(state, 1) != LUA_TSTRING) return 1;
  for (int level = 0; lua_getstack(state, level, &info) != 0; ++level) {
    lua_getinfo(state, "Sl", &info);
    if (info.currentline <= 0) continue;
    const std::string_view message = lua_tostring(state, 1), file = info.short_src;
    if (message.substr(0, file.size()) != file)
      lua_pushfstring(state, "%s:%d: %s", info.short_src, info.currentline, lua_tostring(state, 1));
    break;
  }
  return 1;
}

std::string quantity(std::uint64_t n) {
  return n >= 1'000'000 ? std::to_string(n / 1'000'000) + " million" : std::to_string(n);
}

}  // namespace

LuaHost::LuaHost(std::string path, std::uint64_t seed, LuaLimits limits)
    : path_(std::move(path)), limits_(limits), arena_(limits.memory) {
  for (std::uint64_t& word : random_) word = split_mix(seed);
  state_ = lua_newstate(&LuaHost::allocate, this);
  if (!state_) throw ScriptError(path_ + ": no memory for a Lua state");
  *static_cast<LuaHost**>(lua_getextraspace(state_)) = this;
  lua_sethook(state_, &LuaHost::count_hook, LUA_MASKCOUNT, kHookInterval);
  left_ = limits_.load_instructions;
  lua_pushcfunction(state_, &open_safe_library);
  if (lua_pcall(state_, 0, 0, 0) != LUA_OK) {
    lua_close(state_);
    throw ScriptError(path_ + ": the Lua library does not fit into " + std::to_string(limits_.memory) +
                      " bytes");
  }
}

LuaHost::~LuaHost() {
  lua_close(state_);
}

LuaHost& LuaHost::of(lua_State* state) {
  return **static_cast<LuaHost**>(lua_getextraspace(state));
}

void* LuaHost::allocate(void* host, void* block, std::size_t old_size, std::size_t new_size) {
  LuaHost& self = *static_cast<LuaHost*>(host);
  if (!block) old_size = 0;  // then Lua passes the kind of object in its place
  if (new_size == 0) {
    self.arena_.resize(block, old_size, 0);
    self.used_ -= old_size;
    return nullptr;
  }
  if (new_size > old_size && self.used_ + (new_size - old_size) > self.limits_.memory) return nullptr;
  void* result = self.arena_.resize(block, old_size, new_size);
  if (result) self.used_ += new_size - old_size;
  return result;
}

void LuaHost::count_hook(lua_State* state, lua_Debug* info) {
  LuaHost& self = of(state);
  if (self.left_ > kHookInterval) {
    self.left_ -= kHookInterval;
    return;
  }
  self.left_ = 0;
  lua_getinfo(state, "Sl", info);
  lua_pushfstring(
      state,
      "%s:%d: the script runs for too long (limits: %s instructions to load, %s a callback; a body "
      "or a joint counts %s)",
      info->short_src, info->currentline, quantity(self.limits_.load_instructions).c_str(),
      quantity(self.limits_.call_instructions).c_str(), quantity(kInstructionsOfABody).c_str());
  lua_error(state);
}

void LuaHost::run(std::string_view source) {
  const std::string chunk = "@" + path_;
  if (luaL_loadbufferx(state_, source.data(), source.size(), chunk.c_str(), "t") != LUA_OK) fail_with_top();
  protected_call(0, 0, limits_.load_instructions);
}

void LuaHost::call(int function, int results) {
  lua_rawgeti(state_, LUA_REGISTRYINDEX, function);
  protected_call(0, results, limits_.call_instructions);
}

void LuaHost::call(int function, int results, const std::function<int(lua_State*)>& push) {
  luaL_checkstack(state_, 16, "callback");
  lua_rawgeti(state_, LUA_REGISTRYINDEX, function);
  const int arguments = push(state_);
  protected_call(arguments, results, limits_.call_instructions);
}

void LuaHost::protected_call(int arguments, int results, std::uint64_t budget) {
  left_ = budget;
  const int handler = lua_gettop(state_) - arguments;
  lua_pushcfunction(state_, &add_place);
  lua_insert(state_, handler);
  if (lua_pcall(state_, arguments, results, handler) != LUA_OK) fail_with_top();
  lua_remove(state_, handler);
}

void LuaHost::fail_with_top() {
  // A thrown table or nil has no text; say at least its type.
  std::string message = lua_type(state_, -1) == LUA_TSTRING
                            ? std::string(lua_tostring(state_, -1))
                            : std::string("error of type ") + luaL_typename(state_, -1);
  lua_settop(state_, 0);
  // Lua shortens long file names to "...end/of/path.lua"; people need the whole.
  if (message.rfind("...", 0) == 0) {
    const std::size_t end = message.find(".lua:");
    if (end != std::string::npos) message = path_ + message.substr(end + 4);
  }
  if (message == "not enough memory")
    message = path_ + ": the script needs more than " + std::to_string(limits_.memory >> 20) + " MiB";
  if (message.rfind(path_, 0) != 0) message = path_ + ": " + message;
  throw ScriptError(message);
}

double LuaHost::random() {
  return static_cast<double>(random_bits() >> 11) * 0x1.0p-53;
}

// xoshiro256** [Blackman & Vigna 2021].
std::uint64_t LuaHost::random_bits() {
  const std::uint64_t result = rotate_left(random_[1] * 5, 7) * 9;
  const std::uint64_t t = random_[1] << 17;
  random_[2] ^= random_[0];
  random_[3] ^= random_[1];
  random_[1] ^= random_[2];
  random_[0] ^= random_[3];
  random_[2] ^= t;
  random_[3] = rotate_left(random_[3], 45);
  return result;
}

void LuaHost::restore(const LuaImage& image) {
  arena_.restore(image.arena);
  used_ = image.used;
  random_ = image.random;
}

void LuaHost::print(std::string_view line) {
  if (print_) print_(line);
}

}  // namespace skerry::sandbox
