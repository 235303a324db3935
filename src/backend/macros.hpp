// SPDX-License-Identifier: Apache-2.0
#pragma once

/// Marks functions that run on the host and on the device.
#if defined(__CUDACC__)
#define TETUNE_HD __host__ __device__
#define TETUNE_INLINE __forceinline__
#else
#define TETUNE_HD
#define TETUNE_INLINE inline __attribute__((always_inline))
#endif

/// Checks an invariant in builds without NDEBUG, on every backend. A failure is a bug of the library.
#if defined(NDEBUG)
#define TETUNE_ASSERT(condition) static_cast<void>(0)
#else
#include <cassert>
#define TETUNE_ASSERT(condition) assert(condition)
#endif
