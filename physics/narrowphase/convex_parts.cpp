// SPDX-License-Identifier: MIT
//
// Splits a simple polygon into convex parts: ears are cut off [Meisters 1975; ElGindy, Everett, Toussaint
// 1993], then diagonals that are not needed are taken out again [Hertel, Mehlhorn 1983]. At most four times
// as many parts as the best possible split.
#include <algorithm>
#include <stdexcept>
#include <string>

#include "physics/shape.h"

namespace skerry {
namespace {

using Outline = std::vector<Vec2>;
using Part = std::vector<std::size_t>;  // numbers of corners, counter-clockwise

constexpr std::size_t kMaxCorners = 64;
// As make_polygon's: corners that turn by less count as lying on a line.
constexpr double kCollinearSine = 1.0e-12;

[[noreturn]] void refuse_crossing(std::size_t i, std::size_t j) {
  std::string message("convex_parts: the outline crosses or touches itself between the edges from corner ");
  message.append(std::to_string(i)).append(" and from corner ").append(std::to_string(j));
  throw std::invalid_argument(message);
}

/// Twice the area of (a, b, c) in a wider type, so that the sign is right for all but the closest calls.
long double orientation(Vec2 a, Vec2 b, Vec2 c) {
  const long double bx = static_cast<long double>(b.x) - a.x, by = static_cast<long double>(b.y) - a.y;
  const long double cx = static_cast<long double>(c.x) - a.x, cy = static_cast<long double>(c.y) - a.y;
  return bx * cy - by * cx;
}

double turn_sine(Vec2 before, Vec2 corner, Vec2 after) {
  const double lengths = length(corner - before) * length(after - corner);
  return lengths > 0 ? static_cast<double>(orientation(before, corner, after)) / lengths : 0;
}

bool in_box(Vec2 p, Vec2 a, Vec2 b) {
  return std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
         p.y <= std::max(a.y, b.y);
}

bool segments_touch(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  const long double abc = orientation(a, b, c), abd = orientation(a, b, d);
  const long double cda = orientation(c, d, a), cdb = orientation(c, d, b);
  if (((abc > 0) != (abd > 0)) && ((cda > 0) != (cdb > 0)) && abc != 0 && abd != 0 && cda != 0 && cdb != 0)
    return true;
  return (abc == 0 && in_box(c, a, b)) || (abd == 0 && in_box(d, a, b)) || (cda == 0 && in_box(a, c, d)) ||
         (cdb == 0 && in_box(b, c, d));
}

void require_simple(std::span<const Vec2> outline) {
  const std::size_t n = outline.size();
  if (n < 3) {
    std::string message("convex_parts: at least 3 corners expected, got ");
    throw std::invalid_argument(message.append(std::to_string(n)));
  }
  for (std::size_t i = 0; i < n; ++i) {
    const bool usable = std::abs(outline[i].x) <= 1e12 && std::abs(outline[i].y) <= 1e12;
    if (!usable) {
      std::string message("convex_parts: corner ");
      throw std::invalid_argument(
          message.append(std::to_string(i)).append(" must be finite and within 1e12 m"));
    }
    if (outline[i] == outline[(i + 1) % n]) {
      std::string message("convex_parts: corner ");
      throw std::invalid_argument(
          message.append(std::to_string((i + 1) % n)).append(" repeats the one before"));
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = outline[i], b = outline[(i + 1) % n], c = outline[(i + 2) % n];
    // Neighbours share a corner; they may only overlap by folding back.
    if (orientation(a, b, c) == 0 && dot(b - a, c - b) < 0) refuse_crossing(i, (i + 1) % n);
    for (std::size_t j = i + 2; j < n; ++j) {
      if ((j + 1) % n == i) continue;
      if (segments_touch(a, b, outline[j], outline[(j + 1) % n])) refuse_crossing(i, j);
    }
  }
}

/// Takes out corners on a line with their neighbours, one after another.
void drop_collinear(const std::vector<Vec2>& points, Part& part) {
  for (std::size_t i = 0; i < part.size() && part.size() > 2;) {
    const std::size_t n = part.size();
    const double sine = turn_sine(points[part[(i + n - 1) % n]], points[part[i]], points[part[(i + 1) % n]]);
    if (std::abs(sine) > kCollinearSine) {
      ++i;
      continue;
    }
    part.erase(part.begin() + static_cast<std::ptrdiff_t>(i));
    i = i > 0 ? i - 1 : 0;
  }
}

bool is_ear(const std::vector<Vec2>& points, const Part& ring, std::size_t i) {
  const std::size_t n = ring.size();
  const std::size_t before = ring[(i + n - 1) % n], corner = ring[i], after = ring[(i + 1) % n];
  const Vec2 a = points[before], b = points[corner], c = points[after];
  if (!(orientation(a, b, c) > 0)) return false;
  for (const std::size_t k : ring) {
    if (k == before || k == corner || k == after) continue;
    const Vec2 p = points[k];
    if (orientation(a, b, p) >= 0 && orientation(b, c, p) >= 0 && orientation(c, a, p) >= 0) return false;
  }
  return true;
}

std::vector<Part> triangles(const std::vector<Vec2>& points, Part ring) {
  std::vector<Part> parts;
  while (ring.size() > 3) {
    const std::size_t n = ring.size();
    // Of all ears the one with the widest corner angle there is left: it makes fewer slivers. Where rounding
    // hides all ears, the corner that turns most to the left is cut.
    std::size_t best = n, fallback = 0;
    double best_quality = -1, best_turn = -2;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 a = points[ring[(i + n - 1) % n]], b = points[ring[i]], c = points[ring[(i + 1) % n]];
      const double turn = turn_sine(a, b, c);
      if (turn > best_turn) {
        best_turn = turn;
        fallback = i;
      }
      if (turn <= best_quality) continue;
      const double quality = std::min({turn, turn_sine(b, c, a), turn_sine(c, a, b)});
      if (quality > best_quality && is_ear(points, ring, i)) {
        best_quality = quality;
        best = i;
      }
    }
    const std::size_t i = best < n ? best : fallback;
    parts.push_back({ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
    // A cut may leave corners on a line; they stay on the neighbours' edges.
    drop_collinear(points, ring);
  }
  if (ring.size() == 3) parts.push_back(ring);
  return parts;
}

/// Joins `q` to `p` across their common edge if the result is convex; true if it did.
bool join(const std::vector<Vec2>& points, Part& p, const Part& q) {
  const std::size_t n = p.size(), m = q.size();
  if (n + m - 2 > kMaxCorners) return false;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t from = p[i], to = p[(i + 1) % n];
    for (std::size_t j = 0; j < m; ++j) {
      if (q[j] != to || q[(j + 1) % m] != from) continue;
      const double turn_at_from = turn_sine(points[p[(i + n - 1) % n]], points[from], points[q[(j + 2) % m]]);
      const double turn_at_to = turn_sine(points[q[(j + m - 1) % m]], points[to], points[p[(i + 2) % n]]);
      if (turn_at_from < 0 || turn_at_to < 0) return false;
      Part joined;
      for (std::size_t k = 0; k < n; ++k) joined.push_back(p[(i + 1 + k) % n]);  // to ... from
      for (std::size_t k = 2; k < m; ++k) joined.push_back(q[(j + k) % m]);      // after from ... before to
      p = std::move(joined);
      return true;
    }
  }
  return false;
}

}  // namespace

std::vector<std::vector<Vec2>> convex_parts(std::span<const Vec2> outline) {
  require_simple(outline);
  std::vector<Vec2> points(outline.begin(), outline.end());
  long double twice_area = 0;
  for (std::size_t i = 1; i + 1 < points.size(); ++i)
    twice_area += orientation(points[0], points[i], points[i + 1]);
  if (twice_area < 0) std::reverse(points.begin(), points.end());
  Part ring(points.size());
  for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = i;
  drop_collinear(points, ring);
  if (ring.size() < 3) throw std::invalid_argument("convex_parts: the outline has no area");

  std::vector<Part> parts = triangles(points, ring);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = i + 1; j < parts.size();) {
      if (join(points, parts[i], parts[j])) {
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(j));
        j = i + 1;  // the grown part has new neighbours
      } else {
        ++j;
      }
    }
  }
  std::vector<std::vector<Vec2>> out;
  for (Part& part : parts) {
    drop_collinear(points, part);
    if (part.size() < 3) continue;
    out.emplace_back();
    for (const std::size_t i : part) out.back().push_back(points[i]);
  }
  return out;
}

}  // namespace skerry
