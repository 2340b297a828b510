// SPDX-License-Identifier: MIT
//
// Runs in processes of their own. What an engine leaves of the heap decides how near to each other the bodies
// of the next one lie: Box2D's ragdolls took 11 or 23 ms a step, by which of our runs was before them.
#pragma once

#include <cinttypes>
#include <cstdio>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/bench/scale_run.h"

namespace skerry::scale {

/// Makes `run()` in a new process. @throws std::runtime_error if that ends without a result
template <class MakeRun>
Run alone(MakeRun&& run) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("scale_bench: no pipe");
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("scale_bench: no process");
  if (child == 0) {
    close(ends[0]);
    const Run made = run();
    std::FILE* out = fdopen(ends[1], "w");
    std::fprintf(out, "%zu %a %a %a %a %d %" PRIu64 " %zu %zu\n", made.bodies, made.deepest,
                 made.mean_deepest, made.apart, made.residual, made.asleep, made.state_hash, made.ms.size(),
                 made.collision.size());
    for (const std::vector<double>* times : {&made.ms, &made.collision})
      for (const double ms : *times) std::fprintf(out, "%a\n", ms);
    std::fprintf(out, "%s\n%s\n", made.scene.c_str(), made.engine.c_str());
    _exit(std::fclose(out) == 0 ? 0 : 1);
  }
  close(ends[1]);
  std::FILE* in = fdopen(ends[0], "r");
  Run made;
  std::size_t steps = 0, collisions = 0;
  bool whole = std::fscanf(in, "%zu %la %la %la %la %d %" SCNu64 " %zu %zu", &made.bodies, &made.deepest,
                           &made.mean_deepest, &made.apart, &made.residual, &made.asleep, &made.state_hash,
                           &steps, &collisions) == 9;
  for (std::size_t i = 0; whole && i < steps; ++i)
    whole = std::fscanf(in, "%la", &made.ms.emplace_back()) == 1;
  for (std::size_t i = 0; whole && i < collisions; ++i)
    whole = std::fscanf(in, "%la", &made.collision.emplace_back()) == 1;
  char scene[64], engine[64];
  whole = whole && std::fscanf(in, " %63[^\n] %63[^\n]", scene, engine) == 2;
  std::fclose(in);
  int status = 0;
  waitpid(child, &status, 0);
  if (!whole || status != 0) throw std::runtime_error("scale_bench: a run ended without a result");
  made.scene = scene;
  made.engine = engine;
  return made;
}

}  // namespace skerry::scale
