// SPDX-License-Identifier: MIT
//
// Pair finding: every implementation of the registry beside the peers that are installed, on the same moving
// boxes in the same run. A measured step is: give the new boxes, get the pairs (ours: sorted and exact).
//   broadphase_bench --benchmark_filter='U/100000' --benchmark_format=csv > u.csv
//   python3 tests/bench/broadphase_plot.py u.csv crossover.svg
#include <benchmark/benchmark.h>
#include <cmath>
#include <cstring>
#include <malloc.h>
#include <map>
#include <random>
#include <sstream>

#include "tests/bench/broadphase_scenes.h"

namespace skerry::bench {

namespace {

constexpr unsigned kSeed = 20261121;
constexpr int kRays = 100;
constexpr double kLargest = 300;  ///< M: ratio of sizes

/// Sizes from 1 to kLargest with density size^-3, by inversion.
double power_law_size(double u) {
  return 1 / std::sqrt(1 - u * (1 - 1 / (kLargest * kLargest)));
}

class Ours final : public PairBench {
 public:
  Ours(std::string_view name, int threads)
      : broad_phase_(make_broad_phase(name, {.cell_size = 0, .axes = {}, .threads = threads})) {}
  void build(const BoxScene& scene) override {
    for (std::size_t i = 0; i < scene.boxes().size(); ++i) {
      broad_phase_->insert(static_cast<ProxyIndex>(i), scene.boxes()[i],
                           scene.is_fixed(i) ? ProxyKind::Fixed : ProxyKind::Moving);
    }
    broad_phase_->moved_pairs(pairs_);
  }
  std::size_t step(const BoxScene& scene, const std::vector<BoxUpdate>& updates) override {
    std::size_t met = 0;
    for (const Ray& ray : scene.rays()) {
      broad_phase_->ray_cast(ray, found_);
      met += found_.size();
    }
    if (!scene.rays().empty()) return met;
    broad_phase_->update(updates);
    broad_phase_->moved_pairs(pairs_);
    return pairs_.size();
  }

 private:
  std::unique_ptr<BroadPhase> broad_phase_;
  std::vector<Pair> pairs_;
  std::vector<ProxyIndex> found_;
};

/// Largest scene that an implementation gets: quadratic methods, and those that are O(sqrt n) a box.
std::size_t most_for(std::string_view name) {
  if (name == "brute_force") return 10000;
  if (name == "hash_sort" || name == "hierarchical_hash_sort" || name == "sweep_and_prune") return 100000;
  return 1000000;
}

std::vector<BenchEntry> ours() {
  std::vector<BenchEntry> entries;
  for (const BroadPhaseEntry& entry : broad_phases()) {
    const std::string name(entry.name);
    entries.push_back({name, most_for(name), [name] { return std::make_unique<Ours>(name, 1); }, true});
  }
  // Those that use threads, timed by the wall: to be compared with the rows of one thread on an idle machine.
  for (const std::string name : {"hierarchical_grid", "neighbour_list"}) {
    entries.push_back({name + "_2_threads", most_for(name),
                       [name] { return std::make_unique<Ours>(name, 2); }, true, true});
  }
  return entries;
}

/// Processor time of this thread, because other programs on the machine count little in it; or the wall time.
double seconds(bool by_wall) {
  timespec now{};
  clock_gettime(by_wall ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// What reading the clock adds to a measured time: nothing beside a large scene, half of a step beside a
/// bullet.
double reading_time(bool by_wall) {
  double least = kInfinity;
  for (int i = 0; i < 1000; ++i) {
    const double start = seconds(by_wall);
    least = std::min(least, seconds(by_wall) - start);
  }
  return least;
}

std::size_t heap_bytes() {
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

/// A scene with a structure over it, kept while Google Benchmark calls again with more iterations.
struct Run {
  std::string name;
  std::unique_ptr<BoxScene> scene;
  std::unique_ptr<PairBench> bench;
  double bytes = 0;
};

void run(benchmark::State& state, const BenchEntry& entry, char distribution, std::size_t count) {
  static Run current;
  const std::string name = entry.name + '/' + distribution + '/' + std::to_string(count);
  if (current.name != name) {
    current = {};
    current.name = name;
    current.scene = std::make_unique<BoxScene>(distribution, count);
    const std::size_t before = heap_bytes();
    current.bench = entry.make();
    current.bench->build(*current.scene);
    for (int i = 0; i < 3; ++i) current.bench->step(*current.scene, current.scene->advance());
    current.bytes = static_cast<double>(heap_bytes() - before);
  }
  std::size_t pairs = 0;
  // Steps are not alike where a structure is renewed every few: an iteration has several, and gives their
  // mean.
  const int steps = entry.is_ours ? 12 : 4;
  double total = 0, least = kInfinity, most = 0;
  const double reading = reading_time(entry.by_wall);
  for (auto _ : state) {
    double sum = 0;
    for (int step = 0; step < steps; ++step) {
      const std::vector<BoxUpdate>& updates = current.scene->advance();
      const double start = seconds(entry.by_wall);
      pairs = current.bench->step(*current.scene, updates);
      const double time = seconds(entry.by_wall) - start - reading;
      sum += time;
      least = std::min(least, time);
      most = std::max(most, time);
    }
    state.SetIterationTime(sum / steps);
    total += sum / steps;
  }
  // Of R a ray counts, not a body.
  const auto n = static_cast<double>(distribution == 'R' ? kRays : count);
  state.counters["ns_body"] = 1e9 * total / static_cast<double>(state.iterations()) / n;
  state.counters["ns_body_min"] = 1e9 * least / n;
  state.counters["ns_body_max"] = 1e9 * most / n;
  state.counters["bytes_body"] = current.bytes / static_cast<double>(count);
  state.counters["pairs_body"] = static_cast<double>(pairs) / n;
}

}  // namespace

void BoxScene::add(Vec2 centre, Vec2 half, Vec2 velocity) {
  boxes_.push_back({centre - half, centre + half});
  velocity_.push_back(velocity);
}

BoxScene::BoxScene(char distribution, std::size_t count) {
  std::mt19937_64 random(kSeed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto n = static_cast<double>(count);
  if (distribution == 'C') {
    // Rows of touching boxes, eight times as wide as high, in the order in which they fell: row by row.
    floor_ = trembles_ = true;
    const int columns = std::max(1, static_cast<int>(std::sqrt(8 * n)));
    world_ = {{-1e9, -1e9}, {1e9, 1e9}};
    add({0.5 * columns, -1}, {1.0 * columns, 0.5}, {});
    for (std::size_t i = 1; i < count; ++i) {
      const auto k = static_cast<int>(i) - 1;
      const Vec2 centre{0.97 * (k % columns) + 0.2 * (k / columns % 3), 0.97 * (k / columns)};
      add(centre + Vec2{uniform(-0.02, 0.02), uniform(-0.02, 0.02)}, {0.5, 0.5}, {0.1, 0});
      active_.push_back(static_cast<std::uint32_t>(i));
    }
    return;
  }
  // Overlaps a box = n E[(a + b)^2] / area = 3.
  double mean = 1, mean_square = 1;
  if (distribution == 'M') {
    mean = mean_square = 0;
    for (int i = 0; i < 100000; ++i) {
      const double size = power_law_size((i + 0.5) / 100000);
      mean += size / 100000;
      mean_square += size * size / 100000;
    }
  }
  const double side = std::sqrt(n * 2 * (mean_square + mean * mean) / 3);
  world_ = {{0, 0}, {side, side}};
  for (std::size_t i = 0; i < count; ++i) {
    const double size = distribution == 'M' ? power_law_size(uniform(0, 1)) : 1;
    const double angle = uniform(0, 2 * kPi), speed = (distribution == 'F' ? 5 : 0.1) * size;
    const SinCos sc = sin_cos(angle);
    add({uniform(0, side), uniform(0, side)}, {size / 2, size / 2}, {speed * sc.cos, speed * sc.sin});
    const bool is_active = distribution == 'S'   ? i % 100 == 0
                           : distribution == 'F' ? i == 0
                                                 : distribution != 'R';
    if (is_active) active_.push_back(static_cast<std::uint32_t>(i));
  }
  for (int i = 0; i < (distribution == 'R' ? kRays : 0); ++i) {
    const SinCos sc = sin_cos(uniform(0, 2 * kPi));
    rays_.push_back({{uniform(0, side), uniform(0, side)}, {0.1 * side * sc.cos, 0.1 * side * sc.sin}, 1});
  }
}

const std::vector<BoxUpdate>& BoxScene::advance() {
  updates_.clear();
  for (const std::uint32_t i : active_) {
    Aabb& box = boxes_[i];
    Vec2& v = velocity_[i];
    // Fly straight and turn at the walls.
    if (box.lower.x < world_.lower.x) v.x = std::abs(v.x);
    if (box.upper.x > world_.upper.x) v.x = -std::abs(v.x);
    if (box.lower.y < world_.lower.y) v.y = std::abs(v.y);
    if (box.upper.y > world_.upper.y) v.y = -std::abs(v.y);
    if (trembles_) {
      // Around its place, in another direction every step.
      const SinCos turn = sin_cos(2.4 + 0.001 * (i % 100));
      v = rotate({turn.cos, turn.sin}, v);
    }
    const Vec2 by = v;
    box = {box.lower + by, box.upper + by};
    updates_.push_back({i, box});
  }
  return updates_;
}

}  // namespace skerry::bench

int main(int argc, char** argv) {
  using namespace skerry::bench;
  std::vector<BenchEntry> entries = ours();
  std::string names, skipped;
  for (BenchEntry& peer : peers()) {
    names += (names.empty() ? "" : ", ") + peer.name;
    entries.push_back(std::move(peer));
  }
  for (const std::size_t count : {1000, 10000, 100000, 1000000}) {
    for (const char distribution : {'U', 'M', 'C', 'S', 'F', 'R'}) {
      for (const BenchEntry& entry : entries) {
        if (distribution == 'R' && !entry.is_ours) continue;
        const std::string name = entry.name + '/' + distribution + '/' + std::to_string(count);
        if (count > entry.most) {
          if (distribution == 'U') skipped += ' ' + entry.name + '/' + std::to_string(count);
          continue;
        }
        benchmark::RegisterBenchmark(name.c_str(),
                                     [=](benchmark::State& state) { run(state, entry, distribution, count); })
            ->UseManualTime()
            ->Unit(benchmark::kMicrosecond);
      }
    }
  }
  benchmark::AddCustomContext("peers", names.empty() ? "none found" : names);
  benchmark::AddCustomContext("skipped as too slow", skipped);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
