// SPDX-License-Identifier: MIT
//
// A session as a file: which demo with which options, what the user did, and every state that followed. It
// can be run again anywhere; the first state that differs is named, with the body and the value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sandbox/window/player.h"

namespace skerry::sandbox {

/// State of a body, bit by bit.
struct RecordedBody {
  std::uint32_t slot = 0;
  double values[6]{};  ///< x, y [m], angle [rad], velocity x, y [m/s], omega [rad/s]

  friend bool operator==(const RecordedBody&, const RecordedBody&) = default;
};

/// A state after a step (the first: before any), as what changed since the one before.
struct RecordedState {
  std::uint64_t hash = 0;
  std::vector<RecordedBody> changed;
  std::vector<std::uint32_t> removed;
};

struct Recording {
  std::string path;               ///< of the script, as it was opened
  std::uint64_t script_hash = 0;  ///< of its text
  DemoOptions options;
  std::vector<UserInput> inputs;
  std::vector<RecordedState> states;

  std::uint64_t steps() const { return states.empty() ? 0 : states.size() - 1; }
};

/// Makes all states of `player` up to its end again, with its inputs, and keeps them. The player stays where
/// it is. @throws ScriptError
Recording record(Player& player);

std::vector<std::byte> save_recording(const Recording& recording);
/// @throws ArchiveError for bytes that are no recording, damaged, or of another version, with the offset
Recording load_recording(std::span<const std::byte> bytes);

/// The first thing that came out differently.
struct Difference {
  std::uint64_t step = 0;
  double time = 0;    ///< [s]
  std::string body;   ///< as people call it
  std::string value;  ///< "x", "omega", ... or "exists"
  double expected = 0, found = 0;

  /// "step 37 (t = 0.616667 s): y of box 3 is 1.5, was 1.25 (0.25 more)".
  std::string text() const;
};

/// Runs the recording again. @param path of the script; empty: as recorded
/// @throws ScriptError
std::optional<Difference> replay(const Recording& recording, const std::string& path = {});

/// `text_hash` of a file's bytes. @throws ScriptError if it cannot be read
std::uint64_t file_hash(const std::string& path);

/// All bytes of a file. @throws ScriptError if it cannot be read
std::vector<std::byte> read_bytes(const std::string& path);
/// Writes a file as a whole or not at all. @throws ScriptError if it cannot be written
void write_bytes(const std::string& path, std::span<const std::byte> bytes);

}  // namespace skerry::sandbox
