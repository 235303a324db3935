// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "relocation/coloring.hpp"

namespace tetune {
namespace reduce_colors_detail {

template <class R, class Kernel>
struct StoreResult {
  Kernel kernel;
  Span<R> results;
  TETUNE_HD void operator()(Size i) const { results[i] = kernel(i); }
};
template <class R>
struct LoadResult {
  Span<const R> results;
  TETUNE_HD R operator()(Size i) const { return results[i]; }
};

}  // namespace reduce_colors_detail

/// Merges the results of a kernel for all colored vertices, one color after the other; `kernel.vertices` receives the
/// vertices of a color. Ends between two colors when a stop is requested.
template <class R, class Backend, class Kernel>
R reduce_colors(const Backend& backend, const Coloring<Backend>& coloring, Kernel kernel) {
  using namespace reduce_colors_detail;
  R total{};
  // An asynchronous backend stores the results, as the host would otherwise wait for each color.
  constexpr bool kStores = Backend::kIsAsynchronous;
  BufferOf<Backend, R> results;
  if constexpr (kStores) results.resize(backend, coloring.vertices.size());
  Size done = 0;
  for (int c = 0; c < coloring.colors() && !backend.stop_requested(); ++c) {
    kernel.vertices = coloring.vertices_of(c);
    const Size count = kernel.vertices.size();
    if constexpr (kStores) {
      backend.for_each(count, StoreResult<R, Kernel>{kernel, {results.span().data() + done, count}});
    } else {
      total.merge(backend.template reduce<R>(count, kernel));
    }
    done += count;
  }
  if constexpr (kStores) total = backend.template reduce<R>(done, LoadResult<R>{results});
  return total;
}

}  // namespace tetune
