// SPDX-License-Identifier: MIT
#include "physics/solver/body_space_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "physics/solver/contact_states.h"

namespace skerry {
namespace {

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// B += x (s y)^T
SKERRY_ALWAYS_INLINE void add_outer(Block3& B, const Vec4& x, const Vec4& y) {
  B.column[0] += x * y[0];
  B.column[1] += x * y[1];
  B.column[2] += x * y[2];
}

// Magnitudes, number by number.
SKERRY_ALWAYS_INLINE void take_sizes(Vec4& x) {
  x = x < 0 ? -x : x;
}

}  // namespace

/// The loops, compiled for two instruction sets.
struct BodySpaceModel::Kernels {
  // Numbers of some rows; compares them with those that were there before. Directions in which a body cannot
  // move are left out of its block.
  struct TakeRows {
    static SKERRY_ALWAYS_INLINE RowSizes run(BodySpaceModel& m, const IslandSystem& system, std::size_t first,
                                             std::size_t last, bool compare) {
      double change = 0, scale = 0;
      Vec4 moved{};
      for (std::size_t i = first; i < last; ++i) {
        const Row& row = system.rows[i];
        const Place& place = m.place_[i];
        const auto& low = place.a_is_low ? row.Ja : row.Jb;
        const auto& high = place.a_is_low ? row.Jb : row.Ja;
        const Vec4& low_mass = m.inverse_mass_[at(place.low)].v;
        const Vec4& high_mass = m.inverse_mass_[at(place.high)].v;
        Jacobian J;
        J.low = low_mass > 0 ? Vec4{low[0], low[1], low[2], 0} : Vec4{};
        J.high = high_mass > 0 ? Vec4{high[0], high[1], high[2], 0} : Vec4{};
        const Vec4 d = J.low * J.low * low_mass + J.high * J.high * high_mass;
        const double compliance = system.compliance.empty() ? 0 : system.compliance[i];
        const double D = d[0] + d[1] + d[2] + compliance, b = system.b[i];
        RowInfo& info = m.info_[i];
        if (compare) {
          Vec4 low_size = J.low - m.jacobian_[i].low, high_size = J.high - m.jacobian_[i].high;
          take_sizes(low_size);
          moved = low_size > moved ? low_size : moved;
          take_sizes(high_size);
          moved = high_size > moved ? high_size : moved;
          const double of_D = std::fabs(D - info.D) + std::fabs(compliance - info.compliance);
          change = std::max(change, D > 0 ? of_D / D : of_D);
        }
        m.jacobian_[i] = J;
        info = {row.normal, !(D > 0), row.normal >= 0 ? row.mu : 0, row.lower, row.upper, D, compliance, b};
        scale = std::max(scale, std::fabs(b));
      }
      return {std::max({change, moved[0], moved[1], moved[2]}), scale};
    }
  };

  // v += J^T lambda, or |J|^T |lambda|.
  template <bool kSizes>
  struct Push {
    static SKERRY_ALWAYS_INLINE void run(const BodySpaceModel& m, int first, int last, const double* lambda,
                                         BodyVector* v) {
      for (int i = first; i < last; ++i) {
        const double z = kSizes ? std::fabs(lambda[i]) : lambda[i];
        if (z == 0) continue;
        Jacobian J = m.jacobian_[at(i)];
        if (kSizes) {
          take_sizes(J.low);
          take_sizes(J.high);
        }
        const Place& place = m.place_[at(i)];
        v[place.low].v += J.low * z;
        v[place.high].v += J.high * z;
      }
    }
  };

  // The same body by body, for the positions from `first` on and before `last`.
  template <bool kSizes>
  struct Gather {
    static SKERRY_ALWAYS_INLINE void run(const BodySpaceModel& m, int first, int last, const double* lambda,
                                         BodyVector* v) {
      const Incident* e = m.incident_.data() + m.incident_begin_[at(first)];
      for (int p = first; p < last; ++p) {
        const Incident* const end = m.incident_.data() + m.incident_begin_[at(p) + 1];
        Vec4 sum = v[p].v;
        for (; e < end; ++e) {
          const double z = kSizes ? std::fabs(lambda[e->row]) : lambda[e->row];
          if (z == 0) continue;
          const Jacobian& J = m.jacobian_[at(e->row)];
          Vec4 own = e->is_high ? J.high : J.low;
          if (kSizes) take_sizes(own);
          sum += own * z;
        }
        v[p].v = sum;
      }
    }
  };

  struct DivideByMass {
    static SKERRY_ALWAYS_INLINE void run(BodySpaceModel& m) {
      for (int p = 0; p <= m.nodes_; ++p) m.pushed_[at(p)].v *= m.inverse_mass_[at(p)].v;
    }
  };

  struct Evaluate {
    static SKERRY_ALWAYS_INLINE void run(const BodySpaceModel& m, int first, int last, const double* lambda,
                                         double* w) {
      const BodyVector* v = m.pushed_.data();
      for (int i = first; i < last; ++i) {
        const Jacobian& J = m.jacobian_[at(i)];
        const Place& place = m.place_[at(i)];
        const Vec4 t = J.low * v[place.low].v + J.high * v[place.high].v;
        const RowInfo& info = m.info_[at(i)];
        w[i] = (t[0] + t[1] + t[2]) + info.compliance * lambda[i] - info.b;
      }
    }
  };

  // What the rows of the body at `position` add to its column. Those between the same two bodies come one
  // after the other, so their block is fetched and put back once.
  template <bool kGeneral>
  struct FillColumn {
    static SKERRY_ALWAYS_INLINE void run(const BodySpaceModel& m, BlockFactor& f, int position) {
      const double *const g = m.factored_g_.data(), *const h = m.factored_h_.data();
      // A direction without mobility gets a unit mass: nothing couples to it.
      const Vec4& inverse = m.inverse_mass_[at(position)].v;
      const double linear = inverse[0] > 0 ? 1 / inverse[0] : 1,
                   angular = inverse[2] > 0 ? 1 / inverse[2] : 1;
      Block3 D{{Vec4{linear, 0, 0, 0}, Vec4{0, linear, 0, 0}, Vec4{0, 0, angular, 0}}};
      const Incident *e = m.incident_.data() + m.incident_begin_[at(position)],
                     *const end = m.incident_.data() + m.incident_begin_[at(position) + 1];
      while (e < end) {
        const int block = e->is_high ? -1 : m.place_[at(e->row)].block;
        if (block < 0) {
          const int i = e->row;
          const auto own = [&](int row) -> const Vec4& {
            return e->is_high ? m.jacobian_[at(row)].high : m.jacobian_[at(row)].low;
          };
          if (g[i] != 0) add_outer(D, own(i) * g[i], own(i));
          if (kGeneral && h[i] != 0) add_outer(D, own(i) * h[i], own(m.info_[at(i)].normal));
          ++e;
          continue;
        }
        Block3 L = f.lower(block), U;
        if (kGeneral) U = f.upper(block);
        for (; e < end && !e->is_high && m.place_[at(e->row)].block == block; ++e) {
          const int i = e->row;
          const Jacobian& J = m.jacobian_[at(i)];
          if (g[i] != 0) {
            const Vec4 low = J.low * g[i], high = J.high * g[i];
            add_outer(D, low, J.low);
            add_outer(L, high, J.low);
            if (kGeneral) add_outer(U, J.high, low);
          }
          if (kGeneral && h[i] != 0) {
            const Jacobian& N = m.jacobian_[at(m.info_[at(i)].normal)];
            const Vec4 low = J.low * h[i], high = J.high * h[i];
            add_outer(D, low, N.low);
            add_outer(L, high, N.low);
            add_outer(U, N.high, low);
          }
        }
        f.lower(block) = L;
        if (kGeneral) f.upper(block) = U;
      }
      f.diagonal(position) = D;
    }
  };

  // d_lambda = k - g J dv - h J_n dv
  struct Recover {
    static SKERRY_ALWAYS_INLINE void run(const BodySpaceModel& m, int first, int last, const double* k,
                                         const double* g, const double* h, double* d_lambda) {
      const BodyVector* v = m.velocity_.data();
      for (int i = first; i < last; ++i) {
        double d = k[i];
        const Place& place = m.place_[at(i)];
        if (g[i] != 0) {
          const Jacobian& J = m.jacobian_[at(i)];
          const Vec4 t = J.low * v[place.low].v + J.high * v[place.high].v;
          d -= g[i] * (t[0] + t[1] + t[2]);
        }
        if (h[i] != 0) {
          const Jacobian& N = m.jacobian_[at(m.info_[at(i)].normal)];
          const Vec4 t = N.low * v[place.low].v + N.high * v[place.high].v;
          d -= h[i] * (t[0] + t[1] + t[2]);
        }
        d_lambda[i] = d;
      }
    }
  };

  // u = J v - b
  struct RowVelocities {
    static SKERRY_ALWAYS_INLINE void run(const BodySpaceModel& m, const BodyVector* v, double* u) {
      const int n = m.rows();
      for (int i = 0; i < n; ++i) {
        const Jacobian& J = m.jacobian_[at(i)];
        const Place& place = m.place_[at(i)];
        const Vec4 t = J.low * v[place.low].v + J.high * v[place.high].v;
        u[i] = (t[0] + t[1] + t[2]) - m.info_[at(i)].b;
      }
    }
  };

  // force = J^T lambda - M v
  struct Imbalance {
    static SKERRY_ALWAYS_INLINE double run(const BodySpaceModel& m, const BodyVector* v, const double* lambda,
                                           BodyVector* force) {
      for (int p = 0; p <= m.nodes_; ++p) force[p].v = Vec4{};
      const int n = m.rows();
      for (int i = 0; i < n; ++i) {
        const double z = lambda[i];
        if (z == 0) continue;
        const Jacobian& J = m.jacobian_[at(i)];
        const Place& place = m.place_[at(i)];
        force[place.low].v += J.low * z;
        force[place.high].v += J.high * z;
      }
      double sum = 0;
      for (int p = 0; p < m.nodes_; ++p) {
        const Vec4& inverse = m.inverse_mass_[at(p)].v;
        const double linear = inverse[0] > 0 ? 1 / inverse[0] : 1,
                     angular = inverse[2] > 0 ? 1 / inverse[2] : 1;
        Vec4& f = force[p].v;
        f -= Vec4{linear, linear, angular, 0} * v[p].v;
        const Vec4 t = f * f * inverse;
        sum += t[0] + t[1] + t[2];
      }
      force[m.nodes_].v = Vec4{};
      return sum;
    }
  };
};

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
  for (std::size_t i = 0; same_rows && i < n; ++i) {
    const Row& row = system.rows[i];
    same_rows = row.a == pairs_[i][0] && row.b == pairs_[i][1] && row.normal == normal_of_row_[i];
  }
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
      pattern_.analyse(nodes, edges);
      factor_.set_pattern(pattern_);
      edges_ = std::move(edges);
      analysed_ = true;
    }
    // Whoever forgets counts as if it had not been there.
    ++(fits && !forgotten_ ? work.symbolic_skipped : work.symbolic_analyses);
    forgotten_ = false;
    pairs_.resize(n);
    normal_of_row_.resize(n);
    jacobian_.assign(n, Jacobian{});
    place_.resize(n);
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

  if (!same_rows) place_rows(system);
  const double change = take_rows(system, same_rows);
  return same_rows ? change : kInfinity;
}

double BodySpaceModel::take_rows(const IslandSystem& system, bool compare) {
  Spare<std::vector<RowSizes>> found;
  found->assign(info_.size() / kRowsAPiece + 1, {});
  share(threads_, info_.size(), kRowsAPiece, [&](std::size_t first, std::size_t last) {
    (*found)[first / kRowsAPiece] = run_kernel<Kernels::TakeRows>(*this, system, first, last, compare);
  });
  RowSizes all;
  for (const RowSizes& each : *found) all = {std::max(all.change, each.change), std::max(all.b, each.b)};
  scale_ = residual_scale(all.b);
  return all.change;
}

void BodySpaceModel::place_rows(const IslandSystem& system) {
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    pairs_[i] = {row.a, row.b};
    normal_of_row_[i] = row.normal;
    const int a = row.a < 0 ? nodes_ : position_of_body_[at(row.a)],
              b = row.b < 0 ? nodes_ : position_of_body_[at(row.b)];
    Place& place = place_[i];
    place.low = std::min(a, b);
    place.high = std::max(a, b);
    place.a_is_low = a == place.low;
    if (i > 0 && place.low == place_[i - 1].low && place.high == place_[i - 1].high)
      place.block = place_[i - 1].block;
    else
      place.block = place.high < nodes_ ? pattern_.block(place.low, place.high) : -1;
  }
  find_incident();
}

void BodySpaceModel::find_incident() {
  // First where they end.
  incident_begin_.assign(at(nodes_) + 2, 0);
  for (const Place& place : place_) {
    ++incident_begin_[at(place.low)];
    ++incident_begin_[at(place.high)];
  }
  std::partial_sum(incident_begin_.begin(), incident_begin_.end(), incident_begin_.begin());
  incident_.resize(2 * place_.size());
  for (int i = rows(); i-- > 0;) {
    incident_[at(--incident_begin_[at(place_[at(i)].high)])] = {i, true};
    incident_[at(--incident_begin_[at(place_[at(i)].low)])] = {i, false};
  }
}

void BodySpaceModel::evaluate(const double* lambda, double* w) {
  std::fill(pushed_.begin(), pushed_.end(), BodyVector{});
  push_all(lambda);
  evaluate_pushed(lambda, w);
}

template <bool kSizes>
void BodySpaceModel::push(int first, int last, const double* lambda, BodyVector* v) {
  run_kernel<Kernels::Push<kSizes>>(*this, first, last, lambda, v);
}

void BodySpaceModel::push(int first, int last, const double* lambda) {
  push<false>(first, last, lambda, pushed_.data());
}

// Row by row, or, where threads share it, body by body: the sums are the same.
template <bool kSizes>
void BodySpaceModel::push_all(const double* lambda, BodyVector* v) {
  if (!shared()) return push<kSizes>(0, rows(), lambda, v);
  share_bodies(
      [&](int first, int last) { run_kernel<Kernels::Gather<kSizes>>(*this, first, last, lambda, v); });
}

void BodySpaceModel::push_all(const double* lambda) {
  push_all<false>(lambda, pushed_.data());
}

void BodySpaceModel::evaluate_pushed(const double* lambda, double* w) {
  run_kernel<Kernels::DivideByMass>(*this);
  share_rows([&](int first, int last) { run_kernel<Kernels::Evaluate>(*this, first, last, lambda, w); });
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
  share_rows([&](int first, int last) {
    for (int i = first; i < last; ++i) {
      const RowInfo& r = info_[at(i)];
      if (r.normal >= 0) {
        const double bound = r.mu * std::max(0.0, lambda[r.normal]);
        lambda[i] = std::clamp(lambda[i], -bound, bound);
      } else {
        lambda[i] = std::clamp(lambda[i], r.lower, r.upper);
      }
    }
  });
}

double BodySpaceModel::rounding_floor(const double* lambda) {
  // eps |J| inv(M) |J|^T |lambda|, and a few roundings of that in a residual.
  std::fill(velocity_.begin(), velocity_.end(), BodyVector{});
  push_all<true>(lambda, velocity_.data());
  for (std::size_t p = 0; p < velocity_.size(); ++p) velocity_[p].v *= inverse_mass_[p].v;
  const double worst = largest_of_rows([&](int first, int last) {
    double largest = 0;
    for (int i = first; i < last; ++i) {
      double t = info_[at(i)].compliance * std::fabs(lambda[i]);
      for (int k = 0; k < 3; ++k)
        t += std::fabs(jacobian_[at(i)].low[k]) * velocity_[at(place_[at(i)].low)].v[k] +
             std::fabs(jacobian_[at(i)].high[k]) * velocity_[at(place_[at(i)].high)].v[k];
      largest = std::max(largest, t);
    }
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
  if (general)
    return factor_.factor(true, threads_, [&](int position) {
      run_kernel<Kernels::FillColumn<true>>(*this, factor_, position);
    });
  return factor_.factor(false, threads_, [&](int position) {
    run_kernel<Kernels::FillColumn<false>>(*this, factor_, position);
  });
}

bool BodySpaceModel::is_adaptable() const {
  // Each solve takes half as long again afterwards: small factors are cheaper.
  return pattern_.updates() >= kAdaptFrom * (nodes_ + pattern_.blocks());
}

// Makes a row one that follows another law than the factor takes it to, if it does. False if there are too many.
bool BodySpaceModel::add_to_update(int i, double g, double h) {
  const double dg = g - factored_g_[at(i)], dh = h - factored_h_[at(i)];
  const double size = std::max({g, factored_g_[at(i)], std::fabs(h), std::fabs(factored_h_[at(i)])});
  if (std::fabs(dg) + std::fabs(dh) <= kSameWeight * size) return true;
  const Place& place = place_[at(i)];
  if (place.low == nodes_) return true;
  const Jacobian& J = jacobian_[at(i)];
  LocalUpdate::Row row;
  row.row = i;
  row.size = size;
  row.low = place.low;
  row.high = place.high < nodes_ ? place.high : -1;
  row.C_low.v = J.low;
  row.C_high.v = J.high;
  row.R_low.v = J.low * (dg / size);
  row.R_high.v = J.high * (dg / size);
  if (dh != 0) {
    const Jacobian& N = jacobian_[at(info_[at(i)].normal)];
    row.R_low.v += N.low * (dh / size);
    row.R_high.v += N.high * (dh / size);
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
    for (int e = model.incident_begin_[at(p)]; e < model.incident_begin_[at(p) + 1]; ++e) {
      const Incident& incident = model.incident_[at(e)];
      if (!incident.is_high && model.more_[at(model.place_[at(incident.row)].high)].v[3] == 1)
        rows_.push_back(incident.row);
    }
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
  const Place& place = model_.place_[at(row)];
  const BodyVector &low = model_.more_[at(place.low)], &high = model_.more_[at(place.high)];
  const auto along = [&](int i) {
    const Jacobian& J = model_.jacobian_[at(i)];
    return dot3({J.low}, low) + dot3({J.high}, high);
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
  push_all<false>(law_k_.data(), velocity_.data());
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
    push_all<false>(k, velocity_.data());
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
  run_kernel<Kernels::Recover>(*this, first, last, k, g, h, d_lambda);
}

void BodySpaceModel::solve(const double* k, const double* g, const double* h, double* d_lambda,
                           SolveWork& work) {
  begin_solve(k, work);
  share_rows([&](int first, int last) { finish_solve(first, last, k, g, h, d_lambda); });
}

void BodySpaceModel::row_velocities(const BodyVector* v, double* u) const {
  run_kernel<Kernels::RowVelocities>(*this, v, u);
}

double BodySpaceModel::imbalance(const BodyVector* v, const double* lambda, BodyVector* force) const {
  return run_kernel<Kernels::Imbalance>(*this, v, lambda, force);
}

void BodySpaceModel::solve_bodies(BodyVector* x, SolveWork& work) const {
  count_solve(work);
  factor_.solve(x, threads_);
}

}  // namespace skerry
