// SPDX-License-Identifier: MIT
//
// The rows of an island for the body-space solvers, packed so that one pass over them reads little and goes
// four at a time: up to four rows behind each other between the same two bodies stand side by side, one a
// lane. Bodies are known by their elimination positions; what cannot move is the ground, the position after
// the last.
#pragma once

#include <span>
#include <vector>

#include "physics/archive.h"
#include "physics/islands/island_system.h"
#include "physics/solver/block_ldlt.h"
#include "physics/solver/simd.h"

namespace skerry {

class RowQuads {
 public:
  /// What the methods need to know of a row besides its Jacobian.
  struct Info {
    int normal = -1;    ///< row that scales the bounds, or -1 for constant ones
    bool dead = false;  ///< nothing it could move: D = 0
    double mu = 0;      ///< bounds +-mu lambda[normal]
    double lower = 0;   ///< constant bounds
    double upper = 0;
    double D = 0;           ///< diagonal of W, compliance included
    double compliance = 0;  ///< of which compliance
    double b = 0;

    void fields(Archive& a) {
      auto& [normal_, dead_, mu_, lower_, upper_, D_, compliance_, b_] = *this;
      a(normal_, dead_, mu_, lower_, upper_, D_, compliance_, b_);
    }
  };
  /// Up to four rows between two bodies.
  struct alignas(32) Quad {
    Vec4 low[3], high[3];  ///< Jacobians (x, y, turn) of the body eliminated first and of the other one
    Vec4 b;
    int first = 0, count = 0;  ///< rows
    int at_low = 0, at_high = 0;
    int block = -1;        ///< of the factor, off the diagonal
    bool a_is_low = true;  ///< the first body of the rows is the one eliminated first

    void fields(Archive& a) {
      a.doubles(this, 28);
      a(first, count, at_low, at_high, block, a_is_low);
    }
  };

  /// Finds which rows stand side by side; their numbers are zero. Rows of a contact are not parted where they
  /// fit. @param position  by body of the system @param ground  that of bodies that do not move
  void place(const IslandSystem& system, std::span<const int> position, int ground,
             const BlockPattern& pattern);
  /// Of rows that were taken: the largest relative change of a Jacobian entry, diagonal or compliance, and
  /// the largest |b|.
  struct Sizes {
    double change = 0, b = 0;
  };
  /// Takes the numbers of some rows; directions in which a body cannot move are left out.
  /// @param mass  inverse masses by position @param info  by row
  Sizes take(const IslandSystem& system, int first, int last, const BodyVector* mass, Info* info);

  int rows() const { return static_cast<int>(quad_of_row_.size()); }
  /// Whether a row is the first of its quad: what is done for pieces of the rows begins there.
  bool begins(int row) const { return quad(row).first == row; }
  const Quad& quad(int row) const {
    return quads_[static_cast<std::size_t>(quad_of_row_[static_cast<std::size_t>(row)])];
  }
  /// Jacobian blocks of one row.
  void jacobian(int row, BodyVector& low, BodyVector& high) const;
  /// Rows of the body at `position` between it and the bodies for which `wanted(position)` holds and that are
  /// eliminated later; appended, ascending.
  template <class Wanted>
  void append_rows(int position, const Wanted& wanted, std::vector<int>& rows) const {
    for (const Incident& incident : incident_at(position)) {
      const Quad& q = quads_[static_cast<std::size_t>(incident.quad)];
      if (incident.is_high || !wanted(q.at_high)) continue;
      for (int i = 0; i < q.count; ++i) rows.push_back(q.first + i);
    }
  }

  // In all that follows rows go from `first`, which begins a quad, to before `last`, and vectors of bodies
  // are by position, with one more for the ground.

  /// v += J^T lambda; with `sizes`, |J|^T |lambda|.
  void push(int first, int last, const double* lambda, BodyVector* v, bool sizes) const;
  /// The same for some bodies, with the sums in the same order.
  void gather(int first_position, int last_position, const double* lambda, BodyVector* v, bool sizes) const;
  /// u = J v - b; with `sizes`, |J| |v|.
  void velocities(int first, int last, const BodyVector* v, double* u, bool sizes) const;
  /// d = k - g J v - h J_n v, with n the normal row of a row. @param normal  by row
  void recover(int first, int last, const BodyVector* v, const double* k, const double* g, const double* h,
               const int* normal, double* d) const;
  /// Adds J^T (g J + h J_n) to the column of the factor that belongs to `position`.
  void fill_column(int position, const double* g, const double* h, const int* normal, bool general,
                   BlockFactor& factor) const;

  void fields(Archive& a) {
    [[maybe_unused]] auto& [ground, quads, quad_of_row, incident, incident_begin] = *this;
    a(ground, quads, quad_of_row);
    if (a.reading()) find_incident();
  }

 private:
  struct Kernels;
  /// Rows of a body, and which of their two bodies that is.
  struct Incident {
    int quad;
    bool is_high;
  };
  std::span<const Incident> incident_at(int position) const {
    const auto p = static_cast<std::size_t>(position);
    return std::span(incident_).subspan(
        static_cast<std::size_t>(incident_begin_[p]),
        static_cast<std::size_t>(incident_begin_[p + 1] - incident_begin_[p]));
  }
  void find_incident();
  /// The quads of some rows.
  std::span<const Quad> quads(int first, int last) const {
    if (first >= last) return {};
    const auto from = static_cast<std::size_t>(quad_of_row_[static_cast<std::size_t>(first)]),
               to = static_cast<std::size_t>(quad_of_row_[static_cast<std::size_t>(last) - 1]) + 1;
    return std::span(quads_).subspan(from, to - from);
  }

  int ground_ = 0;
  std::vector<Quad> quads_;
  std::vector<int> quad_of_row_;
  std::vector<Incident> incident_;  // by position, ascending; those of the ground last
  std::vector<int> incident_begin_;
};

}  // namespace skerry
