// SPDX-License-Identifier: Apache-2.0
#include "system/file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <random>

#include "system/write_all.hpp"
#include "tetune/error.hpp"

namespace tetune {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& text) { throw FileError(text + ": " + std::strerror(errno)); }

/// Opens a file without a name in the folder of `path`, with the permissions that the umask leaves. Returns -1 where
/// the system has no such files, or could not give this one a name later.
int open_unnamed(const std::string& path) {
#ifdef O_TMPFILE
  const std::string folder = fs::path(path).parent_path().string();
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  if (descriptor < 0 || ::access(("/proc/self/fd/" + std::to_string(descriptor)).c_str(), F_OK) == 0) return descriptor;
  ::close(descriptor);
#else
  static_cast<void>(path);
#endif
  return -1;
}

}  // namespace

MappedFile::MappedFile(const std::string& path) {
  // O_NONBLOCK: open() must not wait for the writer of a pipe, which is refused below.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) fail(path + ": cannot open");
  try {
    map(descriptor, path);
  } catch (...) {
    ::close(descriptor);
    throw;
  }
  ::close(descriptor);
}

void MappedFile::map(int descriptor, const std::string& name) {
  struct stat info {};
  if (::fstat(descriptor, &info) != 0) fail(name + ": cannot inspect");
  if (!S_ISREG(info.st_mode)) throw FileError(name + ": not a regular file");
  const auto size = std::size_t(info.st_size);
  if (size == 0) return;
  void* memory = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (memory == MAP_FAILED) fail(name + ": cannot map into memory");
  ::madvise(memory, size, MADV_SEQUENTIAL | MADV_WILLNEED);
  bytes_ = {static_cast<const char*>(memory), size};
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<char*>(bytes_.data()), bytes_.size());
}

TemporaryFile::TemporaryFile(std::string path) : path_(std::move(path)) {
  std::random_device random;
  const std::string ending = fs::path(path_).extension().string();
  do {
    name_ = path_ + ".tetune-" + std::to_string(random()) + ".tmp" + ending;
  } while (::access(name_.c_str(), F_OK) == 0);
}

TemporaryFile::~TemporaryFile() {
  if (!name_.empty()) ::unlink(name_.c_str());
}

void TemporaryFile::replace() {
  struct stat old {};
  if (::stat(path_.c_str(), &old) == 0) {
    [[maybe_unused]] const int without_permissions = ::chmod(name_.c_str(), old.st_mode & 0777U);  // FAT has none
  }
  const bool renamed = ::rename(name_.c_str(), path_.c_str()) == 0;
  const int error = errno;
  if (!renamed) ::unlink(name_.c_str());
  name_.clear();
  errno = error;
  if (!renamed) fail("cannot write " + path_);
}

FileWriter::FileWriter(std::string path) : path_(std::move(path)), descriptor_(open_unnamed(path_)) {
  if (descriptor_ >= 0) return;
  temporary_.emplace(path_);
  descriptor_ = ::open(temporary_->name().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail("cannot create a file in the folder of " + path_);
}

FileWriter::~FileWriter() {
  if (owns_descriptor_ && descriptor_ >= 0) ::close(descriptor_);
}

void FileWriter::write(const void* data, std::size_t bytes) {
  if (!write_all(descriptor_, data, bytes)) fail("cannot write " + path_);
}

void FileWriter::commit() {
  if (!owns_descriptor_) return;
  if (!temporary_) {
    // No call replaces an existing file by one without a name: it gets a temporary name for the time between two calls.
    temporary_.emplace(path_);
    const std::string unnamed = "/proc/self/fd/" + std::to_string(descriptor_);
    if (::linkat(AT_FDCWD, unnamed.c_str(), AT_FDCWD, temporary_->name().c_str(), AT_SYMLINK_FOLLOW) != 0) {
      fail("cannot write " + path_);
    }
  }
  const int descriptor = std::exchange(descriptor_, -1);
  if (::close(descriptor) != 0) fail("cannot write " + path_);
  temporary_->replace();
}

}  // namespace tetune
