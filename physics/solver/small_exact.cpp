// SPDX-License-Identifier: MIT
#include "physics/solver/small_exact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>

#include "physics/solver/body_space.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/simd.h"

#if defined(__x86_64__)
#define SKERRY_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl")))
#else
#define SKERRY_AVX512
#endif

namespace skerry {
namespace {

// Relative weight of the first proximal step; two steps leave its square.
constexpr double kEta = 1e-8;
constexpr int kSteps = 2;

using Vec8 = double __attribute__((vector_size(64)));

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// What islands must share to be solved side by side.
struct Topology {
  struct Pair {
    signed char a, b, normal;
    bool joint;
    bool operator==(const Pair&) const = default;
  };
  int bodies = 0, rows = 0;
  std::array<Pair, kSmallRows>
      row;  // the first `rows` are set; clearing the rest would cost a tenth of a box

  bool operator==(const Topology& o) const {
    return bodies == o.bodies && rows == o.rows && std::equal(row.begin(), row.begin() + rows, o.row.begin());
  }
};

// The numbers; T is a double or eight of them.
template <class T>
struct alignas(64) Numbers {
  T Ja[kSmallRows][3], Jb[kSmallRows][3];
  T b[kSmallRows], mu[kSmallRows], lambda[kSmallRows];
  T inverse_mass[kSmallBodies][3];
  T residual;
};

// m <- max(m, x)
template <class T>
SKERRY_ALWAYS_INLINE void raise(T& m, const T& x) {
  m = x > m ? x : m;
}
template <class T>
SKERRY_ALWAYS_INLINE void clamp_to(T& x, const T& lower, const T& upper) {
  x = x < lower ? lower : x;
  x = x > upper ? upper : x;
}
template <class T>
SKERRY_ALWAYS_INLINE void make_absolute(T& x) {
  x = x < T{} ? -x : x;
}

// Block LDL^T of the body graph in natural order, on the stack.
template <class T>
struct SmallFactor {
  T block[kSmallBodies][kSmallBodies][3][3];  // lower triangle, row by column
  T multiplier[kSmallBodies][3];              // unit lower factors of the diagonal blocks: l10, l20, l21
  unsigned below[kSmallBodies];               // rows of each column, as bits

  SKERRY_ALWAYS_INLINE void clear(const Topology& t, const Numbers<T>& n) {
    const T one = T{} + 1.0;
    for (int j = 0; j < t.bodies; ++j) below[j] = 0;
    for (int i = 0; i < t.rows; ++i) {
      const int a = t.row[at(i)].a, b = t.row[at(i)].b;
      if (a >= 0 && b >= 0) below[std::min(a, b)] |= 1u << std::max(a, b);
    }
    for (int j = 0; j < t.bodies; ++j)
      if (below[j]) {
        const int parent = std::countr_zero(below[j]);
        below[parent] |= below[j] & ~(1u << parent);
      }
    for (int j = 0; j < t.bodies; ++j) {
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) block[j][j][r][c] = r == c ? one / n.inverse_mass[j][r] : T{};
      for (unsigned rest = below[j]; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) block[i][j][r][c] = T{};
      }
    }
  }

  // block[i][j] += g x y^T
  SKERRY_ALWAYS_INLINE void add(int i, int j, const T& g, const T (&x)[3], const T (&y)[3]) {
    for (int r = 0; r < 3; ++r) {
      const T s = g * x[r];
      for (int c = 0; c < 3; ++c) block[i][j][r][c] += s * y[c];
    }
  }

  SKERRY_ALWAYS_INLINE void factor(const Topology& t) {
    const T one = T{} + 1.0;
    for (int j = 0; j < t.bodies; ++j) {
      T(&D)[3][3] = block[j][j];
      D[0][0] = one / D[0][0];
      const T l10 = D[1][0] * D[0][0], l20 = D[2][0] * D[0][0];
      D[1][1] = one / (D[1][1] - l10 * D[1][0]);
      const T e = D[2][1] - l20 * D[1][0];
      const T l21 = e * D[1][1];
      D[2][2] = one / (D[2][2] - l20 * D[2][0] - l21 * e);
      multiplier[j][0] = l10;
      multiplier[j][1] = l20;
      multiplier[j][2] = l21;
      for (unsigned rest = below[j]; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        T Y[3][3];
        for (int r = 0; r < 3; ++r) {
          for (int c = 0; c < 3; ++c) Y[r][c] = block[i][j][r][c];
          // A row of L is Y D^-1.
          T x0 = Y[r][0], x1 = Y[r][1] - l10 * x0, x2 = Y[r][2] - l20 * x0 - l21 * x1;
          x2 = x2 * D[2][2];
          x1 = x1 * D[1][1] - l21 * x2;
          x0 = x0 * D[0][0] - l10 * x1 - l20 * x2;
          block[i][j][r][0] = x0;
          block[i][j][r][1] = x1;
          block[i][j][r][2] = x2;
        }
        // Columns above i are finished: their L times this Y; column i itself needs both.
        for (unsigned left = below[j]; left; left &= left - 1) {
          const int k = std::countr_zero(left);
          if (k < i) continue;
          if (k > i) {
            // block[k][j] still holds its Y; L_kj Y_ij^T = Y_kj D^-1 Y_ij^T = Y_kj L_ij^T.
            for (int r = 0; r < 3; ++r)
              for (int c = 0; c < 3; ++c)
                block[k][i][r][c] -= block[k][j][r][0] * block[i][j][c][0] +
                                     block[k][j][r][1] * block[i][j][c][1] +
                                     block[k][j][r][2] * block[i][j][c][2];
          } else {
            for (int r = 0; r < 3; ++r)
              for (int c = 0; c < 3; ++c)
                block[i][i][r][c] -=
                    block[i][j][r][0] * Y[c][0] + block[i][j][r][1] * Y[c][1] + block[i][j][r][2] * Y[c][2];
          }
        }
      }
    }
  }

  SKERRY_ALWAYS_INLINE void solve(const Topology& t, T (&x)[kSmallBodies][3]) const {
    for (int j = 0; j < t.bodies; ++j)
      for (unsigned rest = below[j]; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        for (int r = 0; r < 3; ++r)
          x[i][r] -= block[i][j][r][0] * x[j][0] + block[i][j][r][1] * x[j][1] + block[i][j][r][2] * x[j][2];
      }
    for (int j = t.bodies - 1; j >= 0; --j) {
      const T(&D)[3][3] = block[j][j];
      const T l10 = multiplier[j][0], l20 = multiplier[j][1], l21 = multiplier[j][2];
      T x0 = x[j][0], x1 = x[j][1] - l10 * x0, x2 = x[j][2] - l20 * x0 - l21 * x1;
      x2 = x2 * D[2][2];
      x1 = x1 * D[1][1] - l21 * x2;
      x0 = x0 * D[0][0] - l10 * x1 - l20 * x2;
      for (unsigned rest = below[j]; rest; rest &= rest - 1) {
        const int i = std::countr_zero(rest);
        x0 -= block[i][j][0][0] * x[i][0] + block[i][j][1][0] * x[i][1] + block[i][j][2][0] * x[i][2];
        x1 -= block[i][j][0][1] * x[i][0] + block[i][j][1][1] * x[i][1] + block[i][j][2][1] * x[i][2];
        x2 -= block[i][j][0][2] * x[i][0] + block[i][j][1][2] * x[i][1] + block[i][j][2][2] * x[i][2];
      }
      x[j][0] = x0;
      x[j][1] = x1;
      x[j][2] = x2;
    }
  }
};

// sum += J^T z
template <class T>
SKERRY_ALWAYS_INLINE void add_impulse(const Topology::Pair& row, const Numbers<T>& n, int i, const T& z,
                                      T (&sum)[kSmallBodies][3]) {
  if (row.a >= 0)
    for (int k = 0; k < 3; ++k) sum[row.a][k] += n.Ja[i][k] * z;
  if (row.b >= 0)
    for (int k = 0; k < 3; ++k) sum[row.b][k] += n.Jb[i][k] * z;
}

// u = J v
template <class T>
SKERRY_ALWAYS_INLINE void velocity_along(const Topology::Pair& row, const Numbers<T>& n, int i,
                                         const T (&v)[kSmallBodies][3], T& u) {
  u = T{};
  if (row.a >= 0) u += n.Ja[i][0] * v[row.a][0] + n.Ja[i][1] * v[row.a][1] + n.Ja[i][2] * v[row.a][2];
  if (row.b >= 0) u += n.Jb[i][0] * v[row.b][0] + n.Jb[i][1] * v[row.b][1] + n.Jb[i][2] * v[row.b][2];
}

template <class T>
SKERRY_ALWAYS_INLINE void velocities(const Topology& t, const Numbers<T>& n, T (&v)[kSmallBodies][3]) {
  for (int j = 0; j < t.bodies; ++j)
    for (int k = 0; k < 3; ++k) v[j][k] = T{};
  for (int i = 0; i < t.rows; ++i) add_impulse(t.row[at(i)], n, i, n.lambda[i], v);
  for (int j = 0; j < t.bodies; ++j)
    for (int k = 0; k < 3; ++k) v[j][k] *= n.inverse_mass[j][k];
}

// Sticks everything, then judges by the natural map.
template <class T>
SKERRY_ALWAYS_INLINE void solve_sticking(const Topology& t, Numbers<T>& n) {
  SmallFactor<T> factor;
  T D[kSmallRows], g[kSmallRows], k[kSmallRows], v[kSmallBodies][3], f[kSmallBodies][3];
  const T one = T{} + 1.0;
  factor.clear(t, n);
  for (int i = 0; i < t.rows; ++i) {
    const Topology::Pair& row = t.row[at(i)];
    D[i] = T{};
    for (int c = 0; c < 3; ++c) {
      if (row.a >= 0) D[i] += n.Ja[i][c] * n.Ja[i][c] * n.inverse_mass[row.a][c];
      if (row.b >= 0) D[i] += n.Jb[i][c] * n.Jb[i][c] * n.inverse_mass[row.b][c];
    }
    g[i] = one / (kEta * D[i]);
    if (row.a >= 0) factor.add(row.a, row.a, g[i], n.Ja[i], n.Ja[i]);
    if (row.b >= 0) factor.add(row.b, row.b, g[i], n.Jb[i], n.Jb[i]);
    if (row.a >= 0 && row.b > row.a) factor.add(row.b, row.a, g[i], n.Jb[i], n.Ja[i]);
    if (row.b >= 0 && row.a > row.b) factor.add(row.a, row.b, g[i], n.Ja[i], n.Jb[i]);
    n.lambda[i] = T{};
  }
  factor.factor(t);
  for (int step = 0; step < kSteps; ++step) {
    if (step > 0) velocities(t, n, v);
    for (int j = 0; j < t.bodies; ++j)
      for (int c = 0; c < 3; ++c) f[j][c] = T{};
    for (int i = 0; i < t.rows; ++i) {
      T u{};
      if (step > 0) velocity_along(t.row[at(i)], n, i, v, u);
      k[i] = g[i] * (n.b[i] - u);
      add_impulse(t.row[at(i)], n, i, k[i], f);
    }
    factor.solve(t, f);
    for (int i = 0; i < t.rows; ++i) {
      T u;
      velocity_along(t.row[at(i)], n, i, f, u);
      n.lambda[i] += k[i] - g[i] * u;
    }
  }

  // Bounds: zero for normal rows, the cone for friction and rolling.
  const T zero{};
  for (int i = 0; i < t.rows; ++i) {
    const Topology::Pair& row = t.row[at(i)];
    T& lambda = n.lambda[i];
    if (row.normal >= 0) {
      const T bound = n.mu[i] * n.lambda[row.normal];
      clamp_to(lambda, T(-bound), bound);
    } else if (!row.joint) {
      lambda = lambda < zero ? zero : lambda;
    }
  }
  velocities(t, n, v);
  T worst{}, scale{}, spoiled{};
  for (int i = 0; i < t.rows; ++i) {
    const Topology::Pair& row = t.row[at(i)];
    T u;
    velocity_along(row, n, i, v, u);
    T z = n.lambda[i] - (u - n.b[i]) / D[i];
    if (row.normal >= 0) {
      const T bound = n.mu[i] * n.lambda[row.normal];
      clamp_to(z, T(-bound), bound);
    } else if (!row.joint) {
      z = z < zero ? zero : z;
    }
    T violation = D[i] * (n.lambda[i] - z), size = n.b[i];
    make_absolute(violation);
    make_absolute(size);
    raise(worst, violation);
    raise(scale, size);
    // A comparison does not see what is not a number; a sum does.
    spoiled += violation * 0.0;
  }
  n.residual = worst / (scale > zero ? scale : one) + spoiled;
}

// The same for one body on the ground, the most frequent island of all: no graph, everything in registers.
template <class T>
SKERRY_ALWAYS_INLINE void solve_one_body(const Topology& t, Numbers<T>& n) {
  const T one = T{} + 1.0, zero{};
  T D[kSmallRows], g[kSmallRows], k[kSmallRows];
  const auto jacobian = [&](int i) -> const T(&)[3] { return t.row[at(i)].b >= 0 ? n.Jb[i] : n.Ja[i]; };
  const T m0 = n.inverse_mass[0][0], m1 = n.inverse_mass[0][1], m2 = n.inverse_mass[0][2];
  T h00 = one / m0, h10{}, h11 = one / m1, h20{}, h21{}, h22 = one / m2;
  for (int i = 0; i < t.rows; ++i) {
    const T(&J)[3] = jacobian(i);
    D[i] = J[0] * J[0] * m0 + J[1] * J[1] * m1 + J[2] * J[2] * m2;
    g[i] = one / (kEta * D[i]);
    const T s0 = g[i] * J[0], s1 = g[i] * J[1], s2 = g[i] * J[2];
    h00 += s0 * J[0];
    h10 += s1 * J[0];
    h11 += s1 * J[1];
    h20 += s2 * J[0];
    h21 += s2 * J[1];
    h22 += s2 * J[2];
    n.lambda[i] = zero;
  }
  // LDL^T of the one block.
  const T i0 = one / h00, l10 = h10 * i0, l20 = h20 * i0;
  const T i1 = one / (h11 - l10 * h10), e = h21 - l20 * h10, l21 = e * i1;
  const T i2 = one / (h22 - l20 * h20 - l21 * e);
  T v0{}, v1{}, v2{};
  for (int step = 0; step < kSteps; ++step) {
    T x0{}, x1{}, x2{};
    for (int i = 0; i < t.rows; ++i) {
      const T(&J)[3] = jacobian(i);
      k[i] = g[i] * (n.b[i] - (J[0] * v0 + J[1] * v1 + J[2] * v2));
      x0 += J[0] * k[i];
      x1 += J[1] * k[i];
      x2 += J[2] * k[i];
    }
    x1 -= l10 * x0;
    x2 -= l20 * x0 + l21 * x1;
    x2 *= i2;
    x1 = x1 * i1 - l21 * x2;
    x0 = x0 * i0 - l10 * x1 - l20 * x2;
    v0 = v1 = v2 = zero;
    for (int i = 0; i < t.rows; ++i) {
      const T(&J)[3] = jacobian(i);
      n.lambda[i] += k[i] - g[i] * (J[0] * x0 + J[1] * x1 + J[2] * x2);
      // The bounds are looked at after the last step: zero for normal rows, the cone for friction and
      // rolling.
      if (step + 1 == kSteps) {
        const Topology::Pair& row = t.row[at(i)];
        if (row.normal >= 0) {
          const T bound = n.mu[i] * n.lambda[row.normal];
          clamp_to(n.lambda[i], T(-bound), bound);
        } else if (!row.joint) {
          n.lambda[i] = n.lambda[i] < zero ? zero : n.lambda[i];
        }
      }
      v0 += J[0] * n.lambda[i];
      v1 += J[1] * n.lambda[i];
      v2 += J[2] * n.lambda[i];
    }
    v0 *= m0;
    v1 *= m1;
    v2 *= m2;
  }
  T worst{}, scale{}, spoiled{};
  for (int i = 0; i < t.rows; ++i) {
    const Topology::Pair& row = t.row[at(i)];
    const T(&J)[3] = jacobian(i);
    // D (lambda - clamp(lambda - w / D)) without the division.
    const T w = J[0] * v0 + J[1] * v1 + J[2] * v2 - n.b[i];
    T violation = w;
    if (row.normal >= 0) {
      const T bound = n.mu[i] * n.lambda[row.normal];
      clamp_to(violation, T(D[i] * (n.lambda[i] - bound)), T(D[i] * (n.lambda[i] + bound)));
    } else if (!row.joint) {
      const T most = D[i] * n.lambda[i];
      violation = violation > most ? most : violation;
    }
    T size = n.b[i];
    make_absolute(violation);
    make_absolute(size);
    raise(worst, violation);
    raise(scale, size);
    spoiled += violation * 0.0;
  }
  n.residual = worst / (scale > zero ? scale : one) + spoiled;
}

template <class T>
SKERRY_ALWAYS_INLINE void solve_small(const Topology& t, Numbers<T>& n) {
  if (t.bodies == 1)
    solve_one_body(t, n);
  else
    solve_sticking(t, n);
}

void solve_one(const Topology& t, Numbers<double>& n) {
  solve_small(t, n);
}
void solve_eight_portable(const Topology& t, Numbers<Vec8>& n) {
  solve_small(t, n);
}
SKERRY_AVX2 void solve_eight_avx2(const Topology& t, Numbers<Vec8>& n) {
  solve_small(t, n);
}
SKERRY_AVX512 void solve_eight_avx512(const Topology& t, Numbers<Vec8>& n) {
  solve_small(t, n);
}

bool cpu_has_avx512() {
#if defined(__x86_64__)
  static const bool has = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                          __builtin_cpu_supports("avx512vl");
  return has;
#else
  return false;
#endif
}

// Topology of an island; false if the fast path does not apply.
bool read_topology(const IslandSystem& system, Topology& t) {
  const std::size_t rows = system.rows.size(), bodies = system.bodies.size();
  if (rows == 0 || rows > kSmallRows || bodies > kSmallBodies || !system.compliance.empty()) return false;
  for (const InverseMass& m : system.bodies)
    if (!(m.linear > 0 && m.angular > 0)) return false;
  t.bodies = static_cast<int>(bodies);
  t.rows = static_cast<int>(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    const Row& row = system.rows[i];
    const bool normal = row.kind == RowKind::Normal && row.lower == 0 && row.upper == kInfinity;
    const bool joint = row.kind == RowKind::Joint && row.lower == -kInfinity && row.upper == kInfinity;
    if (!normal && !joint && row.normal < 0) return false;
    t.row[i] = {static_cast<signed char>(row.a), static_cast<signed char>(row.b),
                static_cast<signed char>(row.normal), joint};
  }
  return true;
}

// Copies the numbers of an island through `put(T&, double)`.
template <class T, class Put>
void read_numbers(const IslandSystem& system, Numbers<T>& n, Put&& put) {
  for (std::size_t j = 0; j < system.bodies.size(); ++j) {
    put(n.inverse_mass[j][0], system.bodies[j].linear);
    put(n.inverse_mass[j][1], system.bodies[j].linear);
    put(n.inverse_mass[j][2], system.bodies[j].angular);
  }
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    for (std::size_t k = 0; k < 3; ++k) {
      put(n.Ja[i][k], row.Ja[k]);
      put(n.Jb[i][k], row.Jb[k]);
    }
    put(n.b[i], system.b[i]);
    put(n.mu[i], row.mu);
  }
}

Solution sticking_solution(std::vector<double> lambda, double residual) {
  Solution solution;
  solution.status = SolveStatus::Solved;
  solution.method = "small_exact";
  solution.lambda = std::move(lambda);
  solution.residual = residual;
  solution.iterations = 1;
  solution.work.factorisations = 1;
  solution.work.resolves = kSteps;
  return solution;
}

}  // namespace

bool fits_small_exact(const IslandSystem& system) {
  Topology topology;
  return read_topology(system, topology);
}

Solution solve_small_exact(const IslandSystem& system, std::span<const double> warm_start,
                           const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  Topology topology;
  if (read_topology(system, topology)) {
    Numbers<double> numbers;
    read_numbers(system, numbers, [](double& to, double from) { to = from; });
    solve_one(topology, numbers);
    if (numbers.residual <= options.tolerance) {
      Solution solution =
          sticking_solution({numbers.lambda, numbers.lambda + system.rows.size()}, numbers.residual);
      if (options.trace) {
        solution.trace = std::make_unique<SolveTrace>();
        solution.trace->notes.emplace_back("small island, everything sticks");
      }
      return solution;
    }
  }
  return solve_body_space(system, warm_start, options, memory);
}

struct SmallBatch::Data {
  Topology topology;
  bool any = false;
  Numbers<Vec8> numbers;
};

SmallBatch::SmallBatch() : data_(std::make_unique<Data>()) {}
SmallBatch::~SmallBatch() = default;
SmallBatch::SmallBatch(SmallBatch&&) noexcept = default;
SmallBatch& SmallBatch::operator=(SmallBatch&&) noexcept = default;

bool SmallBatch::set(int lane, const IslandSystem& system) {
  if (lane < 0 || lane >= kLanes)
    throw std::invalid_argument("SmallBatch: lane " + std::to_string(lane) + " of 8");
  Topology topology;
  if (!read_topology(system, topology)) return false;
  if (data_->any && !(topology == data_->topology)) return false;
  if (!data_->any) {
    // Lanes that stay empty must be harmless: they all start as this island.
    data_->topology = topology;
    data_->any = true;
    read_numbers(system, data_->numbers, [](Vec8& to, double from) { to = Vec8{} + from; });
  }
  read_numbers(system, data_->numbers, [lane](Vec8& to, double from) { to[lane] = from; });
  return true;
}

void SmallBatch::solve() {
  if (!data_->any) return;
  if (cpu_has_avx512())
    solve_eight_avx512(data_->topology, data_->numbers);
  else if (cpu_has_avx2())
    solve_eight_avx2(data_->topology, data_->numbers);
  else
    solve_eight_portable(data_->topology, data_->numbers);
}

double SmallBatch::residual(int lane) const {
  return data_->any ? data_->numbers.residual[lane] : kInfinity;
}

void SmallBatch::impulses(int lane, std::span<double> lambda) const {
  for (std::size_t i = 0; i < lambda.size() && i < at(data_->topology.rows); ++i)
    lambda[i] = data_->numbers.lambda[i][lane];
}

std::vector<Solution> solve_batch(std::span<const IslandSystem* const> systems, const SolveOptions& options) {
  std::vector<Solution> solutions(systems.size());
  for (std::size_t first = 0; first < systems.size();) {
    SmallBatch batch;
    int lanes = 0;
    while (lanes < SmallBatch::kLanes && first + at(lanes) < systems.size() &&
           batch.set(lanes, *systems[first + at(lanes)]))
      ++lanes;
    if (lanes > 1) batch.solve();
    for (int lane = 0; lane < std::max(1, lanes); ++lane) {
      const IslandSystem& system = *systems[first + at(lane)];
      Solution& solution = solutions[first + at(lane)];
      if (lanes > 1 && batch.residual(lane) <= options.tolerance) {
        std::vector<double> lambda(system.rows.size());
        batch.impulses(lane, lambda);
        solution = sticking_solution(std::move(lambda), batch.residual(lane));
      } else {
        solution = solve_small_exact(system, {}, options, nullptr);
      }
    }
    first += at(std::max(1, lanes));
  }
  return solutions;
}

extern const SolverEntry kSmallExactEntry;
const SolverEntry kSmallExactEntry = {
    .name = "small_exact",
    .summary = "fixed-size body space on the stack for small islands; else body_space",
    .reference = "physics/README.md",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_small_exact,
};

}  // namespace skerry
