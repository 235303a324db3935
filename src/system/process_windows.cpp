// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <io.h>
#include <windows.h>
// After windows.h:
#include <shellapi.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iterator>

#include "system/process.hpp"

namespace tetune::process {
namespace {

namespace fs = std::filesystem;

void (*handler)() = nullptr;

std::string utf8(const std::wstring& text) { return fs::path(text).string(); }

/// The files that a pattern in the last part of a path fits.
std::vector<std::string> expand(const std::wstring& pattern) {
  const std::size_t last = pattern.find_last_of(L"/\\");
  const std::wstring folder = last == std::wstring::npos ? L"" : pattern.substr(0, last + 1);
  std::vector<std::string> names;
  WIN32_FIND_DATAW found{};
  const HANDLE search = ::FindFirstFileW(pattern.c_str(), &found);
  if (search == INVALID_HANDLE_VALUE) return names;
  do {
    const bool is_folder = (found.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0;
    if (!is_folder) names.push_back(utf8(folder + found.cFileName));
  } while (::FindNextFileW(search, &found) != 0);
  ::FindClose(search);
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

void prepare_standard_streams() {
  int descriptor = 0;
  while (descriptor >= 0 && descriptor <= 2) descriptor = ::_open("NUL", _O_RDWR);
  if (descriptor > 2) ::_close(descriptor);
  for (const int stream : {0, 1, 2}) ::_setmode(stream, _O_BINARY);
  ::SetConsoleOutputCP(CP_UTF8);
}

std::vector<std::string> arguments(int argc, char** argv) {
  int count = 0;
  wchar_t** const words = ::CommandLineToArgvW(::GetCommandLineW(), &count);
  if (words == nullptr) return {argv + 1, argv + argc};
  std::vector<std::string> arguments;
  for (int i = 1; i < count; ++i) {
    const std::wstring word = words[i];
    const bool is_pattern = word.find_first_of(L"*?") != std::wstring::npos;
    const std::vector<std::string> files = is_pattern ? expand(word) : std::vector<std::string>();
    if (files.empty()) arguments.push_back(utf8(word));
    std::copy(files.begin(), files.end(), std::back_inserter(arguments));
  }
  ::LocalFree(words);
  return arguments;
}

bool is_terminal(int descriptor) { return ::_isatty(descriptor) != 0; }

void on_interruption(void (*handle)()) {
  handler = handle;
  // The system calls it on a thread of its own.
  ::SetConsoleCtrlHandler(
      [](DWORD) -> BOOL {
        handler();
        return TRUE;
      },
      TRUE);
  std::signal(SIGTERM, [](int) { handler(); });
}

void write_error(std::string_view text) noexcept {
  [[maybe_unused]] const int done = ::_write(2, text.data(), unsigned(text.size()));
}

void leave(int exit_code) noexcept { std::_Exit(exit_code); }

}  // namespace tetune::process
