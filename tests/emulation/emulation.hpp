// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include "backend/buffer.hpp"
#include "backend/concept.hpp"
#include "backend/pool.hpp"
#include "backend/results.hpp"
#include "backend/span.hpp"
#include "backend/team.hpp"
#include "emulation/device_memory.hpp"

namespace tetune::backend {

/// A handle of the memory of an Emulation.
class EmulatedMemory {
 public:
  static constexpr bool kIsPool = true;
  EmulatedMemory() = default;
  explicit EmulatedMemory(DeviceMemory& memory) : memory_(&memory) {}

  void* allocate(std::size_t bytes) const { return memory_->allocate(bytes); }
  void release(void* memory, std::size_t bytes) const noexcept {
    if (memory != nullptr) memory_->release(memory, bytes);
  }
  void copy(void* to, const void* from, std::size_t bytes) const { memory_->copy(to, from, bytes); }
  void upload(void* to, const void* from, std::size_t bytes) const { memory_->upload(to, from, bytes); }
  void download(void* to, const void* from, std::size_t bytes) const { memory_->download(to, from, bytes); }

 private:
  DeviceMemory* memory_ = nullptr;
};

/// Whether an access of the host to the memory of the emulation ends the process, at the cost of some system calls per
/// primitive.
enum class HostAccess { unchecked, ends_process };

/// The CUDA backend without CUDA, for tests: the same blocks of threads, chunks, scratch memory and order of merging as
/// backend/cuda.cuh, with the threads run one after the other in an order shuffled by a seed. Its memory is separate:
/// the host may not access it, kernels may hold no other addresses, and values that were never written are NaN.
class Emulation {
 public:
  using Pack = double;
  using Memory = EmulatedMemory;
  static constexpr bool kIsAsynchronous = true;
  template <class T>
  using Buffer = backend::Buffer<T, Emulation>;
  template <class T>
  using DeviceView = UploadedView<T, Emulation>;
  template <class R>
  using Result = Available<R>;

  explicit Emulation(std::uint64_t seed = 1, std::size_t memory = std::size_t{1} << 30,
                     HostAccess access = HostAccess::unchecked)
      : random_(seed), memory_(memory, access == HostAccess::ends_process) {}

  Memory memory() const { return Memory(memory_); }
  const DeviceMemory& device_memory() const { return memory_; }

  static bool stop_requested() { return false; }

  template <class F>
  void for_each(Size n, const F& f) const {
    launch(n, f, [&](Size block, const F& kernel) {
      for_each_thread([&](Size thread) {
        const Size i = block * kThreads + thread;
        if (i < n) kernel(i);
      });
    });
  }

  template <class F>
  void for_each_step(Size steps, Size n, const F& f) const {
    backend::for_each_step(*this, steps, n, f);
  }

  template <class F>
  void for_each_in_order(Size n, const F& f) const {
    F kernel(f);
    memory_.check_arguments(kernel);
    const DeviceMemory::Access access(memory_);
    for (Size i = 0; i < n; ++i) {
      if (!kernel.is_ready(SingleThread(), i)) throw std::logic_error("an item waits for one that follows it");
      typename F::Shared shared;
      kernel(SingleThread(), shared, i);
      kernel.finish(i);
    }
  }

  template <class R, class F>
  R reduce(Size n, const F& f) const {
    if (n == 0) return R{};
    Buffer<R> partial = reduce_chunks<R>(n, f);
    while (partial.size() > 1) partial = reduce_chunks<R>(partial.size(), LoadResult<R>{std::as_const(partial).span()});
    R result{};
    memory().download(&result, partial.span().data(), sizeof(R));
    return result;
  }

  template <class R, class F>
  Available<R> reduce_async(Size n, const F& f) const {
    return {reduce<R>(n, f)};
  }

  template <class T>
  Available<T> exclusive_scan_async(Span<const T> in, Span<T> out) const {
    return {exclusive_scan(in, out)};
  }
  template <class T>
  T exclusive_scan(Span<const T> in, Span<T> out) const {
    const Size n = in.size();
    if (n == 0) return T{};
    Buffer<T> ends(*this, 2);
    memory().copy(ends.span().data(), in.data() + n - 1, sizeof(T));
    Buffer<unsigned char> scratch(*this, scratch_bytes(n));
    {
      const DeviceMemory::Access access(memory_);
      T sum{};
      for (Size i = 0; i < n; ++i) {
        const T value = in[i];
        out[i] = sum;
        sum += value;
      }
    }
    memory().copy(ends.span().data() + 1, out.data() + n - 1, sizeof(T));
    T last[2];
    memory().download(last, ends.span().data(), sizeof last);
    return last[1] + last[0];
  }

  /// Flags, their scan, and the write, each in a different order.
  template <class F>
  Size compact(Size n, const F& keep, Span<Index32> out) const {
    if (n == 0) return 0;
    Buffer<Size> count(*this, 1);
    Buffer<unsigned char> scratch(*this, scratch_bytes(n));
    std::vector<Size> place(static_cast<std::size_t>(n));
    launch(n, keep, [&](Size block, const F& kernel) {
      for_each_thread([&](Size thread) {
        const Size i = block * kThreads + thread;
        if (i < n) place[static_cast<std::size_t>(i)] = kernel(i) ? 1 : 0;
      });
    });
    std::exclusive_scan(place.begin(), place.end(), place.begin(), Size{0});
    const Size before_last = place.back();
    launch(n, keep, [&](Size block, const F& kernel) {
      for_each_thread([&](Size thread) {
        const Size i = block * kThreads + thread;
        if (i >= n) return;
        const bool kept =
            i + 1 < n ? place[static_cast<std::size_t>(i + 1)] > place[static_cast<std::size_t>(i)] : kernel(i);
        if (kept) out[place[static_cast<std::size_t>(i)]] = static_cast<Index32>(i);
        if (i + 1 == n) count.span()[0] = before_last + (kept ? 1 : 0);
      });
    });
    Size kept = 0;
    memory().download(&kept, count.span().data(), sizeof kept);
    return kept;
  }

  template <class F, class G, class P>
  auto compact_and_sum(Size n, const F& keep, const G& evaluate, const P& place) const {
    return backend::compact_and_sum(*this, n, keep, evaluate, place);
  }

  template <class K>
  void sort_by_key(Buffer<K>& keys, Buffer<Index32>& values, int bits) const {
    const Size n = keys.size();
    if (n == 0) return;
    Buffer<K> keys_out(*this, n);
    Buffer<Index32> values_out(*this, n);
    Buffer<unsigned char> scratch(*this, scratch_bytes(n));
    {
      const DeviceMemory::Access access(memory_);
      const K mask = bits < static_cast<int>(8 * sizeof(K)) ? static_cast<K>((K{1} << bits) - 1) : static_cast<K>(~K{});
      const Span<K> from = keys.span();
      std::vector<Index32> order(static_cast<std::size_t>(n));
      std::iota(order.begin(), order.end(), 0);
      std::stable_sort(order.begin(), order.end(),
                       [&](Index32 a, Index32 b) { return (from[a] & mask) < (from[b] & mask); });
      for (Size i = 0; i < n; ++i) {
        keys_out.span()[i] = from[order[static_cast<std::size_t>(i)]];
        values_out.span()[i] = values.span()[order[static_cast<std::size_t>(i)]];
      }
    }
    keys.swap(keys_out);
    values.swap(values_out);
  }

  template <class T>
  struct Fill {
    Span<T> out;
    T value;
    void operator()(Size i) const { out[i] = value; }
  };
  template <class T>
  void fill(Span<T> out, T value) const {
    for_each(out.size(), Fill<T>{out, value});
  }

 private:
  /// Threads per block, as in backend/cuda.cuh.
  static constexpr int kThreads = 128;
  static Size blocks(Size n) { return (n + kThreads - 1) / kThreads; }
  /// A little more than CUB requires.
  static Size scratch_bytes(Size n) { return n / 16 + 65536; }

  /// A permutation of [0, n) that depends on a random number: the multiples of a step coprime to n.
  class Order {
   public:
    Order(Size n, std::uint64_t random) : n_(static_cast<std::uint64_t>(n)) {
      first_ = (random >> 32) % n_;
      step_ = (random & 0xffffffffU) % n_;
      while (std::gcd(step_, n_) != 1) ++step_;
    }
    Size operator()(Size i) const { return static_cast<Size>((first_ + step_ * static_cast<std::uint64_t>(i)) % n_); }

   private:
    std::uint64_t n_, first_, step_;
  };

  /// Copies the kernel, as a launch does.
  template <class F, class Block>
  void launch(Size n, const F& f, const Block& run) const {
    static_assert(std::is_trivially_copyable_v<F>);
    if (n == 0) return;
    F kernel(f);
    memory_.check_arguments(kernel);
    const DeviceMemory::Access access(memory_);
    const Order order(blocks(n), next());
    for (Size b = 0; b < blocks(n); ++b) run(order(b), std::as_const(kernel));
  }
  template <class Thread>
  void for_each_thread(const Thread& run) const {
    const Order order(kThreads, next());
    for (Size t = 0; t < kThreads; ++t) run(order(t));
  }

  template <class R, class F>
  Buffer<R> reduce_chunks(Size n, const F& f) const {
    if constexpr (requires { F::kGrain; }) {
      Buffer<R> results(*this, n);
      for_each(n, StoreResult<R, F>{f, results.span()});
      return reduce_chunks<R>(n, LoadResult<R>{std::as_const(results).span()});
    } else {
      return merge_chunks<R>(n, f);
    }
  }
  template <class R, class F>
  Buffer<R> merge_chunks(Size n, const F& f) const {
    Buffer<R> partial(*this, blocks(n));
    launch(n, f, [&](Size block, const F& kernel) {
      R shared[kThreads];
      for_each_thread([&](Size thread) {
        const Size i = block * kThreads + thread;
        R r{};
        if (i < n) r.merge(kernel(i));
        shared[thread] = r;
      });
      for (int half = kThreads / 2; half > 0; half /= 2) {
        for (int t = 0; t < half; ++t) shared[t].merge(shared[t + half]);
      }
      partial.span()[block] = shared[0];
    });
    return partial;
  }

  /// splitmix64.
  std::uint64_t next() const {
    std::uint64_t z = random_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }

  mutable std::uint64_t random_;
  mutable DeviceMemory memory_;
};

static_assert(Backend<Emulation>);

}  // namespace tetune::backend
