// SPDX-License-Identifier: Apache-2.0
#include "allocation_watch.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> watching{false};
std::atomic<std::size_t> largest_request{0};

}  // namespace

// Clang's sanitizers bring an operator new that cannot be replaced: under them nothing is watched.
#define TETUNE_OWN_NEW 1
#if defined(__clang__)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#undef TETUNE_OWN_NEW
#define TETUNE_OWN_NEW 0
#endif
#endif

#if TETUNE_OWN_NEW
// The default array and nothrow forms call these two.
void* operator new(std::size_t bytes) {
  if (watching) {
    std::size_t seen = largest_request;
    while (bytes > seen && !largest_request.compare_exchange_weak(seen, bytes)) {
    }
  }
  if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}

void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace tetune::test {

AllocationWatch::AllocationWatch() {
  largest_request = 0;
  watching = true;
}

AllocationWatch::~AllocationWatch() { watching = false; }

std::size_t AllocationWatch::largest() const { return largest_request; }

}  // namespace tetune::test
