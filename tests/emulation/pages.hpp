// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

/// Memory by pages, from the operating system. One of pages_posix.cpp, pages_windows.cpp and pages_plain.cpp is
/// compiled.
namespace tetune::backend {

constexpr std::size_t kPage = 4096;

/// Memory that costs nothing until it is used, at the start of a page. Throws std::bad_alloc.
char* reserve_pages(std::size_t bytes);
void release_pages(char* block, std::size_t bytes);
/// Whether whole pages may be accessed. An access to others ends the process, except with pages_plain.cpp.
void protect_pages(char* block, std::size_t bytes, bool on);

}  // namespace tetune::backend
