// SPDX-License-Identifier: MIT
//
// A file on its way to its name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace skerry::render {

struct UnfinishedFile;

/// Keeps what stands under a name until the new bytes are complete: they go to a file of its own beside it,
/// "NAME.PID-N.part", which takes the name at the end. Symbolic links are followed, they stay what they are;
/// a file that is replaced hands on its permissions. FIFOs and devices, and open descriptors (/dev/stdout,
/// /dev/fd/3), get the bytes straight away.
class OutputFile {
 public:
  /// @throws EnvironmentError with the file's name and the system's reason
  explicit OutputFile(const std::filesystem::path& path);
  /// Removes what is not finished.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Where the bytes go until `finish`.
  [[nodiscard]] const std::string& target() const { return target_; }
  /// True where they cannot be taken back, and nobody can go back in them: a FIFO, a device, a descriptor.
  [[nodiscard]] bool in_place() const { return in_place_; }

  /// Writes all the bytes, from the beginning. @throws EnvironmentError
  void write(const void* bytes, std::size_t size);
  /// Gives the file its name. @throws EnvironmentError
  void finish();

 private:
  [[noreturn]] void fail(const char* what, int error) const;
  void make_part();

  const std::string name_;    // as given, for messages
  std::string final_;         // with the links followed
  std::string target_;        // equal to `final_` in place
  int descriptor_ = -1;       // that the name stands for
  unsigned permissions_ = 0;  // of the file that is replaced; 0: none
  bool in_place_ = false;
  bool finished_ = false;
  UnfinishedFile* remembered_ = nullptr;  // its place in the list of unfinished files
};

/// The open descriptor that a name such as /dev/stdout or /dev/fd/3 stands for, links followed; -1: none.
[[nodiscard]] int descriptor_of(const std::filesystem::path& path);

/// Whether the name is that of a FIFO, a device or an open descriptor.
[[nodiscard]] bool is_special(const std::filesystem::path& path);

/// Removes all files that no `finish` was called for. A signal handler may call it when the process is to
/// end.
void remove_unfinished_files() noexcept;

}  // namespace skerry::render
