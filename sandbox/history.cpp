// SPDX-License-Identifier: MIT
#include "sandbox/history.h"

#include <algorithm>

namespace skerry::sandbox {
namespace {

// The equations of an impact stay on screen for this many flashes' time.
constexpr double kImpactSystemFlashes = 6;

// "A-B n": the bodies and, where a contact has several rows, which of them this is. The ground comes last.
std::string row_name(const World& world, const IslandTrace& trace, const Row& row, bool friction) {
  const auto label = [&](int index) {
    return index < 0 ? std::string("ground")
                     : body_label(world, trace.bodies[static_cast<std::size_t>(index)]);
  };
  const std::string pair = row.a < 0 ? label(row.b) + "-ground" : label(row.a) + '-' + label(row.b);
  switch (row.kind) {
    case RowKind::Normal:
      return friction ? pair + " n" : pair;
    case RowKind::Friction:
      return pair + " t";
    case RowKind::Rolling:
      return pair + " r";
    default:
      return row.a < 0 ? label(row.b) + " joint" : pair + " joint";
  }
}

SystemRecord record(const World& world, const IslandTrace& trace) {
  SystemRecord result;
  result.time = trace.time;
  result.impact = trace.impact;
  result.system = trace.system;
  result.lambda = trace.lambda;
  result.method = trace.method;
  result.residual = trace.residual;
  if (trace.system.size() > kMostNamedRows) return result;
  const bool friction = std::any_of(trace.system.rows.begin(), trace.system.rows.end(),
                                    [](const Row& row) { return row.kind == RowKind::Friction; });
  for (const Row& row : trace.system.rows) result.row_names.push_back(row_name(world, trace, row, friction));
  return result;
}

}  // namespace

std::string body_label(const World& world, BodyId body) {
  if (!body) return "ground";
  const std::string_view name = world.alive(body) ? world.name(body) : std::string_view();
  if (!name.empty()) return std::string(name);
  const BodyArrays& bodies = world.bodies();
  int rank = 0;
  for (std::size_t i = 0; i < body.index; ++i) rank += bodies.type[i] == BodyType::Dynamic;
  return rank < 26 ? std::string(1, static_cast<char>('A' + rank)) : std::to_string(rank + 1);
}

History::History(const Demo& demo, bool keep_systems, double flash_seconds)
    : keep_systems_(keep_systems), flash_seconds_(flash_seconds) {
  energy_.push_back({0, demo.world().kinetic_energy(), demo.world().potential_energy()});
  look_at_bodies(demo.world());
}

void History::look_at_bodies(const World& world) {
  const BodyArrays& bodies = world.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies.alive[i]) continue;
    fastest_ = std::max(fastest_, length(bodies.velocity[i]));
    largest_mass_ = std::max(largest_mass_, bodies.mass[i]);
  }
}

void History::update(const Demo& demo) {
  const World& world = demo.world();
  const StepReport& report = world.report();
  now_ = demo.time();
  look_at_bodies(world);
  energy_.push_back({now_, report.kinetic_energy, report.potential_energy});

  std::erase_if(flashes_, [&](const Flash& flash) { return brightness(flash) <= 0; });
  for (const ContactReport& contact : report.contacts_list) {
    for (int i = 0; i < contact.count; ++i) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(i)];
      if (report.h > 0 && point.normal_impulse / report.h > force_floor(world))
        largest_force_ = std::max(largest_force_, point.normal_impulse / report.h);
      if (point.impact_impulse <= 0) continue;
      const std::vector<BodyType>& types = world.bodies().type;
      flashes_.push_back({now_, point.impact_position, contact.normal, point.impact_impulse,
                          types[contact.body_a.index] != BodyType::Dynamic,
                          types[contact.body_b.index] != BodyType::Dynamic});
      largest_impulse_ = std::max(largest_impulse_, point.impact_impulse);
    }
  }

  if (!keep_systems_) return;
  const IslandTrace* impact = nullptr;
  const IslandTrace* resting = nullptr;
  for (const IslandTrace& trace : report.traces) {
    const IslandTrace*& best = trace.impact ? impact : resting;
    if (!best || trace.system.size() > best->system.size()) best = &trace;
  }
  if (impact) impact_ = record(world, *impact);
  if (resting) resting_ = record(world, *resting);
}

double History::force_floor(const World& world) const {
  const Vec2 gravity = world.config().gravity;
  const double impact_force = world.report().h > 0 ? largest_impulse_ / world.report().h : 0;
  return 1e-9 * std::max({largest_mass_ * length(gravity), impact_force, largest_force_});
}

double History::brightness(const Flash& flash) const {
  return std::clamp(1 - (now_ - flash.time) / flash_seconds_, 0.0, 1.0);
}

const SystemRecord* History::system() const {
  const bool recent = impact_ && now_ - impact_->time < kImpactSystemFlashes * flash_seconds_;
  if (impact_ && (recent || !resting_)) return &*impact_;
  return resting_ ? &*resting_ : nullptr;
}

}  // namespace skerry::sandbox
