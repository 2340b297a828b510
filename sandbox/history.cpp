// SPDX-License-Identifier: MIT
#include "sandbox/history.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "sandbox/bridge_view.h"

namespace skerry::sandbox {
namespace {

// The equations of an impact stay on screen for this many flashes' time: it takes a while to read them.
constexpr double kImpactSystemFlashes = 6;
constexpr std::size_t kMostSamples = 4096;
constexpr int kMostAnchors = 4096;

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

using ContactsOfPair = std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<const ContactReport*>>;

// The moving body of a side, or none: rows call all fixed bodies the ground.
std::uint32_t moving(const World& world, BodyId body) {
  return world.bodies().type[body.index] == BodyType::Dynamic ? body.index : BodyId::kNone;
}

ContactsOfPair contacts_of_pairs(const World& world, int island) {
  ContactsOfPair result;
  for (const ContactReport& contact : world.report().contacts_list)
    if (contact.island == island)
      result[{moving(world, contact.body_a), moving(world, contact.body_b)}].push_back(&contact);
  return result;
}

// How badly a row does not act at this point: its lever arm about a body against that of the point.
double mismatch(const IslandSystem& system, const Row& row, Vec2 point) {
  const bool on_b = row.b >= 0;
  const std::array<double, 3>& J = on_b ? row.Jb : row.Ja;
  const Vec2 arm = point - system.positions[static_cast<std::size_t>(on_b ? row.b : row.a)];
  return std::abs(cross(arm, Vec2{J[0], J[1]}) - J[2]);
}

RowAnchor anchor_of(const World& world, const IslandTrace& trace, const Row& given,
                    const ContactsOfPair& contacts) {
  // The lever arm of the normal row names the point; that of the others is the same for both points of an
  // edge.
  const Row& row = given.normal >= 0 ? trace.system.rows[static_cast<std::size_t>(given.normal)] : given;
  RowAnchor anchor;
  if (row.a >= 0) anchor.a = trace.bodies[static_cast<std::size_t>(row.a)];
  if (row.b >= 0) anchor.b = trace.bodies[static_cast<std::size_t>(row.b)];
  anchor.carrier = anchor.b ? anchor.b : anchor.a;
  const auto found = contacts.find({anchor.a.index, anchor.b.index});
  if (row.kind != RowKind::Normal || found == contacts.end()) return anchor;
  double best = HUGE_VAL;
  for (const ContactReport* contact : found->second) {
    for (int i = 0; i < contact->count; ++i) {
      const Vec2 point = contact->points[static_cast<std::size_t>(i)].position;
      const double error = mismatch(trace.system, row, point);
      if (error >= best) continue;
      best = error;
      anchor.local = to_local(world.pose(anchor.carrier), point);
    }
  }
  return anchor;
}

SystemRecord record(const World& world, const IslandTrace& trace) {
  SystemRecord result;
  result.time = trace.time;
  result.impact = trace.impact;
  result.island = trace.island;
  result.system = trace.system;
  result.lambda = trace.lambda;
  result.method = trace.method;
  result.status = trace.status;
  result.residual = trace.residual;
  if (trace.trace) {
    result.iterations = trace.trace->iterations;
    result.notes = trace.trace->notes;
  }
  if (trace.system.size() <= kMostAnchors) {
    const ContactsOfPair contacts = contacts_of_pairs(world, trace.island);
    for (const Row& row : trace.system.rows) result.anchors.push_back(anchor_of(world, trace, row, contacts));
  }
  if (trace.system.size() > kMostNamedRows) return result;
  const bool friction = std::any_of(trace.system.rows.begin(), trace.system.rows.end(),
                                    [](const Row& row) { return row.kind == RowKind::Friction; });
  for (const Row& row : trace.system.rows) result.row_names.push_back(row_name(world, trace, row, friction));
  return result;
}

LedgerSample sample_of(const World& world, double time, double residual) {
  return {
      time,    world.kinetic_energy(), world.potential_energy(), world.momentum(), world.angular_momentum(),
      residual};
}

/// When the shapes of a contact collided in the last step [s].
double hit_time(const StepReport& report, const ContactReport& contact) {
  for (const ContactEvent& event : report.events) {
    if (event.kind == ContactEventKind::Hit && event.shape_a == contact.shape_a &&
        event.shape_b == contact.shape_b)
      return event.time;
  }
  return report.time;
}

}  // namespace

const FactorViews& SystemRecord::factors() const {
  if (!factors_) {
    const Eigen::SparseMatrix<double> W = delassus(system);
    factors_ = std::make_shared<const FactorViews>(
        FactorViews{factor_pattern(W, Ordering::Natural), factor_pattern(W, Ordering::ApproximateMinimum)});
  }
  return *factors_;
}

History::History(const Demo& demo, bool keep_systems, double flash_seconds)
    : keep_systems_(keep_systems), flash_seconds_(flash_seconds), traces_(demo) {
  ledger_.add(sample_of(demo.world(), 0, 0));
  look_at_bodies(demo.world());
  look_at_bridges(demo);
}

void History::add_beat(double impulse) {
  if (!beats_.empty() && beats_.back().time == now_) {
    beats_.back().impulse = std::max(beats_.back().impulse, impulse);
    return;
  }
  beats_.push_back({now_, impulse});
  if (beats_.size() <= kMostSamples) return;
  // Neighbours become one, the stronger.
  std::size_t kept = 0;
  for (std::size_t i = 0; i + 1 < beats_.size(); i += 2)
    beats_[kept++] = beats_[i].impulse > beats_[i + 1].impulse ? beats_[i] : beats_[i + 1];
  beats_.resize(kept);
}

void History::look_at_bodies(const World& world) {
  const BodyArrays& bodies = world.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies.alive[i]) continue;
    fastest_ = std::max(fastest_, length(bodies.velocity[i]));
    largest_mass_ = std::max(largest_mass_, bodies.mass[i]);
  }
}

void History::look_at_bridges(const Demo& demo) {
  for (const BridgeView& view : demo.bridges()) {
    for (const statics::Reaction& reaction : standing_reactions(*view.bridge))
      largest_reaction_ = std::max(largest_reaction_, length(reaction.force));
    for (const BendingMoments& moments : bending_moments(*view.bridge))
      for (const double moment : moments) largest_moment_ = std::max(largest_moment_, std::abs(moment));
  }
}

void History::look_at_contacts(const World& world) {
  const StepReport& report = world.report();
  const std::vector<BodyType>& types = world.bodies().type;
  std::erase_if(flashes_, [&](const Flash& flash) { return flash.time < now_ && brightness(flash) <= 0; });
  for (const ContactReport& contact : report.contacts_list) {
    for (int i = 0; i < contact.count; ++i) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(i)];
      if (report.h > 0 && point.normal_impulse / report.h > force_floor(world))
        largest_force_ = std::max(largest_force_, point.normal_impulse / report.h);
      if (point.impact_impulse <= 0) continue;
      flashes_.push_back({now_, now_ - (report.time - hit_time(report, contact)), point.impact_position,
                          contact.impact_normal, point.impact_impulse,
                          types[contact.body_a.index] != BodyType::Dynamic,
                          types[contact.body_b.index] != BodyType::Dynamic});
      largest_impulse_ = std::max(largest_impulse_, point.impact_impulse);
    }
  }
  // Events come with every report, contacts only for those who look at them.
  for (const ContactEvent& event : report.events)
    if (event.kind == ContactEventKind::Hit && !event.sensor) add_beat(event.impulse);
}

void History::look_at_systems(const World& world) {
  const IslandTrace* impact = nullptr;
  const IslandTrace* resting = nullptr;
  int followed = followed_;
  if (followed_body_ && world.alive(followed_body_) && world.bodies().island[followed_body_.index] >= 0)
    followed = world.bodies().island[followed_body_.index];
  for (const IslandTrace& trace : world.report().traces) {
    if (followed >= 0 && trace.island != followed) continue;
    const IslandTrace*& best = trace.impact ? impact : resting;
    // Of one island the last of the step.
    if (!best || trace.system.size() > best->system.size() ||
        (trace.system.size() == best->system.size() && trace.island == best->island))
      best = &trace;
  }
  if (impact) impact_ = record(world, *impact);
  if (resting) resting_ = record(world, *resting);
}

void History::update(const Demo& demo) {
  const World& world = demo.world();
  const StepReport& report = world.report();
  now_ = demo.time();
  look_at_bodies(world);
  look_at_bridges(demo);
  ledger_.add({now_, report.kinetic_energy, report.potential_energy, report.momentum, report.angular_momentum,
               report.worst_residual});
  traces_.update(demo);
  look_at_contacts(world);
  for (std::size_t k = 0; k < stage_seconds_.size(); ++k)
    stage_seconds_[k] += (report.stage_seconds[k] - stage_seconds_[k]) * (report.step < 2 ? 1 : 0.1);
  if (keep_systems_) look_at_systems(world);
}

std::size_t History::bytes() const {
  return sizeof(History) + ledger().size() * sizeof(LedgerSample) + beats_.size() * sizeof(Beat) +
         traces_.bytes();
}

double History::force_floor(const World& world) const {
  const Vec2 gravity = world.config().gravity;
  const double impact_force = world.report().h > 0 ? largest_impulse_ / world.report().h : 0;
  return 1e-9 * std::max({largest_mass_ * length(gravity), impact_force, largest_force_});
}

double History::brightness(const Flash& flash) const {
  if (now_ < flash.begin) return 0;
  return std::clamp(1 - (now_ - flash.time) / flash_seconds_, 0.0, 1.0);
}

const SystemRecord* History::system() const {
  const bool recent = impact_ && now_ - impact_->time < kImpactSystemFlashes * flash_seconds_;
  const bool outdone = impact_ && resting_ && resting_->time >= impact_->time &&
                       resting_->system.size() > impact_->system.size();
  if (impact_ && ((recent && !outdone) || !resting_)) return &*impact_;
  return resting_ ? &*resting_ : nullptr;
}

Vec2 anchor_point(const Demo& demo, const RowAnchor& anchor) {
  if (!anchor.carrier || !demo.world().alive(anchor.carrier)) return anchor.local;
  return to_world(demo.shown(anchor.carrier.index).pose(), anchor.local);
}

}  // namespace skerry::sandbox
