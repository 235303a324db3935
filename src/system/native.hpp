// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

/// Operations on files that the C++ library lacks. One of native_posix.cpp and native_windows.cpp is compiled. A path
/// is UTF-8 on Windows, and bytes elsewhere. Functions that return -1, false, nothing or a null pointer set errno.
namespace tetune::native {

/// The path for functions of the C++ library, which on Windows take long ones only in another notation.
std::filesystem::path long_path(const std::string& path);
/// Opens a file for reading; does not wait for the writer of a pipe.
int open_to_read(const std::string& path);
/// Creates a file that must not exist, with the permissions that the umask leaves, and opens it for writing.
int create(const std::string& path);
/// Opens a file without a name in the folder of `path`, or returns -1 where the system has no such files, or could not
/// give this one a name later.
int create_unnamed(const std::string& path);
/// Gives a file without a name a name, which must not exist.
bool link_unnamed(int descriptor, const std::string& path);
bool close(int descriptor);

/// The size of a regular file; nothing, with errno 0, where the descriptor is something else.
std::optional<std::size_t> regular_size(int descriptor);
/// The content of a file, mapped into memory for reading. `size` is positive.
const char* map(int descriptor, std::size_t size);
void unmap(std::string_view bytes);

/// Hands the permissions of a file on, where the system has them.
void copy_permissions(const std::string& from, const std::string& to);
/// Whether files may be created in a folder, as far as the system knows that before.
bool is_writable(const std::string& folder);

}  // namespace tetune::native
