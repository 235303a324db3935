// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "backend/macros.hpp"
#include "backend/results.hpp"
#include "backend/span.hpp"

/// The contract between the algorithms and the machine that runs them. Everything above src/backend is written once,
/// as templates over a backend, and is instantiated per backend by the files *_cpu.cpp and *_cuda.cu; the compiler
/// checks each backend against this concept.
///
/// Kernels are trivially copyable function objects over Spans, marked TETUNE_HD. A kernel may write what no other call
/// of the same loop reads or writes, and may use backend/atomic.hpp where the order of the calls cannot affect the
/// result. Optional members guide the backend:
/// - `kGrain`, of kernels that do much work per item: the minimum number of items per thread on the CPU; a GPU spreads
///   few such items over many warps.
/// - `prefetch(i, end)`, called on the CPU before item i of a range that ends at `end`.
/// - `Shared` and operator()(team, shared, i), by which threads of a GPU evaluate an item together (backend/team.hpp).
namespace tetune::backend {

namespace concept_detail {

struct Visit {
  TETUNE_HD void operator()(Size) const {}
};
struct VisitInStep {
  TETUNE_HD void operator()(Size, Size) const {}
};
struct Evaluate {
  TETUNE_HD Sum<std::uint32_t> operator()(Size) const { return {}; }
};
struct AnyPredicate {
  TETUNE_HD bool operator()(Size) const { return true; }
};
struct Weight {
  TETUNE_HD std::uint32_t operator()(Size) const { return 1; }
};
struct AnyRow {
  TETUNE_HD Size operator()(Size) const { return 0; }
};
struct PlaceKeptItem {
  static constexpr Size kGrain = 32;
  TETUNE_HD void operator()(Size, Size, std::uint32_t) const {}
};
struct PlaceItem {
  TETUNE_HD void operator()(Size, std::uint32_t) const {}
};
struct EvaluateInOrder {
  struct Shared {};
  template <class Team>
  TETUNE_HD bool is_ready(const Team&, Size) const {
    return true;
  }
  template <class Team>
  TETUNE_HD void operator()(const Team&, Shared&, Size) const {}
  TETUNE_HD void finish(Size) const {}
};

}  // namespace concept_detail

/// A copyable handle of the memory of a backend; see backend/buffer.hpp, its only user but for bulk transfers.
template <class Memory>
concept MemoryHandle = std::default_initializable<Memory> && std::copyable<Memory> &&
    requires(const Memory& memory, void* to, const void* from, std::size_t bytes) {
  /// Null for 0 bytes. Throws std::bad_alloc or DeviceError.
  { memory.allocate(bytes) } -> std::same_as<void*>;
  /// `bytes` as allocated; null is ignored.
  { memory.release(to, bytes) }
  noexcept;
  /// Within the memory of the backend, from the host to it, and from it to the host.
  memory.copy(to, from, bytes);
  memory.upload(to, from, bytes);
  memory.download(to, from, bytes);
  /// Whether memory that is released is free for other buffers at no cost; elsewhere the system hands out new pages.
  requires std::same_as<decltype(Memory::kIsPool), const bool>;
};

/// The interface of an array of a backend: see backend/buffer.hpp.
template <class Buffer, class B, class T>
concept ArrayOf = std::is_nothrow_move_constructible_v<Buffer> && std::default_initializable<Buffer> &&
    requires(const B& backend, Buffer& buffer, const Buffer& other, const std::vector<T>& host) {
  { buffer.span() } -> std::same_as<Span<T>>;
  { other.span() } -> std::same_as<Span<const T>>;
  { other.size() } -> std::same_as<Size>;
  Buffer(backend, Size{1});
  buffer.resize(backend, Size{1});
  buffer.grow(backend, Size{1});
  buffer.assign(backend, other);
  buffer.upload(backend, host);
  { other.download() } -> std::same_as<std::vector<T>>;
};

/// The interface of the view of a caller's array.
template <class View, class B, class T>
concept ViewOf = requires(const B& backend, const View& view, const std::vector<T>& host) {
  View(backend, host);
  { view.span() } -> std::same_as<Span<const T>>;
};

template <class B>
concept Backend = requires(const B& backend, Size n, Span<std::uint32_t> out, Span<const std::uint32_t> in,
                           Span<Index32> ids, typename B::template Buffer<std::uint64_t>& keys,
                           typename B::template Buffer<Index32>& values) {
  // -- Traits --

  /// The doubles that kernels process at a time: backend/pack.hpp.
  requires std::is_trivially_copyable_v<typename B::Pack>;
  /// Whether kernels run concurrently with the host, and a transfer waits for them. Algorithms then launch larger
  /// batches and read results back less often.
  requires std::same_as<decltype(B::kIsAsynchronous), const bool>;
  /// Where arrays are allocated. A handle must not outlive the backend.
  requires MemoryHandle<typename B::Memory>;
  { backend.memory() } -> std::same_as<typename B::Memory>;
  /// An array in that memory.
  requires ArrayOf<typename B::template Buffer<std::uint32_t>, B, std::uint32_t>;
  /// A caller's std::vector as kernels see it: the vector itself, which must outlive it, or a copy in that memory.
  requires ViewOf<typename B::template DeviceView<std::uint32_t>, B, std::uint32_t>;

  /// The result of reduce_async(); by default R{}.
  requires std::default_initializable<typename B::template Result<Sum<std::uint32_t>>>;

  // -- Primitives: none depends on the number of threads in the bits of its result --

  /// Calls f(i) for each i in [0, n), in any order.
  { backend.for_each(n, concept_detail::Visit{}) } -> std::same_as<void>;
  /// Calls f(step, i) for each step in [0, steps) and i in [0, n); those of a step after all of the step before.
  { backend.for_each_step(Size{1}, n, concept_detail::VisitInStep{}) } -> std::same_as<void>;
  /// Merges f(i) for i in [0, n) into R{}, in an order that depends on n and on the backend alone. Requires that R{} is
  /// neutral to R::merge().
  { backend.template reduce<Sum<std::uint32_t>>(n, concept_detail::Evaluate{}) } -> std::same_as<Sum<std::uint32_t>>;
  /// Same as reduce(), but what it returns waits for the result only when get() is called, and not if a primitive that
  /// was called later waited. Requires that get() is called within the life of the backend.
  {
    backend.template reduce_async<Sum<std::uint32_t>>(n, concept_detail::Evaluate{})
    } -> std::same_as<typename B::template Result<Sum<std::uint32_t>>>;
  /// out[i] = in[0] + ... + in[i-1]; returns the sum of all. `in` and `out` may be the same array.
  { backend.exclusive_scan(in, out) } -> std::same_as<std::uint32_t>;
  /// Same as exclusive_scan(), but waits for the sum as reduce_async() does.
  { backend.exclusive_scan_async(in, out) } -> std::same_as<typename B::template Result<std::uint32_t>>;
  /// Writes each i in [0, n) with keep(i) to `ids`, in increasing order; returns their number. Requires room for n.
  /// keep(i) may be called twice, with the same result; like a kernel it may write what no other call reads or writes.
  { backend.compact(n, concept_detail::AnyPredicate{}, ids) } -> std::same_as<Size>;
  /// Calls place(i, k, sum of f(j) over the first k of these j) for each i in [0, n) with keep(i), where k is the
  /// number of those below i; returns the number and the sum of all. place(i, ...) may be called before keep(j) for
  /// other j, and may write what keep(j) and f(j) read, if their results stay the same. Both items of a pair, 2 m and
  /// 2 m + 1, are evaluated before one of them is placed.
  {
    backend.compact_and_sum(n, concept_detail::AnyPredicate{}, concept_detail::Weight{},
                            concept_detail::PlaceKeptItem{})
    } -> std::same_as<CountAndSum<std::uint32_t>>;
  /// Sorts (key, value) pairs by the lowest 64 bits of the key, or fewer; stable.
  { backend.sort_by_key(keys, values, 64) } -> std::same_as<void>;
  /// Sets all elements.
  { backend.fill(out, std::uint32_t{0}) } -> std::same_as<void>;

  // -- Control --

  /// Whether the caller has requested to stop. Called on the calling thread, at points where the mesh is valid.
  { backend.stop_requested() } -> std::same_as<bool>;
};

/// The optional hook of a backend with few threads: a stable counting sort without atomics, used by mesh/csr.hpp.
///
/// count_by_row(n, row_of, offsets, offsets_of_blocks): row_of(i) is the row of item i in [0, n), or negative where it
/// has none; writes to offsets[r] the number of items in rows before r; returns the number of items that have a row.
/// place_by_row(n, row_of, rows, offsets_of_blocks, place): calls place(i, rank of item i in the order by rows) for
/// each item that has a row. Uses up `offsets_of_blocks`, which the first step filled.
template <class B>
concept CountsByRow = Backend<B> && requires(const B& backend, Size n, Span<std::uint32_t> offsets,
                                             typename B::template Buffer<std::uint32_t>& offsets_of_blocks) {
  { backend.count_by_row(n, concept_detail::AnyRow{}, offsets, offsets_of_blocks) } -> std::same_as<Size>;
  {
    backend.place_by_row(n, concept_detail::AnyRow{}, Size{1}, offsets_of_blocks, concept_detail::PlaceItem{})
    } -> std::same_as<void>;
};

/// The optional hook of a backend that starts items in order, each of them evaluated by a team, so that an item may
/// wait for items before it.
///
/// for_each_in_order(n, f): for each item i in [0, n), calls f.is_ready(team, i) until it returns true to all threads
/// of the team, then f(team, shared, i), then f.finish(i) by one thread. Requires that is_ready() returns true once
/// finish() was called for all items before. What the items that is_ready() has found finished have stored is visible;
/// backend/atomic.hpp loads and stores what may change while an item is evaluated.
template <class B>
concept RunsInOrder = Backend<B> && requires(const B& backend, Size n) {
  { backend.for_each_in_order(n, concept_detail::EvaluateInOrder{}) } -> std::same_as<void>;
};

}  // namespace tetune::backend
