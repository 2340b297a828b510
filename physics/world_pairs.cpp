// SPDX-License-Identifier: MIT
//
// The stage of a step that finds pairs: boxes that bound the motion -> broad phase -> contact table
// (`world_contacts.cpp`).
#include <algorithm>

#include "physics/spare.h"
#include "physics/world_step.h"

namespace skerry {

/// New boxes of some bodies.
struct BoxPiece {
  std::vector<BoxUpdate> updates;
  std::vector<std::uint32_t> fresh;  ///< shapes that the broad phase does not know

  void clear() {
    updates.clear();
    fresh.clear();
  }
};

namespace {

struct BoxPieces {
  std::vector<BoxPiece> all;
};

}  // namespace

/// Boxes where the step begins, and those that bound the motion.
void Step::find_pairs() {
  const auto start = now();
  s_.shape_moved.assign(s_.shapes.size(), 0);
  if (rounds_ == 0) {
    s_.start_box.resize(s_.shapes.size());
    share(s_.pool.get(), s_.active.size(), kBodiesAPiece, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) {
        const std::uint32_t body = s_.active[k];
        if (s_.kept[body]) continue;
        const Transform at{s_.backup[body].position, s_.backup[body].rotation};
        for (const std::uint32_t i : s_.shapes_of[body])
          s_.start_box[i] = bounding_box(s_.shapes[i].shape, at);
      }
    });
  }
  const bool moved = place_boxes(rounds_ == 0 ? s_.active : s_.scratch.left);
  s_.loose_shapes.clear();
  s_.broad_phase->moved_pairs(s_.pairs);
  if (rounds_ == 0) {
    expect_blows();
    if (!s_.scratch.left.empty()) add_pairs_of_expecting();
  }
  merge_pairs(moved);
  book(Stage::Broad, start);
}

/// A box that contains all that the shape can go through: never more than its reach, and where the body is
/// fast, what lies along its way.
Aabb Step::box_of(std::uint32_t shape, std::uint32_t body) const {
  const Aabb& start = s_.start_box[shape];
  const double margin = s_.config.contact_margin;
  const Aabb all = grown(start, s_.reach[body] + margin);
  // What was struck in the last step will be struck again, but by whom is not known before there are pairs.
  if (s_.flight[body] != FlightKind::Fast || (rounds_ == 0 && s_.stray_guess[body] == kInfinity)) return all;
  const Way& way = s_.way[body];
  const double turn = std::abs(way.omega) + h_ * std::abs(way.alpha);
  const double astray = margin + s_.allowance[body] + (turn > 0 ? h_ * turn * s_.radius[body] : 0);
  // A parabola lies between its control points.
  const Vec2 middle = 0.5 * h_ * way.v, end = h_ * (way.v + 0.5 * h_ * way.a);
  const auto low = [](double x, double y) { return std::min({0.0, x, y}); };
  const auto high = [](double x, double y) { return std::max({0.0, x, y}); };
  return {{std::max(all.lower.x, start.lower.x + low(middle.x, end.x) - astray),
           std::max(all.lower.y, start.lower.y + low(middle.y, end.y) - astray)},
          {std::min(all.upper.x, start.upper.x + high(middle.x, end.x) + astray),
           std::min(all.upper.y, start.upper.y + high(middle.y, end.y) + astray)}};
}

/// @return whether a box is new
bool Step::place_boxes(const std::vector<std::uint32_t>& bodies) {
  Spare<BoxPieces> spare;
  std::vector<BoxPiece>& pieces = spare->all;
  const std::size_t count = (bodies.size() + kBodiesAPiece - 1) / kBodiesAPiece;
  if (pieces.size() < count) pieces.resize(count);
  for (BoxPiece& piece : pieces) piece.clear();
  share(s_.pool.get(), bodies.size(), kBodiesAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      if (s_.kept[bodies[k]]) continue;
      for (const std::uint32_t i : s_.shapes_of[bodies[k]])
        place_box(i, bodies[k], pieces[from / kBodiesAPiece]);
    }
  });
  s_.box_updates.clear();
  bool moved = false;
  for (const BoxPiece& piece : pieces) {
    moved |= !piece.fresh.empty() || !piece.updates.empty();
    for (const std::uint32_t i : piece.fresh) {
      ShapeRecord& shape = s_.shapes[i];
      const bool fixed = s_.bodies.type[shape.body.index] == BodyType::Static;
      s_.broad_phase->insert(i, shape.box, fixed ? ProxyKind::Fixed : ProxyKind::Moving);
      shape.in_broad_phase = true;
    }
    s_.box_updates.insert(s_.box_updates.end(), piece.updates.begin(), piece.updates.end());
  }
  if (!s_.box_updates.empty()) s_.broad_phase->update(s_.box_updates);
  return moved;
}

/// @param piece  gets the box, if it is another one than the broad phase has
void Step::place_box(std::uint32_t i, std::uint32_t body, BoxPiece& piece) {
  ShapeRecord& shape = s_.shapes[i];
  Aabb box = box_of(i, body);
  // What was found in this step already is not lost.
  if (rounds_ > 0) {
    box.lower = {std::min(box.lower.x, shape.box.lower.x), std::min(box.lower.y, shape.box.lower.y)};
    box.upper = {std::max(box.upper.x, shape.box.upper.x), std::max(box.upper.y, shape.box.upper.y)};
  }
  if (!shape.in_broad_phase)
    piece.fresh.push_back(i);
  else if (box.lower != shape.box.lower || box.upper != shape.box.upper ||
           (rounds_ == 0 && (shape.pairs_changed || s_.flight[body] == FlightKind::Fast)))
    piece.updates.push_back({i, box});
  else
    return;
  shape.box = box;
  shape.pairs_changed = false;
  s_.shape_moved[i] = 1;
}

/// Bodies that may be struck can meet more than those on their way.
void Step::add_pairs_of_expecting() {
  place_boxes(s_.scratch.left);
  std::vector<Pair>&more = s_.scratch.more, &pairs = s_.pairs;
  s_.broad_phase->moved_pairs(more);
  std::vector<PairLook>& looks = s_.scratch.looks;
  // Both are sorted; the larger boxes contain the others.
  const std::size_t before = pairs.size();
  auto known = pairs.begin();
  std::erase_if(more, [&](const Pair& pair) {
    while (known != pairs.end() && *known < pair) ++known;
    return known != pairs.end() && *known == pair;
  });
  pairs.resize(before + more.size());
  looks.resize(pairs.size());
  std::size_t to = pairs.size(), old = before;
  for (std::size_t k = more.size(); k-- > 0;) {
    for (; old > 0 && more[k] < pairs[old - 1]; --old) {
      --to;
      pairs[to] = pairs[old - 1];
      looks[to] = looks[old - 1];
    }
    pairs[--to] = more[k];
    looks[to] = look_at(more[k]);
  }
}

bool Step::may_touch(const ShapeRecord& a, const ShapeRecord& b) const {
  if (a.body == b.body || !may_collide(a.filter, b.filter)) return false;
  const bool dynamic =
      s_.bodies.type[a.body.index] == BodyType::Dynamic || s_.bodies.type[b.body.index] == BodyType::Dynamic;
  if (!dynamic && !a.sensor && !b.sensor) return false;
  for (const std::uint32_t j : s_.joints_of[b.body.index]) {
    const JointDef& def = s_.joints[j].def;
    if (!def.collide && (def.a == a.body || def.b == a.body)) return false;
  }
  return true;
}

}  // namespace skerry
