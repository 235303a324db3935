// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "backend/buffer.hpp"
#include "backend/concept.hpp"
#include "backend/pack.hpp"
#include "backend/results.hpp"
#include "backend/span.hpp"
#include "backend/thread_pool.hpp"

namespace tetune::backend {

/// The memory of the host, aligned to cache lines. Copies on all threads of a pool if it has one: to touch new pages
/// first takes longer than to copy to them.
class HostMemory {
 public:
  static constexpr bool kIsPool = false;
  explicit HostMemory(ThreadPool* pool = nullptr) : pool_(pool) {}

  static void* allocate(std::size_t bytes) {
    if (bytes > std::size_t{PTRDIFF_MAX}) throw std::bad_alloc();
    return bytes > 0 ? ::operator new(bytes, kAlignment) : nullptr;
  }
  static void release(void* memory, std::size_t) noexcept { ::operator delete(memory, kAlignment); }
  void copy(void* to, const void* from, std::size_t bytes) const {
    if (bytes == 0) return;
    if (pool_ == nullptr || bytes <= kPart) {
      std::memcpy(to, from, bytes);
      return;
    }
    const auto copy_part = [=, target = static_cast<char*>(to), source = static_cast<const char*>(from)](Size part) {
      const std::size_t begin = to_size_t(part) * kPart;
      std::memcpy(target + begin, source + begin, std::min(kPart, bytes - begin));
    };
    pool_->run(Size((bytes + kPart - 1) / kPart), PartTask(copy_part));
  }
  void upload(void* to, const void* from, std::size_t bytes) const { copy(to, from, bytes); }
  /// Static, as allocate() and release() are: the handle in a buffer may outlive the pool. Only copy() and upload() use
  /// it, which are called on the backend's own handle.
  static void download(void* to, const void* from, std::size_t bytes) {
    if (bytes > 0) std::memcpy(to, from, bytes);
  }

 private:
  static constexpr std::align_val_t kAlignment{64};
  static constexpr std::size_t kPart = std::size_t{1} << 18;  ///< bytes
  ThreadPool* pool_;
};

/// The CPU backend. The primitives are documented in backend/concept.hpp.
class Cpu {
 public:
  using Pack = Pack4;
  using Memory = HostMemory;
  static constexpr bool kIsAsynchronous = false;
  template <class T>
  using Buffer = backend::Buffer<T, Cpu>;

  template <class R>
  using Result = Available<R>;

  /// The caller's array itself.
  template <class T>
  class DeviceView {
   public:
    DeviceView(const Cpu&, const std::vector<T>& host) : span_(span_of(host)) {}
    Span<const T> span() const { return span_; }

   private:
    Span<const T> span_;
  };

  /// `threads` 0: one per processor. There may be fewer, see ThreadPool.
  explicit Cpu(int threads = 0, std::function<bool()> stop = {})
      : stop_(std::move(stop)),
        pool_(std::make_shared<ThreadPool>(requested_threads(threads))),
        threads_(pool_->threads()) {}

  /// The number of threads that a backend for `threads` requests.
  static int requested_threads(int threads) {
    return ThreadPool::clamp(threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency()));
  }

  int threads() const { return static_cast<int>(threads_); }

  Memory memory() const { return Memory(pool_.get()); }

  bool stop_requested() const { return stop_ && stop_(); }

  template <class F>
  void for_each(Size n, const F& f) const {
    const Size each = grain<F>(n);
    const auto visit = [&f](Size begin, Size end) {
      for (Size i = begin; i < end; ++i) {
        if constexpr (requires { f.prefetch(i, end); }) f.prefetch(i, end);
        f(i);
      }
    };
    if (threads_ == 1 || n <= kSerialGrains * each) return visit(0, n);
    for_parts((n + each - 1) / each, [&](Size part) { visit(part * each, std::min(n, (part + 1) * each)); });
  }

  template <class F>
  void for_each_step(Size steps, Size n, const F& f) const {
    backend::for_each_step(*this, steps, n, f);
  }

  /// Calls f(part) for part in [0, parts), each a sizeable piece of work.
  template <class F>
  void for_parts(Size parts, const F& f) const {
    pool_->run(parts, PartTask(f));
  }

  template <class R, class F>
  Available<R> reduce_async(Size n, const F& f) const {
    return {reduce<R>(n, f)};
  }

  /// Merges within chunks of fixed length, then over the chunks in order.
  template <class R, class F>
  R reduce(Size n, const F& f) const {
    const Size each = grain<F>(n);
    std::vector<R> partial(to_size_t((n + each - 1) / each));
    const Span<R> results = span_of(partial);
    const auto merge_chunk = [&](Size c) {
      const Size end = std::min(n, (c + 1) * each);
      R r{};
      for (Size i = c * each; i < end; ++i) {
        if constexpr (requires { f.prefetch(i, end); }) f.prefetch(i, end);
        r.merge(f(i));
      }
      results[c] = r;
    };
    if (n > kSerialGrains * each) {
      for_parts(results.size(), merge_chunk);
    } else {
      for (Size c = 0; c < results.size(); ++c) merge_chunk(c);
    }
    R total{};
    for (const R& r : partial) total.merge(r);
    return total;
  }

  template <class T>
  Available<T> exclusive_scan_async(Span<const T> in, Span<T> out) const {
    return {exclusive_scan(in, out)};
  }
  template <class T>
  T exclusive_scan(Span<const T> in, Span<T> out) const {
    const Size n = in.size();
    const Size blocks = block_count(n);
    std::vector<T> sums(to_size_t(blocks) + 1, T{});
    const Span<T> start = span_of(sums);
    for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
      T sum{};
      for (Size i = begin; i < end; ++i) sum += in[i];
      start[b + 1] = sum;
    });
    for (Size b = 0; b < blocks; ++b) start[b + 1] += start[b];
    for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
      T sum = start[b];
      for (Size i = begin; i < end; ++i) {
        const T value = in[i];
        out[i] = sum;
        sum += value;
      }
    });
    return sums.back();
  }

  /// Each block writes to its own part of the output; then the parts are moved together.
  template <class F>
  Size compact(Size n, const F& keep, Span<Index32> out) const {
    const Size blocks = block_count(n);
    std::vector<Size> counts(to_size_t(blocks), 0);
    const Span<Size> kept = span_of(counts);
    for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
      Size at = begin;
      for (Size i = begin; i < end; ++i) {
        if (keep(i)) out[at++] = to_index(i);
      }
      kept[b] = at - begin;
    });
    Size total = kept[0];
    for (Size b = 1; b < blocks; ++b) {
      if (kept[b] > 0)
        std::memmove(out.data() + total, out.data() + n * b / blocks, to_size_t(kept[b]) * sizeof(Index32));
      total += kept[b];
    }
    return total;
  }

  template <class F, class G, class P>
  auto compact_and_sum(Size n, const F& keep, const G& evaluate, const P& place) const {
    return backend::compact_and_sum(*this, n, keep, evaluate, place);
  }

  /// A radix sort; each pass counts and moves by blocks.
  template <class K>
  void sort_by_key(Buffer<K>& keys, Buffer<Index32>& values, int bits) const {
    const Size n = keys.size();
    Buffer<K> keys_out(*this, n);
    Buffer<Index32> values_out(*this, n);
    constexpr int kDigitBits = 8;
    constexpr std::size_t kRadix = std::size_t{1} << kDigitBits;
    const Size blocks = block_count(n);
    std::vector<std::array<Size, kRadix>> counts(to_size_t(blocks));
    const Span<std::array<Size, kRadix>> place = span_of(counts);
    for (int shift = 0; shift < bits; shift += kDigitBits) {
      const Span<const K> from = std::as_const(keys).span();
      const Span<const Index32> from_value = std::as_const(values).span();
      const Span<K> to = keys_out.span();
      const Span<Index32> to_value = values_out.span();
      const auto digit = [shift](K key) { return (key >> shift) & (kRadix - 1); };
      for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
        place[b].fill(0);
        for (Size i = begin; i < end; ++i) ++place[b][digit(from[i])];
      });
      Size sum = 0;
      for (std::size_t d = 0; d < kRadix; ++d) {
        for (auto& count : counts) sum += std::exchange(count[d], sum);
      }
      for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
        for (Size i = begin; i < end; ++i) {
          const Size j = place[b][digit(from[i])]++;
          to[j] = from[i];
          to_value[j] = from_value[i];
        }
      });
      keys.swap(keys_out);
      values.swap(values_out);
    }
  }

  /// Blocks of items are counted and placed independently, so no atomics are needed.
  template <class RowOf>
  Size count_by_row(Size n, const RowOf& row_of, Span<std::uint32_t> offsets,
                    Buffer<std::uint32_t>& offsets_of_blocks) const {
    const Size rows = offsets.size();
    // At most n / rows blocks: the counts of all blocks take no more memory than the items.
    const Size blocks = std::max<Size>(1, std::min(block_count(n), n / rows));
    offsets_of_blocks.resize(*this, blocks * rows);
    std::uint32_t* const counts = offsets_of_blocks.span().data();
    for_blocks(n, blocks, [&](Size b, Size begin, Size end) {
      std::uint32_t* const mine = counts + b * rows;
      std::fill(mine, mine + rows, 0U);
      for (Size i = begin; i < end; ++i) {
        const Size row = row_of(i);
        if (row >= 0) ++mine[row];
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
        std::uint32_t offset = offsets[r];
        for (Size b = 0; b < blocks; ++b) offset += std::exchange(counts[b * rows + r], offset);
      }
    });
    return total;
  }
  template <class RowOf, class F>
  void place_by_row(Size n, const RowOf& row_of, Size rows, Buffer<std::uint32_t>& offsets_of_blocks,
                    const F& place) const {
    std::uint32_t* const next = offsets_of_blocks.span().data();
    for_blocks(n, offsets_of_blocks.size() / rows, [&](Size b, Size begin, Size end) {
      std::uint32_t* const mine = next + b * rows;
      for (Size i = begin; i < end; ++i) {
        const Size row = row_of(i);
        if (row >= 0) place(i, mine[row]++);
      }
    });
  }

  template <class T>
  void fill(Span<T> out, T value) const {
    for_blocks(out.size(), block_count(out.size()),
               [&](Size, Size begin, Size end) { std::fill(out.data() + begin, out.data() + end, value); });
  }

 private:
  /// The number of items of a part of a loop.
  static constexpr Size kGrain = 512;
  /// A kernel with a `kGrain` of its own does much work per item: few items are then split into this many parts, of at
  /// least that length. The length depends on the number of items alone, because the bits of a sum depend on it.
  static constexpr Size kHeavyParts = 64;
  template <class F>
  static constexpr Size grain(Size n) {
    if constexpr (requires { F::kGrain; }) {
      return std::clamp(n / kHeavyParts, F::kGrain, kGrain);
    } else {
      return kGrain;
    }
  }
  /// Shorter loops run on the calling thread: to notify the others would take longer.
  static constexpr Size kSerialGrains = 4;

  /// The number of contiguous blocks for a loop whose blocks differ in their work only by their length.
  Size block_count(Size n) const { return std::max<Size>(1, std::min(threads_, n / (kSerialGrains * kGrain))); }

  /// f(block, begin, end) for `blocks` contiguous parts of [0, n).
  template <class F>
  void for_blocks(Size n, Size blocks, const F& f) const {
    for_parts(blocks, [&](Size b) { f(b, n * b / blocks, n * (b + 1) / blocks); });
  }

  std::function<bool()> stop_;
  std::shared_ptr<ThreadPool> pool_;
  Size threads_;
};

static_assert(CountsByRow<Cpu>);

}  // namespace tetune::backend
