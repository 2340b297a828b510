// SPDX-License-Identifier: MIT
//
// Paths of bodies and what a stroboscope shows of them.
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sandbox/errors.h"
#include "sandbox/history.h"
#include "sandbox/loop.h"
#include "sandbox/painter.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace traces_test {

constexpr const char* kBall = R"(
demo{ title = "T", seconds = 2, dt = 0.03, friction = 0, view = { x = 0, y = 1, height = 4 } }
ground{ y = 0, restitution = 1 }
local ball = disc{ at = {0, 1.25}, radius = 0.25, mass = 1, velocity = {1, 0}, restitution = 1 }
)";
constexpr double kG = 9.81;

/// Height of the middle of that ball above its lowest place: it bounces back to where it came from.
double height_at(double t) {
  const double fall = std::sqrt(2 / kG);  // 1 m
  const double since = std::abs(std::remainder(t, 2 * fall));
  return 1 - 0.5 * kG * since * since;
}

class Watched {
 public:
  Watched(const std::string& script, bool paths) : demo_(folder_.write("d.lua", script), {}) {
    demo_.observe({.paths = paths});
    history_.emplace(demo_, false, kFlashSeconds);
  }
  void until(double time) {
    const std::uint64_t steps = steps_until(time, demo_.dt());
    while (demo_.steps_done() < steps) {
      demo_.step();
      history_->update(demo_);
    }
  }
  Demo& demo() { return demo_; }
  const History& history() const { return *history_; }
  const std::vector<Trace>& traces() const { return history_->traces().list(); }

 private:
  TemporaryFolder folder_;
  Demo demo_;
  std::optional<History> history_;
};

TEST(Traces, FollowTheMotionWithinSteps) {
  Watched run(std::string(kBall) + "show{ 'traces' }", true);
  run.until(1.8);
  ASSERT_EQ(run.traces().size(), 1u);
  const std::vector<TracePoint>& path = run.traces()[0].path.samples();
  EXPECT_EQ(path.size(), 1u + 4 * 60);
  double lowest = 1;
  for (const TracePoint& point : path) {
    EXPECT_NEAR(point.at.x, point.time, 1e-12);
    EXPECT_NEAR(point.at.y - 0.25, height_at(point.time), 1e-9) << point.time;
    lowest = std::min(lowest, point.at.y - 0.25);
  }
  // It comes down at 4.4 m/s; the points are 7.5 ms apart.
  EXPECT_LT(lowest, 4.5 * 0.0075);
}

TEST(Traces, StrobesComeWhenTheyShouldWhereverStepsEnd) {
  Watched run(std::string(kBall) + "show{ 'traces', strobe = 0.1 }", true);
  run.until(1.8);
  const std::vector<StrobePose>& strobes = run.traces()[0].strobes.samples();
  ASSERT_EQ(strobes.size(), 19u);
  for (std::size_t k = 0; k < strobes.size(); ++k) {
    const double time = 0.1 * static_cast<double>(k);
    EXPECT_NEAR(strobes[k].time, time, 1e-7);
    EXPECT_NEAR(strobes[k].pose.p.x, time, 1e-7);
    EXPECT_NEAR(strobes[k].pose.p.y - 0.25, height_at(time), 1e-6) << time;
  }
}

TEST(Traces, HaveTheEndsOfStepsWhereNothingElseIsKnown) {
  Watched run(std::string(kBall) + "show{ strobe = 0.1 }", false);
  run.until(1.8);
  const std::vector<TracePoint>& path = run.traces()[0].path.samples();
  EXPECT_GE(path.size(), 61u);
  EXPECT_NEAR(path.back().at.y - 0.25, height_at(1.8), 1e-9);
}

TEST(Traces, AreOfThePointsThatTheScriptNames) {
  Watched run(R"(
demo{ title = "T", seconds = 2, gravity = {0, 0} }
disc{ at = {5, 5}, radius = 1 }
local wheel = disc{ at = {1, 0}, radius = 1, omega = math.pi }
show{ "traces", trace = { wheel, { wheel, {0.5, 0} } } })",
              true);
  run.until(1);
  ASSERT_EQ(run.traces().size(), 2u);
  const std::vector<TracePoint>&centre = run.traces()[0].path.samples(),
        &rim = run.traces()[1].path.samples();
  ASSERT_EQ(rim.size(), centre.size());
  for (std::size_t i = 0; i < rim.size(); ++i) {
    EXPECT_NEAR(length(centre[i].at - Vec2{1, 0}), 0, 1e-12);
    const Vec2 arm{0.5 * std::cos(kPi * rim[i].time), 0.5 * std::sin(kPi * rim[i].time)};
    EXPECT_NEAR(length(rim[i].at - Vec2{1, 0} - arm), 0, 1e-9);
  }
}

TEST(Traces, StayOfWhatIsRemovedAndBeginWithWhatIsMade) {
  Watched run(R"(
demo{ title = "T", seconds = 2 }
local first = disc{ at = {0, 0}, radius = 0.1 }
at(0.5, function() first:remove() disc{ at = {3, 0}, radius = 0.1 } end)
show{ "traces" })",
              true);
  run.until(1);
  ASSERT_EQ(run.traces().size(), 2u);
  EXPECT_NEAR(run.traces()[0].path.samples().back().time, 0.5, 1e-9);
  EXPECT_GT(run.traces()[1].path.samples().front().time, 0.5);
  EXPECT_NEAR(run.traces()[1].path.samples().back().time, 1, 1e-9);
  EXPECT_EQ(run.traces()[1].path.samples().front().at.x, 3);
}

TEST(Traces, StaySmallHoweverLongTheRun) {
  std::string script = "demo{ title = 'T', seconds = 40 }\nshow{ strobe = 0.05 }\n";
  for (int i = 0; i < 100; ++i)
    script +=
        "disc{ at = {" + std::to_string(i) + ", 0}, radius = 0.1, gravity_scale = 0, velocity = {1, 0} }\n";
  Watched run(script, true);
  run.until(40);
  EXPECT_EQ(run.traces().size(), kMostTraces);
  for (const Trace& trace : run.traces()) {
    EXPECT_LE(trace.path.samples().size(), 1025u);
    EXPECT_GE(trace.path.samples().size(), 512u);
    const std::vector<StrobePose>& strobes = trace.strobes.samples();
    EXPECT_LE(strobes.size(), 257u);
    // Equal distances, but for the newest.
    for (std::size_t i = 2; i + 1 < strobes.size(); ++i)
      EXPECT_NEAR(strobes[i].time - strobes[i - 1].time, strobes[1].time - strobes[0].time, 1e-6);
  }
  EXPECT_LT(run.history().bytes(), std::size_t{8} << 20);
}

std::size_t lines_until(Watched& run, double shown, const std::vector<std::string>& overlays) {
  run.demo().show_at(shown);
  Composer composer(render::style(render::Theme::Light), 640, 360);
  composer.show(overlays, 640, 360);
  render::DrawList list;
  Selection selection;
  composer.scene(run.demo(), run.history(), composer.camera(run.demo()), selection, list);
  for (const render::Line& line : list[render::Layer::Structure].lines) EXPECT_LE(line.to.x, shown + 1e-9);
  for (const render::Marker& dot : list[render::Layer::Structure].markers) EXPECT_LE(dot.at.x, shown + 1e-9);
  return list[render::Layer::Structure].lines.size();
}

TEST(Traces, DoNotShowWhatIsStillToCome) {
  Watched run(std::string(kBall) + "show{ 'traces', strobe = 0.01 }", true);
  run.until(0.9);
  // Between the ends of two steps, a frame is older than what has been computed.
  const std::size_t all = lines_until(run, 0.9, {"traces"}), some = lines_until(run, 0.885, {"traces"});
  EXPECT_GT(some, 100u);
  EXPECT_LT(some, all);
  EXPECT_EQ(lines_until(run, 0.9, {}), 0u);
}

std::string error_of(const std::string& line) {
  const TemporaryFolder folder;
  try {
    const Demo demo(
        folder.write("d.lua",
                     "demo{ title = 'T', seconds = 2 }\nlocal b = disc{ at = {0, 0}, radius = 1 }\n" + line),
        {});
  } catch (const ScriptError& error) {
    const std::string text = error.what();
    return text.substr(text.find("d.lua"));
  }
  return "";
}

TEST(Traces, RefuseWhatTheyDoNotUnderstand) {
  EXPECT_EQ(error_of("show{ trace = b }"), "");
  EXPECT_EQ(error_of("show{ trace = { b, { b, {1, 2} } } }"), "");
  EXPECT_EQ(error_of("show{ trace = 3 }"),
            "d.lua:3: show: trace expected a list of bodies or {body, {x, y}}, got the number 3");
  EXPECT_EQ(error_of("show{ trace = { 'b' } }"),
            "d.lua:3: show: trace expected a list of bodies or {body, {x, y}}, got the string \"b\"");
  EXPECT_THAT(error_of("show{ trace = { { b, 2 } } }"),
              testing::HasSubstr("show: trace expected a list of bodies"));
  EXPECT_THAT(error_of("show{ trace = { b, { {1, 2} } } }"),
              testing::HasSubstr("show: trace expected a list of bodies"));
  EXPECT_EQ(error_of("show{ trace = {} }"), "d.lua:3: show: trace names no body");
  EXPECT_EQ(error_of("local all = {} for i = 1, 65 do all[i] = b end show{ trace = all }"),
            "d.lua:3: show: trace expected at most 64 bodies, got 65");
  EXPECT_EQ(error_of("show{ strobe = 0.001 }"),
            "d.lua:3: show: strobe must be at least a thousandth of the demo's 2 s, got 0.001");
  EXPECT_EQ(error_of("show{ strobe = -1 }"),
            "d.lua:3: show: strobe must be at least a thousandth of the demo's 2 s, got -1");
}

}  // namespace traces_test
}  // namespace skerry::sandbox
