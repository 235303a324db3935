// SPDX-License-Identifier: Apache-2.0
#include "io/file.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <random>

#include "tetune/error.hpp"
#include "tetune/io.hpp"

namespace tetune {
namespace {

/// Names of the temporary files there are, for remove_temporary_files(). Of more than so many at once the rest is not
/// known to it.
std::array<std::atomic<const char*>, 64> temporaries{};

void remember(const char* name) {
  for (auto& place : temporaries) {
    const char* none = nullptr;
    if (place.compare_exchange_strong(none, name)) return;
  }
}

void forget(const char* name) {
  for (auto& place : temporaries) {
    const char* same = name;
    if (place.compare_exchange_strong(same, nullptr)) return;
  }
}

std::atomic<int> being_created{0};
std::atomic<bool> leaving{false};

/// While it lives, a file is made and its name remembered as one step: no signal is handled on this thread in between,
/// a handler on another thread waits for it, and after that handler no file is made any more.
class Creation {
 public:
  Creation() {
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &old_);
    ++being_created;
    if (!leaving) return;
    --being_created;
    for (;;) ::pause();  // the process is about to end
  }
  ~Creation() {
    --being_created;
    ::pthread_sigmask(SIG_SETMASK, &old_, nullptr);
  }
  Creation(const Creation&) = delete;
  Creation& operator=(const Creation&) = delete;

 private:
  sigset_t old_{};
};

}  // namespace

bool remove_temporary_files() noexcept {
  leaving = true;
  while (being_created > 0) ::poll(nullptr, 0, 1);
  bool renamed = false;
  for (const auto& place : temporaries) {
    const char* name = place.load();
    if (name != nullptr && ::unlink(name) != 0) renamed = renamed || errno == ENOENT;
  }
  return renamed;
}

MappedFile::MappedFile(const std::string& path) {
  const auto fail = [&path](const char* what) { throw FileError(path + ": " + what + ": " + std::strerror(errno)); };
  // Not blocking: a pipe without a writer is refused below like any other thing that is no file.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) fail("cannot open");
  struct stat info {};
  if (::fstat(descriptor, &info) != 0) {
    ::close(descriptor);
    fail("cannot inspect");
  }
  if (!S_ISREG(info.st_mode)) {
    ::close(descriptor);
    throw FileError(path + ": not a regular file");
  }
  size_ = static_cast<std::size_t>(info.st_size);
  if (size_ > 0) {
    void* memory = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (memory == MAP_FAILED) {
      ::close(descriptor);
      fail("cannot map into memory");
    }
    ::madvise(memory, size_, MADV_SEQUENTIAL | MADV_WILLNEED);
    data_ = static_cast<const char*>(memory);
  }
  ::close(descriptor);
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<char*>(data_), size_);
}

FileWriter::FileWriter(std::string path, const std::string& ending) : path_(std::move(path)) {
  // Created under the user's umask like any other file; mkstemp would make it private.
  std::random_device random;
  do {
    temporary_ = path_ + "." + std::to_string(random() % 1'000'000) + ".tmp" + ending;
    const Creation creation;
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) remember(temporary_.c_str());
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) fail("cannot create a file in the folder of");
  // A file that is replaced hands its permissions on, where the file system has any.
  struct stat old {};
  if (::stat(path_.c_str(), &old) == 0) ::fchmod(descriptor_, old.st_mode & 0777U);
}

FileWriter::~FileWriter() {
  if (descriptor_ < 0 || temporary_.empty()) return;
  ::close(descriptor_);
  ::unlink(temporary_.c_str());
  forget(temporary_.c_str());
}

void FileWriter::fail(const char* what) const {
  throw FileError(std::string(what) + " " + path_ + ": " + std::strerror(errno));
}

void FileWriter::write(const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t done = ::write(descriptor_, at, bytes);
    if (done < 0) {
      if (errno == EINTR) continue;
      fail("cannot write");
    }
    at += done;
    bytes -= static_cast<std::size_t>(done);
  }
}

void FileWriter::commit() {
  if (temporary_.empty()) return;
  const int descriptor = descriptor_;
  descriptor_ = -1;
  const bool failed = ::close(descriptor) != 0 || ::rename(temporary_.c_str(), path_.c_str()) != 0;
  forget(temporary_.c_str());
  if (failed) {
    const int error = errno;
    ::unlink(temporary_.c_str());
    errno = error;
    fail("cannot write");
  }
}

}  // namespace tetune
