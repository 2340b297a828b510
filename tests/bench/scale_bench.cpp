// SPDX-License-Identifier: MIT
//
// Whole steps of large scenes, ours and those of Box2D 2.4 and 3, made from one description; see kUsage.
#include <algorithm>
#include <cstdio>
#include <numeric>
#include <string>
#include <vector>

#include "physics/solver/solver.h"
#include "physics/stepping/stepper.h"
#include "physics/world.h"
#include "tests/bench/arguments.h"
#include "tests/bench/everyday_scenes.h"
#include "tests/bench/scale_alone.h"
#include "tests/bench/scale_run.h"

namespace {

using namespace skerry;
using namespace skerry::scale;

constexpr const char* kUsage =
    R"(usage: scale_bench [OPTION...] [SCENE...]

A Markdown row for each scene and engine: bodies, steps made within the budget, mean, median and slowest
step [ms], of the mean pairs and narrow phase [ms], with --overlaps (for which times are of no use) the
deepest overlap of all steps and the mean of each step's [m], largest gap of a hinge [m], residual of the
contact problem in the last step, bodies asleep at the end. Then the ratios, losing ones first, of the
steps that all made: of each copy the beginning for which the budget of all was enough. With one thread
times are processor times, but pairs and narrow phase are by the clock, ours in a second run. Every engine
runs in a process of its own. Box2D 2.4 runs with its defaults and without its continuous collision; ratios
are to both.

options
  --steps N       at most (default 120)
  --budget S      of one engine in one scene [s] (default 20)
  --threads N     of ours (default 1)
  --solver NAME   of ours (default auto)
  --flow-work N   of ours: row visits a body and step in islands that flow; 0: no limit
  --stepper NAME  of ours (default time_stepping)
  --awake         nothing sleeps
  --fresh         nor are islands at rest kept: every step solves everything
  --overlaps      measured after every step
  --ours          ours alone, in this process
  --turns N       ours alone, so often with one thread and with --threads of them in turn: each step takes
                  the least of its times by the clock, as its bits are the same; the row has the sums,
                  their ratio, and whether the bits are; the exit status is 1 where they are not
  --copies N      of each scene N copies in which what moves has a little speed of its own; a row is over
                  all of their steps: another way of the same pile takes up to 1.2 times as long
  --everyday      the scenes of `everyday_scenes.h` in place of the well-known ones
  --peer-work N   peers make N times their usual iterations (2.4: 8 and 3) or sub-steps (3: 4)
  --peer-stiff    and contacts of Box2D 3 are N times as stiff, as its limit for so many sub-steps allows
)";

void print(const Run& row) {
  std::printf("| %s | %s | %zu | %zu | %.3f | %.3f | %.3f | %.3f | ", row.scene.c_str(), row.engine.c_str(),
              row.bodies, row.ms.size(), row.mean(), row.median(),
              *std::max_element(row.ms.begin(), row.ms.end()), row.mean_collision());
  if (row.deepest >= 0)
    std::printf("%.1e | %.1e", row.deepest, row.mean_deepest);
  else
    std::printf("- | -");
  std::printf(" | %.1e | ", row.apart);
  if (row.residual >= 0)
    std::printf("%.1e", row.residual);
  else
    std::printf("-");
  std::printf(" | %d |\n", row.asleep);
  std::fflush(stdout);
}

World make_world(const Scene& scene, const Options& options, std::vector<BodyId>& bodies) {
  WorldConfig config;
  config.gravity = scene.gravity;
  config.threads = options.threads;
  config.solver = options.solver;
  config.flow_work = options.flow_work;
  config.stepper = options.stepper;
  config.sleep = !options.awake;
  config.reuse_resting = !options.fresh;
  World world(config);
  for (const Item& item : scene.items) {
    const BodyId body = world.create_body({.type = item.type,
                                           .position = item.at,
                                           .angle = item.angle,
                                           .velocity = item.velocity,
                                           .omega = item.omega});
    for (const Part& part : item.parts) {
      ShapeDef def;
      def.shape = part.half.y > 0 ? make_box({2 * part.half.x, 2 * part.half.y}, part.at, part.angle)
                                  : make_disc(part.half.x, part.at);
      def.density = item.density;
      def.material.friction = scene.friction;
      def.material.restitution = scene.restitution;
      world.add_shape(body, def);
    }
    bodies.push_back(body);
  }
  for (const Hinge& hinge : scene.hinges) {
    world.create_joint({.a = bodies[static_cast<std::size_t>(hinge.a)],
                        .b = bodies[static_cast<std::size_t>(hinge.b)],
                        .anchor_a = hinge.at});
  }
  return world;
}

/// Pairs and narrow phase of so many steps [ms], in a run of its own: an observer of the stages reads
/// the clock a dozen times for each island, which is up to a twentieth of a step.
std::vector<double> collision_of_ours(const Scene& scene, const Options& options, std::size_t steps) {
  std::vector<BodyId> bodies;
  World world = make_world(scene, options, bodies);
  world.observe({.stage_times = true});
  std::vector<double> ms;
  for (std::size_t i = 0; i < steps; ++i) {
    const StepReport& report = world.step(1.0 / 60);
    ms.push_back(1e3 * (report.stage_seconds[static_cast<int>(Stage::Broad)] +
                        report.stage_seconds[static_cast<int>(Stage::Narrow)]));
  }
  return ms;
}

/// Without pairs and narrow phase.
Run run_ours(const char* name, const Scene& scene, const Options& options) {
  std::vector<BodyId> bodies;
  World world = make_world(scene, options, bodies);
  Run row{name, "Skerry " + options.solver, scene.items.size(), {}};
  OverlapLog overlaps(scene, options, [&](std::size_t i) {
    return Transform{world.position(bodies[i]), Rot::from_angle(world.angle(bodies[i]))};
  });
  measure(
      options, row, [&] { world.step(1.0 / 60); },
      [&] {
        overlaps.note(row);
        for (const Hinge& hinge : scene.hinges) {
          const auto anchor = [&](int item) {
            const BodyId body = bodies[static_cast<std::size_t>(item)];
            const Rot turn = Rot::from_angle(world.angle(body));
            return world.position(body) + rotate(turn, anchor_on(scene, item, hinge.at));
          };
          row.apart = std::max(row.apart, length(anchor(hinge.a) - anchor(hinge.b)));
        }
      });
  row.residual = world.report().worst_residual;
  row.asleep = world.report().bodies_asleep;
  row.state_hash = world.report().state_hash;
  return row;
}

/// Calls `note(run)` after that of each peer that is installed.
template <class Note>
void run_peers([[maybe_unused]] const char* name, [[maybe_unused]] const Scene& scene,
               [[maybe_unused]] const Options& options, [[maybe_unused]] Note&& note) {
#ifdef SKERRY_WITH_BOX2D
  for (const bool continuous : {true, false})
    note(alone([&] { return run_box2d(name, scene, options, continuous); }));
#endif
#ifdef SKERRY_WITH_BOX2D3
  note(alone([&] { return run_box2d3(name, scene, options); }));
#endif
}

struct Ratio {
  std::string scene, peer;
  double mean, median, collision;  ///< ours over the peer's
};

Ratio ratio_of(const Run& ours, const Run& peer) {
  return {ours.scene, peer.engine, ours.mean() / peer.mean(), ours.median() / peer.median(),
          ours.mean_collision() / peer.mean_collision()};
}

using Copies = std::vector<Run>;  // of a scene, by one engine

Run together(const Copies& copies) {
  Run all = copies.front();
  for (std::size_t k = 1; k < copies.size(); ++k) all.append(copies[k]);
  return all;
}

/// Leaves of each copy the steps that all engines made.
void cut_to_shared(std::vector<Copies>& engines) {
  for (std::size_t k = 0; k < engines.front().size(); ++k) {
    std::size_t steps = engines.front()[k].ms.size();
    for (const Copies& engine : engines) steps = std::min(steps, engine[k].ms.size());
    for (Copies& engine : engines) engine[k].cut(steps);
  }
}

void print(std::vector<Ratio> ratios) {
  std::sort(ratios.begin(), ratios.end(), [](const Ratio& x, const Ratio& y) { return x.mean > y.mean; });
  std::printf(
      "\nOurs / the peer's over the steps that all made, the losing ones first:\n\n| scene | peer | mean "
      "step | median step | pairs + "
      "narrow phase |\n"
      "| --- | --- | --- | --- | --- |\n");
  for (const Ratio& r : ratios)
    std::printf("| %s | %s | %.3g | %.3g | %.3g |\n", r.scene.c_str(), r.peer.c_str(), r.mean, r.median,
                r.collision);
}

/// What threads gain. @param turns  runs of each kind @return whether all runs with as many steps ended with
/// the same bits
bool compare_threads(const char* name, const Scene& scene, Options options, int turns) {
  const int threads = options.threads;
  options.by_clock = true;
  std::vector<double> least[2];
  Run first;
  bool same = true;
  for (int turn = 0; turn < 2 * turns; ++turn) {
    options.threads = turn % 2 == 0 ? 1 : threads;
    const Run run = alone([&] { return run_ours(name, scene, options); });
    if (turn == 0) first = run;
    same &= run.ms.size() != first.ms.size() || run.state_hash == first.state_hash;
    std::vector<double>& all = least[turn % 2];
    if (all.empty()) all = run.ms;
    all.resize(std::min(all.size(), run.ms.size()));
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = std::min(all[i], run.ms[i]);
  }
  const auto steps = static_cast<std::ptrdiff_t>(std::min(least[0].size(), least[1].size()));
  const double one = std::accumulate(least[0].begin(), least[0].begin() + steps, 0.0);
  const double many = std::accumulate(least[1].begin(), least[1].begin() + steps, 0.0);
  std::printf("| %s | %zu | %td | %.1f | %.1f | %.2f | %s |\n", name, scene.items.size(), steps, one, many,
              one / many, same ? "yes" : "NO");
  std::fflush(stdout);
  return same;
}

std::vector<Named> all_scenes() {
  std::vector<Named> all = kScenes;
  all.insert(all.end(), kEverydayScenes.begin(), kEverydayScenes.end());
  return all;
}

/// The copies of a scene that are asked for, or itself.
std::vector<Scene> copies_of(const Named& named, const Options& options) {
  std::vector<Scene> copies{named.make()};
  if (options.copies == 0) return copies;
  copies.resize(static_cast<std::size_t>(options.copies), copies.front());
  for (std::size_t k = 0; k < copies.size(); ++k) disturb(copies[k], static_cast<unsigned>(k) + 1);
  return copies;
}

/// Adds the run of a copy to those of the engine at this place.
void add(std::vector<Copies>& engines, std::size_t place, const Run& run) {
  if (place == engines.size()) engines.emplace_back();
  engines[place].push_back(run);
}

int run(int argc, char** argv) {
  using namespace bench;
  Options options;
  int turns = 0;
  bool ours_alone = false, everyday = false;
  std::vector<std::string> wanted, given;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.starts_with('-')) given.push_back(word);
    const auto value = [&] { return value_of(argc, argv, i); };
    const auto count = [&] { return count_of(word, value(), 1); };
    if (word == "--steps")
      options.steps = count();
    else if (word == "--budget")
      options.budget = number_of(word, value(), 1e-6, 1e9);
    else if (word == "--threads")
      options.threads = count_of(word, value(), 1, 1024);
    else if (word == "--turns")
      turns = count();
    else if (word == "--solver")
      expect_name("solver", options.solver = value(), names_of(solvers()));
    else if (word == "--flow-work")
      options.flow_work = number_of(word, value(), 0, 1e12);
    else if (word == "--peer-work")
      options.peer_work = count();
    else if (word == "--copies")
      options.copies = count();
    else if (word == "--everyday")
      everyday = true;
    else if (word == "--peer-stiff")
      options.peer_stiff = true;
    else if (word == "--stepper")
      expect_name("stepper", options.stepper = value(), names_of(steppers()));
    else if (word == "--overlaps")
      options.overlaps = true;
    else if (word == "--ours")
      ours_alone = true;
    else if (word == "--awake")
      options.awake = true;
    else if (word == "--fresh")
      options.awake = options.fresh = true;
    else if (word.starts_with('-'))
      throw BadArgument("no option " + word);
    else
      wanted.push_back(word);
  }
  if (turns > 0) {
    expect_only("--turns", given,
                {"--steps", "--budget", "--threads", "--solver", "--flow-work", "--stepper", "--awake",
                 "--fresh", "--copies", "--everyday"});
    if (options.threads == 1) throw BadArgument("--turns compares with --threads 2 or more");
  }
  if (options.peer_stiff && options.peer_work == 1)
    throw BadArgument("--peer-stiff needs --peer-work 2 or more");
  if (ours_alone && options.peer_work > 1) throw BadArgument("--ours does not go with --peer-work");
  std::vector<Named> scenes = everyday ? kEverydayScenes : wanted.empty() ? kScenes : all_scenes();
  for (const std::string& name : wanted) expect_name("scene", name, names_of(scenes));
  std::erase_if(scenes, [&](const Named& named) {
    return !wanted.empty() && std::find(wanted.begin(), wanted.end(), named.name) == wanted.end();
  });
  if (turns > 0) {
    std::printf(
        "| scene | bodies | steps | one thread ms | %d threads ms | ratio | same bits |\n"
        "| --- | --- | --- | --- | --- | --- | --- |\n",
        options.threads);
    bool same = true;
    for (const Named& named : scenes)
      for (const Scene& scene : copies_of(named, options))
        same &= compare_threads(named.name, scene, options, turns);
    return same ? 0 : 1;
  }
  std::printf(
      "| scene | engine | bodies | steps | mean ms | median ms | slowest ms | pairs + narrow ms | "
      "deepest m | mean deepest m | joints m | "
      "residual | asleep |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- "
      "|\n");
  std::vector<Ratio> ratios;
  for (const Named& named : scenes) {
    std::vector<Copies> engines;  // ours first
    for (const Scene& scene : copies_of(named, options)) {
      const auto make = [&] {
        Run run = run_ours(named.name, scene, options);
        run.collision = collision_of_ours(scene, options, run.ms.size());
        return run;
      };
      // A profile wants to see it.
      add(engines, 0, ours_alone ? make() : alone(make));
      if (ours_alone) continue;
      std::size_t place = 1;
      run_peers(named.name, scene, options, [&](const Run& peer) { add(engines, place++, peer); });
    }
    for (const Copies& engine : engines) print(together(engine));
    cut_to_shared(engines);
    for (std::size_t k = 1; k < engines.size(); ++k)
      ratios.push_back(ratio_of(together(engines.front()), together(engines[k])));
  }
  if (!ratios.empty()) print(std::move(ratios));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::run_with_arguments("scale_bench", kUsage, argc, argv, run);
}
