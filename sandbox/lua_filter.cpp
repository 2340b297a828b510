// SPDX-License-Identifier: MIT
//
// What meets what: `group`, `category` and `ignores` of bodies, when they are made and later; and `sensor`.
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sandbox/lua_bodies.h"
#include "sandbox/names.h"

namespace skerry::sandbox {
namespace {

constexpr std::size_t kMostCategories = 31;  // besides that of bodies without one
constexpr std::uint32_t kNoCategory = 1;

/// @param whose  "box", "body"
std::int32_t to_group(double group, const std::string& whose) {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  if (group != std::round(group) || std::abs(group) > kMost)
    throw std::invalid_argument(whose + ": group expected a whole number, got " + format_number(group));
  return static_cast<std::int32_t>(group);
}

/// The bit of a name; a new one gets the next.
std::uint32_t bit_of_category(Script& script, const std::string& name, const std::string& whose) {
  std::vector<std::string>& known = script.categories;
  if (name.empty()) throw std::invalid_argument(whose + " expected a name, got the string \"\"");
  auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end()) {
    if (known.size() == kMostCategories)
      throw std::invalid_argument(whose + ": \"" + name + "\" is one more than the " +
                                  std::to_string(kMostCategories) + " categories that there may be");
    found = known.insert(known.end(), name);
  }
  return 2u << static_cast<unsigned>(found - known.begin());
}

/// The names at `index`, a list. @param whose  "box: ignores"
std::vector<std::string> read_names(lua_State* L, int index, const std::string& whose) {
  if (lua_type(L, index) != LUA_TTABLE)
    throw std::invalid_argument(whose + " expected a list of categories as in {\"coin\"}, got " +
                                describe(L, index));
  std::vector<std::string> names;
  for (lua_Unsigned i = 1; i <= lua_rawlen(L, index); ++i) {
    lua_rawgeti(L, index, static_cast<lua_Integer>(i));
    if (lua_type(L, -1) != LUA_TSTRING)
      throw std::invalid_argument(whose + '[' + std::to_string(i) + "] expected a string, got " +
                                  describe(L, -1));
    names.emplace_back(lua_tostring(L, -1));
    lua_pop(L, 1);
  }
  return names;
}

/// All but the categories at `index`.
std::uint32_t read_mask(lua_State* L, int index, Script& script, const std::string& whose) {
  std::uint32_t mask = ~std::uint32_t{0};
  for (const std::string& name : read_names(L, index, whose)) mask &= ~bit_of_category(script, name, whose);
  return mask;
}

void push_category(lua_State* L, const Script& script, std::uint32_t category) {
  for (std::size_t i = 0; i < script.categories.size(); ++i) {
    if (category == 2u << i) {
      lua_pushstring(L, script.categories[i].c_str());
      return;
    }
  }
  lua_pushnil(L);
}

void push_ignored(lua_State* L, const Script& script, std::uint32_t mask) {
  lua_newtable(L);
  lua_Integer count = 0;
  for (std::size_t i = 0; i < script.categories.size(); ++i) {
    if ((mask & 2u << i) != 0) continue;
    lua_pushstring(L, script.categories[i].c_str());
    lua_rawseti(L, -2, ++count);
  }
}

/// All its shapes are.
bool is_sensor(const World& world, BodyId body) {
  const std::vector<ShapeId> shapes = shapes_of(world, body);
  return !shapes.empty() && std::all_of(shapes.begin(), shapes.end(), [&world](ShapeId shape) {
    return world.shapes()[shape.index].sensor;
  });
}

[[noreturn]] void refuse_unknown(const std::string& whose, const std::string& name,
                                 const std::vector<std::string>& known) {
  throw std::invalid_argument(whose + ": no category \"" + name + '"' + suggestion(name, known));
}

}  // namespace

Filter read_filter(lua_State* L, const Args& args, Script& script) {
  Filter filter;
  filter.group = to_group(args.number("group", 0), args.function());
  if (const std::optional<std::string> category = args.text("category"))
    filter.category = bit_of_category(script, *category, args.function() + ": category");
  if (lua_getfield(L, args.index(), "ignores") != LUA_TNIL)
    filter.mask = read_mask(L, lua_gettop(L), script, args.function() + ": ignores");
  lua_pop(L, 1);
  return filter;
}

const std::vector<std::string>& filter_fields() {
  static const std::vector<std::string> names{"group", "category", "ignores", "sensor"};
  return names;
}

bool push_filter_field(lua_State* L, const Script& script, BodyId body, const std::string& key) {
  const std::vector<std::string>& names = filter_fields();
  if (std::find(names.begin(), names.end(), key) == names.end()) return false;
  const World& world = *script.world;
  if (!world.alive(body)) throw std::invalid_argument("body: \"" + key + "\" of a body that was removed");
  const ShapeRecord* shape = first_shape(world, body);
  const Filter filter = shape ? shape->filter : Filter{};
  if (key == "group")
    lua_pushinteger(L, filter.group);
  else if (key == "category")
    push_category(L, script, filter.category);
  else if (key == "ignores")
    push_ignored(L, script, filter.mask);
  else
    lua_pushboolean(L, is_sensor(world, body));
  return true;
}

bool set_filter_field(lua_State* L, Script& script, BodyId body, const std::string& key, int index) {
  if (key != "group" && key != "category" && key != "ignores") return false;
  World& world = *script.world;
  if (!world.alive(body)) throw std::invalid_argument("body: \"" + key + "\" of a body that was removed");
  const bool none = lua_isnil(L, index);
  const std::string whose = "body: " + key;
  for (const ShapeId shape : shapes_of(world, body)) {
    Filter filter = world.shapes()[shape.index].filter;
    if (key == "group")
      filter.group = none ? 0 : to_group(number_argument(L, index, "body", key), "body");
    else if (key == "category")
      filter.category =
          none ? kNoCategory : bit_of_category(script, text_argument(L, index, "body", key), whose);
    else
      filter.mask = none ? Filter{}.mask : read_mask(L, index, script, whose);
    if (filter != world.shapes()[shape.index].filter) world.set_filter(shape, filter);
  }
  return true;
}

std::uint32_t known_categories(lua_State* L, int index, const Script& script, const std::string& whose) {
  std::uint32_t mask = ~std::uint32_t{0};
  for (const std::string& name : read_names(L, index, whose)) {
    const auto found = std::find(script.categories.begin(), script.categories.end(), name);
    if (found == script.categories.end()) {
      // What there is none of yet is nowhere to be found; a slip is near to a name that there is.
      if (!suggestion(name, script.categories).empty()) refuse_unknown(whose, name, script.categories);
      continue;
    }
    mask &= ~(2u << static_cast<unsigned>(found - script.categories.begin()));
  }
  return mask;
}

}  // namespace skerry::sandbox
