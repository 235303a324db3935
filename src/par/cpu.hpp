// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "par/buffer.hpp"
#include "par/host_memory.hpp"
#include "par/span.hpp"
#include "par/thread_pool.hpp"

namespace tetune::par {

/// The CPU backend: threads of its own. Every primitive gives the same bits for any number of threads.
class Cpu {
 public:
  template <class T>
  using Buffer = par::Buffer<T, Cpu>;

  /// A caller's array as kernels see it: here the array itself.
  template <class T>
  class Loan {
   public:
    explicit Loan(const std::vector<T>& host) : span_(host.data(), static_cast<Size>(host.size())) {}
    Span<const T> span() const { return span_; }

   private:
    Span<const T> span_;
  };

  /// `threads` 0 means all that this process may use. There may be fewer, as ThreadPool says.
  explicit Cpu(int threads = 0, std::function<bool()> stop = {}) : stop_(std::move(stop)) {
    if (threads <= 0) threads = static_cast<int>(std::thread::hardware_concurrency());
    if (threads <= 1) return;
    pool_ = std::make_shared<ThreadPool>(threads);
    threads_ = pool_->threads();
  }

  int threads() const { return threads_; }

  /// Whether the caller wants an end. To be asked on the calling thread, where the mesh is valid.
  bool stop_requested() const { return stop_ && stop_(); }

  /// f(i) for i in [0, n), in any order.
  template <class F>
  void for_each(Size n, const F& f) const {
    const Size each = grain<F>(n);
    if (threads_ == 1 || n <= kSerialGrains * each) {
      for_range(0, n, f);
      return;
    }
    for_parts((n + each - 1) / each, [&](Size part) { for_range(part * each, std::min(n, (part + 1) * each), f); });
  }

  /// f(part) for part in [0, parts), each a good piece of work.
  template <class F>
  void for_parts(Size parts, const F& f) const {
    if (pool_ && parts > 1) {
      pool_->run(parts, f);
    } else {
      for (Size part = 0; part < parts; ++part) f(part);
    }
  }

  /// Merges f(i) for i in [0, n) into R{}: within chunks of fixed length, then over the chunks in order.
  template <class R, class F>
  R reduce(Size n, const F& f) const {
    const Size each = grain<F>(n);
    const Size chunks = (n + each - 1) / each;
    std::vector<R> partial(static_cast<std::size_t>(chunks));
    const auto merge_chunk = [&](Size c) {
      partial[static_cast<std::size_t>(c)] = reduce_range<R>(c * each, std::min(n, (c + 1) * each), f);
    };
    if (n > kSerialGrains * each) {
      for_parts(chunks, merge_chunk);
    } else {
      for (Size c = 0; c < chunks; ++c) merge_chunk(c);
    }
    R total{};
    for (const R& r : partial) total.merge(r);
    return total;
  }

  /// out[i] = in[0] + ... + in[i-1]; returns the sum of all. `in` and `out` may be the same array.
  template <class T>
  T exclusive_scan(Span<const T> in, Span<T> out) const {
    const Size n = in.size();
    const Size blocks = std::max<Size>(1, std::min<Size>(threads_, n / kSerial));
    std::vector<T> start(static_cast<std::size_t>(blocks) + 1, T{});
    for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
      T sum{};
      for (Size i = begin; i < end; ++i) sum += in[i];
      start[static_cast<std::size_t>(b) + 1] = sum;
    });
    for (std::size_t b = 0; b < static_cast<std::size_t>(blocks); ++b) start[b + 1] += start[b];
    for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
      T sum = start[static_cast<std::size_t>(b)];
      for (Size i = begin; i < end; ++i) {
        const T value = in[i];
        out[i] = sum;
        sum += value;
      }
    });
    return start.back();
  }

  /// Writes the i in [0, n) with keep(i) to `out`, which has room for n, in increasing order; returns their number.
  template <class F>
  Size compact(Size n, const F& keep, Span<Index32> out) const {
    const Size blocks = std::max<Size>(1, std::min<Size>(threads_, n / kSerial));
    std::vector<Size> kept(static_cast<std::size_t>(blocks), 0);
    // Each block fills its own part of the output; then they move together.
    for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
      Size at = begin;
      for (Size i = begin; i < end; ++i) {
        if (keep(i)) out[at++] = static_cast<Index32>(i);
      }
      kept[static_cast<std::size_t>(b)] = at - begin;
    });
    Size total = kept[0];
    for (Size b = 1; b < blocks; ++b) {
      const auto bytes = static_cast<std::size_t>(kept[static_cast<std::size_t>(b)]) * sizeof(Index32);
      if (bytes > 0) std::memmove(out.data() + total, out.data() + n * b / blocks, bytes);
      total += kept[static_cast<std::size_t>(b)];
    }
    return total;
  }

  /// Sorts (key, value) pairs by the lowest `bits` bits of the key; equal keys keep their order.
  template <class K>
  void sort_by_key(Buffer<K>& keys, Buffer<Index32>& values, int bits) const {
    const Size n = keys.size();
    Buffer<K> keys_out(n);
    Buffer<Index32> values_out(n);
    constexpr int kDigit = 8;
    constexpr int kRadix = 1 << kDigit;
    const Size blocks = std::max<Size>(1, std::min<Size>(threads_, n / kSerial));
    std::vector<std::array<Size, kRadix>> place(static_cast<std::size_t>(blocks));
    for (int shift = 0; shift < bits; shift += kDigit) {
      const Span<const K> from = std::as_const(keys).span();
      const Span<const Index32> from_value = std::as_const(values).span();
      const Span<K> to = keys_out.span();
      const Span<Index32> to_value = values_out.span();
      const auto digit = [shift](K key) { return static_cast<std::size_t>((key >> shift) & (kRadix - 1)); };
      for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
        auto& count = place[static_cast<std::size_t>(b)];
        count.fill(0);
        for (Size i = begin; i < end; ++i) ++count[digit(from[i])];
      });
      Size sum = 0;
      for (std::size_t d = 0; d < kRadix; ++d) {
        for (auto& count : place) {
          const Size c = count[d];
          count[d] = sum;
          sum += c;
        }
      }
      for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
        auto& at = place[static_cast<std::size_t>(b)];
        for (Size i = begin; i < end; ++i) {
          const Size j = at[digit(from[i])]++;
          to[j] = from[i];
          to_value[j] = from_value[i];
        }
      });
      keys.swap(keys_out);
      values.swap(values_out);
    }
  }

  /// A counting sort in two steps, stable, without atomics: blocks of items count and place by themselves. The first
  /// lets find(i) write row[i], which may be no_row, and writes where each row begins in the order by rows; returns the
  /// number of items that have one.
  template <class Find>
  Size count_by_row(const Find& find, std::uint32_t no_row, Span<const std::uint32_t> row, Span<std::uint32_t> offsets,
                    Buffer<std::uint32_t>& places) const {
    const Size n = row.size();
    const Size rows = offsets.size();
    // The counts of all blocks take no more room than the items.
    const Size blocks = std::max<Size>(1, std::min<Size>({threads_, n / kSerial, n / rows}));
    places.resize(blocks * rows);
    std::uint32_t* const counts = places.span().data();
    for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
      std::uint32_t* const mine = counts + b * rows;
      std::fill(mine, mine + rows, 0U);
      for (Size i = begin; i < end; ++i) {
        find(i);
        if (row[i] != no_row) ++mine[row[i]];
      }
    });
    for_blocks(rows, blocks, [&](Size, Size begin, Size end) {
      for (Size r = begin; r < end; ++r) {
        offsets[r] = 0;
        for (Size b = 0; b < blocks; ++b) offsets[r] += counts[b * rows + r];
      }
    });
    const Size total = exclusive_scan(Span<const std::uint32_t>(offsets), offsets);
    for_blocks(rows, blocks, [&](Size, Size begin, Size end) {
      for (Size r = begin; r < end; ++r) {
        std::uint32_t place = offsets[r];
        for (Size b = 0; b < blocks; ++b) place += std::exchange(counts[b * rows + r], place);
      }
    });
    return total;
  }
  /// The second: place(i, rank of item i in the order by rows), once for each `places`.
  template <class F>
  void place_by_row(Span<const std::uint32_t> row, std::uint32_t no_row, Size rows, Buffer<std::uint32_t>& places,
                    const F& place) const {
    std::uint32_t* const next = places.span().data();
    for_blocks(row.size(), places.size() / rows, [&](Size b, Size begin, Size end) {
      std::uint32_t* const mine = next + b * rows;
      for (Size i = begin; i < end; ++i) {
        if (row[i] != no_row) place(i, mine[row[i]]++);
      }
    });
  }

  template <class T>
  void fill(Span<T> out, T value) const {
    for_blocks(out.size(), std::max<Size>(1, std::min<Size>(threads_, out.size() / kSerial)),
               [&](Size, Size begin, Size end) { std::fill(out.data() + begin, out.data() + end, value); });
  }

  static void* allocate(std::size_t bytes) { return host_memory::allocate(bytes); }
  static void release(void* memory, std::size_t bytes) { host_memory::release(memory, bytes); }
  static void copy(void* to, const void* from, std::size_t bytes) {
    if (bytes > 0) std::memcpy(to, from, bytes);
  }
  static void upload(void* to, const void* from, std::size_t bytes) {
    if (bytes > 0) std::memcpy(to, from, bytes);
  }
  static void download(void* to, const void* from, std::size_t bytes) {
    if (bytes > 0) std::memcpy(to, from, bytes);
  }

 private:
  /// Items a thread takes at a time.
  static constexpr Size kGrain = 512;
  /// Few items that are much work each are shared out as well: kernels of such have a smaller `kGrain`, the least that
  /// a thread takes. Depends on the number of items alone, as sums do on this.
  static constexpr Size kHeavyParts = 64;
  template <class F>
  static constexpr Size grain(Size n) {
    if constexpr (requires { F::kGrain; }) {
      return std::clamp(n / kHeavyParts, F::kGrain, kGrain);
    } else {
      return kGrain;
    }
  }
  /// Below this, waking the other threads costs more than they save.
  static constexpr Size kSerialGrains = 4;
  static constexpr Size kSerial = kSerialGrains * kGrain;

  template <class F>
  static void for_range(Size begin, Size end, const F& f) {
    for (Size i = begin; i < end; ++i) {
      if constexpr (requires { f.prefetch(i, end); }) f.prefetch(i, end);
      f(i);
    }
  }

  template <class R, class F>
  static R reduce_range(Size begin, Size end, const F& f) {
    R r{};
    for (Size i = begin; i < end; ++i) {
      if constexpr (requires { f.prefetch(i, end); }) f.prefetch(i, end);
      r.merge(f(i));
    }
    return r;
  }

  /// f(block, begin, end) for `blocks` contiguous parts of [0, n).
  template <class F>
  void for_blocks(Size n, Size blocks, const F& f) const {
    for_parts(blocks, [&](Size b) { f(b, n * b / blocks, n * (b + 1) / blocks); });
  }

  int threads_ = 1;
  std::function<bool()> stop_;
  std::shared_ptr<ThreadPool> pool_;
  std::shared_ptr<host_memory::Session> memory_ = std::make_shared<host_memory::Session>();
};

}  // namespace tetune::par
