// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/macros.hpp"

namespace tetune::backend {

/// Loads a cache line that is read soon. No effect on a GPU, which hides latency by running other threads.
TETUNE_HD TETUNE_INLINE void prefetch([[maybe_unused]] const void* address) {
#if !defined(__CUDA_ARCH__)
  __builtin_prefetch(address);
#endif
}

}  // namespace tetune::backend
