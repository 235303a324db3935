// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime.h>
#include <thrust/iterator/counting_iterator.h>

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>
#include <functional>
#include <string>
#include <utility>

#include "par/buffer.hpp"
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

/// One block merges one chunk of fixed length, as a tree of fixed shape: the same bits on every run.
template <class R, class F, int kThreads, int kChunk>
__global__ void __launch_bounds__(kThreads) reduce_kernel(Size n, F f, R* partial) {
  __shared__ alignas(16) unsigned char storage[sizeof(R) * kThreads];
  R* shared = reinterpret_cast<R*>(storage);
  const Size begin = static_cast<Size>(blockIdx.x) * kChunk;
  const Size end = begin + kChunk < n ? begin + kChunk : n;
  R r{};
  for (Size i = begin + threadIdx.x; i < end; i += kThreads) r.merge(f(i));
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

/// The CUDA backend: the current device, one stream (the default one), memory from the driver's pool.
class Cuda {
 public:
  template <class T>
  using Buffer = par::Buffer<T, Cuda>;

  /// A caller's array as kernels see it: a copy on the device.
  template <class T>
  class Loan {
   public:
    explicit Loan(const std::vector<T>& host) { copy_.upload(host); }
    Span<const T> span() const { return copy_.span(); }

   private:
    Buffer<T> copy_;
  };

  explicit Cuda(std::function<bool()> stop = {}) : stop_(std::move(stop)) {}
  /// As Cpu's.
  bool stop_requested() const { return stop_ && stop_(); }

  template <class F>
  void for_each(Size n, const F& f) const {
    if (n == 0) return;
    for_each_kernel<<<blocks(n, kThreads), kThreads>>>(n, f);
    check_cuda(cudaGetLastError(), "launch");
  }

  template <class R, class F>
  R reduce(Size n, const F& f) const {
    if (n == 0) return R{};
    Size chunks = blocks(n, kChunk);
    Buffer<R> partial(chunks);
    reduce_kernel<R, F, kThreads, kChunk><<<static_cast<unsigned>(chunks), kThreads>>>(n, f, partial.span().data());
    check_cuda(cudaGetLastError(), "launch");
    while (chunks > 1) {
      const Size fewer = blocks(chunks, kChunk);
      Buffer<R> merged(fewer);
      reduce_kernel<R, ReadPartial<R>, kThreads, kChunk><<<static_cast<unsigned>(fewer), kThreads>>>(
          chunks, ReadPartial<R>{partial.span().data()}, merged.span().data());
      check_cuda(cudaGetLastError(), "launch");
      partial.swap(merged);
      chunks = fewer;
    }
    R result{};
    download(&result, partial.span().data(), sizeof(R));
    return result;
  }

  template <class T>
  T exclusive_scan(Span<const T> in, Span<T> out) const {
    const Size n = in.size();
    if (n == 0) return T{};
    T last_in{};
    T last_out{};
    download(&last_in, in.data() + n - 1, sizeof(T));
    std::size_t bytes = 0;
    check_cuda(cub::DeviceScan::ExclusiveSum(nullptr, bytes, in.data(), out.data(), n), "scan");
    Buffer<unsigned char> scratch(static_cast<Size>(bytes));
    check_cuda(cub::DeviceScan::ExclusiveSum(scratch.span().data(), bytes, in.data(), out.data(), n), "scan");
    download(&last_out, out.data() + n - 1, sizeof(T));
    return last_out + last_in;
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
    std::size_t bytes = 0;
    check_cuda(cub::DeviceRadixSort::SortPairs(nullptr, bytes, keys.span().data(), keys_out.span().data(),
                                               values.span().data(), values_out.span().data(), n, 0, bits),
               "sort");
    Buffer<unsigned char> scratch(static_cast<Size>(bytes));
    check_cuda(cub::DeviceRadixSort::SortPairs(scratch.span().data(), bytes, keys.span().data(), keys_out.span().data(),
                                               values.span().data(), values_out.span().data(), n, 0, bits),
               "sort");
    keys.swap(keys_out);
    values.swap(values_out);
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

  static void* allocate(std::size_t bytes) {
    if (bytes == 0) return nullptr;
    void* memory = nullptr;
    check_cuda(cudaMallocAsync(&memory, bytes, nullptr), "allocation");
    return memory;
  }
  static void release(void* memory, std::size_t) {
    if (memory != nullptr) cudaFreeAsync(memory, nullptr);
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
  std::function<bool()> stop_;
  static constexpr int kThreads = 256;
  static constexpr int kChunk = 1024;
  static unsigned blocks(Size n, int each) { return static_cast<unsigned>((n + each - 1) / each); }
};

}  // namespace tetune::par
