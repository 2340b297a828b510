// SPDX-License-Identifier: MIT
//
// accuracy_bench: run time against error, stress and scaling, for us and for the engines that are
// installed.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

#include "tests/bench/accuracy/options.h"
#include "tests/bench/accuracy/problem.h"
#include "tests/bench/arguments.h"

namespace skerry::bench {

void merge_csv(const Options& options, const std::string& name, const std::string& header,
               const std::vector<std::string>& replaced, const std::vector<std::string>& rows) {
  const auto field = [](const std::string& line, std::size_t column) {
    std::size_t begin = 0;
    for (std::size_t k = 0; k < column; ++k) begin = line.find(',', begin) + 1;
    return line.substr(begin, line.find(',', begin) - begin);
  };
  const std::size_t engine = header.find(",engine,");
  const auto column = static_cast<std::size_t>(
      engine == std::string::npos ? 0 : 1 + std::count(header.begin(), header.begin() + engine, ','));
  const std::string file = options.out + '/' + name;
  std::vector<std::string> lines;
  {
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    while (line == header && std::getline(in, line) && !line.empty()) {
      const bool again = std::find(replaced.begin(), replaced.end(), field(line, 0)) != replaced.end();
      if (!again || (column > 0 && !options.wants_engine(field(line, column)))) lines.push_back(line);
      line = header;
    }
  }
  lines.insert(lines.end(), rows.begin(), rows.end());
  std::ofstream out(file);
  out << header << '\n';
  for (const std::string& line : lines) out << line << '\n';
  out.flush();
  if (!out) throw std::runtime_error("cannot write " + file);
}

std::string joined(std::initializer_list<std::string> fields) {
  std::string text;
  for (const std::string& field : fields) {
    if (!text.empty()) text.push_back(',');
    text.append(field);
  }
  return text;
}

namespace {

double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

double thread_seconds() {
  return seconds_of(CLOCK_THREAD_CPUTIME_ID);
}

double process_seconds() {
  return seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

namespace {

constexpr const char* kUsage =
    R"(usage: accuracy_bench PART... [options]

parts
  precision   problems with known answers: error against wall time
  stress      one parameter at a time to its extremes: who explodes, sinks, drifts, jitters
  scaling     time a step against the number of bodies, by stage
  skips       what each skip of a step saves
  demos       the same for every demo, frames included (where the sandbox is built)
  list        the scenes and the engines
options
  -o DIR          folder of the tables (default accuracy-results)
  --scene NAME    only this one; may be repeated
  --engine NAME   precision, stress, scaling: only this one; may be repeated
  --runs N        precision, skips, demos: timed runs of each setting (default 5)
  --cap S         precision: leave out settings finer than 1/60 s that take longer than this [s] (default 0.3)
)";

void list(const Options&) {
  for (const EngineEntry& engine : engines())
    std::printf("%-12s %s\n", engine.name.c_str(), engine.version.c_str());
  for (const Problem& problem : problems())
    std::printf("%-20s %s\n%20s   %s\n%20s   %s\n", problem.name.c_str(), problem.title.c_str(), "",
                problem.measure.c_str(), "", problem.source.c_str());
}

struct Part {
  const char* name;
  const char* options;  ///< those that it heeds
  void (*run)(const Options& options);
  std::vector<std::string> (*scenes)();
};

#ifdef SKERRY_WITH_SANDBOX
constexpr Part kDemos{"demos", "-o --scene --runs", run_demos, demo_scenes};
#else
constexpr Part kDemos{"demos", "-o --scene --runs", nullptr, nullptr};
#endif
constexpr Part kParts[] = {{"list", "", list, precision_scenes},
                           {"precision", "-o --scene --engine --runs --cap", run_precision, precision_scenes},
                           {"stress", "-o --scene --engine", run_stress, stress_scenes},
                           {"scaling", "-o --scene --engine", run_scaling, scaling_scenes},
                           {"skips", "-o --scene --runs", run_skips, skip_scenes},
                           kDemos};

bool heeds(const Part& part, const std::string& option) {
  std::istringstream words(part.options);
  return std::find(std::istream_iterator<std::string>(words), {}, option) !=
         std::istream_iterator<std::string>();
}

int run(int count, char** arguments) {
  Options options;
  std::vector<std::string> parts, given;
  const auto usage = [](const std::string& what) {
    std::fprintf(stderr, "accuracy_bench: %s\n\n%s", what.c_str(), kUsage);
    return 2;
  };
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (!argument.starts_with('-')) {
      parts.push_back(argument);
      continue;
    }
    given.push_back(argument);
    if (argument == "-o") {
      options.out = value_of(count, arguments, i);
    } else if (argument == "--scene") {
      options.scenes.emplace_back(value_of(count, arguments, i));
    } else if (argument == "--engine") {
      options.engines.emplace_back(value_of(count, arguments, i));
    } else if (argument == "--runs") {
      options.runs = count_of(argument, value_of(count, arguments, i), 1);
    } else if (argument == "--cap") {
      options.cap = number_of(argument, value_of(count, arguments, i), 0, 1e9);
    } else {
      return usage("unknown option " + argument);
    }
  }
  if (parts.empty()) return usage("which part?");
  // All that is asked for is known before anything runs.
  std::vector<const Part*> chosen;
  std::vector<std::string> known;
  for (const std::string& name : parts) {
    const auto* part =
        std::find_if(std::begin(kParts), std::end(kParts), [&](const Part& p) { return name == p.name; });
    if (part == std::end(kParts)) return usage("unknown part " + name);
    if (part->run == nullptr) return usage(name + ": built without the sandbox (SKERRY_RENDER=OFF)");
    chosen.push_back(part);
    const std::vector<std::string> more = part->scenes();
    known.insert(known.end(), more.begin(), more.end());
  }
  for (const std::string& option : given) {
    if (std::none_of(chosen.begin(), chosen.end(), [&](const Part* p) { return heeds(*p, option); }))
      return usage(option + " does nothing in this part");
  }
  for (const std::string& name : options.scenes) expect_name("scene", name, known);
  for (const std::string& name : options.engines) expect_name("engine", name, names_of(engines()));
  for (const Part* part : chosen) {
    if (heeds(*part, "-o")) std::filesystem::create_directories(options.out);
    part->run(options);
  }
  return 0;
}

}  // namespace
}  // namespace skerry::bench

int main(int count, char** arguments) {
  using namespace skerry::bench;
  return run_with_arguments("accuracy_bench", kUsage, count, arguments, run);
}
