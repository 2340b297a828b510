// SPDX-License-Identifier: MIT
//
// What a step reports of contacts: begun, going on, ended, hit; of sensors, of chains.
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "physics/snapshot.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace events_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

TEST(Events, BeginHitAndEndAreReportedOnce) {
  World world;
  add_ground(world, smooth(make_disc(1), 0.5));
  add(world, {0, 1.0}, smooth(make_disc(0.5), 0.5));
  int begins = 0, ends = 0, hits = 0;
  for (int i = 0; i < 40; ++i) {
    for (const ContactEvent& event : world.step(1.0 / 60).events) {
      begins += event.kind == ContactEventKind::Begin;
      ends += event.kind == ContactEventKind::End;
      if (event.kind == ContactEventKind::Hit && hits++ == 0) {
        EXPECT_NEAR(event.approach_speed, std::sqrt(2 * 9.81 * 0.5), 1e-9);
      }
    }
  }
  EXPECT_GE(hits, 1);
  EXPECT_LE(ends, begins + 1);
}

TEST(Events, SensorsReportAndDoNotPush) {
  World world;
  const auto gate = world.create_body({.type = BodyType::Static});
  ShapeDef sensor = smooth(make_box({1, 1}));
  sensor.sensor = true;
  world.add_shape(gate, sensor);
  const auto ball = add(world, {0, 3}, smooth(make_disc(0.25)));
  int begins = 0, ends = 0;
  for (int i = 0; i < 120; ++i) {
    for (const ContactEvent& event : world.step(1.0 / 60).events) {
      EXPECT_TRUE(event.sensor);
      begins += event.kind == ContactEventKind::Begin;
      ends += event.kind == ContactEventKind::End;
    }
  }
  EXPECT_EQ(begins, 1);
  EXPECT_EQ(ends, 1);
  EXPECT_NEAR(world.position(ball).y, 3 - 0.5 * 9.81 * 4, 1e-10);
}

TEST(Events, OfSensorsSayWhere) {
  World world(weightless());
  const auto gate = world.create_body({.type = BodyType::Static, .position = {9, 0}});
  ShapeDef sensor = smooth(make_box({1, 1}));
  sensor.sensor = true;
  world.add_shape(gate, sensor);
  const auto ball = add(world, {8, 0.1}, smooth(make_disc(0.25)), 1, {3, 0});
  std::optional<ContactEvent> begin;
  while (!begin && world.time() < 1) {
    for (const ContactEvent& event : world.step(1.0 / 60).events)
      if (event.kind == ContactEventKind::Begin) begin = event;
  }
  ASSERT_TRUE(begin);
  EXPECT_NEAR(begin->point.x, 8.5, 0.06);
  EXPECT_NEAR(begin->point.y, 0.1, 1e-9);
  EXPECT_NEAR(std::abs(begin->normal.x), 1, 1e-12);
  EXPECT_EQ(begin->normal.x < 0, begin->body_b == ball) << "from a to b";
  EXPECT_EQ(begin->segment, -1);
}

TEST(Events, OfChainsSayOfWhichSegment) {
  World world(weightless());
  const auto ground = world.create_body({.type = BodyType::Static});
  std::vector<Vec2> corners;
  for (int i = 0; i <= 8; ++i) corners.push_back({1.0 * i, 0});
  ShapeDef chain = smooth(make_chain(corners));
  chain.sensor = true;
  world.add_shape(ground, chain);
  add(world, {1, 0.1}, smooth(make_box({1.5, 0.5})), 1, {1, 0});
  std::map<int, int> open;
  int begins = 0;
  for (int i = 0; i < 300; ++i) {
    for (const ContactEvent& event : world.step(1.0 / 60).events) {
      const int change = event.kind == ContactEventKind::Begin ? 1
                         : event.kind == ContactEventKind::End ? -1
                                                               : 0;
      begins += change > 0;
      open[event.segment] += change;
      EXPECT_TRUE(open[event.segment] == 0 || open[event.segment] == 1) << event.segment;
      EXPECT_GE(event.segment, 0);
      EXPECT_LE(event.segment, 7);
    }
  }
  EXPECT_GE(begins, 7);
}

TEST(Events, OfWhatLeftInAStepThatThrewComeWithTheNext) {
  World world(weightless());
  const auto floor = world.create_body({.type = BodyType::Static});
  world.add_shape(floor, rough(make_box({4, 1}), 0.5));
  const auto box = add(world, {0, 1}, rough(make_box({1, 1}), 0.5));
  int begins = 0, ends = 0;
  const auto step = [&] {
    for (const ContactEvent& event : world.step(1.0 / 60).events) {
      begins += event.kind == ContactEventKind::Begin;
      ends += event.kind == ContactEventKind::End;
    }
  };
  step();
  ASSERT_EQ(begins, 1);
  world.set_pose(box, {30, 1}, 0);
  // Not before the contact is gone: pairs are found after the forces of the beginning.
  world.set_force_field([begin = world.time()](const FieldSample& s) {
    if (s.time > begin) throw std::runtime_error("no");
    return Wrench{};
  });
  EXPECT_THROW(step(), std::runtime_error);
  world.set_force_field({});
  step();
  EXPECT_EQ(ends, 1);
  step();
  EXPECT_EQ(ends, 1);
}

TEST(Events, WhatIsTakenAwayAndPulledBackInOneStepHasNotLeft) {
  World world(weightless());
  const auto gate = world.create_body({.type = BodyType::Static});
  ShapeDef sensor = smooth(make_box({1, 1}));
  sensor.sensor = true;
  world.add_shape(gate, sensor);
  const auto ball = add(world, {0, 0}, smooth(make_disc(0.2)));
  world.create_joint({.kind = JointKind::Revolute, .b = ball});
  ASSERT_EQ(world.step(1.0 / 60).events.size(), 1u);
  world.set_pose(ball, {3, 0}, 0);
  EXPECT_TRUE(world.step(1.0 / 60).events.empty());
  EXPECT_NEAR(world.position(ball).x, 0, 1e-9);
  EXPECT_TRUE(world.step(1.0 / 60).events.empty());
}

/// From the first touch to the last, from either side; a chain as a sensor, and one that a sensor crosses.
TEST(Events, OfSensorsAndChainsLastAsLongAsTheyTouch) {
  const double h = 1.0 / 60, speed = 1.5;
  for (const double way : {-1.0, 1.0}) {
    for (const bool chain_senses : {false, true}) {
      for (const bool is_disc : {false, true}) {
        World world(weightless());
        const BodyId gate = world.create_body({.type = BodyType::Static});
        ShapeDef line = smooth(make_chain(std::vector<Vec2>{{-1, 0}, {1, 0}})),
                 shape = smooth(is_disc ? make_disc(0.25) : make_box({0.5, 0.5}));
        (chain_senses ? line : shape).sensor = true;
        world.add_shape(gate, line);
        const BodyId body = add(world, {0.3, -1.0 * way}, shape, 1, {0, speed * way});
        int begins = 0, ends = 0;
        for (int i = 0; i < 90; ++i) {
          for (const ContactEvent& event : world.step(h).events) {
            begins += event.kind == ContactEventKind::Begin;
            ends += event.kind == ContactEventKind::End;
          }
          const double y = way * world.position(body).y;
          EXPECT_EQ(begins, y > -0.25 ? 1 : 0) << y;
          EXPECT_EQ(ends, y > 0.25 ? 1 : 0) << y;
        }
        EXPECT_EQ(ends, 1);
      }
    }
  }
}

/// A box on a floor that was told to touch it, moved away, and a step that did not come through.
struct Interrupted {
  Interrupted() {
    floor = world.create_body({.type = BodyType::Static});
    world.add_shape(floor, rough(make_box({4, 1}), 0.5));
    box = world.create_body({.position = {0, 1}});
    shape = world.add_shape(box, rough(make_box({1, 1}), 0.5));
    EXPECT_EQ(told(world), "begin ");
    world.set_pose(box, {30, 1}, 0);
    world.set_force_field([now = world.time()](const FieldSample& sample) -> Wrench {
      if (sample.time > now) throw std::runtime_error("no");
      return {};
    });
    EXPECT_THROW(world.step(1.0 / 60), std::runtime_error);
    EXPECT_THROW(world.step(1.0 / 60), std::runtime_error);
    world.set_force_field({});
  }
  /// What a step reports.
  static std::string told(World& world) {
    std::string all;
    for (const ContactEvent& event : world.step(1.0 / 60).events)
      all += event.kind == ContactEventKind::Begin ? "begin " : "end ";
    return all;
  }

  World world{weightless()};
  BodyId floor, box;
  ShapeId shape;
};

TEST(Events, AfterAStepThatThrewAreThoseOfWhatTouchedBefore) {
  Interrupted moved;
  World loaded = load_snapshot(save_snapshot(moved.world));
  for (World* world : {&moved.world, &loaded}) {
    EXPECT_EQ(Interrupted::told(*world), "end ");
    EXPECT_EQ(world->report().pairs, 0);
    EXPECT_EQ(Interrupted::told(*world), "");
  }
  Interrupted back;
  back.world.set_pose(back.box, {0, 1}, 0);
  EXPECT_EQ(Interrupted::told(back.world), "") << "it touches as before";
  back.world.set_pose(back.box, {30, 1}, 0);
  EXPECT_EQ(Interrupted::told(back.world), "end ");
  Interrupted gone;
  gone.world.destroy(gone.shape);
  EXPECT_EQ(gone.world.add_shape(gone.box, rough(make_disc(0.3), 0.5)).index, gone.shape.index);
  EXPECT_EQ(Interrupted::told(gone.world), "end ") << "another shape in its place never touched";
}

/// A disc drifts against a peg, when another one knocks it away from that: the peg gives nothing.
TEST(Events, OfHitsAreOfWhatGaveAnImpulse) {
  World world(weightless());
  const BodyId disc = add(world, {0, 0}, smooth(make_disc(0.5)), 1, {-5e-6, 0});
  const BodyId peg = world.create_body({.type = BodyType::Static, .position = {-0.6, 0}});
  world.add_shape(peg, smooth(make_disc(0.1)));
  const Vec2 from{std::cos(1.9), std::sin(1.9)};
  const BodyId ball = add(world, 0.6 * from, smooth(make_disc(0.1)), 1, -10 * from);
  int hits = 0;
  for (const ContactEvent& event : world.step(1.0 / 60).events) {
    if (event.kind != ContactEventKind::Hit) continue;
    ++hits;
    EXPECT_GT(event.impulse, 0);
    EXPECT_TRUE(event.body_a == ball || event.body_b == ball);
  }
  EXPECT_EQ(hits, 1);
  EXPECT_GT(world.velocity(disc).x, 0.1);
}

/// What touches counts: begins less ends, of which none is told twice or without the other.
class Counted {
 public:
  void add(const StepReport& report) {
    for (const ContactEvent& event : report.events) {
      const auto pair = std::tuple(event.shape_a.index, event.shape_a.generation, event.shape_b.index,
                                   event.shape_b.generation);
      if (event.kind == ContactEventKind::Begin) {
        EXPECT_TRUE(open.insert(pair).second);
      }
      if (event.kind == ContactEventKind::End) {
        EXPECT_EQ(open.erase(pair), 1u);
      }
    }
  }
  std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t>> open;
};

TEST(Events, OfWhatIsDestroyedEndInTheNextStep) {
  enum class Destroyed { Coin, CoinsShape, Gate, Floor };
  for (const bool asleep : {false, true}) {
    for (const Destroyed what : {Destroyed::Coin, Destroyed::CoinsShape, Destroyed::Gate, Destroyed::Floor}) {
      World world({.sleep = asleep});
      const BodyId floor = world.create_body({.type = BodyType::Static});
      world.add_shape(floor, {.shape = make_box({4, 1})});
      const BodyId gate = world.create_body({.type = BodyType::Static, .position = {0, 1}});
      const ShapeId zone = world.add_shape(gate, {.shape = make_box({2, 2}), .sensor = true});
      const BodyId coin = world.create_body({.position = {0, 0.7}, .mass = 1});
      const ShapeId round = world.add_shape(coin, {.shape = make_box({0.4, 0.4})});
      Counted counted;
      for (int i = 0; i < (asleep ? 120 : 3); ++i) counted.add(world.step(1.0 / 60));
      ASSERT_EQ(counted.open.size(), 2u);
      ASSERT_EQ(world.bodies().asleep[coin.index] != 0, asleep);
      switch (what) {
        case Destroyed::Coin:
          world.destroy(coin);
          break;
        case Destroyed::CoinsShape:
          world.destroy(round);
          break;
        case Destroyed::Gate:
          world.destroy(gate);
          break;
        case Destroyed::Floor:
          world.destroy(floor);
          break;
      }
      const double then = world.time();
      const std::size_t ends = what == Destroyed::Coin || what == Destroyed::CoinsShape ? 2 : 1;
      World loaded = load_snapshot(save_snapshot(world));
      for (World* each : {&world, &loaded}) {
        const auto& events = each->step(1.0 / 60).events;
        ASSERT_EQ(events.size(), ends);
        for (const ContactEvent& event : events) {
          EXPECT_EQ(event.kind, ContactEventKind::End);
          EXPECT_EQ(event.time, then);
          EXPECT_TRUE(event.shape_a == round || event.shape_b == round);
          EXPECT_TRUE(event.body_a == coin || event.body_b == coin);
          EXPECT_EQ(event.sensor, event.shape_a == zone || event.shape_b == zone);
        }
        EXPECT_TRUE(each->step(1.0 / 60).events.empty());
      }
    }
  }
}

TEST(Events, AreInPairsWhateverIsDestroyedAndMade) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const auto uniform = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    World world;
    const BodyId pit = world.create_body({.type = BodyType::Static});
    for (const Shape& side : {make_half_plane({0, 0}, {0, 1}), make_half_plane({-1.5, 0}, {1, 0}),
                              make_half_plane({1.5, 0}, {-1, 0})})
      world.add_shape(pit, {.shape = side});
    const auto make = [&] {
      const BodyId body =
          world.create_body({.position = {uniform(-1, 1), uniform(0.5, 2)}, .angle = uniform(-3, 3)});
      world.add_shape(
          body, {.shape = make_box({uniform(0.2, 0.5), uniform(0.2, 0.5)}), .sensor = uniform(0, 1) < 0.1});
      return body;
    };
    std::vector<BodyId> bodies(12);
    for (BodyId& body : bodies) body = make();
    Counted counted;
    for (int step = 0; step < 60; ++step) {
      counted.add(world.step(1.0 / 60));
      for (const auto& [a, of_a, b, of_b] : counted.open) {
        EXPECT_TRUE(world.alive(ShapeId{a, of_a}));
        EXPECT_TRUE(world.alive(ShapeId{b, of_b}));
      }
      if (step % 3 != 0) continue;
      BodyId& one = bodies[random() % bodies.size()];
      world.destroy(one);
      one = make();
    }
    for (const BodyId body : bodies) world.destroy(body);
    counted.add(world.step(1.0 / 60));
    EXPECT_TRUE(counted.open.empty());
  }
}

// Solid shapes leave what little they overlap in flow to the next step; sensors tell it in this one.
TEST(Events, OfSensorsComeInTheStepInWhichWhatFlowsMeetsThem) {
  std::mt19937_64 random(3);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  World world;
  const BodyId pit = world.create_body({.type = BodyType::Static});
  for (const Shape& side :
       {make_half_plane({0, 0}, {0, 1}), make_half_plane({-4, 0}, {1, 0}), make_half_plane({4, 0}, {-1, 0})})
    world.add_shape(pit, {.shape = side});
  const auto first_sensor = static_cast<std::uint32_t>(world.shapes().size());
  for (int i = 0; i < 100; ++i) {
    const double x = uniform(-4, 4), y = uniform(0, 2);
    const BodyId gate = world.create_body({.type = BodyType::Static, .position = {x, y}});
    world.add_shape(gate, {.shape = make_box({0.3, 0.3}), .sensor = true});
  }
  const auto first_capsule = static_cast<std::uint32_t>(world.shapes().size());
  for (int row = 0; row < 6; ++row) {
    BodyId last;
    for (int column = 0; column < 10; ++column) {
      const Vec2 at{-3.6 + 0.8 * column, 1 + 0.8 * row};
      const BodyId body = world.create_body({.position = at, .velocity = {6 * uniform(-1, 1), -20}});
      world.add_shape(body,
                      {.shape = make_capsule({-0.35, 0}, {0.35, 0}, 0.05), .material = {.restitution = 0.5}});
      if (column % 2 == 1)
        world.create_joint(
            {.kind = JointKind::Revolute, .a = last, .b = body, .anchor_a = {at.x - 0.4, at.y}});
      last = body;
    }
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> told;
  for (int step = 0; step < 10; ++step) {
    for (const ContactEvent& event : world.step(1.0 / 60).events) {
      if (!event.sensor) continue;
      const std::pair pair(event.shape_a.index, event.shape_b.index);
      if (event.kind == ContactEventKind::Begin) told.insert(pair);
      if (event.kind == ContactEventKind::End) told.erase(pair);
    }
    const auto shapes = world.shapes();
    for (std::uint32_t i = first_sensor; i < first_capsule; ++i) {
      for (std::uint32_t j = first_capsule; j < shapes.size(); ++j) {
        const double gap =
            distance(shapes[i].shape, world.pose(shapes[i].body), shapes[j].shape, world.pose(shapes[j].body))
                .distance;
        if (std::abs(gap) < 1e-9) continue;
        ASSERT_EQ(told.count({i, j}), gap < 0 ? 1u : 0u)
            << "step " << step << " sensor " << i << " capsule " << j << " gap " << gap;
      }
    }
  }
  EXPECT_GT(told.size(), 10u);
}

TEST(Events, OfAChainNameItsSegmentWhicheverShapeWasMadeFirst) {
  for (const bool chain_first : {true, false}) {
    World world;
    world.observe({.contacts = true});
    const auto make_chain_of_three = [&] {
      const BodyId ground = world.create_body({.type = BodyType::Static});
      world.add_shape(ground, rough(make_chain(std::vector<Vec2>{{-4, 0}, {-2, 0}, {0, 0}, {4, 0}}), 0.5));
    };
    if (chain_first) make_chain_of_three();
    add(world, {1, 0.499}, rough(make_disc(0.5), 0.5));
    if (!chain_first) make_chain_of_three();
    world.step(1.0 / 60);
    ASSERT_FALSE(world.report().events.empty()) << chain_first;
    for (const ContactEvent& event : world.report().events) EXPECT_EQ(event.segment, 2) << chain_first;
    ASSERT_EQ(world.report().contacts_list.size(), 1u);
    EXPECT_EQ(world.report().contacts_list[0].island, 0) << chain_first;
  }
}

TEST(Events, OfABounceWithinAStepHaveItsTimeAndPlace) {
  World world(weightless());
  world.observe({.contacts = true});
  add_ground(world, smooth(make_disc(1), 1));
  add(world, {0, 0.6}, smooth(make_disc(0.5), 1), 1, {20, -20});
  world.step(1.0 / 60);
  int hits = 0;
  for (const ContactEvent& event : world.report().events) {
    if (event.kind != ContactEventKind::Hit) continue;
    ++hits;
    EXPECT_NEAR(event.time, 0.1 / 20, 1e-12);
    EXPECT_NEAR(length(event.point - Vec2{0.1, 0}), 0, 1e-9);
  }
  EXPECT_EQ(hits, 1);
  ASSERT_EQ(world.report().contacts_list.size(), 1u);
  const ContactReport& contact = world.report().contacts_list[0];
  EXPECT_NEAR(length(contact.points[0].impact_position - Vec2{0.1, 0}), 0, 1e-9);
}

TEST(Events, OfABounceOnAFaceKeepItsNormalWhenTheBodyIsPastTheCorner) {
  World world(weightless());
  world.observe({.contacts = true});
  const BodyId block = world.create_body({.type = BodyType::Static, .position = {0, -1}});
  world.add_shape(block, smooth(make_box({2, 2}), 1));
  add(world, {0.6, 0.6}, smooth(make_disc(0.5), 1), 1, {40, -20});
  world.step(1.0 / 60);
  ASSERT_EQ(world.report().contacts_list.size(), 1u);
  EXPECT_GT(world.report().contacts_list[0].normal.x, 0.1);
  EXPECT_NEAR(world.report().contacts_list[0].impact_normal.y, 1, 1e-12);
}

TEST(Events, OfSensorsAreOfLiftsToo) {
  // Neither of the two is dynamic, whichever of them the sensor belongs to.
  for (const bool gate_feels : {true, false}) {
    World world;
    ShapeDef gate = smooth(make_box({1, 1})), lift = smooth(make_box({0.5, 0.5}));
    (gate_feels ? gate : lift).sensor = true;
    world.add_shape(world.create_body({.type = BodyType::Static}), gate);
    world.add_shape(world.create_body({.type = BodyType::Kinematic, .position = {-2, 0}, .velocity = {2, 0}}),
                    lift);
    int begins = 0, ends = 0;
    for (int i = 0; i < 120; ++i) {
      for (const ContactEvent& event : world.step(1.0 / 60).events) {
        begins += event.kind == ContactEventKind::Begin;
        ends += event.kind == ContactEventKind::End;
      }
    }
    EXPECT_EQ(begins, 1) << gate_feels;
    EXPECT_EQ(ends, 1) << gate_feels;
  }
}

TEST(Events, ABlowThatPassesThroughAContactIsNoHitOfIt) {
  // The box lands, rests, and is struck from above: its ground bears the second blow, too.
  World world;
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
  const BodyId box = add(world, {0, 0.6}, rough(make_box({1, 1}), 0.5));
  BodyId ball;
  int landed = 0, struck = 0;
  for (int i = 0; i < 90; ++i) {
    if (i == 30) ball = add(world, {0, 1.5}, smooth(make_disc(0.25)));
    for (const ContactEvent& event : world.step(1.0 / 60).events) {
      if (event.kind != ContactEventKind::Hit) continue;
      EXPECT_GT(event.approach_speed, 0.1);
      landed += event.body_a == ground && event.body_b == box;
      struck += event.body_a == box && event.body_b == ball;
    }
  }
  EXPECT_EQ(landed, 1);
  EXPECT_EQ(struck, 1);
}

TEST(Events, OfAFaceAreInItsMiddle) {
  World world(weightless());
  world.observe({.contacts = true});
  add_ground(world, smooth(make_disc(1)));
  const BodyId box = add(world, {7, 0.6}, smooth(make_box({1, 1})), 1, {0, -10});
  int told = 0;
  for (int i = 0; i < 4; ++i) {
    if (i == 3) world.set_velocity(box, {0, 5}, 0);
    for (const ContactEvent& event : world.step(1.0 / 60).events) {
      if (event.kind != ContactEventKind::Begin && event.kind != ContactEventKind::Persist) continue;
      ++told;
      EXPECT_NEAR(length(event.point - Vec2{7, 0}), 0, 1e-9);
      EXPECT_NEAR(length(event.normal - Vec2{0, 1}), 0, 1e-9);
    }
  }
  EXPECT_GE(told, 2);
}

}  // namespace events_test
}  // namespace skerry
