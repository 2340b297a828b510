// SPDX-License-Identifier: MIT
//
// Script functions that are told of contacts: on_touch (what begins and ends), on_hit (blows).
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "sandbox/lua_args.h"
#include "sandbox/script.h"

namespace skerry::sandbox {
namespace {

// Contacts of what moves in a pile open and close by micrometres all the time: what began to touch has ended
// when it is farther apart than this [m].
constexpr double kStillTouching = 1e-5;

struct BodyPair {
  BodyId first, second;
};

bool comes_before(BodyId x, BodyId y) {
  return x.index != y.index ? x.index < y.index : x.generation < y.generation;
}

/// @param bodies  ascending
bool is_among(const std::vector<BodyId>& bodies, BodyId body) {
  return std::binary_search(bodies.begin(), bodies.end(), body, comes_before);
}

/// Pairs of bodies, each both ways round, ascending.
class BodyPairs {
 public:
  void add(BodyId a, BodyId b) {
    pairs_.push_back({a, b});
    pairs_.push_back({b, a});
  }
  void sort() {
    std::sort(pairs_.begin(), pairs_.end(), [](const BodyPair& x, const BodyPair& y) {
      return x.first == y.first ? comes_before(x.second, y.second) : comes_before(x.first, y.first);
    });
  }
  /// What `watch` looks at, ascending.
  std::vector<BodyId> of(const TouchWatch& watch) const {
    std::vector<BodyId> others;
    auto at = std::lower_bound(pairs_.begin(), pairs_.end(), watch.first,
                               [](const BodyPair& x, BodyId body) { return comes_before(x.first, body); });
    for (; at != pairs_.end() && at->first == watch.first; ++at) {
      const bool known = !others.empty() && others.back() == at->second;
      if (!known && (!watch.second || at->second == watch.second)) others.push_back(at->second);
    }
    return others;
  }

 private:
  std::vector<BodyPair> pairs_;
};

/// The body that is argument 1. @throws std::invalid_argument
BodyId watched_body(lua_State* L, const World& world, const char* function) {
  const std::optional<BodyId> body = to_body(L, 1);
  if (!body)
    throw std::invalid_argument(std::string(function) + ": first expected a body, got " + describe(L, 1));
  if (!world.alive(*body)) throw std::invalid_argument(std::string(function) + ": first was removed");
  return *body;
}

/// Argument 2 where it is a body, which it need not be. @throws std::invalid_argument
BodyId other_body(lua_State* L, const World& world, const char* function) {
  const std::optional<BodyId> body = to_body(L, 2);
  if (!body && lua_type(L, 2) != LUA_TFUNCTION)
    throw std::invalid_argument(std::string(function) + ": second expected a body or a function, got " +
                                describe(L, 2));
  if (body && !world.alive(*body))
    throw std::invalid_argument(std::string(function) + ": second was removed");
  return body.value_or(BodyId{});
}

// on_touch(a [, b], began [, ended])
int on_touch(lua_State* L) {
  Script& script = script_to_act(L, "on_touch");
  TouchWatch watch;
  watch.first = watched_body(L, *script.world, "on_touch");
  watch.second = other_body(L, *script.world, "on_touch");
  const int next = watch.second ? 3 : 2;
  if (!lua_isnoneornil(L, next + 1) && lua_type(L, next + 1) != LUA_TFUNCTION)
    throw std::invalid_argument("on_touch: ended expected a function, got " + describe(L, next + 1));
  watch.began = function_argument(L, next, "on_touch", "began");
  if (!lua_isnoneornil(L, next + 1)) watch.ended = function_argument(L, next + 1, "on_touch", "ended");
  script.touches.push_back(std::move(watch));
  // Its events are of all that touches, not only of what begins to.
  script.needed.contacts = true;
  script.observe();
  return 0;
}

// on_hit(a [, b], action [, least])
int on_hit(lua_State* L) {
  Script& script = script_to_act(L, "on_hit");
  BlowWatch watch;
  watch.first = watched_body(L, *script.world, "on_hit");
  watch.second = other_body(L, *script.world, "on_hit");
  const int next = watch.second ? 3 : 2;
  if (!lua_isnoneornil(L, next + 1)) watch.least = number_argument(L, next + 1, "on_hit", "least");
  if (watch.least < 0)
    throw std::invalid_argument("on_hit: least must be at least 0, got " + format_number(watch.least));
  watch.action = function_argument(L, next, "on_hit", "action");
  script.blows.push_back(watch);
  script.needed.paths = true;
  script.observe();
  return 0;
}

/// What struck one body in a step, its shapes and those of the other together.
struct Blow {
  BodyId first, other;
  double impulse = 0;         ///< [N s]
  const ContactEvent* worst;  ///< the fastest
};

std::vector<Blow> blows_on(const BlowWatch& watch, const std::vector<ContactEvent>& events) {
  std::vector<Blow> blows;
  for (const ContactEvent& event : events) {
    if (event.kind != ContactEventKind::Hit || event.sensor) continue;
    const bool forward = event.body_a == watch.first;
    if (!forward && event.body_b != watch.first) continue;
    const BodyId other = forward ? event.body_b : event.body_a;
    if (watch.second && other != watch.second) continue;
    auto blow =
        std::find_if(blows.begin(), blows.end(), [&](const Blow& known) { return known.other == other; });
    if (blow == blows.end()) blow = blows.insert(blows.end(), {watch.first, other, 0, &event});
    blow->impulse += event.impulse;
    if (event.approach_speed > blow->worst->approach_speed) blow->worst = &event;
  }
  std::erase_if(blows, [&](const Blow& blow) { return blow.worst->approach_speed < watch.least; });
  return blows;
}

}  // namespace

void find_blows(Script& script, std::vector<Moment>& moments) {
  const StepReport& report = script.world->report();
  // Bodies are seen as the blow left them: later than it by more than times are rounded.
  const double later = std::max(1e-9 * script.dt, 1e-15 * report.time);
  for (const BlowWatch& watch : script.blows) {
    for (const Blow& blow : blows_on(watch, report.events)) {
      const double back = std::clamp(report.time - blow.worst->time - later, 0.0, script.dt);
      const auto act = [&script, action = watch.action, first = blow.first, other = blow.other,
                        impulse = blow.impulse, speed = blow.worst->approach_speed, at = blow.worst->point,
                        time = script.time() - back] {
        if (!script.world->alive(first) || !script.world->alive(other)) return;
        script.host.call(action, 0, [&](lua_State* state) {
          push_body(state, other);
          for (const double value : {speed, at.x, at.y, impulse, time}) lua_pushnumber(state, value);
          return 6;
        });
      };
      moments.push_back({back, act});
    }
  }
}

std::vector<TouchCall> find_touches(Script& script) {
  std::vector<TouchCall> calls;
  if (script.touches.empty()) return calls;
  BodyPairs before, now, close;
  for (const ContactEvent& event : script.world->report().events) {
    using enum ContactEventKind;
    if (event.kind == Persist || event.kind == End) before.add(event.body_a, event.body_b);
    if (event.kind == Persist || event.kind == Begin) now.add(event.body_a, event.body_b);
  }
  for (const ContactReport& contact : script.world->report().contacts_list) {
    const bool near =
        std::any_of(contact.points.begin(), contact.points.begin() + contact.count,
                    [](const ContactPointReport& point) { return point.separation <= kStillTouching; });
    if (near) close.add(contact.body_a, contact.body_b);
  }
  before.sort();
  now.sort();
  close.sort();
  for (std::size_t i = 0; i < script.touches.size(); ++i) {
    TouchWatch& watch = script.touches[i];
    if (!watch.known) watch.touching = before.of(watch);
    watch.known = true;
    const std::vector<BodyId> touching = now.of(watch), near = close.of(watch);
    const std::vector<BodyId> known = std::exchange(watch.touching, {});
    for (const BodyId other : known) {
      if (is_among(touching, other) || is_among(near, other))
        watch.touching.push_back(other);
      else
        calls.push_back({i, other, false});
    }
    for (const BodyId other : touching)
      if (!is_among(known, other)) calls.push_back({i, other, true});
  }
  return calls;
}

void tell_touch(Script& script, const TouchCall& call) {
  TouchWatch& watch = script.touches[call.watch];
  const int function = call.began ? watch.began : watch.ended;
  if (call.began) {
    if (!script.world->alive(watch.first) || !script.world->alive(call.other)) return;
    std::vector<BodyId>& told = watch.touching;
    told.insert(std::upper_bound(told.begin(), told.end(), call.other, comes_before), call.other);
  }
  if (function == 0) return;
  script.host.call(function, 0, [&](lua_State* state) {
    push_body(state, call.other);
    lua_pushnumber(state, script.time());
    return 2;
  });
}

void forget_watches(Script& script) {
  const auto is_over = [&](BodyId first, BodyId second) {
    return !script.world->alive(first) || (second && !script.world->alive(second));
  };
  const auto release = [&](int function) {
    if (function != 0) luaL_unref(script.host.state(), LUA_REGISTRYINDEX, function);
  };
  std::erase_if(script.touches, [&](const TouchWatch& watch) {
    // The end of what it touched is still to be told.
    if (!watch.touching.empty() || !is_over(watch.first, watch.second)) return false;
    release(watch.began);
    release(watch.ended);
    return true;
  });
  std::erase_if(script.blows, [&](const BlowWatch& watch) {
    if (!is_over(watch.first, watch.second)) return false;
    release(watch.action);
    return true;
  });
}

void add_touch_functions(lua_State* state) {
  lua_register(state, "on_touch", guarded<on_touch>);
  lua_register(state, "on_hit", guarded<on_hit>);
}

}  // namespace skerry::sandbox
