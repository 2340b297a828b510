// SPDX-License-Identifier: MIT
#include "sandbox/output.h"

#include <filesystem>
#include <memory>
#include <ostream>
#include <unistd.h>

#include "render/error.h"
#include "render/output_file.h"
#include "sandbox/errors.h"

namespace skerry::sandbox {
namespace {

bool are_the_same(const std::string& one, const std::string& other) {
  if (is_standard_output(one) || is_standard_output(other))
    return is_standard_output(one) && is_standard_output(other);
  std::error_code error;
  // Two curves may well go to /dev/null.
  if (render::is_special(one) && render::is_special(other)) return false;
  if (std::filesystem::equivalent(one, other, error)) return true;
  return std::filesystem::path(one).lexically_normal() == std::filesystem::path(other).lexically_normal();
}

}  // namespace

bool is_standard_output(const std::string& path) {
  return path == "-" || render::descriptor_of(path) == STDOUT_FILENO;
}

std::ostream& words_beside(const Io& io, const std::string& path) {
  return is_standard_output(path) ? io.err : io.out;
}

void write_outputs(const Io& io, std::span<const Output> outputs) {
  std::vector<std::unique_ptr<render::OutputFile>> files;
  for (const Output& output : outputs) {
    if (is_standard_output(output.path)) continue;
    files.push_back(std::make_unique<render::OutputFile>(output.path));
    files.back()->write(output.bytes.data(), output.bytes.size());
  }
  for (const auto& file : files) file->finish();
  for (const Output& output : outputs)
    if (is_standard_output(output.path)) io.out << output.bytes;
}

void write_results(const Io& io, const std::vector<Output>& outputs) {
  try {
    write_outputs(io, outputs);
  } catch (const render::EnvironmentError& error) {
    throw ScriptError(error.what());
  }
}

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw render::EnvironmentError(path + ": cannot be made: " + error.message());
}

void check_outputs(const std::vector<NamedOutput>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (outputs[i].path.empty() || outputs[j].path.empty()) continue;
      if (!are_the_same(outputs[i].path, outputs[j].path)) continue;
      throw UsageError(std::string(outputs[i].option) + " and " + std::string(outputs[j].option) +
                       ": both go to \"" + outputs[i].path + '"');
    }
  }
}

}  // namespace skerry::sandbox
