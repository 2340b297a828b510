// SPDX-License-Identifier: MIT
//
// What all views point at: a cell of the matrix, a contact, a body, an island. Set by the mouse in the
// window, by `--select` and by `highlight{...}` in a script.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "physics/handle.h"
#include "physics/world.h"

namespace skerry::sandbox {

/// Negative numbers and invalid bodies: nothing is selected. Rows and columns count from 0 here and from 1
/// for people.
struct Selection {
  int row = -1;     ///< of the matrix that is shown
  int column = -1;  ///< with `row`: a cell
  BodyId body;
  BodyId other;           ///< with `body`: their contacts
  int island = -1;        ///< number in the last step
  bool hovering = false;  ///< the cell is that under the mouse, for as long as it is there

  bool operator==(const Selection&) const = default;
};

/// A body by the name that labels show ("A", "left", "3"), or itself.
struct SelectedBody {
  std::string label{};
  BodyId id{};

  bool empty() const { return label.empty() && !id; }
  bool operator==(const SelectedBody&) const = default;
};

/// A selection as people write it.
struct SelectionText {
  std::optional<int> row{}, column{}, island{};  ///< rows and columns from 1
  SelectedBody body{}, other{};

  bool operator==(const SelectionText&) const = default;
};

/// Reads "row=3,col=5", "body=plank", "body=A,other=B", "island=2".
/// @throws UsageError with what was expected
SelectionText parse_selection(std::string_view text);

/// Entries of `over` go before those of `base`.
SelectionText merged(const SelectionText& base, const SelectionText& over);

/// Finds the bodies; what is no more is not selected. @throws UsageError for a name that no live body has,
/// with the nearest ones
/// @param who  asks, for the message
Selection resolve(const SelectionText& text, const World& world, const char* who = "select");

/// A short name of a body for labels: its own, else a letter for the first 26 that were ever dynamic, else
/// its number among them (`BodyArrays::number`); "ground" for one that never was.
std::string body_label(const World& world, BodyId body);

}  // namespace skerry::sandbox
