// SPDX-License-Identifier: MIT
#include "physics/statics/limit_load.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/text.h"

#ifdef SKERRY_WITH_CLP
#include <ClpSimplex.hpp>
#include <CoinPackedMatrix.hpp>
#endif

namespace skerry::statics {

const char* to_string(LimitStatus status) {
  switch (status) {
    case LimitStatus::Optimal:
      return "optimal";
    case LimitStatus::Unbounded:
      return "unbounded";
    case LimitStatus::Infeasible:
      return "infeasible";
    case LimitStatus::NoLoad:
      return "no live load";
    case LimitStatus::Unavailable:
      return "unavailable";
    case LimitStatus::Failed:
      return "failed";
  }
  return "";
}

bool limit_load_available() {
#ifdef SKERRY_WITH_CLP
  return true;
#else
  return false;
#endif
}

std::string limit_load_missing() {
  return "built without COIN-OR Clp; install coinor-libclp-dev and configure again";
}

namespace {

void check(const IslandSystem& system, const BodyLoads& loads) {
  validate(system);
  if (loads.size() != system.bodies.size())
    throw std::invalid_argument("limit load: " + std::to_string(loads.size()) + " loads for " +
                                std::to_string(system.bodies.size()) + " bodies");
  for (std::size_t k = 0; k < loads.size(); ++k)
    for (const double value : loads[k])
      if (!std::isfinite(value))
        throw std::invalid_argument("limit load: load " + std::to_string(k + 1) + " is " + to_text(value));
}

#ifdef SKERRY_WITH_CLP

constexpr double kTolerance =
    1e-13;  // of the LP, whose forces are scaled to the largest load; Clp reaches it

/// The programme: force columns, then the columns that a question adds.
class Programme {
 public:
  Programme(const IslandSystem& system, const BodyLoads& dead, Sliding sliding)
      : system_(system), equations_(3 * static_cast<int>(system.bodies.size())) {
    // Torques over a typical lever, so that all equations are forces of one size.
    double sum = 0;
    int count = 0;
    for (const Row& row : system.rows) {
      for (const auto& J : {row.Ja, row.Jb}) {
        if (J[2] == 0) continue;
        sum += std::abs(J[2]);
        ++count;
      }
    }
    if (count > 0) arm_ = sum / count;
    force_ = size(dead);
    if (!(force_ > 0)) force_ = 1;
    for (std::size_t k = 0; k < dead.size(); ++k) {
      const InverseMass& mass = system.bodies[k];
      for (std::size_t c = 0; c < 3; ++c) {
        // What cannot turn is in equilibrium there.
        const bool held = c == 2 && mass.linear > 0 && !(mass.angular > 0);
        const double missing = -dead[k][c] / unit(c, force_);
        lower_row_.push_back(held ? -COIN_DBL_MAX : missing);
        upper_row_.push_back(held ? COIN_DBL_MAX : missing);
      }
    }
    for (const Row& row : system.rows) add_force(row, sliding);
  }

  /// The largest of the loads, torques as forces at the lever.
  double size(const BodyLoads& loads) const {
    double largest = 0;
    for (const auto& load : loads)
      largest = std::max({largest, std::hypot(load[0], load[1]), std::abs(load[2]) / arm_});
    return largest;
  }

  /// What counts as 1 in an equation if a force of `force` does.
  double unit(std::size_t c, double force) const { return c == 2 ? force * arm_ : force; }

  /// Adds a column of the equations; `values` one a body component.
  void add_column(const std::vector<double>& values, double upper, double cost) {
    for (std::size_t i = 0; i < values.size(); ++i) add_entry(static_cast<int>(i), columns_, values[i]);
    lower_.push_back(0);
    upper_.push_back(upper);
    cost_.push_back(cost);
    ++columns_;
  }

  int equations() const { return equations_; }
  double force() const { return force_; }
  double arm() const { return arm_; }

  /// @return Clp's status: 0 optimal, 1 infeasible, 2 unbounded
  int solve() {
    const CoinPackedMatrix matrix(true, rows_.data(), at_.data(), values_.data(),
                                  static_cast<CoinBigIndex>(values_.size()));
    CoinPackedMatrix sized(matrix);
    sized.setDimensions(static_cast<int>(lower_row_.size()), columns_);
    simplex_.setLogLevel(0);
    simplex_.loadProblem(sized, lower_.data(), upper_.data(), cost_.data(), lower_row_.data(),
                         upper_row_.data());
    simplex_.setPrimalTolerance(kTolerance);
    simplex_.setDualTolerance(kTolerance);
    simplex_.setMaximumIterations(200000);
    simplex_.primal();
    return simplex_.status();
  }
  const double* solution() const { return simplex_.primalColumnSolution(); }
  const double* duals() const { return simplex_.dualRowSolution(); }
  double objective() const { return simplex_.objectiveValue(); }

 private:
  void add_entry(int row, int column, double value) {
    if (value == 0) return;
    rows_.push_back(row);
    at_.push_back(column);
    values_.push_back(value);
  }

  void add_force(const Row& row, Sliding sliding) {
    const auto add = [&](int body, const std::array<double, 3>& J) {
      for (int c = 0; body >= 0 && c < 3; ++c)
        add_entry(3 * body + c, columns_, J[static_cast<std::size_t>(c)] / (c == 2 ? arm_ : 1));
    };
    add(row.a, row.Ja);
    add(row.b, row.Jb);
    const bool bounded = row.normal >= 0;
    const bool free_friction = row.kind == RowKind::Friction && sliding == Sliding::None;
    lower_.push_back(bounded || row.lower == -kInfinity ? -COIN_DBL_MAX : row.lower / force_);
    upper_.push_back(bounded || row.upper == kInfinity ? COIN_DBL_MAX : row.upper / force_);
    cost_.push_back(0);
    if (bounded && !free_friction) {
      for (const double sign : {-1.0, 1.0}) {
        const int at = static_cast<int>(lower_row_.size());
        add_entry(at, row.normal, row.mu);
        add_entry(at, columns_, sign);
        lower_row_.push_back(0);
        upper_row_.push_back(COIN_DBL_MAX);
      }
    }
    ++columns_;
  }

  const IslandSystem& system_;
  int equations_;
  double force_ = 0, arm_ = 1;
  int columns_ = 0;
  std::vector<int> rows_, at_;
  std::vector<double> values_, lower_, upper_, cost_, lower_row_, upper_row_;
  ClpSimplex simplex_;
};

#endif

}  // namespace

LimitLoad limit_load(const IslandSystem& system, const BodyLoads& dead, const BodyLoads& live,
                     Sliding sliding) {
  check(system, dead);
  check(system, live);
  LimitLoad result;
#ifdef SKERRY_WITH_CLP
  Programme programme(system, dead, sliding);
  // Its own scale: a live load that is tiny beside the dead one is a load all the same.
  const double live_force = programme.size(live);
  const bool loaded = live_force > 0;
  if (loaded) {
    std::vector<double> values;
    for (const auto& load : live)
      for (std::size_t c = 0; c < 3; ++c) values.push_back(load[c] / programme.unit(c, live_force));
    programme.add_column(values, COIN_DBL_MAX, -1);
  }
  const int status = programme.solve();
  if (status == 1 || status == 2) {
    result.status = status == 1 ? LimitStatus::Infeasible : LimitStatus::Unbounded;
    result.factor = status == 1 ? 0 : kInfinity;
    return result;
  }
  if (status != 0) return result;
  result.status = loaded ? LimitStatus::Optimal : LimitStatus::NoLoad;
  if (!loaded) return result;
  result.factor = programme.solution()[system.rows.size()] * programme.force() / live_force;
  for (std::size_t i = 0; i < system.rows.size(); ++i)
    result.forces.push_back(programme.force() * programme.solution()[i]);
  // The dual of an equation is the velocity along it; scaled so that the live load's power is 1.
  double power = 0;
  for (std::size_t k = 0; k < system.bodies.size(); ++k) {
    std::array<double, 3> v{};
    for (std::size_t c = 0; c < 3; ++c) {
      v[c] = -programme.duals()[3 * k + c] / (c == 2 ? programme.arm() : 1);
      power += v[c] * live[k][c];
    }
    result.mechanism.push_back(v);
  }
  if (power != 0) {
    for (auto& v : result.mechanism)
      for (double& component : v) component /= power;
  }
#else
  (void)sliding;
  result.status = LimitStatus::Unavailable;
#endif
  return result;
}

double missing_support(const IslandSystem& system, const BodyLoads& loads, Sliding sliding) {
  check(system, loads);
#ifdef SKERRY_WITH_CLP
  Programme programme(system, loads, sliding);
  for (int row = 0; row < programme.equations(); ++row) {
    for (const double sign : {1.0, -1.0}) {
      std::vector<double> unit(static_cast<std::size_t>(programme.equations()), 0);
      unit[static_cast<std::size_t>(row)] = sign;
      programme.add_column(unit, COIN_DBL_MAX, 1);
    }
  }
  if (programme.solve() != 0) return kInfinity;
  double sum = 0;
  for (const auto& load : loads)
    for (std::size_t c = 0; c < 3; ++c) sum += std::abs(load[c]) / programme.unit(c, programme.force());
  return sum > 0 ? programme.objective() / sum : 0;
#else
  (void)sliding;
  return kInfinity;
#endif
}

}  // namespace skerry::statics
