// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "backend/atomic.hpp"
#include "backend/buffer.hpp"
#include "backend/concept.hpp"

namespace tetune {

/// Lists of items in compressed sparse rows: row r is items[offsets[r]] .. items[offsets[r + 1] - 1], in increasing
/// order.
struct CsrView {
  Span<const std::uint32_t> offsets;
  Span<const std::uint32_t> items;
  TETUNE_HD Size begin(Size row) const { return offsets[row]; }
  TETUNE_HD Size end(Size row) const { return offsets[row + 1]; }
  TETUNE_HD Size size(Size row) const { return end(row) - begin(row); }
  /// The shorter of two rows. An item common to both is found in either, and one may have thousands of items.
  template <class Id>
  TETUNE_HD Id shorter(Id a, Id b) const {
    return size(b) < size(a) ? b : a;
  }
};

template <class Backend>
struct Csr {
  BufferOf<Backend, std::uint32_t> offsets;
  BufferOf<Backend, std::uint32_t> items;
  CsrView view() const { return {offsets.span(), items.span()}; }
};

template <class T, class Less>
TETUNE_HD void sift_down(T* heap, Size root, Size end, const Less& less) {
  const T value = heap[root];
  for (Size child = 2 * root + 1; child < end; child = 2 * root + 1) {
    if (child + 1 < end && less(heap[child], heap[child + 1])) ++child;
    if (!less(value, heap[child])) break;
    heap[root] = heap[child];
    root = child;
  }
  heap[root] = value;
}

/// Sorts a short array in place, on the host or in a kernel: insertion sort up to 48 elements, heap sort beyond, so
/// that the worst case is O(n log n).
template <class T, class Less>
TETUNE_HD void sort_small(T* a, Size n, const Less& less) {
  if (n <= 48) {
    for (Size i = 1; i < n; ++i) {
      const T value = a[i];
      Size j = i;
      for (; j > 0 && less(value, a[j - 1]); --j) a[j] = a[j - 1];
      a[j] = value;
    }
    return;
  }
  for (Size root = n / 2; root-- > 0;) sift_down(a, root, n, less);
  for (Size end = n - 1; end > 0; --end) {
    const T value = a[0];
    a[0] = a[end];
    a[end] = value;
    sift_down(a, 0, end, less);
  }
}

namespace csr_detail {

struct ItemItself {
  TETUNE_HD std::uint32_t operator()(std::uint32_t item) const { return item; }
};

template <class RowOf>
struct CountItems {
  RowOf row_of;
  Span<std::uint32_t> counts;
  TETUNE_HD void operator()(Size item) const {
    const Size r = row_of(item);
    if (r >= 0) backend::atomic_add(counts[r], 1);
  }
};

/// Makes each item at a place in its row, from the end of the row, in unspecified order. `left` holds the number of
/// items of each row before, 0 after.
template <class RowOf, class Make, class T>
struct FillRows {
  RowOf row_of;
  Make make;
  Span<const std::uint32_t> offsets;
  Span<std::uint32_t> left;
  Span<T> out;
  TETUNE_HD void operator()(Size item) const {
    const Size r = row_of(item);
    if (r >= 0) out[offsets[r] + backend::atomic_add(left[r], ~0U) - 1] = make(static_cast<std::uint32_t>(item));
  }
};

/// Makes each item at its place in increasing order, so that the result does not depend on the order of the atomic
/// operations: behind the lower ones of its row, which are counted.
template <class RowOf, class Make, class T>
struct MakeInOrder {
  RowOf row_of;
  Make make;
  Span<const std::uint32_t> offsets;
  Span<const std::uint32_t> items;
  Span<T> out;
  TETUNE_HD void operator()(Size i) const {
    const std::uint32_t item = items[i];
    const Size row = row_of(item);
    const std::uint32_t begin = offsets[row];
    const std::uint32_t end = offsets[row + 1];
    std::uint32_t place = begin;
    for (std::uint32_t k = begin; k < end; ++k) place += items[k] < item ? 1U : 0U;
    out[place] = make(item);
  }
};

/// Counts the items of each row, and sums up the counts. Returns the pending number of items that have a row.
template <class Backend, class RowOf>
auto count_items(const Backend& backend, Size row_count, Size item_count, const RowOf& row_of,
                 BufferOf<Backend, std::uint32_t>& counts, BufferOf<Backend, std::uint32_t>& offsets) {
  counts.resize(backend, row_count + 1);
  offsets.resize(backend, row_count + 1);
  backend.fill(counts.span(), std::uint32_t{0});
  backend.for_each(item_count, CountItems<RowOf>{row_of, counts});
  return backend.exclusive_scan_async(Span<const std::uint32_t>(counts.span()), offsets.span());
}

}  // namespace csr_detail

/// The items 0..n-1 of rows to build.
template <class RowOf, class Make = csr_detail::ItemItself>
struct RowItems {
  Size rows;
  Size items;
  RowOf row_of;    ///< row_of(item): the row of an item, or a negative number if it has none
  Make make = {};  ///< make(item): what is stored for an item
  /// The number of items that have a row, where it is known, so that the host does not wait for it.
  std::optional<Size> listed = {};
};

/// build_csr_of() on a backend with atomics and without an order within rows, for uses whose result does not depend on
/// it. `grouped` gets room for all items.
template <class Backend, class RowOf, class Make, class T>
void build_unordered_rows(const Backend& backend, const RowItems<RowOf, Make>& source,
                          BufferOf<Backend, std::uint32_t>& offsets, BufferOf<Backend, T>& grouped) {
  using namespace csr_detail;
  BufferOf<Backend, std::uint32_t> counts;
  count_items(backend, source.rows, source.items, source.row_of, counts, offsets);
  grouped.resize(backend, source.items);
  backend.for_each(source.items, FillRows<RowOf, Make, T>{source.row_of, source.make, offsets, counts, grouped});
}

/// Groups items by row, and stores make(item) for each. A backend that provides count_by_row() and place_by_row() does
/// without atomics.
template <class Backend, class RowOf, class Make, class T>
void build_csr_of(const Backend& backend, const RowItems<RowOf, Make>& source,
                  BufferOf<Backend, std::uint32_t>& offsets, BufferOf<Backend, T>& grouped) {
  using namespace csr_detail;
  using Ids = BufferOf<Backend, std::uint32_t>;
  const RowOf& row_of = source.row_of;
  const Make& make = source.make;
  if constexpr (backend::CountsByRow<Backend>) {
    offsets.resize(backend, source.rows + 1);
    Ids positions;
    grouped.resize(backend, backend.count_by_row(source.items, row_of, offsets.span(), positions));
    const Span<T> out = grouped;
    backend.place_by_row(source.items, row_of, offsets.size(), positions, [&](Size item, std::uint32_t position) {
      out[position] = make(static_cast<std::uint32_t>(item));
    });
  } else {
    Ids counts;
    const auto sum = count_items(backend, source.rows, source.items, row_of, counts, offsets);
    Ids ids(backend, source.listed ? *source.listed : Size{sum.get()});
    TETUNE_ASSERT(ids.size() == sum.get());
    backend.for_each(source.items,
                     FillRows<RowOf, ItemItself, std::uint32_t>{row_of, ItemItself{}, offsets, counts, ids});
    grouped.resize(backend, ids.size());
    backend.for_each(ids.size(), MakeInOrder<RowOf, Make, T>{row_of, make, offsets, ids, grouped});
  }
}

/// Builds the rows of the items 0..n-1: build_csr_of() with the items themselves.
template <class Backend, class RowOf>
void build_csr(const Backend& backend, Size row_count, Size item_count, const RowOf& row_of, Csr<Backend>& rows,
               std::optional<Size> listed = {}) {
  build_csr_of<Backend, RowOf, csr_detail::ItemItself, std::uint32_t>(
      backend, {.rows = row_count, .items = item_count, .row_of = row_of, .listed = listed}, rows.offsets, rows.items);
}

}  // namespace tetune
