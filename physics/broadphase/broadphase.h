// SPDX-License-Identifier: MIT
//
// Broad phase: from axis-aligned boxes to the pairs of boxes that overlap. All implementations give the same
// pairs in the same order, so that the physics is bit-identical whichever is chosen; `brute_force` is the
// oracle.
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "physics/math.h"

namespace skerry {

class ThreadPool;

/// A box's number: a small integer that the caller chooses (the world uses the shape's slot).
using ProxyIndex = std::uint32_t;

/// Fixed boxes (shapes of static bodies) never pair with each other.
enum class ProxyKind : std::uint8_t { Fixed, Moving };

/// Two overlapping boxes, low < high.
struct Pair {
  ProxyIndex low;
  ProxyIndex high;
  friend constexpr auto operator<=>(const Pair&, const Pair&) = default;
};

/// A new box for a proxy.
struct BoxUpdate {
  ProxyIndex proxy;
  Aabb box;
};

/// A ray or segment: points `origin + t * direction` with 0 <= t <= t_max.
struct Ray {
  Vec2 origin;     ///< [m], world frame
  Vec2 direction;  ///< any length but zero [m]
  double t_max = 1;
};

/// Settings that implementations may use; the defaults let each choose from the boxes.
struct BroadPhaseOptions {
  /// Grids and hash sorts: edge of a (finest) cell [m]; 0: chosen from the boxes. Cells of one size are
  /// doubled while their lists would exceed eight entries a box, so that memory stays linear.
  double cell_size = 0;
  std::vector<double> axes;  ///< axis methods: directions as angles [rad], 1 to 4; empty: two oblique ones
  int threads = 1;           ///< pair finding may use this many threads; the result does not depend on it
  /// Threads of the caller, which are there whenever pairs are asked for, in place of own ones.
  ThreadPool* pool = nullptr;
};

/// Receives an implementation's structure for drawing: cells, levels, axes with intervals, tree boxes.
class StructureVisitor {
 public:
  virtual ~StructureVisitor() = default;
  /// A cell, tree node or strip that is in use. `level` 0 is the finest or the leaf; `count` boxes are listed
  /// in it.
  virtual void cell(const Aabb& box, int level, int count) = 0;
  /// An axis of projection through `origin` with unit `direction`.
  virtual void axis(int index, Vec2 origin, Vec2 direction) = 0;
  /// The interval [lower, upper] of `proxy` on axis `index` [m along its direction].
  virtual void interval(int index, ProxyIndex proxy, double lower, double upper) = 0;
};

/// Work of the last `moved_pairs` call.
struct BroadPhaseStats {
  std::uint64_t box_tests = 0;    ///< exact box against box tests
  std::uint64_t false_pairs = 0;  ///< tests that gave no pair
  std::uint64_t swaps = 0;        ///< exchanges of sorted end points, a measure of lost coherence
  std::uint64_t pairs = 0;        ///< pairs reported
  std::uint64_t bytes = 0;        ///< memory held by the boxes, the structure and the sort
};

/// Why an implementation is at work.
enum class BroadPhaseReason : std::uint8_t {
  Named,     ///< it was asked for by its name
  FewBoxes,  ///< `auto` begins so, and stays as long as there are few boxes
  Cheapest,  ///< `auto`: the least expected time in the scene that the choice describes
};

/// The implementation that finds the pairs, and why. It has numbers and names of the registry only, so a copy
/// allocates nothing.
struct BroadPhaseChoice {
  std::string_view name;  ///< of the registry; never `auto`
  BroadPhaseReason reason = BroadPhaseReason::Named;
  std::uint64_t switches = 0;  ///< how often `auto` has changed it so far

  // The scene at the last change, for `Cheapest`. Sizes are those of boxes that end somewhere: those of
  // half-planes do not.
  std::uint64_t boxes = 0;
  double moved = 0;                  ///< of these a step, mean of the last steps
  double smallest = 0, largest = 0;  ///< longer side of a box [m]
  Vec2 extent{};                     ///< width and height of what contains them [m]
};
/// The reason in words: "by name", "few boxes", or the scene, for example "about 100 of 10000 moved a step,
/// 0.5 to 1 m, in 80 m x 60 m".
std::string reason_of(const BroadPhaseChoice& choice);

/// A set of boxes that finds its overlapping pairs. Not thread-safe; one call at a time.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  /// The registry's name; for `auto` the name is `auto` and `choice()` says what it uses.
  virtual std::string_view name() const = 0;
  /// The implementation at work, and why; others than `auto` give themselves.
  virtual BroadPhaseChoice choice() const = 0;

  /// Adds a box. @throws std::invalid_argument if `proxy` is present already, or if the box is not finite or
  /// inverted (the message has the proxy's number and the four values); the set is unchanged then.
  virtual void insert(ProxyIndex proxy, const Aabb& box, ProxyKind kind) = 0;
  /// Removes a box. @throws std::invalid_argument if `proxy` is not present.
  virtual void remove(ProxyIndex proxy) = 0;
  /// Gives new boxes to some proxies; the cost is in proportion to their number. All are checked before any
  /// is changed. @throws std::invalid_argument as `insert`.
  virtual void update(std::span<const BoxUpdate> moved) = 0;

  /// Reports the pairs with at least one box that was inserted or updated since the last call; exact overlap
  /// of closed boxes. @param pairs cleared, then filled; sorted by (low, high), no duplicates, no fixed-fixed
  /// pair.
  virtual void moved_pairs(std::vector<Pair>& pairs) = 0;
  /// Reports all overlapping pairs, in the same form.
  virtual void all_pairs(std::vector<Pair>& pairs) = 0;

  /// Boxes that overlap `box`, which may be unbounded; ascending. @param found cleared, then filled
  /// @throws std::invalid_argument if `box` is inverted, not a number, or all at infinity
  virtual void query(const Aabb& box, std::vector<ProxyIndex>& found) const = 0;
  /// Boxes that contain `point`, ascending.
  virtual void query(Vec2 point, std::vector<ProxyIndex>& found) const = 0;
  /// Boxes that the ray meets, ascending by number. @throws std::invalid_argument if the origin or the
  /// direction is not finite, the direction is zero, or t_max is negative or not a number
  virtual void ray_cast(const Ray& ray, std::vector<ProxyIndex>& found) const = 0;

  virtual std::size_t size() const = 0;
  virtual BroadPhaseStats stats() const = 0;
  virtual void visit_structure(StructureVisitor& visitor) const = 0;
};

/// One row of the registry: everything that menus, `--help`, tests and benchmarks need to know.
struct BroadPhaseEntry {
  std::string_view name;       ///< command-line value, for example "uniform_grid"
  std::string_view summary;    ///< one line
  std::string_view reference;  ///< source: author, year, section
  std::unique_ptr<BroadPhase> (*make)(const BroadPhaseOptions&);
};

/// All implementations; the first is the oracle.
std::span<const BroadPhaseEntry> broad_phases();
/// Makes the implementation called `name`. @throws std::invalid_argument that lists the names there are.
std::unique_ptr<BroadPhase> make_broad_phase(std::string_view name, const BroadPhaseOptions& options = {});

}  // namespace skerry
