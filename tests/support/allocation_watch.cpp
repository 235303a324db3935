// SPDX-License-Identifier: Apache-2.0
#include "support/allocation_watch.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> watching{false};
std::atomic<std::size_t> largest_request{0};
std::atomic<std::size_t> requests_left{0};

}  // namespace

// The sanitizers of clang define an operator new that cannot be replaced.
#define TETUNE_OWN_NEW 1
#if defined(__clang__)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#undef TETUNE_OWN_NEW
#define TETUNE_OWN_NEW 0
#endif
#endif

#if TETUNE_OWN_NEW
// The default array forms call these functions; so does the default nothrow form, except with GCC's address sanitizer.
void* operator new(std::size_t bytes) {
  if (watching) {
    std::size_t seen = largest_request;
    while (bytes > seen && !largest_request.compare_exchange_weak(seen, bytes)) {
    }
    std::size_t left = requests_left;
    while (left > 0 && !requests_left.compare_exchange_weak(left, left - 1)) {
    }
    if (left == 0) throw std::bad_alloc();
  }
  if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}

void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace tetune::test {

bool AllocationWatch::works() { return TETUNE_OWN_NEW == 1; }

AllocationWatch::AllocationWatch(std::size_t granted) {
  largest_request = 0;
  requests_left = granted;
  watching = true;
}

AllocationWatch::~AllocationWatch() { watching = false; }

std::size_t AllocationWatch::largest() const { return largest_request; }

}  // namespace tetune::test
