// SPDX-License-Identifier: MIT
#include "physics/world_access.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/text.h"

namespace skerry {

void refuse(const std::string& message) {
  throw std::invalid_argument(message);
}

void require_finite(double value, const char* what) {
  require(std::isfinite(value), what, " must be finite, got ", value);
}

void require_finite(Vec2 value, const char* what) {
  require(is_finite(value), what, " must be finite, got ", value);
}

void require_at_least_zero(double value, const char* what) {
  require(value >= 0 && std::isfinite(value), what, " must be finite and >= 0, got ", value);
}

namespace {

template <class Tag, class Slots>
std::uint32_t checked(Handle<Tag> id, const Slots& generation_of, std::size_t count, const char* what) {
  if (!(id.index < count && generation_of(id.index) == id.generation)) [[unlikely]]
    refuse(std::string(what) + " " + (id ? std::to_string(id.index) : "none") + " does not exist (any more)");
  return id.index;
}

}  // namespace

std::uint32_t slot(const WorldState& s, BodyId id) {
  return checked(
      id, [&](std::uint32_t i) { return s.bodies.alive[i] ? s.bodies.generation[i] : ~0u; }, s.bodies.size(),
      "body");
}

std::uint32_t slot(const WorldState& s, ShapeId id) {
  return checked(
      id, [&](std::uint32_t i) { return s.shapes[i].alive ? s.shapes[i].generation : ~0u; }, s.shapes.size(),
      "shape");
}

std::uint32_t slot(const WorldState& s, JointId id) {
  return checked(
      id, [&](std::uint32_t i) { return s.joints[i].alive ? s.joints[i].generation : ~0u; }, s.joints.size(),
      "joint");
}

std::string body_label(const WorldState& s, std::uint32_t body) {
  const std::string& name = s.names[body];
  return "body " + std::to_string(body) + (name.empty() ? "" : " '" + name + "'");
}

void touch(WorldState& s, std::uint32_t body) {
  s.touched.push_back(body);
  s.rests[body] = 0;
  s.step_memory[body].slow = 0;
  s.ledger.mark(body);
  if (s.sleepers.none()) return;
  s.sleepers.wake(s, {&body, 1});
  s.sleepers.wake_at(s, body);
}

void touch_pairs(WorldState& s, std::uint32_t body) {
  touch(s, body);
  for (const std::uint32_t shape : s.shapes_of[body]) s.shapes[shape].pairs_changed = true;
}

void forget_resting(WorldState& s) {
  if (s.resting.empty()) return;
  s.resting.clear();
  std::fill(s.rests.begin(), s.rests.end(), 0);
}

void touch_definition(WorldState& s, std::uint32_t body) {
  touch(s, body);
  forget_resting(s);
}

void displace(WorldState& s, std::uint32_t body) {
  touch(s, body);
  s.displaced.push_back(body);
}

void make_loose(WorldState& s, std::uint32_t body) {
  touch(s, body);
  s.loose_shapes.insert(s.loose_shapes.end(), s.shapes_of[body].begin(), s.shapes_of[body].end());
}

}  // namespace skerry
