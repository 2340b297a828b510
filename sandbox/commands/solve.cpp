// SPDX-License-Identifier: MIT
//
// `skerry solve`: any contact problem from a file, by any solver.
#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>

#include "physics/export.h"
#include "physics/import.h"
#include "physics/solver/solver.h"
#include "physics/text.h"
#include "sandbox/commands/commands.h"
#include "sandbox/errors.h"
#include "sandbox/names.h"
#include "sandbox/output.h"

namespace skerry::sandbox {
namespace {

struct Options {
  std::string file, out;
  std::string solver = "auto";
  SolveOptions solve;
  double budget = 0;  // millions of row visits
  bool warm = false, json = false;
};

ImportedProblem read(const std::string& path) {
  try {
    return read_problem(path);
  } catch (const std::exception& error) {
    throw ScriptError(error.what());
  }
}

const SolverEntry& chosen_solver(const std::string& name) {
  std::vector<std::string> names;
  for (const SolverEntry& entry : solvers()) names.emplace_back(entry.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    throw UsageError("--solver: no \"" + name + '"' + suggestion(name, names));
  return find_solver(name);
}

struct Answer {
  Solution solution;
  double floor = 0;    // residual that rounding alone explains
  double seconds = 0;  // of the call, without reading and writing
};

Answer solve(const ImportedProblem& problem, const Options& options) {
  const SolverEntry& solver = chosen_solver(options.solver);
  if (!problem.has_bodies && solver.solve_contact == nullptr)
    throw UsageError("--solver: " + options.solver + " needs the bodies of the island; " + options.file +
                     " gives W alone");
  const std::vector<double> warm = options.warm ? problem.lambda : std::vector<double>();
  Answer answer;
  const auto begin = std::chrono::steady_clock::now();
  answer.solution = problem.has_bodies ? solver.solve(problem.island, warm, options.solve, nullptr)
                                       : solver.solve_contact(problem.contact, warm, options.solve, nullptr);
  answer.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  answer.floor = problem.has_bodies ? residual_floor(problem.island, answer.solution.lambda)
                                    : residual_floor(problem.contact, answer.solution.lambda);
  return answer;
}

int contacts_of(const std::vector<Row>& rows) {
  return static_cast<int>(
      std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.kind == RowKind::Normal; }));
}

void print_json(std::ostream& out, const Options& options, const ImportedProblem& problem,
                const std::vector<Row>& rows, const Answer& answer) {
  const Solution& s = answer.solution;
  nlohmann::ordered_json json{{"file", options.file},
                              {"rows", rows.size()},
                              {"contacts", contacts_of(rows)},
                              {"solver", options.solver},
                              {"method", s.method},
                              {"status", to_string(s.status)},
                              {"residual", s.residual},
                              {"floor", answer.floor},
                              {"iterations", s.iterations},
                              {"factorisations", s.work.factorisations},
                              {"pivots", s.work.pivots},
                              {"visits", s.work.visits},
                              {"seconds", answer.seconds},
                              {"lambda", s.lambda}};
  if (problem.has_bodies) json["bodies"] = problem.island.bodies.size();
  if (s.trace) {
    json["trace"] = nlohmann::ordered_json::array();
    for (const SolveIteration& it : s.trace->iterations) {
      json["trace"].push_back({{"residual", it.residual},
                               {"open", it.open},
                               {"stick", it.stick},
                               {"slip", it.slip},
                               {"changes", it.pivots}});
    }
    json["notes"] = s.trace->notes;
  }
  out << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
}

void print_text(std::ostream& out, const Options& options, const ImportedProblem& problem,
                const std::vector<Row>& rows, const Answer& answer) {
  const Solution& s = answer.solution;
  const auto number = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return std::string(text);
  };
  out << options.file << ": " << rows.size() << " rows, " << contacts_of(rows) << " contacts";
  if (problem.has_bodies) out << ", " << problem.island.bodies.size() << " bodies";
  out << "\n  solver      " << options.solver;
  if (s.method != options.solver && !s.method.empty()) out << " (" << s.method << ')';
  out << "\n  status      " << to_string(s.status);
  out << "\n  residual    " << number(s.residual) << "  (rounding " << number(answer.floor) << ')';
  out << "\n  iterations  " << s.iterations << ", factorisations " << s.work.factorisations << ", pivots "
      << s.work.pivots << ", row visits " << number(s.work.visits);
  out << "\n  time        " << number(1e3 * answer.seconds) << " ms\n";
  if (!s.trace) return;
  for (const std::string& note : s.trace->notes) out << "  - " << note << '\n';
  if (s.trace->iterations.empty()) return;
  out << "  iteration  residual   open  stick   slip  changes\n";
  for (std::size_t k = 0; k < s.trace->iterations.size(); ++k) {
    const SolveIteration& it = s.trace->iterations[k];
    char line[80];
    std::snprintf(line, sizeof line, "  %9zu  %8.2e %6d %6d %6d %8d\n", k + 1, it.residual, it.open, it.stick,
                  it.slip, it.pivots);
    out << line;
  }
}

int solve_file(const Options& options, const Io& io) {
  const ImportedProblem problem = read(options.file);
  if (options.warm && problem.lambda.empty())
    throw UsageError("--warm: " + options.file + " comes without impulses");
  const std::vector<Row>& rows = problem.has_bodies ? problem.island.rows : problem.contact.rows;
  const Answer answer = solve(problem, options);
  if (!options.out.empty()) {
    std::ostringstream text;
    write_matrix_market(text, answer.solution.lambda);
    write_results(io, {{options.out, text.str()}});
  }
  std::ostream& out = words_beside(io, options.out);
  (options.json ? print_json : print_text)(out, options, problem, rows, answer);
  return answer.solution.status == SolveStatus::Solved ? kGood : kCheckFailed;
}

}  // namespace

Action setup_solve(OptionTable& table) {
  auto options = std::make_shared<Options>();
  table
      .add("FILE", options->file,
           "Island as JSON, any file of a MatrixMarket set (x_W.mtx), or a Siconos friction problem or LCP")
      .required()
      .type("");
  std::vector<std::string> names;
  for (const SolverEntry& entry : solvers()) names.emplace_back(entry.name);
  table.add("--solver", options->solver, "One of: " + join(names)).type("NAME");
  table.add("-o,--out", options->out, "Writes lambda in MatrixMarket form (- for standard output)")
      .type("FILE");
  table.add("--tolerance", options->solve.tolerance, "Relative residual to reach (default 1e-10)")
      .non_negative();
  table
      .add("--budget", options->budget,
           "Bound on the counted work, in millions of row visits of some 10 ns (default: none)")
      .non_negative();
  table
      .add("--iterations", options->solve.max_iterations,
           "Bound on sweeps, pivots or factorisations (default: the solver's own)")
      .whole(1, std::numeric_limits<int>::max());
  table.add_flag("--warm", options->warm, "Starts from the impulses that the file holds");
  table.add_flag("--trace", options->solve.trace, "Prints residual and states by iteration");
  table.add_flag("--json", options->json, "Machine-readable, with lambda");
  return [options](const Io& io) {
    options->solve.work_limit = 1e6 * options->budget;
    return solve_file(*options, io);
  };
}

}  // namespace skerry::sandbox
