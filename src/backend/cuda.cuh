// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>
#include <thrust/iterator/counting_iterator.h>

#include <algorithm>
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "backend/buffer.hpp"
#include "backend/concept.hpp"
#include "backend/cuda_memory.cuh"
#include "backend/pool.hpp"
#include "backend/results.hpp"
#include "backend/span.hpp"
#include "backend/team.hpp"
#include "tetune/error.hpp"

namespace tetune::backend {

template <class F>
__global__ void for_each_kernel(Size n, F f) {
  const Size i = static_cast<Size>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) f(i);
}

/// kThreads consecutive threads of a warp as a team (backend/team.hpp).
template <int kThreads>
class PartOfWarp {
 public:
  static constexpr int kSize = kThreads;

  TETUNE_HD static int rank() {
#if defined(__CUDA_ARCH__)
    return static_cast<int>(threadIdx.x) % kSize;
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

/// A block of one warp, or of the teams of one that there are items for.
template <class F>
__global__ void __launch_bounds__(Warp::kSize) team_kernel(Size n, F f) {
  using Team = PartOfWarp<kTeamSizeOf<F>>;
  constexpr unsigned kTeams = Warp::kSize / Team::kSize;
  __shared__ alignas(16) unsigned char shared[kTeams][sizeof(typename F::Shared)];
  const unsigned team = threadIdx.x / Team::kSize;
  const Size i = static_cast<Size>(blockIdx.x) * (blockDim.x / Team::kSize) + team;
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

/// Each block merges one chunk of fixed length by a tree of fixed shape, so that each run yields the same bits. One
/// item per thread, as there may be too few items to occupy a GPU. The block that is the last of kThreads consecutive
/// ones to store its result merges theirs in the same way, as one block of the next level, until one result is left.
/// `partial` holds the results of all levels but the last one after the other, `arrived` the number of blocks that
/// stored theirs, per kThreads blocks of each level: 0 before and after.
template <class R, class F, int kThreads>
__global__ void __launch_bounds__(kThreads) reduce_kernel(Size n, F f, R* partial, unsigned* arrived, R* result) {
  __shared__ alignas(16) unsigned char storage[sizeof(R) * kThreads];
  __shared__ bool is_last;
  R* shared = reinterpret_cast<R*>(storage);
  unsigned block = blockIdx.x;
  unsigned results = gridDim.x;  // of this level
  const Size i = Size{block} * kThreads + threadIdx.x;
  R r{};
  if (i < n) r.merge(f(i));
  for (;;) {
    shared[threadIdx.x] = r;
    for (int half = kThreads / 2; half > 0; half /= 2) {
      __syncthreads();
      if (threadIdx.x < half) shared[threadIdx.x].merge(shared[threadIdx.x + half]);
    }
    const unsigned group = block / kThreads;
    const unsigned first = group * kThreads;
    const unsigned size = results - first < kThreads ? results - first : kThreads;
    if (threadIdx.x == 0) {
      store_volatile(results > 1 ? &partial[block] : result, shared[0]);
      __threadfence();
      is_last = results > 1 && atomicInc(&arrived[group], size - 1) == size - 1;
    }
    __syncthreads();
    if (!is_last) return;
    __threadfence();
    r = R{};
    if (threadIdx.x < size) r.merge(load_volatile(&partial[first + threadIdx.x]));
    partial += results;
    results = (results + kThreads - 1) / kThreads;
    arrived += results;
    block = group;
  }
}

/// The CUDA backend: the current device, its default stream, and a pool of memory allocated at the start. The
/// primitives are documented in backend/concept.hpp.
class Cuda {
 public:
  using Pack = double;
  using Memory = CudaMemory;
  static constexpr bool kIsAsynchronous = true;
  template <class T>
  using Buffer = backend::Buffer<T, Cuda>;
  template <class T>
  using DeviceView = UploadedView<T, Cuda>;

  /// `memory`: the bytes for all buffers and scratch memory. Throws DeviceError.
  explicit Cuda(std::size_t memory, std::function<bool()> stop = {})
      : stop_(std::move(stop)),
        warps_(resident_warps()),
        block_(allocate_block(memory)),
        pool_(block_.get(), memory),
        zeros_(allocate_zeros(Readback::kCapacity + kMaxGroups * sizeof(unsigned))),
        readback_(zeros()) {}

  Memory memory() const { return Memory(pool_); }

  bool stop_requested() const { return stop_ && stop_(); }

  template <class F>
  void for_each(Size n, const F& f) const {
    static_assert(std::is_trivially_copyable_v<F>);
    if (n == 0) return;
    if constexpr (TeamKernel<F>) {
      const int teams = std::min(warp_items<F>(n), kWarp / kTeamSizeOf<F>);
      team_kernel<<<blocks(n, teams), static_cast<unsigned>(teams * kTeamSizeOf<F>)>>>(n, f);
    } else {
      const int threads = n < kSmallLaunch ? warp_items<F>(n) : kThreads;
      for_each_kernel<<<blocks(n, threads), static_cast<unsigned>(threads)>>>(n, f);
    }
    check_cuda(cudaGetLastError(), "launch");
  }

  template <class R, class F>
  Pending<R> reduce_async(Size n, const F& f) const {
    static_assert(std::is_trivially_copyable_v<F> && std::is_trivially_copyable_v<R>);
    static_assert(kThreads * sizeof(R) <= 48 * 1024, "a block's partial results must fit its shared memory");
    if (n == 0) return {};
    if constexpr (requires { F::kGrain; }) {
      // Kernels of much work are spread (for_each), but the chunks must be the same on all devices.
      Buffer<R> results(*this, n);
      for_each(n, StoreResult<R, F>{f, results.span()});
      return merge<R>(n, LoadResult<R>{results.span()});
    } else {
      return merge<R>(n, f);
    }
  }
  template <class R, class F>
  R reduce(Size n, const F& f) const {
    return reduce_async<R>(n, f).get();
  }

  template <class T>
  T exclusive_scan(Span<const T> in, Span<T> out) const {
    const Size n = in.size();
    if (n == 0) return T{};
    // The last element of each array. The scan may overwrite that of `in`.
    T* end = nullptr;
    const Pending<T> last_in(readback_, end);
    Memory::copy(end, in.data() + n - 1, sizeof(T));
    std::size_t bytes = 0;
    check_cuda(cub::DeviceScan::ExclusiveSum(nullptr, bytes, in.data(), out.data(), n), "scan");
    Buffer<unsigned char> scratch(*this, static_cast<Size>(bytes));
    check_cuda(cub::DeviceScan::ExclusiveSum(scratch.span().data(), bytes, in.data(), out.data(), n), "scan");
    const Pending<T> last_out(readback_, end);
    Memory::copy(end, out.data() + n - 1, sizeof(T));
    return last_out.get() + last_in.get();
  }

  template <class F>
  Size compact(Size n, const F& keep, Span<Index32> out) const {
    if (n == 0) return 0;
    Size* count = nullptr;
    const Pending<Size> kept(readback_, count);
    const thrust::counting_iterator<Index32> ids(0);
    std::size_t bytes = 0;
    check_cuda(cub::DeviceSelect::If(nullptr, bytes, ids, out.data(), count, n, keep), "select");
    Buffer<unsigned char> scratch(*this, static_cast<Size>(bytes));
    check_cuda(cub::DeviceSelect::If(scratch.span().data(), bytes, ids, out.data(), count, n, keep), "select");
    return kept.get();
  }

  template <class K>
  void sort_by_key(Buffer<K>& keys, Buffer<Index32>& values, int bits) const {
    const Size n = keys.size();
    if (n == 0) return;
    Buffer<K> keys_out(*this, n);
    Buffer<Index32> values_out(*this, n);
    // Sorts back and forth between the two arrays; sorting out of place needs a third one.
    cub::DoubleBuffer<K> key(keys.span().data(), keys_out.span().data());
    cub::DoubleBuffer<Index32> value(values.span().data(), values_out.span().data());
    std::size_t bytes = 0;
    check_cuda(cub::DeviceRadixSort::SortPairs(nullptr, bytes, key, value, n, 0, bits), "sort");
    Buffer<unsigned char> scratch(*this, static_cast<Size>(bytes));
    check_cuda(cub::DeviceRadixSort::SortPairs(scratch.span().data(), bytes, key, value, n, 0, bits), "sort");
    if (key.Current() != keys.span().data()) keys.swap(keys_out);
    if (value.Current() != values.span().data()) values.swap(values_out);
  }

  template <class T>
  struct Fill {
    Span<T> out;
    T value;
    TETUNE_HD void operator()(Size i) const { out[i] = value; }
  };
  template <class T>
  void fill(Span<T> out, T value) const {
    for_each(out.size(), Fill<T>{out, value});
  }

 private:
  struct FreeBlock {
    void operator()(void* block) const { cudaFree(block); }
  };
  using Block = std::unique_ptr<void, FreeBlock>;
  static Block allocate_block(std::size_t bytes) {
    void* block = nullptr;
    check_cuda(cudaMalloc(&block, bytes), "allocation");
    return Block(block);
  }

  static Block allocate_zeros(std::size_t bytes) {
    Block block = allocate_block(bytes);
    check_cuda(cudaMemset(block.get(), 0, bytes), "initialization");
    return block;
  }

  static Size attribute(cudaDeviceAttr attribute) {
    int device = 0;
    int value = 0;
    check_cuda(cudaGetDevice(&device), "device query");
    check_cuda(cudaDeviceGetAttribute(&value, attribute, device), "device query");
    return value;
  }
  /// The warps that kernels of much work are spread over: as many as can be resident with all registers of a thread;
  /// one per multiprocessor where one suffices to occupy the units for double precision, as on cards for consumers.
  static Size resident_warps() {
    constexpr Size kWarpsPerProcessor = 8;
    constexpr Size kMaxRatio = 4;
    const Size ratio = attribute(cudaDevAttrSingleToDoublePrecisionPerfRatio);
    return attribute(cudaDevAttrMultiProcessorCount) * (ratio <= kMaxRatio ? kWarpsPerProcessor : 1);
  }

  /// One launch.
  template <class R, class F>
  Pending<R> merge(Size n, const F& f) const {
    Size results = 0, groups = 0;  // of all levels
    for (Size level = n; level > 1 || results == 0;) {
      level = blocks(level, kThreads);
      results += level;
      groups += blocks(level, kThreads);
    }
    TETUNE_ASSERT(groups <= kMaxGroups);
    Buffer<R> partial(*this, results);
    R* result = nullptr;
    const Pending<R> pending(readback_, result);
    reduce_kernel<R, F, kThreads><<<blocks(n, kThreads), kThreads>>>(n, f, partial.span().data(), arrived(), result);
    check_cuda(cudaGetLastError(), "launch");
    return pending;
  }
  /// Items per warp of a short launch. Those that take much work take different paths, one after the other in a warp:
  /// few of them are spread over more warps.
  template <class F>
  int warp_items(Size n) const {
    if constexpr (requires { F::kGrain; }) {
      return to_index(std::clamp<Size>((n + warps_ - 1) / warps_, 1, kWarp));
    } else {
      return kWarp;
    }
  }

  unsigned char* zeros() const { return static_cast<unsigned char*>(zeros_.get()); }
  /// See reduce_kernel.
  unsigned* arrived() const { return reinterpret_cast<unsigned*>(zeros() + Readback::kCapacity); }

  static constexpr int kThreads = 128;
  /// Groups of blocks in a reduction: enough for 2^31 items.
  static constexpr Size kMaxGroups = 1 << 18;
  /// Short launches run in blocks of one warp, to occupy as many multiprocessors as possible.
  static constexpr int kWarp = Warp::kSize;
  static constexpr Size kSmallLaunch = 65536;
  /// Far below the limit of 2^31 - 1, as all indices have 32 bits.
  static unsigned blocks(Size n, int each) { return static_cast<unsigned>((n + each - 1) / each); }

  std::function<bool()> stop_;
  Size warps_;
  Block block_;
  mutable Pool pool_;
  Block zeros_;
  mutable Readback readback_;
};

static_assert(Backend<Cuda>);

}  // namespace tetune::backend
