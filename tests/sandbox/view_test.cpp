// SPDX-License-Identifier: MIT
//
// The parts between the world and the picture: matrix cells, layout, history, loop.
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "sandbox/delassus_cells.h"
#include "sandbox/history.h"
#include "sandbox/layout.h"
#include "sandbox/loop.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace view_test {

IslandSystem random_system(int bodies, int rows, std::mt19937& random) {
  std::uniform_real_distribution<double> value(-1, 1);
  std::uniform_int_distribution<int> body(-1, bodies - 1);
  IslandSystem system;
  for (int i = 0; i < bodies; ++i)
    system.bodies.push_back({0.5 + std::abs(value(random)), std::abs(value(random))});
  while (system.size() < rows) {
    Row row;
    row.a = body(random);
    row.b = body(random);
    if (row.a == row.b) continue;
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (row.a >= 0) row.Ja[at] = value(random);
      if (row.b >= 0) row.Jb[at] = value(random);
    }
    system.rows.push_back(row);
    system.b.push_back(0);
  }
  return system;
}

// Column j of W is W e_j - b with b = 0.
std::vector<double> column(const IslandSystem& system, int j) {
  std::vector<double> unit(static_cast<std::size_t>(system.size()), 0.0);
  unit[static_cast<std::size_t>(j)] = 1;
  return row_velocities(system, unit);
}

TEST(DelassusCells, AgreeWithTheOperatorOnUnitImpulses) {
  std::mt19937 random(20240611);
  for (int trial = 0; trial < 20; ++trial) {
    IslandSystem system = random_system(5, 12, random);
    if (trial % 2) system.compliance.assign(12, 0.25);
    const CellGrid grid = delassus_cells(system, 100);
    ASSERT_EQ(grid.size, 12);
    int nonzeros = 0;
    double largest = 0;
    for (int j = 0; j < 12; ++j) {
      const std::vector<double> exact = column(system, j);
      for (int i = 0; i < 12; ++i) {
        EXPECT_NEAR(grid.at(i, j), exact[static_cast<std::size_t>(i)], 1e-14) << i << ' ' << j;
        nonzeros += exact[static_cast<std::size_t>(i)] != 0;
        largest = std::max(largest, std::abs(exact[static_cast<std::size_t>(i)]));
      }
    }
    EXPECT_EQ(grid.nonzeros, nonzeros);
    EXPECT_NEAR(grid.largest, largest, 1e-14);
  }
}

TEST(DelassusCells, LargeSystemsKeepTheLargestOfEachBlock) {
  std::mt19937 random(5);
  const IslandSystem system = random_system(6, 30, random);
  const CellGrid full = delassus_cells(system, 30);
  const CellGrid small = delassus_cells(system, 10);
  ASSERT_EQ(small.size, 10);
  EXPECT_EQ(small.nonzeros, full.nonzeros);
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) {
      double largest = 0;
      for (int k = 0; k < 9; ++k)
        largest = std::max(largest, std::abs(full.at(3 * i + k / 3, 3 * j + k % 3)));
      EXPECT_EQ(std::abs(small.at(i, j)), largest);
    }
  }
  EXPECT_EQ(delassus_cells(IslandSystem{}, 10).size, 0);
}

TEST(Layout, RoundsScalesDown) {
  EXPECT_DOUBLE_EQ(round_down_125(1), 1);
  EXPECT_DOUBLE_EQ(round_down_125(4.99), 2);
  EXPECT_DOUBLE_EQ(round_down_125(0.05), 0.05);
  EXPECT_DOUBLE_EQ(round_down_125(999), 500);
  EXPECT_DOUBLE_EQ(round_down(999), 700);
  EXPECT_DOUBLE_EQ(round_down(0.16), 0.15);
}

TEST(Layout, ViewFillsWhatHeaderFooterAndColumnLeave) {
  const View view{{3, -2}, 10, 0};
  for (const bool column : {false, true}) {
    const render::Camera camera = place_camera(view, 1280, 720, column);
    const render::Point top = camera.to_pixels({3, 3});
    const render::Point bottom = camera.to_pixels({3, -7});
    EXPECT_NEAR(top.y, kHeaderPx, 1e-9);
    EXPECT_NEAR(bottom.y, 720 - kFooterPx, 1e-9);
    EXPECT_NEAR(top.x, column ? (1280 - kColumnPx - 2 * kMarginPx) / 2 : 640, 1e-9);
  }
  const render::Camera wide = place_camera({{0, 0}, 1, 100}, 1280, 720, false);
  EXPECT_NEAR(wide.width(), 100, 1e-9);
}

Demo demo_of(const TemporaryFolder& folder, const std::string& source, DemoOptions options = {}) {
  return Demo(folder.write("d.lua", source), options);
}

TEST(Loop, FramesShowTheStepsOfTheirTimes) {
  const TemporaryFolder folder;
  struct Case {
    double dt, fps, speed;
    std::uint64_t frames;
    std::vector<std::uint64_t> first;  // steps done at the first frames
  };
  for (const Case& c :
       {Case{1.0 / 60, 60, 1, 60, {0, 1, 2, 3, 4}}, Case{1.0 / 240, 60, 1, 60, {0, 4, 8, 12, 16}},
        Case{1.0 / 60, 30, 1, 30, {0, 2, 4, 6, 8}}, Case{1.0 / 60, 60, 0.5, 120, {0, 1, 1, 2, 2}},
        Case{1.0 / 60, 60, 2, 30, {0, 2, 4, 6, 8}}}) {
    Demo demo = demo_of(folder, "demo{ title = 'T', seconds = 1 }", {.dt = c.dt});
    std::vector<std::uint64_t> steps;
    LoopCallbacks callbacks;
    callbacks.frame = [&](const Demo& running) {
      EXPECT_NEAR(running.shown_time(), static_cast<double>(steps.size()) * c.speed / c.fps, 1e-12);
      steps.push_back(running.steps_done());
    };
    EXPECT_EQ(frame_count(demo, {c.fps, c.speed}), c.frames);
    EXPECT_TRUE(run_loop(demo, {c.fps, c.speed}, callbacks));
    EXPECT_EQ(steps.size(), c.frames);
    steps.resize(5);
    EXPECT_EQ(steps, c.first) << c.dt << ' ' << c.fps << ' ' << c.speed;
    EXPECT_EQ(demo.steps_done(), demo.total_steps());
  }
}

TEST(Loop, SlowMotionShowsTheMotionWithinSteps) {
  const TemporaryFolder folder;
  Demo demo = demo_of(folder,
                      "demo{ title = 'T', seconds = 0.8, dt = 0.1, restitution = 0.5, friction = 0 }\n"
                      "ground{ y = 0 }\n"
                      "disc{ at = {0, 1.5}, radius = 0.5, mass = 1 }");
  const double hit = std::sqrt(2 / 9.81);
  double worst = 0;
  std::size_t frames = 0;
  LoopCallbacks callbacks;
  callbacks.frame = [&](const Demo& running) {
    const double t = running.shown_time(), after = t - hit;
    const double y =
        after < 0 ? 1.5 - 0.5 * 9.81 * t * t : 0.5 + 0.5 * 9.81 * hit * after - 0.5 * 9.81 * after * after;
    worst = std::max(worst, std::abs(running.shown(1).position.y - y));
    ++frames;
  };
  EXPECT_TRUE(run_loop(demo, {60, 0.1}, callbacks));
  EXPECT_EQ(frames, 480u);
  EXPECT_LE(worst, 1e-12);
}

TEST(History, KeepsAnImpactForItsTimeAndTheEquationsWithNames) {
  const TemporaryFolder folder;
  Demo demo = demo_of(folder,
                      "demo{ title = 'T', gravity = {0, 0}, friction = 0, restitution = 1 }\n"
                      "disc{ at = {-1.5, 0}, radius = 0.5, mass = 1, velocity = {10, 0}, name = 'left' }\n"
                      "disc{ at = {0, 0}, radius = 0.5, mass = 1 }",
                      {.dt = 0.01, .seconds = 1.0});
  demo.observe({.contacts = true, .systems = true});
  History history(demo, true, 0.2);
  EXPECT_EQ(history.system(), nullptr);
  int visible = 0;
  double brightest = 0;
  while (demo.steps_done() < demo.total_steps()) {
    demo.step();
    history.update(demo);
    visible += !history.flashes().empty();
    for (const Flash& flash : history.flashes()) {
      brightest = std::max(brightest, history.brightness(flash));
      EXPECT_NEAR(flash.impulse, 10, 1e-9);
    }
  }
  EXPECT_NEAR(visible, 20, 2);
  EXPECT_EQ(brightest, 1);
  EXPECT_NEAR(history.largest_impulse(), 10, 1e-9);
  ASSERT_NE(history.system(), nullptr);
  EXPECT_TRUE(history.system()->impact);
  EXPECT_NEAR(history.system()->time, 0.05, 1e-9);
  EXPECT_EQ(history.system()->row_names, std::vector<std::string>{"left-B"});
}

}  // namespace view_test
}  // namespace skerry::sandbox
