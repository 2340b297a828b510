// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/text.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

/// Live shapes among `found` and the loose ones, ascending, without duplicates, that may meet `filter`.
void complete(const WorldState& s, const Filter& filter, std::vector<std::uint32_t>& found) {
  found.insert(found.end(), s.loose_shapes.begin(), s.loose_shapes.end());
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::erase_if(
      found, [&](std::uint32_t i) { return !s.shapes[i].alive || !may_collide(s.shapes[i].filter, filter); });
}

Transform pose_of(const WorldState& s, std::uint32_t shape) {
  return s.bodies.pose(s.shapes[shape].body.index);
}

ShapeId id_of(const WorldState& s, std::uint32_t shape) {
  return {shape, s.shapes[shape].generation};
}

/// Half-planes and chains are no bodies that could overlap each other.
bool comparable(const Shape& a, const Shape& b) {
  const auto endless = [](const Shape& x) {
    return x.kind == ShapeKind::HalfPlane || x.kind == ShapeKind::Chain;
  };
  return !(endless(a) && endless(b));
}

void require_shape(const Shape& shape) {
  if (shape.vertices.empty()) throw std::invalid_argument("shape is empty; use make_disc, make_polygon, ...");
}

/// Squares of directions that are much longer or shorter are no numbers. @return the power of 2 that the
/// direction is to be divided by, 0 where it is a usual one
int exponent_of(Vec2 direction) {
  const double size = std::max(std::abs(direction.x), std::abs(direction.y));
  return size > 1e-100 && size < 1e100 ? 0 : std::ilogb(size);
}

/// The same ray with a direction that is 2^exponent times shorter.
Ray scaled(const Ray& ray, int exponent) {
  return {ray.origin,
          {std::ldexp(ray.direction.x, -exponent), std::ldexp(ray.direction.y, -exponent)},
          std::ldexp(ray.t_max, exponent)};
}

QueryHit hit_of(const WorldState& s, std::uint32_t shape, const RayHit& ray) {
  QueryHit hit;
  hit.shape = id_of(s, shape);
  hit.body = s.shapes[shape].body;
  hit.t = ray.t;
  hit.point = ray.point;
  hit.normal = ray.normal;
  return hit;
}

}  // namespace

std::vector<ShapeId> World::shapes_at(Vec2 point, const Filter& filter) const {
  if (!is_finite(point)) throw std::invalid_argument("point must be finite, got " + to_text(point));
  const WorldState& s = *state_;
  std::vector<std::uint32_t> found;
  s.broad_phase->query(point, found);
  complete(s, filter, found);
  std::vector<ShapeId> shapes;
  for (const std::uint32_t i : found) {
    if (contains(s.shapes[i].shape, pose_of(s, i), point)) shapes.push_back(id_of(s, i));
  }
  return shapes;
}

std::vector<ShapeId> World::shapes_overlapping(const Shape& shape, const Transform& pose,
                                               const Filter& filter) const {
  require_shape(shape);
  const WorldState& s = *state_;
  std::vector<std::uint32_t> found;
  s.broad_phase->query(bounding_box(shape, pose), found);
  complete(s, filter, found);
  std::vector<ShapeId> shapes;
  for (const std::uint32_t i : found) {
    if (comparable(shape, s.shapes[i].shape) && overlaps(shape, pose, s.shapes[i].shape, pose_of(s, i))) {
      shapes.push_back(id_of(s, i));
    }
  }
  return shapes;
}

std::vector<ShapeId> World::shapes_in_box(const Aabb& box, const Filter& filter) const {
  if (!is_finite(box.lower) || !is_finite(box.upper) || box.lower.x > box.upper.x ||
      box.lower.y > box.upper.y) {
    throw std::invalid_argument("box is not finite or inverted: " + to_text(box.lower) + " to " +
                                to_text(box.upper));
  }
  const WorldState& s = *state_;
  std::vector<std::uint32_t> found;
  s.broad_phase->query(box, found);
  complete(s, filter, found);
  std::vector<ShapeId> shapes;
  for (const std::uint32_t i : found) {
    if (overlap(bounding_box(s.shapes[i].shape, pose_of(s, i)), box)) shapes.push_back(id_of(s, i));
  }
  return shapes;
}

std::vector<QueryHit> World::ray_cast_all(const Ray& ray, const Filter& filter) const {
  if (!is_finite(ray.origin) || !is_finite(ray.direction) || ray.direction == Vec2{} || !(ray.t_max >= 0)) {
    throw std::invalid_argument("ray from " + to_text(ray.origin) + " along " + to_text(ray.direction) +
                                " up to " + to_text(ray.t_max) +
                                ": must be finite, with a direction and t_max >= 0");
  }
  const WorldState& s = *state_;
  const int exponent = exponent_of(ray.direction);
  const Ray usual = scaled(ray, exponent);
  std::vector<std::uint32_t> found;
  s.broad_phase->ray_cast(usual, found);
  complete(s, filter, found);
  std::vector<QueryHit> hits;
  for (const std::uint32_t i : found) {
    auto hit = skerry::ray_cast(s.shapes[i].shape, pose_of(s, i), usual);
    if (!hit) continue;
    hit->t = std::min(std::ldexp(hit->t, -exponent), ray.t_max);
    hits.push_back(hit_of(s, i, *hit));
  }
  std::stable_sort(hits.begin(), hits.end(), [](const QueryHit& a, const QueryHit& b) { return a.t < b.t; });
  return hits;
}

std::optional<QueryHit> World::ray_cast(const Ray& ray, const Filter& filter) const {
  const std::vector<QueryHit> hits = ray_cast_all(ray, filter);
  if (hits.empty()) return std::nullopt;
  return hits.front();
}

std::optional<QueryHit> World::shape_cast(const Shape& shape, const Transform& pose, Vec2 translation,
                                          const Filter& filter) const {
  require_shape(shape);
  if (!is_finite(translation))
    throw std::invalid_argument("translation must be finite, got " + to_text(translation));
  const WorldState& s = *state_;
  const Aabb from = bounding_box(shape, pose);
  std::vector<std::uint32_t> found;
  s.broad_phase->query(united(from, {from.lower + translation, from.upper + translation}), found);
  complete(s, filter, found);
  std::optional<QueryHit> first;
  for (const std::uint32_t i : found) {
    if (!comparable(shape, s.shapes[i].shape)) continue;
    const auto hit = skerry::shape_cast(shape, pose, translation, s.shapes[i].shape, pose_of(s, i));
    if (hit && (!first || hit->t < first->t)) first = hit_of(s, i, *hit);
  }
  return first;
}

std::optional<QueryHit> World::closest(Vec2 point, double max_distance, const Filter& filter) const {
  if (!is_finite(point)) throw std::invalid_argument("point must be finite, got " + to_text(point));
  if (!(max_distance >= 0) || !std::isfinite(max_distance)) {
    throw std::invalid_argument("max_distance must be finite and >= 0, got " + to_text(max_distance));
  }
  const WorldState& s = *state_;
  std::vector<std::uint32_t> found;
  s.broad_phase->query(grown({point, point}, max_distance), found);
  complete(s, filter, found);
  std::optional<QueryHit> nearest;
  for (const std::uint32_t i : found) {
    const ClosestPoint candidate = closest_point(s.shapes[i].shape, pose_of(s, i), point);
    if (candidate.distance > max_distance || (nearest && candidate.distance >= nearest->distance)) continue;
    QueryHit hit;
    hit.shape = id_of(s, i);
    hit.body = s.shapes[i].body;
    hit.distance = candidate.distance;
    hit.point = candidate.point;
    hit.normal = candidate.normal;
    nearest = hit;
  }
  return nearest;
}

ClosestPoints World::distance(ShapeId a, ShapeId b) const {
  for (const ShapeId id : {a, b}) {
    if (!alive(id))
      throw std::invalid_argument("shape " + std::to_string(id.index) + " does not exist (any more)");
  }
  const WorldState& s = *state_;
  return skerry::distance(s.shapes[a.index].shape, pose_of(s, a.index), s.shapes[b.index].shape,
                          pose_of(s, b.index));
}

}  // namespace skerry
