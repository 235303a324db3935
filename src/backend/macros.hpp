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

/// Keeps a function out of line in the code of a device, so that large functions that several operators call are
/// compiled once: in kernels of some hundred KiB, which exceed the instruction cache, warps would wait for instructions
/// most of the time.
#if defined(__CUDA_ARCH__)
#define TETUNE_OUTLINE __noinline__
#else
#define TETUNE_OUTLINE
#endif
/// Before a loop: keeps it from being unrolled in the code of a device, for the same reason.
#if defined(__CUDA_ARCH__)
#define TETUNE_ROLLED _Pragma("unroll 1")
#else
#define TETUNE_ROLLED
#endif

/// Checks an invariant in builds without NDEBUG, on every backend. A failure is a bug of the library.
#if defined(NDEBUG)
#define TETUNE_ASSERT(condition) static_cast<void>(0)
#else
#include <cassert>
#define TETUNE_ASSERT(condition) assert(condition)
#endif
