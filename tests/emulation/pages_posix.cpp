// SPDX-License-Identifier: Apache-2.0
#include <sys/mman.h>

#include <new>

#include "emulation/pages.hpp"

namespace tetune::backend {

char* reserve_pages(std::size_t bytes) {
  void* block = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (block == MAP_FAILED) throw std::bad_alloc();
  return static_cast<char*>(block);
}

void release_pages(char* block, std::size_t bytes) { ::munmap(block, bytes); }

void protect_pages(char* block, std::size_t bytes, bool on) {
  ::mprotect(block, bytes, on ? PROT_NONE : PROT_READ | PROT_WRITE);
}

}  // namespace tetune::backend
