// SPDX-License-Identifier: MIT
//
// What the script functions that make bodies have in common. Included by the lua_*.cpp files only.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sandbox/lua_args.h"
#include "sandbox/script.h"

namespace skerry::sandbox {

/// `keys`, then those of all functions that make bodies with a mass.
std::vector<std::string> with_common(std::vector<std::string> keys);
/// Of a body or of a part of one. @param standard  what it is of where nothing is said
Material read_material(const Args& args, const Material& standard);
/// Everything but shapes.
BodyDef read_body(const Args& args);
/// Positive. @param standard  [kg/m^2]
double read_density(const Args& args, double standard);
/// Index into the palette, -1: the usual colour.
int read_color(const Args& args);
/// What meets what: `group`, `category`, `ignores`.
Filter read_filter(lua_State* L, const Args& args, Script& script);
/// The mask of a question that leaves out the categories in the list at `index`, which are known.
std::uint32_t known_categories(lua_State* L, int index, const Script& script, const std::string& whose);

/// Shapes by their own arguments.
Shape read_box(const Args& args);
Shape read_disc(const Args& args);
Shape read_polygon(const Args& args);
Shape read_capsule(const Args& args);
/// The names of those.
const std::vector<std::string>& box_keys();
const std::vector<std::string>& disc_keys();
const std::vector<std::string>& polygon_keys();
const std::vector<std::string>& capsule_keys();

/// Makes a body of these shapes and leaves it on the stack.
BodyId add_body(lua_State* L, Script& script, const BodyDef& def, std::span<const ShapeDef> parts, int color);

/// The shapes of a body, by slot.
std::vector<ShapeId> shapes_of(const World& world, BodyId body);
/// The first of them, or null.
const ShapeRecord* first_shape(const World& world, BodyId body);

/// `group`, `category`, `ignores`, `sensor` of a body: whether `key` is one of them, which is on the stack
/// then.
bool push_filter_field(lua_State* L, const Script& script, BodyId body, const std::string& key);
/// Takes the value at `index`. @return whether `key` is one of those that can be set
bool set_filter_field(lua_State* L, Script& script, BodyId body, const std::string& key, int index);
/// The names of those fields.
const std::vector<std::string>& filter_fields();

}  // namespace skerry::sandbox
