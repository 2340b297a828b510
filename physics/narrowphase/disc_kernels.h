// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: four rectangles, each against a disc, side by side. Every lane does what `collide`
// does for one pair (hull_and_disc in meet.cpp), operation by operation.
//
// No include guard: see four_lanes.h.

/// @param wanted  bit k: lane k counts
/// @return bits of lanes that have to be done one by one
inline unsigned box_disc_group(const Group& group, unsigned wanted, NarrowPhaseStats& stats) {
  const Four zero = Four::both(0), half = Four::both(0.5);
  const Columns pose_a = group.pose_a(), pose_b = group.pose_b();
  const Shape *box[4], *disc[4];
  const Vec2 *corners[4], *normals[4];
  double seconds[4];
  for (int lane = 0; lane < 4; ++lane) {
    const Shape &a = group.a(lane), &b = group.b(lane);
    const bool second = a.kind == ShapeKind::Disc;
    box[lane] = second ? &b : &a;
    disc[lane] = second ? &a : &b;
    corners[lane] = box[lane]->vertices.data();
    normals[lane] = box[lane]->normals.data();
    seconds[lane] = second ? 1 : 0;
  }
  const Four exchange = below(zero, Four::gather(seconds, seconds + 1, seconds + 2, seconds + 3));
  const Columns frame = {chosen(exchange, pose_b.x, pose_a.x), chosen(exchange, pose_b.y, pose_a.y),
                         chosen(exchange, pose_b.z, pose_a.z), chosen(exchange, pose_b.w, pose_a.w)};
  const Columns other = {chosen(exchange, pose_a.x, pose_b.x), chosen(exchange, pose_a.y, pose_b.y),
                         chosen(exchange, pose_a.z, pose_b.z), chosen(exchange, pose_a.w, pose_b.w)};

  // The disc's centre in the frame of the rectangle.
  const Four dx = other.x - frame.x, dy = other.y - frame.y;
  const Four px = frame.z * dx + frame.w * dy, py = frame.z * dy - frame.w * dx;
  const Four turn_c = frame.z * other.z + frame.w * other.w, turn_s = frame.z * other.w - frame.w * other.z;
  const unsigned one_by_one = wanted & ~bits(below(magnitude(dx) + magnitude(dy), Four::both(kFarAway)));
  const auto centre_at = [&](int lane) { return &disc[lane]->vertices.data()->x; };
  const Points own = points(centre_at(0), centre_at(1), centre_at(2), centre_at(3));
  const Four cx = px + (turn_c * own.x - turn_s * own.y), cy = py + (turn_s * own.x + turn_c * own.y);
  const Four radius_box = radius_of(box), radius_disc = radius_of(disc);
  const Four radii = radius_box + radius_disc, limit = radii + group.margins();

  // The edge whose line is farthest; the first one where several are.
  const Columns v01 = two_of(corners, 0), v23 = two_of(corners, 2);
  const Columns n01 = two_of(normals, 0), n23 = two_of(normals, 2);
  const Points v[4] = {{v01.x, v01.y}, {v01.z, v01.w}, {v23.x, v23.y}, {v23.z, v23.w}};
  const Points n[4] = {{n01.x, n01.y}, {n01.z, n01.w}, {n23.x, n23.y}, {n23.z, n23.w}};
  const auto sum_of = [](const Points& p) { return magnitude(p.x) + magnitude(p.y); };
  const auto choose = [](Four mask, const Points& p, const Points& q) {
    return Points{chosen(mask, p.x, q.x), chosen(mask, p.y, q.y)};
  };
  Four height = Four::both(-kInfinity), bias = zero, edge = zero, apart = zero;
  Points v0 = v[0], v1 = v[1], normal = n[0];
  for (int i = 0; i < 4; ++i) {
    const Four value = n[i].x * (cx - v[i].x) + n[i].y * (cy - v[i].y);
    const Four farther = below(height + bias, value);
    apart = apart | below(limit, value);
    height = chosen(farther, value, height);
    edge = chosen(farther, Four::both(i), edge);
    bias = chosen(farther, Four::both(kAxisBias) * sum_of(v[i]), bias);
    v0 = choose(farther, v[i], v0);
    v1 = choose(farther, v[(i + 1) & 3], v1);
    normal = choose(farther, n[i], normal);
  }

  // Beyond an end of the edge the corner is closest.
  const Four noise = Four::both(kNoise) * ((sum_of({cx, cy}) + sum_of(v0)) + sum_of(v1));
  const auto along = [&](const Points& end) {
    return negated(normal.y) * (cx - end.x) + normal.x * (cy - end.y);
  };
  const Four before = below(along(v0), zero), behind = below(zero, along(v1));
  const Four corner = at_least(height, negated(noise)) & (before | behind);
  const Points end = choose(before, v0, v1);
  const Four gap_x = cx - end.x, gap_y = cy - end.y, gap = root(gap_x * gap_x + gap_y * gap_y);
  apart = apart | (corner & below(limit, gap));
  const Four along_gap = corner & below(noise, gap);
  const Four distance = chosen(along_gap, gap, height);
  normal = {chosen(along_gap, gap_x / gap, normal.x), chosen(along_gap, gap_y / gap, normal.y)};

  const unsigned done = wanted & ~one_by_one, meet = done & ~bits(apart);
  for (unsigned none = done & ~meet; none != 0; none &= none - 1) {
    group.out(std::countr_zero(none)) = Manifold();
  }
  if (meet == 0) return one_by_one;

  const Four one = Four::both(1), two = Four::both(2);
  const Four next = without(edge + one, at_least(edge, Four::both(3)));
  const Four code = chosen(corner, two * chosen(before, edge, next), two * edge + one);
  const Four back = half * ((distance - radius_box) + radius_disc);
  const Four x = cx - back * normal.x, y = cy - back * normal.y;
  const Columns point = {frame.x + (frame.z * x - frame.w * y), frame.y + (frame.w * x + frame.z * y),
                         distance - radii,
                         as_integers(chosen(exchange, joined(zero, code), joined(code, zero)))};
  const Points outward = {flipped(frame.z * normal.x - frame.w * normal.y, exchange),
                          flipped(frame.w * normal.x + frame.z * normal.y, exchange)};

  // Lanes that do not count are written elsewhere.
  Manifold nowhere;
  double *to_normal[4], *to_point[4];
  for (int lane = 0; lane < 4; ++lane) {
    Manifold& out = (meet >> lane & 1) != 0 ? group.out(lane) : nowhere;
    to_normal[lane] = &out.normal.x;
    to_point[lane] = &out.points[0].position.x;
    out.count = 1;
    stats.manifolds += meet >> lane & 1;
  }
  store_points(outward, to_normal[0], to_normal[1], to_normal[2], to_normal[3]);
  store_columns(point, to_point[0], to_point[1], to_point[2], to_point[3]);
  return one_by_one;
}

/// As `by_fours`.
inline std::size_t box_disc_groups(const PairArrays& pairs, const std::uint32_t* list, std::size_t count,
                                   std::uint32_t* left, NarrowPhaseStats& stats) {
  return by_fours(list, count, left, [&](const std::uint32_t* at, unsigned wanted) {
    return box_disc_group({pairs, at}, wanted, stats);
  });
}
