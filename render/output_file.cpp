// SPDX-License-Identifier: MIT
#include "render/output_file.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <mutex>
#include <string_view>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "render/error.h"

namespace skerry::render {

/// A name that a signal handler can read at any moment. They are never freed, only used again.
struct UnfinishedFile {
  enum State : int { Empty, Changing, Valid };
  explicit UnfinishedFile(std::size_t bytes) : size(bytes), name(new char[bytes]) {}
  std::atomic<int> state{Empty};
  const std::size_t size;
  char* const name;
  UnfinishedFile* next = nullptr;
};

namespace {

namespace fs = std::filesystem;

std::atomic<UnfinishedFile*> all_unfinished{nullptr};
std::mutex empty_mutex;  // guards empty_unfinished, which the handler does not look at
std::vector<UnfinishedFile*> empty_unfinished;

UnfinishedFile* remember(const std::string& name) {
  constexpr std::size_t kUsual = 256;  // with its end
  const std::lock_guard lock(empty_mutex);
  UnfinishedFile* place = nullptr;
  if (!empty_unfinished.empty() && empty_unfinished.back()->size > name.size()) {
    place = empty_unfinished.back();
    empty_unfinished.pop_back();
    place->state = UnfinishedFile::Changing;
  } else {
    place = new UnfinishedFile(std::max(kUsual, name.size() + 1));
    place->next = all_unfinished;
    all_unfinished = place;
  }
  std::memcpy(place->name, name.c_str(), name.size() + 1);
  place->state = UnfinishedFile::Valid;
  return place;
}

void forget(UnfinishedFile* place) {
  place->state = UnfinishedFile::Empty;
  const std::lock_guard lock(empty_mutex);
  empty_unfinished.push_back(place);
}

/// N of "/dev/fd/N", "/proc/self/fd/N" and "/proc/PID/fd/N"; -1 for others.
int number_of_descriptor(const std::string& name) {
  const std::string own = "/proc/" + std::to_string(getpid()) + "/fd/";
  for (const std::string_view prefix : {std::string_view("/dev/fd/"), std::string_view("/proc/self/fd/"),
                                        std::string_view("/proc/thread-self/fd/"), std::string_view(own)}) {
    if (!name.starts_with(prefix)) continue;
    const std::string rest = name.substr(prefix.size());
    const bool digits = !rest.empty() && rest.size() < 7 &&
                        std::all_of(rest.begin(), rest.end(), [](char c) { return c >= '0' && c <= '9'; });
    return digits ? std::stoi(rest) : -1;
  }
  return -1;
}

/// The name behind symbolic links, whether or not there is a file; empty: they lead in a circle.
std::string followed(const fs::path& path) {
  constexpr int kMostLinks = 40;
  fs::path at = path;
  for (int i = 0; i < kMostLinks; ++i) {
    // These are links only to look at.
    if (number_of_descriptor(at.string()) >= 0) return at.string();
    std::error_code error;
    const fs::path next = fs::read_symlink(at, error);
    if (error) return at.string();
    at = next.is_absolute() ? next : at.parent_path() / next;
  }
  return {};
}

}  // namespace

int descriptor_of(const fs::path& path) {
  return number_of_descriptor(followed(path));
}

bool is_special(const fs::path& path) {
  struct stat status {};
  if (descriptor_of(path) >= 0) return true;
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

void OutputFile::fail(const char* what, int error) const {
  throw EnvironmentError(name_ + ": cannot " + what + ": " + system_message(error));
}

OutputFile::OutputFile(const fs::path& path) : name_(path.string()), final_(followed(path)) {
  if (final_.empty()) fail("create", name_.empty() ? ENOENT : ELOOP);
  descriptor_ = number_of_descriptor(final_);
  struct stat status {};
  const bool exists = ::stat(final_.c_str(), &status) == 0;
  if (descriptor_ >= 0 && !exists) fail("open", EBADF);
  if (exists && S_ISDIR(status.st_mode)) fail("write", EISDIR);
  in_place_ = descriptor_ >= 0 || (exists && !S_ISREG(status.st_mode));
  target_ = final_;
  if (in_place_) return;
  if (exists && ::access(final_.c_str(), W_OK) != 0) fail("write", errno);
  if (exists) permissions_ = status.st_mode & 07777;
  make_part();
}

void OutputFile::make_part() {
  // Room for the ending within the 255 bytes of a name.
  constexpr std::size_t kLongestStem = 200;
  constexpr int kMostTrials = 10000;
  static std::atomic<unsigned> count{0};
  const fs::path whole(final_);
  const std::string stem = whole.filename().string().substr(0, kLongestStem);
  // A process of another machine or container may have the same number, and one that was killed left its
  // file.
  for (int i = 0; i < kMostTrials; ++i) {
    target_ = (whole.parent_path() /
               (stem + '.' + std::to_string(getpid()) + '-' + std::to_string(count++) + ".part"))
                  .string();
    // Before there is a file: a signal between the two would leave it. A name in use is forgotten at once.
    remembered_ = remember(target_);
    const int file = ::open(target_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) {
      const int error = errno;
      forget(remembered_);
      if (error == EEXIST) continue;
      fail("create", error);
    }
    // Where the file system has no permissions the old ones do not matter either.
    if (permissions_ != 0) static_cast<void>(::fchmod(file, permissions_));
    ::close(file);
    return;
  }
  fail("create", EEXIST);
}

OutputFile::~OutputFile() {
  if (in_place_ || finished_) return;
  ::unlink(target_.c_str());
  forget(remembered_);
}

void OutputFile::write(const void* bytes, std::size_t size) {
  const int flags = O_WRONLY | O_CLOEXEC | (in_place_ ? 0 : O_TRUNC);
  const int file =
      descriptor_ >= 0 ? ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0) : ::open(target_.c_str(), flags);
  if (file < 0) fail("open", errno);
  const char* from = static_cast<const char*>(bytes);
  int error = 0;
  while (size > 0 && error == 0) {
    const ssize_t written = ::write(file, from, std::min<std::size_t>(size, 1 << 30));
    if (written > 0) {
      from += written;
      size -= static_cast<std::size_t>(written);
    } else if (written == 0 || errno != EINTR) {
      error = written == 0 ? ENOSPC : errno;
    }
  }
  if (::close(file) != 0 && error == 0) error = errno;
  if (error != 0) fail("write", error);
}

void OutputFile::finish() {
  if (!in_place_) {
    if (::rename(target_.c_str(), final_.c_str()) != 0) fail("write", errno);
    forget(remembered_);
  }
  finished_ = true;
}

void remove_unfinished_files() noexcept {
  for (const UnfinishedFile* file = all_unfinished; file != nullptr; file = file->next)
    if (file->state == UnfinishedFile::Valid) ::unlink(file->name);
}

}  // namespace skerry::render
