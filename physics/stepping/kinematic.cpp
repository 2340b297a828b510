// SPDX-License-Identifier: MIT
#include "physics/stepping/kinematic.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
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

// Where a polynomial is compared with the motion, as shares of its time: no kink is missed at both.
constexpr double kChecks[2] = {0.5, 0.2885};
// It may be off by so much of what the motion goes meanwhile, besides rounding [m, rad].
constexpr double kOff = 1e-6, kRounding = 1e-12;
// Times that hold a break are cut in this place, which round times are not, down to this share of the step;
// what is smooth in both parts of a time shorter than `kSharp` has its break between them.
constexpr double kCut = 0.4871, kShortest = 1e-13, kSharp = 1e-4;
// Breaks nearer to each other, or to an end of the step, than this share of it are one, or none.
constexpr double kApart = 1e-9;
// With more breaks, or after asking so often, a motion is taken as it comes at the nodes.
constexpr std::size_t kMostBreaks = 8;
constexpr int kMostAsked = 10000;

}  // namespace

/// Asks a motion in one step.
class MotionPath::Sampler {
 public:
  /// A short time with a break in it, since the beginning of the step [s].
  struct Gap {
    double from, to;
  };

  Sampler(const PrescribedMotion& motion, double time, double h) : motion_(motion), time_(time), h_(h) {}

  Placement ask(double t) {
    ++asked_;
    const Placement place = motion_(time_ + t);
    if (!is_finite(place.position) || !std::isfinite(place.angle)) {
      throw std::invalid_argument("prescribed motion: not finite at " + to_text(time_ + t) +
                                  " s: " + to_text(place.position) + ", " + to_text(place.angle));
    }
    return place;
  }

  /// @param places  at its nodes
  Part fit(double from, double to, std::array<Placement, kNodes>& places) {
    Part part{from, to - from, {}};
    for (std::size_t i = 0; i < kNodes; ++i) {
      places[i] = ask(i + 1 < kNodes ? from + kPoints[i] * part.length : to);
      part.divided[0][i] = places[i].position.x;
      part.divided[1][i] = places[i].position.y;
      part.divided[2][i] = places[i].angle;
    }
    // f[x_i ... x_j] by columns, in place.
    for (auto& f : part.divided) {
      for (std::size_t order = 1; order < kNodes; ++order) {
        for (std::size_t i = kNodes - 1; i >= order; --i)
          f[i] = (f[i] - f[i - 1]) / (kPoints[i] - kPoints[i - order]);
      }
    }
    return part;
  }

  /// Whether the motion is what a polynomial says between its nodes, too.
  bool is_smooth(const Part& part, const std::array<Placement, kNodes>& places) {
    double way = 0, turn = 0, far = 0, angle = 0;
    for (const Placement& place : places) {
      way = std::max(way, skerry::length(place.position - places[0].position));
      turn = std::max(turn, std::abs(place.angle - places[0].angle));
      far = std::max({far, std::abs(place.position.x), std::abs(place.position.y)});
      angle = std::max(angle, std::abs(place.angle));
    }
    // Times are rounded, too.
    constexpr double kEpsilon = 64 * std::numeric_limits<double>::epsilon();
    const double share = kOff + kEpsilon * (std::abs(time_) + h_) / part.length;
    const double most = kRounding + kEpsilon * far + share * way;
    const double most_turn = kRounding + kEpsilon * angle + share * turn;
    return std::all_of(std::begin(kChecks), std::end(kChecks), [&](double check) {
      const double t = part.from + check * part.length;
      const Placement place = ask(t);
      const KinematicState there = part.state(t);
      return std::abs(there.p.x - place.position.x) <= most &&
             std::abs(there.p.y - place.position.y) <= most &&
             std::abs(there.angle - place.angle) <= most_turn;
    });
  }

  /// Looks for breaks between two times of the step. @return whether the motion is smooth there
  bool look(double from, double to) {
    std::array<Placement, kNodes> places;
    const Part part = fit(from, to, places);
    if (is_smooth(part, places)) return true;
    if (is_too_much()) return false;
    const double length = to - from;
    const double shortest =
        std::max(kShortest * h_, 8 * std::numeric_limits<double>::epsilon() * (std::abs(time_) + h_));
    if (length <= shortest) {
      note(from, to);
      return false;
    }
    const double middle = from + kCut * length;
    const bool before = look(from, middle), after = look(middle, to);
    if (before && after && length < kSharp * h_) note(from, to);
    return false;
  }

  bool is_too_much() const { return asked_ > kMostAsked || found_.size() > kMostBreaks; }
  /// Ascending.
  const std::vector<Gap>& found() const { return found_; }

 private:
  void note(double from, double to) {
    if (!found_.empty() && from - found_.back().to < kApart * h_)
      found_.back().to = to;
    else
      found_.push_back({from, to});
  }

  const PrescribedMotion& motion_;
  double time_, h_;
  int asked_ = 0;
  std::vector<Gap> found_;
};

KinematicState MotionPath::Part::state(double t) const {
  const double s = (t - from) / length;
  std::array<double, 3> value{}, rate{}, second{};
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = kNodes; i-- > 0;) {
      const double d = s - kPoints[i];
      second[c] = second[c] * d + 2 * rate[c];
      rate[c] = rate[c] * d + value[c];
      value[c] = value[c] * d + divided[c][i];
    }
  }
  return {{value[0], value[1]},
          value[2],
          {rate[0] / length, rate[1] / length},
          rate[2] / length,
          {second[0] / (length * length), second[1] / (length * length)},
          second[2] / (length * length)};
}

void MotionPath::sample(const PrescribedMotion& motion, double time, double h) {
  h_ = h;
  parts_.clear();
  breaks_.clear();
  extent_ = turn_ = 0;
  Sampler sampler(motion, time, h);
  std::array<Placement, kNodes> places;
  parts_.push_back(sampler.fit(0, h, places));
  end_ = places.back();
  const Placement first = places.front();
  const auto reach = [&] {
    for (const Placement& place : places) {
      extent_ = std::max(extent_, skerry::length(place.position - first.position));
      turn_ = std::max(turn_, std::abs(place.angle - first.angle));
    }
  };
  reach();
  if (sampler.is_smooth(parts_.front(), places)) return;
  sampler.look(0, h);
  if (sampler.found().empty() || sampler.is_too_much()) return;
  parts_.clear();
  double from = 0;
  const auto end_part = [&](double to) {
    if (!(to - from > kApart * h)) return;
    parts_.push_back(sampler.fit(from, to, places));
    reach();
  };
  for (const Sampler::Gap& gap : sampler.found()) {
    const std::size_t before = parts_.size();
    end_part(gap.from);
    from = gap.to;
    if (parts_.size() > before && h - gap.to > kApart * h) breaks_.push_back(0.5 * (gap.from + gap.to));
  }
  end_part(h);
  sharpen_breaks();
}

/// A kink is where the polynomials on both sides meet.
void MotionPath::sharpen_breaks() {
  const auto numbers = [](const KinematicState& s, bool rates) {
    return rates ? std::array{s.v.x, s.v.y, s.omega} : std::array{s.p.x, s.p.y, s.angle};
  };
  for (std::size_t k = 0; k < breaks_.size(); ++k) {
    const double t = breaks_[k];
    const KinematicState left = parts_[k].state(t), right = parts_[k + 1].state(t);
    const double gap = parts_[k + 1].from - (parts_[k].from + parts_[k].length);
    double sum = 0, squares = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double bend = numbers(right, true)[c] - numbers(left, true)[c];
      sum += bend * (numbers(right, false)[c] - numbers(left, false)[c]);
      squares += bend * bend;
    }
    if (squares > 0 && std::abs(sum) <= gap * squares) breaks_[k] -= sum / squares;
  }
}

KinematicState MotionPath::at(double t) const {
  const auto later = std::upper_bound(breaks_.begin(), breaks_.end(), t);
  return parts_[static_cast<std::size_t>(later - breaks_.begin())].state(t);
}

void MotionPath::append_to(std::vector<PathPiece>& pieces, std::uint32_t body,
                           std::uint32_t generation) const {
  for (const Part& part : parts_) {
    PathPiece piece;
    piece.body = body;
    piece.generation = generation;
    piece.begin = part.from;
    piece.length = part.length;
    for (std::size_t c = 0; c < 3; ++c) {
      // Newton's form in powers of theta, then divided by theta and 1 - theta in turn: what is left over each
      // time is the next coefficient.
      std::array<double, kNodes> powers{};
      for (std::size_t i = kNodes; i-- > 0;) {
        for (std::size_t k = kNodes - 1; k > 0; --k) powers[k] = powers[k - 1] - kPoints[i] * powers[k];
        powers[0] = part.divided[c][i] - kPoints[i] * powers[0];
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
    pieces.push_back(piece);
  }
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
