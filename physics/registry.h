// SPDX-License-Identifier: MIT
//
// What all registries share: finding a row by its name.
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace skerry {

/// The row called `name`. @param what  for the message, "solver" @throws std::invalid_argument that lists the
/// names
template <class Entry>
const Entry& find_entry(std::string_view what, std::string_view name, std::span<const Entry> entries) {
  std::string message = "unknown ";
  message.append(what).append(" \"").append(name).append("\"; there are: ");
  bool first = true;
  for (const Entry& entry : entries) {
    if (entry.name == name) return entry;
    message.append(first ? "" : ", ").append(entry.name);
    first = false;
  }
  throw std::invalid_argument(message);
}

}  // namespace skerry
