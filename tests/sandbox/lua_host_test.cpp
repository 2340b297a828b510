// SPDX-License-Identifier: MIT
#include "sandbox/lua_host.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sandbox/errors.h"

namespace skerry::sandbox {
namespace lua_host_test {

using testing::AnyOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string output_of(const std::string& source, std::uint64_t seed = 1, LuaLimits limits = {}) {
  std::string text;
  LuaHost host("demos/x.lua", seed, limits);
  host.on_print([&](std::string_view line) { text += std::string(line) + '\n'; });
  host.run(source);
  return text;
}

std::string error_of(const std::string& source, LuaLimits limits = {}) {
  try {
    output_of(source, 1, limits);
  } catch (const ScriptError& error) {
    return error.what();
  }
  return "no error";
}

// The stock sort takes pivots by the clock for long lists, and then what is equal is in another order.
TEST(LuaHost, SortKeepsTheOrderOfWhatIsEqual) {
  EXPECT_EQ(
      output_of("local t, calls = {}, 0\n"
                "for i = 1, 3000 do t[i] = { row = (i * 7919) % 13, id = i } end\n"
                "table.sort(t, function(a, b) calls = calls + 1 return a.row < b.row end)\n"
                "local wrong = 0\n"
                "for i = 2, #t do local a, b = t[i - 1], t[i]\n"
                "  if a.row > b.row or (a.row == b.row and a.id > b.id) then wrong = wrong + 1 end end\n"
                "print(wrong, calls < 3000 * 12)"),
      "0\ttrue\n");
  EXPECT_EQ(output_of("local t = {5, 3, 9, 1, 7}\ntable.sort(t)\nprint(table.concat(t, ' '))"),
            "1 3 5 7 9\n");
  EXPECT_EQ(output_of("local t = {'b', 'c', 'a'}\ntable.sort(t, function(x, y) return x > y end)\n"
                      "print(table.concat(t, ' '))"),
            "c b a\n");
  EXPECT_EQ(output_of("for _, n in ipairs{0, 1, 2} do local t = {} for i = 1, n do t[i] = n - i end\n"
                      "table.sort(t) print(table.concat(t, ' ')) end"),
            "\n0\n0 1\n");
  EXPECT_EQ(error_of("\ntable.sort({1, {}, 2})"),
            "demos/x.lua:2: sort: attempt to compare table with number");
  EXPECT_EQ(error_of("\ntable.sort({1, 'a'})"), "demos/x.lua:2: sort: attempt to compare string with number");
  EXPECT_EQ(error_of("\ntable.sort({true, false})"),
            "demos/x.lua:2: sort: attempt to compare boolean with boolean");
  EXPECT_EQ(output_of("local t = {2, 1.5, -3}\ntable.sort(t)\nprint(table.concat(t, ' '))"), "-3 1.5 2\n");
  EXPECT_THAT(error_of("table.sort(3)"), HasSubstr("table expected, got number"));
  EXPECT_THAT(error_of("table.sort({1, 2}, 3)"), HasSubstr("function expected, got number"));
}

TEST(LuaHost, TextShowsNoAddresses) {
  EXPECT_EQ(output_of("print(string.format('%s %5s|%d%% %s', {}, print, 3, 'x'), ('%s'):format(true))"),
            "table function|3% x\ttrue\n");
  EXPECT_THAT(error_of("print(('%p'):format({}))"), HasSubstr("addresses differ"));
  EXPECT_THAT(error_of("print(('%-5p'):format({}))"), HasSubstr("addresses differ"));
  EXPECT_EQ(error_of("\nprint(('%s %d'):format(1, 'x'))"),
            "demos/x.lua:2: bad argument #2 to 'format' (number expected, got string)");
  EXPECT_EQ(error_of("local v\nprint(string.format('%.3f', v))"),
            "demos/x.lua:2: bad argument #2 to 'format' (number expected, got nil)");
  EXPECT_THAT(error_of("print(('%s'):format())"), HasSubstr("no value"));
}

TEST(LuaHost, LeavesOutEverythingThatReachesBeyondTheScript) {
  for (const char* name : {"io",
                           "os",
                           "debug",
                           "package",
                           "require",
                           "load",
                           "loadfile",
                           "dofile",
                           "coroutine",
                           "collectgarbage",
                           "setmetatable",
                           "getmetatable",
                           "rawset",
                           "rawget",
                           "pcall",
                           "xpcall",
                           "next",
                           "string.dump",
                           "string.find",
                           "string.gsub",
                           "string.match",
                           "string.gmatch",
                           "math.randomseed",
                           "table.move",
                           "utf8"})
    EXPECT_EQ(output_of(std::string("print(") + name + ")"), "nil\n") << name;
}

TEST(LuaHost, ErrorsInsideTheLibraryHaveALineToo) {
  EXPECT_EQ(error_of("local t\nfor _, x in ipairs(t) do print(x) end"),
            "demos/x.lua:2: bad argument #1 to 'ipairs' (table expected, got nil)");
  EXPECT_EQ(output_of("local t = {5, 6, nil, 8}\nfor i, x in ipairs(t) do print(i, x) t[2] = 7 end\n"
                      "for _ in ipairs{} do print('none') end"),
            "1\t5\n2\t7\n");
  EXPECT_EQ(error_of("local function worst(a)\n  return math.max(true, a)\nend\nprint(worst(3))"),
            "demos/x.lua:2: attempt to compare boolean with number");
  EXPECT_EQ(error_of("\n\nassert(1 > 2, 'no bricks')"), "demos/x.lua:3: no bricks");
  EXPECT_EQ(error_of("\nerror('plain', 0)"), "demos/x.lua:2: plain");
  EXPECT_EQ(error_of("\nerror('once')"), "demos/x.lua:2: once");
  EXPECT_EQ(error_of("\nerror{}"), "demos/x.lua: error of type table");
}

TEST(LuaHost, RefusesBytecode) {
  EXPECT_THAT(error_of("\x1bLua"), HasSubstr("attempt to load a binary chunk"));
}

TEST(LuaHost, PairsGoInSortedOrder) {
  EXPECT_EQ(output_of("for k, v in pairs{b = 1, a = 2, [10] = 3, [2] = 4, c = 5} do print(k, v) end"),
            "2\t4\n10\t3\na\t2\nb\t1\nc\t5\n");
  EXPECT_EQ(output_of("for k in pairs{} do print(k) end"), "");
  EXPECT_EQ(output_of("local t = {a = 1, b = 2} for k in pairs(t) do t.b = nil print(k) end"), "a\n");
}

TEST(LuaHost, RandomNumbersFollowTheSeedOnly) {
  const std::string source = "print(math.random(), math.random(6), math.random(-3, 3))";
  EXPECT_EQ(output_of(source, 7), output_of(source, 7));
  EXPECT_NE(output_of(source, 7), output_of(source, 8));
  EXPECT_EQ(
      output_of("local a, b = 1, 0 for i = 1, 10000 do local r = math.random() "
                "a = math.min(a, r) b = math.max(b, r) end print(a >= 0 and a < 0.001, b < 1 and b > 0.999)"),
      "true\ttrue\n");
  EXPECT_EQ(output_of("local n = {0, 0, 0} for i = 1, 3000 do local k = math.random(3) n[k] = n[k] + 1 end "
                      "print(n[1] > 900, n[2] > 900, n[3] > 900)"),
            "true\ttrue\ttrue\n");
  EXPECT_THAT(error_of("math.random(3, 1)"), HasSubstr("empty interval from 3 to 1"));
}

TEST(LuaHost, PrintsNoAddresses) {
  EXPECT_EQ(output_of("print({}, print, tostring({}))"), "table\tfunction\ttable\n");
}

TEST(LuaHost, NamesFileAndLineInErrors) {
  EXPECT_THAT(error_of("local a\nprint(a.b)"), StartsWith("demos/x.lua:2: attempt to index a nil value"));
  EXPECT_THAT(error_of("x = ("), StartsWith("demos/x.lua:1: unexpected symbol"));
  EXPECT_THAT(error_of("error({})"), StartsWith("demos/x.lua: error of type table"));
}

TEST(LuaHost, NamesLongPathsInFull) {
  const std::string path =
      "a/very/long/path/to/a/demo/that/lua/would/shorten/to/its/last/part/only/stack.lua";
  LuaHost host(path, 1);
  try {
    host.run("\n\nerror('lost')");
    FAIL();
  } catch (const ScriptError& error) {
    EXPECT_EQ(std::string(error.what()), path + ":3: lost");
  }
}

TEST(LuaHost, StopsScriptsThatNeverEnd) {
  const LuaLimits limits{.load_instructions = 100'000};
  EXPECT_THAT(error_of("while true do end", limits),
              StartsWith("demos/x.lua:1: the script runs for too long"));
  EXPECT_THAT(error_of("local function f() return f() end f()", limits), HasSubstr("runs for too long"));
  EXPECT_EQ(output_of("print(#(''):rep(1e7))"), "0\n");
}

TEST(LuaHost, StopsScriptsThatEatMemory) {
  const LuaLimits limits{.memory = 1 << 20};
  EXPECT_THAT(error_of("local s = 'x' while true do s = s .. s end", limits), HasSubstr("more than 1 MiB"));
  EXPECT_THAT(error_of("local t = {} for i = 1, 1e9 do t[i] = {i} end", limits),
              HasSubstr("more than 1 MiB"));
  EXPECT_THAT(error_of("local function f() return 1 + f() end f()"),
              AnyOf(HasSubstr("stack overflow"), HasSubstr("more than 64 MiB")));
}

TEST(LuaHost, CallbacksHaveABudgetOfTheirOwn) {
  LuaHost host("demos/x.lua", 1, {.load_instructions = 10'000, .call_instructions = 100'000});
  host.run("function f(n) for i = 1, n do end return n end");
  lua_getglobal(host.state(), "f");
  const int function = luaL_ref(host.state(), LUA_REGISTRYINDEX);
  const auto with = [](double n) {
    return [n](lua_State* state) {
      lua_pushnumber(state, n);
      return 1;
    };
  };
  for (int i = 0; i < 20; ++i) {
    host.call(function, 1, with(20'000));
    EXPECT_EQ(lua_tonumber(host.state(), -1), 20'000);
    lua_pop(host.state(), 1);
  }
  EXPECT_THROW(host.call(function, 1, with(1e9)), ScriptError);
}

}  // namespace lua_host_test
}  // namespace skerry::sandbox
