// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "par/atomic.hpp"
#include "par/buffer.hpp"

namespace tetune {

using par::Size;
using par::Span;

/// A sparse row format: row r holds items[offsets[r]] .. items[offsets[r + 1] - 1], in increasing order.
struct RowsView {
  Span<const std::uint32_t> offsets;
  Span<const std::uint32_t> items;
  TETUNE_HD Size begin(Size row) const { return offsets[row]; }
  TETUNE_HD Size end(Size row) const { return offsets[row + 1]; }
};

template <class Backend>
struct Rows {
  typename Backend::template Buffer<std::uint32_t> offsets;
  typename Backend::template Buffer<std::uint32_t> items;
  RowsView view() const { return {offsets.span(), items.span()}; }
};

/// Sorts a short array in place: insertion for a few, heap sort beyond, so that no input is slow.
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
  const auto sift = [&](Size root, Size end) {
    const T value = a[root];
    for (Size child = 2 * root + 1; child < end; child = 2 * root + 1) {
      if (child + 1 < end && less(a[child], a[child + 1])) ++child;
      if (!less(value, a[child])) break;
      a[root] = a[child];
      root = child;
    }
    a[root] = value;
  };
  for (Size root = n / 2; root-- > 0;) sift(root, n);
  for (Size end = n - 1; end > 0; --end) {
    const T value = a[0];
    a[0] = a[end];
    a[end] = value;
    sift(0, end);
  }
}

namespace rows_detail {

struct IdLess {
  TETUNE_HD bool operator()(std::uint32_t a, std::uint32_t b) const { return a < b; }
};

/// row_of(item) is the row of an item, or negative for none.
template <class RowOf>
struct Count {
  RowOf row_of;
  Span<std::uint32_t> counts;
  TETUNE_HD void operator()(Size item) const {
    const Size row = row_of(item);
    if (row >= 0) par::atomic_add(counts[row], 1);
  }
};

/// Fills each row from its end: counts hold the row ends when it starts, the row begins when it is done.
template <class RowOf>
struct Fill {
  RowOf row_of;
  Span<std::uint32_t> ends;
  Span<std::uint32_t> items;
  TETUNE_HD void operator()(Size item) const {
    const Size row = row_of(item);
    if (row >= 0) items[par::atomic_add(ends[row], ~0U) - 1] = static_cast<std::uint32_t>(item);
  }
};

struct SortRow {
  Span<const std::uint32_t> offsets;
  Span<std::uint32_t> items;
  TETUNE_HD void operator()(Size row) const {
    const Size begin = offsets[row];
    const Size n = offsets[row + 1] - begin;
    if (n > 1) sort_small(items.data() + begin, n, IdLess{});
  }
};

/// Turns the exclusive scan of counts into row ends.
struct Shift {
  Span<const std::uint32_t> counts;
  Span<std::uint32_t> offsets;
  TETUNE_HD void operator()(Size row) const { offsets[row] += counts[row]; }
};

}  // namespace rows_detail

/// Groups the items 0..n-1 by row. The atomics place the items of a row in any order; sorting makes it one order.
template <class Backend, class RowOf>
void build_rows(const Backend& par, Size row_count, Size item_count, const RowOf& row_of, Rows<Backend>& rows) {
  using namespace rows_detail;
  typename Backend::template Buffer<std::uint32_t> counts(row_count + 1);
  par.fill(counts.span(), std::uint32_t{0});
  par.for_each(item_count, Count<RowOf>{row_of, counts.span()});
  rows.offsets.resize(row_count + 1);
  const std::uint32_t total = par.exclusive_scan(Span<const std::uint32_t>(counts.span()), rows.offsets.span());
  rows.items.resize(total);
  par.for_each(row_count, Shift{counts.span(), rows.offsets.span()});
  par.for_each(item_count, Fill<RowOf>{row_of, rows.offsets.span(), rows.items.span()});
  par.for_each(row_count, SortRow{rows.offsets.span(), rows.items.span()});
}

}  // namespace tetune
