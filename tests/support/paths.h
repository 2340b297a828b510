// SPDX-License-Identifier: MIT
//
// Where the checkout lies. In one source file, so that no other object depends on it (compiler caches are
// shared between checkouts).
#pragma once

namespace skerry {

/// Root of the source tree, absolute, without a trailing slash.
const char* source_dir();

}  // namespace skerry
