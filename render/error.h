// SPDX-License-Identifier: MIT
//
// Trouble that is neither the caller's nor the scene's: no GL driver, a full disk, a missing encoder.
#pragma once

#include <stdexcept>
#include <string>

namespace skerry::render {

/// Something outside of the program is missing or refuses. The text says what was tried, with the file's name
/// where there is one, and what to install or free. The app ends with exit code 4.
class EnvironmentError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Text of the error number `error` of the C library, e.g. "No space left on device".
std::string system_message(int error);

}  // namespace skerry::render
