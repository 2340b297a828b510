// SPDX-License-Identifier: MIT
#include "physics/stepping/travel.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/flow_work.h"

namespace skerry {
namespace {

// Shares of the smallest half width; the second one where there is much work and no joints pull: else
// overlaps come from elsewhere, and steps that are made again are in vain.
constexpr double kOverrun = 0.5, kFineOverrun = 1e-4;

/// What is noted of a way beyond which the world looks again.
double forgiven(const WorldState& state, double way, double bound, std::uint32_t body, bool in_flow) {
  const bool little = in_flow && way <= bound + little_overrun(state, body);
  return little ? std::min(way, bound) : way;
}

}  // namespace

void fly(WorldState& state, std::uint32_t body, double from, double h) {
  BodyArrays& all = state.bodies;
  const Vec2 v0 = all.velocity[body];
  const double w0 = all.omega[body];
  all.velocity[body] = v0 + h * state.acceleration[body];
  all.omega[body] = w0 + h * state.angular_acceleration[body];
  all.position[body] += 0.5 * h * (v0 + all.velocity[body]);
  const double turn = 0.5 * h * (w0 + all.omega[body]);
  if (turn != 0) {
    all.angle[body] += turn;
    all.rotation[body] = Rot::from_angle(all.angle[body]);
  }
  note_travel(state, body, from, h, {v0.x, v0.y, w0},
              {all.velocity[body].x, all.velocity[body].y, all.omega[body]});
}

double length_of_shift(const WorldState& state, std::uint32_t body, const std::array<double, 3>& shift) {
  return length(Vec2{shift[0], shift[1]}) + std::abs(shift[2]) * state.radius[body];
}

double speed_astray(const WorldState& state, std::uint32_t body, const std::array<double, 3>& v,
                    double time) {
  const Way& way = state.way[body];
  const double turn = way.omega + time * way.alpha;
  return length(Vec2{v[0], v[1]} - (way.v + time * way.a)) + std::abs(v[2] - turn) * state.radius[body];
}

void note_travel(WorldState& state, std::uint32_t body, double from, double t,
                 const std::array<double, 3>& before, const std::array<double, 3>& after) {
  state.travelled[body] +=
      t * (std::max(length(Vec2{before[0], before[1]}), length(Vec2{after[0], after[1]})) +
           std::max(std::abs(before[2]), std::abs(after[2])) * state.radius[body]);
  if (state.flight[body] == FlightKind::Bent) return;
  state.strayed[body] +=
      t * std::max(speed_astray(state, body, before, from), speed_astray(state, body, after, from + t));
}

void note_shift(WorldState& state, std::uint32_t body, const std::array<double, 3>& shift) {
  const double way = length_of_shift(state, body, shift);
  state.travelled[body] += way;
  state.strayed[body] += way;
}

void note_way(WorldState& state, std::uint32_t body, double way, bool in_flow) {
  double& all = state.travelled[body];
  all = forgiven(state, all + way, state.reach[body], body, in_flow);
}

void note_way_astray(WorldState& state, std::uint32_t body, double way, bool in_flow) {
  if (state.flight[body] == FlightKind::Bent) return;
  double& all = state.strayed[body];
  all = forgiven(state, all + way, state.allowance[body], body, in_flow);
}

void shift_body(WorldState& state, std::uint32_t body, const std::array<double, 3>& shift) {
  BodyArrays& all = state.bodies;
  all.position[body] += Vec2{shift[0], shift[1]};
  if (shift[2] != 0) {
    all.angle[body] += shift[2];
    all.rotation[body] = Rot::from_angle(all.angle[body]);
  }
}

bool left_its_reach(const WorldState& state, std::uint32_t body) {
  const double slack = 0.5 * state.config.contact_margin, travelled = state.travelled[body];
  const bool astray =
      state.flight[body] == FlightKind::Fast && state.strayed[body] > state.allowance[body] + slack;
  return (travelled > state.reach[body] + slack || astray) && std::isfinite(travelled);
}

double overrun(const WorldState& state, std::uint32_t body) {
  return state.bodies.type[body] == BodyType::Dynamic ? kOverrun * state.thickness[body] : 0;
}

double little_overrun(const WorldState& state, std::uint32_t body) {
  const bool finely = state.joints_of[body].empty() && works_finely(state);
  return (finely ? kFineOverrun / kOverrun : 1) * overrun(state, body);
}

}  // namespace skerry
