// SPDX-License-Identifier: MIT
//
// Bodies that are welded to each other move as one: their rows are left out of the problem, which is solved
// for rigid groups, and found afterwards.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "physics/solver/solver.h"

namespace skerry {

/// Static condensation [Guyan 1965] of an island. Three rows without bounds between two bodies that leave
/// them no motion against each other are a weld. Along a spanning tree of welds every body moves as
///
///   v_i = V + Omega perp(r_i),  omega_i = Omega,   beside a constant that makes the rows' b true,
///
/// with (V, Omega) of its group about the group's centre of mass, so that other rows see one body with the
/// mass and inertia of all. Bodies that are welded to the ground move as told. What the welds carry follows
/// from what all others do; where they close loops that is the smallest of many answers.
class WeldedBodies {
 public:
  /// Looks for welds, and makes the problem of the groups.
  /// @param joints  rows of joints, which come first: others are no welds, though they may hold both ways
  /// @return false where nothing is gained: there are no welds, or other rows than contacts and rigid joints
  /// are between bodies of one group
  bool find(const IslandSystem& system, int joints = std::numeric_limits<int>::max());

  /// The problem of the groups, and of all bodies that are none. @pre `find` was true
  const IslandSystem& groups() const { return groups_; }
  /// Rows that the groups' problem has less.
  int rows_less() const { return static_cast<int>(held_.size() + idle_.size()); }

  /// The problem of the welds alone, without their b, in which `expand` finds what they carry.
  const IslandSystem& welds();

  /// The impulses of the groups' rows among those of all, or none of none.
  void restrict_to_groups(std::span<const double> all, std::vector<double>& own) const;
  /// All impulses. @param own  those of the groups' rows
  /// @param memory  keeps order and fill of the welds
  void expand(const std::vector<double>& own, const SolveOptions& options,
              std::unique_ptr<SolverMemory>* memory, std::vector<double>& all, SolveWork& work);
  /// The same of an answer, judged as one of the whole problem.
  void expand(Solution& solution, const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);

  /// Adds what these impulses and the welds do to the velocities of all bodies; what the welds carry for that
  /// is not asked. @param own  impulses of the groups' rows
  void move(const std::vector<double>& own, std::vector<std::array<double, 3>>& velocities) const;
  /// Rows of the groups' problem among all.
  const std::vector<int>& rows() const { return own_; }
  /// Motion of the groups where their bodies have some, changed so that welds hold: b = -J v, with all that
  /// the ground adds.
  void join(const std::vector<std::array<double, 3>>& bodies,
            std::vector<std::array<double, 3>>& groups) const;
  /// Velocity along row `k` of the groups' problem that comes from bodies which are welded to the ground.
  double told(std::size_t k, const std::vector<std::array<double, 3>>& bodies) const;
  /// Motion of the bodies of groups; those that are welded to the ground keep theirs, changed likewise.
  void spread(const std::vector<std::array<double, 3>>& groups,
              std::vector<std::array<double, 3>>& bodies) const;

  void clear() { system_ = nullptr; }

 private:
  using Velocity = std::array<double, 3>;
  struct Member {
    int group = -1;       ///< body of `groups_`; -1: the ground
    bool alone = false;   ///< in its group
    Vec2 arm;             ///< from the centre of mass of the group [m]
    Velocity constant{};  ///< beside the motion of the group
  };
  /// Rows `first` to `first + 2` hold two bodies together.
  struct Weld {
    int first, a, b;
  };

  /// Of the bodies of a group.
  struct Sum {
    int bodies = 0;
    double mass = 0, inertia = 0;
    Vec2 moment, momentum, place;
    double spin = 0;
    bool turns = true;
  };

  bool find_welds(int joints);
  bool hang_on(std::size_t from, const Weld& weld);
  bool walk_along_welds();
  void weigh_groups();
  static bool pushes_whole(const Row& row);
  bool sort_rows();

  const IslandSystem* system_ = nullptr;
  std::vector<Weld> welds_;
  std::vector<int> first_weld_, weld_of_;  ///< welds of each body
  std::vector<Member> members_;            ///< by body
  std::vector<std::uint8_t> placed_;       ///< by body
  std::vector<int> open_;
  std::vector<Sum> sums_;
  IslandSystem groups_, welds_alone_;
  std::vector<int> own_;   ///< rows of `groups_`
  std::vector<int> held_;  ///< rows between bodies of one group that hold both ways
  std::vector<int> idle_;  ///< contacts between bodies of one group, which carry nothing
  std::vector<int> row_of_;
  std::vector<Velocity> velocity_;
  std::vector<int> number_of_;  ///< by body: in `welds_alone_`
  bool has_welds_ = false;      ///< `welds_alone_` is that of this system
};

}  // namespace skerry
