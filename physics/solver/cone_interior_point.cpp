// SPDX-License-Identifier: MIT
#include "physics/solver/cone_interior_point.h"

#include <algorithm>
#include <cmath>

#include "physics/index.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Where the central path is joined, of the largest |b| and of the violation at least, and where it ends.
constexpr double kStart = 0.3, kFarStart = 5, kEnd = 1e-8;
// The products end no faster than the gaps between the slacks and what they stand for: their mean is at least
// so many times the mean square of the gaps that are left.
constexpr double kFollow = 3;
// Proximal weight, so that rows that say the same do not take the last digits.
constexpr double kProximal = 1e-13;
// Of the step to the boundary.
constexpr double kToBoundary = 0.99;
// A product below this share of the mean after a step is raised to it, by the smaller of the two: what came
// to its boundary far from the path would stop all steps from then on. Of 10 000 random islands of 12 bodies
// 258 ended above 1e-7 without, and 3 do, in 0.93 of the steps.
constexpr double kLeastProduct = 0.3;
// Smoothing of the sign of sliding, of the centre; share of its slope that is left out, of what the step
// before was cut by.
constexpr double kSmoothing = 0.003, kDamping = 0.3;
// Costs in visits, measured: each row that is packed and each block whose place is found; in a step each
// contact, each block of the factor and each of its updates.
constexpr double kSetUpRow = 15, kSetUpBlock = 40, kContactCost = 25, kBlockCost = 8, kUpdateCost = 2.2;
// Fewer steps than this lead nowhere, more do not either; with this many short ones one after the other the
// path is lost.
constexpr int kFewSteps = 10, kManySteps = 60, kShortSteps = 8;
constexpr double kShort = 0.05;
// Sweeps that take the small errors out of the answer.
constexpr int kSmoothingSweeps = 10;

double sum(const Vec4& x) {
  return (x[0] + x[1]) + (x[2] + x[3]);
}

}  // namespace

struct ConeInteriorPoint::Kernels {
  using Vectors = std::vector<BodyVector>;

  static SKERRY_ALWAYS_INLINE void raise(Vec4& x, const Vec4& to) { x = x < to ? to : x; }
  static SKERRY_ALWAYS_INLINE void magnitude(const Vec4& x, Vec4& size) { size = x < Vec4{} ? -x : x; }

  /// Sums of the lanes of four vectors.
  static SKERRY_ALWAYS_INLINE void sums(const Vec4& p, const Vec4& q, const Vec4& r, const Vec4& s,
                                        Vec4& out) {
    const Vec4 pq = __builtin_shufflevector(p, q, 0, 4, 2, 6) + __builtin_shufflevector(p, q, 1, 5, 3, 7);
    const Vec4 rs = __builtin_shufflevector(r, s, 0, 4, 2, 6) + __builtin_shufflevector(r, s, 1, 5, 3, 7);
    out = __builtin_shufflevector(pq, rs, 0, 1, 4, 5) + __builtin_shufflevector(pq, rs, 2, 3, 6, 7);
  }

  /// Velocities along the rows of four contacts.
  static SKERRY_ALWAYS_INLINE void along_rows(const Contact* c, const Group& g, const Vectors& y, Vec4& u_n,
                                              Vec4& u_t) {
    Vec4 n[4], t[4];
    for (int i = 0; i < 4; ++i) {
      const Vec4 low = y[at(c[i].low)].v, high = y[at(c[i].high)].v;
      n[i] = c[i].n_low * low + c[i].n_high * high;
      t[i] = c[i].t_low * low + c[i].t_high * high;
    }
    sums(n[0], n[1], n[2], n[3], u_n);
    sums(t[0], t[1], t[2], t[3], u_t);
    u_n *= g.unit;
    u_t *= g.unit;
  }

  /// What acts along the two edges of four contacts, as impulses of their rows.
  static SKERRY_ALWAYS_INLINE void act(Group& g, const Vec4& plus, const Vec4& minus) {
    g.push_n = (plus + minus) * g.inverse_unit;
    g.push_t = g.mu * (plus - minus) * g.inverse_unit;
  }

  /// y += J' of the impulses of the rows, contact by contact.
  struct Push {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p) {
      const Contact* c = p.contacts_.data();
      for (const Group& g : p.groups_)
        for (int i = 0; i < 4; ++i, ++c) {
          p.y_[at(c->low)].v += c->n_low * g.push_n[i] + c->t_low * g.push_t[i];
          p.y_[at(c->high)].v += c->n_high * g.push_n[i] + c->t_high * g.push_t[i];
        }
    }
  };

  /// The same body by body, of the positions from `first` on and before `last`.
  struct Gather {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, int first, int last) {
      for (int position = first; position < last; ++position) {
        Vec4 all{};
        for (const ConeIncidence::Incident& e : p.incidence_.of(position)) {
          const Contact& c = p.contacts_[at(e.item)];
          const Group& g = p.groups_[at(e.item / 4)];
          const double n = g.push_n[e.item % 4], t = g.push_t[e.item % 4];
          all += e.is_high ? c.n_high * n + c.t_high * t : c.n_low * n + c.t_low * t;
        }
        p.y_[at(position)].v = all;
      }
    }
  };

  static SKERRY_ALWAYS_INLINE void read_velocities(const Contact* c, Group& g, const Vectors& y,
                                                   double shifts) {
    along_rows(c, g, y, g.u_n, g.u_t);
    g.u_n -= g.b_n;
    g.u_t -= g.b_t;
    magnitude(g.u_t, g.shift);
    g.shift *= shifts * g.mu;
  }

  struct ReadVelocities {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k)
        read_velocities(&p.contacts_[4 * k], p.groups_[k], p.y_, p.shifts_);
    }
  };

  /// Impulses, and products l s over their weight.
  struct ActNow {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, std::size_t first, std::size_t last,
                                         BodyVector& products) {
      Vec4 all{};
      for (std::size_t k = first; k < last; ++k) {
        Group& g = p.groups_[k];
        act(g, g.l[0], g.l[1]);
        for (int e = 0; e < 2; ++e) all += g.l[e] * g.s[e] * g.inverse_weight;
      }
      products.v = all;
    }
  };

  /// Gaps of the slacks where the bodies are, and the sums of their squares.
  struct Gaps {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, std::size_t first, std::size_t last,
                                         double smoothing, double share, BodyVector& squares) {
      Vec4 all{};
      for (std::size_t k = first; k < last; ++k) {
        Group& g = p.groups_[k];
        read_velocities(&p.contacts_[4 * k], g, p.y_, p.shifts_);
        Vec4 size;
        magnitude(g.u_t, size);
        g.theta = share * g.u_t / (size + smoothing);
        const Vec4 with = g.mu * g.u_t;
        for (int e = 0; e < 2; ++e) {
          g.gap[e] = (g.u_n + g.shift) + (e == 0 ? with : -with) - g.s[e];
          g.inverse_s[e] = 1 / g.s[e];
          g.inverse[e] = 1 / (g.s[e] + kProximal * g.l[e]);
          g.inverse_l[e] = 1 / g.l[e];
          g.rest[e] = Vec4{};
          all += g.gap[e] * g.gap[e];
        }
        // The two edges of a contact together: their weighted sums of (n +- mu t) (n + (+-mu + theta mu) t)'
        // are (W n + S t) n' + (B n + E t) t'.
        const Vec4 plus = g.l[0] * g.inverse[0], minus = g.l[1] * g.inverse[1], slope = g.mu * g.theta;
        g.W = plus + minus;
        g.S = g.mu * (plus - minus);
        g.B = g.S + slope * g.W;
        g.E = g.mu * g.mu * g.W + slope * g.S;
      }
      squares.v = all;
    }
  };

  /// B += P n' + Q t'
  static SKERRY_ALWAYS_INLINE void add_outer(Block3& B, const Vec4& P, const Vec4& n, const Vec4& Q,
                                             const Vec4& t) {
    for (int k = 0; k < 3; ++k) B.column[k] += P * n[k] + Q * t[k];
  }

  /// What the contacts of the body at `position` add to its column.
  struct FillColumn {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, int position) {
      BlockFactor& f = p.factor_;
      Block3 D{{Vec4{1, 0, 0, 0}, Vec4{0, 1, 0, 0}, Vec4{0, 0, 1, 0}}};
      for (const ConeIncidence::Incident& e : p.incidence_.of(position)) {
        const Contact& c = p.contacts_[at(e.item)];
        const Group& g = p.groups_[at(e.item / 4)];
        const int i = e.item % 4;
        const double W = g.W[i], S = g.S[i], B = g.B[i], E = g.E[i];
        if (e.is_high) {
          add_outer(D, c.n_high * W + c.t_high * S, c.n_high, c.n_high * B + c.t_high * E, c.t_high);
          continue;
        }
        const Vec4 P_low = c.n_low * W + c.t_low * S, Q_low = c.n_low * B + c.t_low * E;
        add_outer(D, P_low, c.n_low, Q_low, c.t_low);
        if (c.block < 0) continue;
        add_outer(f.lower(c.block), c.n_high * W + c.t_high * S, c.n_low, c.n_high * B + c.t_high * E,
                  c.t_low);
        if (!p.shifts_) continue;
        add_outer(f.upper(c.block), c.n_high, P_low, c.t_high, Q_low);
      }
      f.diagonal(position) = D;
      p.joints_.fill(position, p.shifts_, f);
    }
  };

  /// Right-hand side towards l s = target - rest.
  struct Aim {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, std::size_t first, std::size_t last,
                                         double target) {
      for (std::size_t k = first; k < last; ++k) {
        Group& g = p.groups_[k];
        Vec4 edge[2];
        for (int e = 0; e < 2; ++e)
          edge[e] = ((target * g.weight - g.rest[e]) - g.l[e] * (g.s[e] + g.gap[e])) * g.inverse[e];
        act(g, edge[0], edge[1]);
      }
    }
  };

  /// The direction, from that of the bodies; by how much the fastest falls, of what there is.
  struct Direct {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, std::size_t first, std::size_t last,
                                         double target, BodyVector& most) {
      Vec4 fall{};
      for (std::size_t k = first; k < last; ++k) {
        Group& g = p.groups_[k];
        Vec4 n, t;
        along_rows(&p.contacts_[4 * k], g, p.y_, n, t);
        g.du_t = t;
        const Vec4 with = g.mu * t, shift = g.theta * with;
        for (int e = 0; e < 2; ++e) {
          g.ds[e] = (n + shift) + (e == 0 ? with : -with) + g.gap[e];
          g.dl[e] = ((target * g.weight - g.rest[e]) - g.l[e] * (g.s[e] + g.ds[e])) * g.inverse[e];
          raise(fall, -g.dl[e] * g.inverse_l[e]);
          raise(fall, -g.ds[e] * g.inverse_s[e]);
        }
      }
      most.v = fall;
    }
  };

  /// What the predictor, so far, changes in products and shifts; sums of the products.
  struct Predict {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, std::size_t first, std::size_t last,
                                         double length, BodyVector& products) {
      Vec4 all{};
      const double shifts = p.shifts_;
      for (std::size_t k = first; k < last; ++k) {
        Group& g = p.groups_[k];
        const Vec4 change = length * g.du_t;
        Vec4 size;
        magnitude(g.u_t + change, size);
        const Vec4 more = shifts * (g.mu * size - g.shift) - g.mu * (g.theta * change);
        for (int e = 0; e < 2; ++e) {
          all += (g.l[e] + length * g.dl[e]) * (g.s[e] + length * g.ds[e]) * g.inverse_weight;
          g.gap[e] += more;
          g.rest[e] = g.dl[e] * g.ds[e];
        }
      }
      products.v = all;
    }
  };

  struct Move {
    static SKERRY_ALWAYS_INLINE void run(ConeInteriorPoint& p, std::size_t first, std::size_t last,
                                         double length, double least) {
      for (std::size_t k = first; k < last; ++k) {
        Group& g = p.groups_[k];
        const Vec4 wanted = least * g.weight;
        for (int e = 0; e < 2; ++e) {
          g.l[e] += length * g.dl[e];
          g.s[e] += length * g.ds[e];
          const auto small = (g.l[e] * g.s[e]) < wanted;
          const auto acts = g.l[e] > g.s[e];
          const Vec4 l = wanted / g.s[e], s = wanted / g.l[e];
          g.l[e] = small & ~acts ? l : g.l[e];
          g.s[e] = small & acts ? s : g.s[e];
        }
      }
    }
  };

  /// Calls a kernel for pieces of the groups, which are the same for any number of threads.
  template <class Kernel, class... More>
  static void each_piece(ConeInteriorPoint& p, const More&... more) {
    share_each(p.threads_, p.pieces_.size(), 1, [&](std::size_t piece) {
      const std::size_t first = piece * kGroupsAPiece,
                        last = std::min(first + kGroupsAPiece, p.groups_.size());
      run_kernel<Kernel>(p, first, last, more...);
    });
  }
  /// The same for kernels that find numbers of a piece, which go to `pieces_`.
  template <class Kernel, class... More>
  static void each_piece_finds(ConeInteriorPoint& p, const More&... more) {
    share_each(p.threads_, p.pieces_.size(), 1, [&](std::size_t piece) {
      const std::size_t first = piece * kGroupsAPiece,
                        last = std::min(first + kGroupsAPiece, p.groups_.size());
      run_kernel<Kernel>(p, first, last, more..., p.pieces_[piece]);
    });
  }
  static double sum_of_pieces(const ConeInteriorPoint& p) {
    double all = 0;
    for (const BodyVector& piece : p.pieces_) all += sum(piece.v);
    return all;
  }
  static double largest_of_pieces(const ConeInteriorPoint& p) {
    double largest = 0;
    for (const BodyVector& piece : p.pieces_)
      for (int i = 0; i < 4; ++i) largest = std::max(largest, piece.v[i]);
    return largest;
  }
};

// What acts along the rows onto the bodies.
void ConeInteriorPoint::push() {
  if (threads_ != nullptr && threads_->threads() > 1 && pieces_.size() > 1) {
    share(threads_, at(nodes_), kBodiesAPiece, [&](std::size_t from, std::size_t to) {
      run_kernel<Kernels::Gather>(*this, static_cast<int>(from), static_cast<int>(to));
    });
  } else {
    std::fill(y_.begin(), y_.end(), BodyVector{});
    run_kernel<Kernels::Push>(*this);
  }
  joints_.push(y_);
  y_[at(nodes_)].v = Vec4{};
}

double ConeInteriorPoint::direct(double target) {
  Kernels::each_piece<Kernels::Aim>(*this, target);
  joints_.aim(target);
  push();
  factor_.solve(y_.data(), threads_);
  Kernels::each_piece_finds<Kernels::Direct>(*this, target);
  return std::max(Kernels::largest_of_pieces(*this), joints_.direct(y_, target));
}

double ConeInteriorPoint::take_step() {
  Kernels::each_piece_finds<Kernels::ActNow>(*this);
  joints_.act();
  const double tau = (Kernels::sum_of_pieces(*this) + joints_.products()) / products_,
               smoothing = kSmoothing * std::sqrt(tau);
  const double share = shifts_ ? 1 - kDamping * (1 - last_length_) : 0;
  push();
  Kernels::each_piece_finds<Kernels::Gaps>(*this, smoothing, share);
  const double off = (Kernels::sum_of_pieces(*this) + joints_.measure(y_)) / products_;
  if (!factor_.factor(shifts_, threads_,
                      [&](int position) { run_kernel<Kernels::FillColumn>(*this, position); }))
    return 0;

  // Straight to the end: how far that comes tells how much to centre.
  double fall = direct(0);
  double length = fall > 1 ? 1 / fall : 1;
  Kernels::each_piece_finds<Kernels::Predict>(*this, length);
  const double products = Kernels::sum_of_pieces(*this) + joints_.predict(length);
  const double reached = std::max(0.0, products / products_) / tau;
  const double left = (1 - length) * (1 - length) * off;
  const double target = std::max(reached * reached * reached * tau, kFollow * left);
  fall = direct(target);
  length = kToBoundary * (fall > kToBoundary ? 1 / fall : 1 / kToBoundary);
  const double least = kLeastProduct * ((1 - length) * tau + length * target);
  Kernels::each_piece<Kernels::Move>(*this, length, least);
  joints_.move(length, least);
  return length;
}

bool ConeInteriorPoint::assign(const IslandSystem& system, SolveWork& work, ThreadPool* threads) {
  threads_ = threads;
  rows_ = system.size();
  nodes_ = static_cast<int>(system.bodies.size());
  edges_.clear();
  for (int i = 0; i < rows_; ++i) {
    const Row& row = system.rows[at(i)];
    const bool of_contact = row.kind == RowKind::Normal || row.kind == RowKind::Friction;
    if (of_contact && !system.compliance.empty() && system.compliance[at(i)] != 0) return false;
    if (row.kind == RowKind::Friction) {
      if (row.normal != i - 1) return false;
      continue;
    }
    const bool taken =
        row.kind == RowKind::Normal ? row.lower == 0 && row.upper == kInfinity : ConeJoints::takes(row);
    if (!taken) return false;
    if (row.a < 0 || row.b < 0) continue;
    if (edges_.empty() || edges_.back()[0] != row.a || edges_.back()[1] != row.b)
      edges_.push_back({row.a, row.b});
  }
  pattern_.analyse(nodes_, edges_);
  factor_.set_pattern(pattern_);
  ++work.symbolic_analyses;
  mass_.assign(at(nodes_) + 1, BodyVector{});
  y_.assign(at(nodes_) + 1, BodyVector{});
  for (int k = 0; k < nodes_; ++k) {
    const InverseMass& m = system.bodies[at(k)];
    const double linear = std::sqrt(m.linear), angular = std::sqrt(m.angular);
    mass_[at(pattern_.position(k))].v = Vec4{linear, linear, angular, 0};
  }
  contacts_.clear();
  joints_.clear();
  for (int i = 0; i < rows_; ++i) {
    const Row& row = system.rows[at(i)];
    if (row.kind == RowKind::Friction) continue;
    const int a = row.a < 0 ? nodes_ : pattern_.position(row.a);
    const int b = row.b < 0 ? nodes_ : pattern_.position(row.b);
    if (row.kind != RowKind::Normal) {
      joints_.add(system, i, {a, b}, pattern_, mass_, nodes_);
      continue;
    }
    Contact c{};
    c.low = std::min(a, b);
    c.high = std::max(a, b);
    c.block = c.high < nodes_ ? pattern_.block(c.low, c.high) : -1;
    c.row = i;
    c.rough = i + 1 < rows_ && system.rows[at(i + 1)].kind == RowKind::Friction;
    const auto put = [&](const Row& r, Vec4& low, Vec4& high) {
      const Vec4 Ja{r.Ja[0], r.Ja[1], r.Ja[2], 0}, Jb{r.Jb[0], r.Jb[1], r.Jb[2], 0};
      low = (a <= b ? Ja : Jb) * mass_[at(c.low)].v;
      high = (a <= b ? Jb : Ja) * mass_[at(c.high)].v;
      const double root = std::sqrt(sum(low * low) + sum(high * high));
      if (root > 0) {
        low /= root;
        high /= root;
      }
      return root;
    };
    c.n_root = put(row, c.n_low, c.n_high);
    if (c.rough) c.t_root = put(system.rows[at(i + 1)], c.t_low, c.t_high);
    // What nothing moves has no impulse.
    if (c.n_root > 0) contacts_.push_back(c);
  }
  const std::size_t count = contacts_.size();
  if (count == 0) return false;
  Contact none{};
  none.low = none.high = nodes_;
  none.block = none.row = -1;
  contacts_.resize((count + 3) / 4 * 4, none);
  groups_.resize(contacts_.size() / 4);
  pieces_.resize((groups_.size() + kGroupsAPiece - 1) / kGroupsAPiece);
  incidence_.assign(contacts_, nodes_);
  double least = kInfinity, most = 0;
  for (std::size_t k = 0; k < count; ++k) {
    least = std::min(least, contacts_[k].n_root);
    most = std::max(most, contacts_[k].n_root);
  }
  const double middle = std::sqrt(least * most);
  joints_.finish(nodes_, middle);
  products_ = 8 * static_cast<double>(groups_.size()) + joints_.sides();
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const Contact& c = contacts_[k];
    Group& g = groups_[k / 4];
    const std::size_t lane = k % 4;
    const bool is = k < count;
    g.unit[lane] = is ? c.n_root : 1;
    g.inverse_unit[lane] = 1 / g.unit[lane];
    g.weight[lane] = is ? c.n_root / middle : 1;
    g.inverse_weight[lane] = 1 / g.weight[lane];
    g.mu[lane] = is && c.rough ? system.rows[at(c.row + 1)].mu * c.t_root / c.n_root : 0;
    g.b_n[lane] = is ? system.b[at(c.row)] : 0;
    g.b_t[lane] = is && c.rough && c.t_root > 0 ? system.b[at(c.row + 1)] * c.n_root / c.t_root : 0;
  }
  const double blocks = nodes_ + pattern_.blocks();
  work.visits += kSetUpRow * rows_ + kSetUpBlock * blocks;
  step_cost_ = kContactCost * static_cast<double>(contacts_.size() + joints_.size()) + kBlockCost * blocks +
               kUpdateCost * static_cast<double>(pattern_.updates());
  return true;
}

void ConeInteriorPoint::start(std::span<const double> lambda, double centre, Sliding sliding) {
  last_length_ = 1;
  shifts_ = sliding == Sliding::Coulomb;
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const Contact& c = contacts_[k];
    Group& g = groups_[k / 4];
    const std::size_t lane = k % 4;
    g.l[0][lane] = g.l[1][lane] = 0;
    if (c.row < 0) {
      g.b_n[lane] = -centre;
      continue;
    }
    const double normal = lambda[at(c.row)] * c.n_root * c.n_root;
    const double mu = g.mu[lane];
    const double friction = mu > 0 ? lambda[at(c.row) + 1] * c.t_root * c.n_root / mu : 0;
    g.l[0][lane] = 0.5 * (normal + friction);
    g.l[1][lane] = 0.5 * (normal - friction);
  }
  Kernels::each_piece_finds<Kernels::ActNow>(*this);
  joints_.start(lambda, centre);
  joints_.act();
  push();
  Kernels::each_piece<Kernels::ReadVelocities>(*this);
  const double square = centre * centre;
  for (Group& g : groups_) {
    for (std::size_t lane = 0; lane < 4; ++lane) {
      for (int e = 0; e < 2; ++e) {
        const double with = g.mu[lane] * g.u_t[lane];
        const double s = g.u_n[lane] + g.shift[lane] + (e == 0 ? with : -with);
        const double z = g.l[e][lane] - s, product = square * g.weight[lane];
        const double larger = 0.5 * (std::abs(z) + std::sqrt(z * z + 4 * product)),
                     smaller = product / larger;
        g.l[e][lane] = z > 0 ? larger : smaller;
        g.s[e][lane] = z > 0 ? smaller : larger;
      }
    }
  }
}

double ConeInteriorPoint::step(SolveWork& work) {
  ++work.factorisations;
  work.resolves += 2;
  work.visits += step_cost_;
  last_length_ = take_step();
  return last_length_;
}

double ConeInteriorPoint::centre() const {
  double all = 0;
  for (const Group& g : groups_) all += sum((g.l[0] * g.s[0] + g.l[1] * g.s[1]) * g.inverse_weight);
  return std::sqrt((all + joints_.products()) / products_);
}

double ConeInteriorPoint::sliding() const {
  double all = 0;
  for (const Group& g : groups_) {
    Vec4 size;
    Kernels::magnitude(g.u_t, size);
    all += sum(g.mu * size * (g.l[0] + g.l[1]) * g.inverse_weight);
  }
  return std::sqrt(all / (8 * static_cast<double>(groups_.size())));
}

void ConeInteriorPoint::get(std::vector<double>& lambda) const {
  lambda.assign(at(rows_), 0.0);
  joints_.get(lambda);
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const Contact& c = contacts_[k];
    if (c.row < 0) continue;
    const Group& g = groups_[k / 4];
    const std::size_t lane = k % 4;
    const double plus = g.l[0][lane], minus = g.l[1][lane];
    lambda[at(c.row)] = (plus + minus) / (c.n_root * c.n_root);
    if (c.rough && c.t_root > 0) lambda[at(c.row) + 1] = g.mu[lane] * (plus - minus) / (c.n_root * c.t_root);
  }
}

bool improve_by_interior_point(const IslandSystem& system, double limit, ThreadPool* threads,
                               BlockSweeps& sweeps, double& violation, SolveWork& work) {
  const double rows = static_cast<double>(system.size()), last = kSmoothingSweeps * rows;
  // Not even packed where a chain of as many bodies would not fit.
  const double blocks = 2 * static_cast<double>(system.bodies.size());
  const double set_up = kSetUpRow * rows + kSetUpBlock * blocks;
  const double step = 0.5 * kContactCost * rows + kBlockCost * blocks;
  if (work.visits + set_up + kFewSteps * step + last > limit) return false;
  Spare<ConeInteriorPoint> spare;
  ConeInteriorPoint& path = *spare;
  if (!path.assign(system, work, threads) || work.visits + kFewSteps * path.step_cost() + last > limit)
    return false;
  Spare<std::vector<double>> before, after;
  violation = sweeps.violation();
  sweeps.get(sweeps.impulses(), *before);
  const double scale = residual_scale(largest_magnitude(system.b));
  path.start(*before, std::max(kStart * scale, kFarStart * violation));
  int failures = 0;
  for (int k = 0; k < kManySteps && failures < kShortSteps && path.centre() > kEnd * scale; ++k) {
    if (work.visits + path.step_cost() + last > limit) break;
    failures = path.step(work) < kShort ? failures + 1 : 0;
  }
  path.get(*after);
  sweeps.set(*after);
  for (int k = 0; k < kSmoothingSweeps; ++k) sweeps.sweep();
  work.visits += last;
  const double left = sweeps.violation();
  if (left < violation)
    violation = left;
  else
    sweeps.set(*before);
  return true;
}

}  // namespace skerry
