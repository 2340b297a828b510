// SPDX-License-Identifier: MIT
//
// Hierarchical grid: the searches. The build is in hierarchical_grid_build.cpp.
#include "physics/broadphase/hierarchical_grid.h"

#include <bit>

#include "physics/broadphase/ray_reach.h"
#include "physics/spare.h"

namespace skerry {

using namespace grid;

namespace {

/// Below so many boxes a second thread costs more than it finds.
constexpr std::size_t kBoxesPerThread = 2500;
/// The same of boxes that are searched around.
constexpr std::size_t kSearchesPerThread = 500;
/// Boxes in a line of the cache, and how many of a run are fetched at most: a long one fetches for itself.
constexpr std::uint32_t kBoxesInLine = 4, kMostFetched = 32;

}  // namespace

/// The pairs that one thread finds: tests ranges of slots without branches on what it finds.
struct HierarchicalGrid::Search {
  Search(const HierarchicalGrid& owner, const BoxSet& set, bool wants_all, PairBuffer& buffer)
      : boxes(set),
        box(owner.box_.data()),
        id(owner.id_.data()),
        all(wants_all),
        out(buffer)
#if defined(SKERRY_WIDE_TESTS)
        ,
        wide(owner.wide_tests_ && has_wide_tests())
#endif
  {
    next = out.reserve(kRoom);
    limit = next + kRoom;
  }

  /// Starts the search for the partners of the box in `slot`.
  void begin(std::uint32_t slot) {
    begin(id[slot], FloatLimits(box[slot]));
  }
  void begin(std::uint32_t listed, const FloatLimits& wanted) {
    own = listed;
    // Either box has to be marked as moved; if all pairs are wanted, this one counts as marked.
    own_moved = all ? listed | kMovedMark : listed;
    own_number = listed & kNumber;
    limits = wanted;
    first = next;
    ties = 0;
  }

  /// Tests the slots [from, to).
  void test(std::uint32_t from, std::uint32_t to) {
    if (next + (to - from + kPadding) > limit) make_room(to - from + kPadding);
    tests += to - from;
#if defined(SKERRY_WIDE_TESTS)
    if (wide) return test_wide(from, to);
#endif
    test_narrow(from, to);
  }

  void test_narrow(std::uint32_t from, std::uint32_t to) {
    // Local copies: a stored key could otherwise change any member, as far as the compiler knows.
    const FloatLimits wanted = limits;
    const FloatBox* const boxes_at = box;
    const std::uint32_t* const ids = id;
    const std::uint64_t mine = own_number;
    const std::uint32_t mine_moved = own_moved, mine_fixed = own;
    std::uint64_t* at = next;
    std::uint32_t tied = 0;
    // At least one block, even if the range is empty: a loop that runs once nearly always is well predicted.
    std::uint32_t k = from;
    do {
      for (std::uint32_t j = k; j < k + 2; ++j) {
        const FloatOverlap overlaps = wanted.compare(boxes_at[j]);
        const std::uint32_t other = ids[j];
        const std::uint32_t keeps = ((other | mine_moved) & kMovedMark) >> 30 & ~((other & mine_fixed) >> 31);
        const std::uint32_t hit =
            static_cast<std::uint32_t>(overlaps.maybe) & static_cast<std::uint32_t>(j < to) & keeps;
        const std::uint64_t number = other & kNumber;
        // The smaller number first, by a mask: which one it is cannot be predicted.
        const std::uint64_t exchange = std::uint64_t{0} - ((number - mine) >> 63);
        const std::uint64_t both = (number ^ mine) & exchange;
        *at = (mine ^ both) << 32 | (number ^ both);
        at += hit;
        tied |= hit & ~static_cast<std::uint32_t>(overlaps.certain);
      }
      k += 2;
    } while (k < to);
    next = at;
    ties |= tied;
  }

#if defined(SKERRY_WIDE_TESTS)
  /// The same with four boxes in one instruction, where the processor has it; the pairs are the same.
  __attribute__((target("avx512f,avx512vl,bmi2,popcnt"))) void test_wide(std::uint32_t from,
                                                                         std::uint32_t to) {
    const __m512 wanted = _mm512_maskz_broadcast_f32x4(0xFFFF, limits.values());
    const __m256i mine = _mm256_set1_epi64x(static_cast<long long>(own_number));
    const __m256i mine_moved = _mm256_set1_epi64x(own_moved),
                  mine_fixed = _mm256_set1_epi64x(own & kFixedMark);
    const __m256i moved = _mm256_set1_epi64x(kMovedMark), number = _mm256_set1_epi64x(kNumber);
    std::uint64_t* at = next;
    std::uint32_t tied = 0;
    std::uint32_t k = from;
    do {
      const __m512 boxes_at = _mm512_loadu_ps(box[k].v);
      const __m256i ids = _mm256_cvtepu32_epi64(_mm_loadu_si128(reinterpret_cast<const __m128i*>(id + k)));
      // Four bits a box; all four have to be set.
      const std::uint32_t maybe = all_of_four(_mm512_cmp_ps_mask(boxes_at, wanted, _CMP_LE_OQ));
      const std::uint32_t certain = all_of_four(_mm512_cmp_ps_mask(boxes_at, wanted, _CMP_LT_OQ));
      const std::uint32_t hit = _bzhi_u32(maybe, std::min(to - k, 4u)) &
                                _mm256_test_epi64_mask(_mm256_or_si256(ids, mine_moved), moved) &
                                _mm256_testn_epi64_mask(ids, mine_fixed);
      const __m256i other = _mm256_and_si256(ids, number);
      const __m256i keys = _mm256_or_si256(_mm256_slli_epi64(_mm256_min_epu64(other, mine), 32),
                                           _mm256_max_epu64(other, mine));
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(at),
                          _mm256_maskz_compress_epi64(static_cast<__mmask8>(hit), keys));
      at += _mm_popcnt_u32(hit);
      tied |= hit & ~certain;
      k += 4;
    } while (k < to);
    next = at;
    ties |= tied;
  }
#endif

  /// Tests one slot, which need not have any after it.
  void test_one(std::uint32_t slot) {
    if (next == limit) make_room(1);
    ++tests;
    const FloatOverlap overlaps = limits.compare(box[slot]);
    if (!overlaps.maybe) return;
    *next++ = pair_key(id[slot] & kNumber, own & kNumber);
    ties |= !overlaps.certain;
  }

  /// Ends the search of one box: where single precision could not tell, doubles do.
  void finish() {
    if (ties == 0) return;
    filter([&](ProxyIndex low, ProxyIndex high) { return overlap(boxes.box(low), boxes.box(high)); });
  }

  /// Keeps those pairs of the present box for which `keep(low, high)`.
  template <class Keep>
  void filter(Keep keep) {
    std::uint64_t* kept = first;
    for (const std::uint64_t* k = first; k < next; ++k) {
      *kept = *k;
      kept += keep(static_cast<ProxyIndex>(*k >> 32), static_cast<ProxyIndex>(*k)) ? 1 : 0;
    }
    next = kept;
  }

  void close(BroadPhaseStats& stats) {
    out.advance_to(next);
    stats.box_tests += tests;
    stats.false_pairs += tests - out.size();
  }

  void make_room(std::size_t more) {
    const auto found = static_cast<std::size_t>(next - first);
    out.advance_to(next);
    const std::size_t room = more + kRoom + out.size() / 2;
    next = out.reserve(room);
    limit = next + room;
    first = next - found;
  }

  static constexpr std::size_t kRoom = 1024;

  const BoxSet& boxes;
  const FloatBox* box;
  const std::uint32_t* id;
  bool all;
  PairBuffer& out;
  std::uint64_t* next;
  std::uint64_t* limit;
  std::uint64_t* first = nullptr;  ///< pairs of the present box begin here
  std::uint32_t own = 0, own_moved = 0, ties = 0;
  std::uint64_t own_number = 0;
  FloatLimits limits{FloatBox{}};
  std::uint64_t tests = 0;
#if defined(SKERRY_WIDE_TESTS)
  bool wide;
#endif
};

/// Calls `visit(first cell, last cell)` for the columns from `left` to `right` of a table's row; the cells of
/// one run are neighbours in memory.
template <class Visit>
void HierarchicalGrid::for_each_run(const GridLevel& level, std::int64_t row, std::int64_t left,
                                    std::int64_t right, Visit visit) const {
  // More columns than there are: all of them, once.
  const bool whole = right - left + 1 >= level.columns;
  const std::int64_t first_column = whole ? 0 : wrap(left + 1, level.columns);
  const std::int64_t last_column = whole ? level.columns - 1 : first_column + (right - left);
  const std::uint32_t row_base = level.base + static_cast<std::uint32_t>(row * level.columns);
  const auto first = row_base + static_cast<std::uint32_t>(first_column);
  if (last_column < level.columns) {
    visit(first, row_base + static_cast<std::uint32_t>(last_column));
  } else {
    visit(first, row_base + static_cast<std::uint32_t>(level.columns - 1));
    visit(row_base, row_base + static_cast<std::uint32_t>(last_column - level.columns));
  }
}

/// The same for the runs of cells that can list a box of this level that overlaps `region`.
template <class Visit>
void HierarchicalGrid::for_each_range(const GridLevel& level, const Aabb& region, Visit visit) const {
  const std::int64_t left = cell_coordinate(region.lower.x - level.size, origin_.x, level.inverse);
  const std::int64_t right = cell_coordinate(region.upper.x, origin_.x, level.inverse);
  const std::int64_t bottom = cell_coordinate(region.lower.y - level.size, origin_.y, level.inverse);
  const std::int64_t top = cell_coordinate(region.upper.y, origin_.y, level.inverse);
  const std::int64_t rows = std::min(top - bottom + 1, level.rows);
  std::int64_t row = rows == level.rows ? 0 : wrap(bottom + 1, level.rows);
  for (std::int64_t i = 0; i < rows; ++i) {
    for_each_run(level, row, left, right, visit);
    if (++row == level.rows) row = 0;
  }
}

/// Calls `visit(slot)` for the overflow of the cells from `first` to `last`.
template <class Visit>
void HierarchicalGrid::for_each_overflow(std::uint32_t first, std::uint32_t last, Visit visit) const {
  if (!places_ready_ || next_.empty()) return;
  for (std::uint32_t word = first / 64; word <= last / 64; ++word) {
    std::uint64_t bits = has_overflow_[word];
    if (word == first / 64) bits &= ~std::uint64_t{0} << first % 64;
    if (word == last / 64) bits &= ~std::uint64_t{0} >> (63 - last % 64);
    for (; bits != 0; bits &= bits - 1) {
      const std::uint32_t cell = 64 * word + static_cast<std::uint32_t>(std::countr_zero(bits));
      for (std::uint32_t slot = head_[cell]; slot != kNone; slot = next_[slot - packed_]) visit(slot);
    }
  }
}

/// Calls `visit(proxy)` for every box that overlaps `region`.
template <class Visit>
void HierarchicalGrid::for_each_overlap(const BoxSet& boxes, const Aabb& region, BroadPhaseStats& stats,
                                        Visit visit) const {
  const FloatLimits limits(region, origin_);
  std::uint64_t tests = 0, overlaps = 0;
  const auto test = [&](std::uint32_t slot) {
    const FloatOverlap found = limits.compare(box_[slot]);
    if (!found.maybe) return;
    const ProxyIndex proxy = id_[slot] & kNumber;
    if (!found.certain && !overlap(region, boxes.box(proxy))) return;
    ++overlaps;
    visit(proxy);
  };
  for (const GridLevel& level : levels_) {
    for_each_range(level, region, [&](std::uint32_t first, std::uint32_t last) {
      tests += start_[last + 1] - start_[first];
      for (std::uint32_t slot = start_[first]; slot < start_[last + 1]; ++slot) test(slot);
      for_each_overflow(first, last, [&](std::uint32_t slot) {
        ++tests;
        test(slot);
      });
    });
  }
  stats.box_tests += tests;
  stats.false_pairs += tests - overlaps;
}

/// Pairs on one level whose first box is in the slots [begin, end).
void HierarchicalGrid::search_level(const GridLevel& level, std::uint32_t begin, std::uint32_t end,
                                    Search& search) const {
  // Half of the neighbourhood: the rest of the own cell and the next one, and three cells of the row above.
  const auto columns = static_cast<std::uint32_t>(level.columns);
  const std::uint32_t* const start = start_.data();
  for (std::uint32_t slot = begin; slot < end; ++slot) {
    const std::uint32_t cell = cell_[slot];
    search.begin(slot);
    search.test(slot + 1, start[cell + 2]);
    search.test(start[cell + columns - 1], start[cell + columns + 2]);
    search.finish();
  }
}

/// The same where the table's last column and row are neighbours of the first.
void HierarchicalGrid::search_wrapped_level(const GridLevel& level, std::uint32_t begin, std::uint32_t end,
                                            Search& search) const {
  const auto columns = static_cast<std::uint32_t>(level.columns),
             rows = static_cast<std::uint32_t>(level.rows);
  for (std::uint32_t slot = begin; slot < end; ++slot) {
    const std::uint32_t cell = cell_[slot] - level.base;
    const std::uint32_t column = cell % columns, row = cell / columns;
    const std::uint32_t right = column + 1 == columns ? 0 : column + 1;
    const std::uint32_t left = column == 0 ? columns - 1 : column - 1;
    const std::uint32_t here = level.base + row * columns;
    const std::uint32_t above = level.base + (row + 1 == rows ? 0 : row + 1) * columns;
    search.begin(slot);
    search.test(slot + 1, start_[here + column + 1]);
    for (const std::uint32_t next : {here + right, above + left, above + column, above + right}) {
      search.test(start_[next], start_[next + 1]);
    }
    search.finish();
  }
}

/// Pairs of the boxes in the slots [begin, end) of one level with the boxes of another level.
void HierarchicalGrid::search_across(const GridLevel& to, std::uint32_t begin, std::uint32_t end,
                                     Search& search) const {
  for (std::uint32_t slot = begin; slot < end; ++slot) {
    search.begin(slot);
    for_each_range(to, search.boxes.box(id_[slot] & kNumber), [&](std::uint32_t first, std::uint32_t last) {
      search.test(start_[first], start_[last + 1]);
    });
    search.finish();
  }
}

/// The share of the search that one of several threads does.
void HierarchicalGrid::find_part(const BoxSet& boxes, bool all, std::size_t part, std::size_t parts,
                                 PairBuffer& out, BroadPhaseStats& stats) const {
  Search search(*this, boxes, all, out);
  const auto share = [&](const GridLevel& level, std::size_t k) {
    return level.first_slot + static_cast<std::uint32_t>(std::uint64_t{level.count} * k / parts);
  };
  for (const GridLevel& level : levels_) {
    const std::uint32_t begin = share(level, part), end = share(level, part + 1);
    if (level.wrapped) {
      search_wrapped_level(level, begin, end, search);
    } else {
      search_level(level, begin, end, search);
    }
  }
  for (std::size_t fine = 0; fine < levels_.size(); ++fine) {
    for (std::size_t coarse = fine + 1; coarse < levels_.size(); ++coarse) {
      const GridLevel &f = levels_[fine], &c = levels_[coarse];
      // Rows of cells to look at from either side; a small box meets up to three rows of large cells.
      const double up = 3.0 * f.count;
      const double down = 2.0 * c.count + c.heights / f.size;
      const GridLevel& from = down < up ? c : f;
      search_across(down < up ? f : c, share(from, part), share(from, part + 1), search);
    }
  }
  search.close(stats);
}

void HierarchicalGrid::find_all(const PairRequest& request, std::vector<PairBuffer>& parts,
                                BroadPhaseStats& stats) {
  const std::size_t count = workers_->shares(request.boxes.size(), kBoxesPerThread);
  if (parts.size() < count) parts.resize(count);
  std::vector<BroadPhaseStats> work(count);
  workers_->run(count, [&](std::size_t part) {
    find_part(request.boxes, request.all, part, count, parts[part], work[part]);
  });
  for (const BroadPhaseStats& w : work) {
    stats.box_tests += w.box_tests;
    stats.false_pairs += w.false_pairs;
  }
}

/// A search around each of a few boxes; what it met is kept where `reports(box, other)`.
template <class Reports>
void HierarchicalGrid::search_around(const BoxSet& boxes, std::span<const ProxyIndex> around, PairBuffer& out,
                                     BroadPhaseStats& stats, Reports reports) const {
  Search search(*this, boxes, true, out);
  Spare<std::array<Batch, 3>> batches_under_way;
  // The boxes are scattered in memory. Three batches are under way at a time: of one the cells are looked up,
  // of the next the slots, and the third is tested, so that the processor waits for many cache lines at once.
  const std::size_t batches = (around.size() + kBatch - 1) / kBatch;
  const auto batch_at = [&](std::size_t b) {
    return around.subspan(b * kBatch, std::min(kBatch, around.size() - b * kBatch));
  };
  for (std::size_t b = 0; b < batches + 2; ++b) {
    if (b < batches) {
      Batch& batch = (*batches_under_way)[b % 3];
      batch.runs.clear();
      const std::span<const ProxyIndex> proxies = batch_at(b);
      for (std::size_t i = 0; i < proxies.size(); ++i) {
        for (const GridLevel& level : levels_) {
          for_each_range(level, boxes.box(proxies[i]), [&](std::uint32_t first, std::uint32_t last) {
            batch.runs.push_back({0, 0, first, last});
            prefetch(&start_[first]);
          });
        }
        batch.ends[i + 1] = batch.runs.size();
      }
    }
    if (b >= 1 && b <= batches) {
      for (Run& run : (*batches_under_way)[(b - 1) % 3].runs) {
        run.begin = start_[run.first_cell];
        run.end = start_[run.last_cell + 1];
        const std::uint32_t end = std::min(run.end, run.begin + kMostFetched);
        for (std::uint32_t slot = run.begin; slot < end; slot += kBoxesInLine) prefetch(&box_[slot]);
        prefetch(&id_[run.begin]);
        prefetch(&id_[end]);
      }
    }
    if (b < 2) continue;
    const Batch& batch = (*batches_under_way)[(b - 2) % 3];
    const std::span<const ProxyIndex> proxies = batch_at(b - 2);
    for (std::size_t i = 0; i < proxies.size(); ++i) {
      const ProxyIndex proxy = proxies[i];
      search.begin(proxy, FloatLimits(boxes.box(proxy), origin_));
      for (std::size_t r = batch.ends[i]; r < batch.ends[i + 1]; ++r) {
        const Run& run = batch.runs[r];
        search.test(run.begin, run.end);
        for_each_overflow(run.first_cell, run.last_cell, [&](std::uint32_t slot) { search.test_one(slot); });
      }
      search.finish();
      search.filter(
          [&](ProxyIndex low, ProxyIndex high) { return reports(proxy, low == proxy ? high : low); });
    }
  }
  search.close(stats);
}

/// The same by several threads, where there are many.
template <class Reports>
void HierarchicalGrid::search_around(const BoxSet& boxes, std::span<const ProxyIndex> around,
                                     std::vector<PairBuffer>& parts, BroadPhaseStats& stats,
                                     Reports reports) const {
  const std::size_t count = workers_->shares(around.size(), kSearchesPerThread);
  if (count == 1) return search_around(boxes, around, parts.front(), stats, reports);
  if (parts.size() < count) parts.resize(count);
  Spare<std::vector<BroadPhaseStats>> work;
  work->assign(count, {});
  workers_->run(count, [&](std::size_t part) {
    const std::size_t from = around.size() * part / count, to = around.size() * (part + 1) / count;
    search_around(boxes, around.subspan(from, to - from), parts[part], (*work)[part], reports);
  });
  for (const BroadPhaseStats& w : *work) {
    stats.box_tests += w.box_tests;
    stats.false_pairs += w.false_pairs;
  }
}

void HierarchicalGrid::find(const PairRequest& request, std::vector<PairBuffer>& parts,
                            BroadPhaseStats& stats) {
  const BoxSet& boxes = request.boxes;
  if (request.all || 4 * boxes.moved().size() > boxes.size()) {
    // The marks of moved boxes are part of the build.
    if (built_version_ != boxes.version()) rebuild(boxes);
    return find_all(request, parts, stats);
  }
  search_around(boxes, boxes.moved(), parts, stats,
                [&](ProxyIndex from, ProxyIndex other) { return request.reports(from, other); });
}

void HierarchicalGrid::find_around(const BoxSet& boxes, std::span<const ProxyIndex> around,
                                   std::vector<PairBuffer>& parts, BroadPhaseStats& stats) const {
  search_around(boxes, around, parts, stats, [&](ProxyIndex from, ProxyIndex other) {
    return from != other && !(boxes.is_fixed(from) && boxes.is_fixed(other));
  });
}

void HierarchicalGrid::query(const BoxSet& boxes, const Aabb& region, std::vector<ProxyIndex>& found) const {
  BroadPhaseStats unused;
  for_each_overlap(boxes, region, unused, [&](ProxyIndex proxy) { found.push_back(proxy); });
}

/// Row by row along the ray: in each, the columns of the stretch that boxes of this row can reach
/// [Amanatides, Woo 1987, with runs of cells in place of single ones].
void HierarchicalGrid::ray_cast(const BoxSet& boxes, const Ray& ray, std::vector<ProxyIndex>& found) const {
  const RayTest test(ray);
  RayReach reach(ray);
  reach.clip(kAxisX, {bounds_.lower.x, bounds_.upper.x});
  reach.clip(kAxisY, {bounds_.lower.y, bounds_.upper.y});
  if (reach.is_empty()) return;
  const Interval x = reach.on(kAxisX), y = reach.on(kAxisY);
  const auto visit = [&](std::uint32_t first, std::uint32_t last) {
    const auto look_at = [&](std::uint32_t slot) {
      if (id_[slot] == kNone) return;
      const ProxyIndex proxy = id_[slot] & kNumber;
      if (test.meets(boxes.box(proxy))) found.push_back(proxy);
    };
    for (std::uint32_t slot = start_[first]; slot < start_[last + 1]; ++slot) look_at(slot);
    for_each_overflow(first, last, look_at);
  };
  for (const GridLevel& level : levels_) {
    // The share of a cell that rounding may take.
    const double pad = level.size / 64;
    const std::int64_t bottom = cell_coordinate(y.lower - level.size - pad, origin_.y, level.inverse);
    const std::int64_t top = cell_coordinate(y.upper + pad, origin_.y, level.inverse);
    if (top - bottom + 1 >= level.rows) {
      for_each_range(level, {{x.lower, y.lower}, {x.upper, y.upper}}, visit);
      continue;
    }
    std::int64_t row = wrap(bottom + 1, level.rows);
    for (std::int64_t i = bottom; i <= top; ++i) {
      // A box of this row begins in it and is at most one cell high. Far rows are one, and so is a whole
      // world that is too large for cells.
      const auto at = static_cast<double>(i);
      const bool is_world = level.inverse == 0;
      const double low = is_world || at <= -kFarCell ? -kInfinity : origin_.y + level.size * at - pad;
      const double high = is_world || at >= kFarCell ? kInfinity : origin_.y + level.size * (at + 2) + pad;
      RayReach part = reach;
      part.clip(kAxisY, {low, high});
      if (!part.is_empty()) {
        const Interval columns = part.on(kAxisX);
        for_each_run(level, row, cell_coordinate(columns.lower - level.size - pad, origin_.x, level.inverse),
                     cell_coordinate(columns.upper + pad, origin_.x, level.inverse), visit);
      }
      if (++row == level.rows) row = 0;
    }
  }
}

std::size_t HierarchicalGrid::bytes() const {
  return (box_.capacity() + new_box_.capacity()) * sizeof(FloatBox) +
         (start_.capacity() + id_.capacity() + cell_.capacity() + slot_of_.capacity() + head_.capacity() +
          2 * has_overflow_.capacity() + next_.capacity() + new_id_.capacity() + new_cell_.capacity()) *
             sizeof(std::uint32_t) +
         octave_of_box_.capacity();
}

void HierarchicalGrid::visit_structure(const BoxSet& boxes, StructureVisitor& visitor) const {
  // Cells by the boxes in them: a wrapped table knows the cells' places only through the boxes.
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const GridLevel& level = levels_[l];
    std::vector<std::pair<std::int64_t, std::int64_t>> cells;
    for (const std::uint32_t id : id_) {
      if (id == kNone) continue;
      const Aabb& box = boxes.box(id & kNumber);
      if (level_of(std::max(box.upper.x - box.lower.x, box.upper.y - box.lower.y)) != &level) continue;
      cells.emplace_back(cell_coordinate(box.lower.y, origin_.y, level.inverse),
                         cell_coordinate(box.lower.x, origin_.x, level.inverse));
    }
    std::sort(cells.begin(), cells.end());
    for (std::size_t i = 0, j = 0; i < cells.size(); i = j) {
      while (j < cells.size() && cells[j] == cells[i]) ++j;
      const Vec2 corner = origin_ + level.size * Vec2{static_cast<double>(cells[i].second),
                                                      static_cast<double>(cells[i].first)};
      visitor.cell({corner, corner + Vec2{level.size, level.size}}, static_cast<int>(l),
                   static_cast<int>(j - i));
    }
  }
}

}  // namespace skerry
