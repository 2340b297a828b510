// SPDX-License-Identifier: MIT
#include "physics/ledger.h"

#include <algorithm>

#include "physics/hash.h"

namespace skerry {
namespace {

constexpr std::size_t kBlock = 64;  // bodies; a step that moves one body adds up 64, and 1/64 of the blocks
constexpr std::size_t kBlocksAPiece = 16;  // that a thread takes at a time

}  // namespace

void Ledger::add_up(const BodyArrays& b, Vec2 gravity, std::size_t block, Block& out) {
  out = {};
  out.stale = false;
  BodySums& s = out.sums;
  Fnv1a hash;
  const std::size_t end = std::min(b.size(), (block + 1) * kBlock);
  for (std::size_t i = block * kBlock; i < end; ++i) {
    if (!b.alive[i]) continue;
    out.any = true;
    hash.add(static_cast<std::uint64_t>(i));
    for (const double value :
         {b.position[i].x, b.position[i].y, b.angle[i], b.velocity[i].x, b.velocity[i].y, b.omega[i]}) {
      hash.add(value);
    }
    if (b.type[i] != BodyType::Dynamic) continue;
    s.kinetic += 0.5 * (b.mass[i] * length_squared(b.velocity[i]) + b.inertia[i] * b.omega[i] * b.omega[i]);
    s.potential -= b.mass[i] * b.gravity_scale[i] * dot(gravity, b.position[i]);
    s.momentum += b.mass[i] * b.velocity[i];
    s.angular += b.mass[i] * cross(b.position[i], b.velocity[i]) + b.inertia[i] * b.omega[i];
  }
  s.hash = hash.value();
}

namespace {

void add(const BodySums& block, BodySums& total, Fnv1a& hash) {
  total.kinetic += block.kinetic;
  total.potential += block.potential;
  total.momentum += block.momentum;
  total.angular += block.angular;
  hash.add(block.hash);
}

}  // namespace

void Ledger::mark(std::uint32_t body) {
  const std::size_t block = body / kBlock;
  if (block < blocks_.size()) blocks_[block].stale = true;
}

BodySums Ledger::total(const BodyArrays& bodies, Vec2 gravity, ThreadPool* threads) {
  blocks_.resize((bodies.size() + kBlock - 1) / kBlock);
  const auto stale = std::count_if(blocks_.begin(), blocks_.end(), [](const Block& b) { return b.stale; });
  const bool many = static_cast<std::size_t>(stale) > kBlocksAPiece;
  share(many ? threads : nullptr, blocks_.size(), kBlocksAPiece, [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i)
      if (blocks_[i].stale) add_up(bodies, gravity, i, blocks_[i]);
  });
  BodySums total;
  Fnv1a hash;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (blocks_[i].any) add(blocks_[i].sums, total, hash);
  }
  total.hash = hash.value();
  return total;
}

BodySums sum_bodies(const BodyArrays& bodies, Vec2 gravity) {
  BodySums total;
  Fnv1a hash;
  for (std::size_t i = 0; i < (bodies.size() + kBlock - 1) / kBlock; ++i) {
    Ledger::Block block;
    Ledger::add_up(bodies, gravity, i, block);
    if (block.any) add(block.sums, total, hash);
  }
  total.hash = hash.value();
  return total;
}

}  // namespace skerry
