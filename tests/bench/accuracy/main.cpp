// SPDX-License-Identifier: MIT
//
// accuracy_bench: run time against error, stress and scaling, for us and for the engines that are
// installed.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "tests/bench/accuracy/options.h"
#include "tests/bench/accuracy/problem.h"

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
  --engine NAME   only this one; may be repeated
  --runs N        timed runs of each setting (default 5)
  --cap S         precision: leave out settings finer than 1/60 s that take longer than this [s] (default 0.3)
)";

void list() {
  for (const EngineEntry& engine : engines())
    std::printf("%-12s %s\n", engine.name.c_str(), engine.version.c_str());
  for (const Problem& problem : problems())
    std::printf("%-20s %s\n%20s   %s\n%20s   %s\n", problem.name.c_str(), problem.title.c_str(), "",
                problem.measure.c_str(), "", problem.source.c_str());
}

int run(int count, char** arguments) {
  Options options;
  std::vector<std::string> parts;
  const auto usage = [](const std::string& what) {
    std::fprintf(stderr, "accuracy_bench: %s\n\n%s", what.c_str(), kUsage);
    return 2;
  };
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (argument == "-h" || argument == "--help") {
      std::fputs(kUsage, stdout);
      return 0;
    }
    if (argument[0] != '-') {
      parts.push_back(argument);
      continue;
    }
    if (i + 1 == count) return usage(argument + " needs a value");
    const std::string value = arguments[++i];
    if (argument == "-o") {
      options.out = value;
    } else if (argument == "--scene") {
      options.scenes.push_back(value);
    } else if (argument == "--engine") {
      options.engines.push_back(value);
    } else if (argument == "--runs") {
      options.runs = std::max(1, std::atoi(value.c_str()));
    } else if (argument == "--cap") {
      options.cap = std::atof(value.c_str());
    } else {
      return usage("unknown option " + argument);
    }
  }
  if (parts.empty()) return usage("which part?");
  for (const std::string& part : parts) {
    if (part == "list") {
      list();
      continue;
    }
    std::filesystem::create_directories(options.out);
    if (part == "precision") {
      run_precision(options);
    } else if (part == "stress") {
      run_stress(options);
    } else if (part == "scaling") {
      run_scaling(options);
    } else if (part == "skips") {
      run_skips(options);
    } else if (part == "demos") {
#ifdef SKERRY_WITH_SANDBOX
      run_demos(options);
#else
      return usage("demos: built without the sandbox (SKERRY_RENDER=OFF)");
#endif
    } else {
      return usage("unknown part " + part);
    }
  }
  return 0;
}

}  // namespace
}  // namespace skerry::bench

int main(int count, char** arguments) {
  try {
    return skerry::bench::run(count, arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "accuracy_bench: %s\n", error.what());
    return 4;
  }
}
