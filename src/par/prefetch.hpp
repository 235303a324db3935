// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "par/macros.hpp"

namespace tetune::par {

/// What is there is read soon. Nothing on a GPU, which has other threads to run meanwhile.
TETUNE_HD TETUNE_INLINE void prefetch([[maybe_unused]] const void* there) {
#if !defined(__CUDACC__)
  __builtin_prefetch(there);
#endif
}

}  // namespace tetune::par
