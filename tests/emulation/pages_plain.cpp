// SPDX-License-Identifier: Apache-2.0
#include <new>

#include "emulation/pages.hpp"

namespace tetune::backend {

char* reserve_pages(std::size_t bytes) { return static_cast<char*>(::operator new(bytes, std::align_val_t(kPage))); }

void release_pages(char* block, std::size_t) { ::operator delete(block, std::align_val_t(kPage)); }

void protect_pages(char*, std::size_t, bool) {}

}  // namespace tetune::backend
