// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: four pairs of boxes, or of discs, side by side. Every lane does what `collide`
// does for one pair (search<4, 4>, rank_boxes, probe, edges_of, write_ends), operation by operation.
//
// No include guard: see four_lanes.h.

/// Entries of a batch, one a lane; where there are fewer than four, the last ones repeat another.
struct Group {
  const PairArrays& pairs;
  const std::uint32_t* at;

  const Shape& a(int lane) const { return *pairs.shape_a[at[lane]]; }
  const Shape& b(int lane) const { return *pairs.shape_b[at[lane]]; }
  Manifold& out(int lane) const { return *pairs.manifold[at[lane]]; }
  Columns pose_a() const { return poses(pairs.pose_a); }
  Columns pose_b() const { return poses(pairs.pose_b); }
  Columns poses(std::span<const Transform> p) const {
    return columns(&p[at[0]].p.x, &p[at[1]].p.x, &p[at[2]].p.x, &p[at[3]].p.x);
  }
  Four margins() const {
    const double* const m = pairs.margin.data();
    return Four::gather(m + at[0], m + at[1], m + at[2], m + at[3]);
  }
};

inline Four radius_of(const Shape* const* shape) {
  return Four::gather(&shape[0]->radius, &shape[1]->radius, &shape[2]->radius, &shape[3]->radius);
}

inline Columns two_of(const Vec2* const* list, int from) {
  return columns(&list[0][from].x, &list[1][from].x, &list[2][from].x, &list[3][from].x);
}

/// Axes 0 and 1 of a rectangle, or what belongs to them.
struct Axes {
  Four x[2], y[2];
};

/// The corners of both cores in the frame of the first, by number: 0 to 3 of the first, 4 to 7 of the second.
struct Corners {
  double x[8][4], y[8][4];

  Points at(const std::int32_t* k) const {
    return {Four::gather(&x[k[0]][0], &x[k[1]][1], &x[k[2]][2], &x[k[3]][3]),
            Four::gather(&y[k[0]][0], &y[k[1]][1], &y[k[2]][2], &y[k[3]][3])};
  }
};

/// One axis of each pair with all corners of the other core; see narrow::probe.
struct Probed {
  Four axis;  ///< 0 to 3: edge of the first core, 4 to 7: of the second
  Four nx, ny, separation, support;
};

struct Cores {
  Four c, s;  // rotation of the second in the first's frame
  Four ax[4], ay[4], bx[4], by[4];
  const Vec2* normals[2][4];
  Corners corners;
};

inline Points normals_at(const Cores& cores, const std::int32_t* k) {
  const auto at = [&](int lane) { return &cores.normals[k[lane] >> 2][lane][k[lane] & 3].x; };
  return points(at(0), at(1), at(2), at(3));
}

inline Probed probe(const Cores& cores, Four axis) {
  std::int32_t k[4];
  axis.store(k);
  const Four on_a = below(axis, Four::both(4));
  const Points own = normals_at(cores, k);
  const Four nx = chosen(on_a, own.x, cores.c * own.x - cores.s * own.y);
  const Four ny = chosen(on_a, own.y, cores.s * own.x + cores.c * own.y);
  Four value[4];
  for (int i = 0; i < 4; ++i) {
    value[i] = nx * chosen(on_a, cores.bx[i], cores.ax[i]) + ny * chosen(on_a, cores.by[i], cores.ay[i]);
  }
  const Four low = lesser(lesser(value[0], value[2]), lesser(value[1], value[3]));
  const Points face = cores.corners.at(k);
  // The first that is lowest.
  const Four three = Four::both(3);
  const Four last = greater(greater(at_least(low, value[0]) & three, at_least(low, value[1]) & Four::both(2)),
                            at_least(low, value[2]) & Four::both(1));
  return {axis, nx, ny, low - (nx * face.x + ny * face.y), three - last};
}

/// The first of the edges `near` the best that is as good as the best, exactly. @param lanes  that matter
inline Four first_of_equals(const Cores& cores, const Four* near, unsigned lanes, Four bias) {
  Four exact[8], best = Four::both(-kInfinity);
  for (int k = 0; k < 8; ++k) {
    exact[k] = Four::both(-kInfinity);
    if ((bits(near[k]) & lanes) == 0) continue;
    exact[k] = chosen(near[k], probe(cores, Four::both(k)).separation, exact[k]);
    best = greater(best, exact[k]);
  }
  const Four good = best - bias;
  Four first = Four::both(0);
  for (int k = 7; k >= 0; --k) first = chosen(at_least(exact[k], good), Four::both(k), first);
  return first;
}

/// Codes of two features as one number, and its mirror image.
inline Four joined(Four high, Four low) {
  return high * Four::both(65536) + low;
}

/// Notes how far pairs are apart along an axis that stays where it is in the world, so that a turn of a shape
/// moves its corners by their reach.
struct ApartLanes {
  double slack[4], reach_first[4], reach_second[4];
  std::int32_t axis[4];

  void write(const Group& group, int lane, bool exchange) const {
    SatCache& cache = *group.pairs.cache[group.at[lane]];
    const Transform &a = group.pairs.pose_a[group.at[lane]], &b = group.pairs.pose_b[group.at[lane]];
    cache.state = SatCache::State::Apart;
    cache.axis = (axis[lane] < 4) != exchange ? axis[lane] & 3 : ~(axis[lane] & 3);
    cache.slack = slack[lane];
    cache.reach = exchange ? reach_second[lane] : reach_first[lane];
    cache.reach_b = exchange ? reach_first[lane] : reach_second[lane];
    cache.offset = b.p - a.p;
    cache.turn = a.q;
    cache.turn_b = b.q;
  }
};

/// @param wanted  bit k: lane k counts
/// @param stats   gets the manifolds that were made
/// @return bits of lanes that have to be done one by one
inline unsigned box_group(const Group& group, unsigned wanted, NarrowPhaseStats& stats) {
  const Four zero = Four::both(0);
  const Columns pose_a = group.pose_a(), pose_b = group.pose_b();
  // Who is first: see second_comes_first.
  const Four away_x = pose_b.x - pose_a.x, away_y = pose_b.y - pose_a.y;
  const Four side = away_x + Four::both(kOrderSlope) * away_y;
  const Four exchange = below(side, zero);
  const unsigned exchanged = bits(exchange);
  unsigned doubtful = ~bits(below(magnitude(away_x) + magnitude(away_y), Four::both(kFarAway))) |
                      ~bits(exchange | below(zero, side));
  const Shape *first[4], *second[4];
  const Vec2 *first_v[4], *second_v[4];
  Cores cores;
  for (int lane = 0; lane < 4; ++lane) {
    const Shape &a = group.a(lane), &b = group.b(lane);
    const bool swap = (exchanged >> lane & 1) != 0;
    first[lane] = swap ? &b : &a;
    second[lane] = swap ? &a : &b;
    first_v[lane] = first[lane]->vertices.data();
    second_v[lane] = second[lane]->vertices.data();
    cores.normals[0][lane] = first[lane]->normals.data();
    cores.normals[1][lane] = second[lane]->normals.data();
  }
  const Columns frame = {chosen(exchange, pose_b.x, pose_a.x), chosen(exchange, pose_b.y, pose_a.y),
                         chosen(exchange, pose_b.z, pose_a.z), chosen(exchange, pose_b.w, pose_a.w)};
  const Columns other = {chosen(exchange, pose_a.x, pose_b.x), chosen(exchange, pose_a.y, pose_b.y),
                         chosen(exchange, pose_a.z, pose_b.z), chosen(exchange, pose_a.w, pose_b.w)};
  const Four margin = group.margins(), radius_first = radius_of(first), radius_second = radius_of(second);
  // In the order of a and b, as `collide` adds them.
  const Four limit = (margin + chosen(exchange, radius_second, radius_first)) +
                     chosen(exchange, radius_first, radius_second);

  // Pose of the second in the frame of the first.
  const Four dx = other.x - frame.x, dy = other.y - frame.y;
  const Four px = frame.z * dx + frame.w * dy, py = frame.z * dy - frame.w * dx;
  const Four c = frame.z * other.z + frame.w * other.w, s = frame.z * other.w - frame.w * other.z;
  cores.c = c;
  cores.s = s;

  // Scale of the coordinates, from two corners of each.
  const Columns a01 = two_of(first_v, 0), b01 = two_of(second_v, 0);
  const Four scale =
      (((magnitude(a01.x) + magnitude(a01.z)) + (magnitude(b01.x) + magnitude(b01.z))) + magnitude(px)) +
      (((magnitude(a01.y) + magnitude(a01.w)) + (magnitude(b01.y) + magnitude(b01.w))) + magnitude(py));
  const Four bias = Four::both(kAxisBias) * scale, doubt = Four::both(4) * bias;

  // Separations along all edges from middles and half widths.
  const auto rectangles = [](const Shape* const* shape) {
    const auto at = [&](int lane) { return &shape[lane]->rectangle.middle.x; };
    return columns(at(0), at(1), at(2), at(3));
  };
  const Columns box_a = rectangles(first), box_b = rectangles(second);
  const Columns na = two_of(cores.normals[0], 0), nb = two_of(cores.normals[1], 0);
  const Four mx[2] = {c * nb.x - s * nb.y, c * nb.z - s * nb.w};
  const Four my[2] = {s * nb.x + c * nb.y, s * nb.z + c * nb.w};
  const Four middle_x = (px - box_a.x) + (c * box_b.x - s * box_b.y);
  const Four middle_y = (py - box_a.y) + (s * box_b.x + c * box_b.y);
  const Four along_a[2] = {na.x * middle_x + na.y * middle_y, na.z * middle_x + na.w * middle_y};
  const Four along_b[2] = {mx[0] * middle_x + my[0] * middle_y, mx[1] * middle_x + my[1] * middle_y};
  const Four same = magnitude(na.x * mx[0] + na.y * my[0]), turned = magnitude(na.x * mx[1] + na.y * my[1]);
  const Four reach_a[2] = {box_a.z + (box_b.z * same + box_b.w * turned),
                           box_a.w + (box_b.w * same + box_b.z * turned)};
  const Four reach_b[2] = {box_b.z + (box_a.z * same + box_a.w * turned),
                           box_b.w + (box_a.w * same + box_a.z * turned)};
  const Four separation[8] = {along_a[0] - reach_a[0],          along_a[1] - reach_a[1],
                              negated(along_a[0]) - reach_a[0], negated(along_a[1]) - reach_a[1],
                              negated(along_b[0]) - reach_b[0], negated(along_b[1]) - reach_b[1],
                              along_b[0] - reach_b[0],          along_b[1] - reach_b[1]};
  const Four best =
      greater(greater(greater(separation[0], separation[2]), greater(separation[1], separation[3])),
              greater(greater(separation[4], separation[6]), greater(separation[5], separation[7])));
  const Four apart = below(limit + doubt, best);
  doubtful |= ~bits(apart | at_least(limit - doubt, best));
  // The first and the last edge that are as good as the best; the middle form is right within the doubt only.
  const Four good = best - doubt;
  Four near[8], before_first = zero, last_axis = zero, count = zero;
  for (int k = 0; k < 8; ++k) {
    near[k] = at_least(separation[k], good);
    before_first = greater(before_first, near[k] & Four::both(7 - k));
    last_axis = greater(last_axis, near[k] & Four::both(k));
    count = count + (near[k] & Four::both(1));
  }
  Four first_axis = Four::both(7) - before_first;
  const unsigned parted = bits(apart) & ~doubtful & wanted;
  doubtful |= bits(below(count, Four::both(0.5))) & ~bits(apart);  // not a number
  if (parted != 0) {
    ApartLanes lanes;
    const bool keep = !group.pairs.cache.empty();
    if (keep) {
      const auto reach = [](const Columns& box) {
        return Four::both(1.5) * ((magnitude(box.x) + magnitude(box.y)) + (box.z + box.w));
      };
      (best - doubt).store(lanes.slack);
      reach(box_a).store(lanes.reach_first);
      reach(box_b).store(lanes.reach_second);
      first_axis.store(lanes.axis);
    }
    for (int lane = 0; lane < 4; ++lane) {
      if ((parted >> lane & 1) == 0) continue;
      group.out(lane) = Manifold();
      if (keep) lanes.write(group, lane, (exchanged >> lane & 1) != 0);
    }
  }
  doubtful &= wanted;
  const unsigned meet = wanted & ~parted & ~doubtful;
  // One alone is as fast by itself.
  if ((meet & (meet - 1)) == 0) return doubtful | meet;

  // All corners in the frame of the first.
  const Columns a23 = two_of(first_v, 2), b23 = two_of(second_v, 2);
  const Four bx[4] = {b01.x, b01.z, b23.x, b23.z}, by[4] = {b01.y, b01.w, b23.y, b23.w};
  cores.ax[0] = a01.x, cores.ax[1] = a01.z, cores.ax[2] = a23.x, cores.ax[3] = a23.z;
  cores.ay[0] = a01.y, cores.ay[1] = a01.w, cores.ay[2] = a23.y, cores.ay[3] = a23.w;
  for (int i = 0; i < 4; ++i) {
    cores.bx[i] = (c * bx[i] - s * by[i]) + px;
    cores.by[i] = (s * bx[i] + c * by[i]) + py;
    cores.ax[i].store(cores.corners.x[i]);
    cores.ay[i].store(cores.corners.y[i]);
    cores.bx[i].store(cores.corners.x[i + 4]);
    cores.by[i].store(cores.corners.y[i + 4]);
  }

  // The better of the two edges that are left, exactly; of more than two the first that is as good as the
  // best.
  if (const Four tied = below(Four::both(2.5), count); (bits(tied) & meet) != 0) {
    first_axis = chosen(tied, first_of_equals(cores, near, bits(tied) & meet, bias), first_axis);
    last_axis = chosen(tied, first_axis, last_axis);
  }
  Probed axis = probe(cores, first_axis);
  if ((bits(below(first_axis, last_axis)) & meet) != 0) {
    const Probed rival = probe(cores, last_axis);
    const Four better = below(axis.separation, rival.separation - bias);
    axis = {chosen(better, rival.axis, axis.axis), chosen(better, rival.nx, axis.nx),
            chosen(better, rival.ny, axis.ny), chosen(better, rival.separation, axis.separation),
            chosen(better, rival.support, axis.support)};
  }

  // Reference edge p0 -> p1, incident edge q0 -> q1: see edges_of.
  const Four four = Four::both(4), one = Four::both(1);
  const auto wrapped = [&](Four i) { return without(i, at_least(i, four)); };
  const Four on_a = below(axis.axis, four);
  const Four nx = axis.nx, ny = axis.ny;
  const Four inc_nx = chosen(on_a, c * nx + s * ny, nx), inc_ny = chosen(on_a, c * ny - s * nx, ny);
  std::int32_t edge[4], support[4];
  axis.axis.store(edge);
  axis.support.store(support);
  std::int32_t ref_end[4], inc_support[4], inc_before[4];
  for (int lane = 0; lane < 4; ++lane) {
    const std::int32_t core = edge[lane] & 4, inc = core ^ 4;
    ref_end[lane] = core | ((edge[lane] + 1) & 3);
    inc_support[lane] = inc | support[lane];
    inc_before[lane] = inc | ((support[lane] + 3) & 3);
  }
  const Points n_before = normals_at(cores, inc_before), n_support = normals_at(cores, inc_support);
  const Four take_before =
      below(inc_nx * n_before.x + inc_ny * n_before.y, inc_nx * n_support.x + inc_ny * n_support.y);
  const unsigned taken = bits(take_before);
  std::int32_t inc_start[4], inc_end[4];
  for (int lane = 0; lane < 4; ++lane) {
    const bool take = (taken >> lane & 1) != 0;
    const std::int32_t inc = inc_support[lane] & 4;
    inc_start[lane] = take ? inc_before[lane] : inc_support[lane];
    inc_end[lane] = inc | ((inc_start[lane] + 1) & 3);
  }
  const Points p0 = cores.corners.at(edge), p1 = cores.corners.at(ref_end);
  const Points q0 = cores.corners.at(inc_start), q1 = cores.corners.at(inc_end);
  const Four tx = negated(ny), ty = nx;
  const Four base = nx * p0.x + ny * p0.y;
  const Four len = tx * (p1.x - p0.x) + ty * (p1.y - p0.y);
  const Four x0 = tx * (q0.x - p0.x) + ty * (q0.y - p0.y), x1 = tx * (q1.x - p0.x) + ty * (q1.y - p0.y);
  const Four y0 = (nx * q0.x + ny * q0.y) - base, y1 = (nx * q1.x + ny * q1.y) - base;
  const Four radii = radius_first + radius_second, reported = margin + radii;
  const Four radius_ref = chosen(on_a, radius_first, radius_second);
  const Four radius_inc = chosen(on_a, radius_second, radius_first);
  const Four from_ref = Four::both(0.5) * (radius_ref - radius_inc);
  const Four noise = Four::both(kNoise) * scale;

  // Left to `collide`: corners or another edge that are closer, although the edges overlap.
  const Four overlap = lesser(x0, len) - greater(x1, zero);
  const Four touching = at_least(axis.separation, negated(noise));
  const Four x = chosen(take_before, x1, x0), beside = below(x, zero) | below(len, x);
  if (const unsigned maybe = bits(touching & beside) & meet; maybe != 0) {
    const Four at_start = below(x, zero);
    const Four corner_x = chosen(at_start, p0.x, p1.x), corner_y = chosen(at_start, p0.y, p1.y);
    const Four deep_x = chosen(take_before, q1.x, q0.x), deep_y = chosen(take_before, q1.y, q0.y);
    const Four rest_x = chosen(take_before, q0.x, q1.x), rest_y = chosen(take_before, q0.y, q1.y);
    const Four ahead = (rest_x - deep_x) * (corner_x - deep_x) + (rest_y - deep_y) * (corner_y - deep_y);
    const Four tilted = below(Four::both(0.1) * noise, magnitude(y0 - y1));
    doubtful |= maybe & (bits(at_least(zero, ahead)) | bits(tilted));
  }
  // Lanes with one point, between corners or on the edge.
  const Four label = Four::both(kCornerOnCorner) * lesser(x0 - x1, len);
  const Four several = below(greater(noise, label), overlap), disjoint = below(x0, zero) | below(len, x1);
  const unsigned single = ~bits(several) & meet;
  doubtful = (doubtful & ~(single & bits(disjoint))) | (single & bits(without(touching & beside, disjoint)));

  // Both ends of the contact segment: see write_ends.
  const Four slope = (y0 - y1) / (x0 - x1), over_start = x1, over_end = len - x0;
  const Four half = Four::both(0.5);
  struct End {
    Four inside, both, keep, x, y, separation;
  };
  const auto end_of = [&](Four over, Four height, Four rise, const Points& inc, const Points& ref) {
    End end;
    end.inside = at_least(over, zero);
    end.both = at_least(label, magnitude(over));
    const Four y = height + rise * lesser(over, zero);
    end.keep = at_least(reported, y);
    const Four offset = from_ref + chosen(end.inside, negated(half), half) * y;
    const Four local_x = chosen(end.inside, inc.x, ref.x) + offset * nx;
    const Four local_y = chosen(end.inside, inc.y, ref.y) + offset * ny;
    end.x = frame.x + (frame.z * local_x - frame.w * local_y);
    end.y = frame.y + (frame.w * local_x + frame.z * local_y);
    end.separation = y - radii;
    return end;
  };
  const End start = end_of(over_start, y1, negated(slope), q1, p0), end = end_of(over_end, y0, slope, q0, p1);

  // Features, in numbers that a double holds exactly. A corner of the reference edge unless only the other
  // core has one here, and the other way round.
  const Four i0 = axis.axis - without(four, on_a), i1 = wrapped(i0 + one);
  const Four j0 = chosen(take_before, axis.support - one, axis.support);
  const Four j_start = chosen(below(j0, zero), Four::both(3), j0), j_end = wrapped(j_start + one);
  const auto corner = [](Four i) { return i + i; };
  const Four ref_edge = corner(i0) + one, inc_edge = corner(j_start) + one;
  const Four ref_at_start = chosen(without(start.inside, start.both), ref_edge, corner(i0));
  const Four inc_at_start = chosen(start.inside | start.both, corner(j_end), inc_edge);
  const Four ref_at_end = chosen(without(end.inside, end.both), ref_edge, corner(i1));
  const Four inc_at_end = chosen(end.inside | end.both, corner(j_start), inc_edge);
  const Four start_plain = joined(ref_at_start, inc_at_start),
             start_mirrored = joined(inc_at_start, ref_at_start);
  const Four end_plain = joined(ref_at_end, inc_at_end), end_mirrored = joined(inc_at_end, ref_at_end);
  // See in_order.
  const Four key_start = joined(lesser(ref_at_start, inc_at_start), greater(ref_at_start, inc_at_start));
  const Four key_end = joined(lesser(ref_at_end, inc_at_end), greater(ref_at_end, inc_at_end));
  const Four ordered = below(key_start, key_end) |
                       (at_least(key_end, key_start) & at_least(chosen(on_a, end_plain, end_mirrored),
                                                                chosen(on_a, start_plain, start_mirrored)));
  const Four start_second = without(end.keep, start.keep & ordered);
  const Four plain = on_a ^ exchange;
  Columns start_rows = {start.x, start.y, start.separation,
                        as_integers(chosen(plain, start_plain, start_mirrored))};
  const Columns end_rows = {end.x, end.y, end.separation,
                            as_integers(chosen(plain, end_plain, end_mirrored))};
  const Four back = without(Four::both(-0.0), on_a);
  Four out_nx = flipped(nx, back), out_ny = flipped(ny, back), single_kept = zero;
  if ((single & ~doubtful) != 0) {
    // See clip_apart and write_single.
    const Four corners = touching & disjoint, at_start = below(x0, zero);
    const Four corner_x = chosen(at_start, p0.x, p1.x), corner_y = chosen(at_start, p0.y, p1.y);
    const Four to0_x = q0.x - corner_x, to0_y = q0.y - corner_y;
    const Four to1_x = q1.x - corner_x, to1_y = q1.y - corner_y;
    const Four square0 = to0_x * to0_x + to0_y * to0_y, square1 = to1_x * to1_x + to1_y * to1_y;
    const Four aside0 = y0 + greater(zero, x0 - len), aside1 = y1 + greater(zero, negated(x1));
    const Four take_q0 = chosen(corners, below(square0, square1), below(aside0, aside1));
    const Four gap_x = chosen(take_q0, to0_x, to1_x), gap_y = chosen(take_q0, to0_y, to1_y);
    const Four distance = root(gap_x * gap_x + gap_y * gap_y);
    const Four height = chosen(take_q0, y0, y1), along_gap = corners & below(noise, distance);
    const Four n_x = chosen(along_gap, gap_x / distance, nx), n_y = chosen(along_gap, gap_y / distance, ny);
    const Four gap = chosen(along_gap, distance, height), shift = half * gap;
    const Four offset = chosen(corners, shift + from_ref, from_ref - shift);
    const Four local_x = chosen(corners, corner_x, chosen(take_q0, q0.x, q1.x)) + offset * n_x;
    const Four local_y = chosen(corners, corner_y, chosen(take_q0, q0.y, q1.y)) + offset * n_y;
    const Four at = chosen(take_q0, x0, x1), near_end = Four::both(kCornerOnCorner) * len;
    const Four one_corner = chosen(at_least(near_end, magnitude(at)), corner(i0),
                                   chosen(at_least(near_end, magnitude(at - len)), corner(i1), ref_edge));
    const Four ref_code = chosen(corners, corner(chosen(at_start, i0, i1)), one_corner);
    const Four inc_code = corner(chosen(take_q0, j_start, j_end));
    const Four code = chosen(plain, joined(ref_code, inc_code), joined(inc_code, ref_code));
    single_kept = without(at_least(reported, chosen(corners, distance, height)), several);
    const auto take = [&](Four& row, Four one_point) { row = chosen(several, row, one_point); };
    take(start_rows.x, frame.x + (frame.z * local_x - frame.w * local_y));
    take(start_rows.y, frame.y + (frame.w * local_x + frame.z * local_y));
    take(start_rows.z, gap - radii);
    take(start_rows.w, as_integers(code));
    take(out_nx, flipped(n_x, back));
    take(out_ny, flipped(n_y, back));
  }
  const Points normal = {flipped(frame.z * out_nx - frame.w * out_ny, exchange),
                         flipped(frame.w * out_nx + frame.z * out_ny, exchange)};

  // Lanes that do not count are written elsewhere.
  const unsigned done = meet & ~doubtful;
  const unsigned swapped = bits(start_second & several);
  const unsigned keep_start = bits(chosen(several, start.keep, single_kept));
  const unsigned keep_end = bits(end.keep & several);
  Manifold nowhere;
  Manifold* out[4];
  double *to_normal[4], *to_start[4], *to_end[4];
  for (int lane = 0; lane < 4; ++lane) {
    out[lane] = (done >> lane & 1) != 0 ? &group.out(lane) : &nowhere;
    const unsigned slot = swapped >> lane & 1;
    to_normal[lane] = &out[lane]->normal.x;
    to_start[lane] = &out[lane]->points[slot].position.x;
    to_end[lane] = &out[lane]->points[slot ^ 1].position.x;
    out[lane]->count = static_cast<int>((keep_start >> lane & 1) + (keep_end >> lane & 1));
    stats.manifolds += (done & (keep_start | keep_end)) >> lane & 1;
  }
  store_points(normal, to_normal[0], to_normal[1], to_normal[2], to_normal[3]);
  store_columns(start_rows, to_start[0], to_start[1], to_start[2], to_start[3]);
  store_columns(end_rows, to_end[0], to_end[1], to_end[2], to_end[3]);
  for (unsigned none = done & single & ~keep_start; none != 0; none &= none - 1) {
    group.out(std::countr_zero(none)) = Manifold();
  }
  return doubtful;
}

/// Four neighbouring entries of discs, from `i` on: see `discs` in collide.cpp. Result as for box_group.
inline unsigned disc_group(const PairArrays& pairs, std::size_t i, NarrowPhaseStats& stats) {
  const Shape* const* a = pairs.shape_a.data() + i;
  const Shape* const* b = pairs.shape_b.data() + i;
  bool discs = true;
  for (int lane = 0; lane < 4; ++lane)
    discs &= a[lane]->kind == ShapeKind::Disc && b[lane]->kind == ShapeKind::Disc;
  if (!discs) return 15;
  const auto centres = [](const Shape* const* shape) {
    const auto at = [&](int lane) { return &shape[lane]->vertices.data()->x; };
    return points(at(0), at(1), at(2), at(3));
  };
  const auto poses = [](const Transform* p) { return columns(&p[0].p.x, &p[1].p.x, &p[2].p.x, &p[3].p.x); };
  const Columns pose_a = poses(pairs.pose_a.data() + i), pose_b = poses(pairs.pose_b.data() + i);
  const Points own_a = centres(a), own_b = centres(b);
  const Four ax = own_a.x * pose_a.z + own_a.y * negated(pose_a.w);
  const Four ay = own_a.x * pose_a.w + own_a.y * pose_a.z;
  const Four bx = own_b.x * pose_b.z + own_b.y * negated(pose_b.w);
  const Four by = own_b.x * pose_b.w + own_b.y * pose_b.z;
  const Four dx = (pose_b.x - pose_a.x) + (bx - ax), dy = (pose_b.y - pose_a.y) + (by - ay);
  const Four radius_a = radius_of(a), radius_b = radius_of(b);
  const double* const m = pairs.margin.data() + i;
  const Four radii = radius_a + radius_b, reach = radii + Four::gather(m, m + 1, m + 2, m + 3);
  const Four square = dx * dx + dy * dy;
  const unsigned near = bits(at_least(reach * reach, square));
  const Four distance = root(square), half = Four::both(0.5);
  // Discs at one place have no direction.
  const unsigned one_by_one = near & ~bits(below(Four::both(kNoDirection), distance));
  const Points normal = {dx / distance, dy / distance};
  const Four off = half * (radius_a - radius_b);
  const Columns rows = {half * ((pose_a.x + ax) + (pose_b.x + bx)) + off * normal.x,
                        half * ((pose_a.y + ay) + (pose_b.y + by)) + off * normal.y, distance - radii,
                        Four::both(0)};
  Manifold* const* out = pairs.manifold.data() + i;
  Manifold nowhere;
  Manifold* to[4] = {out[0], out[1], out[2], out[3]};
  const unsigned done = near & ~one_by_one;
  if (done != 15) {
    for (int lane = 0; lane < 4; ++lane) {
      if ((done >> lane & 1) != 0) continue;
      if ((one_by_one >> lane & 1) == 0) *out[lane] = Manifold();
      to[lane] = &nowhere;
    }
  }
  store_points(normal, &to[0]->normal.x, &to[1]->normal.x, &to[2]->normal.x, &to[3]->normal.x);
  store_columns(rows, &to[0]->points[0].position.x, &to[1]->points[0].position.x,
                &to[2]->points[0].position.x, &to[3]->points[0].position.x);
  for (int lane = 0; lane < 4; ++lane) to[lane]->count = 1;
  stats.manifolds += (done & 1) + (done >> 1 & 1) + (done >> 2 & 1) + (done >> 3);
  return one_by_one;
}

/// The next entries of a list, one a lane. @return bits of the lanes that count
inline unsigned next_lanes(const std::uint32_t* list, std::size_t count, std::uint32_t* at) {
  for (std::size_t lane = 0; lane < 4; ++lane) at[lane] = list[lane < count ? lane : 0];
  return count < 4 ? (1u << count) - 1 : 15u;
}

/// Goes through a list of entries, four at a time. @param left  gets the entries that have to be done one by
/// one
/// @param one_group  of entries and the bits of lanes that count; gives those that have to be done one by one
/// @return how many those are
template <class OneGroup>
[[gnu::always_inline]] inline std::size_t by_fours(const std::uint32_t* list, std::size_t count,
                                                   std::uint32_t* left, OneGroup one_group) {
  std::size_t rest = 0;
  for (std::size_t i = 0; i < count; i += 4) {
    // One alone is as fast by itself.
    if (i + 1 == count) {
      left[rest++] = list[i];
      break;
    }
    std::uint32_t at[4];
    const unsigned wanted = next_lanes(list + i, count - i, at);
    for (unsigned bad = one_group(at, wanted); bad != 0; bad &= bad - 1) {
      left[rest++] = at[std::countr_zero(bad)];
    }
  }
  return rest;
}

/// As `by_fours`.
inline std::size_t box_groups(const PairArrays& pairs, const std::uint32_t* list, std::size_t count,
                              std::uint32_t* left, NarrowPhaseStats& stats) {
  return by_fours(list, count, left, [&](const std::uint32_t* at, unsigned wanted) {
    return box_group({pairs, at}, wanted, stats);
  });
}

/// Goes through neighbouring entries, from `from` to before `to`. Result as for box_groups.
inline std::size_t disc_groups(const PairArrays& pairs, std::size_t from, std::size_t to, std::uint32_t* left,
                               NarrowPhaseStats& stats) {
  std::size_t rest = 0, i = from;
  for (; i + 4 <= to; i += 4) {
    for (unsigned bad = disc_group(pairs, i, stats); bad != 0; bad &= bad - 1) {
      left[rest++] = static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(std::countr_zero(bad));
    }
  }
  for (; i < to; ++i) left[rest++] = static_cast<std::uint32_t>(i);
  return rest;
}
