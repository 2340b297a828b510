// SPDX-License-Identifier: MIT
//
// One step of a world as a list of stages. Pairs are sorted and islands numbered canonically, so the result
// depends neither on the broad phase nor on the order in which islands are stepped. Where nothing changed,
// nothing is done: bodies that are where they were keep their boxes and manifolds, an unchanged graph its
// islands, and islands that are known to rest are kept as they are.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "physics/world_state.h"

namespace skerry {

/// Pairs that a thread takes at a time: some 50 us.
inline constexpr std::size_t kPairsAPiece = 512;

/// Bodies or joints that a thread takes at a time.
inline constexpr std::size_t kBodiesAPiece = 256;

/// Whether two shapes make a contact of this step, or may in a later round.
enum class PairVerdict : std::uint8_t { Never, Distant, Near, NearChain };

struct BoxPiece;

class Step {
 public:
  Step(WorldState& state, double h) : s_(state), h_(h) {}

  void run();
  /// Puts all bodies back to where the step found them.
  void undo();

 private:
  using Clock = std::chrono::steady_clock;

  /// The clock is read only for an observer: it costs as much as a body.
  Clock::time_point now() const { return s_.observe.stage_times ? Clock::now() : Clock::time_point{}; }
  void book(Stage stage, Clock::time_point start);

  // world_step.cpp: the working set and its forces at the beginning, what is kept at the end.
  void begin();
  void require_masses() const;
  void choose_active();
  void choose_joints();
  void begin_all();
  void begin(std::uint32_t body);
  bool begin_alone(std::uint32_t body);
  void begin(Contact& contact) const;
  void begin_joint(std::uint32_t joint) const;
  void follow_motions();
  void follow(std::uint32_t body);
  std::array<double, 3> acceleration_at_start(std::uint32_t body) const;
  double reach_at_start(std::uint32_t body) const;
  bool has_bounds_of_rest(std::uint32_t body) const;
  bool is_where_it_was(std::uint32_t body) const;
  void stop(std::uint32_t body);
  void note_contained(std::uint32_t body, ContainmentCause cause);
  void contain(std::uint32_t body, ContainmentCause cause);
  void restore(const std::vector<std::uint32_t>& bodies);
  void finish();
  void remember();
  bool may_sleep(const SteppedIsland& island) const;
  double guess_stray(std::uint32_t body) const;
  void keep_motion();

  // world_pairs.cpp: boxes that bound the motion within the step -> broad phase.
  void find_pairs();
  bool place_boxes(const std::vector<std::uint32_t>& bodies);
  void place_box(std::uint32_t shape, std::uint32_t body, BoxPiece& piece);
  Aabb box_of(std::uint32_t shape, std::uint32_t body) const;
  void add_pairs_of_expecting();
  bool may_touch(const ShapeRecord& a, const ShapeRecord& b) const;

  // world_contacts.cpp: which of them make a contact, and where it stands in the table.
  void merge_pairs(bool moved);
  bool are_pairs_of_table() const;
  void choose_wanted();
  void drop_known(std::vector<ContactKey>& wanted) const;
  void update_table();
  void put_back_lost();
  bool is_chain(const Pair& pair) const;
  void add_wanted(const Pair& pair);
  PairVerdict judge(const Pair& pair, const PairLook& look) const;
  void judge_pairs(std::vector<PairVerdict>& verdicts) const;
  void judge_distant(std::vector<PairVerdict>& verdicts) const;
  Contact make_contact(const ContactKey& key) const;

  // world_reach.cpp: how far bodies can go, and which pairs can meet therefore.
  void expect_blows();
  bool may_stray(std::uint32_t body) const;
  bool may_strike(const Pair& pair, const PairLook& look) const;
  PairLook look_at(const Pair& pair) const;
  bool is_near(const Pair& pair, const PairLook& look) const;
  double margin_of(std::uint32_t a, std::uint32_t b) const;
  double way_of(std::uint32_t body) const;
  double strays(std::uint32_t body) const;
  double closest_approach(std::uint32_t a, std::uint32_t b) const;
  bool fly_alike(std::uint32_t a, std::uint32_t b) const;
  double guess_of_joints(std::uint32_t body) const;
  bool went_straight(std::uint32_t body) const;
  Motion straight_motion(std::uint32_t body) const;
  bool meet_deeply(const Contact& contact) const;
  bool may_overrun(std::uint32_t body) const;
  bool find_detours();
  bool extend_reach();
  void loosen_overrun();

  // world_islands.cpp: which contacts belong to the step, the islands that they make, and their steps.
  void link_contacts();
  void refresh_links();
  bool wake_linked(bool first);
  void link(Contact& contact, bool first, LinkCount& count) const;
  void link_together(std::size_t from, std::size_t to, LinkCount& count) const;
  void set_linked(Contact& contact, bool linked, LinkCount& count) const;
  void note_linked(const Contact& contact) const;
  double make_manifold(Contact& contact, LinkCount& count) const;
  bool may_come_over(const Contact& contact) const;
  void find_islands();
  void step_islands();
  std::size_t put_large_ones_first(std::vector<std::size_t>& to_step) const;
  const std::vector<std::size_t>& cut_into_pieces(const std::vector<std::size_t>& to_step, std::size_t from);
  bool is_through() const;
  void give_exact_rounds_up();
  void count_last_round();
  bool stays(const SteppedIsland& island) const;
  bool flies_alone(const Island& island) const;
  void set_off(SteppedIsland& island) const;
  void prepare(SteppedIsland& island, ThreadPool* threads) const;
  void prepare_again(SteppedIsland& island);

  WorldState& s_;
  const double h_;
  int rounds_ = 0;
  bool may_keep_ = false;       ///< islands that rested may rest again
  bool graph_changed_ = false;  ///< since the last step, or the last round
  bool newly_linked_ = false;   ///< contacts, in this round
  std::size_t saved_ = 0;       ///< of the active bodies: those whose backup is that of this step
  bool begun_ = false;          ///< all of them are
};

}  // namespace skerry
