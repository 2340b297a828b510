// SPDX-License-Identifier: MIT
//
// Narrow phase, ns a pair; beside it the same calls of the engines that are installed, in the same run. Each
// benchmark goes over many poses of the same kind in an order that does not repeat: a branch predictor learns
// 512 poses that come round in the same order.
#include <benchmark/benchmark.h>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#ifdef SKERRY_WITH_BOX2D
#include <box2d/b2_time_of_impact.h>
#include <box2d/box2d.h>
#endif
#ifdef SKERRY_WITH_CHIPMUNK
#include <chipmunk/chipmunk.h>
#endif

#include "physics/narrowphase/chain.h"
#include "physics/narrowphase/collide.h"
#include "physics/narrowphase/collide_batch.h"
#include "physics/narrowphase/queries.h"
#include "physics/narrowphase/time_of_impact.h"

namespace {

using namespace skerry;

constexpr std::size_t kPoses = 512;  // a power of two

/// Numbers of poses by a linear congruential generator [Knuth, The Art of Computer Programming 2,
/// sec. 3.3.4].
class Order {
 public:
  std::size_t next() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return state_ >> (64 - std::bit_width(kPoses - 1));
  }

 private:
  std::uint64_t state_ = 2026;
};

struct PosePair {
  Transform a, b;
  double angle_a, angle_b;
};

/// Second bodies around the first at `low` to `high` times the touching distance of two unit shapes.
std::vector<PosePair> poses(double low, double high) {
  std::mt19937_64 random(2026);
  std::uniform_real_distribution<double> angle(-kPi, kPi), distance(low, high);
  std::vector<PosePair> out;
  for (std::size_t i = 0; i < kPoses; ++i) {
    const SinCos sc = sin_cos(angle(random));
    const double d = distance(random), ta = angle(random), tb = angle(random);
    out.push_back(
        {{{3, 4}, Rot::from_angle(ta)}, {{3 + d * sc.cos, 4 + d * sc.sin}, Rot::from_angle(tb)}, ta, tb});
  }
  return out;
}

Shape regular(int corners) {
  std::vector<Vec2> points;
  for (int i = 0; i < corners; ++i) {
    const SinCos sc = sin_cos(2 * kPi * i / corners);
    points.push_back({0.5 * sc.cos, 0.5 * sc.sin});
  }
  return make_polygon(points);
}

Shape shape_of(int kind) {
  switch (kind) {
    case 0:
      return make_disc(0.5);
    case 1:
      return make_capsule({-0.25, 0}, {0.25, 0}, 0.25);
    case 4:
      return make_box({1, 1});
    default:
      return regular(kind);
  }
}

/// Arguments: kind (0 disc, 1 capsule, otherwise corners), distance in percent low and high, cache: 0 none, 1
/// kept and warm.
void BM_Collide(benchmark::State& state) {
  const Shape a = shape_of(static_cast<int>(state.range(0))), b = a;
  const auto pairs =
      poses(0.01 * static_cast<double>(state.range(1)), 0.01 * static_cast<double>(state.range(2)));
  std::vector<SatCache> caches(kPoses);
  const bool cached = state.range(3) != 0;
  if (cached) {
    for (std::size_t i = 0; i < kPoses; ++i) collide(a, pairs[i].a, b, pairs[i].b, 0.0, &caches[i]);
  }
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    benchmark::DoNotOptimize(collide(a, pairs[i].a, b, pairs[i].b, 0.0, cached ? &caches[i] : nullptr));
  }
}
BENCHMARK(BM_Collide)
    ->ArgNames({"corners", "from", "to", "cached"})
    ->Args({0, 80, 99, 0})
    ->Args({1, 30, 60, 0})
    ->Args({1, 30, 60, 1})
    ->Args({4, 60, 95, 0})
    ->Args({4, 60, 95, 1})
    ->Args({4, 142, 200, 0})
    ->Args({4, 142, 200, 1})
    ->Args({8, 60, 90, 0})
    ->Args({8, 60, 90, 1})
    ->Args({64, 60, 95, 0})
    ->Args({64, 60, 95, 1})
    ->Args({64, 102, 150, 0})
    ->Args({64, 102, 150, 1});

/// Boxes that lie on each other in a stack, as most pairs of a settled scene do.
std::vector<PosePair> stacked() {
  std::mt19937_64 random(2026);
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  std::vector<PosePair> pairs;
  for (std::size_t i = 0; i < kPoses; ++i) {
    pairs.push_back({{{0, 0}, Rot::from_angle(0)}, {{shift(random), 0.9999}, Rot::from_angle(0)}, 0, 0});
  }
  return pairs;
}

void BM_CollideStacked(benchmark::State& state) {
  const Shape a = make_box({1, 1}), b = a;
  const auto pairs = stacked();
  std::vector<SatCache> caches(kPoses);
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    benchmark::DoNotOptimize(
        collide(a, pairs[i].a, b, pairs[i].b, 0.005, state.range(0) != 0 ? &caches[i] : nullptr));
  }
}
BENCHMARK(BM_CollideStacked)->ArgName("cached")->Arg(0)->Arg(1);

/// Boxes that are apart although their bounding boxes overlap: what the broad phase leaves to be told apart.
std::vector<PosePair> near_misses() {
  const Shape box = make_box({1, 1});
  std::mt19937_64 random(2027);
  std::uniform_real_distribution<double> angle(-kPi, kPi), distance(1.0, 1.42);
  std::vector<PosePair> out;
  while (out.size() < kPoses) {
    const SinCos sc = sin_cos(angle(random));
    const double d = distance(random), ta = angle(random), tb = angle(random);
    const PosePair pair{
        {{3, 4}, Rot::from_angle(ta)}, {{3 + d * sc.cos, 4 + d * sc.sin}, Rot::from_angle(tb)}, ta, tb};
    if (overlap(bounding_box(box, pair.a), bounding_box(box, pair.b)) &&
        collide(box, pair.a, box, pair.b, 0.01).count == 0) {
      out.push_back(pair);
    }
  }
  return out;
}

void BM_CollideNearMiss(benchmark::State& state) {
  const Shape box = make_box({1, 1});
  const auto pairs = near_misses();
  std::vector<SatCache> caches(kPoses);
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    benchmark::DoNotOptimize(
        collide(box, pairs[i].a, box, pairs[i].b, 0.0, state.range(0) != 0 ? &caches[i] : nullptr));
  }
}
BENCHMARK(BM_CollideNearMiss)->ArgName("cached")->Arg(0)->Arg(1);

/// The same with a cache, while the second box moves on by more than the pair has to spare every time: each
/// call tests the axis of the last one.
void BM_CollideApartInMotion(benchmark::State& state) {
  const Shape box = make_box({1, 1});
  SatCache cache;
  double x = 0;
  for (auto _ : state) {
    x = 1.1 - x;
    benchmark::DoNotOptimize(collide(box, {}, box, {{x - 0.5, 1.3}, {}}, 0.0, &cache));
  }
}
BENCHMARK(BM_CollideApartInMotion);

/// All poses of one kind in one call; the time is that of one pair. Arguments as for BM_Collide, and `scene`:
/// 0 poses by distance, 1 stacked, 2 near misses; `version`: 0 what the library takes on this processor, then
/// those that it could take.
void BM_CollideBatch(benchmark::State& state) {
  const int corners = static_cast<int>(state.range(0));
  const Shape shape = shape_of(corners);
  const auto pairs = state.range(3) == 1   ? stacked()
                     : state.range(3) == 2 ? near_misses()
                                           : poses(0.01 * static_cast<double>(state.range(1)),
                                                   0.01 * static_cast<double>(state.range(2)));
  const std::vector<const Shape*> shapes(kPoses, &shape);
  const std::vector<double> margin(kPoses, state.range(3) == 1 ? 0.005 : 0.0);
  std::vector<Transform> a, b;
  std::vector<Manifold> results(kPoses);
  std::vector<Manifold*> out;
  for (std::size_t i = 0; i < kPoses; ++i) {
    a.push_back(pairs[i].a);
    b.push_back(pairs[i].b);
    out.push_back(&results[i]);
  }
  const PairArrays arrays{shapes, shapes, a, b, margin, {}, out};
  const auto versions = narrow::batch_versions();
  const auto wanted = static_cast<std::size_t>(state.range(4));
  if (wanted > versions.size()) return state.SkipWithError("not on this processor");
  const narrow::BatchVersion& version = versions[wanted == 0 ? 0 : wanted - 1];
  state.SetLabel(version.name);
  while (state.KeepRunningBatch(kPoses)) {
    (corners == 0 ? version.discs : version.boxes)(arrays, nullptr);
    benchmark::DoNotOptimize(results.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_CollideBatch)
    ->ArgNames({"corners", "from", "to", "scene", "version"})
    ->Args({0, 80, 99, 0, 0})
    ->Args({4, 60, 95, 0, 0})
    ->Args({4, 0, 0, 1, 0})
    ->Args({4, 142, 200, 0, 0})
    ->Args({4, 0, 0, 2, 0})
    ->Args({0, 80, 99, 0, 2})
    ->Args({4, 60, 95, 0, 2});

/// Boxes and discs of 1 m that lie on level ground, nearly flat.
std::vector<PosePair> grounded() {
  std::mt19937_64 random(2028);
  std::uniform_real_distribution<double> place(-50, 50), tilt(-0.005, 0.005), gap(-0.004, 0.002);
  std::vector<PosePair> out;
  for (std::size_t i = 0; i < kPoses; ++i) {
    const double angle = tilt(random);
    out.push_back({{}, {{place(random), 0.5 + gap(random)}, Rot::from_angle(angle)}, 0, angle});
  }
  return out;
}

/// On a half-plane. Arguments: corners (0 disc), batch: all poses in one call; the time is that of one pair.
void BM_CollideGround(benchmark::State& state) {
  const Shape shape = shape_of(static_cast<int>(state.range(0))), ground = make_half_plane({}, {0, 1});
  const auto pairs = grounded();
  if (state.range(1) == 0) {
    Order order;
    for (auto _ : state) {
      const std::size_t i = order.next();
      benchmark::DoNotOptimize(collide(ground, pairs[i].a, shape, pairs[i].b, 0.005));
    }
    return;
  }
  const std::vector<const Shape*> grounds(kPoses, &ground), shapes(kPoses, &shape);
  const std::vector<double> margin(kPoses, 0.005);
  std::vector<Transform> a, b;
  std::vector<Manifold> results(kPoses);
  std::vector<Manifold*> out;
  for (std::size_t i = 0; i < kPoses; ++i) {
    a.push_back(pairs[i].a);
    b.push_back(pairs[i].b);
    out.push_back(&results[i]);
  }
  while (state.KeepRunningBatch(kPoses)) {
    collide_half_planes({grounds, shapes, a, b, margin, {}, out});
    benchmark::DoNotOptimize(results.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_CollideGround)
    ->ArgNames({"corners", "batch"})
    ->Args({0, 0})
    ->Args({0, 1})
    ->Args({4, 0})
    ->Args({4, 1});

struct Flights {
  std::vector<Motion> a, b;
};

/// Pairs that fly at each other and may turn; most of them hit within the step of 1 s (the labels say how
/// many).
Flights flights(double spin) {
  std::mt19937_64 random(77);
  std::uniform_real_distribution<double> angle(-kPi, kPi), unit(-1, 1);
  Flights out;
  for (std::size_t i = 0; i < kPoses; ++i) {
    const SinCos sc = sin_cos(angle(random));
    Motion a, b;
    a.angle0 = angle(random);
    a.omega = spin * unit(random);
    b.p0 = {3 * sc.cos, 3 * sc.sin};
    b.angle0 = angle(random);
    b.v = {-4 * sc.cos + 1.5 * unit(random), -4 * sc.sin + 1.5 * unit(random)};
    b.omega = spin * unit(random);
    out.a.push_back(a);
    out.b.push_back(b);
  }
  return out;
}

/// A label and no counters: a table in CSV has the same columns in all rows.
void label_shares(benchmark::State& state, double hits, double evaluations) {
  char text[64];
  if (evaluations > 0) {
    std::snprintf(text, sizeof text, "%.0f %% hit; %.2f evaluations", 100 * hits, evaluations);
  } else {
    std::snprintf(text, sizeof text, "%.0f %% hit", 100 * hits);
  }
  state.SetLabel(text);
}

void BM_TimeOfImpact(benchmark::State& state) {
  const Shape a = shape_of(static_cast<int>(state.range(0))), b = a;
  const Flights f = flights(static_cast<double>(state.range(1)));
  Order order;
  double hits = 0, runs = 0, evaluations = 0;
  for (auto _ : state) {
    const std::size_t i = order.next();
    const ImpactTime impact = time_of_impact(a, f.a[i], b, f.b[i], 1.0);
    hits += impact.hit ? 1 : 0;
    evaluations += impact.iterations;
    runs += 1;
    benchmark::DoNotOptimize(impact);
  }
  label_shares(state, hits / runs, evaluations / runs);
}
BENCHMARK(BM_TimeOfImpact)
    ->ArgNames({"corners", "spin"})
    ->Args({0, 0})
    ->Args({4, 0})
    ->Args({4, 3})
    ->Args({8, 3});

/// Segments of terrain near a box of 1 m, and a ray across it. Argument: segments.
void BM_ChainSegmentsNear(benchmark::State& state) {
  const int count = static_cast<int>(state.range(0));
  std::vector<Vec2> corners;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> height(-0.1, 0.1), at(0, 0.25 * count);
  for (int i = 0; i <= count; ++i) corners.push_back({0.25 * i, height(random)});
  const Shape chain = make_chain(corners);
  std::vector<double> places;
  for (std::size_t i = 0; i < kPoses; ++i) places.push_back(at(random));
  std::vector<int> near;
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    chain_segments_near(chain, {}, {{places[i] - 0.5, -0.5}, {places[i] + 0.5, 0.5}}, near);
    benchmark::DoNotOptimize(near.data());
  }
}
BENCHMARK(BM_ChainSegmentsNear)->ArgName("segments")->Arg(10)->Arg(1000)->Arg(100000);

void BM_RayCast(benchmark::State& state) {
  const Shape shape = shape_of(static_cast<int>(state.range(0)));
  const auto pairs = poses(2, 3);
  std::vector<Transform> a;
  std::vector<Ray> rays;
  for (const PosePair& p : pairs) {
    a.push_back(p.a);
    rays.push_back({p.b.p, 1.5 * (p.a.p - p.b.p), 1});
  }
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    benchmark::DoNotOptimize(ray_cast(shape, a[i], rays[i]));
  }
}
BENCHMARK(BM_RayCast)->ArgName("corners")->Arg(0)->Arg(1)->Arg(4)->Arg(8)->Arg(64);

#ifdef SKERRY_WITH_BOX2D

b2Transform b2_pose(const Transform& t, double angle) {
  return {b2Vec2(static_cast<float>(t.p.x), static_cast<float>(t.p.y)), b2Rot(static_cast<float>(angle))};
}

b2PolygonShape b2_polygon(int corners) {
  b2PolygonShape shape;
  if (corners == 4) {
    shape.SetAsBox(0.5f, 0.5f);
    return shape;
  }
  std::vector<b2Vec2> points;
  for (const Vec2 v : regular(corners).vertices)
    points.emplace_back(static_cast<float>(v.x), static_cast<float>(v.y));
  shape.Set(points.data(), corners);
  return shape;
}

/// `world` 1: with b2WorldManifold, which turns the result into what ours holds (normal, points, separations
/// in the world frame).
void BM_Box2DCollide(benchmark::State& state) {
  const int corners = static_cast<int>(state.range(0));
  const bool with_points = state.range(3) != 0;
  const auto pairs =
      poses(0.01 * static_cast<double>(state.range(1)), 0.01 * static_cast<double>(state.range(2)));
  std::vector<b2Transform> a, b;
  for (const PosePair& p : pairs) {
    a.push_back(b2_pose(p.a, p.angle_a));
    b.push_back(b2_pose(p.b, p.angle_b));
  }
  const b2PolygonShape polygon = b2_polygon(corners == 0 ? 4 : corners);
  b2CircleShape circle;
  circle.m_radius = 0.5f;
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    b2Manifold m;
    if (corners == 0) {
      b2CollideCircles(&m, &circle, a[i], &circle, b[i]);
    } else {
      b2CollidePolygons(&m, &polygon, a[i], &polygon, b[i]);
    }
    benchmark::DoNotOptimize(m);
    if (!with_points) continue;
    b2WorldManifold points;
    const float radius = corners == 0 ? circle.m_radius : polygon.m_radius;
    points.Initialize(&m, a[i], radius, b[i], radius);
    benchmark::DoNotOptimize(points);
  }
}
BENCHMARK(BM_Box2DCollide)
    ->ArgNames({"corners", "from", "to", "world"})
    ->Args({0, 80, 99, 0})
    ->Args({0, 80, 99, 1})
    ->Args({4, 60, 95, 0})
    ->Args({4, 60, 95, 1})
    ->Args({4, 142, 200, 0})
    ->Args({8, 60, 90, 0})
    ->Args({8, 60, 90, 1});

/// Stacked boxes; `world` as above.
void BM_Box2DCollideStacked(benchmark::State& state) {
  const b2PolygonShape polygon = b2_polygon(4);
  std::vector<b2Transform> b;
  for (const PosePair& p : stacked()) b.push_back(b2_pose(p.b, 0));
  const b2Transform a{b2Vec2(0, 0), b2Rot(0)};
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    b2Manifold m;
    b2CollidePolygons(&m, &polygon, a, &polygon, b[i]);
    benchmark::DoNotOptimize(m);
    if (state.range(0) == 0) continue;
    b2WorldManifold points;
    points.Initialize(&m, a, polygon.m_radius, b[i], polygon.m_radius);
    benchmark::DoNotOptimize(points);
  }
}
BENCHMARK(BM_Box2DCollideStacked)->ArgName("world")->Arg(0)->Arg(1);

/// A loop over all poses of one kind that keeps the results, as BM_CollideBatch does; the time is that of one
/// pair. Arguments as there; `world` as above.
void BM_Box2DCollideLoop(benchmark::State& state) {
  const int corners = static_cast<int>(state.range(0));
  const auto pairs = state.range(3) == 1   ? stacked()
                     : state.range(3) == 2 ? near_misses()
                                           : poses(0.01 * static_cast<double>(state.range(1)),
                                                   0.01 * static_cast<double>(state.range(2)));
  std::vector<b2Transform> a, b;
  for (const PosePair& p : pairs) {
    a.push_back(b2_pose(p.a, p.angle_a));
    b.push_back(b2_pose(p.b, p.angle_b));
  }
  const b2PolygonShape polygon = b2_polygon(4);
  b2CircleShape circle;
  circle.m_radius = 0.5f;
  const float radius = corners == 0 ? circle.m_radius : polygon.m_radius;
  std::vector<b2Manifold> results(kPoses);
  std::vector<b2WorldManifold> points(kPoses);
  while (state.KeepRunningBatch(kPoses)) {
    for (std::size_t i = 0; i < kPoses; ++i) {
      if (corners == 0) {
        b2CollideCircles(&results[i], &circle, a[i], &circle, b[i]);
      } else {
        b2CollidePolygons(&results[i], &polygon, a[i], &polygon, b[i]);
      }
      if (state.range(4) != 0) points[i].Initialize(&results[i], a[i], radius, b[i], radius);
    }
    benchmark::DoNotOptimize(results.data());
    benchmark::DoNotOptimize(points.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_Box2DCollideLoop)
    ->ArgNames({"corners", "from", "to", "scene", "world"})
    ->Args({0, 80, 99, 0, 0})
    ->Args({0, 80, 99, 0, 1})
    ->Args({4, 60, 95, 0, 0})
    ->Args({4, 60, 95, 0, 1})
    ->Args({4, 0, 0, 1, 0})
    ->Args({4, 0, 0, 1, 1})
    ->Args({4, 142, 200, 0, 0})
    ->Args({4, 0, 0, 2, 0});

void BM_Box2DCollideNearMiss(benchmark::State& state) {
  const b2PolygonShape polygon = b2_polygon(4);
  std::vector<b2Transform> a, b;
  for (const PosePair& p : near_misses()) {
    a.push_back(b2_pose(p.a, p.angle_a));
    b.push_back(b2_pose(p.b, p.angle_b));
  }
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    b2Manifold m;
    b2CollidePolygons(&m, &polygon, a[i], &polygon, b[i]);
    benchmark::DoNotOptimize(m);
  }
}
BENCHMARK(BM_Box2DCollideNearMiss);

/// On an edge, which is Box2D's ground. Arguments: corners; loop: 1 goes through all poses and keeps the
/// results; `world` as above.
void BM_Box2DCollideGround(benchmark::State& state) {
  const bool polygons = state.range(0) != 0, with_points = state.range(2) != 0;
  std::vector<b2Transform> b;
  for (const PosePair& p : grounded()) b.push_back(b2_pose(p.b, p.angle_b));
  const b2Transform a{b2Vec2(0, 0), b2Rot(0)};
  const b2PolygonShape polygon = b2_polygon(4);
  b2CircleShape circle;
  circle.m_radius = 0.5f;
  b2EdgeShape edge;
  edge.SetTwoSided({-100, 0}, {100, 0});
  const float radius = polygons ? polygon.m_radius : circle.m_radius;
  const auto meet = [&](b2Manifold& m, b2WorldManifold& points, std::size_t i) {
    if (polygons) {
      b2CollideEdgeAndPolygon(&m, &edge, a, &polygon, b[i]);
    } else {
      b2CollideEdgeAndCircle(&m, &edge, a, &circle, b[i]);
    }
    if (with_points) points.Initialize(&m, a, edge.m_radius, b[i], radius);
  };
  if (state.range(1) == 0) {
    Order order;
    for (auto _ : state) {
      b2Manifold m;
      b2WorldManifold points;
      meet(m, points, order.next());
      benchmark::DoNotOptimize(m);
      benchmark::DoNotOptimize(points);
    }
    return;
  }
  std::vector<b2Manifold> results(kPoses);
  std::vector<b2WorldManifold> points(kPoses);
  while (state.KeepRunningBatch(kPoses)) {
    for (std::size_t i = 0; i < kPoses; ++i) meet(results[i], points[i], i);
    benchmark::DoNotOptimize(results.data());
    benchmark::DoNotOptimize(points.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(BM_Box2DCollideGround)
    ->ArgNames({"corners", "loop", "world"})
    ->Args({0, 0, 0})
    ->Args({0, 0, 1})
    ->Args({0, 1, 0})
    ->Args({0, 1, 1})
    ->Args({4, 0, 0})
    ->Args({4, 0, 1})
    ->Args({4, 1, 0})
    ->Args({4, 1, 1});

b2Sweep b2_sweep(const Motion& m) {
  b2Sweep s{};
  s.localCenter.SetZero();
  s.c0 = {static_cast<float>(m.p0.x), static_cast<float>(m.p0.y)};
  s.c = {static_cast<float>(m.p0.x + m.v.x), static_cast<float>(m.p0.y + m.v.y)};
  s.a0 = static_cast<float>(m.angle0);
  s.a = static_cast<float>(m.angle0 + m.omega);
  return s;
}

void BM_Box2DTimeOfImpact(benchmark::State& state) {
  const int corners = static_cast<int>(state.range(0));
  const Flights f = flights(static_cast<double>(state.range(1)));
  const b2PolygonShape polygon = b2_polygon(corners == 0 ? 4 : corners);
  b2CircleShape circle;
  circle.m_radius = 0.5f;
  std::vector<b2TOIInput> inputs(kPoses);
  for (std::size_t k = 0; k < kPoses; ++k) {
    const b2Shape* shape = corners == 0 ? static_cast<const b2Shape*>(&circle) : &polygon;
    inputs[k].proxyA.Set(shape, 0);
    inputs[k].proxyB.Set(shape, 0);
    inputs[k].sweepA = b2_sweep(f.a[k]);
    inputs[k].sweepB = b2_sweep(f.b[k]);
    inputs[k].tMax = 1;
  }
  Order order;
  double hits = 0, runs = 0;
  for (auto _ : state) {
    const std::size_t i = order.next();
    b2TOIOutput out;
    b2TimeOfImpact(&out, &inputs[i]);
    hits += out.state == b2TOIOutput::e_touching ? 1 : 0;
    runs += 1;
    benchmark::DoNotOptimize(out);
  }
  label_shares(state, hits / runs, 0);
}
BENCHMARK(BM_Box2DTimeOfImpact)
    ->ArgNames({"corners", "spin"})
    ->Args({0, 0})
    ->Args({4, 0})
    ->Args({4, 3})
    ->Args({8, 3});

void BM_Box2DRayCast(benchmark::State& state) {
  const int corners = static_cast<int>(state.range(0));
  const b2PolygonShape polygon = b2_polygon(corners == 0 ? 4 : corners);
  b2CircleShape circle;
  circle.m_radius = 0.5f;
  const b2Shape& shape = corners == 0 ? static_cast<const b2Shape&>(circle) : polygon;
  const auto pairs = poses(2, 3);
  std::vector<b2Transform> a;
  std::vector<b2RayCastInput> rays;
  for (const PosePair& p : pairs) {
    a.push_back(b2_pose(p.a, p.angle_a));
    const Vec2 end = p.b.p + 1.5 * (p.a.p - p.b.p);
    rays.push_back({{static_cast<float>(p.b.p.x), static_cast<float>(p.b.p.y)},
                    {static_cast<float>(end.x), static_cast<float>(end.y)},
                    1});
  }
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    b2RayCastOutput out;
    benchmark::DoNotOptimize(shape.RayCast(&out, rays[i], a[i], 0));
    benchmark::DoNotOptimize(out);
  }
}
BENCHMARK(BM_Box2DRayCast)->ArgName("corners")->Arg(0)->Arg(4)->Arg(8);

#endif
#ifdef SKERRY_WITH_CHIPMUNK

/// Chipmunk collides shapes of bodies; their cached world data is brought up to date outside of the timing.
void BM_ChipmunkCollide(benchmark::State& state) {
  const int corners = static_cast<int>(state.range(0));
  const auto pairs =
      poses(0.01 * static_cast<double>(state.range(1)), 0.01 * static_cast<double>(state.range(2)));
  std::vector<cpVect> points;
  if (corners >= 3) {
    for (const Vec2 v : shape_of(corners).vertices) points.push_back(cpv(v.x, v.y));
  }
  std::vector<cpBody*> bodies;
  std::vector<cpShape*> shapes;
  for (const PosePair& p : pairs) {
    for (const bool second : {false, true}) {
      cpBody* body = cpBodyNew(1, 1);
      cpBodySetPosition(body, second ? cpv(p.b.p.x, p.b.p.y) : cpv(p.a.p.x, p.a.p.y));
      cpBodySetAngle(body, second ? p.angle_b : p.angle_a);
      cpShape* shape = corners == 0 ? cpCircleShapeNew(body, 0.5, cpvzero)
                       : corners == 1
                           ? cpSegmentShapeNew(body, cpv(-0.25, 0), cpv(0.25, 0), 0.25)
                           : cpPolyShapeNewRaw(body, static_cast<int>(points.size()), points.data(), 0);
      cpShapeCacheBB(shape);
      bodies.push_back(body);
      shapes.push_back(shape);
    }
  }
  Order order;
  for (auto _ : state) {
    const std::size_t i = order.next();
    benchmark::DoNotOptimize(cpShapesCollide(shapes[2 * i], shapes[2 * i + 1]));
  }
  for (cpShape* shape : shapes) cpShapeFree(shape);
  for (cpBody* body : bodies) cpBodyFree(body);
}
BENCHMARK(BM_ChipmunkCollide)
    ->ArgNames({"corners", "from", "to"})
    ->Args({0, 80, 99})
    ->Args({1, 30, 60})
    ->Args({4, 60, 95})
    ->Args({4, 142, 200})
    ->Args({8, 60, 90})
    ->Args({64, 60, 95});

#endif

}  // namespace

int main(int argc, char** argv) {
#ifdef SKERRY_WITH_BOX2D
  benchmark::AddCustomContext("box2d", std::to_string(b2_version.major) + "." +
                                           std::to_string(b2_version.minor) + "." +
                                           std::to_string(b2_version.revision));
#endif
#ifdef SKERRY_WITH_CHIPMUNK
  benchmark::AddCustomContext("chipmunk", cpVersionString);
#endif
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
