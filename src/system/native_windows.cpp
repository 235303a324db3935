// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "system/native.hpp"
#include "system/path.hpp"

namespace tetune::native {

namespace fs = std::filesystem;

/// Unmarked paths are limited to 260 characters.
fs::path long_path(const std::string& path) {
  constexpr std::size_t kMaxUnmarked = 240;
  std::error_code ignored;
  fs::path whole = fs::absolute(path_of(path), ignored).lexically_normal();
  if (whole.native().starts_with(L"\\\\") || whole.native().size() < kMaxUnmarked) return path_of(path);
  return L"\\\\?\\" + whole.make_preferred().native();
}

int open_to_read(const std::string& path) {
  return ::_wopen(long_path(path).c_str(), _O_RDONLY | _O_BINARY | _O_NOINHERIT);
}

int create(const std::string& path) {
  return ::_wopen(long_path(path).c_str(), _O_WRONLY | _O_CREAT | _O_EXCL | _O_BINARY | _O_NOINHERIT,
                  _S_IREAD | _S_IWRITE);
}

int create_unnamed(const std::string&) { return -1; }

bool link_unnamed(int, const std::string&) {
  errno = ENOSYS;
  return false;
}

bool close(int descriptor) { return ::_close(descriptor) == 0; }

std::optional<std::size_t> regular_size(int descriptor) {
  struct _stat64 info {};
  if (::_fstat64(descriptor, &info) != 0) return {};
  if ((info.st_mode & _S_IFMT) == _S_IFREG) return std::size_t(info.st_size);
  errno = 0;
  return {};
}

/// A copy: a mapped file could not be replaced as long as it is mapped.
const char* map(int descriptor, std::size_t size) {
  constexpr std::size_t kMaxPart = std::size_t{1} << 30;
  char* const bytes = new char[size];
  for (std::size_t at = 0; at < size;) {
    const int got = ::_read(descriptor, bytes + at, unsigned(std::min(size - at, kMaxPart)));
    if (got <= 0) {
      if (got == 0) errno = EIO;
      delete[] bytes;
      return nullptr;
    }
    at += std::size_t(got);
  }
  return bytes;
}

void unmap(std::string_view bytes) { delete[] bytes.data(); }

void copy_permissions(const std::string&, const std::string&) {}

bool is_writable(const std::string&) { return true; }

}  // namespace tetune::native
