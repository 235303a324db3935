// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <cub/device/device_radix_sort.cuh>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "backend/buffer.hpp"
#include "backend/concept.hpp"
#include "backend/cuda_kernels.cuh"
#include "backend/cuda_memory.cuh"
#include "backend/cuda_scan.cuh"
#include "backend/pool.hpp"
#include "backend/results.hpp"
#include "backend/span.hpp"
#include "backend/team.hpp"
#include "tetune/error.hpp"

namespace tetune::backend {

/// The CUDA backend: the current device, its default stream, and a pool of memory, which grows. The
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
  template <class R>
  using Result = Pending<R>;

  /// `memory`: an estimate of the bytes for all buffers and scratch memory. Throws DeviceError.
  explicit Cuda(std::size_t memory, std::function<bool()> stop = {})
      : stop_(std::move(stop)),
        warps_(resident_warps()),
        pool_({allocate_or_null, free_block}, memory),
        zeros_(allocate_zeros((kMaxGroups + 1 + kMaxTiles) * sizeof(unsigned))) {}

  Memory memory() const { return Memory(pool_); }

  bool stop_requested() const { return stop_ && stop_(); }

  template <class F>
  void for_each(Size n, const F& f) const {
    static_assert(std::is_trivially_copyable_v<F>);
    if (n == 0) return;
    if constexpr (kScalesToWarp<F>) {
      if (n <= kWarpEach * warps_) {
        launch_teams<kWarp>(n, f);
      } else {
        launch_teams<kTeamSizeOf<F>>(n, f);
      }
    } else if constexpr (TeamKernel<F>) {
      launch_teams<kTeamSizeOf<F>>(n, f);
    } else {
      const int threads = n < kSmallLaunch ? warp_items<F>(n) : kThreads;
      for_each_kernel<<<blocks(n, threads), static_cast<unsigned>(threads)>>>(n, f);
    }
    check_cuda(cudaGetLastError(), "launch");
  }

  template <class F>
  void for_each_in_order(Size n, const F& f) const {
    static_assert(std::is_trivially_copyable_v<F>);
    if (n == 0) return;
    ordered_kernel<<<blocks(n, 1), kWarp>>>(f, started());
    check_cuda(cudaGetLastError(), "launch");
  }

  template <class F>
  void for_each_step(Size steps, Size n, const F& f) const {
    static_assert(std::is_trivially_copyable_v<F>);
    if (n == 0) return;
    if (n > kMaxBlock) return backend::for_each_step(*this, steps, n, f);
    steps_kernel<F, kMaxBlock><<<1, blocks(n, kWarp) * kWarp>>>(steps, n, f);
    check_cuda(cudaGetLastError(), "launch");
  }

  template <class R, class F>
  Pending<R> reduce_async(Size n, const F& f) const {
    static_assert(std::is_trivially_copyable_v<F> && std::is_trivially_copyable_v<R>);
    static_assert(kMergeChunk * sizeof(R) <= 48 * 1024, "a block's partial results must fit its shared memory");
    if (n == 0) return {};
    if constexpr (requires { F::kGrain; }) {
      // Kernels of much work are spread (for_each), but the chunks must be the same on all devices.
      if (n < kSmallLaunch) return merge_spread<R>(n, f);
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
    return exclusive_scan_async(in, out).get();
  }
  template <class T>
  Pending<T> exclusive_scan_async(Span<const T> in, Span<T> out) const {
    return scan(in.size(), ScanArray<T>{in, out});
  }

  template <class F>
  Size compact(Size n, const F& keep, Span<Index32> out) const {
    return scan(n, ListKept<F>{keep, out}).get();
  }

  template <class F, class G, class P>
  auto compact_and_sum(Size n, const F& keep, const G& evaluate, const P& place) const {
    return scan(n, PlaceKept<F, G, P>{keep, evaluate, place}).get();
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
  static void* allocate_or_null(std::size_t bytes) {
    void* block = nullptr;
    const cudaError_t status = cudaMalloc(&block, bytes);
    if (status == cudaErrorMemoryAllocation) {
      cudaGetLastError();  // clears the error
      return nullptr;
    }
    check_cuda(status, "allocation");
    return block;
  }
  static void free_block(void* block) { cudaFree(block); }
  using Block = std::unique_ptr<void, void (*)(void*)>;

  static Block allocate_zeros(std::size_t bytes) {
    void* memory = nullptr;
    check_cuda(cudaMalloc(&memory, bytes), "allocation");
    Block block(memory, free_block);
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

  /// One launch, a warp per block.
  template <int kTeamSize, class F>
  void launch_teams(Size n, const F& f) const {
    const int teams = std::min(warp_items<F>(n), kWarp / kTeamSize);
    team_kernel<kTeamSize><<<blocks(n, teams), unsigned(teams * kTeamSize)>>>(n, f);
  }

  /// One launch.
  template <class R, class F>
  Pending<R> merge(Size n, const F& f) const {
    Buffer<R> partial(*this, results_above(n));
    R* result = nullptr;
    const Pending<R> pending(readback_, result);
    const MergeLevels<R> levels{partial.span().data(), arrived(), result};
    reduce_kernel<<<blocks(n, kMergeChunk), kMergeChunk>>>(n, f, levels);
    check_cuda(cudaGetLastError(), "launch");
    return pending;
  }
  /// One launch of a kernel of much work.
  template <class R, class F>
  Pending<R> merge_spread(Size n, const F& f) const {
    unsigned each = TeamKernel<F> ? kWarp / kTeamSizeOf<F> : kWarp;
    while (each > 1 && each > unsigned(warp_items<F>(n))) each /= 2;
    Buffer<R> results(*this, n + results_above(n));
    R* result = nullptr;
    const Pending<R> pending(readback_, result);
    R* items = results.span().data();
    const MergeLevels<R> levels{items + n, arrived() + blocks(n, kMergeChunk), result};
    spread_reduce_kernel<<<blocks(n, int(each)), kWarp>>>(n, each, f, items, arrived(), levels);
    check_cuda(cudaGetLastError(), "launch");
    return pending;
  }
  /// The number of results of the levels of a reduction.
  static Size results_above(Size n) {
    Size results = 0, groups = 0;
    for (Size level = n; level > 1 || results == 0;) {
      level = blocks(level, kMergeChunk);
      results += level;
      groups += blocks(level, kMergeChunk);
    }
    TETUNE_ASSERT(groups <= kMaxGroups);
    return results;
  }
  /// One launch.
  template <class F>
  Pending<SumOf<typename F::Value>> scan(Size n, const F& f) const {
    static_assert(std::is_trivially_copyable_v<F>);
    using T = SumOf<typename F::Value>;
    // Few tiles, as each reads sums of those before; several items per thread are kept in registers.
    constexpr Size kGoodTiles = 1024;
    constexpr int kMaxRows = sizeof(T) > sizeof(double) ? 4 : 16;
    if (n == 0) return {};
    const int rows = static_cast<int>(std::clamp<Size>(n / (kThreads * kGoodTiles), 1, kMaxRows));
    const unsigned tiles = blocks(n, kThreads * rows);
    TETUNE_ASSERT(tiles <= kMaxTiles);
    Buffer<T> sums(*this, 2 * Size{tiles});
    T* total = nullptr;
    const Pending<T> pending(readback_, total);
    const ScannedTiles<T> scanned{sums.span().data(), sums.span().data() + tiles, tile_states(), next_scan(),
                                  started()};
    scan_kernel<F, kThreads, kMaxRows><<<tiles, kThreads>>>(n, rows, f, scanned, total);
    check_cuda(cudaGetLastError(), "launch");
    return pending;
  }
  /// See ScannedTiles::has_sum. Clears all states where the number starts from 0 again.
  unsigned next_scan() const {
    scans_ += 2;
    if (scans_ == 0) {
      check_cuda(cudaMemsetAsync(tile_states(), 0, kMaxTiles * sizeof(unsigned), nullptr), "initialization");
      scans_ = 2;
    }
    return scans_;
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

  /// See MergeLevels.
  unsigned* arrived() const { return static_cast<unsigned*>(zeros_.get()); }
  /// See ScannedTiles and ordered_kernel().
  unsigned* started() const { return arrived() + kMaxGroups; }
  unsigned* tile_states() const { return started() + 1; }

  /// The number of items per resident warp up to which a whole warp evaluates each (kScalesToWarp).
  static constexpr Size kWarpEach = 4;
  static constexpr int kThreads = 128;
  /// Threads of the largest block, which runs steps of few items in one launch.
  static constexpr int kMaxBlock = 1024;
  /// Groups of blocks in a reduction: enough for 2^31 items.
  static constexpr Size kMaxGroups = 1 << 18;
  /// Tiles of a scan: enough for 2^31 items where these are counted, and 2^29 where larger values are added up.
  static constexpr Size kMaxTiles = 1 << 20;
  /// Short launches run in blocks of one warp, to occupy as many multiprocessors as possible.
  static constexpr int kWarp = Warp::kSize;
  static constexpr Size kSmallLaunch = 65536;
  /// Far below the limit of 2^31 - 1, as all indices have 32 bits.
  static unsigned blocks(Size n, int each) { return static_cast<unsigned>((n + each - 1) / each); }

  std::function<bool()> stop_;
  Size warps_;
  mutable GrowingPool pool_;
  Block zeros_;
  mutable Readback readback_;
  mutable unsigned scans_ = 0;
};

static_assert(Backend<Cuda> && RunsInOrder<Cuda>);

}  // namespace tetune::backend
