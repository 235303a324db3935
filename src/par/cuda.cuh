// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>
#include <thrust/iterator/counting_iterator.h>

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "par/buffer.hpp"
#include "par/pool.hpp"
#include "par/span.hpp"
#include "tetune/error.hpp"

namespace tetune::par {

inline void check_cuda(cudaError_t status, const char* what) {
  if (status == cudaSuccess) return;
  cudaGetLastError();  // told here, so no later check shall tell it again
  throw DeviceError(std::string("CUDA: ") + what + " failed: " + cudaGetErrorString(status));
}

template <class F>
__global__ void for_each_kernel(Size n, F f) {
  const Size i = static_cast<Size>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i < n) f(i);
}

/// One block merges one chunk of fixed length, as a tree of fixed shape: the same bits on every run. A thread has one
/// item: what there is to do may be little for a GPU.
template <class R, class F, int kThreads>
__global__ void __launch_bounds__(kThreads) reduce_kernel(Size n, F f, R* partial) {
  __shared__ alignas(16) unsigned char storage[sizeof(R) * kThreads];
  R* shared = reinterpret_cast<R*>(storage);
  const Size i = static_cast<Size>(blockIdx.x) * kThreads + threadIdx.x;
  R r{};
  if (i < n) r.merge(f(i));
  shared[threadIdx.x] = r;
  for (int half = kThreads / 2; half > 0; half /= 2) {
    __syncthreads();
    if (threadIdx.x < half) shared[threadIdx.x].merge(shared[threadIdx.x + half]);
  }
  if (threadIdx.x == 0) partial[blockIdx.x] = shared[0];
}

template <class R>
struct ReadPartial {
  const R* partial;
  TETUNE_HD R operator()(Size i) const { return partial[i]; }
};

/// The CUDA backend: the current device, one stream (the default one), memory from a pool that is had at the start.
///
/// A buffer may go back to the pool, and its memory to the next one, while kernels that use it have yet to run: all
/// that uses the memory afterwards, transfers too, is in the same stream, and so comes after them.
class Cuda {
 public:
  template <class T>
  using Buffer = par::Buffer<T, Cuda>;

  /// A caller's array as kernels see it.
  template <class T>
  using Loan = LoanedCopy<T, Cuda>;

  /// With so many bytes for buffers and scratch. Throws DeviceError.
  explicit Cuda(std::size_t memory, std::function<bool()> stop = {})
      : stop_(std::move(stop)), block_(allocate_block(memory)), pool_(block_.get(), memory) {}
  /// As Cpu's.
  bool stop_requested() const { return stop_ && stop_(); }

  template <class F>
  void for_each(Size n, const F& f) const {
    launch(n, f, n < kFew ? kWarp : kThreads);
  }

  template <class R, class F>
  R reduce(Size n, const F& f) const {
    static_assert(std::is_trivially_copyable_v<F> && std::is_trivially_copyable_v<R>);
    static_assert(kThreads * sizeof(R) <= 48 * 1024, "a block's partial results must fit its shared memory");
    if (n == 0) return R{};
    Buffer<R> partial = reduce_chunks<R>(n, f);
    while (partial.size() > 1) partial = reduce_chunks<R>(partial.size(), ReadPartial<R>{partial.span().data()});
    R result{};
    download(&result, partial.span().data(), sizeof(R));
    return result;
  }

  template <class T>
  T exclusive_scan(Span<const T> in, Span<T> out) const {
    const Size n = in.size();
    if (n == 0) return T{};
    // The last of each, next to each other: one transfer. Before the scan, as that may be in place.
    Buffer<T> ends(2);
    copy(ends.span().data(), in.data() + n - 1, sizeof(T));
    std::size_t bytes = 0;
    check_cuda(cub::DeviceScan::ExclusiveSum(nullptr, bytes, in.data(), out.data(), n), "scan");
    Buffer<unsigned char> scratch(static_cast<Size>(bytes));
    check_cuda(cub::DeviceScan::ExclusiveSum(scratch.span().data(), bytes, in.data(), out.data(), n), "scan");
    copy(ends.span().data() + 1, out.data() + n - 1, sizeof(T));
    T last[2];
    download(last, ends.span().data(), sizeof last);
    return last[1] + last[0];
  }

  template <class F>
  Size compact(Size n, const F& keep, Span<Index32> out) const {
    if (n == 0) return 0;
    Buffer<Size> count(1);
    const thrust::counting_iterator<Index32> ids(0);
    std::size_t bytes = 0;
    check_cuda(cub::DeviceSelect::If(nullptr, bytes, ids, out.data(), count.span().data(), n, keep), "select");
    Buffer<unsigned char> scratch(static_cast<Size>(bytes));
    check_cuda(cub::DeviceSelect::If(scratch.span().data(), bytes, ids, out.data(), count.span().data(), n, keep),
               "select");
    Size kept = 0;
    download(&kept, count.span().data(), sizeof(Size));
    return kept;
  }

  template <class K>
  void sort_by_key(Buffer<K>& keys, Buffer<Index32>& values, int bits) const {
    const Size n = keys.size();
    if (n == 0) return;
    Buffer<K> keys_out(n);
    Buffer<Index32> values_out(n);
    // Between the two of each: what is sorted out of place needs a third.
    cub::DoubleBuffer<K> key(keys.span().data(), keys_out.span().data());
    cub::DoubleBuffer<Index32> value(values.span().data(), values_out.span().data());
    std::size_t bytes = 0;
    check_cuda(cub::DeviceRadixSort::SortPairs(nullptr, bytes, key, value, n, 0, bits), "sort");
    Buffer<unsigned char> scratch(static_cast<Size>(bytes));
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

  static void* allocate(std::size_t bytes) { return Pool::current().allocate(bytes); }
  static void release(void* memory, std::size_t) {
    if (memory != nullptr) Pool::current().release(memory);
  }
  static void copy(void* to, const void* from, std::size_t bytes) {
    check_cuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, nullptr), "copy");
  }
  static void upload(void* to, const void* from, std::size_t bytes) {
    check_cuda(cudaMemcpy(to, from, bytes, cudaMemcpyHostToDevice), "upload");
  }
  static void download(void* to, const void* from, std::size_t bytes) {
    check_cuda(cudaMemcpy(to, from, bytes, cudaMemcpyDeviceToHost), "download");
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

  template <class F>
  static void launch(Size n, const F& f, int threads) {
    static_assert(std::is_trivially_copyable_v<F>);
    if (n == 0) return;
    for_each_kernel<<<blocks(n, threads), static_cast<unsigned>(threads)>>>(n, f);
    check_cuda(cudaGetLastError(), "launch");
  }

  template <class R, class F>
  static Buffer<R> reduce_chunks(Size n, const F& f) {
    Buffer<R> partial(blocks(n, kThreads));
    reduce_kernel<R, F, kThreads><<<blocks(n, kThreads), kThreads>>>(n, f, partial.span().data());
    check_cuda(cudaGetLastError(), "launch");
    return partial;
  }

  static constexpr int kThreads = 128;
  /// Few threads go in blocks of a warp, to as many multiprocessors as there can be.
  static constexpr int kWarp = 32;
  static constexpr Size kFew = 65536;
  /// What is numbered by 32 bits makes far fewer than the 2^31 - 1 that there may be.
  static unsigned blocks(Size n, int each) { return static_cast<unsigned>((n + each - 1) / each); }

  std::function<bool()> stop_;
  Block block_;
  Pool pool_;
};

}  // namespace tetune::par
