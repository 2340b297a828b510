// SPDX-License-Identifier: MIT
#pragma once

namespace skerry {

/// Number of the bits that worlds take: raised by every change after which the same calls lead to other
/// states than before, be it by rounding only. Recordings and expected hashes of another number are not
/// comparable. tests/trajectory/trajectories.txt holds what this number stands for.
inline constexpr int kTrajectoryVersion = 116;

}  // namespace skerry
