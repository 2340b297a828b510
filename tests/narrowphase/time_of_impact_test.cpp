// SPDX-License-Identifier: MIT
#include "physics/narrowphase/time_of_impact.h"

#include <gtest/gtest.h>

#include "physics/narrowphase/collide.h"
#include "physics/narrowphase/queries.h"
#include "tests/narrowphase/oracle.h"

namespace skerry {
namespace time_of_impact_test {

using oracle::Scenes;

long double distance_at(const Shape& a, const Motion& ma, const Shape& b, const Motion& mb, long double t) {
  // Poses in long double, so that the oracle's own rounding does not move the root.
  const auto corners = [&](const Shape& shape, const Motion& m) {
    const long double angle = m.angle0 + t * (m.omega + 0.5L * t * m.alpha);
    const long double c = std::cos(angle), s = std::sin(angle);
    const long double px = static_cast<long double>(m.p0.x) - ma.p0.x + t * (m.v.x + 0.5L * t * m.a.x);
    const long double py = static_cast<long double>(m.p0.y) - ma.p0.y + t * (m.v.y + 0.5L * t * m.a.y);
    std::vector<oracle::Point> out;
    for (const Vec2 v : shape.vertices) out.push_back({c * v.x - s * v.y + px, s * v.x + c * v.y + py});
    return out;
  };
  return oracle::signed_distance(corners(a, ma), corners(b, mb)) - a.radius - b.radius;
}

/// First crossing of `target` from above, by sampling and bisection in long double; t_max if there is none.
long double sampled_impact(const Shape& a, const Motion& ma, const Shape& b, const Motion& mb, double t_max,
                           double target, int samples) {
  long double before = 0;
  for (int i = 1; i <= samples; ++i) {
    const long double t = static_cast<long double>(t_max) * i / samples;
    if (distance_at(a, ma, b, mb, t) > target) {
      before = t;
      continue;
    }
    long double low = before, high = t;
    for (int k = 0; k < 80; ++k) {
      const long double middle = 0.5L * (low + high);
      (distance_at(a, ma, b, mb, middle) > target ? low : high) = middle;
    }
    return high;
  }
  return t_max;
}

TEST(TimeOfImpact, OfTwoDiscsIsTheRootOfTheQuadratic) {
  const unsigned seed = 31;
  Scenes scenes(seed);
  int hits = 0;
  for (int k = 0; k < test_scale(100000); ++k) {
    const Shape a = make_disc(scenes.uniform(0.1, 1)), b = make_disc(scenes.uniform(0.1, 1));
    const Motion ma{.p0 = 1e3 * scenes.direction(),
                    .angle0 = 0,
                    .v = 3 * scenes.direction(),
                    .omega = 7,
                    .a = {0, -9.81}};
    const Vec2 start = ma.p0 + scenes.uniform(2.1, 10) * scenes.direction();
    const Motion mb{.p0 = start, .angle0 = 1, .v = 20 * scenes.direction(), .omega = -3, .a = {0, -9.81}};
    const ImpactTime impact = time_of_impact(a, ma, b, mb, 1);
    const long double dx = static_cast<long double>(mb.p0.x) - ma.p0.x,
                      dy = static_cast<long double>(mb.p0.y) - ma.p0.y;
    const long double vx = static_cast<long double>(mb.v.x) - ma.v.x,
                      vy = static_cast<long double>(mb.v.y) - ma.v.y;
    const long double r = static_cast<long double>(a.radius) + b.radius;
    const long double qa = vx * vx + vy * vy, qb = dx * vx + dy * vy, qc = dx * dx + dy * dy - r * r;
    const long double square = qb * qb - qa * qc;
    const long double truth = square < 0 || qb >= 0 ? INFINITY : qc / (-qb + std::sqrt(square));
    if (std::abs(square) < 1e-4L * qb * qb) continue;  // grazing
    ASSERT_EQ(impact.hit, truth <= 1) << "case " << k << " seed " << seed;
    if (!impact.hit) continue;
    ++hits;
    ASSERT_NEAR(static_cast<double>(impact.t - truth), 0, 1e-12) << "case " << k << " seed " << seed;
  }
  EXPECT_GT(hits, 1000);
}

TEST(TimeOfImpact, FollowsBallisticFlightOntoAHalfPlaneAndADisc) {
  const Shape ball = make_disc(0.25), ground = make_half_plane({0, 0}, {0, 1}), rock = make_disc(0.5);
  const Motion still;
  const Motion flight{.p0 = {0, 3}, .v = {0, 2}, .a = {0, -9.81}};
  const double fall = 2.75;  // height of the lowest point
  const ImpactTime down = time_of_impact(ground, still, ball, flight, 5);
  ASSERT_TRUE(down.hit);
  EXPECT_NEAR(down.t, (2 + std::sqrt(4 + 2 * 9.81 * fall)) / 9.81, 1e-14);
  const ImpactTime head_on = time_of_impact(ball, flight, rock, still, 5);
  ASSERT_TRUE(head_on.hit);
  EXPECT_NEAR(head_on.t, (2 + std::sqrt(4 + 2 * 9.81 * (3 - 0.75))) / 9.81, 1e-14);
  // Thrown past it sideways: the quartic's root by sampling.
  const Motion aside{.p0 = {-2, 1}, .v = {3, 3}, .a = {0, -9.81}};
  const ImpactTime side = time_of_impact(ball, aside, rock, still, 5);
  ASSERT_TRUE(side.hit);
  EXPECT_NEAR(side.t, static_cast<double>(sampled_impact(ball, aside, rock, still, 5, 0, 20000)), 5e-12);
  EXPECT_TRUE(side.converged);
}

TEST(TimeOfImpact, AgreesWithFineSamplingForTurningPolygons) {
  const unsigned seed = 77;
  Scenes scenes(seed);
  int hits = 0, most = 0;
  for (int k = 0; k < test_scale(250); ++k) {
    const Shape a = scenes.shape(1), b = scenes.shape(scenes.uniform(0.3, 2));
    const double w = scenes.below(3) == 0 ? 0 : 30;
    Motion ma{.p0 = {}, .angle0 = scenes.angle(), .v = scenes.direction(), .omega = scenes.uniform(-w, w)};
    Motion mb{.p0 = scenes.uniform(2, 5) * scenes.direction(),
              .angle0 = scenes.angle(),
              .v = {},
              .omega = scenes.uniform(-w, w)};
    mb.v = scenes.uniform(5, 30) * (scenes.uniform(-0.3, 0.3) * scenes.direction() - mb.p0 / length(mb.p0));
    if (scenes.below(2) == 0) mb.a = {0, -9.81};
    if (scenes.below(3) == 0) ma.alpha = scenes.uniform(-40, 40);
    const double target = scenes.below(2) == 0 ? 0 : 0.01;
    if (distance_at(a, ma, b, mb, 0) <= target) continue;
    const ImpactTime impact = time_of_impact(a, ma, b, mb, 0.25, target);
    const long double truth = sampled_impact(a, ma, b, mb, 0.25, target, 1500);
    ASSERT_TRUE(impact.converged) << "case " << k << " seed " << seed;
    most = std::max(most, impact.iterations);
    if (!impact.hit) {
      ASSERT_EQ(truth, 0.25) << "case " << k << " seed " << seed;
      continue;
    }
    ++hits;
    // A graze between two samples is seen by the search only; it must be one.
    if (impact.t < truth - 1e-9) {
      ASSERT_NEAR(static_cast<double>(distance_at(a, ma, b, mb, impact.t) - target), 0, 1e-12)
          << "case " << k << " seed " << seed;
      continue;
    }
    const double speed = static_cast<double>((distance_at(a, ma, b, mb, impact.t - 1e-7) - target) / 1e-7L);
    ASSERT_NEAR(static_cast<double>(impact.t - truth), 0, 0.25e-9 + 1e-14 / std::max(speed, 1e-9))
        << "case " << k << " seed " << seed << " iterations " << impact.iterations;
  }
  EXPECT_GT(hits, test_scale(100));
  std::printf("%d hits, at most %d evaluations\n", hits, most);
}

TEST(TimeOfImpact, StopsABulletOfTenThousandSizesAStepAtAThinWall) {
  const Shape wall = make_box({0.01, 4});
  Scenes scenes(3);
  for (const Shape& bullet :
       {make_disc(0.05), make_box({0.1, 0.1}), make_capsule({-0.04, 0}, {0.04, 0}, 0.01)}) {
    for (int k = 0; k < 1000; ++k) {
      const double start = scenes.uniform(1, 900);
      const Motion flight{.p0 = {-start, scenes.uniform(-1.5, 1.5)},
                          .angle0 = scenes.angle(),
                          .v = {1000, 0},
                          .omega = scenes.uniform(-100, 100)};
      const Motion still{.p0 = {}, .angle0 = scenes.uniform(-0.05, 0.05)};
      const ImpactTime impact = time_of_impact(bullet, flight, wall, still, 1);
      ASSERT_TRUE(impact.hit && impact.converged) << k;
      const Manifold m = collide(bullet, flight.at(impact.t), wall, still.at(impact.t), 1e-6);
      ASSERT_GE(m.count, 1);
      ASSERT_NEAR(m.points[0].separation, 0, 1e-10);
      ASSERT_GT(m.normal.x, 0.9);
    }
  }
}

TEST(TimeOfImpact, StopsARodThatSpinsAThousandRadiansASecond) {
  // The rod's tip passes the peg within 1e-3 rad/s * r; the impact angle has a closed form.
  const Shape rod = make_box({2, 0.01}), peg = make_disc(0.02);
  for (const double omega : {1000.0, -1000.0, 50.0}) {
    for (const double at : {0.1, 0.5, 0.9}) {
      const Motion spin{.p0 = {}, .angle0 = 0, .v = {}, .omega = omega};
      const Motion still{.p0 = {0, at}};
      const ImpactTime impact = time_of_impact(rod, spin, peg, still, 1.0 / 60);
      // Contact of the rod's flat side: distance of the peg's centre from the rod's axis is 0.005 + 0.02.
      const double angle = kPi / 2 - std::asin(0.025 / at);
      const double truth = angle / std::abs(omega);
      ASSERT_EQ(impact.hit, truth < 1.0 / 60) << omega << " " << at;
      if (impact.hit) {
        EXPECT_NEAR(impact.t, truth, 1e-11 / 60);
      }
      EXPECT_TRUE(impact.converged);
    }
  }
}

TEST(TimeOfImpact, ReportsATouchingStartOnlyIfItApproaches) {
  const Shape ball = make_disc(0.5), box = make_box({1, 1}), ground = make_half_plane({0, 0}, {0, 1});
  for (const Shape* shape : {&ball, &box}) {
    const Motion still;
    const auto with = [&](double vy, double ay) {
      return Motion{.p0 = {0, 0.5}, .v = {1, vy}, .a = {0, ay}};
    };
    ImpactTime impact = time_of_impact(ground, still, *shape, with(-1, 0), 1);
    EXPECT_TRUE(impact.hit);
    EXPECT_EQ(impact.t, 0);
    EXPECT_FALSE(time_of_impact(ground, still, *shape, with(1, 0), 1).hit);
    EXPECT_FALSE(time_of_impact(ground, still, *shape, with(0, 0), 1).hit);
    impact = time_of_impact(ground, still, *shape, with(0, -10), 1);
    EXPECT_TRUE(impact.hit);
    EXPECT_EQ(impact.t, 0);
    EXPECT_FALSE(time_of_impact(ground, still, *shape, with(0, 10), 1).hit);
    // It leaves and comes back within the step.
    impact = time_of_impact(ground, still, *shape, with(2, -10), 1);
    EXPECT_TRUE(impact.hit);
    EXPECT_NEAR(impact.t, 0.4, 1e-14);
    // On a box that is long enough, and beside one that it has left by then.
    impact = time_of_impact(make_box({1, 1}), {.p0 = {0, -0.5}}, *shape, with(2, -10), 0.5);
    EXPECT_TRUE(impact.hit);
    EXPECT_NEAR(impact.t, 0.4, 1e-14);
    EXPECT_FALSE(
        time_of_impact(make_box({0.1, 1}, {-0.3, 0}), {.p0 = {0, -0.5}}, make_disc(0.5), with(2, -1), 1).hit);
  }
}

TEST(TimeOfImpact, KeepsATargetDistance) {
  const Shape box = make_box({1, 1});
  const ImpactTime impact = time_of_impact(box, {}, box, {.p0 = {0, 3}, .v = {0, -1}}, 5, 0.25);
  ASSERT_TRUE(impact.hit);
  EXPECT_NEAR(impact.t, 1.75, 1e-15);
}

TEST(TimeOfImpact, AtItsWorkLimitStopsBeforeTheImpactAndSaysSo) {
  // Two whisks that mesh: they turn against each other, a quarter turn apart, and miss by a hair twice a
  // turn.
  const Shape blade = make_box({2, 0.01});
  for (const double hair : {1e-2, 1e-3, 1e-4}) {
    for (const double omega : {1e5, -1e6, 1e9}) {
      for (const double drift : {0.0, -1e-3}) {
        const Motion left{.angle0 = 0.3, .omega = omega};
        const Motion right{
            .p0 = {1.005 + hair, 0}, .angle0 = kPi / 2 - 0.3, .v = {drift, 0}, .omega = -omega};
        const ImpactTime impact = time_of_impact(blade, left, blade, right, 1);
        ASSERT_TRUE(impact.hit) << hair << " " << omega;
        ASSERT_FALSE(impact.converged) << hair << " " << omega;
        ASSERT_LE(impact.iterations, 1010);
        ASSERT_GT(impact.t, 0);
        // What it has come past is free.
        for (int i = 0; i <= 500; ++i) {
          ASSERT_GT(distance_at(blade, left, blade, right, impact.t * i / 500), 0) << hair << " " << omega;
        }
      }
    }
  }
  // The same whisks too close together: the impact is found within the first turn.
  const Motion left{.angle0 = 0.3, .omega = 1e6};
  const Motion right{.p0 = {1.004, 0}, .angle0 = kPi / 2 - 0.3, .omega = -1e6};
  const ImpactTime impact = time_of_impact(blade, left, blade, right, 1);
  ASSERT_TRUE(impact.hit && impact.converged);
  EXPECT_LT(impact.t, 2 * kPi / 1e6);
}

TEST(TimeOfImpact, NeverPassesThroughWhateverTheSpin) {
  // Fast spins with long steps, so that guesses at the impact and the work limit both occur.
  const unsigned seed = 909;
  Scenes scenes(seed);
  int hits = 0, limits = 0;
  for (int k = 0; k < test_scale(150); ++k) {
    const Shape a = scenes.shape(1), b = scenes.shape(scenes.uniform(0.2, 1));
    const double w = std::pow(10.0, scenes.uniform(0, 3));
    Motion ma{.angle0 = scenes.angle(), .omega = scenes.uniform(-w, w)};
    Motion mb{.p0 = scenes.uniform(1, 3) * scenes.direction(),
              .angle0 = scenes.angle(),
              .omega = scenes.uniform(-w, w)};
    mb.v = scenes.uniform(-1, 3) * (scenes.direction() - mb.p0);
    if (scenes.below(3) == 0) ma.alpha = scenes.uniform(-w, w);
    if (distance_at(a, ma, b, mb, 0) <= 1e-9) continue;
    const ImpactTime impact = time_of_impact(a, ma, b, mb, 1);
    ASSERT_LE(impact.iterations, 1010);
    // Dense samples until the answer: nothing touches before.
    const int samples = 150;
    for (int i = 0; i < samples; ++i) {
      ASSERT_GT(distance_at(a, ma, b, mb, impact.t * i / samples), -1e-13)
          << "case " << k << " seed " << seed << " t " << impact.t << " at " << i;
    }
    hits += impact.hit ? 1 : 0;
    if (impact.hit && impact.converged) {
      ASSERT_NEAR(static_cast<double>(distance_at(a, ma, b, mb, impact.t)), 0, 1e-12)
          << "case " << k << " seed " << seed;
    }
    limits += impact.converged ? 0 : 1;
  }
  EXPECT_GT(hits, 10);
  std::printf("%d hits, %d at the work limit\n", hits, limits);
}

TEST(TimeOfImpact, FollowsTwoFacesThatTurnTogetherInFewSteps) {
  // Faces a hair apart that turn, slide and fall together, as within a pile: nothing stops the search but
  // what they do to each other.
  const unsigned seed = 411;
  Scenes scenes(seed);
  int hits = 0, most = 0;
  for (int k = 0; k < test_scale(300); ++k) {
    const double w = scenes.uniform(-3, 3), angle = scenes.angle();
    const double hair = std::pow(10.0, scenes.uniform(-13, -6)), aside = scenes.uniform(-0.9, 0.9);
    const Rot q = Rot::from_angle(angle);
    const Shape a = make_box({1, 0.3}), b = make_box({scenes.uniform(0.1, 1), 0.4});
    const Motion ma{.p0 = scenes.uniform(0, 3) * scenes.direction(),
                    .angle0 = angle,
                    .v = scenes.direction(),
                    .omega = w,
                    .a = 10 * scenes.direction()};
    const Vec2 d = rotate(q, {aside, 0.35 + hair});
    Motion mb = ma;
    mb.p0 += d;
    mb.v += w * perp(d) + rotate(q, {scenes.uniform(-0.5, 0.5), scenes.uniform(-1, 1) * 1e3 * hair});
    mb.omega += scenes.uniform(-1, 1) * 1e2 * hair;
    mb.a += -(w * w) * d +
            rotate(q, {scenes.uniform(-10, 10), scenes.below(2) == 0 ? 0.0 : scenes.uniform(-5, 5)});
    const ImpactTime impact = time_of_impact(a, ma, b, mb, 1.0 / 60);
    ASSERT_TRUE(impact.converged) << "case " << k << " seed " << seed;
    ASSERT_LE(impact.iterations, 40) << "case " << k << " seed " << seed << " hair " << hair;
    most = std::max(most, impact.iterations);
    for (int i = 1; i <= 100; ++i) {
      ASSERT_GT(distance_at(a, ma, b, mb, impact.t * i / 100), -1e-13)
          << "case " << k << " seed " << seed << " t " << impact.t << " at " << i;
    }
    if (!impact.hit) continue;
    ++hits;
    ASSERT_NEAR(static_cast<double>(distance_at(a, ma, b, mb, impact.t)), 0, 1e-13) << "case " << k;
  }
  EXPECT_GT(hits, 20);
  std::printf("%d hits, at most %d looks\n", hits, most);
}

TEST(TimeOfImpact, OfWhatSlidesAlongAFaceIsKnownAtOnce) {
  const Shape tile = make_box({1, 1}), box = make_box({0.6, 0.6});
  Scenes scenes(733);
  for (int k = 0; k < test_scale(200); ++k) {
    // Speeds of roundings across the face.
    const auto noise = [&] { return scenes.below(3) == 0 ? 0.0 : scenes.uniform(-1, 1) * 1e-16; };
    const Motion sliding{.p0 = {scenes.uniform(-0.5, 0.5), 0.8},
                         .v = {scenes.uniform(-3, 3), noise()},
                         .omega = noise(),
                         .a = {scenes.uniform(-10, 10), 10 * noise()},
                         .alpha = 100 * noise()};
    const ImpactTime impact = time_of_impact(tile, {}, box, sliding, 1.0 / 60);
    EXPECT_TRUE(impact.converged) << "case " << k;
    EXPECT_FALSE(impact.hit) << "case " << k << " at " << impact.t;
    EXPECT_LE(impact.iterations, 8) << "case " << k;
  }
}

TEST(TimeOfImpact, OfABoxThatTipsOverARidgeTakesFewLooks) {
  // A face turns about the ridge on which it lies: its corners move fast, the gap at the ridge does not.
  const Shape ridge = make_box({0.66, 0.66}), box = make_box({1, 0.64});
  Scenes scenes(734);
  int most = 0;
  for (int k = 0; k < test_scale(300); ++k) {
    Motion below;
    below.angle0 = 0.25 * kPi + scenes.uniform(-0.5, 0.5);
    below.p0 = -rotate(Rot::from_angle(below.angle0), {0.33, 0.33});
    const double gap = scenes.below(4) == 0 ? 0 : std::pow(10.0, scenes.uniform(-14, -9));
    const double rate = scenes.below(3) == 0 ? 0 : std::pow(10.0, scenes.uniform(-11, -8));
    Motion above;
    above.p0 = {scenes.uniform(-0.4, 0.4), 0.32 + gap};
    above.omega = scenes.uniform(-1, 1) * 1e-4;
    above.alpha = scenes.uniform(-10, 10);
    above.v = above.omega * perp(above.p0) + Vec2{0, rate};
    above.a = above.alpha * perp(above.p0) - above.omega * above.omega * above.p0;
    const ImpactTime impact = time_of_impact(ridge, below, box, above, 1.0 / 60);
    ASSERT_TRUE(impact.converged) << "case " << k;
    most = std::max(most, impact.iterations);
    for (int i = 1; i <= 100; ++i)
      ASSERT_GT(distance_at(ridge, below, box, above, impact.t * i / 100), -2e-12)
          << "case " << k << " t " << impact.t << " at " << i;
  }
  EXPECT_LE(most, 100);
  std::printf("at most %d looks\n", most);
}

TEST(TimeOfImpact, RefusesBadArguments) {
  const Shape disc = make_disc(1);
  EXPECT_THROW(time_of_impact(disc, {}, disc, {}, -1), std::invalid_argument);
  EXPECT_THROW(time_of_impact(disc, {}, disc, {}, kInfinity), std::invalid_argument);
  try {
    time_of_impact(disc, {}, disc, {.p0 = {3, 0}, .omega = kInfinity}, 1);
    ADD_FAILURE() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "time_of_impact: the second motion must be finite, got p0 (3, 0), angle0 0, v (0, 0), "
                 "omega inf, a (0, 0), alpha 0");
  }
  EXPECT_THROW(time_of_impact(disc, {.p0 = {std::nan(""), 0}}, disc, {}, 1), std::invalid_argument);
}

/// Nothing touches before the time that was found.
void expect_apart_until(const Shape& a, const Motion& ma, const Shape& b, const Motion& mb, double t) {
  for (int k = 0; k < 2000; ++k) {
    const double before = t * k / 2000;
    ASSERT_GT(distance(a, ma.at(before), b, mb.at(before)).distance, 0) << before << " s of " << t;
  }
  EXPECT_NEAR(distance(a, ma.at(t), b, mb.at(t)).distance, 0, 1e-9);
}

TEST(TimeOfImpact, OfAFastSpinningBarIsTheFirstOfSeveralThatItsFeaturesHave) {
  const Shape box = make_box({1.62, 0.92}), bar = make_box({3.02, 0.35});
  const Motion slow{.angle0 = 1.679, .v = {-0.712, 0.085}, .omega = 1.486};
  const Motion fast{
      .p0 = {-2.026, 1.528}, .angle0 = -1.981, .v = {1.4, -4.222}, .omega = -10.596, .a = {0, -3.508}};
  const ImpactTime impact = time_of_impact(box, slow, bar, fast, 1);
  ASSERT_TRUE(impact.hit);
  expect_apart_until(box, slow, bar, fast, impact.t);
}

TEST(TimeOfImpact, OfATouchingStartFollowsTheFaceThatTurns) {
  const Shape plank = make_box({8, 1});
  const Motion turning{.omega = 1};
  for (const double speed : {1.0, 0.2, -0.2, -1.0}) {
    // In the plank's frame the disc gets higher by -w (0.6 w + 2 v) t^2 / 2.
    const Motion along{.p0 = {0, 0.6}, .v = {speed, 0}};
    const ImpactTime impact = time_of_impact(plank, turning, make_disc(0.1), along, 0.1);
    EXPECT_EQ(impact.hit, 0.6 + 2 * speed > 0) << speed;
    if (impact.hit) {
      EXPECT_EQ(impact.t, 0) << speed;
    }
  }
}

TEST(TimeOfImpact, OfACornerThatComesDownIsNotHiddenByOneThatTouchesAndRises) {
  const Shape plane = make_half_plane({0, 0}, {0, 1}), box = make_box({2, 1});
  const double tilt = -0.2, omega = 1;
  const Vec2 right = rotate(Rot::from_angle(tilt), {1, -0.5});
  const Motion moving{.p0 = {0, -right.y}, .angle0 = tilt, .v = {0, 0.1 - omega * right.x}, .omega = omega};
  const ImpactTime impact = time_of_impact(plane, {}, box, moving, 1);
  ASSERT_TRUE(impact.hit);
  const auto height = [&](double t) {
    const Transform at = moving.at(t);
    return std::min(to_world(at, {-1, -0.5}).y, to_world(at, {1, -0.5}).y);
  };
  EXPECT_GT(impact.t, 0.05);
  EXPECT_NEAR(height(impact.t), 0, 1e-12);
  for (int k = 1; k < 100; ++k) EXPECT_GT(height(impact.t * k / 100), 0) << k;
}

TEST(TimeOfImpact, OfAHalfPlaneThatTurnsIsThatOfWhatItSweepsFarFromItsPoint) {
  const Shape plane = make_half_plane({0, 0}, {0, 1}), disc = make_disc(0.5);
  for (const double x : {5.0, 50.0, 500.0}) {
    const ImpactTime impact = time_of_impact(plane, {.omega = 1}, disc, {.p0 = {x, 0.3 * x}}, 1);
    ASSERT_TRUE(impact.hit) << x;
    EXPECT_NEAR(impact.t, std::atan(0.3) - std::asin(0.5 / (x * std::sqrt(1.09))), 1e-9) << x;
  }
}

TEST(TimeOfImpact, OfAChainThatTurnsIsThatOfWhatIsFarFromItAtTheStart) {
  const Shape chain = make_chain(std::vector<Vec2>{{1, 0}, {2, 0}, {3, 0}, {4, 0}}), disc = make_disc(0.1);
  const Motion still{.p0 = {2.5 * std::cos(0.5), 2.5 * std::sin(0.5)}};
  const ImpactTime impact = time_of_impact(chain, {.omega = 1}, disc, still, 1);
  ASSERT_TRUE(impact.hit);
  EXPECT_NEAR(impact.t, 0.5 - std::asin(0.1 / 2.5), 1e-9);
}

}  // namespace time_of_impact_test
}  // namespace skerry
