// SPDX-License-Identifier: MIT
//
// What an implementation has to provide: a structure over a `BoxSet` that is brought up to date lazily, finds
// pairs and answers region queries. Everything else (validation, marks, order of the pairs) is shared, so
// `auto` can change the structure under a set of boxes at any time and lose nothing.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "physics/broadphase/box_set.h"
#include "physics/broadphase/pair_buffer.h"

namespace skerry {

/// What a pair search asks for, and the rule that makes each pair appear once.
struct PairRequest {
  const BoxSet& boxes;
  bool all = false;  ///< all pairs, not only those with a moved box

  /// True if `proxy` is one of the boxes whose pairs are wanted.
  bool wants(ProxyIndex proxy) const { return all || boxes.is_moved(proxy); }
  /// True if a search that starts at the wanted box `from` has to report that it met `other`: not if both are
  /// fixed, and not if a search from `other` reports it.
  bool reports(ProxyIndex from, ProxyIndex other) const {
    if (from == other || (boxes.is_fixed(from) && boxes.is_fixed(other))) return false;
    return from < other || !wants(other);
  }
  /// True if the pair is wanted, wherever the search starts.
  bool keeps(ProxyIndex a, ProxyIndex b) const {
    return !(boxes.is_fixed(a) && boxes.is_fixed(b)) && (wants(a) || wants(b));
  }
  /// Calls `visit(proxy)` for every wanted box.
  template <class Visit>
  void for_each_wanted(Visit visit) const {
    if (!all) {
      for (const ProxyIndex proxy : boxes.moved()) visit(proxy);
      return;
    }
    for (ProxyIndex proxy = 0; proxy < boxes.limit(); ++proxy) {
      if (boxes.is_present(proxy)) visit(proxy);
    }
  }
};

/// One search structure. Its answers are exact, free of duplicates and in any order.
class PairFinder {
 public:
  virtual ~PairFinder() = default;

  /// Follows the changes: `dirty` are the proxies that were inserted, changed or removed since the last call.
  virtual void synchronise(const BoxSet& boxes, std::span<const ProxyIndex> dirty,
                           BroadPhaseStats& stats) = 0;
  /// Finds the requested pairs; `parts` is empty and may be given one buffer a thread.
  virtual void find(const PairRequest& request, std::vector<PairBuffer>& parts, BroadPhaseStats& stats) = 0;
  /// True if the last `find` gave the pairs sorted, one part after the other.
  virtual bool in_order() const { return false; }
  /// Appends the boxes that overlap `region`, which may be unbounded.
  virtual void query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const = 0;
  /// Appends the boxes that the ray meets.
  virtual void ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const;
  /// What a finder that chooses among others has chosen; without a name for all else.
  virtual BroadPhaseChoice choice() const { return {}; }
  virtual std::size_t bytes() const = 0;
  virtual void visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const = 0;
};

/// A broad phase called `name` that searches with `finder`.
std::unique_ptr<BroadPhase> make_with_finder(std::string_view name, std::unique_ptr<PairFinder> finder);

// One file each.
std::unique_ptr<PairFinder> make_brute_force(const BroadPhaseOptions& options);
std::unique_ptr<PairFinder> make_uniform_grid(const BroadPhaseOptions& options);
std::unique_ptr<PairFinder> make_hierarchical_grid(const BroadPhaseOptions& options);
std::unique_ptr<PairFinder> make_sweep_and_prune(const BroadPhaseOptions& options);
std::unique_ptr<PairFinder> make_hash_sort(const BroadPhaseOptions& options);
std::unique_ptr<PairFinder> make_hierarchical_hash_sort(const BroadPhaseOptions& options);
std::unique_ptr<PairFinder> make_aabb_tree(const BroadPhaseOptions& options);
std::unique_ptr<PairFinder> make_neighbour_list(const BroadPhaseOptions& options);
/// @param wide_tests  use wide vector instructions where the processor has them; the results are the same
std::unique_ptr<PairFinder> make_neighbour_list(const BroadPhaseOptions& options, bool wide_tests);
std::unique_ptr<PairFinder> make_auto(const BroadPhaseOptions& options);

}  // namespace skerry
