// SPDX-License-Identifier: MIT
#include "physics/stepping/motion_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "physics/text.h"

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

// Where a polynomial is compared with the motion, as shares of its time: no kink is missed at both.
constexpr double kChecks[2] = {0.5, 0.2885};
// It may be off by so much of what the motion goes meanwhile, besides rounding, and this [m, rad].
constexpr double kOff = 1e-6, kLeast = 1e-12;
// Times that hold a break are cut in this place, which round times are not, down to this share of the step.
constexpr double kCut = 0.4871, kShortest = 1e-13;
// A part holds a break if it is off by more than it may be, or than this share of the whole: what is smooth
// is a hundred times better there.
constexpr double kHolds = 1.0 / 16;
// Where no part does the break is in it if it is shorter than this share of the step; it is between them if
// the velocities differ by so many times what the whole was off by over its time (0.5 for what is smooth, 10
// and more for a kink); or if the whole was so many times off what it may be, where a pulse met a node. It is
// no farther from the cut than this share of its time.
constexpr double kSharp = 1e-2, kBend = 3, kWild = 1e4, kNear = 0.03;
// Breaks nearer to each other than this share of the step are one, and so near to an end of it they are
// there; so are those with no more than so many roundings of times, or of places, between them, by which no
// velocity is to be had; but none that are farther apart than the last share of the step.
constexpr double kApart = 1e-6, kRoundings = 1e6, kFarApart = 1e-2;
// With more breaks, or after asking so often, a motion is taken as it comes at the nodes.
constexpr std::size_t kMostBreaks = 8;
constexpr int kMostAsked = 10000;

// A time is after the end if it is by more of the step than sums of times are rounded.
constexpr double kAfter = 5e-14;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// How far the places of a motion are from the first of them, and from the origin, at most [m, rad].
struct Spread {
  double way = 0, turn = 0, far = 0, angle = 0;

  void add(const Placement& first, const Placement& place) {
    way = std::max(way, length(place.position - first.position));
    turn = std::max(turn, std::abs(place.angle - first.angle));
    far = std::max({far, std::abs(place.position.x), std::abs(place.position.y)});
    angle = std::max(angle, std::abs(place.angle));
  }
};

}  // namespace

/// Asks a motion in one step.
class MotionPath::Sampler {
 public:
  /// A short time with a break in it, since the beginning of the step [s].
  struct Gap {
    double from, to;
  };
  /// What a polynomial is off by between its nodes [m, rad].
  struct Miss {
    double way = 0, turn = 0;
  };
  /// A polynomial, and how well it fits.
  struct Fit {
    Part part;
    Placement first, last;
    Spread spread;
    Miss off, most, rounding;  ///< it is, may be, and is by rounding alone
    /// How many times it is off what it may be.
    double times() const { return std::max(off.way / most.way, off.turn / most.turn); }
    /// Whether two places are farther apart than it may be off.
    bool tells_apart(const Placement& x, const Placement& y) const {
      return skerry::length(x.position - y.position) > most.way || std::abs(x.angle - y.angle) > most.turn;
    }
  };

  Sampler(const PrescribedMotion& motion, double time, double h) : motion_(motion), time_(time), h_(h) {}

  Fit fit(double from, double to) {
    Fit fit;
    fit.part = {from, to - from, {}};
    for (std::size_t i = 0; i < kNodes; ++i) {
      const Placement place = ask(i + 1 < kNodes ? from + kPoints[i] * fit.part.length : to);
      if (i == 0) fit.first = place;
      fit.last = place;
      fit.spread.add(fit.first, place);
      fit.part.divided[0][i] = place.position.x;
      fit.part.divided[1][i] = place.position.y;
      fit.part.divided[2][i] = place.angle;
    }
    // f[x_i ... x_j] by columns, in place.
    for (auto& f : fit.part.divided) {
      for (std::size_t order = 1; order < kNodes; ++order) {
        for (std::size_t i = kNodes - 1; i >= order; --i)
          f[i] = (f[i] - f[i - 1]) / (kPoints[i] - kPoints[i - order]);
      }
    }
    // Times are rounded, too.
    const double time = kEpsilon * (std::abs(time_) + h_) / fit.part.length;
    fit.rounding = {kEpsilon * fit.spread.far + time * fit.spread.way,
                    kEpsilon * fit.spread.angle + time * fit.spread.turn};
    fit.most = {kLeast + kOff * fit.spread.way + 64 * fit.rounding.way,
                kLeast + kOff * fit.spread.turn + 64 * fit.rounding.turn};
    for (const double check : kChecks) {
      const double t = from + check * fit.part.length;
      const Placement place = ask(t);
      const KinematicState there = fit.part.state(t);
      fit.off.way = std::max(fit.off.way, skerry::length(there.p - place.position));
      fit.off.turn = std::max(fit.off.turn, std::abs(there.angle - place.angle));
    }
    return fit;
  }

  /// Looks for breaks in a step that is not smooth as a whole.
  void look(const Fit& step) {
    constexpr double kTooShort = kRoundings * kEpsilon;
    const Spread& spread = step.spread;
    apart_ = std::max(kApart * h_, kTooShort * (std::abs(time_) + h_));
    if (spread.way > 0) apart_ = std::max(apart_, kTooShort * spread.far / spread.way * h_);
    if (spread.turn > 0) apart_ = std::max(apart_, kTooShort * spread.angle / spread.turn * h_);
    apart_ = std::min(apart_, kFarApart * h_);
    // All parts of a size before smaller ones: what jitters has too many with a break soon.
    std::vector<Fit> level{step}, next;
    while (!level.empty() && !too_much_) {
      next.clear();
      for (const Fit& whole : level) divide(whole, next);
      too_much_ = asked_ > kMostAsked || found_.size() + next.size() > kMostBreaks;
      level.swap(next);
    }
    std::sort(found_.begin(), found_.end(), [](const Gap& x, const Gap& y) { return x.from < y.from; });
    std::vector<Gap> apart;
    for (const Gap& gap : found_) {
      if (!apart.empty() && gap.from - apart.back().to < apart_)
        apart.back().to = std::max(apart.back().to, gap.to);
      else
        apart.push_back(gap);
    }
    found_ = std::move(apart);
  }

  /// What is shorter is no part of the step [s].
  double apart() const { return apart_; }
  bool is_too_much() const { return too_much_; }
  /// Ascending.
  const std::vector<Gap>& found() const { return found_; }

 private:
  Placement ask(double t) {
    ++asked_;
    const Placement place = motion_(time_ + t);
    if (!is_finite(place.position) || !std::isfinite(place.angle)) {
      throw std::invalid_argument("prescribed motion: not finite at " + to_text(time_ + t) +
                                  " s: " + to_text(place.position) + ", " + to_text(place.angle));
    }
    return place;
  }

  /// @param next  takes the parts that hold a break
  void divide(const Fit& whole, std::vector<Fit>& next) {
    const double from = whole.part.from, length = whole.part.length, to = from + length;
    if (length <= std::max(kShortest * h_, 8 * kEpsilon * (std::abs(time_) + h_))) return note(from, to);
    const double middle = from + kCut * length;
    const Fit before = fit(from, middle), after = fit(middle, to);
    const bool in_first = holds_break(before, whole), in_second = holds_break(after, whole);
    // No part is better known than to rounding.
    if ((in_first && is_rounding(before)) || (in_second && is_rounding(after))) return note(from, to);
    if (in_first) next.push_back(before);
    if (in_second) next.push_back(after);
    if (in_first || in_second) return;
    if (length < kSharp * h_) return note(from, to);
    if (whole.times() > kWild || bends(whole, before, after, middle))
      note(middle - kNear * length, middle + kNear * length);
  }

  static bool holds_break(const Fit& part, const Fit& whole) {
    return part.times() > 1 || part.off.way > kHolds * whole.off.way + kLeast ||
           part.off.turn > kHolds * whole.off.turn + kLeast;
  }
  static bool is_rounding(const Fit& part) {
    return part.off.way <= 8 * part.rounding.way && part.off.turn <= 8 * part.rounding.turn;
  }

  /// Whether the velocities of two parts differ where they meet.
  static bool bends(const Fit& whole, const Fit& before, const Fit& after, double middle) {
    const KinematicState left = before.part.state(middle), right = after.part.state(middle);
    const double times = kBend / whole.part.length;
    return skerry::length(right.v - left.v) > times * whole.off.way + kLeast ||
           std::abs(right.omega - left.omega) > times * whole.off.turn + kLeast;
  }

  void note(double from, double to) { found_.push_back({from, to}); }

  const PrescribedMotion& motion_;
  double time_, h_;
  double apart_ = 0;
  bool too_much_ = false;
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

void MotionPath::sample(const PrescribedMotion& motion, double time, double h, const Placement& before) {
  h_ = h;
  parts_.clear();
  breaks_.clear();
  Sampler sampler(motion, time, h);
  const Sampler::Fit step = sampler.fit(0, h);
  parts_.push_back(step.part);
  end_ = step.last;
  extent_ = step.spread.way;
  turn_ = step.spread.turn;
  if (step.times() > 1) {
    sampler.look(step);
    if (!sampler.found().empty() && !sampler.is_too_much()) cut(sampler, step.first);
  }
  const KinematicState first = parts_.front().state(0), last = parts_.back().state(h);
  jump_before_ = step.tells_apart(before, {first.p, first.angle});
  jump_after_ = step.tells_apart({last.p, last.angle}, end_);
}

/// Puts a polynomial on either side of each break.
void MotionPath::cut(Sampler& sampler, const Placement& first) {
  const double h = h_;
  const Part whole = parts_.front();
  parts_.clear();
  double from = 0;
  const auto end_part = [&](double to) {
    if (!(to - from > sampler.apart())) return;
    const Sampler::Fit fit = sampler.fit(from, to);
    parts_.push_back(fit.part);
    extent_ = std::max(extent_, skerry::length(fit.first.position - first.position) + fit.spread.way);
    turn_ = std::max(turn_, std::abs(fit.first.angle - first.angle) + fit.spread.turn);
  };
  for (const Sampler::Gap& gap : sampler.found()) {
    const std::size_t before = parts_.size();
    end_part(gap.from);
    from = gap.to;
    if (parts_.size() > before && h - gap.to > sampler.apart()) breaks_.push_back(0.5 * (gap.from + gap.to));
  }
  end_part(h);
  // Where rounding hides all of the step nothing is known of its breaks.
  if (parts_.size() != breaks_.size() + 1) {
    parts_.assign(1, whole);
    breaks_.clear();
  }
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
  if (jump_after_ && t > h_ * (1 + kAfter)) {
    KinematicState there = parts_.back().state(h_);
    there.p = end_.position;
    there.angle = end_.angle;
    return there;
  }
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

}  // namespace skerry
