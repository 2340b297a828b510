// SPDX-License-Identifier: MIT
//
// A bridge that a train crosses: an exact static solve at every moment, until something breaks; then the rest
// of it moves on as bodies of the world.
//
// The bridge and the train are bodies of the world from the beginning (fixed ones while the answer is
// static), so they are drawn and met by other bodies like everything else.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "physics/statics/structure_solver.h"
#include "physics/world.h"

namespace skerry::statics {

/// In which axles are weighed [m/s^2].
inline constexpr double kStandardGravity = 9.81;

/// A row of axles; the first is in front. Two neighbours make a wagon.
struct Train {
  std::vector<double> axles;   ///< weights where gravity is `kStandardGravity` [N]
  std::vector<double> gaps;    ///< between neighbours, one fewer [m]
  double speed = 10;           ///< [m/s]
  double start = 0;            ///< of the first axle at time 0, along the deck from its first node [m]
  double wheel_radius = 0.45;  ///< [m]
};

struct BridgeDef {
  Structure structure;
  std::vector<int> deck;  ///< nodes along which the train runs, from the left; members join neighbours
  Train train;
  Load fixed;                      ///< loads besides the train and the weight of the members
  bool dynamic = false;            ///< bodies from the beginning, instead of static solves
  bool breaks = true;              ///< members break at their strength
  double thickness = 0.3;          ///< of the members as bodies [m]
  std::optional<double> ground{};  ///< level of the valley [m]: piers, banks and ground are made
};

/// What is known of a member. Of beams that are bodies, and of what is broken, nothing is.
struct MemberState {
  double axial = 0;                   ///< [N], tension positive
  double moment_a = 0, moment_b = 0;  ///< [N m]
  MemberStress stress;
  double signed_use = 0;  ///< utilisation, negative where compression decides
  double peak_use = 0;    ///< the signed use that was largest in magnitude so far
  double peak_time = 0;   ///< [s]
  bool slack = false;     ///< a cable without tension
  bool broken = false;
};

struct Break {
  int member = 0;
  double time = 0;  ///< [s]
  double use = 0;   ///< signed utilisation
};

/// Part of a member as a body.
struct BridgePiece {
  int member = 0;
  double from = 0, to = 1;  ///< shares of the member
  BodyId body;
  Vec2 local_from, local_to;  ///< its ends in the body's frame [m]
};

class Bridge {
 public:
  /// Makes the bodies. @throws std::invalid_argument for a bad structure, deck or train
  Bridge(BridgeDef def, World& world);

  /// Brings the bridge to `time` [s], after the world's step to that time.
  void advance(World& world, double time);

  const BridgeDef& def() const { return def_; }
  StructureSolver& solver() { return *solver_; }
  /// The structure without what broke: the one the solver holds now.
  const Determinacy& determinacy() const { return solver_->determinacy(); }
  bool moving() const { return moving_; }  ///< bodies, no longer static solves
  const std::vector<MemberState>& members() const { return members_; }
  const std::vector<Break>& breaks() const { return breaks_; }
  const std::vector<BridgePiece>& pieces() const { return pieces_; }
  /// Forces of the last solve. When moving only the reactions count: forces of the supports on their nodes,
  /// means of the last step.
  const Response& response() const { return response_; }
  const Load& load() const { return load_; }
  /// Where the axles are now, on the deck [m], and what they weigh [N]; empty without a train or when moving.
  struct Axle {
    Vec2 at;
    double load = 0;
    double station = 0;  ///< distance along the deck from its first node [m]
  };
  std::vector<Axle> axles() const;
  std::vector<BodyId> wagons() const;
  int worst() const;  ///< the member with the largest peak, -1: none
  double deck_length() const { return stations_.empty() ? 0 : stations_.back(); }

  /// Values of a quantity for a unit force downwards at `count` + 1 places along the deck.
  struct Line {
    std::vector<double> x, value;
  };
  Line influence_line(const Quantity& quantity, int count) const;
  /// The same at one place `x` [m] along the deck, of the whole structure.
  double influence_at(const Quantity& quantity, double x) const;

 private:
  /// A body that ends at a node.
  struct Attachment {
    BodyId body;
    Vec2 local;            ///< the node in the body's frame [m]
    bool clamped = false;  ///< one of its beams is, without a hinge
  };
  /// A cable in motion.
  struct RopeMember {
    int member = 0;
    JointId joint;
  };
  struct Wagon {
    BodyId body;
    int first = 0, count = 0;  ///< axles
    Vec2 centre;               ///< of mass, from the middle between the axles, in the body's frame [m]
  };

  struct DeckPlace {
    int member = -1;  ///< -1: beside the bridge
    double share = 0;
    Vec2 at;
  };
  DeckPlace place(double distance) const;
  void add_axles(double front, Load& load) const;
  void solve(double time);
  /// What an axle presses with in the gravity of now [N].
  Vec2 weight(double on_earth) const;
  void find_slack_cables();
  void rebuild_solver();
  void note_state(double time);
  void make_scenery(World& world);
  void make_wagons(World& world, bool dynamic);
  void pose_wagons(World& world);
  void make_fixed_members(World& world);
  void let_go(World& world);
  void measure(World& world, double time);
  void measure_reactions(const World& world);
  Vec2 fixed_force(std::size_t node) const;
  void apply_fixed_loads(World& world) const;
  void snap(World& world, std::size_t piece);
  void connect(World& world, std::size_t node);
  void hang_rope(World& world, RopeMember& rope);
  std::vector<std::size_t> make_group(World& world, const std::vector<BridgePiece>& parts);
  void attach(World& world, int node, BodyId body, bool clamped);
  Vec2 force_at(const World& world, std::size_t node, BodyId body) const;
  Shape piece_shape(const BridgePiece& piece, Vec2 origin, Vec2& from, Vec2& to) const;

  BridgeDef def_;
  Vec2 gravity_;                             ///< of the world [m/s^2]
  std::vector<double> stations_;             ///< distance of the deck's nodes
  std::vector<int> deck_members_;            ///< between them
  std::vector<int> kept_;                    ///< members of the solver's structure, by their number here
  std::vector<int> solver_index_;            ///< and back; -1: broken or slack
  std::shared_ptr<StructureSolver> solver_;  ///< of the members that stand; copies share it
  Load load_, solver_load_;
  Response response_;
  std::vector<MemberState> members_;
  std::vector<Break> breaks_;
  std::vector<BridgePiece> pieces_;
  std::vector<std::vector<Attachment>> attached_;  ///< by node, when moving
  std::vector<std::uint8_t> is_weight_;            ///< by node: its only body is what its cables weigh
  std::vector<std::vector<JointId>> joints_;       ///< by node, ropes not included
  std::vector<RopeMember> ropes_;
  std::vector<std::vector<JointId>> held_by_;  ///< by support, when moving
  std::map<int, BodyId> bearings_;             ///< wheels of the rollers, by node
  std::vector<Wagon> wagons_;
  double time_ = 0;
  bool moving_ = false;
};

}  // namespace skerry::statics
