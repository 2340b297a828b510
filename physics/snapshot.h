// SPDX-License-Identifier: MIT
//
// The whole state of a world as bytes: stepping goes on from them as if nothing had happened, bit by bit.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "physics/archive.h"
#include "physics/world.h"

namespace skerry {

/// Everything that later steps depend on: settings, bodies, shapes, joints, contacts with their impulses, and
/// what solvers keep of islands (states, factors). A world that is loaded from these bytes makes the same
/// steps, with the same state hash and the same counts in its reports, as the one that was saved; measured
/// times differ, and a solver with a time budget may.
///
/// The format is versioned, little-endian, and has a checksum for each part.
std::vector<std::byte> save_snapshot(const World& world);

/// A world from the bytes of `save_snapshot`. Its report is that of the last step, without measured times and
/// without the systems that an observer had asked for.
/// @throws ArchiveError for bytes that are no snapshot, of another version, cut off or damaged; the message
/// has the offset. The checksums find damage, not forgery: load only files that you would run.
World load_snapshot(std::span<const std::byte> bytes);

}  // namespace skerry
