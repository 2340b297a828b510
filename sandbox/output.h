// SPDX-License-Identifier: MIT
//
// Results of a command on their way to files or to standard output.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sandbox/io.h"

namespace skerry::sandbox {

/// Whether a name given for an output means standard output: "-", /dev/stdout.
bool is_standard_output(const std::string& path);

/// Where to talk about an output, so that no words get among its bytes.
std::ostream& words_beside(const Io& io, const std::string& path);

/// A file of a command, complete in memory.
struct Output {
  std::string path;
  std::string bytes;
};

/// Writes all of them or, but for what cannot be taken back (standard output, FIFOs, devices), none.
/// @throws render::EnvironmentError with the file's name
void write_outputs(const Io& io, std::span<const Output> outputs);

/// The same for results as data. @throws ScriptError with the file's name
void write_results(const Io& io, const std::vector<Output>& outputs);

/// Bytes as the text that outputs hold.
std::string text_of(std::span<const std::byte> bytes);

/// Makes a folder and those above it. @throws render::EnvironmentError with its name
void make_folder(const std::string& path);

/// An option that names an output, and the name.
struct NamedOutput {
  std::string_view option;
  const std::string& path;
};

/// @throws UsageError when two of them, those without a name left out, are the same file
void check_outputs(const std::vector<NamedOutput>& outputs);

}  // namespace skerry::sandbox
