// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include "emulation/device_memory.hpp"
#include "par/beside_host.hpp"
#include "par/buffer.hpp"
#include "par/pool.hpp"
#include "par/span.hpp"

namespace tetune::par {

class Emulation;
/// As the CUDA backend: its ways are those to be tested.
template <>
inline constexpr bool kBesideHost<Emulation> = true;

/// The CUDA backend without CUDA, for tests: the same blocks of threads, chunks, scratch and order of merging as
/// par/cuda.cuh, one thread of them after the other, in an order that a seed shuffles. Its memory is apart: the host
/// may not touch it, kernels may touch nothing else that they carry an address of, and what was never written is not a
/// number.
class Emulation {
 public:
  template <class T>
  using Buffer = par::Buffer<T, Emulation>;

  /// A caller's array as kernels see it.
  template <class T>
  using Loan = LoanedCopy<T, Emulation>;

  /// `guard`: an access of the host ends the process; this costs some system calls a primitive.
  explicit Emulation(std::uint64_t seed = 1, std::size_t memory = std::size_t{1} << 30, bool guard = false,
                     std::function<bool()> stop = {})
      : stop_(std::move(stop)), random_(seed), memory_(memory, guard) {}

  bool stop_requested() const { return stop_ && stop_(); }
  const DeviceMemory& memory() const { return memory_; }

  template <class F>
  void for_each(Size n, const F& f) const {
    launch(n, f, [&](Size block, const F& kernel) {
      for_each_thread([&](Size thread) {
        const Size i = block * kThreads + thread;
        if (i < n) kernel(i);
      });
    });
  }

  template <class R, class F>
  R reduce(Size n, const F& f) const {
    if (n == 0) return R{};
    Buffer<R> partial = reduce_chunks<R>(n, f);
    while (partial.size() > 1)
      partial = reduce_chunks<R>(partial.size(), ReadPartial<R>{std::as_const(partial).span()});
    R result{};
    download(&result, partial.span().data(), sizeof(R));
    return result;
  }

  template <class T>
  T exclusive_scan(Span<const T> in, Span<T> out) const {
    const Size n = in.size();
    if (n == 0) return T{};
    Buffer<T> ends(2);
    copy(ends.span().data(), in.data() + n - 1, sizeof(T));
    Buffer<unsigned char> scratch(scratch_bytes(n));
    {
      const DeviceMemory::Open open(memory_);
      T sum{};
      for (Size i = 0; i < n; ++i) {
        const T value = in[i];
        out[i] = sum;
        sum += value;
      }
    }
    copy(ends.span().data() + 1, out.data() + n - 1, sizeof(T));
    T last[2];
    download(last, ends.span().data(), sizeof last);
    return last[1] + last[0];
  }

  /// Flags, their scan, and the write, each in an order of its own.
  template <class F>
  Size compact(Size n, const F& keep, Span<Index32> out) const {
    if (n == 0) return 0;
    Buffer<Size> count(1);
    Buffer<unsigned char> scratch(scratch_bytes(n));
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
    download(&kept, count.span().data(), sizeof kept);
    return kept;
  }

  template <class K>
  void sort_by_key(Buffer<K>& keys, Buffer<Index32>& values, int bits) const {
    const Size n = keys.size();
    if (n == 0) return;
    Buffer<K> keys_out(n);
    Buffer<Index32> values_out(n);
    Buffer<unsigned char> scratch(scratch_bytes(n));
    {
      const DeviceMemory::Open open(memory_);
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

  static void* allocate(std::size_t bytes) { return DeviceMemory::current().allocate(bytes); }
  static void release(void* memory, std::size_t bytes) {
    if (memory != nullptr) DeviceMemory::current().release(memory, bytes);
  }
  static void copy(void* to, const void* from, std::size_t bytes) { DeviceMemory::current().copy(to, from, bytes); }
  static void upload(void* to, const void* from, std::size_t bytes) { DeviceMemory::current().upload(to, from, bytes); }
  static void download(void* to, const void* from, std::size_t bytes) {
    DeviceMemory::current().download(to, from, bytes);
  }

 private:
  /// Of a block, as in par/cuda.cuh.
  static constexpr int kThreads = 128;
  static Size blocks(Size n) { return (n + kThreads - 1) / kThreads; }
  /// A little more than what CUB asks for.
  static Size scratch_bytes(Size n) { return n / 16 + 65536; }

  template <class R>
  struct ReadPartial {
    Span<const R> partial;
    R operator()(Size i) const { return partial[i]; }
  };

  /// [0, n) in an order that a number shuffles: the multiples of a step without a common factor.
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

  /// The kernel is copied, as a launch does.
  template <class F, class Block>
  void launch(Size n, const F& f, const Block& run) const {
    static_assert(std::is_trivially_copyable_v<F>);
    if (n == 0) return;
    F kernel(f);
    memory_.check_arguments(kernel);
    const DeviceMemory::Open open(memory_);
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
    Buffer<R> partial(blocks(n));
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

  std::function<bool()> stop_;
  mutable std::uint64_t random_;
  DeviceMemory memory_;
};

}  // namespace tetune::par
