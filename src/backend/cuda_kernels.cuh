// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "backend/macros.hpp"
#include "backend/span.hpp"
#include "backend/team.hpp"

/// The kernels of the CUDA backend (backend/cuda.cuh).
namespace tetune::backend {

template <class F>
__global__ void for_each_kernel(Size n, F f) {
  const Size i = Size{blockIdx.x} * blockDim.x + threadIdx.x;
  if (i < n) f(i);
}

/// All steps in one block.
template <class F, int kMaxThreads>
__global__ void __launch_bounds__(kMaxThreads) steps_kernel(Size steps, Size n, F f) {
  for (Size step = 0; step < steps; ++step) {
    if (threadIdx.x < n) f(step, Size{threadIdx.x});
    __syncthreads();
  }
}

/// kThreads consecutive threads of a warp as a team (backend/team.hpp).
template <int kThreads>
class PartOfWarp {
 public:
  static constexpr int kSize = kThreads;

  TETUNE_HD static int rank() {
#if defined(__CUDA_ARCH__)
    return int(threadIdx.x) % kSize;
#else
    return 0;
#endif
  }
  TETUNE_HD static bool any([[maybe_unused]] bool condition) {
#if defined(__CUDA_ARCH__)
    return __any_sync(threads(), condition) != 0;
#else
    return condition;
#endif
  }
  TETUNE_HD static Placement rank_among([[maybe_unused]] bool condition) {
#if defined(__CUDA_ARCH__)
    const unsigned holding = __ballot_sync(threads(), condition);
    const unsigned lower = (1U << (threadIdx.x % 32)) - 1;
    return {__popc(holding & lower), __popc(holding)};
#else
    return {0, condition ? 1 : 0};
#endif
  }
  template <class T>
  TETUNE_HD static T merge(T value) {
    for (int distance = kSize / 2; distance > 0; distance /= 2) value.merge(broadcast(value, rank() ^ distance));
    return value;
  }
  template <class T>
  TETUNE_HD static T broadcast(const T& value, [[maybe_unused]] int rank) {
#if defined(__CUDA_ARCH__)
    static_assert(std::is_trivially_copyable_v<T>);
    constexpr int kWords = (sizeof(T) + sizeof(unsigned) - 1) / sizeof(unsigned);
    unsigned words[kWords]{};
    memcpy(words, &value, sizeof(T));
    for (int k = 0; k < kWords; ++k) words[k] = __shfl_sync(threads(), words[k], rank, kSize);
    T result;
    memcpy(&result, words, sizeof(T));
    return result;
#else
    return value;
#endif
  }
  TETUNE_HD static void sync() {
#if defined(__CUDA_ARCH__)
    __syncwarp(threads());
#endif
  }

 private:
#if defined(__CUDA_ARCH__)
  /// The lanes of the team.
  __device__ static unsigned threads() {
    constexpr unsigned kFirst = ~0U >> (32 - kSize);
    return kFirst << (threadIdx.x % 32 / kSize * kSize);
  }
#endif
};
using Warp = PartOfWarp<32>;

/// The number of warps that a multiprocessor is to have at once, which limits the registers of a thread. Sweeps gain
/// nothing from more (docs/benchmarks/gpu.md).
inline constexpr int kMinWarps = 12;

/// A block of one warp, or of the teams of one that there are items for.
template <int kTeamSize, class F>
__global__ void __launch_bounds__(Warp::kSize, kMinWarps) team_kernel(Size n, F f) {
  using Team = PartOfWarp<kTeamSize>;
  constexpr unsigned kTeams = Warp::kSize / Team::kSize;
  __shared__ alignas(16) unsigned char shared[kTeams][sizeof(typename F::Shared)];
  const unsigned team = threadIdx.x / Team::kSize;
  const Size i = Size{blockIdx.x} * (blockDim.x / Team::kSize) + team;
  if (i < n) f(Team(), *reinterpret_cast<typename F::Shared*>(shared[team]), i);
}

/// Stores and loads what other blocks of the same launch load and store.
template <class T>
__device__ void store_volatile(T* to, const T& value) {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % sizeof(unsigned) == 0);
  constexpr int kWords = sizeof(T) / sizeof(unsigned);
  unsigned words[kWords];
  memcpy(words, &value, sizeof(T));
  volatile unsigned* const memory = reinterpret_cast<unsigned*>(to);
  for (int k = 0; k < kWords; ++k) memory[k] = words[k];
}
template <class T>
__device__ T load_volatile(const T* from) {
  constexpr int kWords = sizeof(T) / sizeof(unsigned);
  unsigned words[kWords];
  const volatile unsigned* const memory = reinterpret_cast<const unsigned*>(from);
  for (int k = 0; k < kWords; ++k) words[k] = memory[k];
  T value;
  memcpy(&value, words, sizeof(T));
  return value;
}

/// A block of one warp evaluates an item. Blocks take the items in order, so that those before an item are evaluated by
/// blocks that run already. `started` is the number of items that were taken; 0 before and after.
template <class F>
__global__ void __launch_bounds__(Warp::kSize, kMinWarps) ordered_kernel(F f, unsigned* started) {
  static_assert(kTeamSizeOf<F> == Warp::kSize);
  __shared__ alignas(16) unsigned char shared[sizeof(typename F::Shared)];
  unsigned taken = 0;
  if (Warp::rank() == 0) taken = atomicInc(started, gridDim.x - 1);
  const Size i = Warp::broadcast(taken, 0);
  while (Warp::any(!f.is_ready(Warp(), i))) {
  }
  // Results of the items that any thread has found finished are visible to all threads.
  __threadfence();
  Warp::sync();
  f(Warp(), *reinterpret_cast<typename F::Shared*>(shared), i);
  Warp::sync();
  if (Warp::rank() != 0) return;
  __threadfence();
  f.finish(i);
}

/// Results that are merged at a time, by a tree of fixed shape, so that each run yields the same bits.
inline constexpr int kMergeChunk = 128;

/// Called by a block whose stores of a result are to be counted. Returns whether it is the last of `count` blocks,
/// which then reads the results of all. `arrived` is 0 before and after.
__device__ inline bool is_last_to_store(unsigned* arrived, unsigned count) {
  __shared__ bool is_last;
  __threadfence();
  __syncthreads();
  if (threadIdx.x == 0) is_last = atomicInc(arrived, count - 1) == count - 1;
  __syncthreads();
  if (is_last) __threadfence();
  return is_last;
}

/// The levels of a reduction above its items: `partial` holds the results of all levels but the last one after the
/// other, `arrived` the number of blocks that stored theirs, per kMergeChunk results of each level.
template <class R>
struct MergeLevels {
  R* partial;
  unsigned* arrived;
  R* result;

  /// Called by a block of kThreads with the items of a chunk in `shared`. The last of kMergeChunk consecutive blocks to
  /// store its result merges theirs in the same way, as one block of the next level, until one result is left.
  template <int kThreads>
  __device__ void merge(R* shared, unsigned chunk, unsigned chunks) const {
    R* stored = partial;
    unsigned* count = arrived;
    for (;;) {
#pragma unroll
      for (int half = kMergeChunk / 2; half > 0; half /= 2) {
        __syncthreads();
#pragma unroll
        for (int t = int(threadIdx.x); t < half; t += kThreads) shared[t].merge(shared[t + half]);
      }
      const unsigned group = chunk / kMergeChunk;
      const unsigned first = group * kMergeChunk;
      const unsigned size = chunks - first < kMergeChunk ? chunks - first : kMergeChunk;
      if (threadIdx.x == 0) store_volatile(chunks > 1 ? &stored[chunk] : result, shared[0]);
      if (chunks == 1 || !is_last_to_store(&count[group], size)) return;
      load<kThreads>(shared, stored, first, first + size);
      stored += chunks;
      chunks = (chunks + kMergeChunk - 1) / kMergeChunk;
      count += chunks;
      chunk = group;
    }
  }

  /// Loads a chunk of results that other blocks stored.
  template <int kThreads>
  __device__ static void load(R* shared, const R* from, Size first, Size end) {
    for (int t = int(threadIdx.x); t < kMergeChunk; t += kThreads) {
      R r{};
      if (first + t < end) r.merge(load_volatile(&from[first + t]));
      shared[t] = r;
    }
  }
};

/// Each block evaluates and merges one chunk. One item per thread, as there may be too few items to occupy a GPU.
template <class R, class F>
__global__ void __launch_bounds__(kMergeChunk) reduce_kernel(Size n, F f, MergeLevels<R> levels) {
  __shared__ alignas(16) unsigned char storage[sizeof(R) * kMergeChunk];
  R* shared = reinterpret_cast<R*>(storage);
  const Size i = Size{blockIdx.x} * kMergeChunk + threadIdx.x;
  R r{};
  if (i < n) r.merge(f(i));
  shared[threadIdx.x] = r;
  levels.template merge<kMergeChunk>(shared, blockIdx.x, gridDim.x);
}

/// The memory of a block that evaluates, and then merges.
template <class R, class F>
inline constexpr std::size_t kSpreadBytes = sizeof(R) * kMergeChunk;
template <class R, class F>
requires TeamKernel<F>
inline constexpr std::size_t kSpreadBytes<R, F> =
    std::max(sizeof(R) * kMergeChunk, sizeof(typename F::Shared) * (Warp::kSize / kTeamSizeOf<F>));

/// Same result as reduce_kernel(), for kernels of much work: a block is a warp, which evaluates `each` items, a power
/// of two, by its first lanes or by teams, and stores their results in `items`. The last block to store those of a
/// chunk merges them. `arrived` holds the number of these blocks per chunk.
template <class R, class F>
__global__ void __launch_bounds__(Warp::kSize)
    spread_reduce_kernel(Size n, unsigned each, F f, R* items, unsigned* arrived, MergeLevels<R> levels) {
  __shared__ alignas(16) unsigned char storage[kSpreadBytes<R, F>];
  const Size first = Size{blockIdx.x} * each;
  if constexpr (TeamKernel<F>) {
    using Team = PartOfWarp<kTeamSizeOf<F>>;
    using Shared = typename F::Shared;
    const unsigned team = threadIdx.x / Team::kSize;
    const Size i = first + team;
    if (team < each && i < n) {
      const R r = f(Team(), reinterpret_cast<Shared*>(storage)[team], i);
      if (Team::rank() == 0) store_volatile(&items[i], r);
    }
  } else {
    const Size i = first + threadIdx.x;
    if (threadIdx.x < each && i < n) store_volatile(&items[i], f(i));
  }
  const unsigned chunk = static_cast<unsigned>(first / kMergeChunk);
  const Size begin = Size{chunk} * kMergeChunk;
  const Size end = begin + kMergeChunk < n ? begin + kMergeChunk : n;
  if (!is_last_to_store(&arrived[chunk], static_cast<unsigned>((end - begin + each - 1) / each))) return;
  R* shared = reinterpret_cast<R*>(storage);
  levels.template load<Warp::kSize>(shared, items, begin, end);
  levels.template merge<Warp::kSize>(shared, chunk, static_cast<unsigned>((n + kMergeChunk - 1) / kMergeChunk));
}

}  // namespace tetune::backend
