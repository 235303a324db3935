// SPDX-License-Identifier: Apache-2.0
#include <windows.h>

#include <new>

#include "emulation/pages.hpp"

namespace tetune::backend {

char* reserve_pages(std::size_t bytes) {
  void* block = ::VirtualAlloc(nullptr, bytes, MEM_RESERVE | MEM_COMMIT, PAGE_READWRITE);
  if (block == nullptr) throw std::bad_alloc();
  return static_cast<char*>(block);
}

void release_pages(char* block, std::size_t) { ::VirtualFree(block, 0, MEM_RELEASE); }

void protect_pages(char* block, std::size_t bytes, bool on) {
  DWORD before = 0;
  ::VirtualProtect(block, bytes, on ? PAGE_NOACCESS : PAGE_READWRITE, &before);
}

}  // namespace tetune::backend
