// SPDX-License-Identifier: MIT
#include "physics/solver/body_space_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "physics/index.h"
#include "physics/large_pages.h"
#include "physics/solver/contact_states.h"

namespace skerry {
namespace {

// 1/x, or 1 for a direction without mobility: nothing couples to it.
double mass_of(double inverse) {
  return inverse > 0 ? 1 / inverse : 1;
}

/// Where the bodies are that are nodes; empty if the system does not say.
std::vector<Vec2> places_of_nodes(const IslandSystem& system, const std::vector<int>& node_of_body) {
  std::vector<Vec2> places;
  if (system.positions.size() != node_of_body.size()) return places;
  for (std::size_t i = 0; i < node_of_body.size(); ++i)
    if (node_of_body[i] >= 0) places.push_back(system.positions[i]);
  return places;
}

}  // namespace

void BodySpaceModel::forget() {
  forgotten_ = true;
  update_.reset();
  factored_g_.clear();
  factored_h_.clear();
}

double BodySpaceModel::assign(const IslandSystem& system, SolveWork& work) {
  const std::size_t n = system.rows.size();
  bool same_rows =
      analysed_ && !forgotten_ && info_.size() == n && node_of_body_.size() == system.bodies.size();

  // Bodies that move are the nodes of the graph.
  int nodes = 0;
  std::vector<int> node_of_body(system.bodies.size(), -1);
  for (std::size_t i = 0; i < system.bodies.size(); ++i)
    if (system.bodies[i].linear > 0 || system.bodies[i].angular > 0) node_of_body[i] = nodes++;
  same_rows = same_rows && node_of_body == node_of_body_;

  // The graph: analysed only if it has an edge that the kept fill lacks.
  same_rows = same_rows && !any_of(threads_, n, kRowsAPiece, [&](std::size_t i) {
                const Row& row = system.rows[i];
                return row.a != pairs_[i][0] || row.b != pairs_[i][1] || row.normal != normal_of_row_[i];
              });
  const auto node = [&](int body) { return body < 0 ? -1 : node_of_body[at(body)]; };
  if (!same_rows) {
    bool fits = analysed_ && nodes == nodes_ && node_of_body == node_of_body_;
    std::vector<std::array<int, 2>> edges;
    for (std::size_t i = 0; i < n; ++i) {
      const int a = node(system.rows[i].a), b = node(system.rows[i].b);
      if (a < 0 || b < 0) continue;
      if (!edges.empty() && edges.back()[0] == a && edges.back()[1] == b) continue;
      edges.push_back({a, b});
      if (fits && !forgotten_) {
        const int p = pattern_.position(a), q = pattern_.position(b);
        fits = pattern_.block(std::min(p, q), std::max(p, q)) >= 0;
      }
    }
    node_of_body_ = std::move(node_of_body);
    nodes_ = nodes;
    if (forgotten_) fits = fits && edges == edges_;
    if (!fits) {
      pattern_.analyse(nodes, edges, places_of_nodes(system, node_of_body_));
      factor_.set_pattern(pattern_);
      edges_ = std::move(edges);
      analysed_ = true;
    }
    // Whoever forgets counts as if it had not been there.
    ++(fits && !forgotten_ ? work.symbolic_skipped : work.symbolic_analyses);
    forgotten_ = false;
    pairs_.resize(n);
    normal_of_row_.resize(n);
    reserve_large(info_, n);
    info_.assign(n, RowInfo{});
    inverse_mass_.assign(at(nodes_) + 1, BodyVector{});
    velocity_.assign(at(nodes_) + 1, BodyVector{});
    pushed_.assign(at(nodes_) + 1, BodyVector{});
  } else {
    ++work.symbolic_skipped;
  }
  position_of_body_.assign(system.bodies.size(), nodes_);
  for (std::size_t i = 0; i < system.bodies.size(); ++i)
    if (node_of_body_[i] >= 0) {
      const InverseMass m = system.bodies[i];
      position_of_body_[i] = pattern_.position(node_of_body_[i]);
      inverse_mass_[at(position_of_body_[i])].v = Vec4{m.linear, m.linear, m.angular, 0};
    }

  if (!same_rows) {
    for (std::size_t i = 0; i < n; ++i) {
      pairs_[i] = {system.rows[i].a, system.rows[i].b};
      normal_of_row_[i] = system.rows[i].normal;
    }
    quads_.place(system, position_of_body_, nodes_, pattern_);
  }
  compliant_ = !system.compliance.empty();
  const double change = take_rows(system);
  return same_rows ? change : kInfinity;
}

double BodySpaceModel::take_rows(const IslandSystem& system) {
  if (!shared()) {
    const RowQuads::Sizes all = quads_.take(system, 0, rows(), inverse_mass_.data(), info_.data());
    scale_ = residual_scale(all.b);
    return all.change;
  }
  Spare<std::vector<RowQuads::Sizes>> found;
  found->assign(row_pieces(), {});
  share_row_pieces([&](int first, int last, std::size_t piece) {
    (*found)[piece] = quads_.take(system, first, last, inverse_mass_.data(), info_.data());
  });
  RowQuads::Sizes all;
  for (const RowQuads::Sizes& each : *found)
    all = {std::max(all.change, each.change), std::max(all.b, each.b)};
  scale_ = residual_scale(all.b);
  return all.change;
}

void BodySpaceModel::evaluate(const double* lambda, double* w) {
  std::fill(pushed_.begin(), pushed_.end(), BodyVector{});
  push_all(lambda);
  evaluate_pushed(lambda, w);
}

// Threads from which on sums over bodies take less time than over rows, whose blocks they read twice, and far
// apart.
constexpr int kGatherers = 6;

// Row by row, or, where many threads share it, body by body: the sums are the same.
void BodySpaceModel::push_all(const double* lambda, BodyVector* v, bool sizes) {
  if (!shared() || threads_->threads() < kGatherers) return quads_.push(0, rows(), lambda, v, sizes);
  share_bodies([&](int first, int last) { quads_.gather(first, last, lambda, v, sizes); });
}

void BodySpaceModel::evaluate_pushed(const double* lambda, double* w) {
  for (int p = 0; p <= nodes_; ++p) pushed_[at(p)].v *= inverse_mass_[at(p)].v;
  share_rows([&](int first, int last) {
    quads_.velocities(first, last, pushed_.data(), w, false);
    for (int i = first; compliant_ && i < last; ++i) w[i] += info_[at(i)].compliance * lambda[i];
  });
}

double BodySpaceModel::residual(const double* lambda, const double* w) const {
  const double worst = largest_of_rows([&](int first, int last) {
    double largest = 0;
    for (int i = first; i < last; ++i) {
      const RowInfo& r = info_[at(i)];
      double lower = r.lower, upper = r.upper, violation;
      if (r.normal >= 0) {
        upper = r.mu * std::max(0.0, lambda[r.normal]);
        lower = -upper;
      }
      if (r.dead) {
        const bool explained = (w[i] >= 0 && lambda[i] <= lower) || (w[i] <= 0 && lambda[i] >= upper);
        violation = explained ? 0 : std::fabs(w[i]);
      } else {
        violation = r.D * std::fabs(lambda[i] - std::clamp(lambda[i] - w[i] / r.D, lower, upper));
      }
      // A NaN must not slip through the comparison.
      if (!(violation <= largest)) largest = violation;
    }
    return largest;
  });
  return worst / scale_;
}

void BodySpaceModel::project(double* lambda) const {
  share_rows([&](int first, int last) { project(first, last, lambda); });
}

void BodySpaceModel::project(int first, int last, double* lambda) const {
  for (int i = first; i < last; ++i) {
    const RowInfo& r = info_[at(i)];
    if (r.normal >= 0) {
      const double bound = r.mu * std::max(0.0, lambda[r.normal]);
      lambda[i] = std::clamp(lambda[i], -bound, bound);
    } else {
      lambda[i] = std::clamp(lambda[i], r.lower, r.upper);
    }
  }
}

double BodySpaceModel::rounding_floor(const double* lambda) {
  // eps |J| inv(M) |J|^T |lambda|, and a few roundings of that in a residual.
  std::fill(velocity_.begin(), velocity_.end(), BodyVector{});
  push_all(lambda, velocity_.data(), true);
  for (std::size_t p = 0; p < velocity_.size(); ++p) velocity_[p].v *= inverse_mass_[p].v;
  Spare<std::vector<double>> sizes;
  sizes->resize(info_.size());
  const double worst = largest_of_rows([&](int first, int last) {
    quads_.velocities(first, last, velocity_.data(), sizes->data(), true);
    double largest = 0;
    for (int i = first; i < last; ++i)
      largest = std::max(largest, (*sizes)[at(i)] + info_[at(i)].compliance * std::fabs(lambda[i]));
    return largest;
  });
  return std::min(4 * 2.2e-16 * worst / scale_, kHighestFloor);
}

// Costs relative to a row's share of a Gauss-Seidel sweep, from `body_space_bench` on pyramids and heaps: a
// row assembled, a block factorised, a block update (all twice without symmetry); a block in a solve.
constexpr double kAssembleCost = 1, kBlockCost = 1, kUpdateCost = 0.5, kSolveCost = 0.3;
// Updates a block of the factor from which on a local change of it pays.
constexpr std::int64_t kAdaptFrom = 5;
// Relative change of a weight that is none: a kept factor is as old.
constexpr double kSameWeight = 1e-5;

void BodySpaceModel::count_solve(SolveWork& work) const {
  ++work.resolves;
  work.visits += rows() + (update_.active() ? 1.5 : 1) * kSolveCost * (nodes_ + 2 * pattern_.blocks());
}

void BodySpaceModel::count_factor(bool general, SolveWork& work) const {
  ++work.factorisations;
  work.visits += (general ? 2 : 1) * (kAssembleCost * rows() + kBlockCost * (nodes_ + pattern_.blocks()) +
                                      kUpdateCost * static_cast<double>(pattern_.updates()));
}

bool BodySpaceModel::factor(const double* g, const double* h, SolveWork& work) {
  bool general = false;
  for (int i = 0; i < rows() && !general; ++i) general = h[i] != 0;
  count_factor(general, work);
  update_.reset();
  factored_g_.assign(g, g + rows());
  factored_h_.assign(h, h + rows());
  return factor_.factor(general, threads_, [&](int position) {
    const Vec4& inverse = inverse_mass_[at(position)].v;
    Block3& D = factor_.diagonal(position);
    for (int c = 0; c < 3; ++c) D.column[c][c] = mass_of(inverse[c]);
    quads_.fill_column(position, factored_g_.data(), factored_h_.data(), normal_of_row_.data(), general,
                       factor_);
  });
}

bool BodySpaceModel::is_adaptable() const {
  // Each solve takes half as long again afterwards: small factors are cheaper.
  return pattern_.updates() >= kAdaptFrom * (nodes_ + pattern_.blocks());
}

// Makes a row one that follows another law than the factor takes it to, if it does. False if there are too
// many.
bool BodySpaceModel::add_to_update(int i, double g, double h) {
  const double dg = g - factored_g_[at(i)], dh = h - factored_h_[at(i)];
  const double size = std::max({g, factored_g_[at(i)], std::fabs(h), std::fabs(factored_h_[at(i)])});
  if (std::fabs(dg) + std::fabs(dh) <= kSameWeight * size) return true;
  const RowQuads::Quad& quad = quads_.quad(i);
  if (quad.at_low == nodes_) return true;
  LocalUpdate::Row row;
  row.row = i;
  row.size = size;
  row.low = quad.at_low;
  row.high = quad.at_high < nodes_ ? quad.at_high : -1;
  quads_.jacobian(i, row.C_low, row.C_high);
  row.R_low.v = row.C_low.v * (dg / size);
  row.R_high.v = row.C_high.v * (dg / size);
  if (dh != 0) {
    BodyVector n_low, n_high;
    quads_.jacobian(info_[at(i)].normal, n_low, n_high);
    row.R_low.v += n_low.v * (dh / size);
    row.R_high.v += n_high.v * (dh / size);
  }
  return update_.add(row);
}

bool BodySpaceModel::adapt(const double* g, const double* h, SolveWork& work) {
  if (!is_adaptable() || factored_g_.size() != info_.size()) return false;
  update_.start();
  for (int i = 0; i < rows(); ++i)
    if (!add_to_update(i, g[i], h[i])) return false;
  const bool done = update_.finish(pattern_, factor_);
  take_weights(g, h);
  ++work.partial_factorisations;
  work.visits += rows() + kUpdateCost * update_.visited();
  return done;
}

BodySpaceModel::Surroundings::Surroundings(BodySpaceModel& model) : model_(model) {
  const std::vector<int>& nodes = model.update_.nodes();
  // Who is near is known by a mark in scratch memory that is there by position.
  model.more_.resize(model.velocity_.size());
  for (BodyVector& mark : model.more_) mark.v = Vec4{};
  for (const int p : nodes) model.more_[at(p)].v[3] = 1;
  model.more_.back().v[3] = 1;
  for (const int p : nodes)
    model.quads_.append_rows(
        p, [&](int high) { return model.more_[at(high)].v[3] == 1; }, rows_);
  std::sort(rows_.begin(), rows_.end());
  beyond_.resize(rows_.size());
}

bool BodySpaceModel::Surroundings::follow(const double* g, const double* h, const double* k) {
  LocalUpdate& update = model_.update_;
  update.start();
  for (const int i : rows_)
    if (!model_.add_to_update(i, g[i], h[i])) return false;
  if (!update.finish(model_.pattern_, model_.factor_)) return false;
  z_.clear();
  for (const LocalUpdate::Row& row : update.rows()) z_.push_back(k[row.row]);
  update.solve(nullptr, z_);
  model_.more_.back().v = Vec4{};
  update.respond(z_, model_.more_.data());
  std::fill(beyond_.begin(), beyond_.end(), 0.0);
  std::size_t place = 0;
  for (std::size_t r = 0; r < z_.size(); ++r) {
    while (rows_[place] != update.rows()[r].row) ++place;
    beyond_[place] = z_[r];
  }
  return true;
}

void BodySpaceModel::Surroundings::change(int number, double& d_lambda, double& d_w) const {
  const int row = rows_[at(number)];
  const RowQuads::Quad& quad = model_.quads_.quad(row);
  const BodyVector &low = model_.more_[at(quad.at_low)], &high = model_.more_[at(quad.at_high)];
  const auto along = [&](int i) {
    BodyVector J_low, J_high;
    model_.quads_.jacobian(i, J_low, J_high);
    return dot3(J_low, low) + dot3(J_high, high);
  };
  const RowInfo& info = model_.info_[at(row)];
  const double velocity = along(row), h = model_.factored_h_[at(row)];
  d_lambda = beyond_[at(number)] - model_.factored_g_[at(row)] * velocity;
  if (h != 0) d_lambda -= h * along(info.normal);
  d_w = velocity + info.compliance * d_lambda;
}

void BodySpaceModel::take_weights(const double* g, const double* h) {
  if (!update_.active()) return;
  law_g_.assign(g, g + rows());
  law_h_.assign(h, h + rows());
  for (const LocalUpdate::Row& row : update_.rows()) {
    law_g_[at(row.row)] = factored_g_[at(row.row)];
    law_h_[at(row.row)] = factored_h_[at(row.row)];
  }
}

void BodySpaceModel::begin_adapted(const double* k) {
  law_k_.assign(k, k + rows());
  extra_.clear();
  // A row that was stiff pulls towards zero, one that slipped follows its normal row: neither constant is
  // large where the other side of the equation is not.
  for (const LocalUpdate::Row& row : update_.rows()) {
    const std::size_t i = at(row.row);
    law_k_[i] = 0;
    if (law_h_[i] != 0) {
      const std::size_t n = at(info_[i].normal);
      law_k_[i] = law_h_[i] / factored_g_[n] * law_k_[n];
    }
    extra_.push_back(k[i] - law_k_[i]);
  }
  push_all(law_k_.data(), velocity_.data());
  factor_.forward(velocity_.data(), threads_);
  // Velocities of the changed rows' bodies, from the paths to the root alone.
  const std::vector<int>& paths = update_.columns();
  more_.resize(velocity_.size());
  for (const int j : paths) more_[at(j)] = velocity_[at(j)];
  factor_.backward(more_.data(), paths);
  update_.solve(more_.data(), extra_);
  // Their impulses on top, halfway.
  for (const int j : paths) more_[at(j)] = BodyVector{};
  for (std::size_t r = 0; r < extra_.size(); ++r) {
    const LocalUpdate::Row& row = update_.rows()[r];
    more_[at(row.low)].v += row.C_low.v * extra_[r];
    if (row.high >= 0) more_[at(row.high)].v += row.C_high.v * extra_[r];
  }
  factor_.forward(more_.data(), paths);
  for (const int j : paths) velocity_[at(j)].v += more_[at(j)].v;
  factor_.backward(velocity_.data(), threads_);
  for (std::size_t r = 0; r < extra_.size(); ++r) law_k_[at(update_.rows()[r].row)] += extra_[r];
}

void BodySpaceModel::begin_solve(const double* k, SolveWork& work) {
  count_solve(work);
  std::fill(velocity_.begin(), velocity_.end(), BodyVector{});
  if (update_.active()) {
    begin_adapted(k);
  } else {
    push_all(k, velocity_.data());
    factor_.solve(velocity_.data(), threads_);
  }
  velocity_.back() = BodyVector{};
}

void BodySpaceModel::finish_solve(int first, int last, const double* k, const double* g, const double* h,
                                  double* d_lambda) {
  if (update_.active()) {
    k = law_k_.data();
    g = law_g_.data();
    h = law_h_.data();
  }
  quads_.recover(first, last, velocity_.data(), k, g, h, normal_of_row_.data(), d_lambda);
}

void BodySpaceModel::solve(const double* k, const double* g, const double* h, double* d_lambda,
                           SolveWork& work) {
  begin_solve(k, work);
  share_rows([&](int first, int last) { finish_solve(first, last, k, g, h, d_lambda); });
}

void BodySpaceModel::row_velocities(const BodyVector* v, double* u) const {
  quads_.velocities(0, rows(), v, u, false);
}

double BodySpaceModel::imbalance(const BodyVector* v, const double* lambda, BodyVector* force) const {
  std::fill(force, force + nodes_ + 1, BodyVector{});
  quads_.push(0, rows(), lambda, force, false);
  double sum = 0;
  for (int p = 0; p < nodes_; ++p) {
    const Vec4& inverse = inverse_mass_[at(p)].v;
    Vec4& f = force[p].v;
    f -= Vec4{mass_of(inverse[0]), mass_of(inverse[1]), mass_of(inverse[2]), 0} * v[p].v;
    const Vec4 t = f * f * inverse;
    sum += t[0] + t[1] + t[2];
  }
  force[nodes_].v = Vec4{};
  return sum;
}

void BodySpaceModel::solve_bodies(BodyVector* x, SolveWork& work) const {
  count_solve(work);
  factor_.solve(x, threads_);
}

}  // namespace skerry
