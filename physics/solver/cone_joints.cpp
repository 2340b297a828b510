// SPDX-License-Identifier: MIT
#include "physics/solver/cone_joints.h"

#include <algorithm>
#include <cmath>

#include "physics/index.h"

namespace skerry {
namespace {

// Proximal weight of a row, of D: what a step leaves over, of what it changes.
constexpr double kProximal = 1e-10;
// Impulses begin so far within their bounds, of the way from one to the other.
constexpr double kInside = 0.25;

double sum(const Vec4& x) {
  return (x[0] + x[1]) + (x[2] + x[3]);
}

}  // namespace

void ConeJoints::clear() {
  joints_.clear();
  sides_ = 0;
}

void ConeJoints::add(const IslandSystem& system, int index, std::array<int, 2> positions,
                     const BlockPattern& pattern, const std::vector<BodyVector>& mass, int ground) {
  const Row& row = system.rows[at(index)];
  const auto [a, b] = positions;
  Joint joint;
  joint.low = std::min(a, b);
  joint.high = std::max(a, b);
  joint.block = joint.high < ground ? pattern.block(joint.low, joint.high) : -1;
  joint.row = index;
  const Vec4 Ja{row.Ja[0], row.Ja[1], row.Ja[2], 0}, Jb{row.Jb[0], row.Jb[1], row.Jb[2], 0};
  const Vec4 &low_mass = mass[at(joint.low)].v, &high_mass = mass[at(joint.high)].v;
  joint.low_row.v = (a <= b ? Ja : Jb) * low_mass;
  joint.high_row.v = (a <= b ? Jb : Ja) * high_mass;
  joint.root = std::sqrt(sum(joint.low_row.v * joint.low_row.v) + sum(joint.high_row.v * joint.high_row.v));
  // What nothing moves has no impulse, nor what has no room.
  if (!(joint.root > 0) || row.lower == row.upper) return;
  joint.low_row.v /= joint.root;
  joint.high_row.v /= joint.root;
  const double D = joint.root * joint.root;
  joint.b = system.b[at(index)];
  joint.give = system.compliance.empty() ? 0 : system.compliance[at(index)] / D;
  // Angular rows turn the ends of the bodies by what they have for a radius of gyration.
  const bool angular = Ja[0] == 0 && Ja[1] == 0 && Jb[0] == 0 && Jb[1] == 0;
  const double linear = std::sqrt(low_mass[0] * low_mass[0] + high_mass[0] * high_mass[0]);
  if (angular && linear > 0) joint.unit = linear / joint.root;
  joint.least = row.lower;
  joint.most = row.upper;
  if (std::isfinite(row.lower)) joint.sides[0] = {.is = true, .bound = D * row.lower};
  if (std::isfinite(row.upper)) joint.sides[1] = {.is = true, .bound = D * row.upper};
  sides_ += joint.sides[0].is + joint.sides[1].is;
  joints_.push_back(joint);
}

void ConeJoints::finish(int nodes, double middle) {
  // Products are halfway between velocities and energies, as those of contacts are.
  for (Joint& joint : joints_) {
    joint.weight = joint.root / (joint.unit * middle);
    joint.inverse_weight = 1 / joint.weight;
  }
  incidence_.assign(joints_, nodes);
}

void ConeJoints::start(std::span<const double> lambda, double centre) {
  const double square = centre * centre;
  for (Joint& joint : joints_) {
    joint.impulse = lambda[at(joint.row)] * joint.root * joint.root;
    if (!std::isfinite(joint.impulse)) joint.impulse = 0;
    const auto& [lower, upper] = joint.sides;
    const double room = lower.is && upper.is ? upper.bound - lower.bound : kInfinity;
    const double inside = std::min(centre / joint.unit, kInside * room);
    if (lower.is) joint.impulse = std::max(joint.impulse, lower.bound + inside);
    if (upper.is) joint.impulse = std::min(joint.impulse, upper.bound - inside);
    // Away from the middle of a narrow room what presses from both sides would be far apart, and no step
    // could bring it together.
    if (room < 2 * centre / joint.unit) joint.impulse = 0.5 * (lower.bound + upper.bound);
    for (const int e : {0, 1}) {
      Side& side = joint.sides[at(e)];
      if (!side.is) continue;
      side.slack = e == 0 ? joint.impulse - side.bound : side.bound - joint.impulse;
      side.press = square * joint.weight / side.slack;
    }
  }
}

void ConeJoints::get(std::vector<double>& lambda) const {
  for (const Joint& joint : joints_)
    lambda[at(joint.row)] = std::clamp(joint.impulse / (joint.root * joint.root), joint.least, joint.most);
}

double ConeJoints::products() const {
  double all = 0;
  for (const Joint& joint : joints_)
    for (const Side& side : joint.sides)
      if (side.is) all += side.slack * side.press * joint.inverse_weight;
  return all;
}

void ConeJoints::act() {
  for (Joint& joint : joints_) joint.push = joint.impulse / joint.root;
}

void ConeJoints::push(std::vector<BodyVector>& y) const {
  for (const Joint& joint : joints_) {
    y[at(joint.low)].v += joint.low_row.v * joint.push;
    y[at(joint.high)].v += joint.high_row.v * joint.push;
  }
}

double ConeJoints::velocity(const Joint& joint, const std::vector<BodyVector>& y) {
  return joint.root * sum(joint.low_row.v * y[at(joint.low)].v + joint.high_row.v * y[at(joint.high)].v);
}

double ConeJoints::measure(const std::vector<BodyVector>& y) {
  double squares = 0;
  for (Joint& joint : joints_) {
    joint.wrong = velocity(joint, y) - joint.b + joint.give * joint.impulse;
    joint.stiffness = joint.give + kProximal;
    for (const int e : {0, 1}) {
      Side& side = joint.sides[at(e)];
      if (!side.is) continue;
      joint.wrong += e == 0 ? -side.press : side.press;
      joint.stiffness += side.press / side.slack;
      side.rest = 0;
    }
    joint.stiffness = 1 / joint.stiffness;
    const double off = joint.unit * joint.wrong;
    squares += off * off;
  }
  return squares;
}

void ConeJoints::fill(int position, bool general, BlockFactor& factor) const {
  for (const ConeIncidence::Incident& e : incidence_.of(position)) {
    const Joint& joint = joints_[at(e.item)];
    const Vec4 low = joint.low_row.v * joint.stiffness, high = joint.high_row.v * joint.stiffness;
    const Vec4& own = e.is_high ? high : low;
    const Vec4& row = e.is_high ? joint.high_row.v : joint.low_row.v;
    for (int c = 0; c < 3; ++c) factor.diagonal(position).column[c] += own * row[c];
    if (e.is_high || joint.block < 0) continue;
    for (int c = 0; c < 3; ++c) factor.lower(joint.block).column[c] += high * joint.low_row.v[c];
    if (!general) continue;
    for (int c = 0; c < 3; ++c) factor.upper(joint.block).column[c] += high * joint.low_row.v[c];
  }
}

// By how much the impulse would change if the bodies went on as they move, over the stiffness.
double ConeJoints::towards(const Joint& joint, double target) {
  double all = -joint.wrong;
  for (const int e : {0, 1}) {
    const Side& side = joint.sides[at(e)];
    if (!side.is) continue;
    const double more = (target * joint.weight - side.rest) / side.slack - side.press;
    all += e == 0 ? more : -more;
  }
  return all;
}

void ConeJoints::aim(double target) {
  for (Joint& joint : joints_) joint.push = joint.stiffness * towards(joint, target) / joint.root;
}

double ConeJoints::direct(const std::vector<BodyVector>& y, double target) {
  double fall = 0;
  for (Joint& joint : joints_) {
    joint.change = joint.stiffness * (towards(joint, target) - velocity(joint, y));
    for (const int e : {0, 1}) {
      Side& side = joint.sides[at(e)];
      if (!side.is) continue;
      side.d_slack = e == 0 ? joint.change : -joint.change;
      side.d_press =
          (target * joint.weight - side.rest - side.press * (side.slack + side.d_slack)) / side.slack;
      fall = std::max({fall, -side.d_slack / side.slack, -side.d_press / side.press});
    }
  }
  return fall;
}

double ConeJoints::predict(double length) {
  double all = 0;
  for (Joint& joint : joints_)
    for (Side& side : joint.sides) {
      if (!side.is) continue;
      all +=
          (side.slack + length * side.d_slack) * (side.press + length * side.d_press) * joint.inverse_weight;
      side.rest = side.d_slack * side.d_press;
    }
  return all;
}

void ConeJoints::move(double length, double least) {
  for (Joint& joint : joints_) {
    joint.impulse += length * joint.change;
    for (Side& side : joint.sides) {
      side.slack += length * side.d_slack;
      side.press += length * side.d_press;
      const double wanted = least * joint.weight;
      if (side.is && side.slack * side.press < wanted && side.press < side.slack)
        side.press = wanted / side.slack;
    }
  }
}

}  // namespace skerry
