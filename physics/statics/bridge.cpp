// SPDX-License-Identifier: MIT
//
// The static side of a bridge: the train's load, solves, breaking members.
#include "physics/statics/bridge.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/text.h"

namespace skerry::statics {
namespace {

void require_finite(double value, const char* what) {
  if (!std::isfinite(value))
    throw std::invalid_argument(std::string(what) + " must be finite, got " + to_text(value));
}

void check_train(const Train& train) {
  if (train.axles.empty()) return;
  if (train.gaps.size() + 1 != train.axles.size())
    throw std::invalid_argument("train: " + std::to_string(train.axles.size()) + " axles have " +
                                std::to_string(train.axles.size() - 1) + " gaps, got " +
                                std::to_string(train.gaps.size()));
  for (const double load : train.axles) {
    if (!(load >= 0)) throw std::invalid_argument("train: axles must not be negative, got " + to_text(load));
    require_finite(load, "train: axles");
  }
  for (const double gap : train.gaps) {
    if (!(gap > 0)) throw std::invalid_argument("train: gaps must be positive, got " + to_text(gap));
    require_finite(gap, "train: gaps");
  }
  require_finite(train.speed, "train: speed");
  require_finite(train.start, "train: start");
  if (!(train.wheel_radius > 0))
    throw std::invalid_argument("train: wheel_radius must be positive, got " + to_text(train.wheel_radius));
  require_finite(train.wheel_radius, "train: wheel_radius");
}

/// Makes bodies by `make`; if that throws, the world has none of them.
template <class Make>
void all_or_none(World& world, Make&& make) {
  const std::vector<std::uint8_t> before(world.bodies().alive.begin(), world.bodies().alive.end());
  try {
    make();
  } catch (...) {
    for (std::size_t i = 0; i < world.bodies().size(); ++i) {
      if (world.bodies().alive[i] && (i >= before.size() || !before[i])) world.destroy(world.body_id(i));
    }
    throw;
  }
}

/// Whether a beam is clamped to the node.
bool clamps(const Structure& s, int node) {
  return std::any_of(s.members.begin(), s.members.end(), [node](const Member& m) {
    return m.kind == MemberKind::Beam && ((m.a == node && !m.hinge_a) || (m.b == node && !m.hinge_b));
  });
}

}  // namespace

Bridge::Bridge(BridgeDef def, World& world) : def_(std::move(def)), gravity_(world.config().gravity) {
  validate(def_.structure);
  validate(def_.structure, def_.fixed);
  check_train(def_.train);
  if (!(def_.thickness > 0))
    throw std::invalid_argument("bridge: thickness must be positive, got " + to_text(def_.thickness));
  require_finite(def_.thickness, "bridge: thickness");
  if (def_.ground) require_finite(*def_.ground, "bridge: ground");
  // What cannot push cannot bend either.
  for (Member& member : def_.structure.members)
    if (member.cable) member.kind = MemberKind::Bar;
  const Structure& s = def_.structure;
  for (const NodeLoad& l : def_.fixed.nodes)
    if (l.moment != 0 && !clamps(s, l.node))
      throw std::invalid_argument("load: a moment of " + to_text(l.moment) + " N m on " +
                                  node_label(s, l.node) + ", where no beam is clamped");
  members_.resize(s.members.size());
  for (std::size_t i = 0; i < def_.deck.size(); ++i) {
    const int node = def_.deck[i];
    if (node < 0 || static_cast<std::size_t>(node) >= s.nodes.size())
      throw std::invalid_argument("deck: no node " + std::to_string(node + 1));
    if (i == 0) {
      stations_.push_back(0);
      continue;
    }
    const int before = def_.deck[i - 1];
    int joining = -1;
    for (std::size_t m = 0; m < s.members.size(); ++m) {
      const Member& member = s.members[m];
      if ((member.a == before && member.b == node) || (member.b == before && member.a == node))
        joining = static_cast<int>(m);
    }
    if (joining < 0)
      throw std::invalid_argument("deck: no member joins " + node_label(s, before) + " and " +
                                  node_label(s, node));
    deck_members_.push_back(joining);
    stations_.push_back(stations_.back() + member_length(s, joining));
  }
  if (!def_.train.axles.empty() && deck_members_.empty())
    throw std::invalid_argument("deck: a train needs at least two nodes to run on");

  rebuild_solver();
  if (!def_.dynamic) {
    solve(0);
    find_slack_cables();
    note_state(0);
  }
  // Sizes that are finite may still be too large or too small for shapes.
  all_or_none(world, [&] {
    make_scenery(world);
    if (def_.dynamic) {
      let_go(world);
      return;
    }
    make_fixed_members(world);
    if (!def_.train.axles.empty()) make_wagons(world, false);
  });
}

Bridge::DeckPlace Bridge::place(double distance) const {
  const Structure& s = def_.structure;
  const auto node_at = [&](std::size_t i) { return s.nodes[static_cast<std::size_t>(def_.deck[i])].at; };
  // Beside the bridge the way goes on level.
  if (distance < 0) return {-1, 0, node_at(0) + Vec2{distance, 0}};
  if (distance > stations_.back())
    return {-1, 0, node_at(def_.deck.size() - 1) + Vec2{distance - stations_.back(), 0}};
  std::size_t i = 0;
  while (i + 2 < stations_.size() && distance > stations_[i + 1]) ++i;
  const double share = std::min(1.0, (distance - stations_[i]) / (stations_[i + 1] - stations_[i]));
  const int member = deck_members_[i];
  const bool forward = s.members[static_cast<std::size_t>(member)].a == def_.deck[i];
  return {member, forward ? share : 1 - share, (1 - share) * node_at(i) + share * node_at(i + 1)};
}

std::vector<Bridge::Axle> Bridge::axles() const {
  std::vector<Axle> result;
  if (moving_ || stations_.empty()) return result;
  double at = def_.train.start + def_.train.speed * time_;
  for (std::size_t k = 0; k < def_.train.axles.size(); ++k) {
    if (k > 0) at -= def_.train.gaps[k - 1];
    result.push_back({place(at).at, length(weight(def_.train.axles[k])), at});
  }
  return result;
}

std::vector<BodyId> Bridge::wagons() const {
  std::vector<BodyId> result;
  for (const Wagon& wagon : wagons_) result.push_back(wagon.body);
  return result;
}

Vec2 Bridge::weight(double on_earth) const {
  return on_earth * (gravity_ / kStandardGravity);
}

void Bridge::add_axles(double front, Load& load) const {
  double at = front;
  for (std::size_t k = 0; k < def_.train.axles.size(); ++k) {
    if (k > 0) at -= def_.train.gaps[k - 1];
    const DeckPlace spot = place(at);
    if (spot.member >= 0) load.spans.push_back({spot.member, spot.share, weight(def_.train.axles[k])});
  }
}

void Bridge::rebuild_solver() {
  Structure rest;
  rest.nodes = def_.structure.nodes;
  rest.supports = def_.structure.supports;
  kept_.clear();
  solver_index_.assign(members_.size(), -1);
  for (std::size_t m = 0; m < members_.size(); ++m) {
    if (members_[m].broken || members_[m].slack) continue;
    solver_index_[m] = static_cast<int>(kept_.size());
    kept_.push_back(static_cast<int>(m));
    rest.members.push_back(def_.structure.members[m]);
  }
  solver_ = std::make_shared<StructureSolver>(std::move(rest));
}

void Bridge::solve(double time) {
  load_ = self_weight(def_.structure, gravity_);
  load_.nodes.insert(load_.nodes.end(), def_.fixed.nodes.begin(), def_.fixed.nodes.end());
  load_.spans.insert(load_.spans.end(), def_.fixed.spans.begin(), def_.fixed.spans.end());
  load_.lines.insert(load_.lines.end(), def_.fixed.lines.begin(), def_.fixed.lines.end());
  if (!def_.train.axles.empty()) add_axles(def_.train.start + def_.train.speed * time, load_);
  // Loads on members that are gone (broken, or slack cables with their weight) act on their nodes.
  solver_load_.clear();
  solver_load_.nodes = load_.nodes;
  // A moment on a node whose beams are broken turns nothing.
  for (NodeLoad& l : solver_load_.nodes)
    if (l.moment != 0 && !clamps(solver_->structure(), l.node)) l.moment = 0;
  const auto to_nodes = [&](int member, double share, Vec2 force) {
    const Member& m = def_.structure.members[static_cast<std::size_t>(member)];
    solver_load_.nodes.push_back({m.a, (1 - share) * force});
    solver_load_.nodes.push_back({m.b, share * force});
  };
  for (const SpanLoad& l : load_.spans) {
    const int index = solver_index_[static_cast<std::size_t>(l.member)];
    if (index >= 0)
      solver_load_.spans.push_back({index, l.share, l.force});
    else
      to_nodes(l.member, l.share, l.force);
  }
  for (const LineLoad& l : load_.lines) {
    const int index = solver_index_[static_cast<std::size_t>(l.member)];
    if (index >= 0)
      solver_load_.lines.push_back({index, l.force_per_length});
    else
      to_nodes(l.member, 0.5, member_length(def_.structure, l.member) * l.force_per_length);
  }
  solver_->solve(solver_load_, response_);
}

void Bridge::note_state(double time) {
  for (std::size_t m = 0; m < members_.size(); ++m) {
    MemberState& state = members_[m];
    const int index = solver_index_[m];
    state.axial = state.moment_a = state.moment_b = state.signed_use = 0;
    state.stress = {};
    if (index < 0) continue;
    const MemberForce& force = response_.members[static_cast<std::size_t>(index)];
    state.axial = force.axial;
    state.moment_a = force.moment_a;
    state.moment_b = force.moment_b;
    state.stress = member_stress(solver_->structure(), solver_load_, response_, index);
    state.signed_use = state.stress.squeezed ? -state.stress.utilisation : state.stress.utilisation;
    if (std::abs(state.signed_use) > std::abs(state.peak_use)) {
      state.peak_use = state.signed_use;
      state.peak_time = time;
    }
  }
}

void Bridge::advance(World& world, double time) {
  time_ = time;
  gravity_ = world.config().gravity;
  if (moving_) {
    measure(world, time);
    apply_fixed_loads(world);
    return;
  }
  solve(time);
  find_slack_cables();
  note_state(time);
  // The most loaded member goes first; what is left may still carry.
  while (def_.breaks && solver_->determinacy().stable()) {
    int worst = -1;
    for (std::size_t m = 0; m < members_.size(); ++m) {
      const double use = std::abs(members_[m].signed_use);
      if (use > 1 && (worst < 0 || use > std::abs(members_[static_cast<std::size_t>(worst)].signed_use)))
        worst = static_cast<int>(m);
    }
    if (worst < 0) break;
    MemberState& member = members_[static_cast<std::size_t>(worst)];
    member.broken = true;
    breaks_.push_back({worst, time, member.signed_use});
    rebuild_solver();
    // Without it cables that were slack may carry.
    solve(time);
    find_slack_cables();
    // A train cannot go on over a broken deck, whatever still stands.
    const bool deck = std::find(deck_members_.begin(), deck_members_.end(), worst) != deck_members_.end();
    if (!solver_->determinacy().stable() || (deck && !def_.train.axles.empty())) {
      let_go(world);
      return;
    }
    note_state(time);
  }
  if (!solver_->determinacy().stable()) {
    let_go(world);
    return;
  }
  pose_wagons(world);
}

int Bridge::worst() const {
  int result = -1;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    if (std::abs(members_[m].peak_use) >
        (result < 0 ? 0 : std::abs(members_[static_cast<std::size_t>(result)].peak_use)))
      result = static_cast<int>(m);
  }
  return result;
}

Bridge::Line Bridge::influence_line(const Quantity& quantity, int count) const {
  if (stations_.size() < 2) throw std::invalid_argument("influence line: the bridge has no deck");
  if (count < 1)
    throw std::invalid_argument("influence line: count must be positive, got " + std::to_string(count));
  StructureSolver solver(def_.structure);
  const StructureSolver::Influence influence = solver.influence(quantity);
  Line line;
  for (int i = 0; i <= count; ++i) {
    const double x = stations_.back() * i / count;
    const DeckPlace spot = place(x);
    Load unit;
    unit.spans.push_back({spot.member, spot.share, {0, -1}});
    line.x.push_back(x);
    line.value.push_back(solver.value(influence, unit));
  }
  return line;
}

double Bridge::influence_at(const Quantity& quantity, double x) const {
  if (stations_.size() < 2) throw std::invalid_argument("influence line: the bridge has no deck");
  const DeckPlace spot = place(x);
  if (spot.member < 0) return 0;
  StructureSolver solver(def_.structure);
  Load unit;
  unit.spans.push_back({spot.member, spot.share, {0, -1}});
  return solver.value(solver.influence(quantity), unit);
}

}  // namespace skerry::statics
