// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: four boxes or discs, each against a half-plane, side by side. Every lane does what
// `collide` does for one pair (half_plane_and_hull in meet.cpp), operation by operation.
//
// No include guard: see four_lanes.h.

/// @tparam kCorners  4: boxes, 1: discs
/// @param wanted     bit k: lane k counts
/// @return bits of lanes that have to be done one by one
template <int kCorners>
inline unsigned plane_group(const Group& group, unsigned wanted, NarrowPhaseStats& stats) {
  const Four zero = Four::both(0), half = Four::both(0.5);
  const Columns pose_a = group.pose_a(), pose_b = group.pose_b();
  const Shape *plane[4], *body[4];
  double seconds[4];
  for (int lane = 0; lane < 4; ++lane) {
    const Shape &a = group.a(lane), &b = group.b(lane);
    const bool second = b.kind == ShapeKind::HalfPlane;
    plane[lane] = second ? &b : &a;
    body[lane] = second ? &a : &b;
    seconds[lane] = second ? 1 : 0;
  }
  const auto row = [](const double* x) { return Four::gather(x, x + 1, x + 2, x + 3); };
  const auto vectors = [](auto at) { return points(at(0), at(1), at(2), at(3)); };
  const Four exchange = below(zero, row(seconds));
  const Columns frame = {chosen(exchange, pose_b.x, pose_a.x), chosen(exchange, pose_b.y, pose_a.y),
                         chosen(exchange, pose_b.z, pose_a.z), chosen(exchange, pose_b.w, pose_a.w)};
  const Columns other = {chosen(exchange, pose_a.x, pose_b.x), chosen(exchange, pose_a.y, pose_b.y),
                         chosen(exchange, pose_a.z, pose_b.z), chosen(exchange, pose_a.w, pose_b.w)};

  // Pose of the body in the frame of the half-plane.
  const Four dx = other.x - frame.x, dy = other.y - frame.y;
  const Four px = frame.z * dx + frame.w * dy, py = frame.z * dy - frame.w * dx;
  const Four c = frame.z * other.z + frame.w * other.w, s = frame.z * other.w - frame.w * other.z;
  const unsigned one_by_one = wanted & ~bits(below(magnitude(dx) + magnitude(dy), Four::both(kFarAway)));

  // Heights of the corners above the line, less the rounding; the first one that is lowest.
  const Points foot = vectors([&](int lane) { return &plane[lane]->vertices.data()->x; });
  const Points n = vectors([&](int lane) { return &plane[lane]->normals.data()->x; });
  const Four base = n.x * (px - foot.x) + n.y * (py - foot.y);
  const Four own_x = c * n.x + s * n.y, own_y = c * n.y - s * n.x;
  const auto across = [&](const Points& v) { return own_x * v.x + own_y * v.y; };
  const Four radius = radius_of(body);
  const auto corners = [&](auto number) {
    return vectors([&](int lane) { return &body[lane]->vertices.data()[number(lane)].x; });
  };
  const auto height_of = [&](const Points& v) { return (base + across(v)) - radius; };
  Points deep = corners([](int) { return 0; });
  Four height = height_of(deep), deepest = zero;
  for (int i = 1; i < kCorners; ++i) {
    const Points v = corners([&](int) { return i; });
    const Four value = height_of(v), lower = below(value, height);
    height = chosen(lower, value, height);
    deepest = chosen(lower, Four::both(i), deepest);
    deep = {chosen(lower, v.x, deep.x), chosen(lower, v.y, deep.y)};
  }
  const Four margin = group.margins();
  const unsigned done = wanted & ~one_by_one, meet = bits(at_least(margin, height)) & done;
  for (unsigned none = done & ~meet; none != 0; none &= none - 1) {
    group.out(std::countr_zero(none)) = Manifold();
  }
  if (meet == 0) return one_by_one;

  const auto point = [&](const Points& v, Four separation, Four corner) -> Columns {
    const Four below_by = radius + half * separation;
    const Four x = (px + (c * v.x - s * v.y)) - below_by * n.x;
    const Four y = (py + (s * v.x + c * v.y)) - below_by * n.y;
    const Four code = Four::both(2) * corner, edge = Four::both(1);
    return {frame.x + (frame.z * x - frame.w * y), frame.y + (frame.w * x + frame.z * y), separation,
            as_integers(chosen(exchange, joined(code, edge), joined(edge, code)))};
  };
  const Points normal = {flipped(frame.z * n.x - frame.w * n.y, exchange),
                         flipped(frame.w * n.x + frame.z * n.y, exchange)};

  // Lanes that do not count are written elsewhere. Corners come by their numbers.
  Manifold nowhere;
  Manifold* out[4];
  double *to_normal[4], *to_deep[4], *to_end[4];
  for (int lane = 0; lane < 4; ++lane) {
    out[lane] = (meet >> lane & 1) != 0 ? &group.out(lane) : &nowhere;
    to_normal[lane] = &out[lane]->normal.x;
    to_deep[lane] = &out[lane]->points[0].position.x;
    out[lane]->count = 1;
    stats.manifolds += meet >> lane & 1;
  }
  if constexpr (kCorners > 1) {
    // The other end of the edge that faces the half-plane.
    std::int32_t at[4], before[4], rest[4];
    double numbers[4];
    deepest.store(at);
    for (int lane = 0; lane < 4; ++lane) before[lane] = (at[lane] + 3) & 3;
    const auto normals = [&](const std::int32_t* number) {
      return vectors([&](int lane) { return &body[lane]->normals.data()[number[lane]].x; });
    };
    const unsigned take_next = bits(at_least(across(normals(before)), across(normals(at))));
    for (int lane = 0; lane < 4; ++lane) {
      rest[lane] = (take_next >> lane & 1) != 0 ? (at[lane] + 1) & 3 : before[lane];
      numbers[lane] = rest[lane];
    }
    const Points end = corners([&](int lane) { return rest[lane]; });
    const Four end_height = height_of(end);
    const unsigned two = bits(at_least(margin, end_height));
    for (int lane = 0; lane < 4; ++lane) {
      const unsigned several = two >> lane & 1, slot = several & (rest[lane] < at[lane] ? 1u : 0u);
      out[lane]->count = static_cast<int>(1 + several);
      to_deep[lane] = &out[lane]->points[slot].position.x;
      to_end[lane] = &out[lane]->points[slot ^ 1].position.x;
    }
    store_columns(point(end, end_height, row(numbers)), to_end[0], to_end[1], to_end[2], to_end[3]);
  }
  store_points(normal, to_normal[0], to_normal[1], to_normal[2], to_normal[3]);
  store_columns(point(deep, height, deepest), to_deep[0], to_deep[1], to_deep[2], to_deep[3]);
  return one_by_one;
}

/// As `by_fours`, for bodies of one kind.
template <int kCorners>
std::size_t plane_groups(const PairArrays& pairs, const std::uint32_t* list, std::size_t count,
                         std::uint32_t* left, NarrowPhaseStats& stats) {
  return by_fours(list, count, left, [&](const std::uint32_t* at, unsigned wanted) {
    return plane_group<kCorners>({pairs, at}, wanted, stats);
  });
}
