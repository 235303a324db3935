// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "system/native.hpp"

namespace tetune::native {
namespace {

#ifdef O_TMPFILE
std::string name_of(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }
#endif

}  // namespace

std::filesystem::path long_path(const std::string& path) { return path; }

int open_to_read(const std::string& path) { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); }

int create(const std::string& path) { return ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); }

#ifdef O_TMPFILE
int create_unnamed(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  if (descriptor < 0 || ::access(name_of(descriptor).c_str(), F_OK) == 0) return descriptor;
  ::close(descriptor);
  return -1;
}

bool link_unnamed(int descriptor, const std::string& path) {
  return ::linkat(AT_FDCWD, name_of(descriptor).c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) == 0;
}
#else
int create_unnamed(const std::string&) { return -1; }

bool link_unnamed(int, const std::string&) {
  errno = ENOTSUP;
  return false;
}
#endif

bool close(int descriptor) { return ::close(descriptor) == 0; }

std::optional<std::size_t> regular_size(int descriptor) {
  struct stat info {};
  if (::fstat(descriptor, &info) != 0) return {};
  errno = 0;
  if (!S_ISREG(info.st_mode)) return {};
  const std::size_t size = std::size_t(info.st_size);
  if (off_t(size) == info.st_size) return size;
  errno = EFBIG;  // the addresses of WebAssembly have 32 bits
  return {};
}

const char* map(int descriptor, std::size_t size) {
  void* memory = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  if (memory == MAP_FAILED) return nullptr;
  ::madvise(memory, size, MADV_SEQUENTIAL | MADV_WILLNEED);
  return static_cast<const char*>(memory);
}

void unmap(std::string_view bytes) { ::munmap(const_cast<char*>(bytes.data()), bytes.size()); }

void copy_permissions(const std::string& from, const std::string& to) {
  struct stat old {};
  if (::stat(from.c_str(), &old) != 0) return;
  [[maybe_unused]] const int without_permissions = ::chmod(to.c_str(), old.st_mode & 0777U);  // FAT has none
}

bool is_writable(const std::string& folder) { return ::access(folder.c_str(), W_OK) == 0; }

}  // namespace tetune::native
