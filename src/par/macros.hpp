// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The one macro that marks functions which run on the host and on the device.
#if defined(__CUDACC__)
#define TETUNE_HD __host__ __device__
#define TETUNE_INLINE __forceinline__
#else
#define TETUNE_HD
#define TETUNE_INLINE inline __attribute__((always_inline))
#endif

/// A broken invariant is a bug of ours: stop, on every backend.
#if defined(NDEBUG)
#define TETUNE_ASSERT(condition) static_cast<void>(0)
#else
#include <cassert>
#define TETUNE_ASSERT(condition) assert(condition)
#endif
