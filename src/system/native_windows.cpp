// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>
#include <windows.h>

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

const char* map(int descriptor, std::size_t size) {
  const HANDLE file = reinterpret_cast<HANDLE>(::_get_osfhandle(descriptor));
  const HANDLE mapping = ::CreateFileMappingW(file, nullptr, PAGE_READONLY, 0, 0, nullptr);
  void* const bytes = mapping == nullptr ? nullptr : ::MapViewOfFile(mapping, FILE_MAP_READ, 0, 0, size);
  if (bytes == nullptr) errno = ::GetLastError() == ERROR_NOT_ENOUGH_MEMORY ? ENOMEM : EIO;
  if (mapping != nullptr) ::CloseHandle(mapping);  // the view keeps it
  return static_cast<const char*>(bytes);
}

void unmap(std::string_view bytes) { ::UnmapViewOfFile(bytes.data()); }

void copy_permissions(const std::string&, const std::string&) {}

bool is_writable(const std::string&) { return true; }

}  // namespace tetune::native
