// SPDX-License-Identifier: MIT
#include "physics/stepping/kinematic.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// How far what moves as prescribed may stray from what is foretold, as a share of the thinner of two bodies,
// and how often a time is halved for that.
constexpr double kStray = 0.05, kForeseenPieces = 64;

}  // namespace

KinematicState kinematic_state(const WorldState& state, std::uint32_t body, double elapsed) {
  const BodyArrays& all = state.bodies;
  if (all.type[body] != BodyType::Kinematic) return {all.position[body], all.angle[body], {}, 0, {}, 0};
  if (state.prescribed[body]) return state.paths[body].at(elapsed);
  return {all.position[body] + elapsed * all.velocity[body],
          all.angle[body] + elapsed * all.omega[body],
          all.velocity[body],
          all.omega[body],
          {},
          0};
}

namespace {

/// How far what moves as prescribed is from where it is foretold to be, after a time and after half of it.
struct Stray {
  std::uint32_t body = BodyId::kNone;
  double time = 0;                           ///< [s]
  double way[2] = {0, 0}, turn[2] = {0, 0};  ///< [m], [rad]

  Stray() = default;
  Stray(const WorldState& state, std::uint32_t told, double elapsed, double t) : body(told), time(t) {
    const KinematicState now = kinematic_state(state, told, elapsed);
    for (int k = 0; k < 2; ++k, t *= 0.5) {
      const KinematicState there = kinematic_state(state, told, elapsed + t);
      way[k] = length(there.p - (now.p + t * (now.v + (0.5 * t) * now.a)));
      turn[k] = std::abs(there.angle - (now.angle + t * (now.omega + 0.5 * t * now.alpha)));
    }
  }
  /// Of a point that far from its centre [m].
  double at(double far) const { return std::max(way[0] + turn[0] * far, way[1] + turn[1] * far); }
};

}  // namespace

double foreseeable_length(const WorldState& state, const Island& island, double elapsed, double left) {
  double most = left;
  // Many lie on one table.
  Stray stray;
  const auto look = [&](std::uint32_t told, std::uint32_t other) {
    if (told == BodyId::kNone || !state.prescribed[told]) return;
    // Chains have no thickness.
    double thin = kInfinity;
    for (const std::uint32_t body : {told, other})
      if (const double own = state.thickness[body]; own > 0) thin = std::min(thin, own);
    const Vec2 middle = state.bodies.position[told];
    const double far = length(state.bodies.position[other] - middle) + state.radius[other];
    const double most_off =
        std::max(kStray * std::min(thin, state.paths[told].extent() + state.paths[told].turn() * far),
                 touch_tolerance(state, middle));
    for (;; most *= 0.5) {
      if (stray.body != told || stray.time != most) stray = Stray(state, told, elapsed, most);
      if (!(most > left / kForeseenPieces) || !(stray.at(far) > most_off)) return;
    }
  };
  for (const std::uint32_t index : island.contacts) {
    const Contact& contact = state.contacts[index];
    look(contact.body_a, contact.body_b);
    look(contact.body_b, contact.body_a);
  }
  return most;
}

void add_kinematic_path(const WorldState& state, std::uint32_t body, double h,
                        std::vector<PathPiece>& pieces) {
  const std::uint32_t generation = state.bodies.generation[body];
  if (state.prescribed[body]) return state.paths[body].append_to(pieces, body, generation);
  const BodyBackup& from = state.backup[body];
  PathPiece piece;
  piece.body = body;
  piece.generation = generation;
  piece.length = h;
  piece.c[0] = {from.position.x, h * from.velocity.x};
  piece.c[1] = {from.position.y, h * from.velocity.y};
  piece.c[2] = {from.angle, h * from.omega};
  pieces.push_back(piece);
}

}  // namespace skerry
