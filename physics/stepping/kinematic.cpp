// SPDX-License-Identifier: MIT
#include "physics/stepping/kinematic.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/stepping/touching.h"
#include "physics/text.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// (1 - cos(pi k / 7)) / 2: the points at which interpolation oscillates least.
constexpr double kPoints[8] = {0,
                               0.049515566048790436882,
                               0.18825509907063323478,
                               0.38873953302184279786,
                               0.61126046697815720214,
                               0.81174490092936676522,
                               0.95048443395120956312,
                               1};

// How far what moves as prescribed may stray from what is foretold, as a share of the thinner of two bodies,
// and how often a time is halved for that.
constexpr double kStray = 0.05, kForeseenPieces = 64;

}  // namespace

void MotionPath::sample(const PrescribedMotion& motion, double time, double h) {
  h_ = h;
  extent_ = turn_ = 0;
  Placement first;
  for (std::size_t i = 0; i < kNodes; ++i) {
    const Placement place = motion(i + 1 < kNodes ? time + kPoints[i] * h : time + h);
    if (!is_finite(place.position) || !std::isfinite(place.angle)) {
      throw std::invalid_argument("prescribed motion: not finite at " + to_text(time + kPoints[i] * h) +
                                  " s: " + to_text(place.position) + ", " + to_text(place.angle));
    }
    if (i == 0) first = place;
    divided_[0][i] = place.position.x;
    divided_[1][i] = place.position.y;
    divided_[2][i] = place.angle;
    extent_ = std::max(extent_, length(place.position - first.position));
    turn_ = std::max(turn_, std::abs(place.angle - first.angle));
    end_ = place;
  }
  // f[x_i ... x_j] by columns, in place.
  for (auto& f : divided_) {
    for (std::size_t order = 1; order < kNodes; ++order) {
      for (std::size_t i = kNodes - 1; i >= order; --i)
        f[i] = (f[i] - f[i - 1]) / (kPoints[i] - kPoints[i - order]);
    }
  }
}

KinematicState MotionPath::at(double t) const {
  const double s = t / h_;
  std::array<double, 3> value{}, rate{}, second{};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = kNodes; i-- > 0;) {
      const double d = s - kPoints[i];
      second[c] = second[c] * d + 2 * rate[c];
      rate[c] = rate[c] * d + value[c];
      value[c] = value[c] * d + divided_[c][i];
    }
  }
  return {{value[0], value[1]},
          value[2],
          {rate[0] / h_, rate[1] / h_},
          rate[2] / h_,
          {second[0] / (h_ * h_), second[1] / (h_ * h_)},
          second[2] / (h_ * h_)};
}

PathPiece MotionPath::piece() const {
  PathPiece piece;
  piece.length = h_;
  for (std::size_t c = 0; c < 3; ++c) {
    // Newton's form in powers of theta, then divided by theta and 1 - theta in turn: what is left over each
    // time is the next coefficient.
    std::array<double, kNodes> powers{};
    for (std::size_t i = kNodes; i-- > 0;) {
      for (std::size_t k = kNodes - 1; k > 0; --k) powers[k] = powers[k - 1] - kPoints[i] * powers[k];
      powers[0] = divided_[c][i] - kPoints[i] * powers[0];
    }
    for (std::size_t k = 0; k < kNodes; ++k) {
      const std::size_t degree = kNodes - 1 - k;
      if (k % 2 == 0) {
        piece.c[c][k] = powers[0];
        for (std::size_t m = 0; m < degree; ++m) powers[m] = powers[m + 1];
      } else {
        double quotient = 0;
        for (std::size_t m = degree + 1; m-- > 0;) {
          const double power = powers[m];
          powers[m] = -quotient;
          quotient += power;
        }
        piece.c[c][k] = quotient;
      }
    }
  }
  return piece;
}

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

PathPiece kinematic_path(const WorldState& state, std::uint32_t body, double h) {
  PathPiece piece;
  if (state.prescribed[body]) {
    piece = state.paths[body].piece();
  } else {
    const BodyBackup& from = state.backup[body];
    piece.length = h;
    piece.c[0] = {from.position.x, h * from.velocity.x};
    piece.c[1] = {from.position.y, h * from.velocity.y};
    piece.c[2] = {from.angle, h * from.omega};
  }
  piece.body = body;
  return piece;
}

}  // namespace skerry
