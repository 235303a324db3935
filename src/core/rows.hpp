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
  TETUNE_HD Size size(Size row) const { return end(row) - begin(row); }
  /// The row with fewer items of two: what belongs to both is in either, and one may have thousands.
  template <class Id>
  TETUNE_HD Id shorter(Id a, Id b) const {
    return size(b) < size(a) ? b : a;
  }
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

inline constexpr std::uint32_t kNoRow = 0xffffffffU;

struct IdLess {
  TETUNE_HD bool operator()(std::uint32_t a, std::uint32_t b) const { return a < b; }
};

template <class RowOf>
struct FindRow {
  RowOf row_of;
  Span<std::uint32_t> row;
  TETUNE_HD void operator()(Size item) const {
    const Size r = row_of(item);
    row[item] = r < 0 ? kNoRow : static_cast<std::uint32_t>(r);
  }
};

/// Places the items of a row in any order.
struct Count {
  Span<const std::uint32_t> row;
  Span<std::uint32_t> counts;
  TETUNE_HD void operator()(Size item) const {
    if (row[item] != kNoRow) par::atomic_add(counts[row[item]], 1);
  }
};

/// Fills each row from its end: `ends` holds the row ends when it starts, the row begins when it is done.
struct Fill {
  Span<const std::uint32_t> row;
  Span<std::uint32_t> ends;
  Span<std::uint32_t> items;
  TETUNE_HD void operator()(Size item) const {
    if (row[item] != kNoRow) items[par::atomic_add(ends[row[item]], ~0U) - 1] = static_cast<std::uint32_t>(item);
  }
};

/// Makes it one order.
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

template <class Make, class T>
struct MakeItems {
  Make make;
  Span<const std::uint32_t> ids;
  Span<T> out;
  TETUNE_HD void operator()(Size i) const { out[i] = make(ids[i]); }
};

struct Same {
  TETUNE_HD std::uint32_t operator()(std::uint32_t item) const { return item; }
};

}  // namespace rows_detail

/// Groups the items 0..n-1 by row, and puts make(item) where the item goes. row_of(item) is the row of an item, or
/// negative for none. By atomics and sorting where a backend has many threads, without either where it has few.
template <class Backend, class RowOf, class Make, class T>
void group_by_row(const Backend& par, Size row_count, Size item_count, const RowOf& row_of, const Make& make,
                  typename Backend::template Buffer<std::uint32_t>& offsets,
                  typename Backend::template Buffer<T>& grouped) {
  using namespace rows_detail;
  using Ids = typename Backend::template Buffer<std::uint32_t>;
  Ids row(item_count);
  const FindRow<RowOf> find{row_of, row.span()};
  const Span<const std::uint32_t> rows = row.span();
  offsets.resize(row_count + 1);
  Ids places;
  if constexpr (requires { par.count_by_row(find, kNoRow, rows, offsets.span(), places); }) {
    grouped.resize(par.count_by_row(find, kNoRow, rows, offsets.span(), places));
    const Span<T> out = grouped.span();
    par.place_by_row(rows, kNoRow, offsets.size(), places,
                     [&](Size item, std::uint32_t place) { out[place] = make(static_cast<std::uint32_t>(item)); });
  } else {
    par.for_each(item_count, find);
    Ids counts(row_count + 1);
    par.fill(counts.span(), std::uint32_t{0});
    par.for_each(item_count, Count{rows, counts.span()});
    Ids ids(par.exclusive_scan(Span<const std::uint32_t>(counts.span()), offsets.span()));
    par.for_each(row_count, Shift{counts.span(), offsets.span()});
    par.for_each(item_count, Fill{rows, offsets.span(), ids.span()});
    row = Ids();  // for the memory
    par.for_each(row_count, SortRow{offsets.span(), ids.span()});
    grouped.resize(ids.size());
    par.for_each(ids.size(), MakeItems<Make, T>{make, ids.span(), grouped.span()});
  }
}

/// Groups the items 0..n-1 by row.
template <class Backend, class RowOf>
void build_rows(const Backend& par, Size row_count, Size item_count, const RowOf& row_of, Rows<Backend>& rows) {
  group_by_row<Backend, RowOf, rows_detail::Same, std::uint32_t>(par, row_count, item_count, row_of,
                                                                 rows_detail::Same{}, rows.offsets, rows.items);
}

}  // namespace tetune
