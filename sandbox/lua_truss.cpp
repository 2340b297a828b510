// SPDX-License-Identifier: MIT
//
// Script function `truss`: nodes, members, deck and supports of the usual trusses, for `bridge`.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sandbox/lua_args.h"
#include "sandbox/names.h"
#include "sandbox/script.h"

namespace skerry::sandbox {
namespace {

/// A truss on the stack: a table of lists that is filled field by field.
class TrussTable {
 public:
  explicit TrussTable(lua_State* L) : L_(L) {
    lua_newtable(L);
    table_ = lua_gettop(L);
    for (const char* list :
         {"nodes", "members", "deck", "supports", "lower", "upper", "posts", "diagonals", "ends"}) {
      lua_newtable(L);
      lua_setfield(L, table_, list);
    }
  }

  void node(double x, double y) {
    open("nodes");
    lua_newtable(L_);
    put(1, x);
    put(2, y);
    close();
  }

  /// Adds a member between two nodes, and its number to the list `part`.
  void member(const char* part, int a, int b) {
    open("members");
    pair(a, b);
    close();
    append(part, ++members_);
  }

  void support(int node, const char* kind) {
    open("supports");
    lua_newtable(L_);
    lua_pushinteger(L_, node);
    lua_rawseti(L_, -2, 1);
    lua_pushstring(L_, kind);
    lua_rawseti(L_, -2, 2);
    close();
  }

  void append(const char* list, int number) {
    open(list);
    lua_pushinteger(L_, number);
    close();
  }

 private:
  void open(const char* list) { lua_getfield(L_, table_, list); }
  // Appends the value on top to the list below it.
  void close() {
    lua_rawseti(L_, -2, static_cast<lua_Integer>(lua_rawlen(L_, -2)) + 1);
    lua_pop(L_, 1);
  }
  void put(lua_Integer index, double value) {
    lua_pushnumber(L_, value);
    lua_rawseti(L_, -2, index);
  }
  void pair(int a, int b) {
    lua_newtable(L_);
    lua_pushinteger(L_, a);
    lua_rawseti(L_, -2, 1);
    lua_pushinteger(L_, b);
    lua_rawseti(L_, -2, 2);
  }

  lua_State* L_;
  int table_ = 0, members_ = 0;
};

// truss{ kind = "pratt", panels = 8, side = 4, height = 4 } -> { nodes, members, deck, supports, lower, ... }
int make_truss(lua_State* L) {
  const Args args(L, "truss", {"kind", "panels", "side", "height"});
  static const std::vector<std::string> kinds{"warren", "pratt", "howe"};
  const std::string kind = args.text("kind").value_or("warren");
  if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
    throw std::invalid_argument("truss: no kind \"" + kind + '"' + suggestion(kind, kinds));
  const bool warren = kind == "warren";
  const double side = args.number_from("side", 0).value_or(4);
  const double height = args.number_from("height", 0).value_or(warren ? side * std::sqrt(3.0) / 2 : side);
  const double count = args.number("panels", 8);
  // Two panels make no chord above; more than a thousand no picture.
  if (!(count >= 3 && count <= 1000) || count != std::floor(count))
    throw std::invalid_argument("truss: panels must be a whole number from 3 to 1000, got " +
                                format_number(count));
  if (!(side > 0) || !(height > 0)) throw std::invalid_argument("truss: side and height must be positive");
  const int panels = static_cast<int>(count);
  const auto top = [&](int i) { return panels + 1 + i; };

  TrussTable truss(L);
  for (int i = 0; i <= panels; ++i) {
    truss.node(side * i, 0);
    truss.append("deck", i + 1);
  }
  if (warren) {
    for (int i = 0; i < panels; ++i) truss.node(side * (i + 0.5), height);
  } else {
    for (int i = 1; i < panels; ++i) truss.node(side * i, height);
  }
  for (int i = 1; i <= panels; ++i) truss.member("lower", i, i + 1);
  for (int i = 1; i + (warren ? 0 : 1) < panels; ++i) truss.member("upper", top(i), top(i + 1));
  if (warren) {
    for (int i = 1; i <= panels; ++i) {
      truss.member("diagonals", i, top(i));
      truss.member("diagonals", top(i), i + 1);
    }
  } else {
    truss.member("ends", 1, top(1));
    truss.member("ends", top(panels - 1), panels + 1);
    for (int i = 1; i < panels; ++i) truss.member("posts", i + 1, top(i));
    // Those of a Pratt truss fall towards the middle, those of a Howe truss rise.
    for (int i = 1; i + 1 < panels; ++i) {
      if ((2 * i < panels) == (kind == "pratt"))
        truss.member("diagonals", top(i), i + 2);
      else
        truss.member("diagonals", i + 1, top(i + 1));
    }
  }
  truss.support(1, "pinned");
  truss.support(panels + 1, "roller");
  return 1;
}

}  // namespace

void add_truss_function(lua_State* state) {
  lua_register(state, "truss", guarded<make_truss>);
}

}  // namespace skerry::sandbox
