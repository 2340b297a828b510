// SPDX-License-Identifier: MIT
#include "sandbox/window/recording.h"

#include <array>
#include <bit>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "physics/hash.h"
#include "render/image.h"
#include "sandbox/errors.h"

namespace skerry::sandbox {
namespace {

constexpr std::string_view kKind = "session";
constexpr std::uint32_t kVersion = 2;
constexpr std::string_view kTags[] = {"demo", "inpt", "stat"};
constexpr std::array<const char*, 6> kValueNames{"x", "y", "angle", "velocity x", "velocity y", "omega"};

using BodyTable = std::map<std::uint32_t, RecordedBody>;

void fields(Archive& a, RecordedBody& v) {
  auto& [slot, values] = v;
  a(slot, values);
}

void fields(Archive& a, std::pair<std::string, std::string>& v) {
  auto& [first, second] = v;
  a(first, second);
}

void archive_options(Archive& a, DemoOptions& v) {
  [[maybe_unused]] auto& [seed, dt, seconds, steps, accuracy, budget, flow_work, sleep_speed, threads, solver,
                          broad_phase, impact_law, stepper, parameters, print] = v;
  a(seed, dt, seconds, steps, accuracy, budget, flow_work, sleep_speed, threads, solver, broad_phase,
    impact_law, stepper);
  std::size_t count = parameters.size();
  a.count(count);
  parameters.resize(count);
  for (auto& parameter : parameters) fields(a, parameter);
}

void archive_recording(Archive& demo, Archive& inputs, Archive& states, Recording& v) {
  demo(v.path, v.script_hash);
  archive_options(demo, v.options);
  inputs(v.inputs);
  std::size_t count = v.states.size();
  states.count(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (states.reading()) v.states.emplace_back();
    auto& [hash, changed, removed] = v.states[i];
    std::size_t bodies = changed.size();
    states(hash);
    states.count(bodies);
    for (std::size_t k = 0; k < bodies; ++k) {
      if (states.reading()) changed.emplace_back();
      fields(states, changed[k]);
    }
    states(removed);
  }
}

BodyTable table_of(const World& world) {
  BodyTable table;
  const BodyArrays& b = world.bodies();
  for (std::uint32_t i = 0; i < b.size(); ++i) {
    if (!b.alive[i]) continue;
    table[i] = {i,
                {b.position[i].x, b.position[i].y, b.angle[i], b.velocity[i].x, b.velocity[i].y, b.omega[i]}};
  }
  return table;
}

bool same_bits(double x, double y) {
  return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
}

bool same_bits(const RecordedBody& x, const RecordedBody& y) {
  return std::equal(std::begin(x.values), std::end(x.values), std::begin(y.values),
                    [](double a, double b) { return same_bits(a, b); });
}

RecordedState change(const BodyTable& before, const BodyTable& after, std::uint64_t hash) {
  RecordedState state;
  state.hash = hash;
  for (const auto& [slot, body] : after) {
    const auto old = before.find(slot);
    if (old == before.end() || !same_bits(old->second, body)) state.changed.push_back(body);
  }
  for (const auto& [slot, body] : before)
    if (!after.contains(slot)) state.removed.push_back(slot);
  return state;
}

void apply(const RecordedState& state, BodyTable& table) {
  for (const RecordedBody& body : state.changed) table[body.slot] = body;
  for (const std::uint32_t slot : state.removed) table.erase(slot);
}

std::string name_of(const World& world, std::uint32_t slot) {
  const BodyArrays& b = world.bodies();
  const bool alive = slot < b.size() && b.alive[slot];
  const std::string label = alive ? body_label(world, world.body_id(slot)) : std::string();
  return "body " + std::to_string(slot) + (label.empty() ? "" : " \"" + label + '"');
}

Difference find_difference(const Demo& demo, const BodyTable& expected) {
  const BodyTable found = table_of(demo.world());
  Difference difference{demo.steps_done(), demo.time(), "", "state hash", 0, 0};
  const auto at = [&](std::uint32_t slot, const char* value, double was, double is) {
    difference.body = name_of(demo.world(), slot);
    difference.value = value;
    difference.expected = was;
    difference.found = is;
    return difference;
  };
  for (const auto& [slot, body] : expected) {
    const auto now = found.find(slot);
    if (now == found.end()) return at(slot, "exists", 1, 0);
    for (std::size_t k = 0; k < kValueNames.size(); ++k)
      if (!same_bits(body.values[k], now->second.values[k]))
        return at(slot, kValueNames[k], body.values[k], now->second.values[k]);
  }
  for (const auto& [slot, body] : found)
    if (!expected.contains(slot)) return at(slot, "exists", 0, 1);
  return difference;
}

}  // namespace

Recording record(Player& player) {
  Recording recording;
  recording.path = player.demo().path();
  recording.script_hash = player.demo().script_hash();
  recording.options = player.options();
  recording.options.print = {};
  recording.inputs = player.inputs();
  const std::uint64_t here = player.step(), end = player.end();
  // Bodies that a user made or removed are seen in the next state: a state is what a step left.
  BodyTable before;
  try {
    player.seek(0);
    for (;;) {
      BodyTable now = table_of(player.demo().world());
      recording.states.push_back(change(before, now, player.hash(player.step())));
      before = std::move(now);
      if (player.step() == end) break;
      player.advance();
    }
  } catch (...) {
    player.seek(here);
    throw;
  }
  player.seek(here);
  return recording;
}

std::vector<std::byte> save_recording(const Recording& recording) {
  std::array<ArchiveSection, 3> sections;
  for (std::size_t i = 0; i < sections.size(); ++i) std::copy_n(kTags[i].begin(), 4, sections[i].tag.begin());
  Archive demo(sections[0].bytes), inputs(sections[1].bytes), states(sections[2].bytes);
  Recording copy = recording;
  archive_recording(demo, inputs, states, copy);
  return pack_sections(kKind, kVersion, sections);
}

Recording load_recording(std::span<const std::byte> bytes) {
  std::vector<Archive> sections = unpack_sections(bytes, kKind, kVersion, kTags);
  Recording recording;
  archive_recording(sections[0], sections[1], sections[2], recording);
  for (const Archive& section : sections) section.finish();
  return recording;
}

std::string Difference::text() const {
  char head[64], values[128] = "";
  std::snprintf(head, sizeof head, "step %llu (t = %.6g s): ", static_cast<unsigned long long>(step), time);
  if (value == "exists") return head + body + (found > 0 ? " was not there" : " is missing");
  if (body.empty()) return std::string(head) + "the state hash differs";
  std::snprintf(values, sizeof values, " is %.17g, was %.17g (%+.3g)", found, expected, found - expected);
  return head + value + " of " + body + values;
}

std::optional<Difference> replay(const Recording& recording, const std::string& path) {
  Player player(path.empty() ? recording.path : path, recording.options);
  player.play_inputs(recording.inputs);
  BodyTable expected;
  for (std::size_t i = 0; i < recording.states.size(); ++i) {
    if (i > 0) player.advance();
    apply(recording.states[i], expected);
    if (player.hash(player.step()) != recording.states[i].hash)
      return find_difference(player.demo(), expected);
  }
  return std::nullopt;
}

std::vector<std::byte> read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) throw ScriptError(path + ": cannot be read");
  const std::vector<char> text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

void write_bytes(const std::string& path, std::span<const std::byte> bytes) {
  try {
    render::write_file(path, bytes.data(), bytes.size());
  } catch (const std::runtime_error& error) {
    throw ScriptError(error.what());
  }
}

std::uint64_t file_hash(const std::string& path) {
  const std::vector<std::byte> bytes = read_bytes(path);
  return text_hash({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace skerry::sandbox
