// SPDX-License-Identifier: MIT
#include "physics/solver/row_quads.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "physics/index.h"
#include "physics/large_pages.h"

namespace skerry {
namespace {

using Quad = RowQuads::Quad;

// Four numbers from `p` on; `all` says that so many may be read.
SKERRY_ALWAYS_INLINE void read(const double* p, int count, bool all, Vec4& x) {
  if (all) {
    std::memcpy(&x, p, sizeof x);
    return;
  }
  x = Vec4{};
  for (int i = 0; i < count; ++i) x[i] = p[i];
}

SKERRY_ALWAYS_INLINE void write(double* p, int count, const Vec4& x) {
  if (count == 4) {
    std::memcpy(p, &x, sizeof x);
    return;
  }
  for (int i = 0; i < count; ++i) p[i] = x[i];
}

SKERRY_ALWAYS_INLINE void take_sizes(Vec4& x) {
  x = x < 0 ? -x : x;
}

// Sums of the lanes of three vectors, one a component of a body.
SKERRY_ALWAYS_INLINE void sums(const Vec4& p, const Vec4& q, const Vec4& r, Vec4& out) {
  const Vec4 zero{};
  const Vec4 pq = __builtin_shufflevector(p, q, 0, 4, 2, 6) + __builtin_shufflevector(p, q, 1, 5, 3, 7);
  const Vec4 r0 = __builtin_shufflevector(r, zero, 0, 4, 2, 6) + __builtin_shufflevector(r, zero, 1, 5, 3, 7);
  out = __builtin_shufflevector(pq, r0, 0, 1, 4, 5) + __builtin_shufflevector(pq, r0, 2, 3, 6, 7);
}

// J v, row by row.
SKERRY_ALWAYS_INLINE void along(const Quad& q, const BodyVector* v, Vec4& u) {
  const Vec4 &low = v[q.at_low].v, &high = v[q.at_high].v;
  u = ((q.low[0] * low[0] + q.low[1] * low[1]) + q.low[2] * low[2]) +
      ((q.high[0] * high[0] + q.high[1] * high[1]) + q.high[2] * high[2]);
}

// B += x y^T
SKERRY_ALWAYS_INLINE void add_outer(Block3& B, const Vec4& x, const Vec4& y) {
  B.column[0] += x * y[0];
  B.column[1] += x * y[1];
  B.column[2] += x * y[2];
}

// One side of four rows, row by row, each with its weight.
SKERRY_ALWAYS_INLINE void turn(const Vec4 (&side)[3], const Vec4& weight, Vec4 (&rows)[4]) {
  rows[0] = side[0] * weight;
  rows[1] = side[1] * weight;
  rows[2] = side[2] * weight;
  rows[3] = Vec4{};
  transpose(rows[0], rows[1], rows[2], rows[3]);
}

}  // namespace

/// The loops, compiled for two instruction sets.
struct RowQuads::Kernels {
  struct Take {
    static SKERRY_ALWAYS_INLINE Sizes run(std::span<Quad> quads, const IslandSystem& system,
                                          const BodyVector* mass, Info* info) {
      Vec4 moved{};
      Sizes largest;
      for (Quad& q : quads) {
        const Vec4 &low_mass = mass[q.at_low].v, &high_mass = mass[q.at_high].v;
        Vec4 low[4], high[4];
        for (int i = 0; i < 4; ++i) {
          low[i] = high[i] = Vec4{};
          if (i >= q.count) continue;
          const Row& row = system.rows[at(q.first + i)];
          const auto &l = q.a_is_low ? row.Ja : row.Jb, &h = q.a_is_low ? row.Jb : row.Ja;
          low[i] = low_mass > 0 ? Vec4{l[0], l[1], l[2], 0} : Vec4{};
          high[i] = high_mass > 0 ? Vec4{h[0], h[1], h[2], 0} : Vec4{};
          q.b[i] = system.b[at(q.first + i)];
        }
        Vec4 d[4];
        for (int i = 0; i < 4; ++i) d[i] = low[i] * low[i] * low_mass + high[i] * high[i] * high_mass;
        for (int i = 0; i < q.count; ++i) {
          const std::size_t n = at(q.first + i);
          const Row& row = system.rows[n];
          const double compliance = system.compliance.empty() ? 0 : system.compliance[n], b = system.b[n];
          const double D = d[i][0] + d[i][1] + d[i][2] + compliance;
          const double of_D = std::fabs(D - info[n].D) + std::fabs(compliance - info[n].compliance);
          largest.change = std::max(largest.change, D > 0 ? of_D / D : of_D);
          largest.b = std::max(largest.b, std::fabs(b));
          info[n] = {row.normal, !(D > 0), row.normal >= 0 ? row.mu : 0, row.lower, row.upper, D,
                     compliance, b};
        }
        transpose(low[0], low[1], low[2], low[3]);
        transpose(high[0], high[1], high[2], high[3]);
        for (int c = 0; c < 3; ++c) {
          Vec4 size = low[c] - q.low[c];
          take_sizes(size);
          moved = size > moved ? size : moved;
          size = high[c] - q.high[c];
          take_sizes(size);
          moved = size > moved ? size : moved;
          q.low[c] = low[c];
          q.high[c] = high[c];
        }
      }
      largest.change = std::max({largest.change, moved[0], moved[1], moved[2], moved[3]});
      return largest;
    }
  };

  template <bool kSizes>
  struct Push {
    static SKERRY_ALWAYS_INLINE void run(std::span<const Quad> quads, int rows, const double* lambda,
                                         BodyVector* v) {
      for (const Quad& q : quads) {
        Vec4 z, low, high;
        read(lambda + q.first, q.count, q.first + 4 <= rows, z);
        impulses<kSizes>(q, z, low, high);
        v[q.at_low].v += low;
        v[q.at_high].v += high;
      }
    }
  };

  // What four impulses give the two bodies.
  template <bool kSizes>
  static SKERRY_ALWAYS_INLINE void impulses(const Quad& q, const Vec4& z, Vec4& low, Vec4& high) {
    Vec4 l[3] = {q.low[0] * z, q.low[1] * z, q.low[2] * z};
    Vec4 h[3] = {q.high[0] * z, q.high[1] * z, q.high[2] * z};
    for (int c = 0; kSizes && c < 3; ++c) {
      take_sizes(l[c]);
      take_sizes(h[c]);
    }
    sums(l[0], l[1], l[2], low);
    sums(h[0], h[1], h[2], high);
  }

  template <bool kSizes>
  struct Gather {
    static SKERRY_ALWAYS_INLINE void run(const RowQuads& m, int first, int last, const double* lambda,
                                         BodyVector* v) {
      for (int p = first; p < last; ++p) {
        Vec4 sum = v[p].v;
        for (const Incident& incident : m.incident_at(p)) {
          const Quad& q = m.quads_[at(incident.quad)];
          Vec4 z, low, high;
          read(lambda + q.first, q.count, q.first + 4 <= m.rows(), z);
          impulses<kSizes>(q, z, low, high);
          sum += incident.is_high ? high : low;
        }
        v[p].v = sum;
      }
    }
  };

  template <bool kSizes>
  struct Velocities {
    static SKERRY_ALWAYS_INLINE void run(std::span<const Quad> quads, const BodyVector* v, double* u) {
      for (const Quad& q : quads) {
        Vec4 x;
        if (kSizes) {
          Quad sizes = q;
          for (int c = 0; c < 3; ++c) {
            take_sizes(sizes.low[c]);
            take_sizes(sizes.high[c]);
          }
          along(sizes, v, x);
        } else {
          along(q, v, x);
          x -= q.b;
        }
        write(u + q.first, q.count, x);
      }
    }
  };

  struct Recover {
    static SKERRY_ALWAYS_INLINE void run(const RowQuads& m, std::span<const Quad> quads, const BodyVector* v,
                                         const double* k, const double* g, const double* h, const int* normal,
                                         double* d) {
      for (const Quad& q : quads) {
        const bool all = q.first + 4 <= m.rows();
        Vec4 u, wanted, weight, coupling;
        along(q, v, u);
        read(k + q.first, q.count, all, wanted);
        read(g + q.first, q.count, all, weight);
        read(h + q.first, q.count, all, coupling);
        wanted -= weight * u;
        for (int i = 0; i < q.count; ++i) {
          if (coupling[i] == 0) continue;
          const int n = normal[q.first + i], lane = n - q.first;
          Vec4 of_normal = u;
          if (lane < 0) along(m.quad(n), v, of_normal);
          wanted[i] -= coupling[i] * of_normal[lane < 0 ? n - m.quad(n).first : lane];
        }
        write(d + q.first, q.count, wanted);
      }
    }
  };

  template <bool kGeneral>
  struct FillColumn {
    static SKERRY_ALWAYS_INLINE void run(const RowQuads& m, int position, const double* g, const double* h,
                                         const int* normal, BlockFactor& f) {
      Block3 D = f.diagonal(position);
      for (const Incident& incident : m.incident_at(position)) {
        const Quad& q = m.quads_[at(incident.quad)];
        const Vec4(&own)[3] = incident.is_high ? q.high : q.low;
        Vec4 weight, rows[4];
        read(g + q.first, q.count, q.count == 4, weight);
        turn(own, weight, rows);
        for (int i = 0; i < 4; ++i)
          for (int c = 0; c < 3; ++c) D.column[c] += rows[i] * own[c][i];
        if (!incident.is_high && q.block >= 0) {
          // Where nothing is coupled the mirror is the same.
          turn(q.high, weight, rows);
          Block3 L = f.lower(q.block), U;
          if (kGeneral) U = f.upper(q.block);
          for (int i = 0; i < 4; ++i)
            for (int c = 0; c < 3; ++c) {
              const Vec4 both = rows[i] * own[c][i];
              L.column[c] += both;
              if (kGeneral) U.column[c] += both;
            }
          f.lower(q.block) = L;
          if (kGeneral) f.upper(q.block) = U;
        }
        for (int i = 0; kGeneral && i < q.count; ++i)
          if (h[q.first + i] != 0) couple(m, q, incident.is_high, q.first + i, normal[q.first + i], h, D, f);
      }
      f.diagonal(position) = D;
    }

    static SKERRY_ALWAYS_INLINE void couple(const RowQuads& m, const Quad& q, bool is_high, int row,
                                            int normal, const double* h, Block3& D, BlockFactor& f) {
      BodyVector low, high, n_low, n_high;
      m.jacobian(row, low, high);
      m.jacobian(normal, n_low, n_high);
      low.v *= h[row];
      high.v *= h[row];
      if (is_high) return add_outer(D, high.v, n_high.v);
      add_outer(D, low.v, n_low.v);
      if (q.block < 0) return;
      add_outer(f.lower(q.block), high.v, n_low.v);
      add_outer(f.upper(q.block), n_high.v, low.v);
    }
  };
};

void RowQuads::place(const IslandSystem& system, std::span<const int> position, int ground,
                     const BlockPattern& pattern) {
  ground_ = ground;
  const int n = system.size();
  quad_of_row_.resize(at(n));
  // Rows of the contact that begins at `row`.
  const auto length = [&](int row) {
    int end = row + 1;
    while (end < n && system.rows[at(end)].normal == row) ++end;
    return end - row;
  };
  int quads = 0, count = 0;
  for (int i = 0; i < n; ++i) {
    const Row& row = system.rows[at(i)];
    const bool same = i > 0 && row.a == system.rows[at(i - 1)].a && row.b == system.rows[at(i - 1)].b;
    const int fits = row.normal < 0 ? std::min(length(i), 4) : 1;
    if (!same || count + fits > 4) {
      ++quads;
      count = 0;
    }
    ++count;
    quad_of_row_[at(i)] = quads - 1;
  }
  reserve_large(quads_, at(quads));
  quads_.assign(at(quads), Quad{});
  for (int i = n; i-- > 0;) {
    Quad& q = quads_[at(quad_of_row_[at(i)])];
    q.first = i;
    ++q.count;
  }
  for (std::size_t k = 0; k < quads_.size(); ++k) {
    Quad& q = quads_[k];
    const Row& row = system.rows[at(q.first)];
    const int a = row.a < 0 ? ground : position[at(row.a)], b = row.b < 0 ? ground : position[at(row.b)];
    q.at_low = std::min(a, b);
    q.at_high = std::max(a, b);
    q.a_is_low = a == q.at_low;
    if (k > 0 && quads_[k - 1].at_low == q.at_low && quads_[k - 1].at_high == q.at_high)
      q.block = quads_[k - 1].block;
    else
      q.block = q.at_high < ground ? pattern.block(q.at_low, q.at_high) : -1;
  }
  find_incident();
}

void RowQuads::find_incident() {
  // First where they end.
  incident_begin_.assign(at(ground_) + 2, 0);
  for (const Quad& q : quads_) {
    ++incident_begin_[at(q.at_low)];
    ++incident_begin_[at(q.at_high)];
  }
  std::partial_sum(incident_begin_.begin(), incident_begin_.end(), incident_begin_.begin());
  incident_.resize(2 * quads_.size());
  for (int k = static_cast<int>(quads_.size()); k-- > 0;) {
    incident_[at(--incident_begin_[at(quads_[at(k)].at_high)])] = {k, true};
    incident_[at(--incident_begin_[at(quads_[at(k)].at_low)])] = {k, false};
  }
}

RowQuads::Sizes RowQuads::take(const IslandSystem& system, int first, int last, const BodyVector* mass,
                               Info* info) {
  if (first >= last) return {};
  const auto from = quads_.begin() + quad_of_row_[at(first)],
             to = quads_.begin() + quad_of_row_[at(last - 1)] + 1;
  return run_kernel<Kernels::Take>(std::span<Quad>(from, to), system, mass, info);
}

void RowQuads::jacobian(int row, BodyVector& low, BodyVector& high) const {
  const Quad& q = quad(row);
  const int i = row - q.first;
  low.v = Vec4{q.low[0][i], q.low[1][i], q.low[2][i], 0};
  high.v = Vec4{q.high[0][i], q.high[1][i], q.high[2][i], 0};
}

void RowQuads::push(int first, int last, const double* lambda, BodyVector* v, bool sizes) const {
  if (sizes)
    run_kernel<Kernels::Push<true>>(quads(first, last), rows(), lambda, v);
  else
    run_kernel<Kernels::Push<false>>(quads(first, last), rows(), lambda, v);
}

void RowQuads::gather(int first_position, int last_position, const double* lambda, BodyVector* v,
                      bool sizes) const {
  if (sizes)
    run_kernel<Kernels::Gather<true>>(*this, first_position, last_position, lambda, v);
  else
    run_kernel<Kernels::Gather<false>>(*this, first_position, last_position, lambda, v);
}

void RowQuads::velocities(int first, int last, const BodyVector* v, double* u, bool sizes) const {
  if (sizes)
    run_kernel<Kernels::Velocities<true>>(quads(first, last), v, u);
  else
    run_kernel<Kernels::Velocities<false>>(quads(first, last), v, u);
}

void RowQuads::recover(int first, int last, const BodyVector* v, const double* k, const double* g,
                       const double* h, const int* normal, double* d) const {
  run_kernel<Kernels::Recover>(*this, quads(first, last), v, k, g, h, normal, d);
}

void RowQuads::fill_column(int position, const double* g, const double* h, const int* normal, bool general,
                           BlockFactor& factor) const {
  if (general)
    run_kernel<Kernels::FillColumn<true>>(*this, position, g, h, normal, factor);
  else
    run_kernel<Kernels::FillColumn<false>>(*this, position, g, h, normal, factor);
}

}  // namespace skerry
